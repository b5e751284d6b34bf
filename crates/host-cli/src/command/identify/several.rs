//! Several records of one command: motions of one tissue, specimens, temperatures.

use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_quantity::number;
use haptic_tissue::identify::table::Understood;
use haptic_tissue::identify::{
    Estimate, Identification, MasterCurve, Options, Replicates, identify, replicates,
};
use serde_json::{Map, Value, json};
use std::sync::atomic::AtomicBool;

/// Reference temperatures that a tissue can have, °C.
const TEMPERATURES: Range = Range::Within(-273.15, 10_000.0);

/// Reads a temperature in °C: `20degC`, or `20`.
fn temperature(text: &str) -> Result<f64, String> {
    let plain = ["degC", "°C", "C"]
        .iter()
        .find_map(|unit| text.strip_suffix(unit));
    let known =
        number(plain.unwrap_or(text).trim()).filter(|celsius| TEMPERATURES.contains(*celsius));
    known.ok_or_else(|| "is not from -273.15 to 10000 degC, as 20degC".to_owned())
}

/// Options that say how several records belong together.
#[derive(Debug, Args)]
#[command(next_help_heading = "Several records")]
pub(super) struct SeveralArguments {
    /// The records are of several specimens: fit each by itself, and take the mean
    #[arg(long, conflicts_with = "master_curve")]
    replicates: bool,
    /// The records, or segments, are at several temperatures: shift them to this one
    #[arg(long, value_name = "TEMPERATURE", value_parser = temperature, allow_hyphen_values = true)]
    master_curve: Option<f64>,
}

/// Records as one, what was found, and rows for the report.
pub(super) type Found = (Understood, Identification, Value);

impl SeveralArguments {
    /// True if all segments of a file are wanted.
    pub(super) const fn takes_all(&self) -> bool {
        self.master_curve.is_some()
    }

    /// True if segments of one clock are one motion: unless they are of several specimens or temperatures.
    pub(super) const fn joins(&self) -> bool {
        !self.replicates && self.master_curve.is_none()
    }

    /// Fits the records together, as they are meant.
    pub(super) fn found(
        &self,
        mut all: Vec<Understood>,
        names: &[String],
        options: &Options,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Found, Failure> {
        let one = |understood: &Understood| {
            identify(&understood.record, options, progress).map_err(Failure::input)
        };
        if self.replicates {
            let (records, understood) = Understood::specimens(all).map_err(Failure::input)?;
            let stop = AtomicBool::new(false);
            let mut found =
                replicates(&records, options, &stop, progress).map_err(Failure::input)?;
            for (specimen, name) in found.specimens.iter().zip(names) {
                let warnings = specimen
                    .warnings
                    .iter()
                    .map(|said| format!("{name}: {said}"));
                found.all.warnings.extend(warnings);
            }
            let rows = specimens(&found, names);
            return Ok((understood, found.all, rows));
        }
        if let Some(reference_c) = self.master_curve {
            let (curve, understood) =
                Understood::shifted(all, reference_c).map_err(Failure::input)?;
            let found = one(&understood)?;
            return Ok((understood, found, shifts(&curve, reference_c)));
        }
        let understood = match all.pop() {
            Some(one) if all.is_empty() => one,
            last => {
                all.extend(last);
                Understood::together(all).map_err(Failure::input)?
            }
        };
        let found = one(&understood)?;
        Ok((understood, found, json!({})))
    }
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
        let all = specimen.fits[0].parameters.iter().chain(&specimen.beside);
        let values = all.map(|one| (one.name.to_owned(), json!(one.value)));
        let record = ("record".to_owned(), json!(name));
        Value::Object(std::iter::once(record).chain(values).collect())
    });
    json!({
        "spread": Value::Object(spreads.collect::<Map<_, _>>()),
        "specimens": specimens.collect::<Vec<_>>(),
    })
}

fn shifts(curve: &MasterCurve, reference_c: f64) -> Value {
    let shifts = curve.shifts.iter().map(|shift| {
        json!({
            "temperature_c": shift.temperature_c,
            "log10_shift": shift.log10,
            "standard_error": shift.standard_error,
        })
    });
    let laws = curve.laws.iter().map(|law| {
        let law_of: &[Estimate] = &law.parameters;
        json!({"law": law.name, "rms_log10_shift": law.rms, "bic": law.bic, "parameters": estimates(law_of)})
    });
    json!({
        "reference_temperature_c": reference_c,
        "shifts": shifts.collect::<Vec<_>>(),
        "shift_laws": laws.collect::<Vec<_>>(),
    })
}

/// Each estimate under its name, with its unit, error and interval.
pub(super) fn estimates<'a>(all: impl IntoIterator<Item = &'a Estimate>) -> Value {
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
