//! The rules, and how much a wall at rest may vary by each.

use serde::Serialize;

/// Share of the samples in which the force may be at its limit.
pub(super) const LIMITED_SHARE: f64 = 0.01;

/// By which rule a trial is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Position, force and the force limit.
    Settling,
    /// That of the dissertation's figure 4.3: a push from rest, and a standard deviation of the position of at most 0.1 mm.
    Dissertation,
}

/// Threshold of figure 4.3, m.
const DISSERTATION_THRESHOLD_M: f64 = 1e-4;

/// Everything about a wall that its tolerance depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scales {
    /// Constant push, N.
    pub(crate) push_n: f64,
    /// Wall and hand together, N/m.
    pub(crate) spring_n_per_m: f64,
    /// B·T^(−μ), N/m: force of a step of the position through the operator.
    pub(crate) dissipation_step_n_per_m: f64,
    /// Encoder step, or what stands for noise, m.
    pub(crate) encoder_step_m: f64,
}

/// Largest variation of a wall at rest; `None` for any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tolerance {
    pub(super) position_std_m: Option<f64>,
    pub(super) force_std_n: Option<f64>,
    /// From the least to the largest force, N.
    pub(super) force_range_n: Option<f64>,
    /// Share of the samples at the force limit.
    pub(super) limited: Option<f64>,
}

/// Share of the deflection by which a position at rest may vary.
const POSITION_SHARE: f64 = 0.01;

/// Encoder steps by which it may vary.
const STEPS: f64 = 2.0;

/// A wall at rest lets the force swing by this share of the push from end to end: a force that is half the push too
/// large or too small has let go of the device, however rarely.
const FORCE_RANGE_SHARE: f64 = 1.0;
/// Share of the push by which a force at rest may vary.
const FORCE_SHARE: f64 = 0.05;

/// Share of the push beyond which one encoder step through the operator is no excuse.
const FORCE_STEP_SHARE: f64 = 0.25;

impl Tolerance {
    pub(crate) fn new(criterion: Criterion, scales: Scales) -> Self {
        match criterion {
            Criterion::Dissertation => Self {
                position_std_m: Some(DISSERTATION_THRESHOLD_M),
                force_std_n: None,
                force_range_n: None,
                limited: None,
            },
            Criterion::Settling => {
                let step = scales.encoder_step_m;
                let held = scales.spring_n_per_m > 0.0;
                let deflection = scales.push_n / scales.spring_n_per_m;
                let force_step =
                    (scales.dissipation_step_n_per_m * step).min(FORCE_STEP_SHARE * scales.push_n);
                Self {
                    position_std_m: held.then(|| (STEPS * step).max(POSITION_SHARE * deflection)),
                    force_std_n: Some(force_step.max(FORCE_SHARE * scales.push_n)),
                    force_range_n: Some(FORCE_RANGE_SHARE * scales.push_n),
                    limited: Some(LIMITED_SHARE),
                }
            }
        }
    }
}
