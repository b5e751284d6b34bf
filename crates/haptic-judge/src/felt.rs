//! Numbers of what a hand felt: how often and how long the wall was touched, with what force, how deep and how fast.
//!
//! ```text
//! contact   a tick with the handle behind the surface        dwell      their time
//! force     |f| in contact: largest, mean, rms               deepest    the largest depth
//! speed     the way of the handle over the time, from places 10 ms apart, so that noise is no motion
//! ```
//! A [`Certificate`] has how much of that was the law that was asked for.

use fracdiff::Seconds;
use serde::Serialize;

/// Time between two places from which a speed is computed, s.
const APART_S: f64 = 0.01;

/// A summary of a run in a hand or of a stimulus, as far as it was felt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FeltSummary {
    /// The first tick in the log, and its time, s.
    pub tick: u64,
    /// See `tick`.
    pub time_s: f64,
    /// Time from the first tick to the last, s.
    pub duration_s: f64,
    /// Number of times that the handle went behind the surface, or was there at the start.
    pub contacts: u64,
    /// Time behind the surface, s, over all contacts.
    pub dwell_s: f64,
    /// Largest force, N; null without contact, as mean and rms.
    pub peak_force_n: Option<f64>,
    /// Mean over the contact, N.
    pub mean_force_n: Option<f64>,
    /// Root of the mean square over the contact, N.
    pub rms_force_n: Option<f64>,
    /// Largest depth behind the surface, m; 0 without contact.
    pub deepest_m: f64,
    /// Mean speed of the handle, m/s.
    pub speed_m_per_s: f64,
}

/// Sums over the ticks in which something was felt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Number of the stimulus whose ticks count; 0 where nobody counts them.
    pub stimulus: u64,
    /// Place of the surface, m.
    surface_m: f64,
    /// Ticks that count at most.
    most: u64,
    sample_time_s: f64,
    first: (u64, f64),
    /// Number of ticks that were counted, in contact or not.
    pub ticks: u64,
    inside: u64,
    was_inside: bool,
    contacts: u64,
    peak_n: f64,
    sum_n: f64,
    squares: f64,
    deepest_m: f64,
    from_m: f64,
    way_m: f64,
}

impl Tally {
    /// Tally of the stimulus of this number behind this surface, m, over so many ticks at most.
    #[must_use]
    pub fn of(stimulus: u64, surface_m: f64, most: Option<u64>, t: Seconds) -> Self {
        Self {
            stimulus,
            surface_m,
            most: most.unwrap_or(u64::MAX),
            sample_time_s: t.0,
            ..Self::default()
        }
    }

    /// Takes a tick of a stimulus: its number and time, s, the place of the handle, m, and the force, N.
    pub fn see(&mut self, stimulus: u64, at: (u64, f64), place_m: f64, force_n: f64) {
        if stimulus != self.stimulus || self.ticks >= self.most {
            return;
        }
        if self.ticks == 0 {
            self.first = at;
            self.from_m = place_m;
        }
        let apart = (APART_S / self.sample_time_s).round().max(1.0) as u64;
        if self.ticks.is_multiple_of(apart) {
            self.way_m += (place_m - self.from_m).abs();
            self.from_m = place_m;
        }
        self.ticks += 1;
        let depth_m = place_m - self.surface_m;
        let is_inside = depth_m > 0.0;
        if is_inside {
            let force_n = force_n.abs();
            self.contacts += u64::from(!self.was_inside);
            self.inside += 1;
            self.peak_n = self.peak_n.max(force_n);
            self.sum_n += force_n;
            self.squares += force_n * force_n;
            self.deepest_m = self.deepest_m.max(depth_m);
        }
        self.was_inside = is_inside;
    }

    /// The numbers over all ticks that were seen so far.
    #[must_use]
    pub fn summary(&self) -> FeltSummary {
        let inside = self.inside as f64;
        let touched = |force_n: f64| (self.inside > 0).then_some(force_n);
        let duration_s = self.ticks as f64 * self.sample_time_s;
        FeltSummary {
            tick: self.first.0,
            time_s: self.first.1,
            duration_s,
            contacts: self.contacts,
            dwell_s: inside * self.sample_time_s,
            peak_force_n: touched(self.peak_n),
            mean_force_n: touched(self.sum_n / inside),
            rms_force_n: touched((self.squares / inside).sqrt()),
            deepest_m: self.deepest_m,
            speed_m_per_s: self.way_m / duration_s.max(self.sample_time_s),
        }
    }
}

/// Largest difference from the law's force that does not count, N.
const EXACT_N: f64 = 1e-8;

/// Forces of a tick on their way to the device, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces {
    /// Force of the law that was asked for, alone.
    pub asked_n: f64,
    /// Force after the law that was felt before fades into it.
    pub mixed_n: f64,
    /// Force after the energy of the touch reduced it.
    pub reduced_n: f64,
    /// Force that was sent, after all limits.
    pub sent_n: f64,
}

/// Proof of a stimulus: how much of it was the law that was asked for. Ticks without a force, asked or sent, do not count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// Share of the ticks whose force was the law's to 1e-8 N; null without a force.
    pub exact_share: Option<f64>,
    /// Ticks whose force another law had a part in.
    pub fade_ticks: u64,
    /// Ticks whose force the energy of the touch reduced.
    pub energy_ticks: u64,
    /// Ticks whose force a limit of the safety chain changed.
    pub limit_ticks: u64,
    /// The least factor by which the energy of the touch reduced the force; 1 if it did not.
    pub least_factor: f64,
    /// The largest change of the force from one tick to the next that the law did not make, N.
    pub largest_step_n: f64,
}

/// A [`Certificate`] that is being made.
#[derive(Clone, Copy, Debug)]
pub struct Certifying {
    ticks: u64,
    exact: u64,
    beside_n: Option<f64>,
    so_far: Certificate,
}

impl Default for Certifying {
    fn default() -> Self {
        Self {
            ticks: 0,
            exact: 0,
            beside_n: None,
            so_far: Certificate {
                exact_share: None,
                fade_ticks: 0,
                energy_ticks: 0,
                limit_ticks: 0,
                least_factor: 1.0,
                largest_step_n: 0.0,
            },
        }
    }
}

impl Certifying {
    /// Takes the forces of a tick.
    pub fn see(&mut self, forces: &Forces) {
        let &Forces {
            asked_n,
            mixed_n,
            reduced_n,
            sent_n,
        } = forces;
        let beside_n = sent_n - asked_n;
        let so_far = &mut self.so_far;
        if let Some(before_n) = self.beside_n.replace(beside_n) {
            so_far.largest_step_n = so_far.largest_step_n.max((beside_n - before_n).abs());
        }
        if asked_n == 0.0 && sent_n == 0.0 {
            return;
        }
        let differ = |one_n: f64, other_n: f64| u64::from((one_n - other_n).abs() > EXACT_N);
        self.ticks += 1;
        self.exact += 1 - differ(sent_n, asked_n);
        so_far.fade_ticks += differ(mixed_n, asked_n);
        so_far.limit_ticks += differ(sent_n, reduced_n);
        if differ(reduced_n, mixed_n) > 0 {
            so_far.energy_ticks += 1;
            so_far.least_factor = so_far.least_factor.min(reduced_n / mixed_n);
        }
    }

    /// The certificate of all ticks that were seen so far.
    #[must_use]
    pub fn certificate(&self) -> Certificate {
        Certificate {
            exact_share: (self.ticks > 0).then(|| self.exact as f64 / self.ticks as f64),
            ..self.so_far
        }
    }
}
