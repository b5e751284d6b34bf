//! The PID of order 1 that a fractional controller is compared with.

use crate::{Sampling, Specification, tune_integer};
use fractional_control::{ControlError, ControllerParameters, ControllerSetup, Plant, SetPoint};

/// The PID of order 1 with the crossover and the phase margin of this loop, everything else as in
/// the setup: what a fractional controller is compared with. `None` if the controller is already
/// such a PID.
///
/// # Errors
/// No such PID exists; the plant cannot be simulated.
pub fn integer_baseline(
    setup: &ControllerSetup,
    plant: &Plant,
) -> Result<Option<ControllerSetup>, ControlError> {
    if let ControllerParameters::Pid(law) = setup.law {
        let whole = |gain: f64, order: f64| gain == 0.0 || (order - 1.0).abs() == 0.0;
        if whole(law.integral, law.integral_order) && whole(law.derivative, law.derivative_order) {
            return Ok(None);
        }
    }
    let margins = setup.closed_with(&setup.sampled(plant)?)?.margins();
    let none = ControlError::NotFound {
        what: "a crossover with a phase margin, to compare with an integer-order PID,",
        why: "the loop has none",
    };
    let phase = margins.phase.filter(|phase| phase.value > 0.0);
    let phase = phase.ok_or(none)?;
    let wishes = Specification {
        iso_damping: false,
        ..Specification::new(phase.omega_rad_s, phase.value)
    };
    let sampling = Sampling {
        sample_time: setup.sample_time(),
        rule: setup.memory()?.rule(),
    };
    let tuned = tune_integer(plant, Some(sampling), &wishes)?;
    let is_pid = setup.pid().is_some();
    Ok(Some(ControllerSetup {
        law: tuned.parameters.into(),
        set_point: if is_pid {
            setup.set_point
        } else {
            SetPoint::ERROR
        },
        ..setup.clone()
    }))
}
