//! The live loop: a loop whose law changes while it is held. The page and Python's sessions use it.
//!
//! ```text
//! orders ─ring─▶ loop, by the clock, in virtual time or by a device ─ring─▶ keeper ─▶ whoever watches
//!                  └─ old law ─fades─▶ new law that has heard the same positions
//! ```
//! - *Force*: between those of both laws while one fades into the other; a touch in which the law changed gives no more than it took, see
//!   [`Fading`]. Safety chain and limits are those of any run.
//! - *The thread that ticks* never waits for anybody and wakes nobody: what it needs comes through a ring, what it is done with goes
//!   through another to be freed.

mod by_clock;
mod keeper;
mod orders;
mod recording;
mod runner;
mod session;
#[cfg(test)]
mod tests;

mod waiting;

pub use by_clock::run;
pub use haptic_trial::in_hand::fading::{Fading, FadingHistory, Law};
pub use haptic_trial::in_hand::hand::{HAND_DAMPING, HAND_M, HAND_STIFFNESS, HeldDevice};
pub use haptic_trial::in_hand::law::{Felt, HORIZON, fading, refuse_unstable, rounded_down, ticks};
pub use haptic_trial::in_hand::place::Placed;
use haptic_trial::in_hand::ticking;
pub use haptic_trial::in_hand::ticking::{
    Around, FadingFelt, FromLoop, HandPath, LoopCounts, LoopEnds, LoopOrder, Stimulus, Ticked,
};
pub use keeper::{Keeper, Watch};
pub use orders::{Orders, locked};
pub use recording::{Finished, Recording};
pub use session::{FeltWall, Session, SessionOptions, SessionReport};
