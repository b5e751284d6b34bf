//! Names of the parameters that can be refused.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Names of what can be refused; numbers as on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Field {
    /// [`Configuration::tick_period_us`](crate::Configuration::tick_period_us).
    TickPeriod,
    /// [`Configuration::stiffness_n_per_m`](crate::Configuration::stiffness_n_per_m).
    Stiffness,
    /// [`Configuration::dissipation_n_s_mu_per_m`](crate::Configuration::dissipation_n_s_mu_per_m).
    Dissipation,
    /// [`Configuration::surface_m`](crate::Configuration::surface_m).
    Surface,
    /// [`OperatorShape::integer`](crate::OperatorShape::integer).
    IntegerPart,
    /// [`OperatorShape::count`](crate::OperatorShape::count).
    CoefficientCount,
    /// A coefficient.
    Coefficient,
    /// [`CoefficientBlock::offset`](crate::CoefficientBlock::offset), or that of a request for one.
    Offset,
    /// [`Limits::force_n`](crate::Limits::force_n).
    ForceLimit,
    /// [`Limits::force_rate_n_per_s`](crate::Limits::force_rate_n_per_s).
    ForceRateLimit,
    /// [`Limits::watchdog_ms`](crate::Limits::watchdog_ms).
    Watchdog,
    /// [`Simulation::kind`](crate::Simulation::kind).
    SimulationKind,
    /// [`Simulation::mass_kg`](crate::Simulation::mass_kg).
    Mass,
    /// [`Simulation::damping_n_s_per_m`](crate::Simulation::damping_n_s_per_m).
    Damping,
    /// [`Simulation::hand_stiffness_n_per_m`](crate::Simulation::hand_stiffness_n_per_m).
    HandStiffness,
    /// [`Simulation::push_n`](crate::Simulation::push_n).
    Push,
    /// [`Simulation::depth_m`](crate::Simulation::depth_m).
    Depth,
    /// [`Simulation::ramp_time_s`](crate::Simulation::ramp_time_s).
    RampTime,
    /// Samples in a frame.
    BatchLength,
    /// Ticks from a sent sample to the next.
    Every,
    /// Index of a flight-recorder sample.
    FlightIndex,
    /// [`Limits::start_force_n`](crate::Limits::start_force_n).
    StartForce,
    /// [`Limits::rise_time_s`](crate::Limits::rise_time_s).
    RiseTime,
    /// [`Limits::workspace_low_m`](crate::Limits::workspace_low_m).
    WorkspaceLow,
    /// [`Limits::workspace_high_m`](crate::Limits::workspace_high_m).
    WorkspaceHigh,
    /// [`Limits::workspace_soft_m`](crate::Limits::workspace_soft_m).
    WorkspaceSoft,
    /// [`Limits::speed_soft_m_per_s`](crate::Limits::speed_soft_m_per_s).
    SpeedSoft,
    /// [`Limits::speed_hard_m_per_s`](crate::Limits::speed_hard_m_per_s).
    SpeedHard,
    /// [`Limits::velocity_bandwidth_hz`](crate::Limits::velocity_bandwidth_hz).
    VelocityBandwidth,
    /// [`Limits::braking_n_s_per_m`](crate::Limits::braking_n_s_per_m).
    Braking,
    /// [`Limits::stop_time_s`](crate::Limits::stop_time_s).
    StopTime,
    /// [`Limits::brake_force_n`](crate::Limits::brake_force_n).
    BrakeForce,
    /// [`Limits::device_mass_kg`](crate::Limits::device_mass_kg).
    DeviceMass,
    /// [`Limits::stuck_force_n`](crate::Limits::stuck_force_n).
    StuckForce,
    /// [`Limits::stuck_time_s`](crate::Limits::stuck_time_s).
    StuckTime,
    /// [`Limits::jump_m`](crate::Limits::jump_m).
    Jump,
    /// [`Guard::damping_n_s_per_m`](crate::Guard::damping_n_s_per_m).
    GuardDamping,
    /// [`Guard::share`](crate::Guard::share).
    GuardShare,
    /// [`Guard::forget_s`](crate::Guard::forget_s).
    GuardForget,
    /// [`Guard::delay_least_samples`](crate::Guard::delay_least_samples).
    GuardDelayLeast,
    /// [`Guard::delay_most_samples`](crate::Guard::delay_most_samples).
    GuardDelayMost,
    /// [`Guard::lag_s`](crate::Guard::lag_s).
    GuardLag,
    /// [`Guard::noise_m`](crate::Guard::noise_m).
    GuardNoise,
    /// [`Limits::max_age_ticks`](crate::Limits::max_age_ticks).
    MaxAge,
    /// Another one, of a newer version.
    Other,
}

