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
use super::kept::{Sample, Samples, WHOLE_MOST};
use super::preflight::{Dynamics, Preflight, PreflightRequest, whole_samples};
use super::pushed::{GONE_M, VirtualWall, force_alone, pushed, safe_force_limit, wall_at_start};
use super::remote::{
    RemoteDevice, RemoteLaw, RemoteRun, device_name, host_limits, no_operator, portable, push,
};
use super::report::{Files, RunReport, Warnings};
use super::run::{Pace, Ran, SAMPLES, Schedule, Supervisor, run_logged};
use super::safety::{GuardChoice, GuardedDevice, Safety};
use super::sensed::{Sensed, Sensors};
use super::thinned::Thinned;
use super::track::{TOLERANCE, Track, operator};
use crate::failure::Failure;
use crate::figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use crate::folder::FolderRequest;
use fracdiff::full_memory::Kernel;
use fracdiff::{FrequencyResponse as _, Operator, Order, Scheme};
use haptic_link::{LoopMode, Simulation, SimulationKind};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
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

/// What becomes of a run that reached its end.
struct Judged {
    csv: String,
    curves: Thinned<2>,
    /// See [`WallReport::max_relative_error`].
    operator_error: Option<f64>,
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
        let parts = self.parts()?;
        let rest_m = parts.rest_m;
        let ran = self.record(parts, request, supervisor)?;
        self.publish(&ran, rest_m)
    }

    /// Runs the loop and writes the log.
    fn record(
        &self,
        mut parts: Parts,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let schedule = Schedule {
            samples: parts.samples,
            sample_time_s: self.device.sample_time.0,
            pace: self.pace,
        };
        let mut metadata = self.metadata();
        let preflight = self.preflight(parts.samples);
        match &self.remote {
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
                Ok(Ran {
                    preflight: Some(verdict),
                    ..ran
                })
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
                run.run(&mut parts.controller, supervisor)
            }
        }
    }

    /// Runs without a report.
    #[cfg(test)]
    pub(super) fn run_alone(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        self.record(self.parts()?, request, supervisor)
    }

    /// Judges a run again.
    #[cfg(test)]
    pub(super) fn report(&self, ran: &Ran) -> Result<WallReport, Failure> {
        self.publish(ran, self.parts()?.rest_m)
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
        let mut tried = Vec::new();
        for _ in 0..samples {
            match controller.tick(&mut device) {
                Ok(sample) => tried.push(Sample {
                    tick: sample.reading.tick,
                    time_s: sample.reading.time_s,
                    position_m: sample.reading.position_m[0],
                    force_n: sample.force.newtons()[0],
                }),
                Err(never) => match never {},
            }
            if controller.safety().fault().is_some() {
                return Ok(self.settling(None, rest_m));
            }
        }
        let moments = self.moments(Samples::Whole(&tried), samples)?;
        Ok(self.settling(moments, rest_m))
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
            None => safe_force_limit(self.force_limit_n, &self.device, &self.safety)?,
            Some(_) => SafetyChain::from_limits(&self.limits_here(), t).map_err(Failure::input)?,
        };
        Ok(Parts {
            controller: Controller::new(wall, chain),
            device,
            samples: samples as u64,
            rest_m,
        })
    }

    /// Limits of the chain of a serial device, without its guard.
    fn limits_there(&self) -> Limits {
        let limits = force_alone(self.force_limit_n, self.device.sample_time);
        self.safety.on(limits, true)
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

    /// The number of samples.
    fn planned(&self) -> u64 {
        (self.duration_s / self.device.sample_time.0).round() as u64 + 1
    }

    /// Mean and standard deviation of the position over the window at the end of so many samples, m; `None`
    /// if the device has left.
    ///
    /// # Errors
    /// A log that cannot be read.
    fn moments(&self, samples: Samples<'_>, count: u64) -> Result<Option<(f64, f64)>, Failure> {
        let window = (self.window_s / self.device.sample_time.0).round() as u64;
        let before = count.saturating_sub(window);
        let over_window = |take: &mut dyn FnMut(f64)| {
            let mut number = 0;
            samples.for_each(|sample| {
                number += 1;
                if number > before {
                    take(sample.position_m);
                }
                Ok(())
            })
        };
        let (mut judged, mut sum, mut here) = (0_u64, 0.0, true);
        over_window(&mut |x| {
            judged += 1;
            sum += x;
            here &= x.abs() <= GONE_M;
        })?;
        if judged == 0 || !here {
            return Ok(None);
        }
        let mean = sum / judged as f64;
        let mut squares = 0.0;
        over_window(&mut |x| squares += (x - mean) * (x - mean))?;
        Ok(Some((mean, (squares / judged as f64).sqrt())))
    }

    /// Judges a run by its [`moments`](Self::moments); `None` for one that did not reach its end.
    fn settling(&self, moments: Option<(f64, f64)>, rest_m: Option<f64>) -> Settling {
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

    /// D^μ x by the full history of x; `None` where the force is not −(K·x + B·D^μ x) of it.
    fn derivative(&self, ran: &Ran) -> Result<Option<Track<'static>>, Failure> {
        let record = &ran.record;
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
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let derivative = Track::new(
            samples,
            |x| full_history(kernel, self.order, t, x).map_err(Failure::Run),
            || {
                let mut channel = operator(kernel, self.order, t, self.planned())?;
                Ok(Box::new(move |_, x| channel.step(x)))
            },
        )?;
        Ok(Some(derivative))
    }

    fn publish(&self, ran: &Ran, rest_m: Option<f64>) -> Result<WallReport, Failure> {
        let Ran { record, folder, .. } = ran;
        let samples = Samples::of(record, &ran.log.paths);
        let whole = record.ended.is_none();
        let moments = match whole {
            true => self.moments(samples, record.samples)?,
            false => None,
        };
        let settling = self.settling(moments, rest_m);
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
        let mut operator_error = None;
        if whole {
            let judged = self.judge(ran)?;
            operator_error = judged.operator_error;
            files.csv = Some(judged.csv);
            files.figure = Some(folder.save_picture(&self.draw(&judged.curves, settling)?)?);
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
            max_relative_error: operator_error,
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            closed_form_error: rest
                .filter(|_| settling.stable)
                .map(|(have, want)| (have / want - 1.0).abs()),
            settling,
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
        })
    }

    /// Writes the table of a run that reached its end, and holds each force against theory.
    fn judge(&self, ran: &Ran) -> Result<Judged, Failure> {
        let record = &ran.record;
        let mut derivative = self.derivative(ran)?;
        let mut table = ran.folder.table("csv")?;
        let dense = if record.whole.is_some() {
            WHOLE_MOST
        } else {
            0
        };
        let mut curves = Thinned::new(dense);
        let mut off: f64 = 0.0;
        Samples::of(record, &ran.log.paths).for_each(|sample| {
            let (x, reaction_force_n) = (sample.position_m, sample.reaction_n());
            if let Some(derivative) = &mut derivative {
                let d = derivative.at(sample);
                let wanted = -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d);
                off = off.max((sample.force_n - wanted).abs());
            }
            curves.add(sample.time_s, [x, reaction_force_n]);
            table.row(&Row {
                time_s: sample.time_s,
                position_m: x,
                reaction_force_n,
            })
        })?;
        curves.finish();
        let error = derivative.map(|_| off / record.largest_force_n());
        Ok(Judged {
            csv: table.finish()?,
            curves,
            operator_error: error.filter(|error| error.is_finite()),
        })
    }

    /// The position over its place of rest, and the force below.
    fn draw(&self, curves: &Thinned<2>, settling: Settling) -> Result<Picture, FigureError> {
        let time = &curves.time_s;
        let against_time = |values: &mut dyn Iterator<Item = f64>| -> Vec<(f64, f64)> {
            time.iter().copied().zip(values).collect()
        };
        let [position_m, force_n] = &curves.curves;
        let position = against_time(&mut position_m.iter().map(|x| 1e3 * x));
        let force = against_time(&mut force_n.iter().copied());
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
