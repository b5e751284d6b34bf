//! Linux: clock, sleep, priority, affinity and locked memory.

use super::moment::since_start;
use super::system::{SystemRefusal, Waiter};
use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall, munlockall};
use rustix::process::{Resource, getpriority_process, getrlimit};
use rustix::thread::{
    CapabilitySet, ClockId, CpuSet, capabilities, clock_nanosleep_absolute, current_timer_slack,
    sched_getaffinity, sched_setaffinity, set_current_timer_slack,
};
use rustix::time::Timespec;
use std::num::NonZeroU64;
use std::os::unix::thread::JoinHandleExt as _;
use std::thread::JoinHandle;
use std::time::Duration;
use std::vec::Vec;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadId, ThreadPriority, ThreadPriorityValue,
    ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
    thread_schedule_policy_param,
};

/// The share of a period that may be spinning is one in this many: a thread of real-time priority leaves the rest to others.
pub(super) const SPINNING_IS_ONE_IN: u32 = 4;

/// The clock that counts the time for which the machine slept, and its sleep.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemWaiter(());

impl Waiter for SystemWaiter {
    fn now(&mut self) -> Duration {
        since_start()
    }

    fn sleep_until(&mut self, time: Duration) {
        let request = Timespec {
            tv_sec: time.as_secs() as i64,
            tv_nsec: i64::from(time.subsec_nanos()),
        };
        // A signal wakes it early.
        while clock_nanosleep_absolute(ClockId::Boottime, &request) == Err(Errno::INTR) {}
    }
}

/// Cores that this process may run on; empty where the system does not say.
#[must_use]
pub fn allowed_cores() -> Vec<usize> {
    let set = sched_getaffinity(None).unwrap_or_default();
    (0..CpuSet::MAX_CPU)
        .filter(|core| set.is_set(*core))
        .collect()
}

/// Raises a thread of this process to `SCHED_FIFO` at a priority of 1 to 99.
///
/// # Errors
/// A wish that the system does not allow.
pub fn raise_thread<T>(thread: &JoinHandle<T>, priority: u8) -> Result<(), SystemRefusal> {
    fifo(thread.as_pthread_t() as ThreadId, priority)
}

fn fifo(thread: ThreadId, priority: u8) -> Result<(), SystemRefusal> {
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let value = ThreadPriorityValue::try_from(priority).map_err(|_| SystemRefusal::Unsupported)?;
    let priority = ThreadPriority::Crossplatform(value);
    set_thread_priority_and_policy(thread, priority, policy).map_err(|error| {
        if let thread_priority::Error::OS(code) = error {
            refusal(Errno::from_raw_os_error(code))
        } else {
            SystemRefusal::Unsupported
        }
    })
}

fn refusal(error: Errno) -> SystemRefusal {
    match error {
        Errno::PERM | Errno::ACCESS => SystemRefusal::NotPermitted,
        Errno::NOMEM | Errno::AGAIN => SystemRefusal::Limit,
        Errno::NOSYS => SystemRefusal::Unsupported,
        other => SystemRefusal::Other(other.raw_os_error()),
    }
}

#[derive(Debug, Default)]
pub(super) struct CurrentThread {
    policy: Option<(ThreadSchedulePolicy, ThreadPriority)>,
    affinity: Option<CpuSet>,
    timer_slack: Option<u64>,
    locked: bool,
}

impl CurrentThread {
    pub(super) fn raise(&mut self, priority: u8) -> Result<(), SystemRefusal> {
        let thread = thread_native_id();
        let before = policy_of(thread);
        let raised = fifo(thread, priority);
        if raised.is_ok() {
            self.policy = before;
        } else {
            // A short timer slack needs no privilege. With the usual one, the kernel may delay a wake-up by 50 µs.
            self.timer_slack = current_timer_slack().ok();
            let _ = set_current_timer_slack(NonZeroU64::new(1));
        }
        raised
    }

