//! Nonlinear least squares of the model to a motion; the states at the starts of the pieces are eliminated.
//!
//! ```text
//! min over θ of Σ (x(θ, s) − y)²,   s = position and velocity at the start of each piece, the best for θ
//! ```
//! For a given θ the states are found by Gauss–Newton, piece by piece, two numbers each. The Jacobian over θ is projected onto what no state can
//! make (variable projection, after L. Kaufman, BIT 15, 1975). θ moves by Levenberg–Marquardt.
//!
//! Standard errors hold where residuals are no white noise:
//!
//! ```text
//! cov = (K − 1)/K·Σ over K pieces of d_k·d_kᵀ,   d_k = (A − A_k)⁻¹·J_kᵀ·r_k,   A_k = J_kᵀ·J_k,   A = Σ A_k
//! ```
//! Residuals of an encoder, of friction that varies and of a hand are autocorrelated, so whole pieces are treated as independent:
//! the jackknife, with sums over pieces; R. M. Bell and D. F. `McCaffrey`, Survey Methodology 28, 2002. Autocorrelation of successive
//! residuals comes from an error of the model, not from the sensor, and a model whose residual is larger by that amount may be as good:
//!
//! ```text
//! half an interval = max(2·√cov, √(ρ·Σr²·A⁻¹)),   ρ = Σ r_n·r_(n−1)/Σ r²   where that is above 0.05
//! ```

use crate::MotionRecord;
use haptic_loop::{
    LoopParameterError, SafeForce, SafetyChain, SafetyState,
    plant::{MassDamper, MassDamperConfig},
    units::{
        Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond, Seconds,
    },
};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Vector1, storage::Owned};
use std::ops::Range;

/// Gauss–Newton steps for the states.
const STATE_STEPS: usize = 5;
/// Relative gain below which the steps end.
const STATES_SETTLED: f64 = 1e-5;
/// Step of the difference quotient over the lag, samples.
const LAG_STEP: f64 = 0.03;
/// Evaluations of the search per number.
const PATIENCE: usize = 25;

/// Numbers that are looked for, in this order; the stiffness only with a hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Mass,
    Damping,
    Friction,
    Bias,
    /// Delay and lag together: from a measurement to the mean of what answers it, samples.
    Lateness,
    /// The square of the lag in samples, by which a short one acts at a given lateness; negative for a negative lag.
    SquareOfLag,
    Stiffness,
}

impl Number {
    /// True of a coordinate that may be negative. So may a lag and a delay: no device has such ones, but the best of those that fit a device
    /// without delay or lag is as often there as not.
    const fn is_signed(self) -> bool {
        match self {
            Self::Damping | Self::Friction | Self::Stiffness => false,
            Self::Mass | Self::Bias | Self::Lateness | Self::SquareOfLag => true,
        }
    }
}

/// Numbers without and with a hand.
const NUMBERS: [Number; 7] = [
    Number::Mass,
    Number::Damping,
    Number::Friction,
    Number::Bias,
    Number::Lateness,
    Number::SquareOfLag,
    Number::Stiffness,
];

/// Fitted quantity: positions relative to the start, where they are known.
#[derive(Debug)]
pub(super) struct Fit<'a> {
    replay: &'a Replay,
    /// Positions at the modelled ticks, m; not a number where a sample is missing.
    position: &'a [f64],
    /// Largest force, N: the unit of steps in force.
    force: f64,
    numbers: &'static [Number],
    /// Coordinates of θ: the logarithm of the mass, the others as they are. Of damping, friction and stiffness the magnitude counts.
    theta: DVector<f64>,
    states: Vec<State>,
    found: Option<Solved>,
}

/// Residuals for a θ, and what the states can do about them.
#[derive(Clone, Debug)]
struct Solved {
    left: Vec<f64>,
    /// Slope of each tick's residual over position and velocity at the start of its piece.
    by_state: [Vec<f64>; 2],
}

/// The end of the search.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub model: Model,
    /// Model less record, m; 0 where a sample is missing.
    pub left: Vec<f64>,
    /// Slopes of the residuals over the numbers, a row for each number, without what the states at the starts can make.
    slopes: Vec<Vec<f64>>,
    pieces: Vec<Range<usize>>,
    pub numbers: &'static [Number],
}

