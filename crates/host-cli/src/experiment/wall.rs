//! A wall: push a device into it with a constant force and see whether it settles.
//!
//! ```text
//! m·x'' + b·x' + k·x = push + f,    f = −(K·x + B·D^μ x) through the safety chain,    x(0) = 0
//! stable ⇔ standard deviation of x over the last window ≤ threshold      (0.1 mm over 0.4 s of 5 s)
//! at rest: x = push/(K + k), and B beside K for μ = 0
//! ```
//! The wall is linear, as theory assumes, unless it is asked to push only.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

mod report;

use super::judge::full_history;
use super::outcome::reaction;
use super::preflight::{Dynamics, Preflight, PreflightRequest, whole_samples};
use super::pushed::{GONE_M, VirtualWall, force_alone, pushed, safe_force_limit, wall_at_start};
use super::remote::{
    Kept, RemoteDevice, RemoteLaw, RemoteRun, device_name, host_limits, no_operator, portable, push,
};
use super::report::{Files, RunReport, Warnings};
use super::run::{Pace, Ran, Record, SAMPLES, Schedule, Supervisor, run_logged};
use super::safety::{GuardChoice, GuardedDevice, Safety};
use super::sensed::{Sensed, Sensors};
use crate::failure::Failure;
use crate::figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use crate::folder::FolderRequest;
use fracdiff::full_memory::Kernel;
use fracdiff::{FrequencyResponse as _, Operator, Order, Scheme};
use haptic_link::{LoopMode, Simulation, SimulationKind};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::NewtonsPerSecond;
use haptic_loop::{Controller, Limits, SafetyChain};
pub use report::WallReport;
use serde::Serialize;
use std::collections::BTreeMap;

/// A wall experiment.
#[derive(Clone, Debug)]
pub struct Wall {
    /// The device, the hand that holds it, and what makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// μ, 0 to 2.
    pub order: Order,
    /// The operator.
    pub scheme: Scheme,
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// A wall that pushes but never pulls.
    pub one_sided: bool,
    /// Constant push into the wall, N, above 0.
    pub push_n: f64,
    /// How long, s.
    pub duration_s: f64,
    /// Window at the end in which the position is judged, s.
    pub window_s: f64,
    /// Largest standard deviation of a stable position, m.
    pub threshold_m: f64,
    /// Largest force of the safety chain, N.
    pub force_limit_n: f64,
    /// Largest rate of the force, N/s; `None` for that of a serial device, and none on the simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// What else the safety chain does.
    pub safety: Safety,
    /// How time passes.
    pub pace: Pace,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// Run on a serial device what the analysis calls unstable.
    pub force_unstable: bool,
}

/// Where the device is at the end, and whether it is at rest there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settling {
    /// Whether the position has settled.
    pub stable: bool,
    /// Standard deviation of the position over the window, m; null if the device has left or a fault
    /// latched.
    pub position_std_m: Option<f64>,
    /// Mean of the position over the window, m.
    pub deflection_m: Option<f64>,
    /// Where the push is in balance with wall and hand, m; null without a spring.
    pub expected_deflection_m: Option<f64>,
}

/// A row of the CSV.
#[derive(Serialize)]
struct Row {
    time_s: f64,
    position_m: f64,
    reaction_force_n: f64,
}

/// The wall behind the safety chain and the device behind its sensors: made of good parameters.
struct Parts {
    controller: Controller<f64, 1, VirtualWall>,
    device: Sensed<MassDamper<1>>,
    samples: u64,
    /// See [`Settling::expected_deflection_m`].
    rest_m: Option<f64>,
}

