//! A thread that the system prefers to others, and what it refuses.

use super::here::CurrentThread;
use super::system::SystemRefusal;
use core::fmt;
use core::marker::PhantomData;

/// Priorities that a system may grant.
pub const PRIORITIES: core::ops::RangeInclusive<u8> = 1..=99;

/// The wishes for a thread. One with a priority keeps the memory of the whole process out of the swap, and touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ThreadConfig {
    /// `SCHED_FIFO` at this priority, 1 to 99, and time-critical on Windows; `None` for the normal one.
    pub priority: Option<u8>,
    /// The only core to run on.
    pub pin: Option<usize>,
}

impl ThreadConfig {
    /// Priority where none is given: above the interrupts' threads of a real-time kernel, 50.
    pub const DEFAULT_PRIORITY: u8 = 80;
}

/// The wishes that were refused; prints as one sentence that says what to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fallback {
    /// The requested priority, and why the system refused it.
    pub priority: Option<(u8, SystemRefusal)>,
    /// The requested core, and why the system refused it.
    pub pin: Option<(usize, SystemRefusal)>,
    /// Why the memory could not be locked.
    pub memory: Option<SystemRefusal>,
}

impl fmt::Display for Fallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        if let Some((priority, refusal)) = self.priority {
            write!(f, "no real-time priority {priority} ({refusal})")?;
            if matches!(refusal, SystemRefusal::NotPermitted | SystemRefusal::Limit) {
                write!(
                    f,
                    ": allow it with `ulimit -r {priority}`, a line `@realtime - rtprio {priority}` in \
                     /etc/security/limits.d for a group of yours, or `setcap cap_sys_nice+ep` on this program"
                )?;
            }
            separator = "; ";
        }
        if let Some((core, refusal)) = self.pin {
            write!(f, "{separator}not pinned to core {core} ({refusal})")?;
            separator = "; ";
        }
        if let Some(refusal) = self.memory {
            write!(f, "{separator}memory not locked ({refusal})")?;
            if matches!(refusal, SystemRefusal::NotPermitted | SystemRefusal::Limit) {
                write!(
                    f,
                    ": allow it with `ulimit -l unlimited` or `memlock` there"
                )?;
            }
        }
        Ok(())
    }
}

/// The calling thread, raised until this is dropped.
///
/// Threads that it starts meanwhile inherit priority and core: start those that are to be normal before.
#[derive(Debug)]
pub struct RaisedThread {
    thread: CurrentThread,
    config: ThreadConfig,
    fallback: Fallback,
    /// Dropping it elsewhere would restore another thread.
    not_send: PhantomData<*const ()>,
}

impl RaisedThread {
    /// Raises the calling thread as far as the system allows.
    #[must_use]
    pub fn new(config: ThreadConfig) -> Self {
        let mut thread = CurrentThread::default();
        let pin = config
            .pin
            .and_then(|core| Some((core, thread.pin(core).err()?)));
        let memory = config.priority.and_then(|_| thread.lock_memory().err());
        // Last, so that what comes before does not run at it.
        let priority = config
            .priority
            .and_then(|priority| Some((priority, thread.raise(priority).err()?)));
        let fallback = Fallback {
            priority,
            pin,
            memory,
        };
        Self {
            thread,
            config,
            fallback,
            not_send: PhantomData,
        }
    }

    /// The wishes that were refused.
    #[must_use]
    pub fn fallback(&self) -> Option<Fallback> {
        (self.fallback != Fallback::default()).then_some(self.fallback)
    }

    /// The priority that was granted.
    #[must_use]
    pub fn priority(&self) -> Option<u8> {
        let refused = self.fallback.priority.is_some();
        self.config.priority.filter(|_| !refused)
    }

    /// The core that it was pinned to.
    #[must_use]
    pub fn core(&self) -> Option<usize> {
        self.config.pin.filter(|_| self.fallback.pin.is_none())
    }

    /// True if the memory is locked.
    #[must_use]
    pub const fn memory_is_locked(&self) -> bool {
        self.config.priority.is_some() && self.fallback.memory.is_none()
    }
}

impl Drop for RaisedThread {
    fn drop(&mut self) {
        self.thread.restore();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString as _;

    #[test]
    fn what_is_not_asked_is_not_refused() {
        assert_eq!(RaisedThread::new(ThreadConfig::default()).fallback(), None);
    }

    #[test]
    fn a_refused_priority_says_how_to_get_it() {
        let fallback = Fallback {
            priority: Some((80, SystemRefusal::NotPermitted)),
            ..Fallback::default()
        };
        let text = fallback.to_string();
        for part in [
            "priority 80 (not permitted)",
            "`ulimit -r 80`",
            "limits.d",
            "rtprio 80",
            "setcap cap_sys_nice",
        ] {
            assert!(text.contains(part), "\"{part}\" in: {text}");
        }
        assert!(!text.contains("memory") && !text.contains('\n'), "{text}");
    }

    #[test]
    fn all_refusals_make_one_sentence() {
        let fallback = Fallback {
            priority: Some((80, SystemRefusal::Unsupported)),
            pin: Some((3, SystemRefusal::Other(22))),
            memory: Some(SystemRefusal::Limit),
        };
        assert_eq!(
            fallback.to_string(),
            "no real-time priority 80 (not on this system); not pinned to core 3 (error 22 of the system); \
             memory not locked (above this user's limit): allow it with `ulimit -l unlimited` or `memlock` there"
        );
    }
}
