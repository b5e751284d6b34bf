//! Checks each sample of a run for what cannot be, for every device.

use crate::Impossible;
use haptic_link::{AXES_MAX, BatchItem, Limits, Sample, WorkspaceBox};
use haptic_loop::Limiters;

/// Share of its range from which on a force sensor is at the end of it: amplifiers end before converters do.
const END_OF_RANGE: f32 = 0.99;
/// Longest time in which a force sensor may show the same force to the last bit while the command changes, µs. A converter is never so
/// quiet.
const STILL_US: u32 = 500_000;
/// Share of its range by which the command has to change in that time. Eight bits have 13 steps in it.
const CHANGE_SHARE: f32 = 0.05;

/// A force sensor on one axis, since its reading last changed.
#[derive(Clone, Copy, Debug)]
struct Still {
    bits: u32,
    since: u32,
    least_n: f32,
    most_n: f32,
}

/// Force sensors of a device, watched during a run.
#[derive(Debug)]
struct Watched {
    /// Range, N; 0 without a sensor.
    most_n: f32,
    axes: [Option<Still>; AXES_MAX],
}

impl Watched {
    /// Saturated, or bit by bit the same for longer than [`STILL_US`] while the command changed by [`CHANGE_SHARE`] of the range.
    fn look(&mut self, sample: &Sample, period_us: u32) -> Result<(), Impossible> {
        let (tick, range_n) = (sample.tick, self.most_n);
        if range_n <= 0.0 {
            return Ok(());
        }
        for (n, (still, axis)) in self.axes.iter_mut().zip(&sample.axes).enumerate() {
            let force_n = sample.sensed_force_n.get(n).copied().unwrap_or(f32::NAN);
            if force_n.abs() >= END_OF_RANGE * range_n {
                let most_n = range_n;
                return Err(Impossible::Saturated {
                    tick,
                    force_n,
                    most_n,
                });
            }
            let fresh = Still {
                bits: force_n.to_bits(),
                since: tick,
                least_n: axis.force_n,
                most_n: axis.force_n,
            };
            let seen = still.get_or_insert(fresh);
            if seen.bits != fresh.bits {
                *seen = fresh;
            }
            seen.least_n = seen.least_n.min(axis.force_n);
            seen.most_n = seen.most_n.max(axis.force_n);
            let still_us = u64::from(tick.wrapping_sub(seen.since)) * u64::from(period_us);
            let (changed_n, most_n) = (seen.most_n - seen.least_n, CHANGE_SHARE * range_n);
            if still_us > u64::from(STILL_US) && changed_n > most_n {
                return Err(Impossible::Stuck {
                    tick,
                    force_n,
                    still_ms: (still_us / 1000) as u32,
                    changed_n,
                    most_n,
                });
            }
        }
        Ok(())
    }
}

/// Places that a device reports without a fault of its own, by the limits that it was given.
#[derive(Debug)]
struct Reach {
    /// Ends of each axis, m.
    ends_m: [[f32; 2]; AXES_MAX],
    /// Jump that is allowed beyond the speed, m; infinite without a limit.
    jump_m: f32,
    speed_m_per_s: f32,
}

impl Reach {
    const fn without_limits(far_m: f32) -> Self {
        Self {
            ends_m: [[-far_m, far_m]; AXES_MAX],
            jump_m: f32::INFINITY,
            speed_m_per_s: 0.0,
        }
    }

    fn of(limits: &Limits, workspace: Option<&WorkspaceBox>, far_m: f32) -> Self {
        let mut reach = Self::without_limits(far_m);
        if limits.workspace_low_m < limits.workspace_high_m {
            reach.ends_m = [[limits.workspace_low_m, limits.workspace_high_m]; AXES_MAX];
        }
        let axes = workspace.iter().flat_map(|workspace| &workspace.axes);
        for (ends_m, axis) in reach.ends_m.iter_mut().zip(axes) {
            *ends_m = [axis.low_m, axis.high_m];
        }
        // A device knows a jump by its speed limit alone.
        if limits.jump_m > 0.0 && limits.speed_hard_m_per_s > 0.0 {
            reach.jump_m = limits.jump_m;
            reach.speed_m_per_s = limits.speed_hard_m_per_s;
        }
        reach
    }

    fn look(
        &self,
        sample: &Sample,
        before: Option<&Before>,
        period_us: u32,
    ) -> Result<(), Impossible> {
        /// Rounding in single precision, of a sum of several steps.
        const ROUNDED: f32 = 1.0 + 1e-4;
        let tick = sample.tick;
        for (n, (axis, [low_m, high_m])) in sample.axes.iter().zip(self.ends_m).enumerate() {
            let position_m = axis.position_m;
            if position_m < low_m || position_m > high_m {
                return Err(Impossible::Outside {
                    tick,
                    position_m,
                    low_m,
                    high_m,
                });
            }
            let Some(before) = before else { continue };
            // In ticks that did not come, or that the device missed, it may have moved on; the time of a batch is off by a period.
            let ticks = tick.saturating_sub(before.tick);
            let passed_us = sample
                .time_us
                .wrapping_sub(before.time_us)
                .max(ticks.saturating_mul(period_us));
            let step_m = self.speed_m_per_s * 1e-6 * (passed_us.saturating_add(period_us)) as f32;
            let most_m = ROUNDED * (ticks.max(1) as f32 * self.jump_m + step_m);
            let moved_m = position_m - before.position_m[n];
            if moved_m.abs() > most_m {
                return Err(Impossible::Moved {
                    tick,
                    moved_m,
                    most_m,
                });
            }
        }
        Ok(())
    }
}

