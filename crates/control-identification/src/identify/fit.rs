//! Model less record, as a problem of least squares.

use super::numbers::Numbers;
use super::record::{
    DeadTime, Free, FreeNumber, InputOutputRecord, StartState, UNFIT, answers_at_once,
};
use super::whole::projected;
use crate::largest;
use fracdiff::Seconds;
use fractional_control::{
    ControlError, FractionalTransferFunction, Integral, PowerMemory, SampledTransferFunction,
    StateSpace, Term, fractions,
};
use fractional_control::{MODES, through};
use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use rayon::prelude::*;

/// The output of a function over a record, and where the plant began.
#[derive(Clone, Debug)]
pub(super) struct Ran {
    pub(super) output: Vec<f64>,
    pub(super) offset: f64,
    /// `u_p`.
    pub(super) input_before: f64,
    /// The numbers of the start.
    pub(super) numbers: usize,
}

pub(super) struct Fit<'a> {
    numbers: Numbers,
    parameters: DVector<f64>,
    memory: PowerMemory,
    record: InputOutputRecord<'a>,
    /// Steps of a rule in each sample.
    steps: usize,
    /// I^ν of these parameters, with ν: most of what is run next to them has the same, and they take as long to make as some hundred samples.
    integrals: Vec<(f64, Integral<f64, MODES>)>,
    /// The run with these parameters, if there is a function of them.
    pub(super) run: Option<Ran>,
    /// Model less record, of these parameters.
    left: DVector<f64>,
}

/// Orders nearer than this to a whole number become that number: no record separates them, and a plant of whole orders is sampled exactly.
const WHOLE: f64 = 1e-4;

fn settled(found: &FractionalTransferFunction) -> Result<FractionalTransferFunction, ControlError> {
    let whole = |terms: &[Term]| -> Vec<Term> {
        let settle = |term: &Term| {
            let nearest = libm::round(term.order);
            let is_near = (term.order - nearest).abs() < WHOLE;
            Term::new(term.coefficient, if is_near { nearest } else { term.order })
        };
        terms.iter().map(settle).collect()
    };
    FractionalTransferFunction::new(
        &whole(found.numerator().terms()),
        &whole(found.denominator().terms()),
    )
}

/// Whole steps of a rule, and the part of one.
fn in_steps(late: f64, steps: usize) -> (usize, f64) {
    let late = late * steps as f64;
    (libm::floor(late) as usize, late - libm::floor(late))
}

/// The input as a rule of second order sees it, in `steps` steps a sample: a held one through a hat between neighbouring steps, h of a step late,
/// (1−h)²/2·u\[n\] + (1/2 + h − h²)·u\[n−1\] + h²/2·u\[n−2\]; a smooth one in straight lines.
fn seen_by_a_rule(record: &InputOutputRecord<'_>, late: f64, steps: usize) -> Vec<f64> {
    let count = (record.input.len() - 1) * steps + 1;
    if !record.time_s.is_empty() {
        return seen_at_own_times(record, late, steps, count);
    }
    let (whole, h) = in_steps(late, steps);
    let input = |step: usize| {
        let (sample, part) = (step / steps, step % steps);
        let now = record.input[sample];
        let next = record.input.get(sample + 1).copied().unwrap_or(now);
        let share = part as f64 / steps as f64;
        if record.held {
            now
        } else {
            now + share * (next - now)
        }
    };
    let weights = if record.held {
        [0.5 * (1.0 - h) * (1.0 - h), 0.5 + h - h * h, 0.5 * h * h]
    } else {
        [1.0 - h, h, 0.0]
    };
    let at = |n: usize, lag: usize| n.checked_sub(whole + lag).map_or(0.0, input);
    let seen = |n| (0..3).map(|lag| weights[lag] * at(n, lag)).sum();
    (0..count).map(seen).collect()
}

