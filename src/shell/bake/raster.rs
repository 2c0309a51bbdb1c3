//! Which texels a triangle touches, and the point of it that is nearest to a place.

/// A triangle of the atlas, in texels.
pub(super) type Flat = [[f32; 2]; 3];

/// Calls `f` with column and row of every texel that the triangle touches, within a square of `size` texels.
pub(super) fn touched(flat: &Flat, size: u32, mut f: impl FnMut(u32, u32)) {
    let range = |k: usize| {
        let at = flat.map(|corner| corner[k]);
        let least = at.into_iter().fold(f32::INFINITY, f32::min).floor().max(0.0) as u32;
        let most = at.into_iter().fold(f32::NEG_INFINITY, f32::max).floor().max(0.0) as u32;
        least..=most.min(size - 1)
    };
    for y in range(1) {
        for x in range(0) {
            if touches(flat, [x as f32 + 0.5, y as f32 + 0.5]) {
                f(x, y);
            }
        }
    }
}

/// Whether no edge of the triangle parts it from the unit square around `centre`; their boxes are known to meet.
fn touches(flat: &Flat, centre: [f32; 2]) -> bool {
    (0..3).all(|k| {
        let (a, b, other) = (flat[k], flat[(k + 1) % 3], flat[(k + 2) % 3]);
        let normal = [b[1] - a[1], a[0] - b[0]];
        let along = |p: [f32; 2]| normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1]);
        let half = 0.5 * (normal[0].abs() + normal[1].abs());
        let (inner, square) = (along(other), along(centre));
        let (least, most) = (inner.min(0.0), inner.max(0.0));
        square + half >= least && square - half <= most
    })
}

/// The barycentric weights of the point of the triangle that is nearest to `place`, and its squared distance.
pub(super) fn nearest(flat: &Flat, place: [f32; 2]) -> ([f32; 3], f32) {
    let cross = |a: [f32; 2], b: [f32; 2]| a[0] * b[1] - a[1] * b[0];
    let minus = |a: [f32; 2], b: [f32; 2]| [a[0] - b[0], a[1] - b[1]];
    let [a, b, c] = *flat;
    let area = cross(minus(b, a), minus(c, a));
    let weights = [(b, c), (c, a), (a, b)].map(|(p, q)| cross(minus(p, place), minus(q, place)) / area);
    if weights.iter().all(|w| *w >= 0.0) {
        return (weights, 0.0);
    }
    let on_side = |k: usize| {
        let (p, q) = (flat[k], flat[(k + 1) % 3]);
        let (way, to) = (minus(q, p), minus(place, p));
        let length = way[0] * way[0] + way[1] * way[1];
        let t = ((way[0] * to[0] + way[1] * to[1]) / length.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let off = [to[0] - t * way[0], to[1] - t * way[1]];
        let mut weights = [0.0; 3];
        (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
        (weights, off[0] * off[0] + off[1] * off[1])
    };
    let [first, second, third] = [0, 1, 2].map(on_side);
    let nearer = |a: ([f32; 3], f32), b: ([f32; 3], f32)| if b.1 < a.1 { b } else { a };
    nearer(nearer(first, second), third)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = [f32; 2]> {
        [0.0f32..16.0, 0.0f32..16.0]
    }

    proptest! {
        #[test]
        fn every_texel_with_a_point_of_the_triangle_is_touched(
            flat in [corner(), corner(), corner()],
            weights in prop::collection::vec((0.0f32..1.0, 0.0f32..1.0), 64),
        ) {
            let mut found = std::collections::BTreeSet::new();
            touched(&flat, 16, |x, y| { found.insert((x, y)); });
            for (u, v) in weights {
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let at = [0, 1].map(|k| flat[0][k] * (1.0 - u - v) + flat[1][k] * u + flat[2][k] * v);
                // A point on the border between two texels may be of either.
                let inner = at.iter().all(|x| (x - x.round()).abs() > 1e-4);
                prop_assert!(!inner || found.contains(&(at[0] as u32, at[1] as u32)));
            }
        }

        #[test]
        fn nothing_of_the_triangle_is_nearer_than_the_nearest(
            flat in [corner(), corner(), corner()],
            place in corner(),
            (u, v) in (0.0f32..1.0, 0.0f32..1.0),
        ) {
            let (weights, distance) = nearest(&flat, place);
            prop_assume!(weights.iter().all(|w| w.is_finite()));
            let at = |w: [f32; 3]| [0, 1].map(|k| flat[0][k] * w[0] + flat[1][k] * w[1] + flat[2][k] * w[2]);
            let square = |p: [f32; 2]| (p[0] - place[0]).powi(2) + (p[1] - place[1]).powi(2);
            prop_assert!((square(at(weights)) - distance).abs() <= 1e-2);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            prop_assert!(square(at([1.0 - u - v, u, v])) >= distance - 1e-2);
        }
    }
}
