//! A device of any number of axes and its host, with a line between them that may be bad, in virtual time.

use crate::{mirror::Mirror, witness::Witness};
use haptic_emulator::{FaultyLine, LineFaults};
use haptic_link::{
    CoefficientBlock, Configuration, DeviceReport, DigestBuilder, EventKind, FRAME_MAX, Field,
    Flight, LoopMode, OperatorForm, OperatorShape, Refusal, Request, Sample, Scope, Start, State,
};
use haptic_loop::Fault;
use haptic_remote::{Conversation, DeviceSession, Hardware, Incoming, LinkError, TickSide};
use std::cell::RefCell;

/// Steps of the clock, µs: ten a tick of 1 kHz.
pub(crate) const STEP_US: u64 = 100;

/// What the host answers to a position, an element an axis.
pub(crate) type VectorLaw = Box<dyn FnMut(&Sample) -> Request>;

/// Both ends, both directions, one clock.
pub(crate) struct Bench<H: Hardware<D> = Witness, const D: usize = 1> {
    pub(crate) device: RefCell<TickSide<H, D>>,
    pub(crate) session: DeviceSession,
    pub(crate) host: Conversation,
    pub(crate) to_device: FaultyLine,
    pub(crate) to_host: FaultyLine,
    pub(crate) now_us: u64,
    /// When the device was switched on, by the host's clock.
    pub(crate) boot_us: u64,
    /// Device ticks come only while this is set.
    pub(crate) ticking: bool,
    /// The host does not send anything while this is set.
    pub(crate) host_dead: bool,
    pub(crate) reports: Vec<DeviceReport>,
    pub(crate) rebooted: bool,
    /// What the guard has observed, as of the last answer to a keep-alive, J.
    pub(crate) energy_j: Option<f32>,
    /// Called for each sample in a host loop; its force is sent back.
    pub(crate) law: Option<fn(f32) -> f32>,
    /// The same of a device of several axes.
    pub(crate) vector_law: Option<VectorLaw>,
    /// Norms of the force, N, tick by tick.
    pub(crate) norms: Vec<f32>,
    /// When the device last got a frame that its watchdog may take for a host, by the host's clock.
    pub(crate) heard_us: u64,
    /// What the device hears, judged by the side of it.
    mirror: Mirror,
    /// Hellos said so far; each has a nonce of its own.
    hellos: u32,
    /// What goes to the device is kept here too, for who wants to play it again.
    pub(crate) capture: Option<Vec<Vec<u8>>>,
}

pub(crate) fn device() -> TickSide<Witness> {
    TickSide::new(Witness::new("bench")).expect("a simulated board works")
}

impl Bench {
    pub(crate) fn new(faults: LineFaults, seed: u64) -> Self {
        Self::with(device(), faults, seed)
    }

    /// The device loses everything and starts anew.
    pub(crate) fn reboot(&mut self) {
        self.device = RefCell::new(device());
        self.session = DeviceSession::new([0, 1, 0], 2);
        self.boot_us = self.now_us;
        self.heard_us = self.now_us;
        self.mirror = Mirror::new();
    }

    pub(crate) fn ideal() -> Self {
        Self::new(LineFaults::default(), 1)
    }

    /// Connected over a good line, and set to last.
    pub(crate) fn configured(configuration: Configuration, values: &[f32]) -> Self {
        let mut bench = Self::ideal();
        bench.hello();
        bench.set(configuration, values).expect("good");
        bench
    }

    pub(crate) fn force_n(&self) -> f32 {
        self.device.borrow().hardware().force_n()
    }
}

impl<H: Hardware<D>, const D: usize> Bench<H, D> {
    pub(crate) fn with(device: TickSide<H, D>, faults: LineFaults, seed: u64) -> Self {
        Self {
            device: RefCell::new(device),
            session: DeviceSession::new([0, 1, 0], 1),
            host: Conversation::new(50_000),
            to_device: FaultyLine::new(faults, seed).expect("valid"),
            to_host: FaultyLine::new(faults, seed.wrapping_add(1)).expect("valid"),
            now_us: 0,
            boot_us: 0,
            ticking: true,
            host_dead: false,
            reports: Vec::new(),
            rebooted: false,
            energy_j: None,
            law: None,
            vector_law: None,
            norms: Vec::new(),
            heard_us: 0,
            mirror: Mirror::new(),
            hellos: 0,
            capture: None,
        }
    }

