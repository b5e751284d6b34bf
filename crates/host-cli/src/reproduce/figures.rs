//! The figures of the dissertation, as data and picture.

use super::evidence::{SENSITIVITY_WALL, passive_boundary, region};
use super::relaxation::relax;
use super::{DAMPING_N_S_PER_M, DELTA, Kind, MASS_KG, ORDERS, SAMPLE_TIME_S};
use crate::experiment::{Imperfections, TrialPlan, ZWidth, dissertation_device};
use crate::failure::Failure;
use crate::figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use fracdiff::{Order, Seconds};
use haptic_analysis::{AnalysisError, ClosedLoop, Environment, Nondimensional, SampledLoop};
use serde::Serialize;
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

/// A curve of a figure.
#[derive(Clone, Debug)]
pub struct Curve {
    /// For the data.
    pub name: String,
    /// For the legend; empty for none.
    pub legend: String,
    /// x, y.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub look: Look,
    /// Which colour.
    pub colour: usize,
}

/// A panel of a figure.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Above it.
    pub caption: String,
    /// Label and scale of the horizontal axis.
    pub x: (&'static str, Scale),
    /// Of the vertical one.
    pub y: (&'static str, Scale),
    /// Its curves.
    pub curves: Vec<Curve>,
}

/// A figure of the dissertation, made again.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Its number there.
    pub id: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Parameters, and which of them are our choice.
    pub conditions: String,
    /// Panels side by side.
    pub columns: usize,
    /// The panels.
    pub panels: Vec<Panel>,
}

/// A row of a figure's CSV.
#[derive(Debug, Serialize)]
pub struct Row<'a> {
    panel: &'a str,
    curve: &'a str,
    x: f64,
    y: f64,
}

impl Figure {
    /// The picture.
    ///
    /// # Errors
    /// If no curve has a point.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        let charts = self.panels.iter().map(|panel| Chart {
            caption: &panel.caption,
            x: AxisSpec::new(panel.x.0, panel.x.1),
            y: AxisSpec::new(panel.y.0, panel.y.1),
            series: panel
                .curves
                .iter()
                .map(|curve| Series::new(&curve.legend, &curve.points, curve.look, curve.colour))
                .collect(),
        });
        ChartPage {
            title: &format!("Figure {}: {}", self.id, self.title),
            subtitle: &self.conditions,
            columns: self.columns,
            charts: charts.collect(),
        }
        .draw()
    }

    /// The data.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.panels.iter().flat_map(|panel| {
            panel.curves.iter().flat_map(|curve| {
                curve.points.iter().map(|&(x, y)| Row {
                    panel: &panel.caption,
                    curve: &curve.name,
                    x,
                    // Not −0.
                    y: y + 0.0,
                })
            })
        })
    }
}

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

fn refused(error: AnalysisError) -> Failure {
    Failure::Run(error.into())
}

/// One curve an order.
fn per_order(
    orders: &[f64],
    look: Look,
    points: impl Fn(f64) -> Result<Vec<(f64, f64)>, AnalysisError>,
) -> Result<Vec<Curve>, Failure> {
    orders
        .iter()
        .enumerate()
        .map(|(colour, &mu)| {
            Ok(Curve {
                name: format!("μ = {mu}"),
                legend: format!("μ = {mu}"),
                points: points(mu).map_err(refused)?,
                look,
                colour,
            })
        })
        .collect()
}

/// `count` values from `low` to `high` in equal steps of their logarithm.
fn logarithmic(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    let ratio = (high / low).ln() / f64::from(count - 1);
    (0..count).map(move |i| low * (ratio * f64::from(i)).exp())
}

