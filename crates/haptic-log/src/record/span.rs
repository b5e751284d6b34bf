//! A span of a log: `from_s ≤ t ≤ to_s`, each to a nanosecond, which is what the times of a log are stored to.

/// Times within this of each other are one, s: 0.3 may be logged as 0.300 000 000 000 000 04.
pub const SAME_TIME: f64 = 1e-9;

/// The samples between two times, both with it.
///
/// ```
/// use haptic_log::record::Span;
///
/// let span = Span { from_s: 2.0, ..Span::WHOLE };
/// assert!(span.holds(2.0) && !span.holds(1.999));
/// // A log that ends at 1 s has none of them.
/// assert!(span.check(Some((0.0, 1.0))).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Device time at which it begins, s; −∞ for the first sample.
    pub from_s: f64,
    /// Device time at which it ends, s; ∞ for the last sample.
    pub to_s: f64,
}

/// A span that a log does not have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpanError {
    /// It begins or ends where there are no samples, or ends before it begins.
    #[error(
        "`{key}` {time_s} s is not from {first_s} s to {last_s} s, where the samples are: change or omit `{key}`"
    )]
    Outside {
        /// The end that is wrong.
        key: &'static str,
        /// Value of that end, s.
        time_s: f64,
        /// The first time that it may be, s.
        first_s: f64,
        /// Time of the last sample, s.
        last_s: f64,
    },
    /// Its ends are among the samples, but none is between them.
    #[error("there is no sample in this span: change `from_s` or `to_s`")]
    Bare,
}

impl Span {
    /// All samples, whatever their times are.
    pub const WHOLE: Self = Self {
        from_s: f64::NEG_INFINITY,
        to_s: f64::INFINITY,
    };

    /// True if a sample at this time belongs to it.
    #[must_use]
    pub fn holds(&self, time_s: f64) -> bool {
        (self.from_s - SAME_TIME..=self.to_s + SAME_TIME).contains(&time_s)
    }

    /// Refuses a span that is not among the samples of a log, of which the first and the last are given.
    ///
    /// # Errors
    /// [`SpanError::Outside`], or [`SpanError::Bare`] of a log without samples.
    pub fn check(&self, samples: Option<(f64, f64)>) -> Result<(), SpanError> {
        let (begin_s, last_s) = samples.ok_or(SpanError::Bare)?;
        let from = ("from_s", self.from_s, begin_s);
        let to = ("to_s", self.to_s, begin_s.max(self.from_s));
        for (key, time_s, first_s) in [from, to] {
            let may_be = first_s - SAME_TIME..=last_s + SAME_TIME;
            if time_s.is_finite() && !may_be.contains(&time_s) {
                return Err(SpanError::Outside {
                    key,
                    time_s,
                    first_s,
                    last_s,
                });
            }
        }
        Ok(())
    }
}
