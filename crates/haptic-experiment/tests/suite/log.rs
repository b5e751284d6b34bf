//! What the log of a run says of it.

use crate::ran;
use haptic_document::Document;
use haptic_log::record::{Entry, LogReader};
use std::collections::BTreeMap;
use testkit::Folder;

/// Runs the document: what its log says of the experiment.
fn logged(document: &Document) -> BTreeMap<String, String> {
    let folder = Folder::empty();
    ran(document, folder.join("run"));
    let mut log = LogReader::open(&folder.join("run/run.mcap")).expect("opens");
    let found = log.find_map(|entry| {
        let Entry::Metadata(record) = entry.expect("reads") else {
            return None;
        };
        (record.name == "experiment").then_some(record.values)
    });
    found.expect("what ran")
}

#[test]
fn a_log_says_what_ran_where_the_document_leaves_it_open() {
    let place = Folder::empty();
    let device = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\n";
    std::fs::write(place.join("device.toml"), device).expect("writes");
    let law = "stiffness_n_per_m = 800\ndissipation_n_s_mu_per_m = 12\norder = 0.4\n";
    let body = "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\n";
    for (text, ran) in [
        (
            "[relax]\nduration_s = 1\nramp_time_s = 0.1\nguard = \"observer\"\ndevice_model = \"device.toml\"\n",
            &[("scheme", "full:1e-6"), ("device_mass_kg", "0.08")][..],
        ),
        (
            &format!("[wall]\n{law}{body}duration_s = 1\n"),
            &[("scheme", "full:1e-6")],
        ),
        (
            &format!(
                "[touch]\n{law}{body}duration_s = 1\nway_points = [[0, 0.01, 0.02]]\nradius_m = 0.01\n"
            ),
            &[("scheme", "full:1e-6")],
        ),
        (
            &format!(
                "[teleoperation]\n{body}duration_s = 2\nwindow_s = 0.5\nlow_hz = 4\nhigh_hz = 8\nfrequencies = 2\n"
            ),
            &[
                ("scheme", "full:1e-6"),
                ("slave_mass_kg", "0.065"),
                ("slave_damping_n_s_per_m", "3.5"),
                ("frequencies_hz", "4 8"),
                ("playout_samples", "2"),
            ],
        ),
    ] {
        let document = Document::of_text(&place.join("own.toml"), text);
        let log = logged(&document);
        for (key, value) in [("pace", "virtual"), ("device", "sim")].iter().chain(ran) {
            assert_eq!(
                log.get(*key).map(String::as_str),
                Some(*value),
                "{key} of {text}"
            );
        }
        // The document itself stands there as it was written.
        assert!(!log["document"].contains("\nscheme ="), "{text}");
    }
}
