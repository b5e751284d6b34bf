//! A second device pushes: its report, and what is refused.

use crate::{
    experiment::{bounded_tests::conducted, kind::Experiment as _, wall::WallExperiment},
    open::ExperimentFile,
};
use serde_json::json;
use std::path::Path;
use testkit::{Folder, Tested};

/// A wall of K, N/m, and B, N·s^μ/m, with further lines of `[wall]` and of `[drive]`.
fn text((mu, k, b): (f64, f64, f64), wall: &str, drive: &str) -> String {
    format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = {mu:?}\n\
         stiffness_n_per_m = {k:?}\ndissipation_n_s_mu_per_m = {b:?}\n{wall}\n[drive]\n{drive}\n"
    )
}

fn read(text: &str) -> Result<WallExperiment, String> {
    let file = ExperimentFile::parse(Path::new("lab.toml"), text);
    let file = file.map_err(|error| error.to_string())?;
    Ok(file.of::<WallExperiment>().expect("a wall").clone())
}

#[test]
fn the_report_names_the_second_device_and_the_log_has_the_force_between_both() -> Tested {
    let folder = Folder::empty();
    let wall = read(&text((1.0, 1000.0, 2.0), "duration_s = 2.0", "")).expect("good");
    let ran = conducted(&folder, |watched| wall.recorded(watched))?;
    let (report, _) = wall.report(&ran)?;
    let law = json!(report.law);
    assert_eq!(law["push_by"], "second_device", "{law}");
    assert_eq!(law["push_n"], 1.0, "{law}");
    let margin_of = law["preflight_reason"].to_string();
    assert!(
        margin_of.contains("both devices as one body"),
        "{margin_of}"
    );
    let last = ran.record.whole.as_deref().and_then(<[_]>::last);
    let last = last.expect("kept");
    assert!((last.contact_force_n - 1.0).abs() < 1e-6, "{last:?}");
    assert!((last.force_n + 1.0).abs() < 1e-6, "{last:?}");
    assert_eq!(wall.metadata()["impact_m_per_s"], "0");
    let csv = std::fs::read_to_string(folder.join("run.csv"))?;
    let (names, rows) = csv.split_once('\n').expect("rows");
    assert!(
        names.ends_with(",indenter_position_m,drive_force_n"),
        "{names}"
    );
    // The push from the first sample on; in the end the contact gives by the push over its stiffness.
    let mut last = [0.0; 5];
    for row in rows.lines() {
        let mut values = row
            .split(',')
            .map(|value| value.parse::<f64>().expect("a number"));
        last = std::array::from_fn(|_| values.next().expect("a column"));
        assert!((last[4] - 1.0).abs() < 1e-12, "{row}");
    }
    assert!((last[3] - last[1] - 1e-5).abs() < 1e-9, "{last:?}");
    Ok(())
}

#[test]
fn a_push_that_a_second_device_cannot_make_is_refused_in_one_line() {
    let law = (1.0, 1000.0, 2.0);
    for (wall, drive, words) in [
        ("push_by = 'device'", "", "push_by"),
        ("impact_m_per_s = 0.1", "", "from rest"),
        ("device = 'serial:x'", "", "give `drive_device`"),
        (
            "device = 'serial:x'",
            "drive_device = 'serial:x'",
            "may be the same device",
        ),
        (
            "device = 'serial:x'",
            "drive_device = 'serial:y'\ncontact_damping_n_s_per_m = 1.0",
            "contact_damping_n_s_per_m has no effect",
        ),
        ("", "controller = 'c.toml'", "controller"),
        ("", "drive_device = 'serial:y'", "both devices of a drive"),
        ("", "drive_loop = 'host'", "drive_loop"),
        (
            "push_n = 2.0",
            "drive_force_limit_n = 1.5",
            "drive_force_limit_n = 1.5 N is below the push of 2 N",
        ),
        ("", "contact_stiffness_n_per_m = 0.0", "contact stiffness"),
        ("", "drive_device_model = 'none.toml'", "none.toml"),
    ] {
        let error = read(&text(law, wall, drive)).expect_err(words);
        assert!(error.contains(words), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let touch = "[touch]\n[drive]\n";
    let error = ExperimentFile::parse(Path::new("lab.toml"), touch).expect_err("no drive");
    assert!(error.to_string().contains("not [touch]"), "{error}");
}
