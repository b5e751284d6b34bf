//! Searches: the Z-width of a device, and the best wall for it.

use super::{document, failed};
use crate::arrays::Whole;
use crate::conducted::{Interrupted, conduct, heard};
use crate::json::to_python;
use crate::refused::{OrRefused as _, refused};
use crate::tissue::PyMaterial;
use fracdiff::Order;
use haptic_experiment::question::design::{Design, Device, Wish};
use haptic_experiment::{ExperimentFile, ModelledTissue, WallExperiment, ZWidth};
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// Device, trial and operator, read as those of a wall; the wall itself plays no part.
fn bench(parameters: &Bound<'_, PyDict>) -> PyResult<WallExperiment> {
    let parameters = parameters.copy()?;
    for (key, value) in [
        ("order", 1.0),
        ("stiffness_n_per_m", 1.0),
        ("dissipation_n_s_mu_per_m", 0.0),
    ] {
        if parameters.contains(key)? {
            return Err(refused(format_args!(
                "{key} is what is looked for: leave it out"
            )));
        }
        parameters.set_item(key, value)?;
    }
    let document = document("wall", &parameters)?;
    let read = move |_: &_| ExperimentFile::open(&document).or_refused();
    let ExperimentFile::Wall(wall) = heard(parameters.py(), Duration::MAX, read)? else {
        return Err(refused("not a wall"));
    };
    Ok(wall)
}

fn orders_of(orders: Vec<f64>) -> PyResult<Vec<Order>> {
    orders
        .into_iter()
        .map(|order| Order::new(order).or_refused())
        .collect()
}

/// The stiffest walls by trying.
#[pyfunction]
pub(crate) fn zwidth<'py>(
    parameters: &Bound<'py, PyDict>,
    orders: Vec<f64>,
    points: Whole,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = parameters.py();
    let wall = bench(parameters)?;
    let experiment = ZWidth {
        device: wall.setup.device,
        sensors: wall.setup.sensors,
        one_sided: wall.one_sided,
        scheme: wall.scheme,
        orders: orders_of(orders)?,
        points: points.within("points", ZWidth::POINTS)?,
        plan: wall.setup.plan,
        remote: wall.setup.remote,
    };
    // A device is brought to rest; what is simulated has nothing to lose.
    let interrupted = match experiment.remote {
        Some(_) => Interrupted::Awaited,
        None => Interrupted::Forgotten,
    };
    let report = conduct(py, progress, interrupted, move |conduct| {
        let report = experiment.run(&|cells| conduct.add(cells), conduct.stop(), &|_| ());
        report.map_err(|failure| failed(&failure))
    })?;
    to_python(py, &report)
}

/// A tissue and the area and thickness of its specimen in m² and m.
type WishedTissue<'py> = (Bound<'py, PyMaterial>, f64, f64);

/// What the best wall is to be best in.
fn wish_of(
    wish: &str,
    tissue: Option<WishedTissue<'_>>,
    frequency_hz: Option<f64>,
) -> PyResult<Wish> {
    Ok(match (wish, tissue, frequency_hz) {
        ("stiffest-wall", None, None) => Wish::StiffestWall,
        ("stiffest-wall", None, Some(_)) => {
            return Err(refused(
                "frequency_hz has no meaning for the stiffest wall: leave it out",
            ));
        }
        ("most-damping", None, Some(frequency_hz)) => Wish::MostDamping { frequency_hz },
        ("most-damping", None, None) => {
            return Err(refused(
                "frequency_hz is missing: the most damping is asked for there",
            ));
        }
        ("tissue", Some((material, area, thickness)), frequency_hz) => Wish::Tissue {
            material: ModelledTissue::new(material.get().0.clone())
                .map_err(|failure| failed(&failure))?,
            specimen: Specimen::new(SquareMetres(area), Metres(thickness)).or_refused()?,
            frequency_hz: frequency_hz.unwrap_or(1.0),
        },
        ("tissue", None, _) => return Err(refused("tissue is missing: give one of the library")),
        ("stiffest-wall" | "most-damping", Some(_), _) => {
            return Err(refused(
                "a tissue has no meaning without wish=\"tissue\": leave it out",
            ));
        }
        _ => {
            return Err(refused(format_args!(
                "wish \"{wish}\" is not one of stiffest-wall, most-damping, tissue"
            )));
        }
    })
}

/// The best wall by computation.
#[expect(
    clippy::too_many_arguments,
    reason = "the wrapper in Python names them"
)]
#[pyfunction]
pub(crate) fn design<'py>(
    parameters: &Bound<'py, PyDict>,
    wish: &str,
    tissue: Option<WishedTissue<'py>>,
    frequency_hz: Option<f64>,
    gain_margin: Option<f64>,
    orders: Vec<f64>,
    force_noise_limit_n: Option<f64>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = parameters.py();
    let wall = bench(parameters)?;
    let wish = wish_of(wish, tissue, frequency_hz)?;
    let design = Design {
        device: Device {
            plant: wall.setup.device,
            sensors: wall.setup.sensors,
            force_limit_n: wall.setup.plan.force_limit_n,
        },
        scheme: wall.scheme,
        orders: orders_of(orders)?,
        gain_margin,
        wish,
        force_noise_limit_n,
    };
    let report = conduct(py, progress, Interrupted::Forgotten, move |conduct| {
        let report = design.answer(conduct.stop(), &|orders| conduct.add(orders));
        report.map_err(|failure| failed(&failure))
    })?;
    to_python(py, &report)
}