/// The input as that rule sees it, for a record that is not evenly spaced, on the even grid of the rule.
/// ```text
/// (U(t + δ) − 2U(t) + U(t − δ))/δ²,   U the second integral of the held input, so much later
/// ```
fn seen_at_own_times(
    record: &InputOutputRecord<'_>,
    late: f64,
    steps: usize,
    count: usize,
) -> Vec<f64> {
    let (time_s, input) = (record.time_s, record.input);
    let begin = time_s.first().copied().unwrap_or(0.0);
    let late_s = late * record.sample_time.0;
    let step = record.sample_time.0 / steps as f64;
    let grid = |n: f64| begin + n * step - late_s;
    if !record.held {
        return (0..count).map(|n| record.at(grid(n as f64))).collect();
    }
    // U and its slope at each stamp.
    let (mut once, mut twice) = (0.0, 0.0);
    let mut sums = vec![(0.0, 0.0)];
    for (pair, u) in time_s.windows(2).zip(input) {
        let h = pair[1] - pair[0];
        twice += once * h + 0.5 * u * h * h;
        once += u * h;
        sums.push((once, twice));
    }
    let sum = |t: f64| {
        let held = time_s.partition_point(|stamp| *stamp <= t).checked_sub(1);
        held.map_or(0.0, |n| {
            let ((once, twice), h) = (sums[n], t - time_s[n]);
            twice + once * h + 0.5 * input[n] * h * h
        })
    };
    let sums: Vec<f64> = (0..count + 2).map(|n| sum(grid(n as f64 - 1.0))).collect();
    let hats = sums.windows(3);
    hats.map(|u| (u[2] - 2.0 * u[1] + u[0]) / (step * step))
        .collect()
}

/// The output of a function of whole orders; what it passes on at once is held too. `None` of a function without states.
fn exact(
    function: &FractionalTransferFunction,
    record: &InputOutputRecord<'_>,
    late: f64,
) -> Option<Result<Vec<f64>, ControlError>> {
    let (states, direct) = StateSpace::of_function(function)?;
    Some(moved(&states, record, late).map(|mut outputs| {
        if direct != 0.0 {
            let pairs = outputs.iter_mut().zip(record.now_late(late));
            pairs.for_each(|(y, u)| *y += direct * u);
        }
        outputs
    }))
}

/// The output of these states from rest.
fn moved(
    states: &StateSpace,
    record: &InputOutputRecord<'_>,
    late: f64,
) -> Result<Vec<f64>, ControlError> {
    let c = states.output();
    if c.is_empty() {
        return Ok(vec![0.0; record.input.len()]);
    }
    let mut outputs = Vec::with_capacity(record.input.len());
    let mut seen = |_: usize, x: &[f64]| {
        outputs.push(c.iter().zip(x).map(|(c, x)| c * x).sum());
    };
    shown(states, record, late, &[], &mut seen)?;
    Ok(outputs)
}

/// Shows the states of each sample, from these first ones on, from rest without any.
fn shown(
    states: &StateSpace,
    record: &InputOutputRecord<'_>,
    late: f64,
    first: &[f64],
    seen: &mut dyn FnMut(usize, &[f64]),
) -> Result<(), ControlError> {
    let (t, held) = (record.sample_time.0, record.held);
    if record.time_s.is_empty() {
        let (input, part) = record.acting(late);
        return states.run(t, &input, part, held, first, seen);
    }
    let (time_s, input) = (record.time_s, record.input);
    states.run_at(time_s, input, late * t, held, first, seen)
}

/// A residual where there is no model, in units of the largest output.
const NONE: f64 = 1e3;

impl<'a> Fit<'a> {
    pub(super) fn new(
        numbers: Numbers,
        memory: PowerMemory,
        record: InputOutputRecord<'a>,
        steps: usize,
    ) -> Self {
        let begin = numbers.begin(record.late());
        let mut fit = Self {
            parameters: begin.clone(),
            numbers,
            memory,
            record,
            steps,
            integrals: Vec::new(),
            run: None,
            left: DVector::zeros(0),
        };
        fit.set_params(&begin);
        fit
    }

    /// The dead time, in samples.
    fn late(&self, parameters: &DVector<f64>) -> f64 {
        let free = self.numbers.late(parameters);
        free.unwrap_or_else(|| self.record.late())
    }

