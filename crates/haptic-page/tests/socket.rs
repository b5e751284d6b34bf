//! A page drives the server: every request, and everything that can go wrong.
//!
//! The loop runs by the clock, but nothing here depends on how fast: each test waits until what it wants is there.

use haptic_experiment::RealtimeOptions;
use haptic_page::{OnClose, PageServer, ServerOptions};
use haptic_tissue::Library;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;
use testkit::browser::{Page, get, parts};

const FORCE: usize = 2;
const SHORT: usize = 3;
const A3: usize = 4;

fn server(runs: &Path, on_close: OnClose) -> PageServer {
    PageServer::start(options(runs, on_close, 0)).expect("starts")
}

fn options(runs: &Path, on_close: OnClose, port: u16) -> ServerOptions {
    ServerOptions {
        device: haptic_page::DeviceNumbers::default(),
        imperfections: haptic_experiment::Imperfections::NONE,
        port,
        runs: runs.to_owned(),
        on_close,
        realtime: RealtimeOptions::NORMAL,
        library: Library::load(None).expect("built in"),
        provenance: BTreeMap::from([("program".to_owned(), "a test".to_owned())]),
    }
}

fn prostate() -> serde_json::Value {
    json!({"environment": {"tissue": "prostate-cancerous"}})
}

/// Every key of an answer stands in the row of its request in docs/page-protocol.md.
fn assert_documented(request: &str, answer: &serde_json::Value) {
    let protocol = include_str!("../../../docs/page-protocol.md");
    let row = protocol
        .lines()
        .find(|line| line.starts_with(&format!("| `{request}`")));
    let row = row.unwrap_or_else(|| panic!("no row of {request}"));
    let keys = answer.as_object().expect("an object").keys();
    for key in keys.filter(|key| !["id", "ok"].contains(&key.as_str())) {
        let word = |character: char| !(character.is_alphanumeric() || character == '_');
        assert!(
            row.split(word).any(|known| known == key),
            "`{key}` of {request} is not documented: {row}"
        );
    }
}

#[test]
fn a_tissue_is_felt_relaxes_and_remembers() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    let hello = page.ask("hello", json!({"version": 1}));
    assert_eq!(
        (&hello["controls"], &hello["feel"]),
        (&json!(true), &json!(null))
    );
    assert_eq!(hello["channels"][FORCE], "force_n");
    let started = page.ask("feel.start", prostate());
    assert_eq!(started["verdict"]["stable"], true);
    assert_eq!(started["feel"]["ghosts"], json!(["short", "a3"]));
    page.ask(
        "view",
        json!({"source": "live", "last_s": 30, "columns": 800}),
    );
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    // 5 mm into 173 N·s^μ/m: some tenths of a newton, pushing back.
    let pushed = page.frame(|frame| frame.least(FORCE).iter().any(|&force| force < -0.2));
    assert_eq!(
        (pushed.source, pushed.channels, pushed.sample_time_s),
        (0, 7, 1e-3)
    );
    let position = pushed.largest(0).iter().copied().fold(f32::NAN, f32::max);
    assert!((1e-3..8e-3).contains(&position), "{position}");
    // It relaxes: three seconds later the force is smaller, and A₃, which forgets at once, is not where the true one is.
    let since = pushed.first_tick + pushed.columns as f64 * pushed.ticks_per_column;
    let later = page.frame(|frame| {
        frame.first_tick + (frame.columns as f64) * frame.ticks_per_column > since + 3000.0
    });
    let last = later.columns - 2;
    let peak = later.least(FORCE).iter().copied().fold(f32::NAN, f32::min);
    let (now, short, a3) = (
        later.least(FORCE)[last],
        later.least(SHORT)[last],
        later.least(A3)[last],
    );
    assert!(now > 0.9 * peak && now < -0.05, "from {peak} N to {now} N");
    assert!(
        short < 1.02 * now,
        "the last second alone does not relax on: {short} and {now}"
    );
    assert!(
        a3.is_finite() && (a3 - now).abs() > 0.1 * now.abs(),
        "{a3} and {now}"
    );
    let status = page.status(|status| status["samples_sent"].as_u64() > Some(3000));
    assert_eq!(
        (&status["lost"], &status["fault"], &status["armed"]),
        (&json!(0), &json!(null), &json!(true))
    );
    assert_eq!(status["samples_missed"], 0);
    server.stop();
    assert_eq!(page.closed(), "1001: the server was stopped");
}

