//! Picking one of many lights by what it may contribute: a tree of groups with bounded position and direction.
//!
//! After Conty Estevez and Kulla, *Importance sampling of many lights with adaptive tree splitting*, Proc. ACM
//! Comput. Graph. Interact. Tech. 1(2), 2018, with the bounds of the cosine at the surface from Pharr, Jakob and
//! Humphreys, *Physically Based Rendering*, 4th ed., section 12.6.3; without splitting, and eight children wide, so
//! that a step weighs all children at once. A light's probability is the product of its groups' shares on the way
//! down. A group's weight is its power over the squared distance of its centre, times upper bounds of the cosines at
//! the lights and at the surface: it vanishes only for groups that cannot shine on the surface, and where all of a
//! node's groups vanish power decides, so that the probabilities always sum to one.

use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::light_tree::slot;
use crate::tracer::scene::{LIGHT_LEAF, LightNode8, MAX_LIGHT_DEPTH};
use wide::{f32x8, u32x8};

#[cfg(test)]
mod tests;

/// Added to the bounds of cosines: far more than their rounding, so that no light is lost to it.
const MARGIN: f32 = 1e-3;
/// Least squared distance, against overflow.
const NEAREST: f32 = 1e-30;

/// Where light is wanted, in eight lanes.
#[derive(Clone, Copy)]
pub struct Receiver {
    /// Positions.
    pub position: Vec3x8,
    /// Unit shading normals on the lit side.
    pub normal: Vec3x8,
}

impl Receiver {
    /// Lane `lane` in all lanes.
    fn broadcast(&self, lane: usize) -> Receiver {
        Receiver { position: self.position.lane(lane), normal: self.normal.lane(lane) }
    }
}

/// Lights picked in eight lanes.
pub(super) struct Picked {
    /// Indices of the lights.
    pub light: [u32; 8],
    /// Probabilities with which they were picked.
    pub probability: f32x8,
    /// The random numbers, stretched, to be used again: in `[0, 1]`.
    pub again: f32x8,
}

/// Eight groups: those of a node, or one in all lanes.
struct Groups {
    centre: Vec3x8,
    radius: f32x8,
    axis: Vec3x8,
    cosine: f32x8,
    power: f32x8,
}

impl Groups {
    #[inline(always)]
    fn of(node: &LightNode8) -> Groups {
        let vector = |rows: &[[f32; 8]; 3]| Vec3x8::new(rows[0].into(), rows[1].into(), rows[2].into());
        Groups {
            centre: vector(&node.centre),
            radius: node.radius.into(),
            axis: vector(&node.axis),
            cosine: node.cosine.into(),
            power: node.power.into(),
        }
    }

    #[inline(always)]
    fn one(node: &LightNode8, child: usize) -> Groups {
        let vector = |rows: &[[f32; 8]; 3]| Vec3x8::splat([0, 1, 2].map(|axis| rows[axis][child]));
        Groups {
            centre: vector(&node.centre),
            radius: f32x8::splat(node.radius[child]),
            axis: vector(&node.axis),
            cosine: f32x8::splat(node.cosine[child]),
            power: f32x8::splat(node.power[child]),
        }
    }

    /// What the groups may contribute at `to`.
    #[inline(always)]
    fn weight(&self, to: &Receiver) -> f32x8 {
        let (zero, one) = (f32x8::ZERO, f32x8::ONE);
        let sine = |cosine: f32x8| (one - cosine * cosine).fast_max(zero).sqrt();
        let away = to.position - self.centre;
        let (square, limit) = (away.dot(away), self.radius * self.radius);
        let inverse = one / square.fast_max(f32x8::splat(NEAREST)).sqrt();
        // Half the angle under which the sphere is seen.
        let sin_sphere = (self.radius * inverse).fast_min(one);
        let cos_sphere = sine(sin_sphere);
        // From the cone's axis to the receiver, less the cone, less the sphere.
        let cos_axis = self.axis.dot(away) * inverse;
        let (sin_axis, sin_cone) = (sine(cos_axis), sine(self.cosine));
        let in_cone = cos_axis.simd_ge(self.cosine);
        let cos_light = in_cone.select(one, cos_axis * self.cosine + sin_axis * sin_cone);
        let sin_light = in_cone.select(zero, sin_axis * self.cosine - cos_axis * sin_cone);
        let lit = lessened(cos_light, sin_light, cos_sphere, sin_sphere);
        let cos_surface = -to.normal.dot(away) * inverse;
        let seen = lessened(cos_surface, sine(cos_surface), cos_sphere, sin_sphere);
        let margin = f32x8::splat(MARGIN);
        let cosines = (lit + margin).fast_max(zero) * (seen + margin).fast_max(zero);
        let bounded = square.simd_gt(limit).select(cosines, one);
        self.power * bounded / square.fast_max(limit).fast_max(f32x8::splat(NEAREST))
    }
}

