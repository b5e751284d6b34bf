//! A wall, judged: stable by how much, passive by how much, and in one sentence.

use fracdiff::Seconds;
use haptic_analysis::{AnalysisError, Dynamics, Environment, LoopOperator};
use wasm_bindgen::prelude::*;

/// A wall on a device, judged. Margins that do not exist are left out.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Judgement {
    /// Is the sampled loop stable?
    pub stable: bool,
    /// Factor above 1 on the whole wall that takes a stable loop to its edge.
    pub gain_margin: Option<f64>,
    /// Factor below 1 that does.
    pub gain_margin_down: Option<f64>,
    /// Factor up to which contact that may pull, acts on one side or stiffens is proved stable for every motion.
    pub every_motion_margin: Option<f64>,
    /// Additional delay that does, s.
    pub delay_margin_s: Option<f64>,
    /// Largest sensitivity of a stable loop.
    pub sensitivity: Option<f64>,
    /// Frequency of it, Hz.
    pub sensitivity_hz: Option<f64>,
    /// Damping of the device that passivity asks for, N·s/m.
    pub required_damping_n_s_per_m: f64,
    /// Force noise, rms N.
    pub force_noise_n: f64,
    sentence: String,
}

#[wasm_bindgen]
impl Judgement {
    /// The verdict in a sentence.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn sentence(&self) -> String {
        self.sentence.clone()
    }
}

impl Judgement {
    pub(crate) fn of(
        dynamics: &Dynamics,
        wall: &Environment,
        operator: &LoopOperator,
        force_noise_n: f64,
    ) -> Result<Self, AnalysisError> {
        let t = wall.sample_time_s;
        // Without any spring the device only drifts.
        let closed = dynamics.closed(wall, operator)?.beside_rest();
        let proved = closed.slope_limit().proved;
        let margins = closed.is_stable().then(|| closed.margins()).transpose()?;
        let required = dynamics.port(t, operator)?.required_damping(
            Seconds(t),
            wall.stiffness_n_per_m,
            wall.dissipation_n_s_mu_per_m,
        )?;
        let mut judgement = Self {
            stable: margins.is_some(),
            gain_margin: margins.and_then(|m| m.gain_up).map(|gain| gain.value),
            gain_margin_down: margins.and_then(|m| m.gain_down).map(|gain| gain.value),
            every_motion_margin: (proved > 0.0).then_some(proved),
            delay_margin_s: margins.and_then(|m| m.delay).map(|delay| delay.value * t),
            sensitivity: margins.map(|m| m.sensitivity.value),
            sensitivity_hz: margins.map(|m| m.sensitivity.theta / (2.0 * std::f64::consts::PI * t)),
            required_damping_n_s_per_m: required.damping_n_s_per_m,
            force_noise_n,
            sentence: String::new(),
        };
        judgement.sentence = judgement.say(
            required.passive(dynamics.damping_n_s_per_m),
            required.negative_at_rest,
        );
        Ok(judgement)
    }

    /// Passive by Theorem 1, or not; a wall that pulls at rest no damping makes passive.
    fn say(&self, passive: bool, negative_at_rest: bool) -> String {
        let stable = match (self.stable, self.gain_margin) {
            (false, _) => "unstable".to_owned(),
            (true, Some(gain)) => format!("stable, gain margin {}", rounded(gain)),
            (true, None) => "stable at any gain".to_owned(),
        };
        let passive = if passive {
            "passive".to_owned()
        } else if negative_at_rest {
            "not passive: it pulls at rest".to_owned()
        } else {
            let least = rounded(self.required_damping_n_s_per_m);
            format!("not passive: that takes a damping of {least} N·s/m")
        };
        format!("{stable} · {passive}")
    }
}

/// Three significant digits.
fn rounded(value: f64) -> String {
    let size = value.abs();
    let digits = match size {
        _ if size >= 100.0 => 0,
        _ if size >= 10.0 => 1,
        _ if size >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.digits$}")
}
