//! An experiment on a device at the other end of a link.
//!
//! ```text
//! device loop:  set parameters ─▶ arm ─▶ start ─▶ samples ─▶ log        the device ticks
//! host loop:    ... sample ─▶ controller of this program ─▶ force ...   the device only measures and applies
//! ```
//! Time is the device's, n·T. Samples that the line loses are counted, never made up.

#[cfg(any(test, feature = "bad-lines"))]
pub mod bad_line_tests;
mod pair;
mod partner;
mod run;
mod session;
mod summary;

pub use crate::remote::pair::{PairRun, fits_two_devices};
pub use crate::remote::run::{RemoteRun, delay_of};
pub use crate::remote::session::{Steered, Steers, blank};
use fracdiff::{Operator, parameter::Shown};
use haptic_document::{
    Failure, bad_input,
    parameters::{LOOP, PUSH_BY, SAMPLE_TIME, SCHEME, TRIAL_DURATION},
};

use super::schedule::Schedule;
use crate::device::LinkedName;
use haptic_link::{
    Capabilities, Configuration, ControllerLaw, Limits, LoopMode, OperatorShape, Simulation,
    SimulationKind, SurfaceShape,
};
use haptic_loop::{DepthMap, Limit, plant::MassDamperConfig, units::Seconds};
use haptic_remote::{serial::SerialLink, wire_limits};
use haptic_trial::{
    advice::single,
    ending::{Lateness, MotorPush},
    plant_file::calibration::Calibration,
    safety::{GuardChoice, GuardedDevice, Safety, guard_of},
    tap::TappedLaw,
};
use std::time::Duration;

/// A device and how the loop with it is closed.
#[derive(Clone, Debug, PartialEq)]
pub struct RemoteDevice {
    /// Port or address, and how to speak there.
    pub name: LinkedName,
    /// Place where the loop is closed.
    pub loop_mode: LoopMode,
    /// Silence after which the device lets go, ms; `None` for the default of the loop mode.
    pub watchdog_ms: Option<u16>,
    /// Number of late ticks in a row that latches a fault; 0 for never.
    pub late_ticks: u16,
    /// Ticks from a sample to the force that answers it at most, in a loop on the host.
    pub max_age_ticks: u16,
    /// Longest time to wait for the device to appear.
    pub patience: Duration,
    /// Its newtons, if they were checked.
    pub calibration: Option<Calibration>,
}

impl RemoteDevice {
    /// Has a link to it speak of true newtons, if they are known.
    ///
    /// # Errors
    /// If its file was calibrated on another device, or holds factors that cannot be.
    pub fn calibrate(&self, link: &mut SerialLink) -> Result<(), Failure> {
        if let Some(calibration) = &self.calibration {
            let (of, device) = (&calibration.device, self.name.identity(link).to_string());
            if !of.is_empty() && *of != device {
                return Err(bad_input!(
                    "the device file was calibrated on {of}, and this is {device}, whose newtons may be others: give its own file, or one without [calibration]"
                ));
            }
            link.calibrate(calibration.factors()?);
        }
        Ok(())
    }

    /// One line for a report: its newtons were checked, or never.
    pub fn calibration_in_words(&self) -> String {
        Calibration::in_words(self.calibration.as_ref())
    }

    /// Device with the defaults: the device's loop, 500 ms of silence, 20 late ticks, no patience.
    pub fn new(name: LinkedName) -> Self {
        Self {
            name,
            loop_mode: LoopMode::Device,
            watchdog_ms: None,
            late_ticks: Limits::DEFAULT.late_ticks,
            max_age_ticks: Limits::DEFAULT.max_age_ticks,
            patience: Duration::ZERO,
            calibration: None,
        }
    }

    /// Silence after which the device lets go, ms.
    pub fn watchdog_ms(&self) -> u16 {
        self.watchdog_ms
            .unwrap_or_else(|| self.loop_mode.watchdog_ms())
    }

    /// Silence of the host after which the device takes its force away.
    pub fn watchdog(&self) -> Duration {
        Duration::from_millis(u64::from(self.watchdog_ms()))
    }

    /// Lateness that the device allows this host.
    pub fn lateness(&self) -> Lateness {
        Lateness {
            watchdog_ms: self.watchdog_ms(),
            max_age_ticks: self.max_age_ticks,
        }
    }
}

