//! Figures 4.1, 4.3, 4.4 and 5.1: which walls are stable, in theory and simulated, and which are passive.

use super::evidence::{passive_boundary, region, varied};
use super::figure::{Axis, Curve, Figure, Panel, per_order, refused, share_axes};
use super::trial::{realistic, simulated};
use super::{DELTA, Kind, ORDERS};
use haptic_analysis::AnalysisError;
use haptic_experiment::Failure;
use haptic_figure::Look;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The outline of a region as β, α; closed.
fn outline(kind: Kind, mu: f64, delta: f64, gamma: f64) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let area = region(kind, mu, delta, gamma, 400)?;
    let polygon = area.as_ref().and_then(|area| area.polygons.first());
    let points = polygon.map_or(&[][..], |polygon| &polygon.points);
    let closed = points.iter().chain(points.first());
    Ok(closed.map(|p| (p.beta, p.alpha)).collect())
}

/// The border of a region as β, α, without what runs along the axes; closed if it does so more than once.
fn border(kind: Kind, mu: f64, delta: f64, gamma: f64) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let ring = outline(kind, mu, delta, gamma)?;
    let beta = ring.iter().map(|point| point.0).fold(0.0, f64::max);
    let alpha = ring.iter().map(|point| point.1).fold(0.0, f64::max);
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

const BETA: Axis = Axis::linear("dissipation β = BT^{2−μ}/m", "beta");
const ALPHA: Axis = Axis::linear("stiffness α = KT²/m", "alpha");

pub(super) fn regions() -> Result<Figure, Failure> {
    let panel = |kind: Kind, caption: &str| {
        let curves = per_order(&ORDERS, 0, Look::Area, |mu| outline(kind, mu, DELTA, 0.0))?;
        Ok::<_, Failure>(Panel::new(caption, BETA, ALPHA, curves))
    };
    let mut panels = vec![
        panel(Kind::Muir, "with A₃, as in the chapter")?,
        panel(Kind::Exact, "with (1 − w)^μ")?,
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
            let curve = |factor: f64, look, colour| {
                let (delta, gamma) = at(factor);
                let points = border(Kind::Muir, mu, delta, gamma).map_err(refused)?;
                let name = format!("value × {factor}");
                Ok::<_, Failure>(Curve::new(name, points, look, colour))
            };
            // The curves of k nearly agree, so one lies broad and light beneath the others.
            let curves = vec![
                curve(0.5, Look::Broad, 6)?,
                curve(1.0, Look::Line, 0)?,
                curve(2.0, Look::Dotted, 1)?,
            ];
            let [x, y] =
                [("β", BETA), ("α", ALPHA)].map(|(label, axis)| Axis::linear(label, axis.column));
            Ok::<_, Failure>(Panel::new(format!("μ = {mu}, {what}"), x, y, curves))
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
        let boundary = |mu| passive_boundary(kind, mu, DELTA, 100);
        let curves = per_order(&ORDERS, 0, Look::Line, boundary)?;
        Ok::<_, Failure>(Panel::new(caption, BETA, ALPHA, curves))
    };
    Ok(Figure {
        id: "5.1",
        title: "passive walls for five orders",
        conditions: format!(
            "δ = {DELTA:.5} (the device of section 4.4; our choice); Theorem 1\n\
             with A₃ and μ > 1 the lower edge is a rule of ours: beneath it the wall is a negative spring at rest"
        ),
        columns: 2,
        panels: vec![
            panel(Kind::Exact, "with (1 − w)^μ, = Corollary 1")?,
            panel(Kind::Muir, "warning: A₃ of chapter 4 instead")?,
        ],
    })
}

pub(super) fn zwidth(stop: &Arc<AtomicBool>) -> Result<Figure, Failure> {
    let mut panels = vec![
        zwidth_panel("ideal device", "", stop)?,
        zwidth_panel("realistic device", &realistic(1.0, 1.0), stop)?,
    ];
    share_axes(&mut panels);
    let enlarged = enlarged(&panels);
    panels.extend(enlarged);
    Ok(Figure {
        id: "4.3",
        title: "largest stable stiffness, simulated, over theory",
        conditions: "A₃; markers: simulated, 1 N for 5 s, stable if within 0.1 mm rms over the last 0.4 s; lines: \
                     theory of the ideal device\n\
                     realistic (our choice): 1 µm encoder, 0.05 N friction, 1 ms delay, 1 ms current lag"
            .to_owned(),
        columns: 2,
        panels,
    })
}

/// The border of theory and the markers of a simulated device.
fn zwidth_panel(caption: &str, device: &str, stop: &Arc<AtomicBool>) -> Result<Panel, Failure> {
    let mut curves = per_order(&ORDERS, 0, Look::Line, |mu| {
        border(Kind::Muir, mu, DELTA, 0.0)
    })?;
    let simulated = simulated(Kind::Muir, device, stop)?;
    for (colour, (mu, points)) in ORDERS.into_iter().zip(simulated).enumerate() {
        curves.push(Curve {
            // One entry with the line of theory.
            legend: format!("μ = {mu}"),
            ..Curve::new(
                format!("simulated, μ = {mu}"),
                points,
                Look::Markers,
                colour,
            )
        });
    }
    Ok(Panel::new(caption, BETA, ALPHA, curves))
}

/// The part of the plane that the realistic device, the second, reaches.
fn enlarged(panels: &[Panel]) -> Vec<Panel> {
    let simulated = |panel: &Panel| {
        let mut panel = panel.clone();
        (panel.curves).retain(|curve| curve.look == Look::Markers);
        panel
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
    panels.iter().map(enlarged).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_that_are_compared_have_the_same_axes() {
        let axes = |panel: &Panel| {
            (
                panel.x.spec.range.expect("given"),
                panel.y.spec.range.expect("given"),
            )
        };
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
            for kind in [Kind::Muir, Kind::Exact] {
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
