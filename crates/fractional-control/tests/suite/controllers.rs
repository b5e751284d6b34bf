//! Controllers: their equation, changes without a bump, refusals.

mod responses;

use fracdiff::Seconds;
use fractional_control::{
    Actuator, Controller, CroneParameters, FractionalPid, HeldPlant, LeadController, Mode,
    PidParameters, Plant, PowerMemory, Rule, SetPoint, Station,
};
use testkit::{Tested, assert_close};

const T: Seconds = Seconds(1e-3);

const GAINS: PidParameters = PidParameters {
    proportional: 2.0,
    integral: 1.5,
    integral_order: 0.8,
    derivative: 0.3,
    derivative_order: 0.6,
};

fn memory(rule: Rule) -> PowerMemory {
    PowerMemory::new(rule, 1e-7, 200.0).expect("valid")
}

fn pid(gains: PidParameters, set_point: SetPoint, actuator: Actuator) -> FractionalPid<f64, 64> {
    FractionalPid::new(gains, set_point, actuator, memory(Rule::Bdf2), T).expect("valid")
}

#[test]
fn a_constant_error_gives_the_power_laws_of_integral_and_derivative() {
    let pid = pid(GAINS, SetPoint::ERROR, Actuator::UNLIMITED);
    let mut history = pid.at_rest();
    for n in 0..=5000 {
        // A step lies between two samples.
        let r = if n == 0 { 0.5 } else { 1.0 };
        let u = pid.output(&history, r, 0.0);
        if n % 1000 == 500 {
            let t = f64::from(n) * T.0;
            let want = 2.0
                + 1.5 * t.powf(0.8) / libm::tgamma(1.8)
                + 0.3 * t.powf(-0.6) / libm::tgamma(0.4);
            assert!((u - want).abs() < 1e-5, "{n}: {u} {want}");
        }
        pid.advance(&mut history, r, 0.0, u);
    }
}

#[test]
fn a_step_of_the_reference_kicks_as_much_as_its_weights_say() {
    let gains = PidParameters {
        integral: 0.0,
        ..GAINS
    };
    let kick = |proportional, derivative| {
        let weights = SetPoint {
            proportional,
            derivative,
        };
        let pid = pid(gains, weights, Actuator::UNLIMITED);
        pid.output(&pid.at_rest(), 1.0, 0.0)
    };
    assert_eq!(
        [kick(0.0, 0.0), kick(1.0, 0.0), kick(0.5, 0.0)],
        [0.0, 2.0, 1.0]
    );
    assert!(kick(0.0, 1.0) > 10.0);
}

#[test]
fn limits_hold_and_a_nan_is_not_hidden() {
    let actuator = Actuator::new(-1.0, 3.0).expect("valid");
    let pid = pid(GAINS, SetPoint::DEFAULT, actuator);
    let history = pid.at_rest();
    assert_eq!(pid.output(&history, 1e9, 0.0), 3.0);
    assert_eq!(pid.output(&history, -1e9, 0.0), -1.0);
    assert!(pid.output(&history, f64::NAN, 0.0).is_nan());
    let mut spoiled = history;
    pid.advance(&mut spoiled, 0.0, f64::NAN, 0.0);
    assert!(pid.output(&spoiled, 0.0, 0.0).is_nan());
}

/// Largest jump of the command between neighbouring samples, around sample 3000, where something changes.
fn bump(
    change: impl FnOnce(&mut Station<f64, FractionalPid<f64, 64>>, f64),
    manual_before: bool,
) -> f64 {
    let plant: Plant = "1/(0.2s+1)".parse().expect("valid");
    let plant = HeldPlant::new(&plant, memory(Rule::Bdf2), T).expect("valid");
    let mut state = plant.at_rest();
    let mut station = Station::new(pid(GAINS, SetPoint::DEFAULT, Actuator::UNLIMITED));
    if manual_before {
        station.set_mode(Mode::Manual(0.7));
    }
    let (mut change, mut last, mut most) = (Some(change), 0.0, 0.0_f64);
    for n in 0..15_000 {
        let y = plant.past(&state);
        if n == 3000 {
            change.take().expect("once")(&mut station, y);
        }
        let u = station.step(1.0, y);
        plant.advance(&mut state, u);
        if n >= 3000 {
            most = most.max((u - last).abs());
        }
        last = u;
    }
    // And it gets to the reference in the end.
    let error = (plant.past(&state) - 1.0).abs();
    assert!(error < 0.05 || manual_before, "{error}");
    most
}

