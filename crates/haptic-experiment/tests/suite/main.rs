//! Tests of the public face of `haptic-experiment`, in one binary.

mod against;
mod contact;
mod design;
mod difference;
mod law;
mod log;
mod touch;

use haptic_document::Document;
use haptic_experiment::{DocumentOfKind as _, ExperimentFile, Report};
use haptic_run::{FolderRequest, Supervisor};
use std::{collections::BTreeMap, path::PathBuf};

/// The report of the document, run into this folder with what it says kept in the log.
fn ran(document: &Document, out: PathBuf) -> Report {
    let mut provenance = BTreeMap::new();
    document.keep_in(&mut provenance).expect("good");
    let request = FolderRequest {
        out: Some(out),
        stem: "run".to_owned(),
        overwrite: false,
        roll_bytes: None,
        provenance,
    };
    let supervisor = Supervisor {
        stop: &std::sync::Arc::default(),
        progress: &|_| {},
        live: None,
        warn: &|_| {},
    };
    let experiment = ExperimentFile::open(document).unwrap_or_else(|e| panic!("{e}"));
    experiment.run(&request, supervisor).expect("runs").report
}
