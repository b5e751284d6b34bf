//! Answers to a question of each kind, as JSON to the last digit, from tables that are made here: the storey that touches nothing, run.
//!
//! ```text
//! cargo run -p haptic-question --example answers
//! ```
//! `.ci/run` holds what it prints here against what it prints as WebAssembly in Node.

use haptic_document::{Document, Failure};
use haptic_judge::pushed_trial::PushedTrial as _;
use haptic_judge::setup::Beside;
use haptic_judge::wall::wall;
use haptic_measurement::drive::on_simulated;
use haptic_measurement::estimate::estimate;
use haptic_measurement::{MEASUREMENT, MeasurePlan, TABLES};
use haptic_question::analysis::{Analysis, tables};
use haptic_question::bench::BENCH;
use haptic_question::control_loop::{ControlLoop, FormParts, LoopForm};
use haptic_question::controller::DesignForm;
use haptic_question::controller::report::designed;
use haptic_question::design::{DESIGN, DesignWish, reading};
use haptic_question::plant::PlantQuestion;
use haptic_question::plant::keys::PlantForm;
use haptic_question::tissue::{RecordForm, RecordQuestion};
use haptic_question::zwidth::{ZWIDTH, ZWidth};
use haptic_trial::device_table::{device, with_devices};
use haptic_trial::keys::wall::WALL_TABLES;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn form<T: DeserializeOwned>(keys: Value) -> T {
    serde_json::from_value(keys).expect("a form")
}

/// A number from −1 to 1 for each number.
fn noise(number: u32) -> f64 {
    let mixed = number.wrapping_mul(2_654_435_761).rotate_left(13);
    f64::from(mixed.wrapping_mul(2_246_822_519)) / f64::from(u32::MAX) * 2.0 - 1.0
}

/// Relaxation of a standard linear solid, 1 kPa and 2 kPa with 3 s, with half a percent of noise.
fn relaxation() -> String {
    let row = |n: u32| {
        let time_s = 0.01 * libm::pow(10.0, f64::from(n) / 30.0);
        let modulus_pa = 1000.0 + 2000.0 * libm::exp(-time_s / 3.0);
        format!("{time_s},{}\n", modulus_pa * (1.0 + 0.005 * noise(n)))
    };
    let rows: String = (0..120).map(row).collect();
    format!("time_s,modulus_pa\n{rows}")
}

/// A lag of 2 s and gain 3 that answers a step, with its sensor's noise.
fn step() -> String {
    let row = |n: u32| {
        let time_s = 0.1 * f64::from(n);
        let since_s = (time_s - 1.0).max(0.0);
        let output = 3.0 * (1.0 - libm::exp(-since_s / 2.0)) + 0.002 * noise(n);
        format!("{time_s},{},{output}\n", u8::from(n >= 10))
    };
    let rows: String = (0..200).map(row).collect();
    format!("time_s,input,output\n{rows}")
}

/// The analysis of a document of one table.
fn analysed(text: &str) -> Result<Value, Failure> {
    let document = Document::of_text(Path::new("form"), text);
    let parsed = document.parse()?;
    let known = [
        "analyze-admittance",
        "analyze-stability",
        "analyze-transparency",
        "measure",
        "wall",
        "zwidth",
        "design",
    ];
    let (kind, table, _) = parsed.one_of(&known, &[], "question", "one table")?;
    let stop = AtomicBool::new(false);
    if kind == "wall" {
        let table = with_devices(table.with_keys(WALL_TABLES)?)?;
        return Ok(json!(
            wall(&table, Beside::default(), [None, None])?.settled()?
        ));
    }
    if kind == "zwidth" {
        let table = with_devices(table.with_keys(&[("", ZWIDTH), ("", BENCH)])?)?;
        let no_file = |path: &Path, _: &str| Err(Failure::bad_input(path.display()));
        let found = ZWidth::of(&table, None)?.searched(None, &no_file, &|_| {}, &stop)?;
        return Ok(json!(found));
    }
    if kind == "design" {
        let table = with_devices(table.with_keys(&[("", DESIGN), ("", BENCH)])?)?;
        let wish = reading::wish(&table)?;
        if wish == DesignWish::Coupler {
            return Ok(json!(reading::coupler(&table)?.answer(&stop, &|_| {})?));
        }
        let design = reading::design(&table, wish)?;
        return Ok(json!(design.answer(&stop, &|_| {})?));
    }
    if kind == MEASUREMENT {
        let table = with_devices(table.with_keys(&TABLES)?)?;
        let plan = MeasurePlan::read(&table)?;
        let (moved, sensors) = device(&table, plan.sample_time_s)?;
        let motion = on_simulated(&plan, moved, sensors, &|_| {}, &stop)?;
        return Ok(json!(estimate(&motion, false).map_err(Failure::input)?));
    }
    let table = with_devices(table.with_keys(tables(kind).unwrap_or_default())?)?;
    let unread = |path: &Path| Ok(Document::of_text(path, ""));
    let analysis = Analysis::read(kind, &table, unread).expect("an analysis")?;
    let answer = analysis.answer(&|_| {}, &stop, &|_| {})?;
    Ok(json!([answer, format!("{:?}", answer.drawn)]))
}

