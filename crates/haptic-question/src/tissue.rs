//! A tissue from records of it: the command, the page and Python read, fit and report by this.
//!
//! A form holds what somebody gives, by the names of keys, each text as the command takes it; a question is a form that is understood.

use super::form::form;
use haptic_document::parameters::range::{
    HALF_ANGLES, POISSON_RATIOS, Range, SPECIMENS, STRAINS, STRESSES,
};
use haptic_document::parameters::{
    BONDED, HALF_ANGLE, INDENTER_RADIUS, POISSON_RATIO, Parameter, STIFFENING,
};
use haptic_document::{Failure, Named, Rows, rows, short};
use haptic_loop::{Loading, LoadingKind};
use haptic_quantity::{is_meant, number, parse_for_key};
use haptic_tissue::ModelKind;
use measured_table::{Column, Columns, Reader, read_table};
use serde_json::{Map, Value, json};
use std::sync::atomic::AtomicBool;
use tissue_identification::{
    Baseline, CANDIDATES, ContactPoint, Estimate, Fit, HeldParameter, Identification,
    IdentifyError, MasterCurve, Options, RecordKind, Replicates, ShiftBy, TableDetails, Understood,
    Weighting, identify_unless, replicates,
};

/// Contact points on the axis of a depth, m.
const CONTACT_POINTS: Range = Range::Within(-1.0, 1.0);
/// Times in a record, s.
const RECORD_TIMES: Range = Range::Within(-1e12, 1e12);
/// Temperatures that a tissue can have, °C.
const TEMPERATURES: Range = Range::Within(-273.15, 10_000.0);
const ZERO_CELSIUS: f64 = 273.15;

/// The model that a record chooses.
const AUTO: &str = "auto";

/// Models of a record, with a few words for people.
pub fn models() -> Vec<(Option<ModelKind>, &'static str, &'static str)> {
    let auto = (None, AUTO, "the simplest that the record supports");
    let all = CANDIDATES.map(|kind| (Some(kind), kind.name(), kind.description()));
    std::iter::once(auto).chain(all).collect()
}

form! {
    /// Values that complete the tables of records, by the names of keys; numbers in SI units.
    RecordForm, RECORD:
    "Record"
    COLUMNS = columns: text("",
        "Columns by number or header, as in time=1,modulus=3: time, modulus, compliance, strain, stress, force, position, omega, storage, loss");
    UNITS = units: text("", "Units that headers lack, as in time=ms,stress=kPa");
    KIND = kind: text("", "Kind of record [default: by its columns]");
    TISSUE_MODEL = model: text(AUTO, "Model to fit; auto selects by the record");
    "Specimen"
    RECORD_LOADING = loading: text("", "How it was loaded [default: as the header says]");
    RECORD_RADIUS = indenter_radius_m: optional(SPECIMENS, INDENTER_RADIUS.help);
    RECORD_ANGLE = half_angle_rad: optional(HALF_ANGLES, HALF_ANGLE.help);
    RECORD_AREA = area_m2: optional(SPECIMENS, "Area, to turn force into stress");
    RECORD_THICKNESS = thickness_m: optional(SPECIMENS, "Thickness, to turn position into strain; of a layer under a sphere");
    RECORD_BONDED = bonded: flag(BONDED.help);
    RECORD_RATIO = poisson_ratio: optional(POISSON_RATIOS, POISSON_RATIO.help);
    RECORD_STRAIN = strain: optional(STRAINS, "Held strain of a relaxation");
    RECORD_STRESS = stress_pa: optional(STRESSES, "Held stress of a creep test");
    "Table"
    SEGMENT = segment: text("", "Segments of a table with several, by number or name, as in 1,3, or all");
    FROM = from_s: optional(RECORD_TIMES, "First time, or angular frequency of an oscillation, rad/s");
    TO = to_s: optional(RECORD_TIMES, "Last time or angular frequency");
    SKIP_BAD_ROWS = skip_bad_rows: flag("Leave out rows that are no sample, a tenth at most, and name them");
    "Beginning"
    CONTACT_POINT = contact_point_m: text("", "Depth at which an indenter touches, or fit, to find it [default: 0]");
    RECORD_RAMP_TIME = ramp_time_s: optional(Range::AboveUpTo(0.0, 1e9), "Time of the ramp to the held strain of a relaxation");
    RECORD_RAMP_ENDS = ramp_ends_s: optional(RECORD_TIMES,
        "Time of the record's clock at which this ramp ends, as 0 of one that begins with the hold [default: the ramp begins at 0]");
    SUBTRACT_START = subtract_start: flag("Subtract the first row of strain and stress: a motion that begins at rest, but not at 0");
    "Fit"
    RECORD_STIFFENING = stiffening: flag(STIFFENING.help);
    BASELINE = baseline: text("", "Find the part of the force that is not the tissue's too");
    FIX = fix: text("", "Parameters to hold at a value or in a range, as in order=0.2 or order=0.1..0.3");
    WEIGHTS = weights: text("errors", "Weights of the samples");
    STARTS = starts: count(Options::STARTS as u64, "40", "Starts per model");
    BOOTSTRAP = bootstrap: count(0, "0", "Bootstrap records for the intervals; 0 takes them from profiles of the likelihood");
    BOOTSTRAP_SEED = seed: count(1, "1", "Seed of the bootstrap");
    "Several records"
    REPLICATES = replicates: flag("The records are of several specimens: fit each by itself, and take the mean");
    MASTER_CURVE = master_curve: text("", "The records, or segments, are at several temperatures: shift them to this one, as in 20degC or 293.15K");
    TEMPERATURE = temperature: text("", "Temperatures of the files that have no column of it, one for each in their order");
    SHIFT_BY = shift_by: text("", "Modulus of a sweep that decides the shift [default: both]");
}

