//! What is felt: a tissue, changes of it, stop, a recording.

use crate::{
    A3, FORCE, SHORT, assert_documented, below, has, held_at, hello, opened, prostate, served,
    two_with_force,
};
use serde_json::json;
use testkit::{assert_says, browser::Page};

#[test]
fn the_verdict_stands_beside_what_it_is_of_wherever_that_is_told() {
    let (_runs, server, mut page) = opened();
    let muscle = page.ask(
        "feel.start",
        json!({"environment": {"tissue": "fish-muscle"}}),
    );
    assert_documented("feel.start", &muscle);
    let verdict = &muscle["feel"]["verdict"];
    // Of the model that is felt: of a spring-pot of the same order it would be another.
    assert_eq!(verdict["stable"], true, "{verdict}");
    let margin = verdict["margin"].as_f64().expect("an edge");
    // Where the loop of the free device and both spring-pots, s = (1 - 1/z)/T, meets -1, in NumPy.
    assert!((margin / 19.2197 - 1.0).abs() < 1e-4, "{verdict}");
    let mut watcher = Page::open(server.address());
    let hello = hello(&mut watcher);
    assert_eq!(hello["feel"], muscle["feel"]);
    let halved = page.ask("feel.set", json!({"scale": 0.5}));
    let answer = watcher.wait("feel", |feel| feel["scale"] == 0.5);
    assert_eq!(answer, halved["feel"]);
    let twice = answer["verdict"]["margin"].as_f64().expect("an edge");
    assert!((twice - 2.0 * margin).abs() < 1e-3 * twice, "{answer}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_tissue_is_felt_relaxes_and_remembers() {
    let (_runs, server, mut page) = opened();
    let hello = hello(&mut page);
    has(&hello, json!({"controls": true, "feel": null}));
    assert_eq!(hello["channels"][FORCE], "force_n");
    let started = page.ask("feel.start", prostate());
    assert_eq!(started["feel"]["verdict"]["stable"], true);
    assert_eq!(started["feel"]["ghosts"], json!(["short", "a3"]));
    let view = json!({"source": "live", "last_s": 30, "columns": 800});
    let live = page.ask("view", view);
    held_at(&mut page, 5e-3);
    // 5 mm into 173 N·s^μ/m: some tenths of a newton, pushing back.
    let pushed = page.frame(|frame| {
        let deep = frame.largest(0).iter().any(|&position| position > 1e-3);
        deep && frame.least(FORCE).iter().any(|&force| force < -0.2)
    });
    assert_eq!(
        (json!(pushed.request), pushed.channels, pushed.sample_time_s),
        (live["id"].clone(), 10, 1e-3)
    );
    let position = pushed.largest(0).iter().copied().fold(f32::NAN, f32::max);
    assert!(position < 8e-3, "{position}");
    // It relaxes: three seconds later the force is smaller, and A₃, which forgets at once, is not where the true one is.
    let since = pushed.first_tick + pushed.columns as f64 * pushed.ticks_per_column;
    let later = page.frame(|frame| {
        frame.first_tick + (frame.columns as f64) * frame.ticks_per_column > since + 3000.0
    });
    let last = later.columns - 2;
    let peak = later.least(FORCE).iter().copied().fold(f32::NAN, f32::min);
    let [now, short, a3] = [FORCE, SHORT, A3].map(|channel| later.least(channel)[last]);
    assert!(now > 0.9 * peak && now < -0.05, "from {peak} N to {now} N");
    // The last second alone does not relax on.
    assert!(short < 1.02 * now, "{short} and {now}");
    assert!((a3 - now).abs() > 0.1 * now.abs(), "{a3} and {now}");
    let status = page.status(|status| status["samples_sent"].as_u64() > Some(3000));
    has(&status, json!({"lost": 0, "fault": null, "armed": true}));
    assert_eq!(status["samples_missed"], 0);
    server.stop();
    assert_eq!(page.closed(), "1001: the server was stopped");
}

#[test]
fn a_pointer_beyond_the_reach_of_the_hand_is_told_where_the_hand_goes() {
    let (_runs, _server, mut page) = opened();
    let hello = hello(&mut page);
    let reach = &hello["ranges"]["hand_m"];
    page.ask("feel.start", prostate());
    for (asked, goes_to) in [
        (json!(5e-3), &json!(5e-3)),
        (json!(1e9), &reach["most"]),
        (json!(-1e9), &reach["least"]),
    ] {
        let answer = page.ask("feel.hand", json!({"position_m": asked, "held": true}));
        assert_eq!(&answer["position_m"], goes_to, "{asked}");
        assert_documented("feel.hand", &answer);
    }
    let refused = page.refused("feel.set", json!({"scale": 1e300}));
    assert_eq!(
        refused,
        "`scale` = 1e300 is not from 1e-9 to 100: change it"
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn stop_is_always_possible_and_the_force_is_zero() {
    let (_runs, server) = served();
    let (mut page, mut watcher) = two_with_force(server.address());
    // Who only watches may not move anything, but may stop.
    let hand = json!({"position_m": 0, "held": true});
    watcher.refuses("feel.hand", hand, "controls.take");
    // With a force on the device nothing begins anew.
    page.refuses("arm", json!({}), "`stop` first");
    watcher.ask("stop", json!({}));
    let stopped = page.status(|status| status["force_n"] == 0.0 && status["stopped"] == true);
    has(&stopped, json!({"armed": false, "running": true}));
    // Nothing moves it before it is armed.
    held_at(&mut page, 5e-3);
    let tick = stopped["tick"].as_u64().expect("a tick");
    let still = page.status(|status| status["tick"].as_u64() > Some(tick + 200));
    assert_eq!(still["force_n"], 0.0);
    page.ask("arm", json!({}));
    page.status(|status| status["armed"] == true && below(&status["position_m"], 0.0));
    held_at(&mut page, 5e-3);
    page.status(|status| below(&status["force_n"], -0.1));
    // A world that stands still is stopped too.
    page.ask("feel.pause", json!({"paused": true}));
    page.ask("stop", json!({}));
    page.status(|status| status["force_n"] == 0.0 && status["stopped"] == true);
}

#[test]
fn a_recording_holds_every_sample_and_is_listed_opened_and_gone() {
    let (runs, _server, mut page) = opened();
    assert_eq!(page.ask("runs.list", json!({}))["runs"], json!([]));
    page.ask("feel.start", prostate());
    let name = page.ask("feel.record", json!({"on": true}))["name"].clone();
    assert_eq!(name, "feel-0001/feel");
    held_at(&mut page, 5e-3);
    page.ask("feel.mark", json!({"text": "here"}));
    page.wait("mark", |mark| mark["text"] == "here");
    page.status(|status| status["recorded"].as_u64() > Some(500));
    let ended = page.ask("feel.record", json!({"on": false}));
    assert_documented("feel.record", &ended);
    let samples = ended["samples"].as_u64().expect("a number");
    assert!(samples > 500 && ended["missing"] == 0, "{ended}");
    let list = page.ask("runs.list", json!({}));
    let listed = &list["runs"][0];
    has(listed, json!({"name": "feel-0001/feel", "kind": "feel"}));
    assert_eq!(listed["samples"], samples);
    let opened = page.ask("runs.open", json!({"name": "feel-0001/feel"}));
    assert_documented("runs.open", &opened);
    has(&opened, json!({"complete": true, "missing_samples": 0}));
    assert_eq!(opened["events"][0]["text"], "here");
    let view = json!({"source": "feel-0001/feel", "columns": 300, "channels": ["commanded_force_n", "position_m"]});
    let shown = page.ask("view", view.clone());
    assert_eq!(shown["channels"], view["channels"]);
    let frame = page.frame(|frame| json!(frame.request) == shown["id"]);
    assert!(frame.least(0).iter().any(|&force| force < -0.1));
    let covered = frame.columns as f64 * frame.ticks_per_column;
    assert!(covered >= samples as f64 && frame.first_tick == 0.0);
    std::fs::remove_dir_all(runs.path().join("feel-0001")).expect("deleted");
    let open = json!({"name": "feel-0001/feel"});
    page.refuses("view", view, "deleted or moved");
    page.refuses("runs.open", open, "deleted or moved");
    let outside = page.refused("runs.open", json!({"name": "../../etc/passwd"}));
    assert_says(&outside, "there is no log");
}