    /// The run of the parts over the record, `late` samples late, from the start that fits best.
    /// ```text
    /// y − G·u = c − u_p·(G·1) + Σ x_i·r_i,   by least squares
    /// ```
    fn ran(&self, parts: &[FractionalTransferFunction], late: f64) -> Result<Ran, ControlError> {
        let mut output = self.summed(parts, &self.record, late)?;
        let ones = vec![1.0; output.len()];
        let constant = InputOutputRecord {
            input: &ones,
            ..self.record
        };
        let single = parts.first().filter(|_| parts.len() == 1);
        let single = single.filter(|_| self.numbers.runs_exactly(parts));
        let single = single.filter(|_| self.record.start == StartState::Moving);
        let mut motions = match self.record.start {
            StartState::Rest | StartState::Offset => vec![],
            StartState::Settled | StartState::Moving => match single {
                Some(function) => self.free_motions(function, late)?,
                None => vec![self.summed(parts, &constant, late)?],
            },
        };
        let is_open = self.record.start != StartState::Rest
            && single.is_none_or(|function| function.denominator().lowest() <= 0.0);
        if is_open {
            motions.push(ones.clone());
        }
        let left = self.record.output.iter().zip(&output);
        let left: Vec<f64> = left.map(|(y, modelled)| y - modelled).collect();
        let noise = &self.record.noise;
        let white: Vec<Vec<f64>> = motions
            .iter()
            .map(|motion| noise.whitened(motion))
            .collect();
        let shares = projected(&white, noise.whitened(&left));
        for (motion, share) in motions.iter().zip(&shares) {
            let pairs = output.iter_mut().zip(motion);
            pairs.for_each(|(y, modelled)| *y += share * modelled);
        }
        let is_settled = shares.len() == 2 && single.is_none();
        Ok(Ran {
            output,
            offset: shares.last().filter(|_| is_open).copied().unwrap_or(0.0),
            input_before: if is_settled { 0.0 - shares[0] } else { 0.0 },
            numbers: motions.len(),
        })
    }

    /// The output of the parts from rest, added in their order.
    fn summed(
        &self,
        parts: &[FractionalTransferFunction],
        record: &InputOutputRecord<'_>,
        late: f64,
    ) -> Result<Vec<f64>, ControlError> {
        let mut sum = vec![0.0; record.input.len()];
        for part in parts {
            let output = self.responded(part, record, late)?;
            sum.iter_mut().zip(output).for_each(|(sum, y)| *sum += y);
        }
        Ok(sum)
    }

    /// The motions without input from each state, and that by what acted within a dead time.
    fn free_motions(
        &self,
        function: &FractionalTransferFunction,
        late: f64,
    ) -> Result<Vec<Vec<f64>>, ControlError> {
        let Some((states, _)) = StateSpace::of_function(function) else {
            return Ok(vec![]);
        };
        let c = states.output();
        let (count, samples) = (c.len(), self.record.input.len());
        let (zeros, ones) = (vec![0.0; samples], vec![1.0; samples]);
        let with = |input| InputOutputRecord {
            input,
            ..self.record
        };
        let turned = states.transposed();
        let mut motions = vec![Vec::with_capacity(samples); count];
        if count > 0 {
            let mut seen = |_: usize, x: &[f64]| {
                let pairs = motions.iter_mut().zip(x);
                pairs.for_each(|(motion, x)| motion.push(*x));
            };
            shown(&turned, &with(&zeros), 0.0, c.as_slice(), &mut seen)?;
        }
        if late >= 1.0 {
            let at_once = self.responded(function, &with(&ones), 0.0)?;
            let later = self.responded(function, &with(&ones), late)?;
            motions.push(at_once.iter().zip(later).map(|(a, b)| a - b).collect());
        }
        Ok(motions)
    }

