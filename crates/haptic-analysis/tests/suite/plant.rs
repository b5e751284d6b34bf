//! The sampled plant against 50 digits.

use haptic_analysis::SampledPlant;
use testkit::golden;

/// Largest relative error the plant may have for δ and γ from 1e-9 to 10.
const TOLERANCE: f64 = 1e-12;

#[test]
fn every_coefficient_matches_fifty_digits() {
    let mut cases = 0;
    let mut worst: (f64, String) = (0.0, String::new());
    for row in golden::rows("plant.csv") {
        let [delta, gamma, n1, n0, pole_sum, pole_product, rest] = row[..] else {
            panic!("{row:?}");
        };
        let plant = SampledPlant::new(delta, gamma).expect("in range");
        for (name, have, want) in [
            ("n1", plant.n1(), n1),
            ("n0", plant.n0(), n0),
            ("n1 + n0", plant.numerator_sum(), n1 + n0),
            ("c2 + c3", plant.pole_sum(), pole_sum),
            ("c2·c3", plant.pole_product(), pole_product),
            ("A(1)", plant.denominator_at_rest(), rest),
        ] {
            let error = if want == 0.0 {
                have.abs()
            } else {
                (have / want - 1.0).abs()
            };
            if error > worst.0 {
                worst = (error, format!("{name} at δ = {delta:e}, γ = {gamma:e}"));
            }
            assert!(
                error <= TOLERANCE,
                "δ = {delta:e}, γ = {gamma:e}: {name} is {have:e}, not {want:e} ({error:.1e})"
            );
        }
        cases += 1;
    }
    println!("{cases} cases, worst {:.1e}: {}", worst.0, worst.1);
    assert!(cases > 200);
}

#[test]
#[expect(clippy::float_cmp, reason = "exact")]
fn a_free_mass_moves_half_a_sample_squared() {
    let plant = SampledPlant::new(0.0, 0.0).expect("in range");
    assert_eq!(
        [
            plant.n1(),
            plant.n0(),
            plant.pole_sum(),
            plant.pole_product()
        ],
        [0.5, 0.5, 2.0, 1.0]
    );
}

#[test]
fn a_very_fast_plant_settles_within_a_sample() {
    // x(1) → 1/γ − small, n₀ → 0 relative to n₁: everything has died out.
    for (delta, gamma) in [(1e6, 1e12), (1e3, 1e5), (200.0, 1e4)] {
        let plant = SampledPlant::new(delta, gamma).expect("in range");
        let error = (plant.n1() * gamma - 1.0).abs();
        assert!(error < 1e-12, "δ = {delta}, γ = {gamma}: {error:e}");
        assert!(plant.n0().abs() < 1e-12 * plant.n1());
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
        let have = SampledPlant::new(delta, gamma)
            .expect_err("refused")
            .to_string();
        assert_eq!(have, want);
    }
}
