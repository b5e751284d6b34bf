//! Zones before a hard limit of place or speed, in which motion is braked.

use super::clamps::clamp;
use super::limits::{SpeedLimit, Workspace};
use crate::error::Checks;
use fracdiff::Real;

/// A zone in which motion is braked: not below `from`, fully at from + 1/`per`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Zone<F> {
    from: F,
    per: F,
    pub(super) hard: F,
}

impl<F: Real> Zone<F> {
    /// `soft` wide, up to `hard`; no zone if it has no width.
    #[inline(never)]
    fn new(
        what: &'static str,
        hard: f64,
        soft: f64,
        unit: &'static str,
        checks: &mut Checks,
    ) -> Self {
        let per = if soft > 0.0 { 1.0 / soft } else { 0.0 };
        Self {
            from: checks.rounded(what, hard - soft, unit),
            per: checks.rounded(what, per, unit),
            hard: checks.rounded(what, hard, unit),
        }
    }

    /// Depth into the zone, 0 to 1.
    #[inline]
    pub(super) fn depth(&self, value: F) -> F {
        clamp((value - self.from) * self.per, F::ZERO, F::ONE)
    }
}

/// The ends of a workspace: towards high, and towards −low.
pub(super) type Ends<F> = [Zone<F>; 2];

/// The zones at the ends of a workspace; refuses one that is none.
pub(super) fn workspace<F: Real>(workspace: Workspace, checks: &mut Checks) -> Ends<F> {
    let (low, high, soft) = (workspace.low.0, workspace.high.0, workspace.soft.0);
    checks.range("low end of the workspace", low, true, "finite", "m");
    checks.range(
        "high end of the workspace",
        high,
        high > low,
        "above the low one",
        "m",
    );
    let fits = (0.0..=0.5 * (high - low)).contains(&soft);
    let allowed = "from 0 to half the workspace";
    checks.range("workspace soft zone", soft, fits, allowed, "m");
    [
        Zone::new("high end of the workspace", high, soft, "m", checks),
        Zone::new("low end of the workspace", -low, soft, "m", checks),
    ]
}

/// The zone below a speed limit; refuses one that is none.
pub(super) fn speed<F: Real>(speed: SpeedLimit, checks: &mut Checks) -> Zone<F> {
    let (soft, hard) = (speed.soft.0, speed.hard.0);
    checks.range("soft speed limit", soft, soft >= 0.0, "at least 0", "m/s");
    checks.range(
        "speed limit",
        hard,
        hard > soft,
        "above the soft one",
        "m/s",
    );
    Zone::new("speed limit", hard, hard - soft, "m/s", checks)
}
