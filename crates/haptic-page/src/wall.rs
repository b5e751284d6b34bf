//! A wall on a device, judged and drawn: the map, the margins and the curves of *Design* and of *Is it safe?*.

use crate::Number;
use crate::runs::document;
use crate::scheme::judged_scheme;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{DAMPING, HAND_STIFFNESS};
use haptic_experiment::question::Question;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Points on the boundary of the map: few while a slider is dragged, all at rest. Each lies on the boundary, and with 500 a
/// chord leaves it by less than a pixel.
const POINTS: RangeInclusive<usize> = 16..=500;

/// A wall K + B·D^μ, and the device and operator that render it, by the keys of `analyze stability`.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct WallQuestion {
    /// White noise, rms: an encoder with steps q has q/√12.
    position_noise_m: Number,
    points: usize,
    /// Damping of the device alone, where that of the keys is with a hand.
    device_damping_n_s_per_m: Option<f64>,
    #[serde(flatten)]
    keys: Map<String, Value>,
}

impl WallQuestion {
    /// All that the panels show of it.
    ///
    /// # Errors
    /// What `analyze stability` refuses, more points than pixels, a ring that takes too long.
    pub(crate) fn answer(&self) -> Result<Value, Failure> {
        if !POINTS.contains(&self.points) {
            let (least, most, points) = (POINTS.start(), POINTS.end(), self.points);
            return Err(Failure::bad_input(format_args!(
                "`points` = {points} is not in [{least}, {most}]: {most} are finer than pixels"
            )));
        }
        if let Some(scheme) = self.keys.get("scheme").and_then(Value::as_str) {
            judged_scheme(scheme)?;
        }
        let question = Question::open(&document("analyze-stability", &self.keys)?)?;
        let mut judged = question.wall_map(self.points, self.position_noise_m.0)?;
        judged["hand"] = self.noticed().unwrap_or_else(|failure| {
            let reason = failure.to_string();
            json!({"reason": reason})
        });
        Ok(judged)
    }

    /// The largest difference from the best spring and damper for a hand, as `analyze difference` predicts it.
    fn noticed(&self) -> Result<Value, Failure> {
        let mut keys = self.keys.clone();
        // It is of the device that the hand moves.
        keys.remove(HAND_STIFFNESS.key);
        if let Some(damping) = self.device_damping_n_s_per_m {
            keys.insert(DAMPING.key.to_owned(), damping.into());
        }
        let question = Question::open(&document("analyze-difference", &keys)?)?;
        let never = Arc::default();
        let answer = json!(question.answer(&|_| (), &never, &|_| ())?);
        let mut found = answer["spring_and_damper"].clone();
        for best in [
            "best_stiffness_n_per_m",
            "best_damping_n_s_per_m",
            "best_stable",
        ] {
            found[best] = answer[best].clone();
        }
        Ok(found)
    }
}
