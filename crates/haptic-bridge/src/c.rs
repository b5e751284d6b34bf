//! The functions that C calls. The only `unsafe` of the library is here: it reads and writes through pointers that the
//! caller answers for, as the documentation of each function, which the header repeats, says.
#![expect(unsafe_code, reason = "C hands over pointers")]

use crate::{
    bridge::{Bridge, BridgeError, BridgeTicker},
    description::{Description, Takes},
    status::Handle,
};
use haptic_link::Trouble;
use std::{
    ffi::{CStr, CString, c_char, c_int},
    panic::catch_unwind,
    ptr,
    sync::{Mutex, PoisonError},
};
use thiserror::Error;

/// Default address of a bridge: this machine alone.
const ADDRESS: &str = "127.0.0.1:4250";

/// A pointer that is needed was null.
pub const HB_NULL: c_int = -1;
/// The library failed inside and has let go for good: close the bridge.
pub const HB_ENDED: c_int = -2;

/// The call is that of another kind of device: `hb_tick` gives a force, `hb_tick_motion` a velocity.
pub const HB_OTHER: c_int = -3;

/// A device that takes a force, N, from `hb_tick`.
pub const HB_FORCE: u32 = 0;
/// A device that takes a velocity, m/s, from `hb_tick_motion`: a robot with a force sensor under its handle.
pub const HB_VELOCITY: u32 = 1;

/// Abilities and limits of the device. No host can loosen these limits; it sets its own within them.
/// Set everything to zero first (`hb_device device = {0};`, in C++ `hb_device device{};`), then `size`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct HbDevice {
    /// `sizeof(hb_device)`, by which a library of another version is noticed.
    pub size: usize,
    /// Name in `device info` and in logs, UTF-8, 1 to 16 bytes.
    pub name: *const c_char,
    /// Number of axes, 1 to 3.
    pub axes: u32,
    /// Time from one tick to the next, microseconds, 100 to 10000; 0 takes the mean of the first second, in which there is no force.
    /// Calls of `hb_tick` in between hold the last force.
    pub sample_time_us: u32,
    /// Largest force on an axis, and of several axes the largest magnitude, N, above 0.
    pub force_max_n: f64,
    /// Largest rate of the force, N/s, above 0.
    pub force_rate_max_n_per_s: f64,
    /// Distance of one count of the sensor, m; 0 if it is not known.
    pub position_resolution_m: f64,
    /// Low ends of the workspace, m: outside of it there is no force. Two ends of 0 mean no workspace limit.
    pub workspace_low_m: [f64; 3],
    /// High ends of the workspace, m.
    pub workspace_high_m: [f64; 3],
    /// Longest silence of a host while the device is armed, ms, 5 to 1000; 0 leaves it to the host, which says 1000 at most.
    pub watchdog_ms: u32,
    /// Largest force that the force sensor shows either way, N; 0 without one. See `hb_sense`.
    pub sensed_force_max_n: f64,
    /// Serial number of the device, 6 to 32 letters, digits and any of "-_.:+", under which a host keeps its limits; NULL if it is not
    /// known.
    pub serial_number: *const c_char,
    /// The command that the device takes: `HB_FORCE` (0) or `HB_VELOCITY`. With the latter `sample_time_us` and `sensed_force_max_n` are
    /// declared too; the force limits are of the law that is rendered, and the workspace is that of the command.
    pub takes: u32,
    /// Path of the robot's device file, with `[admittance]`: its virtual body, its own loop, the limits of its motion, the hands that push it.
    /// NULL for a device that takes a force.
    pub robot: *const c_char,
}

/// A bridge. One thread ticks; `hb_stop`, `hb_fault`, `hb_reason` and `hb_port` may be called from others meanwhile.
#[derive(Debug)]
pub struct HbBridge {
    bridge: Bridge,
    /// Texts that `hb_reason` has given away.
    reasons: Mutex<Vec<CString>>,
}

