//! `identify`: from a record to a tissue that other commands take.

use crate::process::{Place, keys};
use haptic_tissue::{Model, ModelKind};
use serde_json::Value;
use testkit::{assert_close, assert_relative, assert_says};

const FISH: &str = include_str!("../../../haptic-tissue/records/fish-muscle-relaxation.tsv");
const SWEEP: &str = include_str!("../../../tissue-identification/tests/golden/identify/chia.csv");

fn place() -> Place {
    let place = Place::new();
    place.write("fish.tsv", FISH);
    place.write("sweep.csv", SWEEP);
    place
}

const SHAPE: &str = "--area 4cm2 --thickness 20mm --model spring-pot --json";

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn json_has_the_contracts_keys() {
    let place = place();
    let ended = place.run("identify fish.tsv --model fractional-maxwell --out muscle.toml --json");
    let report = ended.succeeded_with_warnings().json();
    let keys_of_all = "aic bic candidates correlation figure kind loading model notes parameters rms_log_residual \
                       samples tissue warnings";
    assert_eq!(keys(&report), keys_of_all);
    assert_eq!(
        (&report["kind"], &report["samples"]),
        (&"relaxation".into(), &566.into())
    );
    assert_eq!(report["tissue"], "muscle.toml");
    assert_says(&report["figure"].to_string(), "muscle.");
    let viscosity = &report["parameters"]["viscosity_pa_s_alpha"];
    assert_eq!(keys(viscosity), "high_95 low_95 standard_error unit value");
    assert_relative("value", number(&viscosity["value"]), 876e3, 0.05);
    assert!(number(&viscosity["low_95"]) < number(&viscosity["high_95"]));
    assert!(number(&report["rms_log_residual"]) <= 0.0046);
    let candidates = report["candidates"].as_array().expect("a list");
    // The model itself first, then those with fewer parameters.
    assert_eq!(candidates.len(), 5);
    assert_eq!(candidates[0]["model"], "fractional-maxwell");
    let of_one = keys(&candidates[1]);
    assert_eq!(of_one, "aic bic model parameters rms_log_residual");
    let correlation = report["correlation"].as_array().expect("a matrix");
    let rows = correlation
        .iter()
        .map(|row| row.as_array().map_or(0, Vec::len));
    assert_eq!(rows.collect::<Vec<_>>(), [4; 4]);
    assert_says(
        &report["warnings"].to_string(),
        "kind relaxation, by the columns",
    );
}

#[test]
fn the_tissue_file_reads_back_with_its_source() {
    let place = place();
    let line = "identify fish.tsv --model fractional-maxwell --out muscle.toml --conditions cod";
    place.run(line).succeeded_with_warnings();
    let shown = place.json("materials show muscle.toml");
    assert_eq!(shown["name"], "muscle");
    let source = &shown["source"];
    assert_eq!(
        (&source["conditions"], &source["checked"]),
        (&"cod".into(), &false.into())
    );

    assert_says(
        &place.text("muscle.toml"),
        "model = \"fractional-maxwell\" & fish.tsv & 566 samples & rms & date = \"20 & time_to_s = 981",
    );
    assert_eq!(
        place.listing(),
        "fish.tsv muscle.png muscle.svg muscle.toml sweep.csv"
    );
    // The model that was asked for is drawn alone.
    assert_eq!(place.text("muscle.svg").matches(", rms ").count(), 1);
    // Nothing is overwritten unasked, and that is said before the work is done.
    place.run(line).refused(2, &["muscle.toml"]);
    let again = place.run(&format!("{line} --overwrite"));
    again.succeeded_with_warnings();
}

/// The record of our own run: the tissue that was rendered comes out.
#[test]
fn a_log_of_a_run_gives_back_its_tissue() {
    let place = Place::new();
    let line = "relax --duration 20s --contact rigid --out run";
    place.run(line).succeeded();
    // The same from the CSV of the run, by the names of its columns.
    for record in ["run/relax.mcap", "run/relax.csv"] {
        let ended = place.run(&format!("identify {record} {SHAPE}"));
        let report = ended.succeeded_with_warnings().json();
        let value = |name: &str| number(&report["parameters"][name]["value"]);
        assert_relative(record, value("viscosity_pa_s_alpha"), 8650.0, 1e-3);
        assert_close(record, value("order"), 0.2247, 1e-3);
        assert_eq!(report["kind"], "record");
        assert!(report["rms_log_residual"].is_null() && report["rms_residual_pa"].is_number());
    }
}

