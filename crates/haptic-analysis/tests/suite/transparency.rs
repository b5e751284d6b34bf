//! The feel of the environment and the closed loop, against the definitions and their limits.

use fracdiff::{ExactDifference, MuirPolynomial, Order, Seconds};
use haptic_analysis::{ClosedLoop, Effective, ForcePath, SampledWall};
use num_complex::Complex;
use proptest::prelude::*;
use std::f64::consts::PI;
use testkit::operator::{exact, order, path};
use testkit::{assert_close, assert_refused};

/// Figure 6.2: m = 0.65 kg, b = 3.5 N·s/m, K = 50 N/m, B = 1 N·s^μ/m; T is not given, 1 ms here.
fn figure_6_2(mu: f64) -> ClosedLoop {
    ClosedLoop {
        mass_kg: 0.65,
        damping_n_s_per_m: 3.5,
        environment: SampledWall {
            stiffness_n_per_m: 50.0,
            dissipation_n_s_mu_per_m: 1.0,
            order: order(mu),
            sample_time_s: 1e-3,
        },
        path: ForcePath::NONE,
    }
}

fn with_sample_time(mut closed: ClosedLoop, t: f64) -> ClosedLoop {
    closed.environment.sample_time_s = t;
    closed
}

#[test]
fn the_environment_is_the_closed_form_of_the_exact_operator() {
    // Figure 3.4: K = 10 N/mm, B = 0.1 N·s^μ/mm, T = 1 ms, with the T^(−μ) the dissertation drops.
    let (k, b, t) = (1e4, 100.0, 1e-3);
    for mu in [-0.5, 0.0, 0.5, 1.0, 1.5, 2.0] {
        let environment = SampledWall {
            stiffness_n_per_m: k,
            dissipation_n_s_mu_per_m: b,
            order: order(mu),
            sample_time_s: t,
        };
        for omega in [1.0, 100.0, 2000.0, PI / t] {
            let theta = omega * t;
            let size = b * (2.0 * (0.5 * theta).sin() / t).powf(mu);
            let angle = 0.5 * mu * (PI - theta);
            let have = environment.effective(&exact(mu), omega).expect("valid");
            let what = format!("μ {mu} ω {omega}");
            let scale = k + size;
            assert_close(
                &what,
                have.stiffness_n_per_m,
                k + size * angle.cos(),
                1e-12 * scale,
            );
            assert_close(
                &what,
                have.damping_n_s_per_m,
                size * angle.sin() / omega,
                1e-12 * scale / omega,
            );
        }
    }
}

#[test]
fn a_muir_environment_shows_its_false_spring_at_rest() {
    // P(1) = (1−μ)(3−μ)/3: B·T^(−μ) times that is felt as stiffness, negative between 1 and 3.
    let t = 1e-3;
    for mu in [0.5, 1.0, 1.5, 2.0] {
        let environment = SampledWall {
            stiffness_n_per_m: 0.0,
            dissipation_n_s_mu_per_m: 1.0,
            order: order(mu),
            sample_time_s: t,
        };
        let operator = MuirPolynomial::<f64, 3>::new(order(mu), Seconds(t)).expect("valid");
        let have = environment.effective(&operator, 1e-3).expect("valid");
        let want = t.powf(-mu) * (1.0 - mu) * (3.0 - mu) / 3.0;
        assert_close(
            &format!("μ {mu}"),
            have.stiffness_n_per_m,
            want,
            1e-9 * t.powf(-mu),
        );
    }
}

#[test]
fn the_closed_forms_are_the_definition_of_the_closed_loop() {
    for mu in [-0.5, 0.0, 0.3, 1.0, 1.5, 2.0] {
        for delay in [0.0, 2.0] {
            let closed = ClosedLoop {
                path: path(delay, 0.0),
                ..figure_6_2(mu)
            };
            let t = closed.environment.sample_time_s;
            for omega in [0.1, 5.0, 60.0, 1000.0, PI / t] {
                let j = Complex::new(0.0, 1.0);
                let late = (-j * omega * t * (0.5 + delay)).exp();
                let z = |h: Complex<f64>| j * omega * 0.65 + 3.5 + h * late / (j * omega);
                let derivative = (j * omega).powf(mu);
                let difference = ((1.0 - (-j * omega * t).exp()) / t).powf(mu);
                let cases = [
                    (closed.continuous(omega), z(derivative + 50.0)),
                    (closed.sampled(&exact(mu), omega), z(difference + 50.0)),
                ];
                for (have, z) in cases {
                    let have = have.expect("valid");
                    let what = format!("μ {mu} ω {omega} d {delay}");
                    let scale = 1e-11 * (1.0 + z.norm());
                    assert_close(&what, have.stiffness_n_per_m, -omega * z.im, scale * omega);
                    assert_close(&what, have.damping_n_s_per_m, z.re, scale);
                }
            }
        }
    }
}

