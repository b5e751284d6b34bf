//! Runs that are killed at a random moment: what of their logs is left.
//!
//! The moment of a kill is known from outside: the run's live stream tells the newest tick
//! that the writer of the log had seen, and, since the stream is stamped with the time of day, the clock tells
//! which tick was due. `KILLS=200 cargo test -p host-cli --test cli killed -- --nocapture` makes 200 kills
//! instead of a few; `KILL_SEED` takes other moments.

use crate::devices::Emulated;
use crate::process::{Place, number};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::net::UdpSocket;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// A chunk of the log, ms of device time.
const CHUNK_MS: f64 = 100.0;
/// Latest kill, ms after the start of the process.
const LATEST_MS: u64 = 1200;
/// Runs at the same time: they wait for the clock for the most part.
const AT_ONCE: usize = 3;

/// A kill and what it left.
#[derive(Debug)]
struct Kill {
    after_ms: u64,
    /// True if the log had been begun.
    begun: bool,
    /// Ticks saved.
    saved: f64,
    /// Ticks that the writer of the log had seen for certain, and that are not saved.
    lost_ticks: f64,
    /// From the last tick saved to the kill, ms; `None` if the stream had not begun.
    lost_ms: Option<f64>,
}

/// Time of day, ms.
fn now_ms() -> f64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    1e3 * now.expect("after 1970").as_secs_f64()
}

/// Stamps of the positions in a datagram, ms of the day: first and last.
fn stamps(datagram: &str) -> Option<(f64, f64)> {
    let mut lines = datagram.lines();
    let points = lines.find_map(|line| line.strip_prefix("position_m:"))?;
    let mut stamps = points.split(';').filter_map(|point| {
        let (stamp, _) = point.split_once(':')?;
        stamp.parse().ok()
    });
    let first = stamps.next()?;
    Some((first, stamps.next_back().unwrap_or(first)))
}

/// Receives a live stream until told to end: the first and last stamp.
fn watch(viewer: &UdpSocket, over: &AtomicBool) -> Option<(f64, f64)> {
    let timeout = Some(Duration::from_millis(20));
    viewer.set_read_timeout(timeout).expect("sets");
    let mut buffer = [0; 4096];
    let mut seen: Option<(f64, f64)> = None;
    loop {
        match viewer.recv(&mut buffer) {
            Ok(length) => {
                let text = String::from_utf8_lossy(&buffer[..length]);
                if let Some((first, last)) = stamps(&text) {
                    let first = seen.map_or(first, |(first, _)| first);
                    seen = Some((first, last));
                }
            }
            Err(_) if over.load(Ordering::Relaxed) => return seen,
            Err(_) => {}
        }
    }
}

/// Starts `host-cli LINE` in a place, kills it, and saves its log.
fn kill_once(place: &Place, line: &str, after_ms: u64) -> Kill {
    let viewer = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let address = viewer.local_addr().expect("has one");
    let over = Arc::new(AtomicBool::new(false));
    let watching = std::thread::spawn({
        let over = Arc::clone(&over);
        move || watch(&viewer, &over)
    });
    let mut command = place.command(&format!("{line} --teleplot={address}"));
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("the binary starts");
    std::thread::sleep(Duration::from_millis(after_ms));
    let killed_ms = now_ms();
    // SIGKILL on Unix: nothing of the process runs after it.
    child.kill().expect("can be killed");
    let status = child.wait().expect("ends");
    assert!(!status.success(), "it had ended before: {status}");
    over.store(true, Ordering::Relaxed);
    let stream = watching.join().expect("ends");

    if !place.path("run/relax.mcap.part").exists() {
        assert_eq!(stream, None, "samples before the log");
        return Kill {
            after_ms,
            begun: false,
            saved: 0.0,
            lost_ticks: 0.0,
            lost_ms: None,
        };
    }
    let recovery = place.run("log recover run/relax.mcap.part saved.mcap --json");
    assert!(matches!(recovery.code, Some(0 | 4)), "{recovery}");
    let recovered = recovery.json();
    let check = place.run("log check saved.mcap --json").succeeded().json();
    let saved = number(&check, "samples");
    assert_eq!(check["gaps"], serde_json::json!([]), "{check}");
    assert_eq!(number(&recovered, "samples"), saved);
    if saved > 0.0 {
        // From the first tick on, without a gap.
        assert_eq!(number(&check, "first_s"), 0.0, "{check}");
        assert_eq!(number(&recovered, "last_tick"), saved - 1.0);
        let missing = recovered["missing"].to_string();
        assert!(missing.contains("whatever came after tick"), "{missing}");
    }
    Kill {
        after_ms,
        begun: true,
        saved,
        // A tick is a millisecond.
        lost_ticks: stream.map_or(0.0, |(first, last)| (last - first).round() + 1.0 - saved),
        lost_ms: stream.map(|(first, _)| killed_ms - (first + saved - 1.0)),
    }
}

