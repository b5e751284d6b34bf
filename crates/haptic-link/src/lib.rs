#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod answer;
mod bytes;
mod coefficients;
mod configuration;
mod current_keys;
mod digest;
mod field;
mod frame;
mod hand;
mod identity;
mod in_order;
mod keys;
mod limits;
mod loop_mode;
mod report;
mod request;
mod sample;
mod sequence;
mod simulation;
mod statistics;
mod status;
mod tightened;
#[cfg(feature = "several-axes")]
mod workspace;

pub use answer::{Ack, Outcome, Refusal};
pub use coefficients::{
    COEFFICIENTS_PER_BLOCK, CoefficientBlock, OperatorForm, OperatorShape, block_count,
};
pub use configuration::Configuration;
pub use current_keys::{REPORT_KEYS, REQUEST_KEYS};
pub use digest::{DigestBuilder, hand_digest};
pub use field::Field;
pub use frame::{
    Direction, EncodeError, FRAME_MAX, FrameError, Header, LineCounters, PROTOCOL_VERSION,
    Receiver, encode,
};
pub use hand::{Architecture, HandHello, HandMessage, HandSample, HandSide, HandState};
pub use identity::{Capabilities, Hello};
pub use keys::{KEYS_MAX, Keys, MessageKey};
pub use limits::{Guard, GuardKind, Limits};
pub use loop_mode::LoopMode;
pub use report::Report;
pub use request::{Request, Scope, Start};
pub use sample::{
    AXES_MAX, BATCH_MAX, Batch, BatchItem, Flight, IMPOSSIBLE, NOT_TAKEN, Sample, UNANSWERED,
};
pub use sequence::{Arrival, OutOfOrder, RequestTracker, SequenceTracker};
pub use simulation::{Simulation, SimulationKind};
pub use statistics::Statistics;
pub use status::{Alive, Event, EventKind, FaultReport, State, Status};
#[cfg(feature = "several-axes")]
pub use workspace::{AxisWorkspace, WorkspaceBox};
