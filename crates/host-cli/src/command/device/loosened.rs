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
        // Turned round: a longer rise is the tighter one.
        ("rise_time_s", -before.rise_time_s, -after.rise_time_s),
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
    if before.guard.kind != GuardKind::Off && after.guard.kind == GuardKind::Off {
        words.push("the passivity guard is off".to_owned());
    }
    words
}
