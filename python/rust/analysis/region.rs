//! Regions of stable walls.

use super::plant::AnyPlant;
use super::{operator, scheme_of};
use crate::arrays::{Array, Whole, any_shape, unmasked};
use crate::conducted::{heard, heard_by};
use crate::refused::{OrRefused as _, refused};
use haptic_analysis::{Nondimensional, OutlinePoint, Polygon, StabilityRegion, StableArea};
use pyo3::prelude::*;
use std::time::Duration;

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
    made: Made,
}

/// The arguments of a region: plant, order, sample time, scheme, points, horizon.
type Made = (AnyPlant, f64, f64, String, usize, f64);

/// Beyond this a picture has nothing to gain, and memory much to lose.
const POINTS_MOST: usize = 10_000_000;

impl PyRegion {
    fn area(&self) -> Option<&StableArea> {
        self.region.bounded()
    }

    fn outlines(&self) -> impl Iterator<Item = &Polygon> {
        self.area().into_iter().flat_map(|area| &area.polygons)
    }
}

/// The α, β of a plant that is stable, with units.
#[pyfunction]
pub(crate) fn stability_region(
    py: Python<'_>,
    plant: AnyPlant,
    order: f64,
    sample_time: f64,
    scheme: String,
    points: Whole,
    horizon: f64,
) -> PyResult<PyRegion> {
    let points = points.within("points", 0..=POINTS_MOST)?;
    heard(py, Duration::MAX, move |_| {
        let operator = operator(order, sample_time, &scheme, horizon)?;
        let sampled = plant.sampled(sample_time)?;
        let one = Nondimensional {
            alpha: 1.0,
            beta: 1.0,
            delta: 0.0,
            gamma: 0.0,
        };
        let unit = one
            .with_units(plant.mass_kg(), sample_time, operator.order())
            .or_refused()?;
        let region = StabilityRegion::new(sampled, &operator, 0, points);
        let scheme = scheme_of(&scheme)?.to_string();
        Ok(PyRegion {
            region: region.or_refused()?,
            stiffness: unit.stiffness_n_per_m,
            dissipation: unit.dissipation_n_s_mu_per_m,
            sample_time,
            made: (plant, order, sample_time, scheme, points, horizon),
        })
    })
}

#[pymethods]
impl PyRegion {
    /// No wall is stable.
    #[getter]
    fn is_empty(&self) -> bool {
        self.region.bounded().is_none()
    }

    /// Boundaries, the largest first: K in N/m and B in N·s^order/m of each point.
    #[getter]
    fn polygons(&self) -> Vec<Array<f64>> {
        let array = |points: &[OutlinePoint]| {
            let both = |point: &OutlinePoint| {
                [point.alpha * self.stiffness, point.beta * self.dissipation]
            };
            let rows = points.iter().flat_map(both).collect();
            Array::shaped(rows, vec![points.len(), 2])
        };
        let arrays = self.outlines().map(|polygon| array(&polygon.points));
        arrays.collect()
    }

    /// Frequency at which a pole crosses the circle at each point, rad/s; NaN on an axis.
    #[getter]
    fn omega_rad_s(&self) -> Vec<Array<f64>> {
        let omega = |point: &OutlinePoint| {
            let theta = point.theta.unwrap_or(f64::NAN);
            theta / self.sample_time
        };
        self.outlines()
            .map(|polygon| Array::of(polygon.points.iter().map(omega).collect()))
            .collect()
    }

    /// Area of each polygon in the product of both units; negative for a hole.
    #[getter]
    fn areas(&self) -> Array<f64> {
        let unit = self.stiffness * self.dissipation;
        Array::of(self.outlines().map(|polygon| polygon.area * unit).collect())
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
        slf: &Bound<'py, Self>,
        stiffness_n_per_m: &Bound<'py, PyAny>,
        dissipation_n_s_mu_per_m: &Bound<'py, PyAny>,
    ) -> PyResult<Array<bool>> {
        let py = slf.py();
        unmasked("stiffness_n_per_m", stiffness_n_per_m)?;
        unmasked("dissipation_n_s_mu_per_m", dissipation_n_s_mu_per_m)?;
        let both = (stiffness_n_per_m, dissipation_n_s_mu_per_m);
        let numpy = py.import("numpy")?;
        let both = numpy
            .call_method1("broadcast_arrays", both)
            .map_err(refused)?;
        let (stiffness, shape) = any_shape("stiffness_n_per_m", &both.get_item(0)?)?;
        let (dissipation, _) = any_shape("dissipation_n_s_mu_per_m", &both.get_item(1)?)?;
        let inside: Vec<bool> = heard_by(slf, move |region, _| {
            let within = |(k, b): (&f64, &f64)| {
                (region.region).contains(k / region.stiffness, b / region.dissipation)
            };
            Ok(stiffness.iter().zip(&dissipation).map(within).collect())
        })?;
        Ok(Array::shaped(inside, shape))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, region) = (slf.py(), slf.get());
        let native = py.import("fractional_haptics._native")?;
        let made = (native.getattr("stability_region")?, &region.made);
        Ok(made.into_pyobject(py)?.into_any())
    }
}
