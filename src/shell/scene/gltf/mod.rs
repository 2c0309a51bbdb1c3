//! Scenes and meshes from glTF 2.0 files, `.gltf` and `.glb`.
//!
//! * `container` – bytes to JSON and binary data, versions and extensions; `uri` – what files may be named; `data` – numbers;
//! * `graph` – nodes; `motion` – what moves them; `camera`, `light` – what is at them;
//! * `mesh` – triangles; `material`, `texture` – what they look like.
//!
//! A file as a scene of its own is its default scene: a unit is a metre, radiance 1 is 1 cd/m², a camera's and a light's
//! place that of its node. Frames are counted from time 0 at 24 a second. As a mesh of a scene file it is what stands in it
//! where nothing has moved it, as one object; what it emits is then radiance in the scene file's unit.
//!
//! A file whose structure does not hold (an index that leads nowhere, data that are not there, nodes in a circle, files
//! outside its folder) is refused. What is there and cannot be honoured is named, one line a kind.

mod camera;
mod container;
mod data;
mod graph;
mod light;
mod material;
mod mesh;
mod motion;
mod texture;
mod uri;

use super::animation::Animation;
use super::assemble::{Assembly, Shot};
use super::error::Error;
use super::notes::Notes;
use super::options::Options;
use super::room::Room;
use super::script::{ObjectTrack, Script};
use container::Container;
use data::Data;
use glam::DAffine3;
use graph::Graph;
use light::Lights;
use material::Look;
use mesh::{Part, Site};
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use texture::Pictures;

/// A file in parts.
struct File<'a> {
    path: &'a Path,
    container: Container,
    data: Data,
    graph: Graph,
    notes: Notes,
}

