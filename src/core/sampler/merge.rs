//! Films of one frame, rendered apart with different seeds, as one.

use super::saved::{Pixel, Saved};
use super::{Error, Estimator, Sampler, Settings, State};
use crate::maths::colour::luminance;

impl Sampler<'_> {
    /// Takes in the film of the same frame that was rendered apart from this one, with another seed: afterwards this film is
    /// that of all samples of both.
    ///
    /// Means and variances are merged by Chan, Golub and LeVeque, *Updating formulae and a pairwise algorithm for computing
    /// sample variances*, 1979, in double precision; estimators' own means by the number of samples, or of iterations, that
    /// they are of: every estimator stays as unbiased as it was. The order of merging matters for rounding alone.
    ///
    /// # Errors
    /// [`Error::Merge`] if the films differ in more than the seed, or do not differ in that; [`Error::Running`] if an iteration
    /// of one of them is running.
    pub fn merge(&mut self, other: &Saved<'_>) -> Result<(), Error> {
        let (mine, its) = (self.state, *other.state());
        self.at_rest()?;
        if its.running > 0 {
            return Err(Error::Running);
        }
        let alike = Settings { seed: mine.settings.seed, ..its.settings } == mine.settings;
        let fits =
            (mine.labelled, mine.used) == (its.labelled, its.used) && other.has_labels(self.planes.label);
        if !(alike && fits) || mine.settings.seed == its.settings.seed {
            return Err(Error::Merge);
        }
        for i in 0..self.planes.count.len() {
            self.merge_pixel(i, other.pixel(i), &its);
        }
        let state = &mut self.state;
        state.samples = state.samples.saturating_add(its.samples);
        state.iteration = state.iteration.saturating_add(its.iteration);
        state.fair = state.fair.and(its.fair);
        Ok(())
    }

    fn merge_pixel(&mut self, i: usize, pixel: Pixel, its: &State) {
        let planes = &mut self.planes;
        let mine = Pixel {
            count: planes.count[i],
            drawn: planes.drawn[i],
            mean: [0, 1, 2].map(|c| planes.mean[c][i]),
            m2: planes.m2[i],
            fair: [0, 1, 2].map(|c| planes.fair[c][i]),
        };
        let weight = |state: &State, drawn: u32| match state.settings.estimator {
            Estimator::Subframe => state.iteration,
            _ => state.fair.count().min(drawn),
        };
        let share = share(mine.count, pixel.count);
        let fair_share = self::share(weight(&self.state, mine.drawn), weight(its, pixel.drawn));
        let toward =
            |a: f32, b: f32, share: f64| (f64::from(a) + (f64::from(b) - f64::from(a)) * share) as f32;
        let delta = f64::from(luminance([0, 1, 2].map(|c| pixel.mean[c] - mine.mean[c])));
        let between = delta * delta * share * f64::from(mine.count);
        for c in 0..3 {
            planes.mean[c][i] = toward(mine.mean[c], pixel.mean[c], share);
            planes.fair[c][i] = toward(mine.fair[c], pixel.fair[c], fair_share);
        }
        planes.m2[i] = (f64::from(mine.m2) + f64::from(pixel.m2) + between) as f32;
        planes.count[i] = mine.count.saturating_add(pixel.count);
        planes.drawn[i] = mine.drawn.saturating_add(pixel.drawn);
    }
}

/// The part of both that the second is; none of nothing.
fn share(first: u32, second: u32) -> f64 {
    f64::from(second) / (f64::from(first) + f64::from(second)).max(1.0)
}
