//! The indentation rig: two facing voice-coil actuators, one renders a tissue, one indents it.

use super::discretise::{moved, transition};
use super::profile::RampHold;
use crate::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, Seconds};
use crate::{Device, LoopParameterError, Reading, SafeForce};
use core::convert::Infallible;
use fracdiff::Real;
use fracdiff::parameter::{not_negative, positive, range};
use nalgebra::{RowSVector, SMatrix, SVector};

/// The contact of the indenter with the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigContact {
    /// An ideal indenter without mass: what drives it is imposed on the renderer exactly, for ever
    /// in contact. Position: x₁ = profile. Force: F = push.
    Rigid,
    /// A one-sided contact: F = max(0, k·p + c·p') while the penetration p = x₂ - x₁ > 0.
    Compliant {
        /// k > 0.
        stiffness: NewtonsPerMetre,
        /// c ≥ 0.
        damping: NewtonSecondsPerMetre,
    },
}

impl RigContact {
    /// k = 1e5 N/m, c = 80 N·s/m.
    ///
    /// The two masses of [`RigConfig::new`] bounce on the contact with their reduced mass
    /// 0.065/2 kg: ω = √(k/0.0325) = 1754 rad/s (279 Hz), ζ = c/(2·√(k·0.0325)) = 0.70.
    /// A force F compresses it by F/k: 1.8 µm under the 0.18 N of a prostate 1 mm deep.
    pub const COMPLIANT: Self = Self::Compliant {
        stiffness: NewtonsPerMetre(1e5),
        damping: NewtonSecondsPerMetre(80.0),
    };
}

/// The drive of the indenter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigDrive {
    /// A position profile, followed by the servo (relaxation experiment).
    Position(RampHold),
    /// A constant push from t = 0, without servo (creep experiment). Positive into the tissue.
    Force(Newtons),
}

/// The indenter's position servo, continuous in time.
///
/// ```text
/// S = K·(e + ∫e dt/Tᵢ) + D·e',    e = r - x₂
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigServo {
    /// K > 0.
    pub stiffness: NewtonsPerMetre,
    /// D ≥ 0.
    pub damping: NewtonSecondsPerMetre,
    /// Tᵢ > 0. Stable for Tᵢ above mass/damping: (m₁ + m₂)/(D + b₁ + b₂) in contact.
    pub integral_time: Seconds,
}

impl RigServo {
    /// A triple pole at ω = 200 rad/s for the masses and damping of [`RigConfig::new`] moving
    /// together, M = 0.13 kg and b = 7 N·s/m.
    ///
    /// M·s³ + (b + D)·s² + K·s + K/Tᵢ = M·(s + ω)³ gives K = 3·M·ω² = 15 600 N/m,
    /// D = 3·M·ω - b = 71 N·s/m, Tᵢ = 3/ω = 15 ms. [`RigContact::COMPLIANT`] moves the poles to
    /// -273, -177 ± 23i and -1517 ± 722i rad/s; apart, the indenter's are -899, -124 ± 50i.
    /// So 0.1 s after a corner of the profile, less than 1e-6 of its error is left.
    pub const DEFAULT: Self = Self {
        stiffness: NewtonsPerMetre(15_600.0),
        damping: NewtonSecondsPerMetre(71.0),
        integral_time: Seconds(0.015),
    };

    /// Triple pole for two actuators of this mass and damping each, ω faster where their damping needs it.
    #[must_use]
    pub fn of(mass: Kilograms, damping: NewtonSecondsPerMetre) -> Self {
        let (m, b) = (2.0 * mass.0, 2.0 * damping.0);
        // D = 3Mω − b ≥ 0
        let omega = f64::max(200.0, b / (3.0 * m));
        Self {
            stiffness: NewtonsPerMetre(3.0 * omega * omega * m),
            damping: NewtonSecondsPerMetre(3.0 * omega * m - b),
            integral_time: Seconds(3.0 / omega),
        }
    }
}

/// Parameters of an [`IndentationRig`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigConfig {
    /// The drive of the indenter.
    pub drive: RigDrive,
    /// Its contact with the renderer.
    pub contact: RigContact,
    /// T > 0, the time from one write to the next.
    pub sample_time: Seconds,
    /// m₁ > 0.
    pub renderer_mass: Kilograms,
    /// b₁ ≥ 0.
    pub renderer_damping: NewtonSecondsPerMetre,
    /// Largest magnitude of the renderer's force, > 0.
    pub saturation: Option<Newtons>,
    /// m₂ > 0.
    pub indenter_mass: Kilograms,
    /// b₂ ≥ 0.
    pub indenter_damping: NewtonSecondsPerMetre,
    /// Used by [`RigDrive::Position`] with a compliant contact.
    pub servo: RigServo,
}

impl RigConfig {
    /// Two of the dissertation's voice coils, 65 g and 3.5 N·s/m each, without saturation, and
    /// [`RigServo::DEFAULT`].
    #[must_use]
    pub const fn new(drive: RigDrive, contact: RigContact, sample_time: Seconds) -> Self {
        Self {
            drive,
            contact,
            sample_time,
            renderer_mass: Kilograms(0.065),
            renderer_damping: NewtonSecondsPerMetre(3.5),
            saturation: None,
            indenter_mass: Kilograms(0.065),
            indenter_damping: NewtonSecondsPerMetre(3.5),
            servo: RigServo::DEFAULT,
        }
    }
}

