//! `analyze` and `zwidth`: the contract's keys, known numbers, refusals.

mod zwidth;

use super::process::{Place, number};
use serde_json::Value;

/// One analysis, as JSON.
fn analyze(line: &str) -> Value {
    Place::new()
        .run(&format!("analyze {line} --json"))
        .succeeded()
        .json()
}

fn close(have: f64, want: f64, tolerance: f64) -> bool {
    (have - want).abs() <= tolerance
}

#[test]
fn a_wall_is_stable_below_the_known_boundary_and_not_above() {
    // μ = 1, exact, δ = 0: α < 2β(2 − β)/(2 + β) = 2/3 at β = 1.
    let wall = |alpha| analyze(&format!("stability --order 1 --alpha {alpha} --beta 1"));
    let inside = wall(0.666_666);
    assert_eq!(inside["stable"], true, "{inside}");
    assert_eq!(inside["encirclements"], 0);
    assert!(number(&inside, "gain_margin") > 1.0);
    let outside = wall(0.666_667);
    assert_eq!(outside["stable"], false, "{outside}");
    assert_eq!(outside["encirclements"], 2);
    for key in [
        "order",
        "scheme",
        "alpha",
        "beta",
        "delta",
        "gamma",
        "delay_samples",
    ] {
        assert!(!outside[key].is_null(), "{key}");
    }
    // Irrational with a fraction, a number for a polynomial.
    assert!(
        analyze("stability --order 0.5 --alpha 0.1 --beta 0.1 --delta 0.1")["spectral_radius"]
            .is_null()
    );
    let muir = analyze("stability --order 0.5 --alpha 0.1 --beta 0.1 --delta 0.1 --scheme muir:3");
    assert!(number(&muir, "spectral_radius") < 1.0, "{muir}");
}

/// Full memories of these orders had a small negative spring at rest once, and harmless walls were called unstable.
#[test]
fn a_full_memory_has_no_spring_at_rest_that_could_make_a_wall_unstable() {
    for order in ["0.35", "0.4", "0.45", "0.7", "0.8"] {
        for (scheme, spring) in [("full", "0"), ("full", "30"), ("full:1e-3", "0")] {
            let report = analyze(&format!(
                "stability --order {order} --scheme {scheme} --mass 65g --damping 3.5 --sample-time 2ms \
                 --stiffness {spring} --dissipation 5"
            ));
            assert_eq!(
                report["stable"], true,
                "{order} {scheme} {spring}: {report}"
            );
        }
    }
}

#[test]
fn units_and_no_units_give_the_same_loop() {
    // m = 65 g, T = 2 ms: α = K·4e-6/0.065, β = B·T^1.5/m, δ = 3.5·0.002/0.065.
    let with = analyze(
        "stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms --stiffness 3N/mm --dissipation 100",
    );
    let (alpha, beta) = (number(&with, "alpha"), number(&with, "beta"));
    assert!(close(alpha, 3000.0 * 4e-6 / 0.065, 1e-15), "{alpha}");
    assert!(
        close(beta, 100.0 * 0.002_f64.powf(1.5) / 0.065, 1e-15),
        "{beta}"
    );
    let delta = number(&with, "delta");
    let without = analyze(&format!(
        "stability --order 0.5 --alpha {alpha} --beta {beta} --delta {delta}"
    ));
    // JSON readers round numbers to the last digit but one.
    let margins = (
        number(&with, "gain_margin"),
        number(&without, "gain_margin"),
    );
    assert!(close(margins.0, margins.1, 1e-12), "{margins:?}");
}

