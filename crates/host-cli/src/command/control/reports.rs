//! What several reports of loops have in common.

use fractional_control::{Crossing, Margins, PidParameters, Shape};
use serde::Serialize;

/// Margins and peaks.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct MarginReport {
    pub(super) crossover_rad_s: Option<f64>,
    pub(super) crossovers: usize,
    pub(super) phase_margin_deg: Option<f64>,
    pub(super) gain_up: Option<f64>,
    pub(super) gain_up_rad_s: Option<f64>,
    pub(super) gain_down: Option<f64>,
    pub(super) gain_down_rad_s: Option<f64>,
    pub(super) delay_margin_s: Option<f64>,
    pub(super) sensitivity_peak: f64,
    pub(super) sensitivity_peak_rad_s: f64,
    pub(super) complementary_peak: f64,
    pub(super) complementary_peak_rad_s: f64,
}

impl From<&Margins> for MarginReport {
    fn from(margins: &Margins) -> Self {
        let value = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.value);
        let place = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.omega_rad_s);
        Self {
            crossover_rad_s: place(margins.phase),
            crossovers: margins.crossovers,
            phase_margin_deg: value(margins.phase).map(f64::to_degrees),
            gain_up: value(margins.gain_up),
            gain_up_rad_s: place(margins.gain_up),
            gain_down: value(margins.gain_down),
            gain_down_rad_s: place(margins.gain_down),
            delay_margin_s: value(margins.delay_s),
            sensitivity_peak: margins.sensitivity.value,
            sensitivity_peak_rad_s: margins.sensitivity.omega_rad_s,
            complementary_peak: margins.complementary.value,
            complementary_peak_rad_s: margins.complementary.omega_rad_s,
        }
    }
}

/// The shape of a step.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ShapeReport {
    pub(super) overshoot: f64,
    pub(super) rise_time_s: Option<f64>,
    pub(super) settling_time_s: Option<f64>,
    pub(super) final_error: f64,
}

impl ShapeReport {
    pub(super) fn new(shape: &Shape, sample_time_s: f64) -> Self {
        Self {
            overshoot: shape.overshoot,
            rise_time_s: shape.rise.map(|samples| samples * sample_time_s),
            settling_time_s: shape.settled.map(|samples| samples as f64 * sample_time_s),
            final_error: shape.final_error,
        }
    }
}

/// Parameters of a PI^λD^μ.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct PidReport {
    pub(super) proportional_gain: f64,
    pub(super) integral_gain_per_s_lambda: f64,
    pub(super) integral_order: f64,
    pub(super) derivative_gain_s_mu: f64,
    pub(super) derivative_order: f64,
}

impl From<PidParameters> for PidReport {
    fn from(own: PidParameters) -> Self {
        Self {
            proportional_gain: own.proportional,
            integral_gain_per_s_lambda: own.integral,
            integral_order: own.integral_order,
            derivative_gain_s_mu: own.derivative,
            derivative_order: own.derivative_order,
        }
    }
}
