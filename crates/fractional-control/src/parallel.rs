//! PI^λD^μ and TID, sample by sample: powers of s side by side, each with its gain and set-point weight.

use crate::controller::Stage;
use crate::memory::TAPS;
use crate::pid::BranchParameters;
use crate::transfer::in_samples;
use crate::{
    Actuator, ControlError, Controller, PidParameters, PowerMemory, Rule, SetPoint, TidParameters,
};
use fracdiff::{
    Bdf2History, Bdf2Memory, Differintegrator, FrequencyResponse, FullMemory, FullMemoryHistory,
    Order, Real, Seconds,
};
use num_complex::Complex;

/// Powers side by side at most.
pub(crate) const BRANCHES: usize = 3;

/// A power O with its gain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Branch<F, O> {
    pub(crate) gain: F,
    pub(crate) weight: F,
    /// μ, by which a branch takes over from another.
    pub(crate) order: f64,
    pub(crate) power: O,
    /// True of an integral, whose clock may stand.
    pub(crate) integrates: bool,
}

/// PI^λD^μ: `u = K_p(b·r − y) + K_i I^λ(r − y) + K_d D^μ(c·r − y)`, limited.
///
/// - *Units*: r and y \[y\], u \[u\], T s; gains as in [`PidParameters`]. *Start-up*: zero for ever before.
/// - *Memory*: of integral and derivative, by the rule of [`PowerMemory`]; MODES a multiple of 8.
/// - *Limits, anti-windup, changes*: see [`Controller`](crate::Controller).
/// - *Cost*: `output` three multiply-adds, `advance` as two full memories.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{
///     Actuator, Controller, FractionalPid, PowerMemory, PidParameters, Rule, SetPoint,
/// };
///
/// let gains = PidParameters {
///     proportional: 2.0,
///     integral: 1.0,
///     integral_order: 0.8,
///     derivative: 0.1,
///     derivative_order: 0.6,
/// };
/// let memory = PowerMemory::new(Rule::Grunwald, 1e-4, 200.0)?;
/// let pid = FractionalPid::<f32>::new(gains, SetPoint::DEFAULT, Actuator::new(-3.0, 3.0)?, memory, Seconds(1e-3))?;
/// let mut history = pid.at_rest();
/// let command = pid.output(&history, 5.0, 0.0); // sends this at once,
/// assert_eq!(command, 3.0);
/// pid.advance(&mut history, 5.0, 0.0, command); // then does the history, which winds up by nothing
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// Source: I. Podlubny, *Fractional-order systems and PI^λD^μ-controllers*, IEEE Trans. Automatic Control 44(1), 1999.
#[derive(Clone, Debug, PartialEq)]
pub struct FractionalPid<F, const MODES: usize = 48>(pub(crate) Kind<F, MODES>);

/// One rule for all powers: it is selected once a call.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind<F, const MODES: usize> {
    First(Parallel<F, FullMemory<F, TAPS, MODES>>),
    Second(Parallel<F, Bdf2Memory<F, TAPS, MODES>>),
}

/// History of [`FractionalPid`].
#[derive(Clone, Debug, PartialEq)]
pub struct ParallelHistory<F, const MODES: usize>(KindHistory<F, MODES>);

#[derive(Clone, Debug, PartialEq)]
enum KindHistory<F, const MODES: usize> {
    First(Past<F, FullMemoryHistory<F, TAPS, MODES>>),
    Second(Past<F, Bdf2History<F, TAPS, MODES>>),
}

/// A gain, and powers of one kind, side by side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parallel<F, O> {
    /// Gain and weight of the part without a power, which is added first.
    pub(crate) proportional: Option<[F; 2]>,
    pub(crate) branches: [Option<Branch<F, O>>; BRANCHES],
    pub(crate) feedback: F,
    pub(crate) stage: Stage<F>,
    pub(crate) sample_time: f64,
}

