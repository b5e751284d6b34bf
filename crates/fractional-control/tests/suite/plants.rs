//! Plants in samples: matrices exactly, transfer functions to second order, measured responses between their points.

use crate::fixture::{bdf2, of_impulse_response, p, plant, states};
use core::f64::consts::PI;
use fracdiff::{FrequencyResponse, Seconds};
use fractional_control::{
    Actuator, ControllerParameters, CroneParameters, FractionalPid, FractionalTransferFunction,
    HeldPlant, LeadController, LeadLagParameters, PidParameters, Plant, PowerMemory,
    SampledControlLoop, SetPoint, StateSpace, TidParameters, num_complex::Complex,
};
use nalgebra::{DMatrix, DVector, RowDVector};
use testkit::{Tested, assert_close};

fn memory() -> PowerMemory {
    bdf2(1e-9, 50.0)
}

/// 1/(s² + 0.6 s + 2) as matrices.
fn second_order() -> StateSpace {
    states([[0.0, 1.0], [-2.0, -0.6]], [0.0, 1.0], [1.0, 0.0])
}

fn run(plant: &Plant, t: f64, input: impl Fn(usize) -> f64, samples: usize) -> Vec<f64> {
    let plant = HeldPlant::new(plant, memory(), Seconds(t)).expect("valid");
    let mut state = plant.at_rest();
    (0..samples)
        .map(|n| plant.step(&mut state, input(n)))
        .collect()
}

#[test]
fn matrices_are_sampled_exactly_whatever_the_delay_and_lag() -> Tested {
    // A late step at T = 0.2 is the same curve, moved; the lag multiplies by 1/(τs + 1).
    let states = second_order().behind_lag(0.3)?;
    let fine = Plant::state_space(states.clone(), 0.0)?;
    let fine = run(&fine, 0.01, |_| 1.0, 2000);
    for delay in [0.0, 0.07, 0.2, 0.43] {
        let plant = Plant::state_space(states.clone(), delay)?;
        let coarse = run(&plant, 0.2, |_| 1.0, 90);
        for (n, y) in coarse.iter().enumerate() {
            let late = (n as f64 * 0.2 - delay) / 0.01;
            let want = if late <= 0.0 {
                0.0
            } else {
                fine[late.round() as usize]
            };
            assert_close(&format!("{delay} {n}"), *y, want, 1e-12);
        }
    }
    Ok(())
}

#[test]
fn a_transfer_function_is_the_same_plant_to_second_order() -> Tested {
    // The same function with the factor √s + 1 above and below, so that its orders are not whole.
    let function: FractionalTransferFunction =
        "(s^0.5+1)/(s^2.5+s^2+0.6s^1.5+0.6s+2s^0.5+2)".parse()?;
    for delay in [0.0, 0.013, 0.2] {
        let exact = Plant::state_space(second_order(), delay)?;
        let other = Plant::transfer(function, delay)?;
        let error = |t: f64| {
            let samples = (8.0 / t) as usize;
            let input = |n: usize| (n as f64 * t * 1.7).sin();
            let (a, b) = (
                run(&exact, t, input, samples),
                run(&other, t, input, samples),
            );
            let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
            apart.fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(0.02), error(0.01));
        // A few T².
        assert!(
            fine < 5e-4 && coarse / fine > 3.0,
            "{delay}: {coarse} {fine}"
        );
    }
    Ok(())
}

#[test]
fn a_function_of_whole_orders_is_sampled_as_exactly_as_its_matrices() -> Tested {
    let function: FractionalTransferFunction = "1/(s^2+0.6s+2)".parse()?;
    for delay in [0.0, 0.013, 0.2] {
        let written = Plant::transfer(function, delay)?;
        let matrices = Plant::state_space(second_order(), delay)?;
        let input = |n: usize| (n as f64 * 0.17).sin();
        let [a, b] = [written, matrices].map(|plant| run(&plant, 0.1, input, 100));
        assert_eq!(a, b);
    }
    Ok(())
}

