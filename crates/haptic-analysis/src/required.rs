//! The damping that Theorem 1 asks for, with Corollary 1 beside it.

/// The damping that Theorem 1 asks for, without units, and that of Corollary 1 beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RequiredDelta {
    /// The loop is passive for δ above this, and only then.
    pub delta: f64,
    /// θ that asks for it, rad/sample; of several π, then 0, then the largest.
    pub worst_theta: f64,
    /// The damping that Corollary 1 asks for: [`corollary_delta`](crate::corollary_delta).
    pub corollary_delta: f64,
    /// α + βP(1) < 0: a negative spring at rest, which no damping makes passive. Theorem 1 looks at
    /// θ > 0 only and cannot see it; A₃ with μ > 1 does this, P(1) = (1−μ)(3−μ)/3.
    pub negative_at_rest: bool,
}

impl RequiredDelta {
    /// Is a loop of this δ passive? Strict, as the theorem; never with a negative spring at rest.
    #[must_use]
    pub fn passive(&self, delta: f64) -> bool {
        delta > self.delta && !self.negative_at_rest
    }

    /// Ratio to the damping that the corollary promises; `None` where that is 0.
    #[must_use]
    pub fn excess(&self) -> Option<f64> {
        let ratio = self.delta / self.corollary_delta;
        ratio.is_finite().then_some(ratio)
    }
}

/// The same with units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RequiredDamping {
    /// The loop is passive for b above this, N·s/m, and only then.
    pub damping_n_s_per_m: f64,
    /// ω that asks for it, rad/s.
    pub worst_rad_s: f64,
    /// The damping that Corollary 1 asks for, N·s/m.
    pub corollary_n_s_per_m: f64,
    /// K + B·T^(−μ)·P(1) < 0, see [`RequiredDelta::negative_at_rest`].
    pub negative_at_rest: bool,
}

impl RequiredDamping {
    /// Is a device of this damping, N·s/m, passive? Strict, as the theorem.
    #[must_use]
    pub fn passive(&self, damping_n_s_per_m: f64) -> bool {
        damping_n_s_per_m > self.damping_n_s_per_m && !self.negative_at_rest
    }
}
