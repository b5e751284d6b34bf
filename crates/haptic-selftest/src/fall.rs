//! The way of a force to zero, as its samples show it, and the bounds of the force during the test, by ticks.

use super::promise::Check;
use haptic_link::Limits;
use haptic_remote::Tick;

#[derive(Debug)]
pub(super) struct Bounds {
    pub(super) limits: Limits,
    pub(super) period_s: f64,
}

impl Bounds {
    /// Largest magnitude of a force, N, that was this large `ticks` ticks ago.
    pub(super) fn grown(&self, from_n: f32, ticks: u32) -> f32 {
        let step_n = f64::from(self.limits.force_rate_n_per_s) * self.period_s;
        let most_n = f64::from(from_n) + f64::from(ticks) * step_n;
        // A force that is beyond the limit already has not got there by this.
        from_n.max((most_n as f32).min(self.limits.force_n))
    }

    /// Largest magnitude of a braking force, N, `ticks` ticks after a fault or stop at which it was this large; 0 without braking.
    pub(super) fn braked(&self, from_n: f32, ticks: u32) -> f32 {
        if self.limits.braking_n_s_per_m <= 0.0 {
            return 0.0;
        }
        let left = 1.0 - f64::from(ticks) / f64::from(self.stop_ticks().max(1));
        (left.max(0.0) as f32) * from_n.max(self.limits.brake_force_n)
    }

    pub(super) const fn fall_in_words(&self) -> &'static str {
        if self.limits.braking_n_s_per_m > 0.0 {
            "growing only to brake, and less and less"
        } else {
            "never growing"
        }
    }

    /// Ticks after which the force that is asked for changes its sign: so many that its rate lets it reach its limit on the other side.
    pub(super) fn half_period_ticks(&self) -> u32 {
        let step_n = f64::from(self.limits.force_rate_n_per_s) * self.period_s;
        let reached = SWING * f64::from(self.limits.force_n) / step_n;
        HALF_PERIOD_TICKS.max(reached.ceil() as u32)
    }

    pub(super) fn stop_ticks(&self) -> u32 {
        // A time in single precision is no whole number of ticks more.
        (f64::from(self.limits.stop_time_s) / self.period_s - 1e-4).ceil() as u32
    }
}

/// Fewest ticks with one sign, and the way of a force, in limits, that is made in them: from one to the other, and half of it at rest.
const HALF_PERIOD_TICKS: u32 = 40;
const SWING: f64 = 3.0;
const ROUNDING: f32 = 1e-6;

#[derive(Clone, Copy, Debug)]
pub(super) struct Fall {
    /// Magnitude in the last sample before, N.
    pub(super) from_n: f32,
    /// True if no sample has a larger magnitude than the one before it, or than the braking may have by then.
    pub(super) never_grew: bool,
    /// Ticks until it was zero and stayed so; `None` if the samples do not show it.
    pub(super) ticks: Option<u32>,
}

impl Fall {
    /// Fall in these samples, from the first tick that may not grow on. Up to it the force may have grown where samples
    /// were lost, as fast as these bounds let it; from then on not, whatever was lost.
    pub(super) fn of(samples: &[Tick], first: u32, bounds: &Bounds) -> Self {
        let before = samples.iter().rfind(|sample| sample.tick < first);
        let from_n = before.map_or(0.0, |sample| sample.force_n[0].abs());
        let mut fall = Self {
            from_n,
            never_grew: true,
            ticks: None,
        };
        let lost = before.map_or(0, |before| first - 1 - before.tick);
        let mut most = bounds.grown(from_n, lost) * (1.0 + ROUNDING);
        let begun_n = most;
        for sample in samples.iter().filter(|sample| sample.tick >= first) {
            let force = sample.force_n[0].abs();
            // Written so that what is no number has grown.
            let braked = bounds.braked(begun_n, sample.tick - first);
            fall.never_grew &= force <= most.max(braked);
            most = force * (1.0 + ROUNDING);
            fall.ticks = if force > 0.0 || force.is_nan() {
                None
            } else {
                fall.ticks.or(Some(sample.tick - first + 1))
            };
        }
        fall
    }

    pub(super) fn is_within(self, bounds: &Bounds) -> bool {
        // The first tick of the fall is one of it; what is lost on the line is seen one sample later.
        let most = bounds.stop_ticks() + 1;
        self.never_grew && self.ticks.is_some_and(|ticks| ticks <= most)
    }

    /// The row with its figure, broken for certain if the force grew.
    pub(super) fn shown_by(self, check: Check, bounds: &Bounds) -> Check {
        let check = check.certain(!self.never_grew);
        match self.ticks {
            Some(ticks) => check.figure("time_to_zero_s", f64::from(ticks) * bounds.period_s),
            None => check,
        }
    }