/// Cosine of an angle less another one, of 0 where that is larger.
#[inline(always)]
fn lessened(cosine: f32x8, sine: f32x8, cos_less: f32x8, sin_less: f32x8) -> f32x8 {
    cosine.simd_ge(cos_less).select(f32x8::ONE, cosine * cos_less + sine * sin_less)
}

/// The root's weights for eight receivers: what all picks from the same points share.
pub(super) struct Root<'a> {
    nodes: &'a [LightNode8],
    receiver: Receiver,
    weights: [f32x8; 8],
    children: usize,
    total: f32x8,
}

impl<'a> Root<'a> {
    /// Weighs the root's groups. There must be a node.
    #[inline(always)]
    pub fn new(nodes: &'a [LightNode8], receiver: Receiver) -> Self {
        let node = &nodes[0];
        let children = node.power.iter().take_while(|power| **power > 0.0).count();
        let mut weights = [f32x8::ZERO; 8];
        let mut total = f32x8::ZERO;
        for (child, weight) in weights[..children].iter_mut().enumerate() {
            *weight = Groups::one(node, child).weight(&receiver);
            total += *weight;
        }
        let some = total.simd_gt(f32x8::ZERO);
        if !some.all() {
            total = f32x8::ZERO;
            for (weight, power) in weights[..children].iter_mut().zip(node.power) {
                *weight = some.select(*weight, f32x8::splat(power));
                total += *weight;
            }
        }
        Root { nodes, receiver, weights, children, total }
    }

    /// Picks lights by uniform numbers in `[0, 1)`.
    #[inline(always)]
    pub fn pick(&self, u: f32x8) -> Picked {
        let target = u * self.total;
        let (mut start, mut before, mut share) = (f32x8::ZERO, f32x8::ZERO, f32x8::ONE);
        let mut slot = u32x8::ZERO;
        for (child, weight) in self.weights[..self.children].iter().enumerate() {
            // The last group that begins at or before the target.
            let take = weight.simd_gt(f32x8::ZERO) & target.simd_ge(start);
            before = take.select(start, before);
            share = take.select(*weight, share);
            slot = bytemuck::cast::<_, u32x8>(take).select(u32x8::splat(child as u32), slot);
            start += *weight;
        }
        let again = ((target - before) / share).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
        let probability = share / self.total;
        let child = slot.to_array().map(|slot| self.nodes[0].child[slot as usize & 7]);
        self.descend(child, again, probability)
    }

    /// Goes on from the root's children to single lights.
    #[inline(always)]
    fn descend(&self, mut child: [u32; 8], again: f32x8, probability: f32x8) -> Picked {
        if child.iter().all(|child| child & LIGHT_LEAF != 0) {
            return Picked { light: child.map(|child| child & !LIGHT_LEAF), probability, again };
        }
        let (mut again, mut probability) = (again.to_array(), probability.to_array());
        for lane in 0..8 {
            let receiver = self.receiver.broadcast(lane);
            while child[lane] & LIGHT_LEAF == 0 {
                let node = &self.nodes[child[lane] as usize];
                let shares = Shares::of(node, &receiver);
                let slot = shares.pick(&mut again[lane]);
                probability[lane] *= shares.probability(slot);
                child[lane] = node.child[slot];
            }
        }
        Picked {
            light: child.map(|child| child & !LIGHT_LEAF),
            probability: probability.into(),
            again: again.into(),
        }
    }
}

/// Weights of one node's groups for one receiver.
struct Shares {
    weights: [f32; 8],
    total: f32,
}

impl Shares {
    #[inline(always)]
    fn of(node: &LightNode8, receiver: &Receiver) -> Shares {
        let weights = Groups::of(node).weight(receiver).to_array();
        let total = weights.iter().sum();
        if total > 0.0 {
            return Shares { weights, total };
        }
        Shares { weights: node.power, total: node.power.iter().sum() }
    }

    fn probability(&self, slot: usize) -> f32 {
        self.weights[slot] / self.total
    }

    /// The group on whose share `u` falls; `u` is stretched over it.
    #[inline(always)]
    fn pick(&self, u: &mut f32) -> usize {
        let target = *u * self.total;
        let (mut slot, mut start, mut before) = (0, 0.0, 0.0);
        for (child, weight) in self.weights.into_iter().enumerate() {
            let take = weight > 0.0 && target >= start;
            (slot, before) = if take { (child, start) } else { (slot, before) };
            start += weight;
        }
        *u = ((target - before) / self.weights[slot]).clamp(0.0, 1.0);
        slot
    }
}

/// Probability that a light with this path is picked from lane `lane` of `receiver`.
pub(super) fn probability(nodes: &[LightNode8], path: u32, receiver: &Receiver, lane: usize) -> f32 {
    let receiver = receiver.broadcast(lane);
    let (mut index, mut probability) = (0, 1.0);
    for level in 0..MAX_LIGHT_DEPTH {
        let slot = slot(path, level);
        let node = &nodes[index];
        probability *= Shares::of(node, &receiver).probability(slot);
        if node.child[slot] & LIGHT_LEAF != 0 {
            break;
        }
        index = node.child[slot] as usize;
    }
    probability
}
