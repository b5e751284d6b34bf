//! Blocks of numbers in a text, found before anything above them is looked at.
//! ```text
//! row      a line with a number, or with nothing but gaps, in the columns where the block has numbers
//! block    the longest run of rows alike; blank lines are passed over
//! above    the lines of text between the block before and this one: names, units, preamble
//! ```
//! The cells are apart by what gives the longest block with two columns of numbers: tabs, semicolons, spaces or commas, in this
//! order unless a later one gives half as many rows again. A line that begins with `#` is text. A run of at most two rows with text in them belongs to what stands
//! above the next block, as `Interval 1: 2 16` does.
//!
//! - *Errors*: a line that is no row of a table, more rows than a record may have.
//! - *Cost*: one pass over the first lines for each separator, one over all for the best.

use super::error::TableError;
use super::heading::{Heading, are_units};
use super::instants::since_first;
use super::lines::{Lines, brief, wrong};
use csv::StringRecord;
use haptic_quantity::{DecimalSign, number, number_with, sign_of};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

/// Most rows of numbers in a table.
pub const ROWS_MOST: usize = 1_000_000;

/// Rows that belong together, and what stands above them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    /// Lines of text above, from the top, with their numbers.
    pub(super) above: Vec<(u64, StringRecord)>,
    /// The cells of each row, with its line in the file.
    pub(super) rows: Vec<(u64, StringRecord)>,
    /// Columns that have numbers, and those that have text.
    pub(super) numeric: BTreeSet<usize>,
    text: BTreeSet<usize>,
    /// A line of text right below that may be a row whose numbers are wrong.
    pub(super) broken: Option<(u64, StringRecord)>,
    /// The first empty line between two rows.
    pub(super) blank: Option<u64>,
    /// True if the first cell of each row, below no name, was left out.
    pub(super) drops_names: bool,
    /// The label above the first column, of one of several blocks side by side.
    pub(super) label: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    Empty,
    /// A mark for a missing number.
    Gap,
    Number,
    Text,
}

impl Cell {
    fn of(cell: &str) -> Self {
        match cell {
            "" => Self::Empty,
            cell if is_gap(cell) => Self::Gap,
            cell if number(cell).is_some() => Self::Number,
            _ => Self::Text,
        }
    }
}

/// A cell that marks a missing number, perhaps behind an invalid one: `10 (invalid)`.
pub(super) fn is_gap(cell: &str) -> bool {
    const GAPS: [&str; 7] = ["nan", "na", "n/a", "#n/a", "null", "none", "#div/0!"];
    let is_ruled = || cell.chars().all(|c| matches!(c, '-' | '*' | '–' | '—'));
    let is_refused = || {
        let (row, word) = cell.split_once('(')?;
        let is_word = word.strip_suffix(')')?.chars().all(char::is_alphabetic);
        Some(is_word && row.trim().parse::<u32>().is_ok())
    };
    is_ruled()
        || GAPS.iter().any(|gap| cell.eq_ignore_ascii_case(gap))
        || is_refused() == Some(true)
}

impl Block {
    /// Number of columns with numbers.
    pub(super) fn width(&self) -> usize {
        self.numeric.len()
    }

    pub(super) fn cell(&self, row: usize, place: usize) -> &str {
        self.rows[row].1.get(place).unwrap_or("")
    }

    /// The label of a row, which may have a number behind it.
    pub(super) fn label(&self, row: usize, place: usize) -> &str {
        self.cell(row, place).split('|').next().unwrap_or_default()
    }

    /// Times in s since the first row, of a column of dates or times of day.
    pub(super) fn instants(&self, place: usize) -> Option<Vec<f64>> {
        since_first((0..self.rows.len()).map(|row| self.cell(row, place)))
    }

    /// True of a column of times whose last is later than its first: of instants, or of numbers.
    pub(super) fn runs(&self, place: usize, instants: bool) -> bool {
        let rows = [0, self.rows.len() - 1];
        let ends = if instants {
            since_first(rows.map(|row| self.cell(row, place)).into_iter())
        } else {
            rows.map(|row| number(self.cell(row, place)))
                .into_iter()
                .collect()
        };
        ends.is_some_and(|ends| ends[1] > ends[0])
    }