impl<'a> Fit<'a> {
    pub(super) fn new(
        replay: &'a Replay,
        position: &'a [f64],
        force: f64,
        hand: bool,
        start: &Model,
        states: Vec<State>,
    ) -> Self {
        let numbers = if hand { &NUMBERS[..] } else { &NUMBERS[..6] };
        let theta = numbers.iter().map(|number| match number {
            Number::Mass => libm::log(start.mass),
            Number::Damping => start.damping,
            Number::Friction => start.friction,
            Number::Bias => start.bias,
            Number::Lateness => start.delay + start.lag.abs(),
            Number::SquareOfLag => start.square_of_lag(),
            Number::Stiffness => start.stiffness,
        });
        let theta = DVector::from_iterator(numbers.len(), theta);
        let mut fit = Self {
            replay,
            position,
            force,
            numbers,
            theta,
            states,
            found: None,
        };
        fit.solve();
        fit
    }

    pub(super) fn search(self) -> Option<Fitted> {
        let (mut fit, _) = LevenbergMarquardt::new()
            .with_ftol(1e-8)
            .with_xtol(1e-6)
            .with_gtol(1e-10)
            .with_patience(PATIENCE)
            .minimize(self);
        for (number, x) in fit.numbers.iter().zip(fit.theta.iter_mut()) {
            if !number.is_signed() {
                *x = x.abs();
            }
        }
        fit.solve();
        let slopes = fit.slopes()?;
        let left = fit.found?.left;
        Some(Fitted {
            model: model(fit.numbers, &fit.theta),
            left,
            slopes,
            pieces: fit.replay.pieces().collect(),
            numbers: fit.numbers,
        })
    }

    /// Residuals of a model with these states, 0 where nothing is known, and the states in which it comes to the start of each piece.
    fn run(&self, model: &Model, states: &[State]) -> Option<(Vec<f64>, Vec<State>)> {
        let (mut left, mut arrivals) = self.replay.run(model, states)?;
        if model.lag < 0.0 {
            let (none, _) = self.replay.run(&model.with_lag(0.0), states)?;
            for (left, none) in left.iter_mut().zip(none) {
                *left = 2.0 * none - *left;
            }
        }
        for (left, y) in left.iter_mut().zip(self.position) {
            *left = if y.is_finite() { *left - y } else { 0.0 };
        }
        // The first piece follows no other.
        if let (Some(arrival), Some(start)) = (arrivals.first_mut(), states.first()) {
            *arrival = *start;
        }
        Some((left, arrivals))
    }

    fn residuals(&self, model: &Model, states: &[State]) -> Option<Vec<f64>> {
        Some(self.run(model, states)?.0)
    }

    /// The best states for the present θ.
    fn solve(&mut self) {
        self.found = self.solved();
    }

    fn solved(&mut self) -> Option<Solved> {
        let model = model(self.numbers, &self.theta);
        let (mut left, mut arrivals) = self.run(&model, &self.states)?;
        // Of the last step the share that is tried, for each piece.
        let mut shares = vec![1.0; self.states.len()];
        let mut by_state = self.by_state(&model, &left)?;
        for _ in 0..STATE_STEPS {
            let before = square(&left);
            // Friction makes many minima over a state, and forgets: where the piece before ends is near the best of them.
            let (next, further) = self.run(&model, &arrivals)?;
            let taken = self.take(&mut left, &arrivals, &next);
            if taken.contains(&true) {
                by_state = self.by_state(&model, &left)?;
            }
            arrivals = further;
            let mut tried = self.states.clone();
            for ((piece, state), share) in self.replay.pieces().zip(&mut tried).zip(&shares) {
                let [x, v] = step_of(&left, &by_state, piece);
                state[0] -= share * x;
                state[1] -= share * v;
            }
            let (next, _) = self.run(&model, &tried)?;
            let taken = self.take(&mut left, &tried, &next);
            for (share, taken) in shares.iter_mut().zip(taken) {
                *share = if taken { 1.0 } else { 0.5 * *share };
            }
            by_state = self.by_state(&model, &left)?;
            if before - square(&left) < STATES_SETTLED * before {
                break;
            }
        }
        Some(Solved { left, by_state })
    }

