//! A bridge and its host in virtual time; what would be the line carries each byte at once, unless it is cut.

use crate::allocations;
use haptic_bridge::{Bridge, BridgeTicker, Description, Handle, LineSide, Takes};
use haptic_link::{
    CoefficientBlock, Configuration, DeviceReport, DigestBuilder, FRAME_MAX, FaultReport, Limits,
    Reason, Refusal, Request, Scope, Start, Statistics,
};
use haptic_loop::Fault;
use haptic_remote::{Conversation, Incoming, operator_shape};
use nalgebra::Vector3;

pub(crate) const TICK_US: u64 = 1000;
/// Silence that the host asks for as its watchdog, ms.
pub(crate) const WATCHDOG_MS: u16 = 50;
/// Time from a fault to zero force, ticks: the stop time of 0.1 s, and rounding.
pub(crate) const STOP_TICKS: u32 = 102;

pub(crate) fn description(axes: u32) -> Description {
    Description {
        name: "bench".to_owned(),
        axes,
        sample_time_us: 1000,
        force_max_n: 3.0,
        force_rate_max_n_per_s: 1000.0,
        position_resolution_m: 1e-5,
        sensed_force_max_n: 20.0,
        workspace_low_m: [-0.1; 3],
        workspace_high_m: [0.1; 3],
        watchdog_ms: 0,
        serial_number: "bench-0042".to_owned(),
        takes: Takes::Force,
    }
}

/// A wall of full memory at 1e-6 on each axis, two-sided.
pub(crate) fn wall() -> (Configuration, Vec<f32>) {
    let scheme: fracdiff::Scheme = "full:1e-6".parse().expect("a scheme");
    let order = fracdiff::Order::new(0.5).expect("an order");
    let operator = scheme.build::<f32>(order, fracdiff::Seconds(1e-3), 200e3);
    let (operator, values) = operator_shape(&operator.expect("built")).expect("fits");
    let configuration = Configuration {
        stiffness_n_per_m: 100.0,
        dissipation_n_s_mu_per_m: 2.0,
        operator,
        limits: Limits {
            force_n: 3.0,
            watchdog_ms: WATCHDOG_MS,
            rise_time_s: 0.01,
            ..Limits::DEFAULT
        },
        ..Configuration::PASSIVE
    };
    (configuration, values)
}

/// A spring of 1000 N/m behind a surface at 1 cm, for a robot.
pub(crate) fn stiff_wall() -> (Configuration, Vec<f32>) {
    let configuration = Configuration {
        stiffness_n_per_m: 1000.0,
        one_sided: true,
        surface_m: 0.01,
        limits: Limits {
            force_n: 20.0,
            watchdog_ms: 1000,
            ..Limits::DEFAULT
        },
        ..Configuration::PASSIVE
    };
    (configuration, vec![0.0])
}

/// The requests that stage and commit it, to last.
pub(crate) fn transaction(configuration: &Configuration, values: &[f32]) -> Vec<Request> {
    let digest = DigestBuilder::new(configuration).coefficients(values);
    let blocks = (0..values.len()).step_by(16);
    let blocks =
        blocks.map(|offset| Request::Coefficients(CoefficientBlock::of(values, offset as u16)));
    let commit = Request::Commit {
        digest: digest.finish(),
        scope: Scope::Lasting,
    };
    let configure = std::iter::once(Request::Configure(*configuration));
    configure.chain(blocks).chain([commit]).collect()
}

pub(crate) struct Bench {
    pub(crate) ticker: BridgeTicker,
    pub(crate) line: LineSide,
    pub(crate) handle: Handle,
    pub(crate) host: Conversation,
    pub(crate) time_us: u64,
    /// Time by the host's own clock.
    host_us: u64,
    /// Time from call to call, µs.
    pub(crate) apart_us: u64,
    pub(crate) position_m: [f64; 3],
    /// Force at the sensor, N, before each call; `None` for a program that gives none.
    pub(crate) sensed_n: Option<[f64; 3]>,
    /// The force, or the velocity of a robot.
    pub(crate) force_n: [f64; 3],
    pub(crate) reports: Vec<DeviceReport>,
    /// The host hears and speaks.
    pub(crate) is_there: bool,
    hellos: u32,
    /// Allocations in ticks.
    pub(crate) allocations: u64,
}

impl Bench {
    pub(crate) fn new(description: &Description) -> Self {
        let (ticker, line) = Bridge::apart(description).expect("a device");
        Self {
            handle: ticker.handle(),
            ticker,
            line,
            host: Conversation::new(50_000),
            time_us: 77,
            host_us: 0,
            apart_us: TICK_US,
            position_m: [0.0; 3],
            sensed_n: None,
            force_n: [0.0; 3],
            reports: Vec::new(),
            is_there: true,
            hellos: 1,
            allocations: 0,
        }
    }

    /// Greeted, configured, armed and kept alive.
    pub(crate) fn armed(description: &Description) -> Self {
        Self::armed_for(description, WATCHDOG_MS)
    }

    /// The same with this watchdog, ms.
    pub(crate) fn armed_for(description: &Description, watchdog_ms: u16) -> Self {
        let mut bench = Self::new(description);
        let (mut configuration, values) = wall();
        configuration.tick_period_us = description.sample_time_us;
        configuration.limits.watchdog_ms = watchdog_ms;
        bench.configure(&configuration, &values);
        bench.arm();
        bench
    }

