//! Changes that `device set` makes: `KEY=VALUE`, read before the device is asked.

use super::key_value::{count, in_range, key_and_value, keys_help, refused};
use crate::output::warn;
use crate::parse::parse_scheme;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_experiment::Failure;
use haptic_experiment::parameters::{self, Parameter, Range};

use haptic_experiment::{GuardChoice, Named};
use haptic_link::{Configuration, Guard, Limits, LoopMode, SimulationKind};
use haptic_loop::Limit;
use haptic_quantity::{parse_for_key, without_unit};
use haptic_remote::{operator_shape, wire_guard};
use haptic_trial::advice::single;
use haptic_trial::{GuardedDevice, guard_of, speed, workspace};
use std::collections::BTreeSet;

/// The place of a number that is set as it is.
#[derive(Clone, Copy)]
enum Place {
    Own(fn(&mut Configuration) -> &mut f32),
    Limit(Limit),
}

#[derive(Clone, Copy)]
struct Key {
    key: &'static str,
    help: &'static str,
    number: Option<(Range, Place)>,
}

macro_rules! keys {
    ($($key:literal $(in $range:expr => $c:ident . $($field:ident).+)?, $help:literal;)*) => {
        &[$(Key {
            key: $key,
            help: $help,
            number: [$(Some(($range, Place::Own(|$c| &mut $c.$($field).+))),)? None][0],
        }),*]
    };
}

/// Keys as `device get` names them, and those that operators and guards are made from; but for the [`limits`] of the safety chain.
const KEYS: &[Key] = keys! {
    "loop", "Where the loop runs: device or host";
    "sample_time_s", "Sample time of the loop; needs order too";
    "stiffness_n_per_m" in parameters::STIFFNESS.range() => c.stiffness_n_per_m, "Stiffness K";
    "dissipation_n_s_mu_per_m" in parameters::DISSIPATION.range() => c.dissipation_n_s_mu_per_m,
        "Dissipation B, a number without a unit";
    "order", "Order of the dissipation: makes a new operator";
    "scheme", "Scheme of that operator, see host-cli --help [default: full]";
    "horizon_s", "How far back a full memory remembers [default: 200s]";
    "surface_m", "Surface of a wall that pushes but never pulls; none for one that does both";
    "watchdog_s", "Silence from the host after which the device lets go";
    "late_ticks", "Late ticks in a row that are a fault; 0 = off";
    "max_age_ticks", "Loop on the host: largest age of a force, in ticks from its sample";
    "workspace_m", "Range of positions, as -10mm:20mm; none for any";
    "guard", "Keep the loop from feeding the device energy: off, observer or energy-bounding";
    "device_damping_n_s_per_m", "Its damping, for guard=energy-bounding; so are the next three";
    "device_delay_s", "Delay from a measurement to the effect of its force, as 1ms or 0.2ms:1ms";
    "device_lag_s", "Time constant of its force";
    "device_noise_m", "Standard deviation of its position noise [default: 0]";
    "mass_kg" in parameters::MASS.range() => c.simulation.mass_kg, "Mass of a simulated device";
    "damping_n_s_per_m" in parameters::DAMPING.range() => c.simulation.damping_n_s_per_m,
        "Damping of a simulated device";
    "hand_stiffness_n_per_m" in parameters::HAND_STIFFNESS.range() => c.simulation.hand_stiffness_n_per_m,
        "Stiffness of the hand on a simulated device";
    "push_n" in parameters::PUSH.range().or_0() => c.simulation.push_n, "Push of the hand on a simulated device";
};

/// Every limit that is one number, in the range in which a document asks for it. Where a device takes 0, it may be 0.
fn limits() -> impl Iterator<Item = Key> {
    Limit::ALL.into_iter().map(|limit| {
        let asked = Range::of(limit);
        let range = if limit.least_for(0.0) <= 0.0 {
            asked.or_0()
        } else {
            asked
        };
        let help = if limit == Limit::Speed {
            "Largest speed; 0 for any"
        } else if limit == Limit::Braking {
            "Damping that brakes near a limit and after a fault or stop; 0 = off"
        } else {
            let (help, _) = limit
                .help()
                .split_once(" [default")
                .unwrap_or((limit.help(), ""));
            help
        };
        let number = Some((range, Place::Limit(limit)));
        Key {
            key: limit.key(),
            help,
            number,
        }
    })
}

