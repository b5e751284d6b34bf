//! Two actuators that face each other, each a device of its own, with a contact between their tips.

use super::discretise::{moved, transition};
use super::mass_damper::{MassDamper, MassDamperConfig};
use crate::LoopParameterError;
use crate::error::Checks;
use crate::units::{Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, Seconds};
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use fracdiff::parameter::range;
use nalgebra::{SMatrix, SVector};

/// The devices of a [`FacingDevices`]; its arrays are in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FacingSide {
    /// It renders a tissue: its position is the depth of the indentation.
    Renderer,
    /// It pushes along its own positive axis into the renderer.
    Indenter,
}

/// The contact of two facing devices, one-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacingContact {
    /// k > 0.
    pub stiffness: NewtonsPerMetre,
    /// c ≥ 0.
    pub damping: NewtonSecondsPerMetre,
    /// g ≥ 0, the way of the indenter until it touches a renderer at 0.
    pub gap: Metres,
    /// Fc ≥ 0, Coulomb friction between the tips while they touch.
    pub friction: Newtons,
}

impl FacingContact {
    /// That of [`RigContact::COMPLIANT`](super::RigContact::COMPLIANT): 1e5 N/m, 80 N·s/m, just touching, no friction.
    pub const COMPLIANT: Self = Self {
        stiffness: NewtonsPerMetre(1e5),
        damping: NewtonSecondsPerMetre(80.0),
        gap: Metres(0.0),
        friction: Newtons(0.0),
    };
}

impl Default for FacingContact {
    /// [`COMPLIANT`](Self::COMPLIANT).
    fn default() -> Self {
        Self::COMPLIANT
    }
}

/// Both devices and what is between them: the parameters of [`FacingDevices`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacingConfig {
    /// Both devices, in the order of [`FacingSide`]. Their sample times are those of whoever commands them; here time is continuous.
    pub devices: [MassDamperConfig; 2],
    /// One-sided contact between their tips.
    pub contact: FacingContact,
}

/// Two devices on one line of motion, each moved by its own actuator and by the other through the contact.
///
/// ```text
/// renderer:  m₁·x₁'' + b₁·x₁' + k₁·x₁ = a₁ + F + r₁      τᵢ·aᵢ' = uᵢ(t − delayᵢ) − aᵢ,  or aᵢ = uᵢ(t − delayᵢ) if τᵢ = 0
/// indenter:  m₂·x₂'' + b₂·x₂' + k₂·x₂ = a₂ − F + r₂      p = x₂ − x₁ − g
/// contact:   F = max(0, k·p + c·p' + r)  while p > 0     |r| ≤ Fc against p';  |rᵢ| ≤ Fcᵢ against xᵢ'
/// ```
/// - *Directions*: both positive axes point the same way in space, into the tissue:
///
///   | device | its position | its force |
///   |---|---|---|
///   | renderer | depth of the indentation, m, positive away from the indenter | below 0 it resists |
///   | indenter | way into the renderer, m; they touch at x₂ = x₁ + g | above 0 it pushes |
/// - *Time* is counted in units that the constructor is given, such as nanoseconds: delays are rounded to one.
/// - *Exact* while in contact or apart, by the matrix exponential, for any times between the commands. Contact that begins or ends is
///   found by bisection to one unit of time, if it lasts longer than a piece: 2^17 units, or a fifth of the fastest motion of the contact.
/// - *Energy*: the contact creates none beyond what one unit of lateness holds, k·(v·unit)².
/// - *Friction* is held over a piece and chosen to end at rest if it can, all three together, see J. J. Moreau, "Unilateral contact and
///   dry friction in finite freedom dynamics", 1988; so it is right to one piece, and that of the contact never pulls.
/// - *Start-up*: at rest, both at 0, no force on the way. *Cost*: one 8×8 product a piece, some twenty where contact changes; a queue of
///   the forces on the way, no panic.
///
/// Source: dissertation ch. VII, two facing voice coils.
#[derive(Clone, Debug)]
pub struct FacingDevices {
    config: FacingConfig,
    /// Over 1, 2, 4, … units: apart, and together.
    steps: Vec<[SMatrix<f64, STATES, STATES>; 2]>,
    delays: [u64; 2],
    state: SVector<f64, STATES>,
    /// Commands that do not act yet, with the time from which they do.
    coming: [VecDeque<(u64, f64)>; 2],
    now: u64,
}

// The state: both motions; actuator less command; command.
const X: [usize; 2] = [0, 2];
const V: [usize; 2] = [1, 3];
const LAG: [usize; 2] = [4, 5];
const FORCE: [usize; 2] = [6, 7];
const STATES: usize = 8;

/// Logarithm of the units of the longest piece.
const LONGEST: usize = 17;
/// Turn of the fastest motion in contact in a piece, rad.
const TURN: f64 = 0.2;
/// Rounds in which three frictions agree.
const ROUNDS: usize = 50;

