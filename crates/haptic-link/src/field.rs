//! Names of the parameters that can be refused.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Names of what can be refused, each with its words and, of a limit, its key.
macro_rules! fields {
    ($($name:ident = $words:literal $(, $key:literal)?;)+) => {
        /// Names of what can be refused; numbers as on the wire.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
        pub enum Field {
            $(#[doc = $words] $name,)+
        }

        impl Field {
            /// The key of a limit in files, options and reports; empty for what is none.
            #[must_use]
            pub const fn key(self) -> &'static str {
                match self {
                    $($(Self::$name => $key,)?)+
                    _ => "",
                }
            }
        }

        impl core::fmt::Display for Field {
            /// The name of the parameter with its unit, as a person gives it.
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(match self {
                    $(Self::$name => $words,)+
                })
            }
        }
    };
}

fields! {
    TickPeriod = "sample time (ms)";
    Stiffness = "stiffness (N/m)";
    Dissipation = "dissipation (N·s^μ/m)";
    Surface = "surface (m)";
    IntegerPart = "integer part of the order";
    CoefficientCount = "number of coefficients";
    Coefficient = "coefficient";
    Offset = "offset of coefficients";
    ForceLimit = "force limit (N)", "force_limit_n";
    ForceRateLimit = "force rate limit (N/s)", "force_rate_limit_n_per_s";
    Watchdog = "watchdog time (ms)";
    SimulationKind = "simulation";
    Mass = "mass (kg)";
    Damping = "damping (N·s/m)";
    HandStiffness = "hand stiffness (N/m)";
    Push = "push (N)";
    Depth = "depth of the indentation (m)";
    RampTime = "ramp time (s)";
    BatchLength = "samples in a frame";
    Every = "ticks from sample to sample";
    FlightIndex = "index of a flight-recorder sample";
    StartForce = "start force (N)", "start_force_n";
    RiseTime = "rise time (s)", "rise_time_s";
    WorkspaceLow = "low end of the workspace (m)";
    WorkspaceHigh = "high end of the workspace (m)";
    WorkspaceSoft = "workspace soft zone (m)", "workspace_soft_m";
    SpeedSoft = "soft speed limit (m/s)", "speed_soft_m_per_s";
    SpeedHard = "speed limit (m/s)", "speed_limit_m_per_s";
    VelocityBandwidth = "velocity bandwidth (Hz)", "velocity_bandwidth_hz";
    Braking = "braking (N·s/m)", "braking_n_s_per_m";
    StopTime = "stop time (s)", "stop_time_s";
    BrakeForce = "brake force (N)", "brake_force_n";
    DeviceMass = "mass of the device (kg)", "device_mass_kg";
    StuckForce = "stuck force (N)", "stuck_force_n";
    StuckTime = "stuck time (s)", "stuck_time_s";
    Jump = "jump (m)", "jump_m";
    GuardDamping = "damping of the guard (N·s/m)";
    GuardShare = "share of the damping that the guard uses";
    GuardForget = "time in which the guard forgets (s)";
    GuardDelayLeast = "least delay of the guard (samples)";
    GuardDelayMost = "most delay of the guard (samples)";
    GuardLag = "lag of the actuator for the guard (s)";
    GuardNoise = "noise of the position for the guard (m)";
    MaxAge = "age of a force (ticks)";
    Other = "a parameter of a newer version";
}

impl Field {
    /// A number as on the wire in the unit that [`Display`](core::fmt::Display) names.
    #[must_use]
    pub fn shown(self, on_the_wire: f32) -> f32 {
        match self {
            Self::TickPeriod => on_the_wire / 1000.0,
            _ => on_the_wire,
        }
    }
}