/// Steps per sample between which making and breaking contact is noticed.
pub const SUB_STEPS: usize = 8;

/// The rig as a device of one axis: `write` drives the renderer, `read` returns its position.
///
/// ```text
/// renderer:  m₁·x₁'' + b₁·x₁' = F + f        f written: the tissue's force, < 0 if it resists
/// indenter:  m₂·x₂'' + b₂·x₂' = S - F        S servo, or the constant push
/// ```
/// - *Symbols*: positions m, positive into the tissue; F ≥ 0 contact force N, see [`RigContact`];
///   S N, see [`RigServo`].
/// - *Start-up*: both at rest at 0, just touching; time 0. *Output*: the position of tick n is
///   x₁(n·T), before the force written in tick n.
/// - *Reference*: the profile at the sample instants, straight lines between, so the servo sees no
///   steps.
/// - *Accuracy*: exact while in contact or apart. The change between them is noticed only between
///   [`SUB_STEPS`] parts of a sample, so a contact starts or ends up to h = T/8 late. A late start
///   can add k·h²/μ of the energy of a collision (μ reduced mass; 0.05 at 1 ms with the defaults,
///   whose damping takes 0.96); with much less contact damping, sample faster.
/// - *Cost* per sample: [`SUB_STEPS`] 8×8 products; no allocation, no panic.
///
/// Source: dissertation ch. VII.
#[derive(Clone, Debug)]
pub struct IndentationRig {
    config: RigConfig,
    apart: SMatrix<f64, STATES, STATES>,
    together: SMatrix<f64, STATES, STATES>,
    limit: f64,
    state: SVector<f64, STATES>,
    tick: u64,
}

// The state: both motions, the servo's ∫e dt (index 4), and what is given: drive (the reference in
// m, or the push in N), the reference's rate, the tissue's force f.
const X1: usize = 0;
const V1: usize = 1;
const X2: usize = 2;
const V2: usize = 3;
const DRIVE: usize = 5;
const RATE: usize = 6;
const FORCE: usize = 7;
const STATES: usize = 8;

impl IndentationRig {
    /// A rig at rest, the actuators just touching.
    ///
    /// # Errors
    /// Each parameter must be finite and in the range its field states; and no motion may be
    /// faster than 1e6 per [`SUB_STEPS`]th of a sample.
    pub fn new(config: RigConfig) -> Result<Self, LoopParameterError> {
        let sample_time = positive("sample time", config.sample_time.0, "s")?;
        positive("renderer mass", config.renderer_mass.0, "kg")?;
        not_negative("renderer damping", config.renderer_damping.0, "N·s/m")?;
        positive("indenter mass", config.indenter_mass.0, "kg")?;
        not_negative("indenter damping", config.indenter_damping.0, "N·s/m")?;
        positive("servo stiffness", config.servo.stiffness.0, "N/m")?;
        not_negative("servo damping", config.servo.damping.0, "N·s/m")?;
        positive("servo integral time", config.servo.integral_time.0, "s")?;
        if let RigContact::Compliant { stiffness, damping } = config.contact {
            positive("contact stiffness", stiffness.0, "N/m")?;
            not_negative("contact damping", damping.0, "N·s/m")?;
        }
        let limit = match config.saturation {
            Some(limit) => positive("actuator saturation", limit.0, "N")?,
            None => f64::INFINITY,
        };
        let mut state = SVector::from([0.0; STATES]);
        if let RigDrive::Force(push) = config.drive {
            state[DRIVE] = range("push", push.0, true, "finite", "N")?;
        }
        let step = sample_time / SUB_STEPS as f64;
        let scale = natural_units(&config, step);
        Ok(Self {
            config,
            apart: transition(&generator(&config, false), &scale, step)?,
            together: transition(&generator(&config, true), &scale, step)?,
            limit,
            state,
            tick: 0,
        })
    }

    /// Back to rest, just touching, and to time 0.
    pub fn restart(&mut self) {
        let push = match self.config.drive {
            RigDrive::Force(push) => push.0,
            RigDrive::Position(_) => 0.0,
        };
        self.state = SVector::from([0.0; STATES]);
        self.state[DRIVE] = push;
        self.tick = 0;
    }

    /// x₁ now, m: the indentation of the tissue.
    #[must_use]
    pub fn indentation(&self) -> f64 {
        self.state[X1]
    }

    /// x₂ now, m. With a rigid contact, x₁.
    #[must_use]
    pub fn indenter_position(&self) -> f64 {
        self.state[X2]
    }

