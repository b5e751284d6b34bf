//! The largest relative error between what came and what was wanted, or the reason why it has no meaning.

/// Fraction in per cent, without the digits that binary fractions add.
pub fn percent(fraction: f64) -> f64 {
    (fraction * 1e8).round() / 1e6
}

/// A wanted value below this share of the largest one counts as nothing: it is rounding there, and a
/// relative error has no meaning.
const NOTHING: f64 = 1e-9;

/// |have/want − 1|; NaN where it has no meaning, that is where nothing was wanted.
pub fn relative_error(have: f64, want: f64) -> f64 {
    if want == 0.0 {
        f64::NAN
    } else {
        (have - want).abs() / want.abs()
    }
}

/// The largest relative error of a stretch of samples, or the reason why it has no meaning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compared {
    /// The error; `None` where it has no meaning.
    pub largest: Option<f64>,
    /// Time of the first sample that was compared, s.
    pub from_s: Option<f64>,
    /// Time of the last one, s.
    pub to_s: Option<f64>,
    /// Number of samples that were compared.
    pub samples: u64,
    /// Why no error was computed; `None` if one was.
    pub reason: Option<String>,
}

/// A time without the digits that binary fractions add, s.
fn plain(time_s: f64) -> f64 {
    (time_s * 1e9).round() / 1e9
}

impl Compared {
    /// No error, for this reason.
    pub fn without_meaning(reason: impl Into<String>) -> Self {
        Self {
            reason: Some(reason.into()),
            ..Self::default()
        }
    }

    /// One error over `samples` samples, from the first to the last of these times, s.
    pub fn of_window(error: f64, [from_s, to_s]: [f64; 2], samples: u64) -> Self {
        if !error.is_finite() {
            return Self::without_meaning("a value is not finite");
        }
        Self {
            largest: Some(error),
            from_s: Some(plain(from_s)),
            to_s: Some(plain(to_s)),
            samples,
            reason: None,
        }
    }
}

/// The largest relative error from a given time on, sample by sample.
///
/// Samples where nothing was wanted and nothing came have no relative error and are passed over. If nothing was
/// wanted but something came, or nothing was wanted at all, the error has no meaning.
#[derive(Clone, Debug, Default)]
pub struct LargestError {
    from_s: f64,
    wanted: &'static str,
    unit: &'static str,
    /// Largest magnitude that was wanted so far, before `from_s` too.
    peak: f64,
    /// Time of the last sample, s.
    end_s: f64,
    found: Compared,
    /// Samples that were passed over.
    passed: u64,
    /// Why the error has no meaning, once a sample has shown it.
    spoilt: Option<String>,
    /// Largest difference, and the largest of both values.
    off: f64,
    most: f64,
}

impl LargestError {
    /// Error of no sample yet; those before `from_s` do not count. `wanted` and `unit`, with a space before it, are words
    /// for the wanted values, as in `the closed form` and ` N`.
    pub fn new(from_s: f64, wanted: &'static str, unit: &'static str) -> Self {
        Self {
            from_s,
            wanted,
            unit,
            ..Self::default()
        }
    }

    /// Passes over a sample that is not to be compared.
    pub fn pass(&mut self, time_s: f64) {
        self.end_s = time_s;
        self.passed += 1;
    }

    /// Takes the next sample: what came and what was wanted.
    pub fn add(&mut self, time_s: f64, have: f64, want: f64) {
        self.end_s = time_s;
        self.off = self.off.max((have - want).abs());
        self.most = self.most.max(have.abs()).max(want.abs());
        if want.is_finite() {
            self.peak = self.peak.max(want.abs());
        }
        // Half a nanosecond: times are multiples of T, rounded.
        if time_s < self.from_s - 0.5e-9 || self.spoilt.is_some() {
            return;
        }
        let nothing = NOTHING * self.peak;
        let wanted_nothing = want.abs() <= nothing;
        if wanted_nothing && have.abs() <= nothing {
            return;
        }
        if wanted_nothing || !(have - want).is_finite() {
            let Self { wanted, unit, .. } = self;
            let want = if wanted_nothing { 0.0 } else { want };
            self.spoilt = Some(format!(
                "at {} s {wanted} is {want}{unit} but {have:.1e}{unit} came, so a relative error has no meaning",
                plain(time_s)
            ));
            return;
        }
        let error = relative_error(have, want);
        let found = &mut self.found;
        found.largest = Some(found.largest.map_or(error, |most| most.max(error)));
        found.from_s = found.from_s.or(Some(plain(time_s)));
        found.to_s = Some(plain(time_s));
        found.samples += 1;
    }

