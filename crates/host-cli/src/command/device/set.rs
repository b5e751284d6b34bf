//! `device get` and `device set`.

use super::PortArguments;
use super::parameters::{Parameters, SafetyParameters};
use crate::choice::choice;
use crate::command::remote::watchdog_ms;
use crate::command::words::{order, parse_dissipation, parse_order, parse_scheme};
use crate::output::{Output, note};
use crate::quantity::{
    Damping, Delay, Force, ForceRate, Length, Mass, Speed, Stiffness, Time, Workspace,
};
use clap::Args;
use fracdiff::{Operator, Scheme, Seconds};
use haptic_experiment::GuardChoice;
use haptic_experiment::device::{Loop, at_port};
use haptic_experiment::failure::Failure;
use haptic_experiment::refused::single;
use haptic_experiment::remote::guard_of;
use haptic_experiment::safety::{GuardedDevice, speed, workspace};
use haptic_link::{Configuration, Guard, GuardKind, Limits, LoopMode, SimulationKind};
use haptic_remote::{operator_shape, wire_guard};
use std::io::{self, Write};

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
    #[arg(long, allow_hyphen_values = true)]
    sample_time: Option<Time>,
    /// Stiffness K
    #[arg(long, allow_hyphen_values = true)]
    stiffness: Option<Stiffness>,
    /// Dissipation B, in N.s^mu/m
    #[arg(long, allow_hyphen_values = true, value_parser = parse_dissipation)]
    dissipation: Option<f64>,
    /// Order of the dissipation: makes a new operator
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order)]
    order: Option<f64>,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "full", requires = "order")]
    scheme: Scheme,
    /// What a full memory remembers
    #[arg(long, default_value = "200s", requires = "order")]
    horizon: Time,
    /// Surface of a wall that pushes but never pulls; `none` for one that does both
    #[arg(long, allow_hyphen_values = true, value_parser = parse_surface)]
    surface: Option<Surface>,
    /// Largest force
    #[arg(long, allow_hyphen_values = true)]
    force_limit: Option<Force>,
    /// Largest rate of force
    #[arg(long, allow_hyphen_values = true)]
    force_rate_limit: Option<ForceRate>,
    /// Silence from the host after which the device lets go
    #[arg(long, allow_hyphen_values = true)]
    watchdog: Option<Time>,
    /// Late ticks in a row that latch a fault; 0 for never
    #[arg(long)]
    late_ticks: Option<u16>,
    /// In a loop on the host: ticks from a sample to the force that answers it at most
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    max_age_ticks: Option<u16>,
    /// Largest force with which the device's loop starts; 0 for any
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    start_force: Option<Force>,
    /// Time in which the force rises after a start; 0 for at once
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    rise_time: Option<Time>,
    /// Where the device may be, as in -10mm:20mm; `none` for anywhere
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = parse_range, help_heading = "Safety")]
    workspace: Option<Range>,
    /// How fast it may move; 0 for any speed
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    speed_limit: Option<Speed>,
    /// Damping that brakes near workspace and speed limit, and after a fault or stop; 0 for none
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    braking: Option<Damping>,
    /// Time in which the force falls to zero after a fault or stop, 1ms to 1s
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    stop_time: Option<Time>,
    /// Largest force of the braking meanwhile, 0N to 10N
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    brake_force: Option<Force>,
    /// A wanted force that grows by this on a position that stands still is a fault; 0 for never
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    stuck_force: Option<Force>,
    /// Time for which the position has to have stood still for that, 1ms to 10s
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    stuck_time: Option<Time>,
    /// A position that moves in a tick by this more than the speed limit allows is a fault; 0 for never
    #[arg(long, allow_hyphen_values = true, help_heading = "Safety")]
    jump: Option<Length>,
    /// Keep the loop from feeding the device energy
    #[arg(long, value_parser = choice::<GuardChoice>(), help_heading = "Safety")]
    guard: Option<GuardChoice>,
    /// Mass of a real device, for --guard observer and --braking; 0 for unknown
    #[arg(
        long,
        value_name = "MASS",
        allow_hyphen_values = true,
        help_heading = "Safety"
    )]
    device_mass: Option<Mass>,
    /// Damping of a real device, for --guard energy-bounding
    #[arg(
        long,
        value_name = "DAMPING",
        requires = "guard",
        allow_hyphen_values = true,
        help_heading = "Safety"
    )]
    device_damping: Option<Damping>,
    /// Delay of a real device from a measurement to the effect of its force, or the interval in which it lies, as in
    /// 0.2ms:1ms, for --guard energy-bounding
    #[arg(
        long,
        value_name = "TIME|LEAST:MOST",
        requires = "guard",
        allow_hyphen_values = true,
        help_heading = "Safety"
    )]
    device_delay: Option<Delay>,
    /// Time constant with which the force of a real device follows, for --guard energy-bounding
    #[arg(
        long,
        value_name = "TIME",
        requires = "guard",
        allow_hyphen_values = true,
        help_heading = "Safety"
    )]
    device_lag: Option<Time>,
    /// Standard deviation of the noise of a real device's position, for --guard energy-bounding [default: 0]
    #[arg(
        long,
        value_name = "LENGTH",
        requires = "guard",
        allow_hyphen_values = true,
        help_heading = "Safety"
    )]
    device_noise: Option<Length>,
    /// Mass of a simulated device
    #[arg(long, allow_hyphen_values = true, help_heading = "Simulated device")]
    mass: Option<Mass>,
    /// Damping of a simulated device
    #[arg(long, allow_hyphen_values = true, help_heading = "Simulated device")]
    damping: Option<Damping>,
    /// Stiffness of the hand on a simulated device
    #[arg(long, allow_hyphen_values = true, help_heading = "Simulated device")]
    hand_stiffness: Option<Stiffness>,
    /// Push of the hand on a simulated device
    #[arg(long, allow_hyphen_values = true, help_heading = "Simulated device")]
    push: Option<Force>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    None,
    At(f64),
}

