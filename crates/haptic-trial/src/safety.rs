//! Settings of the safety chain beyond force and rate, as an experiment asks for them: keys, reading, limits.

mod guard;

/// Keys of the settings, and the limit that each one asks for.
pub mod keys {
    use haptic_document::{
        parameters,
        parameters::{
            Parameter,
            range::{DAMPINGS_ABOVE_0, DEVICE_TIMES, SENSOR_STEPS, WORKSPACES},
        },
    };
    use haptic_loop::Limit;

    parameters! {
        all SAFETY;
        GUARD = text("guard", "off", "Keep the loop from feeding the device energy");
        /// Low end of the workspace, m.
        WORKSPACE_LOW = optional("workspace_low_m", WORKSPACES, "Lowest position; below it a fault ends the run");
        /// High end of the workspace, m.
        WORKSPACE_HIGH = optional("workspace_high_m", WORKSPACES, "Highest position; above it a fault ends the run");
        /// Ends a run that goes faster.
        SPEED_LIMIT = limit(Limit::Speed);
        RISE_TIME = limit(Limit::RiseTime);
        /// Brakes near limits, and after a fault or stop.
        BRAKING = limit(Limit::Braking);
        STOP_TIME = limit(Limit::StopTime);
        BRAKE_FORCE = limit(Limit::BrakeForce);
        STUCK_FORCE = limit(Limit::StuckForce);
        /// Together with the stuck force it detects a stuck sensor.
        STUCK_TIME = limit(Limit::StuckTime);
        JUMP = limit(Limit::Jump);
        DEVICE_MASS = limit(Limit::DeviceMass);
        /// Damping of a real device, N·s/m.
        DEVICE_DAMPING = optional("device_damping_n_s_per_m", DAMPINGS_ABOVE_0,
            "Damping of a real device, for guard energy-bounding and the stability check before a run");
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

    /// The parameter by which every experiment asks for a limit. Force and rate have one of their own in each kind; nobody asks
    /// for the other two.
    pub const fn asked(limit: Limit) -> Option<Parameter> {
        Some(match limit {
            Limit::Force | Limit::ForceRate | Limit::StartForce | Limit::VelocityBandwidth => {
                return None;
            }
            Limit::Speed => SPEED_LIMIT,
            Limit::RiseTime => RISE_TIME,
            Limit::Braking => BRAKING,
            Limit::StopTime => STOP_TIME,
            Limit::BrakeForce => BRAKE_FORCE,
            Limit::StuckForce => STUCK_FORCE,
            Limit::StuckTime => STUCK_TIME,
            Limit::Jump => JUMP,
            Limit::DeviceMass => DEVICE_MASS,
        })
    }
}

use fracdiff::parameter::Shown;
pub use guard::{GuardChoice, GuardedDevice};
use haptic_document::{
    Failure, FileError, Named as _, Table, bad_input,
    parameters::{DEVICE, DEVICE_MODEL, Parameter},
};
use haptic_link::{Simulation, SimulationKind};
use haptic_loop::{
    EnergyBounding, Limit, PassivityGuard, PassivityObserver, SafetyLimits, SpeedLimit, Stuck,
    Workspace,
    units::{Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Seconds},
};
use keys::{
    self as p, BRAKING, DEVICE_DAMPING, DEVICE_DELAY_LEAST, DEVICE_DELAY_MOST, DEVICE_LAG,
    DEVICE_MASS, GUARD, JUMP, SPEED_LIMIT, STUCK_FORCE, STUCK_TIME,
};
use std::fmt;

/// Settings that an experiment asks for; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Safety {
    /// The guard of the energy.
    pub guard: GuardChoice,
    /// Lowest and highest position, m.
    pub workspace_m: Option<(f64, f64)>,
    /// Numbers in the order of [`Limit::ALL`]. 0 switches off a default of a real device.
    numbers: [Option<f64>; Limit::ALL.len()],
    /// Facts of the device for its guard, but for the mass, which is a limit of braking too.
    device: GuardedDevice,
}

