//! A start beside a running plant, and readings that are no numbers.

use crate::fixture::plant;
use fracdiff::{Real, Seconds};
use fractional_control::{
    Actuator, Controller, ControllerList, ControllerSetup, CroneParameters, FractionalPid,
    FunctionController, LeadController, MISSED_MOST, Memory, PidParameters, PortableController,
    Rule, SampledPlant, SetPoint, Station, TidParameters,
};

const T: Seconds = Seconds(1e-2);

fn memory(rule: Rule) -> Memory {
    Memory::new(rule, 1e-7, 200.0).expect("valid")
}

fn pid<F: Real>(text: &str, set_point: SetPoint, rule: Rule) -> FractionalPid<F, 64> {
    let gains: PidParameters = text.parse().expect("a controller");
    let actuator = Actuator::new(-10.0, 10.0).expect("valid");
    FractionalPid::new(gains, set_point, actuator, memory(rule), T).expect("valid")
}

const RULES: [Rule; 2] = [Rule::Grunwald, Rule::Bdf2];

/// A heater at 20 °C that is asked for 20 °C: from rest the derivative sees a jump of 20 and throws the command from limit to limit.
#[test]
fn a_controller_beside_a_plant_at_its_reference_does_nothing() {
    for text in [
        "2+1/s+0.5s",
        "2+1/s^0.8+0.5s^0.6",
        "2+1/s^1.3+0.1s^1.2",
        "2+0.5s",
        "3/s^2+5s",
    ] {
        for rule in RULES {
            let pid = pid::<f64>(text, SetPoint::DEFAULT, rule);
            let mut station = Station::new(pid);
            assert_eq!(station.settle(20.0, 20.0, 0.0), Some(0.0), "{text}");
            for n in 0..2000 {
                let u = station.step(20.0, 20.0);
                assert_eq!(u, 0.0, "{text} {rule:?} {n}");
            }
            // From rest it does: the test can fail.
            station.reset();
            let most = (0..20)
                .map(|_| station.step(20.0, 20.0).abs())
                .fold(0.0, f64::max);
            assert!(most > 1.0, "{text} {most}");
        }
    }
}

/// The command that stood goes on, whatever reference, measurement and weights.
#[test]
fn the_command_goes_on_where_an_integral_keeps_it() {
    for text in [
        "2+1/s+0.5s",
        "-0.5+2/s+0.1s^0.4",
        "2+1/s^1.3+0.1s^1.2",
        "3/s^2+5s",
    ] {
        for rule in RULES {
            for (b, c) in [(1.0, 0.0), (0.3, 0.0), (0.0, 1.0)] {
                let weights = SetPoint {
                    proportional: b,
                    derivative: c,
                };
                let pid = pid::<f64>(text, weights, rule);
                // At its reference for ever, to rounding.
                let mut history = pid.settled(20.0, 20.0, 4.5).expect("settles");
                for n in 0..3000 {
                    let u = pid.output(&history, 20.0, 20.0);
                    assert!((u - 4.5).abs() < 1e-10, "{text} {rule:?} {b} {n}: {u}");
                    pid.advance(&mut history, 20.0, 20.0, u);
                }
                // Away from it now, and from there as the law goes; a command beyond a limit is that limit.
                let history = pid.settled(1.5, 1.0, 4.5).expect("settles");
                assert!(
                    (pid.output(&history, 1.5, 1.0) - 4.5).abs() < 1e-10,
                    "{text}"
                );
                let history = pid.settled(1.5, 1.0, 45.0).expect("settles");
                assert!(
                    (pid.wanted(&history, 1.5, 1.0) - 10.0).abs() < 1e-10,
                    "{text}"
                );
            }
        }
    }
}

/// I^λ of an order below 1 fades, so the command is a bias that fades too, with 1 s: the loop takes it over without a jump.
#[test]
fn a_fractional_integral_takes_the_command_over() {
    let gains = "2+1.5/s^0.8+0.1s^0.6";
    let sampled = SampledPlant::new(&plant("1/(s+1)"), memory(Rule::Bdf2), T).expect("runs");
    let pid = pid::<f64>(gains, SetPoint::DEFAULT, Rule::Bdf2);
    let mut history = pid.settled(4.0, 4.0, 4.0).expect("settles");
    // The plant has stood at 4 for a command of 4.
    let mut state = sampled.at_rest();
    for _ in 0..4000 {
        sampled.advance(&mut state, 4.0);
    }
    let (mut last, mut most, mut away) = (4.0, 0.0_f64, 0.0_f64);
    for _ in 0..6000 {
        let y = sampled.past(&state);
        let u = pid.output(&history, 4.0, y);
        pid.advance(&mut history, 4.0, y, u);
        sampled.advance(&mut state, u);
        (most, away) = (most.max((u - last).abs()), away.max((y - 4.0).abs()));
        last = u;
    }
    let end = (sampled.past(&state) - 4.0).abs();
    assert!(
        most < 0.05 && away < 1.2 && end < 0.05,
        "{most} {away} {end}"
    );
}

#[test]
fn without_an_integral_the_bump_is_said() {
    let mut station = Station::new(pid::<f64>("2+0.5s^0.5", SetPoint::DEFAULT, Rule::Bdf2));
    // P of an error of 1, in place of 1.5.
    assert_eq!(station.settle(4.0, 3.0, 1.5), Some(0.5));
    assert_eq!(station.step(4.0, 3.0), 2.0);
}

