//! The device's half of the conversation: what runs in its main loop.

mod staging;

use crate::{
    connections::{Arrived, Connections},
    hardware::{Exclusive, Hardware},
    prepared::COEFFICIENTS_MAX,
    records::Records,
    tick_side::TickSide,
};
use core::borrow::BorrowMut;
#[cfg(feature = "controllers")]
use haptic_link::ControllerLaw;
use haptic_link::{
    Ack, Alive, COEFFICIENTS_PER_BLOCK, Capabilities, CoefficientBlock, Configuration,
    DeviceReport, Direction, Field, Header, Hello, Keys, Outcome, Receiver, Refusal, Request,
    State, Statistics, encode,
};
#[cfg(feature = "several-axes")]
use haptic_link::{SurfaceShape, WorkspaceBox};

/// A [`TickSide`] of D axes that is lent to one user at a time.
pub trait Side<const D: usize>:
    Exclusive<Value = TickSide<<Self as Side<D>>::Board, D, <Self as Side<D>>::Kept>>
{
    /// The board that ticks.
    type Board: Hardware<D>;
    /// Its records, or where they are.
    type Kept: BorrowMut<Records<D>>;
}

impl<E, H, const D: usize, R> Side<D> for E
where
    E: Exclusive<Value = TickSide<H, D, R>>,
    H: Hardware<D>,
    R: BorrowMut<Records<D>>,
{
    type Board = H;
    type Kept = R;
}

/// Takes bytes from the host, acts on them, and makes the bytes to send.
///
/// - *Damaged, repeated and late frames, and frames of other connections,* are counted and not
///   acted on.
/// - *Order*: the answer to a request comes at once, samples and notices when the line has room.
/// - *Memory*: about 1.6 KiB, of which 1 KiB staged coefficients. While a configuration for a run is in force, what was
///   set to last is kept there.
#[derive(Debug)]
pub struct DeviceSession {
    receiver: Receiver<Request>,
    connections: Connections,
    sequence: u16,
    sent: u32,
    /// Frames of the host that armed.
    fed: u32,
    firmware: [u8; 3],
    boot: u32,
    image_digest: u32,
    staged: Option<Configuration>,
    /// A box for the run, staged beside it.
    #[cfg(feature = "several-axes")]
    workspace: Option<WorkspaceBox>,
    /// A surface in front of its law, staged beside it.
    #[cfg(feature = "several-axes")]
    surface: Option<SurfaceShape>,
    /// A controller in place of its law, staged beside it.
    #[cfg(feature = "controllers")]
    controller: Option<ControllerLaw>,
    values: [f32; COEFFICIENTS_MAX],
    /// Bit i: block i is staged.
    blocks: u16,
    /// Connection that has replaced the set configuration for a run; 0 for none. If not 0, `staged` is the set one.
    run_of: u32,
    bytes_overrun: u32,
}

const _: () = assert!(
    COEFFICIENTS_MAX.div_ceil(COEFFICIENTS_PER_BLOCK) <= 16,
    "one bit a block"
);