fn keys() -> impl Iterator<Item = Key> {
    KEYS.iter().copied().chain(limits())
}

pub(super) fn help() -> String {
    keys_help(keys().map(|key| (key.key, key.help)))
}

/// The names of all keys, without their units.
pub(crate) fn names() -> Vec<&'static str> {
    keys().map(|key| without_unit(key.key)).collect()
}

/// Changed settings, in SI units.
#[derive(Default)]
pub(super) struct Changes {
    given: BTreeSet<&'static str>,
    numbers: Vec<(Place, f64)>,
    loop_mode: Option<LoopMode>,
    tick_period_us: Option<u32>,
    order: Option<Order>,
    scheme: Option<Scheme>,
    horizon_s: Option<f64>,
    /// `Some(None)` for no surface.
    surface_m: Option<Option<f32>>,
    watchdog_ms: Option<u16>,
    late_ticks: Option<u16>,
    max_age_ticks: Option<u16>,
    /// `Some(None)` for no workspace.
    workspace_m: Option<Option<(f64, f64)>>,
    guard: Option<GuardChoice>,
    known: GuardedDevice,
}

impl Changes {
    /// Reads changes from `KEY=VALUE`, each key with its unit or without.
    ///
    /// # Errors
    /// A key that is not one, or twice; a value that is not one; a key without another that it needs.
    pub(super) fn read(words: &[String]) -> Result<Self, Failure> {
        let mut changes = Self::default();
        for word in words {
            let (name, text) = key_and_value(word, keys().map(|key| key.key))?;
            if !changes.given.insert(name) {
                return Err(refused(word, "is given twice: keep one"));
            }
            for key in keys().filter(|key| key.key == name) {
                changes.set(key, text).map_err(|why| refused(word, &why))?;
            }
        }
        for (key, needed) in [
            ("sample_time_s", "order"),
            ("scheme", "order"),
            ("horizon_s", "order"),
            ("device_damping_n_s_per_m", "guard"),
            ("device_delay_s", "guard"),
            ("device_lag_s", "guard"),
            ("device_noise_m", "guard"),
        ] {
            if changes.given.contains(key) && !changes.given.contains(needed) {
                let key = without_unit(key);
                return Err(Failure::bad_input(format_args!(
                    "{key} takes effect only with {needed}: give {needed} too"
                )));
            }
        }
        Ok(changes)
    }

    fn set(&mut self, Key { key, number, .. }: Key, text: &str) -> Result<(), String> {
        if let Some((range, place)) = number {
            let value = in_range(key, range, text)?;
            single(key, value).map_err(|error| format!("is too small: {error}"))?;
            self.numbers.push((place, value));
            return Ok(());
        }
        let within = |parameter: Parameter, text: &str| in_range(key, parameter.range(), text);
        match key {
            "loop" => self.loop_mode = Some(named(text)?),
            "sample_time_s" => {
                let us = 1e6 * within(parameters::SAMPLE_TIME, text)?;
                self.tick_period_us = Some(whole(us, "microseconds")?);
            }
            "order" => {
                let mu = parse_for_key(key, text).map_err(|error| format!(": {error}"))?;
                self.order = Some(Order::new(mu).map_err(|error| format!(": {error}"))?);
            }
            "scheme" => {
                self.scheme = Some(parse_scheme(text).map_err(|error| format!(": {error}"))?);
            }
            "horizon_s" => self.horizon_s = Some(within(parameters::MEMORY, text)?),
            "surface_m" => {
                let surface = unless_none(text, |text| within(parameters::WORKSPACE_LOW, text))?;
                self.surface_m = Some(surface.map(|surface| surface as f32));
            }
            "watchdog_s" => {
                self.watchdog_ms = Some(watchdog_ms(within(parameters::WATCHDOG, text)?)?);
            }
            "late_ticks" => self.late_ticks = Some(count(text, 0, u16::MAX)?),
            "max_age_ticks" => self.max_age_ticks = Some(count(text, 1, Limits::MAX_AGE_TICKS)?),
            "workspace_m" => {
                self.workspace_m = Some(unless_none(text, |text| {
                    let (low, high) = text
                        .split_once(':')
                        .ok_or("is not LOW:HIGH, as in -10mm:20mm")?;
                    let [low, high] = [low, high].map(|end| within(parameters::WORKSPACE_LOW, end));
                    let (low, high) = (low?, high?);
                    (low < high)
                        .then_some((low, high))
                        .ok_or_else(|| "has its low end not below its high end".to_owned())
                })?);
            }
            "guard" => self.guard = Some(named(text)?),
            "device_damping_n_s_per_m" => {
                self.known.damping_n_s_per_m = Some(within(parameters::DEVICE_DAMPING, text)?);
            }
            "device_delay_s" => {
                let (least, most) = text.split_once(':').unwrap_or((text, text));
                let [least, most] = [least, most].map(|end| within(parameters::DELAY, end));
                let (least, most) = (least?, most?);
                if least > most {
                    return Err(
                        "is not lowest first: give TIME, or LEAST:MOST as in 0.2ms:1ms".to_owned(),
                    );
                }
                self.known.delay_s = Some((least, most));
            }
            "device_lag_s" => {
                self.known.current_lag_s = Some(within(parameters::DEVICE_LAG, text)?);
            }
            _ => self.known.noise_m = Some(within(parameters::DEVICE_NOISE, text)?),
        }
        Ok(())
    }

