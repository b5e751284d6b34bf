//! The device of a question: its keys, where there are none the device file, where there is none the dissertation's.

use super::device::sensors;
use super::error::FileError;
use super::pushed::device_model;
use super::reader::Table;
use crate::design::Device;
use crate::parameters::{self as p, Parameter};
use crate::plant_file::DeviceModel;
use crate::sensed::Sensors;
use crate::{Imperfections, dissertation_device};
use fracdiff::Seconds;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};

pub(super) fn bench(table: &Table<'_>) -> Result<Device, FileError> {
    let sample_time_s = table.number(&p::SAMPLE_TIME)?;
    let model = device_model(table)?;
    let usual = model.as_ref().map(DeviceModel::imperfections);
    let usual = usual.unwrap_or(Imperfections::NONE);
    let or = |parameter: &Parameter, usual: f64| {
        let given = table.number_if(parameter)?;
        Ok(given.unwrap_or(usual))
    };
    let imperfections = Imperfections {
        friction_n: or(&p::FRICTION, usual.friction_n)?,
        delay_s: or(&p::DELAY, usual.delay_s)?,
        current_lag_s: or(&p::CURRENT_LAG, usual.current_lag_s)?,
        sensors: Sensors {
            encoder_resolution_m: or(&p::ENCODER_RESOLUTION, usual.sensors.encoder_resolution_m)?,
            noise_m: or(&p::SENSOR_NOISE, usual.sensors.noise_m)?,
            ..sensors(table)?
        },
    };
    let device = dissertation_device(Seconds(sample_time_s));
    let values = model.map(|model| model.values);
    let of = |usual: f64, value: fn(&crate::plant_file::DeviceValues) -> f64| {
        values.as_ref().map_or(usual, value)
    };
    let ideal = MassDamperConfig {
        mass: Kilograms(or(&p::MASS, of(device.mass.0, |d| d.mass_kg))?),
        damping: NewtonSecondsPerMetre(or(
            &p::DAMPING,
            of(device.damping.0, |d| d.damping_n_s_per_m),
        )?),
        stiffness: NewtonsPerMetre(or(
            &p::HAND_STIFFNESS,
            of(device.stiffness.0, |d| d.hand_stiffness_n_per_m),
        )?),
        ..device
    };
    Ok(Device {
        plant: imperfections.on(ideal),
        sensors: imperfections.sensors,
        force_limit_n: table.number(&p::TRIAL_FORCE_LIMIT)?,
    })
}
