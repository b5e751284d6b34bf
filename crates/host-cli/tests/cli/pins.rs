//! Pins: commands of all kinds whose positions, forces and verdicts stay the same bits while the house is rebuilt.
//!
//! ```text
//! $ LINE               of host-cli, which writes into the folder `run`
//! | a line of the file that LINE ends with
//! NAME VALUE           pinned: a verdict or result of the JSON, or length and CRC-64 of a list or of a column of the log
//! ```
//! A pin that has to change is made anew with `UPDATE_PINS=1`, and CHANGELOG says by how much and why. Text is not pinned.

use super::process::{Place, column};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;

const PINS: &str = include_str!("pins.txt");

/// Keys of results that somebody acts on, wherever they stand in the JSON.
const RESULTS: &[&str] = &[
    "absolutely_stable",
    "area",
    "beta_max",
    "branch_moduli_pa",
    "branch_times_s",
    "coupler_damping_n_s_per_m",
    "coupler_spring_n_s_1_minus_mu_per_m",
    "crossover_rad_s",
    "damping_n_s_per_m",
    "delay_margin_samples",
    "derivative_gain_s_mu",
    "dissipation",
    "dissipation_n_s_mu_per_m",
    "function",
    "gain_margin",
    "gain_up",
    "given_j",
    "integral_gain_per_s_lambda",
    "largest_delay_s",
    "largest_hand_stiffness_n_per_m",
    "largest_spring_n_per_m",
    "least_body_factor",
    "magnitude_db",
    "margin",
    "order",
    "output",
    "parameters",
    "passive",
    "peak_sensitivity_db",
    "phase_margin_deg",
    "proportional_gain",
    "re",
    "required_damping",
    "required_delta",
    "robust",
    "stable",
    "stiffness_n_per_m",
    "stiffness_max",
    "value",
    "verdict",
    "weights",
];

fn crc(text: &str) -> String {
    let crc = crc::Crc::<u64>::new(&crc::CRC_64_XZ);
    format!("{:016x}", crc.checksum(text.as_bytes()))
}

