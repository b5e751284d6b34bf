//! A table of a measured record of any bytes: what is accepted is a valid record, what is refused says so in one line.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_tissue::identify::RecordKind;
use haptic_tissue::identify::table::{Reader, Reading, read_table};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let record = read_table(bytes)
        .and_then(|table| Reader::default().read(table))
        .and_then(|columns| columns.record(&Reading::default()));
    match record {
        Ok(understood) => {
            let record = understood.record;
            assert_eq!(record.x().len(), record.first().len());
            assert!(record.x().windows(2).all(|pair| pair[0] < pair[1]));
            if record.kind() != RecordKind::History {
                let values = record.first().iter().chain(record.second());
                assert!(
                    values
                        .into_iter()
                        .all(|&value| value > 0.0 && value.is_finite())
                );
            }
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
        }
    }
});
