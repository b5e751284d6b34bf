//! A table of any bytes: its column x is finite numbers, at least one, or the table is refused.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use host_cli::column;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match column::read(bytes, "fuzz", "x") {
        Ok(numbers) => {
            assert!(!numbers.is_empty());
            assert!(numbers.iter().all(|value| value.is_finite()));
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
        }
    }
});
