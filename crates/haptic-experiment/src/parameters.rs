//! Parameters of the experiments: key, default, range and a line for people, once. Experiment files, options with their help,
//! and the reference of keys are made from these tables.
//!
//! Keys carry the SI unit of the value. `shown` is the default as a person writes it, and its value is the same (a test of the
//! command holds each against the number).

use fracdiff::Seconds;
use haptic_link::Limits as Wire;
use haptic_loop::Limits;
use std::fmt;

/// What a number may be. All ranges are of finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// x > low.
    Above(f64),
    /// x ≥ low.
    AtLeast(f64),
    /// low ≤ x ≤ high.
    Within(f64, f64),
    /// low < x ≤ high.
    AboveUpTo(f64, f64),
}

impl Range {
    /// Whether a number is in it; none that is not finite is.
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Above(low) => x > low,
                Self::AtLeast(low) => x >= low,
                Self::Within(low, high) => (low..=high).contains(&x),
                Self::AboveUpTo(low, high) => x > low && x <= high,
            }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Above(low) => write!(f, "above {low}"),
            Self::AtLeast(low) => write!(f, "at least {low}"),
            Self::Within(low, high) if high >= 1e6 => write!(f, "in [{low:e}, {high:e}]"),
            Self::Within(low, high) => write!(f, "in [{low}, {high}]"),
            Self::AboveUpTo(low, high) => write!(f, "in ({low}, {high}]"),
        }
    }
}

/// The kind of value that a parameter takes, and its default.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// A number in a range; the default is in SI units, `None` if the parameter may be left out and is off then.
    Number(Option<f64>, Range),
    /// A whole number.
    Count(u64),
    /// Yes or no.
    Flag(bool),
    /// A text, or one of several names.
    Text(&'static str),
}

/// A parameter of an experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in experiment files, with the unit.
    pub key: &'static str,
    /// Kind and default.
    pub value: Value,
    /// The default as a person writes it; empty if there is none.
    pub shown: &'static str,
    /// One line for people.
    pub help: &'static str,
}

impl Parameter {
    const fn number(
        key: &'static str,
        default: f64,
        shown: &'static str,
        range: Range,
        help: &'static str,
    ) -> Self {
        let value = Value::Number(Some(default), range);
        Self {
            key,
            value,
            shown,
            help,
        }
    }

    const fn optional(key: &'static str, range: Range, help: &'static str) -> Self {
        let value = Value::Number(None, range);
        Self {
            key,
            value,
            shown: "",
            help,
        }
    }

    const fn text(key: &'static str, default: &'static str, help: &'static str) -> Self {
        Self {
            key,
            value: Value::Text(default),
            shown: default,
            help,
        }
    }

    /// The default of a number; NaN if it has none.
    #[must_use]
    pub const fn default_number(&self) -> f64 {
        match self.value {
            Value::Number(Some(default), _) => default,
            _ => f64::NAN,
        }
    }

    /// The range of a number; empty for anything else.
    #[must_use]
    pub const fn range(&self) -> Range {
        match self.value {
            Value::Number(_, range) => range,
            _ => Range::Above(f64::INFINITY),
        }
    }
}

const ABOVE_0: Range = Range::Above(0.0);
const AT_LEAST_0: Range = Range::AtLeast(0.0);
const SAMPLE_TIMES: Range = Range::Within(Seconds::MIN_SAMPLE_TIME, Seconds::MAX_SAMPLE_TIME);

/// Strain of a relaxation.
pub const STRAIN: Parameter = Parameter::number(
    "strain",
    0.05,
    "5%",
    Range::AboveUpTo(0.0, 1.0),
    "Strain that is held",
);
/// Ramp of a relaxation, s.
pub const RAMP_TIME: Parameter =
    Parameter::number("ramp_time_s", 1.0, "1s", ABOVE_0, "Time to reach it");
/// End of a relaxation, s.
pub const RELAX_DURATION: Parameter = Parameter::number(
    "duration_s",
    200.0,
    "200s",
    ABOVE_0,
    "End of the experiment, from the start of the ramp",
);
/// Stress of a creep test, Pa.
pub const STRESS: Parameter = Parameter::number(
    "stress_pa",
    100.0,
    "100Pa",
    Range::AboveUpTo(0.0, 1e9),
    "Stress that is held",
);
/// End of a creep test, s.
pub const CREEP_DURATION: Parameter =
    Parameter::number("duration_s", 200.0, "200s", ABOVE_0, "How long");

