//! Tests of the public face of `tissue-identification`, in one binary: models fitted to records, to measured ones, and to synthetic ones whose
//! truth is known.

mod campaign;
mod cases;
mod contact;
mod errors;
mod fits;
mod golden;
mod history;
mod indentation;
mod layouts;
mod least;
mod master;
mod meaning;
mod public;
mod records;
mod recovery;
mod rendered;
mod replicates;
mod steps;
mod stiffening;
mod sums;
mod table;
mod troubled;
mod untimed;

use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::ModelKind;
use measured_table::{Reader, read_table};
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use tissue_identification::{
    Estimate, Identification, IdentifyError, Options, Record, TableDetails, Understood, identify,
};

/// The measured relaxation of fish muscle.
fn fish() -> Record {
    let rows = include_str!("../records/fish-muscle-relaxation.tsv")
        .lines()
        .skip(1);
    let (time, modulus) = rows
        .map(|row| {
            let (time, modulus) = row.split_once('\t').expect("two columns");
            (
                time.parse::<f64>().expect("time"),
                modulus.parse::<f64>().expect("modulus"),
            )
        })
        .unzip();
    Record::relaxation(time, modulus).expect("valid")
}

/// Public records of others, which stay outside the repository: in `shared/data/public` beside it. None where that folder is not there.
fn read_public<const N: usize>(names: [&str; N]) -> Option<[String; N]> {
    let above = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut folders = above.map(|folder| folder.join("shared/data/public"));
    let Some(folder) = folders.find(|folder| folder.is_dir()) else {
        testkit::skip("shared/data/public is not beside the repository");
        return None;
    };
    Some(names.map(|name| std::fs::read_to_string(folder.join(name)).expect(name)))
}

/// A table, read without a word but these details.
fn understood(table: &str, details: &TableDetails) -> Result<Understood, IdentifyError> {
    details.record(Reader::default().read(read_table(table.as_bytes())?)?)
}

/// Details of a loading that is told.
fn told(loading: Loading) -> TableDetails {
    TableDetails {
        loading,
        loading_is_told: true,
        ..TableDetails::default()
    }
}

fn sphere(radius_m: f64) -> Loading {
    Loading {
        radius_m: Some(radius_m),
        ..Loading::new(LoadingKind::Sphere)
    }
}

fn among(candidates: &[ModelKind]) -> Options {
    Options {
        candidates: candidates.to_vec(),
        ..Options::default()
    }
}

/// A fit of one model.
#[track_caller]
fn one(record: &Record, candidate: ModelKind) -> Identification {
    fit(record, &among(&[candidate]))
}

#[track_caller]
fn fit(record: &Record, options: &Options) -> Identification {
    identify(record, options, &|_| ()).expect("converges")
}

/// All warnings.
fn said(found: &Identification) -> String {
    found.warnings.join("\n")
}

/// Values of the parameters of the best fit.
fn values(found: &Identification) -> Vec<f64> {
    let parameters = found.fits[0].parameters.iter();
    parameters.map(|one| one.value).collect()
}

/// True if a value lies between the bounds that there are, as in a flat valley.
fn holds(estimate: &Estimate, value: f64) -> bool {
    estimate.low_95.is_none_or(|low| low <= value)
        && estimate.high_95.is_none_or(|high| value <= high)
}

/// True if a value lies between two bounds.
fn is_inside(estimate: &Estimate, value: f64) -> bool {
    let ends = [estimate.low_95, estimate.high_95];
    ends.iter().all(Option::is_some) && holds(estimate, value)
}

/// Standard normal numbers.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut generator = Pcg64::seed_from_u64(seed);
    move || StandardNormal.sample(&mut generator)
}

/// So many times from 0 on.
fn evenly(step_s: f64, count: u32) -> Vec<f64> {
    (0..count).map(|n| step_s * f64::from(n)).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn candidate(name: &str) -> ModelKind {
    ModelKind::from_name(name).expect("a model")
}
