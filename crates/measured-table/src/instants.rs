//! Dates and times of day in the cells of a column of time, as loggers write them.

use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime};

/// Spellings of a date with a time of day: ISO 8601, that of SQL and of spreadsheets, and that of German programs.
const DATES: [&str; 4] = [
    "%Y-%m-%dT%H:%M:%S%.f",
    "%Y-%m-%d %H:%M:%S%.f",
    "%Y/%m/%d %H:%M:%S%.f",
    "%d.%m.%Y %H:%M:%S%.f",
];

/// The instant of a cell in s since a fixed one; of a time of day alone since midnight.
fn instant(cell: &str) -> Option<NaiveDateTime> {
    let zoned = || Some(DateTime::parse_from_rfc3339(cell).ok()?.naive_utc());
    let date = |spelling: &&str| NaiveDateTime::parse_from_str(cell, spelling).ok();
    let of_day = || {
        let time = NaiveTime::parse_from_str(cell, "%H:%M:%S%.f").ok()?;
        Some(NaiveDate::default().and_time(time))
    };
    zoned()
        .or_else(|| DATES.iter().find_map(date))
        .or_else(of_day)
}

/// The time of each cell in s since the first, if each is an instant; a time of day that falls by half a day and more is that of the next day.
pub(super) fn since_first<'c>(cells: impl Iterator<Item = &'c str>) -> Option<Vec<f64>> {
    const DAY: f64 = 86_400.0;
    let mut first = None;
    let (mut last, mut days) = (0.0, 0.0);
    cells
        .map(|cell| {
            let instant = instant(cell)?;
            let since = instant - *first.get_or_insert(instant);
            // A record of 292 years in nanoseconds at most.
            let since = since.num_nanoseconds()? as f64 * 1e-9;
            let is_of_day = instant.date() == NaiveDate::default();
            if is_of_day && since + days < last - DAY / 2.0 {
                days += DAY;
            }
            last = since + days;
            Some(last)
        })
        .collect()
}
