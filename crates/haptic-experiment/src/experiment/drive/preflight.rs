//! Pre-flight of a drive: the loop of controller, rig and tissue, certified before it runs.
//!
//! ```text
//! free         controller and indenter alone                     not where a force is the set point: nothing is felt there
//! in contact   controller, both masses, the contact, the tissue that is really rendered: of a rig, and of two devices that face each other
//!              on one device its own mass alone, and the tissue before it as K + B·s^α, which no sample holds
//! ```
//! - *As it runs*: the matrices of both devices from sample to sample, with their delays and lags, the weights of the controller, the
//!   operator of the tissue, both forces held. Frictions, the limits of forces, the safety chain and the end of the contact are not in it.
//! - *Two clocks*: both loops sample at the same instants. Boards that tick apart by a part of a sample are not judged by their own instants.
//! - *Without any spring* a tissue that is pushed creeps on, a pole at z = 1 that the force does not show: such a tissue is judged held by
//!   a spring of 1e-4 of its first sample.

use super::Drive;
use fracdiff::{FrequencyResponse, Seconds, num_complex::Complex};
use fractional_control::{
    ControlError, FractionalTransferFunction, HeldPlant, LoadedPlant, Plant, SampledControlLoop,
    SampledLaw, Term, TwoPort,
};
use haptic_analysis::{Dynamics, ForcePath, LoopOperator};
use haptic_document::Failure;
use haptic_judge::preflight::softer;
use haptic_loop::{
    plant::{FacingConfig, FacingContact, MassDamperConfig, RigDrive},
    units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre},
};
use haptic_trial::{
    advice::parameter,
    device_table::dynamics,
    drive_verdict::{DriveVerdict, LoopVerdict},
};
use nalgebra::{DMatrix, DVector, RowDVector, SMatrix, SVector};
use std::sync::Arc;

/// A gain further from the present one is no remedy.
const WITHIN: f64 = 100.0;
/// A gain is tried this much beyond the edge.
const BEYOND: f64 = 0.01;

/// Verdict on a loop; `later` makes the loop whose command acts this many seconds later.
fn loop_verdict(
    closed: &SampledControlLoop,
    later: impl Fn(f64) -> Result<SampledControlLoop, Failure>,
) -> LoopVerdict {
    let margins = closed.margins();
    if !closed.verdict().stable {
        let stable_at = |gain: f64| closed.with_gain(gain).verdict().stable;
        let down = softer(|gain| Ok(stable_at(gain))).ok().flatten();
        let up = (margins.gain_up.map(|up| up.value))
            .filter(|up| *up < WITHIN && stable_at(up * (1.0 + BEYOND)));
        return LoopVerdict {
            stable_beyond_gain: down.or(up),
            ..LoopVerdict::default()
        };
    }
    let first = closed.remembered(margins.delay_s);
    let delay_s =
        closed.remembered(SampledControlLoop::delay_margin(first, &later).unwrap_or(first));
    LoopVerdict {
        stable: true,
        phase_margin_rad: margins.phase.map(|phase| phase.value),
        crossover_rad_s: margins.phase.map(|phase| phase.omega_rad_s),
        gain_margin: margins.gain_up.map(|gain| gain.value),
        delay_margin_s: delay_s.map(|delay| delay.value),
        stable_beyond_gain: None,
    }
}

/// A tissue as the loop sees it: K + B·T^(−μ)·P(w).
#[derive(Debug)]
pub(crate) struct TissueLaw {
    stiffness: f64,
    /// Dissipation as the force of a step feels it: B·T^(−μ), N/m.
    dissipation: f64,
    operator: LoopOperator,
}