    /// Takes the states of those pieces that leave less with them, as pieces do not touch one another; which.
    fn take(&mut self, left: &mut [f64], states: &[State], next: &[f64]) -> Vec<bool> {
        let pieces = self.replay.pieces().enumerate();
        let taken = pieces.map(|(index, piece)| {
            let better = square(&next[piece.clone()]) < square(&left[piece.clone()]);
            if better {
                self.states[index] = states[index];
                left[piece.clone()].copy_from_slice(&next[piece]);
            }
            better
        });
        taken.collect()
    }

    /// Slopes over the states at the starts, of all pieces at once: they do not touch one another.
    fn by_state(&self, model: &Model, left: &[f64]) -> Option<[Vec<f64>; 2]> {
        let slope = |index: usize, step: f64| {
            let mut states = self.states.clone();
            for state in &mut states {
                state[index] += step;
            }
            let moved = self.residuals(model, &states)?;
            Some(
                moved
                    .iter()
                    .zip(left)
                    .map(|(a, b)| (a - b) / step)
                    .collect::<Vec<f64>>(),
            )
        };
        Some([slope(0, 1e-7)?, slope(1, 1e-6)?])
    }

    /// Step of the difference quotient over a number.
    fn difference(&self, index: usize) -> f64 {
        let x = self.theta[index].abs();
        match self.numbers[index] {
            Number::Mass => 1e-4,
            Number::Damping => 1e-3 * x.max(0.05),
            Number::Friction | Number::Bias => 1e-3 * x.max(0.02 * self.force),
            Number::Lateness => 1e-3,
            Number::SquareOfLag => LAG_STEP * LAG_STEP.max(2.0 * libm::sqrt(x)),
            Number::Stiffness => 1e-3 * x.max(1.0),
        }
    }

    /// Slopes of the residuals over the numbers, without what states can make up for.
    fn slopes(&self) -> Option<Vec<Vec<f64>>> {
        let solved = self.found.as_ref()?;
        let slope = |index: usize| {
            let step = self.difference(index);
            let at = |x: f64| {
                let mut theta = self.theta.clone();
                theta[index] = x;
                self.residuals(&model(self.numbers, &theta), &self.states)
            };
            let here = self.theta[index];
            // Near zero one side alone: the other is its mirror.
            let (low, high) = if self.numbers[index].is_signed() || here.abs() > step {
                (here - step, here + step)
            } else {
                (here, here + libm::copysign(step, here))
            };
            let (below, above) = (at(low)?, at(high)?);
            let mut slope: Vec<f64> = (above.iter().zip(&below))
                .map(|(above, below)| (above - below) / (high - low))
                .collect();
            for piece in self.replay.pieces() {
                let [x, v] = step_of(&slope, &solved.by_state, piece.clone());
                for n in piece {
                    slope[n] -= x * solved.by_state[0][n] + v * solved.by_state[1][n];
                }
            }
            Some(slope)
        };
        (0..self.numbers.len()).map(slope).collect()
    }
}

/// Least squares of a signal by the two slopes over the state, within a piece: two normal equations.
fn step_of(signal: &[f64], by_state: &[Vec<f64>; 2], piece: Range<usize>) -> State {
    let [by_x, by_v] = by_state;
    let (mut xx, mut xv, mut vv, mut xs, mut vs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for n in piece {
        xx += by_x[n] * by_x[n];
        xv += by_x[n] * by_v[n];
        vv += by_v[n] * by_v[n];
        xs += by_x[n] * signal[n];
        vs += by_v[n] * signal[n];
    }
    let determinant = xx * vv - xv * xv;
    if determinant > 1e-9 * xx * vv {
        [
            (vv * xs - xv * vs) / determinant,
            (xx * vs - xv * xs) / determinant,
        ]
    } else if xx > 0.0 {
        // A device that stands still at the start: its velocity there changes nothing.
        [xs / xx, 0.0]
    } else {
        [0.0, 0.0]
    }
}

pub(super) fn square(left: &[f64]) -> f64 {
    left.iter().map(|x| x * x).sum()
}

/// The lag with this square, samples.
pub(super) fn lag_of_square(square: f64) -> f64 {
    libm::copysign(libm::sqrt(square.abs()), square)
}

/// The model at these coordinates.
fn model(numbers: &[Number], theta: &DVector<f64>) -> Model {
    let mut model = Model::default();
    for (number, &x) in numbers.iter().zip(theta.iter()) {
        match number {
            Number::Mass => model.mass = libm::exp(x.clamp(-16.0, 9.0)),
            Number::Damping => model.damping = x.abs(),
            Number::Friction => model.friction = x.abs(),
            Number::Bias => model.bias = x,
            Number::Lateness => model.delay = x,
            Number::SquareOfLag => model.lag = lag_of_square(x).clamp(-DELAY_MAX, DELAY_MAX),
            Number::Stiffness => model.stiffness = x.abs(),
        }
    }
    model.delay = (model.delay - model.lag.abs()).clamp(-EARLY_MAX, DELAY_MAX);
    model
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Fit<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, theta: &DVector<f64>) {
        self.theta.copy_from(theta);
        self.solve();
    }

    fn params(&self) -> DVector<f64> {
        self.theta.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let solved = self.found.as_ref()?;
        Some(DVector::from_column_slice(&solved.left))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let slopes = self.slopes()?;
        Some(DMatrix::from_fn(
            self.position.len(),
            slopes.len(),
            |row, column| slopes[column][row],
        ))
    }
}

