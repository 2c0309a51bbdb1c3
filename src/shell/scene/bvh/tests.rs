use super::*;
use pmcip_core::tracer::scene::{Material, Motion, Scene, SceneData, Surface};

/// What is made of parts is a hierarchy as any other: every triangle has one place, and boxes hold what is below them.
#[test]
fn parts_become_one_hierarchy() {
    let place = |i: usize| [i * 37 % 101, i * 53 % 89, i * 71 % 97].map(|x| x as f32 * 0.1);
    let triangle = |i: usize, shift: f32| Triangle {
        corners: [0, 1, 2].map(|k| {
            let mut corner = place(i);
            corner[k] += 0.2 + shift;
            corner
        }),
    };
    let open: Vec<_> = (0..3000).map(|i| triangle(i, 0.0)).collect();
    let moved: Vec<_> = (0..3000).map(|i| triangle(i, (i % 3) as f32)).collect();
    for closing in [&[][..], &moved] {
        let triangles = Triangles { open: &open, closing };
        let parts = parts::divide(&|i| triangles.bounds(i), (0..3000).collect(), 8);
        let bvh = join(triangles, parts, 1e-4);
        let mut order = bvh.order.clone();
        order.sort_unstable();
        assert_eq!(order, (0..3000).collect::<Vec<_>>());
        let ordered = |all: &[Triangle]| -> Vec<_> {
            bvh.order.iter().filter_map(|&i| all.get(i as usize)).copied().collect()
        };
        let (triangles, closing) = (ordered(&open), ordered(closing));
        let normals = vec![[[0.0; 3]; 3]; closing.len()];
        let moved_leaves = leaves(&bvh.nodes, &closing);
        let motion = Motion { triangles: &closing, leaves: &moved_leaves, normals: &normals };
        let data = SceneData {
            nodes: &bvh.nodes,
            leaves: &leaves(&bvh.nodes, &triangles),
            triangles: &triangles,
            surfaces: &vec![Surface::default(); 3000],
            materials: &[Material::default()],
            motion: (!closing.is_empty()).then_some(motion),
            ..SceneData::default()
        };
        Scene::new(data).unwrap();
    }
}
