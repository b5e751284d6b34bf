//! Keys of every table: the safety chain.

use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::reader::Table;
use crate::run::safety::Safety;

/// Reads the further settings of the safety chain. A wall knows mass and damping of its device by other keys too.
pub(crate) fn safety(table: &Table<'_>) -> Result<Safety, FileError> {
    let low = table.number_if(&p::WORKSPACE_LOW)?;
    let high = table.number_if(&p::WORKSPACE_HIGH)?;
    let workspace_m = match (low, high) {
        (None, None) => None,
        (Some(low), Some(high)) if low < high => Some((low, high)),
        (Some(low), Some(high)) => {
            let reason = format!("workspace_high_m = {high} is not above workspace_low_m = {low}");
            return Err(table.fail_at("workspace_high_m", reason));
        }
        (Some(_), None) => {
            let reason = "a workspace has two ends: give workspace_high_m too".to_owned();
            return Err(table.fail_at("workspace_low_m", reason));
        }
        (None, Some(_)) => {
            let reason = "a workspace has two ends: give workspace_low_m too".to_owned();
            return Err(table.fail_at("workspace_high_m", reason));
        }
    };
    let least = table.number_if(&p::DEVICE_DELAY_LEAST)?;
    let most = table.number_if(&p::DEVICE_DELAY_MOST)?;
    let device_delay_s = match (least, most) {
        (None, None) => None,
        (Some(least), Some(most)) if least <= most => Some((least, most)),
        (Some(least), Some(most)) => {
            let reason =
                format!("device_delay_most_s = {most} is below device_delay_least_s = {least}");
            return Err(table.fail_at("device_delay_most_s", reason));
        }
        (Some(_), None) => {
            let reason =
                "a delay has two ends: give device_delay_most_s too, the same if it is known";
            return Err(table.fail_at("device_delay_least_s", reason.to_owned()));
        }
        (None, Some(_)) => {
            let reason =
                "a delay has two ends: give device_delay_least_s too, the same if it is known";
            return Err(table.fail_at("device_delay_most_s", reason.to_owned()));
        }
    };
    Ok(Safety {
        guard: table.choice(&p::GUARD)?,
        workspace_m,
        speed_limit_m_per_s: table.number_if(&p::SPEED_LIMIT)?,
        rise_time_s: table.number_if(&p::RISE_TIME)?,
        braking_n_s_per_m: table.number_if(&p::BRAKING)?,
        stop_time_s: table.number_if(&p::STOP_TIME)?,
        brake_force_n: table.number_if(&p::BRAKE_FORCE)?,
        stuck_force_n: table.number_if(&p::STUCK_FORCE)?,
        stuck_time_s: table.number_if(&p::STUCK_TIME)?,
        jump_m: table.number_if(&p::JUMP)?,
        device_mass_kg: table.number_if(&p::DEVICE_MASS)?,
        device_damping_n_s_per_m: table.number_if(&p::DEVICE_DAMPING)?,
        device_delay_s,
        device_lag_s: table.number_if(&p::DEVICE_LAG)?,
        device_noise_m: table.number_if(&p::DEVICE_NOISE)?,
    })
}
