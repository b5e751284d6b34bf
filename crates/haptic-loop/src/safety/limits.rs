//! The limits of a safety chain, in SI units.

use crate::guard::PassivityGuard;
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
pub struct SafetyLimits {
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
    /// Time in which the share of the wanted force that is used rises from 0 to 1, from start or
    /// [`clear`](crate::SafetyState::clear), above 0. *Default* 0.5 s: whoever lets go within 0.2 s has met less than half.
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
    pub guard: Option<PassivityGuard>,
}

impl Default for SafetyLimits {
    fn default() -> Self {
        let mut limits = Self::bare(Newtons(0.0), NewtonsPerSecond(0.0));
        for limit in Limit::ALL {
            let number = limit.default_number();
            limit.set(&mut limits, (number > 0.0).then_some(number));
        }
        limits.norm = Some(limits.force);
        if let Some(speed) = &mut limits.speed {
            speed.soft = SpeedLimit::SOFT;
        }
        limits
    }
}

impl SafetyLimits {
    /// The most braking for a device of unknown mass: stable with a margin of 2 for 15 g and more at 1 kHz and a
    /// sample of delay.
    pub const BRAKING_WITHOUT_MASS: NewtonSecondsPerMetre = NewtonSecondsPerMetre(5.0);

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
            velocity_bandwidth: Hertz(Limit::VelocityBandwidth.default_number()),
            braking: None,
            stop_time: Seconds(Limit::StopTime.default_number()),
            brake_force: Newtons(Limit::BrakeForce.default_number()),
            device_mass: None,
            device_delay_samples: 1,
            stuck: None,
            jump: None,
            guard: None,
        }
    }

    pub(super) const fn bound_places(&self) -> bool {
        #[cfg(feature = "std")]
        if self.workspace_box.is_some() {
            return true;
        }
        self.workspace.is_some()
    }
}

/// Order in which values of a limit are tighter. NaN means no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tighter {
    /// The smaller of two values is the tighter one.
    Less,
    /// The larger of two values is the tighter one.
    More,
    /// The smaller one, but 0 is no limit at all.
    LessUnlessOff,
    /// Neither: on, it stays as it was set; off, it may be switched on.
    Unordered,
}

/// Access to a number of the limits; `None` is off, or 0 for a limit that cannot be off.
macro_rules! number {
    (get $field:ident Option<$unit:ident>) => {
        |limits: &SafetyLimits| limits.$field.map(|number| number.0)
    };
    (set $field:ident Option<$unit:ident>) => {
        |limits: &mut SafetyLimits, number: Option<f64>| limits.$field = number.map($unit)
    };
    (get $field:ident $unit:ident) => {
        |limits: &SafetyLimits| Some(limits.$field.0)
    };
    (set $field:ident $unit:ident) => {
        |limits: &mut SafetyLimits, number: Option<f64>| {
            limits.$field = $unit(number.unwrap_or_default())
        }
    };
    (get $within:ident.$field:ident by $set:path) => {
        |limits: &SafetyLimits| limits.$within.map(|within| within.$field.0)
    };
    (set $within:ident.$field:ident by $set:path) => {
        $set
    };
}

/// True for a limit that needs the motion of the device, which a chain without such a limit does not follow.
macro_rules! needs_motion {
    (Motion) => {
        true
    };
    (Nothing) => {
        false
    };
}

macro_rules! table {
    ($($name:ident $key:literal [$least:expr, $most:expr] $default:expr, $tighter:ident, $needs:ident, ($($number:tt)*), $help:literal;)*) => {
        /// A limit that is one number, wherever it stands: in the chain, on the wire, in documents, on the command line.
        /// A new one needs its field and its row here, and what enforces it; whoever has to know of it does not compile before.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Limit {
            $(#[doc = concat!("`", $key, "`: ", $help)] $name,)*
        }

        // A function for each column: a microcontroller has no room for keys and help, which it never asks for.
        impl Limit {
            /// Every limit once, in the order of declaration.
            pub const ALL: [Self; [$(Self::$name),*].len()] = [$(Self::$name),*];

            /// Names the limit in files, options and reports, with its unit.
            #[must_use]
            pub const fn key(self) -> &'static str {
                match self { $(Self::$name => $key,)* }
            }

            /// Explains the limit in one line, as the help of an option.
            #[must_use]
            pub const fn help(self) -> &'static str {
                match self { $(Self::$name => $help,)* }
            }

            /// Least and most; 0 is allowed too where it means no limit. A device may allow less.
            #[must_use]
            pub const fn range(self) -> [f64; 2] {
                match self { $(Self::$name => [$least, $most],)* }
            }

            /// The number in [`SafetyLimits::default`]; 0 is off.
            #[must_use]
            pub const fn default_number(self) -> f64 {
                match self { $(Self::$name => $default,)* }
            }

            /// Order in which values are stricter.
            #[must_use]
            pub const fn tighter(self) -> Tighter {
                match self { $(Self::$name => Tighter::$tighter,)* }
            }

            /// True if one of them is on that needs the motion of the device.
            pub(super) fn any_needs_motion(limits: &SafetyLimits) -> bool {
                $(needs_motion!($needs) && number!(get $($number)*)(limits).is_some())||*
            }

            /// Reads the number; `None` is off.
            #[must_use]
            pub fn get(self, limits: &SafetyLimits) -> Option<f64> {
                match self { $(Self::$name => number!(get $($number)*)(limits),)* }
            }

            /// Sets the number; `None` is off. The stuck time comes after the stuck force, without which it has no effect.
            // In line, loops over all limits are unrolled, for 0.4 KiB of flash.
            #[inline(never)]
            pub fn set(self, limits: &mut SafetyLimits, number: Option<f64>) {
                match self { $(Self::$name => number!(set $($number)*)(limits, number),)* }
            }
        }
    };
}