    /// F now, N, what a force sensor between the actuators shows.
    ///
    /// With a rigid contact: minus the tissue's force under a position profile (whatever its
    /// sign), the push under a force.
    #[must_use]
    pub fn contact_force(&self) -> f64 {
        match (self.config.contact, self.config.drive) {
            // A difference, so that no force is 0 and not -0.
            (RigContact::Rigid, RigDrive::Position(_)) => 0.0 - self.state[FORCE],
            (RigContact::Rigid, RigDrive::Force(push)) => push.0,
            (RigContact::Compliant { stiffness, damping }, _) => {
                let penetration = self.state[X2] - self.state[X1];
                let rate = self.state[V2] - self.state[V1];
                if penetration > 0.0 {
                    // F = max(0, k·p + c·p')
                    (stiffness.0 * penetration + damping.0 * rate).max(0.0)
                } else {
                    0.0
                }
            }
        }
    }

    /// The position profile now, m; `None` if a force drives the indenter.
    #[must_use]
    pub fn reference(&self) -> Option<f64> {
        match self.config.drive {
            RigDrive::Position(profile) => Some(profile.position(self.time(self.tick))),
            RigDrive::Force(_) => None,
        }
    }

    /// The parameters it was made from.
    #[must_use]
    pub const fn config(&self) -> &RigConfig {
        &self.config
    }

    fn time(&self, tick: u64) -> f64 {
        tick as f64 * self.config.sample_time.0
    }

    fn advance(&mut self, force: f64) {
        self.state[FORCE] = force.max(-self.limit).min(self.limit);
        let end = self.time(self.tick + 1);
        if let RigDrive::Position(profile) = self.config.drive {
            // From where it is, not where it should be: rounding does not add up.
            let change = profile.position(end) - self.state[DRIVE];
            self.state[RATE] = change / self.config.sample_time.0;
        }
        for _ in 0..SUB_STEPS {
            let touching = self.contact_force() > 0.0;
            let transition = if touching {
                &self.together
            } else {
                &self.apart
            };
            self.state = moved(transition, &self.state);
        }
        if let (RigContact::Rigid, RigDrive::Position(profile)) =
            (self.config.contact, self.config.drive)
        {
            let imposed = profile.position(end);
            (self.state[X1], self.state[X2]) = (imposed, imposed);
        }
        self.tick += 1;
    }
}

impl<F: Real> Device<F, 1> for IndentationRig {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        Ok(Reading {
            tick: self.tick,
            time_s: self.time(self.tick),
            position_m: SVector::from([F::from_f64(self.state[X1])]),
        })
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        self.advance(force.newtons()[0].to_f64());
        Ok(())
    }
}

/// The rate of change of the state, as rows over the state; `touching` only matters if compliant.
fn generator(config: &RigConfig, touching: bool) -> SMatrix<f64, STATES, STATES> {
    // Each name is the row that picks that state, so the lines below are the equations of motion.
    let pick = SMatrix::<f64, STATES, STATES>::identity();
    let [x1, v1, x2, v2, integral, drive, rate, force] =
        core::array::from_fn(|index| -> RowSVector<f64, STATES> { pick.row(index).into_owned() });
    let none = RowSVector::<f64, STATES>::zeros();
    let (m1, b1) = (config.renderer_mass.0, config.renderer_damping.0);
    let (m2, b2) = (config.indenter_mass.0, config.indenter_damping.0);
    let RigServo {
        stiffness,
        damping,
        integral_time,
    } = config.servo;

    let (servo, error) = match config.drive {
        // S = K·(e + ∫e dt/Tᵢ) + D·e'
        RigDrive::Position(_) => {
            let error = drive - x2;
            let with_integral = error + integral / integral_time.0;
            let servo = with_integral * stiffness.0 + (rate - v2) * damping.0;
            (servo, error)
        }
        RigDrive::Force(_) => (drive, none),
    };
    match (config.contact, config.drive) {
        // x₁ = x₂ = reference, set again at each sample
        (RigContact::Rigid, RigDrive::Position(_)) => {
            SMatrix::from_rows(&[rate, none, rate, none, none, rate, none, none])
        }
        (RigContact::Rigid, RigDrive::Force(_)) => {
            // m₁·x₁'' + b₁·x₁' = push + f
            let acceleration = (drive + force - v1 * b1) / m1;
            SMatrix::from_rows(&[v1, acceleration, v1, acceleration, none, none, none, none])
        }
        (RigContact::Compliant { stiffness, damping }, _) => {
            // F = k·p + c·p'
            let contact = if touching {
                (x2 - x1) * stiffness.0 + (v2 - v1) * damping.0
            } else {
                none
            };
            let renderer = (contact + force - v1 * b1) / m1;
            let indenter = (servo - contact - v2 * b2) / m2;
            SMatrix::from_rows(&[v1, renderer, v2, indenter, error, rate, none, none])
        }
    }
}

/// A natural unit of each state for a step h, see [`transition`].
fn natural_units(config: &RigConfig, step: f64) -> SVector<f64, STATES> {
    let velocity = 1.0 / step;
    let force = config.renderer_mass.0 / step / step;
    let drive = match config.drive {
        RigDrive::Position(_) => 1.0,
        RigDrive::Force(_) => force,
    };
    SVector::from([1.0, velocity, 1.0, velocity, step, drive, velocity, force])
}