/// Name of a tissue.
pub const TISSUE: Parameter = Parameter::text(
    "tissue",
    "prostate-cancerous",
    "Tissue: a name from `host-cli materials list`, or the path of a TOML file",
);
/// Folder of tissues.
pub const LIBRARY: Parameter = Parameter::text("library", "", "Folder with more tissue files");
/// Area of the specimen, m².
pub const AREA: Parameter =
    Parameter::number("area_m2", 4e-4, "4cm2", ABOVE_0, "Area of the specimen");
/// Thickness of the specimen, m.
pub const THICKNESS: Parameter = Parameter::number(
    "thickness_m",
    0.02,
    "20mm",
    ABOVE_0,
    "Thickness of the specimen",
);
/// Scheme of the operator.
pub const SCHEME: Parameter = Parameter::text(
    "scheme",
    "full",
    "Fractional operator by name, as full, grunwald:1000 or tustin-muir:5",
);
/// Number type of the loop.
pub const PRECISION: Parameter = Parameter::text("precision", "f64", "Number type of the loop");
/// Sample time of a rendered tissue, s.
pub const SAMPLE_TIME: Parameter = Parameter::number(
    "sample_time_s",
    1e-3,
    "1ms",
    SAMPLE_TIMES,
    "Sample time of the loop",
);
/// Contact of the rig.
pub const CONTACT: Parameter = Parameter::text(
    "contact",
    "compliant",
    "Contact between indenter and tissue: stiff springs between masses, or imposed exactly",
);
/// Encoder of a simulated device, m.
pub const ENCODER_RESOLUTION: Parameter = Parameter::number(
    "encoder_resolution_m",
    0.0,
    "0",
    AT_LEAST_0,
    "Resolution of the position encoder per count; 0 for an ideal one",
);
/// Noise of a simulated sensor, m.
pub const SENSOR_NOISE: Parameter = Parameter::number(
    "sensor_noise_m",
    0.0,
    "0",
    AT_LEAST_0,
    "Standard deviation of the sensor noise; 0 for none",
);
/// Seed of the noise.
pub const SEED: Parameter = Parameter {
    key: "seed",
    value: Value::Count(1),
    shown: "1",
    help: "Seed of the noise: the same seed gives the same run, bit for bit",
};
/// Force limit of a rendered tissue, N.
pub const FORCE_LIMIT: Parameter = Parameter::number(
    "force_limit_n",
    10.0,
    "10N",
    ABOVE_0,
    "Largest force the loop may command",
);
/// Rate limit of a rendered tissue, N/s.
pub const FORCE_RATE_LIMIT: Parameter = Parameter::number(
    "force_rate_limit_n_per_s",
    1000.0,
    "1000N/s",
    ABOVE_0,
    "Largest rate at which the force may change",
);

/// Mass of a simulated device, kg.
pub const MASS: Parameter =
    Parameter::number("mass_kg", 0.065, "65g", ABOVE_0, "Mass of the device");
/// Damping of a simulated device, N·s/m.
pub const DAMPING: Parameter = Parameter::number(
    "damping_n_s_per_m",
    3.5,
    "3.5",
    AT_LEAST_0,
    "Viscous damping of the device",
);
/// Stiffness of the hand, N/m.
pub const HAND_STIFFNESS: Parameter = Parameter::number(
    "hand_stiffness_n_per_m",
    0.0,
    "0",
    AT_LEAST_0,
    "Stiffness of the hand that holds it; 0 without a hand",
);
/// Sample time of a wall, s.
pub const WALL_SAMPLE_TIME: Parameter =
    Parameter::number("sample_time_s", 2e-3, "2ms", SAMPLE_TIMES, "Sample time");
/// Delay of a simulated device, s.
pub const DELAY: Parameter = Parameter::number(
    "delay_s",
    0.0,
    "0",
    AT_LEAST_0,
    "Delay from a measurement to the force that answers it, beside the hold",
);
/// Friction of a simulated device, N.
pub const FRICTION: Parameter =
    Parameter::number("friction_n", 0.0, "0", AT_LEAST_0, "Coulomb friction");