impl DeviceSession {
    /// The device's half, run by this process, with this program's version and its own number.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn within_this_process() -> Self {
        use std::hash::{BuildHasher as _, Hasher as _};
        let part = |text: &str| text.parse().unwrap_or(0);
        let version = [
            part(env!("CARGO_PKG_VERSION_MAJOR")),
            part(env!("CARGO_PKG_VERSION_MINOR")),
            part(env!("CARGO_PKG_VERSION_PATCH")),
        ];
        let random = std::collections::hash_map::RandomState::new();
        Self::new(version, random.build_hasher().finish() as u32)
    }

    /// A session at power-up. `boot` is a number that changes with each power-up or reset, if the
    /// board can detect it.
    #[must_use]
    pub const fn new(firmware: [u8; 3], boot: u32) -> Self {
        Self {
            receiver: Receiver::new(Direction::FromHost),
            connections: Connections::new(boot),
            sequence: 0,
            sent: 0,
            fed: 0,
            firmware,
            boot,
            image_digest: 0,
            staged: None,
            #[cfg(feature = "several-axes")]
            workspace: None,
            #[cfg(feature = "several-axes")]
            surface: None,
            #[cfg(feature = "controllers")]
            controller: None,
            values: [0.0; COEFFICIENTS_MAX],
            blocks: 0,
            run_of: 0,
            bytes_overrun: 0,
        }
    }

    /// Tells hosts the [`image_digest`](haptic_link::image_digest) of this device.
    pub const fn set_image_digest(&mut self, digest: u32) {
        self.image_digest = digest;
    }

    /// Number of frames so far from the host that armed, the arming included, without late and repeated ones.
    #[must_use]
    pub const fn fed(&self) -> u32 {
        self.fed
    }

    /// Bytes that the hardware lost before they came here.
    pub fn bytes_lost(&mut self, count: u32) {
        self.bytes_overrun = self.bytes_overrun.wrapping_add(count);
    }

    /// Takes a byte. If it ends a request, acts on it, writes the answer's frame into `line`, of
    /// [`FRAME_MAX`](haptic_link::FRAME_MAX) bytes, and returns its length; else 0.
    pub fn receive<const D: usize>(
        &mut self,
        byte: u8,
        now_us: u64,
        device: &impl Side<D>,
        line: &mut [u8],
    ) -> usize {
        let Some((header, request)) = self.take(byte) else {
            return 0;
        };
        match self.respond(header, request, now_us, device) {
            Some(report) => self.send(&report, line),
            None => 0,
        }
    }

    /// Acts on a request and returns its answer, if it has one: [`receive`](Self::receive) where frames are decoded and
    /// encoded elsewhere, so that a thread that ticks spends no time on bytes.
    pub fn respond<const D: usize>(
        &mut self,
        header: Header,
        request: Request,
        now_us: u64,
        device: &impl Side<D>,
    ) -> Option<DeviceReport> {
        if let Request::Hello { nonce } = request {
            let told = device.with(|device| (device.status(), device.hardware().serial_number()));
            let (status, serial_number) = told;
            return Some(DeviceReport::Hello(Hello {
                nonce,
                connection: self.connections.offer(nonce, now_us),
                firmware: self.firmware,
                boot: self.boot,
                status,
                serial_number: serial_number.bytes(),
            }));
        }
        match self.connections.arrive(header) {
            Arrived::Old => None,
            Arrived::Stranger if is_force(&request) => None,
            Arrived::Stranger => Some(ack(header, request.number(), Err(Refusal::Connection))),
            Arrived::New { first } => {
                if first {
                    self.begin(device);
                }
                if self.run_of != 0 && self.run_of != header.connection {
                    // If it cannot be done yet, the next frame tries again.
                    let _ = self.put_back(device);
                }
                self.act(header, request, now_us, device)
            }
        }
    }

    /// Not generic, and so small in a firmware that is fast elsewhere, as is everything that needs no device.
    #[inline(never)]
    fn take(&mut self, byte: u8) -> Option<(Header, Request)> {
        self.receiver.push(byte)
    }

    /// A new connection has staged nothing and asked for no samples.
    fn begin<const D: usize>(&mut self, device: &impl Side<D>) {
        if self.run_of == 0 {
            self.staged = None;
        }
        // Batches of one sample are always allowed.
        let _ = device.with(|device| device.stream_idle(0, 1));
    }

    /// Writes the next unrequested frame into `line` and returns its length; 0 if no frame waits.
    #[inline(never)]
    pub fn poll<const D: usize>(&mut self, device: &impl Side<D>, line: &mut [u8]) -> usize {
        match device.with(TickSide::next_report) {
            Some(report) => self.send(&report, line),
            None => 0,
        }
    }

    fn send(&mut self, report: &DeviceReport, line: &mut [u8]) -> usize {
        // Every report fits into a frame.
        let length = encode(report, Header::from_device(self.sequence), line).unwrap_or(0);
        self.sequence = self.sequence.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        length
    }

    fn act<const D: usize>(
        &mut self,
        header: Header,
        request: Request,
        now_us: u64,
        device: &impl Side<D>,
    ) -> Option<DeviceReport> {
        let number = request.number();
        let owns = self.connections.is_owner();
        if owns && !is_force(&request) {
            self.feed(now_us, false, device);
        }
        if let Request::Force { tick, force_n } = &request {
            // A force for another number of axes is ignored.
            if owns
                && let Ok(force_n) = force_n[..].try_into()
                && device.with(|device| device.command(*tick, force_n))
            {
                self.feed(now_us, true, device);
            }
            return None;
        }
        if let Some(report) = self.answer(header, &request, now_us, device) {
            return Some(report);
        }
        let done = self.obey(request, now_us, device);
        Some(ack(header, number, done))
    }

    #[inline(never)]
    fn obey<const D: usize>(
        &mut self,
        request: Request,
        now_us: u64,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        let owns = self.connections.is_owner();
        match request {
            Request::Configure(configuration) => self.configure(configuration, device),
            Request::Coefficients(block) => self.stage(&block),
            Request::Commit { digest, scope } => {
                let done = self.commit(digest, scope, device);
                #[cfg(all(feature = "defmt", target_os = "none"))]
                tell(digest, &done);
                done
            }
            Request::Arm { faults } => self.arm(faults, now_us, device),
            Request::Disarm => {
                device.with(TickSide::disarm);
                Ok(())
            }
            Request::Start(start) => device.with(|device| {
                let state = device.status().state;
                if !owns && matches!(state, State::Armed | State::Running | State::Stopping) {
                    return Err(Refusal::Connection);
                }
                device.start(start)
            }),
            Request::Stop => device.with(TickSide::stop),
            Request::Stream { every, batch } => {
                device.with(|device| device.stream_idle(every, batch))
            }
            #[cfg(all(feature = "controllers", not(feature = "several-axes")))]
            Request::Workspace(_) => Err(Refusal::Unsupported(Field::WorkspaceLow)),
            #[cfg(feature = "several-axes")]
            Request::Workspace(workspace) => self.stage_workspace::<D>(workspace),
            #[cfg(feature = "several-axes")]
            Request::Surface(surface) => self.stage_surface::<D>(surface),
            #[cfg(all(feature = "several-axes", not(feature = "controllers")))]
            Request::GetControllerCost | Request::Controller(_) => {
                Err(Refusal::Unsupported(Field::Other))
            }
            #[cfg(feature = "controllers")]
            Request::Controller(law) => self.stage_controller(law, device),
            // Answered before, by a report or by nothing.
            #[cfg(feature = "controllers")]
            Request::GetControllerCost => Ok(()),
            Request::Hello { .. }
            | Request::GetCapabilities
            | Request::GetConfiguration
            | Request::GetCoefficients { .. }
            | Request::Force { .. }
            | Request::KeepAlive { .. }
            | Request::GetStatistics
            | Request::ReadFlight { .. }
            | Request::GetKeys => Ok(()),
        }
    }

    /// The host that armed is there.
    fn feed<const D: usize>(&mut self, now_us: u64, is_force: bool, device: &impl Side<D>) {
        self.fed = self.fed.wrapping_add(1);
        device.with(|device| device.heard(now_us, is_force));
    }

    fn arm<const D: usize>(
        &mut self,
        faults: u16,
        now_us: u64,
        device: &impl Side<D>,
    ) -> Result<(), Refusal> {
        let owns = self.connections.is_owner();
        device.with(|device| {
            if device.status().state == State::Armed && !owns {
                return Err(Refusal::Connection);
            }
            device.arm(faults)?;
            device.heard(now_us, false);
            Ok(())
        })?;
        self.connections.claim();
        // Arming counts as a sign of life; an emulated device measures from here how long the host has been silent.
        self.fed = self.fed.wrapping_add(1);
        Ok(())
    }
}

