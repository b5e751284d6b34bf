//! Figures 3.3, 3.4, 4.5 and 6.2: what an environment and a loop do at each frequency.

use super::evidence::sensitivity::SENSITIVITY_WALL;
use super::figure::{Axis, Figure, Panel, logarithmic, per_order};
use super::{DAMPING_N_S_PER_M, DELTA, Kind, ORDERS};
use fracdiff::Order;
use haptic_analysis::{
    AnalysisError, ClosedLoop, Environment, ForcePath, Nondimensional, SampledLoop,
};
use haptic_experiment::Failure;
use haptic_figure::Look;
use std::f64::consts::PI;

const OMEGA: Axis = Axis::log("frequency ω / rad·s⁻¹", "omega_rad_s");
const STIFFNESS: Axis = Axis::linear("effective stiffness / N·m⁻¹", "effective_stiffness_n_per_m");
const DAMPING: Axis = Axis::linear("effective damping / N·s·m⁻¹", "effective_damping_n_s_per_m");

pub(super) fn coefficients() -> Result<Figure, Failure> {
    const THETA: Axis = Axis::linear("digital frequency θ / rad", "theta_rad");
    let orders = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0];
    let panel = |caption: &str, y, value: fn(f64, f64) -> f64| {
        let curves = per_order(&orders, 0, Look::Line, |mu| {
            let thetas = (1..=300).map(|i| PI * f64::from(i) / 300.0);
            Ok(thetas.map(|theta| (theta, value(mu, theta))).collect())
        })?;
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: THETA,
            y,
            curves,
            repeats: false,
        })
    };
    let magnitude = Axis::linear("(2 sin θ/2)^μ", "magnitude");
    let stiffness = Axis::linear("cos(μ(π − θ)/2)", "stiffness_coefficient");
    let damping = Axis::linear("sin(μ(π − θ)/2)", "damping_coefficient");
    Ok(Figure {
        id: "3.3",
        title: "coefficients of effective stiffness and damping",
        conditions: "exact operator; orders chosen here".to_owned(),
        columns: 3,
        panels: vec![
            panel("magnitude", magnitude, |mu, theta| {
                (2.0 * (0.5 * theta).sin()).powf(mu)
            })?,
            panel("stiffness", stiffness, |mu, theta| {
                (0.5 * mu * (PI - theta)).cos()
            })?,
            panel("damping", damping, |mu, theta| {
                (0.5 * mu * (PI - theta)).sin()
            })?,
        ],
    })
}

/// Two panels, effective stiffness and damping over frequency, of orders whose looks begin with the `first`.
fn effective(
    (orders, first): (&[f64], usize),
    what: &str,
    (stiffness_axis, damping_axis): (Axis, Axis),
    stiffness: impl Fn(f64) -> Result<Vec<(f64, f64)>, AnalysisError>,
    damping: impl Fn(f64) -> Result<Vec<(f64, f64)>, AnalysisError>,
) -> Result<[Panel; 2], Failure> {
    let panel = |name: &str, y, curves| Panel {
        caption: format!("{name}{what}"),
        x: OMEGA,
        y,
        curves,
        repeats: false,
    };
    let stiffness = per_order(orders, first, Look::Line, stiffness)?;
    let damping = per_order(orders, first, Look::Line, damping)?;
    Ok([
        panel("stiffness", stiffness_axis, stiffness),
        panel("damping", damping_axis, damping),
    ])
}