    pub(super) fn words(self, bounds: &Bounds) -> String {
        let grew = if self.never_grew { "" } else { ", but it grew" };
        let time_s = self.ticks.map(|ticks| f64::from(ticks) * bounds.period_s);
        let in_time = time_s.map(|time_s| format!("to zero in {time_s:.3} s"));
        let fell = in_time.unwrap_or_else(|| "did not fall to zero".to_owned());
        format!("{} N {fell}{grew}", self.from_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(forces: &[f32]) -> Vec<Tick> {
        let numbered = forces.iter().zip(0..);
        numbered
            .map(|(&force_n, tick)| Tick {
                tick,
                force_n: [force_n],
                ..Tick::NONE
            })
            .collect()
    }

    /// 0.1 N, risen to in 10 ticks of 1 ms, and gone in 4.
    const BOUNDS: Bounds = Bounds {
        limits: Limits {
            force_n: 0.1,
            force_rate_n_per_s: 10.0,
            stop_time_s: 4e-3,
            ..Limits::DEFAULT
        },
        period_s: 1e-3,
    };

    /// The same bounds with another stop time, s.
    fn within(stop_time_s: f32) -> Bounds {
        let limits = Limits {
            stop_time_s,
            ..BOUNDS.limits
        };
        Bounds { limits, ..BOUNDS }
    }

    #[test]
    fn a_fall_that_ends_in_time_is_kept_and_any_other_is_not() {
        let good = Fall::of(
            &samples(&[1.0, -1.0, 0.75, 0.5, 0.25, 0.0, 0.0]),
            2,
            &BOUNDS,
        );
        assert_eq!(
            (good.from_n, good.never_grew, good.ticks),
            (1.0, true, Some(4))
        );
        assert!(good.is_within(&within(4e-3)) && good.is_within(&within(3e-3)));
        assert!(!good.is_within(&within(2e-3)));
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
            let fall = Fall::of(&samples(bad), 1, &within(1.0));
            assert!(!fall.is_within(&within(1.0)), "{bad:?}: {fall:?}");
        }
    }

    #[test]
    fn a_force_may_grow_to_brake_within_its_envelope() {
        let braking = |braking_n_s_per_m, brake_force_n| Bounds {
            limits: Limits {
                braking_n_s_per_m,
                brake_force_n,
                ..BOUNDS.limits
            },
            ..BOUNDS
        };
        let fall = |forces: &[f32], bounds: &Bounds| {
            Fall::of(&samples(forces), 1, bounds).is_within(bounds)
        };
        // From 80 mN within 4 ticks: a tick late 80, 60, 40, 20 mN.
        let grows = [0.08, 0.03, 0.055, -0.035, 0.0];
        assert!(fall(&grows, &braking(5.0, 0.0)));
        assert!(!fall(&grows, &BOUNDS), "without braking");
        let beyond = [0.08, 0.03, 0.065, -0.035, 0.0];
        assert!(!fall(&beyond, &braking(5.0, 0.0)));
        assert!(fall(&beyond, &braking(5.0, 0.1)), "with more brake force");
        let too_long = [0.08, 0.03, 0.055, -0.035, 0.02, 0.01, 0.0];
        assert!(!fall(&too_long, &braking(5.0, 0.0)));
    }

    /// A force that rises by 10 mN a tick up to tick 5 and falls by 10 mN a tick from tick 6 on, without these ticks.
    fn risen_and_fallen(lost: &[u32], spoil: impl Fn(u32, f32) -> f32) -> Vec<Tick> {
        let forces = [
            0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.05, 0.04, 0.03, 0.02, 0.01, 0.0,
        ];
        let mut samples = samples(&forces);
        for sample in &mut samples {
            sample.force_n = [spoil(sample.tick, sample.force_n[0])];
        }
        samples.retain(|sample| !lost.contains(&sample.tick));
        samples
    }

    #[test]
    fn a_force_may_have_grown_where_samples_before_the_stop_were_lost() {
        for lost in [
            &[][..],
            &[5],
            &[4, 5],
            &[3, 4, 5],
            &[4, 5, 6],
            &[4, 5, 7, 8],
            &[1, 3, 6],
        ] {
            let fall = Fall::of(&risen_and_fallen(lost, |_, force| force), 6, &within(0.1));
            assert!(fall.is_within(&within(0.1)), "without {lost:?}: {fall:?}");
        }
    }

    #[test]
    fn a_growth_after_the_stop_is_seen_whatever_was_lost() {
        for lost in [&[][..], &[5], &[4, 5], &[3, 4, 5]] {
            // One tick more than what was lost explains.
            let late = risen_and_fallen(lost, |tick, force| if tick == 6 { 0.07 } else { force });
            assert!(!Fall::of(&late, 6, &BOUNDS).never_grew, "without {lost:?}");
            // A loss after the stop explains nothing.
            let mut later = lost.to_vec();
            later.push(7);
            let comes_back = |tick, force| if tick == 8 { 0.055 } else { force };
            let later = risen_and_fallen(&later, comes_back);
            assert!(!Fall::of(&later, 6, &BOUNDS).never_grew, "without {lost:?}");
        }
        // However much was lost: never beyond the limit.
        let lost: Vec<u32> = (1..6).collect();
        let beyond = risen_and_fallen(&lost, |tick, force| if tick == 6 { 0.11 } else { force });
        let bounds = Bounds {
            limits: Limits {
                force_rate_n_per_s: 1e3,
                ..BOUNDS.limits
            },
            ..BOUNDS
        };
        assert!(!Fall::of(&beyond, 6, &bounds).never_grew);
    }
}
