//! Options of the server.

use crate::OnClose;
use crate::feel::DeviceNumbers;
use haptic_experiment::{Imperfections, RealtimeOptions};
use haptic_tissue::Library;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Options of the server.
#[derive(Clone, Debug)]
pub struct ServerOptions {
    /// The port; 0 for any that is free.
    pub port: u16,
    /// Folder of the runs, made when the first is recorded.
    pub runs: PathBuf,
    /// What happens to a loop or run when the page that controls it is closed.
    pub on_close: OnClose,
    /// For the thread of the loop.
    pub realtime: RealtimeOptions,
    /// The tissues that can be felt.
    pub library: Library,
    /// The simulated device where a page asks for none.
    pub device: DeviceNumbers,
    /// Its friction, delay, lag and sensors, whatever mass and damping a page asks for.
    pub imperfections: Imperfections,
    /// Maker of the logs, for their metadata: program, command line.
    pub provenance: BTreeMap<String, String>,
}
