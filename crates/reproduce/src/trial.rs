//! The experiment of section 4.4 on a simulated device.

use super::Kind;
use haptic_experiment::Failure;
use haptic_experiment::question::{Answer, Question};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Lines of a document that make the ideal device a realistic one, with a delay and a current lag in ms.
pub(super) fn realistic(delay_ms: f64, lag_ms: f64) -> String {
    format!(
        "friction_n = 0.05\ndelay_s = {delay_ms}e-3\ncurrent_lag_s = {lag_ms}e-3\nencoder_resolution_m = 1e-6\n"
    )
}

/// The largest stable walls, as β and α, that the experiment of section 4.4 finds for each order on a simulated device.
pub(super) fn simulated(
    kind: Kind,
    device: &str,
    stop: &Arc<AtomicBool>,
) -> Result<Vec<Vec<(f64, f64)>>, Failure> {
    let document = format!(
        "[zwidth]\ncriterion = \"dissertation\"\nsample_time_s = 2e-3\none_sided = false\n{}{device}",
        kind.line()
    );
    let question = Question::parse(Path::new("reproduce"), &document)?;
    let Answer::ZWidth(report) = question.answer(&|_| {}, stop, &|_| {})? else {
        return Err(Failure::bad_input("not a Z-width"));
    };
    let boundaries = report.orders.iter().map(|order| &order.boundary);
    Ok(boundaries
        .map(|points| points.iter().map(|p| (p.beta, p.alpha)).collect())
        .collect())
}
