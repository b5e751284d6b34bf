//! Records that others published, in `shared/data/public` beside the repository; its README names the sources.

use crate::process::Place;
use fractional_control::FractionalTransferFunction;
use std::path::{Path, PathBuf};

/// The folder; without it the test is skipped, as said.
fn public() -> Option<PathBuf> {
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let found = above
        .map(|folder| folder.join("shared/data/public"))
        .find(|folder| folder.is_dir());
    if found.is_none() {
        testkit::skip("shared/data/public is not beside the repository");
    }
    found
}

/// File, options, kind, samples, and the rms of the logarithms (of a motion: of the strain's unit) that must be reached, 1 % above
/// what was found on 2026-11-26.
const TISSUES: &str = "
    laponite-relaxation-600.csv | - | relaxation | 26 | 0.0237
    laponite-relaxation-1200.csv | - | relaxation | 33 | 0.0229
    polyisoprene-13k-sweep.csv | - | oscillation | 65 | 0.2512
    polypropylene-relaxation.csv | - | relaxation | 76 | 0.00258
    polystyrene-relaxation-145C.csv | - | relaxation | 1799 | 0.0194
    polystyrene-sweep-160C.csv | - | oscillation | 32 | 0.0771
    polystyrene-creep-160C.csv | --model fractional-maxwell | creep | 3599 | 0.0104
    rheos-sweep.csv | --columns omega=1,storage=2,loss=3 | oscillation | 9 | 0.108
    rheos-ramp-hold.csv | --columns time=1,strain=2,stress=3 | record | 101 | 0.015
    pyvisco-relaxations-at-temperatures.csv | --segment 1 | relaxation | 10 | 0.00486
    pyvisco-sweeps-at-temperatures.csv | --segment 2 | oscillation | 10 | 0.0481
    ta-ares-sweeps-at-temperatures.txt | --segment 1 | oscillation | 17 | 0.00527
";

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn public_records_of_tissue_are_what_their_publishers_say() {
    let Some(folder) = public() else { return };
    let place = Place::new();
    for [file, options, kind, samples, rms] in testkit::table(TISSUES) {
        let path = folder.join(&file);
        let options = if options == "-" { "" } else { &options };
        let run = place.run(&format!("identify {} {options} --json", path.display()));
        assert_eq!(run.code, Some(0), "{file}: {}", run.stderr);
        let found = run.json();
        assert_eq!(found["kind"], *kind, "{file}");
        assert_eq!(found["samples"].to_string(), samples, "{file}");
        let have = ["rms_log_residual", "rms_residual_pa"];
        let have = have.iter().find_map(|name| found[*name].as_f64());
        let have = have.expect("a residual");
        assert!(have <= rms.parse().expect("a number"), "{file}: {have}");
        for (name, parameter) in found["parameters"].as_object().expect("parameters") {
            let value = parameter["value"].as_f64().expect("a number");
            assert!(value.is_finite() && value >= 0.0, "{file} {name}: {value}");
        }
    }
}

/// Functions of control records with right values: folder and file, bounds of the gain at rest, of the dead time, and of the times of all lags and the
/// dead time together, s.
const PLANTS: &str = "
    public/gas-furnace.csv | -3.4 -3.1 | 0 45 | 20 45
    public/hair-dryer.csv | 0.85 0.97 | 0.1599 0.24 | 0.4 0.8
    public/heater-apm.csv | 0.15 0.4 | 0 30 | 100 400
    cases/control/drift-0.csv | -4.3 -2.3 | 19 29 | 35 55
    cases/control/drift-1.csv | -4.3 -2.3 | 19 29 | 35 55
    cases/control/drift-2.csv | -4.3 -2.3 | 19 29 | 35 55
    cases/control/drift-3.csv | -4.3 -2.3 | 19 29 | 35 55
    cases/control/slow-noise-one-step.csv | 2.55 2.8 | 0 0.1 | 1.05 1.25
    cases/control/tclab_model.csv | 0.62 0.66 | 0 26 | 160 190
    cases/control/unstable-pole.csv | 0.554 0.556 | 1.9 1.92 | 3.08 3.1
";

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn plants_of_public_records_rest_at_their_gains() {
    let Some(folder) = public() else { return };
    let place = Place::new();
    for [file, gains, delays, all] in testkit::table(PLANTS) {
        let path = folder.parent().expect("a folder").join(&file);
        let run = place.run(&format!("control identify {} --json", path.display()));
        assert_eq!(run.code, Some(0), "{file}: {}", run.stderr);
        let found = run.json();
        let function = found["function"].as_str().expect("a function");
        let function: FractionalTransferFunction = function.parse().expect("a function");
        let at = |side: &fractional_control::FractionalPolynomial, order: f64| {
            let mut terms = side.terms().iter();
            let same_order = terms.find(|term| (term.order - order).abs() < 1e-9);
            same_order.map_or(0.0, |term| term.coefficient)
        };
        let (above, below) = (function.numerator(), function.denominator());
        let rest = at(above, 0.0) / at(below, 0.0);
        let late = found["delay_s"].as_f64().expect("a dead time");
        let lags = at(below, 1.0) / at(below, 0.0) - at(above, 1.0) / at(above, 0.0);
        for (bounds, value) in [(gains, rest), (delays, late), (all, late + lags)] {
            let bounds = bounds
                .split(' ')
                .map(|bound| bound.parse().expect("a number"));
            let bounds: Vec<f64> = bounds.collect();
            assert!(
                (bounds[0]..=bounds[1]).contains(&value),
                "{file}: {value}, {found}"
            );
        }
        assert_eq!(found["unstable_poles"], 0, "{file}: {found}");
    }
}