/// Five seconds of a run whose samples are 5 ms apart, from few starts: every candidate has a minimum, and what was rendered is
/// chosen.
#[test]
fn the_first_seconds_of_a_run_are_identified_as_what_they_are() {
    let place = Place::new();
    let line = "relax --tissue prostate-cancerous --contact ideal --sample-time 5ms --duration 20s --out run";
    place.run(line).succeeded();
    let ended = place.run("identify run/relax.mcap --to 5s --starts 4 --json");
    let report = ended.succeeded_with_warnings().json();
    assert_eq!(report["model"], "spring-pot");
    let candidates = report["candidates"].as_array().expect("a list");
    // No sums of Maxwell elements in a log of our own.
    let known = tissue_identification::CANDIDATES.len();
    assert_eq!(candidates.len(), known - 2);
    let order = number(&report["parameters"]["order"]["value"]);
    assert_close("order", order, 0.2247, 1e-3);
}

/// A sphere that is pressed in and held, of a spring of 3 kPa: f = (16/9)·√R·E·δ^1.5.
fn indentation() -> String {
    let rows = (0..200).map(|n| {
        let (time, depth) = (0.01 * f64::from(n), 0.5 * (0.02 * f64::from(n)).min(1.0));
        let force = 16.0 / 9.0 * 5e-3_f64.sqrt() * 3e3 * (1e-3 * depth).powf(1.5);
        // A spring of 3 kPa, with a millionth of noise: a constant record is none.
        format!(
            "{time},{depth},{}\n",
            force * (1.0 + 1e-6 * f64::from(n % 3))
        )
    });
    "time_s,depth_mm,force_n\n".to_owned() + &rows.collect::<String>()
}

/// How a record was measured goes into the tissue, and a tissue of shear is pressed with three times its modulus.
#[test]
fn the_tissue_file_says_how_its_record_was_loaded() {
    let place = Place::new();
    place.write("sphere.csv", indentation());
    let line = "identify sphere.csv --loading sphere --indenter-radius 5mm --model spring-pot --out ball.toml --json";
    let ended = place.run(line);
    let report = ended.succeeded_with_warnings().json();
    let loading = &report["loading"];
    assert_eq!(keys(loading), "kind modulus poisson_ratio");
    assert_eq!(
        (&loading["kind"], &loading["modulus"]),
        (&"sphere".into(), &"young".into())
    );
    let value = number(&report["parameters"]["viscosity_pa_s_alpha"]["value"]);
    assert_relative("E", value, 3e3, 1e-4);

    assert_says(
        &place.text("ball.toml"),
        "[loading]\nkind = \"sphere\"\nmodulus = \"young\"\npoisson_ratio = 0.5 & strain_to = 0.1",
    );
    assert_says(
        &report["notes"].to_string(),
        "Poisson's ratio is taken as 0.5",
    );
    // A rheometer's record, and its force in compression.
    let rows = (1..40).map(|n| format!("{n},{}\n", 1e3 * f64::from(n).powf(-0.2)));
    place.write(
        "gel.csv",
        "t (s),G(t) (Pa)\n".to_owned() + &rows.collect::<String>(),
    );
    place
        .run("identify gel.csv --model spring-pot --out shear.toml")
        .succeeded_with_warnings();
    assert_says(&place.text("shear.toml"), "[loading]\nmodulus = \"shear\"");
    let young = place.text("shear.toml").replace("\"shear\"", "\"young\"");
    place.write("young.toml", young);
    let last_force = |tissue: &str| {
        let line =
            format!("relax --tissue {tissue}.toml --contact rigid --duration 2s --out {tissue}");
        // The record begins at 1 s: a run asks beyond it.
        place.run(&line).succeeded_with_warnings();
        let table = place.text(&format!("{tissue}/relax.csv"));
        let column = table.lines().next().and_then(|names| {
            let mut names = names.split(',');
            names.position(|name| name == "simulated_force_n")
        });
        let row = table.lines().last().expect("a row").split(',');
        let force: f64 = row
            .skip(column.expect("a column"))
            .flat_map(str::parse)
            .next()
            .expect("a force");
        force
    };
    let ratio = last_force("shear") / last_force("young");
    assert_relative("G to E", ratio, 3.0, 1e-14);
}