/// Kills as many runs as asked for and judges what was lost, by counts of ticks. What the clock says of it is printed, not judged: it
/// runs on while the machine is busy with others and the writer waits for its turn. On an idle machine nothing is above 100 ms.
fn kill_many(few: usize, seed: u64, place: impl Fn() -> (Place, Option<Emulated>, String) + Sync) {
    let from_environment = |name: &str| -> Option<u64> { std::env::var(name).ok()?.parse().ok() };
    let kills = from_environment("KILLS").map_or(few, |kills| kills as usize);
    let seed = from_environment("KILL_SEED").unwrap_or(0) + seed;
    let mut random = Pcg64::seed_from_u64(seed);
    let moments: Vec<u64> = (0..kills).map(|_| random.next_u64() % LATEST_MS).collect();
    let kill = |after_ms| {
        let (place, device, line) = place();
        let place = device.as_ref().map_or(&place, Emulated::place);
        let kill = kill_once(place, &line, after_ms);
        // What the writer had seen it had also given to the system, up to the open chunk.
        assert!(kill.lost_ticks <= CHUNK_MS, "{kill:?}");
        kill
    };
    let together = |moments: &[u64]| -> Vec<Kill> {
        std::thread::scope(|scope| {
            let start = |&after_ms| scope.spawn(move || kill(after_ms));
            let threads: Vec<_> = moments.iter().map(start).collect();
            let ends = threads.into_iter().map(|thread| thread.join());
            ends.map(|kill| kill.expect("is right")).collect()
        })
    };
    let kills: Vec<Kill> = moments.chunks(AT_ONCE).flat_map(together).collect();
    let begun = kills.iter().filter(|kill| kill.begun).count();
    let mut lost: Vec<f64> = kills.iter().filter_map(|kill| kill.lost_ms).collect();
    lost.sort_by(f64::total_cmp);
    let at = |share: f64| lost.get(((lost.len() as f64 - 1.0) * share).round() as usize);
    let over = lost.iter().filter(|&&ms| ms > CHUNK_MS).count();
    let saved: f64 = kills.iter().map(|kill| kill.saved).sum();
    let most = kills.iter().map(|kill| kill.lost_ticks).fold(0.0, f64::max);
    let latest = kills.iter().max_by_key(|kill| kill.after_ms);
    println!(
        "{} kills, seed {seed}: {begun} after the log was begun, all recovered, {saved} samples; {} with a \
         stream; lost by the stream at most {most} ticks; by the clock median {:?} ms, 90 % {:?} ms, most {:?} ms, {over} above \
         {CHUNK_MS} ms; latest {latest:?}",
        kills.len(),
        lost.len(),
        at(0.5),
        at(0.9),
        at(1.0),
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_run_killed_at_any_moment_loses_at_most_the_open_chunk() {
    kill_many(6, 1, || {
        let line = "relax --realtime --contact rigid --out run --quiet";
        (Place::new(), None, line.to_owned())
    });
}

#[test]
fn so_does_a_run_on_a_device() {
    kill_many(2, 2, || {
        let device = Emulated::new("");
        let line = "relax --device serial:device --watchdog 1s --contact rigid --out run --quiet";
        (Place::new(), Some(device), line.to_owned())
    });
}
