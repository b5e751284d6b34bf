//! A run that began at a time known only within δ, and the numbers that this moves.
//!
//! ```text
//! moved  δ·|f'/f|      a value beside its theory f, by a beginning that is δ off; of an error the largest over its samples
//! told   moved ≤ N/10  the number N
//! ```
//! δ is what the clocks of two devices leave open: the bound of their alignment, and as much as the beginning by which the run was counted,
//! which had to be known while it went on, is off the one that all keep-alives give. The force by the full history depends on the motion of
//! one device alone, so δ does not move it.

use haptic_judge::compared::Compared;
use haptic_quantity::digits;
use haptic_run::Ran;

/// The largest share of a number by which it may be moved.
const SHARE: f64 = 0.1;

/// Theory along a run whose beginning may be uncertain.
#[derive(Clone, Debug)]
pub(crate) struct Beginning {
    /// δ, s; 0 for a run on one device.
    pub within_s: f64,
    /// The rate counts from here on, s.
    from_s: f64,
    before: Option<[f64; 2]>,
    last: f64,
    largest: f64,
    withheld: Vec<&'static str>,
}

impl Beginning {
    /// Beginning of a run whose errors are looked for from this time on, s.
    pub(crate) fn of(ran: &Ran, from_s: f64) -> Self {
        let start = ran.record.start;
        let within_s = match &ran.second {
            None => 0.0,
            Some(second) => second.within_s(start),
        };
        Self {
            within_s,
            from_s,
            before: None,
            last: 0.0,
            largest: 0.0,
            withheld: Vec::new(),
        }
    }

    /// Takes a sample of theory.
    pub(crate) fn add(&mut self, time_s: f64, theory: f64) {
        if let Some([before_s, before]) = self.before.replace([time_s, theory]) {
            let rate = (theory - before) / (time_s - before_s) / theory;
            self.last = rate.abs();
            if time_s >= self.from_s && rate.is_finite() {
                self.largest = self.largest.max(self.last);
            }
        }
    }

    /// An error of this name, without its numbers where the beginning moves it too far.
    pub(crate) fn error(&mut self, name: &'static str, error: Compared) -> Compared {
        match error.largest {
            Some(largest) if !self.tells(name, largest, self.largest) => {
                Compared::without_meaning(self.reason())
            }
            Some(_) | None => error,
        }
    }

    /// The last value over theory, if the beginning moves it little.
    pub(crate) fn ratio(&mut self, name: &'static str, ratio: Option<f64>) -> Option<f64> {
        ratio.filter(|ratio| self.tells(name, *ratio, self.last))
    }

    /// True if the beginning alone may have moved the last value so far from theory.
    pub(crate) fn explains(&self, ratio: f64) -> bool {
        self.within_s > 0.0 && (ratio - 1.0).abs() <= self.moved(self.last)
    }

    /// A sentence about the numbers that are missing.
    pub(crate) fn warning(&self) -> Option<String> {
        let names = self.withheld.join(", ");
        (!names.is_empty()).then(|| format!("{names}: not told, {}", self.reason()))
    }

    fn moved(&self, rate: f64) -> f64 {
        // A beginning that is known moves nothing, however fast theory changes.
        if self.within_s == 0.0 {
            0.0
        } else {
            self.within_s * rate
        }
    }

    fn tells(&mut self, name: &'static str, number: f64, rate: f64) -> bool {
        // Not-a-number, without a rate or a time, is withheld too.
        let tells = self.moved(rate) <= SHARE * number.abs();
        if !tells {
            self.withheld.push(name);
        }
        tells
    }

    fn reason(&self) -> String {
        let known = if self.within_s.is_finite() {
            format!(
                "the clocks of both devices tell within {} s when the drive began, which moves this by more than a tenth",
                digits(self.within_s, 2)
            )
        } else {
            "the clocks of both devices do not tell when the drive began".to_owned()
        };
        format!("{known}: use lines with less delay, or a longer run")
    }
}
