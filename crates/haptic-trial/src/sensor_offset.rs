//! The force sensor of a device during a run: its offset, measured at the start without contact, and how far that moves.
//!
//! ```text
//! f₀ = Σ f[n]/N        n the first N samples in a row of a still handle in the air
//! d  = Σ f[n]/N − f₀   n the newest ones
//! ```
//! - *In the air*: the law wants no force, and the motor makes none. *Still*: the means of both halves of the N positions differ by less than
//!   0.1 mm, of whatever noise. A free handle that something leans on moves farther, unless friction holds it.
//! - *A device that holds its handle* from its first tick on is asked before, while it is idle.
//! - *Start-up*: until f₀ is known nothing is sensed. A run that touches before has no offset: its readings stay as they are, and its report
//!   says so.
//! - *Cost*: some ten additions per axis and sample; no allocation, no panic.

use haptic_message::{PerAxis, TickMessage};

/// N. At 1 kHz a tenth of a second.
pub const OFFSET_SAMPLES: u32 = 100;
/// Motion between the halves of a window up to which a handle is still, m.
const STILL_M: f64 = 1e-4;

/// Offset of a force sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum SensorOffset {
    /// Not known yet: the handle has not been still in the air for long enough.
    #[default]
    Measuring,
    /// Offset on each axis, N.
    Known([f64; 3]),
    /// The law wanted a force before it was known, after so many samples.
    Touched {
        /// Samples read before the law wanted that force.
        samples: u32,
    },
}

/// Offset of a force sensor over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tare {
    /// The offset, as far as it is known.
    pub offset: SensorOffset,
    /// Noise with which the offset was measured, on each axis, N.
    pub noise_n: [f64; 3],
    /// d, on each axis, N; `None` as long as the handle was not still in the air once more.
    pub drift_n: Option<[f64; 3]>,
    samples: u32,
    window: Window,
}

/// Samples in a row of a handle in the air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Window {
    samples: u32,
    sums_n: [f64; 3],
    squares: [f64; 3],
    /// Positions of the second half less those of the first.
    moved_m: [f64; 3],
}

impl Window {
    /// Mean and standard deviation of a whole window of a still handle; a whole window begins anew.
    fn add(&mut self, sensed_n: &PerAxis, position_m: &PerAxis) -> Option<[[f64; 3]; 2]> {
        let side = if self.samples < OFFSET_SAMPLES / 2 {
            -1.0
        } else {
            1.0
        };
        self.samples += 1;
        let sums = self.sums_n.iter_mut().zip(&mut self.squares);
        for ((sum, square), force_n) in sums.zip(sensed_n.iter()) {
            *sum += force_n;
            *square += force_n * force_n;
        }
        let moved = self.moved_m.iter_mut().zip(position_m.iter());
        moved.for_each(|(moved, place)| *moved += side * place);
        if self.samples < OFFSET_SAMPLES {
            return None;
        }
        let whole = core::mem::take(self);
        let count = f64::from(OFFSET_SAMPLES);
        let still = |moved: &f64| moved.abs() < STILL_M * 0.5 * count;
        let means = whole.sums_n.map(|sum| sum / count);
        let deviation =
            |n: usize| libm::sqrt((whole.squares[n] / count - means[n] * means[n]).max(0.0));
        (whole.moved_m.iter().all(still)).then(|| [means, [0, 1, 2].map(deviation)])
    }
}

impl Tare {
    /// Takes the offset off the reading of the next sample of a run, or learns it from that.
    pub fn take_off(&mut self, message: &mut TickMessage) {
        let Some(sensed_n) = message.sensed_force_n else {
            return;
        };
        let none = |forces: &PerAxis| forces.iter().all(|&axis| axis == 0.0);
        let touches = !none(&message.environment_force_n);
        if self.offset == SensorOffset::Measuring && touches {
            let samples = self.samples;
            self.offset = SensorOffset::Touched { samples };
        }
        self.samples = self.samples.saturating_add(1);
        if touches || !none(&message.applied_force_n) {
            self.window = Window::default();
        } else if sensed_n.iter().all(|axis| axis.is_finite()) {
            let whole = self.window.add(&sensed_n, &message.position_m);
            match (self.offset, whole) {
                (SensorOffset::Measuring, Some([means_n, noise_n])) => {
                    (self.offset, self.noise_n) = (SensorOffset::Known(means_n), noise_n);
                }
                (SensorOffset::Known(offset_n), Some([means_n, _])) => {
                    self.drift_n = Some([0, 1, 2].map(|axis| means_n[axis] - offset_n[axis]));
                }
                (SensorOffset::Touched { .. }, _) | (_, None) => {}
            }
        }
        message.sensed_force_n = self.less(sensed_n);
    }

