//! The template's board says hello: its own `board.rs` in the device half, over a line in memory, with a real host half.

#[path = "../../../../firmware/template/src/board.rs"]
mod board;

use board::{Board, NAME};
use haptic_board::{
    DeviceMemory, HostLine, Image, MainLoop, Queue, RetainedMemory, Shared, TickTimer, Ticker,
    Watchdog,
    haptic_link::{
        CoefficientBlock, Configuration, DeviceReport, DigestBuilder, FRAME_MAX, Field, Keys,
        Limits, Refusal, Request, Scope, Simulation, SimulationKind, Start, State,
    },
    haptic_loop::Fault,
    haptic_remote::{Conversation, Exclusive as _, Incoming},
    power_up,
};
use std::{
    cell::{Cell, RefCell},
    collections::VecDeque,
    rc::Rc,
};

/// Where a linker would put the parts of an image there are nine bytes.
static IMAGE: Image = Image::linked(NAME, [1, 2, 3], [&[]; 7], || [b"1234", b"567", b"89"]);

/// A timer that only remembers.
#[derive(Debug, Default)]
struct Timer {
    period_us: Rc<Cell<u32>>,
    pending: Rc<Cell<bool>>,
}

impl TickTimer for Timer {
    fn acknowledge(&mut self) {}

    fn is_pending(&self) -> bool {
        self.pending.get()
    }

    fn set_period_us(&mut self, period_us: u32) {
        self.period_us.set(period_us);
    }
}

/// A line in memory, and the host's end of it.
#[derive(Debug)]
struct Wire {
    to_device: Queue<64>,
    to_host: RefCell<VecDeque<u8>>,
    room: Cell<usize>,
}

impl HostLine for &Wire {
    fn receive(&mut self) -> Option<u8> {
        self.to_device.pop()
    }

    fn take_lost(&mut self) -> u32 {
        self.to_device.take_lost()
    }

    fn room(&self) -> usize {
        self.room.get()
    }

    fn send(&mut self, bytes: &[u8]) {
        assert!(
            bytes.len() <= self.room.get(),
            "only what there is room for"
        );
        self.to_host.borrow_mut().extend(bytes);
    }
}

/// Counts how often it is fed.
#[derive(Debug, Default)]
struct Counting(u32);

impl Watchdog for Counting {
    fn feed(&mut self) {
        self.0 += 1;
    }
}

/// A board, and a host that talks to it, in virtual time.
struct World {
    device: &'static Shared<Board>,
    ticker: Ticker<Board, Timer>,
    main_loop: MainLoop<'static, Board>,
    wire: Wire,
    watchdog: Counting,
    host: Conversation,
    period_us: Rc<Cell<u32>>,
    pending: Rc<Cell<bool>>,
    now_us: u64,
    samples: Vec<(u32, f32)>,
}

impl World {
    fn new(retained: &'static RetainedMemory) -> Self {
        let known = retained.take();
        let place = Box::leak(Box::new(DeviceMemory::new()));
        let board = Board::new(|| 0);
        let (device, session) = power_up(place, board, IMAGE.version(), known).expect("a board");
        session.set_image_digest(IMAGE.digest());
        let timer = Timer::default();
        let (period_us, pending) = (timer.period_us.clone(), timer.pending.clone());
        Self {
            device,
            ticker: Ticker::new(device, timer, retained),
            main_loop: MainLoop::new(device, session),
            wire: Wire {
                to_device: Queue::new(),
                to_host: RefCell::default(),
                room: Cell::new(512),
            },
            watchdog: Counting::default(),
            host: Conversation::new(50_000),
            period_us,
            pending,
            now_us: 0,
            samples: Vec::new(),
        }
    }

    fn fresh() -> Self {
        Self::new(Box::leak(Box::default()))
    }

    /// Rounds of the main loop until it would sleep.
    fn rounds(&mut self) {
        let now_us = self.now_us;
        let mut line = &self.wire;
        let (main_loop, watchdog) = (&mut self.main_loop, &mut self.watchdog);
        while !main_loop.round(&mut line, watchdog, || now_us) {}
    }

