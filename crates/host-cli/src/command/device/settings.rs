//! `device get` and `device set`: the parameters of a device as a person and a script see them.

use super::changes::{self, Changes};
use super::port::PortArguments;
use crate::output::{Output, joined, warn};
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::{at_port, refused_at_port};
use haptic_link::{
    Configuration, Field, GuardKind, Limits, LoopMode, OperatorForm, SimulationKind, Tighter,
};
use haptic_quantity::{digits, label, without_unit, written};
use serde_json::{Value, json};

pub(super) fn get(port: &PortArguments, output: Output) -> Result<(), Failure> {
    let link = port.connect_any()?;
    let configuration = link.configuration();
    let (configuration, values) = configuration.map_err(|error| at_port(link.path(), &error))?;
    output.report(&parameters(&link.name(), &configuration, &values))
}

/// Arguments of `device set`.
#[derive(Debug, Args)]
#[command(after_help = format!(
    "Example: host-cli device set --device serial:/dev/ttyACM0 force_limit=0.5N workspace=-10mm:20mm\n\nKeys:{}",
    changes::help()
))]
pub(crate) struct Set {
    #[command(flatten)]
    port: PortArguments,
    /// Parameters, with a unit or in SI units, as in `force_limit=0.5N`
    #[arg(value_name = "KEY=VALUE", required = true)]
    values: Vec<String>,
}

impl Set {
    /// Reads what is set, changes what was given, sets it, and reads it back.
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let changes = Changes::read(&self.values)?;
        let mut link = self.port.connect_any()?;
        let path = link.path().to_owned();
        let problem = |error| at_port(&path, &error);
        let (mut configuration, mut values) = link.configuration().map_err(problem)?;
        let before = configuration.limits;
        changes.apply(&mut configuration, &mut values)?;
        let set = link.set(configuration, &values);
        set.map_err(|error| refused_at_port(&path, error))?;
        let (configuration, values) = link.configuration().map_err(problem)?;
        for limit in loosened(&before, &configuration.limits) {
            warn(&format!("loosened: {limit}"));
        }
        output.summary(&parameters(&link.name(), &configuration, &values))
    }
}

/// A number of a device in its shortest form: 0.1, not 0.10000000149.
pub(super) fn number(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::NAN)
}

/// A configuration with units in its keys.
fn parameters(device: &str, configuration: &Configuration, coefficients: &[f32]) -> Value {
    let limits = &configuration.limits;
    let n = number;
    json!({
        "device": device,
        "loop": match configuration.loop_mode {
            LoopMode::Device => "device",
            LoopMode::Host => "host",
        },
        "sample_time_s": f64::from(configuration.tick_period_us) * 1e-6,
        "stiffness_n_per_m": n(configuration.stiffness_n_per_m),
        "dissipation_n_s_mu_per_m": n(configuration.dissipation_n_s_mu_per_m),
        "order": n(configuration.order),
        "one_sided": configuration.one_sided,
        "surface_m": n(configuration.surface_m),
        "depth_map": configuration.depth_map.map(|numbers| numbers.map(n)),
        "operator": {
            "form": match configuration.operator.form {
                OperatorForm::Taps => "taps",
                OperatorForm::Modes => "modes",
                OperatorForm::Recursion => "recursion",
            },
            "integer": configuration.operator.integer,
            "coefficients": coefficients.iter().copied().map(n).collect::<Vec<_>>(),
        },
        "force_limit_n": n(limits.force_n),
        "force_rate_limit_n_per_s": n(limits.force_rate_n_per_s),
        "watchdog_s": f64::from(limits.watchdog_ms) * 1e-3,
        "late_ticks": limits.late_ticks,
        "max_age_ticks": limits.max_age_ticks,
        "safety": joined([chain(limits), guard(limits)]),
        "simulation": simulation(configuration),
    })
}

/// The safety chain beyond force and rate, row by row of the table of limits; 0 or null is off, and `X_reason` says why.
fn chain(limits: &Limits) -> Value {
    let n = number;
    let mut limits = *limits;
    let mut chain = serde_json::Map::new();
    // Force and its rate stand beside the chain.
    for limit in &Limits::TABLE[2..] {
        let (value, key) = (*(limit.of)(&mut limits), limit.field.key());
        let without_speed = limit.field == Field::Jump && limits.speed_hard_m_per_s <= 0.0;
        let off = value <= 0.0 || without_speed;
        let unknown = limit.field == Field::DeviceMass && off;
        chain.insert(key.to_owned(), json!((!unknown).then(|| n(value))));
        if limit.tighter == Tighter::LessUnlessOff {
            let why = if limit.field == Field::StartForce {
                "off: any force"
            } else if limit.field == Field::SpeedHard {
                "off: any speed"
            } else if limit.field == Field::Jump {
                "off: it needs a speed limit, and to be above 0"
            } else {
                "off"
            };
            let reason = format!("{}_reason", without_unit(key));
            chain.insert(reason, json!(off.then_some(why)));
        }
    }
    let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
    let rest = json!({
        "workspace_m": (low < high).then_some([n(low), n(high)]),
        "workspace_reason": (low >= high).then_some("none is set"),
        "workspace_soft_m": n(limits.workspace_soft_m),
        "speed_soft_m_per_s": n(limits.speed_soft_m_per_s),
        "braking_n_s_per_m": n(limits.braking_n_s_per_m),
        "braking_reason": (limits.braking_n_s_per_m <= 0.0).then_some("off"),
        "device_delay_ticks": limits.device_delay_ticks,
        "stuck_time_s": n(limits.stuck_time_s),
    });
    joined([Value::Object(chain), rest])
}