/// Current lag of a simulated device, s.
pub const CURRENT_LAG: Parameter = Parameter::number(
    "current_lag_s",
    0.0,
    "0",
    AT_LEAST_0,
    "Time constant of the actuator's current",
);
/// Order of a wall.
pub const ORDER: Parameter = Parameter::optional(
    "order",
    Range::Within(0.0, 2.0),
    "Order of the dissipation: 0 a spring, 1 a damper",
);
/// Stiffness of a wall, N/m.
pub const STIFFNESS: Parameter =
    Parameter::optional("stiffness_n_per_m", AT_LEAST_0, "Stiffness K of the wall");
/// Dissipation of a wall, N·s^μ/m.
pub const DISSIPATION: Parameter = Parameter::optional(
    "dissipation_n_s_mu_per_m",
    AT_LEAST_0,
    "Dissipation B of the wall, N·s^μ/m",
);
/// Whether a wall only pushes.
pub const ONE_SIDED: Parameter = Parameter {
    key: "one_sided",
    value: Value::Flag(false),
    shown: "",
    help: "A wall that pushes but never pulls; without this it is linear, as the theory assumes",
};
/// Rule of a trial.
pub const CRITERION: Parameter =
    Parameter::text("criterion", "settling", "By which rule a wall is stable");
/// Impact of a trial, m/s.
pub const IMPACT: Parameter = Parameter::number(
    "impact_m_per_s",
    0.1,
    "",
    AT_LEAST_0,
    "Speed at which the device hits the wall, m/s [default: 0.1, and 0 where it is only pushed]",
);
/// Push of a trial, N.
pub const PUSH: Parameter =
    Parameter::number("push_n", 1.0, "1N", ABOVE_0, "Constant push into the wall");
/// Length of a trial, s.
pub const TRIAL_DURATION: Parameter =
    Parameter::number("duration_s", 5.0, "5s", ABOVE_0, "Length of a run");
/// Window of a trial, s.
pub const WINDOW: Parameter = Parameter::number(
    "window_s",
    0.4,
    "0.4s",
    ABOVE_0,
    "Window at the end that is judged",
);
/// Threshold of the dissertation's rule, m.
pub const THRESHOLD: Parameter = Parameter::optional(
    "threshold_m",
    ABOVE_0,
    "Largest standard deviation of a stable position, with criterion dissertation [default: 0.1 mm]",
);
/// Force limit of a trial, N.
pub const TRIAL_FORCE_LIMIT: Parameter = Parameter::number(
    "force_limit_n",
    100.0,
    "100N",
    ABOVE_0,
    "Largest force of the actuator",
);
/// Rate limit of a trial, N/s.
pub const TRIAL_FORCE_RATE_LIMIT: Parameter = Parameter::optional(
    "force_rate_limit_n_per_s",
    ABOVE_0,
    "Largest rate at which the force may change [default: that of a serial device, none on the simulated one]",
);
/// Whether an unstable wall is a failure.
pub const MUST_BE_STABLE: Parameter = Parameter {
    key: "must_be_stable",
    value: Value::Flag(false),
    shown: "",
    help: "A wall that is not stable by trial and analysis is a failure",
};

/// The device.
pub const DEVICE: Parameter = Parameter::text(
    "device",
    "sim",
    "Device: `sim`, or `serial:PATH[@BAUD]`, or `serial:auto`",
);
/// Where the loop is closed.
pub const LOOP: Parameter = Parameter::text(
    "loop",
    "device",
    "Where the loop with a serial device is closed",
);
/// Watchdog of a serial device, s.
pub const WATCHDOG: Parameter = Parameter::optional(
    "watchdog_s",
    Range::Within(
        1e-3 * Wire::WATCHDOG_MIN_MS as f64,
        1e-3 * Wire::WATCHDOG_MAX_MS as f64,
    ),
    "Silence from this program after which a serial device lets go [default: 500ms, 20ms with a loop on the host]",
);
/// Late ticks of a serial device.
pub const LATE_TICKS: Parameter = Parameter {
    key: "late_ticks",
    value: Value::Count(Wire::DEFAULT.late_ticks as u64),
    shown: "20",
    help: "Late ticks in a row after which a serial device lets go; 0 for never",
};
/// Age of a force from the host, ticks.
pub const MAX_AGE_TICKS: Parameter = Parameter {
    key: "max_age_ticks",
    value: Value::Count(Wire::DEFAULT.max_age_ticks as u64),
    shown: "10",
    help: "In a loop on the host: ticks from a sample to the force that answers it at most, 1 to 1000; an older force makes a \
           serial device let go [default: 10]",
};

