//! The figures of the dissertation: those of frequencies (3.3, 3.4, 4.5, 6.2), and the list of all.

use super::evidence::SENSITIVITY_WALL;
use super::figure::{Axis, Figure, Panel, logarithmic, per_order};
use super::relaxation::relaxation;
use super::walls::{passivity, region_matrix, regions, zwidth};
use super::{DAMPING_N_S_PER_M, DELTA, Kind, ORDERS};
use fracdiff::Order;
use haptic_analysis::{
    AnalysisError, ClosedLoop, Effective, ForcePath, Nondimensional, SampledLoop, SampledWall,
};
use haptic_experiment::Failure;
use haptic_figure::Look;
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

type Make = fn(&Arc<AtomicBool>) -> Result<Figure, Failure>;

/// All figures, in order, each with what makes it. A flag that is set while one is made cuts it short.
pub const FIGURES: [Make; 9] = [
    |_| coefficients(),
    |_| environment(),
    |_| regions(),
    zwidth,
    |_| region_matrix(),
    |_| sensitivity(),
    |_| passivity(),
    |_| transparency(),
    relaxation,
];

const OMEGA: Axis = Axis::log("frequency ω / rad·s⁻¹", "omega_rad_s");
const STIFFNESS: Axis = Axis::linear("effective stiffness / N·m⁻¹", "effective_stiffness_n_per_m");
const DAMPING: Axis = Axis::linear("effective damping / N·s·m⁻¹", "effective_damping_n_s_per_m");

fn coefficients() -> Result<Figure, Failure> {
    const THETA: Axis = Axis::linear("digital frequency θ / rad", "theta_rad");
    let orders = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0];
    let panel = |caption: &str, y, value: fn(f64, f64) -> f64| {
        let curves = per_order(&orders, 0, Look::Line, |mu| {
            let thetas = (1..=300).map(|i| PI * f64::from(i) / 300.0);
            Ok(thetas.map(|theta| (theta, value(mu, theta))).collect())
        })?;
        Ok::<_, Failure>(Panel::new(caption, THETA, y, curves))
    };
    let magnitude = Axis::linear("(2 sin θ/2)^μ", "magnitude");
    let stiffness = Axis::linear("cos(μ(π − θ)/2)", "stiffness_coefficient");
    let damping = Axis::linear("sin(μ(π − θ)/2)", "damping_coefficient");
    Ok(Figure {
        id: "3.3",
        title: "coefficients of effective stiffness and damping",
        conditions: "(1 − w)^μ; orders chosen here".to_owned(),
        columns: 3,
        panels: vec![
            panel("magnitude", magnitude, |mu, theta| {
                libm::pow(2.0 * libm::sin(0.5 * theta), mu)
            })?,
            panel("stiffness", stiffness, |mu, theta| {
                libm::cos(0.5 * mu * (PI - theta))
            })?,
            panel("damping", damping, |mu, theta| {
                libm::sin(0.5 * mu * (PI - theta))
            })?,
        ],
    })
}

type Value = fn(&Effective) -> f64;

/// Two panels, effective stiffness and damping over frequency, of orders whose looks begin with the `first`.
fn effective(
    orders: &[f64],
    first: usize,
    what: &str,
    [stiffness_axis, damping_axis]: [Axis; 2],
    points: impl Fn(f64, Value) -> Result<Vec<(f64, f64)>, AnalysisError>,
) -> Result<[Panel; 2], Failure> {
    let panel = |name: &str, y, value: Value| {
        let curves = per_order(orders, first, Look::Line, |mu| points(mu, value))?;
        Ok::<_, Failure>(Panel::new(format!("{name}{what}"), OMEGA, y, curves))
    };
    Ok([
        panel("stiffness", stiffness_axis, |at| at.stiffness_n_per_m)?,
        panel("damping", damping_axis, |at| at.damping_n_s_per_m)?,
    ])
}

