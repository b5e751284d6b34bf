//! Arguments that sentences name.

use haptic_quantity::Key;

/// Key of the columns that a user chooses.
pub const COLUMNS: Key = Key("columns");
/// Key of the time from which a record counts, s.
pub const FROM: Key = Key("from_s");
/// Key of the choice to leave out rows that are no sample.
pub const SKIP_BAD_ROWS: Key = Key("skip_bad_rows");
pub(super) const SEGMENT: Key = Key("segment");
pub(super) const SEGMENTS: Key = Key("segments");
pub(super) const TO: Key = Key("to_s");
pub(super) const UNITS: Key = Key("units");
