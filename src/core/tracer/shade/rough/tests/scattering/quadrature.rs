//! Integrals over the hemisphere, by cells of cosine × azimuth that are split where the integrand is large or rough.

use super::*;
use core::f64::consts::TAU;

/// A rectangle of cosines and azimuths (in turns): its area times 2π is a solid angle.
#[derive(Clone, Copy)]
pub struct Cell {
    pub cosine: (f64, f64),
    pub turn: (f64, f64),
    depth: u32,
}

/// Cells are split this often whatever is in them, so that no peak is overlooked.
const LEAST_DEPTH: u32 = 5;
const MOST_DEPTH: u32 = 16;

/// Nodes and weights of Gauss and Legendre on [0, 1], half of them; the others mirror them at ½.
const GAUSS: [(f64, f64); 4] = [
    (0.019_855_071_751_231_856, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_23),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_65),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
];

fn node(i: usize) -> (f64, f64) {
    let (x, weight) = GAUSS[if i < 4 { i } else { 7 - i }];
    (if i < 4 { x } else { 1.0 - x }, weight)
}

impl Cell {
    pub const ALL: Cell = Cell { cosine: (0.0, 1.0), turn: (0.0, 1.0), depth: 0 };

    pub fn quarters(&self) -> [Cell; 4] {
        let halves = |(a, b): (f64, f64)| [(a, 0.5 * (a + b)), (0.5 * (a + b), b)];
        let (cosine, turn) = (halves(self.cosine), halves(self.turn));
        [0, 1, 2, 3].map(|i| Cell { cosine: cosine[i / 2], turn: turn[i % 2], depth: self.depth + 1 })
    }

    pub fn holds(&self, cosine: f64, turn: f64) -> bool {
        let within = |(a, b): (f64, f64), x: f64| a <= x && x < b;
        within(self.turn, turn) && (within(self.cosine, cosine) || (cosine >= 1.0 && self.cosine.1 == 1.0))
    }

    /// The integral of `f` by 8 × 8 points.
    pub fn integral(&self, f: &impl Fn(Vec3x8) -> f32x8) -> f64 {
        let at = |(a, b): (f64, f64), x: f64| a + (b - a) * x;
        let mut sum = 0.0;
        for row in 0..8 {
            let (x, row_weight) = node(row);
            let z = at(self.cosine, x);
            let r = libm::sqrt(1.0 - z * z);
            let turn: [f64; 8] = core::array::from_fn(|i| at(self.turn, node(i).0) * TAU);
            let lift = |g: fn(f64) -> f64| f32x8::from(turn.map(|turn| (r * g(turn)) as f32));
            let points = Vec3x8::new(lift(libm::cos), lift(libm::sin), f32x8::splat(z as f32));
            let values = f(points).to_array();
            sum += row_weight * (0..8).map(|i| node(i).1 * f64::from(values[i])).sum::<f64>();
        }
        sum * TAU * (self.cosine.1 - self.cosine.0) * (self.turn.1 - self.turn.0)
    }

    /// The integral by quarters, and whether a cell that should hold at most `most` has to be split.
    pub fn judge(&self, f: &impl Fn(Vec3x8) -> f32x8, most: f64) -> (f64, bool) {
        let (whole, parts) = (self.integral(f), self.quarters().map(|quarter| quarter.integral(f)));
        let sum = parts.iter().sum::<f64>();
        let rough = (sum - whole).abs() > 1e-7 + 1e-3 * sum;
        let split = self.depth < LEAST_DEPTH || (self.depth < MOST_DEPTH && (rough || sum > most));
        (sum, split)
    }
}

/// The integral of `f` over the hemisphere; its error is that of 1024 or more cells, 1e-3 of each and mostly far less.
pub fn hemisphere(f: impl Fn(Vec3x8) -> f32x8) -> f64 {
    fn visit(cell: Cell, f: &impl Fn(Vec3x8) -> f32x8) -> f64 {
        match cell.judge(f, f64::INFINITY) {
            (_, true) => cell.quarters().map(|quarter| visit(quarter, f)).iter().sum(),
            (sum, false) => sum,
        }
    }
    visit(Cell::ALL, &f)
}
