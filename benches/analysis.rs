//! What an analysis costs: one verdict, its margins, the proof for every motion of one-sided contact, one passivity check; beside the
//! naive way in the same run, all poles at each point of a grid. And a design for a fractional plant. `table/run` times the region, the
//! verdict and a tick of a controller.
//!
//! Device of the dissertation's section 4.4 (δ = 0.10769), order 0.5. The naive way needs a polynomial, so
//! it is measured with the Muir polynomial of degree 3 (characteristic polynomial of degree 5); the
//! other rows say which operator they use. A region's boundary has 2000 points; a grid of the same
//! resolution has 2000 × 2000, and its cost is that of one point times four million.
//!
//! Quote with core, flags and date: `cargo benches --bench analysis`.

mod timing;

use control_tuning::Specification;
use control_tuning::design::ControlDesign;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{LoopOperator, Nondimensional, OnePort, SampledLoop};
use std::error::Error;
use std::hint::black_box;
use timing::{Timed, compare, timed};

const WALL: Nondimensional = Nondimensional {
    alpha: 0.2,
    beta: 0.3,
    delta: 3.5 * 0.002 / 0.065,
    gamma: 0.0,
};

fn main() -> Result<(), Box<dyn Error>> {
    let order = Order::new(0.5)?;
    let loop_operator = |scheme| LoopOperator::new(scheme, order, Seconds(1.0), 1e5);
    for (name, operator) in [
        ("exact", loop_operator(Scheme::Exact)?),
        ("muir:3", loop_operator(Scheme::Muir { degree: 3 })?),
    ] {
        let closed = || SampledLoop::new(black_box(WALL), &operator, 0);
        let sampled = closed()?;
        let mut runs = vec![
            once("verdict", || closed().map(|closed| closed.is_stable())),
            once("margins", || black_box(&sampled).margins()),
            once("every motion", || black_box(&sampled).slope_limit()),
            once("passivity", || {
                let port = OnePort::new(&operator, order);
                port.and_then(|port| port.required_delta(black_box(WALL.alpha), WALL.beta))
            }),
        ];
        // One point of a grid: build the characteristic polynomial and find all its roots.
        if sampled.poles().is_some() {
            runs.push(once("naive: all poles", || {
                closed().map(|closed| closed.poles())
            }));
        }
        compare(&format!("one wall, {name}"), 200, runs);
    }
    // Tuning, verdicts, margins and steps of both controllers, as `control design`.
    let design = ControlDesign {
        plant: "1/(0.2s^1.4+1)".parse()?,
        wishes: Specification::new(5.0, 1.0),
        sample_time: Seconds(2e-3),
        scheme: "full-bdf2".parse()?,
        output_low: None,
        output_high: None,
        step: 1.0,
        samples: 6000,
    };
    let runs = vec![once("plant of order 1.4", || black_box(&design).answer())];
    compare("design", 10, runs);
    Ok(())
}

fn once<'a, T>(name: &str, mut run: impl FnMut() -> T + 'a) -> Timed<'a> {
    timed(name, move || {
        black_box(run());
        1
    })
}