/// Logs for a developer with a probe.
#[cfg(all(feature = "defmt", target_os = "none"))]
fn tell(digest: u32, done: &Result<(), Refusal>) {
    match done {
        Ok(()) => defmt::info!("in force: configuration {=u32:08x}", digest),
        Err(refusal) => defmt::warn!("refused: {}", defmt::Debug2Format(refusal)),
    }
}

/// True of what is applied or not, and never answered.
const fn is_force(request: &Request) -> bool {
    matches!(request, Request::Force { .. })
}

/// The answer to a request of this number.
#[inline(never)]
fn ack(header: Header, request: u8, done: Result<(), Refusal>) -> DeviceReport {
    DeviceReport::Ack(Ack {
        sequence: header.sequence as u16,
        request,
        outcome: done.map_or_else(Outcome::Refused, |()| Outcome::Done),
    })
}

impl DeviceSession {
    /// The answer to a question; nothing if it is an order. On its own: an order needs the stack for other things.
    #[inline(never)]
    fn answer<const D: usize>(
        &self,
        header: Header,
        request: &Request,
        now_us: u64,
        device: &impl Side<D>,
    ) -> Option<DeviceReport> {
        let refused = |refusal| ack(header, request.number(), Err(refusal));
        Some(match *request {
            Request::GetKeys => keys(),
            Request::GetCapabilities => {
                let abilities = device.with(|device| device.hardware().capabilities());
                DeviceReport::Capabilities(Capabilities {
                    image_digest: self.image_digest,
                    ..abilities
                })
            }
            Request::GetConfiguration => device.with(|device| {
                let (configuration, digest) = device.configuration();
                DeviceReport::Configuration {
                    configuration: *configuration,
                    digest,
                }
            }),
            Request::KeepAlive { token } => device.with(|device| {
                DeviceReport::Alive(Alive {
                    token,
                    time_us: now_us,
                    status: device.status(),
                    observed_energy_j: device.observed_energy_j(),
                })
            }),
            Request::GetStatistics => {
                let ticks = device.with(|device| *device.statistics());
                DeviceReport::Statistics(self.statistics(ticks))
            }
            Request::GetCoefficients { offset } => device
                .with(|device| coefficients(device, offset))
                .map_or_else(refused, DeviceReport::Coefficients),
            Request::ReadFlight { index } => device
                .with(|device| device.flight(index))
                .unwrap_or_else(refused),
            #[cfg(feature = "controllers")]
            Request::GetControllerCost => device.with(|device| match device.controller_cost() {
                Some(cost) => DeviceReport::ControllerCost(cost),
                None => refused(Refusal::Unsupported(Field::Other)),
            }),
            // `obey` has an arm for each request.
            _ => return None,
        })
    }

