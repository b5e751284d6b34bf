//! Arguments that sentences name.

use haptic_quantity::Key;

pub(super) const COLUMNS: Key = Key("columns");
pub(super) const FROM: Key = Key("from_s");
pub(super) const SEGMENT: Key = Key("segment");
pub(super) const SEGMENTS: Key = Key("segments");
pub(super) const TO: Key = Key("to_s");
pub(super) const UNITS: Key = Key("units");