/// Opens a bridge: from now on a host can connect, as with `host-cli device info --device tcp:127.0.0.1:4250`.
///
/// `listen` is an address of this machine with a port, such as "127.0.0.1:4250", which NULL means; with port 0 one that is
/// free is taken, see `hb_port`. The connection has no password and no encryption: another address than the loopback is for
/// a network in which everybody may push whoever holds the device.
///
/// Returns NULL if it cannot be opened; then `error`, of `room` bytes, says why. It may be NULL.
///
/// # Safety
/// Pointers are null or valid; texts end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_open(
    what: *const HbDevice,
    listen: *const c_char,
    error: *mut c_char,
    room: usize,
) -> *mut HbBridge {
    // SAFETY: valid or null, as the caller promises.
    let opened = catch_unwind(|| unsafe { open(what, listen) });
    let reason = match opened {
        Ok(Ok(bridge)) => return Box::into_raw(Box::new(bridge)),
        Ok(Err(reason)) => reason.to_string(),
        Err(_) => "the library failed: report this as a defect".to_owned(),
    };
    if !error.is_null() && room > 0 {
        // Cut where a character ends.
        let mut length = reason.len().min(room - 1);
        while !reason.is_char_boundary(length) {
            length -= 1;
        }
        // SAFETY: `error` has `room` bytes, of which length + 1 are written; a text of ours overlaps none of the caller's.
        unsafe {
            ptr::copy_nonoverlapping(reason.as_ptr().cast(), error, length);
            error.add(length).write(0);
        }
    }
    ptr::null_mut()
}

/// Arguments that `hb_open` refuses.
#[derive(Debug, Error)]
enum OpenError {
    #[error("the device is NULL: describe it by an hb_device")]
    Null,
    #[error(
        "size = {0} is not {ours}, the size of hb_device in this library: set it to sizeof(hb_device), with the header of this version",
        ours = size_of::<HbDevice>()
    )]
    Size(usize),
    #[error("{0:?} is not UTF-8: give a name and an address in UTF-8")]
    Text(CString),
    #[error("takes = {0}: give HB_FORCE (0), or HB_VELOCITY (1)")]
    Takes(u32),
    #[error(
        "robot = NULL, but takes = HB_VELOCITY: give the path of a device file with [admittance]"
    )]
    NoRobot,
    #[error("robot = \"{0}\" has no effect with takes = HB_FORCE: give NULL, or HB_VELOCITY")]
    Robot(String),
    #[error(transparent)]
    Bridge(#[from] BridgeError),
}

/// # Safety
/// As [`hb_open`].
unsafe fn open(what: *const HbDevice, listen: *const c_char) -> Result<HbBridge, OpenError> {
    if what.is_null() {
        return Err(OpenError::Null);
    }
    // SAFETY: every version of the struct begins with its size.
    let size = unsafe { (&raw const (*what).size).read() };
    if size != size_of::<HbDevice>() {
        return Err(OpenError::Size(size));
    }
    // SAFETY: it is of our size, so all of it is there.
    let what = unsafe { what.read() };
    // SAFETY: texts of the caller.
    let [name, listen, serial_number, robot] = unsafe {
        [
            text(what.name)?,
            text(listen)?,
            text(what.serial_number)?,
            text(what.robot)?,
        ]
    };
    let takes = match (what.takes, robot) {
        (HB_FORCE, None) => Takes::Force,
        (HB_FORCE, Some(robot)) => return Err(OpenError::Robot(robot.to_owned())),
        (HB_VELOCITY, Some(robot)) => Takes::Velocity {
            robot: robot.into(),
        },
        (HB_VELOCITY, None) => return Err(OpenError::NoRobot),
        (other, _) => return Err(OpenError::Takes(other)),
    };
    let description = Description {
        name: name.unwrap_or_default().to_owned(),
        axes: what.axes,
        sample_time_us: what.sample_time_us,
        force_max_n: what.force_max_n,
        force_rate_max_n_per_s: what.force_rate_max_n_per_s,
        position_resolution_m: what.position_resolution_m,
        sensed_force_max_n: what.sensed_force_max_n,
        workspace_low_m: what.workspace_low_m,
        workspace_high_m: what.workspace_high_m,
        watchdog_ms: what.watchdog_ms,
        serial_number: serial_number.unwrap_or_default().to_owned(),
        takes,
    };
    let bridge = Bridge::open(&description, listen.unwrap_or(ADDRESS))?;
    Ok(HbBridge {
        bridge,
        reasons: Mutex::default(),
    })
}

