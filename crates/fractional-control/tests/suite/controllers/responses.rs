//! The response of a controller on the circle: as it is run, and as its parameters say.

use super::{GAINS, T, memory, pid};
use core::f64::consts::PI;
use fracdiff::FrequencyResponse;
use fractional_control::{
    Actuator, Controller, ControllerParameters, CroneParameters, FractionalPid,
    FractionalTransferFunction, LeadController, LeadLagParameters, PidParameters, Rule, SetPoint,
    TidParameters, num_complex::Complex,
};

/// −u/y from the impulse response, on the circle.
fn measured<C: Controller<f64>>(controller: &C, theta: f64) -> Complex<f64> {
    let mut history = controller.at_rest();
    let mut sum = Complex::new(0.0, 0.0);
    for n in 0..60_000 {
        let y = if n == 0 { -1.0 } else { 0.0 };
        let u = controller.output(&history, 0.0, y);
        controller.advance(&mut history, 0.0, y, u);
        sum += Complex::from_polar(u, -theta * f64::from(n));
    }
    sum
}

const NO_INTEGRAL: PidParameters = PidParameters {
    integral: 0.0,
    ..GAINS
};

const CRONE: CroneParameters = CroneParameters {
    gain: 3.0,
    order: 1.4,
    low_rad_s: 5.0,
    high_rad_s: 400.0,
};

const LAG: LeadLagParameters = LeadLagParameters {
    gain: 2.0,
    lambda_s: 0.02,
    x: 7.0,
    order: 0.6,
};

const TID: TidParameters = TidParameters {
    tilt: 2.0,
    tilt_divisor: 3.0,
    integral: 0.7,
    derivative: 0.1,
};

fn crone(shape: CroneParameters) -> LeadController<f64, 64> {
    LeadController::crone(shape, Actuator::UNLIMITED, memory(Rule::Grunwald), T).expect("valid")
}

fn lead_lag(shape: LeadLagParameters) -> LeadController<f64, 64> {
    LeadController::lead_lag(shape, Actuator::UNLIMITED, memory(Rule::Grunwald), T).expect("valid")
}

#[test]
fn each_controller_has_the_response_that_it_says_and_near_rest_the_continuous_one() {
    let pid = pid(NO_INTEGRAL, SetPoint::DEFAULT, Actuator::UNLIMITED);
    let (crone, lag) = (crone(CRONE), lead_lag(LAG));
    for theta in [0.03, 0.4, 2.0, PI] {
        for (name, have, want) in [
            ("pid", pid.response(theta), measured(&pid, theta)),
            ("crone", crone.response(theta), measured(&crone, theta)),
            ("lag", lag.response(theta), measured(&lag, theta)),
        ] {
            // What is cut off of a power law after 60 s.
            assert!(
                (have - want).norm() < 1e-4 * have.norm(),
                "{name} {theta}: {have} {want}"
            );
        }
    }
    for omega in [1.0, 10.0, 50.0] {
        let theta = omega * T.0;
        for (name, have, want) in [
            ("pid", pid.response(theta), NO_INTEGRAL.response(omega)),
            ("crone", crone.response(theta), CRONE.response(omega)),
            ("lag", lag.response(theta), LAG.response(omega)),
        ] {
            // O(T²): (ωT)²/3 at 50 rad/s.
            assert!(
                (have - want).norm() < 1.5e-3 * want.norm(),
                "{name} {omega}: {have} {want}"
            );
        }
    }
    let runs = FractionalPid::<f64, 64>::tid(TID, 0.0, Actuator::UNLIMITED, memory(Rule::Bdf2), T)
        .expect("valid");
    let (have, want) = (runs.response(0.02), TID.response(20.0));
    assert!((have - want).norm() < 1e-3 * want.norm(), "{have} {want}");
}

#[test]
fn crone_keeps_its_phase_over_the_band_and_lead_of_order_one_is_the_plain_filter() {
    let crone = crone(CroneParameters {
        gain: 1.0,
        order: 0.5,
        low_rad_s: 0.1,
        high_rad_s: 1000.0,
    });
    let phases = [3.0, 10.0, 30.0].map(|omega: f64| crone.response(omega * T.0).arg().to_degrees());
    for phase in phases {
        // 45° less what the corners take: 0.5·(90° − atan 30 + atan 0.03).
        assert!((phase - 45.0).abs() < 2.0, "{phases:?}");
    }
    let lead = lead_lag(LeadLagParameters {
        gain: 4.0,
        lambda_s: 0.1,
        x: 0.2,
        order: 1.0,
    });
    for theta in [0.0, 0.3, PI] {
        // (s + 10)/(s + 50) with s = (2/T)(1 − w)/(1 + w), by hand.
        let w = Complex::from_polar(1.0, -theta);
        let s = |k: f64| (Complex::new(1.0, 0.0) - w) * 2000.0 + (w + 1.0) * k;
        let want = s(10.0) / s(50.0) * 4.0;
        let have = lead.response(theta);
        assert!(
            (have - want).norm() < 1e-9 * want.norm(),
            "{theta}: {have} {want}"
        );
    }
}

#[test]
fn a_scaled_law_answers_that_many_times_as_much() {
    let function: FractionalTransferFunction = "(s^0.5+2)/(0.1s+1)".parse().expect("valid");
    let laws: [ControllerParameters; 5] = [
        GAINS.into(),
        TID.into(),
        CRONE.into(),
        LAG.into(),
        function.into(),
    ];
    for law in laws {
        let scaled = law.scaled(-2.5).expect("finite");
        for omega in [0.1, 3.0, 200.0] {
            let (have, want) = (scaled.response(omega), law.response(omega) * -2.5);
            assert!((have - want).norm() < 1e-12 * want.norm(), "{law}: {have}");
        }
    }
    assert!(
        ControllerParameters::from(function)
            .scaled(f64::INFINITY)
            .is_err()
    );
}
