//! Keys that `[wall]` and `[coupler]` share: the device, and the plan of the trial.

use super::device::{samples_fit, sensors};
use super::error::FileError;
use super::reader::Table;
use super::safety::safety;
use crate::parameters::Parameter;
use crate::plant_file::{DeviceModel, DeviceValues};
use crate::pushed::TRIAL_SAMPLES;
use crate::remote::RemoteDevice;
use crate::sensed::Sensors;
use crate::{TrialPlan, TrialSetup, parameters as p};
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};
use std::path::Path;

/// Sample time and duration, s, of a run that is not too long.
pub(super) fn times(table: &Table<'_>) -> Result<(f64, f64), FileError> {
    let sample_time_s = table.required(&p::SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    Ok((sample_time_s, duration_s))
}

/// The device file, if one is named.
pub(super) fn device_model(table: &Table<'_>) -> Result<Option<DeviceModel>, FileError> {
    let name = table.text(&p::DEVICE_MODEL)?;
    let read = |name: &str| {
        DeviceModel::find(Path::new(name), &table.beside(""))
            .map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error.to_string()))
    };
    (!name.is_empty()).then(|| read(name)).transpose()
}

/// The device and its sensors: keys, where there are none the device file, where there is none the defaults.
fn device(
    table: &Table<'_>,
    model: Option<&DeviceModel>,
    sample_time_s: f64,
) -> Result<(MassDamperConfig, Sensors), FileError> {
    let values = model.map(|model| model.values);
    let own = |parameter: &Parameter, value: fn(&DeviceValues) -> f64| {
        let given = table.number_if(parameter)?;
        Ok(given.or(values.as_ref().map(value)))
    };
    let must = |parameter: &Parameter, value: fn(&DeviceValues) -> f64| match own(parameter, value)?
    {
        Some(number) => Ok(number),
        None => table.required(parameter),
    };
    let may = |parameter: &Parameter, value: fn(&DeviceValues) -> f64| match own(parameter, value)?
    {
        Some(number) => Ok(number),
        None => table.number(parameter),
    };
    let device = MassDamperConfig {
        mass: Kilograms(must(&p::MASS, |device| device.mass_kg)?),
        damping: NewtonSecondsPerMetre(must(&p::DAMPING, |device| device.damping_n_s_per_m)?),
        stiffness: NewtonsPerMetre(may(&p::HAND_STIFFNESS, |device| {
            device.hand_stiffness_n_per_m
        })?),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(may(&p::DELAY, |device| device.delay_s)?),
        friction: Newtons(may(&p::FRICTION, |device| device.friction_n)?),
        saturation: None,
        lag: Seconds(may(&p::CURRENT_LAG, |device| device.current_lag_s)?),
    };
    let sensors = Sensors {
        encoder_resolution_m: may(&p::ENCODER_RESOLUTION, |device| device.encoder_resolution_m)?,
        noise_m: may(&p::SENSOR_NOISE, |device| device.sensor_noise_m)?,
        ..sensors(table)?
    };
    Ok((device, sensors))
}

/// Device, trial, safety and pace, but `must_be_stable`, which each table has by itself.
pub(super) fn setup(
    table: &Table<'_>,
    remote: Option<RemoteDevice>,
    (sample_time_s, duration_s): (f64, f64),
) -> Result<TrialSetup, FileError> {
    let model = device_model(table)?;
    let (device, sensors) = device(table, model.as_ref(), sample_time_s)?;
    let plan = plan(table, duration_s)?;
    Ok(TrialSetup {
        force_rate_limit_n_per_s: table.number_if(&p::TRIAL_FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        remote,
        impact_was_given: table.number_if(&p::IMPACT)?.is_some(),
        known: model.as_ref().map(DeviceModel::guarded).unwrap_or_default(),
        ..TrialSetup::new(device, sensors, plan)
    })
}

/// Reads the plan of a trial: how a wall is tried and judged.
pub(super) fn plan(table: &Table<'_>, duration_s: f64) -> Result<TrialPlan, FileError> {
    let plan = TrialPlan {
        impact_m_per_s: table.number(&p::IMPACT)?,
        push_n: table.number(&p::PUSH)?,
        duration_s,
        window_s: table.number(&p::WINDOW)?,
        force_limit_n: table.number(&p::TRIAL_FORCE_LIMIT)?,
        ..TrialPlan::DEFAULT
    };
    if plan.push_n >= plan.force_limit_n {
        let reason = format!(
            "push_n = {} is not below force_limit_n = {}: no wall could hold it",
            Shown(plan.push_n),
            Shown(plan.force_limit_n)
        );
        return Err(table.fail_at("push_n", reason));
    }
    Ok(plan)
}
