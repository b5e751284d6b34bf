//! Bad usage and bad input: each a one-line error with its exit code, and no file made.

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
fn an_option_without_effect_is_refused_with_what_would_give_it_one() {
    all_refused(
        2,
        "
        relax seed=7 => seed=7: seed has no effect without noise | sensor_noise_m
        zwidth threshold=1mm => threshold=1mm: threshold_m has no effect with the criterion settling | `criterion` = dissertation
        zwidth --campaign night => --campaign night: campaign has no effect on the simulated device | omit --campaign
        zwidth impact=1 --push-by device => impact_m_per_s has no effect where the device pushes by itself | push-by
        zwidth --push-by nobody => nobody | hand, device
        zwidth --push-by device --push 0N => push_n = 0 is not above 0
        zwidth --push-by device --push=-1N => push_n = -1 is not above 0
        zwidth --push-by device --push 200N => no wall could hold it
        zwidth --tissue liver --orders 1 => --orders 1: it has no effect beside --tissue: omit it
        zwidth --tissue liver --points 3 => --points 3: it has no effect beside --tissue: omit it
        zwidth area=1cm2 => area=1cm2: it belongs to a tissue: give --tissue, or omit it
        relax --overwrite => no effect | --out | omit --overwrite
        relax device_mass=65g => 0.065 kg | no effect | --guard observer | `braking_n_s_per_m`
        relax --device serial:nowhere precision=f64 => precision=f64: precision has no effect | --loop host
        ",
    );
}

#[test]
fn bad_usage_is_refused_in_one_line() {
    all_refused(
        2,
        "
        rleax => rleax | relax
        zwidth --tissue mucus --scheme muir:3 => muir:3 | --scheme full
        zwidth --tissue passive-muscle => not linear in its depth | slab
        zwidth --tissue liver area=0 => area_m2 = 0 is not above 0 | 10
        relax --stain 5% => --stain | --strain
        relax --strain => --strain
        weights --order 0.5 --count 0 => 0 | --count
        log info => LOG
        ",
    );
}

#[test]
fn a_command_without_its_command_shows_help_as_bad_usage() {
    for (line, word) in [("", "relax"), ("log", "recover")] {
        let ended = Place::new().run(line);
        assert_eq!(ended.code, Some(2), "{ended}");
        assert_eq!(ended.stdout, "", "{ended}");
        assert!(ended.stderr.contains("Usage: "), "{ended}");
        assert!(ended.stderr.contains(word), "{ended}");
    }
}

#[test]
fn what_a_clock_cannot_do_is_refused() {
    all_refused(
        2,
        "
        relax --realtime --priority 0 => 0 | 1 to 99 | --priority
        relax --priority 50 => --priority | --realtime
        rt-check --rate 0 => rate 0 Hz is not from 1 Hz to 100 kHz: change --rate
        ",
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_core_that_is_not_there_is_refused() {
    all_refused(2, "rt-check --pin 100000 => core 100000 | --pin one of");
}

/// Ranges are tested where they are: in the tables of `haptic-experiment`, and in the unit tests of this command.
#[test]
fn a_value_is_refused_in_the_words_in_which_it_was_given() {
    all_refused(
        2,
        "
        relax --strain 500% => --strain 500%: strain = 5 is not above 0 and at most 1 | omit it for 0.05
        relax strain=5mm => strain=5mm | % | is not a number
        relax stress=5 => stress=5: unknown key `stress` in [relax] | did you mean `strain`
        relax --strain 4% strain=3% => strain=3%: strain is given twice, also as --strain 4%
        relax --tissue jelly => jelly | prostate-cancerous | prostate-healthy
        weights --order 3 => order 3 is not from -2 to 2: change --order
        differintegrate --order 0.5 --sample-time 0 file => 0 s | --sample-time
        ",
    );
}

#[test]
fn a_file_may_have_a_name_that_is_no_text() {
    use std::os::unix::ffi::OsStrExt as _;
    let place = Place::new();
    let mut command = place.command("log info");
    command.arg(std::ffi::OsStr::from_bytes(b"a\xff.mcap"));
    let output = command.output().expect("runs");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.starts_with("error: "), "{message}");
}

/// Permissions do not stop the superuser; a folder below a regular file cannot be made by anyone.
#[test]
fn a_folder_that_cannot_be_made_is_refused() {
    all_refused(
        2,
        "
        relax --out file/run => file/run | --out
        man file/run => file/run
        ",
    );
}

#[test]
fn files_of_an_earlier_run_are_kept_unless_overwriting_is_asked_for() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    let files = place.files();
    let (log, csv) = (place.read("run/relax.mcap"), place.read("run/relax.csv"));
    let other = format!("{SHORT} --strain 4%");
    let ended = place.run(&other);
    ended.refused(2, &["run/relax.mcap", "already exists", "--overwrite"]);
    assert!(place.read("run/relax.mcap") == log && place.read("run/relax.csv") == csv);

    place.run(&format!("{other} --overwrite")).succeeded();
    assert_eq!(place.files(), files);
    assert!(place.read("run/relax.mcap") != log && place.read("run/relax.csv") != csv);
}

#[test]
fn one_file_of_an_earlier_run_is_enough_to_be_refused() {
    for ending in ["csv", "mcap.part"] {
        let place = Place::new();
        let name = format!("run/relax.{ending}");
        std::fs::create_dir(place.path("run")).expect("makes the folder");
        place.write(&name, "theirs");
        place.run(SHORT).refused(2, &[name.as_str()]);
        assert_eq!(place.files(), ["run/", &name]);
        assert_eq!(place.text(&name), "theirs");
    }
}

#[test]
fn bad_parameters_do_not_cost_the_files_they_would_have_overwritten() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    let files = place.files();
    for bad in ["--strain 0", "--scheme oustaloup:3:100:1"] {
        place.run(&format!("{SHORT} --overwrite {bad}")).failed(2);
        assert_eq!(place.files(), files, "after {bad}");
    }
}

#[test]
fn a_cut_log_in_the_way_costs_nothing_either() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    place.write("run/relax.mcap.part", "");
    let files = place.files();
    let ended = place.run(&format!("{SHORT} --overwrite"));
    ended.refused(2, &["run/relax.mcap.part", "log recover"]);
    assert_eq!(place.files(), files);
}

/// A pipe that nobody writes to must not be waited for.
#[test]
fn a_pipe_is_no_record_and_no_log() {
    let place = Place::new();
    place.shell("mkfifo q.csv p.mcap").succeeded();
    place.refuses(
        "
        log info p.mcap => p.mcap | not a regular file
        identify p.mcap --area 4cm2 --thickness 20mm => p.mcap | not a regular file
        control analyze --plant q.csv => q.csv | not a regular file
        ",
    );
    assert_eq!(place.files().len(), 2, "nothing was written");
}
