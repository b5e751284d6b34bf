//! Limits that became looser, in words: only `device set` can loosen one.

use haptic_link::{GuardKind, Limits, Tighter};
use haptic_quantity::{digits, label, written};

/// The limits that are looser than before, a sentence each.
pub(super) fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    let (mut then, mut now) = (*before, *after);
    let numbers = Limits::TABLE.iter().filter_map(|limit| {
        let (before, after) = (*(limit.of)(&mut then), *(limit.of)(&mut now));
        let off = |value: f32| limit.tighter == Tighter::LessUnlessOff && value <= 0.0;
        let told = |value: f32| if off(value) { f32::INFINITY } else { value };
        (!limit.is_tight(after, before)).then(|| (limit.field.key(), told(before), told(after)))
    });
    // 0 is no limit.
    let at_most = |ticks: u16| {
        if ticks > 0 {
            ticks.into()
        } else {
            f32::INFINITY
        }
    };
    let of_run: [(_, f32, f32); 4] = [
        ("stuck_time_s", before.stuck_time_s, after.stuck_time_s),
        (
            "watchdog_ms",
            before.watchdog_ms.into(),
            after.watchdog_ms.into(),
        ),
        (
            "late_ticks",
            at_most(before.late_ticks),
            at_most(after.late_ticks),
        ),
        (
            "max_age_ticks",
            before.max_age_ticks.into(),
            after.max_age_ticks.into(),
        ),
    ];
    let of_run = of_run
        .into_iter()
        .filter(|(_, before, after)| after > before);
    let in_words = |key, value: f32| match value {
        value if value.is_infinite() => "none".to_owned(),
        value => written(key, value.into()),
    };
    let mut words: Vec<String> = numbers
        .chain(of_run)
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
