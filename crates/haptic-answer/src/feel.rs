//! A tissue or wall that is felt: its settings, their verdict, laws and limits, the ghosts beside it, and its state.

pub mod ghost;
pub mod law;
pub mod limits;
pub mod settings;
pub mod state;
#[cfg(test)]
mod tests;

pub use law::JudgedFeel;
pub use settings::{DeviceNumbers, FeelChange, FeelSettings, FeltThing, SLIDERS, WallNumbers};
pub use state::{CHANNELS, FeelState};

use crate::pyramid::PyramidSize;
use haptic_loop::SafetyLimits;
use haptic_trial::in_hand::hand::{HAND_DAMPING, HAND_STIFFNESS};
use serde_json::{Value, json};

/// The levels that are kept of a loop.
pub const fn pyramid_size() -> PyramidSize<'static> {
    PyramidSize {
        follows: &state::FOLLOWED,
        ..PyramidSize::usual(CHANNELS.len())
    }
}

/// Settings of the felt loop and its verdict: the same in answers and to all pages.
#[must_use]
pub fn felt(felt: &JudgedFeel) -> Value {
    let limits = SafetyLimits::default();
    let (mut feel, mut verdict) = (json!(felt.settings), json!(felt.verdict));
    feel["hand_stiffness_n_per_m"] = HAND_STIFFNESS.0.into();
    feel["hand_damping_n_s_per_m"] = HAND_DAMPING.0.into();
    feel["force_limit_n"] = limits.force.0.into();
    feel["force_rate_limit_n_per_s"] = limits.rate.0.into();
    feel["memory_s"] = (pyramid_size().samples as f64 * felt.settings.device.sample_time_s).into();
    verdict["line"] = felt.verdict.line().into();
    verdict["mass_kg"] = felt.dynamics.mass_kg.into();
    verdict["damping_n_s_per_m"] = felt.dynamics.damping_n_s_per_m.into();
    verdict["hand_stiffness_n_per_m"] = felt.dynamics.hand_stiffness_n_per_m.into();
    feel["verdict"] = verdict;
    json!({"feel": feel})
}
