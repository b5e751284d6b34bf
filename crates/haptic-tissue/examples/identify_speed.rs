//! Times the fits of the measured fish muscle on one core: `cargo run --release -p haptic-tissue --features identify --example
//! identify_speed`. `benches/identify_against_scipy.py` at the root of the repository holds it against `SciPy`.

use haptic_tissue::ModelKind;
use haptic_tissue::identify::{Options, Record, identify};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rows = include_str!("../records/fish-muscle-relaxation.tsv")
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
    for (what, options) in [
        ("fractional-maxwell", maxwell),
        ("auto", Options::default()),
    ] {
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            let start = Instant::now();
            identify(&record, &options, &|_| ())?;
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{what} {best:.4}");
    }
    Ok(())
}
