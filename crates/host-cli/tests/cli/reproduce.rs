//! `reproduce`: every figure and claim of the dissertation.

use super::process::{Place, holds};
use serde_json::Value;
use testkit::assert_says;

/// The data of a figure that was made again, with its quantities, and its picture.
fn assert_figure(place: &Place, figure: &Value) {
    let data = place.text(figure["data"].as_str().expect("a path"));
    holds(data.lines().count() > 50 && !data.contains("NaN"), &figure);
    // Quantities with their units, not x and y.
    let quantities = match figure["id"].as_str().expect("an id") {
        "3.3" => "theta_rad,magnitude,stiffness_coefficient,damping_coefficient",
        "3.4" | "6.2" => "omega_rad_s,effective_stiffness_n_per_m,effective_damping_n_s_per_m",
        "4.5" => "theta_rad,sensitivity_db",
        "7.2" => "time_s,force_n,relative_deviation",
        _ => "beta,alpha",
    };
    let header = format!("panel,curve,{quantities}");
    assert_eq!(data.lines().next(), Some(header.as_str()), "{figure}");
    let picture = figure["picture"].as_str().expect("a path");
    assert!(!place.read(picture).is_empty());
}

/// What the claims say, and that each was judged with the operator of its chapter.
fn assert_claims(claims: &[Value]) {
    // Areas are compared in planes that the statement names; Corollary 1 says *if*.
    for (id, words) in [
        ("C4a", "in the plane of α"),
        ("C4b", "α–β plane"),
        ("C7", "passive if"),
    ] {
        let claim = claims.iter().find(|claim| claim["id"] == id);
        assert_says(&claim.expect("judged")["statement"].to_string(), words);
    }
    for claim in claims {
        let judged = claim["verdict"].is_string() && claim["statement"].is_string();
        holds(judged, &claim);
        let operators = ["muir", "exact", "continuous", "oustaloup"].map(|key| &claim[key]);
        for one in operators.iter().filter(|one| !one.is_null()) {
            let open = claim["verdict"] == "not judged" && one["holds"].is_null();
            assert!(one["numbers"].is_string() && (open || one["holds"].is_boolean()));
        }
        let polynomial = !claim["muir"].is_null();
        let chapter_4 = claim["section"].to_string().contains('4');
        holds(polynomial == chapter_4, &claim);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_dissertation_is_made_again_and_judged() {
    let place = Place::new();
    let result = place.json("reproduce --out again");
    let figures = result["figures"].as_array().expect("figures").clone();
    let ids = |rows: &[Value]| -> String {
        let ids: Vec<&str> = rows.iter().filter_map(|one| one["id"].as_str()).collect();
        ids.join(" ")
    };
    assert_eq!(ids(&figures), "3.3 3.4 4.1 4.3 4.4 4.5 5.1 6.2 7.2");
    figures
        .iter()
        .for_each(|figure| assert_figure(&place, figure));
    let claims = result["claims"].as_array().expect("claims").clone();
    assert_eq!(
        ids(&claims),
        "C1 C2 C3 C4a C4b C4c C5 C6 C7 C8 C9 C10 C11 C12 C13 C14 C15 C16 C17"
    );
    assert_claims(&claims);
    // Self-contained.
    let html = place.text("again/report.html");
    assert_eq!(html.matches("<svg").count(), 9);
    assert_says(&html, "C17 & Sabancı University & Not compared are");
    assert_says(&place.text("again/report.md"), "| C7 | 5.1 |");
    // Not a second time into the same folder, unless asked.
    let again = place.run("reproduce --out again");
    again.refused(2, &["report.html", "--overwrite"]);
}
