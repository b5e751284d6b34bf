//! Records that people had trouble with, with their right values. They are kept in `shared/data/cases` beside the repository.

use super::fit;
use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::ModelKind;
use measured_table::{Reader, read_table};
use testkit::{assert_refused, assert_relative, assert_says};
use tissue_identification::{Identification, Options, RecordKind, TableDetails, Understood};

/// The record of these files, loaded so; none where they are not there.
fn read(names: &[&str], loading: Loading) -> Option<Understood> {
    let reading = TableDetails {
        loading,
        loading_is_told: true,
        ..TableDetails::default()
    };
    read_as(names, &reading)
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

fn fitted(understood: &Understood, candidates: &[ModelKind], stiffening: bool) -> Identification {
    let options = Options {
        candidates: candidates.to_vec(),
        stiffening,
        ..Options::default()
    };
    fit(&understood.record, &options)
}

fn sphere(radius_m: f64, thickness_m: Option<f64>) -> Loading {
    Loading {
        radius_m: Some(radius_m),
        thickness_m,
        ..Loading::new(LoadingKind::Sphere)
    }
}

/// V = Σεσ/Σε².
#[test]
fn a_convex_record_is_a_spring_of_least_squares() {
    let compression = Loading::new(LoadingKind::Compression);
    let Some(convex) = read(&["convex-b20-n300.csv"], compression) else {
        return;
    };
    let found = fitted(&convex, &[ModelKind::SpringPot], false);
    let [viscosity, order] = &found.fits[0].parameters[..] else {
        panic!("two")
    };
    assert_relative("V", viscosity.value, 239_989.0, 1e-5);
    assert_eq!(order.value.to_bits(), 0.0_f64.to_bits());
    let found = fitted(&convex, &tissue_identification::CANDIDATES, false);
    assert_eq!(found.fits[0].kind, ModelKind::Spring);
    assert!(!found.warnings.join("").contains("no minimum"));
}

/// A real record of pig skin in tension: the rms over all 151 rows is that of the 150 behind the first, which is at rest.
#[test]
fn skin_stiffens_without_memory() {
    let tension = Loading {
        area_m2: Some(8.601e-6),
        thickness_m: Some(34.65e-3),
        ..Loading::new(LoadingKind::Tension)
    };
    let Some(skin) = read(&["c25-mach1-skin.csv"], tension) else {
        return;
    };
    let found = fitted(&skin, &[ModelKind::SpringPot], true);
    let fit = &found.fits[0];
    let values: Vec<f64> = fit.parameters.iter().map(|one| one.value).collect();
    assert_relative("V", values[0], 346_556.0, 1e-4);
    assert_eq!(values[1].to_bits(), 0.0_f64.to_bits());
    assert_relative("b", values[2], 8.0405, 1e-4);
    assert_relative("rms", fit.rms, 1020.1, 1e-4);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn three_depths_of_two_elements_get_them() {
    let names = ["ref58_0.csv", "ref58_1.csv", "ref58_2.csv"];
    let Some(depths) = read(&names, sphere(9.945e-3, None)) else {
        return;
    };
    let kinds = [ModelKind::SpringPot, ModelKind::FractionalKelvinVoigt];
    let found = fitted(&depths, &kinds, true);
    let bic: Vec<f64> = found.fits.iter().map(|fit| fit.bic).collect();
    assert_eq!(found.fits[0].kind, ModelKind::FractionalKelvinVoigt);
    // With each depth weighted by its own stress: −2908 and −2735. The filter of the residuals allows the one element a drift: −2925 and −2856.
    assert!(
        (bic[0] + 2925.0).abs() < 10.0 && (bic[1] + 2856.0).abs() < 10.0,
        "{bic:?}"
    );
}

/// Taken for a deep body it is 2551 Pa.
#[test]
fn a_thin_layer_that_slides_on_its_base_is_softer_than_it_seems() {
    let Some(layer) = read(&["layer-nu0.5-free.csv"], sphere(5e-6, Some(8e-6))) else {
        return;
    };
    let found = fitted(&layer, &[ModelKind::Spring], false);
    assert_relative("E", found.fits[0].parameters[0].value, 2000.0, 1e-3);
}

#[test]
fn equal_times_of_four_digits_are_no_error() {
    let Some(rounded) = read(&["m7-equal-times.csv"], Loading::new(LoadingKind::Shear)) else {
        return;
    };
    let found = fitted(&rounded, &[ModelKind::SpringPot], false);
    assert_eq!(found.fits[0].predicted.len(), 8);
    // ln G = ln V − α ln t − ln Γ(1 − α), by the straight line through the logarithms.
    assert_relative("order", found.fits[0].parameters[1].value, 0.169_4, 1e-3);
}

/// Values of the spring-pot of a record, and what is said.
fn spring_pot(understood: &Understood) -> ([f64; 2], String) {
    let found = fitted(understood, &[ModelKind::SpringPot], false);
    let parameters = &found.fits[0].parameters;
    let message = [&understood.notes[..], &found.warnings].concat().join("\n");
    ([parameters[0].value, parameters[1].value], message)
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

/// Made from 14.52 kPa·s^0.178 and 10.49 kPa·s^0.089. The viscosities hang together by 0.9999: whatever the filter, their least squares are
/// 12.7 and 12.3 kPa, so what the record tells are the orders and their sum.
#[test]
fn slow_noise_buys_no_third_element() {
    let Some(sweep) = read(&["slow-noise-sweep.csv"], Loading::new(LoadingKind::Shear)) else {
        return;
    };
    let found = fitted(&sweep, &tissue_identification::CANDIDATES, false);
    let fit = &found.fits[0];
    assert_eq!(fit.kind, ModelKind::FractionalKelvinVoigt);
    let values: Vec<f64> = fit.parameters.iter().map(|one| one.value).collect();
    assert_relative("order", values[1], 0.178, 0.1);
    assert_relative("second order", values[3], 0.089, 0.1);
    assert_relative("sum", values[0] + values[2], 14_520.0 + 10_490.0, 0.01);
    for (found, truth) in fit
        .parameters
        .iter()
        .zip([14_520.0, 0.178, 10_490.0, 0.089])
    {
        let ends = found.low_95.zip(found.high_95).expect("settled");
        assert!(ends.0 < truth && truth < ends.1, "{found:?}");
    }
}

/// A dashpot of 47 kPa·s in series with a spring-pot; the dashpot alone leaves a thousand times as much.
#[test]
fn creep_from_its_step_on_keeps_its_spring_pot() {
    let Some(creep) = read(&["even-creep.csv"], Loading::new(LoadingKind::Shear)) else {
        return;
    };
    let found = fitted(&creep, &tissue_identification::CANDIDATES, false);
    let fit = &found.fits[0];
    assert_eq!(fit.kind, ModelKind::FractionalMaxwell);
    for (found, truth) in fit.parameters.iter().zip([47_000.0, 1.0, 18_000.0, 0.5]) {
        assert_relative(found.name, found.value, truth, 0.01);
    }
}
