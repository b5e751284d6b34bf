//! The device, its file and its sensors, as the keys of any table give them.

use crate::{
    DeviceModel, Sensors,
    plant_file::calibration::Calibration,
    robot::{ADMITTANCE, RobotModel},
};
use fracdiff::{Seconds, parameter::Shown};
use haptic_analysis::Dynamics;
use haptic_document::{
    FileError, Interval, Parsed, Table, parameters as p,
    parameters::{Parameter, SENSOR_NOISE},
    text_of,
};
use haptic_loop::{
    plant::{ForceSensor, ForceSensorConfig, MassDamperConfig},
    units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre},
};
use haptic_quantity::Key;
use std::{
    borrow::Cow,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

/// Refuses keys that were given over the file and have no effect.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn without<'p>(
    table: &Table<'_>,
    keys: impl IntoIterator<Item = &'p Parameter>,
    whence: &str,
) -> Result<(), FileError> {
    let given = keys.into_iter().find(|parameter| table.is_given(parameter));
    match given {
        Some(parameter) => {
            let key = parameter.key;
            Err(table.fail_at(
                key,
                format_args!("{key} has no effect {whence}, or omit {parameter}"),
            ))
        }
        None => Ok(()),
    }
}

/// The encoder and the noise of a simulated device.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn sensors(table: &Table<'_>) -> Result<Sensors, FileError> {
    let noise_m = table.number(&p::SENSOR_NOISE)?;
    if noise_m == 0.0 {
        without(
            table,
            [&p::SEED],
            &format!("without noise: give {SENSOR_NOISE} too, as 1e-6"),
        )?;
    }
    Ok(Sensors {
        encoder_resolution_m: table.number(&p::ENCODER_RESOLUTION)?,
        noise_m,
        seed: table.count(&p::SEED)?,
    })
}

/// The force sensor of a simulated device, if it has one.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn force_sensor(table: &Table<'_>) -> Result<Option<ForceSensorConfig>, FileError> {
    let Some(range_n) = table.number_if(&p::SENSED_RANGE)? else {
        let idle = format!(
            "without a force sensor: give {} too",
            p::SENSED_RANGE.set_to("20")
        );
        return without(table, &p::FORCE_SENSOR[1..], &idle).map(|()| None);
    };
    let config = ForceSensorConfig {
        range: Newtons(range_n),
        noise: Newtons(table.number(&p::SENSED_NOISE)?),
        lag: Seconds(table.number(&p::SENSED_LAG)?),
        offset: Newtons(table.number(&p::SENSED_OFFSET)?),
        seed: table.count(&p::SENSED_SEED)?,
    };
    let made = ForceSensor::new(config, Seconds(1e-3));
    made.map(|_| Some(config)).map_err(|error| {
        table.fail_at(
            p::SENSED_OFFSET.key,
            format!(
                "{error}: change {} or {}",
                p::SENSED_OFFSET,
                p::SENSED_RANGE
            ),
        )
    })
}

/// Checks that a run can have this number of samples.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn samples_fit(
    table: &Table<'_>,
    sample_time_s: f64,
    duration_s: f64,
    range: &RangeInclusive<f64>,
) -> Result<(), FileError> {
    let samples = (duration_s / sample_time_s).round() + 1.0;
    if range.contains(&samples) {
        return Ok(());
    }
    Err(table.fail_at("duration_s", format_args!(
        "duration_s = {duration_s} is {samples} samples of {sample_time_s} s, not in [{}, {:e}]: change {length} or {step}",
        range.start(),
        range.end(),
        length = Key("duration_s"),
        step = Key("sample_time_s"),
        duration_s = Shown(duration_s),
        sample_time_s = Shown(sample_time_s)
    )))
}

/// The table with the values of its device files below the keys of the layers that name them.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn with_devices(table: Table<'_>) -> Result<Table<'_>, FileError> {
    let logged = table.logged(&p::DEVICE_MODEL);
    let takes_robot = takes_robot(&table);
    table.with_named(&p::DEVICE_MODEL, |path| {
        let text = text_at(path, logged)?;
        if takes_robot && is_robot(path, &text)? {
            return Ok((Vec::new(), Vec::new()));
        }
        let model = device_in(path, &text)?;
        let numbers = (model.values.named()).map(|(parameter, value)| (parameter.key, value));
        let (mut numbers, mut intervals) = (Vec::from(numbers), model.intervals);
        // The lag of a sensor that was calibrated; none is below 0.
        let key = p::SENSED_LAG.key;
        let lag = model
            .calibration
            .iter()
            .find_map(|known| known.found.get(key));
        if let Some(lag) = lag {
            let [low, value, high] = [lag.low, lag.value, lag.high].map(|end| end.max(0.0));
            numbers.push((key, value));
            intervals.push(Interval { key, low, high });
        }
        Ok((numbers, intervals))
    })
}

