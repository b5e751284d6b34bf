//! A whole conversation in virtual time: both ends on the target, bytes between them.

use super::Test;
use core::cell::RefCell;
use haptic_link::{
    CoefficientBlock, Configuration, DigestBuilder, EventKind, FRAME_MAX, Keys, Limits,
    OperatorForm, OperatorShape, Report, Request, Scope, Simulation, Start, State,
};
use haptic_loop::Fault;
use haptic_remote::{Conversation, DeviceSession, Incoming, SimulatedPlant, TickSide};

pub(crate) const TESTS: [Test; 2] = [
    ("a_run_from_hello_to_a_latched_fault_and_on", run),
    ("damaged_bytes_are_counted_and_not_acted_on", damage),
];

/// Device and host, a line without loss between them, and one clock.
struct World {
    device: RefCell<TickSide<SimulatedPlant>>,
    session: DeviceSession,
    host: Conversation,
    now_us: u64,
    samples: u32,
    largest_force: f32,
    ended: Option<EventKind>,
    fault: Option<u8>,
}

impl World {
    fn new() -> Self {
        let plant = SimulatedPlant::new("test", || 0);
        Self {
            device: RefCell::new(TickSide::new(plant).expect("a board")),
            session: DeviceSession::new([1, 2, 3], 7),
            host: Conversation::new(50_000),
            now_us: 0,
            samples: 0,
            largest_force: 0.0,
            ended: None,
            fault: None,
        }
    }

    /// The host hears bytes from the device. Returns an answer to a request, if they hold one.
    fn hear(&mut self, bytes: &[u8]) -> Option<Incoming> {
        let mut answer = None;
        for &byte in bytes {
            match self.host.receive(byte, self.now_us) {
                Some(Incoming::Told(Report::Sample(sample))) => {
                    self.samples += 1;
                    self.largest_force = self.largest_force.max(sample.axes[0].force_n.abs());
                }
                Some(Incoming::Told(Report::Event(event))) => self.ended = Some(event.kind),
                Some(Incoming::Told(Report::Fault(fault))) => self.fault = Some(fault.status.fault),
                Some(other) => answer = Some(other),
                None => {}
            }
        }
        answer
    }

    fn ask(&mut self, request: Request) -> Incoming {
        let (mut out, mut back) = ([0; FRAME_MAX], [0; FRAME_MAX]);
        let sent = self.host.ask(request, self.now_us, &mut out);
        let mut answer = None;
        for &byte in &out[..sent] {
            let length = self
                .session
                .receive(byte, self.now_us, &self.device, &mut back);
            answer = self.hear(&back[..length]).or(answer);
        }
        answer.expect("an answer at once")
    }

    fn greet(&mut self) {
        match self.ask(Request::Hello { nonce: 5 }) {
            Incoming::Answer(Report::Hello(hello)) => {
                assert_eq!((hello.firmware, hello.boot), ([1, 2, 3], 7));
            }
            other => panic!("{other:?}"),
        }
    }

    fn done(&mut self, request: Request) {
        let name = request.name();
        match self.ask(request) {
            Incoming::Answer(Report::Ack(_)) => {}
            other => panic!("{name}: {other:?}"),
        }
    }

    /// Ticks, with the host silent or not.
    fn ticks(&mut self, count: u32, silent: bool) {
        for _ in 0..count {
            self.now_us += 1000;
            if !silent {
                let alive = self.ask(Request::KeepAlive { token: 0 });
                assert!(matches!(alive, Incoming::Alive { .. }), "{alive:?}");
            }
            self.device.borrow_mut().tick(self.now_us);
            let mut line = [0; FRAME_MAX];
            loop {
                let length = self.session.poll(&self.device, &mut line);
                if length == 0 {
                    break;
                }
                self.hear(&line[..length]);
            }
        }
    }

    fn state(&self) -> State {
        self.device.borrow().status().state
    }
}

