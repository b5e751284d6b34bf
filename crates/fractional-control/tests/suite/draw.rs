//! Numbers that are drawn, of a fixed seed.

/// Numbers from 0 to 1, the same in every run: a linear congruence (D. E. Knuth, MMIX).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn from(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Even in the logarithm.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.from(low.ln(), high.ln()).exp()
    }
}