impl FacingConfig {
    /// The state (x₁, x₁', x₂, x₂', a₁ − u₁, a₂ − u₂, u₁, u₂) after a time in which the commands are constant, from that before it; in
    /// contact, which may then pull, or apart. Without gap, friction, delay and saturation.
    ///
    /// # Errors
    /// A motion faster than 1e6 in that time.
    pub fn motion(
        &self,
        touching: bool,
        duration: Seconds,
    ) -> Result<SMatrix<f64, STATES, STATES>, LoopParameterError> {
        let mut generator = SMatrix::<f64, STATES, STATES>::zeros();
        let mut scale = SVector::<f64, STATES>::repeat(1.0);
        // F = k·p + c·p'
        let (k, c) = if touching {
            (self.contact.stiffness.0, self.contact.damping.0)
        } else {
            (0.0, 0.0)
        };
        let rate = self.rate().max(1.0 / duration.0);
        for (side, device) in self.devices.iter().enumerate() {
            let (other, m) = (1 - side, device.mass.0);
            generator[(X[side], V[side])] = 1.0;
            let forces = [
                (X[side], -k - device.stiffness.0),
                (V[side], -c - device.damping.0),
                (X[other], k),
                (V[other], c),
                (LAG[side], 1.0),
                (FORCE[side], 1.0),
            ];
            for (column, force) in forces {
                generator[(V[side], column)] = force / m;
            }
            if device.current_lag.0 > 0.0 {
                generator[(LAG[side], LAG[side])] = -1.0 / device.current_lag.0;
            }
            scale[V[side]] = rate;
            (scale[LAG[side]], scale[FORCE[side]]) = (m * rate * rate, m * rate * rate);
        }
        transition(&generator, &scale, duration.0)
    }

    /// Rate of the fastest motion of the contact, rad/s.
    fn rate(&self) -> f64 {
        let [first, second] = self.devices;
        let lightness = 1.0 / first.mass.0 + 1.0 / second.mass.0;
        let spring = libm::sqrt(self.contact.stiffness.0 * lightness);
        spring.max(self.contact.damping.0 * lightness)
    }
}