impl TissueLaw {
    /// Law with K in N/m, B in N·s^μ/m and the operator.
    pub(crate) fn new(
        stiffness: f64,
        dissipation: f64,
        operator: LoopOperator,
        sample_time_s: f64,
    ) -> Self {
        let rate = libm::pow(sample_time_s, -operator.order().get());
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
    /// Looks at the loop on these two devices, of one sample time, of which the renderer makes this tissue.
    pub(crate) fn facing(
        &self,
        devices: &FacingConfig,
        load: RigDrive,
        mut tissue: TissueLaw,
    ) -> Result<DriveVerdict, Failure> {
        let (free, holding) = match load {
            RigDrive::Position(_) => {
                let indenter = dynamics(&devices.devices[1]);
                (Some(self.looked_at(&indenter, &[])?), None)
            }
            RigDrive::Force(_) => (None, tissue.holding()),
        };
        tissue.stiffness = holding.unwrap_or(tissue.stiffness);
        let tissue: Arc<dyn SampledLaw> = Arc::new(tissue);
        let later = |delay_s: f64| self.in_contact(devices, load, &tissue, delay_s);
        Ok(DriveVerdict {
            free,
            in_contact: Some(loop_verdict(&later(0.0)?, later)),
            holding_stiffness_n_per_m: holding,
        })
    }

    /// Both masses and the tissue, the force of the drive so much later.
    fn in_contact(
        &self,
        devices: &FacingConfig,
        load: RigDrive,
        tissue: &Arc<dyn SampledLaw>,
        delay_s: f64,
    ) -> Result<SampledControlLoop, Failure> {
        let late = LateSample::new(devices, delay_s)?;
        let port = late.port(load, &devices.contact);
        let sample_time = devices.devices[1].sample_time;
        let plant = LoadedPlant::new(&port, Arc::clone(tissue), sample_time);
        plant
            .and_then(|plant| {
                let plant = plant.later(late.later)?;
                SampledControlLoop::loaded(
                    self.controller.setup.law,
                    self.controller.setup.memory()?,
                    &plant,
                )
            })
            .map_err(|error| self.refused(&error))
    }

    /// Verdict on a device that moves the indenter itself. `tissue` is K and B·s^α in front of it, felt all the time, if its law is that.
    pub(crate) fn on_device(
        &self,
        device: &Dynamics,
        tissue: Option<[Term; 2]>,
    ) -> Result<DriveVerdict, Failure> {
        let in_contact = tissue.map(|tissue| self.looked_at(device, &tissue));
        Ok(DriveVerdict {
            free: Some(self.looked_at(device, &[])?),
            in_contact: in_contact.transpose()?,
            holding_stiffness_n_per_m: None,
        })
    }

    /// Looks at one mass, with what else it moves.
    fn looked_at(&self, device: &Dynamics, tissue: &[Term]) -> Result<LoopVerdict, Failure> {
        let later = |delay_s: f64| {
            let closed = self.alone(device, tissue, delay_s);
            closed.map_err(|error| self.refused(&error))
        };
        Ok(loop_verdict(&later(0.0)?, later))
    }

    /// One mass, with what else it moves, the force of the drive so much later.
    ///
    /// ```text
    /// x/u = e^(−s·delay) / ((τs + 1)(ms² + bs + k + …))
    /// ```
    fn alone(
        &self,
        device: &Dynamics,
        tissue: &[Term],
        delay_s: f64,
    ) -> Result<SampledControlLoop, ControlError> {
        let moved = [
            Term::new(device.mass_kg, 2.0),
            Term::new(device.damping_n_s_per_m, 1.0),
            Term::new(device.hand_stiffness_n_per_m, 0.0),
        ];
        let lag_s = device.current_lag_s;
        let terms = moved.iter().chain(tissue).flat_map(|term| {
            let lagging = Term::new(lag_s * term.coefficient, term.order + 1.0);
            [*term, lagging]
        });
        let terms: Vec<Term> = terms.filter(|term| term.coefficient != 0.0).collect();
        let function = FractionalTransferFunction::new(&[Term::new(1.0, 0.0)], &terms)?;
        let plant = Plant::transfer(function, device.delay_s + delay_s)?;
        let setup = &self.controller.setup;
        let sample_time = Seconds(setup.sample_time_s);
        setup.closed_with(&HeldPlant::new(&plant, setup.memory()?, sample_time)?)
    }
}

/// A device of the analysis as one that faces another, of this sample time.
pub(crate) fn device(dynamics: &Dynamics, sample_time: Seconds) -> MassDamperConfig {
    MassDamperConfig {
        stiffness: NewtonsPerMetre(dynamics.hand_stiffness_n_per_m),
        delay: Seconds(dynamics.delay_s),
        current_lag: Seconds(dynamics.current_lag_s),
        ..MassDamperConfig::ideal(
            Kilograms(dynamics.mass_kg),
            NewtonSecondsPerMetre(dynamics.damping_n_s_per_m),
            sample_time,
        )
    }
}

/// A sample of two devices in contact, in parts of constant forces.
#[derive(Debug)]
struct LateSample {
    /// Delay of each command: d and η.
    late: [(usize, f64); 2],
    lags: [bool; 2],
    /// Part of the sample at which each phase begins, and the motion from there to the next.
    phases: Vec<(f64, SMatrix<f64, 8, 8>)>,
    /// Whole samples by which the command of the indenter is later still.
    later: usize,
}

impl LateSample {
    /// Sample of these devices, with the force on the indenter delayed by `delay_s` beyond its own delay.
    fn new(devices: &FacingConfig, delay_s: f64) -> Result<Self, Failure> {
        let [renderer, indenter] = devices.devices;
        let Seconds(t) = indenter.sample_time;
        let path = |delay_s: f64| ForcePath::new(delay_s / t, 0.0).map_err(Failure::input);
        let (first, second) = (path(renderer.delay.0)?, path(indenter.delay.0 + delay_s)?);
        let late = [
            (first.whole_samples(), first.fraction()),
            (0, second.fraction()),
        ];
        let mut cuts = [0.0, first.fraction(), second.fraction(), 1.0];
        cuts.sort_by(f64::total_cmp);
        let phases = cuts.windows(2).filter(|cut| cut[1] > cut[0]);
        let phases = phases.map(|cut| {
            let motion = devices.motion(true, Seconds((cut[1] - cut[0]) * t));
            Ok((cut[0], motion.map_err(parameter)?))
        });
        Ok(Self {
            late,
            lags: devices.devices.map(|device| device.current_lag.0 > 0.0),
            phases: phases.collect::<Result<_, Failure>>()?,
            later: second.whole_samples(),
        })
    }

