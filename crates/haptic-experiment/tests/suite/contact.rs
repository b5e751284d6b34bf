//! Walls that never pull: what is proved of them, how they are hit, and what is refused.

use crate::{
    design::{design, number},
    touch::{request, supervised},
};
use haptic_experiment::ExperimentFile;
use serde_json::Value;
use std::path::Path;
use testkit::{Folder, assert_says};

/// After public reports: a linear loop with a margin of 1.5, which a hit at 0.5 m/s takes to the force limit behind the clamp.
const SATURATES: &str = "mass_kg = 0.065\ndamping_n_s_per_m = 0.2\nsample_time_s = 1e-3\norder = 1\nstiffness_n_per_m = 6000\n\
    dissipation_n_s_mu_per_m = 18\ndelay_s = 1e-3\nhand_stiffness_n_per_m = 1000\nforce_limit_n = 1000\n";
/// And one with a margin of 1.94, which a hit at 0.3 m/s takes to 69 kN.
const LEAVES: &str = "mass_kg = 0.0533\ndamping_n_s_per_m = 0.05\nsample_time_s = 1e-3\norder = 1\nstiffness_n_per_m = 600\n\
    dissipation_n_s_mu_per_m = 2.4\ndelay_s = 2.572e-3\nhand_stiffness_n_per_m = 1000\nforce_limit_n = 1e6\n\
    force_rate_limit_n_per_s = 1e10\n";

fn parsed(text: &str) -> Result<ExperimentFile, String> {
    ExperimentFile::parse(Path::new("lab.toml"), text).map_err(|error| error.to_string())
}

/// The report of `[wall]` with these keys.
fn wall(keys: &str, more: &str) -> Value {
    let file = parsed(&format!("[wall]\n{keys}{more}")).expect("a good wall");
    let folder = Folder::empty();
    let published = supervised(|supervisor| file.run(&request(&folder, "wall"), supervisor));
    serde_json::to_value(published.expect("runs").report).expect("JSON")
}

#[test]
fn a_wall_that_never_pulls_is_judged_by_its_worst_hit_and_nothing_is_said_to_be_proved() {
    for (keys, margin) in [(SATURATES, 1.502), (LEAVES, 1.943)] {
        let report = wall(keys, "one_sided = true\n");
        let preflight = &report["preflight"];
        assert_eq!(preflight["pushing_contact"], "not proved");
        let proved = number(preflight, "pulling_contact_margin");
        assert!((proved / margin - 1.0).abs() < 1e-3, "{preflight}");
        assert_eq!(
            (&report["stable"], &report["analysis_agrees"]),
            (&false.into(), &false.into())
        );
        let hits = report["hits"].as_array().expect("hits");
        let speeds: Vec<f64> = hits
            .iter()
            .map(|hit| number(hit, "impact_m_per_s"))
            .collect();
        assert_eq!(speeds, [0.1, 0.0, 0.05, 0.2, 0.5, 1.0], "{hits:?}");
        let worst = number(&report, "impact_m_per_s");
        assert!(worst > 0.1 && worst < 1.1, "{report}");
        let warnings = report["warnings"].to_string();
        assert_says(&warnings, "when it is hit at");
    }
    // The hit that the file asks for settles, which once was the whole verdict.
    let report = wall(SATURATES, "one_sided = true\n");
    assert_eq!(report["hits"][0]["verdict"], "stable");
    // A guard lets no hit give energy, and the same wall fed with the place settles after each.
    let guarded = wall(SATURATES, "one_sided = true\nguard = \"energy-bounding\"\n");
    let message = &guarded["preflight"]["pushing_contact"];
    assert_eq!(message, "proved to give no energy, with the guard on");
}

#[test]
fn a_signed_wall_settles_after_every_hit_as_its_proof_says() {
    for keys in [SATURATES, LEAVES] {
        let report = wall(keys, "contact = \"signed\"\n");
        let message = report["preflight"]["pushing_contact"]
            .as_str()
            .expect("said");
        assert!(message.starts_with("proved for every motion"), "{message}");
        assert_eq!(report["stable"], true, "{report}");
        assert_eq!(report["hits"].as_array().map(Vec::len), Some(6));
        // It is compared with its full history, and clamped as that is.
        assert!(number(&report, "max_relative_error") < 1e-6, "{report}");
        assert!(report["largest_pull_n"].is_null());
    }
}

