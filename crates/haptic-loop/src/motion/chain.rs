//! The motion chain: the only way for a velocity to become a [`SafeMotion`].
//!
//! ```text
//! reading ─▶ finite? ─▶ age ─▶ saturated, stuck, too large, not following? ─▶ offset ─▶ dead band ─▶ f_m
//! wanted  ─▶ finite? ─▶ jerk ─▶ speed per axis and by norm ─▶ acceleration ─▶ braking before an end ─▶ energy of the hand's port ─▶ SafeMotion
//! ```
//! - *After a fault or stop* each axis goes to rest by a·T a sample, whatever is wanted, and stays at rest until the robot is armed again.
//!   No speed grows on the way.
//! - *Always able to stop*: with x and v of this tick, the way to rest T·(v + (v − aT) + …) ends inside. A velocity is only taken if
//!   ```text
//!   (v + aT/2)²/(2a) ≤ room      the way itself is at most (aT/2)·T/4 shorter
//!   ```
//!   else the axis brakes; so a way to rest that was inside stays inside, tick by tick.
//! - *Rounding*: speed and ends hold exactly, the acceleration to one rounding of the velocity. For the ends a is taken smaller, and each end
//!   nearer, by what rounding could add up to.
//! - *Cost*: some fifty operations an axis; a square root for a dead band on more than one axis, one where a speed is cut by its norm,
//!   and one an axis near an end or with a limit of jerk; no allocation, no panic.

use super::limits::MotionLimits;
use super::state::{AtRest, MotionFault, MotionStartRefused, MotionState, Rest};
use super::{MotionReading, SafeMotion, finite};
use crate::error::{Checks, LoopParameterError};
use crate::safety::Limiters;
use crate::safety::clamps::{clamp, largest, norm, square};
use crate::units::{Metres, Seconds};
use core::array;
use fracdiff::Real;
use nalgebra::SVector;

/// The chain's immutable part.
///
/// ```
/// use fracdiff::Seconds;
/// use haptic_loop::units::{Metres, MetresPerSecond, MetresPerSecondSquared, Newtons};
/// use haptic_loop::{MotionChain, MotionFault, MotionLimits, MotionReading, MotionState};
/// use nalgebra::vector;
///
/// let (speed, acceleration) = (MetresPerSecond(0.5), MetresPerSecondSquared(5.0));
/// let limits = MotionLimits::of(speed, acceleration, [Metres(-0.2)], [Metres(0.2)], Newtons(50.0));
/// let chain = MotionChain::new(&limits, Seconds(1e-3))?;
/// let mut state = MotionState::default();
/// let mut reading = MotionReading {
///     tick: 0, time_s: 0.0, position_m: vector![0.1], sensed_force_n: vector![0.0], force_age_s: 0.0,
/// };
/// // Nothing moves before the resting sensor was watched for 0.2 s.
/// for _ in 0..200 {
///     chain.rest(&mut state, &reading);
/// }
/// chain.arm(&mut state, &reading).expect("may be armed");
/// // 2 m/s are wanted at once: 5 mm/s more in a tick of 1 ms.
/// chain.sense(&mut state, &reading);
/// let (motion, _) = chain.apply(&mut state, &vector![2.0]);
/// assert_eq!(*motion.metres_per_second(), vector![5e-3]);
/// // A sensor that shows no number brings the command to rest, and holds it.
/// (reading.tick, reading.sensed_force_n) = (1, vector![f64::NAN]);
/// chain.sense(&mut state, &reading);
/// let (motion, _) = chain.apply(&mut state, &vector![2.0]);
/// assert_eq!(*motion.metres_per_second(), vector![0.0]);
/// assert_eq!(state.fault(), Some(MotionFault::NotFinite));
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionChain<F, const D: usize> {
    sample_time: F,
    speed: F,
    /// 1 − 2⁻²⁰ of the limit, which is aimed at, and its square.
    speed_norm: Option<[F; 2]>,
    /// A wanted velocity of no larger square, (m/s)², is within all of these, and is not softened.
    free_square: F,
    /// a·T, m/s.
    step: F,
    /// 2a of the ways to rest that must stay inside, and a·T/2 of it.
    twice_plan: F,
    half_step: F,
    /// j·T², m/s.
    jerk: Option<F>,
    low: [F; D],
    high: [F; D],
    sensor_range: F,
    /// Square of the largest magnitude, N².
    force_square: F,
    following: F,
    force_age: F,
    stuck: Option<Standstill<F>>,
    /// N.
    offset: F,
    rest_ticks: u32,
    dead_band: F,
    hand_energy: Option<F>,
}

