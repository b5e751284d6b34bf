//! Arguments of the live streams.

use crate::output::{Output, note};
use clap::Args;
use haptic_experiment::Failure;
use haptic_log::live::{Live, LiveStreams};
use std::net::SocketAddr;

/// Live viewers of a run.
#[derive(Clone, Copy, Debug, Args)]
pub struct LiveArguments {
    /// Stream the samples to Foxglove or PlotJuggler, at 127.0.0.1:8765 by default (feature `foxglove`)
    #[arg(long, hide_short_help = true, help_heading = "Run", value_name = "IP:PORT", value_parser = parse_address)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<SocketAddr>,
}

/// Reads an address.
fn parse_address(text: &str) -> Result<SocketAddr, String> {
    text.parse()
        .map_err(|_| "not an address: give IP:PORT, as in 127.0.0.1:8765 or [::1]:8765".to_owned())
}

impl LiveArguments {
    /// Opens the streams that were asked for, and says where.
    ///
    /// # Errors
    /// An address that is taken or not reachable; a build without Foxglove.
    pub fn open(self, realtime: bool, output: Output) -> Result<LiveStreams, Failure> {
        let mut streams: Vec<Box<dyn Live>> = Vec::new();
        if let Some(address) = self.foxglove {
            streams.push(open_foxglove(address, output)?);
        }
        if !streams.is_empty() && !realtime {
            note(
                "warning",
                "the live stream passes in a burst, as fast as the run is computed, and viewers may miss \
                 most of it: give --realtime to watch",
            );
        }
        Ok(LiveStreams::new(streams))
    }
}

#[cfg(feature = "foxglove")]
fn open_foxglove(address: SocketAddr, output: Output) -> Result<Box<dyn Live>, Failure> {
    let foxglove = haptic_log::live::Foxglove::open(address).map_err(|error| {
        Failure::input_with_advice(
            error,
            "close the program that has the port, or give another, as in --foxglove=127.0.0.1:0 for \
             a free one",
        )
    })?;
    if !output.quiet {
        note(
            "live stream",
            format_args!(
                "ws://{}, open it in Foxglove (Open connection) or PlotJuggler (Foxglove bridge)",
                foxglove.address()
            ),
        );
    }
    Ok(Box::new(foxglove))
}

#[cfg(not(feature = "foxglove"))]
fn open_foxglove(_: SocketAddr, _: Output) -> Result<Box<dyn Live>, Failure> {
    Err(Failure::bad_input(
        "--foxglove: this build has no Foxglove WebSocket; build it with --features foxglove",
    ))
}