fn coefficients() -> Result<Figure, Failure> {
    const THETA: (&str, Scale) = ("digital frequency θ / rad", Scale::Linear);
    let orders = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0];
    let panel = |caption: &str, label, value: fn(f64, f64) -> f64| {
        let curves = per_order(&orders, Look::Line, |mu| {
            let thetas = (1..=300).map(|i| PI * f64::from(i) / 300.0);
            Ok(thetas.map(|theta| (theta, value(mu, theta))).collect())
        })?;
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: THETA,
            y: (label, Scale::Linear),
            curves,
        })
    };
    Ok(Figure {
        id: "3.3",
        title: "coefficients of effective stiffness and damping",
        conditions: "exact operator; orders chosen here".to_owned(),
        columns: 3,
        panels: vec![
            panel("magnitude", "(2 sin θ/2)^μ", |mu, theta| {
                (2.0 * (0.5 * theta).sin()).powf(mu)
            })?,
            panel("stiffness", "cos(μ(π − θ)/2)", |mu, theta| {
                (0.5 * mu * (PI - theta)).cos()
            })?,
            panel("damping", "sin(μ(π − θ)/2)", |mu, theta| {
                (0.5 * mu * (PI - theta)).sin()
            })?,
        ],
    })
}

/// Two panels, effective stiffness and damping over frequency.
fn effective(
    orders: &[f64],
    what: &str,
    stiffness: impl Fn(f64) -> Result<Vec<(f64, f64)>, AnalysisError>,
    damping: impl Fn(f64) -> Result<Vec<(f64, f64)>, AnalysisError>,
) -> Result<[Panel; 2], Failure> {
    const OMEGA: (&str, Scale) = ("frequency ω / rad·s⁻¹", Scale::Log);
    Ok([
        Panel {
            caption: format!("stiffness{what}"),
            x: OMEGA,
            y: ("effective stiffness / N·m⁻¹", Scale::Linear),
            curves: per_order(orders, Look::Line, stiffness)?,
        },
        Panel {
            caption: format!("damping{what}"),
            x: OMEGA,
            y: ("effective damping / N·s·m⁻¹", Scale::Linear),
            curves: per_order(orders, Look::Line, damping)?,
        },
    ])
}

