//! A frequency response in the table of an instrument.
//!
//! ```text
//! frequency in Hz or rad/s, and real and imaginary part, or gain and phase; coherence, if there is one
//! ```
//! Columns are found by name and unit, wherever the table begins and whatever stands beside them. A name with a minus before it, as `-Im(Z)`, has numbers
//! of the other sign; a gain in dB, and logarithms by their names, are taken to the power.

use super::column::{Choice, Column};
use super::error::TableError;
use super::header::{foreign, logarithm, plain, split};
use super::heading::Heading;
use super::lines::wrong;
use super::text::Chosen;
use super::unit::{Dimension, rows};
use std::f64::consts::TAU;

/// A column of a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ResponseColumn {
    /// Frequency, in Hz or rad/s.
    Frequency,
    /// Real part.
    Real,
    /// Imaginary part.
    Imaginary,
    /// Gain, or dB of it.
    Gain,
    /// Phase, in ° or rad.
    Phase,
    /// Coherence, 0 to 1.
    Coherence,
}

use ResponseColumn::{Coherence, Frequency, Gain, Imaginary, Phase, Real};

/// A response as its table says it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ResponseTable {
    /// Line of each row, from 1.
    pub lines: Vec<u64>,
    /// ω of each row, rad/s.
    pub omega_rad_s: Vec<f64>,
    /// Real and imaginary part of each row.
    pub values: Vec<[f64; 2]>,
    /// Coherence; empty without such a column.
    pub coherence: Vec<f64>,
    /// Lines with a gain below 0, and that.
    pub negative: Vec<(u64, f64)>,
    /// One sentence for each thing that was taken without being said.
    pub notes: Vec<String>,
}

impl ResponseColumn {
    const ALL: [Self; 6] = [Frequency, Real, Imaginary, Gain, Phase, Coherence];

    /// Its name where a user chooses columns.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// The column of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name() == name)
    }

    fn row(self) -> (&'static str, &'static str) {
        let mut rows = rows(include_str!("response.txt")).filter_map(|row| row.split_once(" | "));
        rows.nth(self as usize).unwrap_or_default()
    }

    fn spelt(name: &str) -> Option<Self> {
        let is_spelt = |column: &Self| column.row().1.split(", ").any(|known| known == name);
        Self::ALL.into_iter().find(is_spelt)
    }
}

/// A column, its unit, and what its name makes of its cells.
#[derive(Clone, Debug)]
struct Found {
    column: ResponseColumn,
    place: usize,
    unit: String,
    sign: f64,
    base: Option<f64>,
}

impl Found {
    /// A column with a name and the unit below it; what a user chose has any name.
    fn of(heading: &Heading, place: usize, chosen: Option<ResponseColumn>) -> Option<Self> {
        // A capital omega is a unit, and in lower case a name.
        let name = heading.names[place].replace(['Ω', '\u{2126}'], "ohm");
        // `Trace 2: Gain: Phase (°)` is the last of these.
        let name = name.rsplit(": ").next().unwrap_or_default().trim();
        let bare = name.trim_start_matches(['-', '−', '–']);
        let sign = if bare.len() < name.len() { -1.0 } else { 1.0 };
        let (base, bare) = match logarithm(bare) {
            Some((base, name)) => (Some(base), name),
            None => (None, bare.trim().to_owned()),
        };
        let below = heading.below(place);
        let found = |column, unit: &str| {
            // A remark below the names is no unit.
            let is_unit = unit.is_empty() || Dimension::knows(below);
            let unit = if below.is_empty() || !is_unit {
                unit
            } else {
                below
            };
            let unit = unit.to_owned();
            Some(Self {
                column,
                place,
                unit,
                sign,
                base,
            })
        };
        let (name, unit) = split(&bare);
        let unit = unit.unwrap_or_default();
        // `Re(Z)` is a name, `phase_deg` one with a unit.
        let suffixed = bare.match_indices('_').find_map(|(mark, _)| {
            let column = ResponseColumn::spelt(&plain(&bare[..mark]))?;
            Some((column, bare[mark + 1..].replace('_', "/")))
        });
        let known = ResponseColumn::spelt(&plain(&bare)).map(|column| (column, String::new()));
        let known = known.or_else(|| Some((ResponseColumn::spelt(&plain(&name))?, unit.clone())));
        match (chosen, known.or(suffixed)) {
            (Some(column), Some((_, unit))) => found(column, &unit),
            (Some(column), None) => found(column, &unit),
            (None, known) => known.and_then(|(column, unit)| found(column, &unit)),
        }
    }

