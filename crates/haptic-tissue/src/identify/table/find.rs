//! Blocks of numbers in a text, found before anything above them is looked at.
//! ```text
//! row      a line with a number, or with nothing but gaps, in the columns where the block has numbers
//! block    the longest run of rows alike; blank lines are passed over
//! above    the lines of text between the block before and this one: names, units, preamble
//! ```
//! The cells are apart by what gives the most rows of at least two numbers: tabs, semicolons, spaces or commas, in this order if
//! they give as many. A line that begins with `#` is text. A run of at most two rows with text in them belongs to what stands
//! above the next block, as `Interval 1: 2 16` does.
//!
//! - *Errors*: a line that is no row of a table, more rows than a record may have.
//! - *Cost*: one pass over the first lines for each separator, one over all for the best.

use super::super::error::IdentifyError;
use super::super::record::SAMPLES_MOST;
use super::lines::{Lines, wrong};
use csv::StringRecord;
use haptic_quantity::number;
use std::borrow::Cow;

/// Rows that belong together, and what stands above them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    /// Lines of text above, from the top, with their numbers.
    pub(super) above: Vec<(u64, StringRecord)>,
    /// Rows with their lines.
    pub(super) rows: Vec<(u64, StringRecord)>,
    /// Columns that have numbers.
    pub(super) numeric: Vec<bool>,
    /// Columns that have text.
    text: Vec<bool>,
    /// The first empty line between two rows.
    pub(super) blank: Option<u64>,
}

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    Empty,
    /// A sign that there is no number.
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

/// A cell that says that there is no number.
pub(super) fn is_gap(cell: &str) -> bool {
    const GAPS: [&str; 7] = ["nan", "na", "n/a", "#n/a", "null", "none", "#div/0!"];
    let is_ruled = || cell.chars().all(|c| matches!(c, '-' | '*' | '–' | '—'));
    is_ruled() || GAPS.iter().any(|gap| cell.eq_ignore_ascii_case(gap))
}

fn has(columns: &[bool], place: usize) -> bool {
    columns.get(place).copied().unwrap_or(false)
}

fn mark(columns: &mut Vec<bool>, place: usize) {
    if columns.len() <= place {
        columns.resize(place + 1, false);
    }
    columns[place] = true;
}

impl Block {
    /// How many columns have numbers.
    pub(super) fn width(&self) -> usize {
        self.numeric
            .iter()
            .filter(|is_numeric| **is_numeric)
            .count()
    }

    /// True if no row has anything in this column.
    pub(super) fn is_blank(&self, place: usize) -> bool {
        !has(&self.numeric, place) && !has(&self.text, place)
    }

    /// How many columns the widest row has.
    pub(super) fn columns(&self) -> usize {
        self.numeric.len().max(self.text.len())
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
        let place = |of: Cell| {
            let cells = cells.iter().enumerate();
            cells.filter(move |cell| *cell.1 == of).map(|cell| cell.0)
        };
        let alike = place(Cell::Number).filter(|&place| has(&self.numeric, place));
        let alike = alike.count();
        let strange = place(Cell::Text).filter(|&place| !has(&self.text, place));
        let strange = strange.count();
        let is_wider = place(Cell::Number).last() >= Some(self.columns());
        match is_after_blank {
            true => alike > 0 && strange == 0 && !is_wider,
            false => alike > 0 && (strange == 0 || 2 * alike >= self.width()),
        }
    }

    fn push(&mut self, line: u64, row: &StringRecord, cells: &[Cell]) {
        self.rows.push((line, row.clone()));
        for (place, cell) in cells.iter().enumerate() {
            match cell {
                Cell::Number => mark(&mut self.numeric, place),
                Cell::Text => mark(&mut self.text, place),
                Cell::Gap | Cell::Empty => {}
            }
        }
    }

    /// Rows at the beginning that are names or units, most of which are text where the others have numbers: `s,1,Pa`.
    fn drop_names(&mut self) {
        let is_name = |row: &StringRecord| {
            let numeric = row
                .iter()
                .enumerate()
                .filter(|(place, _)| has(&self.numeric, *place));
            let texts = numeric.filter(|(_, cell)| Cell::of(cell) == Cell::Text);
            2 * texts.count() > self.width()
        };
        let names = self.rows.iter().take_while(|(_, row)| is_name(row)).count();
        if names < self.rows.len() {
            self.above.extend(self.rows.drain(..names));
        }
    }

