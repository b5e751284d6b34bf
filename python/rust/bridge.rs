//! A driver in Python is a device: the crate `haptic-bridge`, called by the haptic thread of Python.

use crate::refused::{OrRefused as _, refused};
use haptic_bridge::{Bridge, BridgeTicker, Description, Handle, Takes};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Makes this program's device one of `host-cli`, over TCP: loop, limits and watchdog run inside `tick`.
///
/// Parameters
/// ----------
/// name : str
///     Name in ``device info`` and in logs, 1 to 16 bytes.
/// force_max_n, force_rate_max_n_per_s : float
///     Largest force in N and its largest rate in N/s; no host can ask for more.
/// listen : str, default "127.0.0.1:4250"
///     Address and port; with port 0 one that is free, see `port`. It has no password.
/// axes : int, default 1
///     1, or 2 or 3 for a touch.
/// sample_time_us : int, default 1000
///     Time between two ticks, 100 to 10000 µs; 0 takes the mean of the first second, which has no force.
/// position_resolution_m : float, default 0
///     One count of the sensor in m; 0 if it is not known.
/// sensed_force_max_n : float, default 0
///     Range of the force sensor in N; 0 without one. See `sense`.
/// serial_number : str, default ""
///     Its limits are kept under it; empty if it is not known.
/// workspace_low_m, workspace_high_m : sequence of 3 floats, default zeros
///     Ends in m, outside of which there is no force; 0 and 0 for none.
/// watchdog_ms : int, default 0
///     Longest silence of a host while it is armed, 5 to 1000 ms; 0 leaves it to the host.
/// robot : path-like, optional
///     Device file with ``[admittance]`` of a robot that takes a velocity, by `tick_motion`, with ``sensed_force_max_n`` and `sense`.
///
/// Raises
/// ------
/// ValueError
///     A device that cannot be, with the range; an address that cannot be listened at.
///
/// Notes
/// -----
/// One thread ticks, at the sample time; the others may `stop` it. When it ends or the program dies, the driver may still hold the
/// last force or velocity: set it to zero in a ``finally``.
///
/// Examples
/// --------
/// >>> from fractional_haptics.bridge import Bridge
/// >>> limits = {"force_max_n": 3.0, "force_rate_max_n_per_s": 1000.0}
/// >>> with Bridge(name="mine", listen="127.0.0.1:0", **limits) as bridge:
/// ...     bridge.sense([0.1, 0.0, 0.0])
/// ...     bridge.tick(bridge.wait(), [0.0, 0.0, 0.0])
/// ...     bridge.tick(bridge.wait(), None)
/// ...     bridge.fault, bridge.reason
/// (0.0, 0.0, 0.0)
/// (0.0, 0.0, 0.0)
/// (12, '...')
/// >>> bridge.wait()
/// Traceback (most recent call last):
/// ValueError: the bridge is closed: open another
/// >>> Bridge(name="mine", axes=4, **limits)
/// Traceback (most recent call last):
/// ValueError: axes 4 is not 1, 2 or 3: give another
/// >>> Bridge(name="mine", listen="nowhere", **limits)
/// Traceback (most recent call last):
/// ValueError: ...nowhere...
#[pyclass(frozen, name = "Bridge", module = "fractional_haptics.bridge")]
#[derive(Debug)]
pub(crate) struct PyBridge {
    /// `None` once it is closed.
    bridge: Mutex<Option<Bridge>>,
    handle: Handle,
    /// The port that it listens at.
    #[pyo3(get)]
    port: u16,
}

impl PyBridge {
    fn bridge(&self) -> MutexGuard<'_, Option<Bridge>> {
        self.bridge.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn ticking<T>(&self, call: impl FnOnce(&mut BridgeTicker) -> T) -> PyResult<T> {
        let mut bridge = self.bridge();
        let open = bridge.as_mut().map(|bridge| call(&mut bridge.ticker));
        open.ok_or_else(|| refused("the bridge is closed: open another"))
    }
}

