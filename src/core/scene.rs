//! A scene as borrowed slices: what rays hit, what it looks like, what emits.
//!
//! The owner of a scene (the shell, an engine) keeps its arrays in whatever memory it likes and lends them as
//! [`SceneData`]. [`Scene::new`] checks every index and the depth of the tree once; after that the hot path
//! needs no error handling and a fixed stack suffices. Lengths are in scene units, colours linear Rec. 709.

use crate::shade::{light, light_tree};
use bytemuck::{NoUninit, Pod, Zeroable};

/// The value of [`Material::texture`] that means "none".
pub const NO_TEXTURE: u32 = u32::MAX;

/// A triangle's three corners. Its front is the side from which they run counter-clockwise.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// Corner positions.
    pub corners: [[f32; 3]; 3],
}

/// What a triangle looks like; `surfaces[i]` belongs to `triangles[i]`.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Surface {
    /// Unit shading normals at the corners, on the front side. All zero: the triangle is flat.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates at the corners, `v` growing upwards as in OBJ.
    pub uv: [[f32; 2]; 3],
    /// Index into [`SceneData::materials`].
    pub material: u32,
}

/// How a material scatters light.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, NoUninit)]
pub enum Scattering {
    /// Lambertian `diffuse` plus, where `specular` is not black, a GGX lobe of width `roughness` with Schlick
    /// Fresnel. Both sides of the surface.
    #[default]
    Rough,
    /// Perfect mirror tinted by `specular`. Both sides.
    Mirror,
    /// Smooth dielectric: the front faces air, the back a medium of index `ior`.
    Dielectric,
}

/// The narrowest GGX lobe: single precision cannot tell half vectors apart that are much closer to the normal. What is
/// meant to be smoother is a [`Mirror`](Scattering::Mirror).
pub const MIN_ROUGHNESS: f32 = 1e-6;

/// A surface material.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, NoUninit)]
pub struct Material {
    /// Diffuse reflectance, 0 to 1 a channel; multiplied by the texture.
    pub diffuse: [f32; 3],
    /// How it scatters.
    pub scattering: Scattering,
    /// Index into [`SceneData::textures`] or [`NO_TEXTURE`].
    pub texture: u32,
    /// Specular reflectance at normal incidence (rough), tint (mirror, dielectric), 0 to 1 a channel.
    pub specular: [f32; 3],
    /// Width α of the GGX distribution, [`MIN_ROUGHNESS`] to 1.
    pub roughness: f32,
    /// Index of refraction of the inside over that of the outside.
    pub ior: f32,
    /// Emitted radiance, on the front side only.
    pub emission: [f32; 3],
}

impl Default for Material {
    /// Grey diffuse.
    fn default() -> Self {
        Material {
            diffuse: [0.5; 3],
            scattering: Scattering::Rough,
            texture: NO_TEXTURE,
            specular: [0.0; 3],
            roughness: 1.0,
            ior: 1.5,
            emission: [0.0; 3],
        }
    }
}

/// A rectangle of texels in [`SceneData::texels`], row by row from the top, repeated over the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Texture {
    /// Texels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Index of the first texel.
    pub first: u32,
}

/// An emitting triangle, its place in the table that picks one by power, and its place in the light tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Index into [`SceneData::triangles`].
    pub triangle: u32,
    /// Probability that a light before this one, or this one, is picked; 1 for the last.
    pub cumulative: f32,
    /// Which child to follow in the light tree at each level, three bits a level, the root's lowest. Not used
    /// without a tree.
    pub path: u32,
}

/// Eight groups of lights: a node of the light tree.
///
/// A group is bounded by a sphere around its triangles and by a cone around their normals. Children that are there
/// come first.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightNode8 {
    /// Centres of the spheres, by axis and child.
    pub centre: [[f32; 8]; 3],
    /// Radii of the spheres.
    pub radius: [f32; 8],
    /// Unit axes of the cones, by axis and child.
    pub axis: [[f32; 8]; 3],
    /// Cosines of the cones' half angles.
    pub cosine: [f32; 8],
    /// Shares of the power (luminance times area) of all lights, above 0. 0: the child is not there.
    pub power: [f32; 8],
    /// For a group of one light [`LIGHT_LEAF`] plus its index in [`SceneData::lights`]; else the index of the
    /// group's node, which is above this node's own.
    pub child: [u32; 8],
}

/// What tells a single light from a group in [`LightNode8::child`].
pub const LIGHT_LEAF: u32 = 1 << 31;

