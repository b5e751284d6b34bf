//! From TOML to a controller.

use super::content::{ControllerFile, ControllerOrigin};
use crate::document::Parsed;
use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::parameters::Parameter;
use crate::document::reader::Table;
use fracdiff::{Scheme, Seconds};
use fractional_control::{
    ControllerParameters, ControllerSetup, CroneParameters, FractionalTransferFunction,
    LeadLagParameters, PidParameters, SetPoint, TidParameters, rule_of_scheme,
};
use std::path::Path;

/// Tables with a controller, and their keys.
const LAWS: [(&str, &[Parameter]); 5] = [
    ("pid", p::PID),
    ("tid", p::TID),
    ("crone", p::CRONE),
    ("lead_lag", p::LEAD_LAG),
    ("transfer_function", p::TRANSFER_CONTROLLER),
];
const CHOICE: &str = "a controller file has one of [pid], [tid], [crone], [lead_lag], [transfer_function], then [loop] and perhaps \
                      [source]";

pub(super) fn parse(path: &Path, text: &str) -> Result<ControllerFile, FileError> {
    let document = Parsed::of(path, text)?;
    let names: Vec<&str> = LAWS.iter().map(|(name, _)| *name).collect();
    let names = [&names[..], &["loop", "source"]].concat();
    let (mut law, mut running, mut source) = (None, None, None);
    for (name, table) in document.tables(&names, CHOICE)? {
        match LAWS.iter().find(|(law, _)| *law == name) {
            Some(_) if law.is_some() => {
                return Err(table.fail(format!("a second controller [{name}]: {CHOICE}")));
            }
            Some(known) => law = Some((name, table.with_keys(&[*known])?)),
            None if name == "loop" => {
                running = Some(table.with_keys(&[("loop", p::CONTROLLER_LOOP)])?);
            }
            None => source = Some(table.with_keys(&[("source", p::CONTROLLER_SOURCE)])?),
        }
    }
    let (name, law) = law.ok_or_else(|| document.fail(format!("no controller: {CHOICE}")))?;
    let running = running.ok_or_else(|| {
        let key = p::CONTROLLER_SAMPLE_TIME.key;
        document.fail(format!("missing table [loop]: give it with `{key}`"))
    })?;
    let mut setup = in_loop(self::law(name, &law)?, &running)?;
    if matches!(name, "pid" | "tid") {
        setup.set_point.derivative = law.number(&p::DERIVATIVE_SET_POINT_WEIGHT)?;
    }
    if name == "pid" {
        setup.set_point.proportional = law.number(&p::SET_POINT_WEIGHT)?;
    }
    let mut origin = ControllerOrigin::default();
    if let Some(table) = source {
        let text = |parameter| table.text(parameter).map(str::to_owned);
        origin = ControllerOrigin {
            plant: text(&p::SOURCE_PLANT)?,
            wishes: text(&p::SOURCE_WISHES)?,
            program: text(&p::SOURCE_PROGRAM)?,
            note: text(&p::SOURCE_NOTE)?,
        };
    }
    setup.check().map_err(|error| law.fail(error.to_string()))?;
    Ok(ControllerFile { setup, origin })
}

fn law(name: &str, table: &Table<'_>) -> Result<ControllerParameters, FileError> {
    Ok(match name {
        "pid" => PidParameters {
            proportional: table.number(&p::PROPORTIONAL_GAIN)?,
            integral: table.number(&p::INTEGRAL_GAIN)?,
            integral_order: table.number(&p::INTEGRAL_ORDER)?,
            derivative: table.number(&p::DERIVATIVE_GAIN)?,
            derivative_order: table.number(&p::DERIVATIVE_ORDER)?,
        }
        .into(),
        "tid" => TidParameters {
            tilt: table.required(&p::TILT_GAIN)?,
            tilt_divisor: table.number(&p::TILT_DIVISOR)?,
            integral: table.number(&p::TID_INTEGRAL_GAIN)?,
            derivative: table.number(&p::TID_DERIVATIVE_GAIN)?,
        }
        .into(),
        "crone" => CroneParameters {
            gain: table.required(&p::SHAPED_GAIN)?,
            order: table.required(&p::SHAPED_ORDER)?,
            low_rad_s: table.required(&p::CRONE_LOW)?,
            high_rad_s: table.required(&p::CRONE_HIGH)?,
        }
        .into(),
        "lead_lag" => LeadLagParameters {
            gain: table.required(&p::SHAPED_GAIN)?,
            order: table.required(&p::SHAPED_ORDER)?,
            lambda_s: table.required(&p::LEAD_LAMBDA)?,
            x: table.required(&p::LEAD_X)?,
        }
        .into(),
        _ => {
            let function = table.required_text(&p::FUNCTION)?;
            let function = function.parse::<FractionalTransferFunction>();
            function
                .map_err(|error| table.fail_at(p::FUNCTION.key, error.to_string()))?
                .into()
        }
    })
}

/// The controller with what `[loop]` says.
fn in_loop(law: ControllerParameters, table: &Table<'_>) -> Result<ControllerSetup, FileError> {
    let sample_time = Seconds(table.required(&p::CONTROLLER_SAMPLE_TIME)?);
    let refused = |reason: String| table.fail_at(p::CONTROLLER_SCHEME.key, reason);
    let scheme: Scheme = table
        .text(&p::CONTROLLER_SCHEME)?
        .parse()
        .map_err(|error: fracdiff::SchemeError| refused(error.to_string()))?;
    if rule_of_scheme(scheme).is_none() {
        let reason = format!("scheme \"{scheme}\" is none of a controller: give full or full-bdf2");
        return Err(refused(reason));
    }
    let setup = ControllerSetup {
        set_point: SetPoint::DEFAULT,
        output_low: table.number_if(&p::OUTPUT_LOW)?,
        output_high: table.number_if(&p::OUTPUT_HIGH)?,
        fade_time_s: table.number(&p::FADE_TIME)?,
        scheme,
        memory_s: table.number_if(&p::MEMORY)?,
        ..ControllerSetup::new(law, sample_time)
    };
    setup.actuator().map_err(|error| {
        table.fail_at(
            p::OUTPUT_LOW.key,
            format!("{error}: change `output_low` or `output_high`"),
        )
    })?;
    Ok(setup)
}
