//! A run log of any bytes: read, inspected, exported, recovered. What is recovered is a whole log with as many
//! samples as were readable.
#![no_main]
#![forbid(unsafe_code)]

use haptic_log::record::{Entry, LogReader, RecordError, export_csv, inspect, recover};
use libfuzzer_sys::fuzz_target;
use std::io::Cursor;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Ok(mut reader) = LogReader::new(Cursor::new(bytes), Path::new("fuzz")) else {
        return;
    };
    let mut ticks = 0;
    for entry in &mut reader {
        if let Entry::Tick(_) = entry.expect("memory does not fail") {
            ticks += 1;
        }
    }
    let condition = reader.condition();
    assert!(!condition.complete || condition.damage.is_empty());
    // Files cost far more than reading: only for logs with something in them.
    if ticks == 0 {
        return;
    }
    let folder = tempfile::tempdir().expect("there is room for files");
    let source = folder.path().join("a.mcap");
    std::fs::write(&source, bytes).expect("there is room");
    let summary = inspect(&source).expect("it was read above");
    assert_eq!(summary.samples, ticks);
    let table = export_csv(&source, &folder.path().join("a.csv"), false).expect("there is room");
    assert_eq!(table.rows, ticks);
    let target = folder.path().join("b.mcap");
    match recover(&source, &target, false) {
        Ok(recovered) => {
            assert_eq!(recovered.samples, ticks);
            let again = inspect(&target).expect("a recovered log can be read");
            assert!(again.complete, "{:?}", again.damage);
            assert_eq!(again.samples, ticks);
        }
        // A time that no log can hold.
        Err(RecordError::Time { .. }) => {}
        Err(error) => panic!("{error}"),
    }
});
