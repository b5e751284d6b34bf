//! A device that is told a script, and what must hold after each of its ticks.

use crate::script::Step;
use crate::witness::Witness;
use haptic_link::{
    CoefficientBlock, Configuration, DeviceReport, DigestBuilder, Direction, FRAME_MAX, Header,
    LoopMode, OperatorForm, OperatorShape, Receiver, Request, Scope, Simulation, Start, State,
    encode,
};
use haptic_remote::{COEFFICIENTS_MAX, DeviceSession, TickSide};
use serde::ser::{Serialize, SerializeTuple, Serializer};
use std::cell::RefCell;

/// Bytes that are a message on their own.
struct Raw<'a>(&'a [u8]);

impl Serialize for Raw<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

/// Device, line, and a mirror of what is staged.
pub struct Bench {
    device: RefCell<TickSide<Witness>>,
    session: DeviceSession,
    from_device: Receiver<DeviceReport>,
    now_us: u64,
    sequence: u32,
    /// Connection as the last hello was answered; frames of the fuzzer may make it another one.
    connection: u32,
    /// What the device has staged, seen from outside.
    staged: Configuration,
    values: [f32; COEFFICIENTS_MAX],
    force_n: f32,
    digest: u32,
}

impl Default for Bench {
    fn default() -> Self {
        let device = TickSide::new(Witness::new("fuzz")).expect("a simulated board works");
        let digest = device.configuration().1;
        let mut bench = Self {
            device: RefCell::new(device),
            session: DeviceSession::new([0, 1, 0], 1),
            from_device: Receiver::new(Direction::FromDevice),
            now_us: 0,
            sequence: 0,
            connection: 0,
            staged: Configuration::PASSIVE,
            values: [0.0; COEFFICIENTS_MAX],
            force_n: 0.0,
            digest,
        };
        bench.frame(&Request::Hello { nonce: 1 });
        bench
    }
}

impl Bench {
    /// Does one step.
    pub fn step(&mut self, step: Step<'_>) {
        match step {
            Step::Ticks { count, periods } => {
                for _ in 0..count {
                    self.tick(periods);
                }
            }
            Step::Frame(body) => self.frame(&Raw(body)),
            Step::Noise(bytes) => self.hear(bytes),
            Step::Configure { host_loop, patches } => self.configure(host_loop, patches),
            Step::Coefficients { block, values } => {
                let values: Vec<f32> = values.iter().map(|&v| f32::from(v as i8) / 8.0).collect();
                let CoefficientBlock { values, .. } = CoefficientBlock::of(&values, 0);
                let offset = 16 * u16::from(block);
                self.frame(&Request::Coefficients(CoefficientBlock { offset, values }));
            }
            Step::Commit => {
                let count = usize::from(self.staged.operator.count).min(COEFFICIENTS_MAX);
                let digest = DigestBuilder::new(&self.staged).coefficients(&self.values[..count]);
                let digest = digest.finish();
                self.frame(&Request::Commit {
                    digest,
                    scope: Scope::Lasting,
                });
            }
            Step::Arm => {
                let faults = self.device.borrow().status().faults;
                self.frame(&Request::Arm { faults });
            }
            Step::Start { ticks, batch } => self.frame(&Request::Start(Start {
                run: self.sequence,
                ticks: u32::from(ticks),
                every: 1,
                batch,
            })),
            Step::Force(eighths) => {
                let tick = self.device.borrow().newest().tick;
                let force_n = [f32::from(eighths) / 8.0].into_iter().collect();
                self.frame(&Request::Force { tick, force_n });
            }
            Step::KeepAlive => self.frame(&Request::KeepAlive { token: 1 }),
            Step::Skip(by) => self.sequence = self.sequence.wrapping_add_signed(i32::from(by)),
        }
    }

    fn configure(&mut self, host_loop: bool, patches: &[u8]) {
        let mut configuration = Configuration {
            stiffness_n_per_m: 1000.0,
            dissipation_n_s_mu_per_m: 2.0,
            order: 1.0,
            operator: OperatorShape {
                form: OperatorForm::Taps,
                integer: 0,
                count: 2,
            },
            simulation: Simulation {
                push_n: 1.0,
                ..Simulation::TESTBED
            },
            ..Configuration::PASSIVE
        };
        // A byte too many of the pairs below.
        if patches.len() % 2 == 1 {
            configuration.one_sided = true;
            configuration.depth_map = Some([200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2000.0]);
        }
        if host_loop {
            configuration.loop_mode = LoopMode::Host;
        }
        // The message as it is on the wire, without the frame around it.
        let mut line = [0; FRAME_MAX];
        let request = Request::Configure(configuration);
        let length = encode(&request, Header::from_host(0, 0), &mut line).expect("fits");
        let mut body = unframed(&line[..length - 1]);
        let last = body.len() - 1;
        for patch in patches.chunks_exact(2) {
            body[1 + usize::from(patch[0]) % last] = patch[1];
        }
        self.frame(&Raw(&body));
    }

