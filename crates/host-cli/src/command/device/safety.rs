//! The safety chain of a device beyond force and rate, as `device set` changes it.

use super::number::set_all;
use crate::choice::choice;
use crate::output::note;
use crate::pair::{Delay, Workspace};
use crate::within::within;
use clap::Args;
use fracdiff::Seconds;
use haptic_experiment::Failure;
use haptic_experiment::GuardChoice;
use haptic_experiment::document::advice::single;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::run::guard_of;
use haptic_experiment::run::{GuardedDevice, speed, workspace};
use haptic_link::{Configuration, Guard, Limits, SimulationKind};
use haptic_quantity::{Damping, Force, Length, Mass, Speed, Time};
use haptic_remote::wire_guard;

/// What of the safety chain is set.
#[derive(Debug, Args)]
#[command(next_help_heading = "Safety")]
pub struct SafetyArguments {
    /// Largest force with which the device's loop starts; 0 for any
    #[arg(long, value_parser = within::<Force>(range::FORCE_LIMITS.or_0()), allow_hyphen_values = true)]
    start_force: Option<Force>,
    /// Time in which the force rises after a start; 0 for at once
    #[arg(long, value_parser = within::<Time>(parameters::RISE_TIME.range().or_0()), allow_hyphen_values = true)]
    rise_time: Option<Time>,
    /// Where the device may be, as in -10mm:20mm; `none` for anywhere
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = parse_range)]
    workspace: Option<Range>,
    /// How fast it may move; 0 for any speed
    #[arg(long, value_parser = within::<Speed>(parameters::SPEED_LIMIT.range().or_0()), allow_hyphen_values = true)]
    speed_limit: Option<Speed>,
    /// Damping that brakes near workspace and speed limit, and after a fault or stop; 0 for none
    #[arg(long, value_parser = within::<Damping>(parameters::BRAKING.range().or_0()), allow_hyphen_values = true)]
    braking: Option<Damping>,
    /// Time in which the force falls to zero after a fault or stop, 1ms to 1s
    #[arg(long, value_parser = within::<Time>(parameters::STOP_TIME.range()), allow_hyphen_values = true)]
    stop_time: Option<Time>,
    /// Largest force of the braking meanwhile, 0N to 10N
    #[arg(long, value_parser = within::<Force>(parameters::BRAKE_FORCE.range()), allow_hyphen_values = true)]
    brake_force: Option<Force>,
    /// A wanted force that grows by this on a position that stands still is a fault; 0 for never
    #[arg(long, value_parser = within::<Force>(parameters::STUCK_FORCE.range()), allow_hyphen_values = true)]
    stuck_force: Option<Force>,
    /// Time for which the position has to have stood still for that, 1ms to 10s
    #[arg(long, value_parser = within::<Time>(parameters::STUCK_TIME.range()), allow_hyphen_values = true)]
    stuck_time: Option<Time>,
    /// A position that moves in a tick by this more than the speed limit allows is a fault; 0 for never
    #[arg(long, value_parser = within::<Length>(parameters::JUMP.range()), allow_hyphen_values = true)]
    jump: Option<Length>,
    /// Keep the loop from feeding the device energy
    #[arg(long, value_parser = choice::<GuardChoice>())]
    guard: Option<GuardChoice>,
    /// Mass of a real device, for --guard observer and --braking; 0 for unknown
    #[arg(long, value_parser = within::<Mass>(parameters::DEVICE_MASS.range().or_0()), value_name = "MASS", allow_hyphen_values = true)]
    device_mass: Option<Mass>,
    /// Damping of a real device, for --guard energy-bounding
    #[arg(long, value_parser = within::<Damping>(parameters::DEVICE_DAMPING.range()), value_name = "DAMPING")]
    #[arg(requires = "guard", allow_hyphen_values = true)]
    device_damping: Option<Damping>,
    /// Delay of a real device from a measurement to the effect of its force, or the interval in which it lies, as in
    /// 0.2ms:1ms, for --guard energy-bounding
    #[arg(long, value_name = "TIME|LEAST:MOST")]
    #[arg(requires = "guard", allow_hyphen_values = true)]
    device_delay: Option<Delay>,
    /// Time constant with which the force of a real device follows, for --guard energy-bounding
    #[arg(long, value_parser = within::<Time>(parameters::DEVICE_LAG.range()), value_name = "TIME")]
    #[arg(requires = "guard", allow_hyphen_values = true)]
    device_lag: Option<Time>,
    /// Standard deviation of the noise of a real device's position, for --guard energy-bounding [default: 0]
    #[arg(long, value_parser = within::<Length>(parameters::DEVICE_NOISE.range()), value_name = "LENGTH")]
    #[arg(requires = "guard", allow_hyphen_values = true)]
    device_noise: Option<Length>,
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

impl SafetyArguments {
    /// Changes the safety chain, for the plant and the sample time that are set already. A simulated device has its
    /// mass known if that or the braking is `new_mass`.
    ///
    /// # Errors
    /// A number that single precision cannot hold; a guard that this device cannot have.
    pub(super) fn change(
        &self,
        configuration: &mut Configuration,
        new_mass: bool,
    ) -> Result<(), Failure> {
        let limits = &mut configuration.limits;
        self.change_numbers(limits)?;
        // That of a simulated device is known.
        let simulated = configuration.simulation.kind == SimulationKind::MassDamper;
        let asks = new_mass || self.braking.is_some();
        if simulated && asks && self.device_mass.is_none() {
            limits.device_mass_kg = configuration.simulation.mass_kg;
        }
        self.change_workspace(limits)?;
        self.change_speed(limits)?;
        self.change_guard(configuration)
    }

    fn change_numbers(&self, limits: &mut Limits) -> Result<(), Failure> {
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
        ])
    }

    /// The ends, and with braking the zone to brake in.
    fn change_workspace(&self, limits: &mut Limits) -> Result<(), Failure> {
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
        Ok(())
    }

    fn change_speed(&self, limits: &mut Limits) -> Result<(), Failure> {
        let brakes = limits.braking_n_s_per_m > 0.0;
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
        Ok(())
    }

    fn change_guard(&self, configuration: &mut Configuration) -> Result<(), Failure> {
        let Some(guard) = self.guard else {
            return Ok(());
        };
        let known = GuardedDevice {
            mass_kg: self.device_mass.map(|mass| mass.0),
            damping_n_s_per_m: self.device_damping.map(|damping| damping.0),
            delay_s: self.device_delay.map(|delay| (delay.least_s, delay.most_s)),
            lag_s: self.device_lag.map(|lag| lag.0),
            noise_m: self.device_noise.map(|noise| noise.0),
        };
        let t = Seconds(f64::from(configuration.tick_period_us) * 1e-6);
        let guard = guard_of(guard, known, &configuration.simulation, t)?;
        configuration.limits.guard = guard
            .as_ref()
            .map_or(Guard::OFF, |guard| wire_guard(guard, t));
        Ok(())
    }
}
