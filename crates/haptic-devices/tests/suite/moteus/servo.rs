//! Forces that arrive, and each fault that a servo can have.

use super::world::{Rig, Wire};
use haptic_devices::moteus::{Instead, MoteusOpenError, MoteusSettings, MoteusTrouble};
use haptic_emulator::moteus::Shaft;
use haptic_link::{NOT_TAKEN, State, UNANSWERED};
use haptic_loop::Fault;
use moteus_protocol::Mode;
use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering},
};
use testkit::{assert_close, assert_refused, assert_says};

#[test]
fn a_force_is_a_torque_at_the_radius() {
    let mut rig = Rig::running(200.0);
    rig.lead(0.004);
    // −K·x = −0.8 N, at 20 mm; within a tick the lever gives way by τ/J·t²/2 = 4 µm, a thousandth.
    let torque_nm = rig.torque_nm();
    assert!((torque_nm + 0.8 * 0.02).abs() < 2e-5, "{torque_nm} N·m");
    let newest = rig.device.newest();
    assert!((newest.position_m[0] - 0.004).abs() < 5e-6, "{newest:?}");
    rig.device.disarm();
    for _ in 0..200 {
        rig.tick();
    }
    assert_eq!(rig.state(), State::Idle);
    let world = rig.wire.world();
    assert_eq!(world.adapter.servo.mode(), Mode::Stopped);
}

#[test]
fn ticks_that_are_skipped_are_no_jump_of_the_position() {
    let mut rig = Rig::running(0.0);
    let mut at_m = 0.0;
    for n in 0..60 {
        let skipped = if n % 10 == 5 { 6 } else { 0 };
        at_m += 4e-4 * f64::from(1 + skipped);
        rig.place(at_m);
        rig.tick_after(skipped);
        assert_eq!(rig.fault(), None, "tick {n} at {at_m} m: {}", rig.trouble());
    }
    let newest = f64::from(rig.device.newest().position_m[0]);
    assert_close("position", newest, at_m, 1e-3);
}

#[test]
fn each_command_that_is_lost_is_flagged_in_the_next_tick_and_counted() {
    let mut rig = Rig::running(200.0);
    let lost = Arc::new(AtomicU32::new(0));
    let (counting, mut n) = (Arc::clone(&lost), 0);
    rig.wire.world().harm = Some(Box::new(move |bytes, to_servo| {
        n += u32::from(to_servo);
        // Three of five, never four in a row.
        if to_servo && n % 5 > 1 {
            bytes.clear();
            counting.fetch_add(1, Ordering::Relaxed);
        }
    }));
    let before = *rig.device.statistics();
    let mut flagged = [0; 2];
    for tick in 0..800 {
        // The last is heard of.
        if tick == 799 {
            rig.wire.world().harm = None;
        }
        rig.tick();
        let flaws = rig.device.newest().flaws;
        flagged[0] += u32::from(flaws & UNANSWERED != 0);
        flagged[1] += u32::from(flaws & NOT_TAKEN != 0);
    }
    assert_eq!(rig.fault(), None, "{}", rig.trouble());
    let counted = rig.device.statistics().since(&before);
    assert_eq!([counted.unanswered, counted.forces_not_taken], flagged);
    assert_eq!(flagged, [lost.load(Ordering::Relaxed); 2]);
    assert!(flagged[0] > 400, "{flagged:?}");
}

#[test]
fn a_radius_below_zero_turns_the_direction_round() {
    let wire = Wire::new(Shaft::LEVER);
    let settings = MoteusSettings {
        radius_m: -0.02,
        ..MoteusSettings::DEFAULT
    };
    assert!(settings.metres_per_revolution() < 0.0);
    wire.open(settings).expect("it answers");
}

#[test]
fn an_answer_that_cannot_be_is_not_believed() {
    let mut rig = Rig::running(200.0);
    rig.lead(0.003);
    // Half a turn further, at rest: 63 mm.
    let forged = line("rcv 100 21000A2F010000003F0000000000000000210F00 E B F ");
    instead(&rig, forged);
    for tick in 0..5 {
        rig.tick();
        let position_m = rig.device.newest().position_m[0];
        assert!(
            (position_m - 0.003).abs() < 1e-4,
            "tick {tick}: {position_m} m"
        );
    }
    assert_eq!(rig.fault(), Some(Fault::BoardFailed));
    assert!(
        rig.trouble().contains("did not answer 4 times in a row"),
        "{}",
        rig.trouble()
    );
}

