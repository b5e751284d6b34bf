//! The sampled plant against 50 digits.

use haptic_analysis::{SampledLoop, SampledPlant};
use testkit::operator::operator;
use testkit::{assert_close, golden};

/// Largest relative error the plant may have for δ and γ from 1e-9 to 10.
const TOLERANCE: f64 = 1e-12;

#[test]
fn every_coefficient_matches_fifty_digits() {
    let spring = operator("exact", 0.0);
    let mut cases = 0;
    for row in golden::rows("plant.csv") {
        let [delta, gamma, n1, n0, pole_sum, pole_product, rest] = row[..] else {
            panic!("{row:?}");
        };
        let plant = SampledPlant::new(delta, gamma).expect("in range");
        let (n, a) = (plant.numerator(), plant.denominator());
        // Without a wall the characteristic function at rest is A(1), which does not cancel.
        let alone = SampledLoop::with_plant(plant, 0.0, 0.0, &spring).expect("in range");
        for (name, have, want) in [
            ("n1", n[0], n1),
            ("n0", n[1], n0),
            ("n1 + n0", n[0] + n[1], n1 + n0),
            ("c2 + c3", -a[1], pole_sum),
            ("c2·c3", a[2], pole_product),
            ("A(1)", alone.characteristic(0.0).re, rest),
        ] {
            let size = if want == 0.0 { 1.0 } else { want.abs() };
            let what = format!("{name} at δ = {delta:e}, γ = {gamma:e}");
            assert_close(&what, have, want, TOLERANCE * size);
        }
        cases += 1;
    }
    assert!(cases > 200);
}

#[test]
fn a_free_mass_moves_half_a_sample_squared() {
    let plant = SampledPlant::new(0.0, 0.0).expect("in range");
    assert_eq!(plant.numerator(), [0.5, 0.5]);
    assert_eq!(plant.denominator(), [1.0, -2.0, 1.0]);
}

#[test]
fn a_very_fast_plant_settles_within_a_sample() {
    // x(1) → 1/γ − small, n₀ → 0 relative to n₁: everything has died out.
    for (delta, gamma) in [(1e6, 1e12), (1e3, 1e5), (200.0, 1e4)] {
        let plant = SampledPlant::new(delta, gamma).expect("in range");
        let n = plant.numerator();
        let error = (n[0] * gamma - 1.0).abs();
        assert!(error < 1e-12, "δ = {delta}, γ = {gamma}: {error:e}");
        assert!(n[1].abs() < 1e-12 * n[0]);
    }
}

#[test]
fn bad_parameters_are_refused_in_words() {
    for (delta, gamma, want) in [
        (-0.1, 0.0, "delta -0.1 is not at least 0"),
        (0.1, -2.0, "gamma -2 is not at least 0"),
        (f64::NAN, 0.0, "delta NaN is not at least 0"),
        (1e7, 0.0, "delta 1e7 is not from 0 to 1e6"),
        (0.0, 1e13, "gamma 1e13 is not from 0 to 1e12"),
    ] {
        let have = SampledPlant::new(delta, gamma).expect_err("refused");
        assert_eq!(have.to_string(), want);
    }
}
