//! The limits of a safety chain, in SI units.

use crate::guard::Guard;
use crate::units::{
    Hertz, Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
    Seconds,
};
use fracdiff::parameter::Shown;
use thiserror::Error;

/// Every limit of a [`SafetyChain`](crate::SafetyChain); `None` is off.
///
/// The defaults suit a desktop device of some 65 g, so replace them with those of your device: its
/// workspace is not known here, nor is a guard, which needs its mass or damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest force on each axis, above 0; a larger force is scaled down without changing its
    /// direction. *Default* 10 N: as much as a desktop device makes and a finger can hold.
    pub force: Newtons,
    /// Largest magnitude of the whole force, above 0 and at most 1e9 N: else a diagonal gets √D times the limit
    /// of an axis. With it `force` too is at most 1e9 N. *Default* 10 N.
    pub norm: Option<Newtons>,
    /// Largest rate of the force, |Δf|/T of the whole vector, above 0. *Default* 1000 N/s: a wall of 2 kN/m met at 0.5 m/s.
    pub rate: NewtonsPerSecond,
    /// Largest magnitude of a wanted force with which [`may_start`](crate::Controller::may_start) lets a
    /// device be armed, above 0. *Default* 1 N: felt, but moves no hand.
    pub start_force: Option<Newtons>,
    /// From start or [`clear`](crate::SafetyState::clear) the share of the wanted force that is used rises from
    /// 0 to 1 in this time, above 0. *Default* 0.5 s: whoever lets go within 0.2 s has met less than half.
    pub rise_time: Option<Seconds>,
    /// The range in which the device may move, the same on each axis. *Default* off.
    pub workspace: Option<Workspace>,
    /// A separate range for each of the first three axes, instead of `workspace`; for devices of
    /// more than one axis.
    /// *Default* off. With the feature `std`: a one-axis microcontroller has no memory for it.
    #[cfg(feature = "std")]
    pub workspace_box: Option<[Workspace; 3]>,
    /// The speed at which it may move. *Default* 1 and 1.5 m/s: an exploring hand stays below 0.5 m/s.
    pub speed: Option<SpeedLimit>,
    /// ω/2π above 0, bandwidth of the velocity that is estimated from positions, v ← v + (1 −
    /// e^(−ωT))·(Δ/T − v). *Default* 50 Hz: at 1 kHz an encoder step of 10 µm is 3 mm/s, and a
    /// motion is detected 3 ms late.
    pub velocity_bandwidth: Hertz,
    /// b, viscous damping that brakes near a limit and after a fault, above 0 and at most
    /// [`braking_max`](Self::braking_max). *Default* 5 N·s/m: with the lag of the estimate 1/ω = 3.2 ms and 65 g it is
    /// critical, ζ = √(m·ω/b)/2 = 1. Off, a limit only latches its fault.
    pub braking: Option<NewtonSecondsPerMetre>,
    /// After a fault, a stop or the end of a run the force is zero within this time, whatever `rate` says, 0.001 to
    /// 1 s: |f| ≤ (1 − t/stop time)·max(|f₀|, brake force). *Default* 0.1 s, seven times m/b of the default device.
    pub stop_time: Seconds,
    /// The force up to which braking may go on in that time, if f₀ is smaller, 0 to 10 N. *Default* 2 N: it takes
    /// 65 g from 1.5 m/s to rest in 0.1 s, and hurts nobody.
    pub brake_force: Newtons,
    /// m, the least mass that moves with the device, above 0: how much it can be braked. *Default* unknown.
    pub device_mass: Option<Kilograms>,
    /// d, samples from a force to its effect, rounded up; a lag of the actuator counts as delay. *Default* 1.
    pub device_delay_samples: u32,
    /// The sign of a sensor that is stuck. *Default* 3 N in 0.1 s; off in [`bare`](Self::bare).
    pub stuck: Option<Stuck>,
    /// A position that moves in a sample by more than `speed` allows, T·hard, and by this much more, latches
    /// [`Fault::PositionJump`](crate::Fault::PositionJump), above 0; without `speed` none does. *Default* 1 mm, more
    /// than counts and noise of a desktop device; off in [`bare`](Self::bare).
    pub jump: Option<Metres>,
    /// Keeps the loop from feeding the device energy. *Default* off.
    pub guard: Option<Guard>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            norm: Some(Newtons(10.0)),
            start_force: Some(Newtons(1.0)),
            rise_time: Some(Seconds(0.5)),
            speed: Some(SpeedLimit {
                soft: MetresPerSecond(1.0),
                hard: MetresPerSecond(1.5),
            }),
            braking: Some(Self::BRAKING_WITHOUT_MASS),
            stuck: Some(Stuck::DEFAULT),
            jump: Some(Metres(1e-3)),
            ..Self::bare(Newtons(10.0), NewtonsPerSecond(1000.0))
        }
    }
}

