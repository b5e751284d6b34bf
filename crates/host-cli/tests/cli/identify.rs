//! `identify`: from a record to a tissue that other commands take.

use crate::process::{Place, keys, says};
use serde_json::Value;

const FISH: &str = include_str!("../../../haptic-tissue/records/fish-muscle-relaxation.tsv");
const SWEEP: &str = include_str!("../../../haptic-tissue/tests/golden/identify/chia.csv");

fn place() -> Place {
    let place = Place::new();
    place.write("fish.tsv", FISH);
    place.write("sweep.csv", SWEEP);
    place
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn json_has_the_contracts_keys() {
    let place = place();
    let ended = place.run("identify fish.tsv --model fractional-maxwell --out muscle.toml --json");
    let report = ended.succeeded_with_warnings().json();
    assert_eq!(
        keys(&report),
        "aic bic candidates correlation figure kind model notes parameters rms_log_residual samples \
         tissue warnings"
    );
    assert_eq!(
        (&report["kind"], &report["samples"]),
        (&"relaxation".into(), &566.into())
    );
    assert_eq!(report["tissue"], "muscle.toml");
    assert!(
        report["figure"]
            .as_str()
            .expect("a path")
            .starts_with("muscle.")
    );
    let viscosity = &report["parameters"]["viscosity_pa_s_alpha"];
    assert_eq!(keys(viscosity), "high_95 low_95 standard_error unit value");
    assert!((number(&viscosity["value"]) / 876e3 - 1.0).abs() < 0.05);
    assert!(number(&viscosity["low_95"]) < number(&viscosity["high_95"]));
    assert!(number(&report["rms_log_residual"]) <= 0.0046);
    let candidates = report["candidates"].as_array().expect("a list");
    // The model itself first, then those with fewer parameters.
    assert_eq!(candidates.len(), 2);
    assert_eq!(candidates[0]["model"], "fractional-maxwell");
    assert_eq!(
        keys(&candidates[1]),
        "aic bic model parameters rms_log_residual"
    );
    let correlation = report["correlation"].as_array().expect("a matrix");
    assert_eq!(
        (
            correlation.len(),
            correlation[0].as_array().expect("a row").len()
        ),
        (4, 4)
    );
    let said = report["warnings"].to_string();
    assert!(said.contains("kind relaxation, by the columns"), "{said}");
}

#[test]
fn the_tissue_file_reads_back_with_its_source() {
    let place = place();
    let line = "identify fish.tsv --model fractional-maxwell --out muscle.toml --conditions cod";
    place.run(line).succeeded_with_warnings();
    let shown = place.json("materials show muscle.toml");
    assert_eq!(shown["name"], "muscle");
    assert_eq!(
        (&shown["source"]["conditions"], &shown["source"]["checked"]),
        (&"cod".into(), &false.into())
    );
    let text = place.text("muscle.toml");
    says(
        &text,
        &[
            "model = \"fractional-maxwell\"",
            "fish.tsv",
            "566 samples",
            "rms",
            "date = \"20",
            "time_to_s = 981",
        ],
    );
    assert_eq!(
        place.listing(),
        "fish.tsv muscle.png muscle.svg muscle.toml sweep.csv"
    );
    // Nothing is overwritten unasked, and that is said before the work is done.
    place.run(line).refused(2, &["muscle.toml"]);
    place
        .run(&format!("{line} --overwrite"))
        .succeeded_with_warnings();
}

/// The record of our own run: the tissue that was rendered comes out.
#[test]
fn a_log_of_a_run_gives_back_its_tissue() {
    let place = Place::new();
    place
        .run("relax --duration 20s --contact rigid --out run")
        .succeeded();
    let line = "identify run/relax.mcap --area 4cm2 --thickness 20mm --model spring-pot --json";
    let report = place.run(line).succeeded_with_warnings().json();
    assert_eq!(report["kind"], "record");
    let value = |name: &str| number(&report["parameters"][name]["value"]);
    let (viscosity, order) = (value("viscosity_pa_s_alpha"), value("order"));
    assert!(
        (viscosity / 8650.0 - 1.0).abs() < 1e-3 && (order - 0.2247).abs() < 1e-3,
        "{viscosity} {order}"
    );
    assert!(report["rms_log_residual"].is_null() && report["rms_residual_pa"].is_number());
    // The same from the CSV of the run, by the names of its columns.
    let line = "identify run/relax.csv --area 4cm2 --thickness 20mm --model spring-pot --json";
    let again = place.run(line).succeeded_with_warnings().json();
    assert!((number(&again["parameters"]["order"]["value"]) - order).abs() < 1e-3);
}

#[test]
fn parameters_are_a_table_with_intervals() {
    let ended = place()
        .run("identify sweep.csv --bootstrap 40")
        .succeeded_with_warnings();
    says(
        &ended.stdout,
        &["oscillation", "spring-pot", "second_order", "low 95"],
    );
}

#[test]
fn bad_input_is_refused_in_one_line_with_the_option_that_mends_it() {
    let place = place();
    place.write(
        "zero.csv",
        "time_s,relaxation_modulus_pa\n0,4\n2,3\n4,2.5\n8,2.1\n",
    );
    place.write(
        "word.csv",
        "time_s,relaxation_modulus_pa\n1,4\n2,three\n4,2.5\n",
    );
    place.write("force.csv", "Time (s),Load (N)\n1,4\n2,3\n4,2.5\n");
    place.write("run.mcap.part", "x");
    place.refuses(
        "
        identify run.mcap.part => run.mcap.part | log recover
        identify fish.tsv --seed 3 => --bootstrap
        identify word.csv => word.csv: line 3, column relaxation_modulus_pa | three
        identify force.csv => force.csv | give --strain
        identify fish.tsv --out Fish.toml => Fish.toml | lower-case | --out
        identify run.mcap => --area | --thickness
        ",
    );
    assert_eq!(place.files().len(), 6, "nothing was written");
    // Rows that may be left out are counted and named.
    let ended = place
        .run("identify zero.csv --from 1s --model spring-pot")
        .succeeded_with_warnings();
    assert!(
        ended
            .stdout
            .contains("1 row left out, outside the range asked for: line 2"),
        "{}",
        ended.stdout
    );
}
