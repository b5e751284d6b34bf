//! What a tick may cost: of the whole loop, and `output` and step of each operator, with their share of a period.
//!
//! ```text
//! cargo benches --bench budget        half a minute; fails beyond the budget
//! ```
//! - *The whole loop*: read, force, every limit and a guard, write, advance, pressing into tissue. The median of
//!   batches of 1000 ticks may be at most 1 µs, one hundredth of a period at 10 kHz.
//! - *Budget*, as the README promises: `output` at most 2 ns in the median, the same for any memory; a whole tick
//!   (output, then advance) at most 1 µs at p99.9, one hundredth of a period at 10 kHz.
//! - *`output`*: batches of 256 calls; p50 and p99.9 are of batches, divided by 256. A throughput.
//! - *Tick*: each one by itself, 200 000 of them, less the median of an empty measurement. What the machine does
//!   in between (interrupts, other jobs, a hypervisor) is in the last thousandth.
//! - *State when quoting*: processor, rustc, flags, date, load. `chrt -f 10 taskset -c 1` helps on a busy machine.

mod catalogue;
mod input;
mod press;

use catalogue::Visitor;
use fractional_haptics::fracdiff::{Differintegrator, Real};
use fractional_haptics::haptic_loop::{Controller, SafetyChain};
use input::{BATCH, SAMPLE_TIME, ramp_and_hold};
use press::{Scripted, contact, guards, operator, whole};
use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

/// Largest median of `output`, ns.
const OUTPUT_NS: f64 = 2.0;
/// Largest median of a tick of the loop, and largest p99.9 of a step of an operator, ns.
const TICK_NS: f64 = 1000.0;
const LOOPS: usize = 1000;
const OUTPUTS: usize = 256;
const BATCHES: usize = 20_000;
const TICKS: usize = 200_000;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut budget = Budget {
        clock_ns: clock_ns(),
        exceeded: Vec::new(),
    };
    loops::<f32>("f32", &mut budget)?;
    loops::<f64>("f64", &mut budget)?;
    println!(
        "{:<28} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "ns", "output", "p99.9", "tick", "p99.9", "of 1 kHz", "of 10 kHz"
    );
    catalogue::visit_all(&mut budget)?;
    println!(
        "clock: {:.0} ns, taken off; shares are of the tick's p99.9",
        budget.clock_ns
    );
    for line in &budget.exceeded {
        eprintln!("over budget: {line}");
    }
    Ok(if budget.exceeded.is_empty() {
        println!("within the budget: output {OUTPUT_NS} ns (p50), tick {TICK_NS} ns (p99.9)");
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// The tick of the whole loop without a guard and with each.
fn loops<F: Real>(precision: &str, budget: &mut Budget) -> Result<(), Box<dyn Error>> {
    let full = operator::<F>("full:1e-6", 200e3)?;
    for (guard, limits) in guards().map(|(name, guard)| (name, whole(guard))) {
        let chain = SafetyChain::from_limits(&limits, SAMPLE_TIME)?;
        let controller = Controller::new(contact([1.0], full.clone())?, chain);
        let mut engaged = controller.into_engaged(Scripted::<F, 1>::new());
        let [median, _] = quantiles(LOOPS, || {
            for _ in 0..BATCH {
                let Ok(sample) = black_box(&mut engaged).tick();
                black_box(&sample);
            }
        });
        let median = median / BATCH as f64;
        let line = format!("whole tick {precision}, {guard}: {median:.0} ns, {TICK_NS} allowed");
        println!("{line}");
        budget.exceeded.extend((median > TICK_NS).then_some(line));
    }
    Ok(())
}

struct Budget {
    clock_ns: f64,
    exceeded: Vec<String>,
}

impl Visitor for Budget {
    fn visit<F: Real, O: Differintegrator<F>>(
        &mut self,
        name: &str,
        operator: &O,
    ) -> Result<(), Box<dyn Error>> {
        let input = ramp_and_hold::<F>();
        let mut history = operator.at_rest();
        for &x in input.iter().cycle().take(10_000) {
            operator.advance(&mut history, x);
        }
        let outputs = quantiles(BATCHES, || {
            for &x in &input[..OUTPUTS] {
                black_box(black_box(operator).output(black_box(&history), x));
            }
        });
        let outputs = outputs.map(|ns| (ns - self.clock_ns).max(0.0) / OUTPUTS as f64);
        let mut samples = input.iter().cycle();
        let ticks = quantiles(TICKS, || {
            if let Some(&x) = samples.next() {
                black_box(black_box(operator).step(black_box(&mut history), x));
            }
        });
        let ticks = ticks.map(|ns| (ns - self.clock_ns).max(0.0));
        println!(
            "{name:<28} {:>9.2} {:>9.2} {:>9.0} {:>9.0} {:>8.3}% {:>8.3}%",
            outputs[0],
            outputs[1],
            ticks[0],
            ticks[1],
            ticks[1] / 1e4,
            ticks[1] / 1e3
        );
        if outputs[0] > OUTPUT_NS {
            let line = format!("{name}: output {:.2} ns, {OUTPUT_NS} allowed", outputs[0]);
            self.exceeded.push(line);
        }
        if ticks[1] > TICK_NS {
            let line = format!(
                "{name}: p99.9 of a tick {:.0} ns, {TICK_NS} allowed",
                ticks[1]
            );
            self.exceeded.push(line);
        }
        Ok(())
    }
}

/// p50 and p99.9 of `count` runs, ns, the clock included.
fn quantiles(count: usize, mut run: impl FnMut()) -> [f64; 2] {
    let mut times: Vec<u128> = (0..count)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_nanos()
        })
        .collect();
    times.sort_unstable();
    [count / 2, count - 1 - count / 1000].map(|at| times[at] as f64)
}

/// Median of measuring nothing.
fn clock_ns() -> f64 {
    quantiles(100_000, || ())[0]
}