/// Two numbers of a table of which neither stands alone, the first below the second, or the same where that is allowed.
fn pair(
    table: &Table<'_>,
    [first, second]: [&Parameter; 2],
    one: &str,
    same: bool,
) -> Result<Option<(f64, f64)>, FileError> {
    let (lone, missing) = match (table.number_if(first)?, table.number_if(second)?) {
        (None, None) => return Ok(None),
        (Some(low), Some(high)) if low < high || (same && low <= high) => {
            return Ok(Some((low, high)));
        }
        (Some(low), Some(high)) => {
            let [low_key, key] = [first.key, second.key];
            let what = if same { "below" } else { "not above" };
            return Err(table.fail_at(
                key,
                format_args!("{key} = {high} is {what} {low_key} = {low}"),
            ));
        }
        (Some(_), None) => (first, second),
        (None, Some(_)) => (second, first),
    };
    let too = if same {
        ", the same if it is known"
    } else {
        ""
    };
    Err(table.fail_at(
        lone.key,
        format_args!("{one} has two ends: give {} too{too}", missing.key),
    ))
}

/// Reads the settings of the safety chain. A wall knows mass and damping of its device by other keys too.
///
/// # Errors
/// A number outside its range, or half of a pair.
pub fn safety(table: &Table<'_>) -> Result<Safety, FileError> {
    let workspace = [&p::WORKSPACE_LOW, &p::WORKSPACE_HIGH];
    let delay = [&DEVICE_DELAY_LEAST, &DEVICE_DELAY_MOST];
    let mut safety = Safety {
        guard: table.choice(&GUARD)?,
        workspace_m: pair(table, workspace, "a workspace", false)?,
        numbers: Default::default(),
        device: GuardedDevice {
            mass_kg: None,
            damping_n_s_per_m: table.number_if(&DEVICE_DAMPING)?,
            delay_s: pair(table, delay, "a delay", true)?,
            current_lag_s: table.number_if(&DEVICE_LAG)?,
            noise_m: table.number_if(&p::DEVICE_NOISE)?,
        },
    };
    for limit in Limit::ALL {
        if let Some(parameter) = p::asked(limit) {
            safety = safety.with(limit, table.number_if(&parameter)?);
        }
    }
    Ok(safety)
}

impl Safety {
    /// A limit, if it is given.
    pub const fn number(&self, limit: Limit) -> Option<f64> {
        self.numbers[limit as usize]
    }

    /// Sets a limit, or takes it away with `None`.
    pub const fn with(mut self, limit: Limit, number: Option<f64>) -> Self {
        self.numbers[limit as usize] = number;
        self
    }

    /// Every number of the settings that is there, by its key.
    pub fn numbers(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let device = self.device;
        let (workspace, delay) = (self.workspace_m.unzip(), device.delay_s.unzip());
        let others = [
            (DEVICE_DAMPING, device.damping_n_s_per_m),
            (DEVICE_LAG, device.current_lag_s),
            (p::DEVICE_NOISE, device.noise_m),
            (p::WORKSPACE_LOW, workspace.0),
            (p::WORKSPACE_HIGH, workspace.1),
            (p::DEVICE_DELAY_LEAST, delay.0),
            (p::DEVICE_DELAY_MOST, delay.1),
        ];
        let others = others.map(|(parameter, number)| (parameter.key, number));
        let limits = Limit::ALL.iter().map(|limit| limit.key());
        let all = limits.zip(self.numbers).chain(others);
        all.filter_map(|(key, number)| Some((key, number?)))
    }
}

