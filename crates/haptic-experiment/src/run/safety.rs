//! Settings of the safety chain beyond force and rate, as an experiment asks for them: keys, reading, limits.

mod guard;

pub(crate) mod keys {
    use crate::document::parameters::kind::parameters;
    use crate::document::parameters::range::{
        DAMPINGS_ABOVE_0, DEVICE_TIMES, FORCES, MASSES, PLACES, REACHES, Range, SAFETY_TIMES,
        SENSOR_STEPS, SPEEDS,
    };
    use haptic_loop::Limits;

    parameters! {
        /// Of the safety chain, for every experiment.
        all SAFETY;
        GUARD = text("guard", "off", "Keep the loop from feeding the device energy");
        /// Low end of the workspace, m.
        WORKSPACE_LOW = optional("workspace_low_m", PLACES, "Lowest position; below it a fault ends the run");
        /// High end of the workspace, m.
        WORKSPACE_HIGH = optional("workspace_high_m", PLACES, "Highest position; above it a fault ends the run");
        SPEED_LIMIT = optional("speed_limit_m_per_s", SPEEDS, "Largest speed; above it a fault ends the run");
        RISE_TIME = optional("rise_time_s", SAFETY_TIMES, "Ramp the force up over this time at the start");
        BRAKING = optional("braking_n_s_per_m", DAMPINGS_ABOVE_0,
            "Damping that brakes near workspace and speed limits, and after a fault or stop");
        STOP_TIME = optional("stop_time_s", Range::Within(Limits::STOP_TIME_S[0], Limits::STOP_TIME_S[1]),
            "Time to zero force after a fault, a stop or the end, 1ms to 1s [default: 0.1s]");
        BRAKE_FORCE = optional("brake_force_n", Range::Within(0.0, Limits::BRAKE_FORCE_MAX_N),
            "Largest braking force during that time, 0N to 10N [default: 2N]");
        STUCK_FORCE = optional("stuck_force_n", FORCES,
            "Fault if the force rises by this much while the position is frozen; 0 = off [default: 3N on a \
             serial device, else never]");
        STUCK_TIME = optional("stuck_time_s", Range::Within(1e-3, 10.0),
            "Time for which the position must be frozen [default: 0.1s]");
        /// Jump of a sensor, m.
        JUMP = optional("jump_m", REACHES,
            "Fault if the position moves in one sample by this much more than the speed limit allows; 0 = off \
             [default: 1mm on a serial device, else never]");
        /// Mass of a real device, kg.
        DEVICE_MASS = optional("device_mass_kg", MASSES, "Mass of a real device, for guard observer, braking and pre-flight");
        /// Damping of a real device, N·s/m.
        DEVICE_DAMPING = optional("device_damping_n_s_per_m", DAMPINGS_ABOVE_0,
            "Damping of a real device, for guard energy-bounding and pre-flight");
        /// Least delay of a real device, s.
        DEVICE_DELAY_LEAST = optional("device_delay_least_s", DEVICE_TIMES,
            "Least delay of a real device from a measurement to the effect of its force, for guard energy-bounding");
        /// Largest delay of a real device, s.
        DEVICE_DELAY_MOST = optional("device_delay_most_s", DEVICE_TIMES, "Largest delay; equal to the least if known exactly");
        /// Lag of a real device, s.
        DEVICE_LAG = optional("device_lag_s", DEVICE_TIMES,
            "Time constant of the force of a real device, for guard energy-bounding");
        /// Noise of a real device, m.
        DEVICE_NOISE = optional("device_noise_m", SENSOR_STEPS,
            "Standard deviation of a real device's position noise, for guard energy-bounding [default: 0.29 \
             of its resolution]");
    }
}

use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::named::Named as _;
use crate::document::parameters::{DEVICE, DEVICE_MODEL, Parameter};
use crate::document::reader::Table;
use fracdiff::parameter::Shown;
pub use guard::{GuardChoice, GuardedDevice};
use haptic_loop::units::{
    Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, Seconds,
};
use haptic_loop::{EnergyBounding, Guard, Limits, PassivityObserver, SpeedLimit, Stuck, Workspace};
use keys::{
    self as p, BRAKING, DEVICE_DAMPING, DEVICE_DELAY_LEAST, DEVICE_DELAY_MOST, DEVICE_LAG,
    DEVICE_MASS, GUARD, JUMP, SPEED_LIMIT, STUCK_FORCE, STUCK_TIME,
};
use std::fmt;

