//! The rig whose indenter a holder drives: the matrices that run, the constant push, the reaction on the mass that is held.

use fracdiff::Seconds;
use haptic_loop::plant::{
    HeldRig, Holder, IndentationRig, RampHold, RigConfig, RigContact, RigDrive,
};
use haptic_loop::units::{Metres, Newtons};
use nalgebra::SVector;
use testkit::device::{read, write};
use testkit::{assert_close, assert_refused};

const T: f64 = 1e-3;
/// About that of a cancerous prostate 1 mm deep, N/m.
const SPRING: f64 = 170.0;

fn config(drive: RigDrive) -> RigConfig {
    RigConfig::new(drive, RigContact::COMPLIANT, Seconds(T))
}

/// 1 mm in 0.2 s.
fn ramp() -> RigDrive {
    RigDrive::Position(RampHold::new(Metres(1e-3), Seconds(0.2)).expect("valid"))
}

/// K(r − y) + bias, and all that it was told.
#[derive(Clone, Debug, Default)]
struct Proportional {
    gain: f64,
    bias: f64,
    calls: Vec<(f64, f64)>,
}

impl Holder for Proportional {
    fn force(&mut self, set_point: f64, measured: f64) -> f64 {
        self.calls.push((set_point, measured));
        self.gain * (set_point - measured) + self.bias
    }

    fn restart(&mut self) {
        self.calls.clear();
    }
}

fn held(drive: RigDrive, gain: f64, bias: f64) -> HeldRig<Proportional> {
    let holder = Proportional {
        gain,
        bias,
        ..Proportional::default()
    };
    HeldRig::new(config(drive), holder).expect("valid")
}

#[test]
fn a_constant_force_is_the_constant_push() {
    let mut rig = held(ramp(), 0.0, 0.3);
    let mut pushed = IndentationRig::new(config(RigDrive::Force(Newtons(0.3)))).expect("valid");
    for n in 0..500 {
        let (here, other) = (read::<1>(&mut rig), read::<1>(&mut pushed));
        assert_eq!((here.tick, here.time_s), (other.tick, other.time_s));
        // The rig notices the contact h = T/8 late, F/m·h²/2 = 36 nm deep.
        assert_close("x₁", here.position_m[0], other.position_m[0], 3.6e-8);
        write(&mut rig, -SPRING * here.position_m[0]);
        write(&mut pushed, -SPRING * other.position_m[0]);
        if n > 200 {
            assert_close(
                "x₁ later",
                here.position_m[0],
                other.position_m[0],
                1e-6 * here.position_m[0],
            );
        }
    }
    assert_eq!(rig.drive_force().to_bits(), 0.3_f64.to_bits());
}

/// The matrices of a sample, from those of a fifth of it.
#[test]
fn a_held_indenter_moves_by_the_matrices_of_its_devices_and_feels_the_tissue() {
    let gain = 2000.0;
    let mut rig = held(ramp(), gain, 0.0);
    let fifth = (rig.devices().config())
        .motion(true, Seconds(T / 5.0))
        .expect("slow");
    let mut state = SVector::<f64, 8>::zeros();
    for n in 0..3000 {
        let (x1, x2) = (state[0], state[2]);
        let RigDrive::Position(profile) = ramp() else {
            unreachable!()
        };
        let set_point = profile.position(f64::from(n) * T);
        let reading = read::<1>(&mut rig);
        assert_close("x₁", reading.position_m[0], x1, 1e-12);
        assert_close("x₂", rig.measured(), x2, 1e-12);
        assert_close("r", rig.set_point(), set_point, 0.0);
        (state[6], state[7]) = (-SPRING * x1, gain * (set_point - x2));
        write(&mut rig, -SPRING * reading.position_m[0]);
        assert_close("S", rig.drive_force(), state[7], 1e-8);
        for _ in 0..5 {
            state = fifth * state;
        }
    }
    // S = K(r − x₂) = F = SPRING·x₁ at rest: without an integral the tissue holds the mass back.
    let rest = 1e-3 * gain / (gain + SPRING);
    assert_close("x₂ at rest", rig.measured(), rest, 2e-3 * rest);
    assert!(rig.devices().contact_force() > 0.9 * SPRING * rest);
}

#[test]
fn a_force_set_point_is_measured_as_the_force_between_the_actuators() {
    let mut rig = held(RigDrive::Force(Newtons(0.2)), 1.0, 0.2);
    for _ in 0..4000 {
        let reading = read::<1>(&mut rig);
        write(&mut rig, -SPRING * reading.position_m[0]);
    }
    // S = 0.2 + (0.2 − F) = F
    assert_close("F", rig.measured(), 0.2, 1e-6);
    assert!(rig.reference().is_none());
    assert_eq!(rig.holder().calls[0], (0.2, 0.0));
    rig.restart();
    assert_eq!((rig.drive_force(), rig.measured()), (0.0, 0.0));
    assert!(rig.holder().calls.is_empty());
}

#[test]
fn a_force_that_is_no_number_is_none_and_a_rigid_contact_has_nothing_to_hold() {
    let mut rig = held(ramp(), f64::NAN, 0.0);
    for _ in 0..50 {
        write(&mut rig, 0.0);
    }
    assert_eq!((rig.measured(), rig.drive_force()), (0.0, 0.0));
    let rigid = RigConfig::new(ramp(), RigContact::Rigid, Seconds(T));
    assert_refused(
        HeldRig::new(rigid, Proportional::default()),
        "compliant contact",
    );
}
