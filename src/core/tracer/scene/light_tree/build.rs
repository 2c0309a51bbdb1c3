//! Builds the light tree: sets of lights are halved where that lessens their extent, spread and power most.

use super::node::{LIGHT_LEAF, LightNode8, MAX_LIGHT_DEPTH};
use crate::maths::vec3;
use crate::tracer::scene::light::{self, Light};
use crate::tracer::scene::motion::normals;
use crate::tracer::scene::surface::{Material, Surface, Triangle};
use core::f32::consts::{FRAC_PI_2, PI};

/// Up to as many lights the table of powers serves as well: two triangles are mostly the halves of one lamp.
const FEW: usize = 2;
/// Bins in which halves are looked for along an axis.
const BINS: usize = 12;

/// Nodes that [`build`] needs at most for `lights` lights.
pub const fn required(lights: usize) -> usize {
    if lights <= FEW { 0 } else { lights - 1 }
}

/// Fills `nodes` with a tree over `lights`, writes their paths, and returns how many nodes it has: 0 where the table
/// of powers serves as well, or where a slice is too short.
///
/// `lights` is what [`light::build`] has made of the same triangles, surfaces and materials. `closing` is where the triangles
/// are as the shutter closes; empty if they stand still. `order` is scratch for as many entries; [`required`] says how long
/// `nodes` should be.
pub fn build(
    triangles: &[Triangle],
    closing: &[Triangle],
    surfaces: &[Surface],
    materials: &[Material],
    lights: &mut [Light],
    order: &mut [u32],
    nodes: &mut [LightNode8],
) -> usize {
    let count = lights.len();
    let known = |l: &Light| {
        let surface = surfaces.get(l.triangle as usize).filter(|_| (l.triangle as usize) < triangles.len());
        surface.is_some_and(|s| (s.material as usize) < materials.len())
    };
    if count <= FEW || order.len() < count || nodes.len() < required(count) || !lights.iter().all(known) {
        return 0;
    }
    let order = &mut order[..count];
    (0..).zip(order.iter_mut()).for_each(|(i, slot)| *slot = i);
    let closing = if closing.len() == triangles.len() { closing } else { triangles };
    let mut builder = Builder { triangles, closing, surfaces, materials, lights, nodes, used: 0, scale: 1.0 };
    let power: f32 = order.iter().map(|&i| builder.power(i)).sum();
    builder.scale = 1.0 / power;
    if !(power.is_finite() && builder.scale.is_finite()) {
        return 0;
    }
    builder.node(order, 0, 0);
    builder.used
}

/// What is known of a set of lights while the tree is built.
#[derive(Clone, Copy)]
struct Group {
    lower: [f32; 3],
    upper: [f32; 3],
    /// Sum of the unit normals.
    normals: [f32; 3],
    power: f32,
    count: f32,
}

impl Group {
    const EMPTY: Group = Group {
        lower: [f32::INFINITY; 3],
        upper: [f32::NEG_INFINITY; 3],
        normals: [0.0; 3],
        power: 0.0,
        count: 0.0,
    };

    fn join(self, other: Group) -> Group {
        let pick = |f: fn(f32, f32) -> f32, a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|i| f(a[i], b[i]));
        Group {
            lower: pick(f32::min, self.lower, other.lower),
            upper: pick(f32::max, self.upper, other.upper),
            normals: pick(|a, b| a + b, self.normals, other.normals),
            power: self.power + other.power,
            count: self.count + other.count,
        }
    }

    /// Power times extent times spread: what a split should lessen. The extent is the squared diagonal, since nodes
    /// bound by spheres; the spread is the measure of Conty Estevez and Kulla for a cone whose normals, were they
    /// evenly distributed in it, would have the mean that these have.
    fn cost(&self) -> f32 {
        if self.count == 0.0 {
            return 0.0;
        }
        let diagonal = vec3::sub(self.upper, self.lower);
        let mean = libm::sqrtf(vec3::dot(self.normals, self.normals)) / self.count;
        self.power * vec3::dot(diagonal, diagonal) * spread((2.0 * mean - 1.0).clamp(-1.0, 1.0))
    }
}

