//! Results at one rate.

use crate::run::realtime::{Microseconds, WorstTick, microseconds};
use haptic_loop::realtime::Timing;
use serde::Serialize;
use std::time::Duration;

/// A rate is fit if 999 of 1000 cycles begin within this share of the period, and none a period late.
pub const FIT_SHARE: f64 = 0.1;

/// A rate.
#[derive(Clone, Debug, Serialize)]
pub struct Rate {
    /// The rate.
    pub hz: f64,
    /// True if a loop at this rate is safe here.
    pub fit: bool,
    /// From when a cycle was due to when it began.
    pub lateness_us: Microseconds,
    /// Cycles that began a whole period late or more.
    pub overruns: u64,
    /// Periods that were skipped for it.
    pub skipped_periods: u64,
    /// Cycles that ran.
    pub cycles: u64,
    /// The cycle that ended latest.
    pub worst_cycle: Option<WorstTick>,
    /// For how long before it was due a cycle was waited for without sleeping, µs.
    pub spin_margin_us: f64,
    /// The plain loop; null if none was asked for.
    pub plain: Option<Plain>,
}

/// The plain loop beside.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Plain {
    /// From when a cycle was due to when it began.
    pub lateness_us: Microseconds,
    /// Cycles that began a whole period late or more.
    pub overruns: u64,
    /// Periods that were skipped for it.
    pub skipped_periods: u64,
    /// Its lateness, 99.9 %, over that of the runner.
    pub ratio_p999: f64,
}

impl Rate {
    /// Of what the runner did, which spun for `margin` before each cycle, and of a plain loop.
    pub(super) fn of(hz: f64, runner: &Timing, margin: Duration, plain: Option<&Timing>) -> Self {
        let lateness_us = Microseconds::of(runner.lateness_ns());
        let overruns = runner.overruns();
        Self {
            hz,
            lateness_us,
            overruns: overruns.cycles(),
            skipped_periods: overruns.skipped_periods,
            cycles: runner.lateness_ns().len(),
            worst_cycle: runner.worst().map(WorstTick::from),
            spin_margin_us: microseconds(margin),
            fit: overruns.cycles() == 0 && lateness_us.p999 <= FIT_SHARE * 1e6 / hz,
            plain: plain.map(|plain| {
                let beside = Microseconds::of(plain.lateness_ns());
                Plain {
                    lateness_us: beside,
                    overruns: plain.overruns().cycles(),
                    skipped_periods: plain.overruns().skipped_periods,
                    // The clock's resolution is 1 ns.
                    ratio_p999: beside.p999 / lateness_us.p999.max(1e-3),
                }
            }),
        }
    }
}
