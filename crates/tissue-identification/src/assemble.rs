//! Columns as a record: its kind, how its specimen was loaded, and forces as stresses.

use super::commanded::{is_level, of_stress, without_noise};
use super::error::IdentifyError;
use super::keys::{
    AREA, BONDED, COLUMNS, CONTACT_POINT, FROM, HALF_ANGLE, KIND, LOADING, MASTER_CURVE,
    POISSON_RATIO, RADIUS, RAMP_ENDS, RAMP_TIME, SKIP_BAD_ROWS, STRAIN, STRESS, SUBTRACT_START,
    TEMPERATURE, THICKNESS,
};
use super::master::{MasterCurve, ShiftBy, master_curve};
use super::record::{ContactPoint, Record, RecordKind, area, within};
use fracdiff::parameter::Shown;
use haptic_loop::{INCOMPRESSIBLE, Loading, LoadingKind, LoopParameterError, Modulus, Specimen};
use haptic_quantity::{Key, label};
use haptic_tissue::MeasuredLoading;
use measured_table::{Column, Columns, TableError, are_few, passed, words};
use std::collections::HashSet;

/// A record and its notes.
#[derive(Clone, Debug, PartialEq)]
pub struct Understood {
    /// The record in SI units, ready to be fitted.
    pub record: Record,
    /// Loading of the specimen, as far as it is known.
    pub loading: MeasuredLoading,
    /// One sentence for each thing guessed or left out.
    pub notes: Vec<String>,
    /// Its temperature, °C, if the table says it.
    pub temperature_c: Option<f64>,
}

impl Understood {
    /// Several motions of one tissue, to be fitted together.
    ///
    /// # Errors
    /// As [`Record::together`]; records of different moduli.
    pub fn together(all: Vec<Self>) -> Result<Self, IdentifyError> {
        let (records, understood) = Self::specimens(all)?;
        Ok(Self {
            record: Record::together(records)?,
            ..understood
        })
    }

    /// Several specimens of one tissue, to be fitted one by one: their records, and what is understood of all, with the first record.
    ///
    /// # Errors
    /// Records of different moduli.
    pub fn specimens(all: Vec<Self>) -> Result<(Vec<Record>, Self), IdentifyError> {
        let records = all.iter().map(|one| one.record.clone()).collect();
        let mut all = all.into_iter();
        let Some(mut first) = all.next() else {
            return Err(IdentifyError::Record(
                "there is no record: give one".to_owned(),
            ));
        };
        for one in all {
            if one.loading != first.loading {
                return Err(IdentifyError::Record(format!(
                    "the records are loaded differently: give {LOADING}, or records of one loading"
                )));
            }
            first.notes.extend(one.notes);
        }
        let mut known = HashSet::new();
        first.notes.retain(|note| known.insert(note.clone()));
        first.temperature_c = None;
        Ok((records, first))
    }

    /// Records at several temperatures as a master curve at a reference temperature.
    ///
    /// # Errors
    /// As [`master_curve`]; a record that does not say its temperature; records of different moduli.
    pub fn shifted(
        all: Vec<Self>,
        reference_c: f64,
        by: ShiftBy,
    ) -> Result<(MasterCurve, Self), IdentifyError> {
        let temperatures: Option<Vec<f64>> = all.iter().map(|one| one.temperature_c).collect();
        let (records, mut understood) = Self::specimens(all)?;
        let Some(temperatures) = temperatures else {
            return Err(IdentifyError::Record(format!(
                "{MASTER_CURVE} needs the temperature of each record, and one has none: give {TEMPERATURE}, or name its column by {COLUMNS} {}=",
                Column::Temperature.name()
            )));
        };
        let both = temperatures.into_iter().zip(records);
        let curve = master_curve(both.collect(), reference_c, by)?;
        understood.record = curve.record.clone();
        understood.temperature_c = Some(curve.reference_c);
        Ok((curve, understood))
    }
}

/// Details that a table lacks: the held value of a step, and the specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableDetails {
    /// The kind; `None`: inferred from the columns if clear.
    pub kind: Option<RecordKind>,
    /// Held strain of a relaxation.
    pub strain: Option<f64>,
    /// Held stress of a creep test, Pa.
    pub stress_pa: Option<f64>,
    /// The sizes of the specimen, which turn force into stress and position into strain, and how it was loaded.
    pub loading: Loading,
    /// True if the kind of the loading is given; otherwise headers may give it.
    pub loading_is_told: bool,
    /// Poisson's ratio, if it is known.
    pub poisson_ratio: Option<f64>,
    /// Depth at which an indenter touches.
    pub contact: ContactPoint,
    /// Length of the ramp to the held strain of a relaxation, s.
    pub ramp_time_s: Option<f64>,
    /// End of this ramp on the clock of the record, s; `None` if it begins at 0.
    pub ramp_ends_s: Option<f64>,
    /// True to count strain and stress of a motion from their first row: at rest, but not at 0.
    pub subtract_start: bool,
    /// True if the position was commanded, as a testing machine's is: a force that stays at a level was not.
    pub position_was_commanded: bool,
}

