//! A fractional derivative on a microcontroller whose coefficients build.rs has made.
//!
//! ```text
//! cargo build --release                                  coefficients from build.rs
//! cargo build --release --features design-on-device      designed when it starts, for comparison
//! size target/thumbv7em-none-eabihf/release/coefficients-in-build-rs
//! ```

#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use core::hint::black_box;
use cortex_m_rt::entry;
use fracdiff::{Differintegrator, FullMemory};

include!(concat!(env!("OUT_DIR"), "/coefficients.rs"));

type Operator = FullMemory<f32, 16, MODES>;

/// Operator from flash: no logarithm, no gamma function, no double precision.
#[cfg(not(feature = "design-on-device"))]
fn operator() -> Option<Operator> {
    Operator::from_list(INTEGER, &COEFFICIENTS).ok()
}

/// This derivative, designed on the device, in closed form: a few more modes.
#[cfg(feature = "design-on-device")]
fn operator() -> Option<FullMemory<f32, 16, { MODES + 8 }>> {
    use fracdiff::full_memory::{Design, Kernel};
    use fracdiff::{Order, Seconds};
    let _ = (INTEGER, &COEFFICIENTS, Operator::from_list);
    let order = Order::new(black_box(0.2247)).ok()?;
    let design = Design::closed_form(Kernel::Grunwald, order, 1e-6, 2e5).ok()?;
    FullMemory::new(&design, Seconds(1e-3)).ok()
}

#[entry]
fn main() -> ! {
    let Some(operator) = operator() else { stop() };
    let mut history = operator.at_rest();
    // One tick after the other; a real device waits for its timer here.
    loop {
        // Stands for the sensor, and for the actuator.
        let position_m: f32 = black_box(1e-3);
        let force = operator.output(&history, position_m);
        black_box(force);
        operator.advance(&mut history, position_m);
    }
}

fn stop() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    stop()
}
