//! `device list`.

use crate::output::Output;
use crate::whole::whole;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::device::firmware_version;
use haptic_remote::serial::{ConnectOptions, SerialLink, ports};
use serde::Serialize;

/// Arguments of `device list`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli device list --probe")]
pub struct Arguments {
    /// Greet whatever is at each port; opening a port resets some boards that are no devices of ours
    #[arg(long)]
    probe: bool,
    /// Speed at which to greet [default: 460800 and 921600 in turn]
    #[arg(long, value_name = "BAUD", value_parser = whole::<u32>(1200..=12_000_000))]
    baud: Option<u32>,
}

#[derive(Serialize)]
struct Listed {
    ports: Vec<Port>,
}

#[derive(Serialize)]
struct Port {
    path: String,
    description: String,
    usb_vendor_id: Option<u16>,
    usb_product_id: Option<u16>,
    latency_ms: Option<u32>,
    /// Board of the device there; null if nobody was asked.
    board: Option<String>,
    firmware: Option<String>,
    /// Why there is no device of ours.
    problem: Option<String>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A standard output that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let options = ConnectOptions {
            baud: self.baud,
            ..ConnectOptions::default()
        };
        let listed = ports().into_iter().map(|port| {
            let link = self.probe.then(|| SerialLink::connect(&port.path, options));
            let (board, firmware, problem) = match link {
                Some(Ok(link)) => {
                    let board = link.capabilities().board().to_owned();
                    (Some(board), Some(firmware_version(link.hello())), None)
                }
                Some(Err(error)) => (None, None, Some(error.to_string())),
                None => (None, None, None),
            };
            Port {
                path: port.path,
                description: port.description,
                usb_vendor_id: port.usb.map(|(vendor, _)| vendor),
                usb_product_id: port.usb.map(|(_, product)| product),
                latency_ms: port.latency_ms,
                board,
                firmware,
                problem,
            }
        });
        let listed = Listed {
            ports: listed.collect(),
        };
        output.print(&listed, |out| {
            if listed.ports.is_empty() {
                return writeln!(
                    out,
                    "no serial port: plug a device in, or imitate one with host-cli device emulate"
                );
            }
            for port in &listed.ports {
                write!(out, "{:<20} {}", port.path, port.description)?;
                if let (Some(vendor), Some(product)) = (port.usb_vendor_id, port.usb_product_id) {
                    write!(out, " ({vendor:04x}:{product:04x})")?;
                }
                if let (Some(board), Some(firmware)) = (&port.board, &port.firmware) {
                    write!(out, ", board {board}, firmware {firmware}")?;
                }
                if let Some(problem) = &port.problem {
                    write!(out, ", no device of ours: {problem}")?;
                }
                writeln!(out)?;
            }
            Ok(())
        })
    }
}