impl PyBridge {
    /// A tick that gives a velocity, or a force: what the device takes.
    fn ticking_as(
        &self,
        moves: bool,
        call: impl FnOnce(&mut BridgeTicker) -> [f64; 3],
    ) -> PyResult<(f64, f64, f64)> {
        let output =
            self.ticking(|ticker| (ticker.takes_motion() == moves).then(|| call(ticker)))?;
        let output = output.ok_or_else(|| {
            refused(if moves {
                "this device takes a force: call tick, or give robot"
            } else {
                "this device takes a velocity: call tick_motion, or omit robot"
            })
        })?;
        Ok(output.into())
    }
}

#[pymethods]
impl PyBridge {
    #[new]
    #[pyo3(signature = (*, name, force_max_n, force_rate_max_n_per_s, listen = "127.0.0.1:4250", axes = 1, sample_time_us = 1000,
        position_resolution_m = 0.0, sensed_force_max_n = 0.0, workspace_low_m = [0.0; 3], workspace_high_m = [0.0; 3], watchdog_ms = 0, serial_number = "",
        robot = None))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn new(
        name: String,
        force_max_n: f64,
        force_rate_max_n_per_s: f64,
        listen: &str,
        axes: u32,
        sample_time_us: u32,
        position_resolution_m: f64,
        sensed_force_max_n: f64,
        workspace_low_m: [f64; 3],
        workspace_high_m: [f64; 3],
        watchdog_ms: u32,
        serial_number: &str,
        robot: Option<PathBuf>,
    ) -> PyResult<Self> {
        let description = Description {
            name,
            axes,
            sample_time_us,
            force_max_n,
            force_rate_max_n_per_s,
            position_resolution_m,
            sensed_force_max_n,
            workspace_low_m,
            workspace_high_m,
            watchdog_ms,
            serial_number: serial_number.to_owned(),
            takes: robot.map_or(Takes::Force, |robot| Takes::Velocity { robot }),
        };
        let bridge = Bridge::open(&description, listen).or_refused()?;
        Ok(Self {
            handle: bridge.handle.clone(),
            port: bridge.port(),
            bridge: Mutex::new(Some(bridge)),
        })
    }

    /// Sleeps until the next sample is due, and returns the time then in µs. The other threads of Python run meanwhile.
    fn wait(&self, py: Python<'_>) -> PyResult<u64> {
        py.detach(|| self.ticking(BridgeTicker::wait))
    }

    /// Takes the force of the hand at the device's sensor in N, for the next `tick`.
    fn sense(&self, force_n: [f64; 3]) -> PyResult<()> {
        self.ticking(|ticker| ticker.sense(&force_n))
    }

    /// One tick: time in µs of a clock that never goes back and position in m in, the force until the next call in N out. None or NaN is a
    /// sensor that gave nothing: no force at once, and a `fault`. Elements beyond the axes are ignored, and zero.
    fn tick(&self, time_us: u64, position_m: Option<[f64; 3]>) -> PyResult<(f64, f64, f64)> {
        self.ticking_as(false, |ticker| ticker.tick(time_us, position_m.as_ref()))
    }

    /// One tick of a robot, after `sense`: time in µs and measured position in m in, the velocity until the next call in m/s out. After a
    /// fault or stop, and without a position or a force, it is the way to rest, and then zero: call on until the robot stands.
    fn tick_motion(&self, time_us: u64, position_m: Option<[f64; 3]>) -> PyResult<(f64, f64, f64)> {
        self.ticking_as(true, |ticker| {
            ticker.tick_motion(time_us, position_m.as_ref())
        })
    }

    /// Lets the force fall to zero from the next tick on, and disarms the device.
    fn stop(&self) {
        self.handle.stop();
    }

    /// Code of the latched fault, as in logs; None without one.
    #[getter]
    fn fault(&self) -> Option<u8> {
        self.handle.fault().map(haptic_loop::Fault::code)
    }

    /// Reason of the latched fault, one line; None without one.
    #[getter]
    fn reason(&self) -> Option<String> {
        let reason = self.handle.reason().map(|reason| reason.to_string());
        reason.or_else(|| Some(self.handle.fault()?.to_string()))
    }

    /// Ends the connection.
    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(self.bridge().take()));
    }

    /// The bridge itself.
    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    /// Closes it.
    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) {
        self.close(py);
    }
}