/// Fewer records of a bootstrap say nothing of the ends of an interval.
const BOOTSTRAP_LEAST: u64 = 40;

impl RecordForm {
    /// Refuses counts outside their ranges.
    fn check_counts(&self) -> Result<(), Failure> {
        let (least, most) = Options::STARTS_ALLOWED.into_inner();
        if let Some(starts) = self
            .starts
            .filter(|n| !(u64::from(least)..=u64::from(most)).contains(n))
        {
            return Err(Failure::bad_input(format_args!(
                "{STARTS} = {starts} is not a whole number from {least} to {most}: change it"
            )));
        }
        let most = *Options::BOOTSTRAP_ALLOWED.end();
        let records = self.bootstrap.unwrap_or_default();
        if records != 0 && !(BOOTSTRAP_LEAST..=u64::from(most)).contains(&records) {
            return Err(Failure::bad_input(format_args!(
                "{BOOTSTRAP} = {records} is not 0 or a whole number from {BOOTSTRAP_LEAST} to {most}: change it, as fewer records say nothing of the ends of an interval"
            )));
        }
        if self.seed.is_some() && records == 0 {
            return Err(Failure::bad_input(format_args!(
                "{BOOTSTRAP_SEED} has no effect without {BOOTSTRAP}: omit it"
            )));
        }
        Ok(())
    }
}

/// Reads a contact point: `fit`, or a length.
fn contact_point(text: &str) -> Result<ContactPoint, String> {
    if text == "fit" {
        return Ok(ContactPoint::Fitted);
    }
    let length =
        parse_for_key(CONTACT_POINT.key, text).map_err(|error| format!("{error}, nor fit"))?;
    if CONTACT_POINTS.contains(length) {
        Ok(ContactPoint::At(length))
    } else {
        Err(format!("{length} m is not from -1 m to 1 m, nor fit"))
    }
}

/// Reads `order=0.2` or `order=0.1..0.3`; names are those of tissue files, with the unit or without.
fn held(text: &str) -> Result<HeldParameter, String> {
    let split = text.split_once('=');
    let (name, value) =
        split.ok_or("is not PARAMETER=VALUE or PARAMETER=LOW..HIGH, decimals with a point")?;
    let all = CANDIDATES.iter().flat_map(|kind| kind.parameters());
    let mut names = all.map(|parameter| parameter.name);
    let name = names.find(|known| is_meant(known, name)).unwrap_or(name);
    let read = |text: &str| parse_for_key(name, text).map_err(|error| error.to_string());
    let (low, high) = value.split_once("..").unwrap_or((value, value));
    Ok(HeldParameter {
        name: name.to_owned(),
        low: read(low)?,
        high: read(high)?,
    })
}

