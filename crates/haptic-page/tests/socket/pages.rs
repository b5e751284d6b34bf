//! Several pages, pages that go, pages that talk garbage.

use crate::{below, has, held_at, hello, opened, prostate, record, served, server, two_with_force};
use haptic_page::OnClose;
use serde_json::{Value, json};
use std::time::Instant;
use testkit::browser::{PATIENCE, Page};
use testkit::{Random, cases};

#[test]
fn one_page_holds_the_controls_and_the_others_watch() {
    let (_runs, server) = served();
    let mut first = Page::open(server.address());
    assert_eq!(hello(&mut first)["controls"], true);
    let mut second = Page::open(server.address());
    let hello = hello(&mut second);
    has(&hello, json!({"controls": false, "watching": 1}));
    second.refuses("controls.take", json!({}), "let them go there");
    first.ask("controls.release", json!({}));
    second.ask("controls.take", json!({}));
    first.refuses("feel.start", prostate(), "controls.take");
    first.ask("controls.take", json!({"force": true}));
    let taken = "another page has taken the controls";
    second.wait("notice", |notice| notice == taken);
    // Both see what is felt.
    first.ask("feel.start", prostate());
    let tissue = "prostate-cancerous";
    second.wait("feel", |feel| feel["environment"]["tissue"] == tissue);
    let view = json!({"source": "live", "last_s": 1, "columns": 100});
    second.ask("view", view);
    second.frame(|frame| frame.columns > 10);
    second.refuses("hello", json!({"version": 2}), "reload the page");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_page_that_goes_stops_what_it_controlled_or_not_as_asked() {
    let runs = tempfile::tempdir().expect("a folder");
    for (on_close, goes_on) in [(OnClose::Stop, false), (OnClose::Continue, true)] {
        let server = server(runs.path(), on_close);
        let mut watcher = {
            let mut page = Page::open(server.address());
            page.ask("feel.start", prostate());
            held_at(&mut page, 5e-3);
            page.status(|status| below(&status["force_n"], -0.1));
            let mut watcher = Page::open(server.address());
            // Answered, so it is there before the first goes, without a word.
            hello(&mut watcher);
            watcher
        };
        // A busy machine tells of a page that has gone before it tells of the loop.
        let seen = watcher.status(|status| status["watching"] == 0 && status["tick"].is_u64());
        let tick = seen["tick"].as_u64().expect("a tick");
        if goes_on {
            let status = watcher.status(|status| status["tick"].as_u64() > Some(tick + 300));
            assert!(below(&status["force_n"], -0.05), "{status}");
        } else {
            watcher.status(|status| status["stopped"] == true && status["force_n"] == 0.0);
        }
        watcher.ask("controls.take", json!({}));
    }
}

#[test]
fn garbage_is_answered_and_closes_the_socket_the_third_time() {
    let (_runs, server, mut page) = opened();
    for garbage in ["", "{\"id\": 1"] {
        page.send(garbage);
        let answer = page.answer(&json!(null));
        assert_eq!(answer["ok"], false);
        let message = answer["error"].as_str().expect("a sentence");
        assert!(!message.contains('\n'), "{message}");
    }
    // Something sensible in between starts anew.
    hello(&mut page);
    page.refuses("dance", json!({}), "not understood");
    for _ in 0..3 {
        page.send("☃");
    }
    let three = "1008: three messages in a row were no requests";
    assert_eq!(page.closed(), three);
    // The next page finds a server.
    Page::open(server.address()).ask("hello", json!({"version": 1}));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_page_that_does_not_read_is_closed_and_can_stop_until_then() {
    let (_runs, server) = served();
    let (mut page, mut watcher) = two_with_force(server.address());
    // Frames and answers that nobody reads: the queue is bounded, so the socket goes, and with the controls the force.
    let view = json!({"source": "live", "last_s": 30, "columns": 8192});
    page.ask("view", view);
    std::thread::scope(|scope| {
        // The other page reads meanwhile, however long this takes: it would be silent, and closed, too.
        scope.spawn(|| {
            watcher.status(|status| status["stopped"] == true && status["force_n"] == 0.0);
            watcher.ask("controls.take", json!({}));
        });
        for _ in 0..100_000 {
            if page.try_post("runs.forms", json!({})).is_err() {
                break;
            }
        }
    });
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_is_worked_on_is_bounded_for_the_server_and_given_up_with_its_page() {
    let (_runs, server, first) = opened();
    // Minutes of work.
    let long = record(20_000)["question"].take();
    let more = (0..3).map(|_| Page::open(server.address()));
    let mut pages: Vec<Page> = std::iter::once(first).chain(more).collect();
    for page in &mut pages {
        for panel in ["design", "safety", "control", "identify"] {
            page.post("ask", json!({"panel": panel, "question": long}));
        }
        // Answered, so those before it are being worked on.
        hello(page);
    }
    let mut other = Page::open(server.address());
    let all = "sixteen requests are being worked on";
    other.refuses("ask", record(0), all);
    // Stop is heard all the same.
    other.ask("stop", json!({}));
    // Nobody waits for the work of a page that has gone.
    drop(pages);
    let until = Instant::now() + PATIENCE;
    while other.refused("ask", record(0)).contains(all) {
        assert!(Instant::now() < until, "it is worked on for nobody");
    }
    drop(server);
    assert_eq!(other.closed(), "1001: the server was stopped");
}

#[test]
fn a_page_that_falls_behind_is_told_and_goes_on_where_it_was() {
    let (_runs, server, mut page) = opened();
    page.acknowledges = false;
    page.ask("feel.start", prostate());
    let view = json!({"source": "live", "last_s": 1, "columns": 1000});
    page.ask("view", view.clone());
    // Frames stop, and nothing is said of samples that were left out: they still come.
    let waits = page.status(|status| status["picture_late_s"].as_f64() > Some(0.5));
    let still = page.status(|status| status["picture_late_s"].as_f64() > Some(0.8));
    assert_eq!(still["samples_sent"], waits["samples_sent"]);
    let newest = page.frames.pop().expect("a frame");
    page.acknowledges = true;
    page.acknowledge(&newest);
    page.frame(|frame| frame.columns > 900);
    page.status(|status| status["picture_late_s"].as_f64() < Some(0.5));
    // A page that comes anew has nothing to go on from: its first picture is whole.
    let mut again = Page::open(server.address());
    again.ask("view", view);
    assert!(again.frame(|_| true).columns > 900);
}

#[test]
fn a_stop_is_answered_before_what_is_read_and_worked_on_for_its_page_and_others() {
    let (_runs, server, mut page) = opened();
    let law = json!({"order": 0.5, "stiffness_n_per_m": 10, "dissipation_n_s_mu_per_m": 1, "step_s": 0.02});
    let wide = "[wall]\norder = [".to_owned() + &"0.5, ".repeat(1 << 18) + "1]";
    let long = [
        ("file", json!({"name": "x.toml", "text": wide})),
        ("surface", json!({"law": law, "depths_m": vec![1e-3; 3000]})),
        (
            "quantity",
            json!({"key": "_s", "text": "[".repeat(200_000)}),
        ),
    ];
    let mut watcher = Page::open(server.address());
    for other in [&mut watcher, &mut page] {
        for (what, arguments) in &long {
            other.post(what, arguments.clone());
        }
    }
    let stop = page.post("stop", json!({}));
    let mut ids = std::iter::repeat_with(|| page.read().expect("open")["id"].take());
    assert_eq!(ids.find(Value::is_u64), Some(json!(stop)));
    let asked = watcher.answer(&json!(3));
    let message = asked["error"].as_str().expect("refused");
    let short = "\"[[[[[[[[[[[[[[[[[[[[…\" is not a time: give at most 64 characters";
    assert_eq!(message, short);
}

/// Something of another type, or none that is meant.
fn wrong(random: &mut Random) -> Value {
    let long = "\u{1f41f}[\n`é".repeat(500);
    let deep = (0..60).fold(json!(0), |deep, _| json!([deep]));
    let all = json!([null, true, -1, 1.5e308, u64::MAX, "", long, [], {}, [long, 1], {&long: long}, deep,
        "../../etc/passwd", "65 g, NaN; inf"]);
    let all: Vec<&Value> = all.as_array().into_iter().flatten().collect();
    random.one_of(&all).clone()
}

/// A request with something wrong in one place; the place may be a key.
fn spoilt(request: &Value, random: &mut Random) -> Value {
    let Some(fields) = request.as_object().filter(|_| random.chance(0.9)) else {
        return wrong(random);
    };
    let names: Vec<&String> = fields.keys().collect();
    let (mut spoilt, name) = (fields.clone(), random.one_of(&names));
    let field = spoilt.remove(name).expect("it is there");
    let other = wrong(random);
    let other = other.as_str().filter(|_| random.chance(0.2));
    spoilt.insert(
        other.unwrap_or(name).to_owned(),
        self::spoilt(&field, random),
    );
    spoilt.into()
}

/// Requests, each as a name and its arguments.
const REQUESTS: &str = r#"
    hello {"version": 1}
    controls.take {"force": true}
    feel.start {"environment": {"wall": {"order": 0.5, "stiffness_n_per_m": 100, "dissipation_n_s_mu_per_m": 1, "scheme": "full"}}, "ghosts": ["short"], "device": {"mass_kg": 0.065}, "order": 0.5, "scale": 1}
    feel.start {"environment": {"file": {"name": "x.toml", "text": "[wall]\norder = 1"}}}
    feel.set {"environment": {"tissue": "liver"}, "order": 0.5, "scale": 1, "ghosts": ["a3"]}
    feel.hand {"position_m": 0, "held": true}
    compare.start {"b": {"scale": 1.2}, "trials": 2, "subject": "p07", "seed": 1}
    compare.answer {"stiffer": 1}
    feel.pause {"paused": false}
    feel.mark {"text": "x"}
    view {"source": "live", "from_s": 0, "to_s": 1, "columns": 10, "channels": ["x"]}
    tissue.keep {"name": "x", "text": "name = 1"}
    file {"name": "x.toml", "text": "[wall]"}
    runs.open {"name": "x"}
    runs.table {"name": "x", "channels": ["y"], "from_s": 0}
    runs.start {"kind": "wall", "parameters": {"order": "x", "mass_kg": [1]}, "realtime": false}
    ask {"panel": "design", "question": {"wall": {"scheme": "exact", "order": 0.5, "stiffness_n_per_m": 100, "dissipation_n_s_mu_per_m": 1, "mass_kg": 0.065, "damping_n_s_per_m": 3.5, "hand_stiffness_n_per_m": 0, "delay_s": 0, "current_lag_s": 0, "sample_time_s": 0.001, "position_noise_m": 0, "points": 16}}}
    ask {"panel": "control", "question": {"control": {"plant": "1/(s+1)", "crossover_rad_s": 1, "phase_margin_rad": 1, "not_flat": true, "plant_file": {"name": "p.toml", "text": "[transfer_function]"}, "controller_file": {"name": "c", "text": "[pid]"}}}}
    ask {"panel": "identify", "question": {"record": {"name": "x.csv", "text": "time_s,relaxation_modulus_pa\n1,2\n", "columns": "t", "units": "s", "strain": 0.1, "model": "x"}}}
    quantity {"key": "_s", "text": "1 s"}
    surface {"law": {"order": 0.5, "stiffness_n_per_m": 1, "dissipation_n_s_mu_per_m": 1, "step_s": 0.1}, "depths_m": [0, 1]}
"#;

#[test]
fn what_has_a_wrong_type_is_answered_once_in_a_line_within_its_limit() {
    let (_runs, _server, mut page) = opened();
    let mut random = Random(65);
    let asked: Vec<(&str, Value)> = (REQUESTS
        .lines()
        .filter_map(|row| row.trim().split_once(' ')))
    .map(|(what, arguments)| (what, arguments.parse().expect(what)))
    .collect();
    assert_eq!(asked.len(), 21);
    let (mut refused, mut longest, mut bad) = (0, 0, Vec::new());
    for case in 0..cases(300) {
        let (what, arguments) = &asked[case % asked.len()];
        let mut request = spoilt(arguments, &mut random);
        if !request.is_object() {
            request = json!({"force": request});
        }
        let message = request.to_string();
        let id = page.post(what, request);
        let answer = page.answer(&json!(id));
        page.unasked.clear();
        let Some(error) = answer["error"].as_str() else {
            continue;
        };
        (refused, longest) = (refused + 1, error.chars().count().max(longest));
        let is_line = !error.contains('\n') && error.chars().count() <= 1000;
        // Of what the page sent no more than 200 characters in a row.
        let echo = error.matches('\u{1f41f}').count();
        let panicked = error.contains("could not finish");
        if !is_line || echo > 50 || panicked {
            bad.push(format!("{what} {message:.200}: {error}"));
        }
    }
    println!("{refused} refused, the longest in {longest} characters");
    page.ask("stop", json!({}));
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
