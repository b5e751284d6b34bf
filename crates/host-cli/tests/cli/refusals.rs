//! Bad usage and bad input: each a one-line error with its exit code, and no file made.

mod files;
mod ranges;

use crate::data::GEL;
use crate::experiments::SHORT;
use crate::process::{Place, cases};

/// Runs each line of a table of [`cases`] in a folder that holds only the regular file `file`, and gathers all
/// complaints, so that one run of the test shows every message that is wrong.
fn all_refused(code: i32, table: &str) {
    let mut complaints = Vec::new();
    for (line, wanted) in cases(table) {
        let place = Place::new();
        place.write("file", "");
        let ended = place.run(line);
        complaints.extend(ended.complaint(code, &wanted));
        if place.files() != ["file"] {
            complaints.push(format!("{line}: left {:?}", place.files()));
        }
    }
    let all = complaints.join("\n");
    assert!(all.is_empty(), "{} complaints:\n{all}", complaints.len());
}

#[test]
fn an_analysis_names_the_option_and_writes_large_numbers_short() {
    let stability = "from 0 to 1e12";
    all_refused(
        2,
        &format!(
            "
            analyze passivity --order 0.5 --alpha 1e308 --beta 0.1 => alpha 1e308 is not | {stability} | change --alpha
            analyze passivity --order 0.5 --alpha 0.1 --beta 0.1 --delta 1e300 => delta 1e300 is not | from 0 to 1e6 | change --delta
            analyze passivity --order 0.5 --mass 1e-300 --sample-time 1ms --stiffness 1 --dissipation 1
                => e293 is not | {stability} | --stiffness, --mass or --sample-time
            analyze stability --order 0.5 --mass 0 --sample-time 1ms --stiffness 1 --dissipation 1
                => mass 0 kg is not above 0 and at most 100 kg | change --mass
            analyze stability --order 0.5 --alpha -1 --beta 0.1 => alpha -1 is not | {stability} | change --alpha
            zwidth --mass 0 => --mass 0: mass_kg = 0 is not above 0 and at most 100
            zwidth --mass 1e-30 => fastest motion per step | cannot be simulated
            "
        ),
    );
    let stability = "analyze stability --order 0.5 --mass 100 --sample-time 1e-9 --stiffness 1e-300 --dissipation 1e-300";
    let ended = Place::new().run(stability);
    let longest = ended.stdout.split([' ', ',']).map(str::len).max();
    assert!(longest < Some(30), "{}", ended.stdout);
    ended.succeeded();
}

/// A message shows what it is about, not all that somebody gave.
#[test]
fn long_input_is_not_echoed() {
    let word = "x".repeat(5000);
    let words = "x y ".repeat(2000);
    for long in [&word, &words] {
        let place = Place::new();
        place.write("header.csv", format!("{long}\n1\n"));
        place.write("cell.csv", format!("x\n{long}\n"));
        place.write("key.toml", format!("[wall]\n\"{long}\" = 1\n"));
        place.write("value.toml", format!("[relax]\nscheme = \"{long}\"\n"));
        place.write("number.toml", format!("[relax]\nstrain = \"{long}\"\n"));
        place.write("table.toml", format!("[\"{long}\"]\n"));
        place.write(
            "tissue.toml",
            GEL.replace("\"gel\"", &format!("\"{long}!\"")),
        );
        place.write("unknown.toml", format!("\"{long}\" = 1\n{GEL}"));
        let half = ["differintegrate", "--order", "0.5", "--sample-time", "1ms"];
        let lines: Vec<Vec<&str>> = vec![
            [&half[..], &["header.csv"]].concat(),
            [&half[..], &["cell.csv"]].concat(),
            [&half[..], &["--column", long, "cell.csv"]].concat(),
            vec!["run", "key.toml"],
            vec!["run", "value.toml"],
            vec!["run", "number.toml"],
            vec!["run", "table.toml"],
            vec!["run", long],
            vec![long],
            vec!["relax", "--tissue", "tissue.toml"],
            vec!["relax", "--tissue", "unknown.toml"],
            vec!["relax", "--tissue", long],
            vec!["relax", "--duration", long],
            vec!["relax", "--scheme", long],
            vec!["relax", "--device", long],
            vec!["relax", long],
            vec!["log", "info", long],
            vec!["materials", "show", long],
            vec!["weights", "--order", long],
        ];
        for line in lines {
            let ended = place.run_arguments(&line, &[]).failed(2);
            let shown = ended.stderr.matches(['x']).count();
            // Up to 200 of `x`, and of `x y` half; words of ours have few.
            assert!(shown <= 220, "{shown} x in {ended}");
            assert!(ended.stderr.len() < 2000, "{ended}");
        }
    }
}

