//! Whether lent slices are a scene: all that the hot path relies on, looked at once.

use super::data::{Error, SceneData};
use super::hierarchy::{LEAF, MAX_DEPTH, STACK, by_rows};
use super::light::Lamp;
use super::light_tree::{LIGHT_LEAF, LightNode8, MAX_LIGHT_DEPTH, slot};
use super::motion::normals;
use super::surface::{NO_TEXTURE, Surface, Triangle};
use crate::maths::vec3;

/// The first thing found wrong.
pub(super) fn check(data: &SceneData<'_>) -> Result<(), Error> {
    if data.surfaces.len() != data.triangles.len() {
        return Err(Error::SurfaceCount);
    }
    check_motion(data)?;
    check_hierarchy(data)?;
    check_colours(data)?;
    check_each(data.surfaces, Error::Surface, |s| (s.material as usize) < data.materials.len())?;
    check_each(data.materials, Error::Material, |m| m.is_valid(data.textures.len()))?;
    check_normal_maps(data)?;
    check_each(data.textures, Error::Texture, |t| t.is_valid(data.texels.len()))?;
    check_lights(data)?;
    check_light_tree(data)?;
    if data.sky.is_none_or(|sky| sky.is_valid()) { Ok(()) } else { Err(Error::Sky) }
}

fn check_each<T>(items: &[T], error: fn(usize) -> Error, valid: impl Fn(&T) -> bool) -> Result<(), Error> {
    items.iter().position(|item| !valid(item)).map_or(Ok(()), |i| Err(error(i)))
}

fn check_colours(data: &SceneData<'_>) -> Result<(), Error> {
    if !data.colours.is_empty() && data.colours.len() != data.triangles.len() {
        return Err(Error::Colours(data.colours.len().min(data.triangles.len())));
    }
    check_each(data.colours, Error::Colours, |c| c.as_flattened().iter().all(|v| (0.0..=1.0).contains(v)))
}

/// Whether there is one of everything; what is in it the hierarchy's check looks at.
fn check_motion(data: &SceneData<'_>) -> Result<(), Error> {
    let Some(motion) = &data.motion else { return Ok(()) };
    let triangles = [motion.triangles.len(), motion.normals.len()];
    let complete = triangles == [data.triangles.len(); 2];
    let finite = |normals: &[[f32; 3]; 3]| normals.as_flattened().iter().all(|v| v.is_finite());
    if complete && motion.normals.iter().all(finite) { Ok(()) } else { Err(Error::Motion) }
}

fn check_normal_maps(data: &SceneData<'_>) -> Result<(), Error> {
    if !data.normal_maps.is_empty() && data.normal_maps.len() != data.materials.len() {
        return Err(Error::NormalMap(data.normal_maps.len().min(data.materials.len())));
    }
    let known = |map: &u32| *map == NO_TEXTURE || (*map as usize) < data.textures.len();
    check_each(data.normal_maps, Error::NormalMap, known)
}