    /// True if it is not a part of what stands above another one.
    fn stands_alone(&self) -> bool {
        let is_pure = |row: &StringRecord| !row.iter().any(|cell| Cell::of(cell) == Cell::Text);
        self.rows.len() > 2 || self.rows.iter().all(|(_, row)| is_pure(row))
    }
}

/// A text as blocks, and how its cells are apart.
pub(super) struct Blocks {
    pub(super) blocks: Vec<Block>,
    /// Spaces separate the cells: an empty one is not seen.
    pub(super) spaced: bool,
}

/// Lines of text below the last block so far.
type Texts = Vec<(u64, StringRecord)>;

/// Lines by which the separator is chosen.
const LOOKED_AT: usize = 4000;

impl Blocks {
    pub(super) fn of(text: &str) -> Result<Self, IdentifyError> {
        let head = text
            .match_indices('\n')
            .nth(LOOKED_AT)
            .map_or(text, |(end, _)| &text[..end]);
        let mut best: Option<(u8, [usize; 2])> = None;
        for separator in [b'\t', b';', b' ', b','] {
            let found = Self::separated(head, separator)?;
            let rows = |least: usize| -> usize {
                let blocks = found.blocks.iter().filter(|block| block.width() >= least);
                blocks.map(|block| block.rows.len()).sum()
            };
            let score = [rows(2), rows(1)];
            if best.is_none_or(|(_, other)| score > other) {
                best = Some((separator, score));
            }
        }
        let (separator, [wide, _]) = best.unwrap_or((b',', [0; 2]));
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

    fn separated(text: &str, separator: u8) -> Result<Self, IdentifyError> {
        let spaced = separator == b' ';
        let (text, delimiter) = match spaced {
            true => (Cow::Owned(by_spaces(text)), b'\t'),
            false => (Cow::Borrowed(text), separator),
        };
        let mut found = Self {
            blocks: Vec::new(),
            spaced,
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
                let names = std::iter::once(rest).chain(row.iter().skip(1));
                texts.push((line, names.collect()));
                return Ok(());
            }
            rows += 1;
            if rows > SAMPLES_MOST + 1 {
                let reason = format!(
                    "more than {SAMPLES_MOST} rows: omit every second one, or cut the record"
                );
                return Err(wrong(line, &reason));
            }
            let joins = !open.rows.is_empty() && open.takes(&cells, is_after_blank);
            if joins && is_after_blank && open.blank.is_none() {
                open.blank = Some(open.lines()[1] + 1);
            }
            if !joins {
                found.close(&mut open, &mut texts);
            }
            match joins || cells.contains(&Cell::Number) {
                true => open.push(line, row, &cells),
                false => texts.push((line, row.clone())),
            }
            is_after_blank = false;
            Ok(())
        })?;
        found.close(&mut open, &mut texts);
        Ok(found)
    }

    /// Ends a block: what was text below the one before stands above it.
    fn close(&mut self, open: &mut Block, texts: &mut Texts) {
        if open.rows.is_empty() {
            return;
        }
        let mut block = std::mem::take(open);
        let first = block.lines()[0];
        // A remark between rows stands above the next block.
        (block.above, *texts) = std::mem::take(texts)
            .into_iter()
            .partition(|(line, _)| *line < first);
        block.drop_names();
        self.blocks.push(block);
    }
}

/// Lines whose cells are apart by spaces, with tabs instead. Names may have single spaces where two or more separate them; else a
/// unit in brackets belongs to the name before it.
fn by_spaces(text: &str) -> String {
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

/// Lines that a cell in quotes may have; more are a quote that nobody closed.
const QUOTED_LINES: usize = 4;

/// Line and cells of every row, one after another.
fn each_row(
    bytes: &[u8],
    delimiter: u8,
    mut take: impl FnMut(u64, &StringRecord) -> Result<(), IdentifyError>,
) -> Result<(), IdentifyError> {
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
