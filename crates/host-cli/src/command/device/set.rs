//! `device get` and `device set`.

use super::loosened::loosened;
use super::number::{microseconds, set_all, watchdog_ms};
use super::parameters::{Parameters, print};
use super::port::PortArguments;
use super::safety::SafetyArguments;
use crate::choice::choice;
use crate::command::words::{order, parse_dissipation, parse_order, parse_scheme};
use crate::output::{Output, note};
use crate::whole::whole;
use crate::within::in_range;
use crate::within::{read_within, within};
use clap::Args;
use fracdiff::{Operator, Scheme, Seconds};
use haptic_experiment::Failure;
use haptic_experiment::document::advice::single;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::run::device::{Loop, at_port, refused_at_port};
use haptic_link::{Configuration, LoopMode, Simulation, SimulationKind};
use haptic_quantity::{Damping, Force, ForceRate, Length, Mass, Stiffness, Time};
use haptic_remote::operator_shape;

/// Arguments of `device get`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli device get --device serial:/dev/ttyACM0 --json")]
pub struct GetArguments {
    #[command(flatten)]
    port: PortArguments,
}

/// Arguments of `device set`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli device set --device serial:/dev/ttyACM0 --stiffness 1N/mm \
                  --order 0.5 --dissipation 20"
)]
pub struct SetArguments {
    #[command(flatten)]
    port: PortArguments,
    /// Where the loop is closed
    #[arg(long = "loop", value_parser = choice::<Loop>())]
    loop_mode: Option<Loop>,
    /// Sample time of the loop; the operator must be given again with it
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), allow_hyphen_values = true)]
    sample_time: Option<Time>,
    /// Stiffness K
    #[arg(long, value_parser = within::<Stiffness>(parameters::STIFFNESS.range()), allow_hyphen_values = true)]
    stiffness: Option<Stiffness>,
    /// Dissipation B, in N.s^mu/m
    #[arg(long, allow_hyphen_values = true, value_parser = read_within(parse_dissipation, parameters::DISSIPATION.range()))]
    dissipation: Option<f64>,
    /// Order of the dissipation: makes a new operator
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order)]
    order: Option<f64>,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "full", requires = "order")]
    scheme: Scheme,
    /// What a full memory remembers
    #[arg(long, value_parser = within::<Time>(range::MEMORIES), default_value = "200s", requires = "order")]
    horizon: Time,
    /// Surface of a wall that pushes but never pulls; `none` for one that does both
    #[arg(long, allow_hyphen_values = true, value_parser = parse_surface)]
    surface: Option<Surface>,
    /// Largest force
    #[arg(long, value_parser = within::<Force>(range::FORCE_LIMITS), allow_hyphen_values = true)]
    force_limit: Option<Force>,
    /// Largest rate of force
    #[arg(long, value_parser = within::<ForceRate>(range::FORCE_RATES), allow_hyphen_values = true)]
    force_rate_limit: Option<ForceRate>,
    /// Silence from the host after which the device lets go
    #[arg(long, value_parser = within::<Time>(parameters::WATCHDOG.range()), allow_hyphen_values = true)]
    watchdog: Option<Time>,
    /// Late ticks in a row that latch a fault; 0 for never
    #[arg(long, value_parser = whole::<u16>(0..=u16::MAX))]
    late_ticks: Option<u16>,
    /// In a loop on the host: ticks from a sample to the force that answers it at most
    #[arg(long, value_parser = whole::<u16>(1..=1000))]
    max_age_ticks: Option<u16>,
    #[command(flatten)]
    safety: SafetyArguments,
    #[command(flatten)]
    plant: PlantArguments,
}

/// What of a simulated device is set.
#[derive(Debug, Args)]
#[command(next_help_heading = "Simulated device")]
struct PlantArguments {
    /// Mass of a simulated device
    #[arg(long, value_parser = within::<Mass>(parameters::MASS.range()), allow_hyphen_values = true)]
    mass: Option<Mass>,
    /// Damping of a simulated device
    #[arg(long, value_parser = within::<Damping>(parameters::DAMPING.range()), allow_hyphen_values = true)]
    damping: Option<Damping>,
    /// Stiffness of the hand on a simulated device
    #[arg(long, value_parser = within::<Stiffness>(parameters::HAND_STIFFNESS.range()), allow_hyphen_values = true)]
    hand_stiffness: Option<Stiffness>,
    /// Push of the hand on a simulated device
    #[arg(long, value_parser = within::<Force>(range::FORCES), allow_hyphen_values = true)]
    push: Option<Force>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    None,
    At(f64),
}

fn parse_surface(text: &str) -> Result<Surface, String> {
    if text == "none" {
        return Ok(Surface::None);
    }
    let length: Length = text
        .parse()
        .map_err(|error: haptic_quantity::QuantityError| error.to_string())?;
    Ok(Surface::At(in_range(length, range::PLACES)?.0))
}

impl GetArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit code 3: no port, no device, no answer.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let link = self.port.connect_any()?;
        let configuration = link.configuration();
        let (configuration, values) =
            configuration.map_err(|error| at_port(link.path(), &error))?;
        let parameters = Parameters::new(&configuration, &values);
        output.print(&parameters, |out| print(out, &parameters))
    }
}

