//! Lights of `KHR_lights_punctual` as things that shine.
//!
//! The tracer knows lamps of some size and discs in the sky, so that nothing shines from a point:
//!
//! * a point light of I candela is a small sphere of even radiance; what it sends in all directions together is that of the
//!   point light exactly, in a single one up to a thousandth;
//! * a spot light is such a sphere in the middle of a black shell with a hole. Within the inner cone all of the sphere is
//!   seen through the hole, beyond the outer one nothing, and between them a part of it;
//! * the brightest directional light of E lux is a disc in the sky as wide as the sun (0.53°) of radiance E over its solid
//!   angle. Others are spots in a picture of the sky, about as wide.
//!
//! Candela are per square metre of scene units: where the light should fall off by the square of a distance in metres, a
//! unit is a metre. A sphere's radius is a thousandth of the scene's size, and less where something is near.

use crate::scene::assemble::{Assembly, lamp};
use crate::scene::notes::Notes;
use crate::scene::object::{Corner, Extras};
use crate::scene::place::Placement;
use crate::scene::script::ObjectTrack;
use crate::scene::shapes;
use crate::scene::sky::SkyMap;
use glam::{DVec3, Vec3};
use gltf::Document;
use gltf::khr_lights_punctual::{Kind, Light};
use pmcip_core::tracer::scene::{Material, Sun};
use std::f32::consts::{PI, TAU};
use std::path::Path;

/// How often the icosahedron of a lamp is split.
const SUBDIVISIONS: u32 = 2;
/// A lamp's radius as a part of the scene's size, of the distance of what is nearest, and the least of the former.
const OF_SIZE: f64 = 1e-3;
const OF_DISTANCE: f64 = 0.1;
const LEAST_OF_SIZE: f64 = 1e-4;
/// Half the angle under which the sun is seen, in radians.
const SUN: f32 = 0.00465;
/// Rows of the picture of further directional lights.
const ROWS: u32 = 512;
/// The most candela or lux that a light may have, and the most radiance that a lamp gets.
const BRIGHTEST: f32 = 1e20;
/// How wide the edge of a spot at least is, in radians.
const LEAST_EDGE: f32 = 0.01;

/// A lamp at a node.
struct Lamp {
    node: usize,
    intensity: [f32; 3],
    /// Inner and outer angle of a spot.
    cone: Option<(f32, f32)>,
}

/// Lights of a scene: lamps at nodes, and light from afar.
#[derive(Default)]
pub(super) struct Lights {
    lamps: Vec<Lamp>,
    /// Directions to the lights, and lux.
    distant: Vec<(Vec3, [f32; 3])>,
}

impl Lights {
    /// The lights of these nodes; `track` is what a node does over time.
    pub fn read(
        document: &Document,
        shown: &[usize],
        track: impl Fn(usize) -> ObjectTrack,
        notes: &mut Notes,
    ) -> Lights {
        let mut lights = Lights::default();
        let nodes: Vec<_> = document.nodes().collect();
        for &node in shown {
            if let Some(light) = nodes[node].light() {
                lights.add(node, &light, track(node), notes);
            }
        }
        lights
    }

