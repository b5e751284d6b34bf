//! The force sensor of a device during a run: its offset, measured at the start without contact.
//!
//! ```text
//! f₀ = Σ f[n]/N        n the first N samples of the run, in all of which the law wants no force
//! ```
//! - *A device that holds its handle* from its first tick on is asked before, while it is idle.
//! - *Start-up*: until f₀ is known nothing is sensed. A run that touches before has no offset: its readings stay as they are, and its report
//!   says so.
//! - *Cost*: an addition or a subtraction per axis and sample; no allocation, no panic.

use haptic_log::record::{PerAxis, TickMessage};

/// N. At 1 kHz a tenth of a second.
pub(crate) const OFFSET_SAMPLES: u32 = 100;

/// Offset of a force sensor, and of how much of the run it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SensorOffset {
    /// Sum of this many readings, N.
    Measuring { sum: [f64; 3], samples: u32 },
    /// On each axis, N.
    Known([f64; 3]),
    /// The law wanted a force after so many samples.
    Touched { samples: u32 },
}

impl Default for SensorOffset {
    fn default() -> Self {
        Self::Measuring {
            sum: [0.0; 3],
            samples: 0,
        }
    }
}

impl SensorOffset {
    /// Takes the offset off the reading of the next sample of a run, or learns it from that.
    pub(crate) fn take_off(&mut self, message: &mut TickMessage) {
        let Some(sensed) = message.sensed_force_n else {
            return;
        };
        let touches = message.environment_force_n.iter().any(|&axis| axis != 0.0);
        if let Self::Measuring { sum, samples } = self {
            if touches {
                *self = Self::Touched { samples: *samples };
            } else if sensed.iter().all(|axis| axis.is_finite()) {
                (sum.iter_mut().zip(sensed.iter())).for_each(|(sum, axis)| *sum += axis);
                *samples += 1;
                if *samples == OFFSET_SAMPLES {
                    *self = Self::Known(sum.map(|sum| sum / f64::from(OFFSET_SAMPLES)));
                }
            }
        }
        message.sensed_force_n = self.less(sensed);
    }

    /// A reading less the offset; `None` until that is known.
    pub(crate) fn less(&self, sensed: PerAxis) -> Option<PerAxis> {
        match self {
            Self::Measuring { .. } => None,
            Self::Known(offset) => {
                let axes = sensed.iter().zip(offset);
                Some(axes.map(|(axis, offset)| axis - offset).collect())
            }
            Self::Touched { .. } => Some(sensed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn message(environment_n: [f64; 2], sensed_n: [f64; 2]) -> TickMessage {
        TickMessage {
            environment_force_n: PerAxis::new(&environment_n),
            sensed_force_n: Some(PerAxis::new(&sensed_n)),
            ..TickMessage::at_rest(2)
        }
    }

    proptest! {
        /// Whatever the offset and whenever the law first wants a force: it is taken off from the hundredth sample on, or nothing is.
        #[test]
        fn an_offset_is_that_of_a_hundred_samples_without_contact_or_none(
            offset in -30.0..30.0_f64, touched in 0_u32..300, force in 0.01..20.0_f64
        ) {
            let mut sensor = SensorOffset::default();
            // A noise whose mean over the hundred samples is 0.
            let noise = |n: u32| if n.is_multiple_of(2) { 0.01 } else { -0.01 };
            for n in 0..400 {
                let (wants, pressed) = if n >= touched { (-force, force) } else { (0.0, 0.0) };
                let shown = [offset + noise(n), 2.0 * offset + pressed + noise(n)];
                let mut tick = message([0.0, wants], shown);
                sensor.take_off(&mut tick);
                let want = match (touched >= OFFSET_SAMPLES, n) {
                    (true, ..99) => None,
                    (true, 99..) => Some([noise(n), pressed + noise(n)]),
                    (false, n) => (n >= touched).then_some(shown),
                };
                prop_assert_eq!(tick.sensed_force_n.is_some(), want.is_some(), "{}", n);
                for (have, want) in tick.sensed_force_n.iter().flat_map(|axes| axes.iter()).zip(want.iter().flatten()) {
                    // A hundred sums of numbers up to 60 are rounded to some 1e-14 each.
                    prop_assert!((have - want).abs() < 1e-11, "{} {}", have, want);
                }
            }
            let known = matches!(sensor, SensorOffset::Known(_));
            prop_assert_eq!(known, touched >= OFFSET_SAMPLES);
        }
    }

    #[test]
    fn without_a_sensor_nothing_is_measured_and_a_failed_reading_is_no_part_of_the_offset() {
        let mut sensor = SensorOffset::default();
        let mut blind = TickMessage::at_rest(2);
        sensor.take_off(&mut blind);
        assert_eq!(
            (blind.sensed_force_n, sensor),
            (None, SensorOffset::default())
        );
        for n in 0..=OFFSET_SAMPLES {
            let failed = n == 7;
            sensor.take_off(&mut message(
                [0.0; 2],
                [if failed { f64::NAN } else { 3.0 }; 2],
            ));
        }
        assert_eq!(sensor, SensorOffset::Known([3.0, 3.0, 0.0]));
    }
}