impl Safety {
    /// Adds all but the guard to limits of force and rate. On a device that is not simulated here, `real`, a start
    /// with a blow is refused, and an implausible position is a fault unless that is switched off.
    pub fn on(&self, limits: SafetyLimits, real: bool) -> SafetyLimits {
        let brakes = self.number(Limit::Braking).is_some();
        let default = SafetyLimits::default();
        let mut chain = SafetyLimits {
            stop_time: default.stop_time,
            brake_force: default.brake_force,
            device_mass: None,
            stuck: Some(Stuck::DEFAULT).filter(|_| real),
            jump: default.jump.filter(|_| real),
            start_force: default.start_force.filter(|_| real),
            rise_time: None,
            workspace: self
                .workspace_m
                .map(|(low, high)| workspace(low, high, brakes)),
            speed: None,
            braking: None,
            ..limits
        };
        for (limit, number) in Limit::ALL.into_iter().zip(self.numbers) {
            if number.is_some() {
                limit.set(&mut chain, number.filter(|number| *number > 0.0));
            }
        }
        chain.speed = chain.speed.map(|limit| speed(limit.hard.0, brakes));
        chain
    }

    /// Refuses what would do nothing on a simulated device. A real one may have the limits set that are missing here.
    ///
    /// # Errors
    /// The first setting without effect.
    pub fn acts(&self) -> Result<(), Failure> {
        if let (Some(jump), None) = (self.number(Limit::Jump), self.number(Limit::Speed))
            && jump > 0.0
        {
            return Err(bad_input!(
                "jump {jump} m has no effect without a speed limit: give {SPEED_LIMIT} too, or omit {JUMP}",
                jump = Shown(jump)
            ));
        }
        let stuck = (self.number(Limit::StuckForce)).is_some_and(|force| force > 0.0);
        if let Some(time) = self.number(Limit::StuckTime).filter(|_| !stuck) {
            return Err(bad_input!(
                "stuck time {time} s has no effect without a stuck force: give {STUCK_FORCE} too, or omit {STUCK_TIME}",
                time = Shown(time)
            ));
        }
        let asked = self.guard == GuardChoice::Observer || self.number(Limit::Braking).is_some();
        if let Some(mass) = self.number(Limit::DeviceMass).filter(|_| !asked) {
            return Err(bad_input!(
                "device mass {mass} kg has no effect on a simulated device: give {} or {BRAKING} too, or omit {DEVICE_MASS}",
                GUARD.set_to(GuardChoice::Observer.name()),
                mass = Shown(mass)
            ));
        }
        let bounding = GUARD.set_to(GuardChoice::EnergyBounding.name());
        let bounded = self.guard == GuardChoice::EnergyBounding;
        if let Some(damping) = self.device.damping_n_s_per_m.filter(|_| !bounded) {
            return Err(bad_input!(
                "device damping {damping} N·s/m has no effect on a simulated device: give {bounding} too, or omit {DEVICE_DAMPING}",
            ));
        }
        self.acts_on_device()
    }

    /// Adds facts of the device file where nothing else gives them and these settings need them; `real` is true for a device that is not
    /// simulated here.
    pub fn with_device(self, known: &GuardedDevice, real: bool) -> Self {
        let bounded = self.guard == GuardChoice::EnergyBounding;
        let braked = self.guard == GuardChoice::Observer || self.number(Limit::Braking).is_some();
        let mass = known.mass_kg.filter(|_| real || braked);
        let device = GuardedDevice {
            mass_kg: None,
            damping_n_s_per_m: known.damping_n_s_per_m.filter(|_| real || bounded),
            delay_s: known.delay_s.filter(|_| bounded),
            current_lag_s: known.current_lag_s.filter(|_| bounded),
            noise_m: known.noise_m.filter(|_| bounded),
        };
        Self {
            device: self.device.or(device),
            ..self.with(Limit::DeviceMass, self.number(Limit::DeviceMass).or(mass))
        }
    }