    fn add(&mut self, node: usize, light: &Light<'_>, track: ObjectTrack, notes: &mut Notes) {
        let intensity = light.color().map(|v| v.max(0.0) * light.intensity());
        if !intensity.iter().all(|v| (0.0..=BRIGHTEST).contains(v)) {
            notes.add("dark", || {
                format!("light {}: its intensity is not between 0 and {BRIGHTEST:e}: left out", light.index())
            });
            return;
        }
        if intensity == [0.0; 3] {
            return;
        }
        if light.range().is_some_and(f32::is_finite) {
            notes.add("range", || "the range of lights is without effect: light has no end".into());
        }
        match light.kind() {
            Kind::Directional => {
                if matches!(&track, ObjectTrack::Rigid { rig, node } if rig.moves(*node)) {
                    notes.add("still", || "directional lights stay as they are in the first frame".into());
                }
                // A light shines along −z.
                let back = track.at(0.0).unwrap_or(Placement::IDENTITY).normal(Vec3::Z);
                self.distant.push((back.normalize_or(Vec3::Z), intensity));
            }
            Kind::Point => self.lamps.push(Lamp { node, intensity, cone: None }),
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let outer = outer_cone_angle.clamp(LEAST_EDGE, 0.5 * PI);
                let cone = (inner_cone_angle.clamp(0.0, outer - LEAST_EDGE.min(0.5 * outer)), outer);
                self.lamps.push(Lamp { node, intensity, cone: Some(cone) });
            }
        }
    }

    /// How many triangles all lamps are made of.
    fn triangles(&self) -> usize {
        let shells = self.lamps.iter().filter(|lamp| lamp.cone.is_some()).count();
        shapes::sphere_len(SUBDIVISIONS) * self.lamps.len() + Shell::TRIANGLES * shells
    }

    /// Adds the lamps as objects to an assembly of which `paths` says what its objects do over time.
    pub fn add_lamps(
        &self,
        path: &Path,
        assembly: &mut Assembly,
        paths: &mut Vec<ObjectTrack>,
        track: impl Fn(usize) -> ObjectTrack,
    ) -> Result<(), String> {
        assembly.ask_for(self.triangles())?;
        let place = |track: &ObjectTrack| track.at(0.0).unwrap_or(Placement::IDENTITY);
        let placements: Vec<Placement> = paths.iter().map(place).collect();
        let tracks: Vec<ObjectTrack> = self.lamps.iter().map(|lamp| track(lamp.node)).collect();
        let points: Vec<DVec3> = tracks.iter().map(|track| place(track).exact(Vec3::ZERO)).collect();
        let (size, distances) = assembly.clearances(&placements, &points);
        let size = if size.is_normal() { size } else { 1.0 };
        let black = Material { diffuse: [0.0; 3], ..Material::default() };
        let black = self.lamps.iter().any(|lamp| lamp.cone.is_some()).then(|| assembly.add_material(black));
        for ((each, track), distance) in self.lamps.iter().zip(tracks).zip(distances) {
            let whole = (OF_SIZE * size).min(OF_DISTANCE * distance).max(LEAST_OF_SIZE * size) as f32;
            let shell = each.cone.map(Shell::new);
            // A shell takes the room that the sphere would.
            let radius = whole * shell.as_ref().map_or(1.0, |shell| shell.sphere);
            assembly.begin(path, DVec3::ZERO);
            let sphere = sphere(radius);
            let radiance = 4.0 / sphere.iter().map(area).sum::<f32>();
            let material = assembly.add_material(lamp(each.intensity.map(|v| (v * radiance).min(BRIGHTEST))));
            sphere.into_iter().for_each(|corners| assembly.add_with(corners, material, Extras::default()));
            if let (Some(shell), Some(black)) = (shell, black) {
                shell.triangles(whole).into_iter().for_each(|corners| {
                    assembly.add_with(corners, black, Extras::default());
                });
            }
            paths.push(track);
        }
        Ok(())
    }

    /// Light from afar, not seen by itself; none if there is none.
    pub fn sky(&self) -> Option<SkyMap> {
        let brightest = |light: &&(Vec3, [f32; 3])| light.1.iter().sum::<f32>();
        let first = self.distant.iter().max_by(|a, b| brightest(a).total_cmp(&brightest(b)))?;
        let sine2 = SUN.sin().powi(2);
        // What a surface that faces it gets of a disc: π sin² of its radius times its radiance.
        let sun =
            Sun { direction: first.0.to_array(), radius: SUN, radiance: first.1.map(|v| v / (PI * sine2)) };
        let others = self.distant.iter().filter(|light| !std::ptr::eq(*light, first));
        let mut spots = others.peekable();
        let (size, texels) = match spots.peek() {
            None => ((1, 1), vec![[0.0; 3]]),
            Some(_) => ((2 * ROWS, ROWS), picture(spots)),
        };
        let mut sky = SkyMap::new(size, texels, Some(sun), "directional lights".into());
        sky.visible = false;
        Some(sky)
    }

    /// Says what lights are made of.
    pub fn name(&self, notes: &mut Notes) {
        if !self.lamps.is_empty() {
            let count = self.lamps.len();
            let what = "point and spot lights shine as small spheres, which are seen, too";
            notes.add("lamps", || format!("{count} {what}"));
        }
        if !self.distant.is_empty() {
            let count = self.distant.len();
            notes.add("distant", || {
                format!("{count} directional lights shine as discs in the sky, as wide as the sun")
            });
        }
    }
}

