//! The device's half of the conversation: what runs in its main loop.

use super::hardware::{Exclusive, Hardware};
use super::prepared::{COEFFICIENTS_MAX, prepare};
use super::tick_side::TickSide;
use haptic_link::{
    Ack, Alive, COEFFICIENTS_PER_BLOCK, CoefficientBlock, Configuration, DigestBuilder, Direction,
    Field, Hello, Keys, Outcome, Receiver, Refusal, Report, Request, SequenceTracker, Statistics,
    encode,
};

/// Takes bytes from the host, acts on them, and makes the bytes to send.
///
/// - *Damaged, repeated, late frames* are counted and not acted on.
/// - *Order*: the answer to a request comes at once, samples and notices when the line has room.
/// - *Memory*: about 1.6 KiB, of which 1 KiB staged coefficients.
#[derive(Debug)]
pub struct Session {
    receiver: Receiver<Request>,
    tracker: SequenceTracker,
    /// Number of the next frame.
    sequence: u16,
    sent: u32,
    firmware: [u8; 3],
    boot: u32,
    staged: Option<Configuration>,
    values: [f32; COEFFICIENTS_MAX],
    /// Bit i: block i is staged.
    blocks: u16,
    bytes_overrun: u32,
}

const _: () = assert!(
    COEFFICIENTS_MAX.div_ceil(COEFFICIENTS_PER_BLOCK) <= 16,
    "one bit a block"
);

impl Session {
    /// At power-up. `boot` is another number after each power-up or reset, as far as the board can tell.
    #[must_use]
    pub const fn new(firmware: [u8; 3], boot: u32) -> Self {
        Self {
            receiver: Receiver::new(Direction::FromHost),
            tracker: SequenceTracker::NEW,
            sequence: 0,
            sent: 0,
            firmware,
            boot,
            staged: None,
            values: [0.0; COEFFICIENTS_MAX],
            blocks: 0,
            bytes_overrun: 0,
        }
    }

    /// Bytes that the hardware lost before they came here.
    pub fn bytes_lost(&mut self, count: u32) {
        self.bytes_overrun = self.bytes_overrun.wrapping_add(count);
    }

    /// Takes a byte. If it ends a request, acts on it, writes the answer as a frame into `line`, and returns
    /// its length; 0 otherwise. `line` holds [`FRAME_MAX`](haptic_link::FRAME_MAX) bytes.
    pub fn receive<H: Hardware>(
        &mut self,
        byte: u8,
        now_us: u64,
        device: &impl Exclusive<TickSide<H>>,
        line: &mut [u8],
    ) -> usize {
        let Some((sequence, request)) = self.receiver.push(byte) else {
            return 0;
        };
        // A hello begins to count anew, even one that looks late.
        if matches!(request, Request::Hello(_)) {
            self.tracker.restart();
        }
        if !self.tracker.arrive(sequence).is_new() {
            return 0;
        }
        let is_force = matches!(request, Request::Force { .. });
        device.with(|device| device.heard(now_us, is_force));
        match self.act(sequence, request, now_us, device) {
            Some(report) => self.send(&report, line),
            None => 0,
        }
    }

    /// Writes the next frame to send of itself into `line` and returns its length; 0 if there is none.
    pub fn poll<H: Hardware>(
        &mut self,
        device: &impl Exclusive<TickSide<H>>,
        line: &mut [u8],
    ) -> usize {
        match device.with(TickSide::next_report) {
            Some(report) => self.send(&report, line),
            None => 0,
        }
    }

    fn send(&mut self, report: &Report, line: &mut [u8]) -> usize {
        // Every report fits into a frame.
        let length = encode(report, self.sequence, Direction::FromDevice, line).unwrap_or(0);
        self.sequence = self.sequence.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        length
    }

