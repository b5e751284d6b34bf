//! A span of a log: `from_s ≤ t ≤ to_s`, each to a nanosecond, which is what the times of a log are stored to.

/// A bound within this of a sample means that sample, s: 0.3 may be logged as 0.300 000 000 000 000 04.
pub const SAME_TIME: f64 = 1e-9;

/// The samples between two times, both with it.
///
/// ```
/// use haptic_log::record::Span;
///
/// let span = Span::new(Some(2.0), None)?;
/// assert!(span.holds(2.0) && !span.holds(1.999));
/// // A log that ends at 1 s has none of them.
/// assert!(span.check(Some((0.0, 1.0))).is_err());
/// # Ok::<(), haptic_log::record::SpanError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    from_s: f64,
    to_s: f64,
}

/// A span that no log has.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpanError {
    /// It ends where it begins, or before.
    #[error("`from_s` {from_s} s is not before `to_s` {to_s} s: swap them, or omit one")]
    Empty {
        /// The begin that was given, s.
        from_s: f64,
        /// The end that was given, s.
        to_s: f64,
    },
    /// It begins or ends where the log has no samples.
    #[error(
        "`{key}` {time_s} s is not from {first_s} s to {last_s} s, where the samples are: change or omit `{key}`"
    )]
    Outside {
        /// The bound that is wrong.
        key: &'static str,
        /// Its value, s.
        time_s: f64,
        /// Time of the first sample, s.
        first_s: f64,
        /// Time of the last sample, s.
        last_s: f64,
    },
    /// Both ends are among the samples, or there are none, but no sample is between them.
    #[error("there is no sample in this span: change `from_s` or `to_s`")]
    Bare,
}

impl Span {
    /// All samples.
    pub const WHOLE: Self = Self {
        from_s: f64::NEG_INFINITY,
        to_s: f64::INFINITY,
    };

    /// From the first sample if there is no begin, to the last if there is no end.
    ///
    /// # Errors
    /// [`SpanError::Empty`] if it does not end after it begins.
    pub fn new(from_s: Option<f64>, to_s: Option<f64>) -> Result<Self, SpanError> {
        let from_s = from_s.unwrap_or(Self::WHOLE.from_s);
        let to_s = to_s.unwrap_or(Self::WHOLE.to_s);
        match from_s < to_s {
            true => Ok(Self { from_s, to_s }),
            false => Err(SpanError::Empty { from_s, to_s }),
        }
    }

    /// True if a sample at this time belongs to it.
    #[must_use]
    pub fn holds(&self, time_s: f64) -> bool {
        (self.from_s - SAME_TIME..=self.to_s + SAME_TIME).contains(&time_s)
    }

    /// Refuses a span that begins or ends outside the samples of a log, of which the first and the last are given.
    ///
    /// # Errors
    /// [`SpanError::Outside`], or [`SpanError::Bare`] of a log without samples.
    pub fn check(&self, samples: Option<(f64, f64)>) -> Result<(), SpanError> {
        let Some((first_s, last_s)) = samples else {
            return Err(SpanError::Bare);
        };
        let log = Self {
            from_s: first_s,
            to_s: last_s,
        };
        for (key, time_s) in [("from_s", self.from_s), ("to_s", self.to_s)] {
            if time_s.is_finite() && !log.holds(time_s) {
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
