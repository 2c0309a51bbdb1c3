use super::super::texel::bilinear;
use super::*;
use crate::maths::sobol::hash;
use crate::tracer::scene::{Material, Motion, Surface, Texture, Triangle};

impl SurfacePoints {
    /// The plane z = 0 of this material, its shading normal up, met at this cosine to its front.
    pub(in crate::tracer::shade) fn flat(material: &Material, cosine: f32) -> Self {
        let up = Vec3x8::splat([0.0, 0.0, 1.0]);
        SurfacePoints {
            time: f32x8::ZERO,
            hit: super::super::queue::lane_mask(0xff),
            position: Vec3x8::default(),
            facing: up,
            normal: up,
            cosine: f32x8::splat(cosine),
            scattering: u32x8::splat(material.scattering as u32),
            diffuse: Vec3x8::splat(material.diffuse),
            specular: Vec3x8::splat(material.specular),
            roughness: f32x8::splat(material.roughness),
            ior: f32x8::splat(material.ior),
            emission: Vec3x8::splat(material.emission),
            typical_emission: Vec3x8::splat(material.emission),
            clearance: f32x8::ZERO,
            bent: false,
        }
    }
}

type Vector = [f64; 3];

const TRIANGLES: usize = 40;
/// Coordinates reach 3 and normals are the quotient of sums of three products: two dozen roundings. Triangles whose
/// edges are nearly parallel or whose normals nearly cancel out are not made.
const ROUNDING: f64 = 64.0 / (1 << 24) as f64;

const TEXELS: [[f32; 3]; 12] = {
    let mut texels = [[0.0; 3]; 12];
    let mut i = 0;
    while i < 12 {
        texels[i] = [i as f32 / 12.0, (i * 7 % 12) as f32 / 12.0, (i * 5 % 12) as f32 / 12.0];
        i += 1;
    }
    texels
};
const TEXTURES: [Texture; 2] = [
    Texture { width: 3, height: 2, first: 0, ..Texture::EMPTY },
    Texture { width: 2, height: 3, first: 6, ..Texture::EMPTY },
];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: Vector) -> Vector {
    a.map(|c| c / libm::sqrt(dot(a, a)))
}

fn facing(normal: Vector, direction: Vector) -> Vector {
    if dot(normal, direction) > 0.0 { normal.map(|c| -c) } else { normal }
}

/// Numbers from −1 to 1, the same in every run.
struct Random(u32);

impl Random {
    fn number(&mut self) -> f32 {
        self.0 = hash(self.0);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.number())
    }

    /// Something like the unit vector of an axis.
    fn near(&mut self, axis: usize) -> [f32; 3] {
        let v = self.vector();
        [0, 1, 2].map(|c| 0.3 * v[c] + if c == axis { 1.0 } else { 0.0 })
    }
}

struct World {
    triangles: [Triangle; TRIANGLES],
    surfaces: [Surface; TRIANGLES],
    materials: [Material; 3],
}

impl World {
    /// Triangles around the three axes' unit points; every fourth is flat, two in three have a texture.
    fn new(random: &mut Random) -> World {
        let plain = Material { diffuse: [0.75, 0.5, 0.25], ..Material::default() };
        let mut world = World {
            triangles: [Triangle::default(); TRIANGLES],
            surfaces: [Surface::default(); TRIANGLES],
            materials: [plain, Material { texture: 0, ..plain }, Material { texture: 1, ..plain }],
        };
        for (i, (triangle, surface)) in world.triangles.iter_mut().zip(&mut world.surfaces).enumerate() {
            let place = random.vector();
            triangle.corners = [0, 1, 2].map(|axis| {
                let corner = random.near(axis);
                [0, 1, 2].map(|c| corner[c] + place[c])
            });
            if i % 4 != 0 {
                surface.normals = [0; 3].map(|_| random.near(0));
            }
            surface.uv = [0; 3].map(|_| [3.0 * random.number(), 3.0 * random.number()]);
            surface.material = i as u32 % 3;
        }
        world
    }

    fn scene(&self) -> Scene<'_> {
        Scene::new(SceneData {
            triangles: &self.triangles,
            surfaces: &self.surfaces,
            materials: &self.materials,
            textures: &TEXTURES,
            texels: &TEXELS,
            ..SceneData::default()
        })
        .expect("the triangles are a scene")
    }
}

/// One hit, worked out in f64.
struct Twin {
    position: Vector,
    facing: Vector,
    normal: Vector,
    cosine: f64,
    diffuse: Vector,
}

