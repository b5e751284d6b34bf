#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

mod configuration;
mod frame;
mod keys;
mod report;
mod request;
mod sequence;
mod tightened;

pub use configuration::{
    COEFFICIENTS_PER_BLOCK, Configuration, DigestBuilder, Field, Guard, GuardKind, Limits,
    LoopMode, OperatorForm, OperatorShape, Simulation, SimulationKind, block_count,
};
pub use frame::{
    Direction, EncodeError, FRAME_MAX, FrameError, Header, LineCounters, PROTOCOL_VERSION,
    Receiver, encode, greet_version_1,
};
pub use keys::{KEYS_MAX, Keys, MessageKey, REPORT_KEYS, REQUEST_KEYS};
pub use report::{
    Ack, Alive, BATCH_MAX, Batch, BatchItem, Capabilities, Event, EventKind, FaultReport, Flight,
    Hello, Outcome, Refusal, Report, Sample, State, Statistics, Status,
};
pub use request::{CoefficientBlock, Request, Scope, Start};
pub use sequence::{Arrival, RequestTracker, SequenceTracker};
