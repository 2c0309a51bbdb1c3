//! The camera of a glTF scene.

use crate::scene::assemble::{DEFAULT_FOV, Shot};
use crate::scene::model::MAX_SIZE;
use crate::scene::notes::Notes;
use crate::scene::rig::Rig;
use crate::scene::script::CameraPath;
use gltf::Document;
use std::sync::Arc;

/// How far a camera looks of which only the direction is known, in scene units.
const DISTANCE: f64 = 1.0;

/// The first perspective camera among these nodes, and what it says of the picture; the default view if there is none.
pub(super) fn read(
    document: &Document,
    shown: &[usize],
    rig: &Arc<Rig>,
    notes: &mut Notes,
) -> (Option<CameraPath>, Shot) {
    // An emission of 1 is 1 cd/m².
    let mut shot = Shot { cd_per_unit: 1.0, ..Shot::default() };
    let json = document.as_json();
    let cameras = shown.iter().filter_map(|&node| Some((node, json.nodes[node].camera?.value())));
    let cameras: Vec<(usize, usize)> = cameras.collect();
    let perspective = cameras.iter().find_map(|&(node, camera)| {
        json.cameras[camera].perspective.as_ref().map(|perspective| (node, camera, perspective))
    });
    let Some((node, camera, perspective)) = perspective else {
        if !cameras.is_empty() {
            notes.add("orthographic", || {
                "orthographic cameras are not supported: the view is framed on the scene".into()
            });
        }
        return (None, shot);
    };
    if cameras.len() > 1 {
        let number = camera.to_string();
        let name = json.cameras[camera].name.as_ref().map(|name| format!("\"{}\"", name.escape_debug()));
        let name = name.unwrap_or(number);
        notes.add("cameras", || format!("of {} cameras the first is taken: {name}", cameras.len()));
    }
    if let Some(aspect) = perspective.aspect_ratio.filter(|aspect| *aspect > 0.0 && aspect.is_finite()) {
        let most = (MAX_SIZE / shot.height) as f32;
        shot.width = (shot.height as f32 * aspect.clamp(most.recip(), most)).round().max(1.0) as u32;
    }
    let mut fov = perspective.yfov.to_degrees();
    if !(fov > 0.0 && fov < 180.0) {
        notes.add("yfov", || {
            format!("camera {camera}: yfov is not between 0 and π: taken for {DEFAULT_FOV}°")
        });
        fov = DEFAULT_FOV;
    }
    (Some(CameraPath::Node { rig: Arc::clone(rig), node, fov, distance: DISTANCE }), shot)
}
