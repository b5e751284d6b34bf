//! An experiment file of any text: what is accepted can be run, what is refused is refused in one line.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_experiment::ExperimentFile;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    match ExperimentFile::parse(Path::new("lab/fuzz.toml"), text) {
        Ok(file) => {
            assert!(file.samples().is_ok(), "accepted, but cannot be run");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
            assert!(line.starts_with("lab/fuzz.toml:"), "{line:?}");
        }
    }
});