    pub(crate) fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.device.borrow().status().fault)
    }

    pub(crate) fn state(&self) -> State {
        self.device.borrow().status().state
    }

    /// One step of the clock; what the host hears as the answer to what it asked.
    pub(crate) fn step(&mut self) -> Result<Option<Result<DeviceReport, Refusal>>, LinkError> {
        self.now_us += STEP_US;
        let period = u64::from(self.device.borrow().configuration().0.tick_period_us);
        if self.ticking && self.now_us.is_multiple_of(period) {
            let mut device = self.device.borrow_mut();
            device.tick(self.now_us - self.boot_us);
            let force_n = device.newest().force_n;
            let squares: f32 = force_n.iter().map(|axis| axis * axis).sum();
            self.norms.push(squares.sqrt());
        }
        let mut line = [0; FRAME_MAX];
        while let Some(frame) = self.to_device.receive(self.now_us) {
            if let Some(capture) = &mut self.capture {
                capture.push(frame.clone());
            }
            for byte in frame {
                let length = self.tell_device(byte, &mut line);
                if length > 0 {
                    self.to_host.send(&line[..length], self.now_us);
                }
            }
        }
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
                    Some(Incoming::Answer(report)) => answer = Some(Ok(report)),
                    Some(Incoming::Refused { refusal, .. }) => answer = Some(Err(refusal)),
                    Some(Incoming::Report(report)) => self.hear(report),
                    Some(Incoming::Begun(report)) => {
                        answer = Some(Ok(report.clone()));
                        self.hear(report);
                    }
                    Some(Incoming::Rebooted) => self.rebooted = true,
                    Some(Incoming::Alive {
                        observed_energy_j, ..
                    }) => self.energy_j = Some(observed_energy_j),
                    None => {}
                }
            }
        }
        if !self.host_dead {
            let length = self.host.due(self.now_us, &mut line)?;
            if length > 0 {
                self.to_device.send(&line[..length], self.now_us);
            }
        }
        Ok(answer)
    }

    /// A byte for the device, from whomever; the length of its answer.
    pub(crate) fn tell_device(&mut self, byte: u8, line: &mut [u8]) -> usize {
        let new = self.mirror.new_request(byte);
        let feeds = new.as_ref().is_some_and(|(header, request)| {
            header.connection == self.mirror.owner && self.feeds(request)
        });
        let device_us = self.now_us - self.boot_us;
        let length = self.session.receive(byte, device_us, &self.device, line);
        let arms = new.is_some_and(|(header, request)| {
            let armed = self.mirror.has_armed(&request, &line[..length]);
            if armed {
                self.mirror.owner = header.connection;
            }
            armed
        });
        if feeds || arms {
            self.heard_us = self.now_us;
        }
        length
    }

    /// Whether a request of the owner counts as hearing: in a running host loop only a force that is not too old.
    fn feeds(&self, request: &Request) -> bool {
        let device = self.device.borrow();
        let configuration = device.configuration().0;
        let host_loop = configuration.loop_mode == LoopMode::Host;
        if let Request::Force { tick, .. } = request {
            let age = device.newest().tick.wrapping_add(1).wrapping_sub(*tick);
            age <= u32::from(configuration.limits.max_age_ticks)
        } else {
            !(host_loop && device.status().state == State::Running)
        }
    }

    fn hear(&mut self, report: DeviceReport) {
        let answer = match (&report, self.law, &mut self.vector_law) {
            (DeviceReport::Sample(sample), Some(law), _) => Some(Request::Force {
                tick: sample.tick,
                force_n: [law(sample.axes[0].position_m)].into_iter().collect(),
            }),
            (DeviceReport::Sample(sample), _, Some(law)) => Some(law(sample)),
            _ => None,
        };
        if let Some(force) = answer.filter(|_| !self.host_dead) {
            let mut line = [0; FRAME_MAX];
            let length = self.host.tell(&force, &mut line);
            self.to_device.send(&line[..length], self.now_us);
        }
        self.reports.push(report);
    }

    /// Lets time pass.
    pub(crate) fn run_ms(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds * 1000 / STEP_US {
            self.step().expect("nothing is asked");
        }
    }

    /// Asks, and waits for the answer.
    pub(crate) fn ask(
        &mut self,
        request: Request,
    ) -> Result<Result<DeviceReport, Refusal>, LinkError> {
        let mut line = [0; FRAME_MAX];
        let length = self.host.ask(request, self.now_us, &mut line);
        self.to_device.send(&line[..length], self.now_us);
        loop {
            if let Some(answer) = self.step()? {
                return Ok(answer);
            }
        }
    }

    /// Asks over a line that works.
    pub(crate) fn answered(&mut self, request: Request) -> Result<DeviceReport, Refusal> {
        self.ask(request).expect("the line works")
    }

    /// Asks and expects the device to agree.
    pub(crate) fn done(&mut self, request: Request) -> DeviceReport {
        let name = request.name();
        self.answered(request)
            .unwrap_or_else(|refusal| panic!("{name}: {refusal:?}"))
    }

    /// Asks and expects to be refused.
    pub(crate) fn refused(&mut self, request: Request) -> Refusal {
        let name = request.name();
        match self.answered(request) {
            Ok(report) => panic!("{name} was not refused: {report:?}"),
            Err(refusal) => refusal,
        }
    }

    pub(crate) fn flight(&mut self, index: u16) -> Flight {
        let DeviceReport::Flight(flight) = self.done(Request::ReadFlight { index }) else {
            panic!("no flight");
        };
        flight
    }

    pub(crate) fn hello(&mut self) -> DeviceReport {
        let request = self.greeting();
        self.done(request)
    }

    /// A hello of its own.
    pub(crate) fn greeting(&mut self) -> Request {
        self.hellos += 1;
        Request::Hello { nonce: self.hellos }
    }

    /// Arms, whatever faults there were, and keeps alive from now on.
    pub(crate) fn arm(&mut self) {
        self.host.set_keep_alive(Some(5_000));
        let faults = self.device.borrow().status().faults;
        self.done(Request::Arm { faults });
    }

    /// Sends the whole configuration.
    pub(crate) fn configure(
        &mut self,
        configuration: Configuration,
        values: &[f32],
    ) -> Result<Result<DeviceReport, Refusal>, LinkError> {
        self.configure_for(configuration, values, Scope::Lasting)
    }

    /// Sends the whole configuration over a line that works.
    pub(crate) fn set(
        &mut self,
        configuration: Configuration,
        values: &[f32],
    ) -> Result<DeviceReport, Refusal> {
        self.configure(configuration, values)
            .expect("the line works")
    }

    /// The same for a run, or to last.
    pub(crate) fn configure_for(
        &mut self,
        configuration: Configuration,
        values: &[f32],
        scope: Scope,
    ) -> Result<Result<DeviceReport, Refusal>, LinkError> {
        for request in transaction(configuration, values) {
            if let Err(refusal) = self.ask(request)? {
                return Ok(Err(refusal));
            }
        }
        let digest = DigestBuilder::new(&configuration).coefficients(values);
        let digest = digest.finish();
        self.ask(Request::Commit { digest, scope })
    }

    /// The samples heard so far that came one by one.
    pub(crate) fn samples(&self) -> impl DoubleEndedIterator<Item = &Sample> {
        self.reports.iter().filter_map(|report| {
            if let DeviceReport::Sample(sample) = report {
                Some(sample)
            } else {
                None
            }
        })
    }

    /// The events heard so far.
    pub(crate) fn events(&self) -> Vec<EventKind> {
        let events = self.reports.iter().filter_map(|report| {
            if let DeviceReport::Event(event) = report {
                Some(event.kind)
            } else {
                None
            }
        });
        events.collect()
    }

    /// The first fault that was told, and its tick.
    pub(crate) fn told_fault(&self) -> Option<(Fault, u32)> {
        self.reports.iter().find_map(|report| {
            let DeviceReport::Fault(report) = report else {
                return None;
            };
            Some((Fault::from_code(report.status.fault)?, report.tick))
        })
    }

    /// Ticks of the samples heard so far.
    pub(crate) fn ticks(&self) -> Vec<u32> {
        let samples = self.reports.iter().flat_map(|report| {
            if let DeviceReport::Sample(sample) = report {
                vec![sample.tick]
            } else if let DeviceReport::Batch(batch) = report {
                (0..batch.items.len() as u32)
                    .map(|n| batch.tick + n * u32::from(batch.every))
                    .collect()
            } else {
                Vec::new()
            }
        });
        samples.collect()
    }
}

