//! Tissues as the wish of a design.

use super::{design, near, settles};
use crate::process::{Place, number};
use serde_json::Value;

#[test]
fn a_tissue_fits_or_its_closest_order_is_named() {
    let place = Place::new();
    let report = design(&place, "--wish tissue --tissue prostate-cancerous");
    let tissue = &report["tissue"];
    assert_eq!(tissue["fits"], true);
    assert_eq!(number(&report["best"], "order"), 0.2247);
    // B = A·η/ℓ
    near(
        number(&report["best"], "dissipation"),
        8650.0 * 4e-4 / 0.02,
        1e-12,
    );
    assert_eq!(number(&report["best"], "stiffness"), 0.0);
    assert!(settles(&place, 1.0));
    let scale = number(tissue, "largest_scale");
    // A specimen that is larger by more than that does not fit, one that is a little smaller does.
    for (factor, fits) in [(0.99, true), (1.01, false)] {
        let area = 4.0 * scale * factor;
        let line =
            format!("design --json --wish tissue --tissue prostate-cancerous area={area}cm2");
        let ended = place.run(&line);
        let ended = if fits {
            ended.succeeded()
        } else {
            // At 1 Hz no other order fits either.
            ended.failed(1)
        };
        assert_eq!(ended.json()["tissue"]["fits"], fits, "{factor}");
    }
    // Passive by Corollary 1, E₀ = 0: b > B(T/2)^(1−μ). The stand-in spring takes a share of 1e-4.
    let line = "design --json --wish tissue --tissue prostate-cancerous --require passive --sample-time 2ms";
    let report = place.run(line).succeeded().json();
    let want = 3.5 / (173.0 * 1e-3_f64.powf(1.0 - 0.2247));
    near(number(&report["tissue"], "largest_scale"), want, 1e-3);
    // A larger one: order 0.25 needs more damping still, order 0 less.
    let line = format!("{line} area={}cm2", 4.0 * 1.01 * want);
    let report = place.run(&line).succeeded().json();
    assert_eq!(report["tissue"]["fits"], false);
    assert_eq!(number(&report["best"], "order"), 0.0);
}

#[test]
fn a_tissue_with_elements_in_series_is_designed_for_by_its_own_operator() {
    let place = Place::new();
    let ended =
        place.run("design --json --wish tissue --tissue fish-muscle --orders 0.5 --out design");
    let report = ended.succeeded().json();
    assert_eq!(report["tissue"]["fits"], true);
    assert_eq!(number(&report["tissue"], "order"), 0.6751);
    assert_eq!(report["simulated"]["stable"], true);
    // A wall has no key for a model.
    assert_eq!(report["experiment"], Value::Null);
    let notes = report["notes"].as_array().expect("a list");
    let notes: Vec<&str> = notes.iter().filter_map(Value::as_str).collect();
    assert!(
        notes.iter().any(|note| note.contains("relax and creep")),
        "{notes:?}"
    );
    // Square metres of it are too stiff for the device.
    let stiff = "design --json --wish tissue --tissue fish-muscle area=4m2 --orders 0.5";
    assert_eq!(place.run(stiff).failed(1).json()["tissue"]["fits"], false);
}

#[test]
fn a_tissue_that_makes_too_much_noise_does_not_fit() {
    let place = Place::new();
    let line = "design --json --wish tissue --tissue prostate-cancerous encoder_resolution=30um --orders 0.5";
    let loud = place.run(line).succeeded().json();
    let noise = number(&loud["candidates"][0], "force_noise_rms_n");
    let line = format!("{line} --force-noise-limit {}", 0.5 * noise);
    // The answer is no: the report, and exit code 1.
    let quiet = place.run(&line).failed(1).json();
    near(number(&quiet["tissue"], "largest_scale"), 0.5, 1e-3);
    assert_eq!(quiet["tissue"]["fits"], false);
}
