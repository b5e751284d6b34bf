//! `host-cli serve` as its user and its pages meet it.

use crate::process::{Place, signal};
use serde_json::json;
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Command};
use std::time::{Duration, Instant};
use testkit::browser::Page;
use testkit::{assert_says, until};

/// A server in a process of its own, killed when dropped.
struct Served {
    child: Child,
    address: String,
}

impl Served {
    fn start(place: &Place, line: &str) -> Self {
        let mut child = place.start(line);
        let mut first = String::new();
        let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
        stdout.read_line(&mut first).expect("an address");
        child.stdout = Some(stdout.into_inner());
        Self {
            child,
            address: first.trim().to_owned(),
        }
    }

    /// Sends a signal, and waits: the exit code and what it said.
    fn signal(mut self, name: &str) -> (Option<i32>, String) {
        signal(&self.child, name);
        let status = until("its end", || self.child.try_wait().expect("waits"));
        let mut message = String::new();
        let stderr = self.child.stderr.as_mut().expect("piped");
        stderr.read_to_string(&mut message).expect("text");
        (status.code(), message)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

const SERVE: &str = "serve --port 0 --no-browser";

#[test]
fn it_prints_its_address_and_ctrl_c_stops_the_force_tells_the_page_and_is_success() {
    let place = Place::new();
    let served = Served::start(&place, SERVE);
    let mut page = Page::open(&served.address);
    page.ask(
        "feel.start",
        json!({"environment": {"tissue": "prostate-healthy"}}),
    );
    page.ask("feel.record", json!({"on": true}));
    page.ask("feel.hand", json!({"position_m": 5e-3, "held": true}));
    page.status(|status| status["recorded"].as_u64() > Some(200));
    let (code, message) = served.signal("INT");
    assert_eq!(
        (code, page.closed().as_str()),
        (Some(0), "1001: the server was stopped")
    );
    // The recording was closed: it is whole, and its force ends at zero.
    assert_says(&message, "note: recorded feel-0001");
    let info = place.json("log info results/feel-0001/feel.mcap");
    assert_eq!(
        (&info["complete"], &info["missing_samples"]),
        (&json!(true), &json!(0)),
        "{info}"
    );
    assert!(info["samples"].as_u64() > Some(200));
}

/// A pipe that nobody writes to, and work for hours: nothing of it is waited for.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn it_ends_whatever_is_asked_of_it() {
    let place = Place::new();
    std::fs::create_dir(place.path("results")).expect("made");
    let pipe = place.path("results/tissue.toml");
    let made = Command::new("mkfifo").arg(pipe).status();
    assert!(made.expect("runs").success());
    let served = Served::start(&place, SERVE);
    let mut page = Page::open(&served.address);
    page.post(
        "runs.start",
        json!({"kind": "relax", "parameters": {"tissue": "results/tissue.toml"}}),
    );
    let mut text = "time_s,relaxation_modulus_pa\n".to_owned();
    for n in 1..=20_000 {
        let t = 1e-3 * f64::from(n);
        text += &format!("{t},{}\n", 1000.0 * t.powf(-0.2));
    }
    // Their bodies are large: the page reads what is sent meanwhile.
    for _ in 0..4 {
        let record = json!({"record": {"name": "long.csv", "text": text}});
        page.post("ask", json!({"panel": "identify", "question": record}));
        page.status(|_| true);
    }
    // Ctrl-C is that of another test.
    let (code, message) = served.signal("TERM");
    assert_eq!(code, Some(0), "{message}");
}

#[test]
fn a_file_is_felt_first_and_its_log_holds_the_same() {
    let place = Place::new();
    let wall = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1.63\n\
                stiffness_n_per_m = 900.0\ndissipation_n_s_mu_per_m = 0.02\ndelay_s = 0.001\nduration_s = 1\n";
    place.write("wall.toml", wall);
    let opens = |file: &str| {
        let served = Served::start(&place, &format!("{SERVE} {file}"));
        let mut page = Page::open(&served.address);
        page.ask("hello", json!({"version": 1}))["opens"].take()
    };
    let felt = opens("wall.toml");
    assert_eq!(
        (&felt["order"], &felt["delay_s"]),
        (&json!(1.63), &json!(0.001))
    );
    // Its log holds the same.
    place.run("run wall.toml --out ran");
    assert_eq!(opens("ran/wall.mcap"), felt);
}

/// Processor time, s, and resident memory, bytes, of a process.
#[cfg(target_os = "linux")]
fn used(process: u32) -> (f64, u64) {
    let read =
        |name: &str| std::fs::read_to_string(format!("/proc/{process}/{name}")).expect("reads");
    let stat = read("stat");
    let fields: Vec<&str> = stat
        .rsplit_once(')')
        .expect("a name")
        .1
        .split_whitespace()
        .collect();
    let ticks: u64 = [11, 12]
        .iter()
        .map(|&n| fields[n].parse::<u64>().expect("a number"))
        .sum();
    let pages: u64 = read("statm")
        .split(' ')
        .nth(1)
        .expect("a number")
        .parse()
        .expect("a number");
    // 100 ticks a second, pages of 4 kB, on every Linux that this runs on.
    (ticks as f64 / 100.0, pages * 4096)
}

/// Pushes and looks on for some time; the last status.
#[cfg(target_os = "linux")]
fn watch(page: &mut Page, time: Duration) -> serde_json::Value {
    let until = Instant::now() + time;
    let mut n = 0_u32;
    loop {
        n += 1;
        let position_m = 3e-3 * (1.0 + (f64::from(n) / 20.0).sin());
        page.ask("feel.hand", json!({"position_m": position_m, "held": true}));
        let status = page.status(|_| true);
        page.frames.clear();
        page.unasked.clear();
        if Instant::now() > until {
            return status;
        }
    }
}

/// `SERVE_MINUTES` (10) of a live view: the memory does not grow after the first, and the server takes less than a quarter of a
/// core. Run by .ci/nightly.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_ten_minutes_of_a_live_view_take_no_memory_and_a_quarter_of_a_core_at_most() {
    let minutes: u64 =
        std::env::var("SERVE_MINUTES").map_or(10, |text| text.parse().expect("minutes"));
    let place = Place::new();
    let served = Served::start(&place, SERVE);
    let mut page = Page::open(&served.address);
    page.ask(
        "feel.start",
        json!({"environment": {"tissue": "prostate-cancerous"}}),
    );
    page.ask(
        "view",
        json!({"source": "live", "last_s": 30, "columns": 800}),
    );
    watch(&mut page, Duration::from_secs(60));
    let (cpu_s, bytes) = used(served.child.id());
    let since = Instant::now();
    let mut largest = bytes;
    let mut status = json!(null);
    for minute in 2..=minutes {
        status = watch(&mut page, Duration::from_secs(60));
        let (now_s, now) = used(served.child.id());
        largest = largest.max(now);
        let share = 1e2 * (now_s - cpu_s) / since.elapsed().as_secs_f64();
        println!(
            "minute {minute}: {:.1} MB, {share:.1} % of a core; {status}",
            now as f64 * 1e-6
        );
    }
    let (now_s, _) = used(served.child.id());
    let share = (now_s - cpu_s) / since.elapsed().as_secs_f64();
    let number = |key: &str| status[key].as_u64().expect("a number");
    let (made, sent, missed, lost) = (
        number("samples_made"),
        number("samples_sent"),
        number("samples_missed"),
        number("lost"),
    );
    println!("{made} samples made, {sent} sent, {missed} missed, {lost} lost");
    // Pages of the allocator come and go; a leak of a status or a frame a time would be tens of megabytes.
    assert!(
        largest < bytes + (2 << 20),
        "from {bytes} to {largest} bytes"
    );
    assert!(share < 0.25, "{:.1} % of a core", 1e2 * share);
    assert_eq!((missed, lost), (0, 0));
    // All but those of the last frames.
    assert!(made - sent < 1000, "{made} made, {sent} sent");
}