impl Limits {
    /// The most braking for a device of unknown mass: stable with a margin of 2 for 15 g and more at 1 kHz and a
    /// sample of delay.
    pub const BRAKING_WITHOUT_MASS: NewtonSecondsPerMetre = NewtonSecondsPerMetre(5.0);
    /// Shortest and longest `stop_time`, s.
    pub const STOP_TIME_S: [f64; 2] = [1e-3, 1.0];
    /// Largest `brake_force`, N.
    pub const BRAKE_FORCE_MAX_N: f64 = 10.0;

    /// The most braking that is accepted: half of what makes a free mass shake, for whatever bandwidth of the
    /// velocity.
    ///
    /// ```text
    /// m·a[n] = −b·v̂[n−d],   v̂ ← v̂ + a·(Δ/T − v̂)   ⇒   (1 − w)(1 − cw) + (bT/m)(a/2)(1 + w)w^(1+d) = 0,   c = 1 − a
    /// on the circle, w = e^(−jθ):   bT/m = 2·sin(θ/2)/sin((2d + 1)θ/2) ≥ 2/(2d + 1)
    /// most: b = m/((2d + 1)·T)
    /// ```
    /// At the first θ where the phase is −π: there (1 + d)θ = π/2 − φ, φ the lag of the filter, so
    /// c = cos((1 + d)θ)/cos(dθ), which gives the second line; the gain falls with θ and the phase too, so this is the
    /// edge. It is 2/(2d + 1) for a slow filter and exactly 2 at d = 0. Damping of the device only helps.
    /// Unknown mass: [`BRAKING_WITHOUT_MASS`](Self::BRAKING_WITHOUT_MASS).
    #[must_use]
    pub fn braking_max(&self, sample_time: Seconds) -> NewtonSecondsPerMetre {
        self.device_mass.map_or(Self::BRAKING_WITHOUT_MASS, |mass| {
            let delays = 2.0 * f64::from(self.device_delay_samples) + 1.0;
            NewtonSecondsPerMetre(mass.0 / (delays * sample_time.0))
        })
    }

    /// Force and rate alone, everything else off.
    #[must_use]
    pub const fn bare(force: Newtons, rate: NewtonsPerSecond) -> Self {
        Self {
            force,
            norm: None,
            rate,
            start_force: None,
            rise_time: None,
            workspace: None,
            #[cfg(feature = "std")]
            workspace_box: None,
            speed: None,
            velocity_bandwidth: Hertz(50.0),
            braking: None,
            stop_time: Seconds(0.1),
            brake_force: Newtons(2.0),
            device_mass: None,
            device_delay_samples: 1,
            stuck: None,
            jump: None,
            guard: None,
        }
    }

    /// Index of the row with this key in [`TABLE`](Self::TABLE).
    ///
    /// # Panics
    /// If there is none: a constant that asks for it does not compile.
    #[must_use]
    pub const fn row(key: &str) -> usize {
        let mut row = 0;
        while !is_same(Self::TABLE[row].key, key) {
            row += 1;
        }
        row
    }

    pub(super) const fn bound_places(&self) -> bool {
        #[cfg(feature = "std")]
        if self.workspace_box.is_some() {
            return true;
        }
        self.workspace.is_some()
    }
}

/// A limit that is one number: the row from which experiments, options and the wire make it.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Names the limit in files, options and reports, with its unit.
    pub key: &'static str,
    /// One line for people; empty for a limit that has a parameter of its own elsewhere.
    pub help: &'static str,
    /// Reads the number; `None` is off.
    pub get: fn(&Limits) -> Option<f64>,
}

/// How a number of the limits is read and set; `None` is off, or 0 where nothing is ever off.
macro_rules! number {
    ($field:ident: Option<$unit:ident>) => {
        (
            |limits| limits.$field.map(|number| number.0),
            |limits, number| limits.$field = number.map($unit),
        )
    };
    ($field:ident: $unit:ident) => {
        (
            |limits| Some(limits.$field.0),
            |limits, number| limits.$field = $unit(number.unwrap_or_default()),
        )
    };
}

macro_rules! table {
    ($($key:literal $number:expr, $help:literal;)*) => {
        impl Limits {
            /// Every limit that is one number. A new one needs its field, a row here, what enforces it, and its place on the wire.
            pub const TABLE: &'static [Limit] = &[$(Limit {
                key: $key,
                help: $help,
                get: { let number: (fn(&Self) -> Option<f64>, fn(&mut Self, Option<f64>)) = $number; number.0 },
            }),*];

            /// Sets the number of the same row of [`TABLE`](Self::TABLE). On its own, for a microcontroller has no room for keys and help.
            pub const SET: &'static [fn(&mut Self, Option<f64>)] = &[$({
                let number: (fn(&Self) -> Option<f64>, fn(&mut Self, Option<f64>)) = $number;
                number.1
            }),*];
        }
    };
}

