//! PI^λD^μ and TID, sample by sample: powers of s side by side, each with its gain and set-point weight.

use crate::controller::Stage;
use crate::memory::{Power, PowerHistory};
use crate::pid::BranchParameters;
use crate::{Actuator, ControlError, Controller, Memory, PidParameters, SetPoint, TidParameters};
use fracdiff::{FrequencyResponse, Order, Real, Seconds};
use num_complex::Complex;

/// Powers side by side at most.
const BRANCHES: usize = 3;

#[derive(Clone, Debug, PartialEq)]
struct Branch<F, const MODES: usize> {
    gain: F,
    weight: F,
    order: f64,
    /// `None` for order 0.
    power: Option<Power<F, MODES>>,
    /// gain·g of the power.
    direct: F,
    /// True if it takes part in back-calculation.
    conditioned: bool,
}

/// PI^λD^μ: `u = K_p(b·r − y) + K_i I^λ(r − y) + K_d D^μ(c·r − y)`, limited.
///
/// - *Units*: r and y \[y\], u \[u\], T s; gains as in [`PidParameters`]. *Start-up*: zero for ever before.
/// - *Memory*: of integral and derivative, by the rule of [`Memory`]; MODES a multiple of 8.
/// - *Limits, anti-windup, changes*: see [`Controller`](crate::Controller).
/// - *Cost*: `output` three multiply-adds, `advance` as two full memories.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{
///     Actuator, Controller, FractionalPid, Memory, PidParameters, Rule, SetPoint,
/// };
///
/// let gains = PidParameters {
///     proportional: 2.0,
///     integral: 1.0,
///     integral_order: 0.8,
///     derivative: 0.1,
///     derivative_order: 0.6,
/// };
/// let memory = Memory::new(Rule::Grunwald, 1e-4, 200.0)?;
/// let pid = FractionalPid::<f32>::new(gains, SetPoint::DEFAULT, Actuator::new(-3.0, 3.0)?, memory, Seconds(1e-3))?;
/// let mut history = pid.at_rest();
/// let command = pid.output(&history, 5.0, 0.0); // sends this at once,
/// assert_eq!(command, 3.0);
/// pid.advance(&mut history, 5.0, 0.0, command); // then does the history, which winds up by nothing
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// Source: I. Podlubny, *Fractional-order systems and PI^λD^μ-controllers*, IEEE Trans. Automatic Control 44(1), 1999.
#[derive(Clone, Debug, PartialEq)]
pub struct FractionalPid<F, const MODES: usize = 48> {
    branches: [Option<Branch<F, MODES>>; BRANCHES],
    /// `1/g_r` of the branches that take part in back-calculation, or 0 where no reference reaches the command at once.
    inverse: F,
    feedback: F,
    /// The branch of the lowest order, if that is below 0, and 1/(gain·g) of it.
    integral: Option<(usize, F)>,
    stage: Stage<F>,
    sample_time: f64,
}

/// History of [`FractionalPid`].
#[derive(Clone, Debug, PartialEq)]
pub struct ParallelHistory<F, const MODES: usize> {
    powers: [Option<PowerHistory<F, MODES>>; BRANCHES],
    /// Held over a change; fades.
    bias: F,
}

impl<F: Real, const MODES: usize> Branch<F, MODES> {
    /// The input that the branch sees.
    #[inline]
    fn error(&self, reference: F, measured: F) -> F {
        self.weight * reference - measured
    }

    #[inline]
    fn output(&self, history: Option<&PowerHistory<F, MODES>>, error: F) -> F {
        match (&self.power, history) {
            (Some(power), Some(history)) => self.gain * power.output(history, error),
            _ => self.gain * error,
        }
    }
}

impl<F: Real, const MODES: usize> FractionalPid<F, MODES> {
    /// Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// A gain or weight that is not finite, an order outside its range, a memory that MODES modes do not reach, a sample
    /// time outside 1e-9 s to 1e6 s.
    pub fn new(
        parameters: PidParameters,
        set_point: SetPoint,
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let branches = parameters.checked()?.branches(set_point.checked()?);
        Self::of_branches(branches, actuator, memory, sample_time)
    }

    /// Tilted-integral-derivative: `u = K_t I^(1/n)(r − y) + K_i I(r − y) + K_d D(c·r − y)`; c is `derivative_weight`.
    ///
    /// # Errors
    /// As [`new`](Self::new); n below 1.
    ///
    /// Source: B. J. Lurie, *Three-parameter tunable tilt-integral-derivative (TID) controller*, US patent 5 371 670, 1994.
    pub fn tid(
        parameters: TidParameters,
        derivative_weight: f64,
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let branches = parameters.branches(derivative_weight)?;
        Self::of_branches(branches, actuator, memory, sample_time)
    }

