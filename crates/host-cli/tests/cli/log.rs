//! `log`: what is in a log, whether it is whole, and what a cut one still holds.

mod checked;
mod damaged;
mod runs;

use crate::experiments::SHORT;
use crate::process::{Place, number, row, table};
use haptic_log::record::LogWriter;
use haptic_message::TickMessage;
use serde_json::Value;
use testkit::assert_says;

/// Header of `log export`.
const COLUMNS: &str = "tick,time_s,reference_m,indenter_position_m,position_m,environment_force_n,\
                       commanded_force_n,applied_force_n,contact_force_n,limiters,flaws,observed_energy_j,sensed_force_n";

/// A place with `run/relax.mcap` of 3001 samples.
fn with_log() -> Place {
    let place = Place::new();
    place.run(SHORT).succeeded();
    place
}

#[test]
fn export_writes_every_tick() {
    let place = with_log();
    let export = place.run("log export run/relax.mcap --json").succeeded();
    assert_eq!(export.json()["csv"], "run/relax.ticks.csv");
    let rows = table(&place.text("run/relax.ticks.csv"), COLUMNS);
    assert_eq!(rows.len(), 3001);
    let experiment = place.text("run/relax.csv");
    for (n, (row, line)) in rows.iter().zip(experiment.lines().skip(1)).enumerate() {
        assert_eq!(row[0], n as f64, "tick");
        // The experiment's CSV has positive reaction forces, the log forces along the position.
        let cells = line.split(',').take(4);
        let cells: Vec<f64> = cells.map(|cell| cell.parse().expect("number")).collect();
        assert_eq!(
            [row[1], row[4], -row[6]],
            [cells[0], cells[2], cells[3]],
            "tick {n}"
        );
    }
}

#[test]
fn info_says_what_is_in_a_log() {
    let place = with_log();
    let info = place.json("log info run/relax.mcap");
    let numbers = ["samples", "first_s", "last_s"].map(|key| number(&info, key));
    assert_eq!(numbers, [3001.0, 0.0, 3.0]);
    assert_eq!(info["gaps"], Value::Array(Vec::new()));
    assert_eq!(info["complete"], true);
    let text = place.run("log info run/relax.mcap").succeeded();
    for (label, value) in [("samples", "3001"), ("complete", "yes"), ("strain", "0.05")] {
        assert_eq!(row(&text.stdout, label), value);
    }
}

#[test]
fn a_run_rolls_its_log_on_request() {
    let place = Place::new();
    let line = "relax --duration 30s --out run --roll 1MB --json";
    let report = place.run(line).succeeded().json();
    let logs = report["logs"].as_array().expect("a list");
    assert!(logs.len() >= 2, "{report}");
    assert_eq!(report["log"], logs[0]);
    assert_eq!(logs[1], "run/relax-0002.mcap");
    for command in ["check", "info"] {
        let line = format!("log {command} run/relax.mcap --json");
        let found = place.run(&line).succeeded().json();
        assert_eq!(number(&found, "samples"), 30_001.0, "{command}");
    }
    // The second file on its own names the first, and lacks nothing before its own first sample.
    let second = place.run("log check run/relax-0002.mcap");
    let second = second.succeeded_with_warnings();
    assert_says(&second.stderr, "check relax.mcap for the whole log");
    assert_eq!(row(&second.stdout, "continues"), "relax.mcap");
    let first = place.run("log check run/relax.mcap").succeeded();
    assert!(!first.stdout.contains("continues"), "{first}");
    let whole = place.run("log export run/relax.mcap -").succeeded();
    assert_eq!(table(&whole.stdout, COLUMNS).len(), 30_001);
    let copy = place.json("log recover run/relax.mcap --out .");
    assert_eq!(copy["log"], "./relax.recovered.mcap");
    // Nothing of it is written over unasked, the second file as little as the first.
    std::fs::remove_file(place.path("run/relax.mcap")).expect("removes");
    for name in ["csv", "svg", "png"] {
        std::fs::remove_file(place.path(&format!("run/relax.{name}"))).expect("removes");
    }
    let refused = place.run(SHORT).failed(2);
    assert!(refused.error().contains("relax-0002.mcap"), "{refused}");
    // What a run that died has left is seen at the start, not when the next one gets there.
    place.write("run/relax-0003.mcap.part", "cut");
    let again = place.run(&format!("{SHORT} --overwrite"));
    again.refused(2, &["relax-0003.mcap.part", "log recover"]);
}

#[test]
fn export_to_standard_output_is_the_file() {
    let place = with_log();
    let printed = place.run("log export run/relax.mcap -").succeeded();
    let export = place.json("log export run/relax.mcap");
    assert_eq!(export["csv"], "run/relax.ticks.csv");
    assert!(
        printed.stdout == place.text("run/relax.ticks.csv"),
        "differ"
    );
    assert_eq!(table(&printed.stdout, COLUMNS).len(), 3001);
    assert!(!place.files().iter().any(|file| file.starts_with('-')));
    let bytes = place.read("run/relax.mcap");
    place.write("cut.mcap", &bytes[..bytes.len() / 2]);
    let cut = place.run("log export cut.mcap -").failed(4);
    assert!(cut.stdout.lines().count() > 1000, "{}", cut.error());
}

