//! The impedance that is felt of a wall, `environment` and `transparency`, and the damping that a coupler needs, `coupling`.

use super::resolved::{HORIZON, logarithmic, path, path_result};
use crate::files::Place;
use crate::options::keys::{ANALYSED_DAMPING, ANALYSED_MASS, ANALYSED_SAMPLE_TIME};
use crate::options::{Given, Options, WithFiles, keys};
use crate::output::{Output, joined};
use crate::picture::{Panel, linear, logarithmic as axis, page};
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{ClosedLoop, Coupler, Effective, Environment, LeastDamping, LoopOperator};
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::{OMEGA_MAX, OMEGA_MIN, POINTS};
use haptic_experiment::parameters::{
    COUPLER_DAMPING, COUPLER_SPRING, DISSIPATION, Parameter, STIFFNESS,
};
use haptic_experiment::run::DeviceValues;
use haptic_figure::{FigureError, Look, Picture};
use haptic_quantity::written;
use serde_json::{Value, json};

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
                "{low} to {high} rad/s are not in 0 to {nyquist}: change --omega-min or --omega-max"
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
            operator: LoopOperator::new(scheme, mu, Seconds(t), HORIZON).map_err(Failure::input)?,
            omegas: logarithmic(low, high, count).collect(),
        })
    }
}

pub(super) fn environment(
    asked: WithFiles<keys::Environment>,
    output: Output,
) -> Result<(), Failure> {
    let outputs = asked.files.look("environment", &[])?;
    let wall = Wall::of(&asked.options.given()?)?;
    let effective = |&omega: &f64| {
        let sampled = wall.environment.effective(&wall.operator, omega);
        Ok((sampled.map_err(Failure::input)?, None))
    };
    let points = wall.omegas.iter().map(effective);
    let points = points.collect::<Result<Vec<_>, Failure>>()?;
    let title = "Effective stiffness and damping of the environment";
    report(&points, &wall, json!({}), outputs, title, output)
}

pub(super) fn transparency(
    asked: WithFiles<keys::Transparency>,
    output: Output,
) -> Result<(), Failure> {
    let outputs = asked.files.look("transparency", &[])?;
    let given = asked.options.given()?;
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
        let sampled = closed.sampled(&wall.operator, omega);
        let continuous = closed.continuous(omega).map_err(Failure::input)?;
        Ok((sampled.map_err(Failure::input)?, Some(continuous)))
    };
    let points = wall.omegas.iter().map(effective);
    let points = points.collect::<Result<Vec<_>, Failure>>()?;
    let path = path_result(path, sample_time_s);
    let title = "Effective stiffness and damping at the hand";
    report(&points, &wall, path, outputs, title, output)
}

/// A frequency: sampled, and continuous of a closed loop.
type Point = (Effective, Option<Effective>);

const COLUMNS: [&str; 5] = [
    "omega_rad_s",
    "effective_stiffness_n_per_m",
    "effective_damping_n_s_per_m",
    "continuous_stiffness_n_per_m",
    "continuous_damping_n_s_per_m",
];

fn report(
    points: &[Point],
    wall: &Wall,
    path: Value,
    mut outputs: Place,
    title: &str,
    output: Output,
) -> Result<(), Failure> {
    let rows = points.iter().map(|(sampled, continuous)| {
        (
            sampled.omega_rad_s,
            sampled.stiffness_n_per_m,
            sampled.damping_n_s_per_m,
            continuous.map(|c| c.stiffness_n_per_m),
            continuous.map(|c| c.damping_n_s_per_m),
        )
    });
    let picture = || draw(points, wall, title);
    let files = outputs.table_and_picture(&COLUMNS, rows, picture);
    let points = points.iter().map(|(sampled, continuous)| {
        let mut point = json!({
            "omega_rad_s": sampled.omega_rad_s,
            "effective_stiffness": sampled.stiffness_n_per_m,
            "effective_damping": sampled.damping_n_s_per_m,
        });
        if let Some(continuous) = continuous {
            point["continuous_stiffness_n_per_m"] = json!(continuous.stiffness_n_per_m);
            point["continuous_damping_n_s_per_m"] = json!(continuous.damping_n_s_per_m);
        }
        point
    });
    let asked = json!({
        "order": wall.environment.order.get(),
        "scheme": wall.scheme.to_string(),
        "sample_time_s": wall.environment.sample_time_s,
        "stiffness_n_per_m": wall.environment.stiffness_n_per_m,
        "dissipation_n_s_mu_per_m": wall.environment.dissipation_n_s_mu_per_m,
    });
    let found = json!({
        "effective_stiffness_unit": "N/m",
        "effective_damping_unit": "N·s/m",
        "points": points.collect::<Vec<_>>(),
        "files": files,
    });
    output.report(&joined([asked, path, found]))?;
    outputs.close(Ok(()))
}