/// A controller of each kind: its parameters, and as it is run.
fn one_of_each(t: Seconds) -> [(ControllerParameters, Box<dyn FrequencyResponse>); 4] {
    let (tid, crone, lead) = (
        TidParameters {
            tilt: 2.0,
            tilt_divisor: 3.0,
            integral: 0.7,
            derivative: 0.1,
        },
        CroneParameters {
            gain: 3.0,
            order: -1.4,
            low_rad_s: 0.5,
            high_rad_s: 60.0,
        },
        LeadLagParameters {
            gain: 2.0,
            lambda_s: 0.2,
            x: 0.1,
            order: 0.6,
        },
    );
    let pid = PidParameters {
        proportional: 2.0,
        integral: 1.5,
        integral_order: 1.3,
        derivative: 0.3,
        derivative_order: 1.2,
    };
    let free = Actuator::UNLIMITED;
    let runs = FractionalPid::<f64, 112>::new(pid, SetPoint::DEFAULT, free, memory(), t);
    let tilts = FractionalPid::<f64, 112>::tid(tid, 0.0, free, memory(), t);
    let shapes = LeadController::<f64, 112>::crone(crone, free, memory(), t);
    let leads = LeadController::<f64, 112>::lead_lag(lead, free, memory(), t);
    [
        (pid.into(), Box::new(runs.expect("valid"))),
        (tid.into(), Box::new(tilts.expect("valid"))),
        (crone.into(), Box::new(shapes.expect("valid"))),
        (lead.into(), Box::new(leads.expect("valid"))),
    ]
}

#[test]
fn the_curve_of_the_verdict_is_the_plant_that_runs() -> Tested {
    let function: FractionalTransferFunction = "(s^0.5+2)/(s^1.7+0.5s^0.9+1)".parse()?;
    let plants = [
        Plant::transfer(function, 0.13)?,
        Plant::state_space(second_order().behind_lag(0.05)?, 0.13)?,
    ];
    for plant in plants {
        let (t, gain) = (0.05, p(1.0));
        let sampled = HeldPlant::new(&plant, memory(), Seconds(t))?;
        let closed = SampledControlLoop::new(gain.into(), memory(), &sampled)?;
        let weights = run(&plant, t, |n| f64::from(u8::from(n == 0)), 40_000);
        for theta in [0.05, 0.4, 1.5, PI] {
            let want = of_impulse_response(&weights, theta);
            let have = closed.open(theta);
            // What is cut off, a power law that oscillates.
            let cut = 2.0 * weights[39_999].abs() / theta;
            assert!((have - want).norm() < 1e-7 + cut, "{theta}: {have} {want}");
        }
        // Near rest it is the continuous plant behind half a sample of hold.
        let omega = 0.2;
        let half = Complex::from_polar(1.0, -omega * t / 2.0);
        let want = plant.response(omega).expect("known") * half;
        let have = closed.open(omega * t);
        assert!((have - want).norm() < 1e-4 * want.norm(), "{have} {want}");
    }
    Ok(())
}

#[test]
fn a_measured_response_is_read_between_its_points() {
    let plant: Plant = "2*exp(-0.3s)/(s^1.2+1)".parse().expect("valid");
    let points: Vec<_> = (0..=200)
        .map(|k| 0.01 * 1.04_f64.powi(k))
        .map(|omega| (omega, plant.response(omega).expect("any")))
        .collect();
    let measured = Plant::measured(&points).expect("valid");
    for omega in [0.0101, 0.3, 1.234, 20.0] {
        let have = measured.response(omega).expect("inside");
        let want = plant.response(omega).expect("any");
        // Straight lines across 4 %.
        assert!((have / want - 1.0).norm() < 5e-3, "{omega}: {have} {want}");
    }
    assert_eq!(measured.response(0.009), None);
    assert_eq!(measured.response(1e3), None);
    for bad in [
        &points[..2],
        &[points[0], points[0], points[1]][..],
        &[(0.0, points[0].1); 3][..],
    ] {
        assert!(Plant::measured(bad).is_err());
    }
    assert!(HeldPlant::new(&measured, memory(), Seconds(0.1)).is_err());
}

