//! The status of the loop, as a page is told it.

use super::hub::Hub;
use super::live::Shown;
use crate::feel::{SAMPLE_TIME, locked};
use haptic_loop::Limiters;
use serde_json::{Value, json};

/// The status as this page is told it.
pub(super) fn status(hub: &Hub, page: u64, shown: &Shown) -> Value {
    let mut status = json!({
        "running": false,
        "armed": false,
        "paused": false,
        "stopped": false,
        "watching": hub.watching(),
        "controls": hub.has_controls(page),
        "samples_sent": shown.sent,
        "samples_missed": shown.missed,
    });
    if let Some((state, made, lost)) = hub.newest() {
        let limiters: Vec<usize> = (0..8)
            .filter(|bit| state.limiter & (1 << bit) != 0)
            .collect();
        let kept = locked(&hub.kept.pyramid).made();
        let loop_status = json!({
            "running": true,
            "tick": state.tick,
            "time_s": state.time_s,
            "sample_time_s": SAMPLE_TIME.0,
            "tick_p50_us": state.tick_p50_us,
            "tick_p999_us": state.tick_p999_us,
            "tick_max_us": state.tick_max_us,
            "late_p50_us": state.late_p50_us,
            "late_p999_us": state.late_p999_us,
            "late": state.late,
            "skipped": state.skipped,
            "lost": lost,
            "limiter": state.limiter,
            "limiters": limiters.iter().map(|&bit| Limiters::NAMES[bit]).collect::<Vec<_>>(),
            "fault": state.fault.map(|fault| fault.to_string()),
            "energy_j": state.energy_j,
            "position_m": state.position_m,
            "force_n": state.force_n,
            "armed": !state.stopping && state.fault.is_none(),
            "stopped": state.stopping,
            "paused": hub.feel().is_some_and(|feel| feel.is_paused()),
            "recording": state.recording,
            "recorded": state.recorded,
            "samples_made": made,
            "samples_kept": kept.saturating_sub(lost),
        });
        if let (Some(all), Value::Object(more)) = (status.as_object_mut(), loop_status) {
            all.extend(more);
        }
    }
    json!({"status": status})
}
