//! `--against`: a measured record over a run, from the command line.

use crate::process::Place;
use testkit::assert_says;

#[test]
fn a_record_lies_over_the_run_in_report_figure_and_table() {
    let place = Place::with_examples();
    place.run("relax --duration 2s --out first").succeeded();
    for line in [
        "relax --duration 2s --against first/relax.csv --out second",
        "relax --duration 2s --against first/relax.mcap --out third",
    ] {
        let report = place.json(line);
        assert_eq!(report["against_error"], 0.0, "{report:#}");
        assert_eq!(report["against_error_samples"], 2001);
    }
    let svg = place.text("second/relax.svg");
    for words in [
        "measured",
        "(d) run less record: rms 0.00 %",
        "difference / %",
    ] {
        assert!(svg.contains(words), "{words}");
    }
    let table = place.text("second/relax.against.csv");
    assert!(table.starts_with(
        "time_s,record_force_n,simulated_force_n,difference_force_n,relative_error\n"
    ));
    assert_eq!(table.lines().count(), 2002);
    // A run without a record leaves no table of one behind.
    place
        .run("relax --duration 2s --out second --overwrite")
        .succeeded();
    assert!(!place.path("second/relax.against.csv").exists());
}

#[test]
fn a_written_document_and_the_log_of_a_run_keep_the_record() {
    let place = Place::with_examples();
    let fish = "--tissue fish-muscle --strain 1% --ramp-time 20ms --duration 5s --contact rigid";
    let line = format!("relax {fish} --against fish-muscle-relaxation.tsv");
    place
        .run(&format!("{line} --write muscle.toml"))
        .succeeded();
    let written = place.text("muscle.toml");
    assert_says(&written, "/fish-muscle-relaxation.tsv\"");
    let report = place.json("run muscle.toml --out muscle");
    // The fit of the library has an rms of 0.0044 in log modulus over all of the record.
    let error = report["against_error"].as_f64().expect("a number");
    assert!((0.002..0.0045).contains(&error), "{error}");
    let notes = report["against"]["notes"].to_string();
    assert_says(&notes, "modulus on the piece, under the load of the run");
    let again = place.json("run muscle/relax.mcap --out again");
    assert_eq!(again["against_error"], report["against_error"]);
    // A file names its record from its own folder.
    place.write(
        "lab.toml",
        "[creep]\nduration_s = 2\nagainst = \"muscle/relax.csv\"\n",
    );
    let report = place.json("run lab.toml --out creep");
    assert!(report["against_error"].as_f64() > Some(0.1), "{report:#}");
}

#[test]
fn a_record_that_cannot_be_laid_over_the_run_is_refused_before_it() {
    let place = Place::with_examples();
    place.write("short.csv", "time_s,force_n\n0,0\n0.4,1\n0.8,1.2\n");
    place.write(
        "modulus.csv",
        "time_s,relaxation_modulus_pa\n1,5000\n2,4000\n3,3000\n",
    );
    place.refuses(
        "
        relax --duration 2s --against short.csv => from 0 s to 0.8 s | holds from 1 s to 2 s | --ramp-time
        relax --duration 2s --against modulus.csv => modulus.csv | two samples on the hold
        run experiments/wall.toml --against short.csv => unknown key `against` in [wall]
        ",
    );
}
