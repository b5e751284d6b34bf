//! `[wall]`: device, wall and trial.

use super::device::{remote, scheme, sensors};
use super::pushed::{device, plan, times};
use super::reader::{FileError, Table};
use super::safety::safety;
use crate::schedule::Pace;
use crate::{WallExperiment, parameters as p};
use fracdiff::Order;

pub(super) fn wall(table: &Table<'_>) -> Result<WallExperiment, FileError> {
    let remote = remote(table)?;
    let (sample_time_s, duration_s) = times(table)?;
    let order = table.required(&p::ORDER)?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let device = device(table, sample_time_s)?;
    let plan = plan(table, duration_s)?;
    let wall = WallExperiment {
        device,
        sensors: sensors(table)?,
        order,
        model: None,
        scheme: scheme(table, None, order, sample_time_s, duration_s)?,
        stiffness_n_per_m: table.required(&p::STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.required(&p::DISSIPATION)?,
        one_sided: table.flag(&p::ONE_SIDED)?,
        plan,
        must_be_stable: table.flag(&p::MUST_BE_STABLE)?,
        force_rate_limit_n_per_s: table.number_if(&p::TRIAL_FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote,
        force_unstable: false,
    };
    wall.check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(wall)
}
