//! Passivity of the sampled port: its closed form, what it asks for, and what it is worth.

use super::{Case, T, enough, exact, operator};
use fracdiff::{ExactDifference, FrequencyResponse as _};
use haptic_analysis::{
    CoupledLoop, CoupledObject, Coupler, CouplerOperator, Dynamics, ForcePath, LeastDamping,
};
use num_complex::Complex;
use std::f64::consts::PI;
use testkit::operator::order;
use testkit::{Random, assert_relative};

#[test]
fn the_sampled_port_of_springs_and_dampers_is_known_in_closed_form() {
    let late = |d: u32| ForcePath::new(f64::from(d), 0.0).expect("valid");
    let sampled =
        |coupler: &Coupler<'_>, d| enough(coupler.sampled_damping(late(d)).expect("valid"));
    for d in [0, 1, 2, 7] {
        // (d + 1)²·b_c·T/2, at rest.
        let want = 0.5 * T * 1000.0 * f64::from((d + 1) * (d + 1));
        assert_relative("spring", sampled(&exact(1.0, 0.0, 1000.0), d), want, 1e-7);
        assert_relative("damper", sampled(&exact(1.0, 3.0, 0.0), d), 3.0, 1e-12);
    }
    // The same from another side: the operator that runs, P = (1 − w)/Q.
    let identity = operator("full", 1.0);
    let runs = CouplerOperator(&identity);
    let spring = exact(1.0, 0.0, 1000.0).with_operator(&runs, 1);
    assert_relative("as it runs", sampled(&spring, 0), 0.5, 1e-7);
}

#[test]
fn llewellyn_asks_for_less_than_a_quarter_of_what_the_sampled_port_needs() {
    let mut random = Random(34);
    for n in 0..60 {
        let mu = [0.0, 0.2, 0.5, 0.8, 1.0][n % 5];
        let (damper, spring) = (random.or_nothing(5.0), random.log_between(0.1, 5.0));
        let coupler = exact(mu, damper, spring * T.powf(-mu));
        let tustin = enough(coupler.least_damping().expect("valid"));
        let sampled = enough(coupler.sampled_damping(ForcePath::NONE).expect("valid"));
        let least = 4.0 * tustin * (1.0 - 1e-9);
        assert!(sampled >= least, "{coupler:?}: {sampled} {tustin}");
    }
}

/// b that passivity at one angle asks of this device with c = −wM, V and the impedance Z.
fn asked(late: Complex<f64>, variance: f64, z: Complex<f64>) -> f64 {
    let r = (-late * z).re;
    0.5 * (r + (r * r + variance * z.norm_sqr()).sqrt())
}

/// wM and V of a delay of d + h samples without lag.
fn path(delay: f64, theta: f64) -> (Complex<f64>, f64) {
    let w = Complex::from_polar(1.0, -theta);
    let (d, h) = (delay.floor(), delay.fract());
    let v = Complex::new(1.0, 0.0) - w;
    let late = w * Complex::from_polar(1.0, -theta * d) * (-v * h + 1.0);
    (late, h * (1.0 - h) * v.norm_sqr())
}

#[test]
fn no_passive_object_asks_for_more_and_one_asks_for_all() {
    let mut random = Random(35);
    for n in 0..40 {
        let mu = [0.1, 0.4, 0.6, 0.9][n % 4];
        let delay = [0.0, 0.0, 0.4, 1.0, 2.3][n % 5];
        let k_c = random.or_nothing(5.0);
        let b_c = random.log_between(0.1, 5.0) * T.powf(-mu);
        let coupler = exact(mu, k_c, b_c);
        let way = ForcePath::new(delay, 0.0).expect("valid");
        let LeastDamping::Enough {
            damping_n_s_per_m: least,
            worst_theta,
        } = coupler.sampled_damping(way).expect("valid")
        else {
            panic!("below order 1 some damping is enough");
        };
        let admittance = |theta: f64| {
            let v = ExactDifference(order(1.0)).response(theta);
            1.0 / ((Complex::new(T, 0.0) / v).powf(mu) * b_c + k_c)
        };
        for _ in 0..200 {
            let theta = random.log_between(1e-3, PI);
            let y = admittance(theta);
            let real = random.or_nothing(2.0 * y.re);
            let object = Complex::new(real, random.between(-3.0, 3.0) * y.norm());
            let (late, variance) = path(delay, theta);
            let need = asked(late, variance, 1.0 / (y + object));
            assert!(
                need <= least * (1.0 + 1e-9),
                "{n}, θ {theta}: {need} {least}"
            );
        }
        // The object that asks for it: Y = Re(1/Z_c) + j·Im(c)/(2b).
        let y = admittance(worst_theta);
        let (late, variance) = path(delay, worst_theta);
        let whole = Complex::new(y.re, -late.im / (2.0 * least));
        let need = asked(late, variance, 1.0 / whole);
        assert_relative(&format!("case {n}, d + h {delay}"), need, least, 1e-6);
    }
}

#[test]
fn passive_by_the_sampled_criterion_is_stable_with_every_hand_and_object() {
    let mut random = Random(36);
    for n in 0..150 {
        let mu = [0.0, 0.25, 0.5, 0.75, 1.0][n % 5];
        let operator = operator("full", mu);
        let mut case = Case::random(&mut random, mu);
        let runs = CouplerOperator(&operator);
        let path = case.device.path(T).expect("valid");
        let unit = exact(mu, case.gains[0], case.gains[1]).with_operator(&runs, 1);
        let least = unit.sampled_damping(path).expect("valid");
        let share = 0.999 * case.device.damping_n_s_per_m / enough(least);
        case.gains = case.gains.map(|gain| share * gain);
        assert!(case.closed(&operator).is_stable(), "case {n}");
    }
}

#[test]
fn llewellyn_passive_does_not_mean_stable_in_the_sampled_loop() {
    // 8b ≥ k_c holds, and the sampled mass throws itself about: k_c·T/m = 4.8 > 2.
    let (b, m) = (3.0, 5e-3);
    let damper = exact(1.0, 24.0, 0.0);
    assert!(damper.passive(b).expect("valid"));
    let heavy = CoupledObject {
        mass_kg: 1.0,
        damping_n_s_per_m: 0.0,
        stiffness_n_per_m: 0.0,
    };
    let operator = operator("exact", 1.0);
    let coupled = CoupledLoop::new(&Dynamics::ideal(m, b), &damper, &heavy, &operator);
    assert!(coupled.expect("valid").unstable_poles() > Some(0));
}
