//! From TOML to a plant.

use super::model::{DeviceValues, Interval, PlantFile, PlantModel};
use super::response::read_response;
use crate::document::Parsed;
use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::parameters::Parameter;
use crate::document::reader::Table;
use fracdiff::parameter::Shown;
use fractional_control::ControlError;
use std::path::Path;

/// Tables with a plant, and their keys.
const MODELS: [(&str, &[Parameter]); 4] = [
    ("transfer_function", p::TRANSFER_PLANT),
    ("device", p::DEVICE_PLANT),
    ("state_space", p::STATE_PLANT),
    ("measured_response", p::MEASURED_PLANT),
];
const CHOICE: &str = "a plant file has one of [transfer_function], [device], [state_space], [measured_response], and perhaps [source]; \
[intervals] beside [device]";
/// Intervals of a measured device, with its keys.
const INTERVALS: &str = "intervals";

pub(super) fn parse(path: &Path, text: &str) -> Result<PlantFile, FileError> {
    let document = Parsed::of(path, text)?;
    let names: Vec<&str> = MODELS.iter().map(|(name, _)| *name).collect();
    let names = [&names[..], &["source", INTERVALS]].concat();
    let (mut model, mut source, mut intervals) = (None, None, None);
    for (name, table) in document.tables(&names, CHOICE)? {
        match MODELS.iter().find(|(model, _)| *model == name) {
            Some(_) if model.is_some() => {
                return Err(table.fail(format!("a second plant [{name}]: {CHOICE}")));
            }
            Some(known) => model = Some((name, table.with_keys(&[*known])?)),
            None if name == INTERVALS => {
                intervals = Some(table.with_keys(&[(INTERVALS, p::DEVICE_PLANT)])?);
            }
            None => source = Some(table.with_keys(&[("source", p::PLANT_SOURCE)])?),
        }
    }
    let (name, table) = model.ok_or_else(|| document.fail(format!("no plant: {CHOICE}")))?;
    let mut file = PlantFile::new(self::model(name, &table)?);
    if let Some(found) = intervals {
        let PlantModel::Device(values) = &file.model else {
            let reason =
                format!("[{INTERVALS}] are of a [device], which [{name}] is not: leave it out");
            return Err(found.fail(reason));
        };
        file.intervals = self::intervals(&found, values)?;
    }
    if let Some(source) = source {
        source
            .text(&p::SOURCE_PROGRAM)?
            .clone_into(&mut file.program);
        source.text(&p::SOURCE_NOTE)?.clone_into(&mut file.note);
    }
    file.plant()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(file)
}

fn model(name: &str, table: &Table<'_>) -> Result<PlantModel, FileError> {
    Ok(match name {
        "transfer_function" => {
            let model = table.required_text(&p::FUNCTION)?.parse();
            let refused = |error: ControlError| table.fail_at(p::FUNCTION.key, error.to_string());
            let mut model: PlantModel = model.map_err(refused)?;
            if let PlantModel::Function { delay_s, .. } = &mut model {
                *delay_s += table.number(&p::DEAD_TIME)?;
            }
            model
        }
        "device" => PlantModel::Device(DeviceValues {
            mass_kg: table.required(&p::MASS)?,
            damping_n_s_per_m: table.required(&p::DAMPING)?,
            hand_stiffness_n_per_m: table.number(&p::HAND_STIFFNESS)?,
            delay_s: table.number(&p::DELAY)?,
            current_lag_s: table.number(&p::CURRENT_LAG)?,
            friction_n: table.number(&p::FRICTION)?,
            encoder_resolution_m: table.number(&p::ENCODER_RESOLUTION)?,
            sensor_noise_m: table.number(&p::SENSOR_NOISE)?,
        }),
        "state_space" => PlantModel::StateSpace {
            a: table.matrix(&p::STATE_A)?,
            b: table.numbers(&p::STATE_B)?,
            c: table.numbers(&p::STATE_C)?,
            delay_s: table.number(&p::DEAD_TIME)?,
            current_lag_s: table.number(&p::CURRENT_LAG)?,
        },
        _ => {
            table.required_text(&p::RESPONSE_FILE)?;
            let path = table.file(&p::RESPONSE_FILE)?.unwrap_or_default();
            let points = read_response(&path);
            PlantModel::Measured(
                points.map_err(|reason| table.fail_at(p::RESPONSE_FILE.key, reason))?,
            )
        }
    })
}

/// Intervals that are given, each about the value that it is of.
fn intervals(table: &Table<'_>, values: &DeviceValues) -> Result<Vec<Interval>, FileError> {
    let mut intervals = Vec::new();
    for (parameter, value) in values.named() {
        let Some(ends) = table.numbers_if(parameter)? else {
            continue;
        };
        let key = parameter.key;
        let about = |low: f64, high: f64| {
            // Values are written with fewer digits than they have.
            let slack = 1e-6 * value.abs();
            low - slack <= value && value <= high + slack
        };
        match ends[..] {
            [low, high] if about(low, high) && low >= 0.0 && parameter.range().contains(high) => {
                intervals.push(Interval { key, low, high });
            }
            [low, high] => {
                let reason = format!(
                    "{key} = [{low}, {high}] is not an interval of numbers from 0 to {} about the value {value} in [device]: change it, or leave it out",
                    Shown(parameter.range().ends()[1]),
                    low = Shown(low),
                    high = Shown(high),
                    value = Shown(value)
                );
                return Err(table.fail_at(key, reason));
            }
            _ => {
                let reason = format!(
                    "{key} has {} numbers, not two: write [LOW, HIGH]",
                    ends.len()
                );
                return Err(table.fail_at(key, reason));
            }
        }
    }
    Ok(intervals)
}
