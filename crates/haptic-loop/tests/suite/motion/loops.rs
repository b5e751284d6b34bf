//! A robot in the loop: stops and faults of either side, errors, and guards.

use super::*;

fn mass() -> VirtualBody<f64, Operator<f64>> {
    body(2.0, 10.0, full(1.0, T, 1e-6))
}

fn law(stiffness: f64) -> SpringDamper<f64, Operator<f64>> {
    SpringDamper::new(stiffness, 0.0, full(1.0, T, 1e-6)).expect("in range")
}

type Robot = Admittance<f64, 1, Operator<f64>, SimulatedRobot<1>>;

/// A robot on its way, pushed by 5 N.
fn on_its_way() -> (Controller<f64, 1, SpringDamper<f64, Operator<f64>>>, Robot) {
    let mut device = in_hand(&limits(), RobotHand::relaxed(), mass());
    device.robot_mut().set_hand_force(vector![5.0]);
    for _ in 0..40 {
        device.read().expect("no fault");
        write(&mut device, 0.0);
    }
    assert!(device.state().velocity_m_per_s()[0] > 0.05);
    (Controller::new(law(0.0), law_chain()), device)
}

#[test]
fn a_fault_or_stop_of_the_law_stops_the_motion_though_the_hand_pushes_on() {
    for fault in [Some(Fault::HostSilent), None] {
        let (mut controller, mut device) = on_its_way();
        let mut engaged = controller.engage(&mut device);
        engaged.tick().expect("no fault");
        let mut last = engaged.device().state().velocity_m_per_s()[0];
        match fault {
            Some(fault) => engaged.controller_mut().trip(fault),
            None => engaged.controller_mut().stop(),
        }
        for _ in 0..40 {
            engaged.tick().expect("a stop is no error of the device");
            let v = engaged.device().state().velocity_m_per_s()[0];
            assert_close("braking", v, (last - 10.0 * T.0).max(0.0), 1e-15);
            last = v;
        }
        assert_eq!((last, engaged.device().state().fault()), (0.0, None));
    }
}

#[test]
fn a_body_that_was_pushed_against_the_end_turns_at_once() {
    let (_, mut device) = on_its_way();
    let mut tick = |push: f64| {
        device.robot_mut().set_hand_force(vector![push]);
        device.read().expect("no fault");
        write(&mut device, 0.0);
        (
            *device.state().position_m(),
            *device.state().velocity_m_per_s(),
        )
    };
    for _ in 0..3000 {
        tick(5.0);
    }
    // Up to a·T²/8, from where one sample of any speed needs more room.
    assert_close("at the end", tick(5.0).0[0], 0.1, 5e-6);
    // A wound-up body would go on for 70 ticks, ln 2 of m/b; the sensor alone needs some of these.
    let turned = (0..70).find(|_| tick(-5.0).1[0] < 0.0);
    assert!(turned.is_some_and(|ticks| ticks < 8), "{turned:?}");
}

#[test]
fn a_loop_that_ends_without_a_force_lets_a_moving_robot_go() {
    let (mut controller, mut device) = on_its_way();
    controller.engage(&mut device).tick().expect("no fault");
    assert!(controller.safety().is_at_rest(), "no force");
    assert!(
        device.state().is_at_rest() && !device.state().is_driven(),
        "nor a motion"
    );
}

#[test]
fn a_fault_of_motion_brakes_first_and_is_then_an_error_until_armed_again() {
    let (mut controller, mut device) = on_its_way();
    let mut engaged = controller.engage(&mut device);
    engaged
        .device_mut()
        .robot_mut()
        .set_trouble(Some(SensorTrouble::NotANumber));
    let braking = (0..40).take_while(|_| engaged.tick().is_ok()).count();
    let error = engaged.tick().expect_err("at rest");
    assert!(
        matches!(error, AdmittanceError::Stopped(MotionFault::NotFinite)),
        "{error}"
    );
    assert!((2..26).contains(&braking), "{braking}");
    assert_eq!(
        engaged.controller().safety().fault(),
        Some(Fault::BoardFailed)
    );
    let device = engaged.device_mut();
    device.robot_mut().set_trouble(None);
    device.robot_mut().set_hand_force(vector![0.0]);
    for _ in 0..100 {
        assert_refused(device.read(), "has stopped: a sensed force");
        device.rest().expect("rests");
    }
    // The hand still slid off the handle; now it is gone.
    assert_refused(device.arm(), "let go of the handle");
    for _ in 0..100 {
        device.rest().expect("rests");
    }
    device.arm().expect("may be armed again");
    device.read().expect("no fault");
}