#[test]
fn what_is_no_plant_is_refused() -> Tested {
    let text = |text: &str| text.parse::<Plant>().expect_err(text).to_string();
    assert!(text("exp(0.5s)/(s+1)").starts_with("dead time -0.5 s is not at least 0"));
    assert!(text("s^2/(s+1)").contains("order 2 exceeds"));
    let unstable: Plant = "1/(s^1.5-1)".parse()?;
    let message = unstable.stable_by_itself().expect_err("unstable");
    let want = "the plant has a pole that does not decay: close the loop with a controller first";
    assert_eq!(message.to_string(), want);
    let wrong = StateSpace::new(
        DMatrix::zeros(2, 3),
        DVector::zeros(2),
        RowDVector::zeros(2),
    );
    assert!(wrong.is_err());
    assert!(second_order().behind_lag(-1.0).is_err());
    let fast = second_order().behind_lag(1e-10)?;
    let fast = Plant::state_space(fast, 0.0)?;
    let error = HeldPlant::new(&fast, memory(), Seconds(0.1)).expect_err("too fast");
    let words = "sample time 0.1 s is not within 1e8 time constants of the fastest pole";
    assert!(error.to_string().starts_with(words), "{error}");
    Ok(())
}

#[test]
fn the_curve_of_the_verdict_is_the_controller_that_runs() {
    let t = Seconds(0.01);
    // A gain of 1 that does nothing but be one sample late.
    let lag: Plant = "exp(-0.03s)/(s+1)".parse().expect("valid");
    let plant = HeldPlant::new(&lag, memory(), t).expect("valid");
    let alone = p(1.0);
    let closed = |parameters: ControllerParameters| {
        SampledControlLoop::new(parameters, memory(), &plant).expect("valid")
    };
    for (parameters, runs) in one_of_each(t) {
        let verdict = closed(parameters).verdict();
        assert_ne!(verdict.unstable_poles, None, "{parameters:?}");
        for theta in [1e-3, 0.05, 0.7, PI] {
            let have = closed(parameters).open(theta) / closed(alone.into()).open(theta);
            let want = runs.response(theta);
            let error = (have - want).norm() / want.norm();
            assert!(error < 1e-9, "{parameters:?} {theta}: {have} {want}");
        }
    }
}

#[test]
fn a_plant_has_one_verdict_in_notation_and_as_matrices() -> Tested {
    let memory = bdf2(1e-6, 100.0);
    // Plant, its pole, T; the held loop turns unstable at a gain of (1 + e^(pT))/(e^(pT) − 1)·|p|.
    for (text, pole, t) in [
        ("1/(s-1)", 1.0, 1e-3),
        ("1/(s+1)", -1.0, 10.0),
        ("1/(s+1)", -1.0, 0.1),
    ] {
        let e = f64::exp(pole * t);
        let limit = pole * (1.0 + e) / (e - 1.0);
        let matrices = Plant::state_space(states([[pole]], [1.0], [1.0]), 0.0);
        for plant in [plant(text), matrices?] {
            let sampled = HeldPlant::new(&plant, memory, Seconds(t))?;
            assert!(sampled.is_exact());
            for (share, stable) in [(0.99, true), (1.01, false)] {
                let gain = p(share * limit);
                let closed = SampledControlLoop::new(gain.into(), memory, &sampled)?;
                assert_eq!(
                    closed.verdict().stable,
                    stable,
                    "{text}, T = {t} s, {share}"
                );
            }
        }
    }
    Ok(())
}
