//! The option `--layers`.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use pmcip::frame::settings::{Layer, Layers};
use pmcip_core::sampler::estimate::Estimator;

/// One word of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    One(Layer),
    All,
    None,
}

impl ValueEnum for Wish {
    fn value_variants<'a>() -> &'a [Wish] {
        use Layer::*;
        const WISHES: [Wish; 12] = [
            Wish::One(Coverage),
            Wish::One(Unbiased),
            Wish::One(Balanced),
            Wish::One(Albedo),
            Wish::One(Normal),
            Wish::One(Depth),
            Wish::One(Motion),
            Wish::One(Variance),
            Wish::One(Count),
            Wish::One(Kernel),
            Wish::All,
            Wish::None,
        ];
        &WISHES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Wish::One(layer) => layer.to_possible_value(),
            Wish::All => Some(PossibleValue::new("all").help("Every layer that this render can have")),
            Wish::None => Some(PossibleValue::new("none").help("The picture alone")),
        }
    }
}

/// The layers that are asked for, of a film that accumulates for `estimator`, and of a frame that `follows` another.
///
/// # Errors
/// If there is no frame before that motion could be measured from.
pub fn chosen(wishes: &[Wish], estimator: Estimator, follows: bool) -> Result<Layers, String> {
    if wishes.contains(&Wish::One(Layer::Motion)) && !follows {
        return Err("--layers motion needs --frames: a single picture has no frame before it".into());
    }
    let possible = |layer: &Layer| layer.is_served_by(estimator) && (follows || *layer != Layer::Motion);
    let layers = wishes.iter().flat_map(|wish| match wish {
        Wish::One(layer) => vec![*layer],
        Wish::All => Layer::value_variants().iter().copied().filter(possible).collect(),
        Wish::None => Vec::new(),
    });
    Ok(layers.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layer_can_be_asked_for_by_its_name() {
        for layer in Layer::value_variants() {
            assert!(Wish::value_variants().contains(&Wish::One(*layer)), "{layer:?}");
            assert_eq!(Wish::from_str(layer.name(), false), Ok(Wish::One(*layer)));
        }
    }
}
