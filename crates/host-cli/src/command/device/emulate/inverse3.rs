//! The Inverse Service of `--kind inverse3`, at a port of this machine.

use crate::command::device::key_value::in_range;
use crate::output::{Output, note};
use haptic_devices::inverse3::Inverse3Name;
use haptic_emulator::inverse3::{Body, Hand, Service, serve};
use haptic_experiment::{Failure, parameters};
use serde_json::json;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Keys of an emulated Inverse Service.
pub(super) const KEYS: [(&str, &str); 2] = [
    (
        "service_port",
        "Inverse3: port of this machine, 0 for any free one [default: 10001]",
    ),
    (
        "cursor",
        "Inverse3: its hand: strokes (downwards, the default), free, or at:X:Y:Z",
    ),
];

/// Number of the device at its service.
const ID: &str = "04BA";

/// The version that it reports.
const VERSION: &str = "3.5.0";

/// The hand of a device.
pub(super) fn hand(text: &str) -> Result<Hand, String> {
    const KNOWN: &str = "is not a hand: give strokes, free or at:X:Y:Z, as in at:0mm:20mm:-10mm";
    if let Some(place) = text.strip_prefix("at:") {
        let lengths = place
            .split(':')
            .map(|length| in_range("place_m", parameters::PRESS.range(), length));
        let lengths = lengths.collect::<Result<Vec<f64>, String>>()?;
        let place: [f64; 3] = lengths.try_into().map_err(|_| KNOWN)?;
        return Ok(Hand::At(place));
    }
    match text {
        "strokes" => Ok(Hand::Strokes),
        "free" => Ok(Hand::Free),
        _ => Err(KNOWN.to_owned()),
    }
}

/// Serves until it is stopped or its time is over.
pub(super) fn run(
    service_port: Option<u16>,
    cursor: Hand,
    duration: Option<Duration>,
    output: Output,
    stop: &AtomicBool,
) -> Result<(), Failure> {
    let port = service_port.unwrap_or(Inverse3Name::PORT);
    let failed = |error| {
        Failure::bad_input(format_args!(
            "the service_port {port} cannot be served: {error}; choose another, or 0 for any free one"
        ))
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?.to_string();
    let device = format!("{}:{address}", Inverse3Name::KIND);
    output.report(&json!({"path": address, "device": device}))?;
    let devices = [(ID.to_owned(), Body::held_by(cursor))];
    let service = Arc::new(Mutex::new(Service::new(VERSION, devices)));
    serve(&listener, &service, duration, stop).map_err(failed)?;
    if !output.quiet {
        let service = service.lock().unwrap_or_else(PoisonError::into_inner);
        note("emulated", words(&service));
    }
    Ok(())
}

fn words(service: &Service) -> String {
    let counted = service.counted();
    let (place_m, force_n) = service.first().unwrap_or_default();
    let [x, y, z] = place_m.map(|axis| 1e3 * axis);
    let [f_x, f_y, f_z] = force_n;
    let unreadable = match counted.unreadable {
        0 => String::new(),
        many => format!(" ({many} more had neither vector nor values of three numbers: no force)"),
    };
    format!(
        "{} sessions, {} messages, {} forces{unreadable}; cursor at {x:.3} mm, {y:.3} mm, {z:.3} mm; force {f_x:.6} N, {f_y:.6} N, \
         {f_z:.6} N, largest {:.6} N",
        counted.sessions, counted.messages, counted.forces, counted.largest_n
    )
}
