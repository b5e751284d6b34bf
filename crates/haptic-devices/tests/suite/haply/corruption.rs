//! One byte lost, added or changed, anywhere: a fault within 5 ticks or no harm, and never more force than allowed.

use super::wire::{Damage, FORCE_N, Running, TICK_US, Way, stroked};
use haptic_devices::haply::{TORQUE_MAX_NM, Version};
use haptic_emulator::{AtLine as _, haply::Board};
use haptic_link::State;
use haptic_loop::Fault;
use haptic_remote::{Tick, serial::ServedHardware as _};
use testkit::Random;

/// Cases; the promise is of 10⁵, which `CAMPAIGN_CASES=100000` runs in three minutes.
const CASES: u32 = 5_000;
/// Ticks in which a byte that is lost has to be a fault.
const TICKS: u32 = 5;

/// Counts of outcomes.
#[derive(Debug, Default)]
struct Seen {
    faults: u32,
    harmless: u32,
    /// Ticks from the damage to the fault at most.
    latest: u32,
    /// Cases in which the board made a torque that nobody sent.
    wrong: u32,
}

/// Boards that a hand strokes, in many places of the stroke.
fn boards(version: Version) -> Vec<(Board, u64)> {
    let mut board = stroked(version, 0);
    let phases = (0..32).map(|phase| {
        let now_us = 1_000_000 + phase * 15_625;
        board.advance(now_us);
        (board.clone(), now_us)
    });
    phases.collect()
}

/// Runs a case, and counts how it ended.
fn run<const D: usize>(mut running: Running<D>, planned: (Way, u32, Damage), seen: &mut Seen) {
    running.tick();
    running.tick();
    running.wire.with(|world| world.planned = Some(planned));
    let (way, _, damage) = planned;
    let mut since = None;
    let mut wrong = 0;
    for _ in 0..12 + TICKS {
        running.tick();
        let hit = running.wire.with(|world| world.planned.is_none());
        since = since.or(hit.then_some(0));
        let faulted = running.device.status().state == State::Fault;
        let sent = running.device.newest().force_n.map(f64::from);
        let sent = sent.iter().fold(0.0, |norm: f64, axis| norm.hypot(*axis));
        let made = running.force();
        wrong += u32::from(running.is_wrong());
        // The norm is scaled in single precision.
        let most = f64::from(FORCE_N) * (1.0 + f64::from(f32::EPSILON));
        assert!(sent <= most, "{planned:?}: {sent} N");
        assert!(running.torque() <= TORQUE_MAX_NM);
        if way == Way::ToHost || damage == Damage::Lost {
            assert!(
                made.norm() <= 1.01 * f64::from(FORCE_N),
                "{planned:?}: {made}"
            );
        }
        if damage == Damage::Lost {
            // Not for a moment either; 1e-33 is what zeros and a type of a frame make.
            let (asked, sent) = running.largest_torques();
            assert!(
                asked <= sent.max(1e-20),
                "{planned:?}: {asked} N·m of {sent}"
            );
        }
        if faulted {
            let ticks = since.expect("no fault before the damage");
            assert!(ticks < TICKS, "{planned:?}: {ticks} ticks");
            assert!(
                running.torque() < 1e-30,
                "{planned:?}: {}",
                running.torque()
            );
            let code = running.device.status().fault;
            let known = [Fault::BoardFailed, Fault::Workspace].map(Fault::code);
            assert!(known.contains(&code), "{planned:?}: fault {code}");
            assert!(running.device.hardware().trouble().is_some());
            seen.faults += 1;
            seen.latest = seen.latest.max(ticks + 1);
            seen.wrong += u32::from(wrong > 0);
            return;
        }
        since = since.map(|ticks| ticks + 1);
    }
    assert!(since.is_some(), "{planned:?} never came");
    assert_ne!(damage, Damage::Lost, "{planned:?}: nobody noticed");
    // A wrong torque of a tick is put right with the next frame.
    assert!(wrong <= 1, "{planned:?}: {wrong} ticks");
    seen.harmless += 1;
    seen.wrong += u32::from(wrong > 0);
}

/// Runs many cases of a kind of damage on a way, of one axis or of both: then a spring of the host around a place beside the way of the
/// hand.
fn campaign(both: bool, way: Way, damage: impl Fn(&mut Random) -> Damage) -> Seen {
    let mut random = Random(17 + way as u64);
    let boards = Version::ALL.map(boards);
    let mut seen = Seen::default();
    for case in 0..testkit::cases(CASES) / if both { 12 } else { 6 } {
        let version = case as usize % 2;
        let (board, now_us) = random_of(&boards[version], &mut random).clone();
        let version = Version::ALL[version];
        // Any byte of some frames, or of some answers.
        let byte = (random.bits() % 80) as u32;
        let planned = (way, byte, damage(&mut random));
        if both {
            let spring = |tick: &Tick<2>| {
                let [x, y] = tick.position_m;
                [60.0 * (0.01 - x), -60.0 * y]
            };
            let running = Running::both(board, version, now_us, TICK_US, Box::new(spring));
            run(running, planned, &mut seen);
        } else {
            run(Running::on(board, version, now_us), planned, &mut seen);
        }
    }
    println!("{way:?}, both axes {both}: {seen:?}");
    seen
}

fn random_of<'a, T>(list: &'a [T], random: &mut Random) -> &'a T {
    &list[random.bits() as usize % list.len()]
}

fn any(random: &mut Random) -> u8 {
    (random.bits() >> 13) as u8
}

/// One bit at least.
fn bits(random: &mut Random) -> u8 {
    any(random).max(1)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_lost_byte_is_a_fault_and_no_torque_of_the_wrong_place() {
    for both in [false, true] {
        for way in [Way::ToBoard, Way::ToHost] {
            let seen = campaign(both, way, |_| Damage::Lost);
            assert_eq!((seen.harmless, seen.wrong), (0, 0), "{seen:?}");
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn an_added_byte_of_an_answer_is_a_fault() {
    for both in [false, true] {
        let seen = campaign(both, Way::ToHost, |random| Damage::Added(any(random)));
        assert_eq!((seen.harmless, seen.wrong), (0, 0), "{seen:?}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_changed_byte_of_an_answer_is_a_fault_or_no_harm() {
    for both in [false, true] {
        let seen = campaign(both, Way::ToHost, |random| Damage::Changed(bits(random)));
        // The upper half of the bits of an angle, and the number of the device.
        assert!(seen.faults > seen.harmless / 2, "{seen:?}");
        assert!(both || seen.wrong == 0, "{seen:?}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn bytes_added_or_changed_on_the_way_to_the_board_last_a_tick_or_are_a_fault() {
    // A board without a checksum takes them for torques: nothing on this side can keep it from that, for one frame.
    for both in [false, true] {
        campaign(both, Way::ToBoard, |random| Damage::Added(any(random)));
        campaign(both, Way::ToBoard, |random| Damage::Changed(bits(random)));
    }
}
