//! Plants from records.

use crate::arrays::Array;
use crate::conducted::{Interrupted, conduct};
use crate::json::{from_python, to_python};
use crate::refused::{OrRefused as _, refused};
use haptic_question::plant::keys::PlantForm;
use haptic_question::plant::{PlantData, PlantFound, PlantQuestion};
use num_complex::Complex64;
use pyo3::prelude::*;

/// Name and bytes of a table.
type Named = (String, Vec<u8>);

fn read(question: &PlantQuestion, (name, bytes): &Named) -> PyResult<PlantData> {
    let record = question.data(&question.columns, bytes);
    record.map_err(|error| refused(format_args!("{name}: {error}")))
}

/// Report, signals and plant file.
type Found<'py> = (Bound<'py, PyAny>, Vec<Bound<'py, PyAny>>, String);

/// The plant in a record, tried on another, if there is one, or in a frequency response: report, signals with the function's output, and plant file.
#[pyfunction]
pub(crate) fn identify_plant<'py>(
    py: Python<'py>,
    record: Named,
    other: Option<Named>,
    form: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Found<'py>> {
    let form: PlantForm = from_python("options", form)?;
    let question = PlantQuestion::of(&form).or_refused()?;
    let record = read(&question, &record)?;
    let other = other.map(|other| read(&question, &other)).transpose()?;
    let answer = conduct(py, progress, Interrupted::Forgotten, move |conduct| {
        let steps = |_: &_, _, done| conduct.add(done as u64);
        question
            .found(record, other, conduct.stop(), &steps)
            .or_refused()
    })?;
    let numbers = |signal: &[f64]| Array::of(signal.to_vec()).into_pyobject(py);
    let complex = |values: Vec<Complex64>| Array::of(values).into_pyobject(py);
    let signals = match &answer {
        PlantFound::Record(answer) => {
            let found = &answer.record;
            [&found.time_s, &found.input, &found.output, answer.model()].map(numbers)
        }
        PlantFound::Response(answer) => {
            let (omegas, values): (Vec<f64>, Vec<Complex64>) =
                answer.points.iter().copied().unzip();
            let model = answer.model().to_vec();
            [
                numbers(&omegas),
                numbers(&[]),
                complex(values),
                complex(model),
            ]
        }
    };
    let program = concat!("fractional_haptics ", env!("CARGO_PKG_VERSION"));
    Ok((
        to_python(py, &answer.report())?,
        signals.into_iter().collect::<PyResult<_>>()?,
        answer.to_toml(program, "a record"),
    ))
}
