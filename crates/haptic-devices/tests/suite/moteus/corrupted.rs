//! Bytes that are lost, shifted, flipped or made up on the line: a fault within five ticks, or no harm; never a force beyond
//! the limits.

use super::world::{FORCE_LIMIT_N, Rig, Wire};
use haptic_devices::moteus::MoteusSettings;
use haptic_emulator::moteus::{EmulatedAdapter, EmulatedServo, Shaft};
use haptic_link::State;
use std::sync::{Arc, Mutex};
use testkit::Random;

/// Ticks after the last harmed one by which a fault must have latched.
const SOON: u32 = 5;

/// Something that happens to bytes.
fn harm(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = (random.bits() % bytes.len() as u64) as usize;
    let most = 1 + (random.bits() % 20) as usize;
    let end = (at + most).min(bytes.len());
    match random.bits() % 8 {
        0 => bytes[at] ^= 1 << (random.bits() % 8),
        1 => bytes[at] = random.bits() as u8,
        2 => drop(bytes.drain(at..end)),
        3 => drop(
            bytes
                .splice(at..at, (0..most).map(|_| random.bits() as u8))
                .count(),
        ),
        4 => {
            let again = bytes[at..end].to_vec();
            bytes.splice(at..at, again);
        }
        5 => bytes.truncate(at),
        6 => {
            // Another digit in the place of one: what no text shows.
            let digits = b"0123456789ABCDEF";
            bytes[at] = digits[(random.bits() % 16) as usize];
        }
        _ => {
            for byte in &mut bytes[at..end] {
                *byte = random.bits() as u8;
            }
        }
    }
}

/// Where the lever is at this time, m: it is moved to and fro, 4 mm at 1.5 Hz.
fn place_m(now_us: u64) -> f64 {
    4e-3 * libm::sin(core::f64::consts::TAU * 1.5 * now_us as f64 * 1e-6)
}

/// A tick on the way, with a torque within the limit.
fn step(rig: &mut Rig) {
    let torque_most = f64::from(FORCE_LIMIT_N) * MoteusSettings::DEFAULT.radius_m * (1.0 + 1e-6);
    let now_us = rig.wire.world().now_us;
    rig.place(place_m(now_us));
    rig.tick();
    let torque_nm = rig.torque_nm();
    assert!(torque_nm.abs() <= torque_most, "{torque_nm} N·m");
}