impl Wall {
    /// Runs the experiment; log, CSV and picture go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log, CSV or picture that cannot be written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<WallReport, Failure> {
        let mut parts = self.parts()?;
        let schedule = Schedule {
            samples: parts.samples,
            sample_time_s: self.device.sample_time.0,
            pace: self.pace,
        };
        let mut metadata = self.metadata();
        let preflight = self.preflight(parts.samples);
        let ran = match &self.remote {
            None => {
                // Nothing can break, so it is only noted.
                let t = self.device.sample_time.0;
                let delay = whole_samples(self.device.delay.0, t);
                let verdict = preflight.verdict(self.dynamics(), delay)?;
                verdict.describe(&mut metadata);
                let ran = run_logged(
                    &mut parts.controller,
                    &mut parts.device,
                    schedule,
                    request,
                    metadata,
                    supervisor,
                )?;
                Ran {
                    preflight: Some(verdict),
                    ..ran
                }
            }
            Some(remote) => {
                let run = RemoteRun {
                    device: remote,
                    law: self.law(remote, parts.samples)?,
                    schedule,
                    reference: &|_| 0.0,
                    preflight: Some(preflight),
                    wanted: PreflightRequest {
                        force_unstable: self.force_unstable,
                        dynamics: Some(self.dynamics()),
                    },
                    request,
                    metadata,
                };
                run.run(&mut parts.controller, supervisor)?
            }
        };
        self.publish(&ran, parts.rest_m)
    }

    /// The loop for the analysis.
    fn preflight(&self, samples: u64) -> Preflight {
        Preflight {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            scheme: self.scheme,
            sample_time_s: self.device.sample_time.0,
            samples,
        }
    }

    /// Device and hand.
    fn dynamics(&self) -> Dynamics {
        Dynamics {
            mass_kg: self.device.mass.0,
            damping_n_s_per_m: self.device.damping.0,
            hand_stiffness_n_per_m: self.device.stiffness.0,
        }
    }

    /// The same without log or files: does it settle?
    ///
    /// # Errors
    /// Bad parameters.
    pub fn try_out(&self) -> Result<Settling, Failure> {
        let Parts {
            mut controller,
            mut device,
            samples,
            rest_m,
        } = self.parts()?;
        let mut positions = Vec::new();
        for _ in 0..samples {
            match controller.tick(&mut device) {
                Ok(sample) => positions.push(sample.reading.position_m[0]),
                Err(never) => match never {},
            }
            if controller.safety().fault().is_some() {
                return Ok(self.settling(None, rest_m));
            }
        }
        Ok(self.settling(Some(&positions), rest_m))
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        self.parts().map(|parts| parts.samples)
    }

    fn parts(&self) -> Result<Parts, Failure> {
        let t = self.device.sample_time;
        if self.order.get() < 0.0 {
            return Err(Failure::bad_input(format_args!(
                "order {} is not in [0, 2]: a wall has no integral",
                self.order
            )));
        }
        let device = Sensed::new(pushed(self.device, self.push_n)?, self.sensors)?;
        let samples = (self.duration_s / t.0).round() + 1.0;
        if !SAMPLES.contains(&samples) {
            return Err(Failure::bad_input(format_args!(
                "duration {} s at a sample time of {t} is {samples} samples, which is not in [{}, {:e}]",
                self.duration_s,
                SAMPLES.start(),
                SAMPLES.end()
            )));
        }
        if !(self.window_s >= 10.0 * t.0 && self.window_s <= self.duration_s) {
            return Err(Failure::bad_input(format_args!(
                "window {} s is not in [{}, {}] s, from ten samples to the whole run",
                self.window_s,
                10.0 * t.0,
                self.duration_s
            )));
        }
        if !(self.push_n > 0.0 && self.push_n < self.force_limit_n) {
            return Err(Failure::bad_input(format_args!(
                "push {} N is not above 0 N and below the force limit of {} N",
                self.push_n, self.force_limit_n
            )));
        }
        // A little more than needed, so that the last weights are not at the very edge.
        let operator: Operator<f64> = self
            .scheme
            .build(self.order, t, 1.05 * samples)
            .map_err(Failure::input)?;
        let rest_m = self.expected_deflection(&operator)?;
        let wall = wall_at_start(
            self.stiffness_n_per_m,
            self.dissipation_n_s_mu_per_m,
            operator,
            self.one_sided,
        )
        .map_err(Failure::input)?;
        let chain = match &self.remote {
            None => safe_force_limit(self.force_and_rate(), &self.device, &self.safety)?,
            Some(_) => SafetyChain::from_limits(&self.limits_here(), t).map_err(Failure::input)?,
        };
        Ok(Parts {
            controller: Controller::new(wall, chain),
            device,
            samples: samples as u64,
            rest_m,
        })
    }

    fn force_and_rate(&self) -> Limits {
        let limits = force_alone(self.force_limit_n, self.device.sample_time);
        Limits {
            rate: self
                .force_rate_limit_n_per_s
                .map_or(limits.rate, NewtonsPerSecond),
            ..limits
        }
    }

    /// Limits of the chain of a serial device, without its guard.
    fn limits_there(&self) -> Limits {
        let limits = self.safety.on(self.force_and_rate(), true);
        let delay = limits.device_delay_samples;
        self.safety.braked(limits, self.device.mass.0, delay)
    }

    /// Limits of the chain that runs here with a serial device: in a host loop the device does all but force
    /// and rate, and with its own loop this chain runs only to be checked.
    fn limits_here(&self) -> Limits {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Host => host_limits(&self.limits_there()),
            _ => self.limits_there(),
        }
    }

    /// The same wall and push for a serial device.
    fn law(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let MassDamperConfig {
            mass,
            damping,
            stiffness,
            delay,
            friction,
            lag,
            sample_time: t,
            saturation: _,
        } = self.device;
        if delay.0 > 0.0 || friction.0 > 0.0 || lag.0 > 0.0 {
            return Err(Failure::bad_input(
                "delay_s, friction_n and current_lag_s are of the simulated device: leave them away with a \
                 serial one, which has its own",
            ));
        }
        let operator = match remote.loop_mode {
            LoopMode::Device => {
                let horizon = 1.05 * samples as f64;
                let built = self.scheme.build(self.order, t, horizon);
                portable(&built.map_err(Failure::input)?)?
            }
            LoopMode::Host => no_operator(),
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order.get(),
            one_sided: self.one_sided,
            operator,
            limits: self.limits_there(),
            kept: Kept {
                rate: self.force_rate_limit_n_per_s.is_none(),
                speed: self.safety.speed_limit_m_per_s.is_none(),
                rise: self.safety.rise_time_s.is_none(),
            },
            guard: (
                self.safety.guard,
                self.safety.guarded(GuardedDevice {
                    mass_kg: Some(mass.0),
                    damping_n_s_per_m: Some(damping.0),
                    delay_samples: 0,
                }),
            ),
            simulation: Simulation {
                kind: SimulationKind::MassDamper,
                mass_kg: mass.0 as f32,
                damping_n_s_per_m: damping.0 as f32,
                hand_stiffness_n_per_m: stiffness.0 as f32,
                ..push(self.push_n)
            },
        })
    }

    /// Judges the positions of a whole run; `None` for one that did not reach its end.
    fn settling(&self, position_m: Option<&[f64]>, rest_m: Option<f64>) -> Settling {
        let window = (self.window_s / self.device.sample_time.0).round() as usize;
        let judged = position_m.map(|x| &x[x.len().saturating_sub(window)..]);
        let here = judged.filter(|x| !x.is_empty() && x.iter().all(|x| x.abs() <= GONE_M));
        let moments = here.map(|x| {
            let count = x.len() as f64;
            let mean = x.iter().sum::<f64>() / count;
            let squares: f64 = x.iter().map(|x| (x - mean) * (x - mean)).sum();
            (mean, (squares / count).sqrt())
        });
        Settling {
            stable: moments.is_some_and(|(_, deviation)| deviation <= self.threshold_m),
            position_std_m: moments.map(|(_, deviation)| deviation),
            deflection_m: moments.map(|(mean, _)| mean),
            expected_deflection_m: rest_m,
        }
    }

    /// push/(K + k + B·T^(−μ)·P(1)), m: P(1), the gain of the operator at rest, is 1 for the identity, 0
    /// for a good derivative, and something else for one that forgets.
    ///
    /// # Errors
    /// A sample time outside its range.
    fn expected_deflection(&self, operator: &Operator<f64>) -> Result<Option<f64>, Failure> {
        let rate = self.device.sample_time.rate_to_the(self.order);
        let at_rest = operator.response(0.0).re * rate.map_err(Failure::input)?;
        let spring = self.stiffness_n_per_m
            + self.device.stiffness.0
            + self.dissipation_n_s_mu_per_m * at_rest;
        Ok(Some(self.push_n / spring).filter(|x| x.is_finite() && spring > 0.0))
    }

    /// Commanded force against −(K·x + B·D^μ x) by the full history of x, as a share of the largest.
    fn operator_error(&self, record: &Record) -> Result<Option<f64>, Failure> {
        let kernel = match self.scheme {
            Scheme::Full { kernel, .. } => kernel,
            _ => Kernel::Grunwald,
        };
        // The weights of the other kernel are known in closed form below order 1 only.
        let known = kernel == Kernel::Grunwald || self.order.get() < 1.0;
        if self.one_sided || record.limited > 0 || !known {
            return Ok(None);
        }
        let t = self.device.sample_time;
        let derivative = record
            .of_every_tick(|x| full_history(kernel, self.order, t, x))
            .map_err(Failure::Run)?;
        let wanted = record
            .position_m
            .iter()
            .zip(&derivative)
            .map(|(x, d)| -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d));
        let off = record.force_n.iter().zip(wanted);
        let off = off.fold(0.0, |most: f64, (have, want)| most.max((have - want).abs()));
        Ok(Some(off / record.largest_force_n()).filter(|error| error.is_finite()))
    }

    fn publish(&self, ran: &Ran, rest_m: Option<f64>) -> Result<WallReport, Failure> {
        let Ran { record, folder, .. } = ran;
        let time = &record.time_s;
        let force = reaction(record);
        let whole = record.ended.is_none();
        let settling = self.settling(whole.then_some(record.position_m.as_slice()), rest_m);
        let mut warnings = Warnings::default();
        if whole && settling.stable {
            warnings.limited(record.limited);
        } else if whole {
            warnings.0.push(format!(
                "the wall is unstable: in the last {} s {}",
                self.window_s,
                settling.position_std_m.map_or_else(
                    || format!("the device was more than {GONE_M} m away"),
                    |deviation| format!(
                        "the position varies by {deviation:.3e} m, more than {:e} m",
                        self.threshold_m
                    )
                ),
            ));
        }
        let mut files = Files::default();
        if whole {
            let rows = (0..force.len()).map(|n| Row {
                time_s: time[n],
                position_m: record.position_m[n],
                reaction_force_n: force[n],
            });
            files.csv = Some(folder.write_table("csv", rows)?);
            files.figure = Some(folder.save_picture(&self.draw(record, &force, settling)?)?);
        } else {
            folder.remove_stale_results();
        }
        let rest = settling.deflection_m.zip(settling.expected_deflection_m);
        Ok(WallReport {
            tissue: None,
            order: self.order.get(),
            scheme: self.scheme.to_string(),
            run: RunReport::new(
                ran,
                device_name(self.remote.as_ref()),
                self.device.sample_time.0,
                files,
                warnings,
            ),
            max_relative_error: if whole {
                self.operator_error(record)?
            } else {
                None
            },
            closed_form_error: rest
                .filter(|_| settling.stable)
                .map(|(have, want)| (have / want - 1.0).abs()),
            settling,
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
        })
    }

    /// The position over its place of rest, and the force below.
    fn draw(
        &self,
        record: &Record,
        force: &[f64],
        settling: Settling,
    ) -> Result<Picture, FigureError> {
        let time = &record.time_s;
        let against_time = |values: &mut dyn Iterator<Item = f64>| -> Vec<(f64, f64)> {
            time.iter().copied().zip(values).collect()
        };
        let position = against_time(&mut record.position_m.iter().map(|x| 1e3 * x));
        let force = against_time(&mut force.iter().copied());
        let ends = [time.first(), time.last()].into_iter().flatten();
        let rest: Vec<(f64, f64)> = settling
            .expected_deflection_m
            .map(|x| ends.map(|&t| (t, 1e3 * x)).collect())
            .unwrap_or_default();
        let series = |name, points, look, colour| Series {
            name,
            points,
            look,
            colour,
        };
        let mut positions = vec![series("run", &position, Look::Line, 0)];
        if !rest.is_empty() {
            positions.push(series("place of rest", &rest, Look::Dashed, 1));
        }
        let subtitle = format!(
            "order μ = {} · K = {} N/m · B = {} N·s^μ/m · scheme {} · push {} N · {}",
            self.order,
            six_digits(self.stiffness_n_per_m),
            six_digits(self.dissipation_n_s_mu_per_m),
            self.scheme,
            self.push_n,
            if settling.stable {
                "stable"
            } else {
                "unstable"
            }
        ) + &match self.safety.guard {
            GuardChoice::Off => String::new(),
            guard => format!(" · guard {}", guard.name()),
        };
        let axis = |label| AxisSpec {
            label,
            scale: Scale::Linear,
            range: None,
        };
        let chart = |caption, label, series| Chart {
            caption,
            x: axis("time / s"),
            y: axis(label),
            series,
        };
        ChartPage {
            title: "Pushed into a wall",
            subtitle: &subtitle,
            columns: 1,
            charts: vec![
                chart("position", "position / mm", positions),
                chart(
                    "force of the wall",
                    "force / N",
                    vec![series("run", &force, Look::Line, 0)],
                ),
            ],
        }
        .draw()
    }

    /// Everything needed to repeat the run.
    fn metadata(&self) -> BTreeMap<String, String> {
        let device = &self.device;
        let entries = [
            ("experiment", "wall".to_owned()),
            (
                "program",
                concat!("host-cli ", env!("CARGO_PKG_VERSION")).to_owned(),
            ),
            (
                "command_line",
                std::env::args().collect::<Vec<_>>().join(" "),
            ),
            ("device", device_name(self.remote.as_ref())),
            ("mass_kg", device.mass.0.to_string()),
            ("damping_n_s_per_m", device.damping.0.to_string()),
            ("hand_stiffness_n_per_m", device.stiffness.0.to_string()),
            ("sample_time_s", device.sample_time.0.to_string()),
            ("delay_s", device.delay.0.to_string()),
            ("friction_n", device.friction.0.to_string()),
            ("current_lag_s", device.lag.0.to_string()),
            (
                "encoder_resolution_m",
                self.sensors.encoder_resolution_m.to_string(),
            ),
            ("sensor_noise_m", self.sensors.noise_m.to_string()),
            ("seed", self.sensors.seed.to_string()),
            ("order", self.order.to_string()),
            ("scheme", self.scheme.to_string()),
            ("stiffness_n_per_m", self.stiffness_n_per_m.to_string()),
            (
                "dissipation_n_s_mu_per_m",
                self.dissipation_n_s_mu_per_m.to_string(),
            ),
            ("one_sided", self.one_sided.to_string()),
            ("push_n", self.push_n.to_string()),
            ("duration_s", self.duration_s.to_string()),
            ("window_s", self.window_s.to_string()),
            ("threshold_m", self.threshold_m.to_string()),
            ("force_limit_n", self.force_limit_n.to_string()),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> =
            entries.map(|(key, value)| (key.to_owned(), value)).into();
        self.safety.describe(&mut metadata);
        metadata
    }
}

/// To six significant digits, as a subtitle shows a number.
fn six_digits(value: f64) -> f64 {
    // What a format made of a number is a number.
    format!("{value:.5e}").parse().unwrap_or(value)
}
