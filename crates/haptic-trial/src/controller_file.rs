//! Controller files: TOML, one table for the controller, `[loop]` for how it runs, `[source]` for where it comes from.
//!
//! ```toml
//! [pid]                               # or [tid], [crone], [lead_lag], [transfer_function]
//! proportional_gain = 2.0
//! integral_gain_per_s_lambda = 1.0
//! integral_order = 0.8
//! derivative_gain_s_mu = 0.1
//! derivative_order = 0.6
//!
//! [loop]
//! sample_time_s = 0.01
//! output_low = -3.0
//! output_high = 3.0
//!
//! [source]
//! plant = "1/(0.8s^2.2+0.5s^0.9+1)"
//! ```

use fracdiff::{Scheme, Seconds};
use fractional_control::{
    ControllerParameters, ControllerSetup, CroneParameters, FractionalTransferFunction,
    LeadLagParameters, PidParameters, TidParameters, rule_of_scheme,
};
use haptic_document::{
    FileError, Parsed, Table, lines_of, parameters as p, parameters::Parameter, text_of,
};
use std::path::Path;

#[cfg(test)]
mod tests;

/// A controller and where it comes from.
///
/// ```no_run
/// use haptic_trial::ControllerFile;
/// use std::path::Path;
///
/// let file = ControllerFile::read(Path::new("lab/pid.toml"))?;
/// assert_eq!(file.setup.pid().map(|pid| pid.proportional), Some(2.0));
/// println!("{}", file.to_toml());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerFile {
    /// The controller and how it runs.
    pub setup: ControllerSetup,
    /// Empty in a file that a person wrote.
    pub origin: ControllerOrigin,
}

/// Origin of a controller, in words; a field is empty if unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ControllerOrigin {
    /// The plant it was made for.
    pub plant: String,
    /// The wishes it was made for.
    pub wishes: String,
    /// The program that made it.
    pub program: String,
    /// A comment for readers of the file, without effect.
    pub note: String,
}

impl From<ControllerSetup> for ControllerFile {
    fn from(setup: ControllerSetup) -> Self {
        Self {
            setup,
            origin: ControllerOrigin::default(),
        }
    }
}

/// Tables with a controller, and their keys.
const LAWS: [(&str, &[Parameter]); 5] = [
    ("pid", p::PID),
    ("tid", p::TID),
    ("crone", p::CRONE),
    ("lead_lag", p::LEAD_LAG),
    ("transfer_function", p::TRANSFER_CONTROLLER),
];
const CHOICE: &str = "a controller file has [loop] and one of [pid], [tid], [crone], [lead_lag], [transfer_function]";

impl ControllerFile {
    /// The tables of laws, of which a file has one beside `[loop]`.
    pub fn laws() -> impl Iterator<Item = &'static str> {
        LAWS.iter().map(|law| law.0)
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &text_of(path, "controller")?)
    }

    /// Reads and checks the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        let document = Parsed::of(path, text)?;
        let laws = LAWS.map(|(name, _)| name);
        let mut of_plants = ["device", "state_space", "transfer_function"].into_iter();
        if !document.has("loop") && of_plants.any(|table| document.has(table)) {
            let key = p::CONTROLLER_SAMPLE_TIME.key;
            return Err(FileError::wording(
                "",
                format_args!(
                    "{}: a plant, or a controller without [loop] and its `{key}`: `control design` makes a controller for a plant",
                    path.display()
                ),
            ));
        }
        let (name, law, mut tables) =
            document.one_of(&laws, &["loop", "source"], "controller", CHOICE)?;
        let known = LAWS.iter().find(|(law, _)| *law == name);
        let law = law.with_keys(known.map(std::slice::from_ref).unwrap_or_default())?;
        let running = tables.remove("loop").ok_or_else(|| {
            let key = p::CONTROLLER_SAMPLE_TIME.key;
            let missing = format!("missing table [loop]: add it with `{key}`");
            document.fail(missing).of_file(String::new())
        })?;
        let running = running.with_keys(&[("loop", p::CONTROLLER_LOOP)])?;
        // The sample time stands in `[loop]`.
        let mut setup = ControllerSetup::new(blank(name, &law)?, Seconds(1.0));
        for (key, number) in numbers(&mut setup).1 {
            *number = if key.default_number().is_nan() {
                law.required(&key)?
            } else {
                law.number(&key)?
            };
        }
        let setup = in_loop(setup, &running)?;
        let mut origin = ControllerOrigin::default();
        if let Some(table) = tables.remove("source") {
            let table = table.with_keys(&[("source", p::CONTROLLER_SOURCE)])?;
            let text = |parameter| table.text(parameter).map(str::to_owned);
            origin = ControllerOrigin {
                plant: text(&p::SOURCE_PLANT)?,
                wishes: text(&p::SOURCE_WISHES)?,
                program: text(&p::SOURCE_PROGRAM)?,
                note: text(&p::SOURCE_NOTE)?,
            };
        }
        setup.check().map_err(|error| law.fail(error))?;
        Ok(Self { setup, origin })
    }

    /// The text of a file that reads back to the same.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let Self { setup, origin } = self;
        let running = [
            (p::MEMORY, setup.memory_s),
            (p::OUTPUT_LOW, setup.output_low),
            (p::OUTPUT_HIGH, setup.output_high),
            (p::FADE_TIME, Some(setup.fade_time_s)),
        ];
        let running = running
            .into_iter()
            .filter_map(|(parameter, value)| Some((parameter, value?)));
        let source = source([
            (p::SOURCE_PLANT, &origin.plant),
            (p::SOURCE_WISHES, &origin.wishes),
            (p::SOURCE_PROGRAM, &origin.program),
            (p::SOURCE_NOTE, &origin.note),
        ]);
        format!(
            "{}\n[loop]\n{}{} = \"{}\"\n{}{source}",
            law_lines(setup),
            lines_of([(p::CONTROLLER_SAMPLE_TIME, setup.sample_time_s)]),
            p::CONTROLLER_SCHEME.key,
            setup.scheme,
            lines_of(running)
        )
    }
}

