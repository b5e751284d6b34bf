//! A table of any bytes: its column x is finite numbers, at least one, or the table is refused; as a time of a record too.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_tissue::identify::table::{read_columns, read_record};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match read_columns(bytes, ["x"]) {
        Ok((lines, [numbers])) => {
            assert!(!numbers.is_empty() && lines.len() == numbers.len());
            assert!(numbers.iter().all(|value| value.is_finite()));
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
        }
    }
    if let Ok(record) = read_record(bytes, ["x", "y"]) {
        assert!(record.columns[0].iter().all(|time| time.is_finite()));
    }
});
