//! The parameters of a device as a person and a script see them.

use haptic_link::{
    Configuration, Field, Guard, GuardKind, Limits, LoopMode, OperatorForm, SimulationKind, Tighter,
};
use haptic_quantity::without_unit;
use serde::ser::{Serialize, SerializeMap as _, Serializer};

/// A configuration with units in its keys.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
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

/// The safety chain beyond force and rate, row by row of the table of limits; 0 or null is off, and `X_reason` says why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyParameters(Limits);

impl Serialize for SafetyParameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut limits = self.0;
        let mut map = serializer.serialize_map(None)?;
        // Force and its rate stand beside the chain.
        for limit in &Limits::TABLE[2..] {
            let (value, key) = (*(limit.of)(&mut limits), limit.field.key());
            let off = match limit.field {
                Field::DeviceMass => {
                    map.serialize_entry(key, &(value > 0.0).then_some(value))?;
                    continue;
                }
                Field::Jump if value > 0.0 && limits.speed_hard_m_per_s <= 0.0 => true,
                _ => value <= 0.0,
            };
            map.serialize_entry(key, &value)?;
            if limit.tighter == Tighter::LessUnlessOff {
                let why = match limit.field {
                    Field::StartForce => "off: any force",
                    Field::SpeedHard => "off: any speed",
                    Field::Jump => "off: it needs a speed limit, and to be above 0",
                    _ => "off",
                };
                let reason = format!("{}_reason", without_unit(key));
                map.serialize_entry(&reason, &off.then_some(why))?;
            }
        }
        let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
        map.serialize_entry("workspace_m", &(low < high).then_some([low, high]))?;
        map.serialize_entry("workspace_reason", &(low >= high).then_some("none is set"))?;
        map.serialize_entry("workspace_soft_m", &limits.workspace_soft_m)?;
        map.serialize_entry("speed_soft_m_per_s", &limits.speed_soft_m_per_s)?;
        map.serialize_entry("braking_n_s_per_m", &limits.braking_n_s_per_m)?;
        let unbraked = limits.braking_n_s_per_m <= 0.0;
        map.serialize_entry("braking_reason", &unbraked.then_some("off"))?;
        map.serialize_entry("device_delay_ticks", &limits.device_delay_ticks)?;
        map.serialize_entry("stuck_time_s", &limits.stuck_time_s)?;
        let guard = GuardParameters::of(&limits.guard);
        map.serialize_entry("guard_reason", &guard.is_none().then_some("off"))?;
        map.serialize_entry("guard", &guard)?;
        map.end()
    }
}

/// The passivity guard of a device.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
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

impl GuardParameters {
    fn of(guard: &Guard) -> Option<Self> {
        let kind = match guard.kind {
            GuardKind::Off => return None,
            GuardKind::Observer => "observer",
            GuardKind::EnergyBounding => "energy-bounding",
        };
        Some(Self {
            kind,
            damping_n_s_per_m: guard.damping_n_s_per_m,
            share: guard.share,
            forget_s: guard.forget_s,
            delay_least_samples: guard.delay_least_samples,
            delay_most_samples: guard.delay_most_samples,
            lag_s: guard.lag_s,
            noise_m: guard.noise_m,
        })
    }
}

/// The operator of a device.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OperatorParameters {
    /// `taps`, `modes`, `recursion` or `sections`.
    pub form: &'static str,
    /// Differences or sums around it.
    pub integer: i8,
    /// Its coefficients.
    pub coefficients: Vec<f32>,
}

/// The plant of a simulated device.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
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
            safety: SafetyParameters(configuration.limits),
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
