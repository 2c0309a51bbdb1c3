//! Methods by name: a sampler, and what is changed about it.

use crate::frame::settings::{Estimate, Method, Settings, Startup};
use crate::scene::LoadedScene;
use clap::ValueEnum;
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// A sampler with its defaults, or with another estimator, γ or start of frames that follow others.
///
/// ```
/// use pmcip::compare::Variant;
///
/// let variant: Variant = "pmc:gamma=0.5+pooled".parse()?;
/// assert_eq!(variant.to_string(), "pmc:gamma=0.5+pooled");
/// assert!("pmc:gamma=9".parse::<Variant>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    method: Method,
    gamma: Option<f32>,
    estimate: Option<Estimate>,
    startup: Option<Startup>,
    history: bool,
}

impl From<Method> for Variant {
    /// The method with its defaults.
    fn from(method: Method) -> Variant {
        Variant { method, gamma: None, estimate: None, startup: None, history: false }
    }
}

impl Variant {
    /// The settings of a render that has size, integrator, depth, camera and seed of `base`.
    pub fn settings(&self, scene: &LoadedScene, base: &Settings, spp: u32) -> Settings {
        let size = (base.sampler.width, base.sampler.height);
        let mut settings = Settings::new(scene, self.method, Some(spp), Some(size));
        (settings.max_depth, settings.view) = (base.max_depth, base.view);
        settings.closing_view = base.closing_view;
        settings.integrator = base.integrator;
        settings.sampler.seed = base.sampler.seed;
        settings.startup = self.startup.unwrap_or(base.startup);
        settings.history = self.history;
        settings.sampler.gamma = self.gamma.unwrap_or(settings.sampler.gamma);
        if let Some(estimate) = self.estimate {
            settings.set_estimator(estimate.into());
        }
        settings
    }

    /// Takes one word after the colon.
    fn change(&mut self, option: &str) -> Result<(), String> {
        if let Some(number) = option.strip_prefix("gamma=") {
            let gamma = number.parse().ok().filter(|gamma| (0.0..=4.0).contains(gamma));
            let gamma = gamma.ok_or_else(|| format!("gamma is '{number}', expected a number from 0 to 4"))?;
            if self.method == Method::Uniform {
                return Err("uniform sampling has no gamma".into());
            }
            return set(&mut self.gamma, gamma, "gamma");
        }
        if let Some(name) = option.strip_prefix("startup=") {
            let startup = Startup::from_str(name, false);
            let startup = startup.map_err(|_| format!("startup is one of {}", names::<Startup>()))?;
            return set(&mut self.startup, startup, "startup");
        }
        if option == "history" {
            return match std::mem::replace(&mut self.history, true) {
                false => Ok(()),
                true => Err("history twice".into()),
            };
        }
        let estimate = Estimate::from_str(option, false).map_err(|_| {
            format!(
                "'{option}' is no option: expected gamma=G, startup=S, history or one of {}",
                names::<Estimate>()
            )
        })?;
        set(&mut self.estimate, estimate, "estimator")
    }
}

/// Sets what was not set before.
fn set<T>(slot: &mut Option<T>, value: T, what: &str) -> Result<(), String> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(format!("more than one {what}")),
    }
}

impl FromStr for Variant {
    type Err = String;

    fn from_str(text: &str) -> Result<Variant, String> {
        let (method, options) = match text.split_once(':') {
            Some((method, options)) => (method, Some(options)),
            None => (text, None),
        };
        let method = Method::from_str(method, false).map_err(|_| {
            format!("expected one of {}, as in pmc, pmc:pooled or pmc:gamma=0.5+pooled", names::<Method>())
        })?;
        let mut variant = Variant::from(method);
        options.into_iter().flat_map(|options| options.split('+')).try_for_each(|o| variant.change(o))?;
        if variant.history && variant.estimate != Some(Estimate::Guided) {
            return Err("history needs the estimator guided".into());
        }
        Ok(variant)
    }
}

/// The names of an option's values.
fn names<T: ValueEnum>() -> String {
    let values = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    values.map(|value| value.get_name().to_owned()).collect::<Vec<_>>().join(", ")
}

impl Display for Variant {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let gamma = self.gamma.map(|gamma| format!("gamma={gamma}"));
        let estimate = self.estimate.and_then(|estimate| estimate.to_possible_value());
        let estimate = estimate.map(|value| value.get_name().to_owned());
        let startup = self.startup.and_then(|startup| startup.to_possible_value());
        let startup = startup.map(|value| format!("startup={}", value.get_name()));
        let history = self.history.then(|| "history".to_owned());
        let options: Vec<String> = gamma.into_iter().chain(estimate).chain(startup).chain(history).collect();
        let colon = if options.is_empty() { "" } else { ":" };
        write!(f, "{}{colon}{}", self.method, options.join("+"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for name in [
            "uniform",
            "paper",
            "pmc",
            "pmc:pooled",
            "paper:gamma=0.5",
            "pmc:gamma=1+difference",
            "pmc:guided",
            "pmc:startup=motion",
            "pmc:guided+history",
        ] {
            assert_eq!(name.parse::<Variant>().unwrap().to_string(), name);
        }
        let swapped: Variant = "pmc:pooled+gamma=1".parse().unwrap();
        assert_eq!(swapped, "pmc:gamma=1+pooled".parse().unwrap());
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (name, words) in [
            ("best", "uniform, paper"),
            ("pmc:", "'' is no option"),
            ("pmc:best", "balanced, pooled, subframe, difference, guided"),
            ("pmc:gamma=NaN", "0 to 4"),
            ("pmc:startup=best", "uniform, "),
            ("pmc:gamma=1+gamma=2", "more than one gamma"),
            ("pmc:pooled+balanced", "more than one estimator"),
            ("uniform:gamma=1", "no gamma"),
            ("pmc:history", "needs the estimator guided"),
            ("pmc:guided+history+history", "twice"),
        ] {
            let said = name.parse::<Variant>().unwrap_err();
            assert!(said.contains(words), "{name}: {said}");
        }
    }
}
