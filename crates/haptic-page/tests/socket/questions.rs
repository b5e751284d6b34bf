//! Questions from forms: a Z-width, a design; and records that somebody measured.

use crate::{assert_documented, ended, has, opened, question, ran, refuses};
use haptic_page::OnClose;
use haptic_question::controller::DesignForm;
use haptic_question::controller::report::designed;
use serde_json::{Value, json};
use testkit::{assert_close, assert_relative};
use testkit::{assert_says, browser::Page};

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_stiffest_walls_of_a_device_are_found_and_kept() {
    let (runs, _server, mut page) = opened();
    refuses(&mut page, "zwidth", json!({"points": 1}), "2 to 1000");
    let by_clock = json!({"kind": "zwidth", "realtime": true, "parameters": {}});
    page.refuses("runs.start", by_clock, "omit `realtime`");
    let asked = json!({"orders": [0, 1], "points": 2, "scheme": "muir:3"});
    let done = ran(&mut page, "zwidth", asked);
    has(&done, json!({"state": "done", "samples": 4}));
    let opened = page.ask("runs.open", json!({"name": "zwidth-0001/zwidth"}));
    assert_documented("runs.open", &opened);
    assert_eq!(opened["report"], done["report"]);
    let softest = &opened["report"]["orders"][1]["boundary"][0];
    // Trial and analysis find the same edge.
    let number = |key: &str| softest[key].as_f64().expect("a number");
    let known = number("analysis_stiffness_n_per_m");
    assert_relative("edge", number("stiffness_max"), known, 0.05);
    // It stays: another server finds it, and a view of it is refused.
    let again = crate::server(runs.path(), OnClose::Stop);
    let mut other = Page::open(again.address());
    let listed = other.ask("runs.list", json!({}))["runs"][0].clone();
    let name = "zwidth-0001/zwidth";
    has(
        &listed,
        json!({"name": name, "kind": "zwidth", "verdict": done["verdict"]}),
    );
    let view = json!({"source": name, "columns": 10});
    other.refuses("view", view, "is an answer, not a log");
    std::fs::write(runs.path().join("mine.answer.json"), "[]").expect("written");
    other.refuses("runs.open", json!({"name": "mine"}), "is not an answer");
    let table = std::fs::read_to_string(runs.path().join("zwidth-0001/zwidth.csv"));
    assert_eq!(table.expect("a table").lines().count(), 5);
    let specimen = ran(&mut page, "zwidth", json!({"tissue": "liver"}));
    let verdict = specimen["verdict"].as_str().expect("words");
    assert!(verdict.starts_with("liver: up to 6"), "{verdict}");
}