/// All values of a key in the order of the keys around them; a list of them as its length and CRC.
fn results(value: &Value, found: &mut BTreeMap<&'static str, Vec<String>>) {
    match value {
        Value::Object(members) => {
            for (key, member) in members {
                match RESULTS.iter().find(|result| *result == key) {
                    Some(result) if !member.is_null() => {
                        found.entry(result).or_default().push(member.to_string());
                    }
                    _ => results(member, found),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| results(item, found)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Positions and forces of a log.
fn columns(place: &Place, log: &str, held: &mut String) {
    let ended = place.run(&format!("log export {log} -"));
    assert!(matches!(ended.code, Some(0 | 4)), "{ended}");
    let mut lines = ended.stdout.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    for (column, name) in names.iter().enumerate() {
        let about = ["position_", "commanded_force_", "applied_force_"];
        if about.iter().any(|about| name.starts_with(about)) {
            let cells: Vec<&str> = rows.iter().map(|row| row[column]).collect();
            let file = log.rsplit_once('/').map_or(log, |(_, file)| file);
            writeln!(
                held,
                "{file}:{name} {} {}",
                cells.len(),
                crc(&cells.join(","))
            )
            .expect("text");
        }
    }
}

/// What is held of a command.
fn held(line: &str, document: &str) -> String {
    let place = Place::with_examples();
    if !document.is_empty() {
        let name = line.rsplit(' ').next().expect("a file");
        place.write(name, document);
    }
    let before = place.files();
    let ended = place.run(&format!("{line} --json"));
    // Shown where a pin has changed.
    println!("{ended}");
    let mut held = format!("code {}\n", ended.code.expect("ends by itself"));
    if let Ok(mut json) = serde_json::from_str::<Value>(&ended.stdout) {
        // By name, whatever the order of a report.
        json.sort_all_objects();
        let mut found = BTreeMap::new();
        results(&json, &mut found);
        for (key, values) in found {
            let list = values.join(",");
            if list.len() <= 60 {
                writeln!(held, "{key} {list}")
            } else {
                writeln!(held, "{key} {} {}", values.len(), crc(&list))
            }
            .expect("text");
        }
    }
    for file in place.files() {
        if file.ends_with(".mcap") && !before.contains(&file) {
            columns(&place, &file, &mut held);
        }
    }
    held
}

#[test]
fn forces_positions_and_verdicts_are_the_same_bits() {
    let mut written = String::new();
    let mut pins = Vec::new();
    for block in PINS.split("\n$ ").map(str::trim) {
        let mut lines = block.lines();
        let Some(line) = lines.next().map(|line| line.trim_start_matches("$ ")) else {
            continue;
        };
        let (document, was): (Vec<&str>, Vec<&str>) = lines.partition(|line| line.starts_with('|'));
        let document: String = document
            .iter()
            .map(|line| format!("{}\n", line[1..].trim()))
            .collect();
        pins.push((line, document, was.join("\n").trim().to_owned()));
    }
    assert!(pins.len() >= 40, "{} pins", pins.len());
    let now: Vec<String> = std::thread::scope(|scope| {
        let half = pins.len().div_ceil(2);
        let threads: Vec<_> = pins
            .chunks(half)
            .map(|pins| {
                scope.spawn(|| {
                    pins.iter()
                        .map(|(line, document, _)| held(line, document))
                        .collect::<Vec<_>>()
                })
            })
            .collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().expect("ends"))
            .collect()
    });
    let mut changed = Vec::new();
    for ((line, document, was), now) in pins.iter().zip(&now) {
        writeln!(written, "$ {line}").expect("text");
        for row in document.lines() {
            writeln!(written, "| {row}").expect("text");
        }
        writeln!(written, "{now}").expect("text");
        if was != now.trim() {
            changed.push(format!("{line}\n  was\n{was}\n  is\n{now}"));
        }
    }
    if std::env::var_os("UPDATE_PINS").is_some() {
        let other = std::env::var_os("PLATFORM_CLI");
        assert_eq!(other, None, "pins are made on this platform");
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/pins.txt");
        std::fs::write(file, format!("{}\n", written.trim())).expect("writes");
        return;
    }
    for key in RESULTS {
        assert!(written.contains(&format!("\n{key} ")), "{key} is in no pin");
    }
    assert!(
        changed.is_empty(),
        "{} pins have changed:\n{}",
        changed.len(),
        changed.join("\n")
    );
}

/// `pow` alone is imported, by which indicatif and tokio count times.
#[cfg(target_os = "linux")]
#[test]
fn no_number_comes_from_the_mathematics_of_the_platform() {
    let program = std::fs::read(env!("CARGO_BIN_EXE_host-cli")).expect("built");
    let file = elf::ElfBytes::<elf::endian::AnyEndian>::minimal_parse(&program).expect("ELF");
    let (symbols, names) = (file.dynamic_symbol_table().expect("a table")).expect("symbols");
    let names = symbols
        .iter()
        .filter(elf::symbol::Symbol::is_undefined)
        .map(|symbol| names.get(symbol.st_name as usize).expect("a name"));
    let mathematics = "acos acosh asin asinh atan atan2 atanh cbrt cos cosh erf exp exp10 exp2 expm1 hypot lgamma log log10 log1p log2 pow \
                       sin sincos sinh tan tanh tgamma";
    let is_one = |name: &&str| {
        let mut all = mathematics.split_whitespace();
        all.any(|known| *name == known || name.strip_suffix('f') == Some(known))
    };
    let found: Vec<&str> = names.filter(is_one).collect();
    assert_eq!(found, ["pow"]);
}

#[test]
fn the_first_figure_has_the_forces_of_relax_bit_for_bit() {
    let place = Place::with_examples();
    place.run("relax --out run").succeeded();
    let table = place.text("run/relax.csv");
    let first = first_figure::Relaxation::simulate().expect("the defaults");
    let (times, forces): (Vec<f64>, Vec<f64>) = first.force_n.iter().copied().unzip();
    let bits = |values: &[f64]| {
        values
            .iter()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    for (name, ours) in [
        ("time_s", &times),
        ("simulated_force_n", &forces),
        ("closed_form_force_n", &first.closed_form_n(&times)),
    ] {
        assert!(bits(&column(&table, name)) == bits(ours), "another {name}");
    }
}