    fn cells(&self, cells: &[f64]) -> Vec<f64> {
        let cells = cells.iter().map(|cell| self.sign * cell);
        match self.base {
            Some(base) => cells.map(|cell| libm::pow(base, cell)).collect(),
            None => cells.collect(),
        }
    }

    /// rad/s a unit of frequency.
    fn omega(&self, heading: &Heading, notes: &mut Vec<String>) -> Result<f64, String> {
        let name = &heading.names[self.place];
        let is_angular = ["ω", "omega", "ang", "kreis"].iter().any(|word| {
            let name = plain(name);
            name.contains(word) || name == "w"
        });
        if self.unit.is_empty() {
            let unit = if is_angular { "rad/s" } else { "Hz" };
            notes.push(format!("column {name} names no unit: taken as {unit}"));
            return Ok(if is_angular { 1.0 } else { TAU });
        }
        let size = Dimension("frequency").size(&self.unit);
        Ok(size.ok_or_else(|| foreign(&self.unit, Column::Omega))?.si)
    }

    /// rad a unit of phase.
    fn angle(
        &self,
        heading: &Heading,
        cells: &[f64],
        notes: &mut Vec<String>,
    ) -> Result<f64, String> {
        let name = &heading.names[self.place];
        let reach = cells
            .iter()
            .fold(0.0, |most: f64, cell| most.max(cell.abs()));
        match &*self.unit {
            "" if reach > TAU => {
                notes.push(format!("column {name} names no unit: taken as degrees"));
                Ok(1.0_f64.to_radians())
            }
            "" => Err(format!(
                "the phase in column {name} has no unit, and its largest value {reach} may be in ° or rad: name it phase_deg or phase_rad"
            )),
            unit => Ok(Dimension("angle")
                .size(unit)
                .ok_or_else(|| foreign(unit, Column::Phase))?
                .si),
        }
    }

    /// Ohms a unit of an impedance; 1 of any other unit, which a response keeps.
    fn size(&self) -> f64 {
        let unit = self.unit.replace(['Ω', '\u{2126}'], "ohm");
        let mut ends = ["Ohms", "ohms", "Ohm", "ohm", "OHM"].into_iter();
        match ends.find_map(|end| unit.trim().strip_suffix(end)) {
            Some("m") => 1e-3,
            Some("k" | "K") => 1e3,
            Some("M") => 1e6,
            Some("G") => 1e9,
            Some("u" | "µ" | "μ") => 1e-6,
            Some(_) | None => 1.0,
        }
    }
}