/// Measure of the directions into which lights in a cone shine (Conty Estevez and Kulla 2018, equation 1).
fn spread(cosine: f32) -> f32 {
    let angle = libm::acosf(cosine);
    let reach = (angle + FRAC_PI_2).min(PI);
    let (sine, cos_back) = (libm::sinf(angle), libm::cosf(angle - 2.0 * reach));
    2.0 * PI * (1.0 - cosine) + FRAC_PI_2 * (2.0 * reach * sine - cos_back - 2.0 * angle * sine + cosine)
}

struct Builder<'a> {
    triangles: &'a [Triangle],
    closing: &'a [Triangle],
    surfaces: &'a [Surface],
    materials: &'a [Material],
    lights: &'a mut [Light],
    nodes: &'a mut [LightNode8],
    used: usize,
    /// One over the power of all.
    scale: f32,
}

impl Builder<'_> {
    /// A light's triangle as the shutter opens and closes.
    fn triangles(&self, light: u32) -> [&Triangle; 2] {
        let triangle = self.lights[light as usize].triangle as usize;
        [&self.triangles[triangle], &self.closing[triangle]]
    }

    /// All its corners.
    fn corners(&self, light: u32) -> impl Iterator<Item = [f32; 3]> {
        self.triangles(light).into_iter().flat_map(|triangle| triangle.corners)
    }

    fn power(&self, light: u32) -> f32 {
        let triangle = self.lights[light as usize].triangle as usize;
        let material = &self.materials[self.surfaces[triangle].material as usize];
        light::power(&self.triangles[triangle], material) as f32
    }

    /// Normals between which all its normals lie.
    fn normals(&self, light: u32) -> impl Iterator<Item = [f32; 3]> {
        let [open, closing] = self.triangles(light);
        normals(open, closing).into_iter().flatten()
    }

    fn single(&self, light: u32) -> Group {
        let pick = |f: fn(f32, f32) -> f32, start: f32| {
            self.corners(light).fold([start; 3], |all, corner| [0, 1, 2].map(|i| f(all[i], corner[i])))
        };
        let (lower, upper) = (pick(f32::min, f32::INFINITY), pick(f32::max, f32::NEG_INFINITY));
        let normal = self.normals(light).next().unwrap_or([0.0, 0.0, 1.0]);
        Group { lower, upper, normals: normal, power: self.power(light), count: 1.0 }
    }

    fn group(&self, lights: &[u32]) -> Group {
        lights.iter().fold(Group::EMPTY, |group, &light| group.join(self.single(light)))
    }

    /// Appends the node over `lights` and what is below it; returns its index. `path` leads to it.
    fn node(&mut self, lights: &mut [u32], level: u32, path: u32) -> u32 {
        let index = self.used;
        self.used += 1;
        self.nodes[index] = LightNode8::default();
        let (ends, parts) = self.divide(lights, level);
        let mut first = 0;
        for (slot, &end) in ends[..parts].iter().enumerate() {
            let part = &mut lights[first..end];
            first = end;
            self.bound(index, slot, part);
            let path = path | (slot as u32) << (3 * level);
            self.nodes[index].child[slot] = match *part {
                [light] => {
                    self.lights[light as usize].path = path;
                    LIGHT_LEAF | light
                }
                _ => self.node(part, level + 1, path),
            };
        }
        index as u32
    }

    /// Orders `lights` into up to eight parts; returns where they end, and how many they are.
    fn divide(&self, lights: &mut [u32], level: u32) -> ([usize; 8], usize) {
        // While any part could still become a tree of equal parts below, cost decides, then numbers.
        let by_cost = lights.len() >> (3 * (MAX_LIGHT_DEPTH - level - 1)).min(31) == 0;
        let (mut ends, mut costs, mut parts) = ([0; 8], [0.0f32; 8], 1);
        ends[0] = lights.len();
        while parts < 8 {
            let start = |i: usize| if i == 0 { 0 } else { ends[i - 1] };
            let size = |i: usize| ends[i] - start(i);
            let rank = |i: usize| (if by_cost { costs[i] } else { 0.0 }, size(i));
            let divisible = (0..parts).filter(|&i| size(i) > 1);
            let Some(part) = divisible.max_by(|&a, &b| {
                let (a, b) = (rank(a), rank(b));
                a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
            }) else {
                break;
            };
            let (first, end) = (start(part), ends[part]);
            let middle = first + self.halve(&mut lights[first..end], by_cost);
            ends.copy_within(part..parts, part + 1);
            costs.copy_within(part..parts, part + 1);
            ends[part] = middle;
            costs[part] = self.group(&lights[first..middle]).cost();
            costs[part + 1] = self.group(&lights[middle..end]).cost();
            parts += 1;
        }
        (ends, parts)
    }

    /// Orders at least two lights into two parts; returns the length of the first.
    fn halve(&self, lights: &mut [u32], by_cost: bool) -> usize {
        let split = if by_cost { self.best_split(lights) } else { None };
        let Some((axis, limit)) = split else { return lights.len() / 2 };
        let mut first = 0;
        for i in 0..lights.len() {
            if self.middle(lights[i], axis) < limit {
                lights.swap(i, first);
                first += 1;
            }
        }
        if first == 0 || first == lights.len() { lights.len() / 2 } else { first }
    }

    /// Twice the coordinate of a light's centre.
    fn middle(&self, light: u32, axis: usize) -> f32 {
        let Group { lower, upper, .. } = self.single(light);
        lower[axis] + upper[axis]
    }

    /// The axis and the coordinate of [`middle`](Self::middle) that part the lights at least cost.
    fn best_split(&self, lights: &[u32]) -> Option<(usize, f32)> {
        let mut best: Option<(f32, usize, f32)> = None;
        for axis in 0..3 {
            let middles = || lights.iter().map(|&light| self.middle(light, axis));
            let low = middles().fold(f32::INFINITY, f32::min);
            let extent = middles().fold(f32::NEG_INFINITY, f32::max) - low;
            if !(extent > 0.0 && extent.is_finite()) {
                continue;
            }
            let mut bins = [Group::EMPTY; BINS];
            for &light in lights {
                let place = (self.middle(light, axis) - low) / extent * BINS as f32;
                let bin = &mut bins[(place as usize).min(BINS - 1)];
                *bin = bin.join(self.single(light));
            }
            for (after, cost) in (1..BINS).filter_map(|after| Some((after, split_cost(&bins, after)?))) {
                if best.is_none_or(|best| cost < best.0) {
                    best = Some((cost, axis, low + extent * (after as f32 / BINS as f32)));
                }
            }
        }
        best.map(|(_, axis, limit)| (axis, limit))
    }

    /// Writes the bounds of a group into a node.
    fn bound(&mut self, node: usize, slot: usize, lights: &[u32]) {
        let group = self.group(lights);
        let centre = [0, 1, 2].map(|i| group.lower[i] + 0.5 * (group.upper[i] - group.lower[i]));
        let axis = vec3::normalized(group.normals).unwrap_or([0.0, 0.0, 1.0]);
        let (mut square, mut cosine) = (0.0f32, 1.0f32);
        for &light in lights {
            for corner in self.corners(light) {
                let away = vec3::sub(corner, centre);
                square = square.max(vec3::dot(away, away));
            }
            for normal in self.normals(light) {
                cosine = cosine.min(vec3::dot(normal, axis));
            }
        }
        let node = &mut self.nodes[node];
        for i in 0..3 {
            (node.centre[i][slot], node.axis[i][slot]) = (centre[i], axis[i]);
        }
        node.radius[slot] = libm::sqrtf(square);
        node.cosine[slot] = cosine.max(-1.0);
        // A light too weak for the number format still has a chance.
        node.power[slot] = (group.power * self.scale).clamp(f32::MIN_POSITIVE, 1.0);
    }
}

/// Cost of a split before bin `after`; none if a side is empty.
fn split_cost(bins: &[Group; BINS], after: usize) -> Option<f32> {
    let side = |bins: &[Group]| bins.iter().fold(Group::EMPTY, |a, b| a.join(*b));
    let (low, high) = (side(&bins[..after]), side(&bins[after..]));
    (low.count > 0.0 && high.count > 0.0).then(|| low.cost() + high.cost())
}
