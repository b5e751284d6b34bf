//! Boards of a haptic device: drivers, interrupts. All that does not depend on the board is `haptic_board`.
//!
//! ```text
//! tick interrupt:   haptic_board::Ticker ─▶ TickSide::tick ─▶ hardware.read ─▶ force ─▶ safety chain ─▶ hardware.write
//! UART interrupts:  received bytes ─▶ queue          queue ─▶ sent bytes
//! main loop:        queue ─▶ DeviceSession ─▶ queue;  watchdog, fed if ticks come;  sleep
//! ```
//! The loop, its states and the conversation with the host are `haptic_remote`: no control law here.
//!
//! - *Priorities*: the tick's above the UART's; the main loop has none. What tick and main loop share is
//!   lent by a critical section, a few microseconds at a time.
//! - *Zero force* from reset: a board's pins are neutral and its amplifier disabled until a run begins.
#![no_std]

#[cfg(not(any(feature = "board-mps2", feature = "board-nucleo-f446re")))]
compile_error!(
    "no board is chosen: build with `--features board-mps2` or `--features board-nucleo-f446re`"
);
#[cfg(all(feature = "board-mps2", feature = "board-nucleo-f446re"))]
compile_error!(
    "two boards are chosen: add `--no-default-features` to the one that is not the default"
);

mod board;
#[cfg(feature = "board-mps2")]
pub mod mps2;
mod serve;
#[cfg(feature = "board-nucleo-f446re")]
pub mod stm32f4;

pub use serve::{RETAINED, serve};

#[cfg(feature = "board-mps2")]
pub use mps2 as chip;
#[cfg(all(feature = "board-nucleo-f446re", not(feature = "board-mps2")))]
pub use stm32f4 as chip;