impl Default for TableDetails {
    /// No detail is given; forces compress a slab.
    fn default() -> Self {
        Self {
            kind: None,
            strain: None,
            stress_pa: None,
            loading: Loading::new(LoadingKind::Compression),
            loading_is_told: false,
            poisson_ratio: None,
            contact: ContactPoint::Zero,
            ramp_time_s: None,
            ramp_ends_s: None,
            subtract_start: false,
            position_was_commanded: false,
        }
    }
}

impl TableDetails {
    /// The record that columns make.
    ///
    /// # Errors
    /// Columns that do not make exactly one record; bad numbers, with their lines; more of them than may be left out.
    pub fn record(&self, columns: Columns) -> Result<Understood, IdentifyError> {
        Assembly(columns, None).record(self)
    }
}

/// Columns that become a record, and the phase or loss tangent of which, with |G*|, storage and loss modulus were made.
#[derive(Clone)]
struct Assembly(Columns, Option<Column>);

impl Assembly {
    fn record(mut self, reading: &TableDetails) -> Result<Understood, IdentifyError> {
        let Some(mut bad) = self.0.bad.take() else {
            let made = self.clone().made(reading);
            let Err(IdentifyError::Table(error)) = made else {
                return made;
            };
            self.0.bad = Some(Vec::new());
            let helps = self.record(reading).is_ok();
            return Err(if helps { error.or_skip() } else { error }.into());
        };
        let rows = self.0.lines.len() + bad.len();
        loop {
            let made = self.clone().made(reading);
            if let Err(IdentifyError::Table(TableError::Line { line, .. })) = made
                && let Some(row) = self.0.lines.iter().position(|known| *known == line)
            {
                bad.push(line);
                self.0.lines.remove(row);
                for (.., values) in self.0.values.iter_mut().chain(&mut self.0.errors) {
                    values.remove(row);
                }
            } else if are_few(bad.len(), rows) {
                let mut understood = made?;
                bad.sort_unstable();
                let left_out = passed(
                    &bad,
                    "no sample: a cell that is no number, or a value that cannot be",
                );
                understood.notes.extend(left_out);
                return Ok(understood);
            }
            if !are_few(bad.len(), rows) {
                return Err(IdentifyError::Record(format!(
                    "{} bad rows are more than a tenth of all, which is too many for {SKIP_BAD_ROWS}: correct the table, or name its columns by {COLUMNS}",
                    bad.len()
                )));
            }
        }
    }

