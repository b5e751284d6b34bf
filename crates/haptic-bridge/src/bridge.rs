//! A bridge: the part that ticks, the part that speaks, and what other threads may ask.

use crate::{
    description::{Description, DescriptionError},
    line::LineSide,
    motion::motion,
    pace::Pace,
    status::Handle,
    ticking::{Heard, Ticking, Ticks},
};
use haptic_document::FileError;
use haptic_link::{Capabilities, DeviceReport, Reason, Refusal, SerialNumber, Status, Trouble};
use haptic_loop::{
    Fault,
    realtime::{SystemWaiter, Waiter},
};
use haptic_remote::serial::{SerialError, TcpListening};
use haptic_trial::robot::OwnRobot;
use rtrb::{Consumer, Producer};
use std::{
    io::Error,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};
use thiserror::Error;

/// The part of a bridge for the thread that ticks.
#[derive(Debug)]
pub struct BridgeTicker {
    ticks: Box<dyn Ticks>,
    handle: Handle,
    ended: bool,
    pace: Pace,
    takes_motion: bool,
    /// The last output, and what it may change by in a call once the library has failed.
    output: [f64; 3],
    step: f64,
}

impl BridgeTicker {
    /// One call of the program, at this time of a monotonic clock, µs, with its position, m: the force until the next
    /// call, N. Elements beyond the axes of the device are ignored, and zero.
    ///
    /// A position that is missing or not finite, or a clock that stands still, is a fault: the force is zero at once. A panic in here
    /// ends at this border and is a fault too, for good. A device that takes a velocity has no force.
    pub fn tick(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3] {
        if self.takes_motion {
            return [0.0; 3];
        }
        self.call(time_us, position_m)
    }

    /// One call as [`tick`](Self::tick), of a device that takes a velocity: the measured position, m, and the velocity until the next call,
    /// m/s. [`sense`](Self::sense) before it is a must. After a fault or stop, and without a position or a force, the velocity comes to zero
    /// by the greatest deceleration, and stays there. A device that takes a force has no velocity.
    pub fn tick_motion(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3] {
        if self.takes_motion {
            self.call(time_us, position_m)
        } else {
            [0.0; 3]
        }
    }

    /// True if the device takes a velocity.
    #[must_use]
    pub const fn takes_motion(&self) -> bool {
        self.takes_motion
    }

    fn call(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3] {
        self.output = if self.ended {
            self.braked()
        } else {
            self.called(time_us, position_m)
        };
        self.output
    }

    /// The output one step nearer to zero, of which nothing has to be computed.
    fn braked(&self) -> [f64; 3] {
        self.output
            .map(|axis| axis - axis.clamp(-self.step, self.step))
    }

    fn called(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3] {
        // After a panic nothing of it is looked at again.
        let call = AssertUnwindSafe(|| self.ticks.call(time_us, position_m));
        catch_unwind(call).unwrap_or_else(|panic| {
            // Dropping it could panic once more.
            std::mem::forget(panic);
            self.ended = true;
            self.handle.tell(Status {
                fault: Fault::BoardFailed.code(),
                reason: Reason::of(Trouble::Library),
                ..Status::default()
            });
            self.braked()
        })
    }

    /// The force of the hand on each axis by the device's force sensor, N, positive along the position, for the next tick alone. Elements
    /// beyond the axes of the device are ignored; NaN is no reading.
    pub fn sense(&mut self, force_n: &[f64; 3]) {
        if !self.ended {
            self.ticks.sense(force_n);
        }
    }

    /// Sleeps until the next sample is due, by an absolute clock, and returns the time then, µs, for [`tick`](Self::tick). While the
    /// sample time is being measured that is 1 ms.
    pub fn wait(&mut self) -> u64 {
        self.wait_by(&mut SystemWaiter::default())
    }

    /// Waits as [`wait`](Self::wait) does, by another clock.
    pub fn wait_by(&mut self, waiter: &mut impl Waiter) -> u64 {
        let period = Duration::from_micros(self.ticks.period_us());
        self.pace.wait(waiter, period)
    }

    /// Handle for requests of other threads.
    #[must_use]
    pub fn handle(&self) -> Handle {
        self.handle.clone()
    }
}

