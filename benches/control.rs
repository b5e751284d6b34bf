//! A tick of PI^λD^μ with 200 s of memory at 1 kHz, beside a PID of order 1 and a plain full memory; a design for a fractional plant.
//!
//! ```sh
//! cargo bench --bench control
//! ```

use criterion::{Criterion, criterion_group, criterion_main};
use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{Differintegrator, FullMemory, Order, Seconds};
use fractional_control::design::ControlDesign;
use fractional_control::tuning::Specification;
use fractional_control::{
    Actuator, Controller, FractionalPid, Memory, PidParameters, Rule, SetPoint,
};
use std::hint::black_box;

const T: Seconds = Seconds(1e-3);

fn pid(rule: Rule, tolerance: f64, orders: [f64; 2]) -> FractionalPid<f64, 48> {
    let gains = PidParameters {
        proportional: 2.0,
        integral: 1.5,
        integral_order: orders[0],
        derivative: 0.3,
        derivative_order: orders[1],
    };
    let memory = Memory::new(rule, tolerance, 200.0).map(Memory::fewest_modes);
    let actuator = Actuator::new(-3.0, 3.0);
    memory
        .and_then(|memory| FractionalPid::new(gains, SetPoint::DEFAULT, actuator?, memory, T))
        .expect("valid")
}

fn tick<C: Controller<f64>>(bench: &mut Criterion, name: &str, controller: &C) {
    let mut history = controller.at_rest();
    let mut y = 0.0;
    bench.bench_function(name, |b| {
        b.iter(|| {
            y = if y > 1.0 { 0.0 } else { y + 1e-3 };
            let (r, y) = (black_box(0.5), black_box(y));
            let u = controller.output(&history, r, y);
            controller.advance(&mut history, r, y, u);
            u
        });
    });
}

/// Tuning, verdicts, margins and steps of both controllers, as `control design`.
fn design(bench: &mut Criterion) {
    let design = ControlDesign {
        plant: "1/(0.2s^1.4+1)".parse().expect("valid"),
        wishes: Specification::new(5.0, 1.0),
        sample_time: Seconds(2e-3),
        scheme: "full-bdf2".parse().expect("valid"),
        output_low: None,
        output_high: None,
        step: 1.0,
        samples: 6000,
    };
    bench.bench_function("design", |b| b.iter(|| black_box(&design).answer()));
}

fn benches(bench: &mut Criterion) {
    design(bench);
    tick(bench, "pid 1 1", &pid(Rule::Grunwald, 1e-6, [1.0, 1.0]));
    for tolerance in [1e-4, 1e-6] {
        let own = pid(Rule::Grunwald, tolerance, [0.8, 0.6]);
        tick(bench, &format!("fractional pid {tolerance:e}"), &own);
    }
    tick(
        bench,
        "fractional pid bdf2 1e-6",
        &pid(Rule::Bdf2, 1e-6, [0.8, 0.6]),
    );
    let order = Order::new(0.6).expect("valid");
    let design = Design::<16, 48>::pruned(Kernel::Grunwald, order, 1e-6, 2e5).expect("reachable");
    let memory = FullMemory::<f64, 16, 48>::new(&design, T).expect("valid");
    let mut history = memory.at_rest();
    bench.bench_function("one full memory 1e-6", |b| {
        b.iter(|| memory.step(&mut history, black_box(0.7)));
    });
}

criterion_group!(ticks, benches);
criterion_main!(ticks);
