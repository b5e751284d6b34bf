//! The region for μ = 0, where P is a number p and F depends on κ = α + pβ alone: strips.

use crate::boundary::{BoundaryPoint, Polygon};
use crate::decomposition::Decomposition;
use core::f64::consts::PI;

/// The strips κ₁ < α + pβ < κ₂ of stable loops, cut to the quadrant.
pub(crate) fn polygons(decomposition: &Decomposition) -> Vec<Polygon> {
    let characteristic = &decomposition.characteristic;
    let (p, _) = characteristic.operator.response_and_rate(0.0);
    let mut edges: Vec<(f64, Option<f64>)> = vec![(0.0, None), (decomposition.reach, None)];
    // w = ±1: κ = −A/S.
    let ends = [
        (decomposition.line_at_rest(), 0.0),
        (decomposition.line_at_nyquist(), PI),
    ];
    edges.extend(
        ends.into_iter()
            .filter_map(|(line, theta)| Some((line?.1, Some(theta)))),
    );
    edges.extend(
        real_crossings(decomposition)
            .into_iter()
            .map(|(kappa, theta)| (kappa, Some(theta))),
    );
    edges.retain(|(kappa, _)| (0.0..=decomposition.reach).contains(kappa));
    // The rest at κ = 0 says more than the axis does.
    edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.is_some().cmp(&a.1.is_some())));
    edges.dedup_by(|b, a| b.0 - a.0 <= 1e-12 * a.0.max(1e-3));
    let circle = characteristic.circle();
    let mut strips: Vec<[(f64, Option<f64>); 2]> = Vec::new();
    for pair in edges.windows(2) {
        let kappa = 0.5 * (pair[0].0 + pair[1].0);
        if circle.count((kappa, 0.0), 0.0, false).zeros != Some(0) {
            continue;
        }
        match strips.last_mut() {
            // A crossing that only touches does not bound anything.
            Some(strip) if strip[1].0 >= pair[0].0 => strip[1] = pair[1],
            _ => strips.push([pair[0], pair[1]]),
        }
    }
    strips.iter().map(|strip| polygon(strip, p.re)).collect()
}

fn polygon([low, high]: &[(f64, Option<f64>); 2], p: f64) -> Polygon {
    let corner = |alpha: f64, beta: f64, theta| BoundaryPoint { alpha, beta, theta };
    let mut points = vec![
        corner(low.0, 0.0, low.1),
        corner(high.0, 0.0, high.1),
        corner(0.0, high.0 / p, high.1),
    ];
    if low.0 > 0.0 {
        points.push(corner(0.0, low.0 / p, low.1));
    }
    Polygon {
        points,
        area: 0.5 * (high.0 - low.0) * (high.0 + low.0) / p,
    }
}

/// All κ = −A/S that are real, with their angles: zeros of Im(A·S*) in (0, π), none missed.
fn real_crossings(decomposition: &Decomposition) -> Vec<(f64, f64)> {
    let characteristic = &decomposition.characteristic;
    let value = |theta: f64| {
        let node = characteristic.node(theta);
        (node, (node.plant.value * node.gain.value.conj()).im)
    };
    const END: f64 = 1e-6;
    let mut found = Vec::new();
    let mut todo = vec![(END, PI - END)];
    while let Some((low, high)) = todo.pop() {
        let ((a, at_a), (b, at_b)) = (value(low), value(high));
        let bend = (characteristic.plant_bounds(&a, &b))
            .times(characteristic.gain_bounds(&a, &b))
            .bend;
        let width = high - low;
        if at_a * at_b > 0.0 && at_a.abs().min(at_b.abs()) > 0.125 * width * width * bend {
            continue;
        }
        let middle = 0.5 * (low + high);
        if width > 1e-13 && middle > low && middle < high {
            todo.extend([(low, middle), (middle, high)]);
        } else {
            let gain = a.gain.value;
            found.push(((-a.plant.value / gain).re, middle));
        }
    }
    found
}
