//! The indentation rig: equilibrium, tracking, contact, energy, and the accuracy it was tuned for.

use fracdiff::Seconds;
use haptic_loop::plant::{
    ImposedMotion, IndentationRig, RampHold, RigConfig, RigContact, RigDrive,
};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons};
use testkit::assert_close;
use testkit::device::{read, write};

const T: f64 = 1e-3;
const DEPTH: f64 = 1e-3;
/// k of `RigContact::COMPLIANT`.
const CONTACT_STIFFNESS: f64 = 1e5;
/// About that of a cancerous prostate 1 mm deep, in N/m.
const SPRING: f64 = 170.0;

/// The relaxation experiment's profile: 1 mm in 1 s.
fn ramp(depth: f64) -> RigDrive {
    RigDrive::Position(RampHold::new(Metres(depth), Seconds(1.0)).expect("valid"))
}

fn rig(drive: RigDrive, contact: RigContact) -> IndentationRig {
    IndentationRig::new(RigConfig::new(drive, contact, Seconds(T))).expect("valid")
}

/// Runs `ticks` samples with the tissue's `force(x)`; `look` sees the rig after each.
fn run(
    rig: &mut IndentationRig,
    ticks: u32,
    mut force: impl FnMut(f64) -> f64,
    mut look: impl FnMut(f64, &IndentationRig),
) {
    for _ in 0..ticks {
        let reading = read::<1>(rig);
        write(rig, force(reading.position_m[0]));
        look(reading.time_s + T, rig);
    }
}

#[test]
fn a_profile_ramps_then_holds_exactly() {
    let profile = RampHold::new(Metres(2e-3), Seconds(0.5)).expect("valid");
    for (time, position) in [
        (-1.0, 0.0),
        (0.0, 0.0),
        (0.125, 0.5e-3),
        (0.5, 2e-3),
        (200.0, 2e-3),
    ] {
        assert_close("x(t)", profile.position(time), position, 0.0);
    }
}

#[test]
fn a_rendered_spring_settles_where_a_profile_a_push_or_the_actuator_ends() {
    // K·x = k·(depth - x), or the push, or the most of the actuator, as the spring wants 0.17 N; the integral leaves the indenter no error.
    let compressed = DEPTH * CONTACT_STIFFNESS / (CONTACT_STIFFNESS + SPRING);
    let push = RigDrive::Force(Newtons(0.2));
    let depth = Some(DEPTH);
    for (drive, saturation, x, force, reference) in [
        (ramp(DEPTH), None, compressed, SPRING * compressed, depth),
        (push, None, 0.2 / SPRING, 0.2, None),
        (
            ramp(DEPTH),
            Some(Newtons(0.05)),
            DEPTH - 0.05 / CONTACT_STIFFNESS,
            0.05,
            depth,
        ),
    ] {
        let config = RigConfig {
            saturation,
            ..RigConfig::new(drive, RigContact::COMPLIANT, Seconds(T))
        };
        let mut rig = IndentationRig::new(config).expect("valid");
        run(&mut rig, 5000, |x| -SPRING * x, |_, _| {});
        assert_close("F", rig.contact_force(), force, 1e-6 * force);
        assert_close("x₁", rig.indentation(), x, 1e-6 * x);
        assert_eq!(rig.reference(), reference);
        if let Some(depth) = reference {
            assert_close("x₂", rig.indenter_position(), depth, 1e-6 * depth);
        }
    }
}

#[test]
fn a_rendered_spring_is_at_depth_a_tenth_of_a_second_after_the_ramp() {
    for sample_time in [0.5e-3, 1e-3, 2e-3] {
        let config = RigConfig::new(ramp(DEPTH), RigContact::COMPLIANT, Seconds(sample_time));
        let mut rig = IndentationRig::new(config).expect("valid");
        while read::<1>(&mut rig).time_s < 3.0 {
            let reading = read::<1>(&mut rig);
            let x = reading.position_m[0];
            if reading.time_s >= 1.1 {
                assert_close("x₁", x, DEPTH, 2.5e-3 * DEPTH);
            }
            write(&mut rig, -SPRING * x);
        }
    }
}

#[test]
fn the_indenter_follows_a_ramp_of_a_millimetre_a_second() {
    let mut rig = rig(ramp(DEPTH), RigContact::COMPLIANT);
    run(
        &mut rig,
        1000,
        |x| -SPRING * x,
        |time, rig| {
            let reference = rig.reference().expect("a position profile");
            let error = rig.indenter_position() - reference;
            // From rest the first error is about v/(4·ω) = 1.25 µm; the rising force leaves F'/(K/Tᵢ).
            let allowed = if time < 0.05 { 1.5e-6 } else { 2e-7 };
            assert_close("x₂ - r", error, 0.0, allowed);
        },
    );
}

