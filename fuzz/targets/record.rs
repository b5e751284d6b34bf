//! A table of a measured record of any bytes: what is accepted is a valid record, what is refused says so in one line.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use libfuzzer_sys::fuzz_target;
use measured_table::{Reader, read_table};
use tissue_identification::{IdentifyError, RecordKind, TableDetails};

fuzz_target!(|bytes: &[u8]| {
    let reader = Reader {
        segments: vec!["all".to_owned()],
        ..Reader::default()
    };
    let table = read_table(bytes);
    // What is listed is what is read.
    if let Ok(table) = &table
        && let (Ok(all), Ok(listed)) = (reader.read_all(table), reader.segments(table))
    {
        assert_eq!(all.len(), listed.len());
        for (columns, segment) in all.iter().zip(&listed) {
            assert!(columns.lines.len() <= segment.rows && segment.lines[0] <= segment.lines[1]);
            let length = columns.lines.len();
            assert!(columns.values.iter().all(|column| column.2.len() == length));
        }
    }
    let record = table
        .and_then(|table| Reader::default().read(table))
        .map_err(IdentifyError::from)
        .and_then(|columns| TableDetails::default().record(columns));
    match record {
        Ok(understood) => {
            let record = understood.record;
            assert_eq!(record.x().len(), record.first().len());
            let mut steps = record.x().windows(2);
            let is_history = record.kind() == RecordKind::History;
            // Times of a modulus or compliance may have been rounded to one.
            assert!(steps.all(|pair| pair[0] < pair[1] || (pair[0] == pair[1] && !is_history)));
            if !is_history {
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
