//! `cargo run -p first-figure`: simulates, draws, says where the figure is and what comes next.

use first_figure::Relaxation;
use std::error::Error;
use std::fs;

fn main() -> Result<(), Box<dyn Error>> {
    let run = Relaxation::simulate()?;
    let largest = run.force_n.iter().map(|point| point.1).fold(0.0, f64::max);
    let (end_s, end_n) = run.force_n.last().copied().unwrap_or_default();
    fs::create_dir_all("results")?;
    let file = "results/relaxation.svg";
    fs::write(file, run.picture()?.svg())?;
    println!(
        "A virtual prostate opposes {largest:.3} N at most, and {end_n:.3} N after {end_s} s."
    );
    println!("{file} has the figure: open it in a browser.");
    println!(
        "Next: `cargo run -p host-cli -- relax` keeps a log and a table too, and judges the run."
    );
    Ok(())
}
