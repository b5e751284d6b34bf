//! Keys of every table: the device and its file, its sensors, the operator, the tissue, and how many samples there are.

use super::kind::Conduct;
use crate::run::device::DeviceName;
use crate::run::remote::{RemoteDevice, device_name};
use fracdiff::parameter::Shown;
use fracdiff::{Order, Scheme, Seconds};
use haptic_document::parameters::{DEVICE, Parameter, SENSOR_NOISE};
use haptic_document::{FileError, Interval, Table, parameters as p, text_of};
use haptic_judge::modelled_tissue::{ModelledTissue, TissuePiece, operator};
use haptic_link::Limits;
use haptic_loop::plant::{ForceSensor, ForceSensorConfig, MassDamperConfig};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};
use haptic_loop::{Loading, LoadingKind, LoopParameterError};
use haptic_quantity::label;
use haptic_tissue::{Library, Material, Model};
use haptic_trial::safety::Safety;
use haptic_trial::{DeviceModel, Sensors};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The device at a port; `None` for the simulated one.
pub(crate) fn remote(table: &Table<'_>) -> Result<Option<RemoteDevice>, FileError> {
    remote_by(table, &p::DEVICE)
}

/// The device at a port that this parameter names.
pub(crate) fn remote_by(
    table: &Table<'_>,
    name: &Parameter,
) -> Result<Option<RemoteDevice>, FileError> {
    let device = table.text(name)?.parse::<DeviceName>();
    let device = device.map_err(|reason| table.fail_at(name.key, reason))?;
    let loop_mode = table.choice(&p::LOOP)?;
    let watchdog_s = table.number_if(&p::WATCHDOG)?;
    if let Some(time) = watchdog_s.filter(|time| (1e3 * time - (1e3 * time).round()).abs() > 1e-6) {
        return Err(table.fail_at(
            "watchdog_s",
            format_args!(
                "watchdog_s = {time} is not a whole number of milliseconds: write 0.005 for 5 ms",
                time = Shown(time)
            ),
        ));
    }
    let late_ticks = table.count_in(&p::LATE_TICKS, 0..=u64::from(u16::MAX))? as u16;
    let most = u64::from(Limits::MAX_AGE_TICKS);
    let max_age_ticks = table.count_in(&p::MAX_AGE_TICKS, 1..=most)? as u16;
    let Some(name) = device.0 else {
        // A file may say them for the device that is given with it.
        let idle = [&p::LOOP, &p::WATCHDOG, &p::LATE_TICKS, &p::MAX_AGE_TICKS];
        return without(
            table,
            idle,
            &format!("on the simulated device: give {DEVICE} too, as serial:PATH"),
        )
        .map(|()| None);
    };
    Ok(Some(RemoteDevice {
        loop_mode,
        watchdog_ms: watchdog_s.map(|time| (1e3 * time).round() as u16),
        late_ticks,
        max_age_ticks,
        calibration: device_model(table)?.and_then(|model| model.calibration),
        ..RemoteDevice::new(name)
    }))
}

/// Refuses keys that were given over the file and have no effect.
pub(crate) fn without<'p>(
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

pub(crate) fn sensors(table: &Table<'_>) -> Result<Sensors, FileError> {
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
pub(crate) fn force_sensor(table: &Table<'_>) -> Result<Option<ForceSensorConfig>, FileError> {
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
pub(crate) fn samples_fit(
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
        "duration_s = {duration_s} is {samples} samples of {sample_time_s} s, not in [{}, {:e}]",
        range.start(),
        range.end(),
        duration_s = Shown(duration_s),
        sample_time_s = Shown(sample_time_s)
    )))
}

/// A scheme that can be made for this order, or for a model, and sample time.
pub(crate) fn scheme(
    table: &Table<'_>,
    model: Option<&Model>,
    order: Order,
    sample_time_s: f64,
    duration_s: f64,
) -> Result<Scheme, FileError> {
    let scheme = table.scheme(&p::SCHEME)?;
    let horizon = haptic_trial::samples::horizon((duration_s / sample_time_s) as u64);
    match operator::<f64>(model, scheme, order, Seconds(sample_time_s), horizon) {
        Ok(_) => Ok(scheme),
        Err(error) => Err(table.fail_at("scheme", error)),
    }
}

