//! An emulator that this machine did not run for a while.

use super::*;
use haptic_link::Request;
use haptic_remote::{Conversation, Incoming};
use std::sync::atomic::AtomicU64;

/// The clock of the test, ms.
static NOW_MS: AtomicU64 = AtomicU64::new(0);

fn clock() -> Moment {
    static BEGAN: std::sync::OnceLock<Moment> = std::sync::OnceLock::new();
    *BEGAN.get_or_init(Moment::now) + Duration::from_millis(NOW_MS.load(Ordering::Relaxed))
}

/// A host that speaks with an emulated board over queues.
struct Pair {
    emulator: Emulator<Embodied<SimulatedPlant>, 1>,
    to_device: SyncSender<(usize, Vec<u8>)>,
    from_device: Receiver<Vec<u8>>,
    host: Conversation,
    now: TickTime,
}

impl Pair {
    fn new() -> Self {
        let emulation = Emulation {
            axes: 1,
            body: None,
            speed: 1.0,
            faults: LineFaults::default(),
            seed: 1,
            duration: None,
        };
        let (to_device, arriving) = sync_channel(WAITING_MOST);
        let (leave, from_device) = sync_channel(WAITING_MOST);
        let plant = Embodied::new(SimulatedPlant::new("emulated", || 0), None).expect("ideal");
        let board = EmulatedBoard::new(plant, &emulation, leave).expect("works");
        Self {
            emulator: Emulator {
                boards: vec![board],
                arriving,
                clock: HeldClock::new(clock, 1.0),
                speed: 1.0,
            },
            to_device,
            from_device,
            host: Conversation::new(1 << 40),
            now: TickTime::default(),
        }
    }

    fn asks(&mut self, request: Request) {
        let mut line = [0; FRAME_MAX];
        let length = self.host.ask(request, 0, &mut line);
        let sent = self.to_device.send((0, line[..length].to_vec()));
        sent.expect("it is there");
    }

    /// So much time passes, then the emulator works on what came; true if the answer has left.
    fn answers_after(&mut self, ms: u64) -> bool {
        NOW_MS.fetch_add(ms, Ordering::Relaxed);
        assert!(self.emulator.round(&self.now));
        let said: Vec<u8> = self.from_device.try_iter().flatten().collect();
        let mut answered = false;
        for byte in said {
            answered |= matches!(self.host.receive(byte, 0), Some(Incoming::Answer(_)));
        }
        answered
    }
}

#[test]
fn a_board_that_was_stopped_for_five_seconds_answers_at_once_and_goes_on() {
    let mut pair = Pair::new();
    pair.asks(Request::Hello { nonce: 1 });
    assert!(pair.answers_after(1));
    for _ in 0..3 {
        // It is asked while it does not run, as a host does all the time.
        pair.asks(Request::GetStatistics);
        assert!(pair.answers_after(5000));
        for _ in 0..10 {
            pair.asks(Request::GetStatistics);
            assert!(pair.answers_after(1));
        }
    }
    // Its own time stood still meanwhile, but for what it may be behind.
    let ticks = pair.emulator.boards[0].ticks;
    assert!((33..33 + 3 * 6).contains(&ticks), "{ticks}");
}
