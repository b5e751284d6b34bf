//! Relaxation modulus and creep compliance of every model against mpmath (`golden/make_golden.py`).

use haptic_tissue::{Model, ModelKind};
use testkit::tissue::two_spring_pots;
use testkit::{assert_close, assert_relative};

/// The issue asks for 1e-10; what remains is rounding and the step of the trapezoid rule.
const TOLERANCE: f64 = 1e-10;

fn model(kind: &str, numbers: &[f64]) -> Model {
    of_kind(ModelKind::from_name(kind).expect("known"), numbers)
}

fn of_kind(kind: ModelKind, numbers: &[f64]) -> Model {
    testkit::tissue::model(kind, &numbers[..kind.parameters().len()])
}

#[test]
fn every_model_agrees_with_mpmath_over_twelve_decades() {
    let lines = include_str!("../golden/closed_forms.csv").lines().skip(1);
    for line in lines.filter(|line| !line.contains(",ramp-")) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse().unwrap_or(f64::NAN);
        let numbers: Vec<f64> = (2..7).map(number).collect();
        let (time_s, want) = (number(7), number(8));
        let model = model(cells[0], &numbers);
        let have = match cells[1] {
            "relaxation" => model.relaxation_moduli(&[time_s])[0],
            _ => model.creep_compliances(&[time_s])[0],
        };
        // e^(−1e6) has no digits in a double.
        let size = if want.abs() < 1e-300 { 1.0 } else { want.abs() };
        let error = (have - want).abs() / size;
        assert!(error < TOLERANCE, "{line}: {have:e}, {error:e}");
    }
}

#[test]
fn many_times_at_once_are_the_same_as_each_alone() {
    let times: Vec<f64> = (0..60)
        .map(|i| libm::pow(10.0, f64::from(i) * 0.2 - 6.0))
        .collect();
    for kind in two_spring_pots() {
        let model = of_kind(kind, &[876e3, 0.675, 22.1e3, 0.11, 3e4]);
        let (moduli, compliances) = (
            model.relaxation_moduli(&times),
            model.creep_compliances(&times),
        );
        for (at, &t) in times.iter().enumerate() {
            let error = (moduli[at] / model.relaxation_moduli(&[t])[0] - 1.0).abs();
            assert!(error < 1e-12, "{kind} G({t}): {error:e}");
            let error = (compliances[at] / model.creep_compliances(&[t])[0] - 1.0).abs();
            assert!(error < 1e-12, "{kind} J({t}): {error:e}");
        }
    }
}

#[test]
fn before_at_and_far_from_the_step() {
    let maxwell = model("fractional-maxwell", &[876e3, 0.675, 22.1e3, 0.0, 3e4]);
    let around = maxwell.relaxation_moduli(&[-1.0, 0.0]);
    assert_close("before", around[0], 0.0, 0.0);
    assert_close("at", around[1], 22.1e3, 0.0);
    assert_close(
        "at",
        maxwell.creep_compliances(&[0.0])[0],
        1.0 / 22.1e3,
        1e-20,
    );
    assert!(maxwell.relaxation_moduli(&[f64::NAN])[0].is_nan());
    assert_relative(
        "maxwell.relaxation_moduli(&[1e-60])[0]",
        maxwell.relaxation_moduli(&[1e-60])[0],
        22.1e3,
        1e-12,
    );
    assert!(maxwell.relaxation_moduli(&[]).is_empty());
    let zener = model("fractional-zener", &[876e3, 0.675, 22.1e3, 0.11, 3e4]);
    assert!(zener.relaxation_moduli(&[0.0])[0].is_infinite());
    assert_relative(
        "zener.relaxation_moduli(&[1e60])[0]",
        zener.relaxation_moduli(&[1e60])[0],
        zener.equilibrium_modulus(),
        1e-12,
    );
}

/// M(iω) = iω ∫ G(t) e^(−iωt) dt: the same by the modulus at the complex frequency.
#[test]
fn the_complex_modulus_is_the_modulus_at_i_omega() {
    for kind in two_spring_pots() {
        for orders in [(1.0, 0.0), (0.675, 0.11), (0.5, 0.0)] {
            let model = of_kind(kind, &[876e3, orders.0, 22.1e3, orders.1, 3e4]);
            for omega in [1e-4, 1.0, 7.0, 1e5] {
                let want = model.modulus(num_complex::Complex64::new(0.0, omega));
                let error = (model.complex_modulus(omega) - want).norm() / want.norm();
                assert!(error < 1e-14, "{kind} {omega}: {error:e}");
                assert!(want.re >= 0.0 && want.im >= 0.0);
            }
            let at_rest = model.complex_modulus(0.0);
            let want = model.equilibrium_modulus();
            assert_close(kind.name(), at_rest.re, want, 1e-15 * want);
            assert_close(kind.name(), at_rest.im, 0.0, 1e-300);
        }
    }
}

/// Whatever a search for parameters tries: G falls, J rises, and G·J ≤ 1 (N. W. Tschoegl, 1989, eq. 2.4-13).
#[test]
fn extreme_parameters_give_moduli_and_compliances() {
    let times: Vec<f64> = (0..25)
        .map(|i| libm::pow(10.0, f64::from(i) * 0.5 - 6.0))
        .collect();
    let orders = [
        (1.0, 0.0),
        (1.0, 1e-9),
        (1.0 - 1e-9, 0.0),
        (1.0, 1.0 - 1e-6),
        (0.5, 0.5 - 1e-6),
        (1e-6, 0.0),
        (0.67, 0.0),
        (0.6667, 0.0001),
    ];
    let mut checked = 0;
    for kind in two_spring_pots() {
        for (order, second_order) in orders {
            for ratio in [1e-12, 1.0, 1e12] {
                for spring in [1e-8, 1.0, 1e8] {
                    let numbers = [1e4 * ratio, order, 1e4, second_order, 1e4 * spring];
                    let model = of_kind(kind, &numbers);
                    let (g, j) = (
                        model.relaxation_moduli(&times),
                        model.creep_compliances(&times),
                    );
                    for at in 0..times.len() {
                        let label =
                            format!("{kind} {numbers:?} t {}: {} {}", times[at], g[at], j[at]);
                        assert!(g[at] >= 0.0 && g[at].is_finite(), "{label}");
                        assert!(j[at] > 0.0 && j[at].is_finite(), "{label}");
                        assert!(g[at] * j[at] <= 1.0 + 1e-11, "{label}");
                        if at > 0 {
                            assert!(g[at] <= g[at - 1] * (1.0 + 1e-11), "{label}");
                            assert!(j[at] >= j[at - 1] * (1.0 - 1e-11), "{label}");
                        }
                        checked += 1;
                    }
                }
            }
        }
    }
    assert_eq!(checked, two_spring_pots().len() * 8 * 9 * 25);
}
