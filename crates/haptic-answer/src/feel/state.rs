//! The newest of a loop that is felt, and its channels.

use fracdiff::Seconds;
use haptic_loop::{Fault, Limiters};
use serde::Serialize;
use serde_json::{Value, json};

/// The channels of a loop, in the order of its samples.
pub const CHANNELS: [&str; 10] = [
    "position_m",
    "hand_m",
    "force_n",
    "ghost_short_n",
    "ghost_a3_n",
    "energy_j",
    "limiter",
    "position_at_force_m",
    "position_at_short_m",
    "position_at_a3_m",
];
/// Places of those that the last ones follow: their columns hold the position at the moments of least and largest force.
pub(super) const FOLLOWED: [usize; 3] = [2, 3, 4];
/// Place of the position among them.
pub const POSITION: usize = 0;

/// The newest of the loop, as `status` reports it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the protocol has them, by these names")]
pub struct FeelState {
    pub sample_time_s: f64,
    pub tick: u64,
    pub time_s: f64,
    pub position_m: f64,
    pub force_n: f64,
    pub energy_j: f64,
    pub limiter: u8,
    #[serde(skip)]
    pub fault: Option<Fault>,
    #[serde(rename = "stopped")]
    pub stopping: bool,
    pub late: u64,
    pub skipped: u64,
    pub tick_p50_us: f64,
    pub tick_p999_us: f64,
    pub tick_max_us: f64,
    pub late_p50_us: f64,
    pub late_p999_us: f64,
    pub recording: Option<String>,
    pub recorded: u64,
}

impl FeelState {
    /// State of a loop before its first tick.
    pub fn of(sample_time: Seconds) -> Self {
        Self {
            sample_time_s: sample_time.0,
            ..Self::default()
        }
    }

    /// The status of a loop that has made so many ticks and lost so many; so many are kept.
    #[must_use]
    pub fn status(&self, (made, lost): (u64, u64), kept: u64) -> Value {
        let limiters = (0..8).filter(|bit| self.limiter & (1 << bit) != 0);
        let limiters: Vec<&str> = limiters.map(|bit| Limiters::NAMES[bit]).collect();
        let mut status = json!(self);
        status["running"] = true.into();
        status["lost"] = lost.into();
        status["limiters"] = json!(limiters);
        status["fault"] = json!(self.fault.map(|fault| fault.to_string()));
        status["armed"] = (!self.stopping && self.fault.is_none()).into();
        status["samples_made"] = made.into();
        status["samples_kept"] = kept.saturating_sub(lost).into();
        status
    }
}

/// The status without a loop.
#[must_use]
pub fn idle() -> Value {
    json!({
        "running": false,
        "armed": false,
        "paused": false,
        "stopped": false,
    })
}
