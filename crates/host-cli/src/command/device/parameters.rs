//! The parameters of a device as a person and a script see them.

use haptic_link::{Configuration, GuardKind, Limits, LoopMode, OperatorForm, SimulationKind};
use serde::Serialize;

/// A configuration with units in its keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameters {
    /// Its name.
    pub device: String,
    /// `device` or `host`.
    #[serde(rename = "loop")]
    pub loop_mode: &'static str,
    /// T.
    pub sample_time_s: f64,
    /// K.
    pub stiffness_n_per_m: f32,
    /// B.
    pub dissipation_n_s_mu_per_m: f32,
    /// μ.
    pub order: f32,
    /// Pushes but never pulls.
    pub one_sided: bool,
    /// Position at which the wall begins.
    pub surface_m: f32,
    /// The operator.
    pub operator: OperatorParameters,
    /// Largest force.
    pub force_limit_n: f32,
    /// Largest rate of force.
    pub force_rate_limit_n_per_s: f32,
    /// Silence that latches a fault.
    pub watchdog_s: f64,
    /// Late ticks in a row that latch a fault; 0 never.
    pub late_ticks: u16,
    /// Ticks from a sample to the force that answers it at most.
    pub max_age_ticks: u16,
    /// Other settings of the safety chain.
    pub safety: SafetyParameters,
    /// The simulated plant; null for a real device.
    pub simulation: Option<SimulationParameters>,
}

/// The safety chain beyond force and rate; 0 or null is off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SafetyParameters {
    /// Largest force with which the device's loop starts.
    pub start_force_n: f32,
    /// Why 0 is none.
    pub start_force_reason: Option<&'static str>,
    /// Time in which the force rises.
    pub rise_time_s: f32,
    /// Lowest and highest position.
    pub workspace_m: Option<[f32; 2]>,
    /// Why there is none.
    pub workspace_reason: Option<&'static str>,
    /// Width of the zones to brake in.
    pub workspace_soft_m: f32,
    /// Largest speed.
    pub speed_limit_m_per_s: f32,
    /// Why 0 is none.
    pub speed_limit_reason: Option<&'static str>,
    /// Speed from which on the motion is braked.
    pub speed_soft_m_per_s: f32,
    /// Bandwidth of the estimated velocity.
    pub velocity_bandwidth_hz: f32,
    /// Damping that brakes.
    pub braking_n_s_per_m: f32,
    /// Why 0 is none.
    pub braking_reason: Option<&'static str>,
    /// Time in which the force falls to zero after a fault or stop.
    pub stop_time_s: f32,
    /// Largest force of the braking meanwhile.
    pub brake_force_n: f32,
    /// Mass of the device; null for unknown.
    pub device_mass_kg: Option<f32>,
    /// From a force to its effect.
    pub device_delay_ticks: u8,
    /// Growth of the wanted force on a sensor that stands still.
    pub stuck_force_n: f32,
    /// Why 0 is none.
    pub stuck_force_reason: Option<&'static str>,
    /// Time for which it has to have stood still.
    pub stuck_time_s: f32,
    /// Largest move in a tick beyond the speed limit.
    pub jump_m: f32,
    /// Why 0 is none.
    pub jump_reason: Option<&'static str>,
    /// Passivity guard.
    pub guard: Option<GuardParameters>,
    /// Why there is none.
    pub guard_reason: Option<&'static str>,
}

/// The passivity guard of a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuardParameters {
    /// `observer` or `energy-bounding`.
    pub kind: &'static str,
    /// Most damping that it adds, or damping of the device.
    pub damping_n_s_per_m: f32,
    /// Share of the damping of the device; only energy bounding uses it.
    pub share: f32,
    /// Time for which a credit of energy lasts.
    pub forget_s: f32,
    /// Least delay from a measurement to the effect of its force; only energy bounding uses what follows.
    pub delay_least_samples: f32,
    /// The most.
    pub delay_most_samples: f32,
    /// Time constant of the actuator.
    pub lag_s: f32,
    /// Standard deviation of the noise of the position.
    pub noise_m: f32,
}

