//! Keys that `[wall]` and `[coupler]` share: the device, and the plan of the trial.

use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::reader::Table;
use crate::experiment::reading::{samples_fit, sensors};
use crate::experiment::trial::TRIAL_SAMPLES;
use crate::experiment::trial::keys::{
    IMPACT, PUSH, TRIAL_FORCE_LIMIT, TRIAL_FORCE_RATE_LIMIT, WINDOW,
};
use crate::run::plant_file::DeviceModel;
use crate::run::remote::RemoteDevice;
use crate::run::safety::GuardedDevice;
use crate::run::safety::safety;
use crate::run::sensors::Sensors;
use crate::{TrialPlan, TrialSetup};
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};
use std::path::PathBuf;

/// Sample time and duration, s, of a run that is not too long.
pub(crate) fn times(table: &Table<'_>) -> Result<(f64, f64), FileError> {
    let sample_time_s = table.required(&p::SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    Ok((sample_time_s, duration_s))
}

/// The table with the values of its device files below the keys of the layers that name them.
pub(crate) fn with_devices(table: Table<'_>) -> Result<Table<'_>, FileError> {
    table.with_named(&p::DEVICE_MODEL, |path| {
        let values = DeviceModel::find(path)?.values.named();
        Ok(values
            .map(|(parameter, value)| (parameter.key, value))
            .into())
    })
}

/// The device file, if one is named.
pub(crate) fn device_model(table: &Table<'_>) -> Result<Option<DeviceModel>, FileError> {
    let read = |path: PathBuf| {
        DeviceModel::find(&path)
            .map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error.to_string()))
    };
    table.file(&p::DEVICE_MODEL)?.map(read).transpose()
}

/// The simulated device and its sensors.
pub(crate) fn device(
    table: &Table<'_>,
    sample_time_s: f64,
) -> Result<(MassDamperConfig, Sensors), FileError> {
    let device = MassDamperConfig {
        mass: Kilograms(table.number(&p::MASS)?),
        damping: NewtonSecondsPerMetre(table.number(&p::DAMPING)?),
        stiffness: NewtonsPerMetre(table.number(&p::HAND_STIFFNESS)?),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(table.number(&p::DELAY)?),
        friction: Newtons(table.number(&p::FRICTION)?),
        saturation: None,
        lag: Seconds(table.number(&p::CURRENT_LAG)?),
    };
    Ok((device, sensors(table)?))
}

/// Facts about the device that keys say over a device file; none without one.
fn written(table: &Table<'_>, device: &MassDamperConfig, sensors: Sensors) -> GuardedDevice {
    if !table.has(&p::DEVICE_MODEL) {
        return GuardedDevice::default();
    }
    let is = |parameter: &p::Parameter| !table.lies_below(parameter, &p::DEVICE_MODEL);
    let all = GuardedDevice::simulated(device, sensors);
    GuardedDevice {
        mass_kg: all.mass_kg.filter(|_| is(&p::MASS)),
        damping_n_s_per_m: all.damping_n_s_per_m.filter(|_| is(&p::DAMPING)),
        delay_s: all.delay_s.filter(|_| is(&p::DELAY)),
        lag_s: all.lag_s.filter(|_| is(&p::CURRENT_LAG)),
        noise_m: all
            .noise_m
            .filter(|_| is(&p::ENCODER_RESOLUTION) || is(&p::SENSOR_NOISE)),
    }
}

/// Device, trial, safety and pace, but `must_be_stable`, which each table has by itself.
pub(crate) fn setup(
    table: &Table<'_>,
    remote: Option<RemoteDevice>,
    (sample_time_s, duration_s): (f64, f64),
) -> Result<TrialSetup, FileError> {
    let model = device_model(table)?;
    for key in [&p::MASS, &p::DAMPING] {
        table.required(key)?;
    }
    let (device, sensors) = device(table, sample_time_s)?;
    let plan = plan(table, duration_s)?;
    let of_file = model.as_ref().map(DeviceModel::guarded).unwrap_or_default();
    Ok(TrialSetup {
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        remote,
        impact_was_given: table.number_if(&IMPACT)?.is_some(),
        known: written(table, &device, sensors).or(of_file),
        ..TrialSetup::new(device, sensors, plan)
    })
}

/// Reads the plan of a trial: how a wall is tried and judged.
pub(crate) fn plan(table: &Table<'_>, duration_s: f64) -> Result<TrialPlan, FileError> {
    let plan = TrialPlan {
        impact_m_per_s: table.number(&IMPACT)?,
        push_n: table.number(&PUSH)?,
        duration_s,
        window_s: table.number(&WINDOW)?,
        force_limit_n: table.number(&TRIAL_FORCE_LIMIT)?,
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