#[test]
fn a_linear_wall_says_how_hard_it_pulls_and_is_hit_once() {
    let report = wall(SATURATES, "");
    assert!(report["hits"].is_null() && report["preflight"]["pushing_contact"].is_null());
    // ζ is low: on the way back the damper alone pulls, with up to B·v.
    let pull = number(&report, "largest_pull_n");
    assert!(pull > 0.3 && pull < 2.4, "{pull}");
    assert!(
        number(&report, "largest_pull_position_m").abs() < 1e-3,
        "{report}"
    );
    assert_eq!(report["contact"], "linear");
}

#[test]
fn a_touch_says_that_contact_which_never_pulls_is_not_proved() {
    let keys = "stiffness_n_per_m = 800\ndissipation_n_s_mu_per_m = 12\norder = 0.4\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
                duration_s = 0.1\nforce_limit_n = 100\naxes = 2\nradius_m = 0.25\nhand = \"force\"\ncentre_m = [0, 0.25]\n\
                way_points = [[0, 0, 1]]\n";
    let file = parsed(&format!("[touch]\n{keys}")).expect("a good touch");
    let folder = Folder::empty();
    let published = supervised(|supervisor| file.run(&request(&folder, "touch"), supervisor));
    let report = serde_json::to_value(published.expect("runs").report).expect("JSON");
    assert_eq!(
        report["preflight"]["pushing_contact"], "not proved",
        "{report}"
    );
}

#[test]
fn a_contact_without_meaning_is_refused_in_a_line() {
    for (more, want) in [
        ("contact = \"both\"", "is not one of depth, signed"),
        (
            "one_sided = false\ncontact = \"signed\"",
            "never pulls, and one_sided = false does",
        ),
        (
            "contact = \"signed\"\ndevice = \"serial:x\"",
            "no board runs contact",
        ),
    ] {
        let error = parsed(&format!("[wall]\n{SATURATES}{more}\n")).expect_err("refused");
        assert!(error.contains(want) && !error.contains('\n'), "{error}");
    }
    parsed(&format!(
        "[wall]\n{SATURATES}contact = \"signed\"\ndevice = \"serial:x\"\nloop = \"host\"\n"
    ))
    .expect("a loop on the host runs it");
    let springless = SATURATES.replace("stiffness_n_per_m = 6000", "stiffness_n_per_m = 0");
    assert_ne!(springless, SATURATES);
    let error =
        parsed(&format!("[wall]\n{springless}contact = \"signed\"\n")).expect_err("refused");
    assert_says(&error, "would push anywhere");
}

/// A device without damping of its own throws every one-sided wall off; the design of a linear one keeps a gain margin of 1.1.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_design_takes_a_one_sided_wall_only_if_it_settles_after_each_hit() {
    let keys = "mass_kg = 0.0533\ndamping_n_s_per_m = 0.05\nhand_stiffness_n_per_m = 1000\ndelay_s = 2.572e-3\norders = [0.5, 1]\n\
                gain_margin = 1.05\nforce_limit_n = 1000\n";
    let linear = design(keys);
    assert_eq!(linear["simulated"]["stable"], true, "{linear}");
    let one_sided = design(&format!("{keys}one_sided = true"));
    let refused = |report: &Value| -> Vec<bool> {
        let candidates = report["candidates"].as_array().expect("a list").iter();
        candidates
            .map(|found| found["reason"].to_string().contains("when tried"))
            .collect()
    };
    assert!(refused(&one_sided).contains(&true), "{one_sided}");
    assert!(one_sided["best"].is_null() || one_sided["simulated"]["stable"] == true);
    let signed = design(&format!("{keys}contact = \"signed\""));
    assert!(
        number(&signed["best"], "pulling_contact_margin") >= 1.0,
        "{signed}"
    );
    assert_eq!(
        (&signed["simulated"]["stable"], &signed["contact"]),
        (&true.into(), &"signed".into())
    );
}
