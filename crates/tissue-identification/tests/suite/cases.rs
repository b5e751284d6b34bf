//! Layouts from public bug reports: the same tissue comes out of each as out of its numbers alone.

use super::layouts::reader;
use super::{candidate, one, read_public, sphere, told, values};
use measured_table::{Reader, read_table};
use std::path::PathBuf;
use testkit::{assert_close, assert_refused, assert_relative, assert_says};
use tissue_identification::{ContactPoint, IdentifyError, TableDetails};

/// A file, the options that it needs, Pa·s^α and α of its spring-pot, and how many samples it has.
const CASES: &str = r"
    m1-sample-named-G.txt | - | 1164.23 | 0.2 | 20
    m2-compliance-line.txt | - | 1164.23 | 0.2 | 20
    m3-time-line.txt | - | 63.24555 | 0 | 40
    m4-two-times.csv | - | 5000 | 0.25 | 15
    m5-temperature-column.csv | - | 3158.1 | 0.25 | 15
    m6-stress-step.csv | - | 1089.12 | 0.2 | 20
    c06-rheocompass-two-intervals.csv | segment 1 | 5000 | 0.25 | 16
    c06-rheocompass-two-intervals.csv | segment 2 | 2500 | 0.25 | 16
    c08b-two-temperatures-logged-frequencies.csv | segment 25.0 | 5000 | 0.25 | 12
    c08b-two-temperatures-logged-frequencies.csv | segment 40.0 | 2000 | 0.25 | 12
    c27-rows-without-first-cell.txt | - | 5821 | 0.2 | 10
    c28-commented-header.tab | - | 63.24555 | 0 | 40
    c29-xy-lines-above.csv | - | 63.24555 | 0 | 40
    freq-per-second.csv | units omega=Hz | 5000 | 0.25 | 15
    freq-per-second.csv | units omega=rad/s | 7916 | 0.25 | 15
    phase-without-unit.csv | - | 5000 | 0.25 | 6
    phase-without-unit.csv | units phase=deg | 5000 | 0.25 | 6
    lines-of-pairs-above.txt | - | 3392 | 0 | 8
    units-row-shorter.txt | - | 5000 | 0.25 | 16
    units-row-shorter.txt | columns omega=4,storage=5,loss=6 | 5000 | 0.25 | 16
    strain-in-percent-unnamed.csv | units strain=% | 3000 | 0.2 | 171
    strain-in-percent-unnamed.csv | units strain=1 | 30 | 0.2 | 171
    gstar-and-phase.csv | - | 1123.16 | 0.25 | 4
    log-axes.csv | - | 3000 | 0.2 | 15
    log-axes.csv | columns time=1,modulus=2 | 3000 | 0.2 | 15
    r-write-table.txt | - | 734.57 | 0.2 | 5
    leading-tab.txt | columns omega=1,storage=4,loss=8 | 1082.2 | 0.25 | 3
    loss-and-tangent.csv | - | 1082.37 | 0.25 | 4
    two-moduli.csv | - | 1082.39 | 0.25 | 4
    storage-by-words.csv | - | 1215.5 | 0.25 | 4
    time-in-days.csv | - | 3000 | 0.2 | 26
    creep-equal-times.csv | - | 2000 | 0.4 | 23
    compliance-cm2-per-dyne.csv | - | 3000 | 0.2 | 26
";

/// Files that are refused without a word, and what is said.
const ASKED: &str = r"
    c06-rheocompass-two-intervals.csv | 2 segments could be meant & `segment`
    c08b-two-temperatures-logged-frequencies.csv | 2 segments & 25.0 °C & 40.0 °C & `segment`
    freq-per-second.csv | Hz or rad/s & `units`
    labels-above-pairs.csv | 2 segments could be meant & 600 & 1200 & `segment` & `columns`
    strain-in-percent-unnamed.csv | column Strain & up to 5 & `units` strain=% or strain=1
";

fn bytes(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases");
    std::fs::read(PathBuf::from(folder).join(name)).expect("a case")
}

/// Indentations are those of a sphere of 5 mm, or of 27.5 µm.
fn reading(name: &str) -> TableDetails {
    let is_small = name.starts_with("lines");
    let mut pressed = ["m3", "c28", "c29"].iter();
    let is_pressed = is_small || pressed.any(|start| name.starts_with(start));
    if is_pressed {
        told(sphere(if is_small { 27.5e-6 } else { 5e-3 }))
    } else {
        TableDetails::default()
    }
}

#[test]
fn a_tissue_does_not_depend_on_the_layout_of_its_record() {
    for [name, options, viscosity, order, samples] in testkit::table(CASES) {
        let reader = reader(&options);
        let table = read_table(&bytes(&name)).expect(&name);
        let columns = reader.read(table).expect(&name);
        let record = reading(&name).record(columns).expect(&name).record;
        assert_eq!(record.samples().to_string(), samples, "{name}");
        let found = one(&record, candidate("spring-pot"));
        let number = |cell: &str| cell.parse().expect("a number");
        let values = values(&found);
        // The cases are written with six digits.
        assert_relative(&name, values[0], number(&viscosity), 1e-4);
        assert_close(&name, values[1], number(&order), 1e-4);
    }
}

#[test]
fn what_a_case_leaves_open_is_asked() {
    for [name, wanted] in testkit::table(ASKED) {
        let table = read_table(&bytes(&name)).expect(&name);
        let columns = Reader::default().read(table).map_err(IdentifyError::from);
        let refused = columns.and_then(|columns| reading(&name).record(columns));
        assert_refused(refused, &wanted);
    }
}

/// Public files with how many segments each has; the folder is not part of the repository.
#[test]
fn public_files_are_taken_apart() {
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
        let Some([text]) = read_public([name.as_str()]) else {
            return;
        };
        let table = read_table(text.as_bytes()).expect(&name);
        let found = Reader::default().segments(&table).expect(&name);
        assert_eq!(found.len().to_string(), segments, "{name}");
        assert_eq!(found[0].rows.to_string(), rows, "{name}");
    }
}

/// Contacts to be found in a curve by separation, and in one with adhesion; V and order, place in mm, and what is said.
#[test]
fn a_contact_is_found_and_what_shrinks_is_left_out_aloud() {
    for [name, options, radius, viscosity, contact_mm, said] in testkit::table(
        r"
        afm-separation.txt | columns position=tipSampleSeparation,force=vDeflection,time=seriesTime | 5e-6 | 3000 | -0.01 | 25 samples with a depth below 0
        contact-with-retraction.csv | - | 5e-3 | 3003 | 0.1009 | the contact shrinks from 13 s on: 24 samples of 165 are left out
        ",
    ) {
        let number = |cell: &str| -> f64 { cell.parse().expect("a number") };
        let details = TableDetails {
            contact: ContactPoint::Fitted,
            ..told(sphere(number(&radius)))
        };
        let columns = reader(&options).read(read_table(&bytes(&name)).expect(&name));
        let record = details.record(columns.expect(&name)).expect(&name).record;
        let found = one(&record, candidate("spring-pot"));
        let values = &found.fits[0].parameters;
        assert_relative(&name, values[0].value, number(&viscosity), 5e-3);
        assert_close(&name, values[1].value, 0.2, 1e-3);
        assert_relative(
            &name,
            1e3 * found.placement[0].value,
            number(&contact_mm),
            1e-2,
        );
        assert_says(&super::said(&found), &said);
    }
}
