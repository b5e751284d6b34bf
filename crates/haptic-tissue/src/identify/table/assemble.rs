//! Columns as a record: its kind, and forces as stresses.

use super::super::error::IdentifyError;
use super::super::record::{Record, RecordKind};
use super::column::Column;
use crate::identify::keys::{AREA, COLUMNS, FROM, KIND, STRAIN, STRESS, THICKNESS};
use fracdiff::parameter::Shown;
use haptic_quantity::Key;

/// Facts of the experiment that a table lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loading {
    /// Held strain of a relaxation.
    pub strain: Option<f64>,
    /// Held stress of a creep test, Pa.
    pub stress_pa: Option<f64>,
    /// Area of the specimen, m²: stress = force/area.
    pub area_m2: Option<f64>,
    /// Thickness of the specimen, m: strain = position/thickness.
    pub thickness_m: Option<f64>,
}

/// Columns of numbers in SI units, all of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// Lines of the samples, for messages.
    pub lines: Vec<u64>,
    /// The columns with their names.
    pub values: Vec<(Column, String, Vec<f64>)>,
    /// Those that a user named: they come first, and each must have an effect.
    pub chosen: Vec<Column>,
    /// Guesses, units, omissions.
    pub notes: Vec<String>,
}

/// A record and its notes.
#[derive(Clone, Debug, PartialEq)]
pub struct Understood {
    /// The record.
    pub record: Record,
    /// Guesses and omitted rows.
    pub notes: Vec<String>,
}

/// The kind and the loading of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// The kind; `None`: inferred from the columns if clear.
    pub kind: Option<RecordKind>,
    /// Facts that the table lacks.
    pub loading: Loading,
}

impl Columns {
    /// Makes a record of the columns.
    ///
    /// # Errors
    /// Columns that make no record, or several; bad numbers, with their lines.
    pub fn record(mut self, reading: &Reading) -> Result<Understood, IdentifyError> {
        self.prefer_chosen();
        self.divide_by_specimen(&reading.loading)?;
        let kind = match reading.kind {
            Some(kind) => kind,
            None => {
                let kind = self.guess(&reading.loading)?;
                let names: Vec<&str> = self.values.iter().map(|value| value.1.as_str()).collect();
                self.notes.push(format!(
                    "kind {}, by the columns {}",
                    kind.name(),
                    names.join(", ")
                ));
                kind
            }
        };
        let record = match kind {
            RecordKind::Relaxation => self.relaxation(&reading.loading),
            RecordKind::Creep => self.creep(&reading.loading),
            RecordKind::Oscillation => self.oscillation(),
            RecordKind::History => self.history(),
        };
        let lines = &self.lines;
        let unused = self
            .values
            .iter()
            .find(|value| self.chosen.contains(&value.0));
        if let (Ok(_), Some((column, name, _))) = (&record, unused) {
            return Err(IdentifyError::Record(format!(
                "column {name} has no effect on a record of kind {}: omit {COLUMNS} {}=",
                kind.name(),
                column.name()
            )));
        }
        let record = record.map_err(|error| match error {
            IdentifyError::Sample { index, reason } if index < lines.len() => IdentifyError::Line {
                line: lines[index],
                column: None,
                reason,
            },
            other => other,
        })?;
        Ok(Understood {
            record,
            notes: self.notes,
        })
    }

    /// Drops what columns named by the user can provide, unless it is named too.
    fn prefer_chosen(&mut self) {
        let loads = [Column::Stress, Column::Force];
        let moves = [Column::Strain, Column::Position];
        let of_both = [loads, moves].concat();
        let made: [(Column, &[Column]); 4] = [
            (Column::Modulus, &of_both),
            (Column::Compliance, &of_both),
            (Column::Stress, &[Column::Force]),
            (Column::Strain, &[Column::Position]),
        ];
        let chosen = &self.chosen;
        let left_out = made.into_iter().filter(|(column, of)| {
            !chosen.contains(column) && of.iter().any(|column| chosen.contains(column))
        });
        let left_out: Vec<Column> = left_out.map(|(column, _)| column).collect();
        self.values.retain(|value| !left_out.contains(&value.0));
    }

    fn has(&self, column: Column) -> bool {
        self.values.iter().any(|value| value.0 == column)
    }

    fn take(&mut self, column: Column) -> Option<Vec<f64>> {
        let place = self.values.iter().position(|value| value.0 == column)?;
        Some(self.values.remove(place).2)
    }