/// A slab of 4 cm² and 20 mm that stiffens by 8, pressed to a strain and held.
fn stiffening(strain: f64) -> String {
    let times: Vec<f64> = (0..150).map(|n| 0.02 * f64::from(n)).collect();
    let strains = times.iter().map(|t| strain * (2.0 * t).min(1.0));
    let strains: Vec<f64> = strains.collect();
    let seen: Vec<f64> = strains.iter().map(|e| (8.0 * e).exp_m1() / 8.0).collect();
    let gel = Model::from_parameters(ModelKind::SpringPot, &[3000.0, 0.2]).expect("valid");
    let rows = times.iter().zip(&strains).zip(gel.stress(&times, &seen));
    let rows = rows.map(|((t, e), stress)| format!("{t},{},{}\n", 20.0 * e, 4e-4 * stress));
    "time_s,position_mm,force_n\n".to_owned() + &rows.collect::<String>()
}

#[test]
fn several_depths_give_the_stiffening_of_a_tissue() {
    let place = Place::new();
    for strain in [3, 8, 15] {
        place.write(
            &format!("{strain}.csv"),
            stiffening(0.01 * f64::from(strain)),
        );
    }
    let slab = "--area 4cm2 --thickness 20mm --loading compression --model spring-pot";
    let line = format!("identify 3.csv 8.csv 15.csv --stiffening {slab} --out soft.toml --json");
    let report = place.run(&line).succeeded_with_warnings().json();
    let parameter = &report["parameters"]["stiffening"];
    assert_relative("b", number(&parameter["value"]), 8.0, 0.01);
    assert!(number(&parameter["low_95"]) <= number(&parameter["value"]));
    assert_eq!(report["samples"], 450);

    assert_says(
        &place.text("soft.toml"),
        "stiffening =  & 3.csv, 8.csv, 15.csv & strain_to = 0.15",
    );
    place.run("materials show soft.toml").succeeded();
    place.write(
        "gel.csv",
        "time_s,relaxation_modulus_pa\n1,5\n2,4\n4,3.5\n8,3\n",
    );
    place.refuses(
        "
        identify gel.csv --stiffening => --kind record | --stiffening
        identify 3.csv --stiffening --bootstrap 50 --area 4cm2 --thickness 20mm => --bootstrap
        ",
    );
}

#[test]
fn the_log_of_a_run_says_how_its_tissue_was_pressed() {
    let place = Place::new();
    let line = "relax --loading sphere --indenter-radius 5mm --duration 2s --out run depth=0.5mm tissue=prostate-healthy";
    place.run(line).succeeded();
    let line = "identify run/relax.mcap --model spring-pot --json";
    let report = place.run(line).succeeded_with_warnings().json();
    assert_eq!(report["loading"]["kind"], "sphere");
    let order = number(&report["parameters"]["order"]["value"]);
    assert_relative("order", order, 0.2154, 0.01);
    let modulus = number(&report["parameters"]["viscosity_pa_s_alpha"]["value"]);
    assert_relative("modulus", modulus, 3610.0, 0.01);
    // What options say wins.
    let line =
        "identify run/relax.mcap --model spring-pot --json --loading sphere --indenter-radius 20mm";
    let twice = place.run(line).succeeded_with_warnings().json();
    // γ grows with √R.
    let other = number(&twice["parameters"]["viscosity_pa_s_alpha"]["value"]);
    assert_close("2.0 * other / modulus", 2.0 * other / modulus, 1.0, 0.01);
}