    fn made(mut self, reading: &TableDetails) -> Result<Understood, IdentifyError> {
        self.prefer_chosen();
        let mut measured = self.measured(reading)?;
        self.storage_and_loss();
        let loading = Loading {
            kind: measured.kind.unwrap_or(reading.loading.kind),
            ..reading.loading
        };
        let poisson_ratio = measured.poisson_ratio();
        let indented = !loading.kind.is_slab() && !self.is_of_material();
        if indented {
            if !(self.0.has(Column::Force) && self.0.has(Column::Position)) {
                return Err(IdentifyError::Record(format!(
                    "{LOADING} {} needs columns force_n and position_m, found {}: name them by {COLUMNS}",
                    loading.kind.name(),
                    self.names()
                )));
            }
            no_effect(reading.strain, STRAIN, "")?;
            no_effect(reading.stress_pa, STRESS, " Pa")?;
        } else {
            self.divide_by_specimen(&loading, measured.kind, poisson_ratio)?;
        }
        let creeps = !reading.position_was_commanded && self.is_commanded_creep(reading, indented);
        let kind = match (reading.kind, creeps) {
            (Some(RecordKind::Creep | RecordKind::History) | None, true) => {
                self.0.notes.push("kind creep: the stress stays at levels within its noise, so it was commanded, and the strain is fitted".to_owned());
                RecordKind::Creep
            }
            (Some(kind), _) => kind,
            (None, _) => {
                let kind = self.guess(reading)?;
                let names: Vec<&str> = self.0.values.iter().map(|value| value.1.as_str()).collect();
                self.0.notes.push(format!(
                    "kind {}, by the columns {}",
                    kind.name(),
                    names.join(", ")
                ));
                kind
            }
        };
        if (indented || loading.bonded) && measured.poisson_ratio.is_none() {
            // The modulus is one of this number.
            measured.poisson_ratio = Some(poisson_ratio);
            self.0.notes.push(format!(
                "Poisson's ratio is taken as {poisson_ratio}, incompressible: give {POISSON_RATIO} if it is another"
            ));
        }
        if !indented && reading.contact != ContactPoint::Zero {
            return Err(IdentifyError::Record(format!(
                "{CONTACT_POINT} has no effect on this record, which is not of an indenter: omit it, or give {LOADING}"
            )));
        }
        if kind != RecordKind::Relaxation {
            no_effect(reading.ramp_time_s, RAMP_TIME, " s")?;
        }
        if reading.ramp_time_s.is_none() {
            no_effect(reading.ramp_ends_s, RAMP_ENDS, " s")?;
        }
        if reading.subtract_start && (indented || kind != RecordKind::History) {
            return Err(IdentifyError::Record(format!(
                "{SUBTRACT_START} has no effect on this record: omit it"
            )));
        }
        let record = match kind {
            RecordKind::Relaxation => self.relaxation(reading),
            RecordKind::Creep => self.creep(reading),
            RecordKind::Oscillation => self.oscillation(),
            RecordKind::History if indented => {
                self.pressed(loading, poisson_ratio, reading.contact)
            }
            RecordKind::History => self.history(reading.subtract_start),
        };
        self.is_clear()?;
        let lines = &self.0.lines;
        let mut values = self.0.values.iter();
        let unused = values.find(|value| self.0.chosen.contains(&value.0));
        if let (Ok(_), Some((column, name, _))) = (&record, unused) {
            return Err(IdentifyError::Record(format!(
                "column {name} has no effect on a record of kind {}: omit {COLUMNS} {}=",
                kind.name(),
                column.name()
            )));
        }
        let record = record.map_err(|error| of_line(error, lines))?;
        let unused = self.0.errors.iter().map(|(column, name, _)| {
            format!(
                "column {name} looks like errors of the {}, which do not count: they are not of what is fitted, or not of all of it",
                column.name()
            )
        });
        self.0.notes.extend(unused);
        Ok(Understood {
            record,
            loading: measured,
            notes: self.0.notes,
            temperature_c: self.0.temperature_c,
        })
    }

    /// Refuses a record of a quantity that two headers could be: one that was taken out.
    fn is_clear(&self) -> Result<(), IdentifyError> {
        let doubt = self.0.unclear.iter().find(|column| !self.0.has(column.0));
        doubt.map_or(Ok(()), |(_, asked)| {
            Err(IdentifyError::Record(asked.clone()))
        })
    }

    /// Loading of the specimen: as the user gives it, else as the headers do.
    fn measured(&mut self, reading: &TableDetails) -> Result<MeasuredLoading, IdentifyError> {
        if let Some(ratio) = reading.poisson_ratio
            && !(0.0..=INCOMPRESSIBLE).contains(&ratio)
        {
            return Err(IdentifyError::Record(format!(
                "{POISSON_RATIO} {} is not from 0 to {INCOMPRESSIBLE}: change it",
                Shown(ratio)
            )));
        }
        let of_modulus = [
            Column::Modulus,
            Column::Storage,
            Column::Loss,
            Column::Complex,
        ];
        let headers = self.0.values.iter().map(|value| {
            let loading_of = loading_of(&value.1);
            let modulus = loading_of.modulus.filter(|_| of_modulus.contains(&value.0));
            (value.1.as_str(), loading_of.kind, modulus)
        });
        let kinds = headers
            .clone()
            .filter_map(|(name, kind, _)| Some((name, kind?)));
        let kinds: Vec<_> = kinds.collect();
        let given = reading.loading_is_told.then_some(reading.loading.kind);
        if let (Some(given), Some((name, other))) =
            (given, kinds.iter().find(|named| Some(named.1) != given))
        {
            return Err(IdentifyError::Record(format!(
                "column {name} is of {}, and {LOADING} is {}: change one of them",
                other.name(),
                given.name()
            )));
        }
        let kind = given.or(agreed(kinds.iter().map(|named| named.1)));
        let symbols = headers.filter_map(|(name, _, modulus)| Some((name, modulus?)));
        let symbols: Vec<(&str, Modulus)> = symbols.collect();
        // A slab has one modulus by its loading; what an indenter measured may be written as either.
        let of_slab = given.filter(|one| one.is_slab()).map(LoadingKind::modulus);
        let of_header = agreed(symbols.iter().map(|named| named.1));
        let modulus = of_slab.or(of_header).or(kind.map(LoadingKind::modulus));
        let mut symbols = symbols.iter();
        let other = symbols.find(|named| of_slab.is_some_and(|modulus| modulus != named.1));
        let other = other.map(|(name, _)| format!(
            "column {name} is taken as the modulus that {LOADING} tells: change {LOADING} if it is another"
        ));
        let loading = MeasuredLoading {
            kind,
            modulus,
            poisson_ratio: reading.poisson_ratio,
        };
        self.0.notes.extend(other);
        self.0.notes.extend(match (given, modulus) {
            (Some(_), _) => None,
            (None, Some(modulus)) => Some(format!(
                "the modulus is {}, by the columns: give {LOADING} if it is another",
                match modulus {
                    Modulus::Shear => "that of shear",
                    Modulus::Young => "Young's",
                }
            )),
            (None, None) => Some(format!(
                "loading unknown: the modulus is taken as Young's; give {LOADING}"
            )),
        });
        Ok(loading)
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
        let chosen = &self.0.chosen;
        let left_out = made.into_iter().filter(|(column, of)| {
            !chosen.contains(column) && of.iter().any(|column| chosen.contains(column))
        });
        let left_out: Vec<Column> = left_out.map(|(column, _)| column).collect();
        self.0.values.retain(|value| !left_out.contains(&value.0));
    }

