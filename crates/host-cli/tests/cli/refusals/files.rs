//! Folders and files in the way.

use super::all_refused;
use crate::experiments::SHORT;
use crate::process::Place;

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
#[cfg(unix)]
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