/// Walks the hierarchy as a ray would that hits everything.
fn check_hierarchy(data: &SceneData) -> Result<(), Error> {
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
                let moved = data.motion.map(|motion| (motion.triangles, motion.leaves));
                for (all, leaves) in [Some((data.triangles, data.leaves)), moved].into_iter().flatten() {
                    let triangles = leaf_triangles(all, first, count).ok_or(Error::Node(index as usize))?;
                    if !is_held(leaves, first, triangles) {
                        return Err(Error::Leaf(first));
                    }
                    let mut corners = triangles.iter().flat_map(|t| t.corners);
                    if !corners.all(|c| node.encloses(child, c, c)) {
                        return Err(Error::Bounds(index as usize));
                    }
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

/// Those of `triangles` that belong to a leaf, if they exist.
fn leaf_triangles(triangles: &[Triangle], first: usize, count: usize) -> Option<&[Triangle]> {
    if count > 8 { None } else { triangles.get(first..first.checked_add(count)?) }
}

/// Whether the leaf's rows are those of its triangles, bit by bit, and all that a walk reads is there.
fn is_held(leaves: &[f32], first: usize, triangles: &[Triangle]) -> bool {
    let rows = leaves.get(9 * first..9 * first + LEAF);
    rows.is_some_and(|rows| rows.iter().zip(by_rows(triangles)).all(|(a, b)| a.to_bits() == b.to_bits()))
}

/// Whether every light is the lamp that its triangle is, and the probabilities rise to one.
fn check_lights(data: &SceneData) -> Result<(), Error> {
    let mut before = 0.0;
    for (i, light) in data.lights.iter().enumerate() {
        let triangle = light.triangle as usize;
        let is_lamp = |(triangle, surface): (&Triangle, &Surface)| {
            light.lamp == Lamp::new(triangle, &data.materials[surface.material as usize])
        };
        let there = data.triangles.get(triangle).zip(data.surfaces.get(triangle)).is_some_and(is_lamp);
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

/// Checks that the tree, if there is one, leads to every light, and that every group holds its lights.
pub(crate) fn check_light_tree(data: &SceneData<'_>) -> Result<(), Error> {
    if data.light_nodes.is_empty() {
        return Ok(());
    }
    for (i, node) in data.light_nodes.iter().enumerate() {
        if !node_is_valid(data, i, node) {
            return Err(Error::LightNode(i));
        }
    }
    if !has_one_place_each(data) {
        return Err(Error::LightTree);
    }
    let rises = |i: usize| i == 0 || data.lights[i - 1].triangle < data.lights[i].triangle;
    match (0..data.lights.len()).find(|&i| !(rises(i) && is_reached(data, i))) {
        Some(i) => Err(Error::LightPath(i)),
        None => Ok(()),
    }
}

fn node_is_valid(data: &SceneData<'_>, index: usize, node: &LightNode8) -> bool {
    let used = node.power.iter().take_while(|power| **power > 0.0).count();
    let child_is_valid = |child: u32| match child & LIGHT_LEAF {
        0 => child as usize > index && (child as usize) < data.light_nodes.len(),
        _ => ((child & !LIGHT_LEAF) as usize) < data.lights.len(),
    };
    used > 0
        && node.power[..used].iter().all(|power| *power <= 1.0)
        && node.power[used..].iter().all(|power| *power == 0.0)
        && node.child[..used].iter().all(|&child| child_is_valid(child))
}

/// Whether as many children are lights as there are lights, and as many groups as there are nodes below the root. Together
/// with a path to every light: there is no other way into the tree than to a light by its path.
fn has_one_place_each(data: &SceneData<'_>) -> bool {
    let used = |node: &LightNode8| node.power.iter().filter(|power| **power > 0.0).count();
    let lights =
        |node: &LightNode8| node.child[..used(node)].iter().filter(|child| **child & LIGHT_LEAF != 0).count();
    let all: usize = data.light_nodes.iter().map(used).sum();
    let leaves: usize = data.light_nodes.iter().map(lights).sum();
    leaves == data.lights.len() && all - leaves == data.light_nodes.len() - 1
}

/// Whether the path of light `index` leads to it through groups that hold it.
fn is_reached(data: &SceneData<'_>, index: usize) -> bool {
    let light = &data.lights[index];
    let mut at = 0;
    for level in 0..MAX_LIGHT_DEPTH {
        let (node, slot) = (&data.light_nodes[at], slot(light.path, level));
        if !(node.power[slot] > 0.0 && group_holds(data, node, slot, light.triangle)) {
            return false;
        }
        if node.child[slot] & LIGHT_LEAF != 0 {
            return (node.child[slot] & !LIGHT_LEAF) as usize == index;
        }
        at = node.child[slot] as usize;
    }
    false
}

/// Whether the bounds of a group hold a triangle, up to rounding.
fn group_holds(data: &SceneData<'_>, node: &LightNode8, slot: usize, triangle: u32) -> bool {
    const SLACK: f32 = 1e-4;
    let open = &data.triangles[triangle as usize];
    let closing = data.motion.map_or(open, |motion| &motion.triangles[triangle as usize]);
    let column = |rows: &[[f32; 8]; 3]| [0, 1, 2].map(|axis| rows[axis][slot]);
    let (centre, axis, radius) = (column(&node.centre), column(&node.axis), node.radius[slot]);
    let near = |corner: [f32; 3]| {
        let away = vec3::sub(corner, centre);
        vec3::dot(away, away) <= radius * radius * (1.0 + SLACK)
    };
    let within = |normal: [f32; 3]| vec3::dot(normal, axis) >= node.cosine[slot] - SLACK;
    let normals = normals(open, closing);
    open.corners.into_iter().chain(closing.corners).all(near)
        && normals[0].is_some()
        && normals.into_iter().flatten().all(within)
        && node.cosine[slot] >= -1.0
        && node.cosine[slot] <= 1.0
}
