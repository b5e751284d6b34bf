//! `[measure]`: a device that is to move, and how far.

use crate::document::Document;
use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::parameters::DEVICE;
use crate::experiment::reading::{remote_by, without};
use crate::experiment::trial::reading::{device, with_devices};
use crate::question::measurement::MeasurePlan;
use crate::run::remote::RemoteDevice;
use crate::run::sensors::Sensors;
use haptic_loop::plant::MassDamperConfig;

/// A measurement of a device, all of its parameters checked.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// How it moves.
    pub plan: MeasurePlan,
    /// The device at a port; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// The simulated one.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
}

impl Measurement {
    /// Reads and checks a document.
    ///
    /// # Errors
    /// If it is wrong: in one line, with its place.
    pub fn open(document: &Document) -> Result<Self, FileError> {
        let document = document.parse()?;
        let (kind, table, _) = document.experiment(&[p::MEASUREMENT], "")?;
        let table = with_devices(table.with_keys(&p::of_kind(kind))?)?;
        let remote = remote_by(&table, &p::MEASURE_DEVICE)?;
        if remote.is_some() {
            without(
                &table,
                p::SIMULATED,
                &format!(
                    "on a real device, which is measured: give {device_sim}",
                    device_sim = DEVICE.set_to("sim")
                ),
            )?;
        }
        let plan = MeasurePlan {
            sample_time_s: table.number(&p::MEASURE_SAMPLE_TIME)?,
            force_limit_n: table.number(&p::MEASURE_FORCE_LIMIT)?,
            box_m: table.number(&p::MEASURE_BOX)?,
            duration_s: table.number(&p::MEASURE_DURATION)?,
            hand: table.flag(&p::HELD)?,
        };
        let (device, sensors) = device(&table, plan.sample_time_s)?;
        Ok(Self {
            plan,
            remote,
            device,
            sensors,
        })
    }
}