#[derive(Clone, Copy, Debug)]
struct Before {
    tick: u32,
    time_us: u32,
    position_m: [f32; AXES_MAX],
}

#[derive(Debug)]
pub(crate) struct Plausible {
    /// Largest force that the device makes, N.
    pub force_most_n: f32,
    /// T, µs. A batch carries the time of its first tick alone: that of another may be off by this.
    period_us: u32,
    before: Option<Before>,
    sensors: Watched,
    reach: Reach,
    /// It lets go since a fault or a stop, and looks at its places no more: what comes then is flagged only as long as a force falls.
    pub lets_go: bool,
    /// The farthest place without a workspace, m.
    far_m: f32,
}

impl Plausible {
    /// Bounds for a device with this largest force and this range of its force sensor, N; a plant that it simulates may run away.
    pub(crate) const fn of(force_most_n: f32, sensed_most_n: f32, simulates: bool) -> Self {
        let far_m = if simulates { 1e6 } else { Limits::PLACE_MOST_M };
        Self {
            force_most_n,
            period_us: 0,
            before: None,
            sensors: Watched {
                most_n: sensed_most_n,
                axes: [None; AXES_MAX],
            },
            reach: Reach::without_limits(far_m),
            lets_go: false,
            far_m,
        }
    }

    /// The limits that it has from now on.
    pub(crate) fn limit(&mut self, limits: &Limits, workspace: Option<&WorkspaceBox>) {
        self.reach = Reach::of(limits, workspace, self.far_m);
    }

    /// A run begins: its ticks count anew, at this period.
    pub(crate) const fn begin(&mut self, period_us: u32) {
        (self.period_us, self.before, self.lets_go) = (period_us, None, false);
        self.sensors.axes = [None; AXES_MAX];
    }

