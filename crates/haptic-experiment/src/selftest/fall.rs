//! The way of a force to zero, as its samples show it.

use haptic_link::Sample;

/// Rounding of a force, relative.
const ROUNDING: f32 = 1e-6;

/// The fall of a force from some tick on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fall {
    /// Magnitude in the last sample before, N.
    pub(super) from_n: f32,
    /// True if no sample has a larger magnitude than the one before it.
    pub(super) never_grew: bool,
    /// Ticks until it was zero and stayed so; `None` if the samples do not show it.
    pub(super) ticks: Option<u32>,
}

impl Fall {
    /// Of these samples, from the first tick on that may not grow any more.
    pub(super) fn of(samples: &[Sample], first: u32) -> Self {
        let before = samples.iter().rev().find(|sample| sample.tick < first);
        let from_n = before.map_or(0.0, |sample| sample.force_n.abs());
        let mut fall = Self {
            from_n,
            never_grew: true,
            ticks: None,
        };
        let mut most = from_n * (1.0 + ROUNDING);
        for sample in samples.iter().filter(|sample| sample.tick >= first) {
            let force = sample.force_n.abs();
            // Written so that what is no number has grown.
            fall.never_grew &= force <= most;
            most = force * (1.0 + ROUNDING);
            fall.ticks = if force > 0.0 || force.is_nan() {
                None
            } else {
                fall.ticks.or(Some(sample.tick - first + 1))
            };
        }
        fall
    }

    /// True if the force never grew and was zero within this time.
    pub(super) fn is_within(self, stop_time_s: f32, period_s: f64) -> bool {
        // The first tick of the fall is one of it; what is lost on the line is seen one sample later.
        // A time in single precision is no whole number of ticks more.
        let most = (f64::from(stop_time_s) / period_s - 1e-4).ceil() + 1.0;
        self.never_grew && self.ticks.is_some_and(|ticks| f64::from(ticks) <= most)
    }

    /// In words.
    pub(super) fn words(self, period_s: f64) -> String {
        let Self { from_n, ticks, .. } = self;
        let grew = if self.never_grew { "" } else { ", but it grew" };
        match ticks {
            Some(ticks) => format!(
                "{from_n} N to zero in {:.3} s{grew}",
                f64::from(ticks) * period_s
            ),
            None => format!("{from_n} N did not fall to zero{grew}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(forces: &[f32]) -> Vec<Sample> {
        let numbered = forces.iter().zip(0..);
        numbered
            .map(|(&force_n, tick)| Sample {
                tick,
                force_n,
                ..Sample::default()
            })
            .collect()
    }

    #[test]
    fn a_fall_that_ends_in_time_is_kept_and_any_other_is_not() {
        let good = Fall::of(&samples(&[1.0, -1.0, 0.75, 0.5, 0.25, 0.0, 0.0]), 2);
        assert_eq!(
            (good.from_n, good.never_grew, good.ticks),
            (1.0, true, Some(4))
        );
        assert!(good.is_within(4e-3, 1e-3) && good.is_within(3e-3, 1e-3));
        assert!(!good.is_within(2e-3, 1e-3));
        for bad in [
            // It grows.
            &[1.0, 0.5, 0.6, 0.0][..],
            // It grows beyond what it was.
            &[1.0, 1.1, 0.0],
            // It comes back.
            &[1.0, 0.0, 0.1, 0.0],
            // It stays.
            &[1.0, 0.5, 0.5],
            // It is no number.
            &[1.0, f32::NAN, 0.0],
        ] {
            let fall = Fall::of(&samples(bad), 1);
            assert!(!fall.is_within(1.0, 1e-3), "{bad:?}: {fall:?}");
        }
    }
}
