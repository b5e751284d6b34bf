//! The driver in order: place, force along the line and none across it, both versions; and boards that are not in order.

use super::wire::{Damage, FORCE_N, Running, Way, Wire, World, name, stroked};
use haptic_devices::haply::{
    Haply2Diy, HaplyOpenError, HaplyTrouble, Home, LATE_MOST, Version, configuration, torques,
};
use haptic_emulator::{
    AtLine as _,
    haply::{Board, Body, Hand},
};
use haptic_link::{NOT_TAKEN, Refusal, Start, State, UNANSWERED};
use haptic_loop::{Fault, Limiters};
use haptic_remote::serial::ServedHardware as _;
use testkit::{assert_close, assert_refused, assert_says};

/// A board of a version that a host has configured as another and led for so long, s.
fn configured(version: Version, as_version: Version, hand: Hand, for_s: f64) -> (Board, u64) {
    let model = version.model();
    let mut board = Board::new(model, Body::at_home(&model, hand));
    for byte in configuration(&as_version.model()) {
        board.receive(byte, 0, &mut Vec::new());
    }
    let now_us = (for_s * 1e6) as u64;
    board.advance(now_us);
    (board, now_us)
}

#[test]
fn a_spring_along_the_line_pushes_along_the_line() {
    for version in Version::ALL {
        let mut running = Running::on(stroked(version, 1_000_000), version, 1_000_000);
        let (mut pressed, mut largest) = (0, 0.0_f64);
        for _ in 0..1000 {
            running.tick();
            let sample = *running.device.newest();
            let force = running.force();
            // The Jacobian is that of a tick ago: 0.1 mm away at most, of 60 mm.
            let across = 0.01 * force.y.abs() + 1e-6;
            assert!(force.x.abs() < across, "{force}");
            let difference = (force.y - f64::from(sample.force_n[0])).abs();
            assert!(
                difference < 0.01 * force.y.abs() + 1e-6,
                "{force} {sample:?}"
            );
            pressed += u32::from(sample.force_n[0] < -0.01);
            largest = largest.max(force.y.abs());
        }
        assert_eq!(running.device.status().state, State::Running);
        assert!(
            pressed > 200 && largest > 0.1,
            "{pressed} ticks, {largest} N"
        );
        assert!(largest < f64::from(FORCE_N));
        assert_eq!(running.device.hardware().scaled(), 0);
    }
}

#[test]
fn the_place_is_true_to_a_count() {
    for version in Version::ALL {
        let model = version.model();
        let place = [0.5 * model.pantograph.base_m + 0.02, 0.11];
        let (board, now_us) = configured(version, version, Hand::Fixed(place), 1.5);
        let mut running = Running::on(board, version, now_us);
        running.tick();
        let position = f64::from(running.device.newest().position_m[0]);
        // A whole count at the beginning, half a count now, of two encoders.
        let most = 1.5 * 2.0 * f64::from(model.resolution_m());
        assert_close("position", position, 0.02, most);
    }
}

/// A board that is driven after some ticks.
fn with_torque(version: Version) -> Running {
    let mut running = Running::on(stroked(version, 1_200_000), version, 1_200_000);
    for _ in 0..50 {
        running.tick();
    }
    assert!(running.torque() > 0.0);
    running
}

#[test]
fn a_board_that_falls_silent_is_a_fault_and_has_no_torque_when_it_comes_back() {
    let mut running = with_torque(Version::V3);
    running.wire.with(|world| world.dead = true);
    for tick in 1..=5_u32 {
        running.tick();
        let faulted = running.device.status().state == State::Fault;
        // The answer to the last frame is on its way already.
        assert_eq!(faulted, tick > 1 + LATE_MOST, "tick {tick}");
    }
    assert_eq!(running.device.status().fault, Fault::BoardFailed.code());
    let trouble = running.device.hardware().ended_by();
    let silent = matches!(trouble, Some(HaplyTrouble::Silent { bytes: 0, .. }));
    assert!(silent, "{trouble:?}");
    // What its samples still tell is no measurement, and each says so.
    for _ in 0..50 {
        running.tick();
        let newest = running.device.newest();
        assert_eq!(newest.limiters, Limiters::FAULT.bits(), "{newest:?}");
    }
    // Armed again it is not, however often: what came last is not known to be true.
    assert!(running.device.arm(running.device.status().faults).is_err());
}

