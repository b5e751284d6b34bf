//! `zwidth`: how stiff a wall can be rendered, by trying.

use super::experiment::{parse_scheme, progress_bar, wall_order};
use super::remote::RemoteArguments;
use crate::experiment::{Sensors, ZWidth, ZWidthReport, dissertation_device};
use crate::failure::Failure;
use crate::figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use crate::folder::{FolderRequest, OutputFolder};
use crate::output::{Output, note};
use crate::quantity::{Damping, Force, Length, Mass, Stiffness, Time};
use clap::Args;
use fracdiff::{Order, Scheme, Seconds};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};
use serde::Serialize;
use std::path::PathBuf;

const LONG_ABOUT: &str = "\
Z-width: pushes a simulated device into a wall at its start position and looks for the stiffest wall \
that does not buzz, for each order and dissipation. The defaults are the dissertation's section 4.4: \
65 g, 3.5 N.s/m, 2 ms, a push of 1 N for 5 s, unstable if the position varies by more than 0.1 mm \
(standard deviation) in the last 0.4 s. --realistic adds what real devices have.";

/// Arguments of `zwidth`.
#[derive(Debug, Args)]
#[command(
    long_about = LONG_ABOUT,
    after_help = "Example: host-cli zwidth --orders 0,0.5,1 --points 11 --realistic --out zwidth"
)]
pub struct Arguments {
    /// Orders of the dissipation, 0 to 2
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0,0.5,1,1.5,2",
        allow_hyphen_values = true
    )]
    orders: Vec<f64>,
    /// Dissipations for each order, from 0 to the largest stable one
    #[arg(long, default_value_t = 21, allow_hyphen_values = true)]
    points: usize,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "full")]
    scheme: Scheme,
    #[command(flatten)]
    remote: RemoteArguments,
    #[command(flatten)]
    plant: PlantArguments,
    /// A wall that pushes but never pulls; without this it is linear, as the theory assumes
    #[arg(long)]
    one_sided: bool,
    /// Constant push into the wall
    #[arg(long, default_value = "1N", allow_hyphen_values = true)]
    push: Force,
    /// Length of a run
    #[arg(long, default_value = "5s", allow_hyphen_values = true)]
    duration: Time,
    /// Window at the end in which the position is judged
    #[arg(long, default_value = "0.4s", allow_hyphen_values = true)]
    window: Time,
    /// Largest standard deviation of a stable position
    #[arg(long, default_value = "0.1mm", allow_hyphen_values = true)]
    threshold: Length,
    /// Folder for zwidth.csv and pictures
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run in the folder
    #[arg(long)]
    overwrite: bool,
}

/// The simulated device.
#[derive(Debug, Args)]
#[command(next_help_heading = "Simulated device")]
pub struct PlantArguments {
    /// Mass of the device
    #[arg(long, default_value = "65g", allow_hyphen_values = true)]
    mass: Mass,
    /// Viscous damping of the device
    #[arg(long, default_value = "3.5", allow_hyphen_values = true)]
    damping: Damping,
    /// Stiffness of the hand that holds it; 0 without a hand
    #[arg(long, default_value = "0", allow_hyphen_values = true)]
    hand_stiffness: Stiffness,
    /// Sample time
    #[arg(long, default_value = "2ms", allow_hyphen_values = true)]
    sample_time: Time,
    /// What real devices have: 1 um encoder, 0.05 N friction, half a sample of delay, 1 ms current lag
    /// (each can be set by itself)
    #[arg(long)]
    realistic: bool,
    /// Coulomb friction
    #[arg(long, value_name = "FORCE", allow_hyphen_values = true)]
    friction: Option<Force>,
    /// Delay from computing a force to its acting
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    delay: Option<Time>,
    /// Time constant of the actuator's current
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    current_lag: Option<Time>,
    /// Resolution of the position encoder per count
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    encoder_resolution: Option<Length>,
    /// Standard deviation of the sensor noise
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "0",
        allow_hyphen_values = true
    )]
    sensor_noise: Length,
    /// Seed of the noise: the same seed gives the same result
    #[arg(long, default_value_t = 1, allow_hyphen_values = true)]
    seed: u64,
    /// Largest force of the actuator
    #[arg(
        long,
        value_name = "FORCE",
        default_value = "100N",
        allow_hyphen_values = true
    )]
    force_limit: Force,
}

impl PlantArguments {
    /// Whether anything of a real device is asked of the simulated one.
    fn is_less_than_ideal(&self) -> bool {
        self.realistic
            || self.friction.is_some()
            || self.delay.is_some()
            || self.current_lag.is_some()
            || self.encoder_resolution.is_some()
            || self.sensor_noise.0 > 0.0
    }
}