    fn hear(&mut self) -> Option<Incoming> {
        let mut answer = None;
        let bytes: Vec<u8> = self.wire.to_host.borrow_mut().drain(..).collect();
        for byte in bytes {
            match self.host.receive(byte, self.now_us) {
                Some(Incoming::Report(DeviceReport::Sample(sample))) => {
                    self.samples.push((sample.tick, sample.axes[0].force_n));
                }
                Some(Incoming::Report(_)) | None => {}
                Some(other) => answer = Some(other),
            }
        }
        answer
    }

    fn ask(&mut self, request: Request) -> Incoming {
        let mut frame = [0; FRAME_MAX];
        let length = self.host.ask(request, self.now_us, &mut frame);
        // The line is shorter than most frames: what waits in it is fetched meanwhile.
        for piece in frame[..length].chunks(32) {
            self.wire.to_device.extend(piece);
            self.rounds();
        }
        self.hear().expect("an answer")
    }

    fn done(&mut self, request: Request) {
        let name = request.name();
        let answer = self.ask(request);
        assert!(
            matches!(answer, Incoming::Answer(DeviceReport::Ack(_))),
            "{name}: {answer:?}"
        );
    }

    fn tick(&mut self) {
        self.now_us += u64::from(self.period_us.get());
        self.ticker.tick(self.now_us);
        self.rounds();
        self.hear();
    }

    fn configure(&mut self, configuration: Configuration) -> Incoming {
        self.done(Request::Configure(configuration));
        self.done(Request::Coefficients(CoefficientBlock::of(&[0.0], 0)));
        let digest = DigestBuilder::new(&configuration)
            .coefficients(&[0.0])
            .finish();
        let scope = Scope::Lasting;
        self.ask(Request::Commit { digest, scope })
    }
}

/// The template makes 2 N and 4000 N/s at most.
fn configuration() -> Configuration {
    Configuration {
        limits: Limits {
            force_n: 1.0,
            force_rate_n_per_s: 1000.0,
            ..Configuration::PASSIVE.limits
        },
        ..Configuration::PASSIVE
    }
}

#[test]
fn the_template_says_hello_and_what_it_is() {
    let mut world = World::fresh();
    let answer = world.ask(Request::Hello { nonce: 5 });
    let Incoming::Answer(DeviceReport::Hello(hello)) = answer else {
        panic!("{answer:?}");
    };
    assert_eq!((hello.nonce, hello.firmware, hello.boot), (5, [1, 2, 3], 1));
    assert_eq!((hello.status.state, hello.status.fault), (State::Idle, 0));
    let keys = world.ask(Request::GetKeys);
    assert_eq!(keys, Incoming::Answer(DeviceReport::Keys(Keys::current())));
    let answer = world.ask(Request::GetCapabilities);
    let Incoming::Answer(DeviceReport::Capabilities(mine)) = answer else {
        panic!("{answer:?}");
    };
    assert_eq!((mine.board(), mine.axes, mine.simulated), (NAME, 1, false));
    assert!(mine.force_max_n > 0.0 && mine.force_rate_max_n_per_s > 0.0);
    // The published check value of this CRC.
    assert_eq!(mine.image_digest, 0xCBF4_3926);
}

#[test]
fn it_runs_as_asked_and_the_timer_follows_the_configuration() {
    let mut world = World::fresh();
    world.ask(Request::Hello { nonce: 1 });
    assert_eq!(world.period_us.get(), 1000, "until told otherwise");
    let faster = Configuration {
        tick_period_us: 500,
        ..configuration()
    };
    let committed = world.configure(faster);
    assert!(matches!(committed, Incoming::Answer(DeviceReport::Ack(_))));
    world.tick();
    assert_eq!(world.period_us.get(), 500);
    world.done(Request::Arm { faults: 0 });
    let start = Start {
        ticks: 20,
        ..Start::ENDLESS
    };
    world.done(Request::Start(start));
    for _ in 0..30 {
        world.tick();
    }
    let ticks: Vec<u32> = world.samples.iter().map(|&(tick, _)| tick).collect();
    assert_eq!(ticks[..20], (0..20).collect::<Vec<u32>>());
    assert!(world.samples.iter().all(|&(_, force_n)| force_n == 0.0));
    assert_eq!(world.watchdog.0, 31, "once a tick");
    let state = world.device.with(|device| device.status().state);
    assert_eq!(state, State::Armed);
}

