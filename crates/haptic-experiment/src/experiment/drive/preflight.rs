//! Pre-flight of a drive: the loop of controller, rig and tissue, certified before it runs.
//!
//! ```text
//! free         controller and indenter alone                     not where a force is the set point: nothing is felt there
//! in contact   controller, both masses, the contact, the tissue that is really rendered
//! ```
//! - *As it runs*: the matrices of the rig from sample to sample, the weights of the controller, the operator of the tissue, both forces
//!   held. The limits of forces, the safety chain and the end of the contact are not in it.
//! - *Without any spring* a tissue that is pushed creeps on, a pole at z = 1 that the force does not show: such a tissue is judged held by
//!   a spring of 1e-4 of its first sample.

use super::Drive;
use super::port::LatePort;
use crate::document::failure::Failure;
use crate::document::parameters::{CONTROLLER, FORCE_UNSTABLE};
use crate::judge::preflight::softer;
use fracdiff::FrequencyResponse;
use fracdiff::num_complex::Complex;
use fractional_control::{
    ControlError, LoadedPlant, Margins, Plant, SampledLaw, SampledLoop, SampledPlant, StateSpace,
};
use haptic_analysis::LoopOperator;
use haptic_loop::plant::{RigConfig, RigDrive};
use nalgebra::{DMatrix, DVector, RowDVector};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The certified verdict on one loop of a drive, and how far it is from the edge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopVerdict {
    /// No pole on or outside the unit circle, proved.
    pub stable: bool,
    /// Phase margin, rad; null if |L| is never 1, and of an unstable loop, which has no margins.
    pub phase_margin_rad: Option<f64>,
    /// Crossover of that, rad/s.
    pub crossover_rad_s: Option<f64>,
    /// The least gain above 1 at which the loop is at the edge; null if none is.
    pub gain_margin: Option<f64>,
    /// The least further time by which the force of the drive may act later at which it is, s: a force is held, and switches inside a sample.
    /// Null if none is.
    pub delay_margin_s: Option<f64>,
    /// Of an unstable loop the gain, as a multiple of the present one, beyond which it is stable: below it if it is below 1, above it if
    /// it is above 1. Null if there is none within a hundred times, and of a stable loop.
    pub stable_beyond_gain: Option<f64>,
}

/// A gain further from the present one is no remedy.
const WITHIN: f64 = 100.0;
/// A gain is tried this much beyond the edge.
const BEYOND: f64 = 0.01;

impl LoopVerdict {
    /// Of a loop, and of the same whose command acts so many seconds later.
    fn of(closed: &SampledLoop, later: impl Fn(f64) -> Result<SampledLoop, Failure>) -> Self {
        let Margins {
            phase,
            gain_up,
            delay_s,
            ..
        } = closed.margins();
        if !closed.verdict().stable {
            let stable_at = |gain: f64| closed.with_gain(gain).verdict().stable;
            let down = softer(|gain| Ok(stable_at(gain))).ok().flatten();
            let up = gain_up
                .filter(|up| up.value < WITHIN && stable_at(up.value * (1.0 + BEYOND)))
                .map(|up| up.value);
            return Self {
                stable: false,
                phase_margin_rad: None,
                crossover_rad_s: None,
                gain_margin: None,
                delay_margin_s: None,
                stable_beyond_gain: down.or(up),
            };
        }
        let first = closed.remembered(delay_s);
        let delay_s = closed.remembered(SampledLoop::delay_margin(first, later).unwrap_or(first));
        Self {
            stable: true,
            phase_margin_rad: phase.map(|phase| phase.value),
            crossover_rad_s: phase.map(|phase| phase.omega_rad_s),
            gain_margin: gain_up.map(|gain| gain.value),
            delay_margin_s: delay_s.map(|delay| delay.value),
            stable_beyond_gain: None,
        }
    }

    /// The gain that would make an unstable loop stable, in words.
    fn remedy(&self) -> String {
        match self.stable_beyond_gain {
            Some(gain) if gain < 1.0 => {
                // Rounded down, so that what is proposed is accepted.
                format!("with {:.2e} of its gain it is stable", 0.99 * gain)
            }
            Some(gain) => format!("with more than {gain:.3} times its gain it is stable"),
            None => "no other gain makes it stable".to_owned(),
        }
    }

    fn line(&self) -> String {
        if !self.stable {
            return format!("unstable, {}", self.remedy());
        }
        let phase = self.phase_margin_rad.zip(self.crossover_rad_s);
        let phase = phase.map_or_else(String::new, |(margin, omega)| {
            format!(", {:.0}° at {omega:.3e} rad/s", margin.to_degrees())
        });
        let gain = (self.gain_margin).map_or_else(String::new, |gain| {
            format!(", to the edge with {gain:.2} times the gain")
        });
        format!("stable{phase}{gain}")
    }
}