#[test]
fn a_board_that_is_asked_for_no_force_may_be_silent_for_two_seconds_and_is_not_armed_meanwhile() {
    let mut running = with_torque(Version::V3);
    running.device.disarm();
    let states = |running: &mut Running, silent, count| {
        running.wire.with(|world| world.held = silent);
        (0..count).for_each(|_| running.tick());
        running.device.status().state
    };
    assert_eq!(states(&mut running, false, 500), State::Idle);
    assert_eq!(states(&mut running, true, 1990), State::Idle);
    let persists = Refusal::FaultPersists(Fault::BoardFailed.code());
    assert_eq!(running.device.arm(0), Err(persists));
    assert_eq!(states(&mut running, false, 5), State::Idle);
    running.device.arm(0).expect("it answers");
    assert_eq!(states(&mut running, true, 100), State::Armed);
    // It may not answer a force so late.
    running.device.start(Start::ENDLESS).expect("is armed");
    assert_eq!(states(&mut running, true, 1), State::Fault);
    assert!(running.torque().abs() < 1e-6);

    let mut running = with_torque(Version::V3);
    running.device.disarm();
    assert_eq!(states(&mut running, false, 500), State::Idle);
    assert_eq!(states(&mut running, true, 2010), State::Fault);
}

#[test]
fn the_answer_of_another_device_is_a_fault() {
    let mut running = with_torque(Version::V3);
    let number = (Way::ToHost, 0, Damage::Changed(1));
    running.wire.with(|world| world.planned = Some(number));
    for _ in 0..3 {
        running.tick();
    }
    let trouble = running.device.hardware().ended_by();
    assert_eq!(trouble, Some(HaplyTrouble::OtherDevice { device_id: 4 }));
}

#[test]
fn each_tick_without_an_answer_and_each_force_not_sent_is_flagged_and_counted_once() {
    let mut running = with_torque(Version::V3);
    let heard = |running: &Running| running.wire.with(|world| world.board.counted().torques);
    let (before, frames) = (*running.device.statistics(), heard(&running));
    let (mut flagged, ticks) = ([0; 2], 1000);
    for n in 1..=ticks {
        // One answer in seven comes a tick late, one in eleven two ticks late.
        let held = n % 7 == 0 || n % 11 < 2;
        running
            .wire
            .with(|world| world.held = held && n < ticks - 1);
        running.tick();
        let flaws = running.device.newest().flaws;
        flagged[0] += u32::from(flaws & UNANSWERED != 0);
        flagged[1] += u32::from(flaws & NOT_TAKEN != 0);
        assert_eq!(flaws & UNANSWERED != 0, held && n < ticks - 1, "tick {n}");
    }
    assert_eq!(running.device.status().state, State::Running);
    let counted = running.device.statistics().since(&before);
    assert_eq!([counted.unanswered, counted.forces_not_taken], flagged);
    let not_sent = u64::from(counted.ticks) - (heard(&running) - frames);
    assert_eq!(u64::from(counted.forces_not_taken), not_sent);
    assert!(flagged[0] > 200 && not_sent > 200, "{flagged:?}");
}

#[test]
fn a_port_that_is_gone_is_not_said_to_have_told_the_board_anything() {
    for (silent, outcome) in [(false, "cannot be told to let go"), (true, "was told to")] {
        let mut running = with_torque(Version::V3);
        running.wire.with(|world| {
            world.dead = silent;
            world.gone = !silent;
        });
        for _ in 0..10 {
            running.tick();
        }
        assert_eq!(running.device.status().fault, Fault::BoardFailed.code());
        // What is said is true: behind a port that is gone the motors still push.
        assert!(running.torque() > 0.0);
        let words = running.device.hardware().trouble().expect("failed").words;
        assert_says(&words, outcome);
        assert_eq!(words.contains("its port is gone"), !silent, "{words}");
        assert!(silent || !words.contains("reset"), "{words}");
    }
}

#[test]
fn letting_go_leaves_the_board_without_torque_and_configured() {
    let Running { device, wire, .. } = with_torque(Version::V2);
    drop(device);
    let left = wire.with(|world| world.board.torques_nm());
    assert!(left.iter().all(|torque| torque.abs() < 1e-30), "{left:?}");
    // The home of before is still there.
    let again = Haply2Diy::<_, 1>::greet(wire, &name(Version::V2, Home::Before));
    assert!(again.is_ok(), "{again:?}");
}

