//! A span of a log as a log of its own.

use super::{TICK_S, log_of, tick};
use haptic_log::record::{
    CUT, NewFileError, RecordError, RollingLog, Span, SpanError, cut, inspect,
};
use haptic_message::EventMessage;
use testkit::{Folder, Tested};

const TICKS: u64 = 1000;

#[test]
fn each_span_has_the_ticks_between_its_times_and_no_others() {
    let folder = Folder::empty();
    let (log, part) = (folder.join("a.mcap"), folder.join("b.mcap"));
    log_of(&log, (0..TICKS).map(tick));
    for (from, to) in [(0, 1), (0, TICKS - 1), (17, 18), (333, 700), (998, 999)] {
        let times = [from, to].map(|n| tick(n).time_s);
        let span = Span {
            from_s: times[0],
            to_s: times[1],
        };
        let times = times.map(Some);
        let made = cut(&log, &part, span, true).expect("cuts");
        let want = (to - from + 1, times[0], times[1], true);
        assert_eq!(
            (made.samples, made.first_s, made.last_s, made.complete),
            want
        );
        let found = inspect(&part).expect("reads");
        assert_eq!(
            (found.samples, found.first_s, found.last_s),
            (want.0, want.1, want.2)
        );
        assert_eq!((found.missing_samples, found.complete), (0, true));
        assert!(found.metadata.iter().any(|record| record.name == CUT));
    }
}

#[test]
fn a_span_that_is_not_in_the_log_leaves_nothing() {
    let folder = Folder::empty();
    let (log, part) = (folder.join("a.mcap"), folder.join("b.mcap"));
    log_of(&log, (5..TICKS).map(tick));
    let last_s = tick(TICKS - 1).time_s;
    let between = (10.2 * TICK_S, 10.4 * TICK_S);
    for (from_s, to_s, key) in [
        (0.0, last_s, "from_s"),
        (5.0 * TICK_S, 2.0 * last_s, "to_s"),
        (20.0 * TICK_S, 10.0 * TICK_S, "to_s"),
        (f64::NEG_INFINITY, 0.0, "to_s"),
        (f64::NAN, last_s, ""),
        (between.0, between.1, ""),
    ] {
        let span = Span { from_s, to_s };
        let error = cut(&log, &part, span, false).expect_err("refuses");
        if let RecordError::Span(SpanError::Outside { key: found, .. }) = error {
            assert_eq!(found, key);
        } else {
            let is_bare = matches!(error, RecordError::Span(SpanError::Bare));
            assert!(is_bare && key.is_empty(), "{error}");
        }
        assert_eq!(folder.read_dir().expect("lists").count(), 1);
    }
    let span = Span {
        from_s: 0.1,
        ..Span::WHOLE
    };
    cut(&log, &part, span, false).expect("cuts");
    let again = cut(&log, &part, span, false).expect_err("is there");
    assert!(
        matches!(again, RecordError::File(NewFileError::Exists(_))),
        "{again}"
    );
}

#[test]
fn a_rolled_log_is_cut_across_its_files() -> Tested {
    let folder = Folder::empty();
    let (log, part) = (folder.join("a.mcap"), folder.join("b.mcap"));
    let mut writer = RollingLog::create(&log, [].into(), false)?;
    writer.roll_at(1);
    // Ten are missing.
    for n in (0..40 * TICKS).filter(|n| n / 10 != 1234) {
        if n % TICKS == 0 {
            let time_s = tick(n).time_s;
            let (kind, text) = ("mark".to_owned(), String::new());
            writer.event(&EventMessage { time_s, kind, text })?;
        }
        writer.tick(&tick(n))?;
    }
    assert!(writer.finish()?.paths.len() > 1);
    let [from_s, to_s] = [5 * TICKS, 35 * TICKS].map(|n| tick(n).time_s);
    let span = Span { from_s, to_s };
    let made = cut(&log, &part, span, false)?;
    assert_eq!((made.samples, made.events), (30 * TICKS - 9, 31));
    assert_eq!((made.gaps[0].missing, made.complete), (10, false));
    let found = inspect(&part)?;
    assert_eq!((found.missing_samples, found.complete), (10, true));
    Ok(())
}