impl Twin {
    fn new(world: &World, triangle: usize, (u, v): (f32, f32), direction: Vector) -> Twin {
        let weights = [1.0 - f64::from(u) - f64::from(v), f64::from(u), f64::from(v)];
        let mix = |rows: [[f32; 3]; 3]| {
            [0, 1, 2].map(|c| (0..3).map(|k| weights[k] * f64::from(rows[k][c])).sum::<f64>())
        };
        let corners = world.triangles[triangle].corners;
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let [p, q] = [b, c].map(|corner| [0, 1, 2].map(|i| corner[i] - a[i]));
        let front = unit([p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]);
        let surface = &world.surfaces[triangle];
        let smooth = if triangle.is_multiple_of(4) { front } else { unit(mix(surface.normals)) };
        let uv = mix(surface.uv.map(|[u, v]| [u, v, 0.0]));
        let material = &world.materials[surface.material as usize];
        let texture = TEXTURES.get(material.texture as usize).map_or([1.0; 3], |t| texel(t, uv[0], uv[1]));
        Twin {
            position: mix(corners),
            facing: facing(front, direction),
            normal: facing(smooth, direction),
            cosine: -dot(direction, front),
            diffuse: [0, 1, 2].map(|c| f64::from(material.diffuse[c]) * texture[c]),
        }
    }
}

/// The texture as the sum of all texels within one of the point, by their distance, in the endlessly repeated plane.
fn texel(texture: &Texture, u: f64, v: f64) -> Vector {
    let (width, height) = (i64::from(texture.width), i64::from(texture.height));
    let (x, y) = (u * width as f64 - 0.5, (1.0 - v) * height as f64 - 0.5);
    let mut sum = [0.0; 3];
    for column in libm::floor(x) as i64..=libm::floor(x) as i64 + 1 {
        for row in libm::floor(y) as i64..=libm::floor(y) as i64 + 1 {
            let weight = (1.0 - (x - column as f64).abs()) * (1.0 - (y - row as f64).abs());
            let at = row.rem_euclid(height) * width + column.rem_euclid(width);
            let value = TEXELS[texture.first as usize + at as usize];
            sum = [0, 1, 2].map(|c| sum[c] + weight * f64::from(value[c]));
        }
    }
    sum
}

/// Eight hits on random triangles, from either side; lane 5 misses.
fn hits(random: &mut Random) -> (Rays8, Hits8) {
    let mut triangle = [0u32; 8].map(|_| ((random.number() * 0.5 + 0.5) * TRIANGLES as f32) as u32);
    triangle[5] = MISS;
    let (mut u, mut v) = ([0.0; 8], [0.0; 8]);
    let mut direction = [[0.0; 8]; 3];
    for lane in 0..8 {
        (u[lane], v[lane]) = (random.number().abs() * 0.5, random.number().abs() * 0.5);
        let unit = crate::maths::vec3::normalized(random.vector()).unwrap_or([1.0, 0.0, 0.0]);
        for (row, c) in direction.iter_mut().zip(unit) {
            row[lane] = c;
        }
    }
    let direction = Vec3x8::new(direction[0].into(), direction[1].into(), direction[2].into());
    let rays = Rays8 { origin: Vec3x8::default(), direction, t_max: f32x8::ONE, ..Rays8::default() };
    (rays, Hits8 { t: f32x8::ONE, u: u.into(), v: v.into(), triangle: triangle.into() })
}

fn lane(v: Vec3x8, lane: usize) -> Vector {
    [v.x, v.y, v.z].map(|row| f64::from(row.to_array()[lane]))
}

fn close(found: Vector, expected: Vector, bound: f64) -> bool {
    (0..3).all(|c| (found[c] - expected[c]).abs() < bound)
}

