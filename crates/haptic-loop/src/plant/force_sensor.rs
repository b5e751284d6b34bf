//! A simulated force sensor between a hand and a device.

use super::noise::normal;
use crate::LoopParameterError;
use crate::units::{Newtons, Seconds};
use fracdiff::parameter::{not_negative, positive, range};
use rand_pcg::{Pcg32, rand_core::SeedableRng};

/// Range and flaws of a force sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceSensorConfig {
    /// R, the largest force that it shows either way, N, above 0.
    pub range: Newtons,
    /// σ, the standard deviation of its noise, N.
    pub noise: Newtons,
    /// τ, the time constant of its filter, s; 0 for none.
    pub lag: Seconds,
    /// f₀, the reading without a force, N, within the range.
    pub offset: Newtons,
    /// The seed of its noise, which no other sensor with this number shares: the same seed makes the same noise, bit for bit.
    pub seed: u64,
}

/// Turns a seed into one of a force sensor, so that its noise is not that of an encoder with the same seed.
const OWN: u64 = 0x5e_5e_d0_f0_7c_e5;

/// A force sensor with up to three axes: a lag, then offset and noise, then the ends of its range.
///
/// ```text
/// y[n] = y[n−1] + (1 − exp(−T/τ))·(F[n] − y[n−1])        reading = max(−R, min(R, f₀ + y + σ·g))
/// ```
/// g is independent, standard normal, one per axis and reading. *Start-up*: y = 0. *Cost* per axis: a normal number and some ten
/// operations; no allocation, no panic.
#[derive(Clone, Debug)]
pub struct ForceSensor {
    config: ForceSensorConfig,
    generator: Pcg32,
    /// 1 − exp(−T/τ).
    share: f64,
    lagged: [f64; 3],
}

impl ForceSensor {
    /// A sensor at rest, read once a sample time.
    ///
    /// # Errors
    /// A range that is not above 0; noise or lag below 0; an offset beyond the range; any that is not finite.
    pub fn new(
        config: ForceSensorConfig,
        sample_time: Seconds,
    ) -> Result<Self, LoopParameterError> {
        let most = positive("range of the force sensor", config.range.0, "N")?;
        not_negative("noise of the force sensor", config.noise.0, "N")?;
        not_negative("lag of the force sensor", config.lag.0, "s")?;
        let (offset, within) = (config.offset.0, config.offset.0.abs() < most);
        range(
            "offset of the force sensor",
            offset,
            within,
            "within its range",
            "N",
        )?;
        let mut sensor = Self {
            config,
            generator: Pcg32::seed_from_u64(config.seed ^ OWN),
            share: 1.0,
            lagged: [0.0; 3],
        };
        sensor.read_every(sample_time);
        Ok(sensor)
    }

    /// It is read at another sample time from now on.
    pub fn read_every(&mut self, sample_time: Seconds) {
        self.share = if self.config.lag.0 > 0.0 {
            -libm::expm1(-sample_time.0 / self.config.lag.0)
        } else {
            1.0
        };
    }

    /// Largest magnitude of a reading, N, at which the sensor saturates.
    #[must_use]
    pub const fn range(&self) -> Newtons {
        self.config.range
    }

    /// Turns the force on each axis, N, into the next reading. Axes beyond the third are not changed.
    pub fn read(&mut self, forces: &mut [f64]) {
        let most = self.config.range.0;
        for (axis, lagged) in forces.iter_mut().zip(&mut self.lagged) {
            *lagged += self.share * (*axis - *lagged);
            let noise = normal(&mut self.generator);
            let shown = self.config.offset.0 + *lagged + self.config.noise.0 * noise;
            *axis = shown.max(-most).min(most);
        }
    }
}
