//! Check of this machine for a loop at some rate: measures as `cyclictest` does, with the loop's own runner.

mod machine;
mod rate;

pub use machine::Machine;
pub use rate::{FIT_SHARE, Plain, Rate};

use crate::RealtimeOptions;
use crate::document::failure::Failure;
use crate::document::parameters::RATE;
use haptic_loop::realtime::{
    Fallback, Periodic, PeriodicConfig, SpinMargin, StdWaiter, ThreadConfig, Timing, Waiter,
};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Settings of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct RtCheck {
    /// For each rate.
    pub duration: Duration,
    /// Rates, Hz.
    pub rates_hz: Vec<f64>,
    /// Options for the thread.
    pub thread: RealtimeOptions,
    /// Busy threads beside it, at normal priority.
    pub busy: usize,
    /// Measure a plain loop, too, in turns: normal priority, `std::thread::sleep`.
    pub compare: bool,
}

/// Results of a check.
#[derive(Clone, Debug, Serialize)]
pub struct RtReport {
    /// Facts of the machine.
    pub machine: Machine,
    /// For each rate, s.
    pub duration_s: f64,
    /// Busy threads beside it.
    pub busy: usize,
    /// The priority that was granted; null for a normal thread.
    pub priority: Option<u8>,
    /// The core that it was pinned to.
    pub pin: Option<usize>,
    /// True if the memory was locked.
    pub memory_locked: bool,
    /// Time in which the host of a virtual machine ran others instead, all processors together, ms.
    pub stolen_ms: Option<u64>,
    /// One for each rate.
    pub rates: Vec<Rate>,
    /// Changes to make, a sentence each; empty if nothing is left to change.
    pub advice: Vec<String>,
}

impl RtCheck {
    /// Measures. `progress` hears the share that is done.
    ///
    /// # Errors
    /// A rate outside its range; interrupted.
    pub fn run(&self, stop: &AtomicBool, progress: &dyn Fn(f64)) -> Result<RtReport, Failure> {
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            // Before any thread is raised, so that they are normal.
            for _ in 0..self.busy {
                scope.spawn(|| {
                    while !over.load(Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                });
            }
            let measured = self.measure(stop, progress);
            over.store(true, Ordering::Relaxed);
            measured
        })
    }

    fn measure(&self, stop: &AtomicBool, progress: &dyn Fn(f64)) -> Result<RtReport, Failure> {
        let root = std::path::Path::new("/");
        let machine = Machine::inspect(root);
        let stolen_before = machine::stolen_ms(root);
        let (mut rates, mut granted) = (Vec::new(), Granted::default());
        for (index, &hz) in self.rates_hz.iter().enumerate() {
            let done = |share: f64| progress((index as f64 + share) / self.rates_hz.len() as f64);
            rates.push(self.rate(hz, &mut granted, stop, &done)?);
        }
        let stolen_ms = stolen_before
            .zip(machine::stolen_ms(root))
            .map(|(before, after)| after.saturating_sub(before));
        Ok(RtReport {
            advice: machine.advice(granted.fallback, &rates, stolen_ms.unwrap_or(0)),
            rates,
            priority: granted.priority,
            pin: granted.pin,
            memory_locked: granted.memory_locked,
            busy: self.busy,
            duration_s: self.duration.as_secs_f64(),
            machine,
            stolen_ms,
        })
    }

    /// One rate; in turns of a second with the plain loop, so that both meet the same troubles.
    fn rate(
        &self,
        hz: f64,
        granted: &mut Granted,
        stop: &AtomicBool,
        progress: &dyn Fn(f64),
    ) -> Result<Rate, Failure> {
        let period = Duration::try_from_secs_f64(1.0 / hz).map_err(Failure::input)?;
        let seconds = self.duration.as_secs_f64();
        let turns = if self.compare {
            seconds.ceil().max(2.0)
        } else {
            1.0
        };
        let cycles = (seconds * hz / turns).ceil().max(1.0) as u64;
        let mut raised = PeriodicConfig {
            thread: self.thread.thread(),
            ..PeriodicConfig::new(period)
        };
        let normal = PeriodicConfig {
            thread: ThreadConfig::default(),
            spin_margin: SpinMargin::Fixed(Duration::ZERO),
            ..raised
        };
        let bad =
            |error| Failure::input_with_advice(error, format_args!("give {RATE}, as in 1000"));
        let (mut runner, mut plain): (Option<Timing>, Option<Timing>) = (None, None);
        for turn in 0..turns as u64 {
            let told = |share: f64| progress((turn as f64 + share) / turns);
            let mut periodic = Periodic::new(raised).map_err(bad)?;
            // Measured once for all turns.
            raised.spin_margin = SpinMargin::Fixed(periodic.spin_margin());
            let thread = periodic.thread();
            *granted = Granted {
                fallback: thread.fallback(),
                priority: thread.priority(),
                pin: thread.core(),
                memory_locked: thread.memory_is_locked(),
            };
            go_round(&mut periodic, cycles, stop, &told)?;
            gather(&mut runner, periodic.finish().0);
            if self.compare {
                let mut periodic =
                    Periodic::with_waiter(normal, StdWaiter::default()).map_err(bad)?;
                go_round(&mut periodic, cycles, stop, &told)?;
                gather(&mut plain, periodic.finish().0);
            }
        }
        let runner = runner.ok_or_else(|| Failure::bad_input("nothing to measure"))?;
        let SpinMargin::Fixed(margin) = raised.spin_margin else {
            return Err(Failure::bad_input("nothing to measure"));
        };
        Ok(Rate::of(hz, &runner, margin, plain.as_ref()))
    }
}

/// Options that the system granted.
#[derive(Clone, Copy, Debug, Default)]
struct Granted {
    fallback: Option<Fallback>,
    priority: Option<u8>,
    pin: Option<usize>,
    memory_locked: bool,
}

fn gather(whole: &mut Option<Timing>, part: Timing) {
    match whole {
        Some(whole) => whole.add(&part),
        None => *whole = Some(part),
    }
}

/// Waits for so many cycles, and does nothing in them.
fn go_round<W: Waiter>(
    periodic: &mut Periodic<W>,
    cycles: u64,
    stop: &AtomicBool,
    progress: &dyn Fn(f64),
) -> Result<(), Failure> {
    let mut periods = 0;
    // A skipped period is over, too: a machine that is late does not take longer.
    while periods < cycles {
        let cycle = periodic.wait();
        periods += 1 + cycle.skipped;
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::Run(anyhow::anyhow!("interrupted")));
        }
        if cycle.number.is_multiple_of(256) {
            progress(periods as f64 / cycles as f64);
        }
    }
    Ok(())
}
