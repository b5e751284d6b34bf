//! Plant files: TOML, one table that says what is to be controlled, and perhaps `[source]`.
//!
//! ```toml
//! [transfer_function]                 # a function in notation, perhaps with exp(-0.5s), exp(-sqrt(3s)) or (0.2s+1)^0.6 as factors
//! function = "1/(0.8s^2.2+0.5s^0.9+1)"
//! delay_s = 0.2
//! ```
//! `[calibration]` beside a `[device]` says how many newtons a newton of it is, see [`calibration`].
//! `[device]` has the keys of a `[wall]`: mass, damping, hand, delay, current lag, friction, encoder, noise; force in, position out. Beside it
//! `[intervals]` says between which numbers its values lie, as a measurement writes it, see [`DeviceModel`]. `[state_space]` has `a`, `b`, `c`,
//! `delay_s` and `current_lag_s`, and `b_hand` and `c_hand` where a hand acts elsewhere than the law. `[measured_response]` names a CSV, see [`response_in`].

use crate::{controller_file::source, safety::GuardedDevice, sensors::Sensors};
use calibration::{CALIBRATION_KEYS, Calibration, MeasuredNumber};
use fracdiff::parameter::{Shown, range};
use fractional_control::{ControlError, Plant, StateSpace};
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, FileError, Interval, Parsed, Table, lines_of, parameters as p, parameters::Parameter,
    text_of,
};
use haptic_loop::{
    plant::MassDamperConfig,
    units::{Kilograms, NewtonSecondsPerMetre, Newtons, Seconds},
};
use measured_table::{ResponseTable, TABLE_MOST, read_bytes, read_response, rows_named};
use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex;
use serde::Serialize;
use std::{borrow::Cow, path::Path, str::FromStr};

pub mod calibration;
#[cfg(test)]
mod tests;

/// Tables with a plant, and their keys.
const MODELS: [(&str, &[Parameter]); 4] = [
    ("transfer_function", p::TRANSFER_PLANT),
    ("device", p::DEVICE_PLANT),
    ("state_space", p::STATE_PLANT),
    ("measured_response", p::MEASURED_PLANT),
];
const CHOICE: &str =
    "a plant file has one of [transfer_function], [device], [state_space], [measured_response]";
/// Intervals of a measured device, with its keys.
pub(crate) const INTERVALS: &str = "intervals";
/// Newtons of a device that were checked.
const CALIBRATION: &str = "calibration";

/// Reads and checks the text of a file: its plant, and intervals and calibration of a device; `path` is for messages and for the table of a
/// measured response.
fn parse(
    path: &Path,
    text: &str,
) -> Result<(PlantModel, Vec<Interval>, Option<Calibration>), FileError> {
    let document = Parsed::of(path, text)?;
    let kinds = MODELS.map(|(name, _)| name);
    let (name, table, mut tables) =
        document.one_of(&kinds, &["source", INTERVALS, CALIBRATION], "plant", CHOICE)?;
    let known = MODELS.iter().find(|(model, _)| *model == name);
    let table = table.with_keys(known.map(std::slice::from_ref).unwrap_or_default())?;
    let (model, mut found, mut calibration) = (model(name, &table)?, Vec::new(), None);
    for (heading, keys) in [
        (INTERVALS, p::DEVICE_PLANT),
        (CALIBRATION, CALIBRATION_KEYS),
    ] {
        let Some(table) = tables.remove(heading) else {
            continue;
        };
        let table = table.with_keys(&[(heading, keys)])?;
        let PlantModel::Device(values) = &model else {
            return Err(table.fail(format_args!(
                "[{heading}] belongs to a [device], not to [{name}]: omit it"
            )));
        };
        match heading {
            INTERVALS => found = intervals(&table, values)?,
            _ => calibration = Some(Calibration::read(&table)?),
        }
    }
    if let Some(source) = tables.remove("source") {
        source_of(source)?;
    }
    (model.plant()).map_err(|error| table.fail(error))?;
    Ok((model, found, calibration))
}