/// Settings that an experiment asks for; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Safety {
    pub guard: GuardChoice,
    /// Lowest and highest position, m.
    pub workspace_m: Option<(f64, f64)>,
    pub speed_limit_m_per_s: Option<f64>,
    /// Time in which the force rises after the start, s.
    pub rise_time_s: Option<f64>,
    /// Damping that brakes near limits and after a fault, N·s/m.
    pub braking_n_s_per_m: Option<f64>,
    /// Time in which the force falls to zero after a fault, a stop or the end, s.
    pub stop_time_s: Option<f64>,
    /// Largest force of the braking meanwhile, N.
    pub brake_force_n: Option<f64>,
    /// Growth of the wanted force on a sensor that stands still, N; 0 for never.
    pub stuck_force_n: Option<f64>,
    /// Time for which it has to have stood still, s.
    pub stuck_time_s: Option<f64>,
    /// Largest move in a sample beyond the speed limit, m; 0 for never.
    pub jump_m: Option<f64>,
    /// Mass of the device, for its guard and for braking, kg.
    pub device_mass_kg: Option<f64>,
    /// Damping of the device, for its guard, N·s/m.
    pub device_damping_n_s_per_m: Option<f64>,
    /// Least and most delay of the device, for its guard, s.
    pub device_delay_s: Option<(f64, f64)>,
    /// Lag of the device's actuator, for its guard, s.
    pub device_lag_s: Option<f64>,
    /// Noise of the device's position, for its guard, m.
    pub device_noise_m: Option<f64>,
}

/// A number of the settings: its key, and its place.
type Number = (Parameter, fn(&mut Safety) -> &mut Option<f64>);

/// Every number that is read and told as it is.
const NUMBERS: [Number; 12] = [
    (SPEED_LIMIT, |s| &mut s.speed_limit_m_per_s),
    (p::RISE_TIME, |s| &mut s.rise_time_s),
    (BRAKING, |s| &mut s.braking_n_s_per_m),
    (p::STOP_TIME, |s| &mut s.stop_time_s),
    (p::BRAKE_FORCE, |s| &mut s.brake_force_n),
    (STUCK_FORCE, |s| &mut s.stuck_force_n),
    (STUCK_TIME, |s| &mut s.stuck_time_s),
    (JUMP, |s| &mut s.jump_m),
    (DEVICE_MASS, |s| &mut s.device_mass_kg),
    (DEVICE_DAMPING, |s| &mut s.device_damping_n_s_per_m),
    (DEVICE_LAG, |s| &mut s.device_lag_s),
    (p::DEVICE_NOISE, |s| &mut s.device_noise_m),
];

/// Two numbers of a table of which neither stands alone, the first below the second, or the same where that is allowed.
fn pair(
    table: &Table<'_>,
    [first, second]: [&Parameter; 2],
    (one, same): (&str, bool),
) -> Result<Option<(f64, f64)>, FileError> {
    let (lone, missing) = match (table.number_if(first)?, table.number_if(second)?) {
        (None, None) => return Ok(None),
        (Some(low), Some(high)) if low < high || (same && low <= high) => {
            return Ok(Some((low, high)));
        }
        (Some(low), Some(high)) => {
            let [low_key, key] = [first.key, second.key];
            let what = if same { "below" } else { "not above" };
            let reason = format!("{key} = {high} is {what} {low_key} = {low}");
            return Err(table.fail_at(key, reason));
        }
        (Some(_), None) => (first, second),
        (None, Some(_)) => (second, first),
    };
    let too = if same {
        ", the same if it is known"
    } else {
        ""
    };
    let reason = format!("{one} has two ends: give {} too{too}", missing.key);
    Err(table.fail_at(lone.key, reason))
}

/// Reads the settings of the safety chain. A wall knows mass and damping of its device by other keys too.
pub(crate) fn safety(table: &Table<'_>) -> Result<Safety, FileError> {
    let delay = [&DEVICE_DELAY_LEAST, &DEVICE_DELAY_MOST];
    let mut safety = Safety {
        guard: table.choice(&GUARD)?,
        workspace_m: pair(
            table,
            [&p::WORKSPACE_LOW, &p::WORKSPACE_HIGH],
            ("a workspace", false),
        )?,
        device_delay_s: pair(table, delay, ("a delay", true))?,
        ..Safety::default()
    };
    for (parameter, of) in &NUMBERS {
        *of(&mut safety) = table.number_if(parameter)?;
    }
    Ok(safety)
}