table! {
    Force "force_limit_n" [ABOVE_0, 1e6] 10.0, Less, Nothing, (force Newtons), "Largest force";
    ForceRate "force_rate_limit_n_per_s" [ABOVE_0, 1e10] 1000.0, Less, Nothing, (rate NewtonsPerSecond), "Largest rate of force";
    StartForce "start_force_n" [0.0, 1e6] 1.0, LessUnlessOff, Nothing, (start_force Option<Newtons>),
        "Largest force with which the loop may start; 0 for any";
    Speed "speed_limit_m_per_s" [1e-6, 100.0] 1.5, LessUnlessOff, Motion, (speed.hard by SpeedLimit::set),
        "Largest speed; above it a fault ends the run";
    RiseTime "rise_time_s" [0.0, 60.0] 0.5, More, Nothing, (rise_time Option<Seconds>), "Ramp the force up over this time at the start";
    VelocityBandwidth "velocity_bandwidth_hz" [0.1, 1e4] 50.0, More, Nothing, (velocity_bandwidth Hertz),
        "Bandwidth of the velocity that is estimated from positions";
    Braking "braking_n_s_per_m" [0.0, 1e6] SafetyLimits::BRAKING_WITHOUT_MASS.0, Unordered, Motion, (braking Option<NewtonSecondsPerMetre>),
        "Damping that brakes near workspace and speed limits, and after a fault or stop";
    StopTime "stop_time_s" [1e-3, 1.0] 0.1, Less, Nothing, (stop_time Seconds),
        "Time to zero force after a fault, a stop or the end, 1ms to 1s [default: 0.1s]";
    BrakeForce "brake_force_n" [0.0, 10.0] 2.0, Less, Nothing, (brake_force Newtons),
        "Largest braking force during that time, 0N to 10N [default: 2N]";
    StuckForce "stuck_force_n" [0.0, 1e4] Stuck::DEFAULT.force.0, LessUnlessOff, Motion, (stuck.force by Stuck::set_force),
        "Fault if the force rises by this much while the position is frozen; 0 = off [default: 3N on a serial device, else never]";
    StuckTime "stuck_time_s" [1e-3, 10.0] Stuck::DEFAULT.time.0, Less, Motion, (stuck.time by Stuck::set_time),
        "Time for which the position must be frozen [default: 0.1s]";
    Jump "jump_m" [1e-6, 1.0] 1e-3, LessUnlessOff, Motion, (jump Option<Metres>),
        "Fault if the position moves in one sample by this much more than the speed limit allows; 0 = off \
         [default: 1mm on a serial device, else never]";
    DeviceMass "device_mass_kg" [1e-6, 100.0] 0.0, LessUnlessOff, Nothing, (device_mass Option<Kilograms>),
        "Mass of a real device, for guard observer, braking and the stability check before a run";
}

/// Least number above 0 that is normal in single precision.
const ABOVE_0: f64 = f32::MIN_POSITIVE as f64;

impl Limit {
    /// The least value allowed: 0 where a `value` of 0 means no limit, else that of the [`range`](Self::range).
    #[must_use]
    pub const fn least_for(self, value: f32) -> f32 {
        if self.is_off(value) {
            0.0
        } else {
            self.range()[0] as f32
        }
    }

    /// True if a `value` of 0 means no limit, and this is one.
    #[must_use]
    pub const fn is_off(self, value: f32) -> bool {
        match self.tighter() {
            Tighter::LessUnlessOff | Tighter::Unordered => value <= 0.0,
            Tighter::Less | Tighter::More => false,
        }
    }

    /// True if `value` is at least as tight as what is set.
    #[must_use]
    pub const fn is_tight(self, value: f32, set: f32) -> bool {
        match self.tighter() {
            Tighter::Less => value <= set,
            Tighter::More => value >= set,
            Tighter::LessUnlessOff => self.is_off(set) || (!self.is_off(value) && value <= set),
            Tighter::Unordered => self.is_off(set) || (value - set).abs() <= 0.0,
        }
    }
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
    /// Speed from which on the motion is braked, at least 0.
    pub soft: MetresPerSecond,
    /// Latches the fault, above `soft`.
    pub hard: MetresPerSecond,
}

impl SpeedLimit {
    /// The default of `soft`.
    pub const SOFT: MetresPerSecond = MetresPerSecond(1.0);

    /// A limit that is not braked before it is reached.
    fn set(limits: &mut SafetyLimits, hard: Option<f64>) {
        let hard = hard.map(MetresPerSecond);
        limits.speed = hard.map(|hard| Self { soft: hard, hard });
    }
}

/// A sensor that stands still although the device must move.
///
/// A reading that has been the same, to the last bit, for `time`, and goes on so while the wanted force, limited,
/// grows in magnitude by more than `force` and more than `force` is applied, latches
/// [`Fault::PositionStuck`](crate::Fault::PositionStuck). A force that only falls does not count: that is how a tissue
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

    fn set_force(limits: &mut SafetyLimits, force: Option<f64>) {
        limits.stuck = force.map(|force| Self {
            force: Newtons(force),
            ..Self::DEFAULT
        });
    }

    /// Behind the force: without one there is nothing to set.
    fn set_time(limits: &mut SafetyLimits, time: Option<f64>) {
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
