//! What the readings of all questions share.

use super::design::Device;
use crate::document::error::FileError;
use crate::document::parameters::{Parameter, SAMPLE_TIME, SCHEME};
use crate::document::reader::Table;
use crate::experiment::reading::device;
use crate::experiment::trial::TRIAL_FORCE_LIMIT;
use fracdiff::{Order, Scheme};

pub(super) fn bench(table: &Table<'_>) -> Result<Device, FileError> {
    let (plant, sensors) = device(table, table.number(&SAMPLE_TIME)?)?;
    Ok(Device {
        plant,
        sensors,
        force_limit_n: table.number(&TRIAL_FORCE_LIMIT)?,
    })
}

pub(super) fn scheme(table: &Table<'_>) -> Result<Scheme, FileError> {
    let parsed = table.text(&SCHEME)?.parse();
    let fail = |error: String| table.fail_at(SCHEME.key, error);
    match parsed.map_err(|error: fracdiff::SchemeError| fail(error.to_string()))? {
        Scheme::Exact => Err(fail(fracdiff::SchemeError::AnalysisOnly.to_string())),
        scheme => Ok(scheme),
    }
}

/// Orders of walls.
pub(super) fn orders(table: &Table<'_>, parameter: &Parameter) -> Result<Vec<Order>, FileError> {
    let given = table.numbers_if(parameter)?;
    let numbers = given.unwrap_or_else(|| parameter.default_numbers());
    let order = |mu: f64| {
        let order = Order::new(mu).ok().filter(|_| (0.0..=2.0).contains(&mu));
        order.ok_or_else(|| {
            let reason = format!("orders has {mu}, which is not in [0, 2]: change it");
            table.fail_at(parameter.key, reason)
        })
    };
    numbers.into_iter().map(order).collect()
}
