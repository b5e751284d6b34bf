//! A controller as numbers, from which another language runs it with the same bits.

use crate::{
    Actuator, ControlError, ControllerParameters, ControllerSetup, FractionalPid, PortableForm,
    PortablePart, PowerMemory,
    lead::{LeadPower, LeadShape},
    parallel::{Kind, Parallel},
    pid::BranchParameters,
    transfer::in_samples,
};
use fracdiff::{Differintegrator, OperatorList, Real, Seconds};
use std::vec::Vec;

/// Room for the modes of each memory.
const MODES: usize = crate::records::MODES;

/// A controller as numbers; of memories with the fewest modes that reach the tolerance.
///
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{ControllerList, ControllerSetup, LawList, PidParameters};
///
/// let gains = PidParameters { proportional: 2.0, integral: 1.0, integral_order: 0.8, ..PidParameters::NONE };
/// let list = ControllerList::<f32>::new(&ControllerSetup::new(gains, Seconds(1e-3)))?;
/// let LawList::Parallel(law) = list.law else { unreachable!() };
/// assert_eq!(law.branches.iter().map(|branch| branch.name).collect::<Vec<_>>(), ["proportional", "integral"]);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ControllerList<F> {
    /// The law with its coefficients; limits and bias are the same for all.
    pub law: LawList<F>,
    /// Lowest and highest command; infinite means no limit.
    pub limits: [f64; 2],
    /// The share of a held bump that remains after a sample.
    pub keep: F,
}

/// The law of a [`ControllerList`].
#[derive(Clone, Debug, PartialEq)]
pub enum LawList<F> {
    /// Law of a PI^λD^μ or TID controller.
    Parallel(ParallelList<F>),
    /// Law of a CRONE or lead–lag controller.
    Lead(LeadList<F>),
}

/// Powers side by side: `Σ k_i·D^(μ_i)(w_i·r − y)`, as [`FractionalPid`] adds them up.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParallelList<F> {
    /// The branches whose gain is not 0, in the order in which they are added.
    pub branches: Vec<BranchList<F>>,
}

/// A branch of a [`ParallelList`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BranchList<F> {
    /// Its name: proportional, integral, derivative or tilt.
    pub name: &'static str,
    /// k, in `f64`, as it may be changed while it runs.
    pub gain: f64,
    /// w, the set-point weight; 1 for an integral.
    pub weight: f64,
    /// μ, below 0 of an integral.
    pub order: f64,
    /// The power; `None` for order 0.
    pub power: Option<OperatorList<F>>,
}

/// A power of a lead: whole sections (1 − pw)/(1 − qw), then 1 − pw and two memories, as [`LeadController`](crate::LeadController) runs them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LeadList<F> {
    /// The requested gain, and two factors for the operator's: (gain·first)·second.
    pub gain: f64,
    /// See `gain`.
    pub factors: [f64; 2],
    /// Number of whole sections, each (1 − pw)/(1 − qw).
    pub sections: usize,
    /// p, from the corner of the zero under the Tustin rule.
    pub zero: F,
    /// q, from the corner of the pole under the Tustin rule.
    pub pole: F,
    /// The memories behind 1 − pw; `None` for a whole power.
    pub memories: Option<Vec<OperatorList<F>>>,
}

impl<F: Real> ControllerList<F> {
    /// List of this controller's numbers.
    ///
    /// # Errors
    /// A parameter outside its range; a controller that is given as a transfer function.
    pub fn new(setup: &ControllerSetup) -> Result<Self, ControlError> {
        let t = setup.sample_time();
        let memory = setup.memory()?.fewest_modes();
        let law = match setup.law {
            ControllerParameters::Pid(law) => {
                let branches = law.checked()?.branches(setup.set_point.checked()?);
                let names = ["proportional", "integral", "derivative"];
                parallel(names, branches, memory, t)?
            }
            ControllerParameters::Tid(law) => {
                let branches = law.branches(setup.set_point.derivative)?;
                let names = ["tilt", "integral", "derivative"];
                parallel(names, branches, memory, t)?
            }
            ControllerParameters::Crone(law) => lead(law.shape()?, memory, t)?,
            ControllerParameters::LeadLag(law) => lead(law.shape()?, memory, t)?,
            ControllerParameters::Function(_) => {
                return Err(ControlError::NotFound {
                    what: "a list of numbers for a controller that is a transfer function",
                    why: "give a PI^λD^μ, a TID, a CRONE controller or a lead–lag",
                });
            }
        };
        let integrates = match &law {
            LawList::Parallel(law) => law.branches.iter().any(|branch| branch.order < 0.0),
            LawList::Lead(_) => false,
        };
        let actuator = setup.actuator()?;
        Ok(Self {
            law,
            limits: actuator.limits(),
            keep: actuator.stage(t, integrates).keep,
        })
    }
}

