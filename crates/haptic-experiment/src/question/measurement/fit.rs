//! Nonlinear least squares of the model to a motion; the states at the starts of the pieces are eliminated.
//!
//! ```text
//! min over θ of Σ (x(θ, s) − y)²,   s = position and velocity at the start of each piece, the best for θ
//! ```
//! For a given θ the states are found by Gauss–Newton, piece by piece, two numbers each. The Jacobian over θ is projected onto what no state can
//! make (variable projection, after L. Kaufman, BIT 15, 1975). θ moves by Levenberg–Marquardt.

use super::replay::{DELAY_MAX, EARLY_MAX, Model, Replay, State};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use std::ops::Range;

/// Gauss–Newton steps for the states.
const STATE_STEPS: usize = 5;
/// Relative gain below which a further step is none.
const STATES_SETTLED: f64 = 1e-5;
/// Step of the difference quotient over the lag, samples: of a shorter one it would be that of its square.
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
    /// Of a negative one the square counts as negative: with a given lateness a short lag acts by its square.
    Lag,
    Stiffness,
}

impl Number {
    /// True of a coordinate that may be negative. So may a lag and a delay: no device has such ones, but the best of those that fit a device
    /// without delay or lag is as often there as not.
    const fn is_signed(self) -> bool {
        !matches!(self, Self::Damping | Self::Friction | Self::Stiffness)
    }
}

/// Numbers without and with a hand.
pub(super) const NUMBERS: [Number; 7] = [
    Number::Mass,
    Number::Damping,
    Number::Friction,
    Number::Bias,
    Number::Lateness,
    Number::Lag,
    Number::Stiffness,
];

/// What is fitted: positions about the start, where they are known.
#[derive(Debug)]
pub(super) struct Fit<'a> {
    replay: &'a Replay,
    /// At the modelled ticks, m; not a number where a sample is missing.
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
    /// Of each tick over position and velocity at the start of its piece.
    by_state: [Vec<f64>; 2],
}

/// The end of the search.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) model: Model,
    /// Model less record, m; 0 where a sample is missing.
    pub(super) left: Vec<f64>,
    /// Slopes of the residuals over the numbers, a row for each number, without what the states at the starts can make.
    pub(super) slopes: Vec<Vec<f64>>,
    /// Ticks of each piece.
    pub(super) pieces: Vec<Range<usize>>,
    pub(super) numbers: &'static [Number],
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
            Number::Lag => start.lag,
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

    /// Searches from here.
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
        // Before the first there is none.
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
            Number::Lag => LAG_STEP,
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

/// The model at these coordinates.
fn model(numbers: &[Number], theta: &DVector<f64>) -> Model {
    let mut model = Model::BARE;
    for (number, &x) in numbers.iter().zip(theta.iter()) {
        match number {
            Number::Mass => model.mass = libm::exp(x.clamp(-16.0, 9.0)),
            Number::Damping => model.damping = x.abs(),
            Number::Friction => model.friction = x.abs(),
            Number::Bias => model.bias = x,
            Number::Lateness => model.delay = x,
            Number::Lag => model.lag = x.clamp(-DELAY_MAX, DELAY_MAX),
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