#[test]
fn a_file_of_several_segments_is_listed_and_one_is_chosen() {
    let place = Place::new();
    let sweep = |celsius: f64, viscosity: f64| {
        let rows = (0..12).map(|n| {
            let omega = 0.1 * 10_f64.powf(0.25 * f64::from(n));
            let modulus = viscosity * omega.powf(0.25);
            let (sin, cos) = (std::f64::consts::PI / 8.0).sin_cos();
            format!("{omega};{};{};{celsius}\n", modulus * cos, modulus * sin)
        });
        rows.collect::<String>().replace('.', ",")
    };
    let header = "Rheometer 3;;;\n\nAngular frequency (rad/s);G' (Pa);G'' (Pa);Temperature (°C)\n";
    place.write(
        "sets.csv",
        header.to_owned() + &sweep(25.0, 5000.0) + &sweep(40.0, 2000.0),
    );
    let listed = place.json("identify sets.csv --segments");
    let segments = listed["segments"].as_array().expect("a list");
    assert_eq!(
        keys(&segments[1]),
        "clock columns lines name rows segment temperature_c"
    );
    assert_eq!(
        (&segments[1]["name"], &segments[1]["rows"]),
        (&"40.0 °C".into(), &12.into())
    );
    let viscosity = |segment: &str| {
        let line = format!("identify sets.csv --model spring-pot --json --segment {segment}");
        let report = place.run(&line).succeeded_with_warnings().json();
        number(&report["parameters"]["viscosity_pa_s_alpha"]["value"])
    };
    assert_relative("25 °C", viscosity("1"), 5000.0, 1e-6);
    assert_relative("40 °C", viscosity("40.0"), 2000.0, 1e-6);
    place.refuses(
        "
        identify sets.csv => 2 segments | 25.0 °C | --segment | --segments
        identify sets.csv --segment 3 => --segment | from 1 to 2
        identify sets.csv --segments --segment 1 => --segment
        ",
    );
}

#[test]
fn parameters_are_a_table_with_intervals() {
    let ended = place().run("identify sweep.csv --model fractional-kelvin-voigt --bootstrap 40");

    assert_says(
        &ended.succeeded_with_warnings().stdout,
        "oscillation & spring-pot & second_order & low 95",
    );
}

#[test]
fn bad_input_is_refused_in_one_line_with_the_option_that_mends_it() {
    let place = place();
    let header = "time_s,relaxation_modulus_pa";
    place.write(
        "zero.csv",
        format!("{header}\n0,4\n2,3\n4,2.5\n8,2.1\n16,1.8\n32,1.5\n"),
    );
    place.write("word.csv", format!("{header}\n1,4\n2,three\n4,2.5\n"));
    place.write("force.csv", "Time (s),Load (N)\n1,4\n2,3\n4,2.5\n");
    place.write("run.mcap.part", "x");
    place.refuses(
        "
        identify run.mcap.part => run.mcap.part | log recover
        identify fish.tsv --seed 3 => --bootstrap
        identify word.csv => word.csv: line 3, column relaxation_modulus_pa | three
        identify force.csv => force.csv | give --strain
        identify fish.tsv --out Fish.toml => Fish.toml | lower-case | --out
        identify run.mcap => run.mcap | No such file
        identify force.csv --loading sphere --strain 5% => --loading sphere | force_n and position_m
        identify fish.tsv --indenter-radius 5mm => --indenter-radius | --loading
        identify fish.tsv --poisson-ratio 0.6 => --poisson-ratio | from 0 to 0.5
        identify fish.tsv --loading cone --half-angle 70rad => --half-angle | 89.95 degrees
        relax --loading cone half_angle_rad=70 => half_angle_rad | 89.95 degrees
        ",
    );
    assert_eq!(place.files().len(), 6, "nothing was written");
    // Rows that may be left out are counted and named.
    let ended = place.run("identify zero.csv --from 1s --model spring-pot");
    let warning = "1 row (line 2) left out, outside the range asked for";
    assert_says(&ended.succeeded_with_warnings().stdout, warning);
}

#[test]
fn a_table_is_explained_whether_or_not_it_is_a_record() {
    let place = place();
    place.write("gel.csv", "t (min),G (kPa)\n0.1,1.2\n1,0.8\n10,0.5\n");
    let report = place.json("identify gel.csv --explain");
    assert_eq!(report["columns"][0]["first_value"], 6.0);
    assert_eq!(report["records"][0]["kind"], "relaxation");
    place.write("plain.csv", "a,b\n1,2\n3,4\n");
    let report = place.json("identify plain.csv --explain");
    assert_eq!(report["records"], serde_json::Value::Null);
    let reason = report["records_reason"].as_str().unwrap_or_default();
    assert!(
        reason.contains("give `columns`") || reason.contains("give --columns"),
        "{report}"
    );
    let log = place
        .run("identify gel.csv --explain --out gel.toml")
        .failed(2);
    assert_says(&log.stderr, "cannot be used with");
}
