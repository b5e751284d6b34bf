//! The service: its devices, its reports of them, and its commands.

use super::body::{Body, CENTRE_M};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Number of the grip.
const GRIP_ID: &str = "1102";
/// Silence after which a force ends, µs.
pub const SILENCE_US: u64 = 100_000;

/// Counts of the service since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counted {
    /// WebSocket connections that were made.
    pub sessions: u64,
    /// Messages, each with an answer.
    pub messages: u64,
    /// Commands of a force that were executed.
    pub forces: u64,
    /// Commands of a force that name no vector of three numbers: they are not executed.
    pub unreadable: u64,
    /// Norm of the largest force that was commanded, N.
    pub largest_n: f64,
}

#[derive(Clone, Debug)]
struct Unit {
    id: String,
    body: Body,
    force_n: Vector3<f64>,
    /// Until when the force lasts without another command.
    until_us: u64,
    /// The session that commanded it.
    by: u64,
    preset: String,
    damping: f64,
    gate: f64,
    calibrated: bool,
}

/// An Inverse Service without its socket. Time is an argument, µs.
#[derive(Clone, Debug)]
pub struct Service {
    version: String,
    units: Vec<Unit>,
    pub(super) counted: Counted,
}

impl Service {
    /// A service of a version with these devices. They have some damping, as another program may have left it.
    #[must_use]
    pub fn new(version: &str, devices: impl IntoIterator<Item = (String, Body)>) -> Self {
        let units = devices.into_iter().map(|(id, body)| Unit {
            id,
            body,
            force_n: Vector3::zeros(),
            until_us: 0,
            by: 0,
            preset: "defaults".to_owned(),
            damping: 5.0,
            gate: 0.3,
            calibrated: true,
        });
        Self {
            version: version.to_owned(),
            units: units.collect(),
            counted: Counted::default(),
        }
    }

    /// Counts since it was started.
    #[must_use]
    pub const fn counted(&self) -> Counted {
        self.counted
    }

    /// Unplugs a device: it is no longer reported.
    pub fn unplug(&mut self, id: &str) {
        self.units.retain(|unit| unit.id != id);
    }

    /// The device has forgotten where its encoders count from.
    pub fn forget_calibration(&mut self, id: &str) {
        let unit = self.units.iter_mut().find(|unit| unit.id == id);
        unit.into_iter().for_each(|unit| unit.calibrated = false);
    }

    /// The body of a device, to lead it.
    pub fn body(&mut self, id: &str) -> Option<&mut Body> {
        let unit = self.units.iter_mut().find(|unit| unit.id == id)?;
        Some(&mut unit.body)
    }

    /// Place of the first device, m from the middle of its workspace, and the force on it, N.
    #[must_use]
    pub fn first(&self) -> Option<([f64; 3], [f64; 3])> {
        let unit = self.units.first()?;
        Some((unit.body.place_m.into(), unit.force_n.into()))
    }

    pub(super) fn end_session(&mut self, session: u64) {
        for unit in self.units.iter_mut().filter(|unit| unit.by == session) {
            unit.force_n = Vector3::zeros();
        }
    }

    /// Lets time pass up to this moment.
    pub fn advance(&mut self, now_us: u64) {
        for unit in &mut self.units {
            if now_us >= unit.until_us {
                unit.force_n = Vector3::zeros();
            }
            (unit.body).advance(now_us as f64 * 1e-6, unit.force_n, unit.damping);
        }
    }

    /// The answer to a GET; `None` for a page that it does not have.
    pub(super) fn page(&self, path: &str) -> Option<Value> {
        let tag = self.version.as_str();
        match path {
            "/version" => Some(json!({
                "build_time": "2026-01-01T00:00:00Z", "git_branch": "main", "git_describe": tag, "git_hash": "0",
                "git_tag": tag, "project_name": "emulated-inverse-service", "project_version": tag,
            })),
            "/devices" => Some(self.state(0, true)),
            _ => None,
        }
    }