    /// True if no row has anything in this column.
    pub(super) fn is_blank(&self, place: usize) -> bool {
        !self.numeric.contains(&place) && !self.text.contains(&place)
    }

    /// Number of columns up to the last that holds numbers or text.
    pub(super) fn columns(&self) -> usize {
        let last = self.numeric.last().max(self.text.last());
        last.map_or(0, |last| last + 1)
    }

    /// The first and the last line of the rows.
    pub(super) fn lines(&self) -> [u64; 2] {
        let line = |row: Option<&(u64, StringRecord)>| row.map_or(0, |row| row.0);
        [line(self.rows.first()), line(self.rows.last())]
    }

    /// True if this line is one more row.
    fn takes(&self, cells: &[Cell], is_after_blank: bool) -> bool {
        let numbers = cells.iter().filter(|cell| **cell == Cell::Number).count();
        if numbers == 0 {
            // Gaps alone, or the texts of a row whose numbers are missing.
            return !cells.contains(&Cell::Text);
        }
        let place = |wanted: Cell| {
            let cells = cells.iter().enumerate();
            cells
                .filter(move |cell| *cell.1 == wanted)
                .map(|cell| cell.0)
        };
        let alike = place(Cell::Number)
            .filter(|place| self.numeric.contains(place))
            .count();
        let strange = place(Cell::Text)
            .filter(|place| !self.text.contains(place))
            .count();
        let is_wider = place(Cell::Number).next_back() >= Some(self.columns());
        if is_after_blank {
            alike > 0 && strange == 0 && !is_wider
        } else {
            alike > 0 && (strange == 0 || 2 * alike >= self.width())
        }
    }

    fn push(&mut self, line: u64, row: &StringRecord, cells: &[Cell]) {
        self.rows.push((line, row.clone()));
        for (place, cell) in cells.iter().enumerate() {
            match cell {
                Cell::Number => drop(self.numeric.insert(place)),
                Cell::Text => drop(self.text.insert(place)),
                Cell::Gap | Cell::Empty => {}
            }
        }
    }

    /// Rows at the beginning that are names or units, most of which are text where the others have numbers: `s,1,Pa`.
    fn drop_names(&mut self) {
        let is_name = |row: &StringRecord| {
            let cells = self.numeric.iter().filter_map(|place| row.get(*place));
            2 * cells.filter(|cell| Cell::of(cell) == Cell::Text).count() > self.width()
        };
        let names = self.rows.iter().take_while(|(_, row)| is_name(row)).count();
        if names < self.rows.len() {
            self.above.extend(self.rows.drain(..names));
        }
    }

    /// Parts a line of names that are apart by spaces above cells that are not.
    fn part_names(&mut self) {
        let columns = self.columns();
        for (_, row) in self.above.iter_mut().filter(|(_, row)| row.len() == 1) {
            let (_, names) = wide_cells(&row[0]);
            if columns > 1 && names.len() == columns {
                *row = names.into();
            }
        }
    }

    /// Leaves out the first cell of rows that have one more than the line above them, as R writes their names: nothing, words, or, where
    /// `may_count`, the numbers from 1 on.
    fn drop_row_names(&mut self, may_count: bool) {
        let columns = self.columns();
        let is_text = |row: &StringRecord| row.iter().all(|cell| Cell::of(cell) == Cell::Text);
        let above = self.above.last().map(|above| &above.1);
        let is_short = above.is_some_and(|row| row.len() + 1 == columns && is_text(row));
        let mut rows = self.rows.iter().map(|row| &row.1).enumerate();
        let is_name = |(n, row): (usize, &StringRecord)| {
            let counts = || may_count && row.get(0) == Some(&*(n + 1).to_string());
            row.len() == columns && (!self.numeric.contains(&0) || counts())
        };
        if columns > 2 && is_short && rows.all(is_name) {
            let rows = std::mem::take(&mut self.rows);
            (self.numeric, self.text) = (BTreeSet::new(), BTreeSet::new());
            self.take(
                rows.iter()
                    .map(|(line, row)| (*line, row.iter().skip(1).collect())),
            );
            self.drops_names = true;
        }
    }