/// A row of the CSV.
#[derive(Serialize)]
struct Row {
    order: f64,
    dissipation_n_s_mu_per_m: f64,
    stiffness_max_n_per_m: f64,
    alpha: f64,
    beta: f64,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let experiment = self.experiment()?;
        let bar = progress_bar(experiment.cells(), output);
        let result = experiment.run(&|cells| bar.inc(cells));
        bar.finish_and_clear();
        let report = result?;
        let files = match &self.out {
            Some(out) => {
                let request = FolderRequest {
                    out: Some(out.clone()),
                    stem: "zwidth".to_owned(),
                    overwrite: self.overwrite,
                    roll_bytes: None,
                };
                save(&report, &request.prepare()?)?
            }
            None => Vec::new(),
        };
        let points = report.orders.iter().flat_map(|order| &order.boundary);
        if points
            .clone()
            .any(|p| p.alpha >= 0.999 * report.alpha_searched)
        {
            note(
                "warning",
                format_args!(
                    "some walls were stable up to alpha = {}, where the search ends: their limit is higher",
                    report.alpha_searched
                ),
            );
        }
        output.summary(&report, |out| {
            for order in &report.orders {
                writeln!(
                    out,
                    "order {}: {} points",
                    order.order,
                    order.boundary.len()
                )?;
                writeln!(
                    out,
                    "  {:>16} {:>16} {:>10} {:>10}",
                    format!("B / {}", order.dissipation_unit),
                    "K_max / N/m",
                    "beta",
                    "alpha"
                )?;
                for p in &order.boundary {
                    writeln!(
                        out,
                        "  {:>16.6} {:>16.3} {:>10.5} {:>10.5}",
                        p.dissipation, p.stiffness_max, p.beta, p.alpha
                    )?;
                }
            }
            files
                .iter()
                .try_for_each(|file| writeln!(out, "written: {file}"))
        })
    }

    fn experiment(&self) -> Result<ZWidth, Failure> {
        let orders: Vec<Order> = self
            .orders
            .iter()
            .map(|&mu| wall_order(mu, "--orders"))
            .collect::<Result<_, _>>()?;
        let plant = &self.plant;
        let remote = self.remote.remote(None)?;
        if remote.is_some() && plant.is_less_than_ideal() {
            return Err(Failure::bad_input(
                "--realistic, --friction, --delay, --current-lag, --encoder-resolution and --sensor-noise are \
                 of the simulated device: leave them away with a serial one, which has its own",
            ));
        }
        let t = plant.sample_time.0;
        // What --realistic sets, unless it is given by itself.
        let real = |given: Option<f64>, realistic: f64| {
            given.unwrap_or(if plant.realistic { realistic } else { 0.0 })
        };
        let mut device = dissertation_device(Seconds(t));
        device.mass = Kilograms(plant.mass.0);
        device.damping = NewtonSecondsPerMetre(plant.damping.0);
        device.stiffness = NewtonsPerMetre(plant.hand_stiffness.0);
        device.friction = Newtons(real(plant.friction.map(|f| f.0), 0.05));
        device.delay = Seconds(real(plant.delay.map(|d| d.0), 0.5 * t));
        device.lag = Seconds(real(plant.current_lag.map(|l| l.0), 1e-3));
        Ok(ZWidth {
            device,
            sensors: Sensors {
                encoder_resolution_m: real(plant.encoder_resolution.map(|r| r.0), 1e-6),
                noise_m: plant.sensor_noise.0,
                seed: plant.seed,
            },
            one_sided: self.one_sided,
            scheme: self.scheme,
            orders,
            points: self.points,
            push_n: self.push.0,
            duration_s: self.duration.0,
            window_s: self.window.0,
            threshold_m: self.threshold.0,
            force_limit_n: plant.force_limit.0,
            remote,
        })
    }
}

/// Writes the boundary as CSV and picture.
fn save(report: &ZWidthReport, folder: &OutputFolder) -> Result<Vec<String>, Failure> {
    let rows = report.orders.iter().flat_map(|order| {
        order.boundary.iter().map(|point| Row {
            order: order.order,
            dissipation_n_s_mu_per_m: point.dissipation,
            stiffness_max_n_per_m: point.stiffness_max,
            alpha: point.alpha,
            beta: point.beta,
        })
    });
    let table = folder.write_table("csv", rows)?;
    Ok(vec![table, folder.save_picture(&draw(report)?)?])
}

/// The boundaries in the α–β plane.
fn draw(report: &ZWidthReport) -> Result<Picture, FigureError> {
    let curves: Vec<(String, Vec<(f64, f64)>)> = report
        .orders
        .iter()
        .map(|order| {
            let points = order.boundary.iter().map(|p| (p.beta, p.alpha)).collect();
            (format!("μ = {}", order.order), points)
        })
        .collect();
    let series = |look| {
        curves
            .iter()
            .enumerate()
            .map(move |(colour, (name, points))| Series::new(name, points, look, colour))
    };
    ChartPage {
        title: "Z-width: the stiffest walls that settle",
        subtitle: &format!(
            "scheme {} · T = {} s · δ = {:.5} · simulated device",
            report.scheme, report.sample_time_s, report.delta
        ),
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("dissipation β = BT^{2−μ}/m", Scale::Linear),
            y: AxisSpec::new("largest stiffness α = KT²/m", Scale::Linear),
            series: series(Look::Line).chain(series(Look::Markers)).collect(),
        }],
    }
    .draw()
}