/// The verdict on a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DriveVerdict {
    /// Before contact; null where a force is the set point.
    pub free: Option<LoopVerdict>,
    /// In contact with the tissue.
    pub in_contact: LoopVerdict,
    /// The spring that holds a tissue without one in this judgement, N/m; null if it is judged as it is.
    pub holding_stiffness_n_per_m: Option<f64>,
}

impl DriveVerdict {
    /// True if both loops are stable.
    #[must_use]
    pub fn stable(&self) -> bool {
        self.in_contact.stable && self.free.is_none_or(|free| free.stable)
    }

    /// Refuses what is unstable, unless it is forced.
    ///
    /// # Errors
    /// Bad input, with what to change.
    pub(crate) fn require_stable(&self, force: bool) -> Result<(), Failure> {
        if force || self.stable() {
            return Ok(());
        }
        let (whether, unstable) = match &self.free {
            Some(free) if !free.stable => ("before it touches the tissue", free),
            _ => ("in contact with the tissue", &self.in_contact),
        };
        let remedy = unstable.remedy();
        Err(Failure::bad_input(format_args!(
            "pre-flight: the loop of the drive would be unstable {whether}; {remedy}: take another {CONTROLLER} (lower gains, or tuned with \
             `host-cli control design`), or run it all the same with {FORCE_UNSTABLE}"
        )))
    }

    /// One line for a summary.
    #[must_use]
    pub fn line(&self) -> String {
        let contact = self.in_contact.line();
        match self.free {
            Some(free) => format!("in contact {contact}; free {}", free.line()),
            None => format!("in contact {contact}"),
        }
    }

    /// Adds the verdict to the metadata of a log.
    pub(crate) fn describe(&self, metadata: &mut BTreeMap<String, String>) {
        let or_none =
            |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| value.to_string());
        let loops = [("free", self.free), ("in_contact", Some(self.in_contact))];
        for (name, own) in loops {
            let Some(own) = own else { continue };
            for (key, value) in [
                ("stable", own.stable.to_string()),
                ("phase_margin_rad", or_none(own.phase_margin_rad)),
                ("crossover_rad_s", or_none(own.crossover_rad_s)),
                ("gain_margin", or_none(own.gain_margin)),
                ("delay_margin_s", or_none(own.delay_margin_s)),
            ] {
                metadata.insert(format!("drive.preflight.{name}.{key}"), value);
            }
        }
    }
}

/// A tissue as the loop sees it: K + B·T^(−μ)·P(w).
#[derive(Debug)]
pub(crate) struct TissueLaw {
    stiffness: f64,
    /// B·T^(−μ).
    dissipation: f64,
    operator: LoopOperator,
}

impl TissueLaw {
    /// From K in N/m, B in N·s^μ/m and the operator.
    pub(crate) fn new(
        stiffness: f64,
        dissipation: f64,
        operator: LoopOperator,
        sample_time_s: f64,
    ) -> Self {
        let rate = sample_time_s.powf(-operator.order().get());
        Self {
            stiffness,
            dissipation: dissipation * rate,
            operator,
        }
    }

    /// The weak spring that holds a tissue without one.
    fn holding(&self) -> Option<f64> {
        let least = 1e-4 * self.dissipation * self.operator.direct_gain();
        Some(least).filter(|least| self.stiffness < *least)
    }
}

impl SampledLaw for TissueLaw {
    fn response(&self, theta: f64) -> Complex<f64> {
        self.operator.response(theta) * self.dissipation + self.stiffness
    }

    fn variation(&self, low: f64, high: f64) -> f64 {
        self.dissipation * self.operator.variation(low, high)
    }
}

impl Drive {
    /// Looks at the loop on this rig with this tissue.
    ///
    /// # Errors
    /// A controller or rig that the analysis does not take.
    pub(crate) fn verdict(
        &self,
        rig: &RigConfig,
        mut tissue: TissueLaw,
    ) -> Result<DriveVerdict, Failure> {
        let free = match rig.drive {
            RigDrive::Position(_) => {
                let later =
                    |delay_s: f64| (self.free(rig, delay_s)).map_err(|error| self.refused(&error));
                Some(LoopVerdict::of(&later(0.0)?, later))
            }
            RigDrive::Force(_) => None,
        };
        let holding = match rig.drive {
            RigDrive::Position(_) => None,
            RigDrive::Force(_) => tissue.holding(),
        };
        tissue.stiffness = holding.unwrap_or(tissue.stiffness);
        let tissue: Arc<dyn SampledLaw> = Arc::new(tissue);
        let later = |delay_s: f64| self.in_contact(rig, &tissue, delay_s);
        Ok(DriveVerdict {
            free,
            in_contact: LoopVerdict::of(&later(0.0)?, later),
            holding_stiffness_n_per_m: holding,
        })
    }