    /// Changes a configuration and the coefficients of its operator.
    ///
    /// # Errors
    /// An operator that cannot be built; a guard that this device cannot have.
    pub(super) fn apply(
        &self,
        configuration: &mut Configuration,
        values: &mut Vec<f32>,
    ) -> Result<(), Failure> {
        for (place, value) in &self.numbers {
            *match place {
                Place::Own(of) => of(configuration),
                Place::Limit(limit) => configuration.limits.number(*limit).0,
            } = *value as f32;
        }
        let given = |key| self.given.contains(key);
        let plant = [
            "mass_kg",
            "damping_n_s_per_m",
            "hand_stiffness_n_per_m",
            "push_n",
        ];
        if plant.into_iter().any(given) {
            configuration.simulation.kind = SimulationKind::MassDamper;
        }
        if let Some(us) = self.tick_period_us {
            configuration.tick_period_us = us;
        }
        if let Some(surface) = self.surface_m {
            configuration.one_sided = surface.is_some();
            configuration.surface_m = surface.unwrap_or(configuration.surface_m);
        }
        if let Some(loop_mode) = self.loop_mode {
            let (before, after) = (configuration.loop_mode, loop_mode);
            // A watchdog time that nobody chose goes with the loop.
            if configuration.limits.watchdog_ms == before.watchdog_ms() {
                configuration.limits.watchdog_ms = after.watchdog_ms();
            }
            configuration.loop_mode = after;
        }
        // The mass of a simulated device is known.
        let simulated = configuration.simulation.kind == SimulationKind::MassDamper;
        let asks = given("mass_kg") || given("braking_n_s_per_m");
        if simulated && asks && !given("device_mass_kg") {
            configuration.limits.device_mass_kg = configuration.simulation.mass_kg;
        }
        self.limit(&mut configuration.limits);
        let t = Seconds(f64::from(configuration.tick_period_us) * 1e-6);
        if let Some(guard) = self.guard {
            let mass =
                given("device_mass_kg").then_some(f64::from(configuration.limits.device_mass_kg));
            let known = GuardedDevice {
                mass_kg: mass,
                ..self.known
            };
            let guard = guard_of(guard, known, &configuration.simulation, t)?;
            configuration.limits.guard = guard.map_or(Guard::OFF, |guard| wire_guard(&guard, t));
        }
        if let Some(order) = self.order {
            let scheme = self.scheme.map_or_else(|| "full".parse(), Ok);
            let scheme = scheme.map_err(Failure::input)?;
            let built = scheme.build(order, t, self.horizon_s.unwrap_or(200.0) / t.0);
            let operator: Operator<f32> = built
                .map_err(|error| Failure::input_with_advice(error, "change order or scheme"))?;
            let (shape, list) = operator_shape(&operator).map_err(Failure::input)?;
            configuration.order = order.get() as f32;
            configuration.operator = shape;
            *values = list;
        }
        Ok(())
    }