/// Reads a temperature in °C: `20degC`, `20`, or `293.15K`.
fn temperature(text: &str) -> Result<f64, String> {
    let units = [
        ("degC", 0.0),
        ("°C", 0.0),
        ("C", 0.0),
        ("K", ZERO_CELSIUS),
        ("", 0.0),
    ];
    let mut known = units.iter().filter_map(|(unit, zero)| {
        let celsius = number(text.strip_suffix(unit)?.trim())? - zero;
        TEMPERATURES.contains(celsius).then_some(celsius)
    });
    let wrong = "is not from -273.15 to 10000 degC, as 20degC or 293.15K";
    known.next().ok_or_else(|| wrong.to_owned())
}

/// The parts of a list such as `time=1,modulus=3`.
pub(crate) fn parts<T>(
    parameter: Parameter,
    text: &str,
    read: fn(&str) -> Result<T, String>,
) -> Result<Vec<T>, Failure> {
    let parts = text.split(',').map(str::trim);
    let parts = parts.filter(|part| !part.is_empty());
    let refused = |part: &str, why| {
        Failure::bad_input(format_args!("{parameter}: \"{}\" {why}", short(part)))
    };
    parts
        .map(|part| read(part).map_err(|why| refused(part, why)))
        .collect()
}

/// A text with one part; `None` if nothing is given.
fn part<T>(
    parameter: Parameter,
    text: &str,
    read: fn(&str) -> Result<T, String>,
) -> Result<Option<T>, Failure> {
    parts(parameter, text, read).map(|mut all| all.pop())
}

fn named<T: Copy>(
    parameter: Parameter,
    wanted: &str,
    known: &[(T, &str, &str)],
) -> Result<Option<T>, Failure> {
    let found = known.iter().find(|one| one.1 == wanted);
    if found.is_some() || wanted.is_empty() {
        return Ok(found.map(|one| one.0));
    }
    let names: Vec<&str> = known.iter().map(|one| one.1).collect();
    Err(Failure::bad_input(format_args!(
        "{parameter} {wanted:?} is not one of {}",
        names.join(", ")
    )))
}

/// Relation between the records of one question.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Several {
    /// Motions of one tissue, fitted together.
    #[default]
    Motions,
    /// Specimens, each fitted by itself.
    Replicates,
    /// Records at several temperatures, shifted in time or frequency to one temperature.
    MasterCurve {
        /// The temperature that they are shifted to, °C.
        reference_c: f64,
        /// The modulus whose curves are to meet.
        by: ShiftBy,
    },
}

/// Records to be read and fitted.
#[derive(Clone, Debug, Default)]
pub struct RecordQuestion {
    /// The user's columns, units and ranges for the tables.
    pub reader: Reader,
    /// Facts that the tables lack.
    pub reading: TableDetails,
    /// Candidates and effort of the fit.
    pub options: Options,
    /// Relation between the records, if there are several.
    pub several: Several,
    /// The temperature of each file, °C, or none.
    pub temperatures_c: Vec<f64>,
}