/// The limit beyond whose range something was refused.
pub(crate) fn beyond<T>(refused: &Result<T, Refusal>) -> Option<Field> {
    match refused {
        Err(Refusal::Range { field, .. }) => Some(*field),
        _ => None,
    }
}

/// All but the commit.
pub(crate) fn transaction(configuration: Configuration, values: &[f32]) -> Vec<Request> {
    let blocks = (0..values.len() as u16).step_by(16);
    let blocks = blocks.map(|offset| Request::Coefficients(CoefficientBlock::of(values, offset)));
    [Request::Configure(configuration)]
        .into_iter()
        .chain(blocks)
        .collect()
}

/// A spring of 1000 N/m with some damping against the pushed testbed.
pub(crate) fn spring() -> (Configuration, [f32; 2]) {
    let mut configuration = Configuration {
        stiffness_n_per_m: 1000.0,
        dissipation_n_s_mu_per_m: 2.0,
        order: 1.0,
        operator: OperatorShape {
            form: OperatorForm::Taps,
            integer: 0,
            count: 2,
        },
        simulation: haptic_link::Simulation {
            push_n: 1.0,
            ..haptic_link::Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    };
    configuration.limits.force_rate_n_per_s = 10_000.0;
    configuration.limits.watchdog_ms = LoopMode::Host.watchdog_ms();
    // What is applied is what is wanted.
    configuration.limits.rise_time_s = 0.0;
    (configuration, [1000.0, -1000.0])
}

pub(crate) const START: Start = Start {
    run: 1,
    ticks: 0,
    every: 1,
    batch: 1,
};