impl Safety {
    /// Every number of the settings that is there, by its key.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let mut own = *self;
        let (workspace, delay) = (self.workspace_m.unzip(), self.device_delay_s.unzip());
        let ends = [
            (p::WORKSPACE_LOW, workspace.0),
            (p::WORKSPACE_HIGH, workspace.1),
            (p::DEVICE_DELAY_LEAST, delay.0),
            (p::DEVICE_DELAY_MOST, delay.1),
        ];
        let single = NUMBERS.map(|(parameter, of)| (parameter, *of(&mut own)));
        let all = single.into_iter().chain(ends);
        all.filter_map(|(parameter, value)| Some((parameter.key, value?)))
    }
}

/// Largest force with which a run on a real or serial device starts, N.
const START_FORCE_N: f64 = 1.0;

impl Safety {
    /// Adds all but the guard to limits of force and rate. On a device that is not simulated here, `real`, a start
    /// with a blow is refused, and an implausible position is a fault unless that is switched off.
    pub(crate) fn on(&self, limits: Limits, real: bool) -> Limits {
        let brakes = self.braking_n_s_per_m.is_some();
        let default = Limits::default();
        let unless_off = |given: Option<f64>, default: Option<f64>| {
            given.or(default.filter(|_| real)).filter(|x| *x != 0.0)
        };
        let stuck = default.stuck.unwrap_or(Stuck::DEFAULT);
        let stuck_force = unless_off(self.stuck_force_n, Some(stuck.force.0));
        Limits {
            stop_time: self.stop_time_s.map_or(default.stop_time, Seconds),
            brake_force: self.brake_force_n.map_or(default.brake_force, Newtons),
            device_mass: self.device_mass_kg.map(Kilograms),
            stuck: stuck_force.map(|force| Stuck {
                force: Newtons(force),
                time: self.stuck_time_s.map_or(stuck.time, Seconds),
            }),
            jump: unless_off(self.jump_m, default.jump.map(|jump| jump.0)).map(Metres),
            start_force: real.then_some(Newtons(START_FORCE_N)),
            rise_time: self.rise_time_s.map(Seconds),
            workspace: self.workspace_m.map(|ends| workspace(ends, brakes)),
            speed: self.speed_limit_m_per_s.map(|hard| speed(hard, brakes)),
            braking: self.braking_n_s_per_m.map(NewtonSecondsPerMetre),
            ..limits
        }
    }

    /// Refuses what would do nothing on a simulated device. A real one may have the limits set that are missing here.
    pub(crate) fn acts(&self) -> Result<(), Failure> {
        if let (Some(jump), None) = (self.jump_m, self.speed_limit_m_per_s)
            && jump > 0.0
        {
            return Err(Failure::bad_input(format_args!(
                "jump {jump} m has no effect without a speed limit: give {SPEED_LIMIT} too, or omit {JUMP}",
                jump = Shown(jump)
            )));
        }
        let stuck = self.stuck_force_n.is_some_and(|force| force > 0.0);
        if let Some(time) = self.stuck_time_s.filter(|_| !stuck) {
            return Err(Failure::bad_input(format_args!(
                "stuck time {time} s has no effect without a stuck force: give {STUCK_FORCE} too, or omit {STUCK_TIME}",
                time = Shown(time)
            )));
        }
        let asked = self.guard == GuardChoice::Observer || self.braking_n_s_per_m.is_some();
        if let Some(mass) = self.device_mass_kg.filter(|_| !asked) {
            return Err(Failure::bad_input(format_args!(
                "device mass {mass} kg has no effect on a simulated device: give {} or {BRAKING} too, or omit {DEVICE_MASS}",
                GUARD.set_to(GuardChoice::Observer.name()),
                mass = Shown(mass)
            )));
        }
        let bounded = self.guard == GuardChoice::EnergyBounding;
        if let Some(damping) = self.device_damping_n_s_per_m.filter(|_| !bounded) {
            return Err(Failure::bad_input(format_args!(
                "device damping {damping} N·s/m has no effect on a simulated device: give {} too, or omit {DEVICE_DAMPING}",
                GUARD.set_to(GuardChoice::EnergyBounding.name())
            )));
        }
        self.acts_on_device()
    }