/// Longest delay that is looked for, samples.
pub(super) const DELAY_MAX: f64 = 60.0;
/// Negative delays down to this are modelled too, samples: forces that act before they were given.
const EARLY_MAX: f64 = 4.0;
/// Shorter lags than this share of a sample count as none: the force is off by less than any rounding of a position.
pub(super) const NO_LAG: f64 = 1e-4;

/// Numbers of the model, in SI units; the delay and the lag in samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Model {
    pub mass: f64,
    pub damping: f64,
    pub friction: f64,
    pub bias: f64,
    pub delay: f64,
    /// A negative one stands for the motion that is as far from that without lag, on its other side.
    pub lag: f64,
    pub stiffness: f64,
}

impl Model {
    /// The square of the lag, with its sign.
    pub(super) const fn square_of_lag(self) -> f64 {
        self.lag * self.lag.abs()
    }

    /// Replaces the lag and keeps the total lateness.
    pub(super) const fn with_lag(self, lag: f64) -> Self {
        Self {
            delay: self.delay + self.lag.abs() - lag.abs(),
            lag,
            ..self
        }
    }
}

/// Position and velocity at the start of a piece.
pub(super) type State = [f64; 2];

/// Forces of a record, and the ticks that are modelled.
#[derive(Clone, Debug)]
pub(super) struct Replay {
    sample_time: f64,
    forces: Vec<SafeForce<f64, 1>>,
    /// Steps of a sample, each with a friction of its own.
    pub parts: u32,
    /// First tick of each piece; the last ends with the record.
    pub starts: Vec<usize>,
}

impl Replay {
    /// The forces of a record, as they were applied: a chain that limits nothing hands them on.
    pub(super) fn new(
        record: &MotionRecord,
        starts: Vec<usize>,
    ) -> Result<Self, LoopParameterError> {
        let t = Seconds(record.sample_time_s);
        let most = 1e9;
        let chain = SafetyChain::<f64>::new(Newtons(most), NewtonsPerSecond(2.0 * most / t.0), t)?;
        let mut state = SafetyState::default();
        let still = Vector1::new(0.0);
        let hand_on = |force: &f64| chain.apply(&mut state, &still, &Vector1::new(*force)).0;
        Ok(Self {
            sample_time: t.0,
            forces: record.force_n.iter().map(hand_on).collect(),
            parts: 1,
            starts,
        })
    }

    pub(super) fn from(&self) -> usize {
        self.starts.first().copied().unwrap_or(self.forces.len())
    }

    fn len(&self) -> usize {
        self.forces.len() - self.from()
    }

    /// Ticks of each piece, counted from the first modelled one.
    fn pieces(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let (from, end) = (self.from(), self.forces.len());
        let ends = self.starts.iter().skip(1).copied().chain([end]);
        (self.starts.iter().zip(ends)).map(move |(&start, end)| start - from..end - from)
    }

