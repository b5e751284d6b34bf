//! Devices that cost next to nothing: a script for the loop, and a baseline for the plants.

use crate::input::{BATCH, SAMPLE_TIME, ramp_and_hold};
use fractional_haptics::fracdiff::Real;
use fractional_haptics::haptic_loop::{Device, Reading, SafeForce};
use nalgebra::SVector;
use std::convert::Infallible;

/// A device that goes its own way and keeps the force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scripted<F, const D: usize> {
    script: [F; BATCH],
    tick: usize,
    force: SVector<F, D>,
}

impl<F: Real, const D: usize> Scripted<F, D> {
    pub(crate) fn new() -> Self {
        Self {
            script: ramp_and_hold(),
            tick: 0,
            force: SVector::from([F::ZERO; D]),
        }
    }
}

impl<F: Real, const D: usize> Device<F, D> for Scripted<F, D> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, D>, Infallible> {
        Ok(Reading {
            tick: self.tick as u64,
            time_s: self.tick as f64 * SAMPLE_TIME.0,
            position_m: SVector::from([self.script[self.tick]; D]),
        })
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Infallible> {
        self.force = *force.newtons();
        self.tick = (self.tick + 1) % BATCH;
        Ok(())
    }
}

/// Velocity and position of 65 g and 3.5 N·s/m, the force held for a sample.
#[derive(Debug)]
pub(crate) struct Euler([f64; 2]);

impl Euler {
    pub(crate) fn new() -> Self {
        Self([0.0; 2])
    }
}

impl Device<f64, 1> for Euler {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: SVector::from([self.0[1]]),
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        let [velocity, position] = &mut self.0;
        *velocity += SAMPLE_TIME.0 / 0.065 * (force.newtons()[0] - 3.5 * *velocity);
        *position += SAMPLE_TIME.0 * *velocity;
        Ok(())
    }
}