impl SafetyParameters {
    fn new(limits: &Limits) -> Self {
        let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
        let guard = &limits.guard;
        let kind = match guard.kind {
            GuardKind::Off => None,
            GuardKind::Observer => Some("observer"),
            GuardKind::EnergyBounding => Some("energy-bounding"),
        };
        let off = |value: f32, words| (value <= 0.0).then_some(words);
        Self {
            start_force_reason: off(limits.start_force_n, "off: any force"),
            speed_limit_reason: off(limits.speed_hard_m_per_s, "off: any speed"),
            braking_reason: off(limits.braking_n_s_per_m, "off"),
            stuck_force_reason: off(limits.stuck_force_n, "off"),
            jump_reason: match limits.speed_hard_m_per_s > 0.0 && limits.jump_m > 0.0 {
                true => None,
                false => Some("off: it needs a speed limit, and to be above 0"),
            },
            start_force_n: limits.start_force_n,
            rise_time_s: limits.rise_time_s,
            workspace_m: (low < high).then_some([low, high]),
            workspace_reason: (low >= high).then_some("none is set"),
            workspace_soft_m: limits.workspace_soft_m,
            speed_limit_m_per_s: limits.speed_hard_m_per_s,
            speed_soft_m_per_s: limits.speed_soft_m_per_s,
            velocity_bandwidth_hz: limits.velocity_bandwidth_hz,
            braking_n_s_per_m: limits.braking_n_s_per_m,
            stop_time_s: limits.stop_time_s,
            brake_force_n: limits.brake_force_n,
            device_mass_kg: (limits.device_mass_kg > 0.0).then_some(limits.device_mass_kg),
            device_delay_ticks: limits.device_delay_ticks,
            stuck_force_n: limits.stuck_force_n,
            stuck_time_s: limits.stuck_time_s,
            jump_m: limits.jump_m,
            guard_reason: kind.is_none().then_some("off"),
            guard: kind.map(|kind| GuardParameters {
                kind,
                damping_n_s_per_m: guard.damping_n_s_per_m,
                share: guard.share,
                forget_s: guard.forget_s,
                delay_least_samples: guard.delay_least_samples,
                delay_most_samples: guard.delay_most_samples,
                lag_s: guard.lag_s,
                noise_m: guard.noise_m,
            }),
        }
    }
}

/// The operator of a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OperatorParameters {
    /// `taps`, `modes`, `recursion` or `sections`.
    pub form: &'static str,
    /// Differences or sums around it.
    pub integer: i8,
    /// Its coefficients.
    pub coefficients: Vec<f32>,
}

/// The plant of a simulated device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulationParameters {
    /// `mass-damper`, `rigid-indentation` or `compliant-indentation`.
    pub kind: &'static str,
    /// Mass.
    pub mass_kg: f32,
    /// Damping.
    pub damping_n_s_per_m: f32,
    /// Stiffness of the hand.
    pub hand_stiffness_n_per_m: f32,
    /// Push of the hand.
    pub push_n: f32,
    /// Depth of the indentation.
    pub depth_m: f32,
    /// Time to reach it.
    pub ramp_time_s: f32,
}

impl Parameters {
    /// Of a device, its configuration and its coefficients.
    #[must_use]
    pub fn new(device: String, configuration: &Configuration, coefficients: &[f32]) -> Self {
        let simulation = &configuration.simulation;
        let kind = match simulation.kind {
            SimulationKind::Real => None,
            SimulationKind::MassDamper => Some("mass-damper"),
            SimulationKind::RigidIndentation => Some("rigid-indentation"),
            SimulationKind::CompliantIndentation => Some("compliant-indentation"),
        };
        Self {
            device,
            loop_mode: match configuration.loop_mode {
                LoopMode::Device => "device",
                LoopMode::Host => "host",
            },
            sample_time_s: f64::from(configuration.tick_period_us) * 1e-6,
            stiffness_n_per_m: configuration.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: configuration.dissipation_n_s_mu_per_m,
            order: configuration.order,
            one_sided: configuration.one_sided,
            surface_m: configuration.surface_m,
            operator: OperatorParameters {
                form: match configuration.operator.form {
                    OperatorForm::Taps => "taps",
                    OperatorForm::Modes => "modes",
                    OperatorForm::Recursion => "recursion",
                    OperatorForm::Sections => "sections",
                },
                integer: configuration.operator.integer,
                coefficients: coefficients.to_vec(),
            },
            force_limit_n: configuration.limits.force_n,
            force_rate_limit_n_per_s: configuration.limits.force_rate_n_per_s,
            watchdog_s: f64::from(configuration.limits.watchdog_ms) * 1e-3,
            late_ticks: configuration.limits.late_ticks,
            max_age_ticks: configuration.limits.max_age_ticks,
            safety: SafetyParameters::new(&configuration.limits),
            simulation: kind.map(|kind| SimulationParameters {
                kind,
                mass_kg: simulation.mass_kg,
                damping_n_s_per_m: simulation.damping_n_s_per_m,
                hand_stiffness_n_per_m: simulation.hand_stiffness_n_per_m,
                push_n: simulation.push_n,
                depth_m: simulation.depth_m,
                ramp_time_s: simulation.ramp_time_s,
            }),
        }
    }
}
