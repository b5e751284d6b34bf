//! Time from a command to the answer of a moteus servo, stopped all the while: can a loop at 1 kHz be closed over it?
//!
//! ```text
//! cargo run --release -p haptic-devices --example moteus_round_trip -- /dev/ttyACM0 [ID] [COUNT]
//! ```

use haptic_remote::serial::open;
use moteus_protocol::command::StopCommand;
use moteus_protocol::fdcanusb::{EncodeOptions, MAX_LINE_LENGTH, encode_can_send};
use moteus_protocol::query::QueryFormat;
use moteus_protocol::{CanFdFrame, calculate_arbitration_id};
use std::error::Error;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

/// As long as a servo may take.
const PATIENCE: Duration = Duration::from_secs(1);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("give the path of a port")?;
    let id: i8 = arguments.next().map_or(Ok(1), |id| id.parse())?;
    let count: usize = arguments.next().map_or(Ok(5000), |count| count.parse())?;

    // The frame of a driver at rest: stop, and a query.
    let mut frame = CanFdFrame::new();
    frame.arbitration_id = calculate_arbitration_id(0, id, 0, true);
    StopCommand::serialize(&mut frame);
    QueryFormat::default().serialize(&mut frame);
    let options = EncodeOptions {
        checksum: true,
        ..EncodeOptions::default()
    };
    let mut line = [0; MAX_LINE_LENGTH];
    let length = encode_can_send(&frame, &options, &mut line).map_err(|_| "too long")?;

    let mut port = open(&path, 921_600)?;
    let mut times_us = Vec::with_capacity(count);
    for _ in 0..count {
        let sent = Instant::now();
        port.write_all(&line[..length])?;
        wait_for_answer(&mut port, sent)?;
        times_us.push(sent.elapsed().as_secs_f64() * 1e6);
        // At the pace of a loop.
        std::thread::sleep(Duration::from_millis(1).saturating_sub(sent.elapsed()));
    }
    times_us.sort_by(f64::total_cmp);
    let at = |share: f64| times_us[((count - 1) as f64 * share) as usize];
    println!(
        "{count} round trips: median {:.0} µs, 90 % {:.0} µs, 99 % {:.0} µs, longest {:.0} µs",
        at(0.5),
        at(0.9),
        at(0.99),
        at(1.0)
    );
    Ok(())
}

/// Reads until a whole line `rcv …` has come.
fn wait_for_answer(port: &mut impl Read, sent: Instant) -> Result<(), Box<dyn Error>> {
    let mut text = Vec::new();
    let mut bytes = [0; 256];
    while sent.elapsed() < PATIENCE {
        match port.read(&mut bytes) {
            Ok(count) => text.extend(&bytes[..count]),
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            Err(error) => return Err(error.into()),
        }
        let mut lines = text.split(|byte| *byte == b'\n');
        // What follows the last line end is no whole line.
        lines.next_back();
        if lines.any(|line| line.starts_with(b"rcv")) {
            return Ok(());
        }
    }
    Err("no answer within a second".into())
}
