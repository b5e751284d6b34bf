//! From TOML to a plant.

use super::response::read_response;
use super::{DeviceValues, FileError, PlantFile, PlantModel};
use crate::file::reader::{Document, Table};
use crate::parameters as p;
use crate::parameters::Parameter;
use fractional_control::ControlError;
use std::path::Path;

/// Tables with a plant, and their keys.
const MODELS: [(&str, &[Parameter]); 4] = [
    ("transfer_function", p::TRANSFER_PLANT),
    ("device", p::DEVICE_PLANT),
    ("state_space", p::STATE_PLANT),
    ("measured_response", p::MEASURED_PLANT),
];
const CHOICE: &str = "a plant file has one of [transfer_function], [device], [state_space], [measured_response], and perhaps [source]";

pub(super) fn parse(path: &Path, text: &str) -> Result<PlantFile, FileError> {
    let document = Document::parse(path, text)?;
    let names: Vec<&str> = MODELS.iter().map(|(name, _)| *name).collect();
    let names = [&names[..], &["source"]].concat();
    let (mut model, mut source) = (None, None);
    for (name, table) in document.tables(&names, CHOICE)? {
        match MODELS.iter().find(|(model, _)| *model == name) {
            Some(_) if model.is_some() => {
                return Err(table.fail(format!("a second plant [{name}]: {CHOICE}")));
            }
            Some(known) => model = Some((name, table.with_keys(&[*known])?)),
            None => source = Some(table.with_keys(&[("source", p::PLANT_SOURCE)])?),
        }
    }
    let (name, table) = model.ok_or_else(|| document.fail(format!("no plant: {CHOICE}")))?;
    let mut file = PlantFile::new(self::model(name, &table)?);
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
        }),
        "state_space" => PlantModel::StateSpace {
            a: table.matrix(&p::STATE_A)?,
            b: table.numbers(&p::STATE_B)?,
            c: table.numbers(&p::STATE_C)?,
            delay_s: table.number(&p::DEAD_TIME)?,
            current_lag_s: table.number(&p::CURRENT_LAG)?,
        },
        _ => {
            let path = table.beside(table.required_text(&p::RESPONSE_FILE)?);
            let points = read_response(&path);
            PlantModel::Measured(
                points.map_err(|reason| table.fail_at(p::RESPONSE_FILE.key, reason))?,
            )
        }
    })
}
