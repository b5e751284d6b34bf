//! A page drives the server: every request, and everything that can go wrong.
//!
//! The loop runs by the clock, but nothing here depends on how fast: each test waits until what it wants is there.

mod browser;

use browser::{Page, get, parts, server};
use haptic_page::OnClose;
use serde_json::json;

const FORCE: usize = 2;
const SHORT: usize = 3;
const A3: usize = 4;

fn prostate() -> serde_json::Value {
    json!({"environment": {"tissue": "prostate-cancerous"}})
}

#[test]
fn a_tissue_is_felt_relaxes_and_remembers() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let mut page = Page::open(server.address());
    let hello = page.ask("hello", json!({"version": 1}));
    assert_eq!((&hello["controls"], &hello["feel"]), (&json!(true), &json!(null)));
    assert_eq!(hello["channels"][FORCE], "force_n");
    let started = page.ask("feel.start", prostate());
    assert_eq!(started["verdict"]["stable"], true);
    assert_eq!(started["feel"]["ghosts"], json!(["short", "a3"]));
    page.ask("view", json!({"source": "live", "last_s": 30, "columns": 800}));
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    // 5 mm into 173 N·s^μ/m: some tenths of a newton, pushing back.
    let pushed = page.frame(|frame| frame.least(FORCE).iter().any(|&force| force < -0.2));
    assert_eq!((pushed.source, pushed.channels, pushed.sample_time_s), (0, 7, 1e-3));
    let position = pushed.largest(0).iter().copied().fold(f32::NAN, f32::max);
    assert!((1e-3..8e-3).contains(&position), "{position}");
    // It relaxes: three seconds later the force is smaller, and A₃, which forgets at once, is not where the true one is.
    let since = pushed.first_tick + pushed.columns as f64 * pushed.ticks_per_column;
    let later = page.frame(|frame| {
        frame.first_tick + (frame.columns as f64) * frame.ticks_per_column > since + 3000.0
    });
    let last = later.columns - 2;
    let peak = later.least(FORCE).iter().copied().fold(f32::NAN, f32::min);
    let (now, short, a3) = (later.least(FORCE)[last], later.least(SHORT)[last], later.least(A3)[last]);
    assert!(now > 0.9 * peak && now < -0.05, "from {peak} N to {now} N");
    assert!(short < 1.02 * now, "the last second alone does not relax on: {short} and {now}");
    assert!(a3.is_finite() && (a3 - now).abs() > 0.1 * now.abs(), "{a3} and {now}");
    let status = page.status(|status| status["samples_sent"].as_u64() > Some(3000));
    assert_eq!((&status["lost"], &status["fault"], &status["armed"]), (&json!(0), &json!(null), &json!(true)));
    assert_eq!(status["samples_missed"], 0);
    server.stop();
    assert_eq!(page.closed(), "1001: the server was stopped");
}