/// The past of a [`Parallel`].
#[derive(Clone, Debug, PartialEq)]
struct Past<F, H> {
    /// Histories of the branches, and any in the place of a missing one: only the law is selected, once a tick. `None` without branches.
    powers: Option<[H; BRANCHES]>,
    /// Held over a change or a start; fades where nothing integrates.
    bias: F,
    /// Average of the command before its limits, over the last samples.
    average: F,
}

impl<F: Real, O> Branch<F, O> {
    /// The input that the branch sees.
    #[inline]
    fn error(&self, reference: F, measured: F) -> F {
        self.weight * reference - measured
    }
}

impl<F: Real, O: Differintegrator<F> + PartialEq> Parallel<F, O> {
    /// `Σ k_i·D^(μ_i)(w_i·r − y)`; parts with a gain of 0 are left out.
    fn new(
        parameters: [BranchParameters; BRANCHES],
        actuator: Actuator,
        sample_time: Seconds,
        make: impl Fn(Order) -> Result<O, ControlError>,
    ) -> Result<Self, ControlError> {
        let mut branches: [Option<Branch<F, O>>; BRANCHES] = [const { None }; BRANCHES];
        let (mut feedback, mut proportional) = (0.0, None);
        // Also where no branch has a power.
        sample_time.rate_to_the(Order::new(0.0)?)?;
        let used = parameters.iter().filter(|p| p.gain != 0.0);
        for (slot, part) in branches.iter_mut().zip(used) {
            let gain = in_samples("gain", part.gain)?;
            let weight = in_samples("set-point weight", part.weight)?;
            let mut direct = part.gain;
            if part.order == 0.0 {
                proportional = Some([gain, weight]);
            } else {
                let power = make(Order::new(part.order)?)?;
                direct = part.gain * power.direct_gain().to_f64();
                *slot = Some(Branch {
                    gain,
                    weight,
                    order: part.order,
                    power,
                    integrates: part.order < 0.0,
                });
            }
            feedback += direct;
        }
        let integrates = branches.iter().flatten().any(|branch| branch.integrates);
        Ok(Self {
            proportional,
            branches,
            feedback: in_samples("gain over a sample", feedback)?,
            stage: actuator.stage(sample_time, integrates),
            sample_time: sample_time.0,
        })
    }

    fn at_rest(&self) -> Past<F, O::History> {
        let any = self.branches.iter().flatten().next();
        let rest = |any: &Branch<F, O>| {
            let history =
                |branch: &Option<Branch<F, O>>| branch.as_ref().unwrap_or(any).power.at_rest();
            self.branches.each_ref().map(history)
        };
        Past {
            powers: any.map(rest),
            bias: F::ZERO,
            average: F::ZERO,
        }
    }

    #[inline]
    fn wanted(&self, past: &Past<F, O::History>, r: F, y: F) -> F {
        self.wanted_and_errors(past, r, y).0
    }

    /// The command before its limits, and what each branch sees.
    #[inline]
    fn wanted_and_errors(&self, past: &Past<F, O::History>, r: F, y: F) -> (F, [F; BRANCHES]) {
        let mut errors = [F::ZERO; BRANCHES];
        let mut sum = past.bias;
        if let Some([gain, weight]) = self.proportional {
            sum += gain * (weight * r - y);
        }
        let Some(powers) = &past.powers else {
            return (sum, errors);
        };
        for ((branch, history), error) in self.branches.iter().zip(powers).zip(&mut errors) {
            if let Some(branch) = branch {
                *error = branch.error(r, y);
                sum += branch.gain * branch.power.output(history, *error);
            }
        }
        (sum, errors)
    }

    #[inline]
    fn output(&self, past: &Past<F, O::History>, r: F, y: F) -> F {
        self.stage.limit(self.wanted(past, r, y))
    }

