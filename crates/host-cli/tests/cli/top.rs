//! The terminal view of a run, without a terminal: logs that grow, end, are cut off or deleted, drawn into memory.
#![cfg(all(feature = "top", unix))]

use crate::process::says;
use haptic_log::record::{END, EndKind, EventMessage, LogWriter, RunEnd, StartTime, TickMessage};
use host_cli::top::draw::draw;
use host_cli::top::follow::Run;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use std::fs::File;
use std::io::{BufWriter, Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

/// What a terminal of this size shows.
fn shown(run: Option<&Run>, columns: u16, rows: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).expect("memory");
    terminal.draw(|frame| draw(frame, run)).expect("draws");
    let buffer = terminal.backend().buffer();
    let lines = buffer.content().chunks(usize::from(columns).max(1));
    let lines = lines.map(|line| {
        line.iter()
            .map(ratatui::buffer::Cell::symbol)
            .collect::<String>()
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn log(folder: &Path) -> LogWriter<BufWriter<File>> {
    let mut log = LogWriter::create(&folder.join("relax.mcap")).expect("creates");
    let what = [("experiment", "relax"), ("device", "sim")];
    let what = what.map(|(key, value)| (key.to_owned(), value.to_owned()));
    log.metadata("experiment", what.into()).expect("writes");
    log.starts_at(StartTime::at(SystemTime::now()))
        .expect("writes");
    log
}

/// Ticks at 1 kHz; the force is −1 N but for one peak, and every second one is limited.
fn ticks(log: &mut LogWriter<BufWriter<File>>, ticks: std::ops::Range<u64>) {
    for tick in ticks {
        let message = TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            position_m: 2e-3,
            commanded_force_n: if tick == 555 { 7.5 } else { -1.0 },
            environment_force_n: -1.25,
            limiters: (tick % 2) as u8,
            observed_energy_j: f64::NAN,
            ..TickMessage::default()
        };
        log.tick(&message).expect("writes");
    }
}

fn read(run: &mut Run) {
    while run.read().expect("reads") {}
}

#[test]
fn a_run_is_shown_while_it_goes_and_when_it_has_ended() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log = log(folder.path());
    let mut run = Run::attach(folder.path()).expect("a run");
    assert!(shown(Some(&run), 120, 40).contains("no sample yet"));
    ticks(&mut log, 0..1000);
    // Ten are lost.
    ticks(&mut log, 1010..1101);
    read(&mut run);
    let screen = shown(Some(&run), 120, 40);
    says(
        &screen,
        &[
            "relax.mcap  relax on sim  running",
            "no fault",
            "position 2.0000 mm",
            "force -1.0000 N · -1.0000 to 7.5000 in the last 10 s",
            "period          1000 µs",
            "lost            10",
            "wanted force    -1.2500 N",
            "energy          –",
            "magnitude        50.1 %  545",
            "q ends this view",
        ],
    );
    // The peak of one sample fills its column; a value that stays has a bar too.
    assert!(screen.contains('█') && screen.contains('▁'), "{screen}");
    ticks(&mut log, 1101..2000);
    let end = RunEnd {
        ended: EndKind::Finished,
        reason: String::new(),
        planned_samples: 2000,
        made_samples: 2000,
        dropped_samples: 3,
    };
    log.metadata(END, end.metadata()).expect("writes");
    log.finish().expect("finishes");
    read(&mut run);
    assert!(!run.goes_on());
    let screen = shown(Some(&run), 120, 40);
    says(
        &screen,
        &["finished", "device time     1.999 s", "dropped         3"],
    );
}

#[test]
fn a_fault_is_the_first_thing_to_be_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log = log(folder.path());
    ticks(&mut log, 0..100);
    let text = "the device left its workspace".to_owned();
    let event = EventMessage {
        time_s: 0.1,
        kind: "fault".to_owned(),
        text,
    };
    log.event(&event).expect("writes");
    ticks(&mut log, 100..300);
    let mut run = Run::attach(&folder.path().join("relax.mcap")).expect("a run");
    read(&mut run);
    let screen = shown(Some(&run), 100, 40);
    assert!(
        screen.contains("FAULT: the device left its workspace"),
        "{screen}"
    );
    assert!(
        screen.contains("0.100 s  fault: the device left"),
        "{screen}"
    );
}

#[test]
fn a_log_that_is_deleted_or_cut_off_is_said_to_be() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut first = log(folder.path());
    ticks(&mut first, 0..300);
    let mut run = Run::attach(folder.path()).expect("a run");
    read(&mut run);
    std::fs::remove_file(folder.path().join("relax.mcap.part")).expect("removes");
    ticks(&mut first, 300..600);
    read(&mut run);
    assert_eq!(run.figures.samples, 500, "what comes is shown all the same");
    assert!(shown(Some(&run), 140, 40).contains("the log was deleted"));
    drop(first);
    read(&mut run);
    assert!(!run.goes_on());

    // A process that dies writes no end.
    let second = log(folder.path());
    let mut run = Run::attach(folder.path()).expect("a run");
    read(&mut run);
    assert!(run.goes_on());
    drop(second);
    read(&mut run);
    assert!(!run.goes_on());
    let screen = shown(Some(&run), 140, 40);
    assert!(
        screen.contains("cut off: the process that wrote the log is gone"),
        "{screen}"
    );
}

