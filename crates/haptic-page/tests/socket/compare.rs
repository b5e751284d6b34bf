//! Two walls are compared, blind: the table says what was felt of which, and nothing says it before.

use crate::{has, hello, opened};
use serde_json::{Value, json};
use std::path::Path;
use testkit::browser::Page;
use testkit::{assert_close, assert_relative};

const STIFFNESS: f64 = 300.0;

/// A spring, and a stiffer one beside it.
fn started(page: &mut Page, seed: u32, trials: u32) {
    let spring = json!({"order": 1, "stiffness_n_per_m": STIFFNESS, "dissipation_n_s_mu_per_m": 0});
    page.ask("feel.start", json!({"environment": {"wall": spring}}));
    page.ask("compare.start", compared(seed, trials));
}

fn compared(seed: u32, trials: u32) -> Value {
    let b = json!({"stiffness_n_per_m": 1.5 * STIFFNESS});
    json!({"b": b, "trials": trials, "subject": "p07", "seed": seed})
}

/// Asks for the next wall, and presses it once the handle was out.
fn press(page: &mut Page, trial: u32, wall: u32) {
    page.ask("compare.feel", json!({}));
    let hand = |position_m: f64| json!({"position_m": position_m, "held": true});
    let is_there = |status: &Value| {
        let compare = &status["compare"];
        compare["trial"] == trial && compare["wall"] == wall
    };
    page.ask("feel.hand", hand(-5e-3));
    page.status(|status| is_there(status) && status["position_m"].as_f64() < Some(-1e-3));
    page.ask("feel.hand", hand(5e-3));
    let felt = page.status(|status| is_there(status) && status["compare"]["touched"] == true);
    assert!(felt["compare"]["right"].is_null(), "{felt}");
}

/// Plays all trials, with an answer that is always 1; the end as `status` has it.
fn played(page: &mut Page, trials: u32) -> Value {
    for trial in 0..trials {
        press(page, trial, 1);
        press(page, trial, 2);
        page.ask("compare.answer", json!({"stiffer": 1}));
    }
    page.status(|status| status["compare"]["running"] == false)["compare"].take()
}

