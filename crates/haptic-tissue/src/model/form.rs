//! The elements of a model.

use super::joint::Two;
use super::spring_pot::{SpringPot, series};
use num_complex::Complex64;

/// A branch of a generalised Maxwell model: a spring and a dashpot in series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxwellBranch {
    /// Modulus of the spring, Pa.
    pub elastic_modulus_pa: f64,
    /// Viscosity of the dashpot over it, s.
    pub relaxation_time_s: f64,
}

/// The elements of a model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Form {
    One(SpringPot),
    Two(Two),
    /// A Prony series: a spring, of 0 Pa for none, or a dashpot, and branches, fastest first.
    Branches(SpringPot, Vec<MaxwellBranch>),
}

impl Form {
    /// The model from its elements, by what side by side and in series mean for them; branches of a Prony series are elements
    /// too.
    pub(crate) fn of<T>(
        &self,
        element: impl Fn(&SpringPot) -> T,
        branch: impl Fn(&MaxwellBranch) -> T,
        parallel: impl Fn(T, T) -> T,
        series: impl Fn(T, T) -> T,
    ) -> T {
        let spring = |size: f64| element(&SpringPot::new(size, 0.0));
        match self {
            Self::One(one) => element(one),
            Self::Two(two) => {
                let [first, second] = [&two.first, &two.second].map(&element);
                let parts = [first, second, spring(two.spring_pa)];
                two.joint.of(parts, parallel, series)
            }
            Self::Branches(beside, branches) => {
                let branches = branches.iter().map(branch);
                branches.fold(element(beside), parallel)
            }
        }
    }

    /// M of the model from those of its elements.
    pub(super) fn joined(
        &self,
        element: impl Fn(&SpringPot) -> Complex64,
        branch: impl Fn(&MaxwellBranch) -> Complex64,
    ) -> Complex64 {
        self.of(element, branch, |a, b| a + b, series)
    }

    /// G(0), Pa: infinite where a sudden strain has no finite stress.
    pub(super) fn instantaneous_pa(&self) -> f64 {
        let stiff = |one: &SpringPot| {
            if one.is_spring() {
                one.size
            } else {
                f64::INFINITY
            }
        };
        self.of(stiff, |one| one.elastic_modulus_pa, |a, b| a + b, springs)
    }

    pub(super) fn equilibrium_pa(&self) -> f64 {
        let left = |one: &SpringPot| if one.is_spring() { one.size } else { 0.0 };
        self.of(left, |_| 0.0, |a, b| a + b, springs)
    }
}

/// Two springs in series, each from 0 to rigid.
fn springs(a: f64, b: f64) -> f64 {
    match [a, b].map(f64::is_infinite) {
        [true, _] => b,
        [false, true] => a,
        [false, false] if a + b == 0.0 => 0.0,
        [false, false] => b * (a / (a + b)),
    }
}
