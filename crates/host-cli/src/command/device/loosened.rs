//! Limits that became looser, in words: only `device set` can loosen one.

use haptic_link::{GuardKind, Limits};
use haptic_quantity::{digits, label, written};

/// The limits that are looser than before, a sentence each.
pub(super) fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    // 0 is no limit.
    let at_most = |value: f32| if value > 0.0 { value } else { f32::INFINITY };
    let numbers = [
        ("force_limit_n", before.force_n, after.force_n),
        (
            "force_rate_limit_n_per_s",
            before.force_rate_n_per_s,
            after.force_rate_n_per_s,
        ),
        (
            "start_force_n",
            at_most(before.start_force_n),
            at_most(after.start_force_n),
        ),
        (
            "speed_limit_m_per_s",
            at_most(before.speed_hard_m_per_s),
            at_most(after.speed_hard_m_per_s),
        ),
        ("stop_time_s", before.stop_time_s, after.stop_time_s),
        ("brake_force_n", before.brake_force_n, after.brake_force_n),
        (
            "stuck_force_n",
            at_most(before.stuck_force_n),
            at_most(after.stuck_force_n),
        ),
        ("stuck_time_s", before.stuck_time_s, after.stuck_time_s),
        ("jump_m", at_most(before.jump_m), at_most(after.jump_m)),
        (
            "watchdog_ms",
            before.watchdog_ms.into(),
            after.watchdog_ms.into(),
        ),
        (
            "late_ticks",
            at_most(before.late_ticks.into()),
            at_most(after.late_ticks.into()),
        ),
        (
            "max_age_ticks",
            before.max_age_ticks.into(),
            after.max_age_ticks.into(),
        ),
        // Turned round: a longer rise is the tighter one, and a faster estimate of the velocity.
        ("rise_time_s", -before.rise_time_s, -after.rise_time_s),
        (
            "velocity_bandwidth_hz",
            -before.velocity_bandwidth_hz,
            -after.velocity_bandwidth_hz,
        ),
    ];
    let in_words = |key, value: f32| match value.abs() {
        value if value.is_infinite() => "none".to_owned(),
        value => written(key, value.into()),
    };
    let mut words: Vec<String> = numbers
        .into_iter()
        .filter(|(_, before, after)| after > before)
        .map(|(key, before, after)| {
            let (before, after) = (in_words(key, before), in_words(key, after));
            format!("{} from {before} to {after}", label(key))
        })
        .collect();
    let (low, high) = (after.workspace_low_m, after.workspace_high_m);
    let had = before.workspace_low_m < before.workspace_high_m;
    if had && (low >= high || low < before.workspace_low_m || high > before.workspace_high_m) {
        let ends = |low: f32, high: f32| match low < high {
            true => format!(
                "{}:{} mm",
                digits(1e3 * f64::from(low), 4),
                digits(1e3 * f64::from(high), 4)
            ),
            false => "none".to_owned(),
        };
        let before = ends(before.workspace_low_m, before.workspace_high_m);
        words.push(format!("workspace from {before} to {}", ends(low, high)));
    }
    if before.guard.kind != GuardKind::Off && after.guard != before.guard {
        words.push(match after.guard.kind {
            GuardKind::Off => "the passivity guard is off".to_owned(),
            _ => "the passivity guard is another one".to_owned(),
        });
    }
    let braking = |limits: &Limits| limits.braking_n_s_per_m.to_bits();
    if before.braking_n_s_per_m > 0.0 && braking(after) != braking(before) {
        let [before, after] = [before, after].map(|limits| limits.braking_n_s_per_m);
        let [before, after] = [before, after].map(|b| written("braking_n_s_per_m", b.into()));
        words.push(format!("braking from {before} to {after}"));
    }
    words
}
