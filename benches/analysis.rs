//! What an analysis costs: a region by D-decomposition, one verdict, its margins, the proof for every
//! motion of one-sided contact, one passivity check; beside the naive way in the same run, all poles at each point of a grid.
//! `table/run` times the map of verdicts.
//!
//! Device of the dissertation's section 4.4 (δ = 0.10769), order 0.5. The naive way needs a polynomial, so
//! it is measured with the Muir polynomial of degree 3 (characteristic polynomial of degree 5); the
//! other rows say which operator they use. The region's boundary has 2000 points; a grid of the same
//! resolution has 2000 × 2000, and its cost is that of one point times four million.
//!
//! Quote with core, flags and date: `cargo benches --bench analysis`.

use criterion::{Criterion, criterion_group, criterion_main};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    LoopOperator, Nondimensional, OnePort, SampledLoop, SampledPlant, StabilityRegion,
};
use std::hint::black_box;

const DELTA: f64 = 3.5 * 0.002 / 0.065;
const POINTS: usize = 2000;

fn order() -> Order {
    Order::new(0.5).expect("valid")
}

fn operator(scheme: Scheme) -> LoopOperator {
    LoopOperator::new(scheme, order(), Seconds(1.0), 1e5).expect("valid")
}

fn wall(alpha: f64, beta: f64) -> Nondimensional {
    Nondimensional {
        alpha,
        beta,
        delta: DELTA,
        gamma: 0.0,
    }
}

fn operators() -> [(&'static str, LoopOperator); 2] {
    [
        ("exact", operator(Scheme::Exact)),
        ("muir:3", operator(Scheme::Muir { degree: 3 })),
    ]
}

fn regions(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("region of 2000 points");
    let plant = SampledPlant::new(DELTA, 0.0).expect("valid");
    for (name, operator) in operators() {
        group.bench_function(name, |bencher| {
            bencher.iter(|| StabilityRegion::new(plant, black_box(&operator), 0, POINTS));
        });
    }
    group.finish();
}

fn points(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("one wall");
    for (name, operator) in operators() {
        group.bench_function(format!("verdict, {name}"), |bencher| {
            bencher.iter(|| {
                SampledLoop::new(black_box(wall(0.2, 0.3)), &operator, 0).map(|l| l.is_stable())
            });
        });
        let sampled = SampledLoop::new(wall(0.2, 0.3), &operator, 0).expect("valid");
        group.bench_function(format!("margins, {name}"), |bencher| {
            bencher.iter(|| black_box(&sampled).margins());
        });
        group.bench_function(format!("every motion, {name}"), |bencher| {
            bencher.iter(|| black_box(&sampled).slope_limit());
        });
        group.bench_function(format!("passivity, {name}"), |bencher| {
            bencher.iter(|| {
                let port = OnePort::new(&operator, order()).expect("valid");
                port.required_delta(black_box(0.2), black_box(0.3))
            });
        });
    }
    // The naive way, one point of the grid: build the characteristic polynomial, find all its roots.
    let muir = operator(Scheme::Muir { degree: 3 });
    group.bench_function("naive: all poles, muir:3", |bencher| {
        bencher.iter(|| {
            let sampled = SampledLoop::new(black_box(wall(0.2, 0.3)), &muir, 0).expect("valid");
            sampled.poles()
        });
    });
    group.finish();
}

criterion_group!(benches, regions, points);
criterion_main!(benches);
