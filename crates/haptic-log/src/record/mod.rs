//! The run log: one MCAP file per run, written as the run goes.
//!
//! ```text
//! loop ──TickMessage──▶ LogWriter ──▶ run.mcap.part ──finish──▶ run.mcap
//!                                          │ killed, disk full       │
//!                                          ▼                         ▼
//!                                       recover ──▶ new log     LogReader ──▶ inspect, export
//! ```
//!
//! A log holds topics and any number of metadata records:
//!
//! | topic | type | one message per |
//! |---|---|---|
//! | `/haptics/tick` | `haptics_msgs/msg/Tick`; `Tick2` and `Tick3` of two and three axes | control tick |
//! | `/haptics/drive` | `haptics_msgs/msg/Tick` | tick of a second device that moves the first, by the clock of the first |
//! | `/haptics/event` | `haptics_msgs/msg/Event` | thing worth a sentence |
//!
//! Messages are CDR with `ros2msg` schemas under the profile `ros2`, so Foxglove, PlotJuggler
//! and the ROS 2 bag tools plot them without a plug-in. Log time and publish time are the wall-clock start
//! of the run ([`StartTime`], metadata `clock`) plus the *device's* time, in ns since 1970; the device's time
//! alone is in the message, and the sequence number is the tick. Every 100 ms of device time a chunk is
//! closed and handed to the operating system: a process that dies loses at most that much, and beyond 1.8 h at most
//! a 32 768th of the time so far.
//!
//! Every [`SYNC_INTERVAL`] a thread of its own brings what was handed over to the disk: a power failure
//! costs that much, one chunk, and as long as the disk takes. No topics but these survive [`recover()`].

mod append;
mod error;
mod export;
mod failure;
mod lines;
mod new_file;
mod order;
mod reader;
mod recover;
mod roll;
mod span;
mod start_time;
mod summary;
mod sync;
mod topic;
mod topics;
mod writer;

pub use append::{VERDICT, add_verdict};
pub use error::RecordError;
pub use export::{ExportSummary, export_csv, export_csv_to};
pub use lines::LineFile;
pub use new_file::{
    Leftover, NewFile, NewFileError, leftover_at, part_of, refuse_taken, remove_earlier,
};
pub use reader::{ATTACHMENTS, Condition, Damage, Entry, LogReader};
pub use recover::{CUT, RecoverySummary, cut, recover};
pub use roll::{CONTINUES, LogFiles, NEXT, ROLL_LEAST, RollingLog, first_file, nth_file};
pub use span::{SAME_TIME, Span, SpanError};
pub use start_time::{CLOCK, StartTime};
pub use summary::{BUDGET, Gap, LogSummary, RECOVERED, Skimmed, inspect, skim};
pub use sync::SYNC_INTERVAL;
pub use topic::Topic;
pub use writer::{FinishedLog, LogWriter};
