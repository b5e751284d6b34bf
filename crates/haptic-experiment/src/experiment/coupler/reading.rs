//! `[coupler]`: device, coupler, object and trial.

use crate::CouplerExperiment;
use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::reader::Table;
use crate::experiment::coupler::keys::{
    COUPLER_MUST_BE_STABLE, COUPLER_ORDER, OBJECT_DAMPING, OBJECT_MASS, OBJECT_STIFFNESS,
};
use crate::experiment::reading::{remote, scheme};
use crate::experiment::trial::reading::{setup, times};
use fracdiff::Order;
use haptic_analysis::CoupledObject;
use haptic_loop::deflection_order;

pub(crate) fn coupler(table: &Table<'_>) -> Result<CouplerExperiment, FileError> {
    let remote = remote(table)?;
    let (sample_time_s, duration_s) = times(table)?;
    let order = table.required(&COUPLER_ORDER)?;
    let wrong = |reason: String| table.fail_at("order", reason);
    let order = Order::new(order).map_err(|error| wrong(error.to_string()))?;
    let run = deflection_order(order).map_err(|error| wrong(error.to_string()))?;
    let mut setup = setup(table, remote, (sample_time_s, duration_s))?;
    setup.must_be_stable = table.flag(&COUPLER_MUST_BE_STABLE)?;
    let coupler = CouplerExperiment {
        setup,
        order,
        scheme: scheme(table, None, run, sample_time_s, duration_s)?,
        coupler_stiffness_n_s_per_m: table.required(&p::COUPLER_STIFFNESS)?,
        coupler_dissipation_n_s_1_minus_mu_per_m: table.required(&p::COUPLER_DISSIPATION)?,
        object: CoupledObject {
            mass_kg: table.number(&OBJECT_MASS)?,
            damping_n_s_per_m: table.number(&OBJECT_DAMPING)?,
            stiffness_n_per_m: table.number(&OBJECT_STIFFNESS)?,
        },
    };
    (coupler.check_loop()).map_err(|error| table.fail_at(p::LOOP.key, error.to_string()))?;
    coupler
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(coupler)
}
