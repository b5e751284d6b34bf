//! The end of a run from outside: Ctrl-C, and every other signal.

use haptic_experiment::Failure;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};

/// The flag that Ctrl-C sets, and every other signal that would end or stop a program and that a program may hear: none of them leaves
/// a force behind. Ctrl-Z ends a run too, as a stopped program takes no force away. The handlers are installed once.
///
/// # Errors
/// If the system does not let a program watch for them.
pub fn stop_on_interrupt() -> Result<&'static AtomicBool, Failure> {
    static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
    static INSTALLED: OnceLock<Result<(), String>> = OnceLock::new();
    match INSTALLED.get_or_init(|| heard(&STOP)) {
        Ok(()) => Ok(&STOP),
        Err(error) => Err(Failure::Run(anyhow::anyhow!(
            "cannot watch for Ctrl-C, so a run could not be stopped safely: {error}"
        ))),
    }
}

fn heard(stop: &Arc<AtomicBool>) -> Result<(), String> {
    let flag = Arc::clone(stop);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))
        .map_err(|error| error.to_string())?;
    #[cfg(unix)]
    other_signals(stop).map_err(|error| error.to_string())?;
    Ok(())
}

/// Those beside Ctrl-C, TERM and HUP.
///
/// Not among them are KILL and STOP, which nobody hears; ILL, FPE, SEGV and BUS, after which a program cannot go on; and those
/// that do nothing to a program that does not listen.
#[cfg(unix)]
fn other_signals(stop: &Arc<AtomicBool>) -> std::io::Result<()> {
    use signal_hook::consts::{
        SIGABRT, SIGALRM, SIGPROF, SIGQUIT, SIGSYS, SIGTRAP, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1,
        SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
    };
    let everywhere = [
        SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2, SIGXCPU,
        SIGABRT, SIGSYS, SIGTRAP,
    ];
    for signal in everywhere.into_iter().chain(signals_of_linux()) {
        signal_hook::flag::register(signal, Arc::clone(stop))?;
    }
    // A file that may not grow is told by the write that fails, as a full disk is.
    signal_hook::flag::register(SIGXFSZ, Arc::default())?;
    Ok(())
}

/// Those that end a program on Linux alone, the real-time ones among them.
#[cfg(unix)]
fn signals_of_linux() -> Vec<std::ffi::c_int> {
    #[cfg(target_os = "linux")]
    {
        let named = [libc::SIGIO, libc::SIGPWR, libc::SIGSTKFLT];
        let realtime = libc::SIGRTMIN()..=libc::SIGRTMAX();
        named.into_iter().chain(realtime).collect()
    }
    #[cfg(not(target_os = "linux"))]
    Vec::new()
}
