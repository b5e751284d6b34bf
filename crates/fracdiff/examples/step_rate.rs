//! Time per sample of operators chosen at run time, for comparison with other languages: `python/benches/speed.py`.
//!
//! ```text
//! cargo run --release -p fracdiff --all-features --example step_rate -- SAMPLES SCHEME...
//! ```
//! prints a line `SCHEME NANOSECONDS` for each scheme, the best of nine runs.

use fracdiff::{Channel, Operator, Order, Scheme, Seconds};
use std::error::Error;
use std::time::Instant;

const RUNS: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let samples: usize = arguments.next().ok_or("SAMPLES is missing")?.parse()?;
    let x: Vec<f64> = (0..samples).map(|n| libm::sin(0.01 * n as f64)).collect();
    for text in arguments {
        let scheme: Scheme = text.parse()?;
        let operator: Operator<f64> = scheme.build(Order::new(0.5)?, Seconds(1e-3), 3.6e6)?;
        let mut axis = Channel::new(operator);
        let mut best = f64::INFINITY;
        for _ in 0..RUNS {
            let start = Instant::now();
            let mut y = x.clone();
            axis.process(&mut y);
            best = best.min(start.elapsed().as_secs_f64());
            std::hint::black_box(y);
        }
        println!("{text} {}", best / samples as f64 * 1e9);
    }
    Ok(())
}
