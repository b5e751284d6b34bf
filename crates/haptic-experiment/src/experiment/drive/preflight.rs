//! Pre-flight of a drive: the loop of controller, rig and tissue, certified before it runs.
//!
//! ```text
//! free         controller and indenter alone                     not where a force is the set point: nothing is felt there
//! in contact   controller, both masses, the contact, the tissue that is really rendered
//!              on a device its own mass alone, and the tissue before it as K + B·s^α, which no sample holds
//! ```
//! - *As it runs*: the matrices of the rig from sample to sample, the weights of the controller, the operator of the tissue, both forces
//!   held. The limits of forces, the safety chain and the end of the contact are not in it.
//! - *Without any spring* a tissue that is pushed creeps on, a pole at z = 1 that the force does not show: such a tissue is judged held by
//!   a spring of 1e-4 of its first sample.

use super::Drive;
use crate::document::failure::Failure;
use crate::judge::preflight::softer;
use crate::run::advice::parameter;
use crate::run::drive_verdict::{DriveVerdict, LoopVerdict};
use fracdiff::num_complex::Complex;
use fracdiff::{FrequencyResponse, Seconds};
use fractional_control::{
    ControlError, FractionalTransferFunction, LoadedPlant, Plant, SampledLaw, SampledLoop,
    SampledPlant, Term, TwoPort,
};
use haptic_analysis::{Dynamics, LoopOperator};
use haptic_loop::plant::{IndentationRig, RigConfig, RigContact, RigDrive, RigMotion};
use haptic_loop::units::Newtons;
use nalgebra::{DMatrix, DVector, RowDVector, Vector4};
use std::sync::Arc;

/// A gain further from the present one is no remedy.
const WITHIN: f64 = 100.0;
/// A gain is tried this much beyond the edge.
const BEYOND: f64 = 0.01;

impl LoopVerdict {
    /// Of a loop, and of the same whose command acts so many seconds later.
    fn of(closed: &SampledLoop, later: impl Fn(f64) -> Result<SampledLoop, Failure>) -> Self {
        let margins = closed.margins();
        if !closed.verdict().stable {
            let stable_at = |gain: f64| closed.with_gain(gain).verdict().stable;
            let down = softer(|gain| Ok(stable_at(gain))).ok().flatten();
            let up = (margins.gain_up.map(|up| up.value))
                .filter(|up| *up < WITHIN && stable_at(up * (1.0 + BEYOND)));
            return Self {
                stable_beyond_gain: down.or(up),
                ..Self::default()
            };
        }
        let first = closed.remembered(margins.delay_s);
        let delay_s = closed.remembered(SampledLoop::delay_margin(first, &later).unwrap_or(first));
        Self {
            stable: true,
            phase_margin_rad: margins.phase.map(|phase| phase.value),
            crossover_rad_s: margins.phase.map(|phase| phase.omega_rad_s),
            gain_margin: margins.gain_up.map(|gain| gain.value),
            delay_margin_s: delay_s.map(|delay| delay.value),
            stable_beyond_gain: None,
        }
    }
}