/// The share of a limit that is aimed at, so that no rounding passes it.
const INSIDE: f64 = 1.0 - 1.0 / 1_048_576.0;

/// See [`StuckSensor`](super::StuckSensor).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Standstill<F> {
    travel: F,
    ticks: F,
}

impl<F: Real, const D: usize> MotionChain<F, D> {
    /// A chain with these limits.
    ///
    /// # Errors
    /// A limit outside the range that its field states, or that of the loop's number type; an acceleration that the number type
    /// loses beside the speed; a sample time that is not above zero.
    pub fn new(limits: &MotionLimits<D>, sample_time: Seconds) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let chain = Self::checked(limits, sample_time, &mut checks);
        checks.done().map(|()| chain)
    }

    fn checked(limits: &MotionLimits<D>, sample_time: Seconds, checks: &mut Checks) -> Self {
        let sample_time = checks.positive("sample time", sample_time.0, "s");
        let speed = checks.positive("speed limit", limits.speed.0, "m/s");
        let speed_norm = limits.speed_norm.map(|norm| {
            let norm = checks.positive("speed norm limit", norm.0, "m/s");
            let aim = norm * INSIDE;
            [aim, aim * aim].map(|number| checks.rounded("speed norm limit", number, "m/s"))
        });
        let within = square(&SVector::<F, 1>::from([F::from_f64(speed * INSIDE)]));
        let least = |[_, square]: [F; 2]| if square < within { square } else { within };
        // A square that is no normal number bounds nothing.
        let free_square = if limits.jerk.is_some() || within < F::NEGLIGIBLE {
            -F::ONE
        } else {
            speed_norm.map_or(within, least)
        };
        checks.positive("acceleration limit", limits.acceleration.0, "m/s²");
        if let Some(norm) = limits.acceleration_norm {
            checks.positive("acceleration norm limit", norm.0, "m/s²");
        }
        let acceleration = limits.axis_acceleration();
        let step = acceleration * sample_time;
        // Each a·T that is taken off a velocity is right to half a digit of the velocity.
        let share = INSIDE - speed / step * F::EPSILON.to_f64();
        let allowed = "so large that a sample changes a velocity in this number type: raise it, or lower the speed limit";
        let what = "acceleration limit";
        checks.range(what, acceleration, share > 0.5, allowed, "m/s²");
        let plan = acceleration * share;
        let jerk = limits.jerk.map(|jerk| {
            let jerk = checks.positive("jerk limit", jerk.0, "m/s³");
            checks.rounded("jerk limit", jerk * sample_time * sample_time, "m/s")
        });
        let (low, high) = ends(limits, checks);
        let range = checks.positive("range of the force sensor", limits.sensor_range.0, "N");
        let (force, what_force) = (limits.force.0, "limit of the sensed force");
        let allowed = "above 0 and at most the sensor's range, beyond which nothing is seen";
        checks.range(
            what_force,
            force,
            force > 0.0 && force <= range,
            allowed,
            "N",
        );
        checks.positive("limit of the following error", limits.following.0, "m");
        checks.not_negative("age of the force", limits.force_age.0, "s");
        let share = limits.offset_share;
        let allowed = "from 0 to 1, a share of the sensor's range";
        checks.range(
            "offset at rest",
            share,
            (0.0..=1.0).contains(&share),
            allowed,
            "",
        );
        let rest = limits.rest_time.0;
        let within = (1e-3..=60.0).contains(&rest);
        checks.range("time at rest", rest, within, "from 1 ms to 60 s", "s");
        checks.not_negative("dead band", limits.dead_band.0, "N");
        let hand_energy = limits.hand_energy.map(|energy| {
            let energy = checks.positive("energy to the hand", energy.0, "J");
            checks.rounded("energy to the hand", energy, "J")
        });
        // More than 2²³ could not be counted in single precision.
        let ticks =
            |time: f64| libm::ceil(time / sample_time * (1.0 - 1e-6)).clamp(1.0, 8_388_608.0);
        Self {
            sample_time: checks.rounded("sample time", sample_time, "s"),
            speed: checks.rounded("speed limit", speed, "m/s"),
            speed_norm,
            free_square,
            step: checks.rounded("acceleration limit", step, "m/s"),
            twice_plan: checks.rounded("acceleration limit", 2.0 * plan, "m/s²"),
            half_step: checks.rounded("acceleration limit", 0.5 * plan * sample_time, "m/s"),
            jerk,
            low,
            high,
            sensor_range: checks.rounded("range of the force sensor", range, "N"),
            force_square: checks.rounded(what_force, force * force, "N"),
            following: checks.rounded("limit of the following error", limits.following.0, "m"),
            force_age: checks.rounded("age of the force", limits.force_age.0, "s"),
            stuck: limits.stuck.map(|stuck| {
                let travel = checks.positive("travel with a stuck sensor", stuck.travel.0, "m");
                let within = (1e-3..=10.0).contains(&stuck.time.0);
                let (what, allowed) = ("time of a stuck sensor", "in [0.001, 10] {}");
                checks.range(what, stuck.time.0, within, allowed, "s");
                Standstill {
                    travel: checks.rounded("travel with a stuck sensor", travel, "m"),
                    ticks: checks.rounded(what, ticks(stuck.time.0), "samples"),
                }
            }),
            offset: checks.rounded("offset at rest", share * range, "N"),
            rest_ticks: ticks(rest) as u32,
            dead_band: checks.rounded("dead band", limits.dead_band.0, "N"),
            hand_energy,
        }
    }

    /// Takes a reading of the resting sensor, which is not armed: the robot must stand still, and nobody touch the handle. Readings older
    /// than two [rests](MotionLimits::rest_time) are forgotten, so that a robot may rest for as long as it likes.
    pub fn rest(&self, state: &mut MotionState<F, D>, reading: &MotionReading<F, D>) {
        let shown = &reading.sensed_force_n;
        if state.driven || !state.is_at_rest() || !finite(shown) {
            (state.rest, state.rested) = (Rest::default(), Rest::default());
            return;
        }
        if state.rest.count == self.rest_ticks {
            state.rested = core::mem::take(&mut state.rest);
        }
        let rest = &mut state.rest;
        if rest.count == 0 {
            (rest.first, rest.least, rest.most) = (*shown, *shown, *shown);
        }
        for (axis, &force) in shown.iter().enumerate() {
            rest.sum[axis] += force - rest.first[axis];
            if force < rest.least[axis] {
                rest.least[axis] = force;
            }
            if force > rest.most[axis] {
                rest.most[axis] = force;
            }
        }
        rest.count += 1;
    }

    /// Arms the robot at this reading: the offset of the sensor is taken off from now on, the command begins where the robot stands, and an
    /// old fault is forgotten. The readings of the resting sensor are used up.
    ///
    /// # Errors
    /// The command moves; the sensor was not watched for [`MotionLimits::rest_time`]; its offset or its spread is above
    /// [`MotionLimits::offset_share`] of its range; the robot stands outside; this reading would be a fault. Nothing changes then but that the
    /// sensor is watched anew.
    pub fn arm(
        &self,
        state: &mut MotionState<F, D>,
        reading: &MotionReading<F, D>,
    ) -> Result<AtRest<F, D>, MotionStartRefused> {
        let rested = core::mem::take(&mut state.rested);
        let rest = rested.and(&core::mem::take(&mut state.rest));
        if !state.is_at_rest() {
            return Err(MotionStartRefused::Moves);
        }
        if rest.count < self.rest_ticks {
            return Err(MotionStartRefused::TooShort {
                have: rest.count,
                need: self.rest_ticks,
            });
        }
        let count = F::from_f64(f64::from(rest.count));
        let at_rest = AtRest {
            offset_n: SVector::from(array::from_fn(|axis| {
                rest.first[axis] + rest.sum[axis] / count
            })),
            spread_n: SVector::from(array::from_fn(|axis| rest.most[axis] - rest.least[axis])),
        };
        let most_n = self.offset.to_f64();
        let offset_n = largest(&at_rest.offset_n).to_f64();
        if offset_n > most_n {
            return Err(MotionStartRefused::Offset { offset_n, most_n });
        }
        let spread_n = largest(&at_rest.spread_n).to_f64();
        if spread_n > most_n {
            return Err(MotionStartRefused::Unsteady { spread_n, most_n });
        }
        let mut begun = MotionState {
            driven: true,
            offset: at_rest.offset_n,
            position: reading.position_m,
            ..MotionState::default()
        };
        self.check(&mut begun, reading)
            .map_err(MotionStartRefused::Fault)?;
        for (axis, &x) in reading.position_m.iter().enumerate() {
            if x < self.low[axis] || x > self.high[axis] {
                let position_m = x.to_f64();
                return Err(MotionStartRefused::Outside { axis, position_m });
            }
        }
        *state = begun;
        Ok(at_rest)
    }

    /// `f_m`, N: the sensed force of a reading without offset and dead band. A reading that is a fault latches it; it and every one after
    /// it, as one before the robot is armed, gives none.
    #[inline]
    pub fn sense(
        &self,
        state: &mut MotionState<F, D>,
        reading: &MotionReading<F, D>,
    ) -> SVector<F, D> {
        let missed = reading.tick.saturating_sub(state.next);
        state.next = reading.tick.wrapping_add(1);
        if missed > 0 {
            self.pass(state, missed);
        }
        if state.driven {
            match self.check(state, reading) {
                Ok(()) if self.dead_band > F::ZERO => return self.beyond_dead_band(&state.force),
                Ok(()) => return state.force,
                Err(fault) => state.trip(fault),
            }
        }
        SVector::from([F::ZERO; D])
    }

    #[inline(never)]
    fn beyond_dead_band(&self, force: &SVector<F, D>) -> SVector<F, D> {
        // The only root of a usual tick.
        let norm = norm(force);
        let left = norm - self.dead_band;
        let share = if left > F::ZERO { left / norm } else { F::ZERO };
        force.map(|axis| axis * share)
    }

    /// Ticks that did not come: the command was held.
    #[inline(never)]
    fn pass(&self, state: &mut MotionState<F, D>, missed: u64) {
        // More than 2³² make no difference.
        let missed = F::from_f64(f64::from(u32::try_from(missed).unwrap_or(u32::MAX)));
        let time = missed * self.sample_time;
        if time > self.force_age {
            state.trip(MotionFault::StaleForce);
        }
        self.integrate(state, time);
    }

    /// The faults of a reading. The comparisons of force and position are such that only finite numbers pass.
    #[inline]
    fn check(
        &self,
        state: &mut MotionState<F, D>,
        reading: &MotionReading<F, D>,
    ) -> Result<(), MotionFault> {
        let shown = &reading.sensed_force_n;
        let is_fresh = reading.force_age_s <= self.force_age;
        if !is_fresh || !reading.force_age_s.is_finite() {
            return Err(because(reading, MotionFault::StaleForce));
        }
        for (axis, &force) in shown.iter().enumerate() {
            let is_seen = force.abs() < self.sensor_range;
            if !is_seen {
                return Err(because(reading, MotionFault::SensorSaturated));
            }
            if let Some(stuck) = &self.stuck {
                if force == state.shown[axis] {
                    let (still, travel) = (&mut state.still[axis], &mut state.travel[axis]);
                    if *still < stuck.ticks {
                        *still += F::ONE;
                    }
                    *travel += state.velocity[axis].abs() * self.sample_time;
                    if *still >= stuck.ticks && *travel > stuck.travel {
                        return Err(because(reading, MotionFault::SensorStuck));
                    }
                } else {
                    (state.still[axis], state.travel[axis]) = (F::ZERO, F::ZERO);
                }
            }
            state.force[axis] = force - state.offset[axis];
            let error = state.position[axis] - reading.position_m[axis];
            let follows = error.abs() <= self.following;
            if !follows {
                return Err(because(reading, MotionFault::Following));
            }
        }
        state.shown = *shown;
        // Each axis is within the range of the sensor, so no square overflows.
        if square(&state.force) > self.force_square {
            return Err(MotionFault::Force);
        }
        Ok(())
    }

    /// Makes the velocity wanted after [`sense`](Self::sense), m/s, safe, moves the command on by a sample, and says which limiters
    /// acted: *magnitude* for the speed, *rate* for acceleration and jerk, *workspace* for braking before an end.
    #[inline]
    pub fn apply(
        &self,
        state: &mut MotionState<F, D>,
        wanted: &SVector<F, D>,
    ) -> (SafeMotion<F, D>, Limiters) {
        let mut limiters = Limiters::NONE;
        let mut velocity = state.velocity;
        if state.driven {
            if let Some(limited) = self.limited(state, wanted, &mut limiters) {
                velocity = limited;
                self.keep_books(state, &velocity);
            } else {
                state.trip(MotionFault::NotFinite);
            }
        }
        if !state.driven {
            velocity = state.velocity.map(|v| self.braked(v));
            if state.fault.is_some() {
                limiters.insert(Limiters::FAULT);
            } else {
                limiters.insert(Limiters::STOPPING);
            }
        }
        for axis in 0..D {
            state.change[axis] = velocity[axis] - state.velocity[axis];
        }
        state.velocity = velocity;
        self.integrate(state, self.sample_time);
        (SafeMotion(velocity), limiters)
    }

    /// x ← x + t·v, with what rounding takes from it.
    #[inline]
    fn integrate(&self, state: &mut MotionState<F, D>, time: F) {
        for axis in 0..D {
            let moved = state.velocity[axis] * time + state.lost[axis];
            let (x, sum) = (state.position[axis], state.position[axis] + moved);
            let kept = sum - x;
            state.lost[axis] = (x - (sum - kept)) + (moved - kept);
            state.position[axis] = sum;
        }
    }

    /// A velocity one step nearer to rest.
    #[inline]
    fn braked(&self, velocity: F) -> F {
        if velocity > self.step {
            velocity - self.step
        } else if velocity < -self.step {
            velocity + self.step
        } else {
            F::ZERO
        }
    }

    /// The nearest that can be commanded to what is wanted; `None` for a wish that is not finite.
    #[inline]
    fn limited(
        &self,
        state: &MotionState<F, D>,
        wanted: &SVector<F, D>,
        limiters: &mut Limiters,
    ) -> Option<SVector<F, D>> {
        let last = &state.velocity;
        let mut aim = *wanted;
        let is_free = square(wanted) <= self.free_square;
        if !is_free {
            self.slowed(state, &mut aim, limiters)?;
        }
        let change: SVector<F, D> = SVector::from(array::from_fn(|axis| aim[axis] - last[axis]));
        if change.iter().any(|axis| axis.abs() > self.step) {
            self.nearer(last, change, &mut aim, limiters);
        }
        for axis in 0..D {
            let (v, x) = (aim[axis], state.position[axis]);
            let (room, sign) = if v > F::ZERO {
                (self.high[axis] - x, F::ONE)
            } else {
                (x - self.low[axis], -F::ONE)
            };
            // (v + aT/2)² ≤ 2a·room, without a root
            let reach = v.abs() + self.half_step;
            if reach * reach > self.twice_plan * room {
                aim[axis] = self.held_back(v, last[axis], room, sign, limiters);
            }
        }
        Some(aim)
    }

    /// v = p + λ(q − p), a step from p: both within the speeds, which are convex, so v is.
    #[inline(never)]
    fn nearer(
        &self,
        last: &SVector<F, D>,
        change: SVector<F, D>,
        aim: &mut SVector<F, D>,
        limiters: &mut Limiters,
    ) {
        limiters.insert(Limiters::RATE);
        let share = self.step / largest(&change);
        for axis in 0..D {
            let change = clamp(change[axis] * share, -self.step, self.step);
            aim[axis] = clamp(last[axis] + change, -self.speed, self.speed);
        }
    }

    /// A velocity from which the way to rest is no longer than the room, or one that brakes, whichever can be reached in a sample.
    #[inline(never)]
    fn held_back(&self, v: F, last: F, room: F, sign: F, limiters: &mut Limiters) -> F {
        let room = if room > F::ZERO { room } else { F::ZERO };
        let speed = (self.twice_plan * room).sqrt() - self.half_step;
        let speed = if speed > F::ZERO { speed } else { F::ZERO };
        if v.abs() <= speed || v == F::ZERO {
            return v;
        }
        limiters.insert(Limiters::WORKSPACE);
        let slower = sign * speed;
        if (slower - last).abs() <= self.step {
            slower
        } else {
            self.braked(last)
        }
    }

    /// Softens a velocity by the limit of jerk, and scales it into the speed limits, on the line to 0; `None` if it is not finite.
    #[inline(never)]
    fn slowed(
        &self,
        state: &MotionState<F, D>,
        aim: &mut SVector<F, D>,
        limiters: &mut Limiters,
    ) -> Option<()> {
        if !finite(aim) {
            return None;
        }
        if let Some(jerk) = self.jerk {
            self.soften(state, jerk, aim, limiters);
        }
        let most = largest(aim);
        if most > self.speed {
            limiters.insert(Limiters::MAGNITUDE);
            // The quotient first: it is at most 1, whatever is wanted.
            *aim = aim.map(|axis| clamp(axis / most * self.speed, -self.speed, self.speed));
        }
        if let Some([allowed, allowed_square]) = self.speed_norm {
            let square = square(aim);
            if square > allowed_square {
                limiters.insert(Limiters::MAGNITUDE);
                let share = allowed / square.sqrt();
                *aim = aim.map(|axis| axis * share);
            }
        }
        Some(())
    }

    /// A change that differs from the last one by j·T² at most, and fades in time where the wanted velocity is.
    #[inline(never)]
    fn soften(
        &self,
        state: &MotionState<F, D>,
        step: F,
        aim: &mut SVector<F, D>,
        limiters: &mut Limiters,
    ) {
        for axis in 0..D {
            let way = aim[axis] - state.velocity[axis];
            let far = way.abs();
            // As for the ends, (c + jT²/2)²/(2jT²) ≤ far.
            let most = if far > step {
                (step * (far + far)).sqrt() - step * F::from_f64(0.5)
            } else {
                far
            };
            let change = if way < F::ZERO { -most } else { most };
            let last = state.change[axis];
            let change = clamp(change, last - step, last + step);
            if change != way {
                limiters.insert(Limiters::RATE);
                aim[axis] = state.velocity[axis] + change;
            }
        }
    }

    /// E ← max(0, E − f·v·T): energy given to the hand since the hand had last paid for everything.
    #[inline]
    fn keep_books(&self, state: &mut MotionState<F, D>, velocity: &SVector<F, D>) {
        let Some(most) = self.hand_energy else {
            return;
        };
        let mut power = F::ZERO;
        for axis in 0..D {
            power += state.force[axis] * velocity[axis];
        }
        let energy = state.energy - power * self.sample_time;
        state.energy = if energy > F::ZERO { energy } else { F::ZERO };
        if energy > most {
            state.trip(MotionFault::HandEnergy);
        }
    }
}