impl SetArguments {
    /// Runs the command: reads what is set, changes what was given, sets it, and reads it back.
    ///
    /// # Errors
    /// A parameter beyond the device's limits; exit code 3: no port, no device, no answer.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut link = self.port.connect_any()?;
        let path = link.path().to_owned();
        let problem = |error| at_port(&path, &error);
        let (mut configuration, mut values) = link.configuration().map_err(problem)?;
        let before = configuration.limits;
        self.change(&mut configuration, &mut values)?;
        let set = link.set(configuration, &values);
        set.map_err(|error| refused_at_port(&path, error))?;
        let (configuration, values) = link.configuration().map_err(problem)?;
        for limit in loosened(&before, &configuration.limits) {
            note("warning", format_args!("loosened: {limit}"));
        }
        let parameters = Parameters::new(&configuration, &values);
        output.summary(&parameters, |out| print(out, &parameters))
    }

    fn change(
        &self,
        configuration: &mut Configuration,
        values: &mut Vec<f32>,
    ) -> Result<(), Failure> {
        self.change_loop(configuration)?;
        self.change_environment(configuration)?;
        self.change_plant(&mut configuration.simulation)?;
        self.safety
            .change(configuration, self.plant.mass.is_some())?;
        self.change_operator(configuration, values)
    }

    /// Changes the place and period of the loop, and its reaction to silence and lateness.
    fn change_loop(&self, configuration: &mut Configuration) -> Result<(), Failure> {
        if let Some(loop_mode) = self.loop_mode {
            let (before, after) = (configuration.loop_mode, LoopMode::from(loop_mode));
            // A watchdog time that nobody chose goes with the loop.
            if configuration.limits.watchdog_ms == before.watchdog_ms() {
                configuration.limits.watchdog_ms = after.watchdog_ms();
            }
            configuration.loop_mode = after;
        }
        if let Some(time) = self.sample_time {
            if self.order.is_none() {
                return Err(Failure::bad_input(
                    "another sample time needs another operator: give --order (and --scheme) with \
                     --sample-time",
                ));
            }
            configuration.tick_period_us = microseconds("sample time", time, 1e-6, 4000.0)?;
        }
        if let Some(watchdog) = self.watchdog {
            configuration.limits.watchdog_ms = watchdog_ms(watchdog)?;
        }
        if let Some(late) = self.late_ticks {
            configuration.limits.late_ticks = late;
        }
        if let Some(ticks) = self.max_age_ticks {
            configuration.limits.max_age_ticks = ticks;
        }
        Ok(())
    }

    fn change_environment(&self, configuration: &mut Configuration) -> Result<(), Failure> {
        let rate = self.force_rate_limit.map(|rate| rate.0);
        set_all([
            (
                &mut configuration.stiffness_n_per_m,
                "--stiffness",
                self.stiffness.map(|k| k.0),
            ),
            (
                &mut configuration.dissipation_n_s_mu_per_m,
                "--dissipation",
                self.dissipation,
            ),
            (
                &mut configuration.limits.force_n,
                "--force-limit",
                self.force_limit.map(|f| f.0),
            ),
            (
                &mut configuration.limits.force_rate_n_per_s,
                "--force-rate-limit",
                rate,
            ),
        ])?;
        match self.surface {
            Some(Surface::None) => configuration.one_sided = false,
            Some(Surface::At(surface)) => {
                configuration.one_sided = true;
                configuration.surface_m = single("--surface", surface)?;
            }
            None => {}
        }
        Ok(())
    }

    fn change_plant(&self, simulation: &mut Simulation) -> Result<(), Failure> {
        let plant = [
            (
                &mut simulation.mass_kg,
                "--mass",
                self.plant.mass.map(|m| m.0),
            ),
            (
                &mut simulation.damping_n_s_per_m,
                "--damping",
                self.plant.damping.map(|b| b.0),
            ),
            (
                &mut simulation.hand_stiffness_n_per_m,
                "--hand-stiffness",
                self.plant.hand_stiffness.map(|k| k.0),
            ),
            (
                &mut simulation.push_n,
                "--push",
                self.plant.push.map(|f| f.0),
            ),
        ];
        if plant.iter().any(|(_, _, value)| value.is_some()) {
            simulation.kind = SimulationKind::MassDamper;
        }
        set_all(plant)
    }

    fn change_operator(
        &self,
        configuration: &mut Configuration,
        values: &mut Vec<f32>,
    ) -> Result<(), Failure> {
        if let Some(mu) = self.order {
            let t = Seconds(f64::from(configuration.tick_period_us) * 1e-6);
            let built = self.scheme.build(order(mu)?, t, self.horizon.0 / t.0);
            let operator: Operator<f32> = built
                .map_err(|error| Failure::input_with_advice(error, "change --order or --scheme"))?;
            let (shape, list) = operator_shape(&operator).map_err(Failure::input)?;
            configuration.order = mu as f32;
            configuration.operator = shape;
            *values = list;
        }
        Ok(())
    }
}
