//! Tables as rheometers and testing machines write them, and tables that are wrong.

use haptic_tissue::identify::RecordKind;
use haptic_tissue::identify::table::{
    Choice, Column, Loading, Reader, Reading, Understood, read_table,
};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};

fn understand(text: &str, reader: &Reader, reading: &Reading) -> Result<Understood, String> {
    let table = read_table(text.as_bytes()).map_err(|error| error.to_string())?;
    let columns = reader.read(table).map_err(|error| error.to_string())?;
    columns.record(reading).map_err(|error| error.to_string())
}

fn plain(text: &str) -> Understood {
    understand(text, &Reader::default(), &Reading::default())
        .unwrap_or_else(|error| panic!("{text}\n{error}"))
}

#[test]
fn our_own_headers_need_no_word() {
    for (text, kind) in [
        (
            "time_s\trelaxation_modulus_pa\n1\t5\n2\t4\n",
            RecordKind::Relaxation,
        ),
        (
            "time_s,creep_compliance_per_pa\n1,4\n2,5\n",
            RecordKind::Creep,
        ),
        (
            "omega_rad_s,storage_modulus_pa,loss_modulus_pa\n2,5,1\n1,4,2\n",
            RecordKind::Oscillation,
        ),
        (
            "time_s,strain,stress_pa\n0,0,0\n1,0.1,4\n",
            RecordKind::History,
        ),
    ] {
        let understood = plain(text);
        assert_eq!(understood.record.kind(), kind, "{text}");
        assert_eq!(understood.notes.len(), 1, "{:?}", understood.notes);
        assert!(understood.notes[0].starts_with(&format!("kind {}, by the columns", kind.name())));
    }
}

#[test]
fn usual_spellings_and_units_of_other_programs_are_understood() {
    for (header, rows, x, first) in [
        ("Time [s]\tRelaxation Modulus [kPa]", "1\t5\n2\t4", 1.0, 5e3),
        ("t;G(t) / MPa", "1,5;5,25\n2;4", 1.5, 5.25e6),
        ("Time (ms),E(t) (Pa)", "1,5\n2,4", 1e-3, 5.0),
        ("Test Time in min,Modulus", "1,5\n2,4", 60.0, 5.0),
        (
            "elapsed_time_ms,relaxation_modulus_kpa",
            "1,5\n2,4",
            1e-3,
            5e3,
        ),
        ("Time,Creep Compliance (1/MPa)", "1,4\n2,5", 1.0, 4e-6),
        ("Time,Compliance [Pa⁻¹]", "1,4\n2,5", 1.0, 4.0),
        (
            "Angular Frequency (rad/s),Storage Modulus (kPa),Loss Modulus (kPa)",
            "1,4,1\n2,5,2",
            1.0,
            4e3,
        ),
        (
            "Frequency (Hz)\tG' (Pa)\tG'' (Pa)",
            "1\t4\t1\n2\t5\t2",
            std::f64::consts::TAU,
            4.0,
        ),
        ("ω [rad/s];E′ [MPa];E″ [MPa]", "1;4;1\n2;5;2", 1.0, 4e6),
        (
            "Angular Frequency,Storage Modulus,Loss Modulus\nrad/s,kPa,kPa",
            "1,4,1\n2,5,2",
            1.0,
            4e3,
        ),
    ] {
        let record = plain(&format!("{header}\n{rows}\n")).record;
        let near = |have: f64, want: f64| (have / want - 1.0).abs() < 1e-12;
        assert!(
            near(record.x()[0], x) && near(record.first()[0], first),
            "{header}: {record:?}"
        );
    }
}

#[test]
fn forces_and_positions_become_stresses_and_strains() {
    let loading = Loading {
        area_m2: Some(4e-4),
        thickness_m: Some(0.02),
        ..Loading::default()
    };
    let reading = Reading {
        kind: None,
        loading,
    };
    let text = "Time (s),Extension (mm),Load (N)\n0,0,0\n1,1,2\n2,1,1.5\n";
    let record = understand(text, &Reader::default(), &reading)
        .expect("valid")
        .record;
    assert_eq!(record.kind(), RecordKind::History);
    assert!((record.first()[1] - 0.05).abs() < 1e-15 && (record.second()[1] - 5000.0).abs() < 1e-9);
    // A held strain makes a relaxation of it.
    let held = Reading {
        kind: None,
        loading: Loading {
            strain: Some(0.05),
            area_m2: Some(4e-4),
            ..Loading::default()
        },
    };
    let record = understand("t,F (N)\n1,2\n2,1.5\n", &Reader::default(), &held)
        .expect("valid")
        .record;
    assert_eq!(record.kind(), RecordKind::Relaxation);
    assert!((record.first()[0] - 1e5).abs() < 1e-6);
}

