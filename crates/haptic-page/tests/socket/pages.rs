//! Several pages, pages that go, pages that talk garbage.

use crate::{below, has, opened, prostate, record, server, two_with_force};
use haptic_page::OnClose;
use serde_json::json;
use std::time::Instant;
use testkit::browser::{PATIENCE, Page};

#[test]
fn one_page_holds_the_controls_and_the_others_watch() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut first = Page::open(server.address());
    assert_eq!(first.ask("hello", json!({"version": 1}))["controls"], true);
    let mut second = Page::open(server.address());
    let hello = second.ask("hello", json!({"version": 1}));
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
            page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
            page.status(|status| below(&status["force_n"], -0.1));
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
        let said = answer["error"].as_str().expect("a sentence");
        assert!(!said.contains('\n'), "{said}");
    }
    // Something sensible in between starts anew.
    page.ask("hello", json!({"version": 1}));
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
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
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
        page.ask("stop", json!({}));
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
