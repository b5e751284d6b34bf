//! Models fitted to records: measured ones, and synthetic ones whose truth is known.
#![cfg(feature = "identify")]

mod golden;
mod history;
mod indentation;
mod layouts;
mod records;
mod recovery;
mod stiffening;
mod table;

use haptic_tissue::ModelKind;
use haptic_tissue::identify::{Identification, Options, Record, identify};

/// The measured relaxation of fish muscle.
fn fish() -> Record {
    let rows = include_str!("../../records/fish-muscle-relaxation.tsv")
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

/// A fit of one model.
fn one(record: &Record, candidate: ModelKind) -> Identification {
    let options = Options {
        candidates: vec![candidate],
        ..Options::default()
    };
    identify(record, &options, &|_| ()).expect("converges")
}

fn candidate(name: &str) -> ModelKind {
    ModelKind::from_name(name).expect("a model")
}
