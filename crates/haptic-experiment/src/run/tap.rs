//! Tap of a motor into a law at rest: as large as its limits allow, so that friction matters little beside it.
//!
//! ```text
//! a = min(¾ f, f − p, p/2 of a contact that lifts, ½ (0.4 w·K' − p), ½ v·m·ω, ½ r/ω)     f, r: limits of force, N, and its rate, N/s
//! K' = K + B·(N·T)^(−μ)     ω = max(√(K/m), (B/m)^(1/(2−μ))) ≤ 2/T                       v: speed limit, m/s; w: width of the workspace, m
//! ```
//! A quarter of the force limit is left for swings that grow. The time between two steps holds forty half swings, and the law's relaxation
//! eight times; a trial has three steps at least, an odd number of times between them, and ends without the tap.

/// Share of the force limit.
const FORCE_SHARE: f64 = 0.75;

/// A law that is tapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TappedLaw {
    pub(crate) stiffness_n_per_m: f64,
    pub(crate) dissipation_n_s_mu_per_m: f64,
    pub(crate) order: f64,
    pub(crate) mass_kg: f64,
    pub(crate) sample_time_s: f64,
    /// Samples of the trial.
    pub(crate) samples: u64,
    /// It never pulls.
    pub(crate) lifts: bool,
    pub(crate) push_n: f64,
}

impl TappedLaw {
    /// Ticks from one step to the next.
    pub(crate) fn ticks(&self) -> u32 {
        let (k, b, whole) = (
            self.stiffness_n_per_m,
            self.dissipation_n_s_mu_per_m,
            self.samples as f64,
        );
        let swings_s = 40.0 * std::f64::consts::PI * (self.mass_kg / k).sqrt();
        let relaxes_s = match self.order > 0.0 && b > 0.0 {
            true => 8.0 * libm::pow(b / k, self.order.recip()),
            false => 0.0,
        };
        let ticks = f64::max(swings_s, relaxes_s) / self.sample_time_s;
        let times = (whole / ticks.max(100.0)).clamp(3.0, 39.0) as u32;
        (whole / f64::from(times - 1 + times % 2)).ceil() as u32
    }

    /// The largest tap within this limit of force, N, and those of the workspace's width, m, of speed, m/s, and of the force's rate, N/s;
    /// 0 for none.
    pub(crate) fn force_n(
        &self,
        force_limit_n: f64,
        [width_m, speed, rate]: [Option<f64>; 3],
    ) -> f64 {
        let (k, b, mu) = (
            self.stiffness_n_per_m,
            self.dissipation_n_s_mu_per_m,
            self.order,
        );
        let lasts_s = f64::from(self.ticks()) * self.sample_time_s;
        let holds = k + b * libm::pow(lasts_s, -mu);
        let swings = f64::max(
            (k / self.mass_kg).sqrt(),
            libm::pow(b / self.mass_kg, (2.0 - mu).max(0.1).recip()),
        )
        .min(2.0 / self.sample_time_s);
        let all = [
            Some(FORCE_SHARE * force_limit_n),
            Some(force_limit_n - self.push_n),
            self.lifts.then_some(0.5 * self.push_n),
            width_m.map(|width_m| 0.5 * (0.4 * width_m * holds - self.push_n)),
            speed.map(|speed| 0.5 * speed * self.mass_kg * swings),
            rate.map(|rate| 0.5 * rate / swings),
        ];
        all.into_iter()
            .flatten()
            .fold(f64::INFINITY, f64::min)
            .max(0.0)
    }
}