fn draw(points: &[Point], wall: &Wall, title: &str) -> Result<Picture, FigureError> {
    let panel = |caption, label, value: fn(&Effective) -> f64| {
        let pair = |point: &Effective| (point.omega_rad_s, value(point));
        let sampled = points.iter().map(|(sampled, _)| pair(sampled));
        let continuous = points
            .iter()
            .filter_map(|(_, point)| point.as_ref().map(pair));
        Panel::new(caption, axis("frequency ω / rad·s⁻¹"), linear(label))
            .with("sampled", Look::Line, 0, sampled)
            .with("continuous", Look::Dashed, 1, continuous)
    };
    let environment = &wall.environment;
    let dissipation = environment.dissipation_n_s_mu_per_m;
    let subtitle = format!(
        "order μ = {} · scheme {} · K = {} · B = {} · T = {}",
        environment.order,
        wall.scheme,
        written("stiffness_n_per_m", environment.stiffness_n_per_m),
        written("dissipation_n_s_mu_per_m", dissipation),
        written("sample_time_s", environment.sample_time_s)
    );
    let panels = [
        panel("stiffness", "effective stiffness / N·m⁻¹", |p| {
            p.stiffness_n_per_m
        }),
        panel("damping", "effective damping / N·s·m⁻¹", |p| {
            p.damping_n_s_per_m
        }),
    ];
    page(title, &subtitle, 2, &panels)
}

pub(super) fn coupling(options: Options<keys::Coupling>, output: Output) -> Result<(), Failure> {
    let given = options.given()?;
    let (mu, scheme) = (given.order()?, given.scheme()?);
    let t = given.needed(&ANALYSED_SAMPLE_TIME)?;
    let damper = given.needed(&COUPLER_DAMPING)?;
    let spring = given.needed(&COUPLER_SPRING)?;
    let exact = Coupler::exact(mu, t, damper, spring).map_err(Failure::input)?;
    let operator = LoopOperator::new(scheme, mu, Seconds(t), HORIZON).map_err(Failure::input)?;
    let coupler = if scheme == Scheme::Exact {
        exact
    } else {
        exact.with_operator(&operator, operator.memory())
    };
    let damping = given.number(&ANALYSED_DAMPING);
    let least = coupler.least_damping().map_err(Failure::input)?;
    let (required, worst_theta) = match least {
        LeastDamping::Enough {
            damping_n_s_per_m,
            worst_theta,
        } => (Some(damping_n_s_per_m), worst_theta),
        LeastDamping::NoneIsEnough { theta } => (None, theta),
    };
    let passive = match (required, damping) {
        (None, _) => Some(false),
        (Some(_), Some(b)) => Some(coupler.passive(b).map_err(Failure::input)?),
        (Some(_), None) => None,
    };
    output.report(&json!({
        "order": mu.get(),
        "scheme": scheme.to_string(),
        "sample_time_s": t,
        "coupler_damping_n_s_per_m": damper,
        "coupler_spring_n_s_1_minus_mu_per_m": spring,
        "damping_n_s_per_m": damping,
        // By Llewellyn's criterion, null if no damping is enough, and by Corollary 2.
        "required_damping": required,
        "required_damping_unit": "N·s/m",
        "corollary_damping": coupler.corollary_damping(),
        "corollary_damping_unit": "N·s/m",
        "worst_theta": worst_theta,
        "passive": passive,
        "passive_reason": passive.is_none().then_some("give --damping to know"),
        "reason": required.is_none().then(|| format!(
            "the coupler itself is active at theta = {worst_theta:.6}: no damping is enough"
        )),
    }))
}
