//! `[wall]`: device, wall and trial.

use crate::WallExperiment;
use crate::document::error::FileError;
use crate::document::reader::Table;
use crate::experiment::reading::{remote, scheme};
use crate::experiment::trial::reading::{setup, times};
use crate::experiment::wall::keys::{DISSIPATION, MUST_BE_STABLE, ONE_SIDED, ORDER, STIFFNESS};
use fracdiff::Order;

pub(crate) fn wall(table: &Table<'_>) -> Result<WallExperiment, FileError> {
    let remote = remote(table)?;
    let (sample_time_s, duration_s) = times(table)?;
    let order = table.required(&ORDER)?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let mut setup = setup(table, remote, (sample_time_s, duration_s))?;
    setup.must_be_stable = table.flag(&MUST_BE_STABLE)?;
    let wall = WallExperiment {
        setup,
        order,
        model: None,
        scheme: scheme(table, None, order, sample_time_s, duration_s)?,
        stiffness_n_per_m: table.required(&STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.required(&DISSIPATION)?,
        one_sided: table.flag(&ONE_SIDED)?,
    };
    wall.check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(wall)
}