/// The range of the workspace.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Range {
    None,
    Within(Workspace),
}

fn parse_range(text: &str) -> Result<Range, String> {
    if text == "none" {
        return Ok(Range::None);
    }
    text.parse().map(Range::Within)
}

fn parse_surface(text: &str) -> Result<Surface, String> {
    if text == "none" {
        return Ok(Surface::None);
    }
    let length: Length = text
        .parse()
        .map_err(|error: crate::quantity::QuantityError| error.to_string())?;
    Ok(Surface::At(length.0))
}

impl GetArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit code 3: no port, no device, no answer.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let link = self.port.connect()?;
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
        let mut link = self.port.connect()?;
        let path = link.path().to_owned();
        let problem = |error| at_port(&path, &error);
        let (mut configuration, mut values) = link.configuration().map_err(problem)?;
        let before = configuration.limits;
        self.change(&mut configuration, &mut values)?;
        link.set(configuration, &values).map_err(|error| {
            if error.is_refusal() {
                Failure::bad_input(error)
            } else {
                problem(error)
            }
        })?;
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
        if let Some(watchdog) = self.watchdog {
            configuration.limits.watchdog_ms = watchdog_ms(watchdog)?;
        }
        if let Some(late) = self.late_ticks {
            configuration.limits.late_ticks = late;
        }
        if let Some(ticks) = self.max_age_ticks {
            configuration.limits.max_age_ticks = ticks;
        }
        match self.surface {
            Some(Surface::None) => configuration.one_sided = false,
            Some(Surface::At(surface)) => {
                configuration.one_sided = true;
                configuration.surface_m = single("--surface", surface)?;
            }
            None => {}
        }
        let simulation = &mut configuration.simulation;
        let plant = [
            (&mut simulation.mass_kg, "--mass", self.mass.map(|m| m.0)),
            (
                &mut simulation.damping_n_s_per_m,
                "--damping",
                self.damping.map(|b| b.0),
            ),
            (
                &mut simulation.hand_stiffness_n_per_m,
                "--hand-stiffness",
                self.hand_stiffness.map(|k| k.0),
            ),
            (&mut simulation.push_n, "--push", self.push.map(|f| f.0)),
        ];
        if plant.iter().any(|(_, _, value)| value.is_some()) {
            simulation.kind = SimulationKind::MassDamper;
        }
        set_all(plant)?;
        self.change_limits(configuration)?;
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

