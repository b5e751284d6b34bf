//! Delays of a simulated device: of the force inside a plant, of the measurement around a device.

use crate::error::Checks;
use crate::units::Seconds;
use crate::{Device, ParameterError, Reading, SafeForce};
use fracdiff::Real;
use fracdiff::parameter::RangeError;
use nalgebra::SVector;

/// Longest delay of a plant's force or measurement, in samples.
pub const MAX_DELAY_SAMPLES: usize = 64;

/// The newest sample and those up to [`MAX_DELAY_SAMPLES`] before it.
const LENGTH: usize = MAX_DELAY_SAMPLES + 1;

/// A delay of d + η samples, 0 ≤ η < 1: `(d, η)`.
///
/// A ratio within 1e-9 of a whole number is that number, so that 3e-3 s / 1e-3 s is 3 and not just
/// below.
///
/// Refused unless 0 ≤ delay ≤ [`MAX_DELAY_SAMPLES`] sample times.
pub(super) fn whole_and_fraction(
    what: &'static str,
    delay: Seconds,
    sample_time: f64,
    checks: &mut Checks,
) -> (usize, f64) {
    let ratio = checks.not_negative(what, delay.0, "s") / sample_time;
    let nearest = libm::rint(ratio);
    let ratio = if (ratio - nearest).abs() < 1e-9 {
        nearest
    } else {
        ratio
    };
    let short = ratio <= MAX_DELAY_SAMPLES as f64;
    checks.range(what, delay.0, short, "from 0 to 64 sample times", "s");
    let whole = libm::floor(ratio);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 ≤ whole ≤ 64"
    )]
    (whole as usize, ratio - whole)
}

/// The last commanded forces, N; zero before the first.
#[derive(Clone, Debug)]
pub(super) struct ForceLine<const D: usize> {
    forces: [SVector<f64, D>; LENGTH],
    newest: usize,
}

impl<const D: usize> ForceLine<D> {
    pub(super) fn at_rest() -> Self {
        Self {
            forces: [SVector::from([0.0; D]); LENGTH],
            newest: 0,
        }
    }

    pub(super) fn push(&mut self, force: SVector<f64, D>) {
        self.newest = (self.newest + 1) % LENGTH;
        self.forces[self.newest] = force;
    }

    /// The force pushed `age` pushes before the newest, `age` ≤ [`MAX_DELAY_SAMPLES`].
    pub(super) fn aged(&self, age: usize) -> &SVector<f64, D> {
        &self.forces[(self.newest + LENGTH - age) % LENGTH]
    }
}

/// A device whose position arrives a whole number of samples late.
///
/// ```text
/// position[n] = device position[n - d],    the first position for n < d
/// ```
/// - *Tick and time* of a reading are the present ones; only the position is old.
/// - *Use*: read at least once a tick. A second reading in a tick replaces the first.
/// - *Cost*: one copy in and one out; 65 positions of memory.
#[derive(Clone, Debug)]
pub struct MeasurementDelay<V, F, const D: usize> {
    device: V,
    samples: usize,
    /// The position of tick n at n mod [`LENGTH`]; `None` before the first reading.
    positions: Option<[SVector<F, D>; LENGTH]>,
}

impl<V: Device<F, D>, F: Real, const D: usize> MeasurementDelay<V, F, D> {
    /// Delays the positions of `device` by `samples` ticks.
    ///
    /// # Errors
    /// Unless `samples` ≤ [`MAX_DELAY_SAMPLES`].
    pub fn new(device: V, samples: usize) -> Result<Self, ParameterError> {
        if samples > MAX_DELAY_SAMPLES {
            return Err(RangeError::new(
                "measurement delay",
                samples as f64,
                "at most 64",
                "samples",
            )
            .into());
        }
        Ok(Self {
            device,
            samples,
            positions: None,
        })
    }

    /// The device inside.
    pub const fn device(&self) -> &V {
        &self.device
    }

    /// The device inside, to set its state or an external force.
    pub const fn device_mut(&mut self) -> &mut V {
        &mut self.device
    }
}

impl<V: Device<F, D>, F: Real, const D: usize> Device<F, D> for MeasurementDelay<V, F, D> {
    type Error = V::Error;

    fn read(&mut self) -> Result<Reading<F, D>, Self::Error> {
        let reading = self.device.read()?;
        let positions = self.positions.get_or_insert([reading.position_m; LENGTH]);
        #[expect(clippy::cast_possible_truncation, reason = "a remainder below 65")]
        let newest = (reading.tick % LENGTH as u64) as usize;
        positions[newest] = reading.position_m;
        // position[n] = device position[n - d]
        let position_m = positions[(newest + LENGTH - self.samples) % LENGTH];
        Ok(Reading {
            position_m,
            ..reading
        })
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Self::Error> {
        self.device.write(force)
    }

    fn let_go(&mut self) {
        self.device.let_go();
    }
}