/// The table with the values of its device files below the keys of the layers that name them.
pub(crate) fn with_devices(table: Table<'_>) -> Result<Table<'_>, FileError> {
    let logged = table.logged(&p::DEVICE_MODEL);
    table.with_named(&p::DEVICE_MODEL, |path| {
        let model = device_at(path, logged)?;
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

/// The device of a file, as a log has it or as it is today.
fn device_at(path: &Path, logged: Option<&str>) -> Result<DeviceModel, FileError> {
    logged.map_or_else(
        || DeviceModel::find(path),
        |text| DeviceModel::parse(path, text),
    )
}

/// The text of a device file for the log of a run, if one is named that is not ours.
pub(crate) fn device_text(
    table: &Table<'_>,
    file: &Parameter,
) -> Result<Option<String>, FileError> {
    let logged = table.logged(file);
    let text =
        |path: PathBuf| logged.map_or_else(|| text_of(&path, "device"), |text| Ok(text.to_owned()));
    let path = table.file(file)?;
    path.filter(|path| path != Path::new(p::LABORATORY))
        .map(text)
        .transpose()
}

/// The device file, if one is named.
pub(crate) fn device_model(table: &Table<'_>) -> Result<Option<DeviceModel>, FileError> {
    device_model_by(table, &p::DEVICE_MODEL)
}

/// The device file that this parameter names.
pub(crate) fn device_model_by(
    table: &Table<'_>,
    file: &Parameter,
) -> Result<Option<DeviceModel>, FileError> {
    let read = |path: PathBuf| {
        device_at(&path, table.logged(file)).map_err(|error| table.fail_at(file.key, error))
    };
    table.file(file)?.map(read).transpose()
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
        gain: 1.0,
        current_lag: Seconds(table.number(&p::CURRENT_LAG)?),
    };
    Ok((device, sensors(table)?))
}

/// A tissue of the library and a piece of it.
pub(crate) fn piece(table: &Table<'_>) -> Result<TissuePiece, FileError> {
    let folder = table.file(&p::LIBRARY)?;
    let library =
        Library::load(folder.as_deref()).map_err(|error| table.fail_at("library", error))?;
    let tissue = table.file(&p::TISSUE)?.unwrap_or_default();
    let wrong = |error: String| table.fail_at("tissue", error);
    let logged = table.logged(&p::TISSUE);
    let material = match logged.filter(|_| !table.is_given(&p::LIBRARY)) {
        Some(text) => Material::parse(&tissue, text),
        None => library.find(&tissue.to_string_lossy()),
    };
    let material = ModelledTissue::new(material.map_err(|error| wrong(error.to_string()))?);
    let material = material.map_err(|error| wrong(error.to_string()))?;
    // A size with a default is one of a slab only.
    let given = loading(table)?;
    let usual = |parameter: Parameter| {
        let slab = given.kind.is_slab();
        slab.then_some(parameter.default_number())
    };
    let loading = Loading {
        area_m2: given.area_m2.or(usual(p::AREA)),
        thickness_m: given.thickness_m.or(usual(p::THICKNESS)),
        ..given
    };
    TissuePiece::new(material, loading).map_err(|error| match of_loading(&error) {
        Some((parameter, remedy)) => {
            table.fail_at(parameter.key, format!("{error}: {remedy} {parameter}"))
        }
        None => table.fail(error),
    })
}

/// The loading of a specimen, as far as the keys give it.
fn loading(table: &Table<'_>) -> Result<Loading, FileError> {
    let kind: LoadingKind = table.choice(&p::LOADING)?;
    let given = |parameter: &Parameter| {
        let number = table.has(parameter).then(|| table.number(parameter));
        number.transpose()
    };
    Ok(Loading {
        kind,
        area_m2: given(&p::AREA)?,
        thickness_m: given(&p::THICKNESS)?,
        radius_m: table.number_if(&p::INDENTER_RADIUS)?,
        half_angle_rad: table.number_if(&p::HALF_ANGLE)?,
        bonded: table.flag(&p::BONDED)?,
    })
}

/// The key of a size that a loading refuses, and what to do with it.
fn of_loading(error: &LoopParameterError) -> Option<(&'static Parameter, &'static str)> {
    let (what, remedy) = if let LoopParameterError::Missing { what, .. } = error {
        (*what, "give")
    } else if let LoopParameterError::NoEffect { what, .. }
    | LoopParameterError::Layer { what, .. } = error
    {
        (*what, "omit")
    } else if let LoopParameterError::Range(range) = error {
        (range.what, "change")
    } else {
        return None;
    };
    let mut keys = p::PIECE.iter();
    let key = keys.find(|parameter| label(parameter.key) == what)?;
    Some((key, remedy))
}

/// Refuses a depth beyond the thickness of a piece.
pub(crate) fn fits(table: &Table<'_>, piece: &TissuePiece, depth_m: f64) -> Result<(), FileError> {
    let thickness_m = piece.specimen.loading().thickness_m;
    match thickness_m.filter(|thickness_m| depth_m > *thickness_m) {
        None => Ok(()),
        Some(thickness_m) => Err(table.fail_at(
            "depth_m",
            format_args!(
                "depth_m = {depth_m} is beyond thickness_m = {thickness_m}: change one of them",
                depth_m = Shown(depth_m),
                thickness_m = Shown(thickness_m)
            ),
        )),
    }
}

/// A piece whose force follows its depth by the memory alone.
pub(crate) fn linear_piece(table: &Table<'_>) -> Result<TissuePiece, FileError> {
    let piece = piece(table)?;
    if piece.is_linear() {
        Ok(piece)
    } else {
        Err(table.fail_at(p::LOADING.key, TissuePiece::NOT_LINEAR))
    }
}

/// Metadata for the log of a run of this kind, besides its document, or over it where the program decides what really runs.
pub(crate) fn metadata(
    kind: &str,
    conduct: &Conduct,
    scheme: Scheme,
    safety: &Safety,
) -> BTreeMap<String, String> {
    let words = [
        ("experiment", kind.to_owned()),
        ("pace", conduct.pace.to_string()),
        ("scheme", scheme.to_string()),
        ("device", device_name(conduct.remote.as_ref())),
    ];
    let numbers = safety.numbers();
    let numbers = numbers.map(|(key, value)| (key, value.to_string()));
    let all = words.into_iter().chain(numbers);
    all.map(|(key, value)| (key.to_owned(), value)).collect()
}
