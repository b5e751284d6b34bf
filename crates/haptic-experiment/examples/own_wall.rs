//! A wall of one's own law on a plant of one's own, tried and judged as every wall is.
//!
//! ```text
//! cargo run -p haptic-experiment --example own_wall
//! ```

use fracdiff::Seconds;
use haptic_experiment::{ReportLine, lines};
use haptic_judge::trial::TrialPlan;

const T: f64 = 1e-3;
const STIFFNESS: f64 = 500.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // f = −K·x − B·(x − x of the tick before)/T
    let wall = |before: &mut f64, x: f64| {
        let force_n = -STIFFNESS * x - 2.0 / T * (x - *before);
        *before = x;
        force_n
    };
    // 80 g on 4 N·s/m that hit the wall with 0.1 m/s and are pushed with 1 N.
    let (mut position, mut speed) = (0.0, 0.1);
    let plant = |force_n: f64| {
        speed += (1.0 + force_n - 4.0 * speed) / 0.08 * T;
        position += speed * T;
        position
    };
    let settling = TrialPlan::default().try_law((0.0, wall), plant, Seconds(T), STIFFNESS)?;
    for line in lines(&settling) {
        if let ReportLine::Row(row) = line {
            println!("{}: {}", row.label, row.value);
        }
    }
    assert!(settling.stable);
    Ok(())
}