    /// Works on a message of a session; its answer.
    pub(super) fn take(&mut self, session: u64, message: &str, now_us: u64) -> Value {
        self.counted.messages += 1;
        // It ignores what it does not know, and answers each message once.
        let message: Value = serde_json::from_str(message).unwrap_or_default();
        for asked in message["inverse3"].as_array().into_iter().flatten() {
            let unit = self.units.iter_mut();
            if let Some(unit) = unit.into_iter().find(|unit| asked["device_id"] == unit.id) {
                unit.configure(&asked["configure"]);
                let command = &asked["commands"]["set_cursor_force"];
                if command["execute"] != false && !command.is_null() {
                    let Some(force_n) = force(command) else {
                        self.counted.unreadable += 1;
                        continue;
                    };
                    unit.body.begin();
                    unit.force_n = force_n;
                    (unit.until_us, unit.by) = (now_us + SILENCE_US, session);
                    self.counted.forces += 1;
                    let largest_n = &mut self.counted.largest_n;
                    *largest_n = largest_n.max(unit.force_n.norm());
                }
            }
        }
        let full = message["session"]["force_render_full_state"].is_object();
        self.state(session, full)
    }

    /// All devices, with their configuration if it is to be full.
    pub(super) fn state(&self, session: u64, full: bool) -> Value {
        let units = self.units.iter().map(|unit| unit.state(full));
        let units: Vec<Value> = units.collect();
        json!({"session_id": session, "inverse3": units, "wireless_verse_grip": [grip(full)]})
    }
}

impl Unit {
    fn configure(&mut self, asked: &Value) {
        if let Some(preset) = asked["preset"]["preset"].as_str() {
            preset.clone_into(&mut self.preset);
        }
        let number = |name: &str, key: &str| asked[name][key].as_f64();
        self.damping = number("damping", "scalar").unwrap_or(self.damping);
        self.gate = number("force_gate", "gain").unwrap_or(self.gate);
    }

    fn state(&self, full: bool) -> Value {
        let base = if self.preset.ends_with("_centered") {
            Vector3::zeros()
        } else {
            CENTRE_M.into()
        };
        let none = json!({"a0": 0.0, "a1": 0.0, "a2": 0.0});
        let mut message = json!({
            "device_id": self.id,
            "state": {
                "cursor_position": xyz(self.body.place_m + base),
                "cursor_velocity": xyz(self.body.speed_m_per_s),
                "angular_position": none, "angular_velocity": none, "body_orientation": still(),
                "current_cursor_force": xyz(self.force_n),
                "mode": "idle", "control_domain": "cartesian", "control_mode": "force", "transform": transform(),
            },
            "status": {
                "calibrated": self.calibrated, "in_use": true, "power_supply": true, "ready": true, "started": true,
            },
        });
        if full {
            message["config"] = json!({
                "type": "inverse3", "port": "emulated", "preset": self.preset, "basis": {"permutation": "XYZ"},
                "device_info": {"id": self.id, "major_version": 7, "minor_version": 4, "device_type": 4, "uuid": self.id},
                "extended_device_id": self.id, "extended_firmware_version": "emulated", "handedness": "right",
                "gravity_compensation": {"enabled": true, "scaling_factor": 1.0}, "torque_scaling": {"enabled": true},
                "filters": {"force_gate": {"gain": self.gate}, "damping": {"scalar": self.damping}},
            });
        }
        message
    }
}

/// Vector in single precision, as the service sends it.
fn xyz(vector: Vector3<f64>) -> Value {
    let [x, y, z] = vector.map(|axis| axis as f32).into();
    json!({"x": x, "y": y, "z": z})
}

/// The orientation of a grip at rest.
fn still() -> Value {
    json!({"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0})
}

/// The default transform of a service.
fn transform() -> Value {
    json!({"position": xyz(Vector3::zeros()), "rotation": still(), "scale": xyz(Vector3::repeat(1.0))})
}

/// The force that a command asks for, N: as `vector` since 3.5, and as `values` in the messages before, which programs still send.
fn force(command: &Value) -> Option<Vector3<f64>> {
    let asked = command.get("vector").or_else(|| command.get("values"))?;
    let axis = |name: &str| asked[name].as_f64();
    Some(Vector3::new(axis("x")?, axis("y")?, axis("z")?))
}

/// A grip that points along the third axis, with no button pressed.
fn grip(full: bool) -> Value {
    let mut message = json!({
        "device_id": GRIP_ID,
        "state": {
            "battery_level": 1.0, "battery_voltage": 4.1, "hall": 16, "orientation": still(),
            "buttons": {"a": false, "b": false, "c": false}, "transform": transform(),
        },
        "status": {"awake": true, "connected": true, "ready": true},
    });
    if full {
        message["config"] = json!({
            "type": "wireless_verse_grip", "port": "emulated", "major_version": 0, "minor_version": 0,
            "hardware_version": 0, "streaming_mode": "Radio", "basis": {"permutation": "XYZ"},
        });
    }
    message
}