#[test]
fn columns_units_and_range_can_be_given() {
    let reader = Reader {
        columns: vec![
            (Column::Time, Choice::Number(1)),
            (Column::Modulus, Choice::Name("Value".to_owned())),
        ],
        units: vec![
            (Column::Time, "ms".to_owned()),
            (Column::Modulus, "kPa".to_owned()),
        ],
        from: Some(2e-3),
        to: None,
    };
    let text = "# made by hand\na,Value,Temperature\n0,9,20\n1,8,20\n\n2,7,20\n3,,20\n4,6,20\n";
    let understood = understand(text, &reader, &Reading::default()).expect("valid");
    assert_eq!(understood.record.x(), [2e-3, 4e-3]);
    assert_eq!(understood.record.first(), [7e3, 6e3]);
    let said = understood.notes.join("\n");
    assert!(
        said.contains("1 row left out, a cell without a number: line 7"),
        "{said}"
    );
    assert!(
        said.contains("2 rows left out, outside the range asked for: lines 3, 4"),
        "{said}"
    );
    // No header at all.
    let reader = Reader {
        columns: vec![
            (Column::Time, Choice::Number(1)),
            (Column::Modulus, Choice::Number(2)),
        ],
        ..Reader::default()
    };
    assert_eq!(
        understand("1,8\n2,7\n", &reader, &Reading::default())
            .expect("valid")
            .record
            .samples(),
        2
    );
}

#[test]
fn columns_that_are_named_are_those_that_count() {
    // A machine writes its own modulus beside the stress, whose strain it does not know.
    let text = "time_s,relaxation_modulus_pa,stress_pa,strain,creep_compliance_per_pa\n1,7,10,0.1,9\n2,6,8,0.1,10\n";
    let read = |named: &[Column], kind| {
        let places = [
            Column::Time,
            Column::Modulus,
            Column::Stress,
            Column::Strain,
        ];
        let place = |column: &Column| places.iter().position(|place| place == column);
        let number = |column| Choice::Number(place(column).expect("a column of the table") + 1);
        let reader = Reader {
            columns: named
                .iter()
                .map(|column| (*column, number(column)))
                .collect(),
            ..Reader::default()
        };
        let kind = Some(kind);
        understand(
            text,
            &reader,
            &Reading {
                kind,
                ..Reading::default()
            },
        )
    };
    let first = |named: &[Column], kind| read(named, kind).map(|it| it.record.first().to_vec());
    let (relaxation, creep) = (RecordKind::Relaxation, RecordKind::Creep);
    assert_eq!(first(&[], relaxation).expect("valid"), [7.0, 6.0]);
    assert_eq!(
        first(&[Column::Stress], relaxation).expect("valid"),
        [100.0, 80.0]
    );
    assert_eq!(
        first(&[Column::Modulus], relaxation).expect("valid"),
        [7.0, 6.0]
    );
    for (named, kind) in [
        (&[Column::Modulus, Column::Stress][..], relaxation),
        (&[Column::Modulus], creep),
    ] {
        let refused = read(named, kind).expect_err("no effect");
        assert!(
            refused.contains("has no effect") && refused.contains(kind.name()),
            "{refused}"
        );
    }
}

