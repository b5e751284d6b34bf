//! The figures of the dissertation, as data and picture.

use super::evidence::{SENSITIVITY_WALL, passive_boundary};
use super::figure::{Axis, Curve, Figure, Panel, per_order, share_axes};
use super::relaxation::relax;
use super::walls::{ALPHA, BETA, border, region_matrix, regions};
use super::{DAMPING_N_S_PER_M, DELTA, Kind, ORDERS, SAMPLE_TIME_S};
use fracdiff::{Order, Seconds};
use haptic_analysis::{AnalysisError, ClosedLoop, Environment, Nondimensional, SampledLoop};
use haptic_experiment::Failure;
use haptic_experiment::{Imperfections, TrialPlan, ZWidth, dissertation_device};
use haptic_figure::{Look, Scale};
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

type Make = fn(&AtomicBool) -> Result<Figure, Failure>;

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
    |_| relaxation(),
];

/// `count` values from `low` to `high` in equal steps of their logarithm.
fn logarithmic(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    let ratio = (high / low).ln() / f64::from(count - 1);
    (0..count).map(move |i| low * (ratio * f64::from(i)).exp())
}

fn coefficients() -> Result<Figure, Failure> {
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

const OMEGA: Axis = Axis::log("frequency ω / rad·s⁻¹", "omega_rad_s");
const STIFFNESS: Axis = Axis::linear("effective stiffness / N·m⁻¹", "effective_stiffness_n_per_m");
const DAMPING: Axis = Axis::linear("effective damping / N·s·m⁻¹", "effective_damping_n_s_per_m");

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

fn environment() -> Result<Figure, Failure> {
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

fn zwidth(stop: &AtomicBool) -> Result<Figure, Failure> {
    let panel = |caption: &str, realistic: bool| {
        let imperfections = if realistic {
            Imperfections::realistic(SAMPLE_TIME_S)
        } else {
            Imperfections::NONE
        };
        let orders = ORDERS.map(Order::new).into_iter().collect::<Result<_, _>>();
        let experiment = ZWidth {
            device: imperfections.on(dissertation_device(Seconds(SAMPLE_TIME_S))),
            sensors: imperfections.sensors,
            one_sided: false,
            scheme: Kind::Muir.scheme(),
            orders: orders.map_err(Failure::input)?,
            points: 21,
            plan: TrialPlan::DISSERTATION,
            remote: None,
        };
        let report = experiment.run(&|_| {}, stop, &|_| {})?;
        let mut curves = per_order(&ORDERS, 0, Look::Line, |mu| {
            border(Kind::Muir, mu, DELTA, 0.0)
        })?;
        for (colour, order) in report.orders.iter().enumerate() {
            curves.push(Curve {
                name: format!("simulated, μ = {}", order.order),
                // One entry with the line of theory.
                legend: format!("μ = {}", order.order),
                points: order.boundary.iter().map(|p| (p.beta, p.alpha)).collect(),
                look: Look::MarkersApart,
                colour,
            });
        }
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: BETA,
            y: ALPHA,
            curves,
            repeats: false,
        })
    };
    let mut panels = vec![
        panel("ideal device", false)?,
        panel("realistic device", true)?,
    ];
    share_axes(&mut panels);
    // The part of the plane that the realistic device reaches, enlarged.
    let simulated = |panel: &Panel| {
        let curves = panel.curves.iter().cloned();
        let curves = curves.filter(|curve| curve.look == Look::MarkersApart);
        Panel {
            curves: curves.collect(),
            ..panel.clone()
        }
    };
    let mut reach = [simulated(&panels[1])];
    share_axes(&mut reach);
    let enlarged = |panel: &Panel| Panel {
        caption: format!("{}, enlarged", panel.caption),
        x: reach[0].x,
        y: reach[0].y,
        repeats: true,
        ..panel.clone()
    };
    let enlarged: Vec<Panel> = panels.iter().map(enlarged).collect();
    panels.extend(enlarged);
    Ok(Figure {
        id: "4.3",
        title: "largest stable stiffness, simulated, over theory",
        conditions: "A₃; markers: simulated, 1 N for 5 s, stable if within 0.1 mm rms over the last 0.4 s; lines: \
                     theory of the ideal device\n\
                     realistic (our choice): 1 µm encoder, 0.05 N friction, 1 ms delay, 1 ms current lag; markers \
                     that would cover others are left out"
            .to_owned(),
        columns: 2,
        panels,
    })
}

fn sensitivity() -> Result<Figure, Failure> {
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

fn passivity() -> Result<Figure, Failure> {
    let panel = |kind: Kind, caption: &str| {
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: BETA,
            y: ALPHA,
            curves: per_order(&ORDERS, 0, Look::Line, |mu| {
                passive_boundary(kind, mu, DELTA, 100)
            })?,
            repeats: false,
        })
    };
    Ok(Figure {
        id: "5.1",
        title: "passive walls for five orders",
        conditions: format!("δ = {DELTA:.5} (the device of section 4.4; our choice)"),
        columns: 2,
        panels: vec![
            panel(Kind::Muir, "with A₃, Theorem 1")?,
            panel(Kind::Exact, "with the exact operator, = Corollary 1")?,
        ],
    })
}

fn transparency() -> Result<Figure, Failure> {
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
            delay_samples: 0,
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

fn relaxation() -> Result<Figure, Failure> {
    let exact = relax(Kind::Exact)?;
    let muir = relax(Kind::Muir)?;
    // Points at equal steps of log t: what a picture can show of 200 001 samples.
    let last = exact.time_s.len() - 1;
    let mut picked: Vec<usize> = logarithmic(1.0, last as f64, 600)
        .map(|n| (n.round() as usize).min(last))
        .collect();
    picked.dedup();
    let curve = |name: &str, values: &[f64], look, colour| Curve {
        name: name.to_owned(),
        legend: name.to_owned(),
        points: picked
            .iter()
            .map(|&n| (exact.time_s[n], values[n]))
            .collect(),
        look,
        colour,
    };
    let curves = vec![
        curve("tissue, closed form", &exact.theory_n, Look::Broad, 3),
        curve("simulated, full memory", &exact.force_n, Look::Line, 0),
        curve("simulated, A₃", &muir.force_n, Look::Line, 2),
    ];
    let panel = |caption: &str, scale| Panel {
        caption: caption.to_owned(),
        x: Axis {
            scale,
            ..Axis::linear("time / s", "time_s")
        },
        y: Axis {
            scale,
            ..Axis::linear("force / N", "force_n")
        },
        curves: curves.clone(),
        repeats: scale == Scale::Log,
    };
    Ok(Figure {
        id: "7.2",
        title: "stress relaxation of the cancerous prostate",
        conditions:
            "5 % of 20 mm in 1 s, 4 cm², 1 kHz (our choices); simulated rig with compliant contact"
                .to_owned(),
        columns: 2,
        panels: vec![panel("linear", Scale::Linear), panel("log–log", Scale::Log)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
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