    /// Forces and positions as stresses and strains, if the specimen is known.
    fn divide_by_specimen(&mut self, loading: &Loading) -> Result<(), IdentifyError> {
        let sizes = [
            (Column::Force, Column::Stress, loading.area_m2, AREA, "m²"),
            (
                Column::Position,
                Column::Strain,
                loading.thickness_m,
                THICKNESS,
                "m",
            ),
        ];
        for (from, to, size, parameter, unit) in sizes {
            let Some(size) = size else { continue };
            if !(size > 0.0 && size.is_finite()) {
                return Err(IdentifyError::Record(format!(
                    "{parameter} {size} {unit} is not above 0 {unit} and finite: change it",
                    size = Shown(size)
                )));
            }
            if self.has(to) {
                continue;
            }
            if let Some(value) = self.values.iter_mut().find(|value| value.0 == from) {
                value.0 = to;
                if self.chosen.contains(&from) {
                    self.chosen.push(to);
                }
                value.2.iter_mut().for_each(|x| *x /= size);
            } else {
                return Err(IdentifyError::Record(format!(
                    "{parameter} has no effect without a column {}: name it by {COLUMNS} {}=",
                    from.header(),
                    from.name()
                )));
            }
        }
        Ok(())
    }

    fn guess(&self, loading: &Loading) -> Result<RecordKind, IdentifyError> {
        let has = |column| self.has(column);
        let moves = has(Column::Strain) || has(Column::Position);
        let pushes = has(Column::Stress) || has(Column::Force);
        let mut kinds = Vec::new();
        if has(Column::Omega) && has(Column::Storage) && has(Column::Loss) {
            kinds.push(RecordKind::Oscillation);
        }
        if has(Column::Time) {
            if has(Column::Modulus) || (pushes && !moves && loading.strain.is_some()) {
                kinds.push(RecordKind::Relaxation);
            }
            if has(Column::Compliance) || (moves && !pushes && loading.stress_pa.is_some()) {
                kinds.push(RecordKind::Creep);
            }
            if moves && pushes && !has(Column::Modulus) && !has(Column::Compliance) {
                kinds.push(match (loading.strain, loading.stress_pa) {
                    (Some(_), None) => RecordKind::Relaxation,
                    (None, Some(_)) => RecordKind::Creep,
                    _ => RecordKind::History,
                });
            }
        }
        match kinds[..] {
            [kind] => Ok(kind),
            [] => Err(self.no_record()),
            _ => Err(IdentifyError::Record(format!(
                "the columns {} make more than one record: give {KIND}",
                self.names()
            ))),
        }
    }

    fn names(&self) -> String {
        let names: Vec<String> = (self.values.iter())
            .map(|(column, name, _)| format!("{name} ({})", column.name()))
            .collect();
        names.join(", ")
    }

    /// Columns that make no record, with what is missing.
    fn no_record(&self) -> IdentifyError {
        let has = |column| self.has(column);
        let found = match self.names() {
            names if names.is_empty() => "none that is known".to_owned(),
            names => names,
        };
        let missing = if has(Column::Time) && (has(Column::Stress) || has(Column::Force)) {
            format!("give {STRAIN}, the held strain of a relaxation")
        } else if has(Column::Time) && (has(Column::Strain) || has(Column::Position)) {
            format!("give {STRESS}, the held stress of a creep test")
        } else {
            format!("give time_s and relaxation_modulus_pa, or {COLUMNS}, as in time=1,modulus=3")
        };
        IdentifyError::Record(format!(
            "the columns make no record, found {found}: {missing}"
        ))
    }

    /// A column that the kind needs, or what to do.
    fn need(&mut self, column: Column, kind: RecordKind) -> Result<Vec<f64>, IdentifyError> {
        if let Some(taken) = self.take(column) {
            return Ok(taken);
        }
        let size = match column {
            Column::Stress if self.has(Column::Force) => format!(", or give {AREA}"),
            Column::Strain if self.has(Column::Position) => format!(", or give {THICKNESS}"),
            _ => String::new(),
        };
        Err(IdentifyError::Record(format!(
            "kind {} needs a column {}, found {}: change {KIND}, or give {COLUMNS} {}={size}",
            kind.name(),
            column.header(),
            self.names(),
            column.name()
        )))
    }

    /// A column that needs no held value.
    fn ready(
        &mut self,
        column: Column,
        loading: &Loading,
    ) -> Result<Option<Vec<f64>>, IdentifyError> {
        if !self.has(column) {
            return Ok(None);
        }
        no_effect(loading.strain, STRAIN, "")?;
        no_effect(loading.stress_pa, STRESS, " Pa")?;
        Ok(self.take(column))
    }

    /// Neither this column nor its source exists.
    fn neither(&mut self, column: Column, kind: RecordKind) -> IdentifyError {
        let missing = self.need(column, kind).err();
        missing.unwrap_or_else(|| self.no_record())
    }