/// Checks `[source]`.
pub(crate) fn source_of(source: Table<'_>) -> Result<(), FileError> {
    let source = source.with_keys(&[("source", p::PLANT_SOURCE)])?;
    source.text(&p::SOURCE_PROGRAM)?;
    source.text(&p::SOURCE_NOTE).map(|_| ())
}

/// `[source]` of what this program made.
pub(crate) fn made_by(program: &str, note: &str) -> String {
    let (program, note) = (program.to_owned(), note.to_owned());
    source([(p::SOURCE_PROGRAM, &program), (p::SOURCE_NOTE, &note)])
}

/// The file of a function in notation, made by this program.
pub fn function_file(function: &str, delay_s: f64, program: &str, note: &str) -> String {
    format!(
        "[transfer_function]\n{} = \"{function}\"\n{}{}",
        p::FUNCTION.key,
        lines_of([(p::DEAD_TIME, delay_s)]),
        made_by(program, note)
    )
}

/// A plant as its file says it.
///
/// ```
/// use haptic_trial::{DeviceValues, PlantModel};
///
/// let arm = DeviceValues { mass_kg: 0.065, damping_n_s_per_m: 3.5, delay_s: 0.001, ..DeviceValues::default() };
/// // A mass of 65 g: |x/f| is 1/(m·ω²) at high frequency.
/// let far = PlantModel::Device(arm).plant()?.response(1e4).expect("at any frequency");
/// assert!((far.norm() * 0.065 * 1e8 - 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum PlantModel {
    /// `[transfer_function]`, with its dead time.
    Function(Plant),
    /// `[device]`: m·ẍ + b·ẋ + k·x = f.
    Device(DeviceValues),
    /// `[state_space]`.
    StateSpace {
        /// A, a list of rows.
        a: Vec<Vec<f64>>,
        /// B of ẋ = Ax + Bu, one number a state.
        b: Vec<f64>,
        /// C of y = Cx, one number a state.
        c: Vec<f64>,
        /// B of the force of a hand, N, and C of its place, m, if they are not b and c.
        hand: [Option<Vec<f64>>; 2],
        /// Dead time behind the states, s.
        delay_s: f64,
        /// Time constant of the actuator before it, s.
        current_lag_s: f64,
    },
    /// `[measured_response]`.
    Measured(MeasuredPoints),
}

/// A response as given in a table.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MeasuredPoints {
    /// ω in rad/s and G(jω).
    pub points: Vec<(f64, Complex<f64>)>,
    /// Line numbers of omitted rows, whose coherence is so low that their gain may be wrong by a
    /// tenth or more.
    pub incoherent: Vec<u64>,
    /// One sentence for each thing that was taken without being said.
    pub notes: Vec<String>,
}

/// Below this coherence the gain of a response may be off by a tenth and more.
pub const COHERENT: f64 = 0.95;

/// A device with a hand: force in, position out. The linear plant excludes friction, encoder and
/// noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DeviceValues {
    /// The mass that moves, with whatever is fixed to it.
    pub mass_kg: f64,
    /// Viscous damping of the device alone, without a hand.
    pub damping_n_s_per_m: f64,
    /// Stiffness k of the hand that holds it; 0 for a device that nobody holds.
    pub hand_stiffness_n_per_m: f64,
    /// Delay beyond the hold, s.
    pub delay_s: f64,
    /// Time constant of the actuator's current, s.
    pub current_lag_s: f64,
    /// Coulomb friction, N, which only a simulation has: the analysis is linear.
    pub friction_n: f64,
    /// Encoder resolution, m per count; 0 for none.
    pub encoder_resolution_m: f64,
    /// Standard deviation of the sensor's noise, m; 0 for none.
    pub sensor_noise_m: f64,
}

impl FromStr for PlantModel {
    type Err = ControlError;

    /// Reads a model as a [`Plant`] is read: a transfer function in notation, perhaps with `exp(-0.5s)` as a factor.
    fn from_str(text: &str) -> Result<Self, ControlError> {
        text.parse().map(Self::Function)
    }
}

