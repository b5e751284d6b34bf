//! A simulated robot that takes a velocity, in a hand that it feels by a force sensor.

use super::discretise::{moved, transition};
use super::mass_damper::{MAX_DELAY_SAMPLES, whole_and_fraction};
use super::noise::normal;
use crate::error::Checks;
use crate::units::{
    Hertz, Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, Seconds,
};
use crate::{LoopParameterError, MotionReading, MovingDevice, SafeMotion};
use core::convert::Infallible;
use core::f64::consts::TAU;
use fracdiff::Real;
use nalgebra::{SMatrix, SVector};
use rand_pcg::{Pcg32, rand_core::SeedableRng};

/// Most states of a robot's velocity loop.
pub const LOOP_STATES: usize = 4;
/// Most lags of its force sensor.
pub const SENSOR_LAGS: usize = 4;

/// G, the velocity of a robot over its command: ż = A·z + B·u, v = C·z, all in m/s and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotLoop {
    /// A, 1/s. States that are not needed have rows and columns of 0.
    pub a: SMatrix<f64, LOOP_STATES, LOOP_STATES>,
    /// B, 1/s.
    pub b: SVector<f64, LOOP_STATES>,
    /// C.
    pub c: SVector<f64, LOOP_STATES>,
}

impl RobotLoop {
    /// G(s) = ω²/(s² + 2ζω·s + ω²), ω = 2π times the natural frequency.
    ///
    /// # Errors
    /// Frequency and damping ratio must be finite and above 0.
    pub fn second_order(
        natural_frequency: Hertz,
        damping_ratio: f64,
    ) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let frequency = natural_frequency.0;
        let rate = TAU * checks.positive("natural frequency of the robot", frequency, "Hz");
        let damping = 2.0 * checks.positive("damping ratio of the robot", damping_ratio, "");
        checks.done()?;
        // z = (v, v̇/ω)
        let (mut a, mut b, mut c) = (SMatrix::zeros(), SVector::zeros(), SVector::zeros());
        (a[(0, 1)], a[(1, 0)], a[(1, 1)]) = (rate, -rate, -damping * rate);
        (b[1], c[0]) = (rate, 1.0);
        Ok(Self { a, b, c })
    }
}

/// The hand at a robot's handle, with the mass of the tool beyond the sensor and the stiffness of what the handle touches.
///
/// ```text
/// f = −m·v̇ − b·v − k·(x − x_h) + f_h        force on the robot, N
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotHand {
    /// m ≥ 0.
    pub mass: Kilograms,
    /// b ≥ 0.
    pub damping: NewtonSecondsPerMetre,
    /// k ≥ 0, about the place `x_h` where the hand wants to be.
    pub stiffness: NewtonsPerMetre,
}

impl RobotHand {
    /// 1.5 kg, 20 N·s/m and no stiffness.
    #[must_use]
    pub const fn relaxed() -> Self {
        Self {
            mass: Kilograms(1.5),
            damping: NewtonSecondsPerMetre(20.0),
            stiffness: NewtonsPerMetre(0.0),
        }
    }
}

/// Parameters of a [`SimulatedRobot`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedRobotConfig {
    /// T > 0, the time from one command to the next.
    pub sample_time: Seconds,
    /// G.
    pub motion: RobotLoop,
    /// τ, time from a command to its effect, 0 to 64 sample times, not necessarily whole.
    pub dead_time: Seconds,
    /// The hand at the handle.
    pub hand: RobotHand,
    /// First-order lags of the force sensor's filter, 0 to [`SENSOR_LAGS`].
    pub sensor_lags: usize,
    /// Cut-off frequency of each lag, above 0.
    pub sensor_bandwidth: Hertz,
    /// Largest force that the sensor shows, N, above 0.
    pub sensor_range: Newtons,
    /// σ of the sensor's noise, N, at least 0; white, one number per axis and reading.
    pub sensor_noise: Newtons,
    /// Force of a count of the sensor, N; 0 for none.
    pub sensor_resolution: Newtons,
    /// σ of the noise of the measured position, m, at least 0; white, one number per axis and reading.
    pub position_noise: Metres,
    /// A count of the measured position, m; 0 for none.
    pub position_resolution: Metres,
    /// The seed of both noises: the same seed makes the same noise, bit for bit.
    pub seed: u64,
}