#[test]
fn an_unstable_hand_is_stopped_by_the_energy_that_it_is_given() {
    // Theory: this body grows in a hand of more than 2177 N/m.
    let body = body(1.16, 1.0, full(0.8, T, 1e-6));
    let hand = RobotHand {
        stiffness: NewtonsPerMetre(3500.0),
        ..RobotHand::relaxed()
    };
    let limits = MotionLimits {
        speed: MetresPerSecond(1.0),
        speed_norm: None,
        force: Newtons(1e4),
        sensor_range: Newtons(1e4),
        following: Metres(1.0),
        ..limits()
    };
    let mut device = in_hand(&limits, hand, body);
    device.robot_mut().set_hand_force(vector![1.0]);
    let mut controller = Controller::new(law(0.0), law_chain());
    let mut engaged = controller.engage(&mut device);
    let error = (0..20_000)
        .find_map(|_| engaged.tick().err())
        .expect("a fault");
    assert!(
        matches!(error, AdmittanceError::Stopped(MotionFault::HandEnergy)),
        "{error}"
    );
    // A hand in which it is stable gives more than it gets, for as long as it likes.
    let hand = RobotHand {
        mass: Kilograms(0.5),
        stiffness: NewtonsPerMetre(200.0),
        ..RobotHand::relaxed()
    };
    let mut device = in_hand(&limits, hand, mass());
    let mut controller = Controller::new(law(300.0), law_chain());
    let mut engaged = controller.engage(&mut device);
    for tick in 0..20_000 {
        let place = 0.05 * libm::sin(0.01 * f64::from(tick));
        engaged
            .device_mut()
            .robot_mut()
            .set_hand_target(vector![place]);
        engaged.tick().expect("no fault");
    }
}

/// A robot whose line breaks after some calls.
struct Breaking {
    robot: SimulatedRobot<1>,
    senses: u32,
    commands: u32,
    let_go: u32,
}

impl MovingDevice<f64, 1> for Breaking {
    type Error = &'static str;

    fn sense(&mut self) -> Result<MotionReading<f64, 1>, &'static str> {
        self.senses = self.senses.checked_sub(1).ok_or("no sense")?;
        self.robot.sense().map_err(|never| match never {})
    }

    fn command(&mut self, motion: SafeMotion<f64, 1>) -> Result<(), &'static str> {
        self.commands = self.commands.checked_sub(1).ok_or("no command")?;
        self.robot.command(motion).map_err(|never| match never {})
    }

    fn let_go(&mut self) {
        self.let_go += 1;
    }
}

#[test]
fn a_robot_that_cannot_sense_brakes_and_one_that_cannot_be_commanded_is_let_go() {
    for (senses, commands) in [(150, 1000), (1000, 150)] {
        let mut robot = Breaking {
            robot: made(robot(RobotHand::relaxed())),
            senses,
            commands,
            let_go: 0,
        };
        let mut device = admittance(&limits(), &mut robot, mass());
        device.robot_mut().robot.set_hand_force(vector![5.0]);
        let mut moved = 0.0;
        let error = loop {
            if let Err(error) = device.read() {
                break error;
            }
            if let Err(error) = device.write(testkit::device::safe(vector![0.0])) {
                break error;
            }
            let v = device.state().velocity_m_per_s()[0];
            assert!(v > moved - 10.0 * T.0 - 1e-15, "never harder than allowed");
            moved = v;
        };
        let (word, gone) = if senses < 1000 {
            ("no sense", 0)
        } else {
            ("no command", 1)
        };
        assert!(
            matches!(error, AdmittanceError::Robot(why) if why == word),
            "{error}"
        );
        assert_eq!(device.state().fault(), Some(MotionFault::RobotFailed));
        assert!(device.state().is_at_rest());
        drop(device);
        assert_eq!(robot.let_go, gone);
    }
}

#[test]
fn a_guard_whose_premise_is_a_device_that_damps_is_refused() {
    let device = in_hand(&limits(), RobotHand::relaxed(), mass());
    device.accepts(&law_chain()).expect("no guard");
    let guard = EnergyBounding::of(NewtonSecondsPerMetre(3.5));
    let guarded = SafetyLimits {
        guard: Some(PassivityGuard::EnergyBounding(guard)),
        ..SafetyLimits::default()
    };
    let guarded = SafetyChain::from_limits(&guarded, T).expect("in range");
    assert_refused(device.accepts(&guarded), "needs a device that damps");
}
