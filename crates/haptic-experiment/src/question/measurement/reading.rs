//! `[measure]`: a device that is to move, and how far.

use crate::document::Document;
use crate::document::error::FileError;
use crate::document::parameters::DEVICE;
use crate::experiment::reading::{device, with_devices};
use crate::experiment::reading::{remote_by, without};
use crate::question::keys::SIMULATED;
use crate::question::measurement::MeasurePlan;
use crate::question::measurement::keys::{
    HELD, MEASURE_BOX, MEASURE_DEVICE, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME,
};
use crate::question::{MEASUREMENT, tables};
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
        let (kind, table, _) = document.experiment(&[MEASUREMENT], "")?;
        let table = with_devices(table.with_keys(&tables(kind))?)?;
        let remote = remote_by(&table, &MEASURE_DEVICE)?;
        if remote.is_some() {
            without(
                &table,
                SIMULATED,
                &format!(
                    "on a real device, which is measured: give {device_sim}",
                    device_sim = DEVICE.set_to("sim")
                ),
            )?;
        }
        let plan = MeasurePlan {
            sample_time_s: table.number(&MEASURE_SAMPLE_TIME)?,
            force_limit_n: table.number(&MEASURE_FORCE_LIMIT)?,
            box_m: table.number(&MEASURE_BOX)?,
            duration_s: table.number(&MEASURE_DURATION)?,
            hand: table.flag(&HELD)?,
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