/// Levels of nodes a light tree may have: [`Light::path`] has room for no more.
pub const MAX_LIGHT_DEPTH: u32 = 10;

/// Eight boxes and what is in them: a node of the bounding volume hierarchy, four cache lines.
///
/// Children that are there come first and have finite boxes that enclose what is below them; the others have the boxes of [`EMPTY`](Self::EMPTY).
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node8 {
    /// Lower corners of the children's boxes, by axis and child. An unused child has `+∞`.
    pub lower: [[f32; 8]; 3],
    /// Upper corners. An unused child has `−∞`.
    pub upper: [[f32; 8]; 3],
    /// For an inner child the index of its node, which is above this node's own; else the index of a leaf.
    pub child: [u32; 8],
    /// Number of triangles of a leaf, 1 to 8; 0 for an inner or unused child.
    pub count: [u32; 8],
}

impl Node8 {
    /// A node without children.
    pub const EMPTY: Node8 = Node8 {
        lower: [[f32::INFINITY; 8]; 3],
        upper: [[f32::NEG_INFINITY; 8]; 3],
        child: [0; 8],
        count: [0; 8],
    };

    /// Whether child `i` (0 to 7) is there: unused ones have empty boxes.
    #[inline(always)]
    pub fn is_used(&self, i: usize) -> bool {
        self.lower[0][i] <= self.upper[0][i]
    }

    /// How many children there are, if those that are not there come last and every box is finite or empty. A walk over a
    /// packet stops at the first empty box, that of a single ray looks at all eight: both must see the same.
    fn children(&self) -> Option<usize> {
        let used = (0..8).take_while(|&child| self.is_used(child)).count();
        let finite = |child: usize| {
            (0..3).all(|axis| {
                let (lower, upper) = (self.lower[axis][child], self.upper[axis][child]);
                lower <= upper && lower.is_finite() && upper.is_finite()
            })
        };
        let empty = |child: usize| {
            let boxed = |rows: &[[f32; 8]; 3], bound: f32| rows.iter().all(|row| row[child] == bound);
            boxed(&self.lower, f32::INFINITY)
                && boxed(&self.upper, f32::NEG_INFINITY)
                && self.count[child] == 0
        };
        ((0..used).all(finite) && (used..8).all(empty)).then_some(used)
    }

    /// Whether the box of `child` encloses another.
    fn encloses(&self, child: usize, lower: [f32; 3], upper: [f32; 3]) -> bool {
        (0..3).all(|k| self.lower[k][child] <= lower[k] && upper[k] <= self.upper[k][child])
    }

    /// Whether the box of `child` encloses all of a node's boxes.
    fn encloses_node(&self, child: usize, node: &Node8) -> bool {
        let corner = |rows: &[[f32; 8]; 3], i: usize| rows.map(|row| row[i]);
        (0..8)
            .filter(|&i| node.is_used(i))
            .all(|i| self.encloses(child, corner(&node.lower, i), corner(&node.upper, i)))
    }
}

/// Up to eight triangles in structure-of-arrays form, so that one ray meets all of them at once.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf8 {
    /// Coordinates by corner, axis and triangle; NaN, which nothing hits, where there is no triangle.
    pub(crate) corners: [[[f32; 8]; 3]; 3],
    /// Index of the first triangle in [`SceneData::triangles`]; the others follow.
    pub(crate) first: u32,
}

impl Leaf8 {
    /// The leaf of `triangles`, of which the first has this index in the scene; those beyond eight are left out.
    pub fn new(first: u32, triangles: &[Triangle]) -> Self {
        let mut leaf = Leaf8 { corners: [[[f32::NAN; 8]; 3]; 3], first };
        for (lane, triangle) in triangles.iter().enumerate().take(8) {
            for (rows, corner) in leaf.corners.iter_mut().zip(triangle.corners) {
                for (row, coordinate) in rows.iter_mut().zip(corner) {
                    row[lane] = coordinate;
                }
            }
        }
        leaf
    }

    /// Whether it holds `triangles`, all of a leaf's, bit by bit, and nothing else that could be hit.
    fn holds(&self, triangles: &[Triangle]) -> bool {
        let corner = |lane: usize, k: usize| self.corners[k].map(|row| row[lane].to_bits());
        let same = |(lane, triangle): (usize, &Triangle)| {
            (0..3).all(|k| corner(lane, k) == triangle.corners[k].map(f32::to_bits))
        };
        let rows = || self.corners.as_flattened().iter();
        triangles.iter().enumerate().all(same)
            && rows().all(|row| row[triangles.len()..].iter().all(|x| x.is_nan()))
    }
}