/// A tissue as the loop sees it: K + B·T^(−μ)·P(w).
#[derive(Debug)]
pub(crate) struct TissueLaw {
    stiffness: f64,
    /// As the force of a step feels it: B·T^(−μ), N/m.
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
    pub(crate) fn verdict(
        &self,
        rig: &RigConfig,
        mut tissue: TissueLaw,
    ) -> Result<DriveVerdict, Failure> {
        let free = match rig.drive {
            RigDrive::Position(_) => {
                let indenter = Dynamics::ideal(rig.indenter_mass.0, rig.indenter_damping.0);
                let later = |delay_s: f64| {
                    let closed = self.alone(&indenter, &[], delay_s);
                    closed.map_err(|error| self.refused(&error))
                };
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
            in_contact: Some(LoopVerdict::of(&later(0.0)?, later)),
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

    /// On a device that moves the indenter itself, with a tissue of K and B·s^α in front of it that is felt all the time, if its law is
    /// that.
    pub(crate) fn on_device(
        &self,
        device: &Dynamics,
        tissue: Option<[Term; 2]>,
    ) -> Result<DriveVerdict, Failure> {
        let looked_at = |tissue: &[Term]| -> Result<_, Failure> {
            let later = |delay_s: f64| {
                let closed = self.alone(device, tissue, delay_s);
                closed.map_err(|error| self.refused(&error))
            };
            Ok(LoopVerdict::of(&later(0.0)?, later))
        };
        Ok(DriveVerdict {
            free: Some(looked_at(&[])?),
            in_contact: tissue.map(|tissue| looked_at(&tissue)).transpose()?,
            holding_stiffness_n_per_m: None,
        })
    }

    /// One mass, with what else it moves, the force of the drive so much later.
    ///
    /// ```text
    /// x/u = e^(−s·delay) / ((τs + 1)(ms² + bs + k + …))
    /// ```
    fn alone(
        &self,
        device: &Dynamics,
        beside: &[Term],
        delay_s: f64,
    ) -> Result<SampledLoop, ControlError> {
        let moved = [
            Term::new(device.mass_kg, 2.0),
            Term::new(device.damping_n_s_per_m, 1.0),
            Term::new(device.hand_stiffness_n_per_m, 0.0),
        ];
        let lag_s = device.current_lag_s;
        let terms = moved.iter().chain(beside).flat_map(|term| {
            let lagging = Term::new(lag_s * term.coefficient, term.order + 1.0);
            [*term, lagging]
        });
        let terms: Vec<Term> = terms.filter(|term| term.coefficient != 0.0).collect();
        let function = FractionalTransferFunction::new(&[Term::new(1.0, 0.0)], &terms)?;
        let plant = Plant::transfer(function, device.delay_s + delay_s)?;
        let setup = &self.controller.setup;
        let sample_time = Seconds(setup.sample_time_s);
        setup.closed_with(&SampledPlant::new(&plant, setup.memory()?, sample_time)?)
    }
}

/// Parts of a sample smaller than this are none.
const NO_PART: f64 = 1e-9;

/// A rig whose command acts later, by whole samples and a part of one.
#[derive(Debug)]
struct LatePort {
    /// Both masses in contact: the controller pushes the indenter, the tissue feels and pushes the renderer. Velocities in m a sample.
    ///
    /// With a part h of a sample the command of before acts first, and is a state more:
    ///
    /// ```text
    /// x[n+1] = Φx[n] + Γ((1−h)T)·u[n] + Φ((1−h)T)Γ(hT)·u[n−1] + Γ_f f[n]
    /// ```
    port: TwoPort,
    samples: usize,
}

impl LatePort {
    /// Of this rig, the force on the indenter so many seconds late.
    fn new(rig: &RigConfig, delay_s: f64) -> Result<Self, Failure> {
        let Seconds(t) = rig.sample_time;
        let samples = delay_s / t;
        let near = samples.round();
        let samples = if (samples - near).abs() < NO_PART {
            near
        } else {
            samples
        };
        let part = samples - samples.floor();
        let motion = |share: f64| motion(rig, share * t);
        let whole = motion(1.0)?;
        let commands = if part > 0.0 {
            let (late, early) = (motion(1.0 - part)?, motion(part)?);
            vec![late.indenter, late.transition * early.indenter]
        } else {
            vec![whole.indenter]
        };
        Ok(Self {
            port: port(rig, &whole, &commands),
            samples: samples.floor() as usize,
        })
    }
}

/// In contact, over a time in s.
fn motion(rig: &RigConfig, time_s: f64) -> Result<RigMotion, Failure> {
    let pushed = RigConfig {
        drive: RigDrive::Force(Newtons(0.0)),
        sample_time: Seconds(time_s),
        ..*rig
    };
    Ok(IndentationRig::new(pushed).map_err(parameter)?.motion(true))
}

/// With what the command does in its own sample, and what it does in the next if it comes late.
fn port(rig: &RigConfig, whole: &RigMotion, commands: &[Vector4<f64>]) -> TwoPort {
    let Seconds(t) = rig.sample_time;
    let units = [1.0, 1.0 / t, 1.0, 1.0 / t];
    let measured = match (rig.drive, rig.contact) {
        (RigDrive::Force(_), RigContact::Compliant { stiffness, damping }) => {
            // F = k·p + c·p'
            let (k, c) = (stiffness.0, damping.0);
            [-k, -c, k, c]
        }
        _ => [0.0, 0.0, 1.0, 0.0],
    };
    // The four of the motion, then the command of before.
    let states = 3 + commands.len();
    let input = |v: &Vector4<f64>, kept: f64| {
        DVector::from_fn(states, |row, _| {
            units.get(row).map_or(kept, |unit| v[row] / unit)
        })
    };
    let output = |v: [f64; 4]| {
        RowDVector::from_fn(states, |_, column| {
            units.get(column).map_or(0.0, |unit| v[column] * unit)
        })
    };
    TwoPort {
        transition: DMatrix::from_fn(states, states, |row, column| {
            match (units.get(row), units.get(column)) {
                (Some(to), Some(from)) => whole.transition[(row, column)] * from / to,
                (Some(to), None) => commands[1][row] / to,
                _ => 0.0,
            }
        }),
        command: input(&commands[0], 1.0),
        load: input(&whole.renderer, 0.0),
        measured: output(measured),
        felt: output([1.0, 0.0, 0.0, 0.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::{Order, Scheme};
    use fractional_control::ControllerSetup;
    use haptic_loop::plant::RampHold;
    use haptic_loop::units::Metres;

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
            device: None,
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
            let indenter = Dynamics::ideal(rig.indenter_mass.0, rig.indenter_damping.0);
            let free = |delay_s: f64| drive.alone(&indenter, &[], delay_s).expect("closes");
            let mut judge = |verdict: LoopVerdict, later: &dyn Fn(f64) -> SampledLoop| {
                let Some(delay) = verdict.delay_margin_s else {
                    return;
                };
                let stable = |share: f64| later(share * delay).verdict().stable;
                assert!(stable(0.9999) && !stable(1.0001), "{gains}: {delay}");
                let by_phase = later(0.0).margins().delay_s.expect("one").value;
                largest = largest.max((by_phase / delay - 1.0).abs());
            };
            judge(verdict.in_contact.expect("judged"), &contact);
            if let Some(verdict) = verdict.free {
                judge(verdict, &free);
            }
        }
        // The phase at the crossover alone is not enough.
        assert!(largest > 1e-3, "{largest}");
    }

    /// What the margin of a device promises holds when the device really is so much later.
    #[test]
    fn a_device_is_unstable_just_beyond_its_delay_margin() {
        let device = Dynamics {
            hand_stiffness_n_per_m: 30.0,
            delay_s: 7e-4,
            current_lag_s: 1.3e-3,
            ..Dynamics::ideal(0.2, 3.0)
        };
        let drive = held("900+3000/s^0.9+15s^0.9", false).0;
        let tissue = [Term::new(200.0, 0.0), Term::new(20.0, 0.5)];
        let verdict = drive.on_device(&device, Some(tissue)).expect("judged");
        let contact = verdict.in_contact.expect("judged");
        let free = verdict.free.expect("judged");
        assert!(verdict.stable() && free != contact, "{verdict:?}");
        let stable = |device: &Dynamics, tissue: &[Term]| {
            let closed = drive.alone(device, tissue, 0.0).expect("closes");
            closed.verdict().stable
        };
        let later = |share: f64| Dynamics {
            delay_s: device.delay_s + share * free.delay_margin_s.expect("one"),
            ..device
        };
        assert!(stable(&later(0.999), &[]) && !stable(&later(1.001), &[]));
    }

    /// Eight steps of an eighth of a sample, three of them with the command of before.
    #[test]
    fn a_command_that_comes_late_acts_as_in_small_steps() {
        let rig = RigConfig::new(
            RigDrive::Force(Newtons(0.0)),
            RigContact::COMPLIANT,
            Seconds(2e-3),
        );
        let small = motion(&rig, 2.5e-4).expect("runs");
        let late = LatePort::new(&rig, 2e-3 * 5.375).expect("runs");
        assert_eq!(late.samples, 5);
        let units = [1.0, 500.0, 1.0, 500.0];
        let from = Vector4::new(1e-3, -0.2, 1.5e-3, 0.3);
        let (before, now, load) = (1.7, -0.6, 0.4);
        let mut want = from;
        for part in 0..8 {
            let command = if part < 3 { before } else { now };
            want = small.transition * want + small.indenter * command + small.renderer * load;
        }
        let state = DVector::from_fn(5, |row, _| {
            units.get(row).map_or(before, |unit| from[row] / unit)
        });
        let port = &late.port;
        let have = &port.transition * state + &port.command * now + &port.load * load;
        for (row, unit) in units.iter().enumerate() {
            let (have, want) = (have[row] * unit, want[row]);
            assert!(
                (have - want).abs() < 1e-12 * want.abs().max(1.0),
                "{row}: {have} {want}"
            );
        }
        assert!((have[4] - now).abs() <= 0.0);
    }
}