#[test]
fn every_command_finds_the_handle_at_its_home_or_goes_on_with_that_of_before() {
    for version in Version::ALL {
        let model = version.model();
        let into = [0.5 * model.pantograph.base_m, 0.09];
        let led = |wire: &Wire| {
            wire.with(|world| {
                world.now_us += 1_500_000;
                let now_us = world.now_us;
                world.board.advance(now_us);
                world.board.body().place_m()
            })
        };
        let board = Board::new(model, Body::at_home(&model, Hand::At(into)));
        let home_m = board.body().place_m();
        let wire = Wire::new(World::new(board));
        let seen = |home| {
            let device =
                Haply2Diy::<_, 1>::greet(wire.clone(), &name(version, home)).expect("answers");
            device.posture().hand_m
        };
        let step_m = 2.0 * f64::from(model.resolution_m());
        for _ in 0..3 {
            assert!((seen(Home::Now) - home_m).norm() < step_m);
            let place_m = led(&wire);
            assert!((place_m - home_m).norm() > 0.03, "it was led: {place_m}");
            // The encoders count on.
            let before_m = seen(Home::Before);
            assert!((before_m - place_m).norm() < step_m, "{before_m} {place_m}");
        }
    }
}

#[test]
fn what_the_home_of_before_cannot_be_names_the_remedy() {
    // The home of the wrong version, and led into the middle since.
    let hand = Hand::At([0.03, 0.12]);
    let (board, now_us) = configured(Version::V2, Version::V3, hand, 1.5);
    let mut world = World::new(board);
    world.now_us = now_us;
    let refused = Haply2Diy::<_, 1>::greet(Wire::new(world), &name(Version::V3, Home::Before));
    assert_refused(refused, "omit home=before");
}

#[test]
fn a_2diy_of_the_other_version_is_said_to_be_one() {
    // At its home each version answers as it was told. On its way into the middle the angles of the one that counts twice as far
    // are out of reach, wherever it goes. The other way round they are those of another posture, and cannot be told.
    let model = Version::V2.model();
    for (x, y) in [(0.03, 0.12), (0.0, 0.09), (-0.05, 0.08), (0.04, 0.05)] {
        let hand = Hand::At([x, y]);
        let (board, now_us) = configured(model.version, Version::V3, hand, 0.01);
        let mut running = Running::on(board, Version::V3, now_us);
        let mut ticks = 0;
        while running.device.status().state == State::Running && ticks < 3000 {
            running.tick();
            ticks += 1;
        }
        let trouble = running.device.hardware().ended_by();
        println!("to ({x}, {y}): tick {ticks}, {trouble:?}");
        let message = trouble.expect("a trouble").to_string();
        assert_says(&message, "version");
        assert!(running.torque() < 1e-30);
    }
}

#[test]
fn a_device_that_is_none_is_refused() {
    let fresh = || {
        let model = Version::V3.model();
        Board::new(model, Body::at_home(&model, Hand::Free))
    };
    // A board that nobody has configured answers with one byte.
    let wire = Wire::new(World::new(fresh()));
    let before = Haply2Diy::<_, 1>::greet(wire, &name(Version::V3, Home::Before));
    let mute = matches!(before, Err(HaplyOpenError::NoHome { bytes: 1 }));
    assert!(mute, "{before:?}");
    let mut world = World::new(fresh());
    world.dead = true;
    let dead = Haply2Diy::<_, 1>::greet(Wire::new(world), &name(Version::V3, Home::Now));
    assert!(
        matches!(dead, Err(HaplyOpenError::Mute { bytes: 0 })),
        "{dead:?}"
    );
    // A frame that somebody else has begun does no harm.
    let wire = Wire::new(World::new(fresh()));
    let begun = torques(&Version::V3.model(), [0.1, 0.1]);
    for cut in 1..begun.len() {
        wire.with(|world| {
            for &byte in &begun[..cut] {
                world.board.receive(byte, 0, &mut Vec::new());
            }
        });
        let greeted = Haply2Diy::<_, 1>::greet(wire.clone(), &name(Version::V3, Home::Now));
        assert!(greeted.is_ok(), "{cut}: {greeted:?}");
    }
}
