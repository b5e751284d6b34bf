//! `[wall]`: device, wall and trial.

use crate::WallExperiment;
use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::reader::Table;
use crate::experiment::reading::{remote, scheme};
use crate::experiment::trial::reading::{setup, times};
use fracdiff::Order;

pub(crate) fn wall(table: &Table<'_>) -> Result<WallExperiment, FileError> {
    let remote = remote(table)?;
    let (sample_time_s, duration_s) = times(table)?;
    let order = table.required(&p::ORDER)?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let mut setup = setup(table, remote, (sample_time_s, duration_s))?;
    setup.must_be_stable = table.flag(&p::MUST_BE_STABLE)?;
    let wall = WallExperiment {
        setup,
        order,
        model: None,
        scheme: scheme(table, None, order, sample_time_s, duration_s)?,
        stiffness_n_per_m: table.required(&p::STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.required(&p::DISSIPATION)?,
        one_sided: table.flag(&p::ONE_SIDED)?,
    };
    wall.check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(wall)
}
