//! The sample paths as functions of their own, to look at their machine code:
//!
//! ```text
//! cargo rustc --release -p fracdiff --example kernels -- --emit asm -C lto=off
//! grep -n -A80 '^_.*short_advance' target/release/examples/kernels-*.s
//! ```

use fracdiff::full_memory::{Design, FullMemory, FullMemoryHistory, Kernel};
use fracdiff::{Differintegrator, FirHistory, Order, Seconds, ShortMemory};
use std::hint::black_box;

type Short = ShortMemory<f32, 1024>;
type Full = FullMemory<f32, 16, 40>;

/// The part between sensor and force.
#[inline(never)]
fn short_output(operator: &Short, history: &FirHistory<f32, 1024>, x: f32) -> f32 {
    operator.output(history, x)
}

/// The part after the force.
#[inline(never)]
fn short_advance(operator: &Short, history: &mut FirHistory<f32, 1024>, x: f32) {
    operator.advance(history, x);
}

/// The part between sensor and force, with all of the past.
#[inline(never)]
fn full_output(operator: &Full, history: &FullMemoryHistory<f32, 16, 40>, x: f32) -> f32 {
    operator.output(history, x)
}

/// The part after the force, with all of the past.
#[inline(never)]
fn full_advance(operator: &Full, history: &mut FullMemoryHistory<f32, 16, 40>, x: f32) {
    operator.advance(history, x);
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (order, t) = (Order::new(0.2247)?, Seconds(1e-3));
    let short = black_box(Short::new(order, t)?);
    let design = Design::closed_form(Kernel::Grunwald, order, 1e-6, 2e5)?;
    let full = black_box(Full::new(&design, t)?);
    let (mut near, mut all) = (short.at_rest(), full.at_rest());
    let mut y = (0.0, 0.0);
    for n in 0..2000_u16 {
        let x = black_box(f32::from(n.min(1000)) * 1e-3);
        y = (short_output(&short, &near, x), full_output(&full, &all, x));
        short_advance(&short, &mut near, x);
        full_advance(&full, &mut all, x);
    }
    println!(
        "1 s ramp held for 1 s: short memory {}, full memory {}",
        y.0, y.1
    );
    Ok(())
}
