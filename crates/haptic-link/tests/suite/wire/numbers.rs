//! What is counted and numbered: frames, requests, events; and the keys of the messages.

use haptic_link::{Keys, OutOfOrder, RequestTracker, SequenceTracker, Statistics};

#[test]
fn counters_that_went_round_or_back_give_a_number() {
    let before = Statistics {
        ticks: u32::MAX,
        lost: 7,
        ..Statistics::default()
    };
    let after = Statistics {
        ticks: 4,
        lost: 9,
        tick_cycles_max: 3,
        ..Statistics::default()
    };
    let since = after.since(&before);
    assert_eq!((since.ticks, since.lost, since.tick_cycles_max), (5, 2, 3));
    // A device that was reset in between.
    assert_eq!(before.since(&before), Statistics::default());
    assert_eq!(
        Statistics::default().since(&before).lost,
        7_u32.wrapping_neg()
    );
}

/// Four did not come, one came twice, one late.
const FOUR_LOST: OutOfOrder = OutOfOrder {
    lost: 4,
    duplicate: 1,
    late: 1,
};

#[test]
fn numbers_tell_lost_duplicate_and_late_frames() {
    let mut tracker = SequenceTracker::default();
    let new = [65_534, 65_535, 65_535, 1, 0, 5].map(|n| tracker.is_new(n));
    assert_eq!(new, [true, true, false, true, false, true]);
    assert_eq!(tracker.out_of_order(), FOUR_LOST);
    // One that has started anew is believed after eight frames in a row.
    for n in 0..8 {
        assert_eq!(tracker.is_new(60_000 + n), n == 7, "{n}");
    }
    tracker.restart();
    assert!(tracker.is_new(0));
}

#[test]
fn a_device_believes_no_request_that_comes_again() {
    let mut tracker = RequestTracker::default();
    let new = [u32::MAX - 1, u32::MAX, u32::MAX, 1, 0, 5].map(|n| tracker.is_new(n));
    assert_eq!(new, [true, true, false, true, false, true]);
    assert_eq!(tracker.out_of_order(), FOUR_LOST);
    // A capture of a whole minute at 1 kHz, in order, is late from its first frame to its last.
    assert!(tracker.is_new(70_000));
    assert!(!(5..=70_000).any(|n| tracker.is_new(n)));
    tracker.restart();
    assert!(tracker.is_new(5));
}

#[test]
fn keys_tell_which_message_is_unlike_and_outlive_a_new_one() {
    let mut keys = Keys::current();
    assert_eq!(keys.first_unlike(3), None);
    let distinct: std::collections::BTreeSet<u32> = keys
        .requests
        .iter()
        .chain(&keys.reports)
        .map(|key| key.0)
        .collect();
    assert_eq!(distinct.len(), keys.requests.len() + keys.reports.len());
    keys.requests
        .push(haptic_link::MessageKey(1))
        .expect("there is room");
    keys.reports
        .push(haptic_link::MessageKey(2))
        .expect("there is room");
    assert_eq!(keys.first_unlike(3), None, "a device with more messages");
    // As firmware of one axis tells them: enough for it, and not for a device of several.
    let mut of_one = Keys::current();
    of_one.requests.truncate(17);
    assert_eq!(
        (of_one.first_unlike(1), of_one.first_unlike(2)),
        (None, Some("workspace"))
    );
    keys.reports[5].0 ^= 1;
    assert_eq!(keys.first_unlike(1), Some("sample"));
    keys.requests.truncate(11);
    assert_eq!(keys.first_unlike(1), Some("force"));
}

#[test]
fn hands_with_another_coupler_have_another_digest() {
    let digest_of = haptic_link::hand_digest;
    let digest = digest_of(&[300.0, 10.0, 0.5], "full");
    assert_eq!(digest_of(&[300.0, 10.0, 0.5], "full"), digest);
    for (numbers, scheme) in [
        ([301.0, 10.0, 0.5], "full"),
        ([300.0, 11.0, 0.5], "full"),
        ([300.0, 10.0, 0.4], "full"),
        ([300.0, 10.0, 0.5], "grunwald:100"),
    ] {
        assert_ne!(digest_of(&numbers, scheme), digest, "{numbers:?} {scheme}");
    }
}

/// Whoever knows only the messages of before is told so by name of what it lacks, and is no stranger for it.
#[test]
fn a_device_of_before_controllers_or_surfaces_is_known_by_its_keys() {
    let mut keys = Keys::current();
    assert!(keys.has_controllers() && keys.has_surfaces());
    keys.reports.truncate(13);
    for (requests, axes) in [(18, 2), (17, 1)] {
        keys.requests.truncate(requests);
        assert_eq!(keys.first_unlike(axes), None);
        assert!(!keys.has_controllers() && !keys.has_surfaces());
    }
    // Another controller under the same number.
    let mut other = Keys::current();
    other.requests[19].0 ^= 1;
    assert!(!other.has_controllers());
    assert_eq!(other.first_unlike(3), None);
    // Controllers, but no surfaces; surfaces of another form.
    let mut other = Keys::current();
    other.requests[20].0 ^= 1;
    assert!(other.has_controllers() && !other.has_surfaces());
    other.requests.truncate(20);
    assert!(other.has_controllers() && !other.has_surfaces());
    assert_eq!(other.first_unlike(2), None);
}
