//! Options made from the tables of parameters, and values as `KEY=VALUE`: both write a document.
//!
//! An option is a key without its unit: `--sample-time 1ms` and `sample_time=1ms` are `sample_time_s = 0.001` in a file.

use self::keys::Named;
use crate::files::Files;
use crate::names::option_of;
use crate::parse::read_whole;
use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use haptic_document::{Document, short};
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{
    ADMITTANCE_TABLE, AT_A_DEVICE, BESIDE, DRIVE_TABLE, KINDS, Parameter, QUESTIONS, Value as Kind,
    choices, of_kind,
};
use haptic_quantity::{doubt, kind_of_key, parse_for_key, without_unit};
use haptic_trial::DeviceModel;
use haptic_trial::device_table::is_robot;
use serde::de::DeserializeOwned;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use toml::Value;

/// Options and values of a command, as they were typed.
#[derive(Clone, Debug)]
pub(crate) struct Options<N> {
    /// Each with its text and the words in which it was said.
    options: Vec<(&'static Parameter, String, String)>,
    values: Vec<String>,
    named: PhantomData<N>,
}

/// Placeholder in the usage of a command that accepts any key.
pub(crate) const VALUES: &str = "KEY=VALUE";

/// The keys of the documents of a command, without their units.
pub(crate) fn names(command: &str) -> Vec<&'static str> {
    let all = KINDS.into_iter().chain(QUESTIONS).chain(AT_A_DEVICE);
    let mut kinds: Vec<&str> = match command {
        "run" => KINDS.to_vec(),
        "teleoperate" => vec!["teleoperation"],
        command => all.filter(|kind| *kind == command).collect(),
    };
    if kinds
        .iter()
        .any(|kind| ["relax", "creep", "press"].contains(kind))
    {
        kinds.push(DRIVE_TABLE);
    }
    if command == "run" {
        kinds.push(ADMITTANCE_TABLE);
    }
    let tables = kinds.into_iter().flat_map(of_kind);
    let parameters = tables.flat_map(|(_, table)| table);
    parameters
        .map(|parameter| without_unit(parameter.key))
        .collect()
}

/// A text as the value of a parameter, in SI units, for a key that was written so; without its unit it says nothing of that of a number.
fn value_of(written: &str, parameter: &Parameter, text: &str) -> Result<Value, String> {
    let key = parameter.key;
    if !written.ends_with(key) {
        doubt(key, text)?;
    }
    let number = |text: &str| parse_for_key(key, text).map_err(|error| error.to_string());
    match parameter.value {
        Kind::Number(..) => number(text).map(Value::from),
        Kind::Count(_) => {
            let count = read_whole(text).and_then(|count| i64::try_from(count).ok());
            let none = || format!("\"{text}\" is not a whole number, 0 or more");
            count.map(Value::from).ok_or_else(none)
        }
        Kind::Flag(_) => match text.to_lowercase().as_str() {
            "true" | "yes" | "on" => Ok(Value::from(true)),
            "false" | "no" | "off" => Ok(Value::from(false)),
            _ => Err(format!("\"{text}\" is not true or false")),
        },
        Kind::List(_) => {
            let text = text.trim();
            let inside = text
                .strip_prefix('[')
                .and_then(|text| text.strip_suffix(']'));
            let inside = inside.unwrap_or(text);
            if inside.trim_start().starts_with('[') {
                let table: Result<toml::Table, _> = format!("rows = {text}").parse();
                let rows = table.ok().and_then(|mut table| table.remove("rows"));
                return rows.ok_or_else(|| {
                    format!("\"{text}\" is not a list of rows, as [[0, 1], [0, -5]]")
                });
            }
            let numbers = inside.split(',').map(|text| number(text).map(Value::from));
            numbers.collect::<Result<_, _>>().map(Value::Array)
        }
        Kind::Text(_) => Ok(Value::from(text)),
    }
}

pub(crate) fn help(parameter: &Parameter) -> String {
    let Parameter { shown, help, .. } = parameter;
    if shown.is_empty() {
        (*help).to_owned()
    } else {
        format!("{help} [default: {shown}]")
    }
}

/// Keys whose texts are lists: given again they go on.
const LISTS: [&str; 5] = ["columns", "fix", "segment", "temperature", "units"];