#[test]
fn what_is_felt_changes_while_it_runs_without_a_bump_and_only_to_what_is_stable() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    page.ask("feel.start", json!({"environment": {"wall": {"order": 0.3, "stiffness_n_per_m": 100, "dissipation_n_s_mu_per_m": 20}}}));
    page.ask("feel.hand", json!({"position_m": 4e-3, "held": true}));
    page.status(|status| status["force_n"].as_f64() < Some(-0.3));
    let set = page.ask("feel.set", json!({"order": 0.7, "stiffness_n_per_m": 200}));
    assert_eq!(
        (&set["feel"]["order"], &set["feel"]["stiffness_n_per_m"]),
        (&json!(0.7), &json!(200.0))
    );
    assert_eq!(set["feel"]["dissipation_n_s_mu_per_m"], 20.0);
    // Too stiff for 65 g at 1 kHz: refused with the numbers and a factor that helps.
    let refused = page.refused(
        "feel.set",
        json!({"scale": 100, "dissipation_n_s_mu_per_m": 2000}),
    );
    assert!(
        refused.contains("unstable") && refused.contains("of K and B"),
        "{refused}"
    );
    for wrong in [
        json!({"order": 2}),
        json!({"order": "x"}),
        json!({"environment": {"tissue": "nothing"}}),
        json!({"colour": 1}),
    ] {
        let refused = page.refused("feel.set", wrong.clone());
        assert!(!refused.contains('\n'), "{wrong}: {refused}");
    }
    // What ran before goes on, with the change that was good.
    let felt = page.ask("hello", json!({"version": 1}));
    assert_eq!(
        (&felt["feel"]["order"], &felt["feel"]["scale"]),
        (&json!(0.7), &json!(1.0))
    );
    let before = page.status(|_| true)["tick"].as_u64().expect("a tick");
    page.status(|status| status["tick"].as_u64() > Some(before + 600));
    // In no tick did the force change by more than the motion or a fifth of a second of change makes it: 1 N/ms would be a bump.
    let made = page.status(|_| true)["samples_made"]
        .as_u64()
        .expect("a number");
    page.ask(
        "view",
        json!({"source": "live", "from_s": 0, "to_s": made as f64 * 1e-3, "columns": 8192}),
    );
    let frame = page.frame(|_| true);
    let steps = (0..frame.columns).map(|n| frame.largest(FORCE)[n] - frame.least(FORCE)[n]);
    let largest = steps.fold(
        0.0_f32,
        |largest, step| if step > largest { step } else { largest },
    );
    assert!(
        largest < 0.05 * frame.ticks_per_column as f32 + 0.05,
        "{largest} N in {} ticks",
        frame.ticks_per_column
    );
}

#[test]
fn stop_is_always_possible_and_the_force_is_zero() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (mut page, mut watcher) = (Page::open(server.address()), Page::open(server.address()));
    page.ask("feel.start", prostate());
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    page.status(|status| status["force_n"].as_f64() < Some(-0.1));
    // Who only watches may not move anything, but may stop.
    let refused = watcher.refused("feel.hand", json!({"position_m": 0, "held": true}));
    assert!(refused.contains("controls.take"), "{refused}");
    // With a force on the device nothing begins anew.
    let refused = page.refused("arm", json!({}));
    assert!(refused.contains("`stop` first"), "{refused}");
    watcher.ask("stop", json!({}));
    let stopped = page.status(|status| status["force_n"] == 0.0 && status["stopped"] == true);
    assert_eq!(
        (&stopped["armed"], &stopped["running"]),
        (&json!(false), &json!(true))
    );
    // Nothing moves it before it is armed.
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    let tick = stopped["tick"].as_u64().expect("a tick");
    let still = page.status(|status| status["tick"].as_u64() > Some(tick + 200));
    assert_eq!(still["force_n"], 0.0);
    page.ask("arm", json!({}));
    page.status(|status| status["armed"] == true && status["position_m"].as_f64() < Some(0.0));
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    page.status(|status| status["force_n"].as_f64() < Some(-0.1));
    // A world that stands still is stopped too.
    page.ask("feel.pause", json!({"paused": true}));
    page.ask("stop", json!({}));
    page.status(|status| status["force_n"] == 0.0 && status["stopped"] == true);
}