    /// Adds the device file on the rig of a relaxation or creep test. The simulated rig has masses of its own, so only a guard or braking uses
    /// the file there.
    ///
    /// # Errors
    /// A device file without effect.
    pub fn on_rig(self, known: &GuardedDevice, real: bool) -> Result<Self, Failure> {
        let with_device = self.with_device(known, real);
        if !real && with_device == self {
            return Err(bad_input!(
                "a device file has no effect on the simulated rig: omit {DEVICE_MODEL}, or give {device_serial_path}, {GUARD} or {BRAKING}",
                device_serial_path = DEVICE.set_to("serial:PATH")
            ));
        }
        Ok(with_device)
    }

    /// Refuses what would do nothing on any device.
    pub(crate) fn acts_on_device(&self) -> Result<(), Failure> {
        if self.guard == GuardChoice::EnergyBounding {
            return Ok(());
        }
        let delay_s = self.device.delay_s.map(|delay| delay.1);
        for (value, what, unit) in [
            (delay_s, "delay", "s"),
            (self.device.current_lag_s, "lag", "s"),
            (self.device.noise_m, "noise", "m"),
        ] {
            if let Some(value) = value {
                return Err(bad_input!(
                    "device {what} {value} {unit} has no effect without the guard energy-bounding: give {} too, or omit it",
                    GUARD.set_to(GuardChoice::EnergyBounding.name()),
                    value = Shown(value)
                ));
            }
        }
        Ok(())
    }

    /// Facts of the device as the experiment gives them; where it gives none, those of `device`.
    pub fn guarded(&self, device: GuardedDevice) -> GuardedDevice {
        let message = GuardedDevice {
            mass_kg: self.number(Limit::DeviceMass),
            ..self.device
        };
        message.or(device)
    }

    /// The limits for a device of this mass, unless somebody says otherwise, and delay: how much braking it bears.
    pub fn braked(&self, limits: SafetyLimits, mass_kg: f64, delay_samples: u32) -> SafetyLimits {
        SafetyLimits {
            device_mass: limits.device_mass.or(Some(Kilograms(mass_kg))),
            device_delay_samples: delay_samples,
            ..limits
        }
    }
}

/// A workspace; a tenth of it at each end is for braking.
#[must_use]
pub fn workspace(low: f64, high: f64, brakes: bool) -> Workspace {
    Workspace {
        low: Metres(low),
        high: Metres(high),
        soft: Metres(if brakes { 0.1 * (high - low) } else { 0.0 }),
    }
}

