//! `analyze environment` and `analyze transparency`: effective stiffness and damping.

use super::arguments::{Files, HORIZON, logarithmic, refused};
use super::path::{PathArguments, PathResult};
use crate::command::device_model::DeviceModelArguments;
use crate::command::words::{parse_dissipation, parse_order, parse_scheme, wall_order};
use crate::files::Place;
use crate::output::Output;
use crate::whole::whole;
use crate::within::{number_within, read_within, within};
use clap::Args;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{ClosedLoop, Effective, Environment, LoopOperator};
use haptic_experiment::Failure;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::run::DeviceValues;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use haptic_quantity::{Damping, Mass, Stiffness, Time};
use serde::Serialize;

/// The virtual environment and the frequencies.
#[derive(Debug, Args)]
struct Wall {
    /// Order mu of the dissipation, 0 to 2
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order)]
    order: f64,
    /// Virtual stiffness K
    #[arg(long, value_parser = within::<Stiffness>(parameters::STIFFNESS.range()), allow_hyphen_values = true)]
    stiffness: Stiffness,
    /// Fractional dissipation B, N s^mu/m
    #[arg(long, allow_hyphen_values = true, value_parser = read_within(parse_dissipation, parameters::DISSIPATION.range()))]
    dissipation: f64,
    /// Sample time T
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), allow_hyphen_values = true)]
    sample_time: Time,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "exact")]
    scheme: Scheme,
    /// Lowest frequency, rad/s [default: a thousandth of the highest]
    #[arg(long, value_name = "RAD_PER_S", allow_hyphen_values = true, value_parser = number_within(range::ANGULAR_FREQUENCIES))]
    omega_min: Option<f64>,
    /// Highest frequency, rad/s [default: half the sample rate, pi/T]
    #[arg(long, value_name = "RAD_PER_S", allow_hyphen_values = true, value_parser = number_within(range::ANGULAR_FREQUENCIES))]
    omega_max: Option<f64>,
    /// Number of frequencies
    #[arg(long, default_value_t = 200, value_parser = whole::<u32>(2..=100_000))]
    points: u32,
}

impl Wall {
    fn environment(&self) -> Result<(Environment, LoopOperator), Failure> {
        let mu = wall_order(self.order, "--order")?;
        let operator = LoopOperator::new(self.scheme, mu, Seconds(self.sample_time.0), HORIZON)
            .map_err(refused)?;
        let environment = Environment {
            stiffness_n_per_m: self.stiffness.0,
            dissipation_n_s_mu_per_m: self.dissipation,
            order: mu,
            sample_time_s: self.sample_time.0,
        };
        Ok((environment, operator))
    }

    fn frequencies(&self) -> Result<impl Iterator<Item = f64> + use<>, Failure> {
        let nyquist = std::f64::consts::PI / self.sample_time.0;
        let high = self.omega_max.unwrap_or(nyquist);
        let low = self.omega_min.unwrap_or(high * 1e-3);
        if low > 0.0 && low < high && high <= nyquist {
            Ok(logarithmic(low, high, self.points as usize))
        } else {
            Err(Failure::bad_input(format_args!(
                "frequencies {low} to {high} rad/s are not inside 0 to {nyquist} rad/s, lowest first: \
                 change --omega-min, --omega-max or --sample-time"
            )))
        }
    }
}

/// Arguments of `analyze environment`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze environment --order 0.5 --stiffness 10N/mm --dissipation 100 \
                  --sample-time 1ms --out environment"
)]
pub struct EnvironmentArguments {
    #[command(flatten)]
    wall: Wall,
    #[command(flatten)]
    files: Files,
}

/// Arguments of `analyze transparency`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze transparency --order 0.5 --stiffness 50 --dissipation 1 --mass 0.65kg \
                  --damping 3.5 --sample-time 1ms --out transparency"
)]
pub struct TransparencyArguments {
    #[command(flatten)]
    wall: Wall,
    #[command(flatten)]
    file: DeviceModelArguments,
    /// Mass m of the device
    #[arg(
        long, value_parser = within::<Mass>(parameters::MASS.range()),
        required_unless_present = "device_model",
        allow_hyphen_values = true
    )]
    mass: Option<Mass>,
    /// Viscous damping b of the device
    #[arg(
        long, value_parser = within::<Damping>(parameters::DAMPING.range()),
        required_unless_present = "device_model",
        allow_hyphen_values = true
    )]
    damping: Option<Damping>,
    #[command(flatten)]
    path: PathArguments,
    #[command(flatten)]
    files: Files,
}

/// One frequency.
#[derive(Clone, Copy, Serialize)]
struct Point {
    omega_rad_s: f64,
    effective_stiffness: f64,
    effective_damping: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "continuous_stiffness_n_per_m")]
    continuous_stiffness: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "continuous_damping_n_s_per_m")]
    continuous_damping: Option<f64>,
}

/// A row of the CSV.
#[derive(Serialize)]
struct Row {
    omega_rad_s: f64,
    effective_stiffness_n_per_m: f64,
    effective_damping_n_s_per_m: f64,
    continuous_stiffness_n_per_m: Option<f64>,
    continuous_damping_n_s_per_m: Option<f64>,
}

/// The result.
#[derive(Serialize)]
struct Points {
    order: f64,
    scheme: String,
    /// Of a closed loop.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    path: Option<PathResult>,
    points: Vec<Point>,
    files: Vec<String>,
}