/// Endings of tables, as instruments write them.
pub const TABLES: [&str; 7] = ["csv", "tsv", "txt", "dat", "dta", "mpt", "z"];

/// True of the table of a measured response.
fn is_table(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    TABLES
        .iter()
        .any(|ending| extension.eq_ignore_ascii_case(ending))
}

impl PlantModel {
    /// The tables of plants, of which a file has one.
    pub fn tables() -> impl Iterator<Item = &'static str> {
        MODELS.iter().map(|model| model.0)
    }

    /// Reads a plant file, or the table of a measured response, by its ending.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        if is_table(path) {
            let points = response_in(path).map_err(Failure::bad_input)?;
            return Ok(Self::Measured(points));
        }
        Ok(parse(path, &text_of(path, "plant")?)?.0)
    }

    /// Parses the text of such a file; the extension of `path` decides its kind.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Failure> {
        if is_table(path) {
            let points = response_of(path, text.as_bytes()).map_err(Failure::bad_input)?;
            return Ok(Self::Measured(points));
        }
        Ok(parse(path, text)?.0)
    }

    /// The plant.
    ///
    /// # Errors
    /// A value outside its range, matrices whose sizes do not fit.
    pub fn plant(&self) -> Result<Plant, ControlError> {
        match self {
            Self::Function(plant) => Ok(plant.clone()),
            Self::Device(values) => values.plant(),
            Self::StateSpace {
                a,
                b,
                c,
                delay_s,
                current_lag_s,
                ..
            } => {
                let columns = a.first().map_or(0, Vec::len);
                // A ragged matrix has a size that does not fit.
                let even = a.iter().all(|row| row.len() == columns);
                let rows = if even { a.len() } else { 0 };
                let at = |i: usize, j: usize| a.get(i).and_then(|row| row.get(j)).copied();
                let matrix = DMatrix::from_fn(rows, columns, |i, j| at(i, j).unwrap_or(f64::NAN));
                let (b, c) = (DVector::from_column_slice(b), RowDVector::from_row_slice(c));
                let states = StateSpace::new(matrix, b, c)?.behind_lag(*current_lag_s)?;
                Plant::state_space(states, *delay_s)
            }
            Self::Measured(measured) => Plant::measured(&measured.points),
        }
    }

    /// The plant in a few words: its notation where it has one.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Function(plant) => plant.to_string(),
            Self::Device(values) => values.in_words(),
            Self::StateSpace { a, delay_s, .. } => {
                let plural = if a.len() == 1 { "" } else { "s" };
                format!("{} state{plural}, delay {delay_s} s", a.len())
            }
            Self::Measured(measured) => {
                let mut words = format!("measured at {} frequencies", measured.points.len());
                for note in &measured.notes {
                    words = format!("{words}; {note}");
                }
                match rows_named(&measured.incoherent) {
                    Some(rows) => format!("{words}; {rows} of coherence below {COHERENT} left out"),
                    None => words,
                }
            }
        }
    }
}

impl DeviceValues {
    /// The device to be simulated, held by nobody.
    #[must_use]
    pub const fn free(&self, sample_time: Seconds) -> MassDamperConfig {
        MassDamperConfig {
            friction: Newtons(self.friction_n),
            delay: Seconds(self.delay_s),
            current_lag: Seconds(self.current_lag_s),
            ..MassDamperConfig::ideal(
                Kilograms(self.mass_kg),
                NewtonSecondsPerMetre(self.damping_n_s_per_m),
                sample_time,
            )
        }
    }

    /// Its sensors, for a simulation.
    #[must_use]
    pub const fn sensors(&self) -> Sensors {
        Sensors {
            encoder_resolution_m: self.encoder_resolution_m,
            noise_m: self.sensor_noise_m,
            ..Sensors::NONE
        }
    }

