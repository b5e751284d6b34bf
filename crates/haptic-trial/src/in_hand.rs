//! A law in a hand: it starts at full stiffness, can be exchanged without a jump, and can change its place.

pub mod fading;
pub mod hand;
pub mod law;
pub mod place;
pub mod running;
pub mod ticking;
