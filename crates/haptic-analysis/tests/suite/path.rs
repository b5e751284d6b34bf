//! Delay that is no whole number of samples, and a current lag: the sampled plant against thirty digits,
//! plants from matrices, and verdicts that must agree.

use haptic_analysis::{Dynamics, ForcePath, SampledLoop, SampledPlant, StabilityRegion};
use nalgebra::DMatrix;
use testkit::operator::{operator, path};
use testkit::{Random, assert_close, assert_relative, golden};

/// The numerator at rest.
fn at_rest(plant: &SampledPlant) -> f64 {
    plant.numerator().iter().sum()
}

/// Largest error of a coefficient, of their sum.
const TOLERANCE: f64 = 1e-12;

#[test]
fn every_delayed_and_lagging_numerator_matches_thirty_digits() {
    let mut cases = 0;
    for row in golden::rows("delayed_plant.csv") {
        let [delta, gamma, h, tau, ref want @ .., sum] = row[..] else {
            panic!("{row:?}");
        };
        let plant = SampledPlant::behind(delta, gamma, path(h, tau)).expect("in range");
        for (j, want) in want.iter().enumerate() {
            let have = plant.numerator().get(j).copied().unwrap_or(0.0);
            assert_close(&format!("{j} of {row:?}"), have, *want, TOLERANCE * sum);
        }
        assert_relative(&format!("{row:?}"), at_rest(&plant), sum, TOLERANCE);
        cases += 1;
    }
    assert!(cases > 300);
}

#[test]
fn without_fraction_and_lag_it_is_the_plain_plant_to_the_bit() {
    let plain = SampledPlant::new(0.1, 0.3).expect("in range");
    let behind = SampledPlant::behind(0.1, 0.3, path(2.0, 0.0)).expect("in range");
    assert_eq!(behind.numerator(), plain.numerator());
    assert_eq!(behind.denominator(), plain.denominator());
    assert_eq!(behind.path().whole_samples(), 2);
    // 3 ms at 1 ms, whatever the division says.
    assert_eq!(path(3e-3 / 1e-3, 0.0), path(3.0, 0.0));
}

#[test]
fn a_vanishing_lag_or_fraction_changes_nothing_more_than_itself() {
    let plain = SampledPlant::behind(0.1, 0.0, path(0.5, 0.0)).expect("in range");
    for lag in [1e-12, 1e-10, 1e-8] {
        let near = SampledPlant::behind(0.1, 0.0, path(0.5, lag)).expect("in range");
        for (a, b) in near.numerator().iter().zip(plain.numerator()) {
            assert_close(&format!("{lag:e}"), *a, *b, 2.0 * lag + 1e-13);
        }
        assert_close("at rest", at_rest(&near), at_rest(&plain), 1e-14);
    }
}

/// A of mass, damper, hand and lag, in SI units; B and C.
fn matrices(d: &Dynamics) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (m, b, k) = (d.mass_kg, d.damping_n_s_per_m, d.hand_stiffness_n_per_m);
    let rate = 1.0 / d.current_lag_s;
    (
        vec![0.0, 1.0, 0.0, -k / m, -b / m, 1.0 / m, 0.0, 0.0, -rate],
        vec![0.0, 0.0, rate],
        vec![1.0, 0.0, 0.0],
    )
}

#[test]
fn matrices_of_a_lagging_mass_damper_give_the_same_plant_as_its_name() {
    let mut random = Random(3);
    for _ in 0..200 {
        let t = 1e-3;
        let device = Dynamics {
            mass_kg: random.between(0.02, 1.0),
            damping_n_s_per_m: random.between(0.0, 10.0),
            hand_stiffness_n_per_m: random.between(0.0, 1000.0),
            delay_s: t * random.between(0.0, 3.0),
            current_lag_s: t * random.between(0.05, 3.0),
        };
        let named = device.plant(t).expect("in range");
        let delay = path(device.delay_s / t, 0.0);
        let (a, b, c) = matrices(&device);
        let whole = SampledPlant::linear(&a, &b, &c, t, device.mass_kg, delay).expect("in range");
        // The same with the lag from the path.
        let (m, k) = (device.mass_kg, device.hand_stiffness_n_per_m);
        let a = [0.0, 1.0, -k / m, -device.damping_n_s_per_m / m];
        let both = path(device.delay_s / t, device.current_lag_s / t);
        let part =
            SampledPlant::linear(&a, &[0.0, 1.0 / m], &[1.0, 0.0], t, m, both).expect("in range");
        for plant in [&whole, &part] {
            let near = |a: &[f64], b: &[f64], most: f64| {
                assert_eq!(a.len(), b.len());
                let what = format!("{device:?}");
                let pairs = a.iter().zip(b);
                pairs.for_each(|(a, b)| assert_close(&what, *a, *b, most));
            };
            near(plant.denominator(), named.denominator(), 1e-12);
            let most = 1e-11 * at_rest(&named);
            near(plant.numerator(), named.numerator(), most);
        }
    }
}