/// Law that the device renders, and the plant that it simulates if it is simulated.
#[derive(Clone, Debug)]
pub struct RemoteLaw {
    /// K of the law, N/m.
    pub stiffness_n_per_m: f64,
    /// B of the law, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// Order μ of the law's dissipation.
    pub order: f64,
    /// True for an environment that begins at 0 and pushes but never pulls.
    pub one_sided: bool,
    /// The map of the depth, of a one-sided law.
    pub depth_map: Option<DepthMap<f64>>,
    /// The surface that it lies behind, on a device of several axes.
    pub surface: Option<SurfaceShape>,
    /// Shape and coefficients of the operator, as the wire carries them.
    pub operator: (OperatorShape, Vec<f32>),
    /// The controller that holds the device instead of all that; the operator's numbers are its
    /// coefficients.
    pub controller: Option<ControllerLaw>,
    /// Limits of the safety chain, without a guard.
    pub limits: haptic_loop::SafetyLimits,
    /// Limits that stay as they are on the device.
    pub unchanged: UnchangedLimits,
    /// The guard, and what is known of a real device.
    pub guard: (GuardChoice, GuardedDevice),
    /// The plant of a simulated device.
    pub simulation: Simulation,
    /// Constant push that the force has to hold, N; 0 for none.
    pub held_push_n: f64,
    /// Push of a motor into the law.
    pub push: Option<MotorPush>,
    /// The law as a motor taps it.
    pub tap: Option<TappedLaw>,
    /// The plant stands still until the device has raised its force: so its motion can be compared
    /// with theory from the start.
    pub after_rise: bool,
}

impl RemoteLaw {
    /// No law at all: one of a loop on the host. Of the limits those that nobody has given stay as they are on the device: `rate` is the
    /// force rate limit, N/s. `device` is what is known of it for its guard.
    pub fn none(
        limits: haptic_loop::SafetyLimits,
        rate: Option<f64>,
        safety: &Safety,
        device: GuardedDevice,
        simulation: Simulation,
    ) -> Self {
        Self {
            unchanged: UnchangedLimits {
                rate: rate.is_none(),
                speed: safety.number(Limit::Speed).is_none(),
                rise: safety.number(Limit::RiseTime).is_none(),
            },
            guard: (safety.guard, safety.guarded(device)),
            ..Self::bare(limits, simulation)
        }
    }

    /// No law, these limits, no guard.
    pub fn bare(limits: haptic_loop::SafetyLimits, simulation: Simulation) -> Self {
        Self {
            stiffness_n_per_m: 0.0,
            dissipation_n_s_mu_per_m: 0.0,
            order: 0.0,
            one_sided: false,
            depth_map: None,
            surface: None,
            operator: no_operator(),
            controller: None,
            limits,
            unchanged: UnchangedLimits::default(),
            guard: Default::default(),
            simulation,
            held_push_n: 0.0,
            push: None,
            tap: None,
            after_rise: false,
        }
    }

    /// Push of the device's own motor, N; 0 for none.
    fn own_push_n(&self) -> f64 {
        self.push.map_or(0.0, MotorPush::own_n)
    }
}

/// Limits that an experiment does not speak of: they stay as they are on the device.
#[derive(Clone, Copy, Debug, Default)]
pub struct UnchangedLimits {
    /// Limit of the rate of the force.
    pub rate: bool,
    /// Speed limit, soft and hard.
    pub speed: bool,
    /// Limit of how fast a force may rise.
    pub rise: bool,
}

impl UnchangedLimits {
    /// The limits that are asked for, but for those of the device that stay.
    fn of(self, asked: Limits, device: &Limits) -> Limits {
        let mut limits = asked;
        if self.rate {
            limits.force_rate_n_per_s = device.force_rate_n_per_s;
        }
        if self.speed {
            limits.speed_soft_m_per_s = device.speed_soft_m_per_s;
            limits.speed_hard_m_per_s = device.speed_hard_m_per_s;
        }
        if self.rise {
            limits.rise_time_s = device.rise_time_s;
        }
        limits
    }
}

/// The configuration of a connected device for this law, within what is `set` on it; `warn` hears where that is the tighter.
/// Limits with which no force could hold the push are refused.
///
/// # Errors
/// If the device cannot render the law, or its limits leave no force that holds the push.
pub fn agreed(
    device: &RemoteDevice,
    law: &RemoteLaw,
    schedule: Schedule,
    link: &SerialLink,
    set: &Configuration,
    warn: &dyn Fn(&str),
) -> Result<Configuration, Failure> {
    if let Some(MotorPush::Own(_)) = law.push {
        may_push(device, link)?;
    }
    within(device, law, schedule, link.capabilities(), set, warn)
}