/// The words for what happens to a servo that runs, at most five ticks later.
fn trouble_of(happens: impl FnOnce(&mut Rig)) -> String {
    let mut rig = Rig::running(200.0);
    rig.lead(0.003);
    assert!(rig.torque_nm().abs() > 0.01, "it drives");
    happens(&mut rig);
    for _ in 0..5 {
        rig.tick();
    }
    assert_eq!(rig.fault(), Some(Fault::BoardFailed), "{}", rig.trouble());
    rig.trouble()
}

/// What comes from the servo is this instead.
fn instead(rig: &Rig, answer: Vec<u8>) {
    rig.wire.world().harm = Some(Box::new(move |bytes, to_servo| {
        if !to_servo {
            bytes.clone_from(&answer);
        }
    }));
}

#[test]
fn each_fault_is_named_within_five_ticks() {
    let of_another = "rcv 300 21000A2F01000000000000000000000000210F00 E B F ";
    type Happens = fn(&mut Rig);
    let happens: [(&str, Happens); 6] = [
        ("servo 1 is in fault 34, over voltage", |rig| {
            rig.wire.world().adapter.servo.fail(34);
        }),
        (
            "servo 1 did not answer 4 times in a row: nothing came",
            |rig| instead(rig, Vec::new()),
        ),
        ("does not know its position", |rig| {
            rig.wire.world().adapter.servo.place(f64::NAN);
        }),
        ("watchdog", |rig| {
            // The host has stood still; a hand holds the lever meanwhile.
            {
                let mut world = rig.wire.world();
                world.now_us += 150_000;
                let now_us = world.now_us;
                world.adapter.servo.advance(now_us);
            }
            rig.place(0.003);
        }),
        ("the adapter is gone", |rig| rig.wire.world().gone = true),
        (
            "mode 12, zero velocity, which this program did not ask for",
            |rig| {
                // Another program stops the servo; a stop of ours is followed by a command, this one is not.
                rig.wire.world().harm = Some(Box::new(|bytes, to_servo| {
                    if to_servo {
                        *bytes = line("can send 8001 01000C11001F01110F BF ");
                    }
                }));
            },
        ),
    ];
    for (words, happens) in happens {
        let message = trouble_of(happens);
        assert_says(&message, words);
    }
    let message = trouble_of(|rig| instead(rig, line(of_another)));
    assert_says(&message, "servo 3 talks to 0 on the bus of servo 1");
}

fn line(text: &str) -> Vec<u8> {
    let crc = moteus_protocol::fdcanusb::compute_crc8(text.as_bytes());
    format!("{text}*{crc:02X}\n").into_bytes()
}

#[test]
fn the_force_is_zero_after_a_fault_and_comes_back_with_the_next_run() {
    let mut rig = Rig::running(200.0);
    rig.lead(0.003);
    rig.wire.world().adapter.servo.fail(40);
    for _ in 0..5 {
        rig.tick();
    }
    assert_eq!((rig.state(), rig.torque_nm()), (State::Fault, 0.0));
    assert!(rig.start() < 10, "the stop has cleared it");
    rig.lead(0.003);
    assert!(rig.torque_nm().abs() > 0.01);
}

fn refused(wire: &Wire) -> MoteusTrouble {
    match wire.open(MoteusSettings::DEFAULT) {
        Err(MoteusOpenError::Trouble(trouble)) => trouble,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_servo_that_cannot_be_used_is_refused_at_the_door() {
    let wire = Wire::new(Shaft::LEVER);
    wire.world().harm = Some(Box::new(|bytes, _| bytes.clear()));
    let silent = MoteusTrouble::Silent {
        id: 1,
        ticks: 25,
        instead: Instead::default(),
    };
    assert_eq!(refused(&wire), silent);

    let wire = Wire::new(Shaft::LEVER);
    // Its number is another: the adapter takes the frames, nobody answers.
    let settings = MoteusSettings {
        id: 9,
        ..MoteusSettings::DEFAULT
    };
    assert_refused(wire.open(settings), "servo 9 did not answer & (`id`)");

    let wire = Wire::new(Shaft::LEVER);
    wire.world().harm = Some(Box::new(|bytes, to_servo| {
        if !to_servo {
            *bytes = line("rcv 100 2100012F01000000000000000000000000210F24 E B F ");
        }
    }));
    assert_eq!(refused(&wire), MoteusTrouble::Fault { id: 1, code: 36 });

    let wire = Wire::new(Shaft::LEVER);
    wire.world().harm = Some(Box::new(|bytes, to_servo| {
        if !to_servo {
            *bytes = b"login:\r\n".repeat(3);
        }
    }));
    let words = refused(&wire).to_string();
    assert_says(&words, "none of an fdcanusb");
}
