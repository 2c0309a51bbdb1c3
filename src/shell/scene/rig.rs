//! Nodes that carry one another, over time.

use super::channel::Channel;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A node: its place in that of its parent.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    /// Index of the node that carries it.
    pub parent: Option<usize>,
    /// Its place where nothing moves it.
    pub rest: DAffine3,
    /// Its place in parts, for what moves only some of them.
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
    pub moves: Moves,
}

/// What moves a node.
#[derive(Clone, Debug, Default)]
pub(super) struct Moves {
    pub translation: Option<Channel<3>>,
    pub rotation: Option<Channel<4>>,
    pub scale: Option<Channel<3>>,
}

impl Moves {
    /// Times of the first key and the last, in seconds.
    pub fn span(&self) -> Option<(f64, f64)> {
        let spans = [
            self.translation.as_ref().map(Channel::span),
            self.rotation.as_ref().map(Channel::span),
            self.scale.as_ref().map(Channel::span),
        ];
        spans.into_iter().flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// Nodes, of which none carries itself by way of others.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    pub joints: Vec<Joint>,
    /// Frames a second; frame 0 is at time 0.
    pub fps: f64,
}

impl Rig {
    /// Where a node is in a frame.
    pub fn at(&self, node: usize, frame: f64) -> DAffine3 {
        let time = frame / self.fps;
        let above = std::iter::successors(self.joints[node].parent, |&parent| self.joints[parent].parent);
        above.fold(self.joints[node].at(time), |place, parent| self.joints[parent].at(time) * place)
    }

    /// Where a node is in a frame and how it is turned, without its scale.
    pub fn rigid(&self, node: usize, frame: f64) -> DAffine3 {
        let place = self.at(node, frame);
        let back = place.matrix3.z_axis.normalize_or(DVec3::Z);
        let across = place.matrix3.y_axis.cross(back).try_normalize();
        let across = across.unwrap_or_else(|| back.any_orthonormal_vector());
        let turn = DMat3::from_cols(across, back.cross(across), back);
        DAffine3::from_mat3_translation(turn, place.translation)
    }

    /// Whether anything moves a node.
    pub fn moves(&self, node: usize) -> bool {
        let chain = std::iter::successors(Some(node), |&node| self.joints[node].parent);
        chain.into_iter().any(|node| self.joints[node].moves.span().is_some())
    }
}

impl Joint {
    fn at(&self, time: f64) -> DAffine3 {
        let moves = &self.moves;
        if moves.span().is_none() {
            return self.rest;
        }
        let point = |channel: &Channel<3>| DVec3::from_array(channel.at(time));
        let scale = moves.scale.as_ref().map_or(self.scale, point);
        let rotation = moves.rotation.as_ref().and_then(|turn| turn.turn(time)).unwrap_or(self.rotation);
        let translation = moves.translation.as_ref().map_or(self.translation, point);
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    }
}
