//! Shapes of tables: names of rows, and curves side by side.

use measured_table::{
    Choice, Column, Columns, Reader, TableError, read_record, read_response, read_table,
};

/// All segments, or one, with columns by name.
fn all(text: &str, columns: &[(Column, &str)], segment: &str) -> Result<Vec<Columns>, TableError> {
    let name = |place: &str| Choice::Name(place.to_owned());
    let reader = Reader {
        columns: columns.iter().map(|one| (one.0, name(one.1))).collect(),
        segments: segment.split_whitespace().map(str::to_owned).collect(),
        ..Reader::default()
    };
    reader.read_all(&read_table(text.as_bytes())?)
}

/// Tables whose rows have a name in front, as R writes them, and whether they are read; time 1, 3, 5 and modulus 9, 8, 7.
const NAMED: &str = r#"
read | "time_s" "modulus_pa"\n"1" 1 9\n"2" 3 8\n"3" 5 7
read | time_s\tmodulus_pa\n1\t1\t9\n2\t3\t8\n3\t5\t7
read | time_s\tmodulus_pa\n\t1\t9\n\t3\t8\n\t5\t7
read | time_s,modulus_pa\na,1,9\nb,3,8\nc,5,7
refused | time_s,modulus_pa\n1,1,9\n2,3,8\n3,5,7
refused | time_s modulus_pa\n2 1 9\n4 3 8\n6 5 7
"#;

#[test]
fn names_of_rows_are_no_column() {
    for row in NAMED.trim().lines() {
        let (verdict, text) = row.split_once(" | ").expect("a verdict");
        let text = text.replace("\\n", "\n").replace("\\t", "\t");
        let read = all(&text, &[], "");
        assert_eq!(read.is_ok(), verdict == "read", "{text}: {read:?}");
        for columns in read.into_iter().flatten() {
            assert_eq!(columns.values[0].2, [1.0, 3.0, 5.0], "{text}");
            assert_eq!(columns.values[1].2, [9.0, 8.0, 7.0], "{text}");
            let notes = columns.notes.concat();
            assert!(notes.contains("as their own name"), "{text}: {notes}");
        }
    }
}

#[test]
fn curves_side_by_side_are_segments() {
    let text = "600,,1200,\nX,Y,X,Y\n1,9,2,5\n3,8,4,6\n5,7,,\n";
    let chosen = [(Column::Time, "X"), (Column::Modulus, "Y")];
    for (segment, rows, last) in [("1200", 2, 6.0), ("2", 2, 6.0), ("600", 3, 7.0)] {
        let read = all(text, &chosen, segment).expect(segment);
        let moduli = &read[0].values[1].2;
        assert_eq!((moduli.len(), moduli[rows - 1]), (rows, last), "{segment}");
    }
    let asked = all(text, &chosen, "").expect_err("two").to_string();
    assert!(
        asked.contains("2 segments could be meant, 1 \"600, columns 1 to 2\""),
        "{asked}"
    );
    // Columns by name alone stay one table.
    let named = read_record(text.as_bytes(), ["", "X"]).expect_err("two names");
    assert!(
        named
            .to_string()
            .contains("more than one column is named X"),
        "{named}"
    );
}

#[test]
fn bad_rows_may_be_left_out_where_that_helps() {
    let message = |bad: &str| {
        let rows = (1..30).map(|n| format!("{n},{}\n", 90 - n));
        let text = format!("time_s,modulus_pa\n{}{bad}40,1\n", rows.collect::<String>());
        all(&text, &[], "").expect_err(bad).to_string()
    };
    assert!(message("30,x\n").ends_with("or omit the row, or give `skip_bad_rows`"));
    assert!(message("30,x\n31,x\n32,x\n33,x\n34,x\n").ends_with("or omit the row"));
}

