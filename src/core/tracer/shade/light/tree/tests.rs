use super::*;
use crate::maths::sobol::hash;
use crate::maths::vec3;
use crate::tracer::scene::check::check_light_tree as check;
use crate::tracer::scene::light_tree::{build, required};
use crate::tracer::scene::{Error, Light, Material, SceneData, Surface, Triangle, light};

const MOST: usize = 300;
const RECEIVERS: usize = 40;

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

    fn unit(&mut self) -> [f32; 3] {
        loop {
            let v = self.vector();
            if let Some(unit) = vec3::normalized(v).filter(|_| (0.01..1.0).contains(&vec3::dot(v, v))) {
                return unit;
            }
        }
    }
}

struct Lamps {
    triangles: [Triangle; MOST],
    surfaces: [Surface; MOST],
    materials: [Material; 3],
    lights: [Light; MOST],
    nodes: [LightNode8; MOST],
    used: usize,
    count: usize,
}

impl Lamps {
    /// `count` triangles of sizes and radiances that differ widely, scattered over `[-3, 3]³`.
    fn new(count: usize, seed: u32) -> Lamps {
        let mut random = Random(seed);
        let lamp = |radiance: f32| Material { emission: [radiance; 3], ..Material::default() };
        let mut lamps = Lamps {
            triangles: [Triangle::default(); MOST],
            surfaces: [Surface::default(); MOST],
            materials: [lamp(0.01), lamp(1.0), lamp(1000.0)],
            lights: [Light::default(); MOST],
            nodes: [LightNode8::default(); MOST],
            used: 0,
            count,
        };
        for i in 0..count {
            let place = vec3::scale(random.vector(), 3.0);
            let size = libm::powf(10.0, random.number() - 1.0);
            let corner = |offset: [f32; 3]| [0, 1, 2].map(|c| place[c] + size * offset[c]);
            lamps.triangles[i].corners = [0; 3].map(|_| corner(random.vector()));
            lamps.surfaces[i].material = (i % 3) as u32;
        }
        let (triangles, surfaces) = (&lamps.triangles[..count], &lamps.surfaces[..count]);
        let made = light::build(triangles, surfaces, &lamps.materials, &mut lamps.lights);
        assert_eq!(made, count);
        let lights = &mut lamps.lights[..count];
        let mut order = [0; MOST];
        lamps.used = build(triangles, &[], surfaces, &lamps.materials, lights, &mut order, &mut lamps.nodes);
        lamps
    }

    fn nodes(&self) -> &[LightNode8] {
        &self.nodes[..self.used]
    }

    fn check(&self) -> Result<(), Error> {
        check(&SceneData {
            triangles: &self.triangles[..self.count],
            surfaces: &self.surfaces[..self.count],
            materials: &self.materials,
            lights: &self.lights[..self.count],
            light_nodes: self.nodes(),
            ..SceneData::default()
        })
    }

    /// Whether any of light `i` is on the lit side of `position` with `normal`, which is on its own front.
    fn shines(&self, i: usize, position: [f32; 3], normal: [f32; 3]) -> bool {
        let [a, b, c] = self.triangles[self.lights[i].triangle as usize].corners;
        let front = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
        let above = |corner| vec3::dot(vec3::sub(corner, position), normal) > 0.0;
        vec3::dot(vec3::sub(position, a), front) > 0.0 && (above(a) || above(b) || above(c))
    }
}

const COUNTS: [usize; 6] = [3, 7, 8, 9, 40, MOST];

#[test]
fn probabilities_sum_to_one_and_no_light_is_forgotten() {
    for count in COUNTS {
        let lamps = Lamps::new(count, count as u32);
        assert_eq!(lamps.check(), Ok(()), "{count}");
        let mut random = Random(7);
        for _ in 0..RECEIVERS {
            let (position, normal) = (vec3::scale(random.vector(), 3.5), random.unit());
            let receiver = Receiver { position: Vec3x8::splat(position), normal: Vec3x8::splat(normal) };
            let mut sum = 0.0;
            for i in 0..count {
                let probability = probability(lamps.nodes(), lamps.lights[i].path, &receiver, 3);
                sum += f64::from(probability);
                let shines = lamps.shines(i, position, normal);
                assert!(probability > 0.0 || !shines, "light {i} of {count} is never picked");
            }
            // 300 terms with a few roundings of 2^-24 each.
            assert!((sum - 1.0).abs() < 1e-5, "{count} lights: {sum}");
        }
    }
}

