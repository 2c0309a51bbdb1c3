//! Scenes with single numbers changed to anything: refused, or rays go through them, together and alone.

mod view;

use proptest::prelude::*;
use view::{Change, Random, View, probe};

fn change() -> impl Strategy<Value = Change> {
    let bits = prop_oneof![any::<u32>(), 0..2048u32, any::<f32>().prop_map(f32::to_bits)];
    let parts = (any::<u8>(), any::<u16>(), any::<u8>(), bits);
    parts.prop_map(|(target, at, field, bits)| Change { target, at, field, bits })
}

#[test]
fn a_sound_scene_is_accepted_and_rays_agree() {
    for seed in 0..20 {
        probe(View::new(seed).scene().expect("sound"), &mut Random(seed));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn any_change_is_refused_or_does_no_harm(seed: u32, changes in prop::collection::vec(change(), 1..4)) {
        let mut view = View::new(seed % 8);
        changes.into_iter().for_each(|change| view.change(change));
        if let Some(scene) = view.scene() {
            probe(scene, &mut Random(seed));
        }
    }
}