    /// The output of a function from rest: exactly where its orders are whole and stay so, else by the rule. What overflows is refused, and no rule
    /// stands in for it, which would damp poles that grow fast.
    fn responded(
        &self,
        function: &FractionalTransferFunction,
        record: &InputOutputRecord<'_>,
        late: f64,
    ) -> Result<Vec<f64>, ControlError> {
        let is_exact = self.numbers.freedom.runs_exactly(function);
        let exact = is_exact.then(|| exact(function, record, late)).flatten();
        exact.unwrap_or_else(|| self.by_rule(function, record, late))
    }

    fn by_rule(
        &self,
        function: &FractionalTransferFunction,
        record: &InputOutputRecord<'_>,
        late: f64,
    ) -> Result<Vec<f64>, ControlError> {
        if answers_at_once(function) {
            let [above, below] = [function.numerator(), function.denominator()];
            let direct = above.terms()[0].coefficient / below.terms()[0].coefficient;
            let now = record.now_late(late).into_iter().map(|u| direct * u);
            let slower = function
                .numerator_without(direct)
                .filter(|slower| !slower.terms().is_empty());
            let Some(slower) = slower else {
                return Ok(now.collect());
            };
            let slower = FractionalTransferFunction::from_polynomials(slower, *below)?;
            let later = self.by_rule(&slower, record, late)?;
            return Ok(now.zip(later).map(|(now, later)| now + later).collect());
        }
        let InputOutputRecord {
            sample_time,
            input,
            held,
            ..
        } = *record;
        let seen = seen_by_a_rule(record, late, self.steps);
        let step = Seconds(sample_time.0 / self.steps as f64);
        let integral = |fraction| self.integral(fraction);
        let running = SampledTransferFunction::of_integrals(function, self.memory, step, integral)?;
        let outputs = through(&running, seen.into_iter());
        if let Some(begin) = record.time_s.first() {
            let last = outputs.len() - 1;
            let at = |t: &f64| {
                let place = ((t - begin) / step.0).clamp(0.0, last as f64);
                let (n, share) = (place as usize, place - libm::floor(place));
                outputs[n] + share * (outputs[(n + 1).min(last)] - outputs[n])
            };
            return Ok(record.time_s.iter().map(at).collect());
        }
        let mut outputs: Vec<f64> = outputs.into_iter().step_by(self.steps).collect();
        let is_slower = function.numerator().degree() < function.denominator().degree();
        let (whole, h) = in_steps(late, self.steps);
        if self.steps > 1 && held && whole % self.steps == 0 && is_slower {
            // A plant does not answer a jump in its own sample; the rule has seen a part of it.
            let first = through(&running, core::iter::once(0.5 * (1.0 - h) * (1.0 - h)));
            let before = core::iter::once(&0.0).chain(input);
            let later = outputs.iter_mut().skip(whole / self.steps);
            for (y, (now, before)) in later.zip(input.iter().zip(before)) {
                *y -= first[0] * (now - before);
            }
        }
        Ok(outputs)
    }

    /// I^ν of the rule, from those of the own parameters where it is there.
    fn integral(&self, fraction: f64) -> Result<Integral<f64, MODES>, ControlError> {
        let mut known = self.integrals.iter();
        let known = known.find(|known| (known.0 - fraction).abs() <= 0.0);
        let step = Seconds(self.record.sample_time.0 / self.steps as f64);
        known.map_or_else(
            || self.memory.integral(fraction, step),
            |known| Ok(known.1.clone()),
        )
    }

    /// All of a function, as far as they can be made.
    fn integrals(&self, parts: &[FractionalTransferFunction]) -> Vec<(f64, Integral<f64, MODES>)> {
        let mut known: Vec<f64> = parts.iter().flat_map(fractions).collect();
        known.sort_by(f64::total_cmp);
        known.dedup();
        let all = known.into_iter();
        all.filter_map(|fraction| Some((fraction, self.integral(fraction).ok()?)))
            .collect()
    }

    /// The parts, and the dead time in samples.
    pub(super) fn found(&self) -> Result<(Vec<FractionalTransferFunction>, f64), ControlError> {
        let parts = self.numbers.parts(&self.parameters)?;
        let parts = parts.iter().map(settled).collect::<Result<_, _>>()?;
        Ok((parts, self.late(&self.parameters)))
    }