impl FacingDevices {
    /// Both at rest at their 0, with time in these units.
    ///
    /// # Errors
    /// Each parameter must be finite and in the range its field states, and the contact not faster than 1e6 rad/s nor than a fifth of a
    /// radian in a unit.
    pub fn new(config: FacingConfig, unit: Seconds) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let FacingContact {
            stiffness,
            damping,
            gap,
            friction,
        } = config.contact;
        let unit_s = checks.positive("unit of time", unit.0, "s");
        checks.positive("contact stiffness", stiffness.0, "N/m");
        checks.not_negative("contact damping", damping.0, "N·s/m");
        checks.not_negative("gap", gap.0, "m");
        checks.not_negative("contact friction", friction.0, "N");
        checks.done()?;
        for device in config.devices {
            MassDamper::<1>::new(MassDamperConfig {
                sample_time: Seconds(device.delay.0.max(unit_s)),
                ..device
            })?;
        }
        let rate = config.rate();
        let pieces = TURN / (rate * unit_s);
        let bearable = rate <= 1e6 && pieces >= 1.0;
        let (what, allowed) = ("fastest motion of the contact", "at most 1e6 {}");
        range(what, rate, bearable, allowed, "rad/s")?;
        // Rounded down.
        let longest = LONGEST.min(libm::log2(pieces) as usize);
        let steps = (0..=longest).map(|piece| {
            let duration = Seconds(libm::ldexp(unit_s, piece as i32));
            let motion = |touching| config.motion(touching, duration);
            Ok([motion(false)?, motion(true)?])
        });
        Ok(Self {
            config,
            steps: steps.collect::<Result<_, LoopParameterError>>()?,
            delays: (config.devices).map(|device| libm::round(device.delay.0 / unit_s) as u64),
            state: SVector::zeros(),
            coming: Default::default(),
            now: 0,
        })
    }

    /// Back to rest at 0, no force acting or on its way. Time continues.
    pub fn restart(&mut self) {
        self.state = SVector::zeros();
        self.coming = Default::default();
    }

    /// Time now, in the units of [`new`](Self::new).
    #[must_use]
    pub const fn now(&self) -> u64 {
        self.now
    }

    /// The parameters it was made from.
    #[must_use]
    pub const fn config(&self) -> &FacingConfig {
        &self.config
    }

    /// Position of a device, m.
    #[must_use]
    pub fn position(&self, side: FacingSide) -> f64 {
        self.state[X[side as usize]]
    }

    /// F now, N, without the friction of the contact.
    #[must_use]
    pub fn contact_force(&self) -> f64 {
        self.pressed(&self.state)
    }

    /// The command that acts on a device now, N, within its saturation.
    #[must_use]
    pub fn commanded(&self, side: FacingSide) -> f64 {
        self.state[FORCE[side as usize]]
    }

    /// Another command for a device, N, within its saturation; it acts after the delay of that device.
    pub fn command(&mut self, side: FacingSide, force: f64) {
        let side = side as usize;
        let most = self.config.devices[side].saturation;
        let most = most.map_or(f64::INFINITY, |most| most.0);
        let acts = self.now + self.delays[side];
        self.coming[side].push_back((acts, force.max(-most).min(most)));
        self.switch();
    }

    /// No force of this device from now on, as when its amplifier is switched off.
    pub fn let_go(&mut self, side: FacingSide) {
        let side = side as usize;
        self.coming[side].clear();
        (self.state[FORCE[side]], self.state[LAG[side]]) = (0.0, 0.0);
    }

    /// Moves on to a time; to one that has passed it does not.
    pub fn advance_to(&mut self, end: u64) {
        while self.now < end {
            let next = self.coming.iter().filter_map(VecDeque::front);
            let next = next.fold(end, |first, (at, _)| first.min(*at));
            while self.now < next {
                self.piece(next - self.now);
            }
            self.switch();
        }
    }

    /// Commands whose time has come.
    fn switch(&mut self) {
        for side in [0, 1] {
            while let Some(&(at, force)) = self.coming[side].front()
                && at <= self.now
            {
                self.coming[side].pop_front();
                if self.config.devices[side].current_lag.0 > 0.0 {
                    // The actuator's force continues from its present value.
                    self.state[LAG[side]] += self.state[FORCE[side]] - force;
                }
                self.state[FORCE[side]] = force;
            }
        }
    }

    /// Advances by a power of two of units, at most `most`, in which contact neither begins nor ends; by one unit it may.
    fn piece(&mut self, most: u64) {
        let touching = self.contact_force() > 0.0;
        let mut piece = (self.steps.len() - 1).min(most.ilog2() as usize);
        let mut state = self.moved(piece, touching);
        while piece > 0 && (self.pressed(&state) > 0.0) != touching {
            piece -= 1;
            state = self.moved(piece, touching);
        }
        self.state = state;
        self.now += 1 << piece;
    }

    /// F = max(0, k·p + c·p') while p > 0.
    fn pressed(&self, state: &SVector<f64, STATES>) -> f64 {
        let contact = &self.config.contact;
        let penetration = state[X[1]] - state[X[0]] - contact.gap.0;
        let rate = state[V[1]] - state[V[0]];
        if penetration > 0.0 {
            (contact.stiffness.0 * penetration + contact.damping.0 * rate).max(0.0)
        } else {
            0.0
        }
    }

    /// The state after a piece.
    fn moved(&self, piece: usize, touching: bool) -> SVector<f64, STATES> {
        let step = &self.steps[piece][usize::from(touching)];
        let mut state = self.state;
        if touching {
            // F = k·(x₂ − x₁ − g) + c·p', the matrix knows no gap.
            let missing = self.config.contact.stiffness.0 * self.config.contact.gap.0;
            state[FORCE[0]] -= missing;
            state[FORCE[1]] += missing;
        }
        let mut state = moved(step, &state);
        let [first, second] = self.config.devices.map(|device| device.friction.0);
        // It never pulls.
        let between = self.config.contact.friction.0.min(self.contact_force());
        let limits = [first, second, between];
        if limits.iter().any(|limit| *limit > 0.0) {
            let mobility = |v: usize, force: usize| step[(V[v], FORCE[force])];
            let added = friction(limits, V.map(|v| state[v]), mobility);
            for (column, force) in FORCE.into_iter().zip(added) {
                state += step.column(column) * force;
            }
        }
        for held in FORCE {
            state[held] = self.state[held];
        }
        state
    }
}

/// Both forces, N, that three frictions within these limits make on two masses of these velocities, m/s, without them; `mobility(i, j)` is
/// the velocity of i for each newton on j.
///
/// ```text
/// v = w + Σ Y·dᵢ·rᵢ,   rᵢ ← clamp(rᵢ − dᵢᵀv/(dᵢᵀY·dᵢ), ±limitᵢ)   one after the other, until none changes
/// ```
fn friction(
    limits: [f64; 3],
    velocities: [f64; 2],
    mobility: impl Fn(usize, usize) -> f64,
) -> [f64; 2] {
    /// Directions of the frictions: on the renderer, on the indenter, and of the one on the other.
    const ALONG: [[f64; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [1.0, -1.0]];
    let (mut forces, mut frictions, mut velocities) = ([0.0; 2], [0.0; 3], velocities);
    for _ in 0..ROUNDS {
        let mut changes = false;
        for ((along, limit), friction) in ALONG.iter().zip(limits).zip(&mut frictions) {
            let answer = [0, 1].map(|i| mobility(i, 0) * along[0] + mobility(i, 1) * along[1]);
            let dot = |vector: [f64; 2]| along[0] * vector[0] + along[1] * vector[1];
            let wanted = (*friction - dot(velocities) / dot(answer)).clamp(-limit, limit);
            let change = wanted - *friction;
            *friction = wanted;
            changes |= change.abs() > 1e-15 * limit;
            for i in [0, 1] {
                velocities[i] += answer[i] * change;
                forces[i] += along[i] * change;
            }
        }
        if !changes {
            break;
        }
    }
    forces
}
