//! The live figures of a run on a terminal, from the log that it writes.
//!
//! ```text
//! another process: loop ─▶ log (NAME.mcap.part) ─▶ LogFollower ─▶ Figures ─▶ draw ─▶ terminal
//! ```
//! The run is left alone: it knows nothing of who looks. What is shown is as old as the open chunk of the log, 100 ms of
//! device time.

pub mod draw;
pub mod figures;
pub mod follow;
pub mod screen;