#[test]
fn bad_input_is_refused_in_words() {
    let closed = figure_6_2(1.0);
    let words = |result: Result<Effective, haptic_analysis::AnalysisError>| {
        result.expect_err("out of range").to_string()
    };
    let frequency = "rad/s is not above 0 and at most π/T";
    assert_eq!(
        words(closed.continuous(0.0)),
        format!("angular frequency 0 {frequency}")
    );
    assert_eq!(
        words(closed.continuous(3142.0)),
        format!("angular frequency 3142 {frequency}")
    );
    assert!(closed.continuous(f64::NAN).is_err());
    assert!(closed.sampled(&exact(1.0), 1e9).is_err());
    let wrong = ClosedLoop {
        mass_kg: -1.0,
        ..closed
    };
    assert_eq!(words(wrong.continuous(1.0)), "mass -1 kg is not above 0 kg");
    let wrong = ClosedLoop {
        damping_n_s_per_m: -1.0,
        ..closed
    };
    assert_eq!(
        words(wrong.continuous(1.0)),
        "damping -1 N·s/m is not at least 0 N·s/m"
    );
    let mut wrong = closed;
    wrong.environment.stiffness_n_per_m = -1.0;
    assert!(wrong.sampled(&exact(1.0), 1.0).is_err());
    assert!(wrong.environment.effective(&exact(1.0), 1.0).is_err());
    assert!(with_sample_time(closed, 0.0).continuous(1.0).is_err());
    // Too small for 1/ω to be a number.
    assert!(closed.continuous(1e-310).is_err());
}

proptest! {
    #[test]
    fn every_result_is_a_number(
        mu in -2.0..=2.0_f64, k in 0.0..1e6_f64, b in 0.0..1e4_f64, t in 1e-6..1.0_f64,
        share in 1e-6..=1.0_f64, delay in 0..20_u32,
    ) {
        let mut closed = ClosedLoop { path: path(f64::from(delay), 0.0), ..figure_6_2(mu) };
        closed.environment.stiffness_n_per_m = k;
        closed.environment.dissipation_n_s_mu_per_m = b;
        let closed = with_sample_time(closed, t);
        let omega = share * PI / t;
        let operator = MuirPolynomial::<f64, 3>::new(order(mu), Seconds(t)).expect("valid");
        let results = [
            closed.continuous(omega),
            closed.sampled(&exact(mu), omega),
            closed.sampled(&operator, omega),
            closed.environment.effective(&operator, omega),
        ];
        for felt in results {
            let felt = felt.expect("valid");
            prop_assert!(felt.stiffness_n_per_m.is_finite() && felt.damping_n_s_per_m.is_finite());
        }
    }

}

#[test]
fn any_linear_device_is_felt_as_its_impedance_says() {
    let order = Order::new(0.5).expect("in range");
    let environment = SampledWall {
        stiffness_n_per_m: 500.0,
        dissipation_n_s_mu_per_m: 3.0,
        order,
        sample_time_s: 1e-3,
    };
    let (mass, damping) = (0.065, 3.5);
    let path = ForcePath::new(1.3, 0.7).expect("in range");
    let operator = ExactDifference(order);
    let closed = ClosedLoop {
        mass_kg: mass,
        damping_n_s_per_m: damping,
        environment,
        path,
    };
    for omega in [1e-2, 1.0, 70.0, 900.0, 3000.0] {
        let impedance = Complex::new(damping, omega * mass);
        let have = environment
            .felt_on(impedance, path, &operator, omega)
            .expect("felt");
        let want = closed.sampled(&operator, omega).expect("felt");
        let scale = want.stiffness_n_per_m.abs().max(500.0);
        assert_close(
            "have.stiffness_n_per_m",
            have.stiffness_n_per_m,
            want.stiffness_n_per_m,
            1e-12 * scale,
        );
        assert_close(
            "have.damping_n_s_per_m",
            have.damping_n_s_per_m,
            want.damping_n_s_per_m,
            1e-12 * scale / omega.min(1.0),
        );
    }
    // A second mass behind a spring: Z = b + jωm + 1/(1/(jωM) + jω/κ), in resonance with the first no mass at all.
    let (second, spring) = (0.02, 300.0);
    let omega = f64::sqrt(spring * (mass + second) / (mass * second));
    let behind =
        (Complex::new(0.0, omega * second).inv() + Complex::new(0.0, omega / spring)).inv();
    let device = Complex::new(damping, omega * mass) + behind;
    let felt = environment
        .felt_on(device, ForcePath::NONE, &operator, omega)
        .expect("felt");
    let massless = ClosedLoop {
        mass_kg: 1e-12,
        path: ForcePath::NONE,
        ..closed
    };
    let want = massless.sampled(&operator, omega).expect("felt");
    assert_close(
        "felt.stiffness_n_per_m",
        felt.stiffness_n_per_m,
        want.stiffness_n_per_m,
        1e-6 * want.stiffness_n_per_m,
    );
    let broken = environment.felt_on(Complex::new(f64::NAN, 0.0), path, &operator, 1.0);
    assert_refused(broken, "impedance of the device NaN N·s/m is not finite");
}
