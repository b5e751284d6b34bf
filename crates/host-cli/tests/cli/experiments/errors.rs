//! The two errors of a report: over which samples, and when there are none.

use super::cancerous;
use super::{DASHPOT, SHORT};
use crate::process::{Place, number, says};
use serde_json::Value;

#[test]
fn each_error_says_over_which_samples_it_is() {
    let place = Place::new();
    let line = "relax --duration 3s --ramp-time 0.5s";
    let report = place.run(&format!("{line} --json")).succeeded().json();
    for (name, from_s) in [("max_relative_error", 0.01), ("closed_form_error", 0.6)] {
        assert_eq!(number(&report, &format!("{name}_from_s")), from_s, "{name}");
        assert_eq!(number(&report, &format!("{name}_to_s")), 3.0, "{name}");
        let samples = ((3.0 - from_s) * 1e3_f64).round() + 1.0;
        assert_eq!(number(&report, &format!("{name}_samples")), samples);
        assert_eq!(report[format!("{name}_reason")], Value::Null);
    }
    let summary = place.run(&format!("{line} --out again")).succeeded().stdout;
    says(&summary, &["from 0.01 s to 3 s", "from 0.6 s to 3 s"]);
    let creep = place.run("creep --duration 3s --json").succeeded().json();
    assert_eq!(number(&creep, "closed_form_error_from_s"), 1.0);
}

#[test]
fn an_error_without_meaning_is_null_with_its_reason() {
    let place = Place::new();
    place.write("dashpot.toml", DASHPOT);
    for contact in ["rigid", "compliant"] {
        let line = format!("{SHORT} --overwrite --tissue dashpot.toml --contact {contact}");
        let ended = place
            .run(&format!("{line} --json"))
            .succeeded_with_warnings();
        let report = ended.json();
        assert_eq!(report["closed_form_error"], Value::Null, "{contact}");
        assert_eq!(report["closed_form_error_from_s"], Value::Null);
        assert_eq!(report["final_over_theory"], Value::Null);
        let reason = report["closed_form_error_reason"]
            .as_str()
            .expect("a reason");
        assert!(
            reason.contains("closed form") && reason.contains("0 N"),
            "{reason}"
        );
        // On the ramp the force is 4 cm²·1 kPa·s·0.05/0.5 s; the full history judges that.
        if contact == "rigid" {
            assert!(number(&report, "max_relative_error") < 1e-5, "{report}");
            assert_eq!(number(&report, "max_relative_error_to_s"), 0.5);
        }
        let summary = place.run(&line).succeeded_with_warnings().stdout;
        assert!(summary.contains(reason), "{summary}");
        let csv = place.text("run/relax.csv");
        for text in [&summary, &csv, &ended.stderr, &place.text("run/relax.svg")] {
            assert!(!text.contains("inf") && !text.contains("NaN"), "{text}");
        }
    }
    // A run that ends before the comparison begins says so.
    let short = place
        .run("creep --duration 0.5s --json")
        .succeeded_with_warnings()
        .json();
    assert_eq!(short["closed_form_error"], Value::Null);
    let reason = short["closed_form_error_reason"]
        .as_str()
        .expect("a reason");
    assert!(
        reason.contains("0.5 s") && reason.contains("1 s"),
        "{reason}"
    );
}

#[test]
fn a_memory_shorter_than_the_experiment_is_announced_with_the_factor_it_costs() {
    let ended = Place::new().run(&format!("{SHORT} --scheme grunwald:1000 --json"));
    let ended = ended.succeeded_with_warnings();
    // On the hold the short sum is x₀·(N·T)^(−α)/Γ(1−α) with N·T = 1 s; the ratio to the closed
    // form is 1.2549. The compliant contact takes 0.15 % off.
    let p = 1.0 - cancerous::ALPHA;
    let want = p * 0.5 / (3f64.powf(p) - 2.5f64.powf(p));
    let report = ended.json();
    let have = number(&report, "final_over_theory");
    assert!((have / want - 1.0).abs() < 0.005, "{have} {want}");
    assert_eq!(number(&report, "memory_s"), 1.0);
    let warnings = report["warnings"].as_array().expect("a list");
    let sentence = warnings[0].as_str().expect("a sentence");
    assert_eq!(ended.stderr, format!("warning: {sentence}\n"));
    says(
        sentence,
        &[
            "remembers 1 s",
            "lasts 3 s",
            "the force is 1.253 times",
            "--scheme full",
        ],
    );
}
