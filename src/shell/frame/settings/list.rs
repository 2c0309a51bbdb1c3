//! Settings by name, for reports and for the attributes of EXR files.
//!
//! A frame is made anew from these names and values, and a frame on disk is taken for another one by them: hence every
//! field of every struct is named here, without `..`, so that a new one does not compile until it has its place.

use super::all::Settings;
use super::choices::Integrator;
use super::layers::{Layer, Layers};
use crate::frame::schedule::Target;
use crate::scene::View;
use pmcip_core::sampler;
use serde_json::{Map, Value, json};
use std::fmt;

impl Settings {
    /// Every setting by name, for reports and for the EXR file.
    pub fn list(&self) -> Map<String, Value> {
        let Settings {
            spp,
            iterations,
            method,
            sampler: _,
            integrator,
            max_depth,
            view,
            closing_view,
            startup,
            history,
            target,
            seconds,
            layers,
        } = *self;
        let View { from, at, up, fov, aperture, focus } = view;
        let list = json!({
            "spp": spp,
            "iterations": iterations,
            "pilot_spp": self.pilot(),
            "sampler": method.to_string(),
            "max_depth": max_depth,
            "look_from": from.map(short),
            "look_at": at.map(short),
            "up": up.map(short),
            "fov": short(fov),
            "startup": word(startup),
        });
        let mut list = object(list);
        list.extend(of_sampler(&self.film()));
        list.extend(of_integrator(integrator));
        if aperture > 0.0 {
            list.insert("aperture".into(), short(aperture).into());
            list.insert("focus".into(), focus.map(short).into());
        }
        if let Some(View { from, at, up, fov, aperture, focus }) = closing_view {
            let open = json!([from.map(short), at.map(short), up.map(short), short(fov), short(aperture)]);
            list.insert("shutter_closes".into(), json!([open, focus.map(short)]));
        }
        if history {
            list.insert("history".into(), history.into());
        }
        if layers != Layers::default() {
            list.insert("layers".into(), layers.iter().map(Layer::name).collect());
        }
        if self.grows() {
            list.remove("iterations");
            list.remove("pilot_spp");
        }
        if let Some(seconds) = seconds {
            list.insert("time".into(), short(seconds).into());
        }
        if let Some(Target { err, expected_spp }) = target {
            list.insert("target_err".into(), short(err).into());
            list.insert("expected_spp".into(), expected_spp.into());
        }
        list
    }
}

/// The core's settings.
fn of_sampler(settings: &sampler::Settings) -> Map<String, Value> {
    let sampler::Settings {
        width,
        height,
        seed,
        frame,
        cd_per_unit,
        mode,
        estimator,
        sequence,
        criterion,
        window,
        gamma,
        epsilon,
        defensive,
        fair,
        balance_radius,
    } = *settings;
    object(json!({
        "width": width,
        "height": height,
        "seed": seed,
        "frame": frame,
        "cd_per_unit": short(cd_per_unit),
        "mode": word(mode),
        "estimator": word(estimator),
        "sequence": word(sequence),
        "criterion": word(criterion),
        "window": word(window),
        "gamma": short(gamma),
        "epsilon": short(epsilon),
        "defensive": short(defensive),
        "fair": fair,
        "balance_radius": balance_radius,
    }))
}

/// An integrator's name and its own settings, as the command line spells them.
fn of_integrator(integrator: Integrator) -> Map<String, Value> {
    let name = integrator.name();
    object(match integrator {
        Integrator::Path => json!({ "integrator": name }),
        Integrator::Direct { light_samples, bsdf_samples } => {
            json!({ "integrator": name, "light_samples": light_samples, "bsdf_samples": bsdf_samples })
        }
        Integrator::Gather { photons, photon_seed } => {
            json!({ "integrator": name, "photons": photons, "photon_seed": photon_seed })
        }
    })
}

/// The names and values of a JSON object.
fn object(value: Value) -> Map<String, Value> {
    if let Value::Object(list) = value { list } else { Map::new() }
}

/// The name of an option of the core, as the command line writes it.
pub fn word(option: impl fmt::Debug) -> String {
    format!("{option:?}").to_lowercase()
}