/// The columns of a response under a heading; those that a user names are not looked for.
fn columns(
    heading: &Heading,
    chosen: &[(ResponseColumn, Choice)],
) -> Result<[Option<Found>; 4], String> {
    let mut found: Vec<Found> = Vec::new();
    for (column, choice) in chosen {
        let name = match choice {
            Choice::Number(number) => number.to_string(),
            Choice::Name(name) => name.clone(),
        };
        let place = heading
            .place(&name)?
            .ok_or_else(|| format!("no column {name}"))?;
        found.extend(Found::of(heading, place, Some(*column)));
    }
    let places = (0..heading.names.len()).filter_map(|place| Found::of(heading, place, None));
    for other in places.collect::<Vec<_>>() {
        if !chosen.iter().any(|one| one.0 == other.column) {
            found.push(other);
        }
    }
    let one = |column: ResponseColumn| -> Result<Option<Found>, String> {
        let mut alike = found.iter().filter(|found| found.column == column);
        match (alike.next().cloned(), alike.next()) {
            (Some(one), Some(other)) => Err(format!(
                "the columns {} and {} both look like the {name}: give columns {name}={}",
                heading.names[one.place],
                heading.names[other.place],
                one.place + 1,
                name = column.name()
            )),
            (one, _) => Ok(one),
        }
    };
    let lacking = |column: ResponseColumn| {
        let is_time = |name: &String| name.to_lowercase().starts_with("time");
        let remedy = if column == Frequency && heading.names.iter().any(is_time) {
            "it is a record over time, of which `control identify` makes a plant"
        } else {
            "give frequency in Hz or rad/s; gain and phase, or real and imaginary"
        };
        format!(
            "no column of the {} in the header {:?}; {remedy}",
            column.name(),
            heading.names.join(",")
        )
    };
    let frequency = one(Frequency)?.ok_or_else(|| lacking(Frequency))?;
    let pair = match (one(Real), one(Imaginary)) {
        (Ok(Some(real)), Ok(Some(imaginary))) => [real, imaginary],
        (real, imaginary) => match (one(Gain)?, one(Phase)?) {
            (Some(gain), Some(phase)) => [gain, phase],
            (Some(_), None) => return Err(lacking(Phase)),
            (None, _) => match (real?, imaginary?) {
                (Some(_), _) => return Err(lacking(Imaginary)),
                (None, Some(_)) => return Err(lacking(Real)),
                (None, None) => return Err(lacking(Gain)),
            },
        },
    };
    let [first, second] = pair.map(Some);
    Ok([Some(frequency), first, second, one(Coherence)?])
}

/// True of a table with a column that is named as a frequency.
#[must_use]
pub fn has_frequencies(bytes: &[u8]) -> bool {
    let find = |_: &_, heading: &Heading| {
        let mut found =
            (0..heading.names.len()).filter_map(|place| Found::of(heading, place, None));
        let is_named = found.any(|found| found.column == Frequency);
        is_named.then_some(()).ok_or_else(String::new)
    };
    Chosen::of(bytes, find).is_ok()
}

/// The response in a table, as instruments of frequency responses and impedances write it.
///
/// # Errors
/// As [`read_table`](crate::read_table); no or two columns of a kind, a unit that is another's, a phase whose unit is unclear.
pub fn read_response(
    bytes: &[u8],
    chosen: &[(ResponseColumn, Choice)],
) -> Result<ResponseTable, TableError> {
    let (table, found) = Chosen::of(bytes, |_, heading| columns(heading, chosen))?;
    let places = found
        .each_ref()
        .map(|one| one.as_ref().map(|one| one.place));
    let read = table.complete(places)?;
    let heading = &table.heading;
    let refused = |why: String| wrong(heading.line, &why);
    let cells = |n: usize| -> Vec<f64> {
        let found = found[n].as_ref();
        found.map_or_else(Vec::new, |found| found.cells(&read.columns[n]))
    };
    let [omega, mut first, mut second, coherence] = [0, 1, 2, 3].map(cells);
    let (mut notes, mut negative) = (Vec::new(), Vec::new());
    let [Some(frequency), Some(one), Some(other), _] = &found else {
        return Err(refused("no response".to_owned()));
    };
    let turn = frequency.omega(heading, &mut notes).map_err(refused)?;
    first.iter_mut().for_each(|value| *value *= one.size());
    if one.column == Gain {
        let angle = other.angle(heading, &second, &mut notes).map_err(refused)?;
        if one.unit.eq_ignore_ascii_case("db") {
            first
                .iter_mut()
                .for_each(|gain| *gain = libm::pow(10.0, *gain / 20.0));
        }
        let rows = read.lines.iter().zip(&first);
        let below = rows.filter(|(_, gain)| **gain < 0.0);
        negative.extend(below.map(|(line, gain)| (*line, *gain)));
        for (gain, phase) in first.iter_mut().zip(&mut second) {
            let (sin, cos) = libm::sincos(angle * *phase);
            (*gain, *phase) = (*gain * cos, *gain * sin);
        }
    } else {
        second.iter_mut().for_each(|value| *value *= other.size());
    }
    Ok(ResponseTable {
        omega_rad_s: omega.iter().map(|omega| turn * omega).collect(),
        values: first
            .into_iter()
            .zip(second)
            .map(|(re, im)| [re, im])
            .collect(),
        lines: read.lines,
        coherence,
        negative,
        notes,
    })
}