fn guard(limits: &Limits) -> Value {
    let (n, guard) = (number, &limits.guard);
    let kind = match guard.kind {
        GuardKind::Off => return json!({"guard": null, "guard_reason": "off"}),
        GuardKind::Observer => "observer",
        GuardKind::EnergyBounding => "energy-bounding",
    };
    let guard = json!({
        "kind": kind,
        // Most damping that it adds, or damping of the device.
        "damping_n_s_per_m": n(guard.damping_n_s_per_m),
        // Energy bounding alone uses its share, and what follows the time for which a credit of energy lasts.
        "share": n(guard.share),
        "forget_s": n(guard.forget_s),
        "delay_least_samples": n(guard.delay_least_samples),
        "delay_most_samples": n(guard.delay_most_samples),
        "lag_s": n(guard.lag_s),
        "noise_m": n(guard.noise_m),
    });
    json!({"guard": guard, "guard_reason": null})
}

/// The simulated plant; null for a real device.
fn simulation(configuration: &Configuration) -> Value {
    let (n, plant) = (number, &configuration.simulation);
    let kind = match plant.kind {
        SimulationKind::Real => return Value::Null,
        SimulationKind::MassDamper => "mass-damper",
        SimulationKind::RigidIndentation => "rigid-indentation",
        SimulationKind::CompliantIndentation => "compliant-indentation",
    };
    json!({
        "kind": kind,
        "mass_kg": n(plant.mass_kg),
        "damping_n_s_per_m": n(plant.damping_n_s_per_m),
        "hand_stiffness_n_per_m": n(plant.hand_stiffness_n_per_m),
        "push_n": n(plant.push_n),
        "depth_m": n(plant.depth_m),
        "ramp_time_s": n(plant.ramp_time_s),
    })
}

/// The limits that are looser than before, a sentence each.
fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    let (mut then, mut now) = (*before, *after);
    let numbers = Limits::TABLE.iter().filter_map(|limit| {
        let (before, after) = (*(limit.of)(&mut then), *(limit.of)(&mut now));
        let off = |value: f32| limit.tighter == Tighter::LessUnlessOff && value <= 0.0;
        let told = |value: f32| if off(value) { f32::INFINITY } else { value };
        (!limit.is_tight(after, before)).then(|| (limit.field.key(), told(before), told(after)))
    });
    let of_run = |limits: &Limits| -> [(&str, f32); 4] {
        // 0 is no limit.
        let late_ticks = match limits.late_ticks {
            0 => f32::INFINITY,
            ticks => ticks.into(),
        };
        [
            ("stuck_time_s", limits.stuck_time_s),
            ("watchdog_ms", limits.watchdog_ms.into()),
            ("late_ticks", late_ticks),
            ("max_age_ticks", limits.max_age_ticks.into()),
        ]
    };
    let of_run = of_run(before).into_iter().zip(of_run(after));
    let of_run = of_run.map(|((key, before), (_, after))| (key, before, after));
    let of_run = of_run.filter(|(_, before, after)| after > before);
    let in_words = |key, value: f32| match value {
        value if value.is_infinite() => "none".to_owned(),
        value => written(key, value.into()),
    };
    let mut words: Vec<String> = numbers
        .chain(of_run)
        .map(|(key, before, after)| {
            let (before, after) = (in_words(key, before), in_words(key, after));
            format!("{} from {before} to {after}", label(key))
        })
        .collect();
    let (low, high) = (after.workspace_low_m, after.workspace_high_m);
    let had = before.workspace_low_m < before.workspace_high_m;
    if had && (low >= high || low < before.workspace_low_m || high > before.workspace_high_m) {
        let ends = |low: f32, high: f32| match low < high {
            true => format!(
                "{}:{} mm",
                digits(1e3 * f64::from(low), 4),
                digits(1e3 * f64::from(high), 4)
            ),
            false => "none".to_owned(),
        };
        let before = ends(before.workspace_low_m, before.workspace_high_m);
        words.push(format!("workspace from {before} to {}", ends(low, high)));
    }
    if before.guard.kind != GuardKind::Off && after.guard != before.guard {
        words.push(match after.guard.kind {
            GuardKind::Off => "the passivity guard is off".to_owned(),
            GuardKind::Observer | GuardKind::EnergyBounding => {
                "the passivity guard is another one".to_owned()
            }
        });
    }
    let braking = |limits: &Limits| limits.braking_n_s_per_m.to_bits();
    if before.braking_n_s_per_m > 0.0 && braking(after) != braking(before) {
        let [before, after] = [before, after].map(|limits| limits.braking_n_s_per_m);
        let [before, after] = [before, after].map(|b| written("braking_n_s_per_m", b.into()));
        words.push(format!("braking from {before} to {after}"));
    }
    words
}