    #[inline]
    fn advance(&self, past: &mut Past<F, O::History>, r: F, y: F, applied: F) {
        let (wanted, errors) = self.wanted_and_errors(past, r, y);
        let [down, up] = self.stage.stops(&mut past.average, wanted, applied);
        if past.bias != F::ZERO {
            past.bias = self.stage.faded(past.bias);
        }
        let Some(powers) = &mut past.powers else {
            return;
        };
        for ((branch, history), error) in self.branches.iter().zip(powers).zip(errors) {
            if let Some(branch) = branch {
                // The clock of an integral stands while it pushes on.
                let push = branch.gain * error;
                if branch.integrates && ((down && push < F::ZERO) || (up && push > F::ZERO)) {
                    continue;
                }
                advance_apart(&branch.power, history, error);
            }
        }
    }

    fn follow(&self, past: &mut Past<F, O::History>, r: F, y: F, applied: F) {
        let wanted = self.wanted(past, r, y);
        past.bias += self.stage.applied(wanted, applied) - wanted;
        let powers = past.powers.iter_mut().flatten();
        for (branch, history) in self.branches.iter().zip(powers) {
            if let Some(branch) = branch.as_ref().filter(|branch| !branch.integrates) {
                branch.power.advance(history, branch.error(r, y));
            }
        }
    }

    fn settled(&self, r: F, y: F, command: F) -> Past<F, O::History> {
        let mut past = self.keep(None, r, y);
        let wanted = self.wanted(&past, r, y);
        past.bias = self.stage.limit(self.stage.applied(wanted, command)) - wanted;
        past
    }

    /// The histories of another one, where a branch of the same power has one. Another derivative starts from what it sees
    /// now, as if that always had been; another integral at rest.
    fn keep(
        &self,
        other: Option<(&Self, &Past<F, O::History>)>,
        r: F,
        y: F,
    ) -> Past<F, O::History> {
        let mut kept = self.at_rest();
        kept.average = other.map_or(F::ZERO, |(_, past)| past.average);
        for (branch, slot) in self.branches.iter().zip(kept.powers.iter_mut().flatten()) {
            let Some(branch) = branch else { continue };
            let known = other.into_iter().flat_map(|(other, past)| {
                let powers = past.powers.iter().flatten();
                other.branches.iter().zip(powers)
            });
            let same = known.filter_map(|(theirs, past)| {
                let theirs = theirs.as_ref()?;
                let same = branch.power == theirs.power && branch.weight == theirs.weight;
                same.then_some(past)
            });
            let new = || {
                if branch.order > 0.0 {
                    branch.power.settled(branch.error(r, y))
                } else {
                    None
                }
            };
            if let Some(known) = same.last().cloned().or_else(new) {
                *slot = known;
            }
        }
        kept
    }
}

/// A memory in a function of its own keeps the registers that it needs; on a small core the call costs more.
#[cfg_attr(target_arch = "arm", inline)]
#[cfg_attr(not(target_arch = "arm"), inline(never))]
fn advance_apart<F: Real, O: Differintegrator<F>>(power: &O, history: &mut O::History, error: F) {
    power.advance(history, error);
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
        memory: PowerMemory,
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
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let branches = parameters.branches(derivative_weight)?;
        Self::of_branches(branches, actuator, memory, sample_time)
    }

    pub(crate) fn of_branches(
        parameters: [BranchParameters; BRANCHES],
        actuator: Actuator,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let t = sample_time;
        let design = |order| memory.design(order, t);
        Ok(Self(match memory.rule() {
            Rule::Grunwald => Kind::First(Parallel::new(parameters, actuator, t, |order| {
                Ok(FullMemory::new(&design(order)?, t)?)
            })?),
            Rule::Bdf2 => Kind::Second(Parallel::new(parameters, actuator, t, |order| {
                Ok(Bdf2Memory::new(&design(order)?, t)?)
            })?),
        }))
    }
}

impl<F: Real, const MODES: usize> Controller<F> for FractionalPid<F, MODES> {
    type History = ParallelHistory<F, MODES>;

    fn at_rest(&self) -> Self::History {
        ParallelHistory(match &self.0 {
            Kind::First(sum) => KindHistory::First(sum.at_rest()),
            Kind::Second(sum) => KindHistory::Second(sum.at_rest()),
        })
    }