    /// The state a sample later, in which the forces of both are commanded anew: both motions, both actuators, the commands of the
    /// renderer on their way, newest first, and that of the indenter.
    ///
    /// ```text
    /// u(t) = u[n − d] from the part η of the sample on, u[n − d − 1] before        d + η the delay in samples
    /// ```
    fn pass(&self, state: &DVector<f64>, forces: [f64; 2]) -> DVector<f64> {
        let waiting = [6, state.len() - 1];
        let mut motion = SVector::<f64, 8>::zeros();
        motion.rows_mut(0, 4).copy_from(&state.rows(0, 4));
        let mut made = [state[4], state[5]];
        for (from, moved) in &self.phases {
            for side in [0, 1] {
                let (samples, part) = self.late[side];
                let command = match samples + usize::from(*from < part) {
                    0 => forces[side],
                    age => state[waiting[side] + age - 1],
                };
                motion[6 + side] = command;
                // Without a lag the actuator is its command.
                motion[4 + side] = f64::from(u8::from(self.lags[side])) * (made[side] - command);
            }
            motion = moved * motion;
            made = [0, 1].map(|side| motion[4 + side] + motion[6 + side]);
        }
        let mut next = state.clone();
        next.rows_mut(0, 4).copy_from(&motion.rows(0, 4));
        next.rows_mut(4, 2).copy_from_slice(&made);
        let (samples, _) = self.late[0];
        next.rows_mut(7, samples).copy_from(&state.rows(6, samples));
        (next[6], next[7 + samples]) = (forces[0], forces[1]);
        next
    }

    /// The controller pushes the indenter, the tissue feels and pushes the renderer.
    fn port(&self, load: RigDrive, contact: &FacingContact) -> TwoPort {
        let states = 8 + self.late[0].0;
        let unit = |state| DVector::from_fn(states, |row, _| f64::from(u8::from(row == state)));
        let columns = (0..states).map(|state| self.pass(&unit(state), [0.0; 2]));
        let rest = DVector::zeros(states);
        let seen = match load {
            // F = k·p + c·p'
            RigDrive::Force(_) => {
                let (k, c) = (contact.stiffness.0, contact.damping.0);
                [-k, -c, k, c]
            }
            RigDrive::Position(_) => [0.0, 0.0, 1.0, 0.0],
        };
        let output =
            |seen: [f64; 4]| RowDVector::from_row_slice(&seen).resize_horizontally(states, 0.0);
        TwoPort {
            transition: DMatrix::from_columns(&columns.collect::<Vec<_>>()),
            command: self.pass(&rest, [0.0, 1.0]),
            load: self.pass(&rest, [1.0, 0.0]),
            measured: output(seen),
            felt: output([1.0, 0.0, 0.0, 0.0]),
        }
    }
}

#[cfg(test)]
mod tests {
    use testkit::Tested;
    mod pairs;