table! {
    "force_limit_n" number!(force: Newtons), "";
    "force_rate_limit_n_per_s" number!(rate: NewtonsPerSecond), "";
    "start_force_n" number!(start_force: Option<Newtons>), "";
    "velocity_bandwidth_hz" number!(velocity_bandwidth: Hertz), "";
    "speed_limit_m_per_s" (|limits| limits.speed.map(|speed| speed.hard.0), SpeedLimit::set),
        "Largest speed; above it a fault ends the run";
    "rise_time_s" number!(rise_time: Option<Seconds>), "Ramp the force up over this time at the start";
    "braking_n_s_per_m" number!(braking: Option<NewtonSecondsPerMetre>),
        "Damping that brakes near workspace and speed limits, and after a fault or stop";
    "stop_time_s" number!(stop_time: Seconds),
        "Time to zero force after a fault, a stop or the end, 1ms to 1s [default: 0.1s]";
    "brake_force_n" number!(brake_force: Newtons),
        "Largest braking force during that time, 0N to 10N [default: 2N]";
    "stuck_force_n" (|limits| limits.stuck.map(|stuck| stuck.force.0), Stuck::set_force),
        "Fault if the force rises by this much while the position is frozen; 0 = off [default: 3N on a serial device, else never]";
    "stuck_time_s" (|limits| limits.stuck.map(|stuck| stuck.time.0), Stuck::set_time),
        "Time for which the position must be frozen [default: 0.1s]";
    "jump_m" number!(jump: Option<Metres>),
        "Fault if the position moves in one sample by this much more than the speed limit allows; 0 = off \
         [default: 1mm on a serial device, else never]";
    "device_mass_kg" number!(device_mass: Option<Kilograms>),
        "Mass of a real device, for guard observer, braking and the stability check before a run";
}

/// True of equal texts; `==` is no constant.
const fn is_same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut at = 0;
    while at < one.len() && at < other.len() && one[at] == other[at] {
        at += 1;
    }
    at == one.len() && at == other.len()
}

/// The range in which the device may move on an axis.
///
/// ```text
/// low ─soft─▶ ················· ◀─soft─ high       beyond low or high: Fault::Workspace
/// f = −p·b·v while v points outwards,  p = 0 at the inner edge of the soft zone, 1 at its outer
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// Lowest position that is allowed.
    pub low: Metres,
    /// Highest position, above `low`.
    pub high: Metres,
    /// Width of the zones in which an outward motion is braked, 0 or more, at most half the workspace.
    pub soft: Metres,
}

/// The speed at which the device may move on each axis.
///
/// ```text
/// f = −p·b·v,  p = 0 at the soft speed, 1 at the hard one       above the hard one: Fault::Velocity
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimit {
    /// From here on the motion is braked, at least 0.
    pub soft: MetresPerSecond,
    /// Latches the fault, above `soft`.
    pub hard: MetresPerSecond,
}

impl SpeedLimit {
    /// A limit that is not braked before it is reached.
    fn set(limits: &mut Limits, hard: Option<f64>) {
        let hard = hard.map(MetresPerSecond);
        limits.speed = hard.map(|hard| Self { soft: hard, hard });
    }
}

/// A sensor that stands still although the device must move.
///
/// A reading that has been the same, to the last bit, for `time`, and goes on so while the wanted force, limited,
/// grows in magnitude by more than `force` and more than `force` is applied, latches
/// [`Fault::PositionStuck`](crate::Fault::PositionStuck). A force that only falls is none: that is how a tissue
/// relaxes that is held. Nor is one that stays, as against a hand that does not move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// Above 0.
    pub force: Newtons,
    /// 0.001 to 10 s.
    pub time: Seconds,
}

impl Stuck {
    /// 3 N move even a stiff finger, 3 kN/m, by 1 mm, a hundred counts of an encoder.
    pub const DEFAULT: Self = Self {
        force: Newtons(3.0),
        time: Seconds(0.1),
    };

    fn set_force(limits: &mut Limits, force: Option<f64>) {
        limits.stuck = force.map(|force| Self {
            force: Newtons(force),
            ..Self::DEFAULT
        });
    }

    /// Behind the force: without one there is nothing to set.
    fn set_time(limits: &mut Limits, time: Option<f64>) {
        if let (Some(stuck), Some(time)) = (&mut limits.stuck, time) {
            stuck.time = Seconds(time);
        }
    }
}

/// A device that must not be armed now: the force would begin with a blow.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "the wanted force of {wanted} N is not within the {allowed} N allowed at the start",
    wanted = Shown(*wanted_n), allowed = Shown(*allowed_n)
)]
pub struct StartRefused {
    /// Magnitude of the wanted force, N; NaN or infinite if it is not finite.
    pub wanted_n: f64,
    /// Largest with which a start is allowed, N; infinite if any finite force is.
    pub allowed_n: f64,
}