impl SimulatedRobotConfig {
    /// A robot without dead time, and with an ideal sensor of 100 N.
    #[must_use]
    pub const fn of(sample_time: Seconds, motion: RobotLoop, hand: RobotHand) -> Self {
        Self {
            sample_time,
            motion,
            dead_time: Seconds(0.0),
            hand,
            sensor_lags: 0,
            sensor_bandwidth: Hertz(30.0),
            sensor_range: Newtons(100.0),
            sensor_noise: Newtons(0.0),
            sensor_resolution: Newtons(0.0),
            position_noise: Metres(0.0),
            position_resolution: Metres(0.0),
            seed: 0,
        }
    }
}

/// A fault of a force sensor, for tests of what must bear it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorTrouble {
    /// It shows no number.
    NotANumber,
    /// It shows the last force for ever, as if it were new.
    Stuck,
    /// It shows so much more, N, on each axis.
    Offset(f64),
    /// It shows so many times the force.
    Gain(f64),
    /// Nothing comes any more: the last force grows old.
    Silent,
    /// It shows the last 64 forces again and again.
    Replayed,
}

/// States: x, z, lags of the sensor, the held command u and force `f_h + k·x_h`.
const STATES: usize = 3 + LOOP_STATES + SENSOR_LAGS;
const LOOP: usize = 1;
const LAGS: usize = LOOP + LOOP_STATES;
const COMMAND: usize = LAGS + SENSOR_LAGS;
const PUSH: usize = COMMAND + 1;

/// Forces that are shown again.
const REPLAYED: usize = 64;

type State = SVector<f64, STATES>;

/// A robot with D equal and independent axes: its velocity loop, a force sensor with lags, a hand.
///
/// ```text
/// v = G(s)·e^(−τs)·u,   ẋ = v,   f = −m·v̇ − b·v − k·(x − x_h) + f_h        sensed = f/(1 + s/ω_f)ⁿ
/// ```
/// - *Symbols*: u commanded velocity m/s, held for one sample time T; `x_h` m and `f_h` N, where the hand wants to be and what it pushes, constant
///   until set again; f force of the hand on the robot. The robot is stiff: f does not move it, only its sensor.
/// - *Exact* at the sample instants, for any loop, hand, lags and dead time, by the matrix exponential; a dead time of (d + η)·T splits each
///   sample at η·T.
/// - *Start-up*: at rest at 0. *Output*: a reading is of the instant before the command of its tick.
/// - *Cost* per sample: one 11×11 product per axis, two with a fraction of dead time; no allocation, no panic.
///
/// Source: as [`MassDamper`](super::MassDamper).
#[derive(Clone, Debug)]
pub struct SimulatedRobot<const D: usize> {
    config: SimulatedRobotConfig,
    delay: usize,
    /// η·T under the older command, if η > 0, and the rest of the sample.
    before: Option<SMatrix<f64, STATES, STATES>>,
    after: SMatrix<f64, STATES, STATES>,
    /// f = force·state.
    force: State,
    states: [State; D],
    commands: [SVector<f64, D>; MAX_DELAY_SAMPLES + 1],
    newest: usize,
    target: SVector<f64, D>,
    push: SVector<f64, D>,
    generator: Pcg32,
    trouble: Option<SensorTrouble>,
    /// Forces that the sensor showed lately, N, and the tick of the last.
    shown: [SVector<f64, D>; REPLAYED],
    shown_tick: u64,
    tick: u64,
}

