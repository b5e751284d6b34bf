//! A motion and the forces that made it.

/// Force applied and position read, tick by tick.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionRecord {
    /// T.
    pub sample_time_s: f64,
    /// Position at the start of each tick, m; not a number where the sample was lost.
    pub position_m: Vec<f64>,
    /// Force that the device applied from each tick on, N.
    pub force_n: Vec<f64>,
    /// Ticks at the beginning without any force.
    pub rest: usize,
    /// First tick of the multi-sine.
    pub driven_from: usize,
    /// Forces at which the device began to move, upwards and downwards, N.
    pub breakaway_n: Option<(f64, f64)>,
}

impl MotionRecord {
    /// A record of so many ticks to come.
    #[must_use]
    pub(super) fn with_capacity(sample_time_s: f64, ticks: usize) -> Self {
        Self {
            sample_time_s,
            position_m: Vec::with_capacity(ticks),
            force_n: Vec::with_capacity(ticks),
            rest: 0,
            driven_from: 0,
            breakaway_n: None,
        }
    }

    /// Ticks.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.position_m.len().min(self.force_n.len())
    }

    /// Samples that were lost.
    #[must_use]
    pub fn lost(&self) -> usize {
        self.position_m.iter().filter(|x| !x.is_finite()).count()
    }

    /// Appends a tick; for those that are missing before it the force goes on.
    pub(super) fn push(&mut self, missing: u64, position_m: f64, force_n: f64) {
        let last = self.force_n.last().copied().unwrap_or_default();
        for _ in 0..missing {
            self.position_m.push(f64::NAN);
            self.force_n.push(last);
        }
        self.position_m.push(position_m);
        self.force_n.push(force_n);
    }

    /// Largest force, N.
    #[must_use]
    pub fn largest_force_n(&self) -> f64 {
        self.force_n
            .iter()
            .fold(0.0, |most, f| f64::max(most, f.abs()))
    }

    /// Lowest and highest position about the first, m.
    #[must_use]
    pub fn reach_m(&self) -> (f64, f64) {
        let present = || self.position_m.iter().copied().filter(|x| x.is_finite());
        let start = present().next().unwrap_or_default();
        present().fold((0.0, 0.0), |(low, high), x| {
            (f64::min(low, x - start), f64::max(high, x - start))
        })
    }
}