/// The rows of a table, each cell by its column.
fn rows(runs: &Path, ended: &Value) -> Vec<Value> {
    let name = ended["table"].as_str().expect("a name");
    let text = std::fs::read_to_string(runs.join(name)).expect("a table");
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let row = |line: &str| {
        let cells = columns.iter().zip(line.split(','));
        let cells = cells.map(|(column, cell)| {
            let cell = cell.parse().map_or_else(|_| json!(cell), |x: f64| json!(x));
            ((*column).to_owned(), cell)
        });
        Value::Object(cells.collect())
    };
    lines.map(row).collect()
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_comparison_is_played_to_its_end_and_its_table_says_what_was_felt() {
    let (runs, _server, mut page) = opened();
    started(&mut page, 11, 4);
    let felt = hello(&mut page)["feel"].take();
    let ended = played(&mut page, 4);
    let rows = rows(runs.path(), &ended);
    assert_eq!(rows.len(), 4);
    let opened = page.ask("runs.open", json!({"name": "compare-0001/compare"}));
    has(&opened, json!({"complete": true, "missing_samples": 0}));
    has(
        &opened["metadata"]["experiment"],
        json!({"experiment": "compare", "seed": "11"}),
    );
    let events = opened["events"].as_array().expect("events");
    let (mut stiffer, mut right, mut before) = (Vec::new(), 0, 0.0);
    for (trial, row) in rows.iter().enumerate() {
        let number = |key: &str| row[key].as_f64().expect("a number");
        has(
            row,
            json!({"subject": "p07", "trial": trial as f64, "catch": 0.0, "answer": 1.0, "log": "compare.mcap"}),
        );
        assert_close("difference", number("difference"), 0.5, 1e-12);
        // A spring's force over its depth is its stiffness, whatever the table says of it.
        let [first, second] = ["first", "second"]
            .map(|wall| number(&format!("{wall}_peak_n")) / number(&format!("{wall}_deepest_m")));
        let is_first = first > second;
        let is = if is_first { 1.0 } else { 2.0 };
        has(row, json!({"stiffer": is, "correct": 2.0 - is}));
        assert_relative("both", first + second, 2.5 * STIFFNESS, 1e-6);
        // In the order in which they were felt, by the time of the log.
        let times = [
            number("first_tick"),
            number("second_tick"),
            1e3 * number("answered_s"),
        ];
        assert!(
            before < times[0] && times[0] < times[1] && times[1] < times[2],
            "{row}"
        );
        before = times[2];
        let event_text = |at: usize| events[3 * trial + at]["text"].as_str().expect("words");
        let b = format!("K {} N/m", 1.5 * STIFFNESS);
        assert_eq!(
            [0, 1].map(|at| event_text(at).contains(&b)),
            [is_first, !is_first],
            "{events:?}"
        );
        assert_eq!(
            (event_text(2), &events[3 * trial + 2]["kind"]),
            ("1", &json!("answer"))
        );
        right += u32::from(is_first);
        stiffer.push(is);
    }
    has(&ended, json!({"trials": 4, "trial": 4, "right": right}));
    // Both orders, and none that anybody was told.
    assert!((1..4).contains(&right), "{stiffer:?}");
    let after = hello(&mut page)["feel"].take();
    assert_eq!(after, felt);
    // The same seed draws the same order.
    page.ask("compare.start", compared(11, 2));
    let again = self::rows(runs.path(), &played(&mut page, 2));
    let again: Vec<_> = again.iter().map(|row| row["stiffer"].as_f64()).collect();
    assert_eq!(again, [Some(stiffer[0]), Some(stiffer[1])]);
}

#[test]
fn what_is_no_comparison_is_refused_and_a_stop_begins_the_trial_anew() {
    let (runs, _server, mut page) = opened();
    page.refuses("compare.start", compared(1, 2), "nothing is felt yet");
    started(&mut page, 1, 2);
    page.refuses("compare.start", compared(1, 2), "`compare.end` first");
    page.refuses("feel.set", json!({"order": 0.5}), "`compare.end` first");
    page.refuses("compare.answer", json!({"stiffer": 1}), "before both walls");
    page.ask("compare.feel", json!({}));
    page.refuses("compare.feel", json!({}), "wall 1 was not touched yet");
    page.ask("stop", json!({}));
    page.status(|status| status["stopped"] == true && status["force_n"] == 0.0);
    page.refuses("compare.feel", json!({}), "`arm`");
    page.ask("arm", json!({}));
    page.status(|status| status["armed"] == true && status["compare"]["wall"] == 0);
    press(&mut page, 0, 1);
    press(&mut page, 0, 2);
    page.refuses("compare.feel", json!({}), "`compare.answer`");
    page.refuses("compare.answer", json!({"stiffer": 3}), "not 1 or 2");
    page.ask("compare.answer", json!({"stiffer": 2}));
    // What was answered stays when the rest is given up.
    page.ask("compare.end", json!({}));
    let ended = page.status(|status| status["compare"]["running"] == false)["compare"].take();
    assert_eq!(rows(runs.path(), &ended).len(), 1);
    page.refuses("compare.end", json!({}), "nothing is being compared");
    for (change, words) in [
        (json!({"trials": 0}), "`trials` = 0 is not"),
        (json!({"trials": 1.5}), "`trials` = 1.5 is not"),
        (
            json!({"subject": "a name"}),
            "`subject` = a name is not a code",
        ),
        (json!({"b": {}}), "both are the same"),
        (json!({"b": {"order": 0.5}}), "both are the same"),
        (json!({"rating_scale": [5, 5]}), "does not rise"),
        (json!({"b": {"stiffness_n_per_m": 1e7}}), "unstable"),
    ] {
        let mut asked = compared(1, 2);
        for (key, value) in change.as_object().expect("an object") {
            asked[key] = value.clone();
        }
        page.refuses("compare.start", asked, words);
    }
    // No folder is left of what was refused.
    let folders = std::fs::read_dir(runs.path()).expect("the runs").count();
    assert_eq!(folders, 1);
}

#[test]
fn tissues_are_compared_too_and_each_is_rated_before_anything_else() {
    let (runs, _server, mut page) = opened();
    let tissue = |name: &str| json!({"environment": {"tissue": name}});
    page.ask("feel.start", tissue("prostate-cancerous"));
    page.ask(
        "compare.start",
        json!({"b": tissue("liver"), "trials": 1, "subject": "p07", "seed": 2, "rating_scale": [0, 10]}),
    );
    let rated = |rating: f64| json!({"rating": rating});
    page.refuses("compare.rate", rated(3.0), "before a wall was felt");
    press(&mut page, 0, 1);
    page.refuses("compare.feel", json!({}), "wall 1 was not rated yet");
    page.refuses("compare.rate", rated(11.0), "not in [0, 10]");
    page.ask("compare.rate", rated(3.0));
    page.refuses("compare.rate", rated(4.0), "has its rating");
    press(&mut page, 0, 2);
    page.refuses(
        "compare.answer",
        json!({"stiffer": 1}),
        "wall 2 was not rated yet",
    );
    page.ask("compare.rate", rated(7.5));
    page.ask("compare.answer", json!({"stiffer": 1}));
    let ended = page.status(|status| status["compare"]["running"] == false)["compare"].take();
    let row = rows(runs.path(), &ended).remove(0);
    has(&row, json!({"first_rating": 3.0, "second_rating": 7.5}));
    // The stiffer tissue is pressed in less by more.
    let stiffness = |wall: &str| {
        let number = |key: &str| row[format!("{wall}_{key}")].as_f64().expect("a number");
        number("peak_n") / number("deepest_m")
    };
    let is_first = stiffness("first") > stiffness("second");
    has(&row, json!({"stiffer": if is_first { 1.0 } else { 2.0 }}));
    let opened = page.ask("runs.open", json!({"name": "compare-0001/compare"}));
    let events = opened["events"].as_array().expect("events");
    let kinds: Vec<_> = events.iter().map(|event| event["kind"].as_str()).collect();
    let all = ["feel", "rating", "feel", "rating", "answer"];
    assert_eq!(kinds, all.map(Some));
    let of_liver = |at: usize| events[at]["text"].to_string().contains("tissue liver");
    // Liver is B, the difference that of B.
    let is_b_first = is_first == (row["difference"].as_f64() > Some(0.0));
    assert_eq!([of_liver(0), of_liver(2)], [is_b_first, !is_b_first]);
}