    fn take(&mut self, column: Column) -> Option<Vec<f64>> {
        let index = self.0.values.iter().position(|value| value.0 == column)?;
        Some(self.0.values.remove(index).2)
    }

    /// Errors of a column, over this; none if it has none.
    fn errors_of(&mut self, column: Column, per: f64) -> Vec<f64> {
        let index = self.0.errors.iter().position(|errors| errors.0 == column);
        let Some((_, name, mut errors)) = index.map(|index| self.0.errors.remove(index)) else {
            return Vec::new();
        };
        errors.iter_mut().for_each(|error| *error /= per.abs());
        self.0.notes.push(format!(
            "column {name} is taken for the errors of the {}, which weigh its rows",
            column.name()
        ));
        errors
    }

    /// True if a modulus or compliance is there already.
    fn is_of_material(&self) -> bool {
        let columns = [Column::Modulus, Column::Compliance, Column::Storage];
        columns.iter().any(|column| self.0.has(*column))
    }

    /// Forces and positions as stresses and strains of a slab, if its sizes are known.
    fn divide_by_specimen(
        &mut self,
        loading: &Loading,
        known: Option<LoadingKind>,
        poisson_ratio: f64,
    ) -> Result<(), IdentifyError> {
        let kind = loading.kind.name();
        for (given, key) in [
            (loading.radius_m.is_some(), RADIUS),
            (loading.half_angle_rad.is_some(), HALF_ANGLE),
            (loading.bonded && !self.0.has(Column::Force), BONDED),
        ] {
            if given {
                return Err(IdentifyError::Record(format!(
                    "{key} has no effect on this record of {kind}: omit it, or change {LOADING}"
                )));
            }
        }
        if loading.bonded && (self.0.has(Column::Stress) || self.is_of_material()) {
            return Err(IdentifyError::Record(format!(
                "{BONDED} acts on the force, and the record has columns {}: give {COLUMNS} {}=, or omit {BONDED}",
                self.names(),
                Column::Force.name()
            )));
        }
        let bonded = loading.bonded.then(|| specimen(*loading, poisson_ratio));
        let bonded_area = bonded.transpose()?.as_ref().map(area);
        let sizes = [
            (
                Column::Force,
                Column::Stress,
                bonded_area.or(loading.area_m2),
                AREA,
                "m²",
            ),
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
            if self.0.has(to) {
                continue;
            }
            if let Some(value) = self.0.values.iter_mut().find(|value| value.0 == from) {
                value.0 = to;
                if self.0.chosen.contains(&from) {
                    self.0.chosen.push(to);
                }
                if let Some(kind) = known.filter(|_| from == Column::Position) {
                    within(&value.2, size, kind).map_err(|error| of_line(error, &self.0.lines))?;
                }
                value.2.iter_mut().for_each(|x| *x /= size);
                for errors in self.0.errors.iter_mut().filter(|errors| errors.0 == from) {
                    errors.0 = to;
                    errors.2.iter_mut().for_each(|x| *x /= size);
                }
            } else if !(loading.bonded && from == Column::Position) {
                return Err(IdentifyError::Record(format!(
                    "{parameter} has no effect without a column {}: name it by {COLUMNS} {}=, or omit {parameter}",
                    from.header(),
                    from.name()
                )));
            }
        }
        Ok(())
    }