    fn relaxation(&mut self, loading: &Loading) -> Result<Record, IdentifyError> {
        let kind = RecordKind::Relaxation;
        let time = self.need(Column::Time, kind)?;
        if let Some(modulus) = self.ready(Column::Modulus, loading)? {
            return Record::relaxation(time, modulus);
        }
        if !self.has(Column::Stress) {
            return Err(self.neither(Column::Modulus, kind));
        }
        no_effect(loading.stress_pa, STRESS, " Pa")?;
        let stress = self.need(Column::Stress, kind)?;
        if let Some(strain) = loading.strain.filter(|strain| strain.abs() > 1.0) {
            return Err(IdentifyError::Record(format!(
                "{STRAIN} {} is too much for a linear model: give a share, as 0.05 or 5%",
                Shown(strain)
            )));
        }
        let strain = held(loading.strain, self.take(Column::Strain), STRAIN, "")?;
        Record::relaxation(time, stress.iter().map(|stress| stress / strain).collect())
    }

    fn creep(&mut self, loading: &Loading) -> Result<Record, IdentifyError> {
        let kind = RecordKind::Creep;
        let time = self.need(Column::Time, kind)?;
        if let Some(compliance) = self.ready(Column::Compliance, loading)? {
            return Record::creep(time, compliance);
        }
        if !self.has(Column::Strain) {
            return Err(self.neither(Column::Compliance, kind));
        }
        no_effect(loading.strain, STRAIN, "")?;
        let strain = self.need(Column::Strain, kind)?;
        let stress = held(loading.stress_pa, self.take(Column::Stress), STRESS, " Pa")?;
        Record::creep(time, strain.iter().map(|strain| strain / stress).collect())
    }

    fn oscillation(&mut self) -> Result<Record, IdentifyError> {
        let kind = RecordKind::Oscillation;
        let omega = self.need(Column::Omega, kind)?;
        let storage = self.need(Column::Storage, kind)?;
        let loss = self.need(Column::Loss, kind)?;
        // Sweeps go up or down: sorted here, so messages name the right line.
        let mut order: Vec<usize> = (0..omega.len()).collect();
        order.sort_by(|&a, &b| omega[a].total_cmp(&omega[b]));
        let sorted = |values: &[f64]| order.iter().map(|&i| values[i]).collect();
        if !self.lines.is_empty() {
            self.lines = order.iter().map(|&i| self.lines[i]).collect();
        }
        Record::oscillation(sorted(&omega), sorted(&storage), sorted(&loss))
    }

    fn history(&mut self) -> Result<Record, IdentifyError> {
        let kind = RecordKind::History;
        let time = self.need(Column::Time, kind)?;
        let strain = self.need(Column::Strain, kind)?;
        let stress = self.need(Column::Stress, kind)?;
        Record::history(time, strain, stress)
    }
}

/// Refuses a loading that this kind does not need.
fn no_effect(given: Option<f64>, name: Key, unit: &str) -> Result<(), IdentifyError> {
    given.map_or(Ok(()), |given| {
        Err(IdentifyError::Record(format!(
            "{name} {given}{unit} has no effect on this record: omit it",
            given = Shown(given)
        )))
    })
}

/// The held strain or stress: given, or a column constant within 1 %.
fn held(
    given: Option<f64>,
    column: Option<Vec<f64>>,
    name: Key,
    unit: &str,
) -> Result<f64, IdentifyError> {
    const STAYS: f64 = 0.01;
    let mean = column
        .as_ref()
        .map(|column| column.iter().sum::<f64>() / column.len() as f64);
    let stays = mean.zip(column).is_none_or(|(mean, column)| {
        let near = |x: &f64| (x - mean).abs() <= STAYS * mean.abs();
        column.iter().all(near)
    });
    if let (Some(given), Some(mean)) = (given, mean)
        && !(stays && (given - mean).abs() <= STAYS * mean.abs())
    {
        return Err(IdentifyError::Record(format!(
            "{name} {}{unit} contradicts its column: omit it, or cut the record with {FROM}",
            Shown(given)
        )));
    }
    let value = given.or(mean.filter(|_| stays));
    match value {
        Some(value) if value.is_finite() && value != 0.0 => Ok(value),
        Some(value) => Err(IdentifyError::Record(format!(
            "{name} {}{unit} is not finite and other than 0{unit}: change it",
            Shown(value)
        ))),
        None => Err(IdentifyError::Record(format!(
            "{name} is unknown, or varies by more than 1 %: give it, or {}",
            KIND.set_to("record")
        ))),
    }
}