/// Pairs of `SERVE_SECONDS` (20) with a page that shows everything and with none: 99.9 of 100 ticks take as long. Run by .ci/nightly.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_tick_takes_as_long_with_a_page_as_without() {
    let seconds: u64 =
        std::env::var("SERVE_SECONDS").map_or(20, |text| text.parse().expect("seconds"));
    let place = Place::new();
    let served = Served::start(&place, &format!("{SERVE} --on-close continue"));
    let time = Duration::from_secs(seconds);
    let start = |page: &mut Page| {
        page.ask("controls.take", json!({}));
        page.ask(
            "feel.start",
            json!({"environment": {"tissue": "prostate-cancerous"}}),
        );
        page.ask("feel.hand", json!({"position_m": 3e-3, "held": true}));
    };
    let mut pairs = Vec::new();
    for pair in 0..10 {
        let mut times = [0.0, 0.0];
        // Each comes first as often.
        for turn in [pair % 2, 1 - pair % 2] {
            let mut page = Page::open(&served.address);
            start(&mut page);
            let status = if turn == 0 {
                drop(page);
                std::thread::sleep(time);
                Page::open(&served.address).status(|status| status["running"] == true)
            } else {
                page.ask(
                    "view",
                    json!({"source": "live", "last_s": 30, "columns": 800}),
                );
                let until = Instant::now() + time;
                while Instant::now() < until {
                    page.read().expect("open");
                    page.frames.clear();
                }
                page.unasked.clear();
                page.status(|_| true)
            };
            times[turn] = status["tick_p999_us"].as_f64().expect("a number");
        }
        println!("closed {:.2} µs, open {:.2} µs", times[0], times[1]);
        pairs.push(times[1] / times[0]);
    }
    pairs.sort_by(f64::total_cmp);
    let median = 0.5 * (pairs[4] + pairs[5]);
    println!(
        "ratio of p99.9, open to closed: median {median:.3}, {:.3} to {:.3}",
        pairs[0], pairs[9]
    );
    assert!(median < 1.1, "{median}");
}
