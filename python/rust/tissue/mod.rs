//! Tissues: models, the library, and models from records.

mod identified;
mod material;
mod model;

pub(crate) use identified::{explain_table, identify_record, identify_tables};
pub(crate) use material::{PyMaterial, find_material, library};
pub(crate) use model::{PyModel, restore_model};

use crate::arrays::vector;
use crate::refused::refused;
use haptic_tissue::ModelKind;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

fn kind_of(name: &str) -> PyResult<ModelKind> {
    ModelKind::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = ModelKind::ALL.iter().map(|kind| kind.name()).collect();
        refused(format_args!(
            "model \"{name}\" is not known: use one of {}",
            known.join(", ")
        ))
    })
}

/// Name, description and parameters of each model; a parameter has name, unit, range, help and whether it is a list.
#[pyfunction]
pub(crate) fn model_table(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let table = PyList::empty(py);
    for kind in ModelKind::ALL {
        let parameters = PyList::empty(py);
        for parameter in kind.parameters() {
            parameters.append((
                parameter.name,
                parameter.unit,
                parameter.range.words(),
                parameter.help,
                parameter.for_each_branch,
            ))?;
        }
        table.append((kind.name(), kind.description(), parameters))?;
    }
    Ok(table)
}

/// The values of [`ModelKind::parameters`] in their order, from arguments by name.
fn values_of(kind: ModelKind, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<f64>> {
    let table = kind.parameters();
    let names: Vec<&str> = table.iter().map(|known| known.name).collect();
    for key in parameters.map(|given| given.keys()).iter().flatten() {
        let key: String = key.extract()?;
        if !names.contains(&key.as_str()) {
            return Err(refused(format_args!(
                "{key} is not a parameter of the model {kind}, which has {}",
                names.join(", ")
            )));
        }
    }
    let (mut single, mut branches) = (Vec::new(), Vec::new());
    for known in table {
        let given = match parameters {
            Some(given) => given.get_item(known.name)?,
            None => None,
        };
        let given = given.ok_or_else(|| {
            refused(format_args!(
                "{} is missing: the model {kind} has {}",
                known.name,
                names.join(", ")
            ))
        })?;
        if known.for_each_branch {
            branches.push(vector(known.name, &given)?);
        } else {
            single.push(given.extract::<f64>()?);
        }
    }
    if let [moduli, times] = branches.as_slice() {
        if moduli.len() != times.len() {
            return Err(refused(format_args!(
                "{} moduli and {} times of branches: give one of each for a branch",
                moduli.len(),
                times.len()
            )));
        }
        single.extend(moduli.iter().zip(times).flat_map(|(e, tau)| [*e, *tau]));
    }
    Ok(single)
}

/// Refuses times that do not rise, with the index, and columns of different length.
fn checked_history(time_s: &[f64], other: &[f64], name: &str) -> PyResult<()> {
    if time_s.len() != other.len() {
        return Err(refused(format_args!(
            "time_s has {} values and {name} {}: give one for each time",
            time_s.len(),
            other.len()
        )));
    }
    if let Some(index) = time_s.iter().position(|t| !t.is_finite()) {
        return Err(refused(format_args!(
            "time_s[{index}] = {} s is not finite",
            time_s[index]
        )));
    }
    if let Some(index) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
        return Err(refused(format_args!(
            "time_s[{}] = {} s is not after time_s[{index}] = {} s",
            index + 1,
            time_s[index + 1],
            time_s[index]
        )));
    }
    if let Some(index) = other.iter().position(|x| !x.is_finite()) {
        return Err(refused(format_args!(
            "{name}[{index}] = {} is not finite",
            other[index]
        )));
    }
    Ok(())
}