/// The slices a scene is made of, unchecked.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneData<'a> {
    /// Hierarchy over `triangles`; node 0 is the root. Empty for an empty scene.
    pub nodes: &'a [Node8],
    /// The hierarchy's leaves.
    pub leaves: &'a [Leaf8],
    /// Triangles, those of a leaf side by side.
    pub triangles: &'a [Triangle],
    /// One for each triangle.
    pub surfaces: &'a [Surface],
    /// Materials.
    pub materials: &'a [Material],
    /// Textures.
    pub textures: &'a [Texture],
    /// Linear RGB texels of all textures.
    pub texels: &'a [[f32; 3]],
    /// Emitting triangles, as [`crate::shade::light::build`] makes them.
    pub lights: &'a [Light],
    /// Tree over the lights, as [`crate::shade::light_tree::build`] makes it; node 0 is the root. Empty: lights are
    /// picked by power alone.
    pub light_nodes: &'a [LightNode8],
}

/// Levels of nodes a hierarchy may have: what the traversal's stack is made for.
pub const MAX_DEPTH: usize = 32;

/// Entries a depth-first walk needs: at each level up to seven siblings wait while one is followed.
pub(crate) const STACK: usize = 7 * MAX_DEPTH + 1;

/// Why lent slices are not a scene.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// `surfaces` and `triangles` differ in length.
    SurfaceCount,
    /// The node of this index has a child that does not exist or comes before it, a leaf with more than eight triangles or
    /// some that do not exist, a box that is neither finite nor empty, or an empty one before another.
    Node(usize),
    /// The node of this index has a box that does not enclose what is below it.
    Bounds(usize),
    /// The leaf of this index has other corners than its triangles, or more of them.
    Leaf(usize),
    /// The hierarchy has more than [`MAX_DEPTH`] levels.
    TooDeep,
    /// The surface of this index names a material that does not exist.
    Surface(usize),
    /// The material of this index has a value out of range or names a texture that does not exist.
    Material(usize),
    /// The texture of this index is empty or reaches beyond the texels.
    Texture(usize),
    /// The light of this index names no triangle, or the probabilities do not rise to one.
    Light(usize),
    /// The light of this index is not where its path through the light tree leads, its group does not hold it, or
    /// its triangle is not above that of the light before.
    LightPath(usize),
    /// The node of this index of the light tree has a child that does not exist or comes before it, or a power that
    /// is not a number from 0 to 1.
    LightNode(usize),
    /// A node or a light has more than one place in the light tree, or none.
    LightTree,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Error::SurfaceCount => write!(f, "there must be one surface for each triangle"),
            Error::Node(i) => {
                write!(f, "node {i} refers to a child or a triangle that is not there, or a box is not a box")
            }
            Error::Bounds(i) => write!(f, "a box of node {i} does not enclose what is below it"),
            Error::Leaf(i) => write!(f, "leaf {i} does not hold the triangles it stands for"),
            Error::TooDeep => write!(f, "the hierarchy has more than {MAX_DEPTH} levels"),
            Error::Surface(i) => write!(f, "surface {i} names a material that is not there"),
            Error::Material(i) => write!(f, "material {i} has a value out of range or no such texture"),
            Error::Texture(i) => write!(f, "texture {i} is empty or reaches beyond the texels"),
            Error::LightPath(i) => write!(f, "the light tree does not lead to light {i} or does not hold it"),
            Error::LightNode(i) => {
                write!(f, "node {i} of the light tree has a bad power or a child that is not there")
            }
            Error::LightTree => write!(f, "every node and every light must have one place in the light tree"),
            Error::Light(i) => write!(f, "light {i} has no triangle or its probability does not rise to one"),
        }
    }
}

impl core::error::Error for Error {}

/// A scene that has been checked: every index leads somewhere, the tree is a tree of bounded depth.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    data: SceneData<'a>,
    inverse_power: f32,
}

