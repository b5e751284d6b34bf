//! What a run asks of the pre-flight before a device is armed, and what it answers.

mod llewellyn;
mod verdict;

use crate::document::failure::Failure;
use haptic_analysis::Dynamics;
pub use llewellyn::CouplerVerdict;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Duration;
pub use verdict::PreflightVerdict;

/// Time over which the round trip is measured.
pub(crate) const MEASURED: Duration = Duration::from_millis(200);

/// Request for the pre-flight, and the known dynamics of the device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreflightRequest {
    /// Run what is unstable, too.
    pub force_unstable: bool,
    /// Known dynamics of a device at a port.
    pub dynamics: Option<Dynamics>,
}

/// Whole samples of delay for a round trip, µs: it, and the tick that the force waits for, rounded up.
#[must_use]
pub(crate) fn delay_samples(round_trip_us: u64, sample_time_s: f64) -> usize {
    (1e-6 * round_trip_us as f64 / sample_time_s + 1.0).ceil() as usize
}

/// A loop that the analysis can look at.
pub(crate) trait PreflightSubject {
    /// Looks at the loop with this device and `line` samples of delay beside its own.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure>;
}

/// Adds findings to the metadata of a log, each by its key of reports behind `prefix` and a point.
pub(crate) fn note_findings(
    metadata: &mut BTreeMap<String, String>,
    prefix: &str,
    findings: &impl Serialize,
) {
    fn entry(metadata: &mut BTreeMap<String, String>, key: &str, value: &Value) {
        let text = match value {
            Value::Object(inner) => {
                for (name, value) in inner {
                    entry(metadata, &format!("{key}.{name}"), value);
                }
                return;
            }
            Value::Null => "none".to_owned(),
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN).to_string(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        metadata.insert(key.to_owned(), text);
    }
    // A structure of numbers and words always becomes JSON.
    let findings = serde_json::to_value(findings).unwrap_or_default();
    entry(metadata, prefix, &findings);
}
