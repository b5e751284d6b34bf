//! Records that people had trouble with, with their right values. They are kept in `shared/data/cases` beside the repository.

use super::{one, sphere, told, values};
use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::ModelKind;
use measured_table::{Reader, read_table};
use testkit::{assert_refused, assert_relative, assert_says};
use tissue_identification::{RecordKind, TableDetails, Understood};

/// The record of these files, loaded so; none where they are not there.
fn read(names: &[&str], loading: Loading) -> Option<Understood> {
    read_as(names, &told(loading))
}

fn folder() -> Option<std::path::PathBuf> {
    let above = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut folders = above.map(|folder| folder.join("shared/data/cases/tissue"));
    let folder = folders.find(|folder| folder.is_dir());
    if folder.is_none() {
        testkit::skip("shared/data/cases is not beside the repository");
    }
    folder
}

fn read_as(names: &[&str], reading: &TableDetails) -> Option<Understood> {
    let folder = folder()?;
    let one = |name: &&str| {
        let bytes = std::fs::read(folder.join(name)).expect("a file");
        let columns = Reader::default().read(read_table(&bytes).expect(name));
        reading.record(columns.expect(name)).expect(name)
    };
    let all: Vec<Understood> = names.iter().map(one).collect();
    Some(Understood::together(all).expect("one tissue"))
}

/// Taken for a deep body it is 2551 Pa.
#[test]
fn a_thin_layer_that_slides_on_its_base_is_softer_than_it_seems() {
    let loading = Loading {
        thickness_m: Some(8e-6),
        ..sphere(5e-6)
    };
    let Some(layer) = read(&["layer-nu0.5-free.csv"], loading) else {
        return;
    };
    let found = one(&layer.record, ModelKind::Spring);
    assert_relative("E", values(&found)[0], 2000.0, 1e-3);
}

#[test]
fn equal_times_of_four_digits_are_no_error() {
    let Some(rounded) = read(&["m7-equal-times.csv"], Loading::new(LoadingKind::Shear)) else {
        return;
    };
    let found = one(&rounded.record, ModelKind::SpringPot);
    assert_eq!(found.fits[0].predicted.len(), 8);
    // ln G = ln V − α ln t − ln Γ(1 − α), by the straight line through the logarithms.
    assert_relative("order", values(&found)[1], 0.169_4, 1e-3);
}

/// Values of the spring-pot of a record, and what is said.
fn spring_pot(understood: &Understood) -> ([f64; 2], String) {
    let found = one(&understood.record, ModelKind::SpringPot);
    let message = [&understood.notes[..], &found.warnings].concat().join("\n");
    ([values(&found)[0], values(&found)[1]], message)
}

#[test]
fn creep_as_strain_and_stress_is_fitted_in_the_strain() {
    for kind in [None, Some(RecordKind::History), Some(RecordKind::Creep)] {
        let reading = TableDetails {
            kind,
            ..TableDetails::default()
        };
        let Some(creep) = read_as(&["creep-strain-stress.csv"], &reading) else {
            return;
        };
        let ([viscosity, order], message) = spring_pot(&creep);
        assert_relative("V", viscosity, 2000.0, 2e-3);
        assert_relative("order", order, 0.5, 2e-3);
        assert_says(&message, "the strain is fitted");
    }
}

#[test]
fn a_ramp_inside_a_relaxation_names_its_time() {
    let strain = TableDetails {
        strain: Some(0.05),
        ..TableDetails::default()
    };
    let Some(folder) = folder() else { return };
    let bytes = std::fs::read(folder.join("ramp-inside-relaxation.csv")).expect("a file");
    let columns = || Reader::default().read(read_table(&bytes).expect("a table"));
    assert_refused(
        strain.record(columns().expect("columns")),
        "give `ramp_time_s` = 1s,",
    );
    let ramp = TableDetails {
        ramp_time_s: Some(1.0),
        ..strain
    };
    let understood = ramp.record(columns().expect("columns")).expect("a ramp");
    let ([viscosity, order], _) = spring_pot(&understood);
    assert_relative("V", viscosity, 3000.0, 1e-3);
    assert_relative("order", order, 0.2, 1e-3);
}

#[test]
fn the_clock_of_a_whole_test_is_not_that_of_its_step() {
    let Some(late) = read(
        &["clock-begins-at-60s.csv"],
        Loading::new(LoadingKind::Shear),
    ) else {
        return;
    };
    let ([viscosity, order], message) = spring_pot(&late);
    assert_relative("V", viscosity, 3000.0, 1e-3);
    assert_relative("order", order, 0.2, 1e-3);
    assert_says(&message, "from 60 s of the clock on, 0.01 s before");
}
