//! What a scene is made of, unchecked, and what can be wrong with it.

use super::hierarchy::{MAX_DEPTH, Node8};
use super::light::Light;
use super::light_tree::LightNode8;
use super::motion::Motion;
use super::sky::Sky;
use super::surface::{Material, Surface, Texture, Triangle};

/// The slices a scene is made of, unchecked.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneData<'a> {
    /// Hierarchy over `triangles`; node 0 is the root. Empty for an empty scene.
    pub nodes: &'a [Node8],
    /// The triangles' coordinates leaf by leaf, as [`fill_leaves`](super::fill_leaves) arranges them.
    pub leaves: &'a [f32],
    /// Triangles, those of a leaf side by side.
    pub triangles: &'a [Triangle],
    /// One for each triangle.
    pub surfaces: &'a [Surface],
    /// Linear colours of the corners of each triangle, 0 to 1, by which the diffuse reflectance is multiplied. Empty: white.
    pub colours: &'a [[[f32; 3]; 3]],
    /// Materials.
    pub materials: &'a [Material],
    /// The normal map of each material: the texture of unit vectors x along the texture's u, y along its v and z along the
    /// shading normal, or [`NO_TEXTURE`](super::NO_TEXTURE); need not be of unit length. Of [`Rough`](super::Scattering::Rough)
    /// materials alone. Empty: no material has any.
    pub normal_maps: &'a [u32],
    /// Textures.
    pub textures: &'a [Texture],
    /// Linear RGB texels of all textures.
    pub texels: &'a [[f32; 3]],
    /// Emitting triangles, as [`light::build`](super::light::build) makes them: anew whenever triangles or emissions change.
    pub lights: &'a [Light],
    /// Tree over the lights, as [`light_tree::build`](super::light_tree::build) makes it; node 0 is the root. Empty: lights are
    /// picked by power alone.
    pub light_nodes: &'a [LightNode8],
    /// Light from outside, if there is any.
    pub sky: Option<Sky<'a>>,
    /// Where triangles are as the shutter closes, if any moves while it is open.
    pub motion: Option<Motion<'a>>,
}

impl SceneData<'_> {
    /// Triangle number `index` at `time`, a part of the time in which the shutter is open.
    pub(crate) fn triangle_at(&self, index: u32, time: f32) -> Triangle {
        let open = self.triangles[index as usize];
        let Some(motion) = &self.motion else { return open };
        let closing = motion.triangles[index as usize].corners;
        let at = |corner: usize, axis: usize| {
            let from = open.corners[corner][axis];
            from + (closing[corner][axis] - from) * time
        };
        Triangle { corners: [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| at(corner, axis))) }
    }
}

/// Why lent slices are not a scene.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// `surfaces` and `triangles` differ in length.
    SurfaceCount,
    /// `colours` is neither empty nor as long as `triangles`, or this triangle's are not from 0 to 1.
    Colours(usize),
    /// The node of this index has a child that does not exist or comes before it, a leaf with more than eight triangles or
    /// some that do not exist, a box that is neither finite nor empty, or an empty one before another.
    Node(usize),
    /// The node of this index has a box that does not enclose what is below it.
    Bounds(usize),
    /// The leaf whose first triangle has this index has other corners in `leaves` than its triangles, or these are too short.
    Leaf(usize),
    /// The hierarchy has more than [`MAX_DEPTH`] levels.
    TooDeep,
    /// The surface of this index names a material that does not exist.
    Surface(usize),
    /// The material of this index has a value out of range or names a texture that does not exist.
    Material(usize),
    /// `normal_maps` is neither empty nor as long as `materials`, or this material's is a texture that does not exist.
    NormalMap(usize),
    /// The texture of this index is empty or reaches beyond the texels.
    Texture(usize),
    /// The light of this index names no triangle or is not the lamp that its triangle is, or the probabilities do not rise
    /// to one.
    Light(usize),
    /// The light of this index is not where its path through the light tree leads, its group does not hold it, or
    /// its triangle is not above that of the light before.
    LightPath(usize),
    /// The node of this index of the light tree has a child that does not exist or comes before it, or a power that
    /// is not a number from 0 to 1.
    LightNode(usize),
    /// A node or a light has more than one place in the light tree, or none.
    LightTree,
    /// A slice of the motion has not one entry for each of the scene's, or a normal is not finite.
    Motion,
    /// A slice of the sky has the wrong length or a table does not rise to [`STEPS`](super::sky::STEPS), or a number of it
    /// is out of range.
    Sky,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Error::SurfaceCount => write!(f, "there must be one surface for each triangle"),
            Error::Colours(i) => write!(f, "the colours of triangle {i} are missing or not from 0 to 1"),
            Error::Node(i) => {
                write!(f, "node {i} refers to a child or a triangle that is not there, or a box is not a box")
            }
            Error::Bounds(i) => write!(f, "a box of node {i} does not enclose what is below it"),
            Error::Leaf(i) => write!(f, "the leaf of triangle {i} does not hold the triangles it stands for"),
            Error::TooDeep => write!(f, "the hierarchy has more than {MAX_DEPTH} levels"),
            Error::Surface(i) => write!(f, "surface {i} names a material that is not there"),
            Error::Material(i) => write!(f, "material {i} has a value out of range or no such texture"),
            Error::NormalMap(i) => write!(f, "the normal map of material {i} is missing or no such texture"),
            Error::Texture(i) => write!(f, "texture {i} is empty or reaches beyond the texels"),
            Error::LightPath(i) => write!(f, "the light tree does not lead to light {i} or does not hold it"),
            Error::LightNode(i) => {
                write!(f, "node {i} of the light tree has a bad power or a child that is not there")
            }
            Error::LightTree => write!(f, "every node and every light must have one place in the light tree"),
            Error::Motion => write!(
                f,
                "the motion must have finite triangles, leaves and normals, one for each of the scene's"
            ),
            Error::Sky => write!(f, "the sky has a table or a number that is out of range"),
            Error::Light(i) => {
                write!(f, "light {i} is not what its triangle is, or its probability does not rise to one")
            }
        }
    }
}

impl core::error::Error for Error {}