    /// The run of what was found: of whole orders exactly, though a rule found them. A rule that has other growing poles than its function says
    /// nothing of it.
    pub(super) fn run_of_found(
        &self,
        parts: &[FractionalTransferFunction],
        late: f64,
    ) -> Result<Ran, ControlError> {
        for function in parts.iter().filter(|part| !part.is_whole()) {
            let growing = function.unstable_poles().filter(|poles| *poles > 0);
            let Some(poles) = growing else { continue };
            let step = Seconds(self.record.sample_time.0 / self.steps as f64);
            if function.growing_poles_of_rule(self.memory, step)? != Some(poles) {
                return Err(UNFIT);
            }
        }
        let freedom = if parts.iter().all(FractionalTransferFunction::is_whole) {
            Free::Coefficients
        } else {
            self.numbers.freedom
        };
        let late_s = late * self.record.sample_time.0;
        let dead_time = match self.record.dead_time {
            DeadTime::From(_) => DeadTime::Known(Seconds(late_s)),
            known @ (DeadTime::Known(_) | DeadTime::JustAfter(_)) => known,
        };
        let record = InputOutputRecord {
            dead_time,
            ..self.record
        };
        let numbers = Numbers::fixed(parts, freedom);
        let fit = Self::new(numbers, self.memory, record, self.steps);
        fit.run.ok_or(UNFIT)
    }

    /// The run with other parameters.
    fn run_by(&self, parameters: &DVector<f64>) -> Option<Ran> {
        let parts = self.numbers.parts(parameters).ok()?;
        self.ran(&parts, self.late(parameters)).ok()
    }

    fn left_by(&self, model: Option<&Ran>) -> DVector<f64> {
        let limit = NONE * largest(self.record.output);
        let output = self.record.output;
        match model {
            Some(model) => {
                let pairs = model.output.iter().zip(output);
                // An unstable model overflows.
                let left = pairs.map(|(have, want)| (have - want).clamp(-limit, limit));
                let left = left.map(|left| if left.is_finite() { left } else { limit });
                let left: Vec<f64> = left.collect();
                DVector::from_vec(self.record.noise.whitened(&left))
            }
            None => DVector::from_element(output.len(), limit),
        }
    }

    fn slopes(&self) -> DMatrix<f64> {
        let left = |parameters: &DVector<f64>| self.left_by(self.run_by(parameters).as_ref());
        let slope = |column| (self.numbers).slope(column, &self.parameters, &self.left, left);
        let count = self.numbers.free.len();
        let columns: Vec<DVector<f64>> = if self.numbers.runs_exactly(&self.numbers.guess) {
            (0..count).map(slope).collect()
        } else {
            (0..count).into_par_iter().map(slope).collect()
        };
        DMatrix::from_columns(&columns)
    }

    /// The free numbers, and their covariance: relative of coefficients, in s of a dead time.
    pub(super) fn covariance(&self, left: f64) -> (Vec<FreeNumber>, DMatrix<f64>) {
        let free = self.numbers.free.len();
        let numbers = free + self.run.as_ref().map_or(0, |run| run.numbers);
        let scale = left / self.record.output.len().saturating_sub(numbers).max(1) as f64;
        let t = self.record.sample_time.0;
        let covariance = (self.numbers).covariance(&self.slopes(), scale, &self.parameters, t);
        (
            self.numbers.free.iter().map(|free| free.1).collect(),
            covariance,
        )
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Fit<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f64>) {
        self.parameters.copy_from(parameters);
        let by_rule = !self.numbers.runs_exactly(&self.numbers.guess);
        let parts = self.numbers.parts(parameters).ok().filter(|_| by_rule);
        self.integrals = parts.map_or_else(Vec::new, |parts| self.integrals(&parts));
        self.run = self.run_by(parameters);
        self.left = self.left_by(self.run.as_ref());
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.left.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.slopes())
    }
}
