//! The force that the full history of a motion asks for.

use super::specification::Rendering;
use crate::failure::Failure;
use crate::kept::Samples;
use crate::track::{Track, operator};
use fracdiff::Seconds;

impl Rendering {
    /// The force that the specimen opposes to an indentation, by the full history of it, N.
    ///
    /// ```text
    /// F = max(0, (A/ℓ)·(E₀·x + η·D^α x))        x ≥ 0
    /// ```
    ///
    /// # Errors
    /// If the record cannot be transformed.
    pub fn full_history_force(&self, position_m: &[f64]) -> anyhow::Result<Vec<f64>> {
        let tissue = self.material.tissue();
        // The virtual tissue begins at 0 and only pushes.
        let depth: Vec<f64> = position_m.iter().map(|x| x.max(0.0)).collect();
        let t = Seconds(self.sample_time_s);
        let kernel = self.reference_kernel();
        let derivative = crate::judge::full_history(kernel, tissue.order(), t, &depth)?;
        let pushes = self.pushes();
        let forces = depth.iter().zip(derivative).map(|(&x, d)| pushes(x, d));
        Ok(forces.collect())
    }

    /// The same tick by tick, for a run too long to keep: from each position the force.
    ///
    /// # Errors
    /// A duration outside the range of [`samples`](Self::samples).
    pub(crate) fn full_history_step(
        &self,
        duration_s: f64,
    ) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
        let samples = self.samples(duration_s)?;
        let (kernel, t) = (self.reference_kernel(), Seconds(self.sample_time_s));
        let mut channel = operator(kernel, self.material.tissue().order(), t, samples)?;
        let pushes = self.pushes();
        Ok(move |x: f64| {
            let depth = x.max(0.0);
            pushes(depth, channel.step(depth))
        })
    }

    /// The force of [`full_history_force`](Self::full_history_force) for each sample of a run.
    ///
    /// # Errors
    /// If the record cannot be transformed.
    pub(crate) fn full_history(
        &self,
        samples: Samples<'_>,
        duration_s: f64,
    ) -> Result<Track<'static>, Failure> {
        Track::new(
            samples,
            |x| self.full_history_force(x).map_err(Failure::Run),
            || {
                let mut force = self.full_history_step(duration_s)?;
                Ok(Box::new(move |_, x| force(x)))
            },
        )
    }

    /// The force at a depth of at least 0, m, and its derivative of order α, N.
    fn pushes(&self) -> impl Fn(f64, f64) -> f64 + use<> {
        let (stiffness, dissipation) = self.spring_and_damper();
        move |depth, derivative| {
            if depth > 0.0 {
                (stiffness * depth + dissipation * derivative).max(0.0)
            } else {
                0.0
            }
        }
    }
}
