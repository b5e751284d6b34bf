//! An emulated Haply 2DIY: its board, its arms and a hand.

mod board;
mod body;

pub use board::{Board, Counted};
pub use body::{Body, Hand};