/// [`agreed`] for a device of these abilities.
///
/// # Errors
/// As [`agreed`].
pub fn within(
    device: &RemoteDevice,
    law: &RemoteLaw,
    schedule: Schedule,
    can: &Capabilities,
    set: &Configuration,
    warn: &dyn Fn(&str),
) -> Result<Configuration, Failure> {
    let mut configuration = configuration(device, law, schedule, can, &set.limits)?;
    let tighter = keep_within(&mut configuration, set);
    let most_n = configuration.limits.force_n;
    if law.held_push_n as f32 >= most_n {
        return Err(bad_input!(
            "push_n = {} is not below the device's own force limit of {most_n} N: no wall could hold it; \
             push less, or raise that limit with host-cli device set",
            Shown(law.held_push_n)
        ));
    }
    let own_push_n = law.own_push_n();
    if own_push_n as f32 > most_n {
        return Err(bad_input!(
            "push_n = {} is above the device's own force limit of {most_n} N: push less, or raise that limit with host-cli device set",
            Shown(own_push_n)
        ));
    }
    if let Some(tap) = &law.tap {
        let rise_s = f64::from(configuration.limits.rise_time_s);
        let third_s = tap.samples as f64 * tap.device.sample_time.0 / 3.0;
        if rise_s > third_s {
            return Err(bad_input!(
                "the force rises in {rise_s} s, more than a third of a trial of {} s that taps: give a {TRIAL_DURATION} of at least {} s, or shorten rise_time with host-cli device set",
                Shown(3.0 * third_s),
                Shown((3.1 * rise_s).ceil())
            ));
        }
        configuration.tap_n = tap.force_n(&configuration.limits);
        configuration.tap_ticks = tap.ticks();
    }
    if let Some(text) = tighter {
        warn(&text);
    }
    Ok(configuration)
}

/// Refuses a push of the device's own motor where there is no motor, or not each of the limits within which nobody has to watch it.
///
/// # Errors
/// Either of those, or a file of limits that cannot be read.
pub fn may_push(device: &RemoteDevice, link: &SerialLink) -> Result<(), Failure> {
    let lasting = device.name.remembered(link).set()?;
    let lasting = lasting.map(|lasting| lasting.limits);
    is_bounded(link.path(), link.capabilities(), lasting)
}

fn is_bounded(path: &str, can: &Capabilities, lasting: Option<Limits>) -> Result<(), Failure> {
    if can.force_max_n <= 0.0 {
        return Err(bad_input!(
            "{path} makes no force (at most {} N), so it cannot push: give {}, and hang a weight",
            can.force_max_n,
            PUSH_BY.set_to("hand")
        ));
    }
    let lacks = match lasting {
        None => "force_limit, workspace_low, workspace_high and speed_limit",
        Some(set) if set.workspace_low_m >= set.workspace_high_m => {
            "workspace_low and workspace_high"
        }
        Some(set) if set.speed_hard_m_per_s <= 0.0 => "speed_limit",
        Some(_) => return Ok(()),
    };
    Err(bad_input!(
        "{path} pushes by itself only within lasting limits of force, workspace and speed: set {lacks} with host-cli device set"
    ))
}

/// The configuration of the device, which has these limits now.
fn configuration(
    device: &RemoteDevice,
    law: &RemoteLaw,
    schedule: Schedule,
    capabilities: &Capabilities,
    present: &Limits,
) -> Result<Configuration, Failure> {
    let us = schedule.sample_time_s * 1e6;
    if (us - us.round()).abs() > 1e-6 || !(1.0..=4e9).contains(&us) {
        return Err(bad_input!(
            "sample time {} s is not a whole number of microseconds: change {SAMPLE_TIME}",
            Shown(schedule.sample_time_s)
        ));
    }
    let simulation = if capabilities.simulated {
        law.simulation
    } else {
        Simulation::REAL
    };
    let t = Seconds(schedule.sample_time_s);
    let known = law.guard.1.or(GuardedDevice::read_by(capabilities));
    let guard = guard_of(law.guard.0, known, &simulation, t)?;
    let limits = haptic_loop::SafetyLimits {
        guard,
        ..law.limits
    };
    single("force limit", limits.force.0)?;
    single("force rate limit", limits.rate.0)?;
    let limits = law.unchanged.of(wire_limits(&limits, t), present);
    let depth_map = law.depth_map.map(|map| map.rounded::<f32>()).transpose();
    let depth_map = depth_map.map_err(|error| {
        Failure::input_with_advice(error, "change the sizes of the piece of tissue")
    })?;
    Ok(Configuration {
        loop_mode: device.loop_mode,
        tick_period_us: us.round() as u32,
        stiffness_n_per_m: single("stiffness", law.stiffness_n_per_m)?,
        dissipation_n_s_mu_per_m: single("dissipation", law.dissipation_n_s_mu_per_m)?,
        order: law.order as f32,
        one_sided: law.one_sided,
        surface_m: 0.0,
        operator: law.operator.0,
        limits: Limits {
            watchdog_ms: device.watchdog_ms(),
            late_ticks: device.late_ticks,
            max_age_ticks: device.max_age_ticks,
            ..limits
        },
        simulation,
        own_push_n: match device.loop_mode {
            LoopMode::Device => single("push", law.own_push_n())?,
            // The controller here adds it.
            LoopMode::Host => 0.0,
        },
        tap_n: 0.0,
        tap_ticks: 0,
        depth_map: depth_map.map(|map| map.numbers()),
    })
}