#[test]
fn one_page_holds_the_controls_and_the_others_watch() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut first = Page::open(server.address());
    assert_eq!(first.ask("hello", json!({"version": 1}))["controls"], true);
    let mut second = Page::open(server.address());
    let hello = second.ask("hello", json!({"version": 1}));
    assert_eq!(
        (&hello["controls"], &hello["watching"]),
        (&json!(false), &json!(1))
    );
    let refused = second.refused("controls.take", json!({}));
    assert!(refused.contains("let them go there"), "{refused}");
    first.ask("controls.release", json!({}));
    second.ask("controls.take", json!({}));
    assert!(
        first
            .refused("feel.start", prostate())
            .contains("controls.take")
    );
    first.ask("controls.take", json!({"force": true}));
    second.wait("notice", |notice| {
        notice == "another page has taken the controls"
    });
    // Both see what is felt.
    first.ask("feel.start", prostate());
    second.wait("feel", |feel| {
        feel["environment"]["tissue"] == "prostate-cancerous"
    });
    second.ask(
        "view",
        json!({"source": "live", "last_s": 1, "columns": 100}),
    );
    second.frame(|frame| frame.columns > 10);
    let version = second.refused("hello", json!({"version": 2}));
    assert!(version.contains("reload the page"), "{version}");
}

#[test]
fn a_page_that_goes_stops_what_it_controlled_or_not_as_asked() {
    let runs = tempfile::tempdir().expect("a folder");
    for (on_close, goes_on) in [(OnClose::Stop, false), (OnClose::Continue, true)] {
        let server = server(runs.path(), on_close);
        let mut watcher = {
            let mut page = Page::open(server.address());
            page.ask("feel.start", prostate());
            page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
            page.status(|status| status["force_n"].as_f64() < Some(-0.1));
            let mut watcher = Page::open(server.address());
            // Answered, so it is there before the first goes, without a word.
            watcher.ask("hello", json!({"version": 1}));
            watcher
        };
        // A busy machine tells of a page that has gone before it tells of the loop.
        let there = watcher.status(|status| status["watching"] == 0 && status["tick"].is_u64());
        let tick = there["tick"].as_u64().expect("a tick");
        if goes_on {
            let status = watcher.status(|status| status["tick"].as_u64() > Some(tick + 300));
            assert!(status["force_n"].as_f64() < Some(-0.05), "{status}");
        } else {
            watcher.status(|status| status["stopped"] == true && status["force_n"] == 0.0);
        }
        watcher.ask("controls.take", json!({}));
    }
}

#[test]
fn wrong_tokens_hosts_and_origins_get_a_sentence_and_nothing_else() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (host, path) = parts(server.address());
    assert!(
        host.starts_with("127.0.0.1:") && path.len() == 34,
        "{}",
        server.address()
    );
    let own = format!("Host: {host}\r\n");
    let index = get(host, path, &own);
    assert!(
        index.starts_with("HTTP/1.1 200") && index.contains("<!doctype html>"),
        "{index}"
    );
    for header in [
        "content-security-policy: default-src 'self'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
        "content-type: text/html",
    ] {
        assert!(index.contains(header), "{header} in {index}");
    }
    let elsewhere = format!("Host: {}\r\n", host.replace("127.0.0.1", "evil.example"));
    for (path, headers, status, words) in [
        ("/", &own, "404", "copy the whole address"),
        (
            "/0123456789abcdef0123456789abcdef/",
            &own,
            "404",
            "copy the whole address",
        ),
        (path, &elsewhere, "403", "copy the address"),
        (
            &format!("{path}nothing.js"),
            &own,
            "404",
            "no file of this name",
        ),
        (&format!("{path}../Cargo.toml"), &own, "404", ""),
        (&format!("{path}ws"), &own, "403", "Another web site"),
    ] {
        let answer = get(host, path, headers);
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status}")),
            "{path}: {answer}"
        );
        assert!(
            answer.contains(words) && !answer.contains("<!doctype"),
            "{path}: {answer}"
        );
    }
    for origin in [
        None,
        Some("http://evil.example"),
        Some("null"),
        Some("https://127.0.0.1"),
    ] {
        let refused = Page::from(server.address(), origin).expect_err("refused");
        assert!(refused.contains("403"), "{refused}");
    }
    let wrong = server
        .address()
        .replace(path, "/0123456789abcdef0123456789abcdef/");
    let origin = format!("http://{host}");
    assert!(
        Page::from(&wrong, Some(&origin))
            .expect_err("refused")
            .contains("404")
    );
    // A port that is taken.
    let port = host
        .rsplit_once(':')
        .expect("a port")
        .1
        .parse()
        .expect("a number");
    let taken = options(runs.path(), OnClose::Stop, port);
    let error = haptic_page::PageServer::start(taken)
        .expect_err("taken")
        .to_string();
    assert!(
        error.contains("is taken by another program: take another, or 0"),
        "{error}"
    );
}

