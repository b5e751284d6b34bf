//! Controllers and transfer functions as functions on the circle, of the weights that really run.

use crate::{
    ControlError, CroneParameters, FractionalTransferFunction, LeadLagParameters, PidParameters,
    PowerMemory, SetPoint, Term, TidParameters,
    enclosure::{Factor, Fraction, Product},
    lead::LeadShape,
    memory::{Rule, TAPS},
    pid::BranchParameters,
    records::MODES,
    sampled::entries,
};
use certified_count::count;
use core::fmt;
use fracdiff::{Order, Seconds, full_memory::Design};
use num_complex::Complex;
use std::{vec, vec::Vec};

/// Parameters of any controller of this crate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[expect(
    clippy::large_enum_variant,
    reason = "a value that is copied now and then, and stays one"
)]
pub enum ControllerParameters {
    /// Parameters of a [`FractionalPid`](crate::FractionalPid).
    Pid(PidParameters),
    /// Parameters of a [`FractionalPid::tid`](crate::FractionalPid::tid).
    Tid(TidParameters),
    /// Parameters of a [`LeadController::crone`](crate::LeadController::crone).
    Crone(CroneParameters),
    /// Parameters of a [`LeadController::lead_lag`](crate::LeadController::lead_lag).
    LeadLag(LeadLagParameters),
    /// Transfer function of a [`FunctionController`](crate::FunctionController).
    Function(FractionalTransferFunction),
}

macro_rules! from_parameters {
    ($($kind:ident($parameters:ident)),+) => {
        $(impl From<$parameters> for ControllerParameters {
            fn from(parameters: $parameters) -> Self {
                Self::$kind(parameters)
            }
        })+
    };
}

from_parameters!(
    Pid(PidParameters),
    Tid(TidParameters),
    Crone(CroneParameters),
    LeadLag(LeadLagParameters),
    Function(FractionalTransferFunction)
);

/// C(s) in the usual notation, with brackets where that has none.
impl fmt::Display for ControllerParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pid(law) => law.fmt(f),
            Self::Tid(law) => write!(
                f,
                "{}/s^(1/{})+{}/s+{}s",
                law.tilt, law.tilt_divisor, law.integral, law.derivative
            ),
            Self::Crone(law) => write!(
                f,
                "{}((1+s/{})/(1+s/{}))^{}",
                law.gain, law.low_rad_s, law.high_rad_s, law.order
            ),
            Self::LeadLag(law) => write!(
                f,
                "{}((s+1/{})/(s+1/({}·{})))^{}",
                law.gain, law.lambda_s, law.x, law.lambda_s, law.order
            ),
            Self::Function(law) => law.fmt(f),
        }
    }
}

impl ControllerParameters {
    /// C(jω) of the continuous law, ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        match self {
            Self::Pid(law) => law.response(omega),
            Self::Tid(law) => law.response(omega),
            Self::Crone(law) => law.response(omega),
            Self::LeadLag(law) => law.response(omega),
            Self::Function(law) => law.response(omega),
        }
    }

    /// Parameters with all of the gain this many times as large.
    ///
    /// # Errors
    /// A coefficient of a function that overflows.
    pub fn scaled(mut self, factor: f64) -> Result<Self, ControlError> {
        match &mut self {
            Self::Pid(law) => {
                law.proportional *= factor;
                law.integral *= factor;
                law.derivative *= factor;
            }
            Self::Tid(law) => {
                law.tilt *= factor;
                law.integral *= factor;
                law.derivative *= factor;
            }
            Self::Crone(law) => law.gain *= factor,
            Self::LeadLag(law) => law.gain *= factor,
            Self::Function(law) => {
                let above = law.numerator().terms().iter();
                let above: Vec<Term> = above
                    .map(|term| Term::new(factor * term.coefficient, term.order))
                    .collect();
                *law = FractionalTransferFunction::new(&above, law.denominator().terms())?;
            }
        }
        Ok(self)
    }

    /// True if an error that stands drives the command on and on.
    #[must_use]
    pub fn integrates(&self) -> bool {
        match self {
            Self::Pid(law) => law.integral != 0.0,
            Self::Tid(law) => law.tilt != 0.0 || law.integral != 0.0,
            Self::Crone(_) | Self::LeadLag(_) => false,
            Self::Function(law) => law.numerator().lowest() < law.denominator().lowest(),
        }
    }

    /// −u/y of the sampled controller, as numerator and denominator.
    pub(crate) fn fraction(
        &self,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Fraction, ControlError> {
        let fraction = match self {
            Self::Pid(law) => {
                let branches = law.checked()?.branches(SetPoint::ERROR);
                parallel(&branches, memory, sample_time)
            }
            Self::Tid(law) => parallel(&law.branches(1.0)?, memory, sample_time),
            Self::Crone(law) => lead(law.shape()?, memory, sample_time),
            Self::LeadLag(law) => lead(law.shape()?, memory, sample_time),
            Self::Function(law) => transfer_fraction(law, memory, sample_time),
        };
        fraction?.bearable("gain of the controller")
    }
}