/// Keeps a run within the limits that are set on the device, and says in one line where these are the tighter ones.
fn keep_within(configuration: &mut Configuration, set: &Configuration) -> Option<String> {
    type Row = (&'static str, fn(&Limits) -> f32, &'static str);
    const ROWS: [Row; 6] = [
        ("at most", |limits| limits.force_n, "force_n"),
        (
            "at most",
            |limits| limits.force_rate_n_per_s,
            "force_rate_n_per_s",
        ),
        ("rising in", |limits| limits.rise_time_s, "rise_time_s"),
        (
            "at most",
            |limits| limits.speed_hard_m_per_s,
            "speed_m_per_s",
        ),
        ("from", |limits| limits.workspace_low_m, "position_m"),
        ("up to", |limits| limits.workspace_high_m, "position_m"),
    ];
    let asked = configuration.limits;
    let (tight, looser) = configuration.tightened(set);
    configuration.limits = tight;
    let looser = looser?;
    // Limits that this run asked for are not those of the device.
    let tighter = ROWS.iter();
    let tighter = tighter.filter(|(_, of, _)| of(&tight).to_bits() != of(&asked).to_bits());
    let tighter = tighter.map(|(words, of, key)| {
        let value = f64::from(of(&tight));
        format!("{words} {}", haptic_quantity::written(key, value))
    });
    let tighter: Vec<String> = tighter.collect();
    let tighter = match tighter.as_slice() {
        [] => looser.to_string(),
        some => some.join(", "),
    };
    Some(format!(
        "the limits set on the device hold where they are tighter: {tighter}; a run cannot loosen them, host-cli device set can"
    ))
}

/// Coefficients for a device that does not compute the force itself: one zero.
pub fn no_operator() -> (OperatorShape, Vec<f32>) {
    (Configuration::PASSIVE.operator, vec![0.0])
}

/// The operator of a device, from the scheme.
///
/// # Errors
/// If the operator has a form that the wire does not carry, with what to change.
pub fn portable(operator: &Operator<f32>) -> Result<(OperatorShape, Vec<f32>), Failure> {
    haptic_remote::operator_shape(operator).map_err(|error| {
        Failure::input_with_advice(
            error,
            format_args!(
                "change {SCHEME}, or use {loop_host}",
                loop_host = LOOP.set_to("host")
            ),
        )
    })
}

/// The device, as on the command line.
pub fn device_name(device: Option<&RemoteDevice>) -> String {
    device.map_or_else(|| "sim".to_owned(), |device| device.name.to_string())
}

/// A simulated device without a wall to be felt: what a drive of the rig becomes on a device.
pub fn indentation(compliant: bool, depth_m: f64, ramp_time_s: f64) -> Simulation {
    Simulation {
        kind: if compliant {
            SimulationKind::CompliantIndentation
        } else {
            SimulationKind::RigidIndentation
        },
        depth_m: depth_m as f32,
        ramp_time_s: ramp_time_s as f32,
        ..Simulation::TESTBED
    }
}

/// A mass that a hand holds by a spring and pushes.
pub fn held(device: &MassDamperConfig, push_n: f64) -> Simulation {
    Simulation {
        kind: SimulationKind::MassDamper,
        mass_kg: device.mass.0 as f32,
        damping_n_s_per_m: device.damping.0 as f32,
        hand_stiffness_n_per_m: device.stiffness.0 as f32,
        push_n: push_n as f32,
        ..Simulation::REAL
    }
}

/// A constant push on the testbed's mass.
pub fn push(push_n: f64) -> Simulation {
    Simulation {
        push_n: push_n as f32,
        ..Simulation::TESTBED
    }
}