#[test]
fn export_and_recover_overwrite_nothing() {
    let place = with_log();
    place.write("taken", "theirs");
    for command in ["export", "recover"] {
        let into = |target: &str| place.run(&format!("log {command} run/relax.mcap {target}"));
        into("taken").refused(2, &["taken", "already exists"]);
        assert_eq!(place.text("taken"), "theirs");
        // Not over what is read, asked for or not.
        for target in ["run/relax.mcap", "run/relax.mcap --overwrite"] {
            into(target).refused(2, &["run/relax.mcap", "the log it is made from"]);
        }
    }
    place.run("log check run/relax.mcap").succeeded();
    // Another one is replaced when that is asked for.
    let saved = place.json("log recover run/relax.mcap taken --overwrite");
    assert_eq!(saved["complete"], true);
    place.run("log check taken").succeeded();
}

#[test]
fn plot_draws_a_picture_and_replaces_it_only_when_asked() {
    let place = with_log();
    let plot = "log plot run/relax.mcap --out pictures";
    let made = place.run(&format!("{plot} --json")).succeeded().json();
    assert_eq!(made["figure"], "pictures/relax.log.png");
    assert_eq!(number(&made, "samples"), 3001.0);
    assert_eq!(place.read("pictures/relax.log.png")[..4], *b"\x89PNG");
    assert!(place.text("pictures/relax.log.svg").contains("</svg>"));
    place
        .run(plot)
        .refused(2, &["pictures/relax.log", "exists"]);
    place.run(&format!("{plot} --overwrite")).succeeded();
}

#[test]
fn what_is_no_log_is_refused_by_its_name() {
    let place = Place::new();
    place.write("text", "lag,weight\n0,1\n");
    let before = place.files();
    for command in ["check", "recover"] {
        for (name, reason) in [("text", "not an MCAP log"), ("nowhere", "No such file")] {
            let ended = place.run(&format!("log {command} {name}"));
            let ended = ended.refused(2, &[name, reason]);
            // One line says the cause once.
            assert!(ended.error().matches("os error").count() <= 1, "{ended}");
        }
    }
    assert_eq!(place.files(), before);
}

#[test]
fn a_target_that_cannot_be_written_is_refused_by_its_name() {
    let place = with_log();
    let before = place.files();
    let ended = place.run("log recover run/relax.mcap run/relax.csv/new");
    let ended = ended.refused(2, &["run/relax.csv/new"]);
    assert!(!ended.error().contains("host-cli-tmp"), "{ended}");
    assert_eq!(ended.error().matches("os error").count(), 1, "{ended}");
    assert_eq!(place.files(), before);
}

#[test]
fn a_long_log_is_drawn_with_its_extremes() {
    let place = Place::new();
    let path = place.path("long.mcap");
    let mut log = LogWriter::create(&path).expect("creates");
    // 300 s at 1 kHz, and one tick in which everything is far out.
    for tick in 0..300_000 {
        let far = if tick == 123_457 { 10.0 } else { 1.0 };
        let position_m = (1e-3 * far * (1e-4 * tick as f64).sin()).into();
        let commanded_force_n = (-far).into();
        let time_s = 1e-3 * tick as f64;
        let tick = TickMessage {
            tick,
            time_s,
            position_m,
            commanded_force_n,
            ..TickMessage::at_rest(1)
        };
        log.tick(&tick).expect("writes");
    }
    log.finish().expect("finishes");
    let plotted = place.json("log plot long.mcap");
    assert_eq!(number(&plotted, "samples"), 300_000.0);
    // The axis reaches the one force, which pushes back.
    let picture = place.text("long.log.svg");
    assert!(
        picture.contains(">10</text>"),
        "the largest force is not drawn"
    );
    assert!(picture.len() < 3_000_000, "{}", picture.len());
}

#[test]
fn standard_output_takes_a_csv_and_nothing_else() {
    let place = Place::with_examples();
    place.run(SHORT).succeeded();
    let before = place.files();
    place.refuses(
        "
        log cut run/relax.mcap - --from 1s => `-` stands for standard output | ./-
        log recover run/relax.mcap - => `-` stands for standard output | ./-
        log recover run/relax.mcap - --overwrite => `-` stands for standard output | ./-
        run experiments/wall.toml --write - => `-` stands for standard output | ./-
        ",
    );
    assert_eq!(place.files(), before);
    place
        .run("log cut run/relax.mcap ./- --from 1s")
        .succeeded();
    assert!(place.path("-").exists());
}
