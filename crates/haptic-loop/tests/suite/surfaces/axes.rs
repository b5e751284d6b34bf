//! What a safety chain, its guards and a device make of several axes.

use super::{T, ball_3, tissue};
use fracdiff::{Order, Seconds, ShortMemory};
use haptic_loop::plant::{Axes, MassMatrix};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
use haptic_loop::{
    Contact, Controller, EnergyBounding, Fault, Guard, Limits, PassivityObserver, Reading,
    SafetyChain, SafetyState, SpringDamper, Workspace,
};
use nalgebra::{Matrix2, Matrix3, Rotation3, Vector2, Vector3, vector};
use testkit::assert_relative;
use testkit::device::{ideal, plant, safe, with_hand, write};

#[test]
fn the_norm_of_the_force_is_never_beyond_its_limit() {
    let sphere = Contact::behind(ball_3([0.0; 3], 0.05), tissue());
    let limits = Limits {
        norm: Some(Newtons(2.0)),
        ..Limits::bare(Newtons(10.0), NewtonsPerSecond(1e6))
    };
    let chain = SafetyChain::from_limits(&limits, T).expect("valid");
    let mut controller = Controller::new(sphere, chain);
    // A hand that pulls to the centre of the sphere.
    let mut device = Axes::new([with_hand(0.06, 1.0, 300.0, T.0); 3]).expect("valid");
    device.set_state(vector![0.03, 0.03, 0.03], Vector3::zeros());
    let (mut most, mut limited) = (0.0_f64, false);
    let mut engaged = controller.engage(device);
    for n in 0..2000 {
        let angle = 0.01 * f64::from(n);
        // To ever other sides.
        let push = vector![angle.cos(), angle.sin(), (0.3 * angle).sin()];
        engaged.device_mut().set_external_force(push);
        let Ok(sample) = engaged.tick();
        most = most.max(sample.force.newtons().norm());
        limited |= sample.environment_force_n.norm() > 4.0;
    }
    assert!(limited, "more was wanted");
    assert!(most <= 2.0 && most > 1.99, "{most}");
}

#[test]
fn a_box_has_ends_of_its_own_on_each_axis() {
    let interval = |low, high| Workspace {
        low: Metres(low),
        high: Metres(high),
        soft: Metres(0.0),
    };
    let limits = Limits {
        // The box goes before it.
        workspace: Some(interval(-1e-3, 1e-3)),
        workspace_box: Some([
            interval(-0.1, 0.1),
            interval(-0.02, 0.05),
            interval(0.0, 0.3),
        ]),
        ..Limits::bare(Newtons(10.0), NewtonsPerSecond(1e6))
    };
    let chain = SafetyChain::<f64>::from_limits(&limits, T).expect("valid");
    let fault = |x: Vector3<f64>| {
        let mut state = SafetyState::default();
        chain.apply(&mut state, &x, &Vector3::zeros());
        state.fault()
    };
    for inside in [vector![0.09, 0.04, 0.29], vector![-0.09, -0.019, 0.0]] {
        assert_eq!(fault(inside), None, "{inside}");
    }
    for outside in [
        vector![0.11, 0.0, 0.1],
        vector![0.0, 0.06, 0.1],
        vector![0.0, -0.03, 0.1],
        vector![0.0, 0.0, -1e-6],
        vector![0.0, 0.0, 0.31],
    ] {
        assert_eq!(fault(outside), Some(Fault::Workspace), "{outside}");
    }
    // With two axes the first two count.
    let mut state = SafetyState::default();
    chain.apply(&mut state, &vector![0.0, 0.06], &Vector2::zeros());
    assert_eq!(state.fault(), Some(Fault::Workspace));
    let upside_down = Limits {
        workspace_box: Some([interval(0.1, -0.1); 3]),
        ..limits
    };
    assert!(SafetyChain::<f64>::from_limits(&upside_down, T).is_err());
}

#[test]
fn axes_of_their_own_move_as_devices_of_one_axis() {
    use haptic_loop::Device;
    let configs = [0.05, 0.2].map(|mass| with_hand(mass, 2.0, 300.0, T.0));
    let mut both = Axes::new(configs).expect("valid");
    let mut alone = configs.map(plant);
    for n in 0..300 {
        let force = vector![0.5, -0.01 * f64::from(n)];
        both.write(safe(force)).expect("written");
        for (axis, device) in alone.iter_mut().enumerate() {
            write(device, force[axis]);
            assert_eq!(device.position()[0], both.position()[axis]);
            assert_eq!(device.velocity()[0], both.velocity()[axis]);
        }
        let reading: Reading<f64, 2> = both.read().expect("read");
        assert_eq!(reading.tick, n as u64 + 1);
    }
    let mut other = configs;
    other[1].sample_time = Seconds(2e-3);
    let refused = Axes::new(other).expect_err("two sample times").to_string();
    assert!(
        refused.contains("sample time of an axis 0.002 s"),
        "{refused}"
    );
}