/// The core of a full memory as it runs.
fn memory_factor(design: &Design<TAPS, MODES>) -> Factor {
    let modes = design.modes().iter();
    let modes = modes.map(|mode| (mode.weight, mode.decay()));
    Factor::Memory(design.corrections().into(), modes.collect())
}

/// `Σ k_i T^(−μ_i)(1 − w)^(μ_i)·f_i` over the power of 1 − w that running sums need.
fn parallel(
    branches: &[BranchParameters],
    memory: PowerMemory,
    sample_time: Seconds,
) -> Result<Fraction, ControlError> {
    let used = branches.iter().filter(|branch| branch.gain != 0.0);
    let mut parts: Vec<(i32, Product)> = Vec::new();
    for branch in used {
        let order = Order::new(branch.order)?;
        let design = memory.design::<MODES>(order, sample_time)?;
        let mut factors = vec![memory_factor(&design)];
        if memory.rule() == Rule::Bdf2 {
            factors.push(Factor::InW(fracdiff::bdf2_short_filter(order).to_vec()));
        }
        let scale = branch.gain * sample_time.rate_to_the(order)?;
        parts.push((order.split_up().0, Product::new(scale, factors)));
    }
    let sums = parts.iter().map(|(n, _)| -n).max().unwrap_or(0).max(0);
    let above = parts.into_iter().map(|(n, mut product)| {
        product.factors.push(Factor::Difference(n + sums));
        product
    });
    let below = Product::new(1.0, vec![Factor::Difference(sums)]);
    Ok(Fraction::new(above.collect(), vec![below]))
}

/// `k((1 − pw)/(1 − qw))^ν` as [`lead`](crate::lead) runs it.
fn lead(
    shape: LeadShape,
    memory: PowerMemory,
    sample_time: Seconds,
) -> Result<Fraction, ControlError> {
    let parts = crate::lead::parts::<MODES>(&shape, &memory, sample_time)?;
    let mut above = Product::new(shape.gain * shape.factor * parts.gain, Vec::new());
    let mut below = Product::new(1.0, Vec::new());
    for _ in 0..parts.sections {
        above.factors.push(Factor::InW(vec![1.0, -parts.zero]));
        below.factors.push(Factor::InW(vec![1.0, -parts.pole]));
    }
    if let Some(memories) = &parts.memories {
        above.factors.push(Factor::InW(vec![1.0, -parts.zero]));
        let memories = memories.iter().flatten().map(memory_factor);
        above.factors.extend(memories);
    }
    Ok(Fraction::new(vec![above], vec![below]))
}

/// Numerator and denominator of a [`SampledTransferFunction`](crate::SampledTransferFunction), both times (1 − w) to the number of its
/// running sums.
pub(crate) fn transfer_fraction(
    function: &FractionalTransferFunction,
    memory: PowerMemory,
    sample_time: Seconds,
) -> Result<Fraction, ControlError> {
    let (entries, count) = entries(function)?;
    let entries = &entries[..count];
    let sums = entries.iter().map(|entry| entry.level).max().unwrap_or(0);
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for entry in entries {
        let (taps, used) = memory.filter(entry.order);
        let left = i32::try_from(sums - entry.level).unwrap_or(0);
        let mut factors = vec![Factor::Difference(left), Factor::InW(taps[..used].to_vec())];
        if entry.fraction > 0.0 {
            let order = Order::new(-entry.fraction)?;
            factors.push(memory_factor(&memory.design(order, sample_time)?));
        }
        let scale = libm::pow(sample_time.0, entry.fraction + entry.level as f64);
        for (side, coefficient) in [(&mut above, entry.above), (&mut below, entry.below)] {
            if coefficient != 0.0 {
                side.push(Product::new(scale * coefficient, factors.clone()));
            }
        }
    }
    Ok(Fraction::new(above, below))
}

impl FractionalTransferFunction {
    /// Poles that grow of the rule that runs this function; `None` where one stands, or nothing is proved.
    ///
    /// # Errors
    /// As [`SampledTransferFunction::new`](crate::SampledTransferFunction::new).
    pub fn growing_poles_of_rule(
        &self,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Option<usize>, ControlError> {
        let below = transfer_fraction(self, memory, sample_time)?.below;
        let below = below.without_differences();
        Ok(count(|arc| below.at(arc)).unstable_poles)
    }
}
