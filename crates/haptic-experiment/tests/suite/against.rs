//! A measured record over a run: it is converted, laid on the run's clock and compared, or refused in a line.

use crate::ran;
use haptic_document::Document;
use haptic_experiment::ExperimentFile;
use haptic_log::record::{Entry, LogReader};
use haptic_run::read_document;
use libm::tgamma;
use serde_json::Value;
use std::{fmt::Write as _, path::Path};
use testkit::{Folder, assert_says};

/// Runs a document whose files lie in this folder: its report.
fn run(folder: &Path, name: &str, text: &str) -> Value {
    let document = Document::of_text(&folder.join("own.toml"), text);
    let report = ran(&document, folder.join(name));
    serde_json::to_value(&report).expect("a report")
}

/// Why a document is refused.
fn refused(folder: &Path, text: &str) -> String {
    let document = Document::of_text(&folder.join("own.toml"), text);
    let error = ExperimentFile::open(&document).expect_err(text).to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

fn number(report: &Value, key: &str) -> f64 {
    let number = report[key].as_f64();
    number.unwrap_or_else(|| panic!("no {key} in {report:#}"))
}

/// Writes a table of these columns.
fn table(folder: &Path, header: &str, rows: impl Iterator<Item = Vec<f64>>) {
    let mut text = format!("{header}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        let _ = writeln!(text, "{}", cells.join("\t"));
    }
    std::fs::write(folder.join("record.tsv"), text).expect("writes");
}

/// Time, position and force of a run, as its log has them.
fn samples(log: &Path) -> Vec<[f64; 3]> {
    let entries = LogReader::open(log).expect("opens");
    let ticks = entries.filter_map(|entry| {
        let Entry::Tick(tick) = entry.expect("reads") else {
            return None;
        };
        Some([
            tick.time_s,
            tick.position_m[0],
            0.0 - tick.commanded_force_n[0],
        ])
    });
    ticks.collect()
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_record_made_from_the_run_itself_is_not_off_at_all() {
    for text in [
        "[relax]\nduration_s = 2",
        "[relax]\nduration_s = 2\nsensor_noise_m = 1e-6",
        "[relax]\nduration_s = 1\nramp_time_s = 0.01\nloading = \"sphere\"\nindenter_radius_m = 5e-3\ndepth_m = 1e-3",
        "[creep]\nduration_s = 2",
        "[creep]\nduration_s = 2\nloading = \"sphere\"\nindenter_radius_m = 5e-3\nforce_n = 0.01",
    ] {
        let folder = Folder::empty();
        run(&folder, "first", text);
        for (name, record) in [("log", "run.mcap"), ("csv", "run.csv")] {
            let text = format!("{text}\nagainst = \"first/{record}\"");
            let report = run(&folder, name, &text);
            assert_eq!(report["against_error"], 0.0, "{text}: {report:#}");
            assert_eq!(report["against_largest_error"], 0.0, "{text}");
            assert_eq!(report["against"]["record_start_s"], 0.0, "{text}");
            // Every sample is compared.
            let compared = &report["against_error_samples"];
            assert_eq!(*compared, report["samples"], "{text}");
            // Path and document are in the log, so that the run can be repeated.
            let log = folder.join(name).join("run.mcap");
            let again = read_document(&log).expect("a document");
            ExperimentFile::open(&again).expect("finds its record again");
        }
    }
}

#[test]
fn a_record_in_other_units_with_a_rest_and_noise_is_laid_on_the_ramp() {
    let folder = Folder::empty();
    let text = "[relax]\nduration_s = 3\ncontact = \"rigid\"\narea_m2 = 5e-4";
    run(&folder, "first", text);
    let first = samples(&folder.join("first/run.mcap"));
    let rest = (0..200).map(|n| [0.01 * f64::from(n) - 2.0, 0.0, 0.0]);
    let all: Vec<[f64; 3]> = rest.chain(first).collect();
    // An instrument that reads a tenth too much, in its own units, of which the force is half a kilopascal a millinewton here.
    let noise = |n: usize, size: f64| size * (1e4 * (n as f64).sin()).fract();
    let rows = all.iter().enumerate().map(|(n, [time, depth, force])| {
        let depth_mm = 12.5 + 1e3 * depth + noise(n, 1e-5);
        vec![1e3 * (time + 7.5), depth_mm, -1.1 * 1e-3 * force / 5e-4]
    });
    table(&folder, "Time (ms)\tExtension (mm)\tStress (kPa)", rows);
    let against = format!("{text}\nagainst = \"record.tsv\"");
    let report = run(&folder, "second", &against);
    // 1/1.1 − 1, and a start that is late by at most the two samples in which the way leaves its noise.
    for key in ["against_error", "against_largest_error"] {
        let off = number(&report, key) - (1.0 - 1.0 / 1.1);
        assert!(off.abs() < 3e-4, "{key}: {off:e}");
    }
    let start_s = report["against"]["record_start_s"]
        .as_f64()
        .expect("a start");
    assert!((7.5..7.503).contains(&start_s), "{start_s}");
    let notes = report["against"]["notes"].to_string();
    for words in [
        "stress times the area",
        "sign of the record is turned",
        "time is 0 where the record ends its rest",
    ] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
    assert_eq!(
        report["warnings"].as_array().map(Vec::len),
        Some(0),
        "{report:#}"
    );
    // Held at another depth it is another experiment, and that is said.
    let deeper = format!("{against}\nstrain = 0.06");
    let report = run(&folder, "third", &deeper);
    let notes = report["against"]["notes"].to_string();
    assert_says(&notes, "the record is held at 1 mm, the run at 1.2 mm");
    // So it is at another strain of the slab.
    let strained = [0.0, 1.0, 2.0].map(|time: f64| vec![time, 0.06 * time.min(1.0), time]);
    table(&folder, "time_s\tstrain\tstress_pa", strained.into_iter());
    let report = run(
        &folder,
        "fourth",
        "[relax]\nstrain = 0.05\nduration_s = 2\nagainst = \"record.tsv\"",
    );
    let notes = report["against"]["notes"].to_string();
    assert_says(&notes, "the record is held at 1.2 mm, the run at 1 mm");
}

/// Healthy prostate: η in Pa·s^α, and α.
const VISCOSITY: f64 = 3610.0;
const ORDER: f64 = 0.2154;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_modulus_is_driven_through_the_ramp_of_the_run() {
    let folder = Folder::empty();
    // E(t) = η·t^(−α)/Γ(1 − α), twenty samples a decade.
    let rows = |factor: f64| {
        (0..=100).map(move |n| {
            let time = 1e-3 * 10_f64.powf(f64::from(n) / 20.0);
            vec![
                time,
                factor * VISCOSITY * time.powf(-ORDER) / tgamma(1.0 - ORDER),
            ]
        })
    };
    let slab = "[relax]\ntissue = \"prostate-healthy\"\nduration_s = 50\ncontact = \"rigid\"\nforce_limit_n = 100";
    let sphere = format!("{slab}\nloading = \"sphere\"\nindenter_radius_m = 0.01\ndepth_m = 1e-3");
    let shear = format!("{slab}\nloading = \"shear\"");
    for (n, (header, factor, text)) in [
        ("E(t) (Pa)", 1.0, slab),
        ("relaxation_modulus_pa", 1.0, slab),
        // E = 3 G of what does not change its volume.
        ("G(t) (Pa)", 1.0 / 3.0, slab),
        ("E(t) (Pa)", 1.0, &sphere),
        ("G(t) (Pa)", 1.0 / 3.0, &shear),
    ]
    .into_iter()
    .enumerate()
    {
        table(&folder, &format!("time_s\t{header}"), rows(factor));
        let text = format!("{text}\nagainst = \"record.tsv\"");
        let report = run(&folder, &n.to_string(), &text);
        // Sampling, and the 64 steps of the ramp.
        let most = number(&report, "against_error");
        assert!(most < 3e-4, "{header} of {text}: {most:e}");
        let from_s = number(&report, "against_error_from_s");
        assert!((1.001..1.13).contains(&from_s), "{from_s}");
    }
}

#[test]
fn a_compliance_is_pushed_as_the_run_is() {
    let folder = Folder::empty();
    // J(t) = t^α/(η·Γ(1 + α)), and a specimen with another strain in per cent.
    let compliance = |time: f64| time.powf(ORDER) / (VISCOSITY * tgamma(1.0 + ORDER));
    let times = || (0..=80).map(|n| 1e-2 * 10_f64.powf(f64::from(n) / 20.0));
    let text = "[creep]\ntissue = \"prostate-healthy\"\nstress_pa = 80\nduration_s = 20\nagainst = \"record.tsv\"";
    let rows = times().map(|time| vec![time, compliance(time)]);
    table(&folder, "time_s\tcreep_compliance_per_pa", rows);
    let report = run(&folder, "compliance", text);
    // Sampling, which delays the first samples by half a tick: from 1 s on it is below the closed form's own 1.4e-4.
    assert!(
        number(&report, "against_largest_error") < 1.4e-4,
        "{report:#}"
    );
    let rows = times().map(|time| vec![time, 2.0 * 100.0 * 80.0 * compliance(time)]);
    table(&folder, "time_s\tstrain (%)", rows);
    let report = run(&folder, "strain", text);
    let off = number(&report, "against_largest_error") - 0.5;
    assert!(off.abs() < 1e-4, "{off:e}");
    let sphere = format!(
        "{}\nloading = \"sphere\"\nindenter_radius_m = 0.01\nforce_n = 0.05",
        text.replace("stress_pa = 80\n", "")
    );
    let rows = times().map(|time| vec![time, compliance(time)]);
    table(&folder, "time_s\tcreep_compliance_per_pa", rows);
    let report = run(&folder, "sphere", &sphere);
    assert!(
        number(&report, "against_largest_error") < 1.4e-4,
        "{report:#}"
    );
}

#[test]
fn a_record_that_cannot_be_compared_is_refused_in_a_line() {
    let folder = Folder::empty();
    let relax = "[relax]\nduration_s = 2\nagainst = \"record.tsv\"";
    let forces = |times: &'static [f64]| times.iter().map(|time| vec![*time, 1.0 - 0.1 * time]);
    for (header, times, text, wanted) in [
        (
            "time_s\tforce_n",
            &[0.0, 0.5, 0.9][..],
            relax,
            "from 0 s to 0.9 s after the start of the run, which holds from 1 s to 2 s",
        ),
        (
            "time_s\tforce_n",
            &[5.0, 6.0, 7.0],
            relax,
            "from 5 s to 7 s",
        ),
        (
            "time_s\tforce_n",
            &[0.0, 2.0, 1.0],
            relax,
            "line 4: time 1 s comes after 2 s: sort the rows",
        ),
        (
            "time_s\tstrain",
            &[0.0, 1.0, 2.0],
            relax,
            "force_n or stress_pa or relaxation_modulus_pa",
        ),
        (
            "force_n\tstrain",
            &[0.0, 1.0, 2.0],
            relax,
            "no column of time",
        ),
        (
            "time_s\tstress_pa",
            &[0.0, 1.0, 2.0],
            "[relax]\nloading = \"punch\"\nindenter_radius_m = 5e-3\ndepth_m = 1e-3\nagainst = \"record.tsv\"",
            "(punch) is compared with force_n or relaxation_modulus_pa",
        ),
        (
            "time_s\tforce_n",
            &[0.0, 1.0, 2.0],
            "[creep]\nagainst = \"record.tsv\"",
            "strain or position_m or creep_compliance_per_pa",
        ),
        ("time_s\tforce (parsec)", &[0.0, 1.0, 2.0], relax, "parsec"),
        (
            "time_s\tmodulus (parsec)",
            &[0.0, 1.0, 2.0],
            relax,
            "rename or remove",
        ),
    ] {
        table(&folder, header, forces(times));
        let error = refused(&folder, text);
        assert_says(&error, "record.tsv:  & :");
        assert!(
            wanted.split('|').any(|words| error.contains(words)),
            "{wanted}: {error}"
        );
    }
    for bytes in [
        &b""[..],
        b"only words\nin some lines\n",
        &[0, 159, 146, 150],
        b"time_s\n1\n2\n",
    ] {
        std::fs::write(folder.join("record.tsv"), bytes).expect("writes");
        let error = refused(&folder, relax);
        assert_says(&error, "record.tsv: ");
    }
    for (name, wanted) in [
        ("nowhere.csv", "cannot be read"),
        (".", "not a regular file"),
        ("own.mcap", "own.mcap: "),
    ] {
        let error = refused(&folder, &format!("[relax]\nagainst = \"{name}\""));
        assert_says(&error, wanted);
    }
    // A wall has no tissue that somebody could have measured.
    let error = refused(&folder, "[wall]\nagainst = \"record.tsv\"");
    assert_says(&error, "unknown key `against`");
}
