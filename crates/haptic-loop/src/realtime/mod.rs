//! A loop by the clock: a thread that wakes at t₀ + n·T, knows how late it was, and what made it late.
//!
//! ```text
//! wait ─▶ sleep to due − margin ─▶ spin to due ─▶ Cycle {number, lateness, skipped} ─▶ the caller's tick ─▶ wait
//!                                                └─ lateness ─┴────── compute ──────┘
//!                                                └────────────── tick ──────────────┘
//! ```
//! - *Absolute times*: a late cycle does not move those after it.
//! - *Overrun*: a cycle that starts a period late or more drops the whole periods that have passed, starts at once, and
//!   the next is due where it always was. It is counted, with its cause: the machine woke the thread late, or the cycle
//!   before took too long.
//! - *Cost*: `wait` neither allocates nor locks; on Linux it makes one system call, and some clock reads.
//!
//! Linux: `clock_nanosleep` by the clock that counts the machine's sleep ([`Moment`]), `SCHED_FIFO`, `mlockall`, affinity. What the
//! system refuses is said by [`RaisedThread::fallback`], and the loop runs without it. Elsewhere a thread sleeps as the standard
//! library does, and spins for longer; on Windows it is time-critical, whatever priority was asked for.

mod durations;
#[cfg(target_os = "linux")]
#[path = "linux.rs"]
mod here;
#[cfg(not(target_os = "linux"))]
#[path = "elsewhere.rs"]
mod here;
mod moment;
mod periodic;
mod system;
mod thread;
mod timing;

pub use durations::Durations;
pub use here::{SystemWaiter, allowed_cores, raise_thread};
pub use moment::Moment;
pub use periodic::{Cycle, Periodic, PeriodicConfig, SpinMargin};
pub use system::{SystemRefusal, Waiter};
pub use thread::{Fallback, PRIORITIES, RaisedThread, ThreadConfig};
pub use timing::{Overruns, Timing, WorstCycle};
