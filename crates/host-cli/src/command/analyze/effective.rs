//! `analyze environment` and `analyze transparency`: effective stiffness and damping.

use super::arguments::{Files, HORIZON, logarithmic, refused};
use super::path::{PathResult, path};
use crate::files::Place;
use crate::keys;
use crate::options::{Given, Options};
use crate::output::Output;
use clap::Args;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{ClosedLoop, Effective, Environment, LoopOperator};
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::{
    ANALYSED_DAMPING, ANALYSED_MASS, ANALYSED_SAMPLE_TIME, OMEGA_MAX, OMEGA_MIN, POINTS,
};
use haptic_experiment::parameters::{DISSIPATION, Parameter, STIFFNESS};
use haptic_experiment::run::DeviceValues;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use serde::Serialize;

/// The virtual environment and the frequencies.
struct Wall {
    environment: Environment,
    scheme: Scheme,
    operator: LoopOperator,
    omegas: Vec<f64>,
}

impl Wall {
    fn of(given: &Given) -> Result<Self, Failure> {
        let (mu, scheme) = (given.order()?, given.scheme()?);
        let t = given.needed(&ANALYSED_SAMPLE_TIME)?;
        let nyquist = std::f64::consts::PI / t;
        let high = given.number(&OMEGA_MAX).unwrap_or(nyquist);
        let low = given.number(&OMEGA_MIN).unwrap_or(high * 1e-3);
        if !(low > 0.0 && low < high && high <= nyquist) {
            return Err(Failure::bad_input(format_args!(
                "frequencies {low} to {high} rad/s are not inside 0 to {nyquist} rad/s, lowest first: \
                 change --omega-min, --omega-max or --sample-time"
            )));
        }
        let count = given.count(&POINTS, 2..=100_000)? as usize;
        Ok(Self {
            environment: Environment {
                stiffness_n_per_m: given.needed(&STIFFNESS)?,
                dissipation_n_s_mu_per_m: given.needed(&DISSIPATION)?,
                order: mu,
                sample_time_s: t,
            },
            scheme,
            operator: LoopOperator::new(scheme, mu, Seconds(t), HORIZON).map_err(refused)?,
            omegas: logarithmic(low, high, count).collect(),
        })
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
    options: Options<keys::Environment>,
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
    options: Options<keys::Transparency>,
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
    sample_time_s: f64,
    stiffness_n_per_m: f64,
    dissipation_n_s_mu_per_m: f64,
    /// Of a closed loop.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    path: Option<PathResult>,
    effective_stiffness_unit: &'static str,
    effective_damping_unit: &'static str,
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
        let wall = Wall::of(&self.options.given()?)?;
        let effective = |&omega: &f64| {
            let sampled = wall.environment.effective(&wall.operator, omega);
            Ok(point(sampled.map_err(refused)?, None))
        };
        let points = wall.omegas.iter().map(effective);
        let points = points.collect::<Result<Vec<_>, Failure>>()?;
        report(
            points,
            &wall,
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
        let given = self.options.given()?;
        let wall = Wall::of(&given)?;
        let file = given.device()?.map(|file| file.values);
        let or = |parameter: &Parameter, of_file: fn(&DeviceValues) -> f64| match &file {
            Some(file) if !given.has(parameter) => Ok(of_file(file)),
            _ => given.needed(parameter),
        };
        let mass_kg = or(&ANALYSED_MASS, |file| file.mass_kg)?;
        let damping_n_s_per_m = or(&ANALYSED_DAMPING, |file| file.damping_n_s_per_m)?;
        let sample_time_s = Some(wall.environment.sample_time_s);
        let path = path(&given, sample_time_s, file.as_ref())?;
        let closed = ClosedLoop {
            mass_kg,
            damping_n_s_per_m,
            environment: wall.environment,
            path,
        };
        let effective = |&omega: &f64| {
            let sampled = closed.sampled(&wall.operator, omega).map_err(refused)?;
            let continuous = closed.continuous(omega).map_err(refused)?;
            Ok(point(sampled, Some(continuous)))
        };
        let points = wall.omegas.iter().map(effective);
        let points = points.collect::<Result<Vec<_>, Failure>>()?;
        report(
            points,
            &wall,
            Some(PathResult::new(path, sample_time_s)),
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
        order: wall.environment.order.get(),
        scheme: wall.scheme.to_string(),
        sample_time_s: wall.environment.sample_time_s,
        stiffness_n_per_m: wall.environment.stiffness_n_per_m,
        dissipation_n_s_mu_per_m: wall.environment.dissipation_n_s_mu_per_m,
        path,
        effective_stiffness_unit: "N/m",
        effective_damping_unit: "N·s/m",
        points,
        files: written,
    };
    output.report(&result)?;
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
        wall.environment.order,
        wall.scheme,
        wall.environment.stiffness_n_per_m,
        wall.environment.dissipation_n_s_mu_per_m,
        wall.environment.sample_time_s
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