    /// Both masses and the tissue, the force of the drive so much later.
    fn in_contact(
        &self,
        rig: &RigConfig,
        tissue: &Arc<dyn SampledLaw>,
        delay_s: f64,
    ) -> Result<SampledLoop, Failure> {
        let late = LatePort::new(rig, delay_s)?;
        let plant = LoadedPlant::new(&late.port, Arc::clone(tissue), rig.sample_time);
        plant
            .and_then(|plant| {
                let plant = plant.later(late.samples)?;
                SampledLoop::loaded(
                    self.controller.setup.law,
                    self.controller.setup.memory()?,
                    &plant,
                )
            })
            .map_err(|error| self.refused(&error))
    }

    /// The indenter alone, the force of the drive so much later.
    fn free(&self, rig: &RigConfig, delay_s: f64) -> Result<SampledLoop, ControlError> {
        let (mass, damping) = (rig.indenter_mass.0, rig.indenter_damping.0);
        let indenter = StateSpace::new(
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, -damping / mass]),
            DVector::from_column_slice(&[0.0, 1.0 / mass]),
            RowDVector::from_row_slice(&[1.0, 0.0]),
        )?;
        let plant = Plant::state_space(indenter, delay_s)?;
        let memory = self.controller.setup.memory()?;
        self.controller
            .setup
            .closed_with(&SampledPlant::new(&plant, memory, rig.sample_time)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::{Order, Scheme, Seconds};
    use fractional_control::ControllerSetup;
    use haptic_loop::plant::{RampHold, RigContact};
    use haptic_loop::units::{Metres, Newtons};

    /// A drive, its rig and a tissue of 200 N/m and 20 N·s^0.5/m, 1 ms a sample.
    fn held(gains: &str, of_force: bool) -> (Drive, RigConfig, impl Fn() -> TissueLaw) {
        let t = Seconds(1e-3);
        let drive = Drive {
            name: "own".to_owned(),
            controller: ControllerSetup::new(
                gains
                    .parse::<fractional_control::PidParameters>()
                    .expect("gains"),
                t,
            )
            .into(),
            force_limit_n: 10.0,
        };
        let set_point = if of_force {
            RigDrive::Force(Newtons(0.1))
        } else {
            RigDrive::Position(RampHold::new(Metres(1e-3), Seconds(0.1)).expect("a ramp"))
        };
        let rig = RigConfig::new(set_point, RigContact::COMPLIANT, t);
        let tissue = move || {
            let scheme: Scheme = "full".parse().expect("a scheme");
            let order = Order::new(0.5).expect("an order");
            let operator =
                crate::judge::modelled_tissue::loop_operator(None, scheme, order, t, 10.0)
                    .expect("an operator");
            TissueLaw::new(200.0, 20.0, operator, t.0)
        };
        (drive, rig, tissue)
    }

    /// Just before the delay margin the loop is stable, just behind it is not: the force switches inside a sample.
    #[test]
    fn the_delay_margin_is_where_the_verdict_changes_inside_a_sample() {
        let mut largest: f64 = 0.0;
        for (gains, of_force) in [
            ("2000+60000/s+15s", false),
            ("6000+25s", false),
            ("900+9000/s^0.9+25s^0.9", false),
            ("0.3+20/s^0.9", true),
        ] {
            let (drive, rig, tissue) = held(gains, of_force);
            let verdict = drive.verdict(&rig, tissue()).expect("judged");
            let tissue: Arc<dyn SampledLaw> = Arc::new(tissue());
            let contact = |delay_s: f64| drive.in_contact(&rig, &tissue, delay_s).expect("closes");
            let free = |delay_s: f64| drive.free(&rig, delay_s).expect("closes");
            let mut judge = |verdict: LoopVerdict, later: &dyn Fn(f64) -> SampledLoop| {
                let Some(delay) = verdict.delay_margin_s else {
                    return;
                };
                let stable = |share: f64| later(share * delay).verdict().stable;
                assert!(stable(0.9999) && !stable(1.0001), "{gains}: {delay}");
                let by_phase = later(0.0).margins().delay_s.expect("one").value;
                largest = largest.max((by_phase / delay - 1.0).abs());
            };
            judge(verdict.in_contact, &contact);
            if let Some(verdict) = verdict.free {
                judge(verdict, &free);
            }
        }
        // The phase at the crossover alone is not enough.
        assert!(largest > 1e-3, "{largest}");
    }
}