#[test]
fn a_design_proposes_an_experiment_that_runs() {
    let (runs, _server, mut page) = opened();
    let wall = json!({"orders": [1], "scheme": "muir:3"});
    let coupler = json!({"wish": "coupler", "orders": [1], "sample_time_s": 0.001});
    for (number, given, kind) in [(1, wall, "wall"), (2, coupler, "coupler")] {
        let done = ran(&mut page, "design", given);
        assert_eq!(done["state"], "done", "{done}");
        let name = json!({"name": format!("design-{number:04}/design")});
        let opened = page.ask("runs.open", name);
        assert_documented("runs.open", &opened);
        let experiment = &opened["experiment"];
        assert_eq!(experiment["kind"], kind);
        let file = runs.path().join(format!("design-{number:04}/design.toml"));
        let file = std::fs::read_to_string(file).expect("written");
        assert_eq!(experiment["text"], file);
        // As the page runs it.
        let ran = ran(&mut page, kind, experiment["parameters"].clone());
        has(&ran, json!({"state": "done", "verdict": "stable"}));
    }
    let undamped = json!({"orders": [1], "require": "passive", "damping_n_s_per_m": 0});
    let none = ran(&mut page, "design", undamped);
    let why =
        "no candidate meets the wish: none is passive: the device has no damping; ask for less";
    assert_says(&none["verdict"], why);
    let name = json!({"name": "design-0003/design"});
    assert_eq!(page.ask("runs.open", name)["verdict"], none["verdict"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_question_is_stopped_and_keeps_what_it_found() {
    let (_runs, _server, mut page) = opened();
    let asked =
        json!({"orders": [1], "points": 1000, "scheme": "muir:3", "device_model": "laboratory"});
    page.ask("runs.start", json!({"kind": "zwidth", "parameters": asked}));
    page.wait("run", |run| run["samples_done"].as_u64() > Some(0));
    page.ask("runs.stop", json!({}));
    let stopped = ended(&mut page, |_| true);
    has(
        &stopped,
        json!({"state": "stopped", "error": "interrupted"}),
    );
    let opened = page.ask("runs.open", json!({"name": "zwidth-0001/zwidth"}));
    assert_eq!(opened["report"]["ended_early"], "interrupted");
    // Another may be asked.
    let orders = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
    let asked = json!({"orders": orders, "scheme": "muir:3"});
    page.ask("runs.start", json!({"kind": "design", "parameters": asked}));
    page.ask("runs.stop", json!({}));
    let stopped = ended(&mut page, |run| run["kind"] == "design");
    assert!(
        ["stopped", "done"]
            .map(Value::from)
            .contains(&stopped["state"]),
        "{stopped}"
    );
}

fn asked(wishes: Value) -> Value {
    question("control", "control", wishes)
}

#[test]
fn a_controller_is_designed_with_the_margins_and_sentences_of_the_command() {
    let (_runs, _server, mut page) = opened();
    // The tank of Monje and others, 2008.
    let wishes =
        json!({"plant": "0.55exp(-s)/(62s+1)", "crossover_rad_s": 0.1, "phase_margin_rad": 1.2});
    let found = page.ask("ask", asked(wishes));
    assert_documented("control", &found);
    // The margins are those of the command.
    let wished = json!({"crossover_rad_s": 0.1, "phase_margin_rad": 1.2});
    let wished: DesignForm = serde_json::from_value(wished).expect("a form");
    let plant = "0.55exp(-s)/(62s+1)".parse().expect("a plant");
    let report = designed(wished.design(plant).expect("wishes")).expect("a controller");
    let margins = &report.report("")["margins"];
    // Written and read as the answer is: the reader of the test may miss the last bit.
    let margins: Value = margins.to_string().parse().expect("JSON");
    assert_eq!(found["fractional"]["margins"], margins);
    for which in ["fractional", "integer"] {
        let one = &found[which];
        has(one, json!({"stable": true, "verdict": "stable, proved"}));
        let number = |key: &str| one["margins"][key].as_f64().expect("a number");
        let margin = number("phase_margin_deg").to_radians();
        assert_relative("margin", margin, 1.2, 0.01);
        assert_relative("crossover", number("crossover_rad_s"), 0.1, 0.01);
        let step = one["step"].as_array().expect("a step");
        assert_close(
            "settled",
            step[step.len() - 1].as_f64().expect("a number"),
            1.0,
            0.02,
        );
    }
    assert!(
        found["file"]
            .as_str()
            .expect("a file")
            .contains("integral_order")
    );
    // What the command says: how the plant was read, and that the loop does not settle.
    for (plant, margin, message) in [
        (
            "1/(s+1)(2s+1)",
            1.2,
            "what follows \"1/(s+1)\" multiplies; put brackets around \"(2s+1)\"",
        ),
        ("1/(s^0.5+1)", 2.094, "It does not settle in the time shown"),
    ] {
        let wishes = json!({"plant": plant, "crossover_rad_s": 3.0, "phase_margin_rad": margin, "not_flat": false});
        let notes = page.ask("ask", asked(wishes))["notes"].take();
        let notes = notes.as_array().expect("sentences").iter();
        let mut notes = notes.map(|note| note.as_str().expect("a sentence"));
        assert!(notes.any(|note| note.contains(message)), "{plant}");
    }
}

#[test]
fn a_loop_is_judged_and_run_as_the_command_does_it() {
    let (_runs, _server, mut page) = opened();
    let asked = |name: &str, key: &str, value: Value| {
        let text = "[pid]\nproportional_gain = 1\n[loop]\nsample_time_s = 0.01\n";
        let file = json!({"name": "p.toml", "text": text});
        let given = json!({"plant": "1/(s+1)", "controller_file": file, key: value});
        question("loop", name, given)
    };
    // A gain of 1 over 1/(s + 1) rests at half of its reference, a ramp that is held between its rows.
    let ramp = json!({"name": "ramp.csv", "text": "time_s,reference\n0,0\n1,1\n2,2\n20,2\n"});
    let run = page.ask("ask", asked("simulate", "reference_file", ramp));
    assert_documented("simulate", &run);
    has(
        &run["report"],
        json!({"stable": true, "at_reference": false}),
    );
    let warnings = run["report"]["warnings"].to_string();
    assert_says(&warnings, "the loop rests beside it");
    assert_close(
        "output",
        run["output"][500].as_f64().expect("a number"),
        1.0,
        1e-3,
    );
    assert_eq!(run["reference"][37], 1.0);
    let judged = page.ask("ask", asked("analyze", "delay_s", json!(0.1)));
    assert_documented("analyze", &judged);
    let reason = judged["report"]["reason"].as_str().expect("a sentence");
    assert!(reason.starts_with("Stable, proved."), "{reason}");
    for [key, value, words] in testkit::table(
        r#"
        plant | "plant.toml" | plant "plant.toml"
        reference_file | {"name": "ramp.csv", "text": "time_s"} | ramp.csv: no row with numbers
        scheme | "muir:3" | `scheme`: scheme "muir:3" is not for a controller
        mass_kg | 1 | `mass_kg` belongs to a device: give `mass_kg` and no `plant`
        "#,
    ) {
        let value = value.parse().expect("JSON");
        page.refuses("ask", asked("simulate", &key, value), &words);
    }
}
