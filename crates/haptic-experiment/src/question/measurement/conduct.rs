//! The excitation on a device, through the safety chain, to its end or to whatever ends it.

use super::excitation::{Course, Excitation, Finding, Phase};
use super::plan::MeasurePlan;
use super::record::MotionRecord;
use crate::document::failure::Failure;
use crate::question::measurement::keys::{HELD, MEASURE_BOX, MEASURE_FORCE_LIMIT};
use crate::run::sensors::Sensors;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::Seconds;
use haptic_loop::{Controller, Device, Fault, ParameterError, SafetyChain};
use std::sync::atomic::{AtomicBool, Ordering};

/// The end of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// The multi-sine came to its end.
    Complete,
    /// Stopped from outside.
    Interrupted,
    /// The safety chain latched a fault.
    Fault(Fault),
    /// No force that is allowed moves the device.
    Blocked,
    /// The device moved without any force.
    MovesByItself,
}

/// A motion, and how it ended; the force is zero.
#[derive(Clone, Debug)]
pub struct Driven {
    /// The motion up to there.
    pub record: MotionRecord,
    /// Its end.
    pub outcome: Outcome,
}

/// A measurement that could not be made.
#[derive(Debug, PartialEq)]
pub enum DriveError<E> {
    /// Limits that make no safety chain.
    Plan(ParameterError),
    /// The device did not do what it was told.
    Device(E),
}