impl RecordQuestion {
    /// Understands a form.
    ///
    /// # Errors
    /// A text that does not fit its key, options that do not belong together.
    pub fn of(form: &RecordForm) -> Result<Self, Failure> {
        form.check()?;
        form.check_counts()?;
        let loading = named(RECORD_LOADING, &form.loading, LoadingKind::CHOICES)?;
        let contact = part(CONTACT_POINT, &form.contact_point_m, contact_point)?;
        let master = part(MASTER_CURVE, &form.master_curve, temperature)?;
        let by = named(SHIFT_BY, &form.shift_by, &ShiftBy::CHOICES)?;
        Ok(Self {
            reader: Reader {
                columns: parts(COLUMNS, &form.columns, Column::chosen)?,
                units: parts(UNITS, &form.units, Column::with_unit)?,
                from: form.from_s,
                to: form.to_s,
                segments: parts(SEGMENT, &form.segment, |text| Ok(text.to_owned()))?,
                skip_bad_rows: form.skip_bad_rows,
            },
            reading: TableDetails {
                kind: named(KIND, &form.kind, &RecordKind::CHOICES)?,
                strain: form.strain,
                stress_pa: form.stress_pa,
                loading: Loading {
                    kind: loading.unwrap_or(LoadingKind::Compression),
                    area_m2: form.area_m2,
                    thickness_m: form.thickness_m,
                    radius_m: form.indenter_radius_m,
                    half_angle_rad: form.half_angle_rad,
                    bonded: form.bonded,
                },
                loading_is_told: loading.is_some(),
                poisson_ratio: form.poisson_ratio,
                contact: contact.unwrap_or_default(),
                ramp_time_s: form.ramp_time_s,
                ramp_ends_s: form.ramp_ends_s,
                subtract_start: form.subtract_start,
                position_was_commanded: false,
            },
            options: Options {
                weighting: named(WEIGHTS, &form.weights, &Weighting::CHOICES)?.unwrap_or_default(),
                starts: form
                    .starts
                    .map_or(Options::STARTS, |starts| starts as usize),
                bootstrap: form.bootstrap.unwrap_or_default() as usize,
                seed: form.seed.unwrap_or(BOOTSTRAP_SEED.default_count()),
                stiffening: form.stiffening,
                baseline: named(BASELINE, &form.baseline, &Baseline::CHOICES)?,
                held: parts(FIX, &form.fix, held)?,
                ..Self::choosing(named(TISSUE_MODEL, &form.model, &models())?.flatten())
            },
            several: Self::several(form.replicates, master, by)?,
            temperatures_c: parts(TEMPERATURE, &form.temperature, temperature)?,
        })
    }

    /// The candidates where this model was asked for: it, and those with fewer parameters, to say if one of these is as good.
    fn choosing(chosen: Option<ModelKind>) -> Options {
        let wanted = |candidate: &ModelKind| {
            let parameters = |kind: ModelKind| kind.parameters().len();
            // A series has as many parameters as the record shows branches.
            let is_series = *candidate == ModelKind::Prony;
            let fewer = |one: ModelKind| !is_series && parameters(*candidate) < parameters(one);
            chosen.is_none_or(|one| *candidate == one || fewer(one))
        };
        Options {
            candidates: CANDIDATES.into_iter().filter(wanted).collect(),
            chosen,
            ..Options::default()
        }
    }

    /// Derives the relation between several records.
    ///
    /// # Errors
    /// Options that do not belong together.
    fn several(
        is_replicates: bool,
        reference_c: Option<f64>,
        by: Option<ShiftBy>,
    ) -> Result<Several, Failure> {
        match (is_replicates, reference_c, by) {
            (true, Some(_), _) => Err(Failure::bad_input(
                "`replicates` and `master_curve` exclude each other: omit one",
            )),
            (_, None, Some(_)) => Err(Failure::bad_input(
                "`shift_by` has no effect without `master_curve`: omit it",
            )),
            (true, None, None) => Ok(Several::Replicates),
            (false, None, None) => Ok(Several::Motions),
            (false, Some(reference_c), by) => Ok(Several::MasterCurve {
                reference_c,
                by: by.unwrap_or_default(),
            }),
        }
    }

    /// Refuses temperatures that are not one for each of the files.
    ///
    /// # Errors
    /// If there are more or fewer, or if they have no effect.
    pub fn check(&self, files: usize) -> Result<(), Failure> {
        let given = self.temperatures_c.len();
        let shifts = matches!(self.several, Several::MasterCurve { .. });
        match given {
            0 => Ok(()),
            _ if !shifts => Err(Failure::bad_input(
                "`temperature` has no effect without `master_curve`: omit it",
            )),
            _ if given == files => Ok(()),
            _ => Err(Failure::bad_input(format_args!(
                "there are {files} files, and not as many temperatures ({given}): give `temperature` once for each file, in their order"
            ))),
        }
    }

