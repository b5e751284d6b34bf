//! Looks on while a device is tried.

use super::criterion::{Criterion, Tolerance};
use super::verdict::{GONE_M, Settling, TrialVerdict};

/// Share of the force limit that counts as the limit: single precision on a device rounds it.
const AT_LIMIT: f64 = 1.0 - 1e-6;

/// Running mean and variance (B. P. Welford, *Technometrics* 4(3), 1962).
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let change = value - self.mean;
        self.mean += change / self.count;
        self.squares += change * (value - self.mean);
    }

    fn deviation(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Looks on while a device is tried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judge {
    criterion: Criterion,
    impact_m_per_s: f64,
    tolerance: Tolerance,
    /// Begin of the window, s.
    from_s: f64,
    force_limit_n: f64,
    samples: u64,
    limited: u64,
    position: Moments,
    force: Moments,
    /// Least and largest force in the window, N.
    force_ends_n: (f64, f64),
    gone: bool,
}

impl Judge {
    pub(crate) fn new(
        (criterion, impact_m_per_s): (Criterion, f64),
        tolerance: Tolerance,
        from_s: f64,
        force_limit_n: f64,
    ) -> Self {
        Self {
            criterion,
            impact_m_per_s,
            tolerance,
            from_s,
            force_limit_n,
            samples: 0,
            limited: 0,
            position: Moments::default(),
            force: Moments::default(),
            force_ends_n: (f64::INFINITY, f64::NEG_INFINITY),
            gone: false,
        }
    }

    /// One sample; `false` if the device has left, so that nothing more can come of it.
    pub(crate) fn see(&mut self, time_s: f64, position_m: f64, force_n: f64) -> bool {
        self.samples += 1;
        self.limited += u64::from(force_n.abs() >= AT_LIMIT * self.force_limit_n);
        self.gone |= position_m.is_nan() || position_m.abs() > GONE_M;
        if time_s >= self.from_s {
            self.position.add(position_m);
            self.force.add(force_n);
            let (least, most) = self.force_ends_n;
            self.force_ends_n = (least.min(force_n), most.max(force_n));
        }
        !self.gone
    }

    /// The judgement of a trial that reached its end, or did not.
    pub(crate) fn settling(&self, whole: bool, expected_deflection_m: Option<f64>) -> Settling {
        let seen = whole && !self.gone && self.position.count > 0.0;
        let share = self.limited as f64 / self.samples as f64;
        let deviations = seen.then(|| (self.position.deviation(), self.force.deviation()));
        let range = self.force_ends_n.1 - self.force_ends_n.0;
        let within = |have: f64, most: Option<f64>| most.is_none_or(|most| have <= most);
        let verdict = match deviations {
            _ if self.gone => TrialVerdict::Gone,
            None => TrialVerdict::Unfinished,
            Some(_) if !within(share, self.tolerance.limited) => TrialVerdict::Saturated,
            Some((position, force))
                if within(position, self.tolerance.position_std_m)
                    && within(force, self.tolerance.force_std_n)
                    && within(range, self.tolerance.force_range_n) =>
            {
                TrialVerdict::Stable
            }
            Some(_) => TrialVerdict::Unstable,
        };
        Settling {
            stable: verdict == TrialVerdict::Stable,
            verdict,
            criterion: self.criterion,
            impact_m_per_s: self.impact_m_per_s,
            position_std_m: deviations.map(|(position, _)| position),
            position_std_limit_m: self.tolerance.position_std_m,
            force_std_n: deviations.map(|(_, force)| force),
            force_std_limit_n: self.tolerance.force_std_n,
            force_range_n: seen.then_some(range),
            force_range_limit_n: self.tolerance.force_range_n,
            saturated_share: (self.samples > 0).then_some(share),
            deflection_m: seen.then_some(self.position.mean),
            expected_deflection_m,
        }
    }
}