#[test]
fn a_rigid_indenter_imposes_its_profile_exactly() {
    let mut rig = rig(ramp(DEPTH), RigContact::Rigid);
    let profile = RampHold::new(Metres(DEPTH), Seconds(1.0)).expect("valid");
    let mut motion = ImposedMotion::new(profile, Seconds(T)).expect("valid");
    for n in 0..1500_u32 {
        let reading = read::<1>(&mut rig);
        assert_eq!(read::<1>(&mut motion), reading, "without a rig");
        write(&mut motion, 0.0);
        let want = profile.position(f64::from(n) * T);
        assert_eq!(reading.position_m[0].to_bits(), want.to_bits(), "tick {n}");
        assert_eq!(rig.indenter_position().to_bits(), want.to_bits());
        let force = SPRING * want;
        write(&mut rig, -force);
        assert_eq!(rig.contact_force().to_bits(), force.to_bits());
    }
}

#[test]
fn a_rigid_push_moves_the_renderer_alone() {
    let mut rig = rig(RigDrive::Force(Newtons(0.35)), RigContact::Rigid);
    run(
        &mut rig,
        500,
        |_| -0.1,
        |time, rig| {
            // m·x'' + b·x' = 0.35 N - 0.1 N
            let lost = -libm::expm1(-3.5 * time / 0.065);
            let want = 0.25 / 3.5 * (time - 0.065 / 3.5 * lost);
            assert_close("x₁", rig.indentation(), want, 1e-13);
            assert_close("F", rig.contact_force(), 0.35, 0.0);
        },
    );
}

#[test]
fn apart_each_actuator_moves_under_its_own_force() {
    let config = RigConfig {
        renderer_mass: Kilograms(0.1),
        renderer_damping: NewtonSecondsPerMetre(2.0),
        indenter_mass: Kilograms(0.2),
        indenter_damping: NewtonSecondsPerMetre(5.0),
        ..RigConfig::new(
            RigDrive::Force(Newtons(-0.3)),
            RigContact::COMPLIANT,
            Seconds(T),
        )
    };
    // m·x'' + b·x' = f from rest.
    let want = |f: f64, m: f64, b: f64, t: f64| f / b * (t + m / b * libm::expm1(-b * t / m));
    let mut rig = IndentationRig::new(config).expect("valid");
    run(
        &mut rig,
        500,
        |_| 0.4,
        |time, rig| {
            assert_close("x₁", rig.indentation(), want(0.4, 0.1, 2.0, time), 1e-13);
            let indenter = want(-0.3, 0.2, 5.0, time);
            assert_close("x₂", rig.indenter_position(), indenter, 1e-13);
        },
    );
}

/// Knocks the renderer away and back onto the free indenter. Returns its approach velocity, then
/// the velocities of both after the collision, m/s.
fn collide(sample_time: f64) -> (f64, [f64; 2]) {
    let undamped = RigConfig {
        renderer_damping: NewtonSecondsPerMetre(0.0),
        indenter_damping: NewtonSecondsPerMetre(0.0),
        ..RigConfig::new(
            RigDrive::Force(Newtons(0.0)),
            RigContact::COMPLIANT,
            Seconds(sample_time),
        )
    };
    let mut rig = IndentationRig::new(undamped).expect("valid");
    let mut coast = |seconds: f64, force: f64| {
        let mut last = [0.0; 2];
        for _ in 0..(seconds / sample_time).round() as u32 {
            last = [rig.indentation(), rig.indenter_position()];
            write(&mut rig, force);
            let (apart, force) = (
                rig.indenter_position() <= rig.indentation(),
                rig.contact_force(),
            );
            assert!(force >= 0.0, "the contact pulls");
            assert!(!apart || force.to_bits() == 0, "a force across a gap");
        }
        let now = [rig.indentation(), rig.indenter_position()];
        [0, 1].map(|body| (now[body] - last[body]) / sample_time)
    };
    // 0.02 s out and 0.03 s back leave 0.154 m/s towards the indenter, 5.4 mm away: 35 ms.
    coast(0.02, 1.0);
    coast(0.03, -1.0);
    let [approach, _] = coast(0.02, 0.0);
    (approach, coast(0.04, 0.0))
}

#[test]
fn a_collision_keeps_the_momentum_and_loses_the_energy_that_the_contact_damps() {
    // p'' + 2·β·p' + ω₀²·p = 0 from p = 0 until the force, so p'', is zero:
    // tan(ω·t) = -2·β·ω/(ω₀² - 2·β²), restitution e = -p'(t)/p'(0).
    let reduced = 0.065 / 2.0;
    let (beta, stiff) = (80.0 / 2.0 / reduced, CONTACT_STIFFNESS / reduced);
    let omega = libm::sqrt(stiff - beta * beta);
    let phase = libm::atan2(2.0 * beta * omega, 2.0 * beta * beta - stiff);
    let restitution =
        libm::exp(-beta * phase / omega) * (beta / omega * libm::sin(phase) - libm::cos(phase));
    for sample_time in [1e-3, 1e-4, 1e-5] {
        let (approach, [renderer, indenter]) = collide(sample_time);
        assert_close("approach", approach, -0.01 / 0.065, 1e-9);
        assert_close("momentum", renderer + indenter, approach, 1e-9);
        let have = (renderer - indenter) / -approach;
        // Contact is noticed up to T/8 late, the distance p then being up to v·T/8: first order.
        let late = omega * sample_time / 8.0;
        assert_close("restitution", have, restitution, late);
    }
}
