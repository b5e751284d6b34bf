//! Questions from forms: a Z-width, a design; and records that somebody measured.

use crate::{assert_documented, has, opened, ran};
use haptic_page::OnClose;
use serde_json::json;
use testkit::browser::Page;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_stiffest_walls_of_a_device_are_found_and_kept() {
    let (runs, _server, mut page) = opened();
    page.refuses(
        "runs.start",
        json!({"kind": "zwidth", "parameters": {"points": 1}}),
        "[2, 1000]",
    );
    page.refuses(
        "runs.start",
        json!({"kind": "zwidth", "realtime": true, "parameters": {}}),
        "leave `realtime` away",
    );
    let done = ran(
        &mut page,
        "zwidth",
        json!({"orders": [0, 1], "points": 2, "scheme": "muir:3"}),
    );
    has(&done, json!({"state": "done", "samples": 4}));
    let opened = page.ask("runs.open", json!({"name": "zwidth-0001/zwidth"}));
    assert_documented("runs.open", &opened);
    assert_eq!(opened["report"], done["report"]);
    let softest = &opened["report"]["orders"][1]["boundary"][0];
    // Trial and analysis find the same edge.
    let (tried, known) = (
        softest["stiffness_max"].as_f64().expect("a number"),
        softest["analysis_stiffness_n_per_m"]
            .as_f64()
            .expect("a number"),
    );
    assert!((tried / known - 1.0).abs() < 0.05, "{tried} and {known}");
    // It stays: another server finds it, and a view of it is refused.
    let again = crate::server(runs.path(), OnClose::Stop);
    let mut other = Page::open(again.address());
    let listed = other.ask("runs.list", json!({}))["runs"][0].clone();
    assert_eq!(
        (&listed["name"], &listed["kind"], &listed["verdict"]),
        (
            &json!("zwidth-0001/zwidth"),
            &json!("zwidth"),
            &done["verdict"]
        )
    );
    other.refuses(
        "view",
        json!({"source": "zwidth-0001/zwidth", "columns": 10}),
        "is an answer, not a log",
    );
    std::fs::write(runs.path().join("mine.answer.json"), "[]").expect("written");
    other.refuses("runs.open", json!({"name": "mine"}), "is no answer");
    let table = std::fs::read_to_string(runs.path().join("zwidth-0001/zwidth.csv"));
    assert_eq!(table.expect("a table").lines().count(), 5);
}

#[test]
fn a_design_proposes_an_experiment_that_runs() {
    let (runs, _server, mut page) = opened();
    for (number, given, kind) in [
        (1, json!({"orders": [1], "scheme": "muir:3"}), "wall"),
        (
            2,
            json!({"wish": "coupler", "orders": [1], "sample_time_s": 0.001}),
            "coupler",
        ),
    ] {
        let done = ran(&mut page, "design", given);
        assert_eq!(done["state"], "done", "{done}");
        let opened = page.ask(
            "runs.open",
            json!({"name": format!("design-{number:04}/design")}),
        );
        assert_documented("runs.open", &opened);
        let experiment = &opened["experiment"];
        assert_eq!(experiment["kind"], kind);
        let file = runs.path().join(format!("design-{number:04}/design.toml"));
        assert_eq!(
            experiment["text"].as_str(),
            std::fs::read_to_string(file).ok().as_deref()
        );
        // As the page runs it.
        let ran = ran(&mut page, kind, experiment["parameters"].clone());
        has(&ran, json!({"state": "done", "verdict": "stable"}));
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_question_is_stopped_and_keeps_what_it_found() {
    let (_runs, _server, mut page) = opened();
    page.ask(
        "runs.start",
        json!({"kind": "zwidth", "parameters": {"orders": [1], "points": 1000, "scheme": "muir:3", "device_model": "laboratory"}}),
    );
    page.wait("run", |run| run["samples_done"].as_u64() > Some(0));
    page.ask("runs.stop", json!({}));
    let stopped = page.wait("run", |run| run["state"] != "running");
    has(
        &stopped,
        json!({"state": "stopped", "error": "interrupted"}),
    );
    let opened = page.ask("runs.open", json!({"name": "zwidth-0001/zwidth"}));
    assert_eq!(opened["report"]["ended_early"], "interrupted");
    // Another may be asked.
    page.ask(
        "runs.start",
        json!({"kind": "design", "parameters": {"orders": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0], "scheme": "muir:3"}}),
    );
    page.ask("runs.stop", json!({}));
    let stopped = page.wait("run", |run| {
        run["kind"] == "design" && run["state"] != "running"
    });
    assert!(
        stopped["state"] == "stopped" || stopped["state"] == "done",
        "{stopped}"
    );
}

#[test]
fn a_record_is_identified_and_one_that_is_none_is_refused() {
    let (_runs, _server, mut page) = opened();
    // G(t) = 1000·t^(−0.2)/Γ(0.8): a spring-pot.
    let mut text = "time_s,relaxation_modulus_pa\n".to_owned();
    for n in 0..60 {
        let t = 10.0_f64.powf(-1.0 + f64::from(n) / 20.0);
        text += &format!("{t},{}\n", 1000.0 * t.powf(-0.2) / 1.164_229_713_725_303);
    }
    let found = page.ask(
        "identify",
        json!({"name": "gel.csv", "text": text, "model": "spring-pot"}),
    );
    assert_documented("identify", &found);
    has(&found, json!({"kind": "relaxation", "best": "spring-pot"}));
    let order = &found["models"][0]["parameters"][1];
    assert!(
        (order["value"].as_f64().expect("a number") - 0.2).abs() < 1e-6,
        "{order}"
    );
    for none in ["", "a,b\n1,2\n", "\u{0}\u{1}\u{2}", "time_s\n1\n2\n"] {
        let refused = page.refused("identify", json!({"name": "x.csv", "text": none}));
        assert!(
            refused.starts_with("x.csv") && !refused.contains('\n'),
            "{refused}"
        );
    }
}