#[test]
#[cfg(unix)]
fn endless_input_ends_in_a_message() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    place.shell("ln -s /dev/zero endless.toml; ln -s /dev/zero endless.mcap");
    place.shell("head -c 1048577 /dev/zero > long.toml");
    let half = "differintegrate --order 0.5 --sample-time 1ms";
    for (line, wanted) in [
        (
            format!("{half} /dev/zero"),
            "a row is longer than 1048576 bytes",
        ),
        (
            format!("{half} < /dev/zero"),
            "a row is longer than 1048576 bytes",
        ),
        ("run /dev/zero".to_owned(), "it is not a regular file"),
        ("run endless.toml".to_owned(), "it is not a regular file"),
        (
            "relax --tissue endless.toml".to_owned(),
            "it is not a regular file",
        ),
        (
            "relax --tissue endless library=.".to_owned(),
            "it is not a regular file",
        ),
        ("run long.toml".to_owned(), "longer than 1048576 bytes"),
        (
            "log info endless.mcap".to_owned(),
            "it is not a regular file",
        ),
        (
            "log recover endless.mcap saved.mcap".to_owned(),
            "it is not a regular file",
        ),
    ] {
        let ended = place.shell(&format!("exec \"$0\" {line}")).failed(2);
        assert!(ended.error().contains(wanted), "{ended}");
    }
    // A quote that is never closed makes all that follows one row.
    let quote = format!("(echo x; echo '\"'; yes 1) | \"$0\" {half}");
    let ended = place.shell(&quote).failed(2);
    assert!(ended.error().contains("is every quote closed?"), "{ended}");
    // Where the records of a log become a terabyte of zeros, it is damaged.
    let zeros = "truncate -s 1T run/relax.mcap.cut; exec \"$0\" log check run/relax.mcap.cut";
    let bytes = place.read("run/relax.mcap");
    for kept in [8, 40, bytes.len() / 2] {
        place.write("run/relax.mcap.cut", &bytes[..kept]);
        let ended = place.shell(zeros).failed(4);
        assert!(ended.error().contains("not whole"), "{ended}");
    }
}

#[test]
fn an_option_without_effect_is_refused_with_what_would_give_it_one() {
    let seed = "seed=7: seed has no effect without noise | sensor_noise_m";
    let specimen = "belongs to the wish tissue: omit it";
    let overwrite = "no effect | --out | leave --overwrite out";
    let bounding = "no effect | --guard energy-bounding | leave `device_";
    all_refused(
        2,
        &format!(
            "
            relax seed=7 => {seed}
            design --device-model laboratory seed=7 => {seed}
            relax --overwrite => {overwrite}
            creep --overwrite => {overwrite}
            zwidth --overwrite => {overwrite}
            design --overwrite => {overwrite}
            relax jump=1mm => jump 0.001 m | no effect | `speed_limit_m_per_s` | leave `jump_m`
            relax stuck_time=50ms => 0.05 s | no effect | `stuck_force_n` | leave `stuck_time_s`
            relax device_mass=65g => 0.065 kg | no effect | --guard observer | `braking_n_s_per_m`
            relax device_mass=65g --guard energy-bounding => 0.065 kg | no effect | --guard observer
            relax device_damping=3.5 => {bounding}
            relax device_damping=3.5 --guard observer => {bounding}
            relax device_delay_least=1ms device_delay_most=1ms => {bounding}
            creep device_lag=1ms => {bounding}
            relax device_noise=1um => {bounding}
            relax --device serial:nowhere precision=f64 => precision=f64: precision has no effect | --loop host
            design area=4cm2 => {specimen}
            design thickness=20mm => {specimen}
            design --wish coupler --force-limit 3N => belongs to a wall
            "
        ),
    );
}

#[test]
fn bad_usage_is_refused_in_one_line() {
    all_refused(
        2,
        "
        rleax => rleax | relax
        relax --stain 5% => --stain | --strain
        relax --strain => --strain
        relax precision=f16 => precision=f16 | f32 | f64
        weights => --order
        weights --order 0.5 --count 0 => 0 | --count
        weights --order 0.5 --count -3 => -3 | --count
        weights --order 0.5 --count 100000000 => 100000000 | 10000000 | --count
        completions csh => csh | bash
        log info => LOG
        ",
    );
}

#[test]
fn a_command_without_its_command_shows_help_as_bad_usage() {
    for (line, word) in [("", "relax"), ("log", "recover"), ("materials", "show")] {
        let ended = Place::new().run(line);
        assert_eq!(ended.code, Some(2), "{ended}");
        assert_eq!(ended.stdout, "", "{ended}");
        assert!(ended.stderr.contains("Usage: "), "{ended}");
        assert!(ended.stderr.contains(word), "{ended}");
    }
}

#[test]
fn what_a_clock_cannot_do_is_refused() {
    let realtime = "relax --realtime --duration 1s --ramp-time 0.5s";
    all_refused(
        2,
        &format!(
            "
            {realtime} --priority 0 => 0 | 1 to 99 | --priority
            {realtime} --priority 100 => 100 | off | --priority
            {realtime} --priority high => high | 1 to 99 | --priority
            {realtime} --priority -1 => -1 | 1 to 99 | --priority
            {realtime} --pin -1 => -1 | --pin | whole number
            {realtime} --sample-time 1us => period | 1e-5 | --sample-time
            "
        ),
    );
    all_refused(
        2,
        "
        relax --priority 50 => --priority | --realtime
        relax --pin 0 => --pin | --realtime
        creep --priority off => --priority | --realtime
        rt-check --duration 0 => 0 | [0.01, 86400] s | --duration
        rt-check --duration -1s => -1 | --duration
        rt-check --duration NaN => NaN | --duration
        rt-check --duration 2000h => 86400 | --duration
        rt-check --rate 0 => 0 Hz | [1, 100000] Hz | --rate
        rt-check --rate 1e6 => 1e6 Hz | --rate
        rt-check --rate fast => fast | kHz | --rate
        rt-check --busy -1 => -1 | --busy
        rt-check --busy 5000 => 5000 | --busy
        rt-check --priority 100 => 100 | 1 to 99 | --priority
        ",
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_core_that_is_not_there_is_refused() {
    all_refused(
        2,
        "
        rt-check --pin 100000 => core 100000 | --pin one of
        relax --realtime --pin 100000 => core 100000 | --pin one of
        ",
    );
}
