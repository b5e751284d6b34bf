//! A controller as a header.

use super::{Arguments, named};
use crate::output::Output;
use fracdiff_c::{CHeader, CNumber};
use fractional_control::{ControllerList, ControllerParameters, ControllerSetup, rule_of_scheme};
use haptic_experiment::{Failure, Named as _, Precision};
use haptic_trial::advice::refused;
use serde_json::json;

impl Arguments {
    /// Writes a controller, its memory as `--horizon` says.
    pub(super) fn controller(
        &self,
        mut setup: ControllerSetup,
        output: Output,
    ) -> Result<(), Failure> {
        if setup.function().is_some() {
            return Err(Failure::bad_input(
                "a transfer function cannot be exported to C: give --controller with a PI^λD^μ, TID, CRONE or lead-lag",
            ));
        }
        if rule_of_scheme(setup.scheme).is_none() {
            return Err(Failure::bad_input(format_args!(
                "scheme {} is not for a controller: give --scheme full or full-bdf2",
                setup.scheme
            )));
        }
        setup.memory_s = self.horizon.or(setup.memory_s);
        let header = match self.precision {
            Precision::F32 => self.controller_header::<f32>(&setup)?,
            Precision::F64 => self.controller_header::<f64>(&setup)?,
        };
        let what = json!({
            "controller": setup.law.to_string(),
            "sample_time_s": setup.sample_time_s,
            "scheme": setup.scheme.to_string(),
            "horizon_s": setup.horizon_s(),
        });
        self.write(header, output, what)
    }

    fn controller_header<F: CNumber>(&self, setup: &ControllerSetup) -> Result<String, Failure> {
        let list = ControllerList::<F>::new(setup).map_err(refused)?;
        let (b, c) = (setup.set_point.proportional, setup.set_point.derivative);
        let weights = if matches!(setup.law, ControllerParameters::Pid(_)) {
            format!(" of b r - y, r - y and c r - y, b = {b}, c = {c}")
        } else if matches!(setup.law, ControllerParameters::Tid(_)) {
            format!(" of r - y, r - y and c r - y, c = {c}")
        } else {
            " of r - y".to_owned()
        };
        let [low, high] = list.limits;
        let notes = [
            format!("u = C(s){weights}, C(s) = {}.", setup.law),
            format!(
                "Limits {low} to {high}, sample time {} s, scheme {} over {} s, {}.",
                setup.sample_time_s,
                setup.scheme,
                setup.horizon_s(),
                self.precision.name()
            ),
            format!("Made by host-cli {} export-c.", env!("CARGO_PKG_VERSION")),
        ];
        let header = CHeader::of_controller(&self.name, &list, &notes).map_err(named)?;
        Ok(header.to_string())
    }
}
