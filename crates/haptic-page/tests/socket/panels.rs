//! Questions of the page's panels: what is answered, what is refused, and that the newest wins.

use crate::{assert_documented, has, opened, question, ran, record};
use haptic_experiment::parameters::{
    CONTROL_DESIGN, CONTROL_LOOP, CROSSOVER, NOT_FLAT, PHASE_MARGIN, PLANT, PLANT_RECORD, RECORD,
    REFERENCE, VALIDATE,
};
use serde_json::{Value, json};
use testkit::{Random, assert_close, assert_relative};
use testkit::{assert_says, browser::Page};

/// A wall of the dissertation's device, with these keys instead of its own.
fn wall(other: &Value) -> Value {
    let mut wall = json!({
        "scheme": "exact", "order": 0.5, "stiffness_n_per_m": 3000, "dissipation_n_s_mu_per_m": 100,
        "mass_kg": 0.065, "damping_n_s_per_m": 3.5, "hand_stiffness_n_per_m": 0, "delay_s": 0,
        "current_lag_s": 0, "sample_time_s": 0.001, "position_noise_m": 1e-5, "points": 500,
    });
    for (key, value) in other.as_object().expect("an object") {
        wall[key] = value.clone();
    }
    question("design", "wall", wall)
}

fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().expect("a list").iter();
    numbers.map(|x| x.as_f64().expect("a number")).collect()
}

/// True within a polygon of B, K, by the even number of crossings outside.
fn is_inside(polygon: &Value, at: [f64; 2]) -> bool {
    let corners: Vec<_> = polygon
        .as_array()
        .expect("corners")
        .iter()
        .map(numbers)
        .collect();
    let before = corners.iter().cycle().skip(corners.len() - 1);
    let crossed = corners.iter().zip(before).filter(|(a, b)| {
        (a[1] > at[1]) != (b[1] > at[1])
            && at[0] < a[0] + (b[0] - a[0]) * (at[1] - a[1]) / (b[1] - a[1])
    });
    crossed.count() % 2 == 1
}

#[test]
fn a_wall_is_judged_and_stands_where_the_map_says() {
    let (_runs, _server, mut page) = opened();
    let found = page.ask("ask", wall(&json!({})));
    assert_documented("wall", &found);
    has(&found, json!({"stable": true, "passive": false}));
    let margin = found["gain_margin"].as_f64().expect("a margin");
    let [outline] = &found["region"].as_array().expect("polygons")[..] else {
        panic!("one polygon");
    };
    for (factor, stable) in [(0.999, true), (1.001, false)] {
        let [b, k] = [100.0, 3000.0].map(|gain| factor * margin * gain);
        assert_eq!(is_inside(outline, [b, k]), stable, "{factor}");
        let scaled = json!({"stiffness_n_per_m": k, "dissipation_n_s_mu_per_m": b});
        has(&page.ask("ask", wall(&scaled)), json!({"stable": stable}));
    }
    // Fewer points, the same edge.
    let coarse = page.ask("ask", wall(&json!({"points": 200})));
    let corners = |found: &Value| found["region"][0].as_array().expect("corners").len();
    assert!(corners(&coarse) < corners(&found));
    assert_eq!(coarse["gain_margin"], found["gain_margin"]);
    // Just inside the edge of the passive walls one is passive, just outside none.
    let edge = numbers(&found["passive_walls"][7]);
    for (factor, passive) in [(0.999, true), (1.001, false)] {
        let [b, k] = [factor * edge[0], factor * edge[1]];
        let scaled = json!({"stiffness_n_per_m": k, "dissipation_n_s_mu_per_m": b});
        has(&page.ask("ask", wall(&scaled)), json!({"passive": passive}));
    }
}