    /// A reading less the offset; `None` until that is known.
    pub fn less(&self, sensed: PerAxis) -> Option<PerAxis> {
        match self.offset {
            SensorOffset::Measuring => None,
            SensorOffset::Known(offset) => {
                let axes = sensed.iter().zip(&offset);
                Some(axes.map(|(axis, offset)| axis - offset).collect())
            }
            SensorOffset::Touched { .. } => Some(sensed),
        }
    }

    /// The largest of the drifts beyond what the noise of two means explains, N.
    pub fn drifted_n(&self) -> Option<f64> {
        /// Deviations of the difference of two means.
        const BEYOND: f64 = 5.0;
        let by_noise = BEYOND * libm::sqrt(2.0 / f64::from(OFFSET_SAMPLES));
        let drifts = self.drift_n?.into_iter().zip(self.noise_n);
        let drifts = drifts.filter(|(drift, noise)| drift.abs() > by_noise * noise);
        (drifts.map(|one| one.0)).max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

impl From<SensorOffset> for Tare {
    fn from(offset: SensorOffset) -> Self {
        Self {
            offset,
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::sensor_offset::*;
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
            let mut sensor = Tare::default();
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
            let known = matches!(sensor.offset, SensorOffset::Known(_));
            prop_assert_eq!(known, touched >= OFFSET_SAMPLES);
        }
    }

    #[test]
    fn without_a_sensor_nothing_is_measured_and_a_failed_reading_is_no_part_of_the_offset() {
        let mut sensor = Tare::default();
        let mut blind = TickMessage::at_rest(2);
        sensor.take_off(&mut blind);
        assert_eq!((blind.sensed_force_n, sensor), (None, Tare::default()));
        for n in 0..=OFFSET_SAMPLES {
            let failed = n == 7;
            sensor.take_off(&mut message(
                [0.0; 2],
                [if failed { f64::NAN } else { 3.0 }; 2],
            ));
        }
        assert_eq!(sensor.offset, SensorOffset::Known([3.0, 3.0, 0.0]));
    }

    /// A handle that something pushes moves, one that a motor holds is pushed by it: neither shows the offset. Later windows show the drift.
    #[test]
    fn only_a_still_handle_without_force_is_tared_and_what_it_shows_later_is_the_drift() {
        let mut sensor = Tare::default();
        let mut see = |samples: u32, speed_m: f64, applied_n: f64, sensed_n: f64| {
            for n in 0..samples {
                let noise = if n.is_multiple_of(2) { 1e-3 } else { -1e-3 };
                sensor.take_off(&mut TickMessage {
                    applied_force_n: applied_n.into(),
                    position_m: (speed_m * f64::from(n)).into(),
                    sensed_force_n: Some((sensed_n + noise).into()),
                    ..TickMessage::at_rest(1)
                });
            }
            (sensor.offset, sensor.drift_n, sensor.drifted_n())
        };
        let measuring = (SensorOffset::Measuring, None, None);
        assert_eq!(see(300, 3e-6, 0.0, 0.8), measuring);
        assert_eq!(see(300, 0.0, -0.3, 0.8), measuring);
        let (offset, drift, _) = see(100, 0.0, 0.0, -0.5);
        assert!(
            matches!(offset, SensorOffset::Known([offset_n, ..]) if (offset_n + 0.5).abs() < 1e-12)
        );
        assert_eq!(drift, None);
        // Within the noise of two means there is no drift.
        let (_, drift, drifted) = see(100, 0.0, 0.0, -0.5004);
        assert!(drift.is_some() && drifted.is_none(), "{drift:?}");
        let (_, _, drifted) = see(100, 0.0, 0.0, -0.2);
        assert!(drifted.is_some_and(|drift_n| (drift_n - 0.3).abs() < 1e-12));
    }
}
