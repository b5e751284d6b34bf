//! Experiments from forms.

use crate::{assert_documented, ended, has, opened, ran, refuses};
use haptic_log::record::{Entry, LogFiles};
use haptic_message::TickMessage;
use serde_json::{Value, json};
use testkit::browser::{get, parts};
use testkit::{assert_close, assert_says};

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn an_experiment_is_started_from_a_form_watched_and_stopped() {
    let (runs, _server, mut page) = opened();
    let forms = page.ask("runs.forms", json!({}));
    assert_eq!(forms["forms"].as_array().map(Vec::len), Some(19));
    let much = "above 0 and at most 1";
    refuses(&mut page, "relax", json!({"strain": 5}), much);
    let healthy = json!({"duration_s": 3, "tissue": "prostate-healthy"});
    let done = ran(&mut page, "relax", healthy);
    has(
        &done,
        json!({"name": "relax-0001/relax", "samples": 3001, "state": "done"}),
    );
    assert_eq!(done["report"]["samples"], 3001);
    let opened = page.ask("runs.open", json!({"name": "relax-0001/relax"}));
    assert_eq!(opened["samples"], 3001);
    as_many(&opened["curves"], ["closed_form", "values"]);
    // Its own log as a record over it.
    let log = runs.path().join("relax-0001/relax.mcap");
    let again = json!({"duration_s": 3, "tissue": "prostate-healthy", "against": log});
    let done = ran(&mut page, "relax", again);
    assert_eq!(done["report"]["against_error"], 0.0, "{done}");
    let opened = page.ask("runs.open", json!({"name": "relax-0002/relax"}));
    as_many(&opened["curves"], ["record", "record_time_s"]);
    // By the clock, for longer than anybody waits: stopped, its log is whole.
    let slow = json!({"kind": "wall", "realtime": true, "parameters": {"mass_kg": 0.065, "damping_n_s_per_m": 3.5, "sample_time_s": 0.002,
        "order": 0.5, "stiffness_n_per_m": 300, "dissipation_n_s_mu_per_m": 6, "duration_s": 1000, "window_s": 1}});
    page.ask("runs.start", slow.clone());
    page.refuses("runs.start", slow, "is still running");
    let running = |run: &Value| run["state"] == "running" && run["name"] == "wall-0001/wall";
    page.wait("run", running);
    let shown = page.ask("view", json!({"source": "wall-0001/wall", "columns": 10}));
    let channels = shown["channels"].as_array().expect("a list");
    assert!(channels.contains(&json!("position_m")), "{shown}");
    page.ask("stop", json!({}));
    let stopped = ended(&mut page, |_| true);
    assert_eq!(stopped["state"], "stopped", "{stopped}");
    let opened = page.ask("runs.open", json!({"name": "wall-0001/wall"}));
    assert_eq!(opened["complete"], true);
}

/// Two curves with some points, one of each for the other.
fn as_many(curves: &Value, keys: [&str; 2]) {
    let [a, b] = keys.map(|key| curves[key].as_array().map(Vec::len));
    assert!(a > Some(10) && a == b, "{curves}");
}

/// What the page sends of a form that nobody has touched: what has to be given.
fn untouched(form: &Value) -> Value {
    let tables = form["tables"].as_array().expect("tables").iter();
    let parameters = tables.flat_map(|table| table["parameters"].as_array().expect("a list"));
    let required = parameters.filter(|parameter| parameter["required"] == true);
    let given = required.map(|parameter| {
        let key = parameter["key"].as_str().expect("a key");
        (key.to_owned(), parameter["default"].clone())
    });
    json!({"kind": form["kind"], "parameters": given.collect::<serde_json::Map<_, _>>()})
}

#[test]
fn the_defaults_of_every_form_run() {
    let (_runs, _server, mut page) = opened();
    let forms = page.ask("runs.forms", json!({}))["forms"].take();
    for form in forms.as_array().expect("a list") {
        let kind = form["kind"].as_str().expect("a kind");
        // No wall is the usual one: it has to be given.
        if kind.starts_with("analyze-") && kind != "analyze-teleoperation" {
            page.refuses("runs.start", untouched(form), "missing key `");
            continue;
        }
        page.ask("runs.start", untouched(form));
        // These two have numbers of the page; the others those of the command, which has tests of its own.
        let whole = ["wall", "coupler"].contains(&kind);
        if !whole {
            page.ask("runs.stop", json!({}));
        }
        let end = ended(&mut page, |run| run["kind"] == kind);
        if whole {
            has(&end, json!({"state": "done", "verdict": "stable"}));
        } else {
            let over = end["state"] == "stopped" || end["state"] == "done";
            assert!(over, "{kind}: {end}");
        }
    }
}

