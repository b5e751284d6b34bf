//! `device get` and `device set`: the parameters of a device as a person and a script see them.

use super::changes::{self, Changes};
use super::port::PortArguments;
use crate::output::{Output, joined, warn};
use clap::Args;
use haptic_experiment::Failure;
use haptic_link::{Configuration, GuardKind, Limits, LoopMode, OperatorForm, SimulationKind};
use haptic_loop::Limit;
use haptic_quantity::without_unit;
use haptic_run::{Remembered, at_port, loosened, refused_at_port};
use serde_json::{Value, json};

pub(super) fn get(port: &PortArguments, output: Output) -> Result<(), Failure> {
    let link = port.connect_any()?;
    let configuration = link.configuration();
    let (configuration, values) = configuration.map_err(|error| at_port(link.path(), &error))?;
    let tighter = port.device.remembered(&link)?.tightened(&configuration)?;
    if let Some(tight) = tighter {
        let lost = loosened(&tight, &configuration.limits).join(", ");
        warn(&format!(
            "it has forgotten limits, which it gets again before it is armed: {lost}"
        ));
    }
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
    /// Reads what is set, or was set before the device forgot it; changes what was given, sets it, reads it back and remembers it.
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let changes = Changes::read(&self.values)?;
        let mut link = self.port.connect_any()?;
        let path = link.path().to_owned();
        let problem = |error| at_port(&path, &error);
        let remembered = self.port.device.remembered(&link)?;
        let (mut configuration, mut values) = link.configuration().map_err(problem)?;
        let tightened = remembered.tightened(&configuration)?;
        configuration.limits = tightened.unwrap_or(configuration.limits);
        let before = configuration.limits;
        changes.apply(&mut configuration, &mut values)?;
        remembered.admits(&configuration)?;
        let set = link.set(configuration, &values);
        set.map_err(|error| refused_at_port(&path, error))?;
        let (configuration, values) = link.configuration().map_err(problem)?;
        if !remembered.keep(&configuration)? {
            warn(&format!(
                "nothing remembers these limits: they hold until the device is switched off; set {} to a folder, and name an emulated device by its link",
                Remembered::VARIABLE
            ));
        }
        for limit in loosened(&before, &configuration.limits) {
            warn(&format!("loosened: {limit}"));
        }
        output.report(&parameters(&link.name(), &configuration, &values))
    }
}

/// Ends what `device set` set; what the device has set now stays until it is switched off.
pub(super) fn forget(port: &PortArguments, output: Output) -> Result<(), Failure> {
    let link = port.connect_any()?;
    let remembered = port.device.remembered(&link)?;
    let limits = remembered.forget()?;
    output.report(&json!({
        "device": link.name(),
        "identity": remembered.identity().to_string(),
        "forgotten": limits.is_some(),
        // The file that is gone.
        "limits": limits,
        "limits_reason": limits.is_none().then_some("none were set"),
    }))
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

/// The safety chain beyond force and rate, limit by limit; 0 or null is off, and `X_reason` says why.
fn chain(limits: &Limits) -> Value {
    let n = number;
    let mut limits = *limits;
    let mut chain = serde_json::Map::new();
    for limit in Limit::ALL {
        let (value, key) = (*limits.number(limit).0, limit.key());
        // They stand beside the chain.
        if limit == Limit::Force || limit == Limit::ForceRate {
            continue;
        }
        let without_speed = limit == Limit::Jump && limits.speed_hard_m_per_s <= 0.0;
        let off = limit.is_off(value) || without_speed;
        let unknown = limit == Limit::DeviceMass && off;
        chain.insert(key.to_owned(), json!((!unknown).then(|| n(value))));
        if limit.is_off(0.0) {
            let why = if limit == Limit::StartForce {
                "off: any force"
            } else if limit == Limit::Speed {
                "off: any speed"
            } else if limit == Limit::Jump {
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
        "device_delay_ticks": limits.device_delay_ticks,
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