    fn frame(&mut self, message: &impl Serialize) {
        let mut line = [0; FRAME_MAX];
        // What the fuzzer makes too long is not a frame.
        let header = Header::from_host(self.sequence, self.connection);
        let Ok(length) = encode(message, header, &mut line) else {
            return;
        };
        self.sequence = self.sequence.wrapping_add(1);
        let mut seen = Receiver::<Request>::new(Direction::FromHost);
        match line[..length].iter().find_map(|&byte| seen.push(byte)) {
            Some((_, Request::Configure(configuration))) => {
                (self.staged, self.values) = (configuration, [0.0; COEFFICIENTS_MAX]);
            }
            Some((_, Request::Coefficients(block))) => {
                let start = usize::from(block.offset);
                if let Some(slots) = self.values.get_mut(start..start + 16) {
                    slots.copy_from_slice(&block.values);
                }
            }
            _ => {}
        }
        self.hear(&line[..length]);
    }

    fn hear(&mut self, bytes: &[u8]) {
        let mut line = [0; FRAME_MAX];
        for &byte in bytes {
            let length = self
                .session
                .receive(byte, self.now_us, &self.device, &mut line);
            self.words(&line[..length]);
        }
        // Between two ticks no force changes.
        self.check(false);
    }

    fn tick(&mut self, periods: u8) {
        let period = u64::from(self.device.borrow().configuration().0.tick_period_us);
        self.now_us += period * u64::from(periods);
        self.device.borrow_mut().tick(self.now_us);
        self.check(true);
        let mut line = [0; FRAME_MAX];
        loop {
            let length = self.session.poll(&self.device, &mut line);
            if length == 0 {
                break;
            }
            self.words(&line[..length]);
        }
    }

    /// Whatever a device says is a frame with a message in it.
    fn words(&mut self, line: &[u8]) {
        if !line.is_empty() {
            let message = line.iter().find_map(|&byte| self.from_device.push(byte));
            match message {
                Some((_, DeviceReport::Hello(hello))) => self.connection = hello.connection,
                Some(_) => {}
                None => panic!("no message: {line:?}"),
            }
        }
    }

    fn check(&mut self, ticked: bool) {
        let device = self.device.borrow();
        let (configuration, digest) = device.configuration();
        let force_n = device.hardware().force_n();
        let limits = &configuration.limits;
        assert!(
            force_n.abs() <= limits.force_n,
            "{force_n} N beyond {limits:?}"
        );
        let step_n = (force_n - self.force_n).abs();
        if !ticked {
            assert!(
                step_n == 0.0,
                "the force changed by {step_n} N without a tick"
            );
        }
        let most_n = f64::from(limits.force_rate_n_per_s) * f64::from(configuration.tick_period_us);
        // A rounding of the force, and of a step too small for all its digits.
        let rounding = f64::from(f32::EPSILON) * f64::from(force_n.abs().max(self.force_n.abs()))
            + f64::from(f32::MIN_POSITIVE);
        let same = digest == self.digest;
        assert!(
            !same || f64::from(step_n) <= 1e-6 * most_n * (1.0 + 1e-6) + rounding,
            "a step of {step_n} N under {limits:?}"
        );
        let state = device.status().state;
        if matches!(state, State::Idle | State::Armed) {
            assert!(force_n == 0.0, "{force_n} N while {state}");
        }
        assert_eq!(state == State::Fault, device.status().fault != 0);
        (self.force_n, self.digest) = (force_n, digest);
    }
}

/// The message in a frame, by the definition of COBS.
fn unframed(frame: &[u8]) -> Vec<u8> {
    let (mut content, mut at) = (Vec::new(), 0);
    while let Some(&code) = frame.get(at) {
        let next = at + usize::from(code);
        content.extend_from_slice(&frame[at + 1..next.min(frame.len())]);
        if code < 255 && next < frame.len() {
            content.push(0);
        }
        at = next;
    }
    content[9..content.len() - 4].to_vec()
}