#[test]
fn an_effective_mass_is_that_of_a_push_along_the_normal() {
    let masses = [Kilograms(0.05), Kilograms(0.2)];
    let axes = MassMatrix::of_axes(masses).expect("valid");
    for angle in [0.0, 0.3, 1.0, 1.5, 2.5] {
        let normal = vector![f64::cos(angle), f64::sin(angle)];
        let closed = 1.0 / (normal[0] * normal[0] / 0.05 + normal[1] * normal[1] / 0.2);
        let have = axes.along(&(3.0 * normal)).expect("a direction").0;
        assert_relative("effective mass", have, closed, 1e-14);
        assert!((0.05..=0.2).contains(&have));
        // The device, pushed for a sample.
        let configs = masses.map(|m| ideal(m.0, 0.0, T.0));
        let mut device = Axes::new(configs).expect("valid");
        haptic_loop::Device::write(&mut device, safe(normal)).expect("written");
        assert_relative(
            "speed along it",
            device.velocity().dot(&normal),
            T.0 / closed,
            1e-12,
        );
    }
    let turn = Rotation3::from_euler_angles(0.2, 0.4, -0.9);
    let axes = Matrix3::from_diagonal(&vector![0.05, 0.1, 0.3]);
    let turned = MassMatrix::new(turn * axes * turn.transpose()).expect("valid");
    let along = turned
        .along(&(turn * vector![0.0, 0.0, 1.0]))
        .expect("valid");
    assert_relative("along an own axis", along.0, 0.3, 1e-12);
    for wrong in [
        Matrix2::new(1.0, 2.0, 2.0, 1.0),
        Matrix2::new(1.0, 0.5, 0.0, 1.0),
        Matrix2::new(-1.0, 0.0, 0.0, 1.0),
        Matrix2::new(f64::NAN, 0.0, 0.0, 1.0),
    ] {
        assert!(MassMatrix::new(wrong).is_err(), "{wrong}");
    }
    assert!(
        MassMatrix::of_axes(masses)
            .expect("valid")
            .along(&Vector2::zeros())
            .is_err()
    );
}

/// A stiff wall, a hand that slides along it while it shakes: forces of both guards.
fn guarded(guard: Guard) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let operator = ShortMemory::<f64, 64>::new(Order::new(0.3).expect("valid"), T).expect("valid");
    let stiff = SpringDamper::new(60e3, 0.0, operator).expect("valid");
    let normal = [0.6, 0.8];
    let wall = Contact::new(normal, Metres(0.0), stiff).expect("valid");
    let limits = Limits {
        guard: Some(guard),
        ..Limits::bare(Newtons(1e3), NewtonsPerSecond(1e9))
    };
    let mut controller =
        Controller::new(wall, SafetyChain::from_limits(&limits, T).expect("valid"));
    let device = Axes::new([ideal(0.065, 3.5, T.0); 2]).expect("valid");
    let (normal, along) = (Vector2::from(normal), vector![0.8, -0.6]);
    let mut engaged = controller.engage(device);
    (0..3000)
        .map(|n| {
            let slide = if n < 1500 { 1.5 } else { -1.5 };
            let push = 2.0 * normal + slide * along;
            engaged.device_mut().set_external_force(push);
            let Ok(sample) = engaged.tick();
            (*sample.force.newtons(), sample.environment_force_n)
        })
        .collect()
}

#[test]
fn guards_act_along_the_normal_and_add_no_friction() {
    let damping = NewtonSecondsPerMetre(3.5);
    for guard in [
        Guard::Observer(PassivityObserver::bearable(Kilograms(0.065), T)),
        Guard::EnergyBounding(EnergyBounding::of(damping)),
    ] {
        let forces = guarded(guard);
        let along = vector![0.8, -0.6];
        let mut acted = 0;
        for (sent, wanted) in &forces {
            if wanted.norm() > 0.0 {
                assert!(
                    sent.dot(&along).abs() < 1e-9,
                    "{guard:?}: {sent} for {wanted}"
                );
                acted += usize::from((sent - wanted).norm() > 1e-6);
            }
        }
        assert!(acted > 10, "{guard:?} acted {acted} times");
    }
}