    /// The records of a table that is read so, the file of this number from 0: one, the segments that were chosen, or all of a master curve.
    ///
    /// # Errors
    /// As [`Reader::read_all`] and [`TableDetails::record`].
    pub fn read(
        &self,
        file: usize,
        mut reader: Reader,
        bytes: &[u8],
    ) -> Result<Vec<Understood>, IdentifyError> {
        if matches!(self.several, Several::MasterCurve { .. }) && reader.segments.is_empty() {
            reader.segments.push("all".to_owned());
        }
        let mut all = reader.read_all(&read_table(bytes)?)?;
        if self.several == Several::Motions {
            all = Columns::joined(all);
        }
        let records = all.into_iter().map(|mut columns| {
            let given = self.temperatures_c.get(file).copied();
            columns.temperature_c = given.or(columns.temperature_c);
            if self.options.weighting != Weighting::Errors {
                columns.errors.clear();
            }
            self.reading.record(columns)
        });
        records.collect()
    }

    /// Explains a table: each column and what else it could be, its segments, and the records that they make, or why they make none.
    ///
    /// # Errors
    /// A file without a row of numbers.
    pub fn explained(
        &self,
        file: usize,
        reader: &Reader,
        bytes: &[u8],
    ) -> Result<Rows, IdentifyError> {
        let table = read_table(bytes)?;
        let (read, refused) = match self.read(file, reader.clone(), bytes) {
            Ok(read) => (read, None),
            Err(error) => (Vec::new(), Some(error.to_string())),
        };
        let records = read.iter().map(|one| {
            json!({
                "kind": one.record.kind().name(),
                "samples": one.record.samples(),
                "temperature_c": one.temperature_c,
            })
        });
        let notes: Vec<&String> = read.iter().flat_map(|one| &one.notes).collect();
        Ok(rows([json!({
            "columns": reader.explained(&table),
            "segments": reader.segments(&table).unwrap_or_default(),
            "records": refused.is_none().then(|| records.collect::<Vec<_>>()),
            "records_reason": refused,
            "notes": notes,
        })]))
    }

