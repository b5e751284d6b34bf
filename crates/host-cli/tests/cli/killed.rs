//! Runs that are killed at a random moment: what of their logs is left.
//!
//! All that was handed to the system is recovered, from the first tick on. That this is all but the open chunk is
//! tested with the writer. `KILLS=200 cargo test -p host-cli --test cli killed -- --nocapture` makes 200 kills
//! instead of a few; `KILL_SEED` takes other moments.

use crate::devices::Emulated;
use crate::process::{Place, number};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::process::Stdio;
use std::time::Duration;

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
}

/// Starts `host-cli LINE` in a place, kills it, and saves its log.
fn kill_once(place: &Place, line: &str, after_ms: u64) -> Kill {
    let mut command = place.command(line);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("the binary starts");
    std::thread::sleep(Duration::from_millis(after_ms));
    // SIGKILL on Unix: nothing of the process runs after it.
    child.kill().expect("can be killed");
    let status = child.wait().expect("ends");
    assert!(!status.success(), "it had ended before: {status}");
    if !place.path("run/relax.mcap.part").exists() {
        return Kill {
            after_ms,
            begun: false,
            saved: 0.0,
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
    }
}

/// Kills as many runs as asked for.
fn kill_many(few: usize, seed: u64, place: impl Fn() -> (Place, Option<Emulated>, String) + Sync) {
    let from_environment = |name: &str| -> Option<u64> { std::env::var(name).ok()?.parse().ok() };
    let kills = from_environment("KILLS").map_or(few, |kills| kills as usize);
    let seed = from_environment("KILL_SEED").unwrap_or(0) + seed;
    let mut random = Pcg64::seed_from_u64(seed);
    let moments: Vec<u64> = (0..kills).map(|_| random.next_u64() % LATEST_MS).collect();
    let kill = |after_ms| {
        let (place, device, line) = place();
        let place = device.as_ref().map_or(&place, Emulated::place);
        kill_once(place, &line, after_ms)
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
    let saved: f64 = kills.iter().map(|kill| kill.saved).sum();
    let latest = kills.iter().max_by_key(|kill| kill.after_ms);
    println!(
        "{} kills, seed {seed}: {begun} after the log was begun, all recovered, {saved} samples; latest {latest:?}",
        kills.len(),
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_run_killed_at_any_moment_leaves_a_log_that_is_whole_up_to_there() {
    kill_many(6, 1, || {
        let line = "relax --realtime --contact rigid --out run --quiet";
        (Place::new(), None, line.to_owned())
    });
}

#[test]
fn so_does_a_run_on_a_device() {
    kill_many(2, 2, || {
        let device = Emulated::new("");
        let line = "relax --device serial:device watchdog=1s --contact rigid --out run --quiet";
        (Place::new(), Some(device), line.to_owned())
    });
}
