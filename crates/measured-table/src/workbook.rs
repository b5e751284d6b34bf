//! The sheets of an XLSX workbook as the text that their export would be: cells apart by tabs.
//!
//! A line of the first sheet is its row, so that messages name what a person sees; the rows of a further sheet follow below a line with its name.
//! Formulas count with the values that were saved with them. Cost: the text in memory, which ends at the size of a table, however far apart the cells
//! of a sheet are. An XLS of before 2007 is refused: calamine 0.38 does not end on one that is damaged.

use super::text_file::TABLE_MOST;
use calamine::{Data, ExcelDateTime, Reader as _, Xlsx, open_workbook_from_rs};
use std::io::Cursor;

/// First bytes of an XLSX, a ZIP, and of an XLS, a compound document.
const XLSX: &[u8] = b"PK\x03\x04";
const XLS: &[u8] = b"\xd0\xcf\x11\xe0";
const SECONDS_A_DAY: f64 = 86_400.0;

/// The text of a workbook; `None` of anything else.
pub(crate) fn text_of(bytes: &[u8]) -> Option<Result<String, String>> {
    if bytes.starts_with(XLS) {
        return Some(Err(
            "this is an XLS workbook of before 2007: save it as XLSX".to_owned(),
        ));
    }
    bytes.starts_with(XLSX).then(|| xlsx(Cursor::new(bytes)))
}

fn wrong(error: impl std::fmt::Display) -> String {
    format!("this is no workbook that can be read: {error}")
}

fn xlsx(bytes: Cursor<&[u8]>) -> Result<String, String> {
    let mut book: Xlsx<_> = open_workbook_from_rs(bytes).map_err(wrong)?;
    let mut text = Text::default();
    for name in book.sheet_names() {
        // A sheet of a chart has no cells.
        let Ok(mut cells) = book.worksheet_cells_reader(&name) else {
            continue;
        };
        text.begin(&name);
        while let Some(found) = cells.next_cell().map_err(wrong)? {
            text.put(found.get_position(), &found.get_value().clone().into())?;
        }
    }
    Ok(text.all)
}

/// A text that grows cell by cell.
#[derive(Default)]
struct Text {
    all: String,
    /// Row and column of the cell that is written.
    at: (u32, u32),
}

impl Text {
    fn begin(&mut self, name: &str) {
        if !self.all.is_empty() {
            self.all += &format!("\n\nsheet {}\n", plain(name));
        }
        self.at = (0, 0);
    }

    /// Cells come row by row; one that does not is left out.
    fn put(&mut self, place: (u32, u32), found: &Data) -> Result<(), String> {
        let shown = cell(found);
        if shown.is_empty() || place < self.at {
            return Ok(());
        }
        let (down, across) = match place.0 - self.at.0 {
            0 => (0, place.1 - self.at.1),
            down => (down, place.1),
        };
        let longer = self.all.len() as u64 + u64::from(down) + u64::from(across);
        if longer + shown.len() as u64 > TABLE_MOST {
            return Err(format!("the sheets are longer than {TABLE_MOST} bytes"));
        }
        self.all.extend((0..down).map(|_| '\n'));
        self.all.extend((0..across).map(|_| '\t'));
        self.all += &shown;
        self.at = place;
        Ok(())
    }
}

fn cell(cell: &Data) -> String {
    match cell {
        Data::Int(number) => number.to_string(),
        Data::Float(number) => number.to_string(),
        Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => plain(text),
        Data::Bool(value) => value.to_string(),
        Data::DateTime(time) => instant(time),
        Data::Error(_) | Data::Empty => String::new(),
    }
}

/// A date, a time of day or a duration, as CSV has them.
fn instant(time: &ExcelDateTime) -> String {
    let days = time.as_f64();
    if !time.is_duration() && days >= 1.0 {
        let (year, month, day, hour, minute, second, milli) = time.to_ymd_hms_milli();
        return format!(
            "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{milli:03}"
        );
    }
    // Whole milliseconds, so that no minute has 60 s.
    let all = libm::round(days * SECONDS_A_DAY * 1e3);
    let (minutes, rest) = (libm::floor(all / 6e4), all.rem_euclid(6e4));
    let (hours, minutes) = (libm::floor(minutes / 60.0), minutes.rem_euclid(60.0));
    format!("{hours:02}:{minutes:02}:{:06.3}", rest / 1e3)
}

/// Text without the signs that part cells and lines.
fn plain(text: &str) -> String {
    text.replace(['\t', '\r', '\n'], " ")
}