    fn guess(&self, reading: &TableDetails) -> Result<RecordKind, IdentifyError> {
        let has = |column| self.0.has(column);
        let moves = has(Column::Strain) || has(Column::Position);
        let pushes = has(Column::Stress) || has(Column::Force);
        let mut kinds = Vec::new();
        if has(Column::Omega) && has(Column::Storage) && has(Column::Loss) {
            kinds.push(RecordKind::Oscillation);
        }
        if has(Column::Time) {
            if has(Column::Modulus) || (pushes && !moves && reading.strain.is_some()) {
                kinds.push(RecordKind::Relaxation);
            }
            if has(Column::Compliance) || (moves && !pushes && reading.stress_pa.is_some()) {
                kinds.push(RecordKind::Creep);
            }
        }
        if moves && pushes && !has(Column::Modulus) && !has(Column::Compliance) {
            kinds.push(match (reading.strain, reading.stress_pa) {
                (Some(_), None) if has(Column::Time) => RecordKind::Relaxation,
                (None, Some(_)) if has(Column::Time) => RecordKind::Creep,
                _ => RecordKind::History,
            });
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
        let names: Vec<String> = (self.0.values.iter())
            .map(|(column, name, _)| format!("{name} ({})", column.name()))
            .collect();
        names.join(", ")
    }

    /// Columns that make no record, with what is missing.
    fn no_record(&self) -> IdentifyError {
        let has = |column| self.0.has(column);
        let found = match self.names() {
            names if names.is_empty() => "none that is known".to_owned(),
            names => names,
        };
        let missing = if has(Column::Time) && (has(Column::Stress) || has(Column::Force)) {
            format!("give {STRAIN}, the held strain of a relaxation")
        } else if has(Column::Time) && (has(Column::Strain) || has(Column::Position)) {
            format!("give {STRESS}, the held stress of a creep test")
        } else if self.0.values.len() > 1 && !has(Column::Time) && !has(Column::Omega) {
            format!("add a column of times, or name it with {COLUMNS}, as in time=3")
        } else {
            format!(
                "give time_s and relaxation_modulus_pa, or {COLUMNS}, as in time=1,modulus=3; of a plant's input and output `control identify` makes a plant"
            )
        };
        IdentifyError::Record(format!(
            "the columns make no record, found {found}: {missing}"
        ))
    }

    /// True of strain and stress of a slab whose stress was commanded.
    fn is_commanded_creep(&self, reading: &TableDetails, indented: bool) -> bool {
        let values = |column| self.0.values.iter().find(|value| value.0 == column);
        let both = values(Column::Strain).zip(values(Column::Stress));
        let is_plain = !indented && self.0.has(Column::Time) && !reading.subtract_start;
        let is_given = reading.strain.is_some() || reading.stress_pa.is_some();
        let levels = both.and_then(|(strain, stress)| of_stress(&strain.2, &stress.2));
        is_plain && !is_given && !self.is_of_material() && levels.is_some()
    }

    /// A column that the kind needs, or what to do.
    fn need(&mut self, column: Column, kind: RecordKind) -> Result<Vec<f64>, IdentifyError> {
        if let Some(taken) = self.take(column) {
            return Ok(taken);
        }
        if self.0.has(Column::Force) && self.0.has(Column::Position) {
            return Err(IdentifyError::Record(format!(
                "force and depth need a specimen: give {} and {RADIUS} for an indenter, or {AREA} and {THICKNESS} for a slab",
                LOADING.set_to(LoadingKind::Sphere.name())
            )));
        }
        let size = if column == Column::Stress && self.0.has(Column::Force) {
            format!(", or give {AREA}")
        } else if column == Column::Strain && self.0.has(Column::Position) {
            format!(", or give {THICKNESS}")
        } else {
            String::new()
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
        reading: &TableDetails,
    ) -> Result<Option<Vec<f64>>, IdentifyError> {
        if !self.0.has(column) {
            return Ok(None);
        }
        no_effect(reading.strain, STRAIN, "")?;
        no_effect(reading.stress_pa, STRESS, " Pa")?;
        Ok(self.take(column))
    }

    /// Neither this column nor its source exists.
    fn neither(&mut self, column: Column, kind: RecordKind) -> IdentifyError {
        let missing = self.need(column, kind).err();
        missing.unwrap_or_else(|| self.no_record())
    }

    /// Storage and loss modulus of what a rheometer writes instead: G′ = |G*|·cos δ, G″ = |G*|·sin δ = G′·tan δ; of two moduli the third by
    /// |G*|² = G′² + G″².
    fn storage_and_loss(&mut self) {
        let both = [Column::Storage, Column::Loss];
        if both.into_iter().all(|column| self.0.has(column)) {
            let others = [Column::Complex, Column::Phase, Column::LossTangent];
            let chosen = &self.0.chosen;
            let stays = |column: Column| !others.contains(&column) || chosen.contains(&column);
            self.0.values.retain(|value| stays(value.0));
            return;
        }
        let find = |column| {
            let mut values = self.0.values.iter();
            Some(values.find(|value| value.0 == column)?.2.clone())
        };
        let each = |a: Option<Vec<f64>>, b: &[f64], of: fn(f64, f64) -> f64| {
            let pairs = a?.into_iter().zip(b);
            Some(pairs.map(|(a, b)| of(a, *b)).collect::<Vec<f64>>())
        };
        let [storage, complex, loss] = [Column::Storage, Column::Complex, Column::Loss].map(find);
        let of_size = |part: &Option<Vec<f64>>, of: fn(f64, f64) -> f64| {
            each(complex.clone(), part.as_ref()?, of)
        };
        let phase = || Some(find(Column::Phase)?.into_iter().map(libm::tan).collect());
        let tangent = find(Column::LossTangent)
            .or_else(phase)
            .or_else(|| of_size(&storage, |size, storage| other(size, storage) / storage))
            .or_else(|| of_size(&loss, |size, loss| loss / other(size, loss)));
        let Some(tangent) = tangent else { return };
        let storage = storage
            .or_else(|| each(complex, &tangent, |size, t| size / libm::sqrt(1.0 + t * t)))
            .or_else(|| each(loss, &tangent, |loss, t| loss / t));
        let Some(storage) = storage else { return };
        if self.0.has(Column::Complex) && !self.0.has(Column::Storage) {
            let turns = [Column::LossTangent, Column::Phase];
            self.1 = turns.into_iter().find(|column| self.0.has(*column));
        }
        let pairs = storage.iter().zip(tangent);
        let loss = pairs.map(|(storage, t)| storage * t).collect();
        let made = [
            Column::Complex,
            Column::Phase,
            Column::LossTangent,
            Column::Storage,
            Column::Loss,
        ];
        let names = self.0.values.iter().filter(|value| made.contains(&value.0));
        let names: Vec<&str> = names.map(|value| value.1.as_str()).collect();
        let names = names.join(" and ");
        self.0
            .notes
            .push(format!("storage and loss modulus are made of {names}"));
        self.0.values.retain(|value| !made.contains(&value.0));
        self.0.chosen.retain(|column| !made.contains(column));
        for (column, values) in both.into_iter().zip([storage, loss]) {
            let name = column.header().to_owned();
            self.0.values.push((column, name, values));
        }
    }

    /// Loads with the sign in which the tissue resists, as where compression is written below 0.
    fn upright(&mut self, work: f64, loads: &mut [f64], what: &str) {
        if work < 0.0 {
            loads.iter_mut().for_each(|load| *load = -*load);
            self.0.notes.push(format!(
                "the {what} is read with the other sign, so that the modulus is above 0"
            ));
        }
    }

    fn relaxation(&mut self, reading: &TableDetails) -> Result<Record, IdentifyError> {
        let kind = RecordKind::Relaxation;
        let time = self.need(Column::Time, kind)?;
        if let Some(modulus) = self.ready(Column::Modulus, reading)? {
            let errors = self.errors_of(Column::Modulus, 1.0);
            return self.relaxed(time, modulus, errors, None, reading);
        }
        if !self.0.has(Column::Stress) {
            return Err(self.neither(Column::Modulus, kind));
        }
        no_effect(reading.stress_pa, STRESS, " Pa")?;
        let stress = self.need(Column::Stress, kind)?;
        if let Some(strain) = reading.strain.filter(|strain| strain.abs() > 1.0) {
            return Err(IdentifyError::Record(format!(
                "{STRAIN} {} is too much for a linear model: give a share, as 0.05 or 5%",
                Shown(strain)
            )));
        }
        let strain = held(reading.strain, self.take(Column::Strain), STRAIN, "")?;
        let modulus = stress.iter().map(|stress| stress / strain).collect();
        let errors = self.errors_of(Column::Stress, strain);
        self.relaxed(time, modulus, errors, Some(strain.abs()), reading)
    }

    /// Stress over the held strain, after a step or with the ramp to it.
    fn relaxed(
        &mut self,
        time: Vec<f64>,
        mut modulus: Vec<f64>,
        mut errors: Vec<f64>,
        strain: Option<f64>,
        reading: &TableDetails,
    ) -> Result<Record, IdentifyError> {
        self.upright(modulus.iter().sum(), &mut modulus, "stress");
        let Some(ramp_s) = reading.ramp_time_s else {
            let record = Record::relaxation(time, modulus)?.with_errors(&errors, &[])?;
            return Ok(match strain {
                Some(strain) => record.with_strain_to(strain),
                None => record,
            });
        };
        // Stress and strain over an unknown strain are those of a strain of 1.
        let held = strain.unwrap_or(1.0);
        let ends_s = reading.ramp_ends_s.unwrap_or(ramp_s);
        if time.first().is_some_and(|first| *first > ends_s - ramp_s) {
            self.0.lines.splice(..0, self.0.lines.first().copied());
            errors.splice(..0, errors.first().copied());
        }
        errors.iter_mut().for_each(|error| *error *= held);
        let stress = modulus.iter().map(|modulus| modulus * held).collect();
        let record = Record::ramp(time, stress, held, ramp_s, ends_s)?;
        let mut record = record.with_errors(&errors, &[])?;
        if strain.is_none() {
            record.forget_strain();
        }
        Ok(record)
    }

    fn creep(&mut self, reading: &TableDetails) -> Result<Record, IdentifyError> {
        let kind = RecordKind::Creep;
        let is_commanded = self.is_commanded_creep(reading, false);
        let time = self.need(Column::Time, kind)?;
        if let Some(compliance) = self.ready(Column::Compliance, reading)? {
            let errors = self.errors_of(Column::Compliance, 1.0);
            return Record::creep(time, compliance)?.with_errors(&errors, &[]);
        }
        if !self.0.has(Column::Strain) {
            return Err(self.neither(Column::Compliance, kind));
        }
        no_effect(reading.strain, STRAIN, "")?;
        let mut strain = self.need(Column::Strain, kind)?;
        if is_commanded {
            let stress = self.need(Column::Stress, kind)?;
            let work = strain.iter().zip(&stress).map(|(e, s)| e * s).sum();
            self.upright(work, &mut strain, "strain");
            let errors = self.errors_of(Column::Strain, 1.0);
            return Record::creep_under(time, strain, stress)?.with_errors(&errors, &[]);
        }
        let stress = held(reading.stress_pa, self.take(Column::Stress), STRESS, " Pa")?;
        let most = strain.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut compliance: Vec<f64> = strain.iter().map(|strain| strain / stress).collect();
        self.upright(compliance.iter().sum(), &mut compliance, "strain");
        let errors = self.errors_of(Column::Strain, stress);
        let record = Record::creep(time, compliance)?.with_errors(&errors, &[])?;
        Ok(record.with_strain_to(most))
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
        if !self.0.lines.is_empty() {
            self.0.lines = order.iter().map(|&i| self.0.lines[i]).collect();
        }
        let record = Record::oscillation(sorted(&omega), sorted(&storage), sorted(&loss))?;
        let both = match self.1 {
            Some(turn) => [Column::Complex, turn],
            None => [Column::Storage, Column::Loss],
        };
        let has_errors = |column: &Column| self.0.errors.iter().any(|errors| errors.0 == *column);
        if !both.iter().all(has_errors) {
            return Ok(record);
        }
        let errors = both.map(|column| sorted(&self.errors_of(column, 1.0)));
        let [first, mut second]: [Vec<f64>; 2] = errors;
        if self.1 == Some(Column::LossTangent) {
            // dδ = d tan δ/(1 + tan² δ).
            for (error, &row) in second.iter_mut().zip(&order) {
                let tangent = loss[row] / storage[row];
                *error /= 1.0 + tangent * tangent;
            }
        }
        if self.1.is_some() {
            record.with_polar_errors(&first, &second)
        } else {
            record.with_errors(&first, &second)
        }
    }

    /// Times, or the same one for all samples of a table without.
    fn times(&mut self) -> Vec<f64> {
        let samples = self.0.values.first().map_or(0, |value| value.2.len());
        self.take(Column::Time)
            .unwrap_or_else(|| vec![0.0; samples])
    }

    fn history(&mut self, subtract_start: bool) -> Result<Record, IdentifyError> {
        let kind = RecordKind::History;
        let time = self.times();
        let mut strain = self.need(Column::Strain, kind)?;
        let mut stress = self.need(Column::Stress, kind)?;
        for values in [&mut strain, &mut stress]
            .into_iter()
            .filter(|_| subtract_start)
        {
            let first = values.first().copied().unwrap_or_default();
            values.iter_mut().for_each(|value| *value -= first);
        }
        let pairs = strain.iter().zip(&stress);
        let work = pairs.map(|(strain, stress)| strain * stress).sum();
        self.upright(work, &mut stress, "stress");
        without_noise(&mut strain);
        let errors = self.errors_of(Column::Stress, 1.0);
        Record::history(time, strain, stress)?.with_errors(&errors, &[])
    }

    fn pressed(
        &mut self,
        loading: Loading,
        poisson_ratio: f64,
        contact: ContactPoint,
    ) -> Result<Record, IdentifyError> {
        let kind = RecordKind::History;
        let time = self.times();
        let position = self.need(Column::Position, kind)?;
        let mut force = self.need(Column::Force, kind)?;
        let begin = |values: &[f64]| values.first().copied().unwrap_or_default();
        let (above, at_rest) = (begin(&position), begin(&force));
        let both = position.iter().zip(&force);
        let work = both.map(|(depth, load)| (depth - above) * (load - at_rest));
        self.upright(work.sum(), &mut force, "force");
        let specimen = specimen(loading, poisson_ratio)?;
        let errors = self.errors_of(Column::Force, 1.0);
        let record = Record::pressed_from(contact, time, position, force, &specimen)?;
        record.with_errors(&errors, &[])
    }
}

/// Words for a loading, and symbols for a modulus.
const LOADINGS: [(LoadingKind, &[&str]); 3] = [
    (LoadingKind::Shear, &["shear", "γ", "gamma", "τ", "tau"]),
    (LoadingKind::Tension, &["tension", "tensile"]),
    (LoadingKind::Compression, &["compressive"]),
];
const MODULI: [(Modulus, &[&str]); 2] = [
    (
        Modulus::Shear,
        &[
            "g", "g(t)", "g'", "g''", "gp", "gpp", "g*", "|g*|", "|g|", "gprime",
        ],
    ),
    (
        Modulus::Young,
        &[
            "e", "e(t)", "e'", "e''", "ep", "epp", "e*", "|e*|", "|e|", "eprime", "young",
            "young's", "youngs",
        ],
    ),
];

/// Loading of the specimen and kind of modulus that a header names.
fn loading_of(header: &str) -> MeasuredLoading {
    let name = words(header);
    let says = |known: &[&str]| name.iter().any(|word| known.contains(&word.as_str()));
    let kind = LOADINGS.iter().find(|known| says(known.1));
    let modulus = MODULI.iter().find(|known| says(known.1));
    MeasuredLoading {
        kind: kind.map(|known| known.0),
        modulus: modulus.map(|known| known.0),
        poisson_ratio: None,
    }
}

/// The other part of a complex modulus of this size.
fn other(size: f64, part: f64) -> f64 {
    libm::sqrt(size * size - part * part)
}

/// Value common to all; `None` if two differ or the iterator is empty.
fn agreed<T: PartialEq>(mut all: impl Iterator<Item = T>) -> Option<T> {
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// The specimen, whose memory alone is sought.
fn specimen(loading: Loading, poisson_ratio: f64) -> Result<Specimen, IdentifyError> {
    Specimen::new(loading, poisson_ratio, 0.0).map_err(|error| {
        let (what, remedy) = if let LoopParameterError::Missing { what, .. } = &error {
            (*what, ": give")
        } else if let LoopParameterError::NoEffect { what, .. } = &error {
            (*what, ": omit")
        } else if let LoopParameterError::Layer { what, .. } = &error {
            (*what, ", and omit")
        } else if let LoopParameterError::Range(range) = &error {
            (range.what, ": change")
        } else {
            ("", ": change")
        };
        let keys = [AREA, THICKNESS, RADIUS, HALF_ANGLE, BONDED];
        let key = keys.into_iter().find(|key| label(key.0) == what);
        let key = key.unwrap_or(POISSON_RATIO);
        IdentifyError::Record(format!("{error}{remedy} {key}"))
    })
}

/// The line of a sample that is wrong.
fn of_line(error: IdentifyError, lines: &[u64]) -> IdentifyError {
    let IdentifyError::Sample { index, reason } = error else {
        return error;
    };
    match lines.get(index) {
        Some(&line) => TableError::Line {
            line,
            column: None,
            reason,
        }
        .into(),
        None => IdentifyError::Sample { index, reason },
    }
}

/// Refuses a held value that this kind does not need.
fn no_effect(given: Option<f64>, name: Key, unit: &str) -> Result<(), IdentifyError> {
    given.map_or(Ok(()), |given| {
        Err(IdentifyError::Record(format!(
            "{name} {given}{unit} has no effect on this record: omit it",
            given = Shown(given)
        )))
    })
}

/// The held strain or stress: given, or a column constant within 1 % or its own noise.
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
        is_level(&column) || column.iter().all(near)
    });
    if let (Some(given), Some(mean)) = (given, mean)
        && !(stays && (given.abs() - mean.abs()).abs() <= STAYS * mean.abs())
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
