//! The three gains of given orders: crossover, margin and slope are three linear equations.

use super::open_loop::OpenLoop;
use crate::PidParameters;
use core::f64::consts::PI;
use nalgebra::{Matrix3, Vector3};
use num_complex::Complex;

/// The equations of a plant at its crossover.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equations {
    /// ln s, and its slope over ln ω.
    ln_s: Complex<f64>,
    slope_s: Complex<f64>,
    /// Of the plant, over ln ω, rad.
    phase_slope: f64,
    /// `C(s_c)` that crossover and margin ask for.
    target: Complex<f64>,
    /// Of the plant.
    sign: f64,
}

impl Equations {
    pub(super) fn new(open: &OpenLoop, phase_margin_rad: f64, sign: f64) -> Self {
        let (ln_s, slope_s, response, slope_plant) = open.crossover;
        Self {
            ln_s,
            slope_s,
            phase_slope: slope_plant.im,
            target: Complex::from_polar(1.0, phase_margin_rad - PI) / response,
            sign,
        }
    }

    /// `K_p`, `K_i` and `K_d` of these orders and this slope, of any sign.
    fn solved(&self, [lambda, mu, slope]: [f64; 3]) -> Option<Vector3<f64>> {
        let powers =
            [0.0, -lambda, mu].map(|order| (order, (self.ln_s * order).exp() / self.target));
        // Σ k·s^μ/R = 1,   Im(σ·Σ k·μ·s^μ/R) = ψ − Im(G′/G)
        let row = |value: &dyn Fn(f64, Complex<f64>) -> f64| {
            powers.map(|(order, power)| value(order, power))
        };
        let rows = [
            row(&|_, power| power.re),
            row(&|_, power| power.im),
            row(&|order, power| (power * self.slope_s * order).im),
        ];
        let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
        let wanted = Vector3::new(1.0, 0.0, slope - self.phase_slope);
        let gains = matrix.lu().solve(&wanted)?;
        gains.iter().all(|gain| gain.is_finite()).then_some(gains)
    }

    /// The three gains, if `K_p` and `K_i` have the sign of the plant. `K_d` may have any: a negative one of small order is a lag.
    pub(super) fn gains(&self, place: [f64; 3]) -> Option<PidParameters> {
        let gains = self.solved(place)?;
        let with_plant = gains[0] * self.sign >= 0.0 && gains[1] * self.sign >= 0.0;
        with_plant.then_some(PidParameters {
            proportional: gains[0],
            integral: gains[1],
            integral_order: place[0],
            derivative: gains[2],
            derivative_order: place[1],
        })
    }

    /// Between two neighbours of μ where both `K_p` and `K_i` change sign, both may have the right one, however near these places are:
    /// the middle of the two.
    pub(super) fn between(&self, lambda: f64, ends: [f64; 2], slope: f64) -> Option<[f64; 3]> {
        let zero = |gain: usize| {
            let at = |mu: f64| Some(self.solved([lambda, mu, slope])?[gain] > 0.0);
            let ([mut low, mut high], above) = (ends, at(ends[0])?);
            if at(high)? == above {
                return None;
            }
            while high - low > 1e-6 {
                let middle = 0.5 * (low + high);
                if at(middle)? == above {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            Some(low)
        };
        Some([lambda, 0.5 * (zero(0)? + zero(1)?), slope])
    }
}