impl<F: Real> ControllerList<F> {
    /// Controller as one list, for a [`PortableController`](crate::PortableController): its form, its parts, and their numbers.
    #[must_use]
    pub fn portable(&self) -> (PortableForm, Vec<PortablePart>, Vec<F>) {
        let part = |power: Option<&OperatorList<F>>| PortablePart {
            integer: power.map_or(0, |power| power.integer),
            values: power.map_or(0, |power| power.values.len()),
            filter: power.map_or(0, |power| power.filter.len()),
        };
        let numbers = |power: &OperatorList<F>| [&power.values[..], &power.filter].concat();
        match &self.law {
            LawList::Parallel(law) => {
                let mut values = [self.keep].to_vec();
                for branch in &law.branches {
                    values.extend([branch.gain, branch.weight].map(F::from_f64));
                    values.extend(branch.power.iter().flat_map(numbers));
                }
                let branches = law.branches.iter();
                let parts = branches.map(|branch| part(branch.power.as_ref()));
                (PortableForm::Parallel, parts.collect(), values)
            }
            LawList::Lead(law) => {
                let [first, second] = law.factors;
                let gain = law.gain * first * second;
                let mut values = [self.keep, F::from_f64(gain), law.zero, law.pole].to_vec();
                let memories = law.memories.iter().flatten();
                values.extend(memories.clone().flat_map(numbers));
                let parts = memories.map(|power| part(Some(power))).collect();
                // At most 2, as the order is.
                let sections = law.sections as u8;
                (PortableForm::Lead { sections }, parts, values)
            }
        }
    }
}

fn parallel<F: Real>(
    names: [&'static str; 3],
    parameters: [BranchParameters; 3],
    memory: PowerMemory,
    sample_time: Seconds,
) -> Result<LawList<F>, ControlError> {
    let unlimited = Actuator::UNLIMITED;
    let running =
        FractionalPid::<F, MODES>::of_branches(parameters, unlimited, memory, sample_time)?;
    let named = names.into_iter().zip(parameters);
    let used = named.filter(|(_, term)| term.gain != 0.0);
    Ok(LawList::Parallel(match &running.0 {
        Kind::First(running) => side_by_side(used, running),
        Kind::Second(running) => side_by_side(used, running),
    }))
}

fn side_by_side<F: Real, O: Differintegrator<F>>(
    used: impl Iterator<Item = (&'static str, BranchParameters)>,
    running: &Parallel<F, O>,
) -> ParallelList<F>
where
    for<'a> OperatorList<F>: From<&'a O>,
{
    let branches = used.zip(&running.branches).map(|((name, term), branch)| {
        let power = branch.as_ref().map(|branch| &branch.power);
        BranchList {
            name,
            gain: term.gain,
            weight: term.weight,
            order: term.order,
            power: power.map(OperatorList::from),
        }
    });
    ParallelList {
        branches: branches.collect(),
    }
}

fn lead<F: Real>(
    shape: LeadShape,
    memory: PowerMemory,
    sample_time: Seconds,
) -> Result<LawList<F>, ControlError> {
    let (operator, normaliser) = LeadPower::<F, MODES>::new(&shape, &memory, sample_time)?;
    let gain = shape.gain * shape.factor * normaliser;
    in_samples::<F>("gain", gain)?;
    in_samples::<F>("inverse of the gain", 1.0 / gain)?;
    Ok(LawList::Lead(LeadList {
        gain: shape.gain,
        factors: [shape.factor, normaliser],
        sections: operator.sections,
        zero: operator.zero,
        pole: operator.pole,
        memories: operator
            .memories
            .as_ref()
            .map(|memories| memories.iter().flatten().map(OperatorList::from).collect()),
    }))
}
