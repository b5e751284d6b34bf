//! A device of two axes and its host, with a line between them that may be bad, in virtual time.

use haptic_link::{
    Configuration, DigestBuilder, FRAME_MAX, Limits, LoopMode, Refusal, Report, Request, Scope,
    Simulation, Start, State, VectorSample, WorkspaceBox,
};
use haptic_loop::Fault;
use haptic_remote::{
    Conversation, DeviceSession, FaultyLine, Incoming, LineFaults, SimulatedAxes, TickSide,
};
use std::cell::RefCell;

/// T, µs.
const TICK_US: u64 = 1000;
/// Largest norm of the force, N.
pub(crate) const FORCE_N: f32 = 2.0;

/// What the host answers to a position, an element an axis.
pub(crate) type Law = Box<dyn FnMut(&VectorSample) -> Request>;

fn norm(vector: &[f32]) -> f32 {
    vector.iter().map(|axis| axis * axis).sum::<f32>().sqrt()
}

pub(crate) struct Bench {
    pub(crate) device: RefCell<TickSide<SimulatedAxes<2>, 2>>,
    pub(crate) session: DeviceSession,
    pub(crate) host: Conversation,
    to_device: FaultyLine,
    to_host: FaultyLine,
    now_us: u64,
    pub(crate) told: Vec<Report>,
    pub(crate) law: Option<Law>,
    /// Norms of the force, tick by tick.
    pub(crate) norms: Vec<f32>,
}

impl Bench {
    pub(crate) fn new(faults: LineFaults) -> Self {
        let device = TickSide::new(SimulatedAxes::new("plane")).expect("starts");
        let line = |seed| FaultyLine::new(faults, seed).expect("valid");
        Self {
            device: RefCell::new(device),
            session: DeviceSession::new([0, 1, 0], 1),
            host: Conversation::new(50_000),
            to_device: line(1),
            to_host: line(2),
            now_us: 0,
            told: Vec::new(),
            law: None,
            norms: Vec::new(),
        }
    }

    fn say(&mut self, line: &[u8]) {
        if !line.is_empty() {
            self.to_device.send(line, self.now_us);
        }
    }

    /// One tick of device and host; the answer to what was asked.
    pub(crate) fn step(&mut self) -> Option<Incoming> {
        self.now_us += TICK_US;
        let mut line = [0; FRAME_MAX];
        while let Some(frame) = self.to_device.receive(self.now_us) {
            for byte in frame {
                let length = self
                    .session
                    .receive(byte, self.now_us, &self.device, &mut line);
                if length > 0 {
                    self.to_host.send(&line[..length], self.now_us);
                }
            }
        }
        self.device.borrow_mut().tick(self.now_us);
        self.norms
            .push(norm(&self.device.borrow().newest().force_n));
        loop {
            let length = self.session.poll(&self.device, &mut line);
            if length == 0 {
                break;
            }
            self.to_host.send(&line[..length], self.now_us);
        }
        let mut answer = None;
        while let Some(frame) = self.to_host.receive(self.now_us) {
            for byte in frame {
                match self.host.receive(byte, self.now_us) {
                    Some(Incoming::Told(report)) => {
                        if let (Report::VectorSample(sample), Some(law)) = (&report, &mut self.law)
                        {
                            let request = law(sample);
                            let length = self.host.tell(&request, &mut line);
                            self.to_device.send(&line[..length], self.now_us);
                        }
                        self.told.push(report);
                    }
                    Some(Incoming::Alive { .. }) | None => {}
                    other => answer = other,
                }
            }
        }
        let length = self.host.due(self.now_us, &mut line).expect("goes on");
        self.say(&line[..length]);
        answer
    }

    pub(crate) fn ask(&mut self, request: Request) -> Result<Report, Refusal> {
        let mut line = [0; FRAME_MAX];
        let length = self.host.ask(request, self.now_us, &mut line);
        self.say(&line[..length]);
        for _ in 0..2000 {
            match self.step() {
                Some(Incoming::Answer(report)) => return Ok(report),
                Some(Incoming::Refused { refusal, .. }) => return Err(refusal),
                other => assert!(other.is_none(), "{other:?}"),
            }
        }
        panic!("no answer");
    }

    pub(crate) fn set(
        &mut self,
        configuration: Configuration,
        workspace: Option<WorkspaceBox>,
        scope: Scope,
    ) -> Result<(), Refusal> {
        self.ask(Request::Configure(configuration))?;
        let block = haptic_link::CoefficientBlock::of(&[0.0], 0);
        self.ask(Request::Coefficients(block))?;
        let mut digest = DigestBuilder::new(&configuration).coefficients(&[0.0]);
        if let Some(workspace) = workspace {
            digest = digest.workspace(&workspace);
            self.ask(Request::Workspace(workspace))?;
        }
        let digest = digest.finish();
        self.ask(Request::Commit { digest, scope }).map(drop)
    }

    /// Connected, and configured until something else is set.
    pub(crate) fn set_to_last() -> Self {
        let mut bench = Self::new(LineFaults::default());
        bench.ask(Request::Hello { nonce: 1 }).expect("answers");
        let lasting = bench.set(configuration(), None, Scope::Lasting);
        lasting.expect("good");
        bench
    }

    /// Connected, configured, armed and started, with a hand that pushes along x.
    pub(crate) fn running(faults: LineFaults, law: Law) -> Self {
        let mut bench = Self::new(faults);
        bench.ask(Request::Hello { nonce: 1 }).expect("answers");
        bench
            .set(configuration(), None, Scope::Lasting)
            .expect("good");
        bench.host.set_keep_alive(Some(5_000));
        bench.ask(Request::Arm { faults: 0 }).expect("arms");
        bench.law = Some(law);
        bench.ask(Request::Start(START)).expect("starts");
        bench
    }

    pub(crate) fn run(&mut self, ticks: u32) {
        for _ in 0..ticks {
            self.step();
        }
    }

    pub(crate) fn state(&self) -> State {
        self.device.borrow().status().state
    }

    pub(crate) fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.device.borrow().status().fault)
    }
}

pub(crate) const START: Start = Start {
    run: 1,
    ticks: 0,
    every: 1,
    batch: 1,
};

pub(crate) fn configuration() -> Configuration {
    Configuration {
        loop_mode: LoopMode::Host,
        limits: Limits {
            watchdog_ms: 20,
            ..Limits::bare(FORCE_N, 1000.0)
        },
        simulation: Simulation {
            push_n: 1.0,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    }
}