#[test]
fn matrices_that_cannot_be_sampled_are_refused_in_one_line() {
    let free = [0.0, 1.0, 0.0, 0.0];
    let refused = |a: &[f64], b: &[f64], c: &[f64], lag: f64| {
        let error = SampledPlant::linear(a, b, c, 1e-3, 1.0, path(0.0, lag)).expect_err("refused");
        error.to_string()
    };
    for (refused, want) in [
        (
            refused(&free, &[0.0, 1.0], &[1.0], 0.0),
            "entries of C 1 is not as many as the entries of B ask for",
        ),
        (
            refused(&[0.0; 64], &[1.0; 8], &[1.0; 8], 1.0),
            "states of a plant 8 is not from 1 to 7 with a current lag",
        ),
        (
            refused(&free, &[0.0, f64::NAN], &[1.0, 0.0], 0.0),
            "entry of B NaN is not finite",
        ),
        (
            refused(&[0.0, 1.0, 0.0, -1e10], &[0.0, 1.0], &[1.0, 0.0], 0.0),
            "fastest motion of the plant 1e7 per sample is not at most 1e6 per sample",
        ),
        // The second state never moves the first.
        (
            refused(&[-1.0, 0.0, 0.0, -2.0], &[0.0, 1.0], &[1.0, 0.0], 0.0),
            "the sampled plant cannot be computed: its input does not move its output",
        ),
        (
            ForcePath::new(-0.1, 0.0).expect_err("refused").to_string(),
            "delay -0.1 samples is not from 0 to 10000 samples",
        ),
        (
            ForcePath::new(0.0, 2e6).expect_err("refused").to_string(),
            "current lag 2e6 samples is not from 0 to 1e6 samples",
        ),
    ] {
        assert_eq!(refused, want);
    }
}

/// The series elastic actuator of the guide under a damper alone: two poles at rest, of which rounding makes a pair beside 1.
#[test]
fn a_law_without_a_spring_drifts_on_an_actuator_that_rests_anywhere_and_is_judged_as_its_motion_is()
{
    #[rustfmt::skip]
    let a = [
        0.0,             1.0, 0.0,            0.0,
        -400.0 / 0.3,    0.0, 400.0 / 0.3,    0.0,
        80.0,            0.0, -80.0,          4.0,
        400.0,           0.0, -400.0,         0.0,
    ];
    let (input, output) = ([0.0, 0.0, 0.2, 1.0], [1.0, 0.0, 0.0, 0.0]);
    let operator = operator("grunwald:2", 1.0);
    let mut stable = 0;
    for t in [1e-4, 1e-3, 1e-2] {
        let plant = SampledPlant::linear(&a, &input, &output, t, 1.0, path(0.0, 0.0));
        let plant = plant.expect("in range");
        // x and the force, held over a sample.
        let mut held = DMatrix::zeros(5, 5);
        for (row, &driven) in input.iter().enumerate() {
            for column in 0..4 {
                held[(row, column)] = t * a[4 * row + column];
            }
            held[(row, 4)] = t * driven;
        }
        let mut term = DMatrix::identity(5, 5);
        let mut sum = term.clone();
        for k in 1..80 {
            term = &term * &held / f64::from(k);
            sum += &term;
        }
        let held = sum;
        for damping in [0.5, 5.0, 50.0, 500.0, 1500.0, 2000.0, 2500.0, 5000.0] {
            let subject = SampledLoop::with_plant(plant, 0.0, damping * t, &operator);
            let subject = subject.expect("in range");
            assert!(subject.drifts(), "{t} s, {damping} N·s/m");
            // x and the position before: f = −B·(y − y₋₁)/T.
            let moved = DMatrix::from_fn(5, 5, |row, column| match (row, column) {
                (4, column) => f64::from(u8::from(column == 0)),
                (row, 4) => held[(row, 4)] * damping / t,
                (row, 0) => held[(row, 0)] - held[(row, 4)] * damping / t,
                (row, column) => held[(row, column)],
            });
            let mut poles: Vec<_> = moved.complex_eigenvalues().iter().copied().collect();
            poles.sort_by(|one, other| (one - 1.0).norm().total_cmp(&(other - 1.0).norm()));
            let radius = (poles.iter().skip(1)).fold(0.0, |most, z| f64::max(most, z.norm()));
            let verdict = subject.beside_rest().verdict();
            assert_eq!(
                verdict.stable,
                radius < 1.0,
                "{t} s, {damping} N·s/m: {radius}"
            );
            stable += usize::from(verdict.stable);
        }
    }
    assert_eq!(stable, 11);
}

