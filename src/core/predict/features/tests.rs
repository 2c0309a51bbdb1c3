use super::*;
use crate::maths::sobol::hash;
use proptest::prelude::*;

const WIDTH: usize = 132;
const HEIGHT: usize = 116;
const PIXELS: usize = WIDTH * HEIGHT;
const SCRATCH: usize = required(WIDTH, HEIGHT);
const MANY: usize = 300;

fn unit(seed: u32, i: usize) -> f32 {
    (hash(hash(seed) ^ i as u32) >> 8) as f32 / 16_777_216.0
}

/// Ninety soft blobs of random place, size, shape and brightness: place, axes over their squared lengths, height.
fn blobs(seed: u32) -> [[f32; 7]; 90] {
    core::array::from_fn(|i| {
        let number = |k: usize| unit(seed, 8 * i + k);
        let (sin, cos) = (libm::sinf(6.3 * number(2)), libm::cosf(6.3 * number(2)));
        let size = 1.5 + 7.0 * number(3) * number(3);
        let (a, b) = (1.0 / size, 1.0 / (size * (0.5 + number(4))));
        let place = |k: usize| 160.0 * number(k) - 14.0;
        [place(0), place(1), cos * a, sin * a, cos * b, sin * b, 0.8 * (number(5) - 0.5)]
    })
}

