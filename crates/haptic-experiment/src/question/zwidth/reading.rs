//! `[zwidth]`.

use super::ZWidth;
use super::keys::{ZWIDTH_ORDERS, ZWIDTH_POINTS};
use crate::document::error::FileError;
use crate::document::parameters::{DEVICE, LESS_THAN_IDEAL, TRIAL_DURATION};
use crate::document::reader::Table;
use crate::experiment::reading::{remote, samples_fit, without};
use crate::experiment::trial::IMPACT;
use crate::experiment::trial::TRIAL_SAMPLES;
use crate::experiment::trial::plan;
use crate::experiment::wall::ONE_SIDED;
use crate::question::reading::{bench, orders, scheme};
use crate::run::imperfections::Imperfections;

pub(crate) fn zwidth(table: &Table<'_>) -> Result<ZWidth, FileError> {
    let remote = remote(table)?;
    if remote.is_some() {
        // It has its own, whatever its file says of them.
        let own = LESS_THAN_IDEAL.iter().chain([&IMPACT]);
        without(
            table,
            own,
            &format!(
                "on a real device, which has its own and cannot be thrown: give {device_sim}",
                device_sim = DEVICE.set_to("sim")
            ),
        )?;
    }
    let mut bench = bench(table)?;
    if remote.is_some() {
        bench.plant = Imperfections::NONE.on(bench.plant);
        bench.sensors = Imperfections::NONE.sensors;
    }
    let sample_time_s = bench.plant.sample_time.0;
    let duration_s = table.number(&TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let zwidth = ZWidth {
        device: bench.plant,
        sensors: bench.sensors,
        one_sided: table.flag(&ONE_SIDED)?,
        scheme: scheme(table)?,
        orders: orders(table, &ZWIDTH_ORDERS)?,
        points: usize::try_from(table.count(&ZWIDTH_POINTS)?).unwrap_or(usize::MAX),
        plan: plan(table, duration_s)?,
        remote,
    };
    zwidth
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(zwidth)
}