    pub(crate) fn look(&mut self, sample: &Sample) -> Result<(), Impossible> {
        /// A norm in single precision is rounded.
        const ROUNDED: f64 = 1.0 + 1e-5;
        let &Sample { tick, time_us, .. } = sample;
        let mut position_m = [0.0; AXES_MAX];
        for (place, axis) in position_m.iter_mut().zip(&sample.axes) {
            *place = axis.position_m;
        }
        let before = self.before.replace(Before {
            tick,
            time_us,
            position_m,
        });
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
        self.sensors.look(sample, self.period_us)?;
        if let Some(before) = before {
            if tick < before.tick {
                let before = before.tick;
                return Err(Impossible::Tick { tick, before });
            }
            // Both go round at 2³² µs.
            let back_us = before.time_us.wrapping_sub(time_us).cast_signed();
            if let Ok(back_us) = u32::try_from(back_us)
                && back_us > self.period_us
            {
                return Err(Impossible::Time { tick, back_us });
            }
        }
        let stops = |axis: &BatchItem| axis.limiters & Limiters::STOPPING.bits() != 0;
        self.lets_go |= sample.axes.iter().any(stops);
        if self.lets_go {
            return Ok(());
        }
        self.reach.look(sample, before.as_ref(), self.period_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString as _;

    /// What can be.
    const ITEM: BatchItem = BatchItem {
        position_m: 1e-3,
        environment_force_n: 0.0,
        force_n: -5.0,
        limiters: 0,
        flaws: 0,
    };

    fn sample_at(tick: u32, time_us: u32, item: BatchItem) -> Sample {
        Sample {
            tick,
            time_us,
            axes: [item].into_iter().collect(),
            ..Sample::default()
        }
    }

    fn sample(tick: u32, time_us: u32) -> Sample {
        sample_at(tick, time_us, ITEM)
    }

    #[test]
    fn what_can_be_passes_the_end_of_the_clock_and_rounded_norms_too() {
        let mut plausible = Plausible::of(5.0, 0.0, false);
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
            let mut plausible = Plausible::of(5.0, 0.0, false);
            plausible.begin(1000);
            plausible.look(&sample(9, 9000)).expect("can be");
            plausible.look(&bad).expect_err("cannot be")
        };
        for position_m in [f32::NAN, f32::INFINITY] {
            let bad = BatchItem { position_m, ..ITEM };
            let message = look(sample_at(10, 10_000, bad)).to_string();
            assert!(message.contains(&position_m.to_string()), "{message}");
        }
        for force_n in [f32::NAN, f32::NEG_INFINITY, 5.001, -1e30] {
            let bad = BatchItem { force_n, ..ITEM };
            let found = look(sample_at(10, 10_000, bad));
            assert!(
                matches!(found, Impossible::Force { tick: 10, .. }),
                "{found}"
            );
            let message = found.to_string();
            assert!(message.contains(&force_n.to_string()), "{message}");
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

    /// Rows of: the tick and place, m, after a first at 0, and what of it cannot be.
    #[test]
    fn a_place_beyond_the_limits_needs_a_fault_of_the_device() {
        let limits = Limits {
            workspace_low_m: -0.01,
            workspace_high_m: 0.02,
            speed_hard_m_per_s: 1.5,
            jump_m: 1e-3,
            ..Limits::bare(5.0, 1e3)
        };
        let none = Limits::bare(5.0, 1e3);
        for (limits, simulates, tick, position_m, limiters, what) in [
            (limits, false, 1, 0.0039, 0, ""),
            (limits, false, 1, 0.0041, 0, "moved"),
            (limits, false, 3, 0.0089, 0, ""),
            (limits, false, 3, -0.0091, 0, "moved"),
            (limits, false, 9, 0.02, 0, ""),
            (limits, false, 9, 0.02_f32.next_up(), 0, "outside"),
            (limits, false, 9, -0.011, 0, "outside"),
            (limits, false, 9, -0.011, Limiters::STOPPING.bits(), ""),
            (none, false, 1, 100.0, 0, ""),
            (none, false, 1, 101.0, 0, "outside"),
            (none, true, 1, 1e5, 0, ""),
            (none, true, 1, -1e30, 0, "outside"),
        ] {
            let mut plausible = Plausible::of(5.0, 0.0, simulates);
            plausible.limit(&limits, None);
            plausible.begin(1000);
            let still = BatchItem {
                position_m: 0.0,
                ..ITEM
            };
            plausible.look(&sample_at(0, 0, still)).expect("can be");
            let item = BatchItem {
                position_m,
                limiters,
                ..ITEM
            };
            let found = plausible.look(&sample_at(tick, 1000 * tick, item));
            let found = match found {
                Ok(()) => "",
                Err(Impossible::Outside { .. }) => "outside",
                Err(Impossible::Moved { .. }) => "moved",
                Err(other) => panic!("{other}"),
            };
            assert_eq!(found, what, "{position_m} m in tick {tick}");
        }
    }

    /// Looks at a run of 1 ms ticks with a sensor of 20 N until one cannot be, or for 3 s.
    fn run(
        sensed: impl Fn(u32) -> Option<f32>,
        command: impl Fn(u32) -> f32,
    ) -> Option<Impossible> {
        let mut plausible = Plausible::of(50.0, 20.0, false);
        plausible.begin(1000);
        (0..3000).find_map(|tick| {
            let force_n = command(tick);
            let mut sample = sample_at(tick, 1000 * tick, BatchItem { force_n, ..ITEM });
            sample.sensed_force_n.extend(sensed(tick));
            plausible.look(&sample).err()
        })
    }

    fn wave(tick: u32) -> f32 {
        (f64::from(tick) * 0.01).sin() as f32
    }

    proptest::proptest! {
        #[test]
        fn a_sensor_that_sticks_or_is_saturated_ends_a_run_in_time_and_no_other(
            stuck in 0_u32..2000, amplitude_n in 0.51_f32..15.0, offset_n in -4.0_f32..4.0, silent: bool
        ) {
            // A millinewton of a converter is the whole noise.
            let live = |tick: u32| offset_n + amplitude_n * wave(tick) + 1e-3 * (tick % 2) as f32;
            let command = |tick: u32| -amplitude_n * wave(tick);
            assert_eq!(run(|tick| Some(live(tick)), command), None);
            // One that rests while nothing is asked of it, and one whose command moves less than it resolves.
            assert_eq!(run(|_| Some(offset_n), |_| -3.0), None);
            assert_eq!(run(|_| Some(offset_n), |tick| 0.49 * wave(tick)), None);
            let sticks = |tick: u32| if tick < stuck { Some(live(tick)) } else { (!silent).then(|| live(stuck)) };
            let found = run(sticks, command).expect("is stuck");
            assert!(matches!(found, Impossible::Stuck { .. }), "{found}");
            // It tells when the time is over and the command has swung far enough, which takes a period at most.
            let late = found.tick() - stuck;
            assert!((500..=500 + 629).contains(&late), "{late}");
            let beyond = |tick: u32| Some(if tick < stuck { live(tick) } else { 19.8_f32.copysign(offset_n) });
            let found = run(beyond, command).expect("is saturated");
            assert!(matches!(found, Impossible::Saturated { tick, .. } if tick == stuck), "{found}");
            let words = crate::LinkError::Impossible(found).to_string();
            assert!(words.contains("±20 N") && words.ends_with(found.remedy()), "{words}");
        }
    }
}
