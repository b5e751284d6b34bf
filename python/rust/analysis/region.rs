//! Regions of stable walls.

use super::operator;
use super::plant::AnyPlant;
use crate::arrays::any_shape;
use crate::refused::{OrRefused as _, refused};
use fracdiff::Order;
use haptic_analysis::{Nondimensional, StabilityRegion, StableArea};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;

/// All stable walls of an order on a plant, made by `region`.
///
/// Notes
/// -----
/// Outer boundaries run anticlockwise in K (right) and B (up), holes clockwise; the last point is followed by the first.
#[pyclass(name = "Region", module = "fractional_haptics.analysis", frozen)]
#[derive(Debug)]
pub(crate) struct PyRegion {
    region: StabilityRegion,
    /// N/m and N·s^μ/m of α and β of 1.
    stiffness: f64,
    dissipation: f64,
    sample_time: f64,
}

impl PyRegion {
    fn area(&self) -> Option<&StableArea> {
        self.region.bounded()
    }
}

/// The α, β of a plant that is stable, with units.
#[pyfunction]
pub(crate) fn stability_region(
    py: Python<'_>,
    plant: AnyPlant<'_>,
    order: f64,
    sample_time: f64,
    scheme: &str,
    points: usize,
    horizon: f64,
) -> PyResult<PyRegion> {
    let operator = operator(order, sample_time, scheme, horizon)?;
    let sampled = plant.sampled(sample_time)?;
    let one = Nondimensional {
        alpha: 1.0,
        beta: 1.0,
        delta: 0.0,
        gamma: 0.0,
    };
    let order = Order::new(order).or_refused()?;
    let unit = one
        .with_units(plant.mass_kg(), sample_time, order)
        .or_refused()?;
    // Beyond this a picture has nothing to gain, and memory much to lose.
    if points > 10_000_000 {
        return Err(refused(format_args!(
            "{points} points are not in [0, 10000000]"
        )));
    }
    let region = py.detach(|| StabilityRegion::new(sampled, &operator, 0, points));
    Ok(PyRegion {
        region: region.or_refused()?,
        stiffness: unit.stiffness_n_per_m,
        dissipation: unit.dissipation_n_s_mu_per_m,
        sample_time,
    })
}

#[pymethods]
impl PyRegion {
    /// No wall is stable.
    #[getter]
    fn is_empty(&self) -> bool {
        self.region.is_empty()
    }

    /// Boundaries, the largest first: K in N/m and B in N·s^order/m of each point.
    #[getter]
    fn polygons<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray2<f64>>> {
        let polygons = self.area().into_iter().flat_map(|area| &area.polygons);
        let array = |points: &[haptic_analysis::BoundaryPoint]| {
            Array2::from_shape_fn((points.len(), 2), |(row, column)| match column {
                0 => points[row].alpha * self.stiffness,
                _ => points[row].beta * self.dissipation,
            })
        };
        polygons
            .map(|polygon| array(&polygon.points).into_pyarray(py))
            .collect()
    }

    /// Frequency at which a pole crosses the circle at each point, rad/s; NaN on an axis.
    #[getter]
    fn omega_rad_s<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<f64>>> {
        let polygons = self.area().into_iter().flat_map(|area| &area.polygons);
        let omega = |point: &haptic_analysis::BoundaryPoint| {
            point
                .theta
                .map_or(f64::NAN, |theta| theta / self.sample_time)
        };
        polygons
            .map(|polygon| PyArray1::from_iter(py, polygon.points.iter().map(omega)))
            .collect()
    }

    /// Area of each polygon in the product of both units; negative for a hole.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let polygons = self.area().into_iter().flat_map(|area| &area.polygons);
        let unit = self.stiffness * self.dissipation;
        PyArray1::from_iter(py, polygons.map(|polygon| polygon.area * unit))
    }

    /// Least upper bound of K.
    #[getter]
    fn stiffness_max_n_per_m(&self) -> f64 {
        self.area()
            .map_or(0.0, |area| area.alpha_max * self.stiffness)
    }

    /// B where K has it.
    #[getter]
    fn dissipation_at_stiffness_max_n_s_mu_per_m(&self) -> f64 {
        self.area()
            .map_or(f64::NAN, |area| area.beta_at_alpha_max * self.dissipation)
    }

    /// Least upper bound of B.
    #[getter]
    fn dissipation_max_n_s_mu_per_m(&self) -> f64 {
        self.area()
            .map_or(0.0, |area| area.beta_max * self.dissipation)
    }

    /// Is a wall stable? Read from the polygons: right up to their chords.
    ///
    /// Parameters
    /// ----------
    /// stiffness_n_per_m, dissipation_n_s_mu_per_m : array_like
    ///     K and B, of the same shape or such as broadcast.
    ///
    /// Returns
    /// -------
    /// ndarray of bool
    fn contains<'py>(
        &self,
        stiffness_n_per_m: &Bound<'py, PyAny>,
        dissipation_n_s_mu_per_m: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let py = stiffness_n_per_m.py();
        let both = (stiffness_n_per_m, dissipation_n_s_mu_per_m);
        let numpy = py.import("numpy")?;
        let both = numpy
            .call_method1("broadcast_arrays", both)
            .map_err(refused)?;
        let (stiffness, shape) = any_shape("stiffness_n_per_m", &both.get_item(0)?)?;
        let (dissipation, _) = any_shape("dissipation_n_s_mu_per_m", &both.get_item(1)?)?;
        let inside: Vec<bool> = py.detach(|| {
            let walls = stiffness.iter().zip(&dissipation);
            walls
                .map(|(k, b)| {
                    self.region
                        .contains(k / self.stiffness, b / self.dissipation)
                })
                .collect()
        });
        inside.into_pyarray(py).reshape(shape)
    }

    fn __repr__(&self) -> String {
        format!(
            "<Region of {} polygons, K up to {} N/m, B up to {} N·s^μ/m>",
            self.area().map_or(0, |area| area.polygons.len()),
            self.stiffness_max_n_per_m(),
            self.dissipation_max_n_s_mu_per_m()
        )
    }
}