#[test]
fn a_log_in_several_files_is_followed_into_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = folder.path().join("day.mcap");
    let mut log =
        haptic_log::record::RollingLog::create(&first, [].into(), false).expect("creates");
    log.roll_at(haptic_log::record::ROLL_LEAST);
    let mut run = Run::attach(&first).expect("a run");
    for tick in 0..30_000 {
        let message = TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            ..TickMessage::default()
        };
        log.tick(&message).expect("writes");
        if tick % 5000 == 0 {
            read(&mut run);
        }
    }
    let done = log.finish().expect("finishes");
    assert!(done.paths.len() > 1, "{done:?}");
    read(&mut run);
    assert_eq!((run.figures.samples, run.figures.samples_lost), (30_000, 0));
    assert!(!run.goes_on());
}

#[test]
fn any_size_of_terminal_can_be_drawn_into() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log = log(folder.path());
    ticks(&mut log, 0..300);
    let mut run = Run::attach(folder.path()).expect("a run");
    read(&mut run);
    for (columns, rows) in [(1, 1), (2, 50), (20, 5), (80, 24), (300, 100)] {
        shown(Some(&run), columns, rows);
        shown(None, columns, rows);
    }
    assert!(shown(None, 80, 24).contains("No run goes on under results/"));
}

fn host_cli(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("host-cli"));
    command
        .args(arguments.split(' '))
        .current_dir(folder)
        .stdin(Stdio::null());
    command
}

#[test]
fn the_command_finds_the_run_that_goes_on_and_refuses_what_is_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |arguments: &str| host_cli(folder.path(), arguments).output().expect("runs");
    let said = |output: &std::process::Output| String::from_utf8_lossy(&output.stderr).into_owned();
    // Nothing goes on; no terminal; no log.
    let none = run("top --json");
    assert_eq!(none.status.code(), Some(2), "{}", said(&none));
    assert!(
        said(&none).contains("no run goes on under `results`"),
        "{}",
        said(&none)
    );
    let terminal = run("top");
    assert_eq!(terminal.status.code(), Some(2), "{}", said(&terminal));
    assert!(
        said(&terminal).contains("needs a terminal"),
        "{}",
        said(&terminal)
    );
    std::fs::write(folder.path().join("no.mcap"), "words").expect("writes");
    let words = run("top --json --attach no.mcap");
    assert_eq!(words.status.code(), Some(2), "{}", said(&words));
    // A run by the clock, in a folder of its own choice.
    let mut going = host_cli(folder.path(), "relax --realtime --duration 60s --quiet")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("runs");
    let mut figures = serde_json::Value::Null;
    for _ in 0..600 {
        let output = run("top --json");
        if output.status.success() {
            figures = serde_json::from_slice(&output.stdout).expect("JSON");
            // A second has passed, and the log says where its time went.
            if figures["timing"]["lateness_us_p99"].is_string() {
                break;
            }
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    going.kill().expect("can be killed");
    going.wait().expect("ends");
    assert_eq!(figures["running"], true, "{figures}");
    assert!(figures["timing"]["compute_us_max"].is_string(), "{figures}");
    assert!(figures["samples"].as_u64() > Some(100), "{figures}");
    assert_eq!(figures["experiment"]["experiment"], "relax", "{figures}");
    let dead = run("top --json results/relax-0001");
    let dead: serde_json::Value = serde_json::from_slice(&dead.stdout).expect("JSON");
    assert!(
        dead["state"]
            .as_str()
            .expect("words")
            .starts_with("cut off"),
        "{dead}"
    );
}

#[test]
fn a_key_ends_the_view_and_gives_the_terminal_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log = log(folder.path());
    ticks(&mut log, 0..300);
    for key in ["q", "\x03"] {
        // A pseudo-terminal around the binary.
        let binary = assert_cmd::cargo::cargo_bin!("host-cli");
        let line = format!(
            "stty cols 120 rows 40; timeout --foreground 60 {} top --attach .",
            binary.display()
        );
        let spawned = Command::new("script")
            .args(["--quiet", "--return", "--command", &line, "/dev/null"])
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let Ok(mut view) = spawned else {
            return testkit::skip("there is no script(1) to make a terminal");
        };
        let mut keys = view.stdin.take().expect("piped");
        let mut shown = view.stdout.take().expect("piped");
        let mut screen = String::new();
        let mut part = [0; 4096];
        // Only a view that is there takes a key.
        let mut pressed = false;
        loop {
            let taken = shown.read(&mut part).expect("the screen");
            if taken == 0 {
                break;
            }
            screen += &String::from_utf8_lossy(&part[..taken]);
            if !pressed && screen.contains("running") {
                keys.write_all(key.as_bytes()).expect("takes it");
                pressed = true;
            }
        }
        let code = view.wait().expect("ends").code();
        assert_eq!((code, pressed), (Some(0), true), "{screen}");
        // The other screen was entered and left.
        assert!(
            screen.contains("\x1b[?1049h") && screen.contains("\x1b[?1049l"),
            "{screen:?}"
        );
    }
}