    /// `Σ k_i·D^(μ_i)(w_i·r − y)`; branches with a gain of 0 are left out.
    fn of_branches(
        parameters: [BranchParameters; BRANCHES],
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let mut branches: [Option<Branch<F, MODES>>; BRANCHES] = [const { None }; BRANCHES];
        let (mut forward, mut feedback) = (0.0, 0.0);
        let mut integral: Option<(usize, f64, F)> = None;
        // Also where no branch has a power.
        sample_time.rate_to_the(Order::new(0.0)?)?;
        let used = parameters.iter().filter(|p| p.gain != 0.0);
        // A derivative against the others would make the inverse grow, by which back-calculation goes.
        let others = parameters.iter().filter(|p| p.order <= 0.0);
        let others: f64 = others.map(|p| p.gain).sum();
        for (index, (slot, own)) in branches.iter_mut().zip(used).enumerate() {
            let power = match own.order == 0.0 {
                true => None,
                false => Some(memory.power::<F, MODES>(Order::new(own.order)?, sample_time)?),
            };
            let direct = power.as_ref().map_or(F::ONE, Power::direct_gain);
            let direct = own.gain * direct.to_f64();
            let conditioned = own.order <= 0.0 || others * own.gain >= 0.0;
            if conditioned {
                forward += own.weight * direct;
            }
            feedback += direct;
            if own.order < integral.map_or(0.0, |(_, order, _)| order) {
                integral = Some((index, own.order, F::from_f64(1.0 / direct)));
            }
            *slot = Some(Branch {
                gain: F::from_f64(own.gain),
                weight: F::from_f64(own.weight),
                order: own.order,
                power,
                direct: F::from_f64(direct),
                conditioned,
            });
        }
        let inverse = if forward == 0.0 { 0.0 } else { 1.0 / forward };
        Ok(Self {
            branches,
            inverse: F::from_f64(inverse),
            feedback: F::from_f64(feedback),
            integral: integral.map(|(index, _, inverse)| (index, inverse)),
            stage: actuator.stage(sample_time),
            sample_time: sample_time.0,
        })
    }

    /// The reference that would have given what was applied, to the branches that take part.
    #[cold]
    #[inline(never)]
    fn conditioned(&self, r: F, excess: F) -> F {
        r + excess * self.inverse
    }

    /// The histories of another one, where a branch of the same power has one. Another derivative starts from what it sees
    /// now, as if that always had been; another integral at rest.
    fn keep(
        &self,
        other: &Self,
        history: &ParallelHistory<F, MODES>,
        r: F,
        y: F,
    ) -> ParallelHistory<F, MODES> {
        let mut kept = self.at_rest();
        for (own, slot) in self.branches.iter().zip(&mut kept.powers) {
            let Some(own) = own else { continue };
            let theirs = other.branches.iter().zip(&history.powers);
            let same = theirs.filter_map(|(branch, past)| {
                let branch = branch.as_ref()?;
                let same = own.power == branch.power && own.weight == branch.weight;
                past.as_ref().filter(|_| same)
            });
            let power = own.power.as_ref().filter(|_| own.order > 0.0);
            let new = power.map(|power| power.settled(own.error(r, y)));
            *slot = same.last().cloned().or(new).or(slot.take());
        }
        kept
    }
}

impl<F: Real, const MODES: usize> Controller<F> for FractionalPid<F, MODES> {
    type History = ParallelHistory<F, MODES>;

    fn at_rest(&self) -> Self::History {
        ParallelHistory {
            powers: self.branches.each_ref().map(|branch| {
                let power = branch.as_ref()?.power.as_ref();
                power.map(Power::at_rest)
            }),
            bias: F::ZERO,
        }
    }

    #[inline]
    fn feedback_gain(&self) -> F {
        self.feedback
    }

    #[inline]
    fn wanted(&self, history: &Self::History, r: F, y: F) -> F {
        let mut sum = history.bias;
        for (branch, own) in self.branches.iter().zip(&history.powers) {
            if let Some(branch) = branch {
                sum += branch.output(own.as_ref(), branch.error(r, y));
            }
        }
        sum
    }

    #[inline]
    fn output(&self, history: &Self::History, r: F, y: F) -> F {
        self.stage.limit(self.wanted(history, r, y))
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, r: F, y: F, applied: F) {
        let excess = applied - self.wanted(history, r, y);
        let mut instead = r;
        // A branch that is foreseen: the memories need not wait for the sum.
        if excess != F::ZERO {
            instead = self.conditioned(r, excess);
        }
        for (branch, own) in self.branches.iter().zip(&mut history.powers) {
            if let (Some(branch), Some(own)) = (branch, own)
                && let Some(power) = &branch.power
            {
                let r = if branch.conditioned { instead } else { r };
                power.advance(own, branch.error(r, y));
            }
        }
        history.bias = self.stage.faded(history.bias);
    }

    fn follow(&self, history: &mut Self::History, r: F, y: F, applied: F) {
        let excess = applied - self.wanted(history, r, y);
        for (index, (branch, own)) in self.branches.iter().zip(&mut history.powers).enumerate() {
            if let (Some(branch), Some(own)) = (branch, own)
                && let Some(power) = &branch.power
            {
                let mut error = branch.error(r, y);
                if let Some((integral, inverse)) = self.integral
                    && integral == index
                {
                    // The error with whose integral the command is what was applied.
                    error += excess * inverse;
                }
                power.advance(own, error);
            }
        }
        if self.integral.is_none() {
            history.bias += excess;
        } else {
            history.bias = self.stage.faded(history.bias);
        }
    }

    fn take_over(&self, other: &Self, history: &Self::History, r: F, y: F) -> Self::History {
        let wanted = other.wanted(history, r, y);
        let mut next = self.keep(other, history, r, y);
        next.bias += wanted - self.wanted(&next, r, y);
        next
    }
}

impl<F: Real, const MODES: usize> FrequencyResponse for FractionalPid<F, MODES> {
    /// −u/y at the angle θ, of the weights held.
    fn response(&self, theta: f64) -> Complex<f64> {
        let branches = self.branches.iter().flatten();
        branches
            .map(|branch| match &branch.power {
                None => Complex::new(branch.gain.to_f64(), 0.0),
                Some(power) => {
                    let rate = libm::pow(self.sample_time, -branch.order);
                    power.response(theta) * (rate * branch.gain.to_f64())
                }
            })
            .sum()
    }
}
