//! An emulated Haply 2DIY: its board, its arms and a hand.

mod board;
mod body;
mod emulation;

pub use board::{Board, Counted};
pub use body::{Body, Hand};
pub use emulation::{Emulated, emulate};
