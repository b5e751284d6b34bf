//! A controller file holds the indenter: `[drive]`.

use crate::process::{Place, number, says};
use std::path::{Path, PathBuf};

fn example(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    folder.join(name)
}

/// So many samples of it: the hold of 2 s.
fn short() -> String {
    format!(
        "relax --duration 3s --controller {}",
        example("indenter.toml").display()
    )
}

#[test]
fn the_worked_example_holds_its_indenter_and_says_how_well() {
    let place = Place::new();
    let file = example("relax-driven.toml");
    let run = format!("run {} --out driven --json", file.display());
    let report = place.run(&run).succeeded().json();
    let drive = &report["drive"];
    assert!(
        drive["controller"]
            .as_str()
            .is_some_and(|name| name.ends_with("indenter.toml"))
    );
    assert_eq!(drive["quantity"], "position");
    // 1 mm in 1 s.
    assert!(number(drive, "tracking_error_max") < 1e-4, "{drive}");
    assert!(number(drive, "tracking_error_final") < 2e-6, "{drive}");
    assert!(number(drive, "drive_force_peak_n") > number(&report, "peak_force_n"));
    assert_eq!(number(drive, "saturated_samples"), 0.0);
    let loops = &drive["preflight"];
    for name in ["free", "in_contact"] {
        assert_eq!(loops[name]["stable"], true, "{name}");
        assert!(number(&loops[name], "gain_margin") > 2.0, "{name}");
    }
    // The tissue is that of the motion really made.
    assert!(number(&report, "max_relative_error") < 1e-5);
    let picture = place.text("driven/relax.svg");
    says(
        &picture,
        &[
            "(d) set point less measurement",
            "(e) force of the drive",
            "tracking error / µm",
        ],
    );
    let table = place.text("driven/relax.csv");
    let names = table.lines().next().expect("names");
    assert!(
        names.ends_with("indenter_position_m,drive_force_n"),
        "{names}"
    );
    let info = place.run("log info driven/relax.mcap").succeeded().stdout;
    assert!(info.contains("indenter.toml"), "{info}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_drive_of_the_command_line_is_that_of_a_file_and_is_printed() {
    let place = Place::new();
    let printed = place.run(&short()).succeeded().stdout;
    says(
        &printed,
        &[
            "drive  ",
            "indenter.toml: position off by",
            "N at most of 10 N",
            "drive pre-flight  in contact stable",
        ],
    );
    let file = example("relax-driven.toml");
    let text = std::fs::read_to_string(file).expect("the example");
    place.write(
        "own.toml",
        text.replace("duration_s = 20.0", "duration_s = 3.0"),
    );
    place.write(
        "indenter.toml",
        std::fs::read(example("indenter.toml")).expect("the example"),
    );
    let from_file = place.run("run own.toml --json").succeeded().json();
    let limited = place.run("run own.toml drive_force_limit=50mN --json");
    let limited = limited.succeeded_with_warnings();
    assert!(
        limited.stderr.contains("`drive_force_limit_n`"),
        "{limited}"
    );
    let limited = limited.json();
    let from_options = place.run(&format!("{} --json", short())).succeeded().json();
    for key in [
        "tracking_error_max",
        "tracking_error_rms",
        "drive_force_peak_n",
    ] {
        let (one, other) = (
            number(&from_file["drive"], key),
            number(&from_options["drive"], key),
        );
        assert_eq!(one, other, "{key}");
    }
    let drive = &limited["drive"];
    assert_eq!(number(drive, "drive_force_peak_n"), 0.05);
    assert!(number(drive, "saturated_samples") > 100.0);
    assert!(
        number(drive, "tracking_error_final") > number(&from_file["drive"], "tracking_error_final")
    );
}

#[test]
fn what_a_drive_cannot_do_is_refused_in_one_line() {
    let place = Place::new();
    let unstable = "[pid]\nproportional_gain = 2e5\n[loop]\nsample_time_s = 1e-3\n";
    place.write("unstable.toml", unstable);
    place.write(
        "indenter.toml",
        std::fs::read(example("indenter.toml")).expect("the example"),
    );
    place.write("slow.toml", unstable.replace("1e-3", "2e-3"));
    place.write("wall.toml", "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 2e-3\norder = 0.5\n\
                              stiffness_n_per_m = 3000\ndissipation_n_s_mu_per_m = 60\n[drive]\ncontroller = \"unstable.toml\"\n");
    place.write("empty.toml", "[relax]\n[drive]\n");
    place.refuses(
        "
        relax --controller unstable.toml => would be unstable before it touches the tissue; with  | --controller
        creep --controller indenter.toml => in contact with the tissue; with  | of its gain it is stable
        relax --controller slow.toml => made for a sample time of 0.002 s | --sample-time
        relax --controller unstable.toml --contact rigid => a rigid contact has none | --contact
        relax --controller missing.toml => missing.toml | cannot read the controller file
        relax drive_force_limit=1N => missing key `controller` in [drive]
        relax --controller unstable.toml drive_force_limit=0N => drive_force_limit_n = 0 is not above 0 and at most 1e6
        relax --force-unstable => --force-unstable is for | --controller
        run wall.toml => wall.toml:8 | [drive] holds the indenter of [relax] or [creep]
        run empty.toml => empty.toml:2 | missing key `controller` in [drive]
        ",
    );
    assert!(!place.files().iter().any(|file| file.ends_with(".mcap")));
    let forced = place.run("relax --duration 2s --controller unstable.toml --force-unstable");
    let forced = forced.succeeded_with_warnings();
    assert!(
        forced.stderr.contains("the loop of the drive is unstable"),
        "{forced}"
    );
}
