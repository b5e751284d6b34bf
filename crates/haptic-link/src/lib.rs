#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

mod configuration;
mod frame;
mod report;
mod request;
mod sequence;

pub use configuration::{
    COEFFICIENTS_PER_BLOCK, Configuration, DigestBuilder, Field, Guard, GuardKind, Limits,
    LoopMode, OperatorForm, OperatorShape, Simulation, SimulationKind, block_count,
};
pub use frame::{
    Direction, EncodeError, FRAME_MAX, FrameError, LineCounters, PROTOCOL_VERSION, Receiver, encode,
};
pub use report::{
    Ack, Alive, BATCH_MAX, Batch, BatchItem, Capabilities, Event, EventKind, FaultReport, Flight,
    Hello, Outcome, Refusal, Report, Sample, State, Statistics, Status,
};
pub use request::{CoefficientBlock, Keys, Request, Start};
pub use sequence::{Arrival, SequenceTracker};