fn argument(parameter: &'static Parameter) -> Arg {
    let argument = Arg::new(parameter.key)
        .long(option_of(parameter.key))
        .help(help(parameter));
    if let Kind::Flag(_) = parameter.value {
        return argument.action(ArgAction::SetTrue);
    }
    let argument = argument.allow_hyphen_values(true);
    let argument = if LISTS.contains(&parameter.key) {
        argument.action(ArgAction::Append)
    } else {
        argument
    };
    let names = choices(parameter);
    if !names.is_empty() {
        let names = names.into_iter().map(|(name, _)| name);
        return argument
            .value_parser(PossibleValuesParser::new(names))
            .value_name("NAME");
    }
    // Bad values are reported where they are read, as for a value without an option.
    argument.value_name(match parameter.value {
        Kind::Number(..) => kind_of_key(parameter.key),
        Kind::Count(_) => "COUNT",
        Kind::List(_) => "LIST",
        Kind::Text(_) if parameter.is_path("x.toml") => "FILE.toml",
        Kind::Text(_) | Kind::Flag(_) => "NAME",
    })
}

impl<N: Named> Args for Options<N> {
    fn augment_args(command: Command) -> Command {
        let groups = N::OPTIONS.iter().enumerate();
        let options = groups.flat_map(|(group, parameters)| {
            let hidden = group > 0;
            let options = parameters.iter();
            options.map(move |parameter| argument(parameter).hide_short_help(hidden))
        });
        let command = command.args(options);
        let tables = N::TABLES.iter().flat_map(|tables| *tables);
        let headed = tables.flat_map(|(heading, parameters)| {
            let options = parameters.iter();
            options.map(|parameter| argument(parameter).help_heading(*heading))
        });
        let command = command.args(headed);
        if !N::VALUES {
            return command;
        }
        let values = Arg::new(VALUES)
            .num_args(0..)
            .help("Any key, as in sample_time=1ms; `host-cli run --help` lists them");
        command.arg(values)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<N: Named> FromArgMatches for Options<N> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut options = Vec::new();
        let tables = N::TABLES.iter().flat_map(|tables| *tables);
        let headed = tables.flat_map(|(_, parameters)| *parameters);
        for parameter in N::OPTIONS.concat().into_iter().chain(headed) {
            let name = option_of(parameter.key);
            if let Kind::Flag(_) = parameter.value {
                if matches.get_flag(parameter.key) {
                    options.push((parameter, "true".to_owned(), format!("--{name}")));
                }
            } else if let Some(texts) = matches.get_many::<String>(parameter.key) {
                let text = texts.cloned().collect::<Vec<_>>().join(",");
                let option = format!("--{name} {}", short(&text));
                options.push((parameter, text, option));
            }
        }
        let values = N::VALUES.then(|| matches.get_many::<String>(VALUES));
        let values = values.flatten().unwrap_or_default();
        Ok(Self {
            options,
            values: values.cloned().collect(),
            named: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<N: Named> Options<N> {
    /// Parameters with their texts and the words in which they were said.
    pub(crate) const fn of(options: Vec<(&'static Parameter, String, String)>) -> Self {
        Self {
            options,
            values: Vec::new(),
            named: PhantomData,
        }
    }

    /// True if this key is in no option, and no file could have it.
    pub(crate) fn leaves_out(&self, key: &str) -> bool {
        let has = |value: &String| value.starts_with(key) || value.ends_with(".toml");
        self.options.iter().all(|option| option.0.key != key) && !self.values.iter().any(has)
    }

    /// Appends a `KEY=VALUE`.
    pub(crate) fn and(mut self, value: &str) -> Self {
        self.values.push(value.to_owned());
        self
    }

    /// A form of a library, whose fields have the names of keys.
    pub(crate) fn form<T: DeserializeOwned>(self) -> Result<T, Failure> {
        let mut values = toml::Table::new();
        for (parameter, text, wording) in self.options {
            let value = value_of("", parameter, &text).map_err(|error| refused(&wording, error))?;
            if let Some(outside) = parameter.outside(value.as_float()) {
                return Err(refused(&wording, format!("{} = {outside}", parameter.key)));
            }
            values.insert(parameter.key.to_owned(), value);
        }
        values.try_into().map_err(Failure::bad_input)
    }

    pub(crate) fn over(self, mut document: Document) -> Result<Document, Failure> {
        let kind = document.kind()?;
        for (parameter, text, wording) in self.options {
            let value = value_of("", parameter, &text)
                .map_err(|error| refused(&wording, error + &instead(kind, parameter, &text)))?;
            document.set(table_of(kind, parameter), parameter.key, value, &wording)?;
        }
        for text in &self.values {
            let shown = &short(text);
            let Some((written, value)) = text
                .split_once('=')
                .filter(|(key, _)| !key.trim().is_empty())
            else {
                let error = if Path::new(text).is_file() {
                    "is a file: `host-cli run` runs an experiment file, `host-cli identify` makes a tissue of a record"
                } else if text.starts_with(['–', '—', '−']) {
                    "begins with a dash of typography: write two hyphens, as --strain"
                } else {
                    "is not KEY=VALUE, as sample_time=1ms; a name goes with its option, as --tissue liver"
                };
                return Err(refused(shown, error.to_owned()));
            };
            let (written, parameter) = (written.trim(), found(kind, written.trim()));
            let (table, key, value) = match &parameter {
                Some(parameter) => {
                    let value = value_of(written, parameter, value.trim());
                    let value = value.map_err(|error| refused(shown, error))?;
                    (table_of(kind, parameter), parameter.key, value)
                }
                // Its reader knows what there is instead.
                None => {
                    let (table, key) = unknown(kind, written);
                    (table, key, Value::from(value))
                }
            };
            document.set(table, key, value, shown)?;
        }
        Ok(document)
    }
}

/// The option whose value this text would be: a stress of 50 N is a force.
fn instead(kind: &str, parameter: &Parameter, text: &str) -> String {
    let words = format!("instead of a {}", option_of(parameter.key));
    let mut others = of_kind(kind).into_iter().flat_map(|(_, table)| table);
    let other = others.find(|p| p.help.contains(&words) && value_of("", p, text).is_ok());
    other.map_or_else(String::new, |other| {
        format!("; or --{} {}", option_of(other.key), short(text))
    })
}

/// An error with the words that were given.
fn refused(shown: &str, error: String) -> Failure {
    Failure::bad_input(format_args!("{shown}: {error}"))
}

/// The table of a document that has this key.
fn table_of<'k>(kind: &'k str, parameter: &Parameter) -> &'k str {
    let has = |name: &str| {
        let tables = of_kind(name);
        tables.iter().any(|(_, table)| table.contains(parameter))
    };
    let beside = BESIDE.into_iter().find(|name| has(name));
    // A question has the keys of a robot in its own table.
    beside.filter(|_| KINDS.contains(&kind)).unwrap_or(kind)
}

/// The parameter of this key, or of this key without its unit, with the heading of its table before it or without.
fn found(kind: &str, written: &str) -> Option<Parameter> {
    let (heading, key) = match written.split_once('.') {
        Some((heading, key)) => (Some(heading), key),
        None => (None, written),
    };
    let key = key.replace('-', "_");
    let tables = of_kind(kind)
        .into_iter()
        .chain(BESIDE.into_iter().flat_map(of_kind));
    let tables =
        tables.filter(|(name, _)| heading.is_none_or(|heading| [*name, kind].contains(&heading)));
    let parameters: Vec<Parameter> = tables.flat_map(|(_, table)| table).copied().collect();
    let by = |matches: &dyn Fn(&str) -> bool| {
        parameters
            .iter()
            .find(|parameter| matches(parameter.key))
            .copied()
    };
    let in_full = heading.map(|heading| format!("{heading}_{key}"));
    by(&|known| known == key)
        .or_else(|| by(&|known| without_unit(known) == key))
        .or_else(|| by(&|known| in_full.as_deref() == Some(without_unit(known))))
}

/// A key that there is not, without the heading of a table that there is, behind the table that would have it.
fn unknown<'w>(kind: &'w str, written: &'w str) -> (&'w str, &'w str) {
    let is_table =
        |heading: &str| heading == kind || of_kind(kind).iter().any(|(name, _)| *name == heading);
    match written.split_once('.') {
        Some((heading, key)) if is_table(heading) => (kind, key),
        Some((heading, key)) if BESIDE.contains(&heading) && KINDS.contains(&kind) => {
            (heading, key)
        }
        _ => (kind, written),
    }
}

/// Options of a command whose answer can be kept.
#[derive(Debug, Args)]
pub(crate) struct WithFiles<K: Named> {
    #[command(flatten)]
    pub(crate) options: Options<K>,
    #[command(flatten)]
    pub(crate) files: Files,
}

/// A device whose values are in a file, of commands without a document.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Device")]
pub(crate) struct DeviceModelArguments {
    /// Device file, as written by device measure, or `laboratory`, a typical device; options take precedence over it
    #[arg(long, value_name = "FILE.toml")]
    device_model: Option<PathBuf>,
}

impl DeviceModelArguments {
    pub(crate) const fn is_given(&self) -> bool {
        self.device_model.is_some()
    }

    /// The path of the file of a robot, and its text.
    pub(crate) fn robot(&self) -> Result<Option<(&Path, String)>, Failure> {
        let Some(path) = self.device_model.as_deref() else {
            return Ok(None);
        };
        let text = DeviceModel::text(path)?;
        let robot = is_robot(path, &text)?.then(|| (path, text.into_owned()));
        Ok(robot)
    }

    pub(crate) fn read(&self) -> Result<Option<DeviceModel>, Failure> {
        let file = self
            .device_model
            .as_ref()
            .map(|name| DeviceModel::find(name));
        Ok(file.transpose()?)
    }
}

/// Keys that have an option, command by command: those that most runs change. Any other key is given as `KEY=VALUE`.
pub(crate) mod keys {
    use haptic_experiment::parameters::analysis as a;
    use haptic_experiment::parameters::{
        AGAINST, AREA, BONDED, CALIBRATE_STEP, CALIBRATE_WEIGHT, CAMPAIGN, CONTACT, CONTROL_DESIGN,
        CONTROL_LOOP, CONTROLLER, CREEP_CONTACT, CREEP_DURATION, DAMPING, DELAY, DEPTH,
        DEPTH_LIMIT, DESIGN_ORDERS, DEVICE, DEVICE_MODEL, FORCE, FORCE_LIMIT, FORCE_NOISE_LIMIT,
        FRAME_STIFFNESS, FRONT, GAIN_MARGIN, GUARD, HALF_ANGLE, HAND_STIFFNESS, HELD,
        INDENTER_RADIUS, LOADING, LOOP, MASS, MEASURE_BOX, MEASURE_DEVICE, MEASURE_DURATION,
        MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME, ONE_SIDED, PIECE_ORDER, PLANT_RECORD,
        PRESS_AMPLITUDE, PRESS_DEPTH, PRESS_DEPTHS, PRESS_FREQUENCIES, PRESS_HOLD, PRESS_RAMP,
        PROTOCOL, PUSH, PUSH_BY, Parameter, RAMP_TIME, RECORD, RELAX_DURATION, REQUIRE,
        SAMPLE_TIME, SCHEME, SENSED_RANGE, STRAIN, STRESS, THICKNESS, TISSUE, TRIAL_FORCE_LIMIT,
        WALL_CONTACT, WISH, WISH_FREQUENCY, WISH_TISSUE, ZWIDTH_ORDERS, ZWIDTH_POINTS,
    };

    /// A command whose options are made from tables of parameters.
    pub(crate) trait Named {
        /// Options in the order of the help, in groups. The first is what most runs change, and all that `-h` shows.
        const OPTIONS: &'static [&'static [&'static Parameter]];
        /// More of them under headings; `-h` shows all.
        const TABLES: &'static [&'static [(&'static str, &'static [Parameter])]];
        /// False of a command that takes files in place of `KEY=VALUE`.
        const VALUES: bool;
    }

    macro_rules! named {
        ($($command:ident: $groups:expr $(, $tables:expr $(, $values:literal)?)?;)*) => {$(
            #[derive(Clone, Debug)]
            pub(crate) struct $command;

            impl Named for $command {
                const OPTIONS: &'static [&'static [&'static Parameter]] = $groups;
                const TABLES: &'static [&'static [(&'static str, &'static [Parameter])]] = &[$($tables)?];
                const VALUES: bool = Self::TABLES.is_empty() $($(|| $values)?)?;
            }
        )*};
    }

    /// Options of the rig that presses a tissue.
    #[rustfmt::skip]
    const RIG: &[&Parameter] =
        &[&AREA, &THICKNESS, &LOADING, &INDENTER_RADIUS, &CONTROLLER, &LOOP, &DEVICE_MODEL, &GUARD];

    /// A tissue, if one is named.
    pub(crate) const NO_TISSUE: Parameter = TISSUE.without_default();

    named! {
        Relax: &[
            &[&TISSUE, &PIECE_ORDER, &STRAIN, &RAMP_TIME, &RELAX_DURATION, &SCHEME, &SAMPLE_TIME, &DEVICE],
            &[&DEPTH, &CONTACT, &AGAINST],
            RIG,
        ];
        Creep: &[
            &[&TISSUE, &PIECE_ORDER, &STRESS, &CREEP_DURATION, &SCHEME, &SAMPLE_TIME, &DEVICE],
            &[&FORCE, &CREEP_CONTACT, &AGAINST],
            RIG,
        ];
        Press: &[
            &[&PROTOCOL, &PRESS_DEPTH, &PRESS_RAMP, &PRESS_HOLD, &CONTROLLER, &TISSUE, &DEVICE, &LOOP, &DEVICE_MODEL],
            &[&PRESS_DEPTHS, &PRESS_AMPLITUDE, &PRESS_FREQUENCIES, &DEPTH_LIMIT, &FRAME_STIFFNESS, &FORCE_LIMIT],
            &[&AREA, &THICKNESS, &LOADING, &INDENTER_RADIUS, &HALF_ANGLE, &SENSED_RANGE],
        ];
        Run: &[&[&DEVICE, &LOOP, &DEVICE_MODEL, &GUARD, &CONTROLLER, &AGAINST]];
        ZWidth: &[&[
            &ZWIDTH_ORDERS, &ZWIDTH_POINTS, &a::ANALYSED_TISSUE, &a::ANALYSED_CONTROLLER, &SCHEME, &DEVICE_MODEL,
            &MASS, &DAMPING, &HAND_STIFFNESS, &SAMPLE_TIME, &TRIAL_FORCE_LIMIT, &PUSH, &PUSH_BY, &ONE_SIDED, &DEVICE, &LOOP,
            &CAMPAIGN,
        ]];
        Design: &[&[
            &WISH, &WISH_TISSUE, &a::ANALYSED_CONTROLLER, &FRONT, &WISH_FREQUENCY, &REQUIRE, &GAIN_MARGIN, &DESIGN_ORDERS, &SCHEME,
            &DEVICE_MODEL, &MASS, &DAMPING, &HAND_STIFFNESS, &SAMPLE_TIME, &DELAY, &TRIAL_FORCE_LIMIT,
            &FORCE_NOISE_LIMIT, &ONE_SIDED, &WALL_CONTACT,
        ]];
        Teleoperate: &[];
        ExportC: &[&[
            &NO_TISSUE, &LOADING, &AREA, &THICKNESS, &INDENTER_RADIUS, &HALF_ANGLE, &BONDED,
        ]];
        Measure: &[&[
            &MEASURE_DEVICE, &MEASURE_FORCE_LIMIT, &MEASURE_BOX, &MEASURE_DURATION,
            &MEASURE_SAMPLE_TIME, &HELD, &DEVICE_MODEL, &MASS, &DAMPING,
        ]];
        Calibrate: &[&[
            &MEASURE_DEVICE, &MEASURE_FORCE_LIMIT, &CALIBRATE_WEIGHT, &CALIBRATE_STEP, &DEVICE_MODEL,
        ]];
        // Of `analyze`.
        Admittance: &[], a::ADMITTANCE, true;
        Stability: &[], a::STABILITY, true;
        Sensitivity: &[], a::SENSITIVITY, true;
        Environment: &[], a::ENVIRONMENT, true;
        Transparency: &[], a::TRANSPARENCY, true;
        Coupling: &[], a::COUPLING, true;
        Difference: &[], a::DIFFERENCE;
        Hands: &[], a::HANDS, true;
        // Of `identify` and `control`.
        ControlPlant: &[], CONTROL_LOOP.split_at(1).0;
        ControlDesign: &[], CONTROL_DESIGN;
        ControlAnalyze: &[], CONTROL_LOOP.split_at(2).0;
        ControlSimulate: &[], CONTROL_LOOP;
        Record: &[], RECORD;
        PlantRecord: &[], PLANT_RECORD;
    }
}
