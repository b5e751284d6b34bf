//! Pre-flight along the normal, with the effective mass of the posture.

use super::shape::{TouchShape, per_axis};
use super::specification::TouchExperiment;
use crate::failure::Failure;
use crate::preflight::{Preflight, PreflightVerdict};
use crate::pushed::dynamics;
use haptic_loop::plant::MassMatrix;
use haptic_loop::units::Kilograms;
use nalgebra::SVector;
use serde::Serialize;
use std::collections::BTreeMap;

/// Mass that is felt along the normal, in the postures that come up, and the worst of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PostureVerdict {
    /// Least 1/(nᵀ M⁻¹ n), kg.
    pub effective_mass_least_kg: f64,
    /// Largest, kg.
    pub effective_mass_most_kg: f64,
    /// The one of them that the pre-flight is of: unstable before stable, then of the smaller margin, kg.
    pub judged_mass_kg: f64,
}

impl PostureVerdict {
    /// Adds it to the metadata of a log.
    pub(super) fn describe(&self, metadata: &mut BTreeMap<String, String>) {
        for (key, value) in [
            ("effective_mass_least_kg", self.effective_mass_least_kg),
            ("effective_mass_most_kg", self.effective_mass_most_kg),
            ("judged_mass_kg", self.judged_mass_kg),
        ] {
            metadata.insert(format!("preflight.{key}"), value.to_string());
        }
    }
}

impl TouchExperiment {
    /// Least and largest effective mass along the normals that come up, kg: of axes that are masses of their own those of the
    /// axes themselves, unless there is one normal alone.
    ///
    /// # Errors
    /// A mass that is not above 0, a normal without length.
    fn effective_masses<const D: usize>(&self) -> Result<[f64; 2], Failure> {
        let masses = per_axis::<D>("mass_kg", &self.mass_kg)?.map(Kilograms);
        let matrix = MassMatrix::of_axes(masses)
            .map_err(|error| Failure::input_with_advice(error, "change `mass_kg`"))?;
        let TouchShape::Plane { normal, .. } = &self.shape else {
            return Ok(self.masses());
        };
        let normal = SVector::from(per_axis::<D>("normal", normal)?);
        let along = matrix
            .along(&normal)
            .map_err(|error| Failure::input_with_advice(error, "change `normal`"))?;
        Ok([along.0; 2])
    }

    /// The pre-flight of the worst posture.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub(super) fn preflight<const D: usize>(
        &self,
        samples: u64,
    ) -> Result<(PreflightVerdict, PostureVerdict), Failure> {
        let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = self.law.spring_and_damper();
        let preflight = Preflight {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order: self.law.order(),
            model: self.law.model(),
            scheme: self.scheme,
            sample_time_s: self.sample_time().0,
            samples,
        };
        let [least, most] = self.effective_masses::<D>()?;
        let judge = |mass: f64| -> Result<_, Failure> {
            let verdict = preflight.verdict(dynamics(&self.axis(mass)), 0)?;
            Ok((verdict, mass))
        };
        let (light, heavy) = (judge(least)?, judge(most)?);
        // Without an edge any margin is there; unstable without one none is.
        let rank = |verdict: &PreflightVerdict| {
            let margin = match verdict.stable {
                true => verdict.margin.unwrap_or(f64::INFINITY),
                false => verdict.margin.unwrap_or(0.0),
            };
            (verdict.stable, margin)
        };
        let (verdict, judged_mass_kg) = match rank(&heavy.0) < rank(&light.0) {
            true => heavy,
            false => light,
        };
        let posture = PostureVerdict {
            effective_mass_least_kg: least,
            effective_mass_most_kg: most,
            judged_mass_kg,
        };
        Ok((verdict, posture))
    }
}
