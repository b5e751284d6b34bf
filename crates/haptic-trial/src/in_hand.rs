//! A law that begins whole in a hand, becomes another without a bump, and may change its place.

pub mod fading;
pub mod hand;
pub mod law;
pub mod place;