    /// Greets it and puts this in force.
    pub(crate) fn configure(&mut self, configuration: &Configuration, values: &[f32]) {
        self.done(Request::Hello { nonce: 1 });
        for request in transaction(configuration, values) {
            self.done(request);
        }
    }

    /// And pushed against a wall, with a force on each axis.
    pub(crate) fn running(description: &Description) -> Self {
        let mut bench = Self::armed(description);
        bench.start();
        bench
    }

    /// Arms on a connection of its own, whatever faults there were.
    pub(crate) fn arm(&mut self) {
        self.host.set_keep_alive(None);
        self.hellos += 1;
        let nonce = self.hellos;
        let DeviceReport::Hello(hello) = self.done(Request::Hello { nonce }) else {
            panic!("no hello");
        };
        self.host.set_keep_alive(Some(10_000));
        let faults = hello.status.faults;
        self.done(Request::Arm { faults });
    }

    pub(crate) fn start(&mut self) {
        self.position_m = [0.0; 3];
        let run = self.reports.len() as u32 + 1;
        self.done(Request::Start(Start {
            run,
            ..Start::ENDLESS
        }));
        for step in 1..=200 {
            self.position_m = [5e-5 * f64::from(step); 3];
            self.step();
        }
        assert!(self.norm_n() > 0.5, "{:?}", self.force_n);
    }

    /// The next call of the program.
    pub(crate) fn tick(&mut self) {
        self.tick_after(self.apart_us);
    }

    /// A call of the program so much later, µs.
    pub(crate) fn tick_after(&mut self, time_us: u64) {
        self.time_us += time_us;
        let before = allocations();
        if let Some(sensed_n) = &self.sensed_n {
            self.ticker.sense(sensed_n);
        }
        self.force_n = if self.ticker.takes_motion() {
            (self.ticker).tick_motion(self.time_us, Some(&self.position_m))
        } else {
            self.ticker.tick(self.time_us, Some(&self.position_m))
        };
        self.allocations += allocations() - before;
    }

    /// A tick, and what the host hears and says.
    pub(crate) fn step(&mut self) -> Option<Result<DeviceReport, Refusal>> {
        self.tick();
        self.host_us += self.apart_us;
        if !self.is_there {
            return None;
        }
        let mut answer = None;
        let mut frame = [0; FRAME_MAX];
        loop {
            let length = self.line.next(&mut frame);
            if length == 0 {
                break;
            }
            for &byte in &frame[..length] {
                match self.host.receive(byte, self.host_us) {
                    Some(Incoming::Answer(report) | Incoming::Begun(report)) => {
                        answer = Some(Ok(report));
                    }
                    Some(Incoming::Refused { refusal, .. }) => answer = Some(Err(refusal)),
                    Some(Incoming::Report(report)) => self.reports.push(report),
                    Some(Incoming::Rebooted | Incoming::Alive { .. }) | None => {}
                }
            }
        }
        let length = self
            .host
            .due(self.host_us, &mut frame)
            .expect("a good line");
        self.line.take(&frame[..length]);
        answer
    }

    pub(crate) fn answered(&mut self, request: Request) -> Result<DeviceReport, Refusal> {
        let mut frame = [0; FRAME_MAX];
        let length = self.host.ask(request, self.host_us, &mut frame);
        self.line.take(&frame[..length]);
        for _ in 0..1000 {
            if let Some(answer) = self.step() {
                return answer;
            }
        }
        panic!("no answer in a second of the device");
    }

    pub(crate) fn done(&mut self, request: Request) -> DeviceReport {
        let name = request.name();
        self.answered(request)
            .unwrap_or_else(|refusal| panic!("{name}: {refusal:?}"))
    }

    pub(crate) fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.step();
        }
    }

    pub(crate) fn statistics(&mut self) -> Statistics {
        let DeviceReport::Statistics(statistics) = self.done(Request::GetStatistics) else {
            panic!("no statistics");
        };
        statistics
    }

    /// The host heard of a fault for this reason.
    pub(crate) fn told_of(&self, fault: Fault, reason: Reason) {
        let wanted = (fault.code(), reason);
        let is_wanted = |report: &DeviceReport| matches!(report, DeviceReport::Fault(FaultReport { status, .. }) if (status.fault, status.reason) == wanted);
        assert!(self.reports.iter().any(is_wanted), "{:?}", self.reports);
    }

    pub(crate) fn norm_n(&self) -> f64 {
        Vector3::from(self.force_n).norm()
    }

    /// Ticks until this fault has latched, then until the force is zero. It never grows on the way, and stays zero.
    pub(crate) fn falls(&mut self, fault: Fault, most_ticks: u32) -> u32 {
        let mut ticks = 0;
        while self.handle.fault().is_none() {
            self.step();
            ticks += 1;
            assert!(ticks <= most_ticks, "no fault after {ticks} ticks");
        }
        assert_eq!(self.handle.fault(), Some(fault));
        self.fades();
        ticks
    }

    /// The force never grows in the stop time, and is zero after it.
    pub(crate) fn fades(&mut self) {
        self.fades_by(|bench| drop(bench.step()));
    }

    /// Asserts the same as [`fades`](Self::fades), with calls of this kind.
    pub(crate) fn fades_by(&mut self, mut call: impl FnMut(&mut Self)) {
        let mut before = self.norm_n();
        for _ in 0..STOP_TICKS {
            call(self);
            let after = self.norm_n();
            assert!(after <= before, "{after} N after {before} N");
            before = after;
        }
        assert_eq!(self.force_n, [0.0; 3]);
    }
}