    /// Mass, damping, hand, delay and lag, for an analysis.
    #[must_use]
    pub const fn dynamics(&self) -> Dynamics {
        Dynamics {
            mass_kg: self.mass_kg,
            damping_n_s_per_m: self.damping_n_s_per_m,
            hand_stiffness_n_per_m: self.hand_stiffness_n_per_m,
            delay_s: self.delay_s,
            current_lag_s: self.current_lag_s,
        }
    }

    /// The plant of these values, from force in N to measured position in m.
    ///
    /// # Errors
    /// Values that have no plant, as a mass of 0.
    pub fn plant(&self) -> Result<Plant, ControlError> {
        let (m, b, k) = (
            self.mass_kg,
            self.damping_n_s_per_m,
            self.hand_stiffness_n_per_m,
        );
        // Less would move faster than numbers go.
        range("mass", m, m >= 1e-15, "at least 1e-15 {}", "kg")?;
        fracdiff::parameter::not_negative("damping", b, "N·s/m")?;
        fracdiff::parameter::not_negative("hand stiffness", k, "N/m")?;
        let states = StateSpace::new(
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -k / m, -b / m]),
            DVector::from_column_slice(&[0.0, 1.0 / m]),
            RowDVector::from_row_slice(&[1.0, 0.0]),
        )?;
        Plant::state_space(states.behind_lag(self.current_lag_s)?, self.delay_s)
    }

    fn in_words(&self) -> String {
        format!(
            "device of {} kg, {} N·s/m, hand {} N/m, delay {} s, current lag {} s",
            Shown(self.mass_kg),
            Shown(self.damping_n_s_per_m),
            Shown(self.hand_stiffness_n_per_m),
            Shown(self.delay_s),
            Shown(self.current_lag_s)
        )
    }
}

/// The device of a plant file with `[device]`, to be simulated, analysed or guarded.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceModel {
    /// The values of the file's `[device]`.
    pub values: DeviceValues,
    /// Between which numbers they lie, where that is known.
    pub intervals: Vec<Interval>,
    /// Newtons that were checked against an instrument; `None` if nobody did.
    pub calibration: Option<Calibration>,
}

type Field = fn(&mut DeviceValues) -> &mut f64;

impl DeviceValues {
    /// Parameters and the values that they set.
    const FIELDS: [(&'static Parameter, Field); 8] = [
        (&p::MASS, |values| &mut values.mass_kg),
        (&p::DAMPING, |values| &mut values.damping_n_s_per_m),
        (&p::HAND_STIFFNESS, |values| {
            &mut values.hand_stiffness_n_per_m
        }),
        (&p::DELAY, |values| &mut values.delay_s),
        (&p::CURRENT_LAG, |values| &mut values.current_lag_s),
        (&p::FRICTION, |values| &mut values.friction_n),
        (&p::ENCODER_RESOLUTION, |values| {
            &mut values.encoder_resolution_m
        }),
        (&p::SENSOR_NOISE, |values| &mut values.sensor_noise_m),
    ];

    /// The values with their parameters.
    #[must_use]
    pub fn named(mut self) -> [(&'static Parameter, f64); 8] {
        Self::FIELDS.map(|(parameter, value)| (parameter, *value(&mut self)))
    }

    /// Sets the value of a parameter, if it has one.
    pub fn set(&mut self, parameter: &Parameter, number: f64) {
        for (_, value) in Self::FIELDS.iter().filter(|(known, _)| *known == parameter) {
            *value(self) = number;
        }
    }

    fn read(table: &Table<'_>) -> Result<Self, FileError> {
        let mut values = Self::default();
        for (parameter, value) in Self::FIELDS {
            *value(&mut values) = match parameter {
                &p::MASS | &p::DAMPING => table.required(parameter)?,
                _ => table.number(parameter)?,
            };
        }
        Ok(values)
    }
}

impl DeviceModel {
    /// The built-in device `laboratory`, or one from a file.
    ///
    /// # Errors
    /// As reading.
    pub fn find(name: &Path) -> Result<Self, FileError> {
        Self::parse(name, &Self::text(name)?)
    }

    /// The text of the file of the built-in device `laboratory`, or of one at a path.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn text(name: &Path) -> Result<Cow<'static, str>, FileError> {
        match name.to_str() {
            Some(p::LABORATORY) => Ok(include_str!("../devices/laboratory.toml").into()),
            _ => text_of(name, "device").map(Cow::Owned),
        }
    }

    /// Reads and checks the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// A file that is wrong, with its place.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        let (model, intervals, calibration) = parse(path, text)?;
        let PlantModel::Device(values) = model else {
            let reason = "no [device] in it: `device measure` writes such a file";
            return Err(Parsed::of(path, text)?.fail(reason));
        };
        Ok(Self {
            values,
            intervals,
            calibration,
        })
    }