/// The fault of a reading, which is another one where a number of it is not finite.
#[cold]
#[inline(never)]
fn because<F: Real, const D: usize>(
    reading: &MotionReading<F, D>,
    fault: MotionFault,
) -> MotionFault {
    let whole = finite(&reading.sensed_force_n) && finite(&reading.position_m);
    if whole && reading.force_age_s.is_finite() {
        fault
    } else {
        MotionFault::NotFinite
    }
}

/// The ends of the command, nearer by what rounding of a position could add up to.
fn ends<F: Real, const D: usize>(
    limits: &MotionLimits<D>,
    checks: &mut Checks,
) -> ([F; D], [F; D]) {
    for (&Metres(low), &Metres(high)) in limits.low.iter().zip(&limits.high) {
        checks.range("low end of the workspace", low, true, "finite", "m");
        let (what, allowed) = ("high end of the workspace", "above the low one");
        checks.range(what, high, high > low, allowed, "m");
    }
    let ends = limits.low.iter().chain(&limits.high);
    let farthest = ends.fold(0.0, |most, end| f64::max(most, end.0.abs()));
    let margin = 8.0 * F::EPSILON.to_f64() * farthest;
    let mut inside =
        |end: f64| F::from_f64(checks.range("end of the workspace", end, true, "finite", "m"));
    (
        limits.low.map(|end| inside(end.0 + margin)),
        limits.high.map(|end| inside(end.0 - margin)),
    )
}