/// The text of a file, as a log has it or as it is today.
fn text_at<'t>(path: &Path, logged: Option<&'t str>) -> Result<Cow<'t, str>, FileError> {
    logged.map_or_else(|| DeviceModel::text(path), |text| Ok(text.into()))
}

/// True of the device file of a robot.
///
/// # Errors
/// A text that is no document.
pub fn is_robot(path: &Path, text: &str) -> Result<bool, FileError> {
    Parsed::of(path, text).map(|document| document.has(ADMITTANCE))
}

/// True of a table that may be of a robot.
fn takes_robot(table: &Table<'_>) -> bool {
    ["wall", "zwidth", "analyze-admittance"].contains(&table.name)
}

/// The device of a file, which is no robot.
fn device_in(path: &Path, text: &str) -> Result<DeviceModel, FileError> {
    if is_robot(path, text)? {
        let reason = "[admittance] is of a robot that moves, which [wall] and [zwidth] take and `analyze admittance` judges: give the file of a [device]";
        return Err(Parsed::of(path, text)?.fail(reason));
    }
    DeviceModel::parse(path, text)
}

/// Path and text of the device file of a robot, where one is named that the table may be of.
fn robot_file<'t>(table: &Table<'t>) -> Result<Option<(PathBuf, Cow<'t, str>)>, FileError> {
    let (Some(path), true) = (table.file(&p::DEVICE_MODEL)?, takes_robot(table)) else {
        return Ok(None);
    };
    let read = || {
        let text = text_at(&path, table.logged(&p::DEVICE_MODEL))?;
        is_robot(&path, &text).map(|is| is.then_some(text))
    };
    let text = read().map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error))?;
    Ok(text.map(|text| (path, text)))
}

/// The robot of a trial: that of `[admittance]` beside its table, or that of its device file.
///
/// # Errors
/// Both; a value that is wrong, with its place.
pub fn robot(
    table: &Table<'_>,
    beside: Option<&Table<'_>>,
    sample_time_s: f64,
) -> Result<Option<RobotModel>, FileError> {
    if let Some(beside) = beside {
        if table.has(&p::DEVICE_MODEL) {
            let reason = "device_model has no effect beside [admittance], which is the device: omit one of them";
            return Err(table.fail_at(p::DEVICE_MODEL.key, reason));
        }
        return RobotModel::of(beside, sample_time_s).map(Some);
    }
    let Some((path, text)) = robot_file(table)? else {
        return Ok(None);
    };
    let model = RobotModel::parse(&path, &text, sample_time_s);
    let model = model.map_err(|error| table.fail_at(p::DEVICE_MODEL.key, error));
    model.map(Some)
}

/// The newtons of the device file that is named, if they were checked; those of a robot are its own.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn calibration(table: &Table<'_>) -> Result<Option<Calibration>, FileError> {
    if robot_file(table)?.is_some() {
        return Ok(None);
    }
    Ok(device_model(table)?.and_then(|model| model.calibration))
}

/// The text of a device file for the log of a run, if one is named that is not ours.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn device_text(table: &Table<'_>, file: &Parameter) -> Result<Option<String>, FileError> {
    let logged = table.logged(file);
    let text =
        |path: PathBuf| logged.map_or_else(|| text_of(&path, "device"), |text| Ok(text.to_owned()));
    let path = table.file(file)?;
    path.filter(|path| path != Path::new(p::LABORATORY))
        .map(text)
        .transpose()
}

/// The device file, if one is named.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn device_model(table: &Table<'_>) -> Result<Option<DeviceModel>, FileError> {
    device_model_by(table, &p::DEVICE_MODEL)
}

/// The device file that this parameter names.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn device_model_by(
    table: &Table<'_>,
    file: &Parameter,
) -> Result<Option<DeviceModel>, FileError> {
    let read = |path: PathBuf| {
        let read = text_at(&path, table.logged(file)).and_then(|text| device_in(&path, &text));
        read.map_err(|error| table.fail_at(file.key, error))
    };
    table.file(file)?.map(read).transpose()
}

/// The simulated device and its sensors.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn device(
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
        gain: 1.0,
        current_lag: Seconds(table.number(&p::CURRENT_LAG)?),
    };
    Ok((device, sensors(table)?))
}

/// Dynamics that the analysis knows of a simulated device: all but friction.
pub fn dynamics(device: &MassDamperConfig) -> Dynamics {
    Dynamics {
        mass_kg: device.mass.0,
        damping_n_s_per_m: device.damping.0,
        hand_stiffness_n_per_m: device.stiffness.0,
        delay_s: device.delay.0,
        current_lag_s: device.current_lag.0,
    }
}

/// The step of an encoder that is as coarse as these sensors, m: noise has the rms of steps √12 times as large.
pub fn encoder_step(sensors: Sensors) -> f64 {
    (sensors.encoder_resolution_m).max(12.0_f64.sqrt() * sensors.noise_m)
}