/// The body of an answer in chunks.
fn body(answer: &str) -> String {
    let (head, mut rest) = answer.split_once("\r\n\r\n").expect("a head");
    assert!(head.starts_with("HTTP/1.1 200"), "{head}");
    assert_says(&head, "text/csv");
    let mut body = String::new();
    while let Some((length, more)) = rest.split_once("\r\n") {
        let length = usize::from_str_radix(length, 16).expect("a length");
        if length == 0 {
            break;
        }
        body += &more[..length];
        rest = &more[length + 2..];
    }
    body
}

#[test]
fn frames_answer_their_requests_and_a_table_is_the_samples_of_the_log() {
    let (runs, server, mut page) = opened();
    ran(&mut page, "relax", json!({"duration_s": 2}));
    let name = "relax-0001/relax";
    // Two are asked for at once.
    let view = |channel| json!({"source": name, "columns": 8192, "channels": [channel]});
    let asked = ["commanded_force_n", "position_m"]
        .map(|channel| (page.post("view", view(channel)), channel));
    for (id, channel) in asked {
        assert_eq!(page.answer(&json!(id))["channels"], json!([channel]));
    }
    let log = LogFiles::open(&runs.path().join("relax-0001/relax.mcap")).expect("opens");
    let tick = |entry| match entry {
        Ok(Entry::Tick(tick)) => Some(tick),
        other => other.map(|_| None).expect("whole"),
    };
    let log: Vec<TickMessage> = log.filter_map(tick).collect();
    for (id, channel) in asked {
        let frame = (page.frames.iter()).find(|frame| json!(frame.request) == json!(id));
        let drawn = frame.expect("a frame").least(0);
        let value = |tick: &TickMessage| match channel {
            "commanded_force_n" => tick.commanded_force_n[0],
            _ => tick.position_m[0],
        };
        let logged: Vec<f32> = log.iter().map(|tick| value(tick) as f32).collect();
        assert_eq!(&drawn[..logged.len()], logged, "{channel}");
    }
    // Every sample of the span, with all digits, once.
    let table = json!({"name": name, "channels": ["position_m", "commanded_force_n"], "from_s": 0.25, "to_s": 1.5});
    let named = page.ask("runs.table", table);
    assert_documented("runs.table", &named);
    let (host, folder) = parts(server.address());
    let path = format!("{folder}{}", named["address"].as_str().expect("an address"));
    let head = format!("Host: {host}\r\n");
    let text = body(&get(host, &path, &head));
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,position_m,commanded_force_n"));
    let row = |line: &str| -> [f64; 3] {
        let numbers = line.split(',').map(|cell| cell.parse().expect("a number"));
        numbers
            .collect::<Vec<_>>()
            .try_into()
            .expect("three columns")
    };
    let rows: Vec<[f64; 3]> = lines.map(row).collect();
    let within = log
        .iter()
        .filter(|tick| (0.25..=1.5).contains(&tick.time_s));
    let numbers = |tick: &TickMessage| [tick.time_s, tick.position_m[0], tick.commanded_force_n[0]];
    let wanted: Vec<[f64; 3]> = within.map(numbers).collect();
    assert!(wanted.len() > 1200 && rows == wanted, "{} rows", rows.len());
    assert!(get(host, &path, &head).starts_with("HTTP/1.1 404"));
    let late = json!({"name": name, "channels": [], "from_s": 2, "to_s": 1});
    for (wrong, want) in [
        (
            json!({"name": name, "channels": ["colour"]}),
            "use some of reference_m",
        ),
        (late, "before"),
        (json!({"name": "../x", "channels": []}), "there is no log"),
    ] {
        page.refuses("runs.table", wrong, want);
    }
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_opened_for_a_page() {
    let (runs, _server, mut page) = opened();
    let pipe = runs.path().join("tissue.toml");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("runs").success());
    for (kind, key, path) in [
        ("relax", "tissue", pipe.as_path()),
        ("design", "controller", pipe.as_path()),
        ("wall", "device_model", std::path::Path::new("/dev/zero")),
        ("relax", "library", runs.path()),
    ] {
        refuses(&mut page, kind, json!({key: path}), "not a regular file");
    }
}