    fn take(&mut self, rows: impl Iterator<Item = (u64, StringRecord)>) {
        for (line, row) in rows {
            let cells: Vec<Cell> = row.iter().map(Cell::of).collect();
            self.push(line, &row, &cells);
        }
    }

    /// Tables whose names repeat from left to right, as `X,Y,X,Y` of several curves do, as a block each: with the labels above them, which
    /// may be numbers.
    pub(super) fn side_by_side(blocks: Vec<Self>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for mut block in blocks {
            let Some([width, count]) = block.curves() else {
                all.push(block);
                continue;
            };
            let is_label = |row: &StringRecord| {
                let mut filled = (0..row.len()).filter(|n| !row[*n].is_empty());
                row.len() > width && filled.by_ref().eq((0..count).map(|n| n * width))
            };
            let label = all.pop_if(|before| {
                let [(_, row)] = &before.rows[..] else {
                    return false;
                };
                is_label(row)
            });
            block
                .above
                .splice(..0, label.into_iter().flat_map(|one| one.rows));
            all.extend((0..count).map(|n| {
                let from = n * width;
                let cut = |(line, row): &(u64, StringRecord)| {
                    let cells: StringRecord = if row.len() > width {
                        row.iter().skip(from).take(width).collect()
                    } else {
                        row.clone()
                    };
                    (!cells.iter().all(str::is_empty)).then_some((*line, cells))
                };
                let labels = block.above.iter().rfind(|(_, row)| is_label(row));
                let columns = format!("columns {} to {}", from + 1, from + width);
                let mut part = Self {
                    above: block.above.iter().filter_map(cut).collect(),
                    label: Some(labels.map_or(columns.clone(), |(_, row)| {
                        format!("{}, {columns}", &row[from])
                    })),
                    ..Self::default()
                };
                part.take(block.rows.iter().filter_map(cut));
                part
            }));
        }
        all.retain(|part| !part.rows.is_empty());
        all
    }

    /// Columns of a curve and the number of curves, if names repeat from left to right.
    fn curves(&self) -> Option<[usize; 2]> {
        let heading = self.headings().into_iter().next()?;
        let last = heading.names.iter().rposition(|name| !name.is_empty())?;
        let names = &heading.names[..=last];
        let repeats = |width: &usize| {
            let first: BTreeSet<&String> = names[..*width].iter().collect();
            let mut all = names.iter().enumerate();
            names.len().is_multiple_of(*width)
                && first.len() == *width
                && all.all(|(n, name)| !name.is_empty() && *name == names[n % width])
        };
        let width = (2..=names.len() / 2).find(repeats)?;
        (self.columns() <= names.len()).then_some([width, names.len() / width])
    }

    /// The decimal sign of its numbers, by all of them; a comma in one of these columns that may be of thousands as well is refused.
    fn decimal_sign(&self, places: &[usize]) -> Result<DecimalSign, TableError> {
        let (mut point, mut comma, mut thousands, mut has_point) = (false, false, false, false);
        let mut first_comma = None;
        for (line, row) in &self.rows {
            for place in &self.numeric {
                let cell = row.get(*place).unwrap_or("");
                let marks = cell.matches(['.', ',']).count();
                if marks == 0 || number(cell).is_none() {
                    continue;
                }
                let sign = sign_of(cell);
                point |= sign == Some(DecimalSign::Point);
                comma |= sign == Some(DecimalSign::Comma);
                // Both signs in a number, or one of them twice.
                thousands |= marks > 1;
                let is_comma = cell.contains(',');
                has_point |= marks == 1 && !is_comma;
                if marks == 1 && is_comma && places.contains(place) {
                    first_comma = first_comma.or(Some((*line, cell)));
                }
            }
        }
        match (point, comma, first_comma) {
            (true, false, Some(_)) if thousands => Ok(DecimalSign::Point),
            (false, true, _) if thousands || !has_point || first_comma.is_none() => {
                Ok(DecimalSign::Comma)
            }
            (_, _, None) => Ok(DecimalSign::Point),
            (_, _, Some((line, cell))) => Err(wrong(
                line,
                &format!(
                    "{:?} has a comma that may separate thousands or decimals: write numbers without the former, and all decimals alike",
                    brief(cell)
                ),
            )),
        }
    }

