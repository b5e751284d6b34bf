//! The outcome of a trial.

use super::criterion::{Criterion, LIMITED_SHARE};
use serde::Serialize;

/// A device this far away has left, m: it will not come to rest.
pub(crate) const GONE_M: f64 = 1.0;

/// The outcome of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrialVerdict {
    /// At rest.
    Stable,
    /// At rest, but only because friction holds the device: without friction it is not.
    HeldByFriction,
    /// Position or force varies.
    Unstable,
    /// The force was at its limit too often: the limit was tried, not the wall.
    Saturated,
    /// The device has left.
    Gone,
    /// A fault or an interruption ended the trial.
    Unfinished,
}

impl TrialVerdict {
    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::HeldByFriction => "held still by friction alone",
            Self::Unstable => "unstable",
            Self::Saturated => "saturated",
            Self::Gone => "gone",
            Self::Unfinished => "not finished",
        }
    }
}

/// State of the device at the end, and whether it is at rest there. Keys of reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settling {
    /// True if it is at rest, and not by friction alone.
    pub stable: bool,
    /// Verdict on the trial.
    pub verdict: TrialVerdict,
    /// By which rule.
    pub criterion: Criterion,
    /// Speed at which the device hit the wall, m/s; 0 for a push from rest.
    pub impact_m_per_s: f64,
    /// Standard deviation of the position over the window, m; null if the device has left or the trial did
    /// not reach its end.
    pub position_std_m: Option<f64>,
    /// The largest that counts as rest, m; null without a spring, where the device gives way for ever.
    pub position_std_limit_m: Option<f64>,
    /// Standard deviation of the force over the window, N.
    pub force_std_n: Option<f64>,
    /// The largest that counts as rest, N; null if the criterion does not ask.
    pub force_std_limit_n: Option<f64>,
    /// From the least to the largest force of the window, N.
    pub force_range_n: Option<f64>,
    /// The largest that counts as rest, N; null if the criterion does not ask.
    pub force_range_limit_n: Option<f64>,
    /// Share of all samples whose force was at its limit, 0 to 1.
    pub saturated_share: Option<f64>,
    /// Mean of the position over the window, m.
    pub deflection_m: Option<f64>,
    /// Position at which the push is in balance with wall and hand, m; null without a spring.
    pub expected_deflection_m: Option<f64>,
}

impl Settling {
    /// The same, found to rest on friction.
    #[must_use]
    pub(crate) fn by_friction(self) -> Self {
        Self {
            stable: false,
            verdict: TrialVerdict::HeldByFriction,
            ..self
        }
    }

    /// Why it is not stable, in words; `None` if it is.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        let of = |have: Option<f64>, most: Option<f64>| Some((have?, most?));
        let over = |pair: Option<(f64, f64)>| pair.filter(|(have, most)| have > most);
        let share = self.saturated_share.unwrap_or(0.0);
        match self.verdict {
            TrialVerdict::Stable => None,
            TrialVerdict::HeldByFriction => Some(
                "friction alone holds the device still: without it, it does not settle".to_owned(),
            ),
            TrialVerdict::Saturated => Some(format!(
                "the force was at its limit in {:.1} % of the samples, more than {} %",
                1e2 * share,
                1e2 * LIMITED_SHARE
            )),
            TrialVerdict::Gone => Some(format!("the device was more than {GONE_M} m away")),
            TrialVerdict::Unfinished => Some("the trial did not reach its end".to_owned()),
            TrialVerdict::Unstable => {
                let position =
                    over(of(self.position_std_m, self.position_std_limit_m)).map(|(have, most)| {
                        format!("the position varies by {have:.3e} m, more than {most:.3e} m")
                    });
                let force =
                    over(of(self.force_std_n, self.force_std_limit_n)).map(|(have, most)| {
                        format!("the force varies by {have:.3e} N, more than {most:.3e} N")
                    });
                let swing =
                    over(of(self.force_range_n, self.force_range_limit_n)).map(|(have, most)| {
                        format!("the force swings over {have:.3e} N, more than {most:.3e} N")
                    });
                let all: Vec<String> = position.into_iter().chain(force).chain(swing).collect();
                Some(format!("at the end {}", all.join(", and ")))
            }
        }
    }
}