    /// The same with what a device file says of the device, where nothing else does, and as far as these settings ask for it; `real` is true for a
    /// device that is not simulated here.
    pub(crate) fn with_device(self, known: &GuardedDevice, real: bool) -> Self {
        let bounded = self.guard == GuardChoice::EnergyBounding;
        let braked = self.guard == GuardChoice::Observer || self.braking_n_s_per_m.is_some();
        let mass = known.mass_kg.filter(|_| real || braked);
        let damping = known.damping_n_s_per_m.filter(|_| real || bounded);
        Self {
            device_mass_kg: self.device_mass_kg.or(mass),
            device_damping_n_s_per_m: self.device_damping_n_s_per_m.or(damping),
            device_delay_s: self.device_delay_s.or(known.delay_s.filter(|_| bounded)),
            device_lag_s: self.device_lag_s.or(known.lag_s.filter(|_| bounded)),
            device_noise_m: self.device_noise_m.or(known.noise_m.filter(|_| bounded)),
            ..self
        }
    }

    /// The same on the rig of a relaxation or creep test: the simulated one has masses of its own, so that a device file only serves a guard or
    /// braking there.
    pub(crate) fn on_rig(self, known: &GuardedDevice, real: bool) -> Result<Self, Failure> {
        let with_device = self.with_device(known, real);
        if !real && with_device == self {
            return Err(Failure::bad_input(format_args!(
                "a device file has no effect on the simulated rig: omit {DEVICE_MODEL}, or give {device_serial_path}, {GUARD} or {BRAKING}",
                device_serial_path = DEVICE.set_to("serial:PATH")
            )));
        }
        Ok(with_device)
    }

    /// Refuses what would do nothing on any device.
    pub(crate) fn acts_on_device(&self) -> Result<(), Failure> {
        if self.guard == GuardChoice::EnergyBounding {
            return Ok(());
        }
        let told = [
            (self.device_delay_s.map(|delay| delay.1), "delay", "s"),
            (self.device_lag_s, "lag", "s"),
            (self.device_noise_m, "noise", "m"),
        ];
        for (value, what, unit) in told {
            if let Some(value) = value {
                return Err(Failure::bad_input(format_args!(
                    "device {what} {value} {unit} has no effect without the guard energy-bounding: give {} too, or omit it",
                    GUARD.set_to(GuardChoice::EnergyBounding.name()),
                    value = Shown(value)
                )));
            }
        }
        Ok(())
    }

    /// Facts of the device as the experiment gives them; where it gives none, those of `device`.
    pub(crate) fn guarded(&self, device: GuardedDevice) -> GuardedDevice {
        let said = GuardedDevice {
            mass_kg: self.device_mass_kg,
            damping_n_s_per_m: self.device_damping_n_s_per_m,
            delay_s: self.device_delay_s,
            lag_s: self.device_lag_s,
            noise_m: self.device_noise_m,
        };
        said.or(device)
    }

    /// The limits for a device of this mass, unless somebody says otherwise, and delay: how much braking it bears.
    pub(crate) fn braked(&self, limits: Limits, mass_kg: f64, delay_samples: u32) -> Limits {
        Limits {
            device_mass: limits.device_mass.or(Some(Kilograms(mass_kg))),
            device_delay_samples: delay_samples,
            ..limits
        }
    }
}

/// A workspace, a tenth of it at each end to brake in.
#[must_use]
pub fn workspace((low, high): (f64, f64), brakes: bool) -> Workspace {
    Workspace {
        low: Metres(low),
        high: Metres(high),
        soft: Metres(if brakes { 0.1 * (high - low) } else { 0.0 }),
    }
}

/// A speed limit, braked from two thirds of it on. Without braking a zone as narrow as can be, so that no
/// limiter seems to act.
#[must_use]
pub fn speed(hard: f64, brakes: bool) -> SpeedLimit {
    let soft = if brakes { hard / 1.5 } else { 0.999 * hard };
    // A device has no zone narrower than 1e-6 m/s, in single precision.
    let soft = soft.min(hard - 2e-6).max(0.0);
    SpeedLimit {
        soft: MetresPerSecond(soft),
        hard: MetresPerSecond(hard),
    }
}