impl SetArguments {
    /// Changes the safety chain, for the plant and the sample time that are set already.
    fn change_limits(&self, configuration: &mut Configuration) -> Result<(), Failure> {
        let limits = &mut configuration.limits;
        let (stop, stuck) = (self.stop_time.map(|t| t.0), self.stuck_time.map(|t| t.0));
        set_all([
            (
                &mut limits.start_force_n,
                "--start-force",
                self.start_force.map(|f| f.0),
            ),
            (
                &mut limits.rise_time_s,
                "--rise-time",
                self.rise_time.map(|t| t.0),
            ),
            (
                &mut limits.braking_n_s_per_m,
                "--braking",
                self.braking.map(|b| b.0),
            ),
            (&mut limits.stop_time_s, "--stop-time", stop),
            (
                &mut limits.brake_force_n,
                "--brake-force",
                self.brake_force.map(|f| f.0),
            ),
            (
                &mut limits.stuck_force_n,
                "--stuck-force",
                self.stuck_force.map(|f| f.0),
            ),
            (&mut limits.stuck_time_s, "--stuck-time", stuck),
            (&mut limits.jump_m, "--jump", self.jump.map(|jump| jump.0)),
            (
                &mut limits.device_mass_kg,
                "--device-mass",
                self.device_mass.map(|m| m.0),
            ),
        ])?;
        // That of a simulated device is known.
        let simulated = configuration.simulation.kind == SimulationKind::MassDamper;
        let asks = self.mass.is_some() || self.braking.is_some();
        if simulated && asks && self.device_mass.is_none() {
            limits.device_mass_kg = configuration.simulation.mass_kg;
        }
        let brakes = limits.braking_n_s_per_m > 0.0;
        let ends = match self.workspace {
            Some(Range::Within(ends)) => Some((ends.low_m, ends.high_m)),
            Some(Range::None) => {
                (limits.workspace_low_m, limits.workspace_high_m) = (0.0, 0.0);
                limits.workspace_soft_m = 0.0;
                None
            }
            // With braking comes and goes the zone to brake in.
            None if self.braking.is_some() => {
                let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
                (low < high).then_some((f64::from(low), f64::from(high)))
            }
            None => None,
        };
        if let Some(ends) = ends {
            let workspace = workspace(ends, brakes);
            limits.workspace_low_m = single("--workspace", workspace.low.0)?;
            limits.workspace_high_m = single("--workspace", workspace.high.0)?;
            limits.workspace_soft_m = workspace.soft.0 as f32;
        }
        let hard = match self.speed_limit {
            Some(speed) => Some(speed.0),
            None if self.braking.is_some() => Some(f64::from(limits.speed_hard_m_per_s)),
            None => None,
        };
        if let Some(hard) = hard {
            let speed = speed(hard, brakes);
            limits.speed_soft_m_per_s = speed.soft.0 as f32;
            limits.speed_hard_m_per_s = single("--speed-limit", speed.hard.0)?;
        }
        if self.jump.is_some_and(|jump| jump.0 > 0.0) && limits.speed_hard_m_per_s == 0.0 {
            note(
                "warning",
                "--jump has no effect without a speed limit: give --speed-limit too",
            );
        }
        if let Some(guard) = self.guard {
            let known = GuardedDevice {
                mass_kg: self.device_mass.map(|mass| mass.0),
                damping_n_s_per_m: self.device_damping.map(|damping| damping.0),
                delay_s: self.device_delay.map(|delay| (delay.least_s, delay.most_s)),
                lag_s: self.device_lag.map(|lag| lag.0),
                noise_m: self.device_noise.map(|noise| noise.0),
            };
            let t = Seconds(f64::from(configuration.tick_period_us) * 1e-6);
            let guard = guard_of(guard, known, &configuration.simulation, t)?;
            limits.guard = guard
                .as_ref()
                .map_or(Guard::OFF, |guard| wire_guard(guard, t));
        }
        Ok(())
    }
}

/// Sets what was given.
///
/// # Errors
/// A number that single precision cannot hold.
fn set_all<const N: usize>(numbers: [(&mut f32, &str, Option<f64>); N]) -> Result<(), Failure> {
    for (target, option, value) in numbers {
        if let Some(value) = value {
            *target = single(option, value)?;
        }
    }
    Ok(())
}

