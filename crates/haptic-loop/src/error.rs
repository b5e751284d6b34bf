//! Parameters outside their documented range.

use fracdiff::Real;
use fracdiff::parameter::{self, RangeError, Shown};
use thiserror::Error;

/// A parameter outside its documented range: name, rejected value, allowed range, unit.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LoopParameterError {
    /// A quantity outside the range that its field states.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// More braking than the device bears, see [`SafetyLimits::braking_max`](crate::SafetyLimits::braking_max).
    #[error(
        "braking {value} N·s/m must be at most {most} N·s/m, {why}",
        value = Shown(*value_n_s_per_m), most = Shown(*most_n_s_per_m), why = less_braking(*mass_known)
    )]
    Braking {
        /// Damping that was asked for, N·s/m.
        value_n_s_per_m: f64,
        /// The most that is accepted, N·s/m.
        most_n_s_per_m: f64,
        /// It follows from the mass of the device.
        mass_known: bool,
    },
    /// A size that a loading needs.
    #[error("loading {loading} needs {what}")]
    Missing {
        /// Name of the size, as in `area`.
        what: &'static str,
        /// Name of the kind of loading, as in `punch`.
        loading: &'static str,
    },
    /// A size that a loading does not have.
    #[error("{what} has no effect on loading {loading}")]
    NoEffect {
        /// Name of the size, as in `area`.
        what: &'static str,
        /// Name of the kind of loading, as in `punch`.
        loading: &'static str,
    },
    /// A layer under an indenter whose force is known on a deep body only.
    #[error(
        "a layer under a {loading} resists more than a deep body, and no formula for it is implemented (3.6 times where a bonded layer is as thick as a punch's radius: W. C. Hayes and others, 1972): press with a sphere, or on a body deeper than ten radii"
    )]
    Layer {
        /// Name of the size, as in `thickness`.
        what: &'static str,
        /// Name of the kind of loading, as in `punch`.
        loading: &'static str,
    },
    /// A parameter of the operator.
    #[error(transparent)]
    Operator(#[from] fracdiff::ParameterError),
}

const fn less_braking(mass_known: bool) -> &'static str {
    if mass_known {
        "half of what mass, delay and sample time bear: use less braking or a shorter sample time"
    } else {
        "the most for a device of unknown mass: give its mass, or use less braking"
    }
}

/// The checks of a constructor with many parameters, one after another: the first that fails is kept, and returned at the end.
///
/// Each way out in between would copy the error, on a microcontroller some 40 B of flash. What is computed meanwhile from
/// a refused value is thrown away.
#[derive(Debug, Default)]
pub(crate) struct Checks {
    first: Option<LoopParameterError>,
}

impl Checks {
    #[inline(never)]
    pub(crate) fn refuse(&mut self, error: LoopParameterError) {
        self.first.get_or_insert(error);
    }

    /// A finite value that the caller has found to be in its range.
    #[inline(never)]
    pub(crate) fn range(
        &mut self,
        what: &'static str,
        value: f64,
        accepted: bool,
        allowed: &'static str,
        unit: &'static str,
    ) -> f64 {
        if let Err(error) = parameter::range(what, value, accepted, allowed, unit) {
            self.refuse(error.into());
        }
        value
    }

    #[inline(never)]
    pub(crate) fn positive(&mut self, what: &'static str, value: f64, unit: &'static str) -> f64 {
        self.range(what, value, value > 0.0, "above 0 {}", unit)
    }

    #[inline(never)]
    pub(crate) fn not_negative(
        &mut self,
        what: &'static str,
        value: f64,
        unit: &'static str,
    ) -> f64 {
        self.range(what, value, value >= 0.0, "at least 0 {}", unit)
    }

    /// A value rounded to the loop's precision, in which it neither overflows nor vanishes.
    #[inline(never)]
    pub(crate) fn rounded<F: Real>(
        &mut self,
        what: &'static str,
        value: f64,
        unit: &'static str,
    ) -> F {
        let rounded = F::from_f64(value);
        let kept = rounded.is_finite() && (rounded.abs() > F::ZERO || value.abs() == 0.0);
        let allowed = "in the range of the number type";
        self.range(what, value, kept, allowed, unit);
        rounded
    }

    pub(crate) fn done(self) -> Result<(), LoopParameterError> {
        self.first.map_or(Ok(()), Err)
    }
}