impl<const D: usize> SimulatedRobot<D> {
    /// A robot at rest at position 0.
    ///
    /// # Errors
    /// Each parameter must be finite and in the range its field states, and the fastest motion below 1e6 per sample.
    pub fn new(config: SimulatedRobotConfig) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let sample_time = checks.positive("sample time", config.sample_time.0, "s");
        checks.not_negative("hand mass", config.hand.mass.0, "kg");
        checks.not_negative("hand damping", config.hand.damping.0, "N·s/m");
        checks.not_negative("hand stiffness", config.hand.stiffness.0, "N/m");
        let (lags, most) = (config.sensor_lags as f64, config.sensor_lags <= SENSOR_LAGS);
        checks.range("lags of the force sensor", lags, most, "at most 4", "");
        checks.positive(
            "bandwidth of the force sensor",
            config.sensor_bandwidth.0,
            "Hz",
        );
        checks.positive("range of the force sensor", config.sensor_range.0, "N");
        checks.not_negative("noise of the force sensor", config.sensor_noise.0, "N");
        checks.not_negative(
            "resolution of the force sensor",
            config.sensor_resolution.0,
            "N",
        );
        let (noise, count) = (config.position_noise.0, config.position_resolution.0);
        checks.not_negative("noise of the position", noise, "m");
        checks.not_negative("resolution of the position", count, "m");
        let (delay, fraction) =
            whole_and_fraction("dead time", config.dead_time, sample_time, &mut checks);
        checks.done()?;
        let before = if fraction > 0.0 {
            Some(config.motion_in(fraction * sample_time)?)
        } else {
            None
        };
        Ok(Self {
            after: config.motion_in((1.0 - fraction) * sample_time)?,
            before,
            force: config.force(),
            config,
            delay,
            states: [State::zeros(); D],
            commands: [SVector::from([0.0; D]); MAX_DELAY_SAMPLES + 1],
            newest: 0,
            target: SVector::from([0.0; D]),
            push: SVector::from([0.0; D]),
            generator: Pcg32::seed_from_u64(config.seed),
            trouble: None,
            shown: [SVector::from([0.0; D]); REPLAYED],
            shown_tick: 0,
            tick: 0,
        })
    }

    /// Sets `x_h`, m: where the hand wants to be.
    pub fn set_hand_target(&mut self, target: SVector<f64, D>) {
        self.target = target;
        self.grip();
    }

    /// Sets `f_h`, N: what the hand pushes besides.
    pub fn set_hand_force(&mut self, push: SVector<f64, D>) {
        self.push = push;
        self.grip();
    }

    fn grip(&mut self) {
        for axis in 0..D {
            let pull = self.config.hand.stiffness.0 * self.target[axis];
            self.states[axis][PUSH] = self.push[axis] + pull;
        }
    }

    /// Gives the sensor a fault, or takes it away.
    pub const fn set_trouble(&mut self, trouble: Option<SensorTrouble>) {
        self.trouble = trouble;
    }

    /// True position now, m, of each axis.
    #[must_use]
    pub fn position(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.states[axis][0])
    }

    /// True velocity now, m/s, of each axis.
    #[must_use]
    pub fn velocity(&self) -> SVector<f64, D> {
        let rows = LOOP..LOOP + LOOP_STATES;
        let velocity = |state: &State| {
            let parts = rows.clone().zip(self.config.motion.c.iter());
            parts.map(|(row, c)| c * state[row]).sum()
        };
        SVector::from_fn(|axis, _| velocity(&self.states[axis]))
    }

    /// f now, N: the true force of the hand on the robot.
    #[must_use]
    pub fn hand_force(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.force.dot(&self.states[axis]))
    }

    /// The parameters it was made from.
    #[must_use]
    pub const fn config(&self) -> &SimulatedRobotConfig {
        &self.config
    }

    /// A command that was given `age` commands before the newest.
    fn aged(&self, age: usize) -> SVector<f64, D> {
        self.commands[(self.newest + MAX_DELAY_SAMPLES + 1 - age) % (MAX_DELAY_SAMPLES + 1)]
    }

    /// Moves on by a sample under this velocity, m/s.
    fn advance(&mut self, velocity: SVector<f64, D>) {
        self.newest = (self.newest + 1) % (MAX_DELAY_SAMPLES + 1);
        self.commands[self.newest] = velocity;
        let (newer, older) = (self.aged(self.delay), self.aged(self.delay + 1));
        for (axis, state) in self.states.iter_mut().enumerate() {
            if let Some(before) = &self.before {
                state[COMMAND] = older[axis];
                *state = moved(before, state);
            }
            state[COMMAND] = newer[axis];
            *state = moved(&self.after, state);
        }
        self.tick += 1;
    }

    /// The force that the sensor shows in this tick, N.
    fn show(&mut self) -> SVector<f64, D> {
        let lags = self.config.sensor_lags;
        let forces = if lags > 0 {
            SVector::from_fn(|axis, _| self.states[axis][LAGS + lags - 1])
        } else {
            self.hand_force()
        };
        let (most, count) = (self.config.sensor_range.0, self.config.sensor_resolution.0);
        let (gain, offset) = match self.trouble {
            Some(SensorTrouble::Gain(gain)) => (gain, 0.0),
            Some(SensorTrouble::Offset(offset)) => (1.0, offset),
            Some(SensorTrouble::NotANumber) => (f64::NAN, 0.0),
            Some(SensorTrouble::Stuck | SensorTrouble::Silent) => return self.shown[self.place()],
            Some(SensorTrouble::Replayed) => {
                return self.shown[(self.tick % REPLAYED as u64) as usize];
            }
            None => (1.0, 0.0),
        };
        let (noise, generator) = (self.config.sensor_noise.0, &mut self.generator);
        let shown = forces.map(|force| {
            let shown = counted(gain * force + offset, noise, count, generator);
            shown.clamp(-most, most)
        });
        self.shown_tick = self.tick;
        let place = self.place();
        if !gain.is_nan() {
            self.shown[place] = shown;
        }
        shown
    }

    /// The place of what was shown last.
    const fn place(&self) -> usize {
        (self.shown_tick % REPLAYED as u64) as usize
    }
}