#[test]
fn a_board_with_a_motor_simulates_nothing() {
    let mut world = World::fresh();
    world.ask(Request::Hello { nonce: 1 });
    let simulated = Configuration {
        simulation: Simulation {
            kind: SimulationKind::MassDamper,
            ..Simulation::TESTBED
        },
        ..configuration()
    };
    let answer = world.configure(simulated);
    let Incoming::Refused { refusal, .. } = answer else {
        panic!("{answer:?}");
    };
    assert_eq!(refusal, Refusal::Unsupported(Field::SimulationKind));
}

#[test]
fn the_watchdog_is_fed_by_ticks_alone() {
    let mut world = World::fresh();
    world.rounds();
    world.ask(Request::Hello { nonce: 1 });
    assert_eq!(world.watchdog.0, 0, "the main loop runs, but no tick");
    world.tick();
    world.rounds();
    assert_eq!(world.watchdog.0, 1);
}

#[test]
fn ticks_that_are_due_again_before_they_are_done_latch_a_fault() {
    let mut world = World::fresh();
    world.ask(Request::Hello { nonce: 1 });
    world.done(Request::Arm { faults: 0 });
    world.pending.set(true);
    let most = u32::from(Configuration::PASSIVE.limits.late_ticks);
    assert!(most > 0, "late ticks are judged");
    for _ in 0..most {
        world.tick();
    }
    let status = world.device.with(|device| device.status());
    assert_eq!(status.fault, Fault::TickOverrun.code());
}

#[test]
fn nothing_is_read_without_room_for_the_answer_and_lost_bytes_are_counted() {
    let mut world = World::fresh();
    world.ask(Request::Hello { nonce: 1 });
    let mut frame = [0; FRAME_MAX];
    let length = world.host.ask(Request::GetCapabilities, 0, &mut frame);
    world.wire.room.set(FRAME_MAX - 1);
    world.wire.to_device.extend(&frame[..length]);
    world.rounds();
    assert_eq!(world.wire.to_device.room(), 64 - length, "it waits");
    world.wire.to_device.extend(&[0; 64]);
    world.wire.room.set(FRAME_MAX);
    world.rounds();
    let answer = world.hear();
    assert!(matches!(
        answer,
        Some(Incoming::Answer(DeviceReport::Capabilities(_)))
    ));
    let Incoming::Answer(DeviceReport::Statistics(counters)) = world.ask(Request::GetStatistics)
    else {
        panic!("statistics");
    };
    assert_eq!(counters.bytes_overrun as usize, length);
}

#[test]
fn a_reset_while_armed_is_a_fault_and_one_in_idle_is_none() {
    let memory: &'static RetainedMemory = Box::leak(Box::default());
    let mut world = World::new(memory);
    world.ask(Request::Hello { nonce: 1 });
    world.done(Request::Arm { faults: 0 });
    world.tick();
    // The program begins anew; its memory stays.
    let mut again = World::new(memory);
    let status = again.device.with(|device| device.status());
    assert_eq!(
        (status.state, status.fault),
        (State::Fault, Fault::Reset.code())
    );
    again.tick();
    // Its zero is where it stood: nobody presses into a wall there before somebody has put it back.
    again.ask(Request::Hello { nonce: 2 });
    let lost = Incoming::Refused {
        request: "arm",
        refusal: Refusal::FaultPersists(Fault::Reset.code()),
    };
    assert_eq!(again.ask(Request::Arm { faults: 1 }), lost);
    again.tick();
    // Nor does another reset forget it, which a watchdog may bring.
    let mut third = World::new(memory);
    third.tick();
    third.ask(Request::Hello { nonce: 3 });
    assert_eq!(third.ask(Request::Arm { faults: 1 }), lost);
    // After power-up the memory is anything else.
    let mut restarted = World::new(Box::leak(Box::default()));
    restarted.ask(Request::Hello { nonce: 3 });
    restarted.done(Request::Arm { faults: 0 });
}