/// So many ticks with damage, and some without: for how many of them in a row the place is wrong, at most.
fn longest_at_a_wrong_place(rig: &mut Rig, harmed: u32) -> u32 {
    let (mut wrong, mut longest) = (0, 0);
    for tick in 0..harmed + SOON {
        if tick == harmed {
            rig.wire.world().harm = None;
        }
        step(rig);
        let now_us = rig.wire.world().now_us;
        let seen = f64::from(rig.device.newest().position_m[0]);
        // As old as four ticks, at 0.04 mm a tick.
        let off = (seen - place_m(now_us - 1000)).abs() > 0.2e-3;
        let felt = off && rig.state() != State::Fault;
        wrong = if felt { wrong + 1 } else { 0 };
        longest = longest.max(wrong);
    }
    longest
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn damage_ends_in_a_fault_soon_or_does_no_harm() {
    // 10⁵ each night.
    let cases = testkit::cases(10_000);
    let mut random = Random(17);
    let mut rig = Rig::new(300.0);
    let (mut faults, mut harmless, mut mistaken) = (0, 0, 0);
    for case in 0..cases {
        rig.start();
        for _ in 0..1 + random.bits() % 4 {
            step(&mut rig);
        }
        let to_servo = random.chance(0.5);
        let harmed = 1 + (random.bits() % 6) as u32;
        let mut chance = Random(random.bits());
        rig.wire.world().harm = Some(Box::new(move |bytes, towards| {
            if towards == to_servo {
                harm(bytes, &mut chance);
            }
        }));
        let longest = longest_at_a_wrong_place(&mut rig, harmed);
        assert!(
            longest <= SOON,
            "case {case}: {longest} ticks at a wrong place, and no fault"
        );
        mistaken += u32::from(longest > 0);
        if rig.state() == State::Fault {
            faults += 1;
            // The frames that say stop are whole again.
            assert!(
                rig.torque_nm().abs() <= 0.0,
                "case {case}: a torque after a fault"
            );
        } else {
            harmless += 1;
        }
    }
    println!(
        "{cases} corruptions: {faults} faults, {harmless} without harm; a wrong place in {mistaken}"
    );
    // A checksum of 8 bits lets one of 256 through, and most of those are no answers.
    assert!(mistaken <= cases / 1000, "{mistaken} wrong places");
    assert!(
        faults > cases / 1000 && harmless > cases / 4,
        "both ways are taken"
    );
}

/// Damages commands and nothing else, one to three in a row: how many, and how many of them made a torque beyond the limit.
fn damaged_commands(mut rig: Rig, cases: u32) -> (u32, u32) {
    let mut random = Random(18);
    let torque_most = f64::from(FORCE_LIMIT_N) * MoteusSettings::DEFAULT.radius_m * (1.0 + 1e-6);
    let (mut beyond, mut damaged) = (0, 0);
    for _ in 0..cases {
        rig.start();
        let mut chance = Random(random.bits());
        rig.wire.world().harm = Some(Box::new(move |bytes, towards| {
            if towards {
                harm(bytes, &mut chance);
            }
        }));
        for _ in 0..1 + random.bits() % 3 {
            let now_us = rig.wire.world().now_us;
            rig.place(place_m(now_us));
            rig.tick();
            damaged += 1;
            beyond += u32::from(rig.torque_nm().abs() > torque_most);
        }
        rig.wire.world().harm = None;
        for _ in 0..SOON {
            let now_us = rig.wire.world().now_us;
            rig.place(place_m(now_us));
            rig.tick();
        }
    }
    println!("{damaged} damaged commands: {beyond} with a torque beyond the limit");
    (damaged, beyond)
}

#[test]
fn without_checksums_a_damaged_command_hardly_ever_makes_a_force_beyond_the_limit() {
    let (damaged, beyond) = damaged_commands(Rig::without_checksum(300.0), testkit::cases(3000));
    // Several bytes in a row that are lost, added or others may make a block of one-byte torques, of 0.5 N·m a step, in the place of
    // those that are limited. No single byte does: see below. 0.07 % seen.
    assert!(500 * beyond <= damaged, "{beyond} of {damaged}");
}

#[test]
fn an_adapter_that_shows_that_it_knows_checksums_is_spoken_to_with_them() {
    let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
    let wire = Wire::to(EmulatedAdapter::new(servo), false);
    let (_, beyond) = damaged_commands(Rig::on(wire, 300.0), testkit::cases(3000));
    assert_eq!(beyond, 0);
}

/// An adapter whose servo drives at a torque, N·m, and the line of its next command.
fn driving(mut rig: Rig) -> (EmulatedAdapter, f64, Vec<u8>) {
    rig.start();
    rig.lead(0.003);
    let torque_nm = rig.torque_nm().abs();
    let sent = Arc::new(Mutex::new(Vec::new()));
    let heard = Arc::clone(&sent);
    rig.wire.world().harm = Some(Box::new(move |bytes, towards| {
        if towards {
            heard.lock().expect("whole").clone_from(bytes);
        }
    }));
    rig.tick();
    let line = sent.lock().expect("whole").clone();
    let adapter = rig.wire.world().adapter.clone();
    (adapter, torque_nm.max(rig.torque_nm().abs()), line)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn one_byte_of_a_command_makes_no_more_torque_whatever_becomes_of_it() {
    for rig in [Rig::new(300.0), Rig::without_checksum(300.0)] {
        let (adapter, torque_nm, line) = driving(rig);
        let most_nm = torque_nm * (1.0 + 1e-6);
        assert!(torque_nm > 0.01 && line.len() > 80, "{torque_nm} N·m");
        let mut tried = 0;
        let mut take = |damaged: &[u8]| {
            let mut adapter = adapter.clone();
            // A line without its end goes on with the next one.
            for bytes in [damaged, &line, &line] {
                adapter.receive(bytes, 0, &mut Vec::new());
                let made_nm = adapter.servo.torque_nm();
                let text = String::from_utf8_lossy(damaged);
                assert!(made_nm.abs() <= most_nm, "{made_nm} N·m: {text}");
            }
            tried += 1;
        };
        for at in 0..line.len() {
            let mut lost = line.clone();
            lost.remove(at);
            take(&lost);
            for byte in 0..=u8::MAX {
                let (mut changed, mut added) = (line.clone(), line.clone());
                changed[at] = byte;
                added.insert(at, byte);
                take(&changed);
                take(&added);
            }
        }
        println!("{tried} commands with one byte lost, changed or added: none made more torque");
    }
}