/// The limits that are looser than before, in words: it is only here that they can be.
fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    // 0 is no limit.
    let at_most = |value: f32| if value > 0.0 { value } else { f32::INFINITY };
    let numbers = [
        ("force limit", "N", before.force_n, after.force_n),
        (
            "force rate limit",
            "N/s",
            before.force_rate_n_per_s,
            after.force_rate_n_per_s,
        ),
        (
            "start force",
            "N",
            at_most(before.start_force_n),
            at_most(after.start_force_n),
        ),
        (
            "speed limit",
            "m/s",
            at_most(before.speed_hard_m_per_s),
            at_most(after.speed_hard_m_per_s),
        ),
        // Turned round: a longer rise is the tighter one.
        ("rise time", "s", -before.rise_time_s, -after.rise_time_s),
    ];
    let in_words = |value: f32, unit: &str| match value.abs() {
        value if value.is_infinite() => "none".to_owned(),
        value => format!("{value} {unit}"),
    };
    let mut words: Vec<String> = numbers
        .into_iter()
        .filter(|(_, _, before, after)| after > before)
        .map(|(name, unit, before, after)| {
            let (before, after) = (in_words(before, unit), in_words(after, unit));
            format!("{name} from {before} to {after}")
        })
        .collect();
    let (low, high) = (after.workspace_low_m, after.workspace_high_m);
    let had = before.workspace_low_m < before.workspace_high_m;
    if had && (low >= high || low < before.workspace_low_m || high > before.workspace_high_m) {
        words.push(format!(
            "workspace from {}:{} to {low}:{high} m, 0:0 being none",
            before.workspace_low_m, before.workspace_high_m
        ));
    }
    if before.guard.kind != GuardKind::Off && after.guard.kind == GuardKind::Off {
        words.push("the passivity guard is off".to_owned());
    }
    words
}

/// A time in whole microseconds.
///
/// # Errors
/// Outside its range, or not a whole number of them.
pub fn microseconds(what: &str, time: Time, least_s: f64, most_s: f64) -> Result<u32, Failure> {
    let us = (time.0 * 1e6).round();
    if time.0 >= least_s && time.0 <= most_s && (us - time.0 * 1e6).abs() < 1e-6 {
        Ok(us as u32)
    } else {
        Err(Failure::bad_input(format_args!(
            "{what} {time} is not a whole number of microseconds in [{least_s}, {most_s}] s, which a device \
             needs"
        )))
    }
}

/// One line: what is on.
fn print_safety(out: &mut dyn Write, s: &SafetyParameters) -> io::Result<()> {
    let mut on = Vec::new();
    if s.start_force_n > 0.0 {
        on.push(format!("starts with at most {} N", s.start_force_n));
    }
    if s.rise_time_s > 0.0 {
        on.push(format!("rises in {} s", s.rise_time_s));
    }
    if let Some([low, high]) = s.workspace_m {
        on.push(format!("from {low} m to {high} m"));
    }
    if s.speed_limit_m_per_s > 0.0 {
        on.push(format!("at most {} m/s", s.speed_limit_m_per_s));
    }
    if s.braking_n_s_per_m > 0.0 {
        on.push(format!("brakes with {} N·s/m", s.braking_n_s_per_m));
    }
    on.push(format!("stops in {} s", s.stop_time_s));
    if s.jump_m > 0.0 && s.speed_limit_m_per_s > 0.0 {
        on.push(format!("no jump of {} m", s.jump_m));
    }
    if s.stuck_force_n > 0.0 {
        on.push(format!(
            "no growth of {} N on a position that stands still",
            s.stuck_force_n
        ));
    }
    if let Some(guard) = &s.guard {
        on.push(format!(
            "guard {} with {} N·s/m",
            guard.kind, guard.damping_n_s_per_m
        ));
    }
    writeln!(out, "  safety            {}", on.join(", "))
}

fn print(out: &mut dyn Write, p: &Parameters) -> io::Result<()> {
    writeln!(
        out,
        "loop on the {}, every {} ms",
        p.loop_mode,
        1e3 * p.sample_time_s
    )?;
    writeln!(
        out,
        "  environment       K = {} N/m, B = {} N·s^μ/m, μ = {}{}",
        p.stiffness_n_per_m,
        p.dissipation_n_s_mu_per_m,
        p.order,
        if p.one_sided {
            format!(", pushes from {} m on", p.surface_m)
        } else {
            String::new()
        }
    )?;
    writeln!(
        out,
        "  operator          {} {}, integer part {}",
        p.operator.coefficients.len(),
        p.operator.form,
        p.operator.integer
    )?;
    writeln!(
        out,
        "  limits            {} N, {} N/s, {} ms of silence, {} late ticks in a row",
        p.force_limit_n,
        p.force_rate_limit_n_per_s,
        1e3 * p.watchdog_s,
        p.late_ticks
    )?;
    print_safety(out, &p.safety)?;
    match &p.simulation {
        Some(s) => writeln!(
            out,
            "  simulation        {}: {} kg, {} N·s/m, hand {} N/m, push {} N, depth {} m in {} s",
            s.kind,
            s.mass_kg,
            s.damping_n_s_per_m,
            s.hand_stiffness_n_per_m,
            s.push_n,
            s.depth_m,
            s.ramp_time_s
        ),
        None => Ok(()),
    }
}
