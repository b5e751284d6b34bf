//! A wall on a device, judged and drawn: the map, the margins and the curves of *Design* and of *Is it safe?*.

use crate::Number;
use crate::runs::document;
use fracdiff::Scheme;
use haptic_experiment::Failure;
use haptic_experiment::question::Question;
use haptic_quantity::short;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Points on the boundary of the map: few while a slider is dragged, all at rest. Each lies on the boundary, and with 500 a
/// chord leaves it by less than a pixel.
const POINTS: RangeInclusive<usize> = 16..=500;
/// Longest ring buffer that is judged here: its characteristic polynomial has as many roots, and a minute would pass for ten thousand.
const RING_MOST: usize = 300;

/// A wall K + B·D^μ, and the device and operator that render it, by the keys of `analyze stability`.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct WallQuestion {
    /// White noise, rms: an encoder with steps q has q/√12.
    position_noise_m: Number,
    points: usize,
    #[serde(flatten)]
    keys: Map<String, Value>,
}

/// A scheme that is read, and judged within the time that a person waits for.
pub(crate) fn judged_scheme(text: &str) -> Result<Scheme, Failure> {
    let refused =
        |why: &dyn Display| Failure::bad_input(format_args!("`scheme` = {}: {why}", short(text)));
    let scheme: Scheme = short(text).parse().map_err(|error| refused(&error))?;
    if matches!(scheme, Scheme::Grunwald { length } if length > RING_MOST) {
        return Err(refused(&format_args!(
            "the page judges at most {RING_MOST} samples: use the command line for more"
        )));
    }
    Ok(scheme)
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
        question.wall_map(self.points, self.position_noise_m.0)
    }
}
