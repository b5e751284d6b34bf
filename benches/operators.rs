//! Time per tick of each operator, in `f32` and `f64`: `output`, `advance` and both (`step`).
//!
//! ```text
//! cargo bench --bench operators                        all, some three minutes
//! cargo bench --bench operators -- 'step f64/Full'     one group, one family
//! ```
//! - *Unit*: an iteration is 1000 calls (criterion's timer then counts for nothing), so its µs are
//!   ns per tick. Quote the median, `target/criterion/GROUP/NAME/new/estimates.json`.
//! - *State when quoting*: processor, rustc, flags (`target-cpu`, profile), date. On a busy machine run it
//!   under `chrt -f 10 taskset -c 1` (as root).
//! - *Input*: a ramp and hold, again and again; order 0.2247 at 1 kHz; the history is full.
//! - *Warm*: one operator, back to back, everything in the cache that fits. `output`s do not depend
//!   on each other and overlap, so theirs is a throughput; `advance` needs the one before.
//! - *Nothing is left out*: operator, history and result pass through `black_box` in each call, which
//!   costs what the entry "nothing" shows. It is included in all others, not subtracted.
//! - *Compare with*: the naive `%` ring of 1024 taps in the same run (`benches/baseline`); ratios travel
//!   between machines, nanoseconds do not.
//! - *Full memory* has the fewest modes its tolerance allows, as the command line makes it; their
//!   number is printed.

mod baseline;
mod input;

use baseline::{ModuloRing, Nothing};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use fractional_haptics::fracdiff::full_memory::{Design, FullMemory, Kernel};
use fractional_haptics::fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fractional_haptics::fracdiff::{
    Band, Differintegrator, MuirPolynomial, Oustaloup, Real, ShortMemory, TustinMuir,
};
use input::{BATCH, SAMPLE_TIME, order, ramp_and_hold};
use std::error::Error;
use std::hint::black_box;

/// What is timed.
#[derive(Clone, Copy, Debug)]
enum Phase {
    Output,
    Advance,
    Step,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = baseline::short_runs();
    operators::<f64>(&mut criterion, "f64")?;
    operators::<f32>(&mut criterion, "f32")?;
    criterion.final_summary();
    Ok(())
}

fn operators<F: Real>(criterion: &mut Criterion, precision: &str) -> Result<(), Box<dyn Error>> {
    let t = SAMPLE_TIME;
    let short_64 = ShortMemory::<F, 64>::new(order(), t)?;
    let short_256 = ShortMemory::<F, 256>::new(order(), t)?;
    let short_1024 = ShortMemory::<F, 1024>::new(order(), t)?;
    let short_4096 = ShortMemory::<F, 4096>::new(order(), t)?;
    let full = [
        ("FullMemory 1e-3, 200 s", full_memory::<F>(1e-3, 200.0)?),
        ("FullMemory 1e-6, 200 s", full_memory(1e-6, 200.0)?),
        ("FullMemory 1e-6, 24 h", full_memory(1e-6, 86_400.0)?),
        ("FullMemory 1e-9, 200 s", full_memory(1e-9, 200.0)?),
    ];
    let band = Band {
        low_hz: 0.01,
        high_hz: 100.0,
    };
    let tustin_muir = TustinMuir::<F, 9>::new(order(), t)?;
    let oustaloup = Oustaloup::<F, 9>::new(order(), band, t)?;
    let muir = MuirPolynomial::<F, 3>::new(order(), t)?;
    let ring = ModuloRing::<F, 1024>::new();

    for (phase, name) in [
        (Phase::Output, "output"),
        (Phase::Advance, "advance"),
        (Phase::Step, "step"),
    ] {
        let mut group = criterion.benchmark_group(format!("{name} {precision}"));
        group.throughput(Throughput::Elements(BATCH as u64));
        measure::<F, _>(&mut group, phase, "nothing", &Nothing);
        measure(&mut group, phase, "ShortMemory 64", &short_64);
        measure(&mut group, phase, "ShortMemory 256", &short_256);
        measure(&mut group, phase, "ShortMemory 1024", &short_1024);
        measure(&mut group, phase, "ShortMemory 4096", &short_4096);
        for (name, operator) in &full {
            measure(&mut group, phase, name, operator);
        }
        measure(&mut group, phase, "TustinMuir 9", &tustin_muir);
        measure(&mut group, phase, "Oustaloup 9", &oustaloup);
        measure(&mut group, phase, "MuirPolynomial 3", &muir);
        measure(&mut group, phase, "naive % ring 1024", &ring);
        group.finish();
    }
    Ok(())
}

/// As `Scheme::build` makes it.
fn full_memory<F: Real>(
    tolerance: f64,
    horizon_s: f64,
) -> Result<FullMemory<F, FULL_TAPS, FULL_MODES>, Box<dyn Error>> {
    let horizon = horizon_s / SAMPLE_TIME.0;
    let design = Design::pruned(Kernel::Grunwald, order(), tolerance, horizon)?;
    let modes = design.modes().len();
    eprintln!("full memory, {tolerance:e} for {horizon_s} s: {FULL_TAPS} taps, {modes} modes");
    Ok(FullMemory::new(&design, SAMPLE_TIME)?)
}

fn measure<F: Real, O: Differintegrator<F>>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    phase: Phase,
    name: &str,
    operator: &O,
) {
    let input = ramp_and_hold::<F>();
    let mut history = operator.at_rest();
    // Five presses fill the longest buffer.
    for &x in input.iter().cycle().take(5 * BATCH) {
        operator.advance(&mut history, x);
    }
    group.bench_function(name, |bencher| match phase {
        Phase::Output => bencher.iter(|| {
            for &x in &input {
                black_box(black_box(operator).output(black_box(&history), x));
            }
        }),
        Phase::Advance => bencher.iter(|| {
            for &x in &input {
                black_box(operator).advance(black_box(&mut history), x);
            }
            // Also the last one counts.
            black_box(&mut history);
        }),
        Phase::Step => bencher.iter(|| {
            for &x in &input {
                black_box(black_box(operator).step(black_box(&mut history), x));
            }
        }),
    });
}
