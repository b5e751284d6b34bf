//! A start beside a running plant, and readings that are no numbers.

use fracdiff::{Real, Seconds};
use fractional_control::{
    Actuator, Controller, ControllerList, ControllerSetup, CroneParameters, FractionalPid,
    FunctionController, LeadController, MISSED_MOST, Mode, PidParameters, PortableController,
    PowerMemory, Rule, SetPoint, Station, TidParameters,
};
use testkit::assert_close;

const T: Seconds = Seconds(1e-2);

fn memory(rule: Rule) -> PowerMemory {
    PowerMemory::new(rule, 1e-7, 200.0).expect("valid")
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
        "2+1.5/s^0.8+0.1s^0.6",
        "1/s^0.4",
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

/// The bias fades in a second without an integral.
#[test]
fn without_an_integral_the_command_fades_into_that_of_the_parts() {
    let mut station = Station::new(pid::<f64>("2+0.5s^0.5", SetPoint::DEFAULT, Rule::Bdf2));
    assert_eq!(station.settle(4.0, 3.0, 1.5), Some(0.0));
    let mut u = (0..200).map(|_| station.step(4.0, 3.0));
    // P of an error of 1, in place of 1.5.
    let want = |n: f64| 2.0 - 0.5 * (-n * T.0).exp();
    assert!((0..200).all(|n| (u.next().expect("a command") - want(f64::from(n))).abs() < 1e-9));
}

/// Lost telemetry moves nothing: as if it had reported the command.
#[test]
fn what_is_not_finite_counts_as_the_command() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let new = || {
            Station::new(pid::<f64>(
                "2+8/s^0.8+0.5s^0.6",
                SetPoint::DEFAULT,
                Rule::Bdf2,
            ))
        };
        let (mut restored, mut lost) = (new(), new());
        for n in 0..600 {
            let y = 0.01 * f64::from(n);
            if n % 200 == 150 {
                lost.set_mode(Mode::Automatic);
                assert_eq!(lost.settle(y, y, bad), Some(0.0));
                restored.settle(y, y, lost.output(y, y));
            }
            restored.set_mode(Mode::Automatic);
            let automatic = restored.output(4.0, y);
            let by_hand =
                [Mode::Automatic, Mode::Manual(3.0), Mode::Manual(automatic)][n as usize / 50 % 3];
            restored.set_mode(by_hand);
            lost.set_mode(if n / 50 % 3 == 2 {
                Mode::Manual(bad)
            } else {
                by_hand
            });
            let u = restored.output(4.0, y);
            assert!(u.abs() <= 10.0 && lost.output(4.0, y) == u, "{n}: {u}");
            restored.advance(4.0, y, u);
            lost.advance(4.0, y, bad);
            // A reading that fails holds no more than a limit.
            assert_eq!(lost.step(4.0, bad), restored.step(4.0, bad), "{n}");
        }
    }
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
    let mut history = crone.settled(5.0, 4.0, f64::NAN).expect("settles");
    for _ in 0..100 {
        // The gain at rest of the weights that run.
        let u = crone.output(&history, 5.0, 4.0);
        assert_close("u", u, 2.0, 1e-5);
        // A weak drive leaves it alone.
        crone.advance(&mut history, 5.0, 4.0, 0.85 * u);
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
            let controller = function(text, rule);
            let mut history = controller.settled(5.0, 3.0, f64::NAN).expect(text);
            for n in 0..500 {
                let u = controller.output(&history, 5.0, 3.0);
                assert!((u - 2.0 * gain).abs() < 1e-9, "{text} {n}: {u}");
                controller.advance(&mut history, 5.0, 3.0, 0.85 * u);
            }
        }
        for text in ["(s+1)/s", "(s^0.5+2)/(s^0.5+1)"] {
            let controller = function(text, rule);
            assert!(controller.settled(5.0, 3.0, 0.0).is_none(), "{text}");
            // Of these two the first holds the command that stood.
            let mut history = controller.settled(5.0, 5.0, 4.5).expect(text);
            for _ in 0..1000 {
                controller.advance(&mut history, 5.0, 5.0, f64::NAN);
            }
            let kept = controller.output(&history, 5.0, 5.0) == 4.5;
            assert_eq!(kept, text == "(s+1)/s", "{text}");
        }
    }
}

/// The commands of a controller and of the list that it makes, from a start beside a running plant.
fn starts_as_its_list<C: Controller<f32>>(
    law: impl Into<fractional_control::ControllerParameters>,
    weights: SetPoint,
    made: impl FnOnce(Actuator, PowerMemory) -> Result<C, fractional_control::ControlError>,
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