    /// Fits records as they belong together; `names` are those of their files.
    ///
    /// # Errors
    /// Records that do not belong together, no candidate that fits, a stop.
    pub fn answer(
        &self,
        mut all: Vec<Understood>,
        names: &[String],
        stop: &AtomicBool,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<RecordAnswer, IdentifyError> {
        let (understood, rows) = match self.several {
            Several::Replicates => {
                let (records, understood) = Understood::specimens(all)?;
                let mut of_all = replicates(&records, &self.options, stop, progress)?;
                for (specimen, name) in of_all.specimens.iter().zip(names) {
                    let warnings = specimen.warnings.iter();
                    let warnings = warnings.map(|warnings| format!("{name}: {warnings}"));
                    of_all.all.warnings.extend(warnings);
                }
                return Ok(RecordAnswer {
                    understood,
                    rows: specimens(&of_all, names),
                    found: of_all.all,
                });
            }
            Several::MasterCurve { reference_c, by } => {
                let (curve, understood) = Understood::shifted(all, reference_c, by)?;
                (understood, shifts(&curve))
            }
            Several::Motions if all.len() == 1 => (all.remove(0), json!({})),
            Several::Motions => (Understood::together(all)?, json!({})),
        };
        let found = identify_unless(&understood.record, &self.options, stop, progress)?;
        Ok(RecordAnswer {
            understood,
            found,
            rows,
        })
    }
}

/// A tissue that was found.
#[derive(Clone, Debug)]
pub struct RecordAnswer {
    /// The records joined into one, as it was fitted.
    pub understood: Understood,
    /// Models fitted to that record, best first.
    pub found: Identification,
    /// Rows of specimens or of temperatures for the report; an empty object of one record.
    pub rows: Value,
}

impl RecordAnswer {
    /// The best model and what was found beside it, the candidates and the warnings; the files hold the tissue and its picture.
    #[must_use]
    pub fn report(&self, tissue: Option<String>, figure: Option<String>) -> Rows {
        let (found, notes) = (&self.found, &self.understood.notes);
        let fit = &found.fits[0];
        let finite = |&x: &f64| Some(x).filter(|x| x.is_finite());
        let correlation = fit.correlation.iter();
        let correlation = correlation.map(|row| row.iter().map(finite).collect::<Vec<_>>());
        let candidates = found.fits.iter().map(|fit| {
            let model = json!({"model": fit.kind.name()});
            let parameters = json!({"parameters": estimates(&fit.parameters)});
            rows([model, quality(found, fit), parameters])
        });
        let chosen = json!({
            "kind": found.kind.name(),
            "samples": found.samples,
            "loading": self.understood.loading,
            "model": fit.kind.name(),
            "parameters": estimates(fit.parameters.iter().chain(&found.placement)),
        });
        let further = json!({
            "candidates": candidates.collect::<Vec<_>>(),
            "correlation": correlation.collect::<Vec<_>>(),
            "tissue": tissue,
            "figure": figure,
            // Notes on the reading of the record; `warnings` has them too.
            "notes": notes,
            "warnings": notes.iter().chain(&found.warnings).collect::<Vec<_>>(),
        });
        rows([chosen, self.rows.clone(), quality(found, fit), further])
    }
}

fn quality(found: &Identification, fit: &Fit) -> Value {
    let rms = match (found.is_absolute, found.kind) {
        (true, RecordKind::Creep) => "rms_residual_per_pa",
        (true, _) => "rms_residual_pa",
        (false, _) => "rms_log_residual",
    };
    json!({rms: fit.rms, "aic": fit.aic, "bic": fit.bic})
}

fn specimens(found: &Replicates, names: &[String]) -> Value {
    let spreads = found.spreads.iter().map(|spread| {
        let spread_of = json!({
            "mean": spread.mean.value,
            "standard_deviation": spread.standard_deviation,
            "between_specimens": spread.between,
            "n": found.specimens.len(),
        });
        (spread.mean.name.to_owned(), spread_of)
    });
    let specimens = found.specimens.iter().zip(names).map(|(specimen, name)| {
        let all = specimen.fits[0]
            .parameters
            .iter()
            .chain(&specimen.placement);
        let values = all.map(|one| (one.name.to_owned(), json!(one.value)));
        let record = ("record".to_owned(), json!(name));
        Value::Object(std::iter::once(record).chain(values).collect())
    });
    json!({
        "spread": Value::Object(spreads.collect::<Map<_, _>>()),
        "specimens": specimens.collect::<Vec<_>>(),
    })
}

/// A row, with what storage and loss modulus say alone if there are two.
fn row_of_pair(mut row: Value, alone: Option<[f64; 2]>, [storage, loss]: [&str; 2]) -> Value {
    if let Some(alone) = alone {
        row[storage] = json!(alone[0]);
        row[loss] = json!(alone[1]);
    }
    row
}

fn shifts(curve: &MasterCurve) -> Value {
    let shifts = curve.shifts.iter().map(|shift| {
        let row = json!({
            "temperature_c": shift.temperature_c,
            "log10_shift": shift.log10,
            "standard_error": shift.standard_error,
        });
        row_of_pair(row, shift.alone, ["by_storage", "by_loss"])
    });
    let overlaps = curve.overlaps.iter().map(|overlap| {
        let row = json!({
            "from_c": overlap.temperatures_c[0],
            "to_c": overlap.temperatures_c[1],
            "points": overlap.points,
            "rms_log_misfit": overlap.misfit,
        });
        row_of_pair(row, overlap.alone, ["of_storage", "of_loss"])
    });
    let laws = curve.laws.iter().map(|law| {
        json!({
            "law": law.name,
            "rms_log10_shift": law.rms,
            "bic": law.bic,
            "parameters": estimates(&law.parameters),
        })
    });
    let law = curve.laws.first().filter(|_| curve.is_lawful);
    json!({
        "reference_temperature_c": curve.reference_c,
        "shifts": shifts.collect::<Vec<_>>(),
        "overlaps": overlaps.collect::<Vec<_>>(),
        "shifts_are_lawful": curve.is_lawful,
        "shift_laws": laws.collect::<Vec<_>>(),
        // Those of the better law; null where even that does not fit.
        "shift_law_parameters": law.map(|law| estimates(&law.parameters)),
    })
}

/// Each estimate under its name, with its unit, error and interval.
fn estimates<'a>(all: impl IntoIterator<Item = &'a Estimate>) -> Value {
    let parameters = all.into_iter().map(|estimate| {
        let parameter = json!({
            "value": estimate.value,
            "unit": if estimate.unit.is_empty() { "1" } else { estimate.unit },
            "standard_error": estimate.standard_error,
            "low_95": estimate.low_95,
            "high_95": estimate.high_95,
        });
        (estimate.name.to_owned(), parameter)
    });
    Value::Object(parameters.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A form as JSON, and what its question says or refuses.
    const REFUSED: &str = r#"
        {"fix": "order"} | `fix`: "order" is not PARAMETER=VALUE
        {"contact_point_m": "3m"} | `contact_point_m`: "3m" 3 m is not from -1 m to 1 m, nor fit
        {"contact_point_m": "deep"} | nor fit
        {"baseline": "curved"} | `baseline` "curved" is not one of constant, linear
        {"kind": "x"} | is not one of relaxation, creep, oscillation, record
        {"model": "x"} | is not one of auto, spring
        {"loading": "bend"} | is not one of shear
        {"master_curve": "-300degC"} | is not from -273.15 to 10000 degC
        {"master_curve": 20, "replicates": true} | exclude each other
        {"shift_by": "loss"} | no effect without `master_curve`
        {"shift_by": "phase", "master_curve": 20} | is not one of storage, loss, both
        {"temperature": "20"} | `temperature` has no effect without `master_curve`
        {"temperature": "20,30,40", "master_curve": "20"} | there are 2 files, and not as many temperatures (3)
    "#;

    #[test]
    fn a_form_is_understood_or_refused_in_a_line() {
        let question = |form: &str| {
            let form: RecordForm = serde_json::from_str(form).expect("a form");
            let question = RecordQuestion::of(&form)?;
            question.check(2).map(|()| question)
        };
        for [form, wanted] in testkit::table(REFUSED) {
            let error = question(&form).expect_err(&form).to_string();
            assert!(
                error.contains(&wanted) && !error.contains('\n'),
                "{form}: {error}"
            );
        }
        for (text, celsius) in [
            ("303.15K", 30.0),
            ("303.15 K", 30.0),
            ("30degC", 30.0),
            ("-20 °C", -20.0),
            ("0K", -273.15),
            ("25", 25.0),
        ] {
            let form = format!("{{\"master_curve\": \"{text}\", \"temperature\": \"20, {text}\"}}");
            let question = question(&form).expect(text);
            let Several::MasterCurve { reference_c, by } = question.several else {
                panic!("{text}: {:?}", question.several)
            };
            assert_eq!(by, ShiftBy::Both);
            assert!(
                (reference_c - celsius).abs() < 1e-9,
                "{text}: {reference_c}"
            );
            assert!((question.temperatures_c[1] - celsius).abs() < 1e-9);
        }
        let full = question(
            r#"{"contact_point_m": 1e-4, "fix": "order=0.1..0.3, elastic_modulus=2kPa", "model": "spring-pot", "segment": "1, 3", "ramp_time_s": 1}"#,
        )
        .expect("a question");
        assert_eq!(full.reading.contact, ContactPoint::At(1e-4));
        assert_eq!(full.options.held[1].low.to_bits(), 2000.0_f64.to_bits());
        assert_eq!(full.reader.segments, ["1", "3"]);
        assert!(full.options.candidates.contains(&ModelKind::Spring));
        assert!(!full.options.candidates.contains(&ModelKind::Zener));
        let rich = question(r#"{"model": "fractional-zener"}"#).expect("a question");
        assert!(rich.options.candidates.contains(&ModelKind::Jeffreys));
        assert!(!rich.options.candidates.contains(&ModelKind::Prony));
    }
}