impl<'a> Scene<'a> {
    /// Checks `data` and borrows it.
    ///
    /// # Errors
    /// The first thing found wrong: see [`Error`].
    pub fn new(data: SceneData<'a>) -> Result<Self, Error> {
        if data.surfaces.len() != data.triangles.len() {
            return Err(Error::SurfaceCount);
        }
        check_tree(&data)?;
        check_each(data.surfaces, Error::Surface, |s| (s.material as usize) < data.materials.len())?;
        check_each(data.materials, Error::Material, |m| material_is_valid(m, data.textures.len()))?;
        check_each(data.textures, Error::Texture, |t| texture_is_valid(t, data.texels.len()))?;
        check_lights(&data)?;
        light_tree::check(&data)?;
        let power = light::total_power(&data);
        Ok(Scene { data, inverse_power: if power > 0.0 { (1.0 / power) as f32 } else { 0.0 } })
    }

    /// The slices behind the scene.
    #[inline(always)]
    pub fn data(&self) -> &SceneData<'a> {
        &self.data
    }

    /// One over the lights' total power (luminance times area, up to π).
    #[inline(always)]
    pub(crate) fn inverse_power(&self) -> f32 {
        self.inverse_power
    }
}

fn check_each<T>(items: &[T], error: fn(usize) -> Error, valid: impl Fn(&T) -> bool) -> Result<(), Error> {
    items.iter().position(|item| !valid(item)).map_or(Ok(()), |i| Err(error(i)))
}

/// Walks the hierarchy as a ray would that hits everything.
fn check_tree(data: &SceneData) -> Result<(), Error> {
    let mut stack = [(0u32, 0u32); STACK];
    let mut top = usize::from(!data.nodes.is_empty());
    let mut visited = 0;
    while top > 0 {
        top -= 1;
        let (index, depth) = stack[top];
        visited += 1;
        if visited > data.nodes.len() {
            return Err(Error::Node(index as usize));
        }
        if depth as usize >= MAX_DEPTH {
            return Err(Error::TooDeep);
        }
        let node = &data.nodes[index as usize];
        let children = node.children().ok_or(Error::Node(index as usize))?;
        for child in 0..children {
            let (first, count) = (node.child[child] as usize, node.count[child] as usize);
            if count > 0 {
                let triangles = leaf_triangles(data, first, count).ok_or(Error::Node(index as usize))?;
                if !data.leaves[first].holds(triangles) {
                    return Err(Error::Leaf(first));
                }
                let mut corners = triangles.iter().flat_map(|t| t.corners);
                if !corners.all(|c| node.encloses(child, c, c)) {
                    return Err(Error::Bounds(index as usize));
                }
            } else {
                if first <= index as usize || first >= data.nodes.len() {
                    return Err(Error::Node(index as usize));
                }
                if !node.encloses_node(child, &data.nodes[first]) {
                    return Err(Error::Bounds(index as usize));
                }
                stack[top] = (node.child[child], depth + 1);
                top += 1;
            }
        }
    }
    Ok(())
}

/// The triangles of leaf number `leaf`, if it and they exist.
fn leaf_triangles<'a>(data: &SceneData<'a>, leaf: usize, count: usize) -> Option<&'a [Triangle]> {
    let start = data.leaves.get(leaf)?.first as usize;
    if count > 8 { None } else { data.triangles.get(start..start.checked_add(count)?) }
}

fn material_is_valid(m: &Material, textures: usize) -> bool {
    let unit = |c: &[f32; 3]| c.iter().all(|v| (0.0..=1.0).contains(v));
    let emits = m.emission.iter().all(|v| v.is_finite() && *v >= 0.0);
    let texture = m.texture == NO_TEXTURE || (m.texture as usize) < textures;
    let rough = (MIN_ROUGHNESS..=1.0).contains(&m.roughness);
    let ior = m.ior.is_finite() && m.ior > 0.0;
    unit(&m.diffuse) && unit(&m.specular) && emits && texture && rough && ior
}

fn texture_is_valid(t: &Texture, texels: usize) -> bool {
    let size = (t.width as usize).checked_mul(t.height as usize);
    let end = size.and_then(|n| n.checked_add(t.first as usize));
    t.width > 0 && t.height > 0 && end.is_some_and(|end| end <= texels)
}

fn check_lights(data: &SceneData) -> Result<(), Error> {
    let mut before = 0.0;
    for (i, light) in data.lights.iter().enumerate() {
        let there = (light.triangle as usize) < data.triangles.len();
        if !(there && light.cumulative >= before && light.cumulative <= 1.0) {
            return Err(Error::Light(i));
        }
        before = light.cumulative;
    }
    if data.lights.last().is_some_and(|l| l.cumulative != 1.0) {
        return Err(Error::Light(data.lights.len() - 1));
    }
    Ok(())
}