/// Even random numbers pick every light as often as its probability says, up to two of the numbers.
#[test]
fn lights_are_picked_as_often_as_they_should() {
    const NUMBERS: usize = 8192;
    for count in COUNTS {
        let lamps = Lamps::new(count, 100 + count as u32);
        let mut random = Random(11);
        for _ in 0..4 {
            let (position, normal) = (vec3::scale(random.vector(), 3.0), random.unit());
            let receiver = Receiver { position: Vec3x8::splat(position), normal: Vec3x8::splat(normal) };
            let root = Root::new(lamps.nodes(), receiver);
            let mut times = [0u32; MOST];
            for first in (0..NUMBERS).step_by(8) {
                let u = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| (first + lane) as f32 / NUMBERS as f32);
                let picked = root.pick(u.into());
                let chance = picked.probability.to_array();
                assert!(picked.again.to_array().iter().all(|again| (0.0..=1.0).contains(again)));
                for (lane, light) in picked.light.into_iter().enumerate() {
                    times[light as usize] += 1;
                    let path = lamps.lights[light as usize].path;
                    let expected = probability(lamps.nodes(), path, &receiver, lane);
                    assert!((chance[lane] / expected - 1.0).abs() < 1e-5, "light {light} of {count}");
                }
            }
            for (i, times) in times[..count].iter().enumerate() {
                let share = probability(lamps.nodes(), lamps.lights[i].path, &receiver, 0);
                let off = (f64::from(*times) - f64::from(share) * NUMBERS as f64).abs();
                assert!(off <= 2.0, "light {i} of {count}: {times} times, share {share}");
            }
        }
    }
}

/// The most even tree that there is: 300 equal lights in one place.
#[test]
fn lights_in_one_place_make_a_tree() {
    let mut lamps = Lamps::new(MOST, 1);
    lamps.triangles = [lamps.triangles[0]; MOST];
    lamps.surfaces = [Surface::default(); MOST];
    let mut order = [0; MOST];
    lamps.used = build(
        &lamps.triangles,
        &[],
        &lamps.surfaces,
        &lamps.materials,
        &mut lamps.lights,
        &mut order,
        &mut lamps.nodes,
    );
    assert_eq!(lamps.check(), Ok(()));
    assert!(lamps.lights.iter().all(|light| light.path < 1 << 9), "three levels hold 512");
}

#[test]
fn few_lights_need_no_tree_and_too_little_memory_makes_none() {
    assert_eq!((required(0), required(1), required(2)), (0, 0, 0));
    assert_eq!(Lamps::new(2, 5).used, 0);
    let mut lamps = Lamps::new(9, 5);
    let mut short = [0; 8];
    let (lights, nodes) = (&mut lamps.lights[..9], &mut lamps.nodes);
    assert_eq!(build(&lamps.triangles, &[], &lamps.surfaces, &lamps.materials, lights, &mut short, nodes), 0);
}

#[test]
fn a_tree_that_leads_astray_is_refused() {
    let fault = |change: fn(&mut Lamps)| {
        let mut lamps = Lamps::new(40, 9);
        change(&mut lamps);
        lamps.check().unwrap_err()
    };
    assert_eq!(fault(|l| l.nodes[0].child[0] = 0), Error::LightNode(0), "a node that contains itself");
    assert_eq!(fault(|l| l.nodes[0].child[0] = 99), Error::LightNode(0), "no such node");
    assert_eq!(fault(|l| l.nodes[1].power[0] = f32::NAN), Error::LightNode(1));
    assert_eq!(fault(|l| l.nodes[1].power[0] = 2.0), Error::LightNode(1));
    assert_eq!(fault(|l| l.nodes[1].child[0] = LIGHT_LEAF | 40), Error::LightNode(1), "no such light");
    assert_eq!(fault(|l| l.lights[7].path ^= 1), Error::LightPath(7), "another light's path");
    assert!(matches!(fault(|l| l.nodes[0].radius[0] *= 0.5), Error::LightPath(_)), "too small a sphere");
    assert!(matches!(fault(|l| l.nodes[0].centre[1][0] = f32::NAN), Error::LightPath(_)));
    assert!(matches!(fault(|l| l.nodes[0].cosine[0] += 0.2), Error::LightPath(_)), "too narrow a cone");
    assert_eq!(fault(|l| l.lights.swap(3, 4)), Error::LightPath(3), "triangles do not rise");
}