/// A picture of some blobs through a mapping from its pixels to the blobs' plane.
fn render(seed: u32, map: impl Fn(f32, f32) -> (f32, f32)) -> [f32; PIXELS] {
    let blobs = blobs(seed);
    core::array::from_fn(|i| {
        let (x, y) = map((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5);
        blobs.iter().fold(0.5, |sum, [left, top, ax, ay, bx, by, height]| {
            let (dx, dy) = (x - left, y - top);
            let (u, v) = (dx * ax + dy * ay, dy * bx - dx * by);
            let square = u * u + v * v;
            if square > 30.0 { sum } else { sum + height * libm::expf(-0.5 * square) }
        })
    })
}

/// Features of a picture of `WIDTH` × `HEIGHT`.
fn found(values: &[f32], features: &mut [Feature]) -> usize {
    let picture = Picture::new(values, WIDTH, HEIGHT).expect("the right size");
    detect(picture, &Settings::default(), &mut [0.0; SCRATCH], features).expect("enough scratch")
}

/// Matches between the plain picture and a mapped one: all, and those within a pixel of the mapping.
fn agreement(map: impl Fn(f32, f32) -> (f32, f32)) -> (usize, usize) {
    let (mut plain, mut mapped) = ([Feature::default(); MANY], [Feature::default(); MANY]);
    let counts = [found(&render(1, |x, y| (x, y)), &mut plain), found(&render(1, &map), &mut mapped)];
    let (plain, mapped) = (&plain[..counts[0]], &mapped[..counts[1]]);
    let right = |m: &Match| {
        let (p, q) = (&plain[m.to], &mapped[m.from]);
        let (x, y) = map(q.x, q.y);
        (x - p.x).abs().max((y - p.y).abs()) < 1.0
    };
    let all = matches(mapped, plain, 0.8);
    all.fold((0, 0), |(all, good), m| (all + 1, good + usize::from(right(&m))))
}

#[test]
fn a_blob_is_found_where_it_is_with_its_size_and_sign() {
    for (x, y, size, height) in [(60.3, 50.8, 4.0, 0.5), (70.0, 41.25, 7.0, -0.3), (33.0, 80.5, 10.0, 0.4)] {
        let picture: [f32; PIXELS] = core::array::from_fn(|i| {
            let (dx, dy) = ((i % WIDTH) as f32 + 0.5 - x, (i / WIDTH) as f32 + 0.5 - y);
            0.5 + height * libm::expf(-0.5 * (dx * dx + dy * dy) / (size * size))
        });
        let mut features = [Feature::default(); MANY];
        let count = found(&picture, &mut features);
        let best = features[..count].iter().max_by(|a, b| a.response.abs().total_cmp(&b.response.abs()));
        let best = best.expect("a blob is a feature");
        assert!((best.x - x).abs() < 0.1 && (best.y - y).abs() < 0.1, "{best:?}");
        // A Gaussian's normalised Laplacian is largest at its own size; differences of Gaussians see it between
        // their two scales, 2^(1/3) apart.
        assert!((best.scale * 1.12 / size - 1.0).abs() < 0.1, "{best:?}");
        assert_eq!(best.response < 0.0, height > 0.0);
    }
}

#[test]
fn features_are_found_again_moved_turned_and_scaled() {
    for (turn, scale) in [(0.0, 1.0), (0.01, 1.0), (0.06, 1.1), (0.25, 1.0), (0.4, 0.9), (0.5, 1.3)] {
        let angle = turn * core::f32::consts::TAU;
        let (sin, cos) = (libm::sinf(angle) * scale, libm::cosf(angle) * scale);
        let map = |x: f32, y: f32| {
            let (x, y) = (x - 66.0, y - 58.0);
            (cos * x - sin * y + 68.5, sin * x + cos * y + 57.25)
        };
        let (all, good) = agreement(map);
        assert!(good >= 12 && 10 * good >= 7 * all, "turn {turn}, scale {scale}: {good} of {all}");
    }
}

#[test]
fn different_pictures_have_few_matches() {
    let far = |x: f32, y: f32| (x + 5_000.0, y);
    assert_eq!(agreement(far).0, 0, "a flat picture has no features");
    let (mut here, mut there) = ([Feature::default(); MANY], [Feature::default(); MANY]);
    let counts = [found(&render(2, |x, y| (x, y)), &mut here), found(&render(3, |x, y| (x, y)), &mut there)];
    assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
    let matches = matches(&here[..counts[0]], &there[..counts[1]], 0.8).count();
    assert!(10 * matches < counts[0], "{matches} of {counts:?}");
}

#[test]
fn straight_edges_are_no_features() {
    let mut features = [Feature::default(); MANY];
    for slope in [0.0, 0.3, 1.0] {
        let picture: [f32; PIXELS] = core::array::from_fn(|i| {
            ((i % WIDTH) as f32 - slope * (i / WIDTH) as f32 - 30.0).clamp(0.0, 1.0)
        });
        // At the border the reflected edge has corners, which larger features see from afar.
        let inside = |f: &&Feature| {
            f.scale < 5.0 && f.x.min(f.y) > 20.0 && f.x < WIDTH as f32 - 20.0 && f.y < HEIGHT as f32 - 20.0
        };
        let count = found(&picture, &mut features);
        assert_eq!(features[..count].iter().filter(inside).count(), 0, "slope {slope}");
    }
}

#[test]
fn the_strongest_stay_when_there_is_little_room() {
    let picture = render(1, |x, y| (x, y));
    let (mut all, mut few) = ([Feature::default(); MANY], [Feature::default(); 10]);
    let count = found(&picture, &mut all);
    assert!(count > 20 && count < MANY, "{count}");
    assert_eq!(found(&picture, &mut few), 10);
    assert_eq!(found(&picture, &mut []), 0);
    let weakest = few.iter().map(|f| f.response.abs()).fold(f32::INFINITY, f32::min);
    assert!(all[..count].iter().filter(|f| f.response.abs() > weakest).count() < 10);
}

#[test]
fn descriptors_have_unit_norm() {
    let mut features = [Feature::default(); MANY];
    let count = found(&render(1, |x, y| (x, y)), &mut features);
    for feature in &features[..count] {
        let square: f64 = feature.descriptor.iter().map(|d| f64::from(*d) * f64::from(*d)).sum();
        assert!((square.sqrt() / f64::from(UNIT) - 1.0).abs() < 1e-3);
    }
}

#[test]
fn wild_pixels_do_no_harm() {
    let mut picture = render(1, |x, y| (x, y));
    for (i, wild) in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, -5.0].into_iter().enumerate() {
        picture[WIDTH * (20 + 15 * i) + 60] = wild;
    }
    let mut features = [Feature::default(); MANY];
    let count = found(&picture, &mut features);
    let numbers = |f: &Feature| [f.x, f.y, f.scale, f.turn, f.response];
    assert!(count > 20 && features[..count].iter().flat_map(numbers).all(f32::is_finite));
}