impl Field {
    /// The key of a limit in files, options and reports; empty for what is none.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::ForceLimit => "force_limit_n",
            Self::ForceRateLimit => "force_rate_limit_n_per_s",
            Self::StartForce => "start_force_n",
            Self::RiseTime => "rise_time_s",
            Self::SpeedHard => "speed_limit_m_per_s",
            Self::VelocityBandwidth => "velocity_bandwidth_hz",
            Self::StopTime => "stop_time_s",
            Self::BrakeForce => "brake_force_n",
            Self::DeviceMass => "device_mass_kg",
            Self::StuckForce => "stuck_force_n",
            Self::StuckTime => "stuck_time_s",
            Self::Jump => "jump_m",
            Self::Braking => "braking_n_s_per_m",
            Self::WorkspaceSoft => "workspace_soft_m",
            Self::SpeedSoft => "speed_soft_m_per_s",
            _ => "",
        }
    }

    /// A number as on the wire in the unit that [`Display`](core::fmt::Display) names.
    #[must_use]
    pub fn shown(self, on_the_wire: f32) -> f32 {
        match self {
            Self::TickPeriod => on_the_wire / 1000.0,
            _ => on_the_wire,
        }
    }
}

impl core::fmt::Display for Field {
    /// The name of the parameter with its unit, as a person gives it.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TickPeriod => "sample time (ms)",
            Self::Stiffness => "stiffness (N/m)",
            Self::Dissipation => "dissipation (N·s^μ/m)",
            Self::Surface => "surface (m)",
            Self::IntegerPart => "integer part of the order",
            Self::CoefficientCount => "number of coefficients",
            Self::Coefficient => "coefficient",
            Self::Offset => "offset of coefficients",
            Self::ForceLimit => "force limit (N)",
            Self::ForceRateLimit => "force rate limit (N/s)",
            Self::Watchdog => "watchdog time (ms)",
            Self::SimulationKind => "simulation",
            Self::Mass => "mass (kg)",
            Self::Damping => "damping (N·s/m)",
            Self::HandStiffness => "hand stiffness (N/m)",
            Self::Push => "push (N)",
            Self::Depth => "depth of the indentation (m)",
            Self::RampTime => "ramp time (s)",
            Self::BatchLength => "samples in a frame",
            Self::Every => "ticks from sample to sample",
            Self::FlightIndex => "index of a flight-recorder sample",
            Self::StartForce => "start force (N)",
            Self::RiseTime => "rise time (s)",
            Self::WorkspaceLow => "low end of the workspace (m)",
            Self::WorkspaceHigh => "high end of the workspace (m)",
            Self::WorkspaceSoft => "workspace soft zone (m)",
            Self::SpeedSoft => "soft speed limit (m/s)",
            Self::SpeedHard => "speed limit (m/s)",
            Self::VelocityBandwidth => "velocity bandwidth (Hz)",
            Self::Braking => "braking (N·s/m)",
            Self::StopTime => "stop time (s)",
            Self::BrakeForce => "brake force (N)",
            Self::DeviceMass => "mass of the device (kg)",
            Self::StuckForce => "stuck force (N)",
            Self::StuckTime => "stuck time (s)",
            Self::Jump => "jump (m)",
            Self::GuardDamping => "damping of the guard (N·s/m)",
            Self::GuardShare => "share of the damping that the guard uses",
            Self::GuardForget => "time in which the guard forgets (s)",
            Self::GuardDelayLeast => "least delay of the guard (samples)",
            Self::GuardDelayMost => "most delay of the guard (samples)",
            Self::GuardLag => "lag of the actuator for the guard (s)",
            Self::GuardNoise => "noise of the position for the guard (m)",
            Self::MaxAge => "age of a force (ticks)",
            Self::Other => "a parameter of a newer version",
        })
    }
}