impl EnvironmentArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let place = self.files.look("environment")?;
        let (environment, operator) = self.wall.environment()?;
        let points = self
            .wall
            .frequencies()?
            .map(|omega| {
                let sampled = environment.effective(&operator, omega).map_err(refused)?;
                Ok(point(sampled, None))
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        report(
            points,
            &self.wall,
            None,
            place,
            "Effective stiffness and damping of the environment",
            output,
        )
    }
}

impl TransparencyArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let place = self.files.look("transparency")?;
        let (environment, operator) = self.wall.environment()?;
        let file = self.file.read()?.map(|file| file.values);
        let or = |given: Option<f64>, of_file: fn(&DeviceValues) -> f64| {
            // The parser asks for one of the two.
            given.or(file.as_ref().map(of_file)).unwrap_or_default()
        };
        let closed = ClosedLoop {
            mass_kg: or(self.mass.map(|m| m.0), |file| file.mass_kg),
            damping_n_s_per_m: or(self.damping.map(|b| b.0), |file| file.damping_n_s_per_m),
            environment,
            delay_samples: 0,
        };
        let path = self
            .path
            .resolve(Some(self.wall.sample_time.0), file.as_ref())?;
        let closed = closed.through(path);
        let points = self
            .wall
            .frequencies()?
            .map(|omega| {
                let sampled = closed.sampled(&operator, omega).map_err(refused)?;
                let continuous = closed.continuous(omega).map_err(refused)?;
                Ok(point(sampled, Some(continuous)))
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        report(
            points,
            &self.wall,
            Some(PathResult::new(path, Some(self.wall.sample_time.0))),
            place,
            "Effective stiffness and damping at the hand",
            output,
        )
    }
}

fn point(sampled: Effective, continuous: Option<Effective>) -> Point {
    Point {
        omega_rad_s: sampled.omega_rad_s,
        effective_stiffness: sampled.stiffness_n_per_m,
        effective_damping: sampled.damping_n_s_per_m,
        continuous_stiffness: continuous.map(|c| c.stiffness_n_per_m),
        continuous_damping: continuous.map(|c| c.damping_n_s_per_m),
    }
}

fn report(
    points: Vec<Point>,
    wall: &Wall,
    path: Option<PathResult>,
    mut place: Place,
    title: &str,
    output: Output,
) -> Result<(), Failure> {
    let rows = points.iter().map(|p| Row {
        omega_rad_s: p.omega_rad_s,
        effective_stiffness_n_per_m: p.effective_stiffness,
        effective_damping_n_s_per_m: p.effective_damping,
        continuous_stiffness_n_per_m: p.continuous_stiffness,
        continuous_damping_n_s_per_m: p.continuous_damping,
    });
    let written = place.table_and_picture(rows, || draw(&points, wall, title));
    let result = Points {
        order: wall.order,
        scheme: wall.scheme.to_string(),
        path,
        points,
        files: written,
    };
    output.print(&result, |out| {
        writeln!(
            out,
            "{:>14} {:>18} {:>20}",
            "omega / rad/s", "stiffness / N/m", "damping / N·s/m"
        )?;
        for p in &result.points {
            writeln!(
                out,
                "{:>14.6} {:>18.6} {:>20.8}",
                p.omega_rad_s, p.effective_stiffness, p.effective_damping
            )?;
        }
        result
            .files
            .iter()
            .try_for_each(|file| writeln!(out, "written: {file}"))
    })?;
    place.close(Ok(()))
}

fn draw(points: &[Point], wall: &Wall, title: &str) -> Result<Picture, FigureError> {
    let column = |value: fn(&Point) -> Option<f64>| -> Vec<(f64, f64)> {
        let pairs = points
            .iter()
            .filter_map(|p| Some((p.omega_rad_s, value(p)?)));
        pairs.collect()
    };
    let stiffness = column(|p| Some(p.effective_stiffness));
    let damping = column(|p| Some(p.effective_damping));
    let continuous_stiffness = column(|p| p.continuous_stiffness);
    let continuous_damping = column(|p| p.continuous_damping);
    let omega = || AxisSpec::new("frequency ω / rad·s⁻¹", Scale::Log);
    let chart = |caption, label, sampled, continuous| Chart {
        caption,
        x: omega(),
        y: AxisSpec::new(label, Scale::Linear),
        series: vec![
            Series::new("sampled", sampled, Look::Line, 0),
            Series::new("continuous", continuous, Look::Dashed, 1),
        ]
        .into_iter()
        .filter(|series| !series.points.is_empty())
        .collect(),
    };
    let subtitle = format!(
        "order μ = {} · scheme {} · K = {} N/m · B = {} N·s^μ/m · T = {} s",
        wall.order, wall.scheme, wall.stiffness.0, wall.dissipation, wall.sample_time.0
    );
    ChartPage {
        title,
        subtitle: &subtitle,
        columns: 2,
        charts: vec![
            chart(
                "stiffness",
                "effective stiffness / N·m⁻¹",
                &stiffness,
                &continuous_stiffness,
            ),
            chart(
                "damping",
                "effective damping / N·s·m⁻¹",
                &damping,
                &continuous_damping,
            ),
        ],
    }
    .draw()
}
