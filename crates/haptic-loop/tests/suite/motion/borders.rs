//! Borders of stability in time, where theory has them, and a wall at the virtual port.

use super::*;

/// Limits so wide that none acts on a tiny motion.
fn wide() -> MotionLimits<1> {
    MotionLimits {
        hand_energy: Some(Joules(1e9)),
        stuck: None,
        rest_time: Seconds(1e-3),
        ..MotionLimits::of(
            MetresPerSecond(10.0),
            MetresPerSecondSquared(1e4),
            [Metres(-10.0)],
            [Metres(10.0)],
            Newtons(1e4),
        )
    }
}

fn stiff(newtons_per_metre: f64) -> RobotHand {
    RobotHand {
        stiffness: NewtonsPerMetre(newtons_per_metre),
        ..RobotHand::relaxed()
    }
}

/// Natural logarithm of the growth of a tiny motion from one third of the horizon to the next, against a virtual spring of this stiffness,
/// N/m; infinite if it runs into a limit of the robot.
fn growth([alpha, m, b]: [f64; 3], hand: f64, wall: f64, horizon: usize) -> f64 {
    // A weight is right to 1e-9 of itself.
    let mut device = in_hand(&wide(), stiff(hand), body(m, b, full(alpha, T, 1e-9)));
    let mut sums = [0.0_f64; 3];
    for tick in 0..horizon {
        let push = if tick < 10 { 1e-6 } else { 0.0 };
        device.robot_mut().set_hand_force(vector![push]);
        let Ok(reading) = device.read() else {
            return f64::INFINITY;
        };
        write(&mut device, -wall * reading.position_m[0]);
        assert!(wall > 0.0 || device.limiters() == Limiters::NONE);
        let v = device.state().velocity_m_per_s()[0];
        sums[3 * tick / horizon] += v * v;
    }
    0.5 * libm::log(sums[2] / sums[1])
}

#[test]
fn simulation_decays_below_and_grows_above_the_border_that_theory_computes() {
    for (body, border) in [
        ([0.8, 1.16, 1.0], 2176.953),
        ([1.0, 0.523, 7.37], 2241.629),
        ([0.4, 2.56, 11.0], 4521.731),
        ([1.2, 0.352, 24.4], 2418.541),
        ([0.7, 1.72, 0.0], 2344.115),
    ] {
        let [below, above] = [0.97, 1.03].map(|share| growth(body, share * border, 0.0, 6000));
        assert!(below < -0.1 && above > 0.1, "{body:?}: {below} {above}");
    }
}

#[test]
fn a_wall_holds_at_the_virtual_port_exactly() {
    for alpha in [0.0, 0.6, 1.0] {
        let operator =
            |order_of| ShortMemory::<f64, 512>::new(order(order_of), T).expect("in range");
        let body = body(3.0, 30.0, operator(alpha));
        let mut device = in_hand(&limits(), RobotHand::relaxed(), body);
        let wall = SpringDamper::new(1000.0, 10.0, operator(1.0)).expect("in range");
        let wall = Contact::at(Metres(0.01), wall).expect("in range");
        let mut controller = Controller::new(wall, law_chain());
        device.robot_mut().set_hand_force(vector![3.0]);
        let mut engaged = controller.engage(&mut device);
        for _ in 0..6000 {
            engaged.tick().expect("no fault");
        }
        // f_m = 3 N and f_e = −K·depth: in rest they are equal, whatever the robot.
        let depth = engaged.device().state().position_m()[0] - 0.01;
        assert_close("depth", depth, 3e-3, 1e-8);
        // The robot is there too, as it follows without a lasting error.
        assert_close(
            "robot",
            engaged.device().robot().position()[0],
            depth + 0.01,
            1e-6,
        );
    }
}

#[test]
fn walls_make_a_robot_run_away_that_is_stable_in_free_space() {
    // Theory: (0.8, 1.16, 1) in a hand of 300 N/m is unstable against virtual springs from 230 N/m to 10 kN/m.
    let grows = |wall: f64| growth([0.8, 1.16, 1.0], 300.0, wall, 12_000) > 0.0;
    assert!(!grows(0.0) && !grows(180.0) && grows(280.0) && grows(5000.0) && !grows(13_000.0));
}