    /// The largest difference as a share of the largest value, from the first sample on.
    pub fn off(&self) -> Option<f64> {
        (self.most > 0.0).then_some(self.off / self.most)
    }

    /// The error, or the reason why it has no meaning.
    pub fn get(self) -> Compared {
        let (from_s, end_s) = (plain(self.from_s), plain(self.end_s));
        let Self { wanted, unit, .. } = self;
        match self.spoilt {
            Some(reason) => Compared::without_meaning(reason),
            None if self.found.samples > 0 => self.found,
            None if end_s < from_s => Compared::without_meaning(format!(
                "the run ends at {end_s} s, the comparison begins at {from_s} s"
            )),
            None if self.passed > 0 => Compared::without_meaning(format!(
                "the safety chain limited the force wherever there was one from {from_s} s on"
            )),
            None => Compared::without_meaning(format!(
                "{wanted} is 0{unit} from {from_s} s on, so a relative error has no meaning"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIME: [f64; 4] = [0.0, 1.0, 2.0, 3.0];

    fn compared(have: [f64; 4], want: [f64; 4], from_s: f64) -> Compared {
        let mut largest = LargestError::new(from_s, "the closed form", " N");
        for (time_s, (have, want)) in TIME.into_iter().zip(have.into_iter().zip(want)) {
            largest.add(time_s, have, want);
        }
        largest.get()
    }

    fn reason(compared: Compared) -> String {
        assert_eq!((compared.largest, compared.samples), (None, 0));
        assert_eq!((compared.from_s, compared.to_s), (None, None));
        compared.reason.expect("a reason")
    }

    #[test]
    fn the_largest_error_is_looked_for_in_its_window_only() {
        let (have, want) = ([9.0, 1.0, 2.2, 3.0], [1.0, 1.0, 2.0, 3.0]);
        let found = compared(have, want, 1.0);
        let error = found.largest.expect("an error");
        assert!((error - 0.1).abs() < 1e-15, "{error}");
        assert_eq!((found.from_s, found.to_s), (Some(1.0), Some(3.0)));
        assert_eq!((found.samples, found.reason), (3, None));
        let mut limited = LargestError::new(1.0, "the closed form", " N");
        limited.add(0.0, 1.0, 1.0);
        limited.pass(1.0);
        let reason_of_none = reason(limited.clone().get());
        assert!(
            reason_of_none.contains("limited the force wherever"),
            "{reason_of_none}"
        );
        limited.add(2.0, 1.1, 1.0);
        assert_eq!(
            (limited.clone().get().samples, limited.get().from_s),
            (1, Some(2.0))
        );
        let late = reason(compared(have, want, 4.0));
        assert_eq!(late, "the run ends at 3 s, the comparison begins at 4 s");
    }

    #[test]
    fn an_error_without_meaning_is_none_with_its_reason() {
        assert!(relative_error(0.0, 0.0).is_nan() && relative_error(1.0, 0.0).is_nan());
        // Nothing wanted, nothing came: passed over.
        let ramp = compared([0.0, 1.0, 2.0, 0.0], [0.0, 1.0, 2.0, 0.0], 0.0);
        assert_eq!((ramp.largest, ramp.samples), (Some(0.0), 2));
        assert_eq!((ramp.from_s, ramp.to_s), (Some(1.0), Some(2.0)));
        // Rounding beside nothing is nothing.
        let hold = compared([0.0, 1.0, 1e-15, -0.0], [0.0, 1.0, 1e-17, 0.0], 2.0);
        assert!(reason(hold).starts_with("the closed form is 0 N from 2 s on"));
        let some = reason(compared([0.0, 1.0, 0.5, 0.0], [0.0, 1.0, 0.0, 0.0], 1.0));
        assert!(
            some.starts_with("at 2 s the closed form is 0 N but 5.0e-1 N came"),
            "{some}"
        );
        for odd in [f64::NAN, f64::INFINITY] {
            assert!(reason(compared([0.0, odd, 1.0, 1.0], [1.0; 4], 0.0)).starts_with("at 1 s"));
            assert!(reason(compared([0.0; 4], [0.0, odd, 1.0, 1.0], 1.0)).contains("no meaning"));
            assert!(reason(compared([0.0, odd, 0.0, 0.0], [0.0; 4], 0.0)).starts_with("at 1 s"));
        }
    }
}