/// A spring of 100 N/m and the testbed with a hand that pushes by 1 N.
fn configuration() -> Configuration {
    Configuration {
        stiffness_n_per_m: 100.0,
        dissipation_n_s_mu_per_m: 2.0,
        operator: OperatorShape {
            form: OperatorForm::Taps,
            integer: 0,
            count: 2,
        },
        limits: Limits {
            force_rate_n_per_s: 100.0,
            watchdog_ms: 20,
            rise_time_s: 0.0,
            ..Limits::DEFAULT
        },
        simulation: Simulation {
            push_n: 1.0,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    }
}

/// A first difference at 1 kHz.
const VALUES: [f32; 2] = [1000.0, -1000.0];

fn configure(world: &mut World) {
    let configuration = configuration();
    world.done(Request::Configure(configuration));
    world.done(Request::Coefficients(CoefficientBlock::of(&VALUES, 0)));
    let digest = DigestBuilder::new(&configuration)
        .coefficients(&VALUES)
        .finish();
    let scope = Scope::Lasting;
    world.done(Request::Commit { digest, scope });
    match world.ask(Request::GetConfiguration) {
        Incoming::Answer(Report::Configuration {
            configuration: have,
            digest: is,
        }) => {
            assert_eq!((have, is), (configuration, digest));
        }
        other => panic!("{other:?}"),
    }
}

fn run() {
    let mut world = World::new();
    world.greet();
    let keys = world.ask(Request::GetKeys);
    assert_eq!(keys, Incoming::Answer(Report::Keys(Keys::current())));
    configure(&mut world);
    let start = Start::ENDLESS;
    let too_early = world.ask(Request::Start(start));
    assert!(
        matches!(too_early, Incoming::Refused { .. }),
        "{too_early:?}"
    );
    world.done(Request::Arm { faults: 0 });
    world.done(Request::Start(start));
    world.ticks(200, false);
    assert_eq!((world.state(), world.samples), (State::Running, 200));
    // The hand's 1 N on 100 N/m: 1 N at rest.
    assert!(world.largest_force > 0.9, "{}", world.largest_force);
    world.done(Request::Stop);
    world.ticks(50, false);
    assert_eq!(
        (world.state(), world.ended),
        (State::Armed, Some(EventKind::Stopped))
    );

    // Again, and the host falls silent: after 20 ms the fault latches, and the force falls in some 10 ticks.
    world.done(Request::Start(Start { run: 2, ..start }));
    world.ticks(200, false);
    world.ticks(20, true);
    assert_eq!(
        world.state(),
        State::Running,
        "20 ms are not more than 20 ms"
    );
    world.ticks(1, true);
    assert_eq!(
        (world.state(), world.fault),
        (State::Fault, Some(Fault::HostSilent.code()))
    );
    let too_early = world.ask(Request::Arm { faults: 1 });
    assert!(
        matches!(too_early, Incoming::Refused { .. }),
        "{too_early:?}"
    );
    world.ticks(50, true);
    let unknown = world.ask(Request::Arm { faults: 0 });
    assert!(matches!(unknown, Incoming::Refused { .. }), "{unknown:?}");
    world.done(Request::Arm { faults: 1 });
    world.done(Request::Start(Start { run: 3, ..start }));
    world.ticks(10, false);
    assert_eq!(world.state(), State::Running);
}

fn damage() {
    let mut world = World::new();
    let (mut out, mut back) = ([0; FRAME_MAX], [0; FRAME_MAX]);
    world.greet();
    let sent = world.host.tell(&Request::Stop, &mut out);
    out[5] ^= 1;
    let answered: usize = out[..sent]
        .iter()
        .map(|&byte| world.session.receive(byte, 0, &world.device, &mut back))
        .sum();
    assert_eq!(answered, 0);
    match world.ask(Request::GetStatistics) {
        Incoming::Answer(Report::Statistics(counters)) => {
            assert_eq!((counters.corrupt, counters.received), (1, 2));
        }
        other => panic!("{other:?}"),
    }
}
