//! A scene as borrowed slices: what rays hit, what it looks like, what emits.
//!
//! The owner of a scene (the shell, an engine) keeps its arrays in whatever memory it likes and lends them as
//! [`SceneData`]. [`Scene::new`] checks every index and the depth of the tree once; after that the hot path
//! needs no error handling and a fixed stack suffices. Lengths are in scene units, colours linear Rec. 709.

mod hierarchy;
pub mod light;
pub mod light_tree;
mod surface;

pub(crate) use hierarchy::STACK;
pub use hierarchy::{Leaf8, MAX_DEPTH, Node8};
pub use light::Light;
pub use light_tree::{LIGHT_LEAF, LightNode8, MAX_LIGHT_DEPTH};
pub use surface::{MIN_ROUGHNESS, Material, NO_TEXTURE, Scattering, Surface, Texture, Triangle};

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
    /// Emitting triangles, as [`light::build`] makes them.
    pub lights: &'a [Light],
    /// Tree over the lights, as [`light_tree::build`] makes it; node 0 is the root. Empty: lights are
    /// picked by power alone.
    pub light_nodes: &'a [LightNode8],
}

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
        hierarchy::check(&data)?;
        check_each(data.surfaces, Error::Surface, |s| (s.material as usize) < data.materials.len())?;
        check_each(data.materials, Error::Material, |m| m.is_valid(data.textures.len()))?;
        check_each(data.textures, Error::Texture, |t| t.is_valid(data.texels.len()))?;
        light::check(&data)?;
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
