#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod configuration;
#[cfg(feature = "controllers")]
mod controller;
mod frame;
mod hand;
mod image;
mod in_order;
mod keys;
mod limits;
mod report;
mod request;
mod sample;
mod sequence;
mod serial_number;
#[cfg(feature = "several-axes")]
mod surface;

#[cfg(feature = "controllers")]
pub use configuration::{AxisWorkspace, WorkspaceBox};
pub use configuration::{
    COEFFICIENTS_PER_BLOCK, CoefficientBlock, Configuration, DigestBuilder, OperatorForm,
    OperatorShape, Simulation, SimulationKind, block_count, hand_digest,
};
#[cfg(feature = "controllers")]
pub use controller::{
    CONTROLLER_PARTS, ControllerCost, ControllerForm, ControllerLaw, ControllerPart,
};
pub use frame::{
    Direction, EncodeError, FRAME_MAX, FrameError, Header, LineCounters, PROTOCOL_VERSION,
    Receiver, encode,
};
pub use hand::{Architecture, HandHello, HandMessage, HandSample, HandSide, HandState};
pub use image::{IMAGE_MARK, image_digest};
pub use keys::{REPORT_KEYS, REQUEST_KEYS};
pub use limits::{Field, Guard, GuardKind, Limits, LoopMode};
pub use report::{
    Ack, Alive, Capabilities, Conduct, DeviceReport, Event, EventKind, FaultReport, Hello,
    KEYS_MAX, Keys, MEASURING_DAMPING_N_S_PER_M, MessageKey, Outcome, Reason, Refusal, State,
    Statistics, Status, Trouble,
};
pub use request::{Request, Scope, Start};
pub use sample::{
    AXES_MAX, BATCH_MAX, BatchItem, Flight, IMPOSSIBLE, NOT_TAKEN, SENSED_MAX, Sample, SampleBatch,
    UNANSWERED,
};
pub use sequence::{OutOfOrder, RequestTracker, SequenceTracker};
pub use serial_number::SerialNumber;
#[cfg(feature = "several-axes")]
pub use surface::{SurfaceKind, SurfaceShape};