    /// Columns of numbers; NaN for a gap, and for a cell that is no number where bad rows are to be left out: their lines are added.
    pub(super) fn numbers(
        &self,
        heading: &Heading,
        places: &[usize],
        rows: Range<usize>,
        mut bad: Option<&mut Vec<u64>>,
    ) -> Result<Vec<Vec<f64>>, TableError> {
        let width = heading.names.len();
        let sign = self.decimal_sign(places)?;
        let mut columns = vec![Vec::with_capacity(rows.len()); places.len()];
        for (line, row) in &self.rows[rows] {
            let is_wide = row.iter().skip(width).any(|cell| !cell.is_empty());
            let regrouped = is_wide.then(|| regrouped(row, width)).flatten();
            let row = regrouped.as_ref().unwrap_or(row);
            if is_wide && regrouped.is_none() {
                let reason = format!(
                    "{} cells under a header of {width}: separate cells by semicolons if decimals have commas, or quote numbers with commas",
                    row.len()
                );
                return Err(wrong(*line, &reason));
            }
            for (column, &place) in columns.iter_mut().zip(places) {
                let cell = row.get(place).unwrap_or("");
                let gap = is_gap(cell).then_some(f64::NAN);
                let mut value = gap.or_else(|| number_with(cell, sign));
                if let (None, Some(bad)) = (value, &mut bad) {
                    bad.push(*line);
                    value = Some(f64::NAN);
                }
                column.push(value.ok_or_else(|| TableError::Line {
                    line: *line,
                    column: heading.names.get(place).cloned(),
                    reason: format!(
                        "{:?} is not a finite number: correct it, or omit the row",
                        brief(cell)
                    ),
                })?);
            }
        }
        Ok(columns)
    }

    /// True if it is not a part of what stands above another one: a row or two with text, or numbers with a name before each.
    fn stands_alone(&self) -> bool {
        let is_pure = |row: &StringRecord| !row.iter().any(|cell| Cell::of(cell) == Cell::Text);
        let is_named = |row: &StringRecord| {
            let cells: Vec<Cell> = row.iter().map(Cell::of).collect();
            let mut numbers = (0..cells.len()).filter(|n| cells[*n] == Cell::Number);
            numbers.all(|n| n > 0 && cells[n - 1] == Cell::Text)
        };
        let mut rows = self.rows.iter().map(|(_, row)| row);
        match self.rows.len() {
            0..=2 => rows.all(is_pure),
            _ => !rows.all(is_named),
        }
    }
}

/// The cells of a row with commas between thousands, `0.5,1,234.567`: joined wherever they make a number, so that more cells than that
/// could be are refused.
fn regrouped(row: &StringRecord, width: usize) -> Option<StringRecord> {
    let mut cells: Vec<String> = Vec::new();
    for cell in row {
        let joined = cells.last().map(|last| format!("{last},{cell}"));
        let is_number = |text: &String| {
            let is_padded = text.trim_start_matches(['+', '-']).starts_with('0');
            !is_padded && number_with(text, DecimalSign::Point).is_some()
        };
        match (cells.last_mut(), joined.filter(is_number)) {
            (Some(last), Some(joined)) => *last = joined,
            (_, _) => cells.push(cell.to_owned()),
        }
    }
    (cells.len() == width).then(|| cells.into())
}

/// A text as blocks, and how its cells are apart.
pub(super) struct Blocks {
    pub(super) blocks: Vec<Block>,
    /// Spaces separate the cells: an empty one is not seen.
    pub(super) spaced: bool,
    /// Tabs separate them.
    tabs: bool,
}

/// Lines of text below the last block so far.
type Texts = Vec<(u64, StringRecord)>;

/// Lines by which the separator is chosen.
const LOOKED_AT: usize = 4000;