/// A text of the caller; `None` for a null pointer.
///
/// # Safety
/// It is null, or valid until a zero byte, as long as `'a`.
unsafe fn text<'a>(text: *const c_char) -> Result<Option<&'a str>, OpenError> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: as the caller promises.
    let text = unsafe { CStr::from_ptr(text) };
    let read = text.to_str().map(Some);
    read.map_err(|_| OpenError::Text(text.to_owned()))
}

/// One tick of the haptic thread: takes the position, m, gives the force until the next call, N, behind the safety chain.
/// Elements beyond the device's axes are ignored, and zero. Both may be the same array. Never waits, allocates or locks.
///
/// `time_us` is from a clock that only goes on, microseconds, as `hb_wait` returns it or as `std::chrono::steady_clock` has it; the
/// watchdog counts by it. One that is plainly in milliseconds or seconds is fault 12. Call it once a sample time or more often: a
/// thread that is slower than was declared, by more than 5 % over 0.2 s or 2 % over 2 s, is fault 3. When the calls cease, the host
/// hears nothing more and ends its run; the force is then the program's to take away.
///
/// Returns 0, or the code of the latched fault, as in `hb_fault`: the force falls to zero, and is zero at once where no
/// position can be used. `HB_NULL`: no bridge. `HB_ENDED`: close it.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed; the arrays are null or of three numbers; one thread at a time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_tick(
    bridge: *mut HbBridge,
    time_us: u64,
    position_m: *const f64,
    force_n: *mut f64,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe {
        called(
            bridge,
            false,
            BridgeTicker::tick,
            time_us,
            position_m,
            force_n,
        )
    }
}

/// One tick of a robot, which takes a velocity: the position that was measured, m, gives the velocity until the next call, m/s, behind
/// the chain of motion. Between the force of the hand, by `hb_sense`, and that of the law stands the virtual body of the device file.
/// All else is as with `hb_tick`.
///
/// `hb_sense` before each call is a must. Without it, with NaN, after a fault, `hb_stop` or a silent host the velocity comes to zero by
/// the greatest deceleration of the device file, and stays there: go on calling until it has. The robot has to stop by itself when the
/// calls cease.
///
/// Returns as `hb_tick` does. `HB_OTHER`, with zero: the device takes a force, as `hb_tick` on a device that takes a velocity.
///
/// # Safety
/// As `hb_tick`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_tick_motion(
    bridge: *mut HbBridge,
    time_us: u64,
    position_m: *const f64,
    velocity_m_per_s: *mut f64,
) -> c_int {
    let call = BridgeTicker::tick_motion;
    // SAFETY: as the caller promises.
    unsafe { called(bridge, true, call, time_us, position_m, velocity_m_per_s) }
}

/// A tick of either kind.
///
/// # Safety
/// As [`hb_tick`].
unsafe fn called(
    bridge: *mut HbBridge,
    is_motion: bool,
    call: impl FnOnce(&mut BridgeTicker, u64, Option<&[f64; 3]>) -> [f64; 3],
    time_us: u64,
    position_m: *const f64,
    output: *mut f64,
) -> c_int {
    let output = output.cast::<[f64; 3]>();
    let position_m = position_m.cast::<[f64; 3]>();
    // Before a force is written, which may go to the same array. Without room for a force there is nothing to compute one for.
    let position = if position_m.is_null() || output.is_null() {
        None
    } else {
        // SAFETY: three numbers; unaligned ones do no harm.
        Some(unsafe { position_m.read_unaligned() })
    };
    if !output.is_null() {
        // SAFETY: as above.
        unsafe { output.write_unaligned([0.0; 3]) };
    }
    if bridge.is_null() {
        return HB_NULL;
    }
    // SAFETY: only this thread touches the ticker, and other fields are borrowed apart from it.
    let ticker = unsafe { &mut (*bridge).bridge.ticker };
    if ticker.takes_motion() != is_motion {
        return HB_OTHER;
    }
    let commanded = call(ticker, time_us, position.as_ref());
    if !output.is_null() {
        // SAFETY: as above.
        unsafe { output.write_unaligned(commanded) };
    }
    // SAFETY: shared by all threads, and only read.
    code(unsafe { &(*bridge).bridge.handle })
}