/// A speed limit; braking begins at two thirds of it. Without braking a zone as narrow as can be,
/// so that no limiter seems to act.
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
    /// The guard for a device, if one was chosen.
    ///
    /// # Errors
    /// If a property of the device that it needs is unknown.
    pub fn of(self, device: &GuardedDevice, t: Seconds) -> Result<Option<PassivityGuard>, Failure> {
        let unknown = |what, key: &dyn fmt::Display| {
            bad_input!(
                "guard {} needs to know the {what} of a real device: give {key}",
                self.name()
            )
        };
        let known =
            |value: Option<f64>, what, key: Parameter| value.ok_or_else(|| unknown(what, &key));
        Ok(match self {
            Self::Off => None,
            Self::Observer => {
                let mass = known(device.mass_kg, "mass", DEVICE_MASS)?;
                Some(PassivityGuard::Observer(PassivityObserver::bearable(
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
                let lag = known(device.current_lag_s, "lag", DEVICE_LAG)?;
                Some(PassivityGuard::EnergyBounding(EnergyBounding {
                    delay_least: Seconds(least),
                    delay_most: Seconds(most),
                    current_lag: Seconds(lag),
                    noise: Metres(device.noise_m.unwrap_or_default()),
                    ..EnergyBounding::of(NewtonSecondsPerMetre(damping))
                }))
            }
        })
    }
}

/// A guard for a device: values not given for a simulated device come from its simulation, without
/// delay or lag. A real one does not know its own.
///
/// # Errors
/// As [`GuardChoice::of`].
pub fn guard_of(
    guard: GuardChoice,
    known: GuardedDevice,
    simulation: &Simulation,
    t: Seconds,
) -> Result<Option<PassivityGuard>, Failure> {
    let simulated = |value: f32| Some(f64::from(value));
    let itself = if simulation.kind == SimulationKind::Real {
        GuardedDevice::default()
    } else {
        GuardedDevice {
            mass_kg: simulated(simulation.mass_kg),
            damping_n_s_per_m: simulated(simulation.damping_n_s_per_m),
            delay_s: Some((0.0, 0.0)),
            current_lag_s: Some(0.0),
            noise_m: None,
        }
    };
    guard.of(&known.or(itself), t)
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
                let safety = Safety::default()
                    .with(Limit::Speed, Some(hard))
                    .with(Limit::Braking, braking)
                    .with(Limit::DeviceMass, Some(1.0));
                let limits = safety.on(SafetyLimits::default(), true);
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
    fn document_and_device_take_the_same_numbers_for_every_limit() {
        use haptic_document::parameters::Range;
        use haptic_link::{Capabilities, Configuration, Limits as Wire, Simulation};
        use haptic_remote::{Hardware as _, SimulatedPlant, prepare};
        let abilities = Capabilities {
            force_max_n: 1e6,
            force_rate_max_n_per_s: 1e10,
            ..SimulatedPlant::new("plain", || 0).capabilities()
        };
        let same = |range: Range, key: &str, set: &dyn Fn(&mut Wire, f32)| {
            let decades = (-90..=110).map(|tenths| 10_f64.powf(f64::from(tenths) / 10.0));
            let ends = range
                .ends()
                .map(|end| [0.999 * end, end, 1.001 * end])
                .concat();
            // 0 is asked for only where it switches off what is on unless somebody says so.
            for x in decades.chain(ends).filter(|x| *x > 0.0) {
                let mut configuration = Configuration {
                    simulation: Simulation::TESTBED,
                    ..Configuration::PASSIVE
                };
                configuration.limits.speed_soft_m_per_s = 0.0;
                set(&mut configuration.limits, x as f32);
                let taken = prepare::<SimulatedPlant, 1>(configuration, &[0.0], &abilities).is_ok();
                assert_eq!(range.contains(x), taken, "{key} = {x}");
            }
        };
        // How much braking a device bears follows from its mass.
        for limit in Limit::ALL
            .into_iter()
            .filter(|limit| *limit != Limit::Braking)
        {
            same(Range::of(limit), limit.key(), &|limits, x| {
                *limits.number(limit).0 = x;
            });
        }
        same(p::WORKSPACE_HIGH.range(), "workspace", &|limits, x| {
            limits.workspace_high_m = x;
        });
    }

    #[test]
    fn what_somebody_says_of_a_device_goes_before_what_it_simulates() {
        let t = Seconds(1e-3);
        let message = GuardedDevice {
            damping_n_s_per_m: Some(2.0),
            delay_s: Some((0.0, 1e-3)),
            current_lag_s: Some(5e-4),
            ..GuardedDevice::default()
        };
        let bounding =
            |known, simulation| match guard_of(GuardChoice::EnergyBounding, known, simulation, t)
                .expect("known")
            {
                Some(PassivityGuard::EnergyBounding(bounding)) => {
                    let delay = (bounding.delay_least.0, bounding.delay_most.0);
                    (bounding.device_damping.0, delay, bounding.current_lag.0)
                }
                other => panic!("{other:?}"),
            };
        let nothing = GuardedDevice::default();
        let ideal = (3.5, (0.0, 0.0), 0.0);
        assert_eq!(bounding(nothing, &Simulation::TESTBED), ideal);
        let worse = (2.0, (0.0, 1e-3), 5e-4);
        assert_eq!(bounding(message, &Simulation::TESTBED), worse);
        assert_eq!(bounding(message, &Simulation::REAL), worse);
        assert!(guard_of(GuardChoice::EnergyBounding, nothing, &Simulation::REAL, t).is_err());
    }
}
