//! A controller file holds the indenter: `[drive]`.

use crate::process::{Place, number, says};
use std::path::{Path, PathBuf};

fn example(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    folder.join(name)
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
fn an_unstable_drive_is_refused_unless_it_is_forced() {
    let place = Place::new();
    place.write(
        "unstable.toml",
        "[pid]\nproportional_gain = 2e5\n[loop]\nsample_time_s = 1e-3\n",
    );
    place.write("empty.toml", "[relax]\n[drive]\n");
    place.refuses(
        "
        relax --controller unstable.toml => would be unstable before it touches the tissue; with  | --controller
        relax --force-unstable => --force-unstable is for | --controller
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
