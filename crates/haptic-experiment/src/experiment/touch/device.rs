//! The device in the hand, and the record of each of its ticks.

use super::shape::{Grip, HandPath};
use fracdiff::Real;
use haptic_loop::{
    Device, Reading, SafeForce, Shape, Surface as _,
    plant::{Axes, MassDamperConfig},
};
use haptic_message::{PerAxis, TickMessage};
use haptic_trial::{
    simulate::Instrumented,
    tick::{KeptSample, TickRecord, judged_force_n, per_axis},
};
use nalgebra::SVector;
use std::convert::Infallible;

/// A device whose axes a hand moves along its path.
///
/// The hand's force, or the point that its spring pulls to, is held over a sample.
#[derive(Clone, Debug)]
pub(super) struct HeldAxes<const D: usize> {
    axes: Axes<D>,
    path: HandPath,
    grip: Grip,
    shape: Shape<f64, D>,
    damping_n_s_per_m: f64,
    sample_time_s: f64,
    tick: u64,
    energy: HandEnergy,
}

/// Energy that the hand was given, J.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HandEnergy {
    /// Energy given in all; negative if the hand gave more.
    pub given_j: f64,
    /// The most at any time.
    pub most_j: f64,
    /// All that went through the hand, either way.
    pub moved_j: f64,
}

impl<const D: usize> HeldAxes<D> {
    /// Axes at rest where the hand begins, or at 0 under a force. They have the spring of the hand in them.
    pub(super) fn new(
        mut axes: Axes<D>,
        path: HandPath,
        grip: Grip,
        shape: Shape<f64, D>,
        device: &MassDamperConfig,
    ) -> Self {
        if let Grip::Spring(_) = grip {
            let begin = SVector::from_fn(|axis, _| path.at(0.0, axis));
            axes.set_state(begin, SVector::zeros());
        }
        Self {
            axes,
            path,
            grip,
            shape,
            damping_n_s_per_m: device.damping.0,
            sample_time_s: device.sample_time.0,
            tick: 0,
            energy: HandEnergy::default(),
        }
    }

    pub(super) fn position_m(&self) -> SVector<f64, D> {
        self.axes.position()
    }

    /// Energy that the hand was given so far.
    pub(super) const fn energy(&self) -> HandEnergy {
        self.energy
    }

    /// The point of the path at this tick.
    fn hand(&self) -> SVector<f64, D> {
        let time_s = self.tick as f64 * self.sample_time_s;
        SVector::from_fn(|axis, _| self.path.at(time_s, axis))
    }

    /// The hand's force on the device, as a sensor in the handle sees it: damping counts as the hand's.
    fn force_of_hand(&self) -> SVector<f64, D> {
        let push = self.push(&self.hand()) - self.damping_n_s_per_m * self.axes.velocity();
        match self.grip {
            Grip::Spring(stiffness) => push - stiffness * self.axes.position(),
            Grip::Force => push,
        }
    }

    /// The hand's force without its spring, which is in the axes.
    fn push(&self, hand: &SVector<f64, D>) -> SVector<f64, D> {
        match self.grip {
            // k·(hand − x) = k·hand − k·x
            Grip::Spring(stiffness) => stiffness * hand,
            Grip::Force => *hand,
        }
    }

    /// Books the work of a sample on the way from `before` to where the device is.
    fn book(&mut self, push: &SVector<f64, D>, before: &SVector<f64, D>) {
        let after = self.axes.position();
        // ∫ (w − k·x)·dx, w held: exact whatever the motion in between.
        let mut work_j = push.dot(&(after - before));
        if let Grip::Spring(stiffness) = self.grip {
            work_j -= 0.5 * stiffness * (after + before).dot(&(after - before));
        }
        let energy = &mut self.energy;
        energy.given_j -= work_j;
        energy.moved_j += work_j.abs();
        energy.most_j = energy.most_j.max(energy.given_j);
    }
}

impl<F: Real, const D: usize> Device<F, D> for HeldAxes<D> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, D>, Infallible> {
        self.axes.read()
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Infallible> {
        let push = self.push(&self.hand());
        let before = self.axes.position();
        self.axes.set_external_force(push);
        self.axes.write(force)?;
        self.book(&push, &before);
        self.tick += 1;
        Ok(())
    }
}

/// A tick as the log has it, and the shape that it is judged by.
#[derive(Clone, Copy, Debug)]
pub(super) struct TouchTick<const D: usize> {
    tick: TickMessage,
    shape: Shape<f64, D>,
}

/// Depth into a shape, at least 0, m.
pub(super) fn depth<const D: usize>(shape: &Shape<f64, D>, position_m: &[f64]) -> f64 {
    let position = SVector::from_fn(|axis, _| position_m.get(axis).copied().unwrap_or(f64::NAN));
    shape.depth(&position).max(0.0)
}

impl<const D: usize> TouchTick<D> {
    /// Tick of a device that reports neither the aim of its hand nor the output of its motors.
    pub(super) fn unknown(shape: Shape<f64, D>) -> Self {
        let tick = TickMessage::unknown(D);
        Self { tick, shape }
    }

    /// Sensed force against the force on the hand, N: NaN if the sensor does not read every axis.
    fn sensed_n(&self) -> Option<f64> {
        let force_n = judged_force_n(&self.tick);
        let along = |sensed: PerAxis| -> f64 {
            let axes = sensed.iter().zip(force_n.iter());
            axes.map(|(sensed, force)| sensed * force).sum()
        };
        let sensed = self.tick.sensed_force_n.map(along)?;
        (force_n.norm() > 0.0).then(|| 0.0 - sensed / force_n.norm())
    }
}

impl<const D: usize> TickRecord for TouchTick<D> {
    fn logged(&self) -> &TickMessage {
        &self.tick
    }

    fn logged_mut(&mut self) -> &mut TickMessage {
        &mut self.tick
    }

    /// Along the normal: depth, and the force that is opposed to it.
    fn kept(&self) -> KeptSample {
        let tick = &self.tick;
        KeptSample {
            tick: tick.tick,
            time_s: tick.time_s,
            position_m: depth(&self.shape, &tick.position_m),
            force_n: 0.0 - judged_force_n(tick).norm(),
            applied_force_n: 0.0 - tick.applied_force_n.norm(),
            indenter_position_m: depth(&self.shape, &tick.indenter_position_m),
            contact_force_n: tick.contact_force_n.norm(),
            sensed_force_n: self.sensed_n(),
            limiters: tick.limiters,
        }
    }
}

impl<const D: usize> Instrumented<D> for HeldAxes<D> {
    type Message = TouchTick<D>;

    /// The point of the path (of a force: where the device is), the true position, and the force that the actuators make.
    fn observe(&self) -> TouchTick<D> {
        let position = self.axes.position();
        let reference = match self.grip {
            Grip::Spring(_) => self.hand(),
            Grip::Force => position,
        };
        TouchTick {
            tick: TickMessage {
                reference_m: per_axis(&reference),
                indenter_position_m: per_axis(&position),
                contact_force_n: per_axis(&self.axes.applied_force()),
                sensed_force_n: Some(per_axis(&self.force_of_hand())),
                ..TickMessage::unknown(D)
            },
            shape: self.shape,
        }
    }
}