#[test]
fn parameters_change_without_a_bump() {
    let with = |gains| {
        move |station: &mut Station<f64, FractionalPid<f64, 64>>, y: f64| {
            station.set_controller(pid(gains, SetPoint::DEFAULT, Actuator::UNLIMITED), 1.0, y);
        }
    };
    let changes: [fn(&mut PidParameters); 5] = [
        |gains| gains.proportional = 6.0,
        |gains| gains.integral = 6.0,
        |gains| gains.derivative = 0.9,
        |gains| gains.integral_order = 1.0,
        |gains| (gains.derivative_order, gains.integral_order) = (0.3, 0.95),
    ];
    for change in changes {
        let mut gains = GAINS;
        change(&mut gains);
        let bump = bump(with(gains), false);
        // The command is about 1; a plain exchange of the histories jumps by a tenth to one.
        assert!(bump < 1e-2, "{gains:?}: {bump}");
    }
}

#[test]
fn from_manual_to_automatic_the_command_goes_on() {
    let bump = bump(|station, _| station.set_mode(Mode::Automatic), true);
    assert!(bump < 2e-2, "{bump}");
}

#[test]
fn single_precision_agrees_with_double() -> Tested {
    let actuator = Actuator::new(-4.0, 4.0)?;
    let memory = memory(Rule::Grunwald);
    let single = FractionalPid::<f32, 64>::new(GAINS, SetPoint::DEFAULT, actuator, memory, T);
    let double = FractionalPid::<f64, 64>::new(GAINS, SetPoint::DEFAULT, actuator, memory, T);
    let (single, double) = (single?, double?);
    let (mut s, mut d) = (single.at_rest(), double.at_rest());
    for n in 0..50_000 {
        let y = (f64::from(n) * 3e-3).sin();
        let (a, b) = (single.output(&s, 0.5, y as f32), double.output(&d, 0.5, y));
        assert!((f64::from(a) - b).abs() < 1e-4, "{n}: {a} {b}");
        single.advance(&mut s, 0.5, y as f32, a);
        double.advance(&mut d, 0.5, y, b);
    }
    Ok(())
}

#[test]
fn bad_parameters_are_refused_in_one_line() {
    let pid = |gains| {
        let free = (SetPoint::DEFAULT, Actuator::UNLIMITED);
        FractionalPid::<f64, 64>::new(gains, free.0, free.1, memory(Rule::Bdf2), T).map(drop)
    };
    let crone = |low_rad_s, high_rad_s| {
        let shape = CroneParameters {
            gain: 1.0,
            order: 0.5,
            low_rad_s,
            high_rad_s,
        };
        let memory = memory(Rule::Bdf2);
        LeadController::<f64>::crone(shape, Actuator::UNLIMITED, memory, T).map(drop)
    };
    let off = |change: fn(&mut PidParameters)| {
        let mut gains = GAINS;
        change(&mut gains);
        pid(gains)
    };
    // Without gain of a part its order has no meaning.
    let none = off(|gains| (gains.integral, gains.integral_order) = (0.0, 9.0));
    assert_eq!(none, Ok(()));
    for (refused, text) in [
        (
            off(|gains| gains.proportional = f64::NAN),
            "proportional gain NaN is not 0, or from 1e-60 to 1e60 in size",
        ),
        (
            off(|gains| gains.integral_order = 0.0),
            "order of the integral 0 is not above 0 and at most 2",
        ),
        (
            off(|gains| gains.derivative_order = 2.1),
            "order of the derivative 2.1 is not above 0 and at most 2",
        ),
        (
            crone(10.0, 1.0),
            "lower corner 10 rad/s is not below the upper corner",
        ),
        (
            crone(1.0, 5000.0),
            "corner of the pole 5000 rad/s is not at most 2/T, twice the sample rate",
        ),
        (
            crone(-1.0, 10.0),
            "corner of the zero -1 rad/s is not above 0",
        ),
        (
            Actuator::new(2.0, 1.0).map(drop),
            "lower limit of the command 2 is not below the upper limit",
        ),
        (
            PowerMemory::new(Rule::Bdf2, 1e-6, 0.0).map(drop),
            "horizon 0 s is not above 0 s",
        ),
    ] {
        let error = refused.expect_err(text).to_string();
        assert!(error.starts_with(text) && !error.contains('\n'), "{error}");
    }
}

/// The shape of a step by hand.
#[test]
fn the_shape_of_a_ramp_up_to_a_little_too_much() {
    // 0, 0.2, … 2.2, then 2 for ever: a step of 2.
    let rise = (0..=11).map(|n| 0.2 * f64::from(n));
    let mut run = fractional_control::Response::default();
    run.measured = rise.chain([2.0; 5]).collect();
    let shape = run.shape_of_step(2.0);
    assert_close("shape.overshoot", shape.overshoot, 0.1, 1e-12);
    assert!(shape.rise.is_some_and(|rise| (rise - 8.0).abs() < 1e-9));
    assert_eq!(shape.settled, Some(12));
    assert!(shape.final_error < 1e-12);
    assert_eq!(run.shape_of_step(5.0).rise, None);
    assert_eq!(run.shape_of_step(5.0).settled, None);
}
