//! A page drives the server: every request, and everything that can go wrong.
//!
//! The loop runs by the clock, but nothing here depends on how fast: each test waits until what it wants is there.

mod compare;
mod door;
mod feel;
mod files;
mod messages;
mod pages;
mod panels;
mod questions;
mod runs;
mod walls;

use haptic_page::{OnClose, PageServer, ServerOptions};
use haptic_run::RealtimeOptions;
use haptic_tissue::Library;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;
use testkit::browser::Page;

const FORCE: usize = 2;
const SHORT: usize = 3;
const A3: usize = 4;

fn server(runs: &Path, on_close: OnClose) -> PageServer {
    PageServer::start(options(runs, on_close, 0)).expect("starts")
}

/// A server over a folder of its own.
fn served() -> (TempDir, PageServer) {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    (runs, server)
}

/// Such a server, and a page of it.
fn opened() -> (TempDir, PageServer, Page) {
    let (runs, server) = served();
    let page = Page::open(server.address());
    (runs, server, page)
}

fn options(runs: &Path, on_close: OnClose, port: u16) -> ServerOptions {
    ServerOptions {
        device: haptic_page::DeviceNumbers::default(),
        opens: None,
        port,
        runs: runs.to_owned(),
        on_close,
        realtime: RealtimeOptions::default(),
        library: Library::load(None).expect("built in"),
        provenance: BTreeMap::from([("program".to_owned(), "a test".to_owned())]),
    }
}

/// A page with the controls, and one that watches: it comes when the first is there.
fn two(address: &str) -> (Page, Page) {
    let mut page = Page::open(address);
    hello(&mut page);
    (page, Page::open(address))
}

fn hello(page: &mut Page) -> Value {
    page.ask("hello", json!({"version": 1}))
}

/// Somebody holds the handle at this place, m.
fn held_at(page: &mut Page, position_m: f64) {
    page.ask("feel.hand", json!({"position_m": position_m, "held": true}));
}

fn prostate() -> Value {
    json!({"environment": {"tissue": "prostate-cancerous"}})
}

/// What a panel of the page asks.
fn question(panel: &str, kind: &str, question: Value) -> Value {
    json!({"panel": panel, "question": {kind: question}})
}

/// A record of so many rows, a spring-pot's relaxation: many take minutes to identify, none is refused.
fn record(rows: u32) -> Value {
    let mut text = "time_s,relaxation_modulus_pa\n".to_owned();
    for n in 1..=rows {
        let t = 1e-3 * f64::from(n);
        text += &format!("{t},{}\n", 1000.0 * t.powf(-0.2));
    }
    question("identify", "record", json!({"name": "x.csv", "text": text}))
}

/// True for a number below this one; before the loop runs there is none.
fn below(value: &Value, limit: f64) -> bool {
    value.as_f64().is_some_and(|number| number < limit)
}

/// The same two, and the first presses on a tissue: a force acts.
fn two_with_force(address: &str) -> (Page, Page) {
    let (mut page, watcher) = two(address);
    page.ask("feel.start", prostate());
    held_at(&mut page, 5e-3);
    page.status(|status| below(&status["force_n"], -0.1));
    (page, watcher)
}

/// These are in an answer.
#[track_caller]
fn has(answer: &Value, wanted: Value) {
    for (key, value) in wanted.as_object().expect("an object") {
        assert_eq!(&answer[key], value, "{key} of {answer}");
    }
}

/// Starts a run or question; its last word.
fn ran(page: &mut Page, kind: &str, parameters: Value) -> Value {
    let run = json!({"kind": kind, "parameters": parameters});
    let name = page.ask("runs.start", run)["name"].take();
    ended(page, |run| run["name"] == name)
}

/// The last word of a run.
fn ended(page: &mut Page, is: impl Fn(&Value) -> bool) -> Value {
    page.wait("run", |run| is(run) && run["state"] != "running")
}

/// A run or question of these parameters is refused so.
fn refuses(page: &mut Page, kind: &str, parameters: Value, words: &str) {
    let run = json!({"kind": kind, "parameters": parameters});
    page.refuses("runs.start", run, words);
}

/// Every key of an answer stands in the row of its request in docs/page-protocol.md.
fn assert_documented(request: &str, answer: &Value) {
    let protocol = include_str!("../../../../docs/page-protocol.md");
    let named = format!("| `{request}`");
    let row = protocol.lines().find(|line| line.starts_with(&named));
    let row = row.unwrap_or_else(|| panic!("no row of {request}"));
    let keys = answer.as_object().expect("an object").keys();
    for key in keys.filter(|key| !["id", "ok"].contains(&key.as_str())) {
        let word = |character: char| !(character.is_alphanumeric() || character == '_');
        let known = row.split(word).any(|known| known == key);
        assert!(known, "`{key}` of {request} is not documented: {row}");
    }
}
