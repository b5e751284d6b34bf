//! A design for a fractional plant. What a tick costs: `table/run`.
//!
//! ```sh
//! cargo benches --bench control
//! ```

use criterion::{Criterion, criterion_group, criterion_main};
use fracdiff::Seconds;
use fractional_control::design::ControlDesign;
use fractional_control::tuning::Specification;
use std::hint::black_box;

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

criterion_group!(designs, design);
criterion_main!(designs);