/// Drives a device through a measurement. `applied` tells the force that the device really applied in a tick, from the one that it was sent;
/// `progress` hears the number of ticks.
///
/// Whatever ends it, the force is zero when this returns.
///
/// # Errors
/// Limits outside their range; the device's own.
pub fn drive<V: Device<f64, 1>>(
    plan: &MeasurePlan,
    device: &mut V,
    applied: &mut dyn FnMut(&V, f64) -> f64,
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<Driven, DriveError<V::Error>> {
    let first = device.read().map_err(DriveError::Device)?;
    let limits = plan.limits(first.position_m[0]);
    let chain = SafetyChain::from_limits(&limits, Seconds(plan.sample_time_s));
    let chain = chain.map_err(DriveError::Plan)?;
    let mut controller = Controller::<f64, 1, _>::new(Excitation::new(*plan), chain);
    // Whatever ends this function, no force stays.
    let mut engaged = controller.engage(device);
    let capacity = plan.ticks_at_most() as usize;
    let mut record = MotionRecord::with_capacity(plan.sample_time_s, capacity);
    let mut outcome = None;
    let mut next = first.tick;
    let mut reading = first;
    loop {
        let phase = engaged.controller_mut().law_mut().1.phase;
        let done = engaged.tick_reading(reading);
        let done = done.map_err(DriveError::Device)?;
        let missing = reading.tick.saturating_sub(next);
        next = reading.tick + 1;
        if outcome.is_none() {
            let force = applied(engaged.device(), done.force.newtons()[0]);
            note(&mut record, phase);
            record.push(missing, reading.position_m[0], force);
            progress(record.len() as u64);
            let course = engaged.controller_mut().law_mut().1;
            outcome = ended(course, done.fault, stop);
            if let [Some(up), Some(down)] = course.moved_at_n {
                record.breakaway_n = Some((up, down));
            }
        }
        if outcome.is_some() {
            engaged.controller_mut().stop();
        }
        if let (Some(outcome), true) = (outcome, engaged.controller().safety().is_at_rest()) {
            return Ok(Driven { record, outcome });
        }
        reading = engaged.read().map_err(DriveError::Device)?;
    }
}

/// Notes where the parts of the measurement begin.
fn note(record: &mut MotionRecord, phase: Phase) {
    match phase {
        Phase::Rest => record.rest = record.len() + 1,
        Phase::Driven => {}
        _ => record.driven_from = record.len() + 1,
    }
}

/// Reason to end, if there is one.
fn ended(course: &Course, fault: Option<Fault>, stop: &AtomicBool) -> Option<Outcome> {
    if let Some(fault) = fault {
        return Some(match fault {
            Fault::PositionStuck => Outcome::Blocked,
            // There is no force yet that could have moved it.
            Fault::Workspace | Fault::Velocity if course.phase == Phase::Rest => {
                Outcome::MovesByItself
            }
            fault => Outcome::Fault(fault),
        });
    }
    match course.finding {
        Some(Finding::Blocked) => return Some(Outcome::Blocked),
        Some(Finding::MovesByItself) => return Some(Outcome::MovesByItself),
        None => {}
    }
    if stop.load(Ordering::Relaxed) {
        return Some(Outcome::Interrupted);
    }
    (course.phase == Phase::Over).then_some(Outcome::Complete)
}

impl Outcome {
    /// Refuses all but a measurement that came to its end.
    ///
    /// # Errors
    /// In one line what happened, that the force is zero, and what to do.
    pub fn require_complete(self, plan: &MeasurePlan) -> Result<(), Failure> {
        let force = plan.force_n();
        let box_mm = 1e3 * plan.box_m;
        Err(Failure::Run(match self {
            Self::Complete => return Ok(()),
            Self::Interrupted => {
                anyhow::anyhow!("interrupted: the force is zero, nothing was written")
            }
            Self::Fault(Fault::Workspace) => anyhow::anyhow!(
                "the device left the box of {box_mm} mm about its start, and the force is zero: put it in the middle of its range, give a larger \
                 {MEASURE_BOX} or a smaller {MEASURE_FORCE_LIMIT}"
            ),
            Self::Fault(fault @ (Fault::Velocity | Fault::PositionJump)) => anyhow::anyhow!(
                "the device is too fast, and the force is zero ({fault}): give a smaller {MEASURE_FORCE_LIMIT}, or see to its sensor"
            ),
            Self::Fault(fault) => {
                anyhow::anyhow!("the measurement ended in a fault, and the force is zero: {fault}")
            }
            Self::Blocked => anyhow::anyhow!(
                "the device does not move under {force} N, and the force is zero: free it, see that its motor is on and its sensor works, or give \
                 a larger {MEASURE_FORCE_LIMIT}, of which a fifth is used"
            ),
            Self::MovesByItself => anyhow::anyhow!(
                "the device moves by itself, without any force: level it, let go of it, or give {HELD} if a hand holds it"
            ),
        }))
    }
}

/// Measures a simulated device in virtual time.
///
/// # Errors
/// A parameter outside its range; a measurement that did not come to its end.
pub fn on_simulated(
    plan: &MeasurePlan,
    (device, sensors): (MassDamperConfig, Sensors),
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<MotionRecord, Failure> {
    plan.check()?;
    let config = MassDamperConfig {
        sample_time: Seconds(plan.sample_time_s),
        ..device
    };
    let plant = MassDamper::<1>::new(config).map_err(Failure::input)?;
    let mut device = sensors.before(plant)?;
    let driven = drive(plan, &mut device, &mut |_, sent| sent, progress, stop);
    let driven = driven.map_err(|error| match error {
        DriveError::Plan(error) => Failure::input(error),
        DriveError::Device(never) => match never {},
    })?;
    driven.outcome.require_complete(plan)?;
    Ok(driven.record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_loop::Environment as _;

    #[test]
    fn who_leaves_the_box_before_there_is_a_force_moves_by_itself() {
        let mut course = Excitation::new(MeasurePlan::default()).at_rest();
        let never = AtomicBool::new(false);
        let mut seen = |phase, fault| {
            course.phase = phase;
            ended(&course, Some(fault), &never)
        };
        for fault in [Fault::Workspace, Fault::Velocity] {
            let itself = seen(Phase::Rest, fault);
            assert_eq!(itself, Some(Outcome::MovesByItself), "{fault}");
            let driven = seen(Phase::Driven, fault);
            assert_eq!(driven, Some(Outcome::Fault(fault)));
        }
        // A sensor that jumps is none that moves.
        let jump = seen(Phase::Rest, Fault::PositionJump);
        assert_eq!(jump, Some(Outcome::Fault(Fault::PositionJump)));
    }
}
