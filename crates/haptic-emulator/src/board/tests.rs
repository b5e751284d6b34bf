//! An emulator that this machine did not run for a while.

use super::*;
use haptic_link::Request;
use haptic_remote::Conversation;
use std::sync::atomic::AtomicU64;

/// The clock of the test, ms.
static NOW_MS: AtomicU64 = AtomicU64::new(0);

fn clock() -> Moment {
    static BEGAN: std::sync::OnceLock<Moment> = std::sync::OnceLock::new();
    *BEGAN.get_or_init(Moment::now) + Duration::from_millis(NOW_MS.load(Ordering::Relaxed))
}

#[test]
fn a_board_that_was_stopped_for_five_seconds_answers_at_once_and_goes_on() {
    let emulation = Emulation {
        axes: 1,
        body: None,
        sensor: None,
        at_handle: None,
        robot: None,
        speed: 1.0,
        faults: LineFaults::default(),
        seed: 1,
        duration: None,
    };
    let (to_device, arriving) = sync_channel(WAITING_MOST);
    let (leave, from_device) = sync_channel(WAITING_MOST);
    let plant = Embodied::new(SimulatedPlant::new("emulated", || 0), None, None).expect("ideal");
    let mut emulator = Emulator {
        boards: vec![EmulatedBoard::new(plant, &emulation, leave).expect("works")],
        arriving,
        clock: HeldClock::new(clock, 1.0),
        speed: 1.0,
    };
    let (mut host, mut line) = (Conversation::new(1 << 40), [0; FRAME_MAX]);
    // It is asked while it does not run, as a host does all the time.
    for (nonce, passed_ms) in (0..).zip([1, 5000, 1, 1, 1, 5000, 1, 1, 1, 1, 300_000, 1, 1]) {
        let length = host.tell(&Request::Hello { nonce }, &mut line);
        let sent = to_device.send((0, line[..length].to_vec()));
        sent.expect("it is there");
        NOW_MS.fetch_add(passed_ms, Ordering::Relaxed);
        assert!(emulator.round(&TickTime::default()));
        assert!(from_device.try_iter().count() > 0, "{nonce}: no answer");
    }
    // Its own time stood still meanwhile: a tick each time.
    assert_eq!(emulator.boards[0].ticks, 13);
}
