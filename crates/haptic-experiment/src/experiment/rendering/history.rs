//! The force that the full history of a motion asks for.

use super::specification::Rendering;
use crate::document::failure::Failure;
use crate::judge::reference::ReferenceSeries;
use crate::run::samples::Samples;
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
    pub(crate) fn full_history_force(&self, position_m: &[f64]) -> anyhow::Result<Vec<f64>> {
        // The virtual tissue begins at 0 and only pushes.
        let depth: Vec<f64> = position_m.iter().map(|x| x.max(0.0)).collect();
        let (shape, t) = (self.shape(), Seconds(self.sample_time_s));
        let reference = self.reference_kernel();
        let forces = self.material.full_history(shape, reference, t, &depth)?;
        let pushes = depth.iter().zip(forces).map(|(&x, f)| pushes(x, f));
        Ok(pushes.collect())
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
        let (reference, t) = (self.reference_kernel(), Seconds(self.sample_time_s));
        let mut tissue = self.material.sampled(self.shape(), reference, t, samples)?;
        Ok(move |x: f64| {
            let depth = x.max(0.0);
            let force = tissue.force(depth);
            tissue.advance(depth);
            pushes(depth, force)
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
    ) -> Result<ReferenceSeries<'static>, Failure> {
        ReferenceSeries::new(
            samples,
            |x| self.full_history_force(x).map_err(Failure::Run),
            || {
                let mut force = self.full_history_step(duration_s)?;
                Ok(Box::new(move |_, x| force(x)))
            },
        )
    }
}

/// The force of a tissue that only pushes, N, and only at a depth above 0, m.
fn pushes(depth: f64, force: f64) -> f64 {
    if depth > 0.0 { force.max(0.0) } else { 0.0 }
}