/// Takes the force of the hand by a force sensor, N, positive along the position, for the next `hb_tick`, which sends it to the host.
/// Call it before each `hb_tick`, in the same thread; NaN is a sensor that gave nothing. Elements beyond the device's axes are ignored.
/// State the range of the sensor in `sensed_force_max_n`. A robot that takes a velocity does not move without it. Never waits, allocates or locks.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed; the array is null or of three numbers; one thread at a time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_sense(bridge: *mut HbBridge, force_n: *const f64) {
    if bridge.is_null() || force_n.is_null() {
        return;
    }
    // SAFETY: three numbers; unaligned ones do no harm.
    let force_n = unsafe { force_n.cast::<[f64; 3]>().read_unaligned() };
    // SAFETY: only this thread touches the ticker, and other fields are borrowed apart from it.
    unsafe { &mut (*bridge).bridge.ticker }.sense(&force_n);
}

/// Sleeps until the next sample is due, by an absolute clock, so that a loop runs at the sample time that it declared; returns the
/// time then, microseconds, for `hb_tick`. A loop that is late goes on at once, and periods that have passed are not made up for.
/// For the haptic thread alone; a thread that a driver calls at its own rate has no need of it. 0 without a bridge.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed; one thread at a time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_wait(bridge: *mut HbBridge) -> u64 {
    if bridge.is_null() {
        return 0;
    }
    // SAFETY: only this thread touches the ticker, and other fields are borrowed apart from it.
    let ticker = unsafe { &mut (*bridge).bridge.ticker };
    ticker.wait()
}

fn code(handle: &Handle) -> c_int {
    let reason = handle.reason();
    if reason.is_some_and(|reason| reason.trouble == Trouble::Library) {
        return HB_ENDED;
    }
    handle.fault().map_or(0, |fault| fault.code().into())
}

/// Lets the force fall to zero within the stop time from the next tick on, or a robot come to rest, and disarms the device: the host has
/// to arm it again. From any thread; NULL is nothing.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_stop(bridge: *mut HbBridge) {
    if !bridge.is_null() {
        // SAFETY: shared by all threads, and only read.
        unsafe { &(*bridge).bridge.handle }.stop();
    }
}

/// The code of the latched fault, as in logs; 0 without one, `HB_NULL` without a bridge, `HB_ENDED` if it has to be closed.
/// From any thread.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_fault(bridge: *const HbBridge) -> c_int {
    if bridge.is_null() {
        return HB_NULL;
    }
    // SAFETY: shared by all threads, and only read.
    code(unsafe { &(*bridge).bridge.handle })
}

/// The reason of the latched fault, one line of English; "" without one. It is valid until `hb_close`. From any thread.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_reason(bridge: *const HbBridge) -> *const c_char {
    if bridge.is_null() {
        return c"the bridge is NULL: open it first".as_ptr();
    }
    // SAFETY: shared by all threads, and only read.
    let (handle, reasons) = unsafe { (&(*bridge).bridge.handle, &(*bridge).reasons) };
    let reason = match (handle.reason(), handle.fault()) {
        (Some(reason), _) => reason.to_string(),
        (None, Some(fault)) => fault.to_string(),
        (None, None) => return c"".as_ptr(),
    };
    // No text of ours has a zero in it.
    let reason = CString::new(reason).unwrap_or_default();
    let mut reasons = reasons.lock().unwrap_or_else(PoisonError::into_inner);
    let known = reasons.iter().position(|known| *known == reason);
    let at = known.unwrap_or_else(|| {
        reasons.push(reason);
        reasons.len() - 1
    });
    reasons[at].as_ptr()
}

/// The port that the bridge listens at; 0 without a bridge.
///
/// # Safety
/// `bridge` is null or from `hb_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_port(bridge: *const HbBridge) -> u16 {
    if bridge.is_null() {
        return 0;
    }
    // SAFETY: shared by all threads, and only read.
    unsafe { (*bridge).bridge.serving.port }
}

/// Closes a bridge: the connection ends, and the memory is given back. NULL is nothing. It writes no force: end the haptic
/// thread first, and set the force of the device to zero.
///
/// # Safety
/// `bridge` is null or from `hb_open`; nobody uses it any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hb_close(bridge: *mut HbBridge) {
    if bridge.is_null() {
        return;
    }
    // SAFETY: from Box::into_raw in hb_open, and given back once.
    let bridge = unsafe { Box::from_raw(bridge) };
    // Nothing in there panics; if it did, the memory would be lost and the program go on.
    let _ = catch_unwind(std::panic::AssertUnwindSafe(|| drop(bridge)));
}
