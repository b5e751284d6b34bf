//! A wall on a device, judged and drawn: the map, the margins and the curves of *Design* and of *Is it safe?*.

use crate::form::{Files, document};
use crate::scheme::judged_scheme;
use crate::words::Number;
use haptic_document::Failure;
use haptic_document::parameters::{DAMPING, HAND_STIFFNESS};
use haptic_question::analysis::{Analysis, tables};
use haptic_trial::device_table::with_devices;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;
use std::sync::atomic::AtomicBool;

/// Points on the boundary of the map: few while a slider is dragged, all at rest. Each lies on the boundary, and with 500 a
/// chord leaves it by less than a pixel.
const POINTS: RangeInclusive<usize> = 16..=500;

/// The analysis of this name, by the keys of a form.
fn analysis(
    kind: &'static str,
    keys: &Map<String, Value>,
    files: &Files,
) -> Result<Analysis, Failure> {
    let tables = tables(kind).unwrap_or_default();
    let document = document(kind, tables, keys, files)?;
    let parsed = document.parse()?;
    let (_, table, _) = parsed.one_of(&[kind], &[], "question", kind)?;
    let table = with_devices(table.with_keys(tables)?)?;
    let unknown = || Failure::bad_input(format_args!("{kind} is no analysis"));
    Analysis::read(kind, &table, files.read).ok_or_else(unknown)?
}

/// A wall K + B·D^μ, and the device and operator that render it, by the keys of `analyze stability`.
#[derive(Clone, Debug, Deserialize)]
pub struct WallQuestion {
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
    pub fn answer(&self, files: &Files) -> Result<Value, Failure> {
        if !POINTS.contains(&self.points) {
            let (least, most, points) = (POINTS.start(), POINTS.end(), self.points);
            return Err(Failure::bad_input(format_args!(
                "`points` = {points} is not in [{least}, {most}]: {most} are finer than pixels"
            )));
        }
        if let Some(scheme) = self.keys.get("scheme").and_then(Value::as_str) {
            judged_scheme(scheme)?;
        }
        let analysis = analysis("analyze-stability", &self.keys, files)?;
        let mut judged = analysis.wall_map(self.points, self.position_noise_m.0)?;
        judged["hand"] = self.noticed(files).unwrap_or_else(|failure| {
            let reason = failure.to_string();
            json!({"reason": reason})
        });
        Ok(judged)
    }

    /// The largest difference from the best spring and damper for a hand, as `analyze difference` predicts it.
    fn noticed(&self, files: &Files) -> Result<Value, Failure> {
        let mut keys = self.keys.clone();
        // It is of the device that the hand moves.
        keys.remove(HAND_STIFFNESS.key);
        if let Some(damping) = self.device_damping_n_s_per_m {
            keys.insert(DAMPING.key.to_owned(), damping.into());
        }
        let never = AtomicBool::new(false);
        let analysis = analysis("analyze-difference", &keys, files)?;
        let answer = json!(analysis.answer(&|_| (), &never, &|_| ())?);
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