    pub(super) fn pin(&mut self, core: usize) -> Result<(), SystemRefusal> {
        if !allowed_cores().contains(&core) {
            return Err(SystemRefusal::NotPermitted);
        }
        let before = sched_getaffinity(None).map_err(refusal)?;
        let mut only = CpuSet::new();
        only.set(core);
        sched_setaffinity(None, &only).map_err(refusal)?;
        self.affinity = Some(before);
        Ok(())
    }

    pub(super) fn lock_memory(&mut self) -> Result<(), SystemRefusal> {
        // Below a limit that counts, locking what is to come would make allocations fail later.
        let unlimited = getrlimit(Resource::Memlock).current.is_none();
        let privileged =
            capabilities(None).is_ok_and(|sets| sets.effective.contains(CapabilitySet::IPC_LOCK));
        let flags = if unlimited || privileged {
            MlockAllFlags::CURRENT | MlockAllFlags::FUTURE
        } else {
            MlockAllFlags::CURRENT
        };
        mlockall(flags).map_err(refusal)?;
        self.locked = true;
        Ok(())
    }

    pub(super) fn restore(&mut self) {
        // Best effort, in the order that gives up the most first.
        if let Some((policy, priority)) = self.policy.take() {
            let _ = set_thread_priority_and_policy(thread_native_id(), priority, policy);
        }
        if let Some(before) = self.timer_slack.take() {
            let _ = set_current_timer_slack(NonZeroU64::new(before));
        }
        if let Some(before) = self.affinity.take() {
            let _ = sched_setaffinity(None, &before);
        }
        if core::mem::take(&mut self.locked) {
            let _ = munlockall();
        }
    }
}

/// Policy and priority of a thread, as `set_thread_priority_and_policy` takes them.
fn policy_of(thread: ThreadId) -> Option<(ThreadSchedulePolicy, ThreadPriority)> {
    let (policy, parameters) = thread_schedule_policy_param(thread).ok()?;
    let value = match policy {
        ThreadSchedulePolicy::Realtime(_) => u8::try_from(parameters.sched_priority).ok()?,
        ThreadSchedulePolicy::Normal(_) => value_of_nice(getpriority_process(None).unwrap_or(0)),
    };
    let value = ThreadPriorityValue::try_from(value).ok()?;
    Some((policy, ThreadPriority::Crossplatform(value)))
}

/// The value v that `thread-priority` turns into this niceness, trunc(39·(1 − v/99)) − 20.
fn value_of_nice(nice: i32) -> u8 {
    let middle = 99.0 * (1.0 - (f64::from(nice) + 20.5) / 39.0);
    middle.round().clamp(0.0, 99.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use thread_priority::NormalThreadSchedulePolicy;

    #[test]
    fn a_niceness_survives_the_way_there_and_back() {
        let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        for nice in -20..=19 {
            let value = ThreadPriorityValue::try_from(value_of_nice(nice)).expect("in range");
            let priority = ThreadPriority::Crossplatform(value);
            assert_eq!(priority.to_posix(policy), Ok(nice));
        }
    }

    #[test]
    fn a_core_that_is_not_there_is_refused() {
        let mut thread = CurrentThread::default();
        assert_eq!(thread.pin(usize::MAX), Err(SystemRefusal::NotPermitted));
        assert!(thread.affinity.is_none());
    }

    #[test]
    fn a_thread_is_afterwards_what_it_was_before() {
        std::thread::spawn(|| {
            let before = (policy_of(thread_native_id()), allowed_cores());
            let mut thread = CurrentThread::default();
            // As far as this machine allows.
            let raised = thread.raise(1);
            let pinned = before.1.first().map(|&core| thread.pin(core));
            if raised.is_ok() {
                assert_ne!(policy_of(thread_native_id()), before.0);
            }
            if pinned == Some(Ok(())) {
                assert_eq!(allowed_cores().len(), 1);
            }
            thread.restore();
            let after = (policy_of(thread_native_id()), allowed_cores());
            assert_eq!(after, before);
        })
        .join()
        .expect("no panic");
    }
}