#[test]
fn regions_have_their_known_extremes() {
    let region = analyze("stability-region --order 1");
    assert!(
        close(number(&region, "alpha_max"), 12.0 - 8.0 * 2f64.sqrt(), 1e-9),
        "{region}"
    );
    assert!(close(
        number(&region, "beta_at_alpha_max"),
        2.0 * 2f64.sqrt() - 2.0,
        1e-7
    ));
    assert!(close(number(&region, "beta_max"), 2.0, 1e-9));
    assert!(
        region["boundary"]
            .as_array()
            .is_some_and(|points| points.len() > 100)
    );
    // Delays of one, two, three samples, to the digits printed in the theory.
    for (delay, alpha, beta) in [
        (1, 0.14447, 0.42469),
        (2, 0.06243, 0.29139),
        (3, 0.03478, 0.22238),
    ] {
        let region = analyze(&format!(
            "stability-region --order 1 --delay-samples {delay}"
        ));
        assert!(
            close(number(&region, "alpha_max"), alpha, 5e-6),
            "{delay}: {region}"
        );
        assert!(
            close(number(&region, "beta_at_alpha_max"), beta, 5e-6),
            "{delay}"
        );
    }
}

#[test]
fn a_region_that_is_empty_is_said_to_be_empty() {
    // Two springs and no damping at all.
    let place = Place::new();
    let ended = place.run("analyze stability-region --order 0").succeeded();
    assert!(ended.stdout.starts_with("empty: no wall"), "{ended}");
    assert_eq!(analyze("stability-region --order 0")["empty"], true);
}

#[test]
fn the_third_order_polynomial_needs_more_damping_than_the_corollary_promises() {
    // Finding 3, on the β term: 4/3 at μ = 1.
    let muir = analyze("passivity --order 1 --scheme muir:3 --alpha 0 --beta 1 --delta 1.2");
    assert!(
        close(number(&muir, "required_delta"), 4.0 / 3.0, 1e-9),
        "{muir}"
    );
    assert!(close(number(&muir, "corollary_delta"), 1.0, 1e-12));
    assert_eq!(muir["passive"], false);
    // δ = 1.2 bears β = 1.2·3/4; α/2 + … at β = 1 is past it already.
    assert!(close(number(&muir, "largest_beta"), 0.9, 1e-9), "{muir}");
    let exact = analyze("passivity --order 1 --alpha 0 --beta 1 --delta 1.2");
    assert!(
        close(number(&exact, "required_delta"), 1.0, 1e-9),
        "{exact}"
    );
    assert_eq!(exact["passive"], true);
    assert!(analyze("passivity --order 1 --alpha 0 --beta 1")["passive"].is_null());
}

#[test]
fn a_damping_at_the_bound_is_said_to_be_there() {
    let said = |delta: &str| {
        let line = format!(
            "analyze passivity --order 1 --scheme grunwald:2 --alpha 0.1 --beta 0.2 --delta {delta}"
        );
        Place::new().run(&line).succeeded().stdout
    };
    // δ = α/2 + β = 0.05 + 0.2 by hand.
    for (delta, want) in [
        (
            "0.25",
            "no, with delta = 0.25, which is the bound itself: take more",
        ),
        ("0.2500000000001", "above the bound"),
        ("0.2499999999999", "below the bound"),
    ] {
        let text = said(delta);
        assert!(text.contains(want), "{text}");
    }
    let far = said("0.3");
    assert!(far.contains("yes, with delta = 0.3\n"), "{far}");
}

#[test]
fn a_scheme_with_frequencies_needs_a_sample_time() {
    let line = "analyze stability --order 0.5 --scheme oustaloup:3:1:100 --alpha 0.1 --beta 0.1";
    Place::new()
        .run(line)
        .refused(2, &["oustaloup:3:1:100", "Hz", "--sample-time"]);
    let report = analyze(
        "stability --order 0.5 --scheme oustaloup:3:1:100 --alpha 0.1 --beta 0.1 --delta 0.2 --sample-time 1ms",
    );
    assert!(report["stable"].is_boolean(), "{report}");
}

#[test]
fn the_coupled_port_needs_up_to_twice_what_the_corollary_promises_and_is_hopeless_above_order_one()
{
    let one = analyze(
        "coupling --order 1 --coupler-stiffness 0 --coupler-dissipation 1 --sample-time 1ms",
    );
    let factor = number(&one, "required_damping") / number(&one, "corollary_damping");
    assert!(close(factor, 2.0, 1e-9), "{one}");
    let above = analyze(
        "coupling --order 1.5 --coupler-stiffness 1 --coupler-dissipation 1 --sample-time 1ms --damping 100",
    );
    assert!(above["required_damping"].is_null(), "{above}");
    assert_eq!(above["passive"], false);
}

