//! A table of any bytes: its column x is finite numbers, at least one, or the table is refused; as a time of a record too.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use libfuzzer_sys::fuzz_target;
use measured_table::read_record;

fuzz_target!(|bytes: &[u8]| {
    match read_record(bytes, ["time_s", "x"]) {
        Ok(record) => {
            let [times, x] = &record.columns;
            assert!(!x.is_empty() && record.lines.len() == x.len());
            assert!(times.iter().all(|time| time.is_finite()));
            assert!(times.is_empty() || times.len() == x.len());
            assert!(record.gaps().is_some() || x.iter().all(|x| x.is_finite()));
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
        }
    }
    if let Ok(record) = read_record(bytes, ["x", "y"]) {
        assert!(record.columns[0].iter().all(|time| time.is_finite()));
    }
});
