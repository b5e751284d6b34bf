//! Figures 4.1, 4.4 and 5.1: which walls are stable, which are passive.

use super::evidence::passivity::passive_boundary;
use super::evidence::region::region;
use super::evidence::robustness::varied;
use super::figure::{Axis, Curve, Figure, Panel, per_order, refused, share_axes};
use super::{DELTA, Kind, ORDERS};
use haptic_analysis::AnalysisError;
use haptic_experiment::Failure;
use haptic_figure::Look;

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

/// The border of a region as β, α, without what runs along the axes; closed if it does so more than once.
pub(super) fn border(
    kind: Kind,
    mu: f64,
    delta: f64,
    gamma: f64,
) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let ring = outline(kind, mu, delta, gamma)?;
    let (beta, alpha) = ring
        .iter()
        .fold((0.0, 0.0), |(beta, alpha): (f64, f64), p| {
            (beta.max(p.0), alpha.max(p.1))
        });
    // Corners are computed, so they are not 0 to the last digit.
    let on_axis = |from: (f64, f64), to: (f64, f64)| {
        from.0.max(to.0) < 1e-9 * beta || from.1.max(to.1) < 1e-9 * alpha
    };
    let sides = ring.len().saturating_sub(1);
    let hidden: Vec<bool> = (0..sides).map(|i| on_axis(ring[i], ring[i + 1])).collect();
    let begins = |i: &usize| !hidden[*i] && hidden[(*i + sides - 1) % sides];
    let starts: Vec<usize> = (0..sides).filter(begins).collect();
    let [start] = starts[..] else {
        return Ok(ring);
    };
    let seen = (0..sides)
        .map(|i| (start + i) % sides)
        .take_while(|&i| !hidden[i]);
    let mut border = vec![ring[start]];
    border.extend(seen.map(|i| ring[i + 1]));
    Ok(border)
}

pub(super) const BETA: Axis = Axis::linear("dissipation β = BT^{2−μ}/m", "beta");
pub(super) const ALPHA: Axis = Axis::linear("stiffness α = KT²/m", "alpha");

pub(super) fn regions() -> Result<Figure, Failure> {
    let panel = |kind: Kind, caption: &str| {
        Ok::<_, Failure>(Panel {
            caption: caption.to_owned(),
            x: BETA,
            y: ALPHA,
            curves: per_order(&ORDERS, 0, Look::Area, |mu| outline(kind, mu, DELTA, 0.0))?,
            repeats: false,
        })
    };
    let mut panels = vec![
        panel(Kind::Muir, "with A₃, as in the dissertation")?,
        panel(Kind::Exact, "with the exact operator")?,
    ];
    share_axes(&mut panels);
    Ok(Figure {
        id: "4.1",
        title: "stable walls for five orders",
        conditions: format!("m = 65 g, b = 3.5 N·s/m, T = 2 ms (δ = {DELTA:.5}), no hand"),
        columns: 2,
        panels,
    })
}

pub(super) fn region_matrix() -> Result<Figure, Failure> {
    let mut panels = Vec::new();
    for mu in ORDERS {
        let column = |what: &str, at: fn(f64) -> (f64, f64)| {
            let curve = |(factor, look, colour): (f64, Look, usize)| {
                let (delta, gamma) = at(factor);
                Ok(Curve {
                    name: format!("value × {factor}"),
                    legend: format!("value × {factor}"),
                    points: border(Kind::Muir, mu, delta, gamma).map_err(refused)?,
                    look,
                    colour,
                })
            };
            // The curves of k nearly agree, so one lies broad and light beneath the others.
            let factors = [
                (0.5, Look::Broad, 6),
                (1.0, Look::Line, 0),
                (2.0, Look::Dotted, 1),
            ];
            Ok::<_, Failure>(Panel {
                caption: format!("μ = {mu}, {what}"),
                x: Axis {
                    label: "β", ..BETA
                },
                y: Axis {
                    label: "α",
                    ..ALPHA
                },
                curves: factors
                    .into_iter()
                    .map(curve)
                    .collect::<Result<_, Failure>>()?,
                repeats: false,
            })
        };
        let mut row = [
            column("T", |factor| varied(factor, 1.0, 1.0))?,
            column("b", |factor| varied(1.0, factor, 1.0))?,
            column("k", |factor| varied(1.0, 1.0, factor))?,
        ];
        share_axes(&mut row);
        panels.extend(row);
    }
    Ok(Figure {
        id: "4.4",
        title: "effect of sample time T, damping b and hand stiffness k",
        conditions: "A₃; T = 2 ms, b = 3.5 N·s/m, k = 500 N/m (our choice), one of them halved and doubled\n\
                     α = KT²/m and β = BT^{2−μ}/m with the varied T"
            .to_owned(),
        columns: 3,
        panels,
    })
}

pub(super) fn passivity() -> Result<Figure, Failure> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_that_are_compared_have_the_same_axes() {
        let axes = |panel: &Panel| (panel.x.range.expect("given"), panel.y.range.expect("given"));
        for (figure, row) in [(regions(), 2), (region_matrix(), 3)] {
            let panels = figure.expect("makes").panels;
            for row in panels.chunks(row) {
                assert!(row.iter().all(|panel| axes(panel) == axes(&row[0])));
                let ((_, beta), (_, alpha)) = axes(&row[0]);
                let points = row.iter().flat_map(|panel| &panel.curves);
                let mut points = points.flat_map(|curve| &curve.points);
                assert!(
                    points.all(|point| point.0 < beta && point.1 < alpha),
                    "nothing is cut off"
                );
            }
        }
    }

    #[test]
    fn a_border_leaves_out_what_runs_along_the_axes() {
        for mu in ORDERS {
            for kind in Kind::BOTH {
                let ring = outline(kind, mu, DELTA, 0.0).expect("bounded");
                let border = border(kind, mu, DELTA, 0.0).expect("bounded");
                assert!(border.len() > 1 && border.len() < ring.len(), "μ {mu}");
                assert!(border.iter().all(|point| ring.contains(point)), "μ {mu}");
                let on_axis =
                    |from: (f64, f64), to: (f64, f64)| from.0 + to.0 < 1e-9 || from.1 + to.1 < 1e-9;
                assert!(
                    !border.windows(2).any(|side| on_axis(side[0], side[1])),
                    "μ {mu}"
                );
            }
        }
    }
}
