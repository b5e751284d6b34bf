//! Passivity behind a delay that is no whole number of samples and a current lag: against the closed
//! form of a spring, against quadrature in the time domain, and against the energy of all motions.

use fracdiff::{ExactDifference, FrequencyResponse, Seconds, grunwald_weights};
use haptic_analysis::{ForcePath, Largest, OnePort};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex;
use std::f64::consts::PI;
use testkit::operator::{order, path};
use testkit::{assert_close, assert_relative};

fn port(operator: &ExactDifference, mu: f64, way: ForcePath) -> OnePort<'_, ExactDifference> {
    OnePort::new(operator, order(mu))
        .expect("valid")
        .through(way)
        .expect("valid")
}

#[test]
fn a_spring_behind_part_of_a_sample_needs_what_its_closed_form_says() {
    let operator = ExactDifference(order(1.0));
    for h in [0.0, 1e-8, 0.1, 0.25, 0.5, 0.75, 0.99, 1.0] {
        let port = port(&operator, 1.0, path(h, 0.0));
        let required = port.required_delta(0.3, 0.0).expect("valid");
        // (α/2)(1/2 + h + √(1/4 + 2h))
        let want = 0.15 * (0.5 + h + (0.25 + 2.0 * h).sqrt());
        assert_close("δ", required.delta, want, 1e-12);
    }
}

/// Response to a unit step of commands after the time t in samples.
fn step(way: ForcePath, t: f64) -> f64 {
    let since = t - way.delay_samples();
    if since < 0.0 {
        0.0
    } else if way.lag_samples() == 0.0 {
        1.0
    } else {
        -(-since / way.lag_samples()).exp_m1()
    }
}

/// Nodes and weights of Gauss on both parts of a sample, each in so many pieces; x and w of half a rule.
fn nodes(way: ForcePath, pieces: u32, rule: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let h = way.fraction();
    let mut nodes = Vec::new();
    for (low, high) in [(0.0, h), (h, 1.0)] {
        let half = 0.5 * (high - low) / f64::from(pieces);
        for piece in 0..pieces {
            let middle = low + half * (2.0 * f64::from(piece) + 1.0);
            for (x, w) in rule {
                nodes.push((middle - half * x, half * w));
                nodes.push((middle + half * x, half * w));
            }
        }
    }
    nodes
}

/// Eight points, for short lags, which change within a small part of a sample.
const EIGHT: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