#[test]
fn effective_stiffness_and_damping_are_those_of_a_spring_and_a_damper_at_order_one() {
    let points = analyze(
        "environment --order 1 --stiffness 100 --dissipation 2 --sample-time 1ms --omega-min 0.1 --omega-max 1 --points 5",
    );
    let points = points["points"].as_array().expect("points").clone();
    assert_eq!(points.len(), 5);
    for point in points {
        assert!(
            close(number(&point, "effective_stiffness"), 100.0, 1e-2),
            "{point}"
        );
        assert!(
            close(number(&point, "effective_damping"), 2.0, 1e-5),
            "{point}"
        );
    }
    let hand = analyze(
        "transparency --order 1 --stiffness 100 --dissipation 2 --sample-time 0.1ms --mass 0.1kg --damping 1 \
         --omega-min 0.1 --omega-max 1 --points 3",
    );
    let first = &hand["points"][0];
    assert!(
        close(number(first, "effective_stiffness"), 100.0, 1e-2),
        "{first}"
    );
    // b + B, less the K·T/2 that the hold costs.
    assert!(
        close(
            number(first, "effective_damping"),
            3.0 - 100.0 * 0.5e-4,
            1e-4
        ),
        "{first}"
    );
}

#[test]
fn an_analysis_leaves_a_picture_and_a_table_without_nan() {
    let place = Place::new();
    for (line, stem) in [
        ("stability-region --order 0.5 --delta 0.1", "region"),
        (
            "sensitivity --order 0.5 --alpha 0.1 --beta 0.3 --delta 0.1",
            "sensitivity",
        ),
        (
            "environment --order 2 --stiffness 10N/mm --dissipation 100 --sample-time 1ms",
            "environment",
        ),
        (
            "transparency --order 0.5 --stiffness 50 --dissipation 1 --mass 0.65kg --damping 3.5 --sample-time 1ms",
            "transparency",
        ),
    ] {
        place
            .run(&format!("analyze {line} --out here --quiet"))
            .succeeded();
        for extension in ["csv", "svg"] {
            let text = place.text(&format!("here/{stem}.{extension}"));
            assert!(text.len() > 500, "{stem}.{extension}");
            assert!(
                !text.contains("NaN") && !text.contains("inf,"),
                "{stem}.{extension}"
            );
        }
        assert!(!place.read(&format!("here/{stem}.png")).is_empty());
    }
}

#[test]
fn questions_without_an_answer_are_refused_in_words() {
    let place = Place::new();
    for (line, words) in [
        ("stability --order 1 --alpha 0.1", "--beta is missing"),
        (
            "stability --order 1 --alpha 0.1 --beta 1 --mass 1kg",
            "both without units and with them",
        ),
        (
            "stability --order -0.5 --alpha 0.1 --beta 1",
            "order -0.5 is not in [0, 2], a wall has no integral",
        ),
        (
            "stability --order x --alpha 0.1 --beta 1",
            "not a finite number",
        ),
        (
            "stability --order 1 --mass -1kg --sample-time 1ms --stiffness 1 --dissipation 1",
            "mass -1 kg is not above 0 and at most 100 kg",
        ),
        (
            "stability --order 1 --alpha -0.1 --beta 1",
            "alpha -0.1 is not from 0 to 1e12: change --alpha",
        ),
        ("sensitivity --order 1 --alpha 3 --beta 1", "not stable"),
        (
            "coupling --order 1 --coupler-stiffness -1 --coupler-dissipation 1 --sample-time 1ms",
            "-1",
        ),
        (
            "environment --order 1 --stiffness 1 --dissipation 1 --sample-time 1ms --omega-max 1e9",
            "--omega-max",
        ),
        (
            "passivity --order 1 --alpha 1 --beta 1 --delay-samples -1",
            "--delay-samples",
        ),
    ] {
        place.run(&format!("analyze {line}")).refused(2, &[words]);
    }
}
