//! The signals that a run hears: none of them leaves a force behind. Who installs the handlers is the program.

use std::ffi::c_int;

/// Every signal that would end or stop this program, and that a program may hear. Excluded are KILL
/// and STOP, which no program can catch; ILL, FPE, SEGV and BUS, after which a program cannot go
/// on; PIPE and XFSZ, which a failed write reports; those that do nothing to a program that does
/// not listen; and HUP where it is ignored, as by `nohup`. The other ones are heard all the same: a
/// shell ignores INT for whatever it starts in the background, and `kill -INT` is to stop that too.
#[cfg(unix)]
#[must_use]
pub fn signals() -> Vec<c_int> {
    use signal_hook::consts::{
        SIGABRT, SIGALRM, SIGHUP, SIGINT, SIGPROF, SIGQUIT, SIGSYS, SIGTERM, SIGTRAP, SIGTSTP,
        SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU,
    };
    let mut heard = vec![
        SIGINT, SIGTERM, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1,
        SIGUSR2, SIGXCPU, SIGABRT, SIGSYS, SIGTRAP,
    ];
    if mask("SigIgn:").is_none_or(|ignored| !is_in(ignored, SIGHUP)) {
        heard.push(SIGHUP);
    }
    #[cfg(target_os = "linux")]
    {
        // The real-time ones end a program on Linux alone.
        heard.extend([libc::SIGIO, libc::SIGPWR, libc::SIGSTKFLT]);
        heard.extend(libc::SIGRTMIN()..=libc::SIGRTMAX());
    }
    heard
}

/// No signal is known by its number here.
#[cfg(not(unix))]
#[must_use]
pub const fn signals() -> Vec<c_int> {
    Vec::new()
}

/// One of these signals that this process does not catch although a handler was installed: somebody
/// has put another in its place. None where the system does not report it.
#[must_use]
pub fn uncaught(signals: &[c_int]) -> Option<c_int> {
    let caught = mask("SigCgt:")?;
    (signals.iter().copied()).find(|&signal| !is_in(caught, signal))
}

/// A set of signals of this process. Only Linux reports it without `unsafe`.
fn mask(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mask = status.lines().find_map(|line| line.strip_prefix(name))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

const fn is_in(mask: u64, signal: c_int) -> bool {
    mask & 1 << (signal - 1) != 0
}
