//! The refusals of the plants, by name, value, range and unit.

use fracdiff::Seconds;
use haptic_loop::plant::{
    IndentationRig, MAX_DELAY_SAMPLES, MassDamper, MassDamperConfig, RampHold, RigConfig,
    RigContact, RigDrive, Sensed,
};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};
use std::fmt::Display;
use testkit::assert_refused;
use testkit::device::{DAMPING as B, MASS as M, ideal, with_hand};

/// Sample time at 1 kHz, s.
const T: f64 = 1e-3;

fn drive() -> RigDrive {
    RigDrive::Position(RampHold::new(Metres(1e-3), Seconds(1.0)).expect("valid"))
}

/// What is changed of a good configuration.
pub(super) type Change<C> = fn(&mut C);

/// Changes of a good configuration, each with its refusal.
macro_rules! refusals {
    ($config:ident: $($change:expr => $words:literal;)*) => {
        [$((|$config| $change, $words)),*]
    };
}

/// Changes of a good mass-damper, and their refusals.
const BAD_MASS_DAMPERS: [(Change<MassDamperConfig>, &str); 9] = refusals! { config:
    config.mass = Kilograms(0.0) => "mass 0 kg is not above 0 kg";
    config.damping = NewtonSecondsPerMetre(-1.0) => "damping -1 N·s/m is not at least 0 N·s/m";
    config.sample_time = Seconds(f64::NAN) => "sample time NaN s is not above 0 s";
    config.stiffness = NewtonsPerMetre(f64::INFINITY) => "hand stiffness inf N/m is not finite and at least 0 N/m";
    config.friction = Newtons(-0.1) => "friction -0.1 N is not at least 0 N";
    config.delay = Seconds(0.0641) => "delay 0.0641 s is not from 0 to 64 sample times";
    config.saturation = Some(Newtons(0.0)) => "actuator saturation 0 N is not above 0 N";
    config.current_lag = Seconds(-1.0) => "current lag -1 s is not at least 0 s";
    (config.friction, config.stiffness) = (Newtons(0.1), NewtonsPerMetre(1e5)) => "hand stiffness 100000 N/m is not at most m/T², as with friction";
};

/// Each change of a good configuration is refused, in these words.
pub(super) fn refuses<C: Copy, T, E: Display>(
    good: C,
    changes: &[(Change<C>, &str)],
    made: fn(C) -> Result<T, E>,
) {
    assert!(made(good).is_ok());
    for (change, words) in changes {
        let mut config = good;
        change(&mut config);
        assert_refused(made(config), words);
    }
}

#[test]
fn a_mass_damper_refuses_bad_parameters() {
    let good = with_hand(M, B, 0.0, T);
    refuses(good, &BAD_MASS_DAMPERS, MassDamper::<1>::new);
    let longest = MassDamperConfig {
        delay: Seconds(MAX_DELAY_SAMPLES as f64 * T),
        ..good
    };
    assert!(MassDamper::<1>::new(longest).is_ok());
    assert_refused(
        MassDamper::<1>::new(ideal(1.0, 2e6, 1.0)),
        "fastest motion per step 2e6 rad is not at most 1e6 rad",
    );
}

const fn contact(stiffness: f64, damping: f64) -> RigContact {
    RigContact::Compliant {
        stiffness: NewtonsPerMetre(stiffness),
        damping: NewtonSecondsPerMetre(damping),
    }
}

/// Changes of a good rig, and their refusals.
const BAD_RIGS: [(Change<RigConfig>, &str); 8] = refusals! { config:
    config.renderer_mass = Kilograms(0.0) => "renderer mass 0 kg is not above 0 kg";
    config.indenter_damping = NewtonSecondsPerMetre(-1.0) => "indenter damping -1 N·s/m is not at least 0 N·s/m";
    config.contact = contact(0.0, 1.0) => "contact stiffness 0 N/m is not above 0 N/m";
    config.contact = contact(1.0, -1.0) => "contact damping -1 N·s/m is not at least 0 N·s/m";
    config.servo.integral_time = Seconds(0.0) => "servo integral time 0 s is not above 0 s";
    config.drive = RigDrive::Force(Newtons(f64::NAN)) => "push NaN N is not finite";
    config.saturation = Some(Newtons(-2.0)) => "actuator saturation -2 N is not above 0 N";
    config.sample_time = Seconds(0.0) => "sample time 0 s is not above 0 s";
};

#[test]
fn a_rig_refuses_bad_parameters() {
    let good = RigConfig::new(drive(), RigContact::COMPLIANT, Seconds(T));
    refuses(good, &BAD_RIGS, IndentationRig::new);
}

#[test]
fn profiles_and_sensors_refuse_bad_parameters() {
    for (depth, time, words) in [
        (f64::INFINITY, 1.0, "indentation depth inf m is not finite"),
        (1.0, 0.0, "ramp time 0 s is not above 0 s"),
    ] {
        assert_refused(RampHold::new(Metres(depth), Seconds(time)), words);
    }
    for (resolution, noise, words) in [
        (
            -1e-6,
            0.0,
            "encoder resolution -0.000001 m is not above 0 m",
        ),
        (
            0.0,
            -1e-6,
            "standard deviation of the noise -0.000001 m is not at least 0 m",
        ),
        (f64::NAN, 0.0, "NaN"),
        (0.0, f64::NAN, "NaN"),
    ] {
        let still = MassDamper::<1>::new(ideal(M, B, T)).expect("valid");
        let sensed = Sensed::new(still, Metres(resolution), Metres(noise), 0);
        assert_refused(sensed, words);
    }
}
