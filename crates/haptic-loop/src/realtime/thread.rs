//! A thread that the system prefers to others, and what it refuses.

use super::here::CurrentThread;
use super::system::{Refusal, System};
use core::fmt;
use core::marker::PhantomData;

/// Priorities that a system may grant.
pub const PRIORITIES: core::ops::RangeInclusive<u8> = 1..=99;

/// The wishes for a thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ThreadConfig {
    /// `SCHED_FIFO` at this priority, 1 to 99; `None` for the normal one.
    pub priority: Option<u8>,
    /// The only core to run on.
    pub pin: Option<usize>,
    /// Keep the memory of the whole process out of the swap, and touched.
    pub lock_memory: bool,
}

/// The wishes that were refused; prints as one sentence that says what to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fallback {
    /// The priority.
    pub priority: Option<(u8, Refusal)>,
    /// The core.
    pub pin: Option<(usize, Refusal)>,
    /// Locked memory.
    pub memory: Option<Refusal>,
}

impl fmt::Display for Fallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        if let Some((priority, refusal)) = self.priority {
            write!(f, "no real-time priority {priority} ({refusal})")?;
            if matches!(refusal, Refusal::NotPermitted | Refusal::Limit) {
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
            if matches!(refusal, Refusal::NotPermitted | Refusal::Limit) {
                write!(
                    f,
                    ": allow it with `ulimit -l unlimited` or `memlock` there"
                )?;
            }
        }
        Ok(())
    }
}

/// Asks for everything, and gathers what is refused.
fn ask(system: &mut impl System, config: ThreadConfig) -> Option<Fallback> {
    let pin = config
        .pin
        .and_then(|core| Some((core, system.pin(core).err()?)));
    let memory = match config.lock_memory {
        true => system.lock_memory().err(),
        false => None,
    };
    // Last, so that what comes before does not run at it.
    let priority = config
        .priority
        .and_then(|priority| Some((priority, system.raise(priority).err()?)));
    let fallback = Fallback {
        priority,
        pin,
        memory,
    };
    (fallback != Fallback::default()).then_some(fallback)
}

/// The calling thread, raised until this is dropped.
///
/// Threads that it starts meanwhile inherit priority and core: start those that are to be normal before.
#[derive(Debug)]
pub struct RaisedThread {
    thread: CurrentThread,
    config: ThreadConfig,
    fallback: Option<Fallback>,
    /// Dropping it elsewhere would restore another thread.
    not_send: PhantomData<*const ()>,
}

impl RaisedThread {
    /// Raises the calling thread as far as the system allows.
    #[must_use]
    pub fn new(config: ThreadConfig) -> Self {
        let mut thread = CurrentThread::default();
        let fallback = ask(&mut thread, config);
        Self {
            thread,
            config,
            fallback,
            not_send: PhantomData,
        }
    }

    /// The wishes that were refused.
    #[must_use]
    pub const fn fallback(&self) -> Option<Fallback> {
        self.fallback
    }

    /// The priority that was granted.
    #[must_use]
    pub fn priority(&self) -> Option<u8> {
        let refused = self
            .fallback
            .is_some_and(|fallback| fallback.priority.is_some());
        self.config.priority.filter(|_| !refused)
    }

    /// The core that it was pinned to.
    #[must_use]
    pub fn core(&self) -> Option<usize> {
        let refused = self.fallback.is_some_and(|fallback| fallback.pin.is_some());
        self.config.pin.filter(|_| !refused)
    }

    /// True if the memory is locked.
    #[must_use]
    pub fn memory_is_locked(&self) -> bool {
        let refused = self
            .fallback
            .is_some_and(|fallback| fallback.memory.is_some());
        self.config.lock_memory && !refused
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

    /// Answers what it is told to.
    struct Stubborn {
        raise: Result<(), Refusal>,
        pin: Result<(), Refusal>,
        lock: Result<(), Refusal>,
    }

    impl System for Stubborn {
        fn raise(&mut self, _: u8) -> Result<(), Refusal> {
            self.raise
        }

        fn pin(&mut self, _: usize) -> Result<(), Refusal> {
            self.pin
        }

        fn lock_memory(&mut self) -> Result<(), Refusal> {
            self.lock
        }

        fn restore(&mut self) {}
    }

    const ALL: ThreadConfig = ThreadConfig {
        priority: Some(80),
        pin: Some(3),
        lock_memory: true,
    };

    #[test]
    fn what_is_granted_needs_no_words() {
        let mut willing = Stubborn {
            raise: Ok(()),
            pin: Ok(()),
            lock: Ok(()),
        };
        assert_eq!(ask(&mut willing, ALL), None);
    }

    #[test]
    fn what_is_not_asked_is_not_refused() {
        let mut unwilling = Stubborn {
            raise: Err(Refusal::NotPermitted),
            pin: Err(Refusal::Unsupported),
            lock: Err(Refusal::Limit),
        };
        assert_eq!(ask(&mut unwilling, ThreadConfig::default()), None);
    }

    #[test]
    fn a_refused_priority_says_how_to_get_it() {
        let mut unwilling = Stubborn {
            raise: Err(Refusal::NotPermitted),
            pin: Ok(()),
            lock: Ok(()),
        };
        let fallback = ask(&mut unwilling, ALL).expect("refused");
        assert_eq!(fallback.priority, Some((80, Refusal::NotPermitted)));
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
        let mut unwilling = Stubborn {
            raise: Err(Refusal::Unsupported),
            pin: Err(Refusal::Other(22)),
            lock: Err(Refusal::Limit),
        };
        let text = ask(&mut unwilling, ALL).expect("refused").to_string();
        assert_eq!(
            text,
            "no real-time priority 80 (not on this system); not pinned to core 3 (error 22 of the system); \
             memory not locked (above this user's limit): allow it with `ulimit -l unlimited` or `memlock` there"
        );
    }
}
