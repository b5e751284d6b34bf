//! Plants: a mass with damper and hand, or any matrices, behind a delay and a current lag.

use crate::arrays::{Array, matrix, vector};
use crate::refused::{OrRefused as _, refused};
use haptic_analysis::{Dynamics, ForcePath, SampledPlant};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A device as every analysis takes it; `fractional_haptics.analysis.Device` says what is what.
#[pyclass(
    name = "Device",
    module = "fractional_haptics.analysis",
    frozen,
    get_all,
    subclass
)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct PyDevice {
    /// m in kg.
    mass_kg: f64,
    /// b in N·s/m.
    damping_n_s_per_m: f64,
    /// k of the hand in N/m.
    hand_stiffness_n_per_m: f64,
    /// Delay in s.
    delay_s: f64,
    /// tau in s.
    current_lag_s: f64,
}

impl PyDevice {
    pub(super) fn dynamics(&self) -> Dynamics {
        Dynamics {
            mass_kg: self.mass_kg,
            damping_n_s_per_m: self.damping_n_s_per_m,
            hand_stiffness_n_per_m: self.hand_stiffness_n_per_m,
            delay_s: self.delay_s,
            current_lag_s: self.current_lag_s,
        }
    }
}

#[pymethods]
impl PyDevice {
    #[new]
    #[pyo3(signature = (mass_kg, damping_n_s_per_m, hand_stiffness_n_per_m = 0.0, delay_s = 0.0, current_lag_s = 0.0))]
    fn new(
        mass_kg: f64,
        damping_n_s_per_m: f64,
        hand_stiffness_n_per_m: f64,
        delay_s: f64,
        current_lag_s: f64,
    ) -> PyResult<Self> {
        let device = Self {
            mass_kg,
            damping_n_s_per_m,
            hand_stiffness_n_per_m,
            delay_s,
            current_lag_s,
        };
        device.dynamics().checked().or_refused()?;
        Ok(device)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (f64, f64, f64, f64, f64)) {
        let device = slf.get();
        let arguments = (
            device.mass_kg,
            device.damping_n_s_per_m,
            device.hand_stiffness_n_per_m,
            device.delay_s,
            device.current_lag_s,
        );
        (slf.get_type().into_any(), arguments)
    }
}

/// Any linear plant from force to position: ``x' = A x + B u(t - delay)``, ``y = C x``.
///
/// Parameters
/// ----------
/// a : array_like, shape (n, n)
///     1/s.
/// b, c : array_like, n numbers of any shape
///     u in N, y in m.
/// delay_s : float, default 0
///     As in `Device`.
/// current_lag_s : float, default 0
///     As in `Device`, if `a` does not have it.
/// mass_kg : float, default 1
///     Unit of mass inside; no result depends on it.
///
/// Raises
/// ------
/// ValueError
///     Sizes that do not fit; a delay, lag or mass outside its range.
#[pyclass(name = "LinearPlant", module = "fractional_haptics.analysis", frozen)]
#[derive(Clone, Debug)]
pub(crate) struct PyLinearPlant {
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    delay_s: f64,
    current_lag_s: f64,
    mass_kg: f64,
}

/// The numbers of a column or a row.
fn flat(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let raveled = x.py().import("numpy")?.call_method1("ravel", (x,))?;
    vector(name, &raveled)
}

#[pymethods]
impl PyLinearPlant {
    #[new]
    #[pyo3(signature = (a, b, c, delay_s = 0.0, current_lag_s = 0.0, mass_kg = 1.0))]
    fn new(
        a: &Bound<'_, PyAny>,
        b: &Bound<'_, PyAny>,
        c: &Bound<'_, PyAny>,
        delay_s: f64,
        current_lag_s: f64,
        mass_kg: f64,
    ) -> PyResult<Self> {
        let (a, [rows, columns]) = matrix("a", a)?;
        let (b, c) = (flat("b", b)?, flat("c", c)?);
        if [columns, b.len(), c.len()].iter().any(|&n| n != rows) {
            return Err(refused(format_args!(
                "a of shape ({rows}, {columns}), b of {} and c of {} numbers do not fit: with n states a is n by n, b and c have n",
                b.len(),
                c.len()
            )));
        }
        Dynamics {
            delay_s,
            current_lag_s,
            ..Dynamics::ideal(mass_kg, 0.0)
        }
        .checked()
        .or_refused()?;
        Ok(Self {
            a,
            b,
            c,
            delay_s,
            current_lag_s,
            mass_kg,
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, plant) = (slf.py(), slf.get());
        let rows = plant.a.chunks(plant.b.len().max(1));
        let rows: Vec<_> = rows
            .map(|row| PyTuple::new(py, row))
            .collect::<PyResult<_>>()?;
        let arguments = (
            PyTuple::new(py, rows)?,
            PyTuple::new(py, &plant.b)?,
            PyTuple::new(py, &plant.c)?,
            plant.delay_s,
            plant.current_lag_s,
            plant.mass_kg,
        );
        Ok((slf.get_type(), arguments).into_pyobject(py)?.into_any())
    }

    /// A, in rows: n² numbers.
    #[getter]
    fn _a(&self) -> Array<f64> {
        Array::of(self.a.to_vec())
    }

    /// B.
    #[getter]
    fn _b(&self) -> Array<f64> {
        Array::of(self.b.to_vec())
    }

    /// C.
    #[getter]
    fn _c(&self) -> Array<f64> {
        Array::of(self.c.to_vec())
    }
}

/// Any of them; alive as long as work with it.
#[derive(Debug, FromPyObject, IntoPyObjectRef)]
pub(crate) enum AnyPlant {
    Device(Py<PyDevice>),
    Linear(Py<PyLinearPlant>),
}

impl AnyPlant {
    /// Plant as the loop sees it once a sample.
    pub(super) fn sampled(&self, sample_time: f64) -> PyResult<SampledPlant> {
        match self {
            Self::Device(device) => device.get().dynamics().plant(sample_time).or_refused(),
            Self::Linear(plant) => {
                let model = plant.get();
                let path = self.path(sample_time)?;
                SampledPlant::linear(
                    &model.a,
                    &model.b,
                    &model.c,
                    sample_time,
                    model.mass_kg,
                    path,
                )
                .or_refused()
            }
        }
    }

    /// The mass in α and β.
    pub(super) fn mass_kg(&self) -> f64 {
        match self {
            Self::Device(device) => device.get().mass_kg,
            Self::Linear(plant) => plant.get().mass_kg,
        }
    }

    /// The way of the force, in samples.
    pub(super) fn path(&self, sample_time: f64) -> PyResult<ForcePath> {
        let (delay_s, current_lag_s) = match self {
            Self::Device(device) => (device.get().delay_s, device.get().current_lag_s),
            Self::Linear(plant) => (plant.get().delay_s, plant.get().current_lag_s),
        };
        path(delay_s, current_lag_s, sample_time)
    }
}

/// Delay and lag in samples.
pub(super) fn path(delay_s: f64, current_lag_s: f64, sample_time: f64) -> PyResult<ForcePath> {
    let dynamics = Dynamics {
        delay_s,
        current_lag_s,
        ..Dynamics::ideal(1.0, 0.0)
    };
    dynamics.path(sample_time).or_refused()
}