impl GuardChoice {
    /// The guard for a device, if there is to be one.
    ///
    /// # Errors
    /// If what it needs to know of the device is not known.
    pub fn of(self, device: &GuardedDevice, t: Seconds) -> Result<Option<Guard>, Failure> {
        let unknown = |what, key: &dyn fmt::Display| {
            Failure::bad_input(format_args!(
                "guard {} needs to know the {what} of a real device: give {key}",
                self.name()
            ))
        };
        let known =
            |value: Option<f64>, what, key: Parameter| value.ok_or_else(|| unknown(what, &key));
        Ok(match self {
            Self::Off => None,
            Self::Observer => {
                let mass = known(device.mass_kg, "mass", DEVICE_MASS)?;
                Some(Guard::Observer(PassivityObserver::bearable(
                    Kilograms(mass),
                    t,
                )))
            }
            Self::EnergyBounding => {
                let damping = known(device.damping_n_s_per_m, "damping", DEVICE_DAMPING)?;
                let (least, most) = device.delay_s.ok_or_else(|| {
                    let both = format_args!("{DEVICE_DELAY_LEAST} and {DEVICE_DELAY_MOST}");
                    unknown("delay", &both)
                })?;
                let lag = known(device.lag_s, "lag", DEVICE_LAG)?;
                Some(Guard::EnergyBounding(EnergyBounding {
                    delay_least: Seconds(least),
                    delay_most: Seconds(most),
                    lag: Seconds(lag),
                    noise: Metres(device.noise_m.unwrap_or_default()),
                    ..EnergyBounding::of(NewtonSecondsPerMetre(damping))
                }))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guard_says_what_it_has_to_know() {
        let t = Seconds(1e-3);
        let unknown = GuardedDevice::default();
        assert_eq!(GuardChoice::Off.of(&unknown, t).expect("off"), None);
        let damped = GuardedDevice {
            damping_n_s_per_m: Some(3.5),
            ..unknown
        };
        let late = GuardedDevice {
            delay_s: Some((0.0, 1e-3)),
            ..damped
        };
        for (guard, device, option) in [
            (GuardChoice::Observer, unknown, "device_mass_kg"),
            (
                GuardChoice::EnergyBounding,
                unknown,
                "device_damping_n_s_per_m",
            ),
            (GuardChoice::EnergyBounding, damped, "device_delay_least_s"),
            (GuardChoice::EnergyBounding, late, "device_lag_s"),
        ] {
            let error = guard.of(&device, t).expect_err("unknown").to_string();
            assert!(
                error.contains(option) && error.contains(guard.name()),
                "{error}"
            );
        }
    }

    #[test]
    fn every_speed_limit_of_a_device_is_taken_with_the_zone_that_nobody_set() {
        use haptic_link::{Configuration, Simulation};
        use haptic_remote::{Hardware as _, SimulatedPlant, prepare, wire_limits};
        let abilities = SimulatedPlant::new("plain", || 0).capabilities();
        // 1e-6 to 100 m/s.
        for step in -600..=200 {
            let hard = 10_f64.powf(f64::from(step) / 100.0);
            for braking in [None, Some(1.0)] {
                let safety = Safety {
                    speed_limit_m_per_s: Some(hard),
                    braking_n_s_per_m: braking,
                    device_mass_kg: Some(1.0),
                    ..Safety::default()
                };
                let limits = safety.on(Limits::default(), true);
                let configuration = Configuration {
                    limits: wire_limits(&limits, Seconds(1e-3)),
                    simulation: Simulation::TESTBED,
                    ..Configuration::PASSIVE
                };
                let refused = prepare::<SimulatedPlant, 1>(configuration, &[0.0], &abilities).err();
                assert_eq!(refused, None, "{hard} m/s, braking {braking:?}");
            }
        }
    }

    #[test]
    fn what_somebody_says_of_a_device_goes_before_what_it_simulates() {
        use crate::run::remote::guard_of;
        use haptic_link::Simulation;
        let t = Seconds(1e-3);
        let said = GuardedDevice {
            damping_n_s_per_m: Some(2.0),
            delay_s: Some((0.0, 1e-3)),
            lag_s: Some(5e-4),
            ..GuardedDevice::default()
        };
        let bounding =
            |known, simulation| match guard_of(GuardChoice::EnergyBounding, known, simulation, t)
                .expect("known")
            {
                Some(Guard::EnergyBounding(bounding)) => {
                    let delay = (bounding.delay_least.0, bounding.delay_most.0);
                    (bounding.device_damping.0, delay, bounding.lag.0)
                }
                other => panic!("{other:?}"),
            };
        let nothing = GuardedDevice::default();
        let ideal = (3.5, (0.0, 0.0), 0.0);
        assert_eq!(bounding(nothing, &Simulation::TESTBED), ideal);
        let worse = (2.0, (0.0, 1e-3), 5e-4);
        assert_eq!(bounding(said, &Simulation::TESTBED), worse);
        assert_eq!(bounding(said, &Simulation::REAL), worse);
        assert!(guard_of(GuardChoice::EnergyBounding, nothing, &Simulation::REAL, t).is_err());
    }
}