#[test]
fn a_table_tells_what_each_column_is_taken_for() {
    // Column, unit, quantity, first value in SI units | other quantities | remark.
    const READ: &str = "\
        1 min Some(\"time\") Some(6.0) | |
        2 kPa Some(\"stress\") Some(1200.0) | modulus, storage, loss, complex-modulus |
        3 % Some(\"strain\") Some(0.05) | loss-tangent |
        4 s None None | time | time is column 1: give `columns` time=4 if it is this one
        5 - None None | | its cells are no numbers
        6 - None None | | its values tell segments apart
        7 - None None | | no quantity of a record has this name or unit
        8 mm None None | position | its name says nothing: name it by `columns`";
    const TABLE: &str = "step time (min);stress (kPa);strain (%);total time (s);operator;step;gain;gap (mm)\n\
                         0.1;1.2;5;3;ann;1;7;1\n1;0.8;5;60;ann;1;7;1\n10;0.5;5;600;ann;1;7;1\n";
    let table = read_table(TABLE.as_bytes()).expect("a table");
    let read = Reader::default().explained(&table);
    assert_eq!(read.len(), 8);
    for (one, row) in read.iter().zip(READ.lines()) {
        let row: Vec<&str> = row.split('|').map(str::trim).collect();
        let unit = one.unit.as_deref().unwrap_or("-");
        let could_be = one.could_be.clone().unwrap_or_default().join(", ");
        let head = format!(
            "{} {unit} {:?} {:?}",
            one.number, one.taken_for, one.first_value
        );
        assert_eq!([&head, &could_be], [row[0], row[1]]);
        let remark = one.remark.as_deref().unwrap_or_default();
        assert!(
            remark.starts_with(row[2]) && remark.is_empty() == row[2].is_empty(),
            "{remark}"
        );
    }
    // What cannot be read is told too.
    let table = read_table(b"a,b\n1,2\n3,4\n").expect("a table");
    let read = Reader::default().explained(&table);
    assert!(
        read.len() == 2 && read.iter().all(|one| one.taken_for.is_none()),
        "{read:?}"
    );
}

/// Names and units of machines, and what a 1 in each column is in SI.
const HEADERS: &str = r#"
Running Time;Axial Force\nSec;kN | time 1, force 1000
Segment;Displacement Into Surface;Load On Sample;Time On Sample\n;nm;mN;s | position 1e-9, force 1e-3, time 1
Frequency(rad/s);Elastic shear modulus(kPa);Viscous shear modulus(kPa) | omega 1, storage 1e3, loss 1e3
Time: min;Modul kPa | time 60, modulus 1e3
Zeit (min);Modul (Pa) | time 60, modulus 1
"#;

/// Of responses, of a row 1, 20, 90, and the response.
const RESPONSES: &str = "
w (rad/s);Trace 1: Gain: Magnitude (dB);Trace 2: Gain: Phase (°) | 0 10
Frequency (rad/s);|Z|(data);theta-z(deg) | 0 20
omega (rad/s);Y' (S);Y'' (S) | 20 90
freq. /Hz;Z1 /mohm;Z2 /mohm | 0.02 0.09
";

#[test]
fn headers_of_machines_are_known() {
    for (header, columns) in HEADERS.lines().filter_map(|row| row.split_once(" | ")) {
        let header = header.replace("\\n", "\n");
        let row = header
            .split(['\n'])
            .next()
            .map(|names| names.replace(|c| c != ';', "").replace(';', ";1"));
        let row = format!("1{}\n", row.expect("names"));
        let read = all(&format!("{header}\n{}", row.repeat(3)), &[], "").expect(&header);
        let mut columns: Vec<&str> = columns.split(", ").collect();
        let values = read[0].values.iter();
        let mut have: Vec<String> = values
            .map(|(column, _, values)| format!("{} {}", column.name(), values[0]))
            .collect();
        columns.sort_unstable();
        have.sort_unstable();
        let plain = |text: &str| -> f64 {
            text.rsplit_once(' ')
                .expect("a size")
                .1
                .parse()
                .expect("a number")
        };
        for (have, want) in have.iter().zip(&columns) {
            assert!(
                have.split(' ').next() == want.split(' ').next()
                    && (plain(have) / plain(want) - 1.0).abs() < 1e-12,
                "{header}: {have}"
            );
        }
        assert_eq!(have.len(), columns.len(), "{header}: {have:?}");
    }
    for (header, want) in RESPONSES.lines().filter_map(|row| row.split_once(" | ")) {
        let table = format!("{header}\n1;20;90\n2;20;90\n3;20;90\n");
        let read = read_response(table.as_bytes(), &[]).expect(header);
        let want: Vec<f64> = want
            .split(' ')
            .map(|part| part.parse().expect("a part"))
            .collect();
        let off = (0..2).map(|n| (read.values[0][n] - want[n]).abs());
        assert!(
            off.fold(0.0, f64::max) < 1e-9,
            "{header}: {:?}",
            read.values[0]
        );
    }
}

/// Names of a column of errors behind `time_s` and a measured column, and the first error in SI units of a first value of 5; `-` if it is none.
const ERRORS: &str = "\
    modulus_pa | modulus_sd_pa | 2
    modulus_pa | modulus_std_kpa | 2000
    modulus_pa | modulus_pa_err | 2
    G(t) (kPa) | SD | 2000
    G(t) (kPa) | ± | 2000
    G(t) [kPa] | +/- [Pa] | 2
    G(t) [kPa] | Std. Dev. [kPa] | 2000
    G(t) (kPa) | G(t) (SD) | 2000
    G(t) (Pa) | u(G(t)) | 2
    G(t) (Pa) | G(t) (Pa) SEM | 2
    G(t) (Pa) | error (%) | 0.1
    relaxation modulus / MPa | Standard deviation of relaxation modulus / MPa | 2000000
    Creep compliance (1/kPa) | uncertainty of creep compliance (1/MPa) | 0.000002
    compliance_per_pa | compliance_stderr_per_kpa | 0.002
    Spannung (kPa) | Standardabweichung Spannung (kPa) | 2000
    stress (kPa) | σ(stress) | 2000
    strain (%) | strain std (%) | 0.02
    log10 G(t) (Pa) | sd | 460517.0186
    modulus_pa | gain | -
    modulus_pa | force_sd_n | -
    modulus_pa | SD (mm) | -
    modulus_pa | Standardkraft (N) | -";

#[test]
fn errors_are_found_by_name_or_beside_their_column() {
    for row in ERRORS.lines() {
        let row: Vec<&str> = row.trim().split(" | ").collect();
        let [column, errors, size] = row[..] else {
            panic!("{row:?}")
        };
        let text = format!("time_s;{column};{errors};note\n1;5;2;9\n2;4;1;9\n3;3;1;9\n");
        let read = all(&text, &[], "").expect(&text).remove(0);
        let first = read.errors.first().map(|errors| errors.2[0]);
        let wanted: Option<f64> = size.parse().ok();
        let is_near = |(a, b): (f64, f64)| (a / b - 1.0).abs() < 1e-9;
        assert_eq!(first.is_some(), wanted.is_some(), "{text}: {first:?}");
        assert!(first.zip(wanted).is_none_or(is_near), "{text}: {first:?}");
        let explained = Reader::default().explained(&read_table(text.as_bytes()).expect("a table"));
        let taken = explained[2].taken_for.as_deref().unwrap_or("-");
        assert_eq!(
            taken.starts_with("error of "),
            wanted.is_some(),
            "{text}: {taken}"
        );
        assert_eq!(
            explained[2].first_value.filter(|_| wanted.is_some()),
            first,
            "{text}"
        );
    }
    // Columns that a user named have theirs too; of two the first counts, and a row without an error is left out.
    let text = "X;Y;Y SD;Y SEM\n1;9;2;1\n2;8;;1\n3;7;1;1\n4;6;3;1\n";
    let chosen = [(Column::Time, "X"), (Column::Modulus, "Y")];
    let read = all(text, &chosen, "").expect("a segment").remove(0);
    let (column, name, errors) = &read.errors[0];
    assert_eq!(
        (*column, &name[..], &errors[..]),
        (Column::Modulus, "Y SD", &[2.0, 1.0, 3.0][..])
    );
    assert_eq!(read.values[1].2, [9.0, 7.0, 6.0]);
}