    #[inline]
    fn feedback_gain(&self) -> F {
        match &self.0 {
            Kind::First(sum) => sum.feedback,
            Kind::Second(sum) => sum.feedback,
        }
    }

    #[inline]
    fn wanted(&self, history: &Self::History, r: F, y: F) -> F {
        match (&self.0, &history.0) {
            (Kind::First(sum), KindHistory::First(past)) => sum.wanted(past, r, y),
            (Kind::Second(sum), KindHistory::Second(past)) => sum.wanted(past, r, y),
            _ => F::from_f64(f64::NAN),
        }
    }

    #[inline]
    fn output(&self, history: &Self::History, r: F, y: F) -> F {
        match (&self.0, &history.0) {
            (Kind::First(sum), KindHistory::First(past)) => sum.output(past, r, y),
            (Kind::Second(sum), KindHistory::Second(past)) => sum.output(past, r, y),
            _ => F::from_f64(f64::NAN),
        }
    }

    #[inline]
    fn limited(&self, command: F) -> F {
        match &self.0 {
            Kind::First(sum) => sum.stage.limit(command),
            Kind::Second(sum) => sum.stage.limit(command),
        }
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, r: F, y: F, applied: F) {
        match (&self.0, &mut history.0) {
            (Kind::First(sum), KindHistory::First(past)) => sum.advance(past, r, y, applied),
            (Kind::Second(sum), KindHistory::Second(past)) => sum.advance(past, r, y, applied),
            _ => {}
        }
    }

    fn follow(&self, history: &mut Self::History, r: F, y: F, applied: F) {
        match (&self.0, &mut history.0) {
            (Kind::First(sum), KindHistory::First(past)) => sum.follow(past, r, y, applied),
            (Kind::Second(sum), KindHistory::Second(past)) => sum.follow(past, r, y, applied),
            _ => {}
        }
    }

    fn settled(&self, r: F, y: F, command: F) -> Option<Self::History> {
        Some(ParallelHistory(match &self.0 {
            Kind::First(sum) => KindHistory::First(sum.settled(r, y, command)),
            Kind::Second(sum) => KindHistory::Second(sum.settled(r, y, command)),
        }))
    }

    fn take_over(&self, other: &Self, history: &Self::History, r: F, y: F) -> Self::History {
        let mut next = ParallelHistory(match &self.0 {
            Kind::First(sum) => {
                let theirs = match (&other.0, &history.0) {
                    (Kind::First(other), KindHistory::First(past)) => Some((other, past)),
                    _ => None,
                };
                KindHistory::First(sum.keep(theirs, r, y))
            }
            Kind::Second(sum) => {
                let theirs = match (&other.0, &history.0) {
                    (Kind::Second(other), KindHistory::Second(past)) => Some((other, past)),
                    _ => None,
                };
                KindHistory::Second(sum.keep(theirs, r, y))
            }
        });
        let bump = other.wanted(history, r, y) - self.wanted(&next, r, y);
        match &mut next.0 {
            KindHistory::First(past) => past.bias += bump,
            KindHistory::Second(past) => past.bias += bump,
        }
        next
    }
}

impl<F: Real, O: FrequencyResponse> Parallel<F, O> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let proportional = self.proportional.iter();
        let proportional = proportional.map(|[gain, _]| Complex::new(gain.to_f64(), 0.0));
        let powers = self.branches.iter().flatten().map(|branch| {
            let rate = libm::pow(self.sample_time, -branch.order);
            branch.power.response(theta) * (rate * branch.gain.to_f64())
        });
        proportional.chain(powers).sum()
    }
}

impl<F: Real, const MODES: usize> FrequencyResponse for FractionalPid<F, MODES> {
    /// −u/y at the angle θ, of the weights held.
    fn response(&self, theta: f64) -> Complex<f64> {
        match &self.0 {
            Kind::First(sum) => sum.response(theta),
            Kind::Second(sum) => sum.response(theta),
        }
    }
}