/// A form of a hand that goes round in a disc.
fn disc() -> Value {
    json!({"shape": "ball", "radius_m": 0.02, "centre_m": [0, 0], "mass_kg": [0.065, 0.12],
        "circle_radius_m": 0.018, "stiffness_n_per_m": 300})
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_touch_is_run_from_a_form_and_seen_while_it_grows() {
    let (_runs, _server, mut page) = opened();
    // A hand that begins inside would be a blow: nothing is started.
    let mut inside = disc();
    inside["circle_radius_m"] = json!(0.01);
    inside["circle_start_radius_m"] = json!(0.01);
    refuses(&mut page, "touch", inside, "deep in the shape");
    // By the clock: it is looked at while it goes.
    let mut slow = disc();
    slow["duration_s"] = json!(900);
    let slow = json!({"kind": "touch", "realtime": true, "parameters": slow});
    page.ask("runs.start", slow);
    page.wait("run", |run| run["samples_done"].as_u64() > Some(20));
    let name = json!({"name": "touch-0001/touch"});
    let table = json!({"name": "touch-0001/touch", "channels": []});
    page.refuses("runs.table", table, "is still running");
    let going = page.ask("runs.open", name.clone());
    assert_documented("runs.open", &going);
    has(&going, json!({"axes": 2, "running": true}));
    assert_eq!(going["metadata"]["experiment"]["radius_m"], "0.02");
    let seen = json!({"source": "touch-0001/touch", "columns": 50, "channels": ["position_x_m", "commanded_force_norm_n"]});
    let shown = page.ask("view", seen);
    let frame = page.frame(|frame| json!(frame.request) == shown["id"]);
    assert_eq!(frame.channels, 2);
    // The hand begins at the edge of the disc.
    let begins = f64::from(frame.largest(0)[0]);
    assert_close("begins", begins, 0.02, 1e-3);
    page.ask("runs.stop", json!({}));
    page.wait("run", |run| run["state"] == "stopped");
}

#[test]
fn a_touch_that_was_run_to_its_end_is_opened_axis_by_axis() {
    let (_runs, _server, mut page) = opened();
    // To its end, in virtual time.
    let mut disc = disc();
    disc["duration_s"] = json!(2);
    let done = ran(&mut page, "touch", disc);
    assert_eq!(done["state"], "done", "{done}");
    let opened = page.ask("runs.open", json!({"name": "touch-0001/touch"}));
    assert_documented("runs.open", &opened);
    has(
        &opened,
        json!({"axes": 2, "samples": done["report"]["samples"]}),
    );
    let channels =
        "commanded_force_x_n commanded_force_y_n commanded_force_norm_n position_x_m position_y_m";
    let channels: Vec<&str> = channels.split(' ').collect();
    assert!(opened["channels"].to_string().contains("reference_x_m"));
    let view = json!({"source": "touch-0001/touch", "columns": 3000, "channels": channels});
    let shown = page.ask("view", view);
    let frame = page.frame(|frame| json!(frame.request) == shown["id"]);
    // A column a sample: the norm is that of the components, and the force pushes out of the disc.
    assert_eq!((frame.ticks_per_column, frame.columns), (1.0, 2001));
    let mut pushed = 0;
    for n in 0..frame.columns {
        let [fx, fy, norm, x, y] = [0, 1, 2, 3, 4].map(|channel| frame.least(channel)[n]);
        let off = (fx.hypot(fy) - norm).abs();
        assert!(off < 1e-5 * (1.0 + norm), "column {n}");
        pushed += usize::from(norm > 0.1 && fx * x + fy * y > 0.0);
    }
    assert!(pushed > 1200, "{pushed}");
    let listed = page.ask("runs.list", json!({}));
    let wanted = json!({"name": "touch-0001/touch", "verdict": done["verdict"]});
    has(&listed["runs"][0], wanted);
}