/// A value with the noise of its sensor, in its counts.
fn counted(value: f64, noise: f64, count: f64, generator: &mut Pcg32) -> f64 {
    let noise = if noise > 0.0 {
        noise * normal(generator)
    } else {
        0.0
    };
    let shown = value + noise;
    if count > 0.0 {
        count * libm::round(shown / count)
    } else {
        shown
    }
}

impl<F: Real, const D: usize> MovingDevice<F, D> for SimulatedRobot<D> {
    type Error = Infallible;

    fn sense(&mut self) -> Result<MotionReading<F, D>, Infallible> {
        let sample_time = self.config.sample_time.0;
        let shown = self.show();
        let (noise, count) = (
            self.config.position_noise.0,
            self.config.position_resolution.0,
        );
        let position = self.position();
        let position = position.map(|x| counted(x, noise, count, &mut self.generator));
        let age = match self.trouble {
            Some(SensorTrouble::Silent) => (self.tick - self.shown_tick) as f64 * sample_time,
            Some(_) | None => 0.0,
        };
        Ok(MotionReading {
            tick: self.tick,
            time_s: self.tick as f64 * sample_time,
            position_m: position.map(F::from_f64),
            sensed_force_n: shown.map(F::from_f64),
            force_age_s: F::from_f64(age),
        })
    }

    fn command(&mut self, motion: SafeMotion<F, D>) -> Result<(), Infallible> {
        self.advance(motion.metres_per_second().map(F::to_f64));
        Ok(())
    }
}

impl SimulatedRobotConfig {
    /// f as a row over the state: −m·(C·A·z + C·B·u) − b·C·z − k·x + p.
    fn force(&self) -> State {
        let RobotLoop { a, b, c } = &self.motion;
        let [m, damping, k] = [self.hand.mass.0, self.hand.damping.0, self.hand.stiffness.0];
        let (acceleration, direct) = (a.transpose() * c, c.dot(b));
        let mut row = State::zeros();
        row[0] = -k;
        for state in 0..LOOP_STATES {
            row[LOOP + state] = -m * acceleration[state] - damping * c[state];
        }
        (row[COMMAND], row[PUSH]) = (-m * direct, 1.0);
        row
    }

    /// The motion in this time, s, command and push being constant.
    fn motion_in(&self, duration: f64) -> Result<SMatrix<f64, STATES, STATES>, LoopParameterError> {
        let RobotLoop { a, b, c } = &self.motion;
        let cutoff = TAU * self.sensor_bandwidth.0;
        let mut generator = SMatrix::<f64, STATES, STATES>::zeros();
        for row in 0..LOOP_STATES {
            generator[(0, LOOP + row)] = c[row];
            generator[(LOOP + row, COMMAND)] = b[row];
            for column in 0..LOOP_STATES {
                generator[(LOOP + row, LOOP + column)] = a[(row, column)];
            }
        }
        // ṡ₁ = ω·(f − s₁),   ṡ_i = ω·(s_(i−1) − s_i)
        for lag in LAGS..LAGS + self.sensor_lags {
            if lag == LAGS {
                generator.set_row(lag, &(self.force() * cutoff).transpose());
            } else {
                generator[(lag, lag - 1)] = cutoff;
            }
            generator[(lag, lag)] = -cutoff;
        }
        // Natural units: what a metre per second and a way of it in the fastest time make of force.
        let fastest = a.amax().max(cutoff).max(1.0 / duration);
        let hand = self.hand;
        let force = hand.mass.0 * fastest + hand.damping.0 + hand.stiffness.0 / fastest;
        let force = if force > 0.0 { force } else { 1.0 };
        let scale = State::from_fn(|state, _| match state {
            0 => 1.0 / fastest,
            _ if (LAGS..COMMAND).contains(&state) || state == PUSH => force,
            _ => 1.0,
        });
        transition(&generator, &scale, duration)
    }
}