    /// A device whose newtons turned out to be so many: mass, damping, hand and friction were in them.
    pub fn calibrated(mut self, newton: MeasuredNumber, calibration: Calibration) -> Self {
        for parameter in [p::MASS, p::DAMPING, p::HAND_STIFFNESS, p::FRICTION] {
            for (_, value) in DeviceValues::FIELDS
                .iter()
                .filter(|known| *known.0 == parameter)
            {
                *value(&mut self.values) *= newton.value;
            }
            for Interval { low, high, .. } in self
                .intervals
                .iter_mut()
                .filter(|known| known.key == parameter.key)
            {
                (*low, *high) = (*low * newton.low, *high * newton.high);
            }
        }
        self.calibration = Some(calibration);
        self
    }

    /// The text of its file, made by this program; the note says how it was measured.
    pub fn to_toml(&self, program: &str, note: &str) -> String {
        let values = self
            .values
            .named()
            .map(|(parameter, value)| (*parameter, value));
        let mut text = format!("[device]\n{}", lines_of(values));
        if !self.intervals.is_empty() {
            text += "\n# 95 of 100 such intervals have the true value in them.\n[intervals]\n";
        }
        for Interval { key, low, high } in &self.intervals {
            text += &format!("{key} = [{low:?}, {high:?}]\n");
        }
        text.extend(self.calibration.as_ref().map(Calibration::to_toml));
        text + &made_by(program, note)
    }

    /// The least of mass and damping and the whole interval of the delay, for a guard, which must hold for what is certain.
    pub fn guarded(&self) -> GuardedDevice {
        let values = &self.values;
        let ends = |key: &str, value: f64| {
            let found = self.intervals.iter().find(|interval| interval.key == key);
            found.map_or((value, value), |interval| (interval.low, interval.high))
        };
        GuardedDevice {
            mass_kg: Some(ends(p::MASS.key, values.mass_kg).0),
            damping_n_s_per_m: Some(ends(p::DAMPING.key, values.damping_n_s_per_m).0),
            delay_s: Some(ends(p::DELAY.key, values.delay_s)),
            current_lag_s: Some(values.current_lag_s),
            noise_m: Some(values.sensors().deviation_m()),
        }
    }
}

fn model(name: &str, table: &Table<'_>) -> Result<PlantModel, FileError> {
    Ok(match name {
        "transfer_function" => {
            let model = table.required_text(&p::FUNCTION)?.parse();
            let refused = |error: ControlError| table.fail_at(p::FUNCTION.key, error);
            let plant: Plant = model.map_err(refused)?;
            let delay_s = table.number(&p::DEAD_TIME)?;
            let late = plant.delayed(delay_s);
            PlantModel::Function(late.map_err(|error| table.fail_at(p::DEAD_TIME.key, error))?)
        }
        "device" => PlantModel::Device(DeviceValues::read(table)?),
        "state_space" => PlantModel::StateSpace {
            a: table.matrix(&p::STATE_A)?,
            b: table.numbers(&p::STATE_B)?,
            c: table.numbers(&p::STATE_C)?,
            hand: [
                table.numbers_if(&p::STATE_B_HAND)?,
                table.numbers_if(&p::STATE_C_HAND)?,
            ],
            delay_s: table.number(&p::DEAD_TIME)?,
            current_lag_s: table.number(&p::CURRENT_LAG)?,
        },
        _ => {
            table.required_text(&p::RESPONSE_FILE)?;
            let path = table.file(&p::RESPONSE_FILE)?.unwrap_or_default();
            let points = response_in(&path);
            PlantModel::Measured(
                points.map_err(|reason| table.fail_at(p::RESPONSE_FILE.key, reason))?,
            )
        }
    })
}