    /// Positions of the model at the modelled ticks, and the states in which it comes to the start of each piece from the one before;
    /// `None` if there is no such device.
    fn run(&self, model: &Model, states: &[State]) -> Option<(Vec<f64>, Vec<State>)> {
        let t = self.sample_time;
        let lag = model.lag.abs();
        // Whole samples of delay are forces of earlier ticks, of a negative one forces that are still to come.
        let whole = model.delay.floor();
        let mut device = MassDamper::<1>::new(MassDamperConfig {
            mass: Kilograms(model.mass),
            damping: NewtonSecondsPerMetre(model.damping),
            sample_time: Seconds(t / f64::from(self.parts)),
            stiffness: NewtonsPerMetre(model.stiffness),
            friction: Newtons(model.friction),
            delay: Seconds((model.delay - whole) * t),
            saturation: None,
            gain: 1.0,
            current_lag: Seconds(if lag > NO_LAG { lag * t } else { 0.0 }),
        })
        .ok()?;
        device.set_external_force(Vector1::new(model.bias));
        let from = self.from();
        // A current that has forgotten where it began.
        let before = from.saturating_sub(2 + 40 * lag.min(10.0) as usize);
        let forces = |ticks: Range<usize>| {
            // Of ticks before the first and after the last its force.
            let given = ticks.map(move |tick| tick.saturating_add_signed(-whole as isize));
            given.filter_map(|tick| self.forces.get(tick).or(self.forces.last()).copied())
        };
        device.replay(&mut forces(before..from), self.parts, &mut |_| ());
        let mut positions = Vec::with_capacity(self.len());
        let mut arrivals = Vec::with_capacity(states.len());
        for (piece, [x, v]) in self.pieces().zip(states) {
            arrivals.push([device.position()[0], device.velocity()[0]]);
            device.set_state(Vector1::new(*x), Vector1::new(*v));
            let ticks = from + piece.start..from + piece.end;
            let see = &mut |position| positions.push(position);
            device.replay(&mut forces(ticks), self.parts, see);
        }
        let is_finite = positions.iter().all(|x| x.is_finite());
        is_finite.then_some((positions, arrivals))
    }
}

/// Standard errors on each side of a value between which it lies in 95 of 100 cases: Student's t of some hundred pieces.
pub(super) const SIDES: f64 = 2.0;

/// Autocorrelation of successive residuals above which they are not white.
pub(super) const GOES_ON: f64 = 0.05;

pub(super) fn goes_on(left: &[f64]) -> f64 {
    left.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / square(left).max(f64::MIN_POSITIVE)
}

/// Uncertainty of the numbers of a fit.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    covariance: DMatrix<f64>,
    /// Covariance that the error of the model allows.
    fault: DMatrix<f64>,
}

impl Spread {
    /// `None` if the record says nothing of one of the numbers.
    pub(super) fn of(fitted: &Fitted, is_simple: bool) -> Option<Self> {
        let (p, pieces) = (fitted.slopes.len(), fitted.pieces.len());
        let all = products(fitted, 0..fitted.left.len());
        // Numbers of very different size: to a unit diagonal first.
        let scale = all.diagonal().map(f64::sqrt);
        if pieces <= p + 1 || scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
            return None;
        }
        let mut sum = DMatrix::zeros(p, p);
        for piece in &fitted.pieces {
            let others = &all - products(fitted, piece.clone());
            let others = others.component_div(&(&scale * scale.transpose()));
            let seen = |n: usize| {
                let ticks = piece.clone();
                let seen = ticks.map(|tick| fitted.slopes[n][tick] * fitted.left[tick]);
                seen.sum::<f64>() / scale[n]
            };
            let step = others.try_inverse()? * DVector::from_fn(p, |n, _| seen(n));
            let step = step.component_div(&scale);
            sum += &step * step.transpose();
        }
        let unit = all.component_div(&(&scale * scale.transpose()));
        let inverse = unit
            .try_inverse()?
            .component_div(&(&scale * scale.transpose()));
        let left = &fitted.left;
        let share = match goes_on(left) {
            share if is_simple && share <= GOES_ON => 0.0,
            share => share.max(GOES_ON),
        };
        let fault = share * square(left);
        Some(Self {
            covariance: sum * ((pieces - 1) as f64 / pieces as f64),
            fault: inverse * fault,
        })
    }

    /// Half the interval of a sum of numbers with these weights.
    pub(super) fn side(&self, weights: &DVector<f64>) -> f64 {
        let along = |matrix: &DMatrix<f64>| weights.dot(&(matrix * weights)).max(0.0).sqrt();
        f64::max(SIDES * along(&self.covariance), along(&self.fault))
    }

    /// Correlation of two such sums, −1 to 1.
    pub(super) fn correlation(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        let covariance = |a: &DVector<f64>, b: &DVector<f64>| a.dot(&(&self.covariance * b));
        covariance(a, b) / (covariance(a, a) * covariance(b, b)).sqrt()
    }
}