#[test]
fn every_lane_is_what_a_scalar_twin_finds() {
    let mut random = Random(3);
    let world = World::new(&mut random);
    let scene = world.scene();
    let (mut fronts, mut backs) = (0, 0);
    for _ in 0..500 {
        let (rays, hits) = hits(&mut random);
        let points = SurfacePoints::at(&scene, &rays, &hits);
        assert_eq!(points.hit.to_bitmask(), 0b1101_1111);
        let (u, v, triangle) = (hits.u.to_array(), hits.v.to_array(), hits.triangle.to_array());
        for at in (0..8).filter(|at| *at != 5) {
            let direction = lane(rays.direction, at);
            let twin = Twin::new(&world, triangle[at] as usize, (u[at], v[at]), direction);
            let cosine = f64::from(points.cosine.to_array()[at]);
            // Which side is seen is a matter of rounding where the ray grazes the surface.
            if twin.cosine.abs() < ROUNDING || dot(twin.normal, direction).abs() < ROUNDING {
                continue;
            }
            assert!((cosine - twin.cosine).abs() < ROUNDING, "triangle {}: {cosine}", triangle[at]);
            assert!(close(lane(points.position, at), twin.position, ROUNDING));
            assert!(close(lane(points.facing, at), twin.facing, ROUNDING));
            assert!(close(lane(points.normal, at), twin.normal, ROUNDING), "triangle {}", triangle[at]);
            // Coordinates reach 6, times three texels, and neighbours differ by up to 1.
            let diffuse = lane(points.diffuse, at);
            assert!(close(diffuse, twin.diffuse, ROUNDING), "{diffuse:?} instead of {:?}", twin.diffuse);
            (fronts, backs) = if twin.cosine > 0.0 { (fronts + 1, backs) } else { (fronts, backs + 1) };
        }
    }
    assert!(fronts > 1000 && backs > 1000, "both sides were seen: {fronts}, {backs}");
}

/// What moves is where its corners are on their straight way, and its normals are between those at the ends.
#[test]
fn what_moves_is_between_its_places() {
    let mut random = Random(11);
    let (open, closing) = (World::new(&mut random), World::new(&mut random));
    let normals = closing.surfaces.map(|surface| surface.normals);
    let motion = Motion { triangles: &closing.triangles, leaves: &[], normals: &normals };
    let moving = Scene::new(SceneData { motion: Some(motion), ..*open.scene().data() }).unwrap();
    for time in [0.0, 0.25, 0.75] {
        let mix = |a: [[f32; 3]; 3], b: [[f32; 3]; 3]| {
            [0, 1, 2].map(|k| [0, 1, 2].map(|c| a[k][c] + (b[k][c] - a[k][c]) * time))
        };
        let then = World {
            triangles: core::array::from_fn(|i| Triangle {
                corners: mix(open.triangles[i].corners, closing.triangles[i].corners),
            }),
            surfaces: core::array::from_fn(|i| Surface {
                normals: mix(open.surfaces[i].normals, normals[i]),
                ..open.surfaces[i]
            }),
            materials: open.materials,
        };
        let (rays, hits) = hits(&mut random);
        let found = SurfacePoints::at(&moving, &Rays8 { time: f32x8::splat(time), ..rays }, &hits);
        let expected = SurfacePoints::at(&then.scene(), &rays, &hits);
        for at in (0..8).filter(|at| *at != 5) {
            assert!(close(lane(found.position, at), lane(expected.position, at), ROUNDING), "{time}");
            assert!(close(lane(found.normal, at), lane(expected.normal, at), ROUNDING), "{time}");
            assert!(close(lane(found.facing, at), lane(expected.facing, at), ROUNDING), "{time}");
        }
    }
}

/// Rays leave off the surface, on the side they go to.
#[test]
fn rays_leave_on_their_own_side() {
    let mut random = Random(8);
    let world = World::new(&mut random);
    let (rays, hits) = hits(&mut random);
    let points = SurfacePoints::at(&world.scene(), &rays, &hits);
    for sign in [1.0, -1.0] {
        let toward = points.facing * f32x8::splat(sign);
        let height = (points.leave(toward) - points.position).dot(points.facing) * f32x8::splat(sign);
        for at in (0..8).filter(|at| *at != 5) {
            let corners = world.triangles[hits.triangle.to_array()[at] as usize].corners;
            let largest = corners.as_flattened().iter().fold(0.0, |a: f32, b| a.max(b.abs()));
            let clear = height.to_array()[at] / (largest * CLEARANCE);
            // Rounding of the position, a few of the 32 units of its last place that the clearance has.
            assert!((0.8..1.2).contains(&clear), "lane {at}: {clear}");
        }
    }
}

#[test]
fn texels_repeat_and_broken_coordinates_name_one() {
    for texture in &TEXTURES {
        for (u, v) in [(0.1, 0.2), (0.99, 0.01), (0.5, 0.5), (0.0, 1.0)] {
            let value = bilinear(texture, &TEXELS, u, v).map(f64::from);
            assert!(close(value, texel(texture, f64::from(u), f64::from(v)), ROUNDING));
            assert!(close(bilinear(texture, &TEXELS, u - 4.0, v + 7.0).map(f64::from), value, ROUNDING));
        }
        let broken = bilinear(texture, &TEXELS, f32::NAN, f32::INFINITY);
        assert!(broken.iter().all(|c| (0.0..=1.0).contains(c)));
    }
}