impl<'a> File<'a> {
    fn open(path: &'a Path, room: &Room) -> Result<File<'a>, Error> {
        let mut container = container::open(path)?;
        let data = Data::read(path, &container.document, container.binary.take(), room)?;
        let graph = graph::read(&container.document, motion::FPS).map_err(|m| Error::in_file(path, m))?;
        let mut file = File { path, container, data, graph, notes: Notes::default() };
        file.name_unknown();
        Ok(file)
    }

    /// Names what nothing is known of.
    fn name_unknown(&mut self) {
        let unknown = &self.container.unknown;
        if !unknown.is_empty() {
            self.notes
                .add("extensions", || format!("extensions without effect here: {}", unknown.join(", ")));
        }
        if self.container.odd_channels > 0 {
            self.notes.add("channels", || "animations of anything but nodes are left out".into());
        }
        let nodes = &self.container.document.as_json().nodes;
        if self.graph.shown.iter().any(|node| nodes[*node].skin.is_some()) {
            self.notes.add("skins", || {
                "skins are left out: meshes have their own shape, and stand where their nodes do".into()
            });
        }
    }

    /// The meshes of all nodes shown, for which there is room.
    fn meshes(&mut self, assembly: &mut Assembly) -> Result<Vec<Standing>, Error> {
        let nodes: Vec<_> = self.container.document.nodes().collect();
        let mut read: HashMap<usize, Rc<Vec<Option<Part>>>> = HashMap::new();
        let mut standing = Vec::new();
        for &node in &self.graph.shown {
            let Some(mesh) = nodes[node].mesh() else { continue };
            let parts = match read.get(&mesh.index()) {
                Some(parts) => Rc::clone(parts),
                None => {
                    let parts = mesh::parts(&mesh, &self.data, &mut self.notes);
                    let parts = Rc::new(parts.map_err(|m| Error::in_file(self.path, m))?);
                    read.insert(mesh.index(), Rc::clone(&parts));
                    parts
                }
            };
            standing.push(Standing { node, mesh: mesh.index(), parts });
        }
        let count = |standing: &Standing| standing.parts.iter().flatten().map(Part::len).sum::<usize>();
        match standing.iter().map(count).fold(0, usize::saturating_add) {
            0 => Err(Error::in_file(self.path, "no triangles")),
            count => assembly.ask_for(count).map_err(|m| Error::in_file(self.path, m)).map(|()| standing),
        }
    }

    /// Adds meshes to an assembly. `begin` may start an object for each, and says where its corners go.
    fn add(
        &mut self,
        standing: &[Standing],
        material: Option<u32>,
        assembly: &mut Assembly,
        mut begin: impl FnMut(&mut Assembly, &Standing) -> Site,
    ) {
        let document = &self.container.document;
        let mut pictures = Pictures::new(self.path, document, &self.data);
        let mut looks: HashMap<(Option<usize>, bool), Look> = HashMap::new();
        let meshes: Vec<_> = document.meshes().collect();
        for each in standing {
            let site = begin(assembly, each);
            for (primitive, part) in meshes[each.mesh].primitives().zip(each.parts.iter()) {
                let Some(part) = part else { continue };
                let stated = primitive.material();
                let closed = stated.transmission().is_some() && part.is_closed();
                let look = match material {
                    Some(material) => Look::plain(material),
                    None => *looks.entry((stated.index(), closed)).or_insert_with(|| {
                        material::convert(&stated, closed, &mut pictures, &mut self.notes, assembly)
                    }),
                };
                part.note_missing(&look, &mut self.notes);
                part.add_to(assembly, &look, &site);
            }
        }
    }
}

/// A mesh at a node.
struct Standing {
    node: usize,
    mesh: usize,
    parts: Rc<Vec<Option<Part>>>,
}

/// A glTF file as a scene of its own.
///
/// # Errors
/// If it cannot be read or understood, or holds no triangle.
pub(super) fn scene(path: &Path, options: &Options) -> Result<Animation, Error> {
    let mut assembly = Assembly::new(options);
    let mut file = File::open(path, &assembly.room)?;
    let document = &file.container.document;
    let frames = motion::animate(document, &file.data, &mut file.graph.rig, &mut file.notes);
    let frames = frames.map_err(|m| Error::in_file(path, m))?;
    let rig = Arc::new(file.graph.rig.clone());
    let standing = file.meshes(&mut assembly)?;
    let mut paths = Vec::new();
    file.add(&standing, None, &mut assembly, |assembly, each| {
        let home = mesh::home_of(&[(&each.parts, DAffine3::IDENTITY)]);
        assembly.begin(path, home);
        paths.push(ObjectTrack::Node { rig: Arc::clone(&rig), node: each.node });
        Site::new(DAffine3::IDENTITY, home)
    });
    let rigid = |node| ObjectTrack::Rigid { rig: Arc::clone(&rig), node };
    let (document, shown) = (&file.container.document, &file.graph.shown);
    let lights = Lights::read(document, shown, rigid, &mut file.notes);
    lights.add_lamps(path, &mut assembly, &mut paths, rigid).map_err(|m| Error::in_file(path, m))?;
    lights.name(&mut file.notes);
    let (camera, shot) = camera::read(document, shown, &rig, &mut file.notes);
    let moving = paths.iter().any(|path| match path {
        ObjectTrack::Node { rig, node } | ObjectTrack::Rigid { rig, node } => rig.moves(*node),
        _ => false,
    });
    let script = Script { frames, camera, paths, moving, ..Script::default() };
    file.notes.warn(path, "times", &mut assembly);
    assembly.finish(path, Shot { sky: lights.sky(), ..shot }, options, script)
}

/// Adds what stands in a glTF file as an object, all of one `material` if it is given.
///
/// # Errors
/// If it cannot be read or understood, or holds no triangle.
pub(super) fn add_mesh(assembly: &mut Assembly, path: &Path, material: Option<u32>) -> Result<(), Error> {
    let mut file = File::open(path, &assembly.room)?;
    let standing = file.meshes(assembly)?;
    let places: Vec<_> =
        standing.iter().map(|each| (&*each.parts, file.graph.rig.at(each.node, 0.0))).collect();
    let home = mesh::home_of(&places);
    assembly.begin(path, home);
    let rig = file.graph.rig.clone();
    file.add(&standing, material, assembly, |_, each| Site::new(rig.at(each.node, 0.0), home));
    let json = file.container.document.as_json();
    let lit = file.container.document.lights().is_some_and(|lights| lights.len() > 0);
    if lit || !(json.cameras.is_empty() && json.animations.is_empty()) {
        file.notes
            .add("mesh", || "as a mesh of a scene file it is without cameras, lights and animations".into());
    }
    file.notes.warn(path, "times", assembly);
    Ok(())
}