/// A device that a host can reach over TCP. Dropping it closes the connection.
#[derive(Debug)]
pub struct Bridge {
    // Dropped first: its thread has ended before what it shares is let go.
    pub(crate) serving: Serving,
    /// Ticker, to be moved into the thread that ticks.
    pub ticker: BridgeTicker,
    /// Clones of it may be used by any thread.
    pub handle: Handle,
}

impl Bridge {
    /// Listens at an address, such as `127.0.0.1:4250`; with port 0 at one that is free.
    ///
    /// # Errors
    /// A device that cannot be; an address that cannot be listened at; no thread.
    pub fn open(description: &Description, address: &str) -> Result<Self, BridgeError> {
        let (ticker, line) = Self::apart(description)?;
        let listening = TcpListening::open(address)?;
        let mut hosts = listening.line();
        // Takes what is there: this thread has reports to look after too.
        hosts
            .set_patience(Duration::ZERO)
            .map_err(BridgeError::Thread)?;
        let pause = Duration::from_micros(ticker.ticks.period_us() / 2);
        let ended = Arc::new(AtomicBool::new(false));
        let ending = Arc::clone(&ended);
        let thread = std::thread::Builder::new().name("haptic-bridge".into());
        let thread = thread.spawn(move || line.serve(hosts, pause, &ending));
        Ok(Self {
            handle: ticker.handle(),
            ticker,
            serving: Serving {
                port: listening.address().port(),
                ended,
                thread: Some(thread.map_err(BridgeError::Thread)?),
            },
        })
    }

    /// Both ends without a line: whoever has it carries the bytes.
    ///
    /// # Errors
    /// A device that cannot be.
    pub fn apart(description: &Description) -> Result<(BridgeTicker, LineSide), BridgeError> {
        let (capabilities, number) = (description.capabilities()?, description.serial_number()?);
        let robot = description.robot()?;
        let handle = Handle::default();
        let (line, ends) = LineSide::new(handle.clone(), description.sample_time_us.into());
        let shared = handle.clone();
        let given = (description, robot.as_ref());
        let ticks = match capabilities.axes {
            1 => ticking::<1>(given, capabilities, number, ends, shared),
            2 => ticking::<2>(given, capabilities, number, ends, shared),
            _ => ticking::<3>(given, capabilities, number, ends, shared),
        }?;
        let ticker = BridgeTicker {
            ticks,
            handle,
            ended: false,
            pace: Pace::default(),
            takes_motion: robot.is_some(),
            output: [0.0; 3],
            step: robot.map_or(f64::INFINITY, |robot| {
                robot.limits.acceleration.0 * f64::from(description.sample_time_us) * 1e-6
            }),
        };
        Ok((ticker, line))
    }

    /// The port that it listens at.
    #[must_use]
    pub const fn port(&self) -> u16 {
        self.serving.port
    }
}

/// The part that ticks, with so many axes.
fn ticking<const D: usize>(
    (description, robot): (&Description, Option<&OwnRobot>),
    capabilities: Capabilities,
    number: SerialNumber,
    ends: (Consumer<Heard>, Producer<DeviceReport>),
    handle: Handle,
) -> Result<Box<dyn Ticks>, BridgeError> {
    let motion = robot.map(|robot| motion::<D>(description, robot).map(Box::new));
    let motion = motion.transpose().map_err(BridgeError::Robot)?;
    let ticking = Ticking::new(description, capabilities, number, ends, handle, motion)?;
    Ok(Box::new(ticking))
}

/// The thread of the line.
#[derive(Debug)]
pub(crate) struct Serving {
    pub port: u16,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If it panicked, that has been printed, and the line is closed.
            let _ = thread.join();
        }
    }
}

/// A bridge that cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BridgeError {
    /// The device as it was described cannot be.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// A device file that cannot be read, or describes no robot.
    #[error(transparent)]
    File(#[from] FileError),
    /// A robot whose numbers do not fit those of the description.
    #[error("{0}: change the robot's device file, or hb_device")]
    Robot(String),
    /// An address that cannot be listened at.
    #[error(transparent)]
    Address(#[from] SerialError),
    /// The loop refuses the device, although its description is good.
    #[error("the loop refuses this device: {0:?}")]
    Refused(Refusal),
    /// The system gives no thread for the line.
    #[error("the line cannot be served: {0}")]
    Thread(Error),
}

impl From<Refusal> for BridgeError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}