pub(super) fn environment() -> Result<Figure, Failure> {
    const T: f64 = 1e-3;
    const DISSIPATION: f64 = 100.0;
    let all = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0];
    let points = |mu: f64, value: fn(&haptic_analysis::Effective) -> f64| {
        let environment = Environment {
            stiffness_n_per_m: 10_000.0,
            dissipation_n_s_mu_per_m: DISSIPATION,
            order: Order::new(mu)?,
            sample_time_s: T,
        };
        let operator = Kind::Exact.operator(mu)?;
        logarithmic(10.0, PI / T, 200)
            .map(|omega| {
                let at = environment.effective(&operator, omega.min(PI / T))?;
                Ok((omega, value(&at)))
            })
            .collect()
    };
    // Rows, because the terms of the higher orders are larger by decades. Up to order 1 the stiffness is positive,
    // so that a logarithmic axis tells the orders apart; the damping of order 0 is 0, which is not to lie on the
    // frame.
    let stiffness = Axis::log(STIFFNESS.label, STIFFNESS.column);
    let damping = DAMPING.between(-0.05 * DISSIPATION, 1.05 * DISSIPATION);
    let mut panels = Vec::new();
    for (places, what, axes) in [
        (0..5, ", μ ≤ 1", (stiffness, damping)),
        (5..7, ", μ = 1.25 and 1.5", (STIFFNESS, DAMPING)),
        (7..9, ", μ = 1.75 and 2", (STIFFNESS, DAMPING)),
    ] {
        panels.extend(effective(
            (&all[places.clone()], places.start),
            what,
            axes,
            |mu| points(mu, |at| at.stiffness_n_per_m),
            |mu| points(mu, |at| at.damping_n_s_per_m),
        )?);
    }
    Ok(Figure {
        id: "3.4",
        title: "effective stiffness and damping of the environment",
        conditions: "K = 10 N/mm, B = 0.1 N·s^μ/mm, T = 1 ms; exact operator".to_owned(),
        columns: 2,
        panels,
    })
}

pub(super) fn sensitivity() -> Result<Figure, Failure> {
    let (alpha, beta) = SENSITIVITY_WALL;
    let panel = |kind: Kind, caption: &str| {
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: Axis::log("digital frequency θ / rad", "theta_rad"),
            y: Axis::linear("|S| / dB", "sensitivity_db"),
            curves: per_order(&ORDERS, 0, Look::Line, |mu| {
                let operator = kind.operator(mu)?;
                let wall = Nondimensional {
                    alpha,
                    beta,
                    delta: DELTA,
                    gamma: 0.0,
                };
                let sampled = SampledLoop::new(wall, &operator, 0)?;
                let thetas = logarithmic(0.01, PI, 400).map(|theta| theta.min(PI));
                Ok(thetas
                    .map(|theta| (theta, 20.0 * sampled.sensitivity(theta).log10()))
                    .collect())
            })?,
            repeats: false,
        })
    };
    Ok(Figure {
        id: "4.5",
        title: "sensitivity |1/(1 + GH)|",
        conditions: format!("α = {alpha}, β = {beta} (our choice), δ = {DELTA:.5}, no hand"),
        columns: 2,
        panels: vec![
            panel(Kind::Muir, "with A₃")?,
            panel(Kind::Exact, "with the exact operator")?,
        ],
    })
}

pub(super) fn transparency() -> Result<Figure, Failure> {
    const T: f64 = 1e-3;
    let points = |mu: f64, value: fn(&haptic_analysis::Effective) -> f64| {
        let order = Order::new(mu)?;
        let closed = ClosedLoop {
            mass_kg: 0.65,
            damping_n_s_per_m: DAMPING_N_S_PER_M,
            environment: Environment {
                stiffness_n_per_m: 50.0,
                dissipation_n_s_mu_per_m: 1.0,
                order,
                sample_time_s: T,
            },
            path: ForcePath::NONE,
        };
        logarithmic(0.1, 30.0, 200)
            .map(|omega| Ok((omega, value(&closed.continuous(omega)?))))
            .collect()
    };
    Ok(Figure {
        id: "6.2",
        title: "effective stiffness and damping at the hand",
        conditions:
            "m = 0.65 kg, b = 3.5 N·s/m, K = 50 N/m, B = 1 N·s^μ/m; T = 1 ms (our choice)\n\
                     continuous s^μ, signs as in the text"
                .to_owned(),
        columns: 2,
        panels: effective(
            (&ORDERS, 0),
            "",
            (STIFFNESS, DAMPING),
            |mu| points(mu, |at| at.stiffness_n_per_m),
            |mu| points(mu, |at| at.damping_n_s_per_m),
        )?
        .into(),
    })
}
