//! A table of any bytes: its column x is finite numbers, at least one, or the table is refused; as a time of a record too.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_tissue::identify::table::{read_record, read_signal};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match read_signal(bytes, "x") {
        Ok(signal) => {
            let times = signal.time_s.unwrap_or_else(|| signal.x.clone());
            assert!(!times.is_empty() && signal.lines.len() == times.len());
            let all = signal.x.iter().chain(&times);
            assert!(all.copied().all(f64::is_finite) && signal.x.len() == times.len());
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
        }
    }
    if let Ok(record) = read_record(bytes, ["x", "y"]) {
        assert!(record.columns[0].iter().all(|time| time.is_finite()));
    }
});
