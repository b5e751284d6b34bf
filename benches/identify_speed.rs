//! Times the fits of the measured fish muscle and of an indentation on one core: `cargo run --release --manifest-path
//! benches/Cargo.toml --example identify_speed [NAME]`. `identify_against_scipy.py` beside it holds it against `SciPy`.

use haptic_loop::{Loading, LoadingKind, Modulus, Specimen};
use haptic_tissue::{Model, ModelKind};
use std::time::Instant;
use tissue_identification::{Options, Record, identify};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rows = include_str!("../crates/haptic-tissue/records/fish-muscle-relaxation.tsv")
        .lines()
        .skip(1);
    let (mut time, mut modulus) = (Vec::new(), Vec::new());
    for row in rows {
        let (t, g) = row.split_once('\t').ok_or("two columns")?;
        time.push(t.parse()?);
        modulus.push(g.parse()?);
    }
    let record = Record::relaxation(time, modulus)?;
    let maxwell = Options {
        candidates: vec![ModelKind::FractionalMaxwell],
        ..Options::default()
    };
    let zener = Options {
        candidates: vec![ModelKind::FractionalZener],
        ..Options::default()
    };
    let stiffening = Options {
        stiffening: true,
        ..zener.clone()
    };
    let indentation = indented([1500.0, 0.7, 3000.0, 0.15, 400.0])?;
    // Two spring-pots whose orders are near each other: a flat valley.
    let flat = indented([3000.0, 0.5, 2000.0, 0.2, 100.0])?;
    for (what, record, options) in [
        ("fractional-maxwell", &record, maxwell),
        ("auto", &record, Options::default()),
        ("indentation", &indentation, zener.clone()),
        ("flat-valley", &flat, zener),
        ("indentation-stiffening", &indentation, stiffening),
    ] {
        if std::env::args().nth(1).is_some_and(|only| only != what) {
            continue;
        }
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            let start = Instant::now();
            identify(record, &options, &|_| ())?;
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{what} {best:.4}");
    }
    Ok(())
}

/// A sphere that is pressed in within 0.5 s and held for 19.5 s, 2000 samples of a fractional Zener model with a wave of 1 %.
fn indented(tissue: [f64; 5]) -> Result<Record, Box<dyn std::error::Error>> {
    let sphere = Loading {
        radius_m: Some(5e-3),
        ..Loading::new(LoadingKind::Sphere)
    };
    let sphere = Specimen::new(sphere, 0.5, 0.0)?;
    let map = sphere.depth_map().ok_or("a map")?;
    let tissue = Model::from_parameters(ModelKind::FractionalZener, &tissue)?;
    let time_s: Vec<f64> = (0..2000).map(|n| 0.01 * f64::from(n)).collect();
    let depth_m: Vec<f64> = time_s.iter().map(|t| 1e-3 * (2.0 * t).min(1.0)).collect();
    let input: Vec<f64> = depth_m.iter().map(|depth| map.at(*depth)).collect();
    let stress = tissue.stress(&time_s, &input);
    let shape = sphere.shape(Modulus::Young);
    let force = (0_u32..).zip(stress);
    let force =
        force.map(|(n, stress)| shape * stress * (1.0 + 0.01 * libm::sin(37.0 * f64::from(n))));
    Ok(Record::pressed(time_s, depth_m, force.collect(), &sphere)?)
}
