//! Loops whose boundary is known.

use super::stiffest;
use fracdiff::FrequencyResponse as _;
use haptic_analysis::SampledLoop;
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
fn the_boundary_itself_is_not_stable() {
    let operator = operator("exact", 1.0);
    let parameters = wall(2.0 / 3.0, 1.0, 0.0, 0.0);
    let verdict = SampledLoop::new(parameters, &operator, 0)
        .expect("in range")
        .verdict();
    assert!(!verdict.stable);
    assert_eq!(verdict.unstable_poles, None);
    assert!(verdict.distance < 1e-9, "{verdict:?}");
    // No stiffness and no hand: nothing brings the device back, a pole at z = 1.
    let adrift = wall(0.0, 1.0, 0.1, 0.0);
    let verdict = SampledLoop::new(adrift, &operator, 0)
        .expect("in range")
        .verdict();
    assert_eq!(
        (verdict.stable, verdict.unstable_poles, verdict.theta),
        (false, None, 0.0)
    );
}

#[test]
fn a_tissue_without_a_spring_drifts_and_held_it_is_stable() {
    for scheme in ["full", "full:1e-3", "piecewise-linear", "exact"] {
        for order in [0.2154, 0.35, 0.4, 0.45, 0.7, 0.8, 1.0] {
            let operator = operator(scheme, order);
            // P(1) = 0, to the last bit.
            assert!(
                operator.response(0.0).norm().to_bits() == 0,
                "{scheme} {order}"
            );
            let closed =
                SampledLoop::new(wall(0.0, 0.2, 0.05, 0.0), &operator, 0).expect("in range");
            assert!(closed.drifts() && !closed.is_stable(), "{scheme} {order}");
            let verdict = closed.held().verdict();
            assert!(verdict.stable, "{scheme} {order}: {verdict:?}");
            // A spring of its own is left alone.
            let walled =
                SampledLoop::new(wall(0.1, 0.2, 0.05, 0.0), &operator, 0).expect("in range");
            assert!(!walled.drifts());
            assert_eq!(walled.held().verdict(), walled.verdict());
            // What shakes is still told.
            let shaking =
                SampledLoop::new(wall(0.0, 40.0, 0.05, 0.0), &operator, 0).expect("in range");
            assert!(!shaking.held().is_stable(), "{scheme} {order}");
        }
    }
}

#[test]
fn a_very_small_order_is_certified_although_its_response_jumps_at_rest() {
    // θ^0.001 climbs from 0 to 0.98 within the first 1e-9 rad.
    let tiny = operator("exact", 1e-3);
    let none = operator("exact", 0.0);
    for (alpha, beta, delta) in [
        (0.1, 0.1, 0.5),
        (1e-6, 0.05, 0.5),
        (0.5, 1.5, 0.1),
        (0.3, 0.2, 1.5),
    ] {
        let verdict = |operator| {
            SampledLoop::new(wall(alpha, beta, delta, 0.0), operator, 0)
                .expect("in range")
                .verdict()
        };
        assert_eq!(
            verdict(&tiny).unstable_poles,
            verdict(&none).unstable_poles,
            "α = {alpha}, β = {beta}"
        );
    }
}
