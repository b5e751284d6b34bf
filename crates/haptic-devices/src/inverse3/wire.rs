//! The messages of a tick: a force as text, and a position from it.
//!
//! *Cost*: one pass over the answer. What is asked for is borrowed from it; what is not is skipped.

use super::trouble::{DEVICES_MOST, Inverse3Trouble};
use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Room for a force beyond the text around it: three numbers of single precision.
const NUMBERS: usize = 192;

#[derive(Deserialize)]
struct Answer<'a> {
    #[serde(borrow)]
    inverse3: heapless::Vec<DeviceEntry<'a>, DEVICES_MOST>,
}

#[derive(Deserialize)]
struct DeviceEntry<'a> {
    device_id: &'a str,
    state: Option<State>,
}

#[derive(Deserialize)]
struct State {
    cursor_position: Option<Place>,
}

#[derive(Deserialize)]
struct Place {
    x: Option<f64>,
    y: Option<f64>,
    z: Option<f64>,
}

/// Position of a device in an answer, m.
pub(super) fn position(text: &str, id: &str) -> Result<Vector3<f64>, Inverse3Trouble> {
    let answer: Answer<'_> = serde_json::from_str(text).map_err(|_| Inverse3Trouble::Unreadable)?;
    let mut devices = answer.inverse3.iter();
    let device = devices.find(|device| device.device_id == id);
    let state = device.ok_or(Inverse3Trouble::Vanished)?.state.as_ref();
    let place = state.and_then(|state| state.cursor_position.as_ref());
    let place = place.and_then(|Place { x, y, z }| Some(Vector3::new((*x)?, (*y)?, (*z)?)));
    let place = place.filter(|place| place.iter().all(|axis| axis.is_finite()));
    place.ok_or(Inverse3Trouble::NoPosition)
}

/// Beginning of a request for a force, up to the number of x.
pub(super) fn before_force(id: &str) -> String {
    let id = Value::from(id);
    format!(r#"{{"inverse3":[{{"device_id":{id},"commands":{{"set_cursor_force":{{"vector":{{"x":"#)
}

/// Asks for a force, N.
pub(super) fn force(before: &str, force_n: Vector3<f32>) -> String {
    let mut text = String::with_capacity(before.len() + NUMBERS);
    text.push_str(before);
    let [x, y, z] = force_n.into();
    // A string takes whatever is written to it.
    let _ = write!(text, r#"{x},"y":{y},"z":{z}}}}}}}}}]}}"#);
    text
}

/// The place from which positions count, and the damping of the service.
pub(super) const PRESET: &str = "arm_front_centered";

/// Asks for this place, no damping and no force, under the name of this program, and for a full answer.
pub(super) fn opening(id: &str) -> String {
    let zero = json!({"x": 0.0, "y": 0.0, "z": 0.0});
    json!({
        "session": {
            "configure": {"profile": {"name": "fractional-haptics", "required_version": ">=3.5"}},
            "force_render_full_state": {},
        },
        "inverse3": [{
            "device_id": id,
            "configure": {"preset": {"preset": PRESET}, "damping": {"scalar": 0.0, "vector": zero}},
            "commands": {"set_cursor_force": {"vector": zero}},
        }],
    })
    .to_string()
}
