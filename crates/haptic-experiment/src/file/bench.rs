//! The device of a question: its keys and the device file, where there are none the dissertation's.

use super::error::FileError;
use super::pushed::device;
use super::reader::Table;
use crate::design::Device;
use crate::parameters as p;

pub(super) fn bench(table: &Table<'_>) -> Result<Device, FileError> {
    let (plant, sensors) = device(table, table.number(&p::SAMPLE_TIME)?)?;
    Ok(Device {
        plant,
        sensors,
        force_limit_n: table.number(&p::TRIAL_FORCE_LIMIT)?,
    })
}
