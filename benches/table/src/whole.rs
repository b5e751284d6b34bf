//! What is more than an operator: ticks of controllers, regions and verdicts.

use crate::{BATCH, Bench, RUNS, SAMPLES, T, sample};
use cpu_time::ThreadTime;
use fracdiff::{Order, Scheme, Seconds};
use fractional_control::{
    Actuator, Controller, FractionalPid, PidParameters, PowerMemory, Rule, SetPoint,
};
use haptic_analysis::{LoopOperator, Nondimensional, SampledLoop, SampledPlant, StabilityRegion};
use std::error::Error;
use std::hint::black_box;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// PI^λD^μ of λ = 0.8 and μ = 0.6 with 200 s at 1 kHz, and a PID of order 1.
pub(crate) fn controllers(bench: &Bench) -> Outcome {
    for (name, rule, tolerance, orders) in [
        ("PID of order 1, f64", Rule::Grunwald, 1e-6, [1.0, 1.0]),
        ("PI^λD^μ 1e-4, f64", Rule::Grunwald, 1e-4, [0.8, 0.6]),
        ("PI^λD^μ 1e-6, f64", Rule::Grunwald, 1e-6, [0.8, 0.6]),
        ("PI^λD^μ 1e-6, bdf2, f64", Rule::Bdf2, 1e-6, [0.8, 0.6]),
    ] {
        let gains = PidParameters {
            proportional: 2.0,
            integral: 1.5,
            integral_order: orders[0],
            derivative: 0.3,
            derivative_order: orders[1],
        };
        let memory = PowerMemory::new(rule, tolerance, 200.0)?.fewest_modes();
        let actuator = Actuator::new(-3.0, 3.0)?;
        let pid =
            FractionalPid::<f64, 48>::new(gains, SetPoint::DEFAULT, actuator, memory, Seconds(T))?;
        bench.time(name, tick(&pid))?;
    }
    Ok(())
}

/// Command, then history: the shortest batch, ns a tick.
fn tick(controller: &impl Controller<f64>) -> f64 {
    let y: Vec<f64> = (0..SAMPLES).map(sample).collect();
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let mut history = controller.at_rest();
        for y in y.chunks_exact(BATCH) {
            let start = ThreadTime::now();
            for &y in y {
                let y = black_box(y);
                let u = controller.output(&history, 0.5, y);
                controller.advance(&mut history, 0.5, y, black_box(u));
            }
            least = least.min(start.elapsed().as_nanos() as f64 / BATCH as f64);
        }
    }
    least
}

/// Damping without units of the device of the dissertation's section 4.4, 65 g and 3.5 N·s/m at 500 Hz, with a fractional wall of order 0.5.
const DELTA: f64 = 3.5 * 0.002 / 0.065;

fn wall(alpha: f64, beta: f64) -> Nondimensional {
    Nondimensional {
        alpha,
        beta,
        delta: DELTA,
        gamma: 0.0,
    }
}

fn exact() -> Outcome<LoopOperator> {
    let order = Order::new(0.5)?;
    Ok(LoopOperator::new(Scheme::Exact, order, Seconds(1.0), 1e5)?)
}

/// A region and a verdict.
pub(crate) fn analyses(bench: &Bench) -> Outcome {
    let (operator, plant) = (exact()?, SampledPlant::new(DELTA, 0.0)?);
    let region = least(4 * RUNS, || {
        black_box(StabilityRegion::new(plant, black_box(&operator), 0, 2000)).is_ok()
    });
    bench.time("stability region, 2000 points", region)?;
    let verdict = least(100 * RUNS, || {
        SampledLoop::new(black_box(wall(0.2, 0.3)), &operator, 0)
            .is_ok_and(|sampled| black_box(sampled.is_stable()))
    });
    bench.time("one certified verdict", verdict)
}

/// The shortest of several runs, ns; each must say that it did its work.
fn least(runs: usize, mut run: impl FnMut() -> bool) -> f64 {
    let times = (0..runs).map(|_| {
        let start = ThreadTime::now();
        assert!(run(), "a wall or plant out of range");
        start.elapsed().as_nanos() as f64
    });
    times.fold(f64::INFINITY, f64::min)
}