/// `[source]` with what is not empty.
pub fn source<'a>(texts: impl IntoIterator<Item = (Parameter, &'a String)>) -> String {
    let texts = texts.into_iter().filter(|(_, text)| !text.is_empty());
    let lines: String = texts
        .map(|(parameter, text)| {
            format!("{} = {}\n", parameter.key, toml::Value::from(text.as_str()))
        })
        .collect();
    if lines.is_empty() {
        lines
    } else {
        format!("\n[source]\n{lines}")
    }
}

/// A controller whose numbers are still to be read.
fn blank(name: &str, table: &Table<'_>) -> Result<ControllerParameters, FileError> {
    Ok(match name {
        "pid" => PidParameters::default().into(),
        "tid" => TidParameters::default().into(),
        "crone" => CroneParameters::default().into(),
        "lead_lag" => LeadLagParameters::default().into(),
        _ => {
            let function = table.required_text(&p::FUNCTION)?;
            let function = function.parse::<FractionalTransferFunction>();
            function
                .map_err(|error| table.fail_at(p::FUNCTION.key, error))?
                .into()
        }
    })
}

/// The table of a controller, and its numbers by their keys.
fn numbers(setup: &mut ControllerSetup) -> (&'static str, Vec<(Parameter, &mut f64)>) {
    let weights = &mut setup.set_point;
    match &mut setup.law {
        ControllerParameters::Pid(law) => (
            "pid",
            vec![
                (p::PROPORTIONAL_GAIN, &mut law.proportional),
                (p::INTEGRAL_GAIN, &mut law.integral),
                (p::INTEGRAL_ORDER, &mut law.integral_order),
                (p::DERIVATIVE_GAIN, &mut law.derivative),
                (p::DERIVATIVE_ORDER, &mut law.derivative_order),
                (p::SET_POINT_WEIGHT, &mut weights.proportional),
                (p::DERIVATIVE_SET_POINT_WEIGHT, &mut weights.derivative),
            ],
        ),
        ControllerParameters::Tid(law) => (
            "tid",
            vec![
                (p::TILT_GAIN, &mut law.tilt),
                (p::TILT_DIVISOR, &mut law.tilt_divisor),
                (p::TID_INTEGRAL_GAIN, &mut law.integral),
                (p::TID_DERIVATIVE_GAIN, &mut law.derivative),
                (p::DERIVATIVE_SET_POINT_WEIGHT, &mut weights.derivative),
            ],
        ),
        ControllerParameters::Crone(law) => (
            "crone",
            vec![
                (p::CRONE_GAIN, &mut law.gain),
                (p::SHAPED_ORDER, &mut law.order),
                (p::CRONE_LOW, &mut law.low_rad_s),
                (p::CRONE_HIGH, &mut law.high_rad_s),
            ],
        ),
        ControllerParameters::LeadLag(law) => (
            "lead_lag",
            vec![
                (p::LEAD_GAIN, &mut law.gain),
                (p::SHAPED_ORDER, &mut law.order),
                (p::LEAD_LAMBDA, &mut law.lambda_s),
                (p::LEAD_X, &mut law.x),
            ],
        ),
        ControllerParameters::Function(_) | _ => ("transfer_function", Vec::new()),
    }
}

/// The controller with what `[loop]` says.
fn in_loop(setup: ControllerSetup, table: &Table<'_>) -> Result<ControllerSetup, FileError> {
    let sample_time_s = table.number_if(&p::CONTROLLER_SAMPLE_TIME)?;
    // An option takes the place of a value, and there must be one.
    let sample_time_s = sample_time_s.ok_or_else(|| {
        let key = p::CONTROLLER_SAMPLE_TIME.key;
        let missing = format!("missing key `{key}` in [loop]: add it, as in {key} = 0.001");
        table.fail(missing).of_file(String::new())
    })?;
    let refused = |reason: String| table.fail_at(p::CONTROLLER_SCHEME.key, reason);
    let scheme: Scheme = table
        .text(&p::CONTROLLER_SCHEME)?
        .parse()
        .map_err(|error: fracdiff::SchemeError| refused(error.to_string()))?;
    if rule_of_scheme(scheme).is_none() {
        let reason = format!("scheme \"{scheme}\" is not for a controller: give full or full-bdf2");
        return Err(refused(reason));
    }
    let setup = ControllerSetup {
        sample_time_s,
        output_low: table.number_if(&p::OUTPUT_LOW)?,
        output_high: table.number_if(&p::OUTPUT_HIGH)?,
        fade_time_s: table.number(&p::FADE_TIME)?,
        scheme,
        memory_s: table.number_if(&p::MEMORY)?,
        ..setup
    };
    setup.actuator().map_err(|error| {
        table.fail_at(
            p::OUTPUT_LOW.key,
            format!("{error}: change `output_low` or `output_high`"),
        )
    })?;
    Ok(setup)
}

/// The table of the controller, its name first.
fn law_lines(setup: &ControllerSetup) -> String {
    let mut setup = setup.clone();
    let mut function = String::new();
    if let law @ ControllerParameters::Function(_) = &setup.law {
        function = format!("{} = \"{law}\"\n", p::FUNCTION.key);
    }
    let (name, numbers) = numbers(&mut setup);
    let numbers = numbers.into_iter().map(|(key, number)| (key, *number));
    format!("[{name}]\n{function}{}", lines_of(numbers))
}
