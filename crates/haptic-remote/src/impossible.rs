//! Impossible samples of a device: one check of each sample of a run, for every device.

#[cfg(feature = "std")]
use haptic_link::Sample;
use thiserror::Error;

/// A sample that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Impossible {
    /// A position that is not a finite number.
    #[error("a position of {position_m} m in tick {tick}")]
    Position {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// The reported position, m.
        position_m: f32,
    },
    /// A force that is not a finite number, or beyond the largest that the device makes.
    #[error("a force of {force_n} N in tick {tick}, of at most {most_n} N")]
    Force {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// On the axis of the largest, N.
        force_n: f32,
        /// The largest that it makes, N.
        most_n: f32,
    },
    /// A tick before the one that came before it.
    #[error("tick {tick} after tick {before}")]
    Tick {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// That of the sample before.
        before: u32,
    },
    /// A time before that of the tick before it.
    #[error("a time in tick {tick} that is {back_us} µs before that of the tick before")]
    Time {
        /// Number of the tick that it is said to be of.
        tick: u32,
        /// Time by which it goes back, µs.
        back_us: u32,
    },
}

impl Impossible {
    /// The tick of the sample.
    #[must_use]
    pub const fn tick(self) -> u32 {
        match self {
            Self::Position { tick, .. }
            | Self::Force { tick, .. }
            | Self::Tick { tick, .. }
            | Self::Time { tick, .. } => tick,
        }
    }
}

#[cfg(feature = "std")]
#[derive(Debug)]
pub(crate) struct Plausible {
    /// Largest force that the device makes, N.
    pub(crate) force_most_n: f32,
    /// T, µs. A batch carries the time of its first tick alone: that of another may be off by this.
    period_us: u32,
    /// Tick and time of the sample before, µs.
    before: Option<(u32, u32)>,
}

#[cfg(feature = "std")]
impl Plausible {
    pub(crate) const fn of(force_most_n: f32) -> Self {
        Self {
            force_most_n,
            period_us: 0,
            before: None,
        }
    }

    /// A run begins: its ticks count anew, at this period.
    pub(crate) const fn begin(&mut self, period_us: u32) {
        (self.period_us, self.before) = (period_us, None);
    }

    pub(crate) fn look(&mut self, sample: &Sample) -> Result<(), Impossible> {
        /// A norm in single precision is rounded.
        const ROUNDED: f64 = 1.0 + 1e-5;
        let &Sample { tick, time_us, .. } = sample;
        let before = self.before.replace((tick, time_us));
        if let Some(axis) = (sample.axes.iter()).find(|axis| !axis.position_m.is_finite()) {
            let position_m = axis.position_m;
            return Err(Impossible::Position { tick, position_m });
        }
        let most_n = self.force_most_n;
        let sizes = sample.axes.iter().map(|axis| f64::from(axis.force_n));
        let squares = sizes.map(|force_n| force_n * force_n).sum::<f64>();
        let within = squares <= ROUNDED * f64::from(most_n) * f64::from(most_n);
        if !within {
            let larger = |a: f32, b: f32| if b.abs() < a.abs() { a } else { b };
            let forces = sample.axes.iter().map(|axis| axis.force_n);
            return Err(Impossible::Force {
                tick,
                force_n: forces.fold(0.0, larger),
                most_n,
            });
        }
        match before {
            Some((before, _)) if tick < before => Err(Impossible::Tick { tick, before }),
            Some((_, before_us)) => {
                // Both go round at 2³² µs.
                let back_us = before_us.wrapping_sub(time_us).cast_signed();
                match u32::try_from(back_us) {
                    Ok(back_us) if back_us > self.period_us => {
                        Err(Impossible::Time { tick, back_us })
                    }
                    _ => Ok(()),
                }
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_link::BatchItem;
    use std::string::ToString as _;

    /// What can be.
    const ITEM: BatchItem = BatchItem {
        position_m: 1e-3,
        environment_force_n: 0.0,
        force_n: -5.0,
        limiters: 0,
        flaws: 0,
    };

    fn of(tick: u32, time_us: u32, item: BatchItem) -> Sample {
        Sample {
            tick,
            time_us,
            axes: [item].into_iter().collect(),
        }
    }

    fn sample(tick: u32, time_us: u32) -> Sample {
        of(tick, time_us, ITEM)
    }

    #[test]
    fn what_can_be_passes_the_end_of_the_clock_and_rounded_norms_too() {
        let mut plausible = Plausible::of(5.0);
        let near_the_end = u32::MAX - 1500;
        for n in 0..5 {
            let time_us = near_the_end.wrapping_add(1000 * n);
            assert_eq!(plausible.look(&sample(3 * n, time_us)), Ok(()));
        }
        // The same once more is a sample that is looked at again.
        assert_eq!(
            plausible.look(&sample(12, near_the_end.wrapping_add(4000))),
            Ok(())
        );
        plausible.begin(1000);
        assert_eq!(plausible.look(&sample(0, 7)), Ok(()));
        let mut both = sample(1, 1007);
        both.axes[0].force_n = 3.000_001;
        both.axes.push(both.axes[0]).expect("room");
        both.axes[1].force_n = 4.0;
        assert_eq!(plausible.look(&both), Ok(()));
    }

    #[test]
    fn what_cannot_be_is_named() {
        let look = |bad: Sample| {
            let mut plausible = Plausible::of(5.0);
            plausible.begin(1000);
            plausible.look(&sample(9, 9000)).expect("can be");
            plausible.look(&bad).expect_err("cannot be")
        };
        for position_m in [f32::NAN, f32::INFINITY] {
            let bad = BatchItem { position_m, ..ITEM };
            let said = look(of(10, 10_000, bad)).to_string();
            assert!(said.contains(&position_m.to_string()), "{said}");
        }
        for force_n in [f32::NAN, f32::NEG_INFINITY, 5.001, -1e30] {
            let bad = BatchItem { force_n, ..ITEM };
            let found = look(of(10, 10_000, bad));
            assert!(
                matches!(found, Impossible::Force { tick: 10, .. }),
                "{found}"
            );
            let said = found.to_string();
            assert!(said.contains(&force_n.to_string()), "{said}");
        }
        assert_eq!(
            look(sample(8, 10_000)),
            Impossible::Tick { tick: 8, before: 9 }
        );
        let back_us = 1001;
        assert_eq!(
            look(sample(10, 7999)),
            Impossible::Time { tick: 10, back_us }
        );
    }
}