/// Intervals that are given, each about the value that it is of.
fn intervals(table: &Table<'_>, values: &DeviceValues) -> Result<Vec<Interval>, FileError> {
    let mut intervals = Vec::new();
    for (parameter, value) in values.named() {
        let Some(ends) = table.numbers_if(parameter)? else {
            continue;
        };
        let key = parameter.key;
        let about = |low: f64, high: f64| {
            // Values are written with fewer digits than they have.
            let slack = 1e-6 * value.abs();
            low - slack <= value && value <= high + slack
        };
        match ends[..] {
            [low, high] if about(low, high) && low >= 0.0 && parameter.range().contains(high) => {
                intervals.push(Interval { key, low, high });
            }
            [low, high] => {
                return Err(table.fail_at(key, format_args!(
                    "{key} = [{low}, {high}] is not an interval of numbers from 0 to {} around the value {value} in [device]: change it, or omit it",
                    Shown(parameter.range().ends()[1]),
                    low = Shown(low),
                    high = Shown(high),
                    value = Shown(value)
                )));
            }
            _ => {
                return Err(table.fail_at(
                    key,
                    format_args!(
                        "{key} has {} numbers, not two: write [LOW, HIGH]",
                        ends.len()
                    ),
                ));
            }
        }
    }
    Ok(intervals)
}

/// ω in rad/s and G(jω), from a table of an instrument, see [`measured_table::read_response`]. Rows whose coherence is below [`COHERENT`] are left out.
///
/// # Errors
/// A file that cannot be read, or is no table of a response.
pub fn response_in(path: &Path) -> Result<MeasuredPoints, String> {
    let bytes = read_bytes(path, TABLE_MOST).map_err(|error| {
        let shown = path.display();
        format!("cannot read the measured response `{shown}`: {error}; give the path of a CSV file")
    })?;
    response_of(path, &bytes)
}

/// Parses the bytes of a table; `path` is for messages.
fn response_of(path: &Path, bytes: &[u8]) -> Result<MeasuredPoints, String> {
    let shown = path.display();
    let table = read_response(bytes, &[]).map_err(|error| format!("{shown}: {error}"))?;
    MeasuredPoints::of(table).map_err(|why| format!("{shown}: {why}"))
}

impl MeasuredPoints {
    /// The coherent rows of a table.
    ///
    /// # Errors
    /// None of them is coherent; one with a gain below 0.
    pub fn of(table: ResponseTable) -> Result<Self, String> {
        let mut found = Self {
            notes: table.notes,
            ..Self::default()
        };
        let rows = table
            .lines
            .into_iter()
            .zip(table.omega_rad_s)
            .zip(table.values);
        for (row, ((line, omega), [re, im])) in rows.enumerate() {
            match table.coherence.get(row) {
                Some(coherence) if *coherence < COHERENT => found.incoherent.push(line),
                Some(_) | None => found.points.push((omega, Complex::new(re, im))),
            }
            let negative = table.negative.iter().find(|negative| negative.0 == line);
            if let Some((_, gain)) = negative.filter(|_| found.incoherent.last() != Some(&line)) {
                return Err(format!(
                    "line {line}: gain {} is below 0: add 180° to the phase instead",
                    Shown(*gain)
                ));
            }
        }
        match rows_named(&found.incoherent) {
            Some(rows) if found.points.is_empty() => Err(format!(
                "{rows} of coherence below {COHERENT}, and no other: measure for longer, or with more force"
            )),
            _ => Ok(found),
        }
    }
}