fn environment() -> Result<Figure, Failure> {
    const T: f64 = 1e-3;
    const DISSIPATION: f64 = 100.0;
    let all = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0];
    let points = |mu: f64, value: Value| {
        let environment = SampledWall {
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
    let stiffness = Axis::log(STIFFNESS.spec.label, STIFFNESS.column);
    let damping = DAMPING.between(-0.05 * DISSIPATION, 1.05 * DISSIPATION);
    let mut panels = Vec::new();
    for (places, what, axes) in [
        (0..5, ", μ ≤ 1", [stiffness, damping]),
        (5..7, ", μ = 1.25 and 1.5", [STIFFNESS, DAMPING]),
        (7..9, ", μ = 1.75 and 2", [STIFFNESS, DAMPING]),
    ] {
        let first = places.start;
        panels.extend(effective(&all[places], first, what, axes, points)?);
    }
    Ok(Figure {
        id: "3.4",
        title: "effective stiffness and damping of the environment",
        conditions: "K = 10 N/mm, B = 0.1 N·s^μ/mm, T = 1 ms; (1 − w)^μ".to_owned(),
        columns: 2,
        panels,
    })
}

fn sensitivity() -> Result<Figure, Failure> {
    const THETA: Axis = Axis::log("digital frequency θ / rad", "theta_rad");
    const DECIBEL: Axis = Axis::linear("|S| / dB", "sensitivity_db");
    let Nondimensional { alpha, beta, .. } = SENSITIVITY_WALL;
    let panel = |kind: Kind, caption: &str| {
        let curves = per_order(&ORDERS, 0, Look::Line, |mu| {
            let operator = kind.operator(mu)?;
            let sampled = SampledLoop::new(SENSITIVITY_WALL, &operator, 0)?;
            let thetas = logarithmic(0.01, PI, 400).map(|theta| theta.min(PI));
            Ok(thetas
                .map(|theta| (theta, 20.0 * libm::log10(sampled.sensitivity(theta))))
                .collect())
        })?;
        Ok::<_, Failure>(Panel::new(caption, THETA, DECIBEL, curves))
    };
    Ok(Figure {
        id: "4.5",
        title: "sensitivity |1/(1 + GH)|",
        conditions: format!("α = {alpha}, β = {beta} (our choice), δ = {DELTA:.5}, no hand"),
        columns: 2,
        panels: vec![
            panel(Kind::Muir, "with A₃, as in the chapter")?,
            panel(Kind::Exact, "with (1 − w)^μ")?,
        ],
    })
}

fn transparency() -> Result<Figure, Failure> {
    const T: f64 = 1e-3;
    let points = |mu: f64, value: Value| {
        let order = Order::new(mu)?;
        let closed = ClosedLoop {
            mass_kg: 0.65,
            damping_n_s_per_m: DAMPING_N_S_PER_M,
            environment: SampledWall {
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
                     continuous s^μ, signs and b as in the text; (6.1) prints the stiffness with opposite signs, the caption b in N·s/mm"
                .to_owned(),
        columns: 2,
        panels: effective(&ORDERS, 0, "", [STIFFNESS, DAMPING], points)?.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Panel;
    use std::collections::BTreeMap;

    #[test]
    fn each_order_of_a_figure_has_a_look_of_its_own() {
        for make in [
            coefficients,
            environment,
            sensitivity,
            passivity,
            transparency,
        ] {
            let figure = make().expect("makes");
            let curves = figure.panels.iter().flat_map(|panel| &panel.curves);
            let mut looks: BTreeMap<&str, usize> = BTreeMap::new();
            for curve in curves {
                let colour = *looks.entry(&curve.name).or_insert(curve.colour);
                assert_eq!(colour, curve.colour, "{} of {}", curve.name, figure.id);
            }
            let colours: std::collections::BTreeSet<usize> = looks.values().copied().collect();
            assert_eq!(colours.len(), looks.len(), "figure {}", figure.id);
        }
    }

    #[test]
    fn the_data_of_a_figure_have_a_column_for_each_quantity() {
        let figure = environment().expect("makes");
        let columns = figure.columns();
        assert_eq!(
            columns[2..],
            [
                "omega_rad_s",
                "effective_stiffness_n_per_m",
                "effective_damping_n_s_per_m"
            ]
        );
        for (panel, _, cells) in figure.rows() {
            let filled: Vec<bool> = cells.iter().map(Option::is_some).collect();
            assert_eq!(
                filled,
                [
                    true,
                    panel.starts_with("stiffness"),
                    panel.starts_with("damping")
                ]
            );
        }
        // 7.2 shows the same curves twice and holds them once.
        let figure = Figure {
            panels: vec![
                Panel {
                    repeats: true,
                    ..figure.panels[0].clone()
                },
                figure.panels[1].clone(),
            ],
            ..figure
        };
        assert!(
            figure
                .rows()
                .all(|(panel, _, _)| panel.starts_with("damping"))
        );
    }
}
