//! Loops whose boundary is known.

use super::stiffest;
use fracdiff::FrequencyResponse as _;
use haptic_analysis::{SampledLoop, SampledPlant};
use num_complex::Complex;
use std::f64::consts::PI;
use testkit::assert_relative;
use testkit::operator::{operator, wall};

#[test]
fn the_spring_and_damper_without_device_damping_has_its_closed_form() {
    let operator = operator("exact", 1.0);
    for beta in [0.1, 0.5, 8_f64.sqrt() - 2.0, 1.0, 1.5, 1.9] {
        let want = 2.0 * beta * (2.0 - beta) / (2.0 + beta);
        let have = stiffest(&operator, beta, 0.0, 0);
        // The verdict calls |F| ≤ 1e-9 the boundary.
        assert!((have - want).abs() < 3e-9, "β = {beta}: {have} {want}");
    }
}

#[test]
fn a_drift_by_itself_is_not_stable() {
    let operator = operator("exact", 1.0);
    // No stiffness and no hand: nothing brings the device back, a pole at z = 1.
    let adrift = SampledLoop::new(wall(0.0, 1.0, 0.1, 0.0), &operator, 0);
    let adrift = adrift.expect("in range").verdict();
    let verdict = (adrift.stable, adrift.unstable_poles, adrift.theta);
    assert_eq!(verdict, (false, None, 0.0));
}

#[test]
fn a_tissue_without_a_spring_drifts_and_beside_that_it_is_stable() {
    for scheme in ["full", "full:1e-3", "piecewise-linear", "exact"] {
        for order in [0.2154, 0.35, 0.4, 0.45, 0.7, 0.8, 1.0] {
            let operator = operator(scheme, order);
            // P(1) = 0, to the last bit.
            assert_eq!(
                operator.response(0.0).norm().to_bits(),
                0,
                "{scheme} {order}"
            );
            let loop_of = |alpha, beta| {
                SampledLoop::new(wall(alpha, beta, 0.05, 0.0), &operator, 0).expect("in range")
            };
            let closed = loop_of(0.0, 0.2);
            assert!(closed.drifts() && !closed.is_stable(), "{scheme} {order}");
            let verdict = closed.beside_rest().verdict();
            assert!(verdict.stable, "{scheme} {order}: {verdict:?}");
            // A spring of its own is left alone.
            let walled = loop_of(0.1, 0.2);
            assert!(!walled.drifts());
            assert_eq!(walled.beside_rest().verdict(), walled.verdict());
            // What shakes is still told.
            assert!(
                !loop_of(0.0, 40.0).beside_rest().is_stable(),
                "{scheme} {order}"
            );
        }
    }
}

/// Hurwitz's criterion without a hand: F is c₀ + c₁v + c₂v² + c₃v³ in v = 1 − w. With v = 2s/(1 + s) the circle is the imaginary axis, its
/// inside Re s > 0, and nothing cancels however near to v = 0 the zeros are, so the criterion decides.
fn by_hurwitz(alpha: f64, [beta, order]: [f64; 2], delta: f64) -> bool {
    let plant = SampledPlant::new(delta, 0.0).expect("in range");
    let [n1, n0, p] = coefficients(&plant);
    // w(n₁ + n₀w) and α + βP, P = 1 or v.
    let gain = [n1 + n0, -(n1 + 2.0 * n0), n0];
    let law = if order == 0.0 {
        [alpha + beta, 0.0]
    } else {
        [alpha, beta]
    };
    let c0 = gain[0] * law[0];
    let c1 = -(-delta).exp_m1() + gain[1] * law[0] + gain[0] * law[1];
    let c2 = p + gain[2] * law[0] + gain[1] * law[1];
    let c3 = gain[2] * law[1];
    let a = [
        c0,
        3.0 * c0 + 2.0 * c1,
        3.0 * c0 + 4.0 * c1 + 4.0 * c2,
        c0 + 2.0 * c1 + 4.0 * c2 + 8.0 * c3,
    ];
    a.iter().all(|a| *a > 0.0) && a[2] * a[1] > a[3] * a[0]
}

#[test]
fn weak_springs_over_decades_are_decided_by_hurwitz() {
    let mut stable = 0;
    for order in [0.0, 1.0] {
        let operator = operator("exact", order);
        let loop_of = |alpha, beta, delta| {
            SampledLoop::new(wall(alpha, beta, delta, 0.0), &operator, 0).expect("in range")
        };
        for decade in 0..14 {
            let alpha = 0.7 * 10_f64.powi(-decade);
            for beta in [0.0, 1e-8, 1e-4, 0.025, 0.3, 3.0] {
                for delta in [1e-7, 1e-4, 5e-3, 0.2] {
                    let closed = loop_of(alpha, beta, delta);
                    let (verdict, want) =
                        (closed.verdict(), by_hurwitz(alpha, [beta, order], delta));
                    let name = format!("μ {order}, α {alpha:e}, β {beta}, δ {delta}");
                    assert!(
                        !closed.drifts() && verdict.unstable_poles.is_some(),
                        "{name}: {verdict:?}"
                    );
                    assert_eq!(verdict.stable, want, "{name}: {verdict:?}");
                    stable += i32::from(want);
                }
            }
        }
    }
    assert!((200..600).contains(&stable), "{stable}");
}