    fn act<H: Hardware>(
        &mut self,
        sequence: u16,
        request: Request,
        now_us: u64,
        device: &impl Exclusive<TickSide<H>>,
    ) -> Option<Report> {
        let number = request.number();
        let done = match request {
            Request::Force { force_n, .. } => {
                device.with(|device| device.command(force_n));
                return None;
            }
            Request::Hello(_) => {
                self.staged = None;
                // A new session has not asked for any samples.
                let status = device.with(|device| {
                    // Batches of one sample are always allowed.
                    let _ = device.stream_idle(0, 1);
                    device.status()
                });
                return Some(Report::Hello(Hello {
                    keys: Keys::CURRENT,
                    firmware: self.firmware,
                    boot: self.boot,
                    status,
                }));
            }
            Request::GetCapabilities => {
                let capabilities = device.with(|device| device.hardware().capabilities());
                return Some(Report::Capabilities(capabilities));
            }
            Request::GetConfiguration => {
                return Some(device.with(|device| {
                    let (configuration, digest) = device.configuration();
                    Report::Configuration {
                        configuration: *configuration,
                        digest,
                    }
                }));
            }
            Request::KeepAlive { token } => {
                return Some(device.with(|device| {
                    Report::Alive(Alive {
                        token,
                        time_us: now_us,
                        status: device.status(),
                        observed_energy_j: device.observed_energy_j(),
                    })
                }));
            }
            Request::GetStatistics => {
                let ticks = device.with(|device| *device.statistics());
                return Some(Report::Statistics(self.statistics(ticks)));
            }
            Request::GetCoefficients { offset } => {
                match device.with(|device| coefficients(device, offset)) {
                    Ok(block) => return Some(Report::Coefficients(block)),
                    Err(refusal) => Err(refusal),
                }
            }
            Request::ReadFlight { index } => match device.with(|device| device.flight(index)) {
                Ok(flight) => return Some(Report::Flight(flight)),
                Err(refusal) => Err(refusal),
            },
            Request::Configure(configuration) => {
                self.staged = Some(configuration);
                self.values = [0.0; COEFFICIENTS_MAX];
                self.blocks = 0;
                Ok(())
            }
            Request::Coefficients(block) => self.stage(&block),
            Request::Commit { digest } => self.commit(digest, device),
            Request::Arm { faults } => device.with(|device| device.arm(faults)),
            Request::Disarm => {
                device.with(TickSide::disarm);
                Ok(())
            }
            Request::Start(start) => device.with(|device| device.start(start)),
            Request::Stop => device.with(TickSide::stop),
            Request::Stream { every, batch } => {
                device.with(|device| device.stream_idle(every, batch))
            }
        };
        Some(Report::Ack(Ack {
            sequence,
            request: number,
            outcome: done.map_or_else(Outcome::Refused, |()| Outcome::Done),
        }))
    }

    fn stage(&mut self, block: &CoefficientBlock) -> Result<(), Refusal> {
        let start = usize::from(block.offset);
        if self.staged.is_none() {
            return Err(Refusal::Incomplete);
        }
        let slots = self.values.get_mut(start..start + COEFFICIENTS_PER_BLOCK);
        let aligned = start.is_multiple_of(COEFFICIENTS_PER_BLOCK);
        let Some(slots) = slots.filter(|_| aligned) else {
            return Err(Refusal::Range {
                field: Field::Offset,
                value: f32::from(block.offset),
                least: 0.0,
                most: (COEFFICIENTS_MAX - COEFFICIENTS_PER_BLOCK) as f32,
            });
        };
        slots.copy_from_slice(&block.values);
        self.blocks |= 1 << (start / COEFFICIENTS_PER_BLOCK);
        Ok(())
    }

    /// On its own, so that only a commit needs room for what it prepares.
    #[inline(never)]
    fn commit<H: Hardware>(
        &mut self,
        digest: u32,
        device: &impl Exclusive<TickSide<H>>,
    ) -> Result<(), Refusal> {
        let Some(configuration) = self.staged else {
            // Sent again because the answer was lost: true already.
            let in_force = device.with(|device| device.configuration().1);
            return if in_force == digest {
                Ok(())
            } else {
                Err(Refusal::Incomplete)
            };
        };
        let count = configuration.operator.count;
        let Some(values) = self.values.get(..usize::from(count)) else {
            return Err(Refusal::Range {
                field: Field::CoefficientCount,
                value: f32::from(count),
                least: 1.0,
                most: COEFFICIENTS_MAX as f32,
            });
        };
        let needed = haptic_link::block_count(count);
        if (0..needed).any(|block| self.blocks >> block & 1 == 0) {
            return Err(Refusal::Incomplete);
        }
        let own = DigestBuilder::new(&configuration).coefficients(values);
        if own.finish() != digest {
            return Err(Refusal::Digest);
        }
        device.with(|device| device.may_install())?;
        let capabilities = device.with(|device| device.hardware().capabilities());
        let prepared = prepare::<H>(configuration, values, &capabilities)?;
        device.with(|device| device.install(prepared))?;
        self.staged = None;
        Ok(())
    }

    fn statistics(&self, ticks: Statistics) -> Statistics {
        let line = self.receiver.counters();
        Statistics {
            sent: self.sent,
            received: line.received,
            corrupt: line.corrupt,
            oversize: line.oversize,
            foreign: line.foreign,
            lost: self.tracker.lost(),
            duplicate: self.tracker.duplicate(),
            late: self.tracker.late(),
            bytes_overrun: self.bytes_overrun,
            ..ticks
        }
    }
}

/// The block of coefficients in force at an offset.
fn coefficients<H: Hardware>(
    device: &TickSide<H>,
    offset: u16,
) -> Result<CoefficientBlock, Refusal> {
    let count = device.configuration().0.operator.count;
    if offset >= count || !offset.is_multiple_of(COEFFICIENTS_PER_BLOCK as u16) {
        return Err(Refusal::Range {
            field: Field::Offset,
            value: f32::from(offset),
            least: 0.0,
            most: f32::from(count.saturating_sub(1)),
        });
    }
    let values = core::array::from_fn(|i| {
        device
            .coefficient(usize::from(offset) + i)
            .unwrap_or_default()
    });
    Ok(CoefficientBlock { offset, values })
}