/// A table, the kind of record that is asked for, and what the refusal says.
const REFUSED: &[(&str, Option<RecordKind>, &[&str])] = &[
    ("", None, &["empty"]),
    ("time_s\n1\n", None, &["line 1", "only one column"]),
    ("1,2\n3,4\n", None, &["line 1", "no header", "`columns`"]),
    (
        "time_s,relaxation_modulus_pa\n",
        None,
        &["no row with numbers"],
    ),
    (
        "time_s,relaxation_modulus_pa\n1,5\n2,four\n",
        None,
        &[
            "line 3, column relaxation_modulus_pa",
            "\"four\" is not a finite number",
        ],
    ),
    (
        "time_s,relaxation_modulus_pa\n1,5\n2,inf\n",
        None,
        &["line 3, column relaxation_modulus_pa", "\"inf\""],
    ),
    (
        "time_s,relaxation_modulus_pa\n0,5\n1,4\n",
        None,
        &["line 2", "time 0 s is not above 0 s", "omit the rows"],
    ),
    (
        "time_s,relaxation_modulus_pa\n2,5\n\n1,4\n",
        None,
        &["line 4", "time 1 s comes after 2 s", "sort"],
    ),
    (
        "time_s,relaxation_modulus_pa\n1,5\n2,-4\n",
        None,
        &["line 3", "modulus -4 Pa is not above 0 Pa"],
    ),
    (
        "time_s,relaxation_modulus_pa\n1,5\n2,5\n",
        None,
        &["5 Pa in every sample"],
    ),
    (
        "time_s,relaxation_modulus_pa\n1,4,5\n",
        None,
        &["line 2", "3 cells under a header of 2", "decimal commas"],
    ),
    (
        "Time [Pa],Modulus\n1,5\n",
        None,
        &[
            "line 1, column Time [Pa]",
            "unit \"Pa\" is none of time",
            "`units` time=s",
        ],
    ),
    (
        "time_s,t [s],modulus\n1,1,5\n",
        None,
        &["line 1", "both look like time", "`columns`"],
    ),
    (
        "time_s,stress_pa\n1,5\n2,4\n",
        None,
        &["stress_pa (stress)", "give `strain`"],
    ),
    ("time_s,strain\n1,5\n2,4\n", None, &["give `stress_pa`"]),
    (
        "time_s,temperature\n1,5\n2,4\n",
        None,
        &["the columns make no record", "relaxation_modulus_pa"],
    ),
    (
        "time_s,relaxation_modulus_pa\n1,5\n2,4\n",
        Some(RecordKind::Creep),
        &[
            "kind creep needs a column creep_compliance_per_pa",
            "`kind`",
        ],
    ),
    (
        "time_s,creep_compliance_per_pa\n1,5\n2,4\n",
        None,
        &["compliance falls with time", "`kind` = relaxation"],
    ),
    (
        "time_s,position_m,stress_pa\n0,0,5\n2,4,5\n",
        Some(RecordKind::History),
        &["needs a column strain", "`thickness_m`"],
    ),
    (
        "omega_rad_s,storage_modulus_pa,loss_modulus_pa\n2,1,1\n1,2,2\n2,3,3\n",
        None,
        &["line 4", "angular frequency 2 rad/s"],
    ),
];

#[test]
fn a_bad_table_is_refused_with_line_column_and_remedy() {
    for &(text, kind, wanted) in REFUSED {
        let reading = Reading {
            kind,
            ..Reading::default()
        };
        let message = understand(text, &Reader::default(), &reading).expect_err(text);
        for wanted in wanted {
            assert!(
                message.contains(wanted),
                "{text:?}\nhave {message}\nwant {wanted}"
            );
        }
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn what_is_no_text_and_a_unit_of_something_else_are_refused() {
    let latin = read_table(b"time_s,modulus\n1,5 \xb5Pa\n")
        .expect_err("not UTF-8")
        .to_string();
    assert!(
        latin.contains("line 2") && latin.contains("UTF-8"),
        "{latin}"
    );
    let unit = Reader {
        units: vec![(Column::Time, "kPa".to_owned())],
        ..Reader::default()
    };
    let message = understand("t,modulus\n1,5\n2,4\n", &unit, &Reading::default())
        .expect_err("a unit of pressure");
    assert!(
        message.contains("unit \"kPa\" is none of time"),
        "{message}"
    );
    let twice = Reader {
        units: vec![(Column::Modulus, "kPa".to_owned())],
        ..Reader::default()
    };
    let message = understand(
        "time_s,relaxation_modulus_pa\n1,5\n2,4\n",
        &twice,
        &Reading::default(),
    )
    .expect_err("two units");
    assert!(message.contains("names its own unit"), "{message}");
}

const LETTERS: &[u8] = b"0123456789.,;\t\n-eE\"#%[]()/x";

/// Whatever the bytes are, a table is read or refused in one line.
#[test]
fn damaged_tables_never_panic() {
    let tables = [
        "time_s\trelaxation_modulus_pa\n1\t5\n2\t4\n3\t3.5\n",
        "Frequency (Hz),G' (Pa),G'' (Pa)\n1,4,1\n2,5,2\n3,6,2.5\n",
        "Time [s];Strain [%];Stress [kPa]\n0;0;0\n0,5;1;2\n1;1;1,5\n",
    ];
    let mut generator = Pcg64::seed_from_u64(7);
    let mut below = |most: usize| (generator.next_u64() % most as u64) as usize;
    let (mut read, mut refused) = (0, 0);
    for case in 0..3000 {
        let mut bytes = tables[case % 3].as_bytes().to_vec();
        for _ in 0..=below(4) {
            let place = below(bytes.len());
            match below(3) {
                0 => bytes[place] = LETTERS[below(LETTERS.len())],
                1 => drop(bytes.remove(place)),
                _ => bytes.insert(place, below(256) as u8),
            }
        }
        let record = read_table(&bytes)
            .and_then(|table| Reader::default().read(table))
            .and_then(|columns| columns.record(&Reading::default()));
        match record {
            Ok(_) => read += 1,
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                assert!(
                    message.len() > 20 && !message.contains(char::is_control),
                    "{message:?}"
                );
            }
        }
    }
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );
}