/// The number whose few digits are those of `x`: widening 0.1 would print 0.10000000149.
fn short(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

#[cfg(test)]
mod tests {
    use super::super::choices::{Method, Startup};
    use super::*;
    use pmcip_core::sampler::estimate::Estimator;
    use pmcip_core::sampler::kernel::{Criterion, Window};
    use pmcip_core::sampler::{Mode, Sequence};

    fn settings() -> Settings {
        Settings {
            spp: 16,
            iterations: 8,
            method: Method::Pmc,
            sampler: sampler::Settings::new(5, 2),
            integrator: Integrator::Path,
            max_depth: 8,
            view: View {
                from: [0.0; 3],
                at: [0.0, 0.0, -1.0],
                up: [0.0, 1.0, 0.0],
                fov: 40.0,
                aperture: 0.0,
                focus: None,
            },
            closing_view: None,
            startup: Startup::Uniform,
            history: false,
            target: None,
            seconds: None,
            layers: Layers::default(),
        }
    }

    #[test]
    fn the_list_keeps_the_digits_of_floats() {
        let mut settings = settings();
        settings.sampler.gamma = 2.0 / 3.0;
        let list = settings.list();
        assert_eq!(list["gamma"].to_string(), "0.6666667");
        assert_eq!(list["epsilon"].to_string(), "0.01");
        assert_eq!((&list["estimator"], &list["criterion"]), (&"balanced".into(), &"mean".into()));
    }

    #[test]
    fn every_setting_shows_in_the_list() {
        let changes: [fn(&mut Settings); 36] = [
            |s| s.spp = 17,
            |s| s.iterations = 9,
            |s| s.method = Method::Paper,
            |s| s.sampler.width = 6,
            |s| s.sampler.height = 3,
            |s| s.sampler.seed = 1,
            |s| s.sampler.frame = 1,
            |s| s.sampler.cd_per_unit = 20.0,
            |s| s.sampler.mode = Mode::Uniform,
            |s| s.sampler.estimator = Estimator::Pooled,
            |s| s.sampler.sequence = Sequence::Fresh,
            |s| s.sampler.criterion = Criterion::Sample,
            |s| s.sampler.window = Window::Pixel,
            |s| s.sampler.gamma = 0.800_000_1,
            |s| s.sampler.epsilon = 0.02,
            |s| s.sampler.defensive = 0.0,
            |s| s.sampler.fair = 5,
            |s| s.sampler.balance_radius = 3,
            |s| s.integrator = Integrator::Direct { light_samples: 8, bsdf_samples: 8 },
            |s| s.integrator = Integrator::Direct { light_samples: 9, bsdf_samples: 8 },
            |s| s.integrator = Integrator::Direct { light_samples: 8, bsdf_samples: 9 },
            |s| s.integrator = Integrator::Gather { photons: 8, photon_seed: 8 },
            |s| s.integrator = Integrator::Gather { photons: 9, photon_seed: 8 },
            |s| s.integrator = Integrator::Gather { photons: 8, photon_seed: 9 },
            |s| s.max_depth = 9,
            |s| s.view.from[1] = 1.0,
            |s| s.view.at[1] = 1.0,
            |s| s.view.up[2] = 1.0,
            |s| s.view.fov = 41.0,
            |s| s.view.aperture = 0.1,
            |s| (s.view.aperture, s.view.focus) = (0.1, Some(2.0)),
            |s| s.closing_view = Some(s.view),
            |s| s.startup = Startup::Motion,
            |s| s.history = true,
            |s| s.layers = [Layer::Depth].into_iter().collect(),
            |s| s.layers = [].into_iter().collect(),
        ];
        let targets = [(0.5, None), (0.5, Some(1)), (0.5, Some(2)), (0.25, Some(1))];
        let targets = targets.map(|(err, expected_spp)| Some(Target { err, expected_spp }));
        let targets = [None].into_iter().chain(targets).map(|target| Settings { target, ..settings() });
        let changed = changes.into_iter().map(|change| {
            let mut settings = settings();
            change(&mut settings);
            settings
        });
        let all = changed.chain(targets).map(|settings| Value::Object(settings.list()).to_string());
        let mut lists: Vec<String> = all.collect();
        lists.sort();
        assert_eq!(lists.windows(2).find(|pair| pair[0] == pair[1]), None, "two settings have one list");
    }
}
