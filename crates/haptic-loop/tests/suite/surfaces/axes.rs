//! A device whose axes differ.

use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::{Device, Reading, SafeForce};
use nalgebra::SVector;
use std::convert::Infallible;
use testkit::device::{plant, read, write};

/// A mass-damper of its own on each axis.
#[derive(Clone, Debug)]
pub(super) struct Axes<const D: usize>([MassDamper<1>; D]);

impl<const D: usize> Axes<D> {
    pub(super) fn new(configs: [MassDamperConfig; D]) -> Self {
        Self(configs.map(plant))
    }

    pub(super) fn set_state(&mut self, position: SVector<f64, D>, velocity: SVector<f64, D>) {
        for (index, axis) in self.0.iter_mut().enumerate() {
            axis.set_state([position[index]].into(), [velocity[index]].into());
        }
    }

    pub(super) fn set_external_force(&mut self, force: SVector<f64, D>) {
        for (axis, &force) in self.0.iter_mut().zip(&force) {
            axis.set_external_force([force].into());
        }
    }

    pub(super) fn velocity(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.0[axis].velocity()[0])
    }
}

impl<const D: usize> Device<f64, D> for Axes<D> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, D>, Infallible> {
        let first = read::<1>(&mut self.0[0]);
        Ok(Reading {
            tick: first.tick,
            time_s: first.time_s,
            position_m: SVector::from_fn(|axis, _| self.0[axis].position()[0]),
        })
    }

    fn write(&mut self, force: SafeForce<f64, D>) -> Result<(), Infallible> {
        for (axis, &force) in self.0.iter_mut().zip(force.newtons()) {
            write(axis, force);
        }
        Ok(())
    }
}
