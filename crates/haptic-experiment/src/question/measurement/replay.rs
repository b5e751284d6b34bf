//! The model of the device run through the forces of a record, in pieces, each with a state of its own at its start.

use super::record::MotionRecord;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{
    Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond, Seconds,
};
use haptic_loop::{Device, ParameterError, SafeForce, SafetyChain, SafetyState};
use nalgebra::Vector1;

/// Longest delay that is looked for, samples.
pub(super) const DELAY_MAX: f64 = 60.0;
/// Negative delays down to this are modelled too, samples: forces that act before they were given.
pub(super) const EARLY_MAX: f64 = 4.0;
/// Shorter lags than this share of a sample count as none: the force is off by less than any rounding of a position.
const NO_LAG: f64 = 1e-4;

/// Numbers of the model, in SI units; the delay and the lag in samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    pub(super) mass: f64,
    pub(super) damping: f64,
    pub(super) friction: f64,
    /// Constant force, N.
    pub(super) bias: f64,
    pub(super) delay: f64,
    /// A negative one stands for the motion that is as far from that without lag, on its other side.
    pub(super) lag: f64,
    /// Of the hand.
    pub(super) stiffness: f64,
}

impl Model {
    /// A mass of 1 kg, and nothing else.
    pub(super) const BARE: Self = Self {
        mass: 1.0,
        damping: 0.0,
        friction: 0.0,
        bias: 0.0,
        delay: 0.0,
        lag: 0.0,
        stiffness: 0.0,
    };

    /// The same with another lag, and as late in all.
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
    pub(super) parts: u32,
    /// First tick of each piece; the last ends with the record.
    pub(super) starts: Vec<usize>,
}

impl Replay {
    /// The forces of a record, as they were applied: a chain that limits nothing hands them on.
    pub(super) fn new(record: &MotionRecord, starts: Vec<usize>) -> Result<Self, ParameterError> {
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

    /// First modelled tick.
    pub(super) fn from(&self) -> usize {
        self.starts.first().copied().unwrap_or(self.forces.len())
    }

    /// Modelled ticks.
    pub(super) fn len(&self) -> usize {
        self.forces.len() - self.from()
    }

    /// Ticks of each piece, counted from the first modelled one.
    pub(super) fn pieces(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let (from, end) = (self.from(), self.forces.len());
        let ends = self.starts.iter().skip(1).copied().chain([end]);
        (self.starts.iter().zip(ends)).map(move |(&start, end)| start - from..end - from)
    }

    /// Positions of the model at the modelled ticks, and the states in which it comes to the start of each piece from the one before;
    /// `None` if there is no such device.
    pub(super) fn run(&self, model: &Model, states: &[State]) -> Option<(Vec<f64>, Vec<State>)> {
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
            lag: Seconds(if lag > NO_LAG { lag * t } else { 0.0 }),
        })
        .ok()?;
        device.set_external_force(Vector1::new(model.bias));
        let from = self.from();
        // A current that has forgotten where it began.
        let before = from.saturating_sub(2 + 40 * lag.min(10.0) as usize);
        let mut pieces = self.starts.iter().zip(states).peekable();
        let mut positions = Vec::with_capacity(self.len());
        let mut arrivals = Vec::with_capacity(states.len());
        for tick in before..self.forces.len() {
            if let Some((_, [x, v])) = pieces.next_if(|(start, _)| **start == tick) {
                arrivals.push([device.position()[0], device.velocity()[0]]);
                device.set_state(Vector1::new(*x), Vector1::new(*v));
            }
            if tick >= from {
                positions.push(device.position()[0]);
            }
            let given = tick.saturating_add_signed(-whole as isize);
            let force = self.forces.get(given).or(self.forces.last())?;
            for _ in 0..self.parts {
                device.write(*force).unwrap_or_else(|never| match never {});
            }
        }
        let is_finite = positions.iter().all(|x| x.is_finite());
        is_finite.then_some((positions, arrivals))
    }
}
