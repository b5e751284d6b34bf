//! Pre-flight along the normal, with the effective mass of the posture.

use super::shape::{TouchShape, per_axis};
use super::specification::TouchExperiment;
use crate::document::failure::Failure;
use crate::experiment::touch::keys::{TOUCH_BOX_HIGH, TOUCH_BOX_LOW, TOUCH_MASS, TOUCH_NORMAL};
use crate::judge::preflight::Preflight;
use crate::run::device::LinkedName;
use crate::run::preflight::{PreflightSubject, PreflightVerdict};
use haptic_analysis::Dynamics;
use haptic_devices::haply::Plane;
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

/// The loop in the lightest and the heaviest posture.
#[derive(Clone, Debug)]
pub(super) struct Postures<'a> {
    loops: Preflight<'a>,
    /// kg.
    masses: [f64; 2],
}

impl Postures<'_> {
    /// The verdict of the worse of both, and its mass, with this device but for the mass and so many samples of delay on a line.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub(super) fn worse(
        &self,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<(PreflightVerdict, PostureVerdict), Failure> {
        let [least, most] = self.masses;
        let judge = |mass_kg: f64| -> Result<_, Failure> {
            let dynamics = Dynamics {
                mass_kg,
                ..dynamics
            };
            Ok((self.loops.verdict(dynamics, line)?, mass_kg))
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

impl PreflightSubject for Postures<'_> {
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        Ok(self.worse(dynamics, line)?.0)
    }
}

impl TouchExperiment {
    /// Least and largest effective mass along the normals that come up, kg: of axes that are masses of their own those of the
    /// axes themselves, unless there is one normal alone; of arms those of their postures in the box.
    ///
    /// # Errors
    /// A mass that is not above 0, a normal without length, a box that the arms do not reach.
    fn effective_masses<const D: usize>(&self) -> Result<[f64; 2], Failure> {
        let masses = per_axis::<D>("mass_kg", &self.mass_kg)?;
        if let Some(plane) = self.plane() {
            let mean = masses.iter().product::<f64>().powf(1.0 / D as f64);
            return Ok(self.reached(&plane)?.map(|mass| mean * mass));
        }
        let matrix = MassMatrix::of_axes(masses.map(Kilograms)).map_err(|error| {
            Failure::input_with_advice(error, format_args!("change {TOUCH_MASS}"))
        })?;
        let TouchShape::Plane { normal, .. } = &self.shape else {
            return Ok(self.masses());
        };
        let normal = SVector::from(per_axis::<D>("normal", normal)?);
        let along = matrix.along(&normal).map_err(|error| {
            Failure::input_with_advice(error, format_args!("change {TOUCH_NORMAL}"))
        })?;
        Ok([along.0; 2])
    }

    /// The plane of a 2DIY.
    pub(super) fn plane(&self) -> Option<Plane> {
        match &self.remote.as_ref()?.name {
            LinkedName::Foreign(name) => name.plane(),
            LinkedName::Serial(_) => None,
        }
    }

    /// Least and largest mass in the box, or in the middle of the plane without one, for 1 kg in its centre.
    ///
    /// # Errors
    /// A box that the arms do not reach.
    pub(super) fn reached(&self, plane: &Plane) -> Result<[f64; 2], Failure> {
        let (low_m, high_m) = match &self.workspace {
            Some(workspace) => (
                per_axis("box_low_m", &workspace.low_m)?,
                per_axis("box_high_m", &workspace.high_m)?,
            ),
            None => Plane::HANDY_M,
        };
        plane.masses(low_m, high_m).map_err(|error| {
            Failure::input_with_advice(
                format_args!("the box is not within reach of the 2DIY: {error}"),
                format_args!("change {TOUCH_BOX_LOW} or {TOUCH_BOX_HIGH}"),
            )
        })
    }

    /// What the pre-flight is of.
    ///
    /// # Errors
    /// As [`effective_masses`](Self::effective_masses).
    pub(super) fn postures<const D: usize>(&self, samples: u64) -> Result<Postures<'_>, Failure> {
        let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = self.law.spring_and_damper();
        Ok(Postures {
            loops: Preflight {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                order: self.law.order(),
                model: self.law.model(),
                scheme: self.scheme,
                sample_time_s: self.sample_time().0,
                samples,
            },
            masses: self.effective_masses::<D>()?,
        })
    }
}