/// `JᵀJ` of a range of ticks.
fn products(fitted: &Fitted, range: Range<usize>) -> DMatrix<f64> {
    let p = fitted.slopes.len();
    DMatrix::from_fn(p, p, |a, b| {
        let ticks = range.clone();
        ticks
            .map(|n| fitted.slopes[a][n] * fitted.slopes[b][n])
            .sum()
    })
}

#[cfg(test)]
mod tests {
    use crate::fit::{NUMBERS, *};
    use testkit::Random;

    const PIECES: usize = 12;
    const PIECE: usize = 60;

    /// Least squares of y by two slopes, without the ticks of one piece.
    fn without(slopes: &[Vec<f64>], y: &[f64], piece: Option<usize>) -> DVector<f64> {
        let ticks = || (0..y.len()).filter(|n| Some(n / PIECE) != piece);
        let sum = |a: &[f64], b: &[f64]| ticks().map(|n| a[n] * b[n]).sum::<f64>();
        let gram = DMatrix::from_fn(2, 2, |a, b| sum(&slopes[a], &slopes[b]));
        let seen = DVector::from_fn(2, |a, _| sum(&slopes[a], y));
        gram.lu().solve(&seen).expect("regular")
    }

    /// Two sines and noise that is new every `hold` ticks, fitted.
    fn problem(hold: usize) -> (Fitted, Vec<f64>) {
        let mut random = Random(7);
        let mut noise = 0.0;
        let y: Vec<f64> = (0..PIECES * PIECE)
            .map(|n| {
                if n % hold == 0 {
                    noise = random.between(-1.0, 1.0);
                }
                noise
            })
            .collect();
        let wave = |step: f64| (0..y.len()).map(|n| (step * n as f64).sin()).collect();
        let slopes = vec![wave(0.21), wave(0.037)];
        let theta = without(&slopes, &y, None);
        let left = |n: usize| slopes[0][n] * theta[0] + slopes[1][n] * theta[1] - y[n];
        let fitted = Fitted {
            model: Model::default(),
            left: (0..y.len()).map(left).collect(),
            pieces: (0..PIECES).map(|n| n * PIECE..(n + 1) * PIECE).collect(),
            numbers: &NUMBERS[..2],
            slopes,
        };
        (fitted, y)
    }

    #[test]
    fn an_interval_is_what_fits_without_each_piece_make_of_it() {
        let (fitted, y) = problem(1);
        let best = without(&fitted.slopes, &y, None);
        let spread = Spread::of(&fitted, true).expect("tells");
        for n in 0..2 {
            let steps = (0..PIECES).map(|k| without(&fitted.slopes, &y, Some(k))[n] - best[n]);
            let variance = steps.map(|step| step * step).sum::<f64>() * 11.0 / 12.0;
            let only = DVector::from_fn(2, |m, _| if m == n { 1.0 } else { 0.0 });
            let (have, want) = (spread.side(&only), SIDES * variance.sqrt());
            assert!((have / want - 1.0).abs() < 1e-9, "{n}: {have} {want}");
        }
    }

    #[test]
    fn what_goes_on_from_sample_to_sample_widens_an_interval() {
        let (fitted, _) = problem(20);
        let share = goes_on(&fitted.left);
        assert!((share - 0.95).abs() < 0.03, "{share}");
        let only = DVector::from_vec(vec![1.0, 0.0]);
        let gram = products(&fitted, 0..PIECES * PIECE);
        let inverse = gram.try_inverse().expect("regular");
        let want = (share * square(&fitted.left) * inverse[(0, 0)]).sqrt();
        let have = Spread::of(&fitted, true).expect("tells").side(&only);
        assert!((have / want - 1.0).abs() < 1e-9, "{have} {want}");
        // Of white ones nothing is added, unless the model is known to be off.
        let (fitted, _) = problem(1);
        let side = |is_simple| Spread::of(&fitted, is_simple).expect("tells").side(&only);
        assert!(goes_on(&fitted.left) < GOES_ON && side(false) > side(true));
    }
}