    fn statistics(&self, ticks: Statistics) -> Statistics {
        let line = self.receiver.counters();
        let requests = self.connections.tracker.out_of_order();
        Statistics {
            sent: self.sent,
            received: line.received,
            corrupt: line.corrupt,
            oversize: line.oversize,
            foreign: line.foreign,
            lost: requests.lost,
            duplicate: requests.duplicate,
            late: requests.late,
            bytes_overrun: self.bytes_overrun,
            strangers: self.connections.strangers,
            ..ticks
        }
    }
}

#[inline(never)]
fn keys() -> DeviceReport {
    DeviceReport::Keys(Keys::current())
}

fn coefficients<H: Hardware<D>, const D: usize, R: BorrowMut<Records<D>>>(
    device: &TickSide<H, D, R>,
    offset: u16,
) -> Result<CoefficientBlock, Refusal> {
    let count = device.configuration().0.operator.count;
    if offset >= count || !offset.is_multiple_of(COEFFICIENTS_PER_BLOCK as u16) {
        return Err(Refusal::range(
            Field::Offset,
            f32::from(offset),
            0.0,
            f32::from(count.saturating_sub(1)),
        ));
    }
    let values = core::array::from_fn(|i| {
        device
            .coefficient(usize::from(offset) + i)
            .unwrap_or_default()
    });
    Ok(CoefficientBlock { offset, values })
}
