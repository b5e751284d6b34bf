//! A device whose axes differ.

use super::mass_damper::{MassDamper, MassDamperConfig};
use crate::{Device, LoopParameterError, Reading, SafeForce};
use core::array;
use core::convert::Infallible;
use fracdiff::Real;
use fracdiff::parameter::range;
use nalgebra::SVector;

/// A simulated device whose axes each have their own mass, damping, hand and friction, each a
/// [`MassDamper`].
///
/// ```text
/// m_i·x_i'' + b_i·x_i' + k_i·x_i = a_i + w_i        i = 1 … D
/// ```
/// *Cost* and exactness are as for the single axes.
#[derive(Clone, Debug)]
pub struct Axes<const D: usize> {
    axes: [MassDamper<1>; D],
    sample_time_s: f64,
    tick: u64,
}

impl<const D: usize> Axes<D> {
    /// Axes at rest at 0.
    ///
    /// # Errors
    /// A parameter outside its range, sample times that differ.
    pub fn new(configs: [MassDamperConfig; D]) -> Result<Self, LoopParameterError> {
        const { assert!(D > 0, "a device has an axis") };
        let sample_time_s = configs[0].sample_time.0;
        let first = MassDamper::new(configs[0])?;
        let mut axes = array::from_fn(|_| first.clone());
        for (axis, config) in axes.iter_mut().zip(configs) {
            let t = config.sample_time.0;
            let same = t.to_bits() == sample_time_s.to_bits();
            range("sample time of an axis", t, same, "that of the first", "s")?;
            *axis = MassDamper::new(config)?;
        }
        Ok(Self {
            axes,
            sample_time_s,
            tick: 0,
        })
    }

    /// Puts the device at `position` (m) with `velocity` (m/s). Forces and time continue.
    pub fn set_state(&mut self, position: SVector<f64, D>, velocity: SVector<f64, D>) {
        for (index, axis) in self.axes.iter_mut().enumerate() {
            axis.set_state([position[index]].into(), [velocity[index]].into());
        }
    }

    /// Sets w, N: see [`MassDamper::set_external_force`].
    pub fn set_external_force(&mut self, force: SVector<f64, D>) {
        for (axis, &force) in self.axes.iter_mut().zip(&force) {
            axis.set_external_force([force].into());
        }
    }

    /// Current position of each axis, m.
    #[must_use]
    pub fn position(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.axes[axis].position()[0])
    }

    /// Current velocity of each axis, m/s.
    #[must_use]
    pub fn velocity(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.axes[axis].velocity()[0])
    }

    /// The actuators' force at the end of the last sample, N: see [`MassDamper::applied_force`].
    #[must_use]
    pub fn applied_force(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.axes[axis].applied_force()[0])
    }
}

impl<F: Real, const D: usize> Device<F, D> for Axes<D> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, D>, Infallible> {
        Ok(Reading {
            tick: self.tick,
            time_s: self.tick as f64 * self.sample_time_s,
            position_m: self.position().map(F::from_f64),
        })
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Infallible> {
        for (axis, force) in self.axes.iter_mut().zip(force.newtons()) {
            axis.advance([force.to_f64()].into());
        }
        self.tick += 1;
        Ok(())
    }
}