impl Blocks {
    pub(super) fn of(text: &str) -> Result<Self, TableError> {
        let end = text.match_indices('\n').nth(LOOKED_AT);
        let head = end.map_or(text, |(end, _)| &text[..end]);
        // Rows of the longest block with at least two columns of numbers, or one.
        let (mut separator, mut wide, mut any) = (b'\t', 0, 0);
        for other in [b'\t', b';', b' ', b','] {
            let found = Self::separated(head, other)?;
            let longest = |least: usize| {
                let blocks = found.blocks.iter().filter(|block| block.width() >= least);
                blocks.map(|block| block.rows.len()).max().unwrap_or(0)
            };
            let (more_wide, more) = (longest(2), longest(1));
            // The words of a preamble may be apart by spaces in more rows than a short table has.
            if 2 * more_wide > 3 * wide || (wide == 0 && more > any) {
                (separator, wide, any) = (other, more_wide, more);
            }
        }
        let mut found = Self::separated(text, separator)?;
        // Beside tables with two columns of numbers, one number a line is preamble.
        if wide > 0 {
            found.give_up(|block| block.width() < 2);
        }
        if found.blocks.iter().any(Block::stands_alone) {
            found.give_up(|block| !block.stands_alone());
        }
        Ok(found)
    }

    /// Turns blocks into text above the next one.
    fn give_up(&mut self, is_text: impl Fn(&Block) -> bool) {
        let mut above = Vec::new();
        for mut block in std::mem::take(&mut self.blocks) {
            above.append(&mut block.above);
            if is_text(&block) {
                above.append(&mut block.rows);
            } else {
                block.above = std::mem::take(&mut above);
                self.blocks.push(block);
            }
        }
    }

    fn separated(text: &str, separator: u8) -> Result<Self, TableError> {
        let spaced = separator == b' ';
        let (text, delimiter) = if spaced {
            (Cow::Owned(by_spaces(text)), b'\t')
        } else {
            (Cow::Borrowed(text), separator)
        };
        let mut found = Self {
            blocks: Vec::new(),
            spaced,
            tabs: separator == b'\t',
        };
        let mut texts = Texts::new();
        let mut open = Block::default();
        let (mut last_line, mut rows) = (0, 0);
        let mut is_after_blank = false;
        each_row(text.as_bytes(), delimiter, |line, row| {
            let cells: Vec<Cell> = row.iter().map(Cell::of).collect();
            is_after_blank |= line > last_line + 1;
            last_line = line;
            if cells.iter().all(|cell| *cell == Cell::Empty) {
                is_after_blank = true;
                return Ok(());
            }
            let remark = row
                .get(0)
                .filter(|first| first.starts_with('#') && !is_gap(first));
            if let Some(first) = remark {
                let rest = first.trim_start_matches('#').trim();
                let names = (!rest.is_empty()).then_some(rest).into_iter();
                let names = names.chain(row.iter().skip(1));
                texts.push((line, names.collect()));
                return Ok(());
            }
            rows += 1;
            if rows > ROWS_MOST + 1 {
                let reason =
                    format!("more than {ROWS_MOST} rows: omit every second one, or cut the record");
                return Err(wrong(line, &reason));
            }
            let joins = !open.rows.is_empty() && open.takes(&cells, is_after_blank);
            if joins && is_after_blank && open.blank.is_none() {
                open.blank = Some(open.lines()[1] + 1);
            }
            if !joins {
                let filled = cells.iter().filter(|cell| **cell == Cell::Text).count();
                let may_be_row = !is_after_blank && filled == cells.len() && filled >= open.width();
                open.broken = may_be_row.then(|| (line, row.clone()));
                found.close(&mut open, &mut texts);
            }
            if joins || cells.contains(&Cell::Number) {
                open.push(line, row, &cells);
            } else {
                texts.push((line, row.clone()));
            }
            is_after_blank = false;
            Ok(())
        })?;
        found.close(&mut open, &mut texts);
        Ok(found)
    }

    /// Ends a block: what was text below the one before stands above it.
    fn close(&mut self, open: &mut Block, texts: &mut Texts) {
        let mut block = std::mem::take(open);
        if block.rows.is_empty() {
            return;
        }
        let first = block.lines()[0];
        // A remark between rows stands above the next block.
        (block.above, *texts) = std::mem::take(texts)
            .into_iter()
            .partition(|(line, _)| *line < first);
        block.drop_names();
        block.part_names();
        block.drop_row_names(self.spaced || self.tabs);
        self.blocks.push(block);
    }
}