/// Passivity guard.
pub const GUARD: Parameter = Parameter::text(
    "guard",
    "off",
    "Keep the loop from feeding the device energy",
);
/// Low end of the workspace, m.
pub const WORKSPACE_LOW: Parameter = Parameter::optional(
    "workspace_low_m",
    Range::Within(-1e3, 1e3),
    "Lowest position; below it a fault ends the run",
);
/// High end of the workspace, m.
pub const WORKSPACE_HIGH: Parameter = Parameter::optional(
    "workspace_high_m",
    Range::Within(-1e3, 1e3),
    "Highest position; above it a fault ends the run",
);
/// Speed limit, m/s.
pub const SPEED_LIMIT: Parameter = Parameter::optional(
    "speed_limit_m_per_s",
    ABOVE_0,
    "How fast the device may move; beyond it a fault ends the run",
);
/// Rise time, s.
pub const RISE_TIME: Parameter = Parameter::optional(
    "rise_time_s",
    ABOVE_0,
    "Let the force rise in this time from the start on",
);
/// Braking, N·s/m.
pub const BRAKING: Parameter = Parameter::optional(
    "braking_n_s_per_m",
    ABOVE_0,
    "Brake with this damping near workspace and speed limit, and after a fault or stop",
);
/// Stop time, s.
pub const STOP_TIME: Parameter = Parameter::optional(
    "stop_time_s",
    Range::Within(Limits::STOP_TIME_S[0], Limits::STOP_TIME_S[1]),
    "Time in which the force falls to zero after a fault, a stop or the end, 1ms to 1s [default: 0.1s]",
);
/// Brake force, N.
pub const BRAKE_FORCE: Parameter = Parameter::optional(
    "brake_force_n",
    Range::Within(0.0, Limits::BRAKE_FORCE_MAX_N),
    "Largest force of the braking meanwhile, 0N to 10N [default: 2N]",
);
/// Stuck sensor, N.
pub const STUCK_FORCE: Parameter = Parameter::optional(
    "stuck_force_n",
    AT_LEAST_0,
    "A force that grows by this on a position that stands still is a fault; 0 for never [default: 3N on a serial device, else \
     never]",
);
/// Stuck sensor, s.
pub const STUCK_TIME: Parameter = Parameter::optional(
    "stuck_time_s",
    Range::Within(1e-3, 10.0),
    "Time for which the position has to have stood still for that [default: 0.1s]",
);
/// Jump of a sensor, m.
pub const JUMP: Parameter = Parameter::optional(
    "jump_m",
    AT_LEAST_0,
    "A position that moves in a sample by this more than the speed limit allows is a fault; 0 for never [default: 1mm on a \
     serial device, else never]",
);
/// Mass of a real device, kg.
pub const DEVICE_MASS: Parameter = Parameter::optional(
    "device_mass_kg",
    ABOVE_0,
    "Mass of a real device, for the guard observer, braking and the pre-flight",
);
/// Damping of a real device, N·s/m.
pub const DEVICE_DAMPING: Parameter = Parameter::optional(
    "device_damping_n_s_per_m",
    ABOVE_0,
    "Damping of a real device, for the guard energy-bounding and the pre-flight",
);
/// Least delay of a real device, s.
pub const DEVICE_DELAY_LEAST: Parameter = Parameter::optional(
    "device_delay_least_s",
    AT_LEAST_0,
    "Least delay of a real device from a measurement to the effect of its force, for the guard energy-bounding",
);
/// Largest delay of a real device, s.
pub const DEVICE_DELAY_MOST: Parameter = Parameter::optional(
    "device_delay_most_s",
    AT_LEAST_0,
    "Largest delay, the same if it is known",
);
/// Lag of a real device, s.
pub const DEVICE_LAG: Parameter = Parameter::optional(
    "device_lag_s",
    AT_LEAST_0,
    "Time constant with which the force of a real device follows, for the guard energy-bounding",
);
/// Noise of a real device, m.
pub const DEVICE_NOISE: Parameter = Parameter::optional(
    "device_noise_m",
    AT_LEAST_0,
    "Standard deviation of the noise of a real device's position, for the guard energy-bounding [default: 0.29 of its \
     resolution]",
);

