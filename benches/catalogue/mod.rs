//! The operators that the budget and the instruction counts look at, by name.

use crate::input::{SAMPLE_TIME, order};
use fractional_haptics::fracdiff::full_memory::{Design, FullMemory, Kernel};
use fractional_haptics::fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fractional_haptics::fracdiff::{
    Band, Differintegrator, Oustaloup, Real, ShortMemory, TustinMuir,
};
use std::error::Error;

/// What is done with each operator.
pub(crate) trait Visitor {
    /// `name` has the sample type at its end.
    fn visit<F: Real, O: Differintegrator<F>>(
        &mut self,
        name: &str,
        operator: &O,
    ) -> Result<(), Box<dyn Error>>;

    /// Whether to make this one at all.
    fn wants(&mut self, _name: &str) -> bool {
        true
    }
}

/// Shows all of them to the visitor, in both precisions.
pub(crate) fn visit_all(visitor: &mut impl Visitor) -> Result<(), Box<dyn Error>> {
    visit::<f32>(visitor, "f32")?;
    visit::<f64>(visitor, "f64")
}

fn visit<F: Real>(visitor: &mut impl Visitor, precision: &str) -> Result<(), Box<dyn Error>> {
    macro_rules! show {
        ($name:expr, $operator:expr) => {
            let name = format!("{} {precision}", $name);
            if visitor.wants(&name) {
                visitor.visit::<F, _>(&name, &$operator)?;
            }
        };
    }
    let t = SAMPLE_TIME;
    show!("ShortMemory 64", ShortMemory::<F, 64>::new(order(), t)?);
    show!("ShortMemory 256", ShortMemory::<F, 256>::new(order(), t)?);
    show!("ShortMemory 1024", ShortMemory::<F, 1024>::new(order(), t)?);
    for (name, tolerance, horizon_s) in [
        ("FullMemory 1e-3 200 s", 1e-3, 200.0),
        ("FullMemory 1e-6 200 s", 1e-6, 200.0),
        ("FullMemory 1e-6 24 h", 1e-6, 86_400.0),
    ] {
        show!(name, {
            let horizon = horizon_s / t.0;
            let design = Design::pruned(Kernel::Grunwald, order(), tolerance, horizon)?;
            FullMemory::<F, FULL_TAPS, FULL_MODES>::new(&design, t)?
        });
    }
    show!("TustinMuir 9", TustinMuir::<F, 9>::new(order(), t)?);
    let (low_hz, high_hz) = (0.01, 100.0);
    show!(
        "Oustaloup 9",
        Oustaloup::<F, 16>::new(order(), 9, Band { low_hz, high_hz }, t)?
    );
    Ok(())
}