#[test]
fn garbage_is_answered_and_closes_the_socket_the_third_time() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    for garbage in ["", "{\"id\": 1"] {
        page.send(garbage);
        let answer = page.answer(&json!(null));
        assert_eq!(answer["ok"], false);
        assert!(
            answer["error"]
                .as_str()
                .is_some_and(|error| !error.contains('\n')),
            "{answer}"
        );
    }
    // Something sensible in between starts anew.
    page.ask("hello", json!({"version": 1}));
    assert!(page.refused("dance", json!({})).contains("not understood"));
    for _ in 0..3 {
        page.send("☃");
    }
    assert_eq!(
        page.closed(),
        "1008: three messages in a row were no requests"
    );
    // The next page finds a server.
    Page::open(server.address()).ask("hello", json!({"version": 1}));
}

#[test]
fn a_page_that_does_not_read_is_closed_and_can_stop_until_then() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (mut page, mut watcher) = (Page::open(server.address()), Page::open(server.address()));
    page.ask("feel.start", prostate());
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    page.status(|status| status["force_n"].as_f64() < Some(-0.1));
    // Frames and answers that nobody reads: the queue is bounded, so the socket goes, and with the controls the force.
    page.ask(
        "view",
        json!({"source": "live", "last_s": 30, "columns": 8192}),
    );
    for _ in 0..100_000 {
        if page.try_post("runs.forms", json!({})).is_err() {
            break;
        }
    }
    watcher.status(|status| status["stopped"] == true && status["force_n"] == 0.0);
    watcher.ask("controls.take", json!({}));
}

#[test]
fn a_recording_holds_every_sample_and_is_listed_opened_and_gone() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    assert_eq!(page.ask("runs.list", json!({}))["runs"], json!([]));
    page.ask("feel.start", prostate());
    let name = page.ask("feel.record", json!({"on": true}))["name"].clone();
    assert_eq!(name, "feel-0001/feel");
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    page.ask("feel.mark", json!({"text": "here"}));
    page.wait("mark", |mark| mark["text"] == "here");
    page.status(|status| status["recorded"].as_u64() > Some(500));
    let ended = page.ask("feel.record", json!({"on": false}));
    assert_documented("feel.record", &ended);
    let samples = ended["samples"].as_u64().expect("a number");
    assert!(samples > 500 && ended["missing"] == 0, "{ended}");
    let list = page.ask("runs.list", json!({}));
    let listed = &list["runs"][0];
    assert_eq!(
        (&listed["name"], &listed["kind"]),
        (&json!("feel-0001/feel"), &json!("feel"))
    );
    assert_eq!(listed["samples"], samples);
    let opened = page.ask("runs.open", json!({"name": "feel-0001/feel"}));
    assert_documented("runs.open", &opened);
    assert_eq!(
        (&opened["complete"], &opened["missing_samples"]),
        (&json!(true), &json!(0))
    );
    assert_eq!(opened["events"][0]["text"], "here");
    let view =
        json!({"source": "feel-0001/feel", "columns": 300, "channels": ["force_n", "position_m"]});
    let shown = page.ask("view", view.clone());
    assert_eq!(shown["channels"], json!(["force_n", "position_m"]));
    let frame = page.frame(|frame| frame.source != 0);
    assert_eq!(json!(frame.source), shown["view"]);
    assert!(frame.least(0).iter().any(|&force| force < -0.1));
    let covered = frame.columns as f64 * frame.ticks_per_column;
    assert!(covered >= samples as f64 && frame.first_tick == 0.0);
    std::fs::remove_dir_all(runs.path().join("feel-0001")).expect("deleted");
    for (what, with) in [
        ("view", view),
        ("runs.open", json!({"name": "feel-0001/feel"})),
    ] {
        let refused = page.refused(what, with);
        assert!(refused.contains("deleted or moved"), "{refused}");
    }
    let outside = page.refused("runs.open", json!({"name": "../../etc/passwd"}));
    assert!(outside.contains("there is no log"), "{outside}");
}

