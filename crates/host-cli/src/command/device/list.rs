//! `device list`.

use crate::output::{Output, note};
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
    /// Ask what is at each port; opening a port resets some foreign boards
    #[arg(long)]
    probe: bool,
    /// Baud rate to ask at [default: 460800, then 921600]
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
    /// Vendor and product, as `lsusb` writes them.
    usb: Option<String>,
    usb_vendor_id: Option<u16>,
    usb_product_id: Option<u16>,
    latency_ms: Option<u32>,
    /// Board of the device there; null without `--probe`.
    board: Option<String>,
    firmware: Option<String>,
    /// Why no device answered.
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
                usb: port
                    .usb
                    .map(|(vendor, product)| format!("{vendor:04x}:{product:04x}")),
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
        if listed.ports.is_empty() {
            note(
                "ports",
                "none: plug in a device, or emulate one with host-cli device emulate",
            );
        }
        output.report(&listed)
    }
}