/// Lines whose cells are apart by spaces, with tabs instead. Names may have single spaces where two or more separate them; else a
/// unit in brackets belongs to the name before it.
fn by_spaces(text: &str) -> String {
    let mut names: Vec<Range<usize>> = Vec::new();
    let lines = text.lines().map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers = words
            .iter()
            .filter(|word| number(word).is_some() || is_gap(word));
        if 2 * numbers.count() >= words.len() {
            return words.join("\t");
        }
        let wide = line.trim().replace('\t', "  ");
        let mut cells: Vec<String> = Vec::new();
        let is_wide = wide.contains("  ");
        if is_wide && !line.contains('\t') {
            let (places, cells) = wide_cells(line);
            let below = below_names(&names, &places, &cells);
            names = places;
            return below.unwrap_or(cells).join("\t");
        }
        for word in wide.split(if is_wide { "  " } else { " " }).map(str::trim) {
            let is_open = |cell: &String| {
                let count = |sign: [char; 2]| cell.matches(sign).count();
                count(['(', '[']) > count([')', ']'])
            };
            let is_unit = word.starts_with(['(', '[']);
            match cells.last_mut() {
                Some(cell) if !is_wide && (is_unit || is_open(cell)) => {
                    cell.push(' ');
                    cell.push_str(word);
                }
                _ if word.is_empty() => {}
                _ => cells.push(word.to_owned()),
            }
        }
        cells.join("\t")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Cells with two spaces or more between them, and the letters of the line that each takes.
fn wide_cells(line: &str) -> (Vec<Range<usize>>, Vec<&str>) {
    let mut at = 0;
    let cells = line.split("  ").filter_map(|part| {
        let cell = part.trim();
        let start = at + part.chars().take_while(|c| c.is_whitespace()).count();
        at += part.chars().count() + 2;
        (!cell.is_empty()).then(|| (start..start + cell.chars().count(), cell))
    });
    cells.unzip()
}

/// Units each below its name, which are fewer than the names above them.
fn below_names<'a>(
    names: &[Range<usize>],
    places: &[Range<usize>],
    units: &[&'a str],
) -> Option<Vec<&'a str>> {
    let is_short = units.len() < names.len() && are_units(units.iter().copied());
    let mut cells = vec![""; names.len()];
    for (place, unit) in places.iter().zip(units).filter(|_| is_short) {
        let mut above =
            (0..names.len()).filter(|n| names[*n].start < place.end && place.start < names[*n].end);
        let (Some(name), None) = (above.next(), above.next()) else {
            return None;
        };
        cells[name] = unit;
    }
    is_short.then_some(cells)
}

/// Most lines of a cell in quotes; more mean a missing closing quote.
const QUOTED_LINES: usize = 4;

/// Line and cells of every row, one after another.
fn each_row(
    bytes: &[u8],
    delimiter: u8,
    mut take: impl FnMut(u64, &StringRecord) -> Result<(), TableError>,
) -> Result<(), TableError> {
    let is_closed = |row: &StringRecord| {
        let lines = |cell: &str| cell.matches('\n').count();
        row.iter().all(|cell| lines(cell) < QUOTED_LINES)
    };
    let mut quoting = true;
    let mut row = StringRecord::new();
    let mut from = 0;
    let mut lines = Lines::new(bytes);
    loop {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .quoting(quoting)
            .trim(csv::Trim::All)
            .from_reader(&bytes[from..]);
        let start = from;
        let is_whole = loop {
            let begin = start + usize::try_from(reader.position().byte()).unwrap_or(0);
            let is_read = reader.read_record(&mut row).map_err(|error| {
                let line = error.position().map_or(1, csv::Position::line);
                wrong(line, &format!("{error}: correct the row"))
            })?;
            if !is_read {
                break true;
            }
            if quoting && !is_closed(&row) {
                // Read again from here, with quotes as letters.
                from = begin;
                break false;
            }
            let end = start as u64 + reader.position().byte();
            take(lines.of_row_before(end, &row), &row)?;
        };
        if is_whole {
            return Ok(());
        }
        quoting = false;
    }
}