/// A wall of order ½ on the device of the dissertation.
const WALL: &str = "order = 0.5\nstiffness_n_per_m = 300\ndissipation_n_s_mu_per_m = 8\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
                    sample_time_s = 0.002\n";

/// A fractional body on a robot, against a soft wall.
const ROBOT: &str = "body_inertance_n_s_mu_per_m = 4\nbody_order = 0.7\nbody_damping_n_s_per_m = 0.5\nbandwidth_hz = 10\ndead_time_s = 0.004\n\
                     force_cutoff_hz = 30\nsample_time_s = 0.002\nstiffness_n_per_m = 500\n";

fn answers() -> Result<Vec<(&'static str, Value)>, Failure> {
    let stop = AtomicBool::new(false);
    let record = RecordQuestion::of(&form::<RecordForm>(json!({})))?;
    let read = record.read(0, record.reader.clone(), relaxation().as_bytes());
    let read = read.map_err(Failure::bad_input)?;
    let tissue = record.answer(read, &["made".to_owned()], &stop, &|_| {});
    let tissue = tissue.map_err(Failure::bad_input)?;
    let plant = PlantQuestion::of(&form::<PlantForm>(json!({})))?;
    let data = plant.data(&plant.columns, step().as_bytes());
    let data = data.map_err(Failure::bad_input)?;
    let plant = plant.found(data, None, &stop, &|_, _, _| {})?;
    let fractional = json!({"plant": "1/(0.8s^2.2+0.5s^0.9+1)"});
    let wishes: DesignForm = form(json!({"crossover_rad_s": 2.0}));
    let plant_of = form::<LoopForm>(fractional.clone()).plant(None)?;
    let design = designed(wishes.design(plant_of.plant)?)?;
    let alone = ControlLoop::of(form(fractional), FormParts::default())?;
    Ok(vec![
        ("tissue", json!(tissue.report(None, None))),
        ("plant", json!(plant.report())),
        ("controller", design.report("plant")),
        ("loop", json!(alone.analysed()?.report)),
        ("stable", analysed(&format!("[analyze-stability]\n{WALL}"))?),
        (
            "felt",
            analysed(&format!("[analyze-transparency]\n{WALL}"))?,
        ),
        (
            "moving",
            analysed(&format!("[analyze-admittance]\n{ROBOT}"))?,
        ),
        ("device", analysed("[measure]\nduration_s = 2\n")?),
        (
            "tried",
            analysed(&format!("[wall]\n{WALL}friction_n = 0.01\n"))?,
        ),
        (
            "stiffest",
            analysed("[zwidth]\nsample_time_s = 0.002\norders = [0.5]\npoints = 3\n")?,
        ),
        (
            "designed",
            analysed("[design]\nsample_time_s = 0.002\norders = [0.5]\n")?,
        ),
        (
            "coupled",
            analysed("[design]\nwish = \"coupler\"\nsample_time_s = 0.002\norders = [1]\n")?,
        ),
    ])
}

fn main() {
    for (asked, answer) in answers().expect("made to be answered") {
        println!("{asked} {answer}");
    }
}