#[test]
fn an_experiment_is_started_from_a_form_watched_and_stopped() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    let forms = page.ask("runs.forms", json!({}));
    assert_eq!(forms["forms"].as_array().map(Vec::len), Some(5));
    let refused = page.refused(
        "runs.start",
        json!({"kind": "relax", "parameters": {"strain": 5}}),
    );
    assert!(refused.contains("(0, 1]"), "{refused}");
    let started = page.ask(
        "runs.start",
        json!({"kind": "relax", "parameters": {"duration_s": 3, "tissue": "prostate-healthy"}}),
    );
    assert_eq!(
        (&started["name"], &started["samples"]),
        (&json!("relax-0001/relax"), &json!(3001))
    );
    let done = page.wait("run", |run| run["state"] != "running");
    assert_eq!(
        (&done["state"], &done["report"]["samples"]),
        (&json!("done"), &json!(3001))
    );
    let opened = page.ask("runs.open", json!({"name": "relax-0001/relax"}));
    assert_eq!(opened["samples"], 3001);
    let curves = &opened["curves"];
    let count = |key: &str| curves[key].as_array().map(Vec::len);
    assert!(
        count("closed_form") > Some(10) && count("closed_form") == count("values"),
        "{curves}"
    );
    // By the clock, for longer than anybody waits: stopped, its log is whole.
    let slow = json!({"kind": "wall", "realtime": true, "parameters": {"mass_kg": 0.065, "damping_n_s_per_m": 3.5, "sample_time_s": 0.002,
        "order": 0.5, "stiffness_n_per_m": 300, "dissipation_n_s_mu_per_m": 6, "duration_s": 1000, "window_s": 1}});
    page.ask("runs.start", slow.clone());
    let refused = page.refused("runs.start", slow);
    assert!(refused.contains("goes on"), "{refused}");
    page.wait("run", |run| {
        run["state"] == "running" && run["name"] == "wall-0001/wall"
    });
    let shown = page.ask("view", json!({"source": "wall-0001/wall", "columns": 10}));
    assert_eq!(shown["channels"][0], "position_m");
    page.ask("stop", json!({}));
    let stopped = page.wait("run", |run| run["state"] != "running");
    assert_eq!(stopped["state"], "stopped", "{stopped}");
    assert_eq!(
        page.ask("runs.open", json!({"name": "wall-0001/wall"}))["complete"],
        true
    );
}

#[test]
fn two_hands_over_a_line_are_run_from_a_form_too() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    let refused = page.refused(
        "runs.start",
        json!({"kind": "teleoperation", "parameters": {"architecture": "telepathy"}}),
    );
    assert!(refused.contains("time-domain"), "{refused}");
    page.ask(
        "runs.start",
        json!({"kind": "teleoperation", "parameters": {"architecture": "wave", "line_delay_s": 0.02, "duration_s": 5}}),
    );
    let done = page.wait("run", |run| run["state"] != "running");
    assert_eq!(done["state"], "done", "{done}");
    let opened = page.ask(
        "runs.open",
        json!({"name": "teleoperation-0001/teleoperation"}),
    );
    assert_eq!(opened["samples"], done["report"]["samples"]);
    let curves = &opened["curves"];
    let count = |key: &str| curves[key].as_array().map(Vec::len);
    assert!(
        count("far_position_m") > Some(10) && count("far_position_m") == count("position_m"),
        "{curves}"
    );
}

#[test]
fn a_record_is_identified_and_one_that_is_none_is_refused() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
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
    assert_eq!(
        (&found["kind"], &found["best"]),
        (&json!("relaxation"), &json!("spring-pot"))
    );
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