#[test]
fn a_wall_is_judged_as_by_the_questions_of_the_command() {
    let (_runs, _server, mut page) = opened();
    for scheme in ["exact", "full", "full-bdf2:1e-4", "muir:3", "grunwald:60"] {
        let held =
            json!({"scheme": scheme, "order": 0.3, "delay_s": 1e-3, "hand_stiffness_n_per_m": 300});
        let asked = wall(&held);
        let mut keys = asked["question"]["wall"].clone();
        for of_page in ["points", "position_noise_m"] {
            keys[of_page].take();
        }
        let found = page.ask("ask", asked);
        for (kind, shared) in [
            (
                "analyze-stability",
                ["stable", "gain_margin", "pulling_contact_margin"],
            ),
            (
                "analyze-passivity",
                ["passive", "negative_at_rest", "required_damping_n_s_per_m"],
            ),
        ] {
            let known = ran(&mut page, kind, keys.clone());
            for key in shared {
                assert_eq!(found[key], known["report"][key], "{scheme}: {key}");
            }
        }
        // The hand moves the device: its spring is not of it.
        keys["hand_stiffness_n_per_m"].take();
        let known = ran(&mut page, "analyze-difference", keys)["report"].take();
        has(&found["hand"], known["spring_and_damper"].clone());
        for best in [
            "best_stiffness_n_per_m",
            "best_damping_n_s_per_m",
            "best_stable",
        ] {
            assert_eq!(found["hand"][best], known[best], "{scheme}: {best}");
        }
        assert!(
            known["spring_and_damper"]["frequency_hz"].is_number(),
            "{known}"
        );
    }
}

#[test]
fn a_hand_should_tell_no_spring_from_the_best_one_and_a_loop_too_slow_for_it_says_so() {
    let (_runs, _server, mut page) = opened();
    let mut hand = |other: Value| page.ask("ask", wall(&other))["hand"].take();
    let spring = hand(json!({"dissipation_n_s_mu_per_m": 0, "points": 16}));
    // The best spring of a loop is the spring of that loop, held and delayed as it is.
    let difference = spring["difference"].as_f64().expect("a number");
    assert!(difference < 1e-6, "{difference}");
    let stiffness = spring["best_stiffness_n_per_m"].as_f64().expect("a number");
    assert_relative("K", stiffness, 3000.0, 1e-7);
    has(&spring, json!({"felt": false}));
    let fractional = json!({"stiffness_n_per_m": 0, "points": 16});
    let felt = hand(fractional.clone());
    // With the damping of a hand in the loop, the device as it is without.
    let mut held = fractional;
    held["damping_n_s_per_m"] = 9.0.into();
    assert_ne!(hand(held.clone()), felt);
    held["device_damping_n_s_per_m"] = 3.5.into();
    assert_eq!(hand(held), felt);
    let slow = hand(
        json!({"sample_time_s": 0.2, "stiffness_n_per_m": 10, "dissipation_n_s_mu_per_m": 0, "points": 16}),
    );
    let reason = slow["reason"].as_str().expect("a reason");
    assert_says(&reason, "half the sample rate");
}

#[test]
fn a_spring_makes_the_noise_and_the_curves_of_a_spring() {
    let (_runs, _server, mut page) = opened();
    let found = page.ask("ask", wall(&json!({"dissipation_n_s_mu_per_m": 0})));
    let noise = found["force_noise_n"].as_f64().expect("a number");
    assert_relative("noise", noise, 3000.0 * 1e-5, 1e-12);
    let curves = found["curves"].as_array().expect("rows");
    let curves: Vec<Vec<f64>> = curves.iter().map(numbers).collect();
    assert_close("lowest", curves[0][0], 0.1, 1e-12);
    assert_relative("highest", curves[curves.len() - 1][0], 500.0, 1e-12);
    assert!(curves.iter().all(|row| row[1..3] == [3000.0, 0.0]));
    // K − mω², and the half sample of the hold takes KT/2 of the damping away.
    let row = &curves[40];
    let omega = 2.0 * std::f64::consts::PI * row[0];
    assert_relative("felt", row[3], 3000.0 - 0.065 * omega * omega, 1e-3);
    assert_relative("felt", row[4], 3.5 - 1.5, 1e-3);
}