fn environment() -> Result<Figure, Failure> {
    const T: f64 = 1e-3;
    let points = |mu: f64, value: fn(&haptic_analysis::Effective) -> f64| {
        let environment = Environment {
            stiffness_n_per_m: 10_000.0,
            dissipation_n_s_mu_per_m: 100.0,
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
    // Two rows, because the terms of the higher orders are larger by decades.
    let mut panels = Vec::new();
    for (orders, what) in [
        (&[0.0, 0.25, 0.5, 0.75, 1.0][..], ", μ ≤ 1"),
        (&[1.25, 1.5, 1.75][..], ", μ > 1"),
        (&[2.0][..], ", μ = 2"),
    ] {
        panels.extend(effective(
            orders,
            what,
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

/// The outline of a region as β, α; closed.
fn outline(kind: Kind, mu: f64, delta: f64, gamma: f64) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let Some(area) = region(kind, mu, delta, gamma, 400)? else {
        return Ok(Vec::new());
    };
    let Some(polygon) = area.polygons.first() else {
        return Ok(Vec::new());
    };
    let closed = polygon.points.iter().chain(polygon.points.first());
    Ok(closed.map(|p| (p.beta, p.alpha)).collect())
}

const BETA: (&str, Scale) = ("dissipation β = BT^{2−μ}/m", Scale::Linear);
const ALPHA: (&str, Scale) = ("stiffness α = KT²/m", Scale::Linear);

fn regions() -> Result<Figure, Failure> {
    let panel = |kind: Kind, caption: &str| {
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: BETA,
            y: ALPHA,
            curves: per_order(&ORDERS, Look::Area, |mu| outline(kind, mu, DELTA, 0.0))?,
        })
    };
    Ok(Figure {
        id: "4.1",
        title: "stable walls for five orders",
        conditions: format!("m = 65 g, b = 3.5 N·s/m, T = 2 ms (δ = {DELTA:.5}), no hand"),
        columns: 2,
        panels: vec![
            panel(Kind::Muir, "with A₃, as in the dissertation")?,
            panel(Kind::Exact, "with the exact operator")?,
        ],
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
        let report = experiment.run(&|_| {}, stop)?;
        let mut curves = per_order(&ORDERS, Look::Line, |mu| {
            outline(Kind::Muir, mu, DELTA, 0.0)
        })?;
        for (colour, order) in report.orders.iter().enumerate() {
            curves.push(Curve {
                name: format!("simulated, μ = {}", order.order),
                legend: if colour == 0 { "simulated" } else { "" }.to_owned(),
                points: order.boundary.iter().map(|p| (p.beta, p.alpha)).collect(),
                look: Look::Markers,
                colour,
            });
        }
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: BETA,
            y: ALPHA,
            curves,
        })
    };
    Ok(Figure {
        id: "4.3",
        title: "Z-width by experiment on the simulated device, over theory",
        conditions: "A₃; 1 N for 5 s, 0.1 mm in the last 0.4 s; realistic (our choice): 1 µm encoder, 0.05 N friction, \
                     1 ms delay, 1 ms current lag"
            .to_owned(),
        columns: 2,
        panels: vec![panel("ideal device", false)?, panel("realistic device", true)?],
    })
}

fn region_matrix() -> Result<Figure, Failure> {
    let mut panels = Vec::new();
    for mu in ORDERS {
        // `stretch` is T over the T of the axes: the same wall has α and β of T² and T^(2−μ).
        let mut column =
            |what: &str, values: [(f64, f64, f64, f64); 3]| -> Result<(), Failure> {
                let curves = values.into_iter().enumerate().map(
                    |(colour, (factor, delta, gamma, stretch))| {
                        let points = outline(Kind::Muir, mu, delta, gamma).map_err(refused)?;
                        let scaled = points.into_iter().map(|(beta, alpha)| {
                            (beta / stretch.powf(2.0 - mu), alpha / stretch.powi(2))
                        });
                        Ok(Curve {
                            name: format!("value × {factor}"),
                            legend: format!("value × {factor}"),
                            points: scaled.collect(),
                            look: Look::Area,
                            colour,
                        })
                    },
                );
                panels.push(Panel {
                    caption: format!("μ = {mu}, {what}"),
                    x: ("β", Scale::Linear),
                    y: ("α", Scale::Linear),
                    curves: curves.collect::<Result<_, Failure>>()?,
                });
                Ok(())
            };
        column("T", [0.5, 1.0, 2.0].map(|f| (f, f * DELTA, 0.0, f)))?;
        column("b", [0.5, 1.0, 2.0].map(|f| (f, f * DELTA, 0.0, 1.0)))?;
        let gamma = 500.0 * SAMPLE_TIME_S * SAMPLE_TIME_S / MASS_KG;
        column("k", [0.5, 1.0, 2.0].map(|f| (f, DELTA, f * gamma, 1.0)))?;
    }
    Ok(Figure {
        id: "4.4",
        title: "effect of sample time T, damping b and hand stiffness k",
        conditions:
            "A₃; T = 2 ms, b = 3.5 N·s/m, k = 500 N/m (our choice) halved and doubled; α, β of 2 ms"
                .to_owned(),
        columns: 3,
        panels,
    })
}

fn sensitivity() -> Result<Figure, Failure> {
    let (alpha, beta) = SENSITIVITY_WALL;
    let panel = |kind: Kind, caption: &str| {
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: ("digital frequency θ / rad", Scale::Log),
            y: ("|S| / dB", Scale::Linear),
            curves: per_order(&ORDERS, Look::Line, |mu| {
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
            curves: per_order(&ORDERS, Look::Line, |mu| {
                passive_boundary(kind, mu, DELTA, 100)
            })?,
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
        conditions: "m = 0.65 kg, b = 3.5 N·s/m, K = 50 N/m, B = 1 N·s^μ/m; T = 1 ms (our choice); continuous s^μ, signs as in the text"
            .to_owned(),
        columns: 2,
        panels: effective(
            &ORDERS,
            "",
            |mu| points(mu, |at| at.stiffness_n_per_m),
            |mu| points(mu, |at| at.damping_n_s_per_m),
        )?
        .into(),
    })
}

fn relaxation() -> Result<Figure, Failure> {
    let exact = relax(Kind::Exact).map_err(refused)?;
    let muir = relax(Kind::Muir).map_err(refused)?;
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
        curve("tissue, closed form", &exact.theory_n, Look::Line, 0),
        curve("rendered, full memory", &exact.force_n, Look::Dashed, 1),
        curve("rendered, A₃", &muir.force_n, Look::Line, 2),
    ];
    let panel = |caption: &str, scale| Panel {
        caption: caption.to_owned(),
        x: ("time / s", scale),
        y: ("force / N", scale),
        curves: curves.clone(),
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
