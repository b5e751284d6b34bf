//! Sheets of a workbook that `tests/golden/make_workbook.py` made, and files that only look like one.

use measured_table::{Reader, read_record, read_table};

const GEL: &[u8] = include_bytes!("../golden/gel.xlsx");

#[test]
fn sheets_are_tables_of_one_file() {
    let table = read_table(GEL).expect("a workbook");
    let reader = Reader::default();
    let segments = reader.segments(&table).expect("segments");
    // The rows of the first sheet are its lines, those of the second follow.
    let lines = segments.iter().map(|one| (&*one.name, one.lines));
    let lines: Vec<_> = lines.collect();
    assert_eq!(lines, [("lines 5 to 8", [5, 8]), ("sheet Clock", [12, 15])]);
    let reader = Reader {
        segments: vec!["1".to_owned()],
        ..reader
    };
    let read = reader.read(table).expect("a record");
    assert_eq!(read.values[0].2, [0.5, 1.0, 2.0, 4.0]);
    assert_eq!(read.values[1].2, [4000.0, 2500.0, 1250.0, 1000.0]);
    assert!(
        read.notes[0].contains("Sample: gel of today"),
        "{:?}",
        read.notes
    );
}

#[test]
fn dates_times_and_durations_are_clocks() {
    for clock in ["time of day", "date", "elapsed"] {
        let found = read_record(GEL, [clock, "force"]).expect(clock);
        assert_eq!(
            found.columns,
            [vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 0.25, 0.5, 0.75]],
            "{clock}"
        );
    }
}

#[test]
fn what_only_looks_like_a_workbook_is_refused() {
    for (bytes, why) in [
        (&GEL[..2000], "no workbook that can be read"),
        (b"PK\x03\x04", "no workbook that can be read"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1", "before 2007: save it as XLSX"),
    ] {
        let error = read_table(bytes).expect_err(why).to_string();
        assert!(error.contains(why) && !error.contains('\n'), "{error}");
    }
    // Cut or turned anywhere, it is read or refused.
    for n in 0..GEL.len() / 7 {
        let mut bytes = GEL.to_vec();
        bytes[7 * n] ^= 0x55;
        let _ = read_table(&bytes);
        let _ = read_table(&GEL[..7 * n]);
    }
}