    use super::*;
    use fracdiff::{Order, Scheme};
    use fractional_control::ControllerSetup;
    use haptic_loop::{
        plant::{FacingDevices, FacingSide, RampHold, RigConfig, RigContact},
        units::{Metres, Newtons},
    };

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
            force_limit_reason: None,
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
                haptic_judge::modelled_tissue::loop_operator(None, scheme, order, t, 10.0)
                    .expect("an operator");
            TissueLaw::new(200.0, 20.0, operator, t.0)
        };
        (drive, rig, tissue)
    }

    /// Just before the delay margin the loop is stable, just behind it is not: the force switches inside a sample.
    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn the_delay_margin_is_where_the_verdict_changes_inside_a_sample() {
        let mut largest: f64 = 0.0;
        for (gains, of_force) in [
            ("2000+60000/s+15s", false),
            ("6000+25s", false),
            ("900+9000/s^0.9+25s^0.9", false),
            ("0.3+20/s^0.9", true),
        ] {
            let (drive, rig, tissue) = held(gains, of_force);
            let devices = rig.facing().expect("a mass");
            let verdict = drive.facing(&devices, rig.drive, tissue());
            let verdict = verdict.expect("judged");
            let tissue: Arc<dyn SampledLaw> = Arc::new(tissue());
            let contact = |delay_s: f64| {
                let closed = drive.in_contact(&devices, rig.drive, &tissue, delay_s);
                closed.expect("closes")
            };
            let indenter = Dynamics::ideal(rig.indenter_mass.0, rig.indenter_damping.0);
            let free = |delay_s: f64| drive.alone(&indenter, &[], delay_s).expect("closes");
            let mut judge = |verdict: LoopVerdict, later: &dyn Fn(f64) -> SampledControlLoop| {
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

    /// Two devices that differ, both with a delay and a lag.
    fn pair() -> FacingConfig {
        let t = Seconds(1e-3);
        let device = |mass, damping, delay, lag| MassDamperConfig {
            delay: Seconds(delay),
            current_lag: Seconds(lag),
            ..MassDamperConfig::ideal(Kilograms(mass), NewtonSecondsPerMetre(damping), t)
        };
        FacingConfig {
            devices: [
                device(0.065, 3.5, 1.25e-3, 0.3e-3),
                device(0.21, 2.0, 2.625e-3, 0.7e-3),
            ],
            contact: FacingContact::COMPLIANT,
        }
    }

    /// The world that runs, with a preload that keeps the contact: what the matrices say of the deviations.
    #[test]
    fn the_matrices_of_two_late_devices_are_the_motion_of_the_world_that_runs() -> Tested {
        for (lags, gap) in [
            ([0.3e-3, 0.7e-3], 0.0),
            ([0.0, 0.0], 2e-3),
            ([1e-3, 0.0], 0.0),
        ] {
            let mut devices = pair();
            devices.contact.gap = Metres(gap);
            for (device, lag) in devices.devices.iter_mut().zip(lags) {
                device.current_lag = Seconds(lag);
            }
            let mut world = FacingDevices::new(devices, Seconds(1e-9))?;
            let mut sample = |forces: [f64; 2]| {
                world.command(FacingSide::Renderer, forces[0]);
                world.command(FacingSide::Indenter, forces[1]);
                world.advance_to(world.now() + 1_000_000);
                assert!(world.now() < 1_000_000_000 || world.contact_force() > 0.0);
                [FacingSide::Renderer, FacingSide::Indenter].map(|side| world.position(side))
            };
            let preload = 50.0;
            let mut rest = [0.0; 2];
            for _ in 0..2000 {
                rest = sample([-preload, preload]);
            }
            let way = RigDrive::Position(RampHold::new(Metres(1e-3), Seconds(0.1))?);
            let late = LateSample::new(&devices, 0.0)?;
            assert_eq!(late.later, 2);
            let port = late.port(way, &devices.contact);
            let mut state = DVector::zeros(port.felt.len());
            let mut on_the_way = std::collections::VecDeque::from([0.0; 2]);
            for n in 0..200 {
                let forces = [(1.3 * f64::from(n)).sin(), (0.7 * f64::from(n)).cos() - 0.3];
                let have = sample([forces[0] - preload, forces[1] + preload]);
                on_the_way.push_back(forces[1]);
                let command = on_the_way.pop_front().expect("two and one");
                state =
                    &port.transition * &state + &port.command * command + &port.load * forces[0];
                let want = [&port.felt, &port.measured].map(|seen| (seen * &state)[0]);
                for (side, want) in want.into_iter().enumerate() {
                    let have = have[side] - rest[side];
                    assert!(
                        (have - want).abs() < 1e-9 * want.abs().max(1e-3),
                        "{n}: {have} {want}"
                    );
                }
            }
        }
        Ok(())
    }
}