fn sphere(radius: f32) -> Vec<[Corner; 3]> {
    // Flat: what shines needs no normals.
    let corner = |c: Corner| Corner { position: radius * c.position, ..Corner::default() };
    shapes::sphere(SUBDIVISIONS).into_iter().map(|triangle| triangle.map(corner)).collect()
}

fn area(corners: &[Corner; 3]) -> f32 {
    let [a, b, c] = corners.map(|corner| corner.position);
    0.5 * (b - a).cross(c - a).length()
}

/// A shell of radius 1 with a hole around −z.
struct Shell {
    /// Radius of the sphere within.
    sphere: f32,
    /// Half the angle of the hole.
    hole: f32,
}

impl Shell {
    const SIDES: u32 = 48;
    const RINGS: u32 = 12;
    /// The last ring of quads is one of triangles.
    const TRIANGLES: usize = (Shell::SIDES * (2 * Shell::RINGS - 1)) as usize;

    /// Through the hole all of the sphere is seen up to the inner angle, nothing from the outer one on: the edge of the
    /// sphere is seen past that of the hole under an angle of asin(radius of the sphere).
    fn new((inner, outer): (f32, f32)) -> Shell {
        Shell { sphere: (0.5 * (outer - inner)).sin(), hole: 0.5 * (outer + inner) }
    }

    /// Triangles of the shell of this radius.
    fn triangles(&self, radius: f32) -> Vec<[Corner; 3]> {
        const SIDES: u32 = Shell::SIDES;
        const RINGS: u32 = Shell::RINGS;
        // Triangles are chords: at their middles the hole is as wide as it should be.
        let wide = self.hole.tan() / (PI / SIDES as f32).cos();
        let edge = if self.hole < 1.5 { wide.atan() } else { self.hole };
        let point = |ring: u32, side: u32| {
            let down = edge + (PI - edge) * ring as f32 / RINGS as f32;
            let (sin, cos) = (TAU * side as f32 / SIDES as f32).sin_cos();
            let position = radius * Vec3::new(down.sin() * cos, down.sin() * sin, -down.cos());
            Corner { position, ..Corner::default() }
        };
        let quads = (0..RINGS).flat_map(|ring| (0..SIDES).map(move |side| (ring, side)));
        let halves = quads.flat_map(|(ring, side)| {
            let [a, b] = [point(ring, side), point(ring, side + 1)];
            let [c, d] = [point(ring + 1, side), point(ring + 1, side + 1)];
            // The last ring is a point.
            if ring + 1 == RINGS { vec![[a, b, c]] } else { vec![[a, b, d], [a, d, c]] }
        });
        halves.collect()
    }
}

/// A picture of the sky with a spot for each light: the four texels around its direction share it.
fn picture<'a>(lights: impl Iterator<Item = &'a (Vec3, [f32; 3])>) -> Vec<[f32; 3]> {
    let (columns, rows) = (2 * ROWS as i32, ROWS as i32);
    let mut texels = vec![[0.0; 3]; (columns * rows) as usize];
    for (direction, lux) in lights {
        let around = direction.x.atan2(-direction.z).rem_euclid(TAU);
        let below = direction.y.clamp(-1.0, 1.0).acos();
        let [x, y] = [around, below].map(|angle| angle / PI * rows as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = |at: f32, first: f32, k: i32| if k == 0 { 1.0 - (at - first) } else { at - first };
            let share = weight(x, left, i) * weight(y, top, j);
            let column = (left as i32 + i).rem_euclid(columns);
            let row = (top as i32 + j).clamp(0, rows - 1);
            // Interpolated, a texel is seen as if all of it were in a cell of its own.
            let solid_angle = {
                let half = 0.5 * PI / rows as f32;
                4.0 * half * ((2 * row + 1) as f32 * half).sin() * half.sin()
            };
            let texel = &mut texels[(row * columns + column) as usize];
            (0..3).for_each(|c| texel[c] += share * lux[c] / solid_angle);
        }
    }
    texels
}