/// Four points: enough for forces that change over a fifth of a sample or more.
const FOUR: [(f64, f64); 2] = [
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// `p_i(t)`, the force at t in a sample of the command i samples before: a pulse one sample long.
fn pulse(way: ForcePath, i: usize, t: f64) -> f64 {
    let age = i as f64 + t;
    step(way, age) - step(way, age - 1.0)
}

/// Commands that still act: a lag of 40 time constants is over.
fn reach(way: ForcePath) -> usize {
    (way.delay_samples() + 40.0 * way.lag_samples()) as usize + 3
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn mean_and_variance_of_a_lagging_force_are_those_of_quadrature() {
    for (delay, lag) in [
        (0.4, 0.0),
        (0.0, 0.03),
        (0.0, 0.7),
        (0.25, 0.2),
        (1.6, 0.999),
        (2.5, 1.001),
        (0.7, 5.0),
        (0.0, 40.0),
    ] {
        let way = path(delay, lag);
        let nodes = nodes(way, 24, &EIGHT);
        for mu in [0.0, 0.5, 1.0, 1.6] {
            let operator = ExactDifference(order(mu));
            for theta in [0.01, 0.3, 1.0, 2.0, PI] {
                let w = |k: usize| Complex::from_polar(1.0, -theta * k as f64);
                let force = |t: f64| -> Complex<f64> {
                    (0..reach(way)).map(|i| w(i) * pulse(way, i, t)).sum()
                };
                let (mut mean, mut square) = (Complex::new(0.0, 0.0), 0.0);
                for &(t, weight) in &nodes {
                    mean += force(t) * weight;
                    square += force(t).norm_sqr() * weight;
                }
                let v = -w(1) + 1.0;
                let q = operator.response(theta) * 0.3 + 0.2;
                let r = (v * mean * q).re;
                let variance = square - mean.norm_sqr();
                let root = (r * r + variance * q.norm_sqr() * v.norm_sqr()).sqrt();
                let want = (r + root) / (2.0 * v.norm_sqr());
                let port = port(&operator, mu, way);
                let have = port.delta_at(0.2, 0.3, theta).expect("valid");
                let what = format!("d + h = {delay}, τ = {lag}, μ = {mu}, θ = {theta}");
                let scale = 1.0 + root / v.norm_sqr();
                assert_close(&what, have, want, 1e-9 * scale);
            }
        }
    }
}

/// The energy of device and loop over `samples` as a quadratic form of the displacements, for δ and
/// the weights of P:  Σ −ḡΔ + δΔ² − Var g/(4δ), with T = m = 1.
struct Energy {
    /// −ḡΔ, not yet symmetric.
    work: DMatrix<f64>,
    /// Var g.
    variance: DMatrix<f64>,
}

impl Energy {
    fn new(samples: usize, way: ForcePath, alpha: f64, beta: f64, mu: f64) -> Self {
        let weights: Vec<f64> = grunwald_weights(order(mu)).take(samples).collect();
        let lower = |value: &dyn Fn(usize) -> f64, lag: usize| {
            DMatrix::from_fn(samples, samples, |row, column| {
                let is_below = row >= column + lag;
                if is_below { value(row - column) } else { 0.0 }
            })
        };
        // x[n] is the sum of the displacements before it; f = −(α + βP)x.
        let position = lower(&|_| 1.0, 1);
        let now = |k| if k == 0 { alpha } else { 0.0 };
        let law = lower(&|k| -(beta * weights[k] + now(k)), 0);
        let command = law * position;
        let force = |t: f64| lower(&|k| pulse(way, k, t), 0) * &command;
        let mut mean = DMatrix::zeros(samples, samples);
        let mut square = DMatrix::zeros(samples, samples);
        for (t, weight) in nodes(way, 1, &FOUR) {
            let g = force(t);
            mean += &g * weight;
            square += g.transpose() * g * weight;
        }
        Self {
            variance: square - mean.transpose() * &mean,
            work: -mean,
        }
    }

    /// The least energy of any motion with Σ Δ² = 1.
    fn least(&self, delta: f64) -> f64 {
        let n = self.work.nrows();
        let form = 0.5 * (&self.work + self.work.transpose()) + DMatrix::identity(n, n) * delta
            - &self.variance / (4.0 * delta);
        let values: DVector<f64> = form.symmetric_eigenvalues();
        values.min()
    }
}

#[test]
fn the_energy_of_all_motions_changes_sign_at_the_damping_required() {
    const SAMPLES: usize = 120;
    for (delay, lag, alpha, beta, mu) in [
        (0.0, 0.0, 0.3, 0.0, 1.0),
        (0.25, 0.0, 0.3, 0.0, 1.0),
        (0.5, 0.0, 0.3, 0.0, 1.0),
        (0.75, 0.0, 0.3, 0.0, 1.0),
        (1.4, 0.0, 0.1, 0.3, 0.5),
        (0.0, 0.3, 0.3, 0.0, 1.0),
        (0.0, 0.5, 0.1, 0.3, 1.0),
        (0.3, 0.5, 0.2, 0.2, 0.5),
        (1.6, 2.0, 0.05, 0.1, 0.7),
        (0.7, 0.4, 0.0, 0.2, 1.5),
    ] {
        let way = path(delay, lag);
        let operator = ExactDifference(order(mu));
        let port = port(&operator, mu, way);
        let required = port.required_delta(alpha, beta).expect("valid");
        let energy = Energy::new(SAMPLES, way, alpha, beta, mu);
        let what = format!("d + h = {delay}, τ = {lag}, μ = {mu}: {required:?}");
        // A finite time asks for a little less: 0.3 % here, 1/N² of it.
        let enough = energy.least(required.delta * 1.0001);
        assert!(enough >= -1e-12, "{what}: {enough:e}");
        let short = energy.least(required.delta * 0.99);
        assert!(short < -1e-9, "{what}: {short:e}");
    }
}

#[test]
fn the_largest_wall_is_the_one_that_needs_just_the_damping_there_is() {
    for (delay, lag, mu) in [
        (0.5, 0.0, 0.5),
        (0.0, 0.7, 1.0),
        (1.3, 0.5, 0.3),
        (0.4, 2.0, 1.4),
        (2.2, 1.0, 0.0),
    ] {
        let operator = ExactDifference(order(mu));
        let port = port(&operator, mu, path(delay, lag));
        for (delta, other) in [(0.5, 0.0), (0.5, 0.05), (0.1, 0.01)] {
            let what = format!("d + h = {delay}, τ = {lag}, μ = {mu}, δ = {delta}");
            let below = |largest: Largest| match largest {
                Largest::Below { value, .. } => value,
                Largest::Any | Largest::Empty => panic!("{what}: {largest:?}"),
            };
            let alpha = below(port.largest_alpha(delta, other).expect("valid"));
            let at = |alpha: f64| port.required_delta(alpha, other).expect("valid").delta;
            assert_relative(&what, at(alpha), delta, 1e-10);
            assert!(
                at(1.01 * alpha) > delta && at(0.99 * alpha) < delta,
                "{what}"
            );
            let beta = below(port.largest_beta(delta, other).expect("valid"));
            let at = |beta: f64| port.required_delta(other, beta).expect("valid").delta;
            assert_relative(&what, at(beta), delta, 1e-10);
            assert!(at(1.01 * beta) > delta, "{what}");
        }
    }
}

#[test]
fn with_units_the_mass_drops_out_behind_a_delay_too() {
    let operator = ExactDifference(order(1.0));
    let port = port(&operator, 1.0, path(0.5, 0.0));
    let required = port
        .required_damping(Seconds(1e-3), 4000.0, 0.0)
        .expect("valid");
    // 1.059 KT
    let want = 0.5 * 4.0 * (1.0 + 1.25_f64.sqrt());
    assert_close("b", required, want, 1e-9);
}