/// α = 2β(2 − β)/(2 + β), β over decades: there the zeros are on the circle, a thousandth beside they are not.
#[test]
fn the_edge_is_one_at_any_scale() {
    let operator = operator("exact", 1.0);
    for decade in 0..9 {
        let beta = 10_f64.powi(-decade);
        let edge = 2.0 * beta * (2.0 - beta) / (2.0 + beta);
        for (factor, zeros) in [(0.999, Some(0)), (1.0, None), (1.001, Some(2))] {
            let closed = SampledLoop::new(wall(factor * edge, beta, 0.0, 0.0), &operator, 0);
            let verdict = closed.expect("in range").verdict();
            assert_eq!(
                verdict.unstable_poles, zeros,
                "{beta} {factor}: {verdict:?}"
            );
        }
    }
}

/// n₁, n₀ and the product of the poles.
fn coefficients(plant: &SampledPlant) -> [f64; 3] {
    let n = plant.numerator();
    [n[0], n[1], plant.denominator()[2]]
}

/// GH of β·v^μ alone on 1/(s(s + δ)), by itself; the least gain above 1 at which it is −1.
fn edge_without_a_spring(plant: &SampledPlant, beta: f64, mu: f64) -> f64 {
    let gain = |theta: f64| {
        let w = Complex::from_polar(1.0, -theta);
        let v = -w + 1.0;
        let [n1, n0, product] = coefficients(plant);
        w * (w * n0 + n1) * v.powf(mu) * beta / (v * (-w * product + 1.0))
    };
    let mut edge = -1.0 / gain(PI).re;
    if edge < 1.0 {
        edge = f64::INFINITY;
    }
    let angles = (1..=4000).map(|k| PI * f64::from(k) / 4000.0);
    for (a, b) in angles.clone().zip(angles.skip(1)) {
        let (mut low, mut high) = (a, b.min(PI - 1e-9));
        if gain(low).im.signum() == gain(high).im.signum() {
            continue;
        }
        while high - low > 1e-15 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if gain(middle).im.signum() == gain(low).im.signum() {
                low = middle;
            } else {
                high = middle;
            }
        }
        let value = -1.0 / gain(low).re;
        if value > 1.0 {
            edge = edge.min(value);
        }
    }
    edge
}

#[test]
fn margins_of_a_loop_without_any_spring_are_exact() {
    for order in [0.2154, 0.5, 0.8, 1.0, 1.3] {
        let operator = operator("exact", order);
        for delta in [0.0, 0.01, 0.1, 1.0] {
            let plant = SampledPlant::new(delta, 0.0).expect("in range");
            for beta in [1e-3, 0.05, 0.3] {
                let what = format!("order {order}, delta {delta}, beta {beta}");
                let at = |gain: f64| {
                    let closed = SampledLoop::with_plant(plant, 0.0, gain * beta, &operator);
                    closed.expect("in range").beside_rest()
                };
                assert!(at(1.0).is_stable(), "{what}");
                let up = at(1.0).margins().expect("stable").gain_up.expect("an edge");
                let want = edge_without_a_spring(&plant, beta, order);
                assert_relative(&what, up.value, want, 1e-9);
                // The verdict turns there, and nowhere else.
                let edge = [1.0 - 1e-7, 1.0 + 1e-7].map(|share| at(share * up.value).is_stable());
                assert_eq!(edge, [true, false], "{what}");
            }
        }
    }
}

#[test]
fn a_very_small_order_is_certified_although_its_response_jumps_at_rest() {
    // θ^0.001 climbs from 0 to 0.98 within the first 1e-9 rad.
    let tiny = operator("exact", 1e-3);
    let none = operator("exact", 0.0);
    let walls = [
        (0.1, 0.1, 0.5),
        (1e-6, 0.05, 0.5),
        (0.5, 1.5, 0.1),
        (0.3, 0.2, 1.5),
    ];
    for (alpha, beta, delta) in walls {
        let [tiny, none] = [&tiny, &none].map(|operator| {
            let subject = SampledLoop::new(wall(alpha, beta, delta, 0.0), operator, 0);
            subject.expect("in range").verdict().unstable_poles
        });
        assert_eq!(tiny, none, "α = {alpha}, β = {beta}");
    }
}
