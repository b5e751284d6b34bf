//! Limits that became looser, in words: only `device set` can loosen one.

use haptic_link::{GuardKind, Limits};

/// The limits that are looser than before, a sentence each.
pub(super) fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    // 0 is no limit.
    let at_most = |value: f32| if value > 0.0 { value } else { f32::INFINITY };
    let numbers = [
        ("force limit", "N", before.force_n, after.force_n),
        (
            "force rate limit",
            "N/s",
            before.force_rate_n_per_s,
            after.force_rate_n_per_s,
        ),
        (
            "start force",
            "N",
            at_most(before.start_force_n),
            at_most(after.start_force_n),
        ),
        (
            "speed limit",
            "m/s",
            at_most(before.speed_hard_m_per_s),
            at_most(after.speed_hard_m_per_s),
        ),
        // Turned round: a longer rise is the tighter one.
        ("rise time", "s", -before.rise_time_s, -after.rise_time_s),
    ];
    let in_words = |value: f32, unit: &str| match value.abs() {
        value if value.is_infinite() => "none".to_owned(),
        value => format!("{value} {unit}"),
    };
    let mut words: Vec<String> = numbers
        .into_iter()
        .filter(|(_, _, before, after)| after > before)
        .map(|(name, unit, before, after)| {
            let (before, after) = (in_words(before, unit), in_words(after, unit));
            format!("{name} from {before} to {after}")
        })
        .collect();
    let (low, high) = (after.workspace_low_m, after.workspace_high_m);
    let had = before.workspace_low_m < before.workspace_high_m;
    if had && (low >= high || low < before.workspace_low_m || high > before.workspace_high_m) {
        words.push(format!(
            "workspace from {}:{} to {low}:{high} m, 0:0 being none",
            before.workspace_low_m, before.workspace_high_m
        ));
    }
    if before.guard.kind != GuardKind::Off && after.guard.kind == GuardKind::Off {
        words.push("the passivity guard is off".to_owned());
    }
    words
}
