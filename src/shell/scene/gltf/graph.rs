//! The nodes of a glTF scene, as a rig.

use crate::scene::rig::{Joint, Moves, Rig};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::scene::Transform;
use gltf::{Document, Node};

/// How deep nodes may be nested.
const MOST_LEVELS: usize = 1024;

/// Nodes of the scene that is shown, each after the one that carries it.
pub(super) struct Graph {
    /// Their indices in the file, in the order of the tree.
    pub shown: Vec<usize>,
    /// All nodes of the file.
    pub rig: Rig,
}

/// The nodes of the default scene, of the first if none is, of all where there are no scenes.
///
/// # Errors
/// If a node is reached in two ways, or nodes are nested too deep.
pub(super) fn read(document: &Document, fps: f64) -> Result<Graph, String> {
    let nodes: Vec<Node<'_>> = document.nodes().collect();
    let joints = nodes.iter().map(joint).collect();
    let mut graph = Graph { shown: Vec::new(), rig: Rig { joints, fps } };
    let mut reached = vec![false; nodes.len()];
    let mut open: Vec<(usize, usize)> =
        roots(document, &nodes).into_iter().rev().map(|node| (node, 1)).collect();
    while let Some((node, level)) = open.pop() {
        if std::mem::replace(&mut reached[node], true) {
            return Err(format!("node {node} is reached in two ways: nodes must be trees"));
        }
        if level > MOST_LEVELS {
            return Err(format!("nodes are nested more than {MOST_LEVELS} deep"));
        }
        graph.shown.push(node);
        let children: Vec<usize> = nodes[node].children().map(|child| child.index()).collect();
        for child in children.into_iter().rev() {
            graph.rig.joints[child].parent = Some(node);
            open.push((child, level + 1));
        }
    }
    Ok(graph)
}

fn roots(document: &Document, nodes: &[Node<'_>]) -> Vec<usize> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().map(|node| node.index()).collect();
    }
    let mut carried = vec![false; nodes.len()];
    nodes.iter().flat_map(Node::children).for_each(|child| carried[child.index()] = true);
    (0..nodes.len()).filter(|node| !carried[*node]).collect()
}

fn joint(node: &Node<'_>) -> Joint {
    let (rest, scale, rotation, translation) = match node.transform() {
        Transform::Matrix { matrix } => {
            let columns = matrix.map(|column| column.map(f64::from));
            let rest = DAffine3::from_mat4(DMat4::from_cols_array_2d(&columns));
            let (scale, rotation, translation) = rest.to_scale_rotation_translation();
            (rest, scale, rotation, translation)
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let length = rotation.length();
            let rotation = if length.is_normal() { rotation * length.recip() } else { DQuat::IDENTITY };
            let (scale, translation) = (vector(scale), vector(translation));
            let rest = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
            (rest, scale, rotation, translation)
        }
    };
    Joint { parent: None, rest, translation, rotation, scale, moves: Moves::default() }
}