#[test]
fn bad_input_gets_a_line_that_names_it_and_the_page_goes_on() {
    let (_runs, _server, mut page) = opened();
    for [given, words] in testkit::table(
        r#"
        {"stiffness_n_per_m": null} | `stiffness_n_per_m` is missing
        {"mass_kg": 0} | mass_kg = 0 is not above 0
        {"order": 3} | order = 3
        {"order": "x"} | order = "x" is a string
        {"sample_time_s": -1} | sample_time_s = -1
        {"scheme": "fly"} | fly
        {"scheme": "grunwald:301"} | at most 300
        {"points": 100000} | `points` = 100000 is not in [16, 500]
        {"points": 15} | [16, 500]
        {"points": -1} | -1
        {"delay_s": 1} | delay
        {"colour": 1} | unknown key `colour`
        "#,
    ) {
        let given = given.parse().expect("JSON");
        let refused = page.refused("ask", wall(&given));
        assert!(refused.contains(&words), "{given}: {refused}");
        assert!(!refused.contains('\n'), "{refused}");
    }
    for [asked, words] in testkit::table(
        r#"
        {"panel": "design"} | missing field `question`
        {"panel": "design", "question": {"dance": {}}} | unknown variant `dance`
        {"panel": "attic", "question": {"wall": {}}} | unknown variant `attic`
        {"panel": "design", "question": {"wall": {}}} | missing field `points`
        {"panel": "design", "question": {"wall": 7}} | WallQuestion
        "#,
    ) {
        page.refuses("ask", asked.parse().expect("JSON"), &words);
    }
    page.send(r#"{"do": "ask", "panel": "design"}"#);
    let answer = page.answer(&json!(null));
    let message = answer["error"].as_str().expect("a sentence");
    assert_says(&message, "`id`");
    // Numbers of any size: an answer or a line, and never a panic.
    let mut random = Random(56);
    for _ in 0..testkit::cases(200) {
        let mut given = json!({"scheme": random.one_of(&["exact", "full", "muir:3"])});
        for key in [
            "order",
            "stiffness_n_per_m",
            "dissipation_n_s_mu_per_m",
            "mass_kg",
            "damping_n_s_per_m",
            "hand_stiffness_n_per_m",
            "delay_s",
            "current_lag_s",
            "sample_time_s",
            "position_noise_m",
        ] {
            if random.chance(0.5) {
                given[key] = json!(random.log_between(1e-12, 1e12));
            }
        }
        let number = page.post("ask", wall(&given));
        let answer = page.answer(&json!(number));
        if answer["ok"] == false {
            let message = answer["error"].as_str().expect("a sentence");
            let is_line = !message.contains('\n') && !message.contains("terminal");
            assert!(is_line, "{given}: {message}");
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_newest_question_of_a_panel_wins_and_those_before_it_are_given_up() {
    let (_runs, _server, mut page) = opened();
    // Minutes of work, one after the other.
    let long = record(20_000);
    let asked: Vec<u64> = (0..40).map(|_| page.post("ask", long.clone())).collect();
    // Another panel does not wait for it.
    page.ask("ask", wall(&json!({})));
    let newest = page.post("ask", record(0));
    let answer = page.answer(&json!(newest));
    assert!(
        answer["error"]
            .as_str()
            .expect("a sentence")
            .starts_with("x.csv")
    );
    let given_up = |page: &mut Page, id: u64| page.answer(&json!(id))["error"].take();
    for id in asked {
        let message = given_up(&mut page, id);
        let words = [
            "a newer question from this panel has replaced this one",
            "x.csv: interrupted",
        ];
        assert!(words.map(Value::from).contains(&message), "{message}");
    }
}

#[test]
fn a_record_of_a_plant_is_identified_tried_on_another_and_has_all_keys_of_the_command() {
    let (_runs, _server, mut page) = opened();
    // 2·exp(−0.3 s)/(s + 1) after a step.
    let rows = (0..100).map(|n| {
        let t = 0.05 * f64::from(n);
        format!("{t},1,{}\n", -2.0 * f64::exp_m1(-(t - 0.3).max(0.0)))
    });
    let text = format!("time_s,input,level\n{}", rows.collect::<String>());
    let again = json!({"name": "again.csv", "text": text});
    let plant = |key: &str, value: Value| {
        let asked = json!({"name": "tank.csv", "text": text, "columns": "output=level", "more": [again], key: value});
        question("identify", "plant_record", asked)
    };
    let found = page.ask("ask", plant("poles", json!(1)));
    assert_documented("plant_record", &found);
    assert_close(
        "dead time",
        found["delay_s"].as_f64().expect("s"),
        0.3,
        1e-3,
    );
    has(
        &found,
        json!({"begins": "at rest", "samples": 100, "unstable_poles": 0}),
    );
    let fit = found["validation"]["fit"].as_f64().expect("a fit");
    assert!(fit > 0.999, "{fit}");
    let file = page.ask("file", found["file"].clone());
    has(&file, json!({"is": "plant"}));
    for (key, value, words) in [
        ("poles", json!(5), "`poles` = 5 is not from 1 to 4"),
        ("more", json!([again, again]), "give one record"),
        ("colour", json!(1), "unknown field `colour`"),
    ] {
        page.refuses("ask", plant(key, value), words);
    }
    let forms = page.ask("runs.forms", json!({}));
    let design = [&CONTROL_LOOP[..1], CONTROL_DESIGN].concat();
    for (question, tables) in [
        ("record", RECORD),
        ("plant_record", PLANT_RECORD),
        ("control_design", &design),
        ("control_loop", CONTROL_LOOP),
    ] {
        let fields = forms[question].as_array().expect("fields").iter();
        let fields: Vec<&str> = fields.filter_map(|field| field["key"].as_str()).collect();
        let keys = tables.iter().flat_map(|(_, table)| *table);
        // Records are files; plant, crossover, margin and flat phase have controls of their own.
        let of_page = [
            VALIDATE,
            REFERENCE,
            PLANT,
            CROSSOVER,
            PHASE_MARGIN,
            NOT_FLAT,
        ];
        let keys = keys.filter(|one| !of_page.contains(one));
        assert_eq!(fields, keys.map(|one| one.key).collect::<Vec<_>>());
    }
}

#[test]
fn a_tissue_remembers_where_its_law_pushes_with_nothing() {
    let (_runs, _server, mut page) = opened();
    page.refuses("surface", json!({"depths_m": []}), "no `law` yet");
    let (order, stiffness, dissipation, step) = (0.3, 20.0, 80.0, 0.02);
    let law = json!({"order": order, "stiffness_n_per_m": stiffness, "dissipation_n_s_mu_per_m": dissipation, "step_s": step});
    let depth = |n: i32| {
        if n < 150 {
            4e-3 * f64::from(n) / 150.0
        } else {
            0.0
        }
    };
    let depths: Vec<f64> = (0..200).map(depth).collect();
    let first = page.ask("surface", json!({"law": law, "depths_m": depths[..120]}));
    assert_documented("surface", &first);
    let set = page.ask("surface", json!({"depths_m": depths[120..]}))["surface_m"].take();
    let set = set.as_f64().expect("a number");
    // The defining sum, with the depth that follows.
    let (mut weight, mut sum) = (1.0, set);
    for (k, depth) in (1..).zip(depths.iter().rev()) {
        weight *= 1.0 - (order + 1.0) / f64::from(k);
        sum += weight * depth;
    }
    let force = stiffness * set + dissipation * f64::powf(step, -order) * sum;
    assert!(set > 1e-5, "{set}");
    assert_close("force", force, 0.0, 1e-3 * stiffness * set);
    // Untouched again.
    let anew = page.ask("surface", json!({"law": law, "depths_m": [0]}));
    has(&anew, json!({"surface_m": 0.0}));
    for (surface, words) in [
        (json!({"depths_m": vec![0.0; 3001]}), "at most 3000"),
        (json!({"depths_m": [null]}), "null"),
        (
            json!({"law": {"order": 9, "stiffness_n_per_m": 0, "dissipation_n_s_mu_per_m": 1, "step_s": 0.02}, "depths_m": []}),
            "order 9",
        ),
    ] {
        page.refuses("surface", surface, words);
    }
}
