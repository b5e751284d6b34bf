//! Two hands over a line: a hand moves a master, a slave moves in a remote tissue or wall, and a bad line is between them.
//!
//! ```text
//! hand ─ k_h, b_h ─▶ master ─▶ port ─▶ line: delay, jitter, loss, duplication ─▶ port ─▶ slave ─▶ tissue or wall
//!                                  ◀─                                        ◀─
//! ```
//! - *The hand* moves its own end, `x_h` = press + Σ sines, and holds the master by a spring and a damper.
//! - *Devices, hand and environment* are stepped eight times a sample, the ports once.
//! - *Impedances*: over the window at the end, forces and places of both sides at each frequency of the motion; beside them
//!   the tissue's own and what the formula says is felt of it, see [`Teleoperation`](haptic_analysis::Teleoperation).
//! - *Energy*: what the line has given to both devices, Σ f·Δx; never above 0 with a passive architecture.
//!
//! The log has the hand as the reference, the master as the position, the slave as the indenter, the force on the slave's
//! environment as the contact force, and the energy taken by the line as the observed energy.

mod advice;
mod body;
mod conduct;
mod curves;
mod judge;
pub(crate) mod keys;
mod metadata;
mod pair;
mod place;
mod preflight;
pub(crate) mod reading;
mod report;
mod specification;
mod udp;

pub use curves::{SideCurves, TeleoperationCurves};
pub use pair::{PairSink, PairTick, SideTick};
pub use place::{PlaceName, RemotePlace};
pub use report::{FeltAt, LineCounts, TeleoperationReport, TeleoperationVerdict};
pub use specification::{ArchitectureName, HandModel, HandMotion, TeleoperationExperiment};
pub use udp::{End, FarEnd, FarReport, Terms};
