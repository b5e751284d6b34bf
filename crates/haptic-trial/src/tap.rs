//! Tap of a motor into a law at rest: as large as its limits allow, so that friction matters little beside it.
//!
//! ```text
//! a = min(¾ f, f − p, p/2 of a contact that lifts, ½ (0.4 w·K' − p), ½ v·m·ω, ½ r/ω)     f, r: limits of force, N, and its rate, N/s
//! K' = K + B·(N·T)^(−μ)     ω = max(√(K/m), (B/m)^(1/(2−μ))) ≤ 2/T                       v: speed limit, m/s; w: width of the workspace, m
//! ```
//! A quarter of the force limit is left for swings that grow. The time between two steps holds forty half swings, and the law's relaxation
//! eight times; a trial has three steps at least, an odd number of times between them, and ends without the tap.

use haptic_link::Limits;
use haptic_loop::plant::MassDamperConfig;

/// A law that is tapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TappedLaw {
    /// Device and hand, as they are known.
    pub device: MassDamperConfig,
    /// K of wall and hand, N/m, and B, N·s^μ/m.
    pub wall: [f64; 2],
    /// Order μ of the wall's dissipation.
    pub order: f64,
    /// Samples of the trial, over which the taps are spread.
    pub samples: u64,
    /// True if the law never pulls, so that a tap may lift the device off.
    pub lifts: bool,
    /// Push into the law, N.
    pub push_n: f64,
}

impl TappedLaw {
    /// Ticks from one step to the next.
    pub fn ticks(&self) -> u32 {
        let ([k, b], whole) = (self.wall, self.samples as f64);
        let swings_s = 40.0 * std::f64::consts::PI * (self.device.mass.0 / k).sqrt();
        let relaxes_s = if self.order > 0.0 && b > 0.0 {
            8.0 * libm::pow(b / k, self.order.recip())
        } else {
            0.0
        };
        let ticks = f64::max(swings_s, relaxes_s) / self.device.sample_time.0;
        let times = (whole / ticks.max(100.0)).clamp(3.0, 39.0) as u32;
        (whole / f64::from(times - 1 + times % 2)).ceil() as u32
    }

    /// The largest tap within these limits, N; 0 for none.
    pub fn force_n(&self, limits: &Limits) -> f32 {
        let ([k, b], m, mu) = (self.wall, self.device.mass.0, self.order);
        let (t, push_n) = (self.device.sample_time.0, self.push_n);
        let holds = k + b * libm::pow(f64::from(self.ticks()) * t, -mu);
        let damped = libm::pow(b / m, (2.0 - mu).max(0.1).recip());
        let swings = f64::max((k / m).sqrt(), damped).min(2.0 / t);
        let all = [
            limits.force_n,
            limits.workspace_high_m - limits.workspace_low_m,
            limits.speed_hard_m_per_s,
            limits.force_rate_n_per_s,
            // A larger step on a stiff wall could look like a sensor that is stuck.
            0.9 * limits.stuck_force_n,
        ];
        // 0 is no limit.
        let all = all.map(|most| {
            if most > 0.0 {
                most.into()
            } else {
                f64::INFINITY
            }
        });
        let [force_n, width_m, speed, rate, stuck_n] = all;
        let all = [
            0.75 * force_n,
            force_n - push_n,
            if self.lifts { 0.5 * push_n } else { stuck_n },
            0.5 * (0.4 * width_m * holds - push_n),
            0.5 * speed * m * swings,
            0.5 * rate / swings,
        ];
        all.into_iter().fold(stuck_n, f64::min).max(0.0) as f32
    }
}
