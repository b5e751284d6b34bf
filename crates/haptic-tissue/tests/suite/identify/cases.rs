//! Layouts from public bug reports: the same tissue comes out of each as out of its numbers alone.

use super::{candidate, one};
use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::identify::table::{Reader, Reading, read_table};
use std::path::PathBuf;
use testkit::{assert_close, assert_relative};

/// A file, segment, unit of the frequency, Pa·s^α and α of its spring-pot, and how many samples it has.
const CASES: &str = r"
    m1-sample-named-G.txt | - | - | 1164.23 | 0.2 | 20
    m2-compliance-line.txt | - | - | 1164.23 | 0.2 | 20
    m3-time-line.txt | - | - | 63.24555 | 0 | 40
    m4-two-times.csv | - | - | 5000 | 0.25 | 15
    m5-temperature-column.csv | - | - | 3158.1 | 0.25 | 15
    m6-stress-step.csv | - | - | 1089.12 | 0.2 | 20
    c06-rheocompass-two-intervals.csv | 1 | - | 5000 | 0.25 | 16
    c06-rheocompass-two-intervals.csv | 2 | - | 2500 | 0.25 | 16
    c08b-two-temperatures-logged-frequencies.csv | 25.0 | - | 5000 | 0.25 | 12
    c08b-two-temperatures-logged-frequencies.csv | 40.0 | - | 2000 | 0.25 | 12
    c27-rows-without-first-cell.txt | - | - | 5821 | 0.2 | 10
    c28-commented-header.tab | - | - | 63.24555 | 0 | 40
    c29-xy-lines-above.csv | - | - | 63.24555 | 0 | 40
    freq-per-second.csv | - | Hz | 5000 | 0.25 | 15
    freq-per-second.csv | - | rad/s | 7916 | 0.25 | 15
";

/// Files that are refused without a word, and what is said.
const ASKED: &str = r"
    c06-rheocompass-two-intervals.csv | 2 segments could be meant & `segment`
    c08b-two-temperatures-logged-frequencies.csv | 2 segments & 25.0 °C & 40.0 °C & `segment`
    freq-per-second.csv | Hz or rad/s & `units`
";

fn bytes(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases");
    std::fs::read(PathBuf::from(folder).join(name)).expect("a case")
}

/// Indentations are those of a sphere of 5 mm.
fn reading(name: &str) -> Reading {
    let is_pressed = ["m3", "c28", "c29"]
        .iter()
        .any(|start| name.starts_with(start));
    let sphere = Loading {
        radius_m: Some(5e-3),
        ..Loading::new(LoadingKind::Sphere)
    };
    Reading {
        loading: if is_pressed {
            sphere
        } else {
            Reading::default().loading
        },
        loading_is_told: is_pressed,
        ..Reading::default()
    }
}

#[test]
fn a_tissue_does_not_depend_on_the_layout_of_its_record() {
    for [name, segment, unit, viscosity, order, samples] in testkit::table(CASES) {
        let mut reader = Reader::default();
        if segment != "-" {
            reader.segments.push(segment);
        }
        if unit != "-" {
            let omega = haptic_tissue::identify::table::Column::Omega;
            reader.units.push((omega, unit));
        }
        let table = read_table(&bytes(&name)).expect(&name);
        let columns = reader.read(table).expect(&name);
        let record = columns.record(&reading(&name)).expect(&name).record;
        assert_eq!(record.samples().to_string(), samples, "{name}");
        let found = one(&record, candidate("spring-pot"));
        let number = |cell: &str| cell.parse().expect("a number");
        let values = found.fits[0].parameters.iter().map(|p| p.value);
        let values: Vec<f64> = values.collect();
        // The cases are written with six digits.
        assert_relative(&name, values[0], number(&viscosity), 1e-4);
        assert_close(&name, values[1], number(&order), 1e-4);
    }
}

#[test]
fn what_a_case_leaves_open_is_asked() {
    for [name, wanted] in testkit::table(ASKED) {
        let table = read_table(&bytes(&name)).expect(&name);
        let columns = Reader::default().read(table);
        let refused = columns.and_then(|columns| columns.record(&reading(&name)));
        let message = refused.expect_err(&name).to_string();
        for wanted in wanted.split(" & ") {
            assert!(message.contains(wanted), "{name}: {message}");
        }
    }
}

/// Public files with how many segments each has; the folder is not part of the repository.
#[test]
fn public_files_are_taken_apart() {
    let folders = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut folders = folders.map(|folder| folder.join("shared/data/public"));
    let Some(folder) = folders.find(|folder| folder.is_dir()) else {
        return testkit::skip("the folder of public records is not here");
    };
    for [name, segments, rows] in testkit::table(
        r"
        laponite-relaxation-600.csv | 1 | 26
        polyisoprene-13k-sweep.csv | 1 | 65
        polystyrene-creep-160C.csv | 1 | 3599
        polystyrene-sweep-160C.csv | 1 | 32
        pyvisco-relaxations-at-temperatures.csv | 21 | 10
        pyvisco-sweeps-at-temperatures.csv | 21 | 10
        softmech-curve.csv | 1 | 500
        afm-workshop.csv | 1 | 1015
        ta-ares-sweeps-at-temperatures.txt | 4 | 17
        ta-trios-several-techniques.txt | 2 | 29
        ",
    ) {
        let bytes = std::fs::read(folder.join(&name)).expect(&name);
        let table = read_table(&bytes).expect(&name);
        let found = Reader::default().segments(&table).expect(&name);
        assert_eq!(found.len().to_string(), segments, "{name}");
        assert_eq!(found[0].rows.to_string(), rows, "{name}");
    }
}