#[test]
fn encirclement_and_eigenvalues_agree_behind_any_delay_and_lag() {
    let mut random = Random(5);
    let mut stable = 0;
    const CASES: usize = 3000;
    for case in 0..CASES {
        let delay = random.between(0.0, 3.0);
        let lag = random.between(0.0, 3.0) * f64::from(u8::from(case % 3 != 0));
        let delta = random.between(0.0, 1.0) * random.share();
        let gamma = random.between(0.0, 0.3) * random.share();
        let plant = SampledPlant::behind(delta, gamma, path(delay, lag)).expect("in range");
        let most = 1.0 / (1.0 + 3.0 * delay + 2.0 * lag);
        let alpha = most * random.share() * random.share();
        let beta = 2.0 * most * random.share();
        let name = ["muir:3", "grunwald:20", "tustin-muir:5"][case % 3];
        let operator = operator(name, random.between(0.0, 2.0));
        let subject = SampledLoop::with_plant(plant, alpha, beta, &operator).expect("in range");
        let verdict = subject.verdict();
        let radius = subject.spectral_radius().expect("a polynomial");
        if (radius - 1.0).abs() < 1e-9 {
            continue;
        }
        let poles = subject.poles().expect("a polynomial");
        let outside = poles.iter().filter(|z| z.norm() > 1.0).count();
        let what = format!("case {case}: {plant:?}");
        assert_eq!(verdict.unstable_poles, Some(outside), "{what}");
        stable += usize::from(verdict.stable);
    }
    assert!(stable > CASES / 5 && stable < 4 * CASES / 5, "{stable}");
}

#[test]
fn regions_behind_delay_and_lag_agree_with_verdicts_on_both_sides_of_the_boundary() {
    let mut random = Random(17);
    let mut checked = 0;
    let paths = [
        (0.0, 0.5),
        (0.3, 0.0),
        (1.999_999, 0.0),
        (0.5, 1e-3),
        (1.3, 0.5),
        (2.75, 3.0),
    ];
    for (delay, lag) in paths {
        for order in [0.0, 0.5, 1.0, 1.7] {
            let operator = operator("exact", order);
            let plant = SampledPlant::behind(0.1, 0.01, path(delay, lag)).expect("in range");
            let region = StabilityRegion::new(plant, &operator, 0, 2000).expect("closes");
            let area = region.bounded().expect("not empty");
            for _ in 0..200 {
                let alpha = 1.2 * area.alpha_max * random.share();
                let beta = 1.2 * area.beta_max * random.share();
                let subject = SampledLoop::with_plant(plant, alpha, beta, &operator);
                let verdict = subject.expect("in range").verdict();
                // Chords are within 1e-6 of the boundary.
                if verdict.distance < 1e-5 {
                    continue;
                }
                let inside = region.contains(alpha, beta);
                let what =
                    format!("d + h = {delay}, τ = {lag}, μ = {order}, α = {alpha}, β = {beta}");
                assert_eq!(inside, verdict.stable, "{what}");
                checked += 1;
            }
        }
    }
    assert!(checked > 4000, "{checked}");
}
