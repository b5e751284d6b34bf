//! The columns of a table as they are read, for the person whose table it is: what each was taken for, and what else it could be.
//!
//! Nothing is refused here: a column that no record can use has the reason beside it. Of blocks below the same names the first is shown, and of a
//! table with records in it no other block. Cost: that of reading the table.

use super::column::Column;
use super::find::Block;
use super::header::{Unit, could_be, understand};
use super::keys::COLUMNS;
use super::numbers::{Part, Reader};
use super::text::TextTable;
use serde::Serialize;

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnRead {
    /// Number from 1, as a user names it.
    #[serde(rename = "column")]
    pub number: usize,
    /// Name as it stands in the header.
    pub name: String,
    /// The unit in the name or below it.
    pub unit: Option<String>,
    /// The first cell as it is written.
    pub first_cell: String,
    /// The quantity that the column is read as, or of which it has the errors.
    pub taken_for: Option<String>,
    /// The first cell in the SI unit of that quantity.
    pub first_value: Option<f64>,
    /// The SI unit of that quantity.
    pub si_unit: Option<&'static str>,
    /// Other quantities of this name, or of this unit.
    pub could_be: Option<Vec<&'static str>>,
    /// Why it is not read, or what is doubtful.
    pub remark: Option<String>,
}

impl Reader {
    /// All columns of a table, whether or not they can be a record.
    #[must_use]
    pub fn explained(&self, table: &TextTable) -> Vec<ColumnRead> {
        let mut parts: Vec<Part<'_>> = Vec::new();
        for block in &table.blocks {
            let named = self.heading(block, parts.last()).ok();
            let heading = named.or_else(|| block.headings().pop());
            let heading = heading.unwrap_or_else(|| block.numbered());
            let bare = Part::unknown(block, heading.clone());
            parts.push(self.part(block, heading).unwrap_or(bare));
        }
        if parts.iter().any(Part::is_whole) {
            parts.retain(Part::is_whole);
        }
        parts.dedup_by(|next, before| next.heading.names == before.heading.names);
        let columns = parts.iter().flat_map(|part| {
            let places = 0..part.heading.names.len();
            places.map(|place| self.column(part, place))
        });
        columns.collect()
    }

    fn column(&self, part: &Part<'_>, place: usize) -> ColumnRead {
        let (block, heading) = (part.block, &part.heading);
        let (name, below) = (&heading.names[place], heading.below(place));
        let found = part.found.iter().find(|found| found.place == place);
        let errors = part.errors.iter().find(|errors| errors.place == place);
        let of = errors.map(|errors| part.found[errors.of].column);
        let taken = found.map(|found| found.column).or(of);
        let could_be = could_be(name, below).into_iter();
        let could_be: Vec<Column> = could_be.filter(|one| Some(*one) != taken).collect();
        let doubt = part.unclear.iter().find(|doubt| Some(doubt.0) == taken);
        let doubt = doubt.map(|doubt| doubt.1.clone());
        ColumnRead {
            number: place + 1,
            unit: heading
                .unit(place)
                .filter(|unit| !unit.is_empty())
                .or_else(|| taken.and_then(|column| Unit::behind(column, name))),
            first_cell: first_cell(block, place).to_owned(),
            first_value: match (found, errors) {
                (Some(found), _) => self.first(part, found).map(|first| first[0]),
                (None, errors) => errors.and_then(|errors| self.first_error(part, errors)),
            },
            taken_for: taken.map(|column| match of {
                Some(_) => format!("error of {}", column.name()),
                None => column.name().to_owned(),
            }),
            si_unit: taken.map(|column| column.dimension().si()),
            remark: match taken {
                Some(_) => doubt,
                None => Some(why_not(part, place, !could_be.is_empty())),
            },
            could_be: (!could_be.is_empty())
                .then(|| could_be.into_iter().map(Column::name).collect()),
            name: name.clone(),
        }
    }
}

fn first_cell(block: &Block, place: usize) -> &str {
    let mut cells = (0..block.rows.len()).map(|row| block.cell(row, place));
    cells.find(|cell| !cell.is_empty()).unwrap_or_default()
}

/// Why a column is no number of a record.
fn why_not(part: &Part<'_>, place: usize, could_be: bool) -> String {
    let (block, heading) = (part.block, &part.heading);
    if block.is_blank(place) {
        return "no cell of it has anything".to_owned();
    }
    if part.tells_apart(place) {
        return "its values tell segments apart".to_owned();
    }
    if !block.numeric.contains(&place) {
        return "its cells are no numbers".to_owned();
    }
    let meaning = understand(&heading.names[place], heading.below(place));
    let Some(meaning) = meaning else {
        return if could_be {
            format!("its name says nothing: name it by {COLUMNS} if its unit is that of one")
        } else {
            "no quantity of a record has this name or unit".to_owned()
        };
    };
    let mut others = part.found.iter();
    match others.find(|found| found.column == meaning.column) {
        Some(other) => format!(
            "{} is column {}: give {COLUMNS} {}={} if it is this one",
            meaning.column.name(),
            other.place + 1,
            meaning.column.name(),
            place + 1
        ),
        None if part.found.is_empty() => "no column is read".to_owned(),
        None => "the columns that are read are a record without it".to_owned(),
    }
}