#[test]
fn functions_of_the_error_settle_at_their_gain_or_are_refused() {
    let crone = CroneParameters {
        gain: 2.0,
        order: 1.6,
        low_rad_s: 1.0,
        high_rad_s: 50.0,
    };
    let free = Actuator::UNLIMITED;
    let crone =
        LeadController::<f64>::crone(crone, free, memory(Rule::Grunwald), T).expect("valid");
    let mut history = crone.settled(5.0, 4.0, 7.0).expect("settles");
    for _ in 0..100 {
        // The gain at rest of the weights that run.
        let u = crone.output(&history, 5.0, 4.0);
        assert!((u - 2.0).abs() < 1e-5, "{u}");
        crone.advance(&mut history, 5.0, 4.0, u);
    }
    let function = |text: &str, rule| {
        let function = text.parse().expect("a function");
        FunctionController::<f64>::new(&function, free, memory(rule), T).expect("valid")
    };
    for rule in RULES {
        for (text, gain) in [
            ("3(s^0.5+1)/(0.01s+1)", 3.0),
            ("(s^2+2s+4)/(s^2+3s+2)", 2.0),
            ("1.5", 1.5),
        ] {
            let own = function(text, rule);
            let mut history = own.settled(5.0, 3.0, 0.0).expect(text);
            for n in 0..500 {
                let u = own.output(&history, 5.0, 3.0);
                assert!((u - 2.0 * gain).abs() < 1e-9, "{text} {n}: {u}");
                own.advance(&mut history, 5.0, 3.0, u);
            }
        }
        for text in ["(s+1)/s", "(s^0.5+2)/(s^0.5+1)"] {
            let own = function(text, rule);
            assert!(own.settled(5.0, 3.0, 0.0).is_none(), "{text}");
            assert!(own.settled(5.0, 5.0, 0.0).is_some(), "{text}");
        }
    }
}

/// The commands of a controller and of the list that it makes, from a start beside a running plant.
fn starts_as_its_list<C: Controller<f32>>(
    law: impl Into<fractional_control::ControllerParameters>,
    weights: SetPoint,
    made: impl FnOnce(Actuator, Memory) -> Result<C, fractional_control::ControlError>,
) {
    let setup = ControllerSetup {
        set_point: weights,
        ..ControllerSetup::new(law, T)
    };
    let memory = setup.memory().expect("valid").fewest_modes();
    let made = made(setup.actuator().expect("valid"), memory).expect("valid");
    let (form, parts, values) = ControllerList::<f32>::new(&setup)
        .expect("a list")
        .portable();
    let unlimited = [f32::NEG_INFINITY, f32::INFINITY];
    let listed = PortableController::<f32>::new(form, &parts, &values, unlimited).expect("a list");
    let mut want = made.settled(0.3, 0.2, 0.7).expect("settles");
    let mut have = listed.settled(0.3, 0.2, 0.7).expect("settles");
    for n in 0..200 {
        let u = made.output(&want, 0.3, 0.2);
        assert_eq!(
            listed.output(&have, 0.3, 0.2).to_bits(),
            u.to_bits(),
            "{setup:?} {n}"
        );
        made.advance(&mut want, 0.3, 0.2, u);
        listed.advance(&mut have, 0.3, 0.2, u);
    }
}

#[test]
fn a_controller_from_its_list_starts_with_the_same_bits() {
    let weights = SetPoint {
        proportional: 0.4,
        derivative: 0.7,
    };
    for text in ["2+1/s+0.5s", "2+1/s^0.8+0.5s^0.6", "2+3s^0.4"] {
        let gains: PidParameters = text.parse().expect("a controller");
        starts_as_its_list(gains, weights, |free, memory| {
            FractionalPid::<f32>::new(gains, weights, free, memory, T)
        });
    }
    let tid = TidParameters {
        tilt: 2.0,
        tilt_divisor: 3.0,
        integral: 1.5,
        derivative: 1e-3,
    };
    starts_as_its_list(tid, weights, |free, memory| {
        FractionalPid::<f32>::tid(tid, 0.7, free, memory, T)
    });
    let crone = CroneParameters {
        gain: 1.5,
        order: 1.4,
        low_rad_s: 3.0,
        high_rad_s: 30.0,
    };
    starts_as_its_list(crone, weights, |free, memory| {
        LeadController::<f32>::crone(crone, free, memory, T)
    });
}

/// A sensor that fails for a sample, and one that fails for good.
#[test]
fn readings_that_are_no_numbers_hold_the_command_and_then_give_zero() {
    let pid = || pid::<f64>("2+1/s^0.8+0.5s^0.6", SetPoint::DEFAULT, Rule::Bdf2);
    let (mut whole, mut failing) = (Station::new(pid()), Station::new(pid()));
    let mut last = 0.0;
    for n in 0..300 {
        let y = 0.01 * f64::from(n);
        last = whole.step(1.0, y);
        assert_eq!(failing.step(1.0, y), last);
        if n % 100 == 50 {
            for bad in [f64::NAN, f64::INFINITY] {
                assert_eq!(failing.step(1.0, bad), last);
            }
            assert_eq!((failing.step(f64::NAN, y), failing.missed()), (last, 3));
        }
    }
    assert_eq!(failing.missed(), 0);
    for missed in 1..=2 * MISSED_MOST {
        let held = if missed < MISSED_MOST { last } else { 0.0 };
        assert_eq!(failing.step(1.0, f64::NAN), held, "{missed}");
    }
    assert!(failing.step(1.0, 1.0).is_finite());
}