#[test]
fn unusable_arguments_are_errors() {
    let values = [0.0; PIXELS];
    assert_eq!(Picture::new(&values, WIDTH, HEIGHT - 1).err(), Some(Error::Size));
    assert_eq!(Picture::new(&values[..15 * 20], 15, 20).err(), Some(Error::Size));
    let picture = Picture::new(&values, WIDTH, HEIGHT).expect("the right size");
    let mut scratch = [0.0; SCRATCH];
    assert_eq!(detect(picture, &Settings::default(), &mut scratch[1..], &mut []), Err(Error::Scratch));
    assert_eq!(median3(picture, &mut scratch[..5]), Err(Error::Size));
    for (blur, contrast, edge) in
        [(0.5, 0.0, 10.0), (f32::NAN, 0.0, 10.0), (2.0, -1.0, 10.0), (2.0, 0.0, 0.5)]
    {
        let settings = Settings { blur, contrast, edge };
        assert_eq!(detect(picture, &settings, &mut scratch, &mut []), Err(Error::Settings));
    }
}

/// The median filter against sorting, at widths that packets do not divide.
#[test]
fn medians_agree_with_sorting() {
    for (width, height) in [(16, 16), (17, 19), (23, 40), (64, 16)] {
        let values: [f32; 64 * 40] = core::array::from_fn(|i| unit(5, i));
        let values = &values[..width * height];
        let mut filtered = [0.0; 64 * 40];
        let picture = Picture::new(values, width, height).expect("large enough");
        median3(picture, &mut filtered[..width * height]).expect("as many values");
        for (i, median) in filtered[..width * height].iter().enumerate() {
            let mut around: [f32; 9] = core::array::from_fn(|k| {
                let (x, y) = ((i % width + k % 3).saturating_sub(1), (i / width + k / 3).saturating_sub(1));
                values[y.min(height - 1) * width + x.min(width - 1)]
            });
            around.sort_by(f32::total_cmp);
            assert_eq!(*median, around[4], "{width} x {height}, pixel {i}");
        }
    }
}

/// The blur against its definition in double precision, one pixel at a time.
#[test]
fn blurs_agree_with_their_definition() {
    let (width, height, sigma) = (19, 16, 1.7f32);
    let source: [f32; 19 * 16] = core::array::from_fn(|i| unit(6, i));
    let (mut target, mut row) = ([0.0; 19 * 16], [0.0; blur::row_len(19)]);
    blur::blur(&source, &mut target, (width, height), sigma, &mut row);
    let reflect = |i: isize, side: usize| {
        let i = if i < 0 { -1 - i } else { i } as usize;
        if i < side { i } else { 2 * side - 1 - i }
    };
    let radius = libm::ceilf(3.0 * sigma) as isize;
    let weight = |k: isize| libm::exp(-0.5 * (k as f64 / f64::from(sigma)) * (k as f64 / f64::from(sigma)));
    let norm: f64 = (-radius..=radius).map(weight).sum();
    for (i, value) in target.iter().enumerate() {
        let (x, y) = ((i % width) as isize, (i / width) as isize);
        let mut exact = 0.0;
        for (dy, dx) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dy, dx))) {
            let at = reflect(y + dy, height) * width + reflect(x + dx, width);
            exact += weight(dx) * weight(dy) * f64::from(source[at]) / (norm * norm);
        }
        assert!((f64::from(*value) - exact).abs() < 1e-6, "pixel {i}");
    }
}

proptest! {
    /// Any size and any values: features lie in the picture and are numbers.
    #[test]
    fn features_lie_in_the_picture(width in 16usize..70, height in 16usize..60, seed: u32, power in 0i32..3) {
        let values: [f32; 70 * 60] = core::array::from_fn(|i| libm::powf(unit(seed, i), power as f32));
        let picture = Picture::new(&values[..width * height], width, height).expect("large enough");
        let mut features = [Feature::default(); 100];
        let mut scratch = [0.0; required(70, 60)];
        let count = detect(picture, &Settings::default(), &mut scratch, &mut features).expect("enough scratch");
        for f in &features[..count] {
            prop_assert!(f.x > 0.0 && f.x < width as f32 && f.y > 0.0 && f.y < height as f32, "{:?}", f);
            prop_assert!(f.scale.is_finite() && (0.0..=1.0).contains(&f.turn) && f.response.is_finite());
        }
    }
}