/// Of `[relax]`, beside [`RENDERING`].
pub const RELAX: &[Parameter] = &[STRAIN, RAMP_TIME, RELAX_DURATION];
/// Of `[creep]`, beside [`RENDERING`].
pub const CREEP: &[Parameter] = &[STRESS, CREEP_DURATION];
/// What is rendered, and how.
pub const RENDERING: &[Parameter] = &[
    TISSUE,
    LIBRARY,
    AREA,
    THICKNESS,
    SCHEME,
    PRECISION,
    SAMPLE_TIME,
    CONTACT,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
    SEED,
    FORCE_LIMIT,
    FORCE_RATE_LIMIT,
];
/// Of `[wall]` that have to be given in a file.
pub const WALL_REQUIRED: &[Parameter] = &[
    MASS,
    DAMPING,
    WALL_SAMPLE_TIME,
    ORDER,
    STIFFNESS,
    DISSIPATION,
];
/// Of `[wall]`, with defaults.
pub const WALL: &[Parameter] = &[
    HAND_STIFFNESS,
    DELAY,
    FRICTION,
    CURRENT_LAG,
    ENCODER_RESOLUTION,
    SENSOR_NOISE,
    SEED,
    TRIAL_FORCE_LIMIT,
    TRIAL_FORCE_RATE_LIMIT,
    SCHEME,
    ONE_SIDED,
    CRITERION,
    IMPACT,
    PUSH,
    TRIAL_DURATION,
    WINDOW,
    THRESHOLD,
    MUST_BE_STABLE,
];
/// Of every experiment on a device.
pub const ON_DEVICE: &[Parameter] = &[DEVICE, LOOP, WATCHDOG, LATE_TICKS, MAX_AGE_TICKS];
/// Of the safety chain, for every experiment.
pub const SAFETY: &[Parameter] = &[
    GUARD,
    WORKSPACE_LOW,
    WORKSPACE_HIGH,
    SPEED_LIMIT,
    RISE_TIME,
    BRAKING,
    STOP_TIME,
    BRAKE_FORCE,
    STUCK_FORCE,
    STUCK_TIME,
    JUMP,
    DEVICE_MASS,
    DEVICE_DAMPING,
    DEVICE_DELAY_LEAST,
    DEVICE_DELAY_MOST,
    DEVICE_LAG,
    DEVICE_NOISE,
];

/// Tables of experiment files by kind: heading and parameters.
#[must_use]
pub fn of_kind(kind: &str) -> Vec<(&'static str, &'static [Parameter])> {
    let common = [("device", ON_DEVICE), ("safety", SAFETY)];
    let own: &[(&str, &[Parameter])] = match kind {
        "relax" => &[("relaxation", RELAX), ("rendering", RENDERING)],
        "creep" => &[("creep", CREEP), ("rendering", RENDERING)],
        _ => &[("required", WALL_REQUIRED), ("wall", WALL)],
    };
    own.iter().copied().chain(common).collect()
}

/// Whether experiment files have this key.
#[must_use]
pub fn is_key(key: &str) -> bool {
    let all = [
        RELAX,
        CREEP,
        RENDERING,
        WALL_REQUIRED,
        WALL,
        ON_DEVICE,
        SAFETY,
    ];
    all.concat().iter().any(|parameter| parameter.key == key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_no_key_twice_and_every_default_is_in_its_range() {
        for kind in ["relax", "creep", "wall"] {
            let all: Vec<Parameter> = of_kind(kind)
                .iter()
                .flat_map(|(_, table)| *table)
                .copied()
                .collect();
            for (n, parameter) in all.iter().enumerate() {
                assert!(
                    all[..n].iter().all(|other| other.key != parameter.key),
                    "{}",
                    parameter.key
                );
                if let Value::Number(Some(default), range) = parameter.value {
                    assert!(range.contains(default), "{}: {default}", parameter.key);
                }
            }
        }
    }
}