    /// Changes silence, lateness, workspace and speed; with braking comes and goes the zone to brake in.
    fn limit(&self, limits: &mut Limits) {
        limits.watchdog_ms = self.watchdog_ms.unwrap_or(limits.watchdog_ms);
        limits.late_ticks = self.late_ticks.unwrap_or(limits.late_ticks);
        limits.max_age_ticks = self.max_age_ticks.unwrap_or(limits.max_age_ticks);
        let brakes = limits.braking_n_s_per_m > 0.0;
        let braking_changes = self.given.contains("braking_n_s_per_m");
        let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
        let before = (low < high).then_some((f64::from(low), f64::from(high)));
        match self.workspace_m.or(braking_changes.then_some(before)) {
            Some(Some(ends)) => {
                let workspace = workspace(ends.0, ends.1, brakes);
                limits.workspace_low_m = workspace.low.0 as f32;
                limits.workspace_high_m = workspace.high.0 as f32;
                limits.workspace_soft_m = workspace.soft.0 as f32;
            }
            Some(None) => {
                (limits.workspace_low_m, limits.workspace_high_m) = (0.0, 0.0);
                limits.workspace_soft_m = 0.0;
            }
            None => {}
        }
        let before = braking_changes.then_some(f64::from(limits.speed_hard_m_per_s));
        let mut given = self.numbers.iter();
        let given = given.find(|(place, _)| matches!(place, Place::Limit(Limit::Speed)));
        if let Some(hard) = given.map(|(_, hard)| *hard).or(before) {
            let speed = speed(hard, brakes);
            limits.speed_soft_m_per_s = speed.soft.0 as f32;
            limits.speed_hard_m_per_s = speed.hard.0 as f32;
        }
        if self.given.contains("jump_m") && limits.jump_m > 0.0 && limits.speed_hard_m_per_s == 0.0
        {
            warn("jump has no effect without a speed limit: give speed_limit too");
        }
    }
}

/// A text as one of the names of a type.
fn named<T: Named>(text: &str) -> Result<T, String> {
    let names = T::CHOICES.iter().map(|choice| choice.1);
    T::named(text).ok_or_else(|| format!("is not one of {}", names.collect::<Vec<_>>().join(", ")))
}

fn unless_none<T>(
    text: &str,
    read: impl FnOnce(&str) -> Result<T, String>,
) -> Result<Option<T>, String> {
    match text {
        "none" => Ok(None),
        text => read(text).map(Some),
    }
}

fn whole(number: f64, what: &str) -> Result<u32, String> {
    if (number - number.round()).abs() < 1e-6 && number >= 1.0 {
        Ok(number.round() as u32)
    } else {
        Err(format!(
            "is not a whole number of {what}, which a device needs"
        ))
    }
}

/// A watchdog time in whole milliseconds.
///
/// # Errors
/// One that is not.
fn watchdog_ms(watchdog_s: f64) -> Result<u16, String> {
    whole(1e3 * watchdog_s, "milliseconds").map(|ms| ms as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<Changes, Failure> {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        Changes::read(&words)
    }

    #[test]
    fn a_value_has_a_range_and_is_given_once() {
        for (line, why) in [
            ("stiffness", "is not KEY=VALUE"),
            ("spring=1", "does not name a parameter"),
            ("stiffness=20 stiffness_n_per_m=2", "is given twice"),
            ("mass=1e9kg", "is not above 0 and at most 100 kg"),
            ("watchdog=1ms", "is not from 5 ms to 1 s"),
            ("watchdog=5.5ms", "is not a whole number of milliseconds"),
            ("late_ticks=-1", "is not a whole number from 0 to 65535"),
            ("loop=here", "is not one of device, host"),
            ("workspace=2mm:1mm", "low end"),
            ("workspace=-1mm:1e300", "is not from -100 m to 100 m"),
            ("surface=1e300", "is not from"),
            ("device_delay=1ms:0.2ms guard=off", "lowest first"),
            ("order=3", "order=3: order 3"),
            ("sample_time=1ms", "give order too"),
            ("device_lag=1ms", "give guard too"),
            ("force_limit=inf", "finite"),
        ] {
            let refused = read(line).err().expect(line).to_string();
            assert!(refused.contains(why), "{line}: {refused}");
        }
    }

    #[test]
    fn every_key_can_be_set_and_none_is_there_twice() {
        let mut names = BTreeSet::new();
        for key in keys() {
            assert!(names.insert(without_unit(key.key)), "{}", key.key);
            let name = without_unit(key.key);
            let text = match name {
                "loop" => "host",
                "scheme" => "full",
                "guard" => "off",
                "workspace" => "-1mm:1mm",
                "stiffness" => "1N/m",
                _ => "1",
            };
            let mut changes = Changes::default();
            changes
                .set(key, text)
                .or_else(|_| changes.set(key, "1e-3"))
                .expect(name);
        }
    }
}
