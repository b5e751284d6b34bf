//! Records that are refused.

use haptic_tissue::ModelKind;
use haptic_tissue::identify::{IdentifyError, Options, Record, identify};

fn refused(record: Result<Record, IdentifyError>, wanted: &str) {
    let message = record.expect_err(wanted).to_string();
    assert!(message.contains(wanted), "have {message}\nwant {wanted}");
    assert!(
        !message.contains('\n') && !message.contains("--"),
        "{message}"
    );
}

#[test]
fn a_bad_record_is_refused_with_its_sample_and_the_remedy() {
    let relaxation =
        |time: &[f64], modulus: &[f64]| Record::relaxation(time.to_vec(), modulus.to_vec());
    refused(
        relaxation(&[0.0, 1.0], &[2.0, 1.0]),
        "sample 1: time 0 s is not above 0 s",
    );
    refused(relaxation(&[1.0, -1.0], &[2.0, 1.0]), "sample 2: time -1 s");
    refused(
        relaxation(&[1.0, 1.0], &[2.0, 1.0]),
        "sample 2: time 1 s comes after 1 s and is not above it: sort",
    );
    refused(
        relaxation(&[1.0, 2.0], &[2.0, -1.0]),
        "sample 2: modulus -1 Pa is not above 0 Pa",
    );
    refused(
        relaxation(&[1.0, 2.0], &[2.0, f64::NAN]),
        "sample 2: modulus NaN Pa",
    );
    refused(
        relaxation(&[1.0, 2.0, 3.0], &[2.0; 3]),
        "modulus is 2 Pa in every sample",
    );
    refused(relaxation(&[1.0, 2.0], &[2.0]), "different lengths");
    refused(relaxation(&[], &[]), "no sample");
    refused(
        relaxation(&[1.0, 2.0, 4.0], &[1.0, 2.0, 4.0]),
        "the modulus grows with time",
    );
    refused(
        Record::creep(vec![1.0, 2.0, 4.0], vec![4.0, 2.0, 1.0]),
        "the compliance falls with time",
    );
    refused(
        Record::oscillation(
            vec![1.0, 2.0, 1.0],
            vec![1.0, 2.0, 3.0],
            vec![1.0, 2.0, 3.0],
        ),
        "angular frequency 1 rad/s comes after 1 rad/s",
    );
    refused(
        Record::oscillation(vec![1.0, 2.0], vec![1.0, 2.0], vec![1.0, 0.0]),
        "sample 2: loss modulus 0 Pa",
    );
    let history = |strain: &[f64], stress: &[f64]| {
        Record::history(vec![0.0, 1.0, 2.0], strain.to_vec(), stress.to_vec())
    };
    refused(
        history(&[0.0, 0.0, 0.0], &[0.0, 1.0, 2.0]),
        "the strain stays at 0",
    );
    refused(
        history(&[0.5, 0.5, 1.0], &[0.0, 1.0, 2.0]),
        "begins at 0.5, not at rest",
    );
    refused(
        history(&[0.0, 0.5, 1.0], &[1.0, 1.0, 1.0]),
        "the stress is 1 Pa in every sample",
    );
    refused(
        history(&[0.0, 0.5, f64::INFINITY], &[1.0, 1.0, 1.0]),
        "sample 3",
    );
}

#[test]
fn three_samples_for_four_parameters_are_too_few() {
    let record = Record::relaxation(vec![1.0, 2.0, 4.0], vec![4.0, 3.0, 2.5]).expect("valid");
    let options = Options {
        chosen: Some(ModelKind::FractionalMaxwell),
        ..Options::default()
    };
    let message = identify(&record, &options, &|_| ())
        .expect_err("too few")
        .to_string();
    assert!(
        message.contains("3 numbers are too few for the 4 parameters of fractional-maxwell"),
        "{message}"
    );
    // The others are no reason to refuse what can be fitted, but are named.
    let found = identify(&record, &Options::default(), &|_| ()).expect("two parameters");
    assert_eq!(found.fits.len(), 1);
    assert_eq!(
        found
            .warnings
            .iter()
            .filter(|said| said.contains("too few"))
            .count(),
        4
    );
}
