//! The keys of a question to the record of a plant.

use crate::form::form;
use haptic_document::parameters::range::{DEAD_TIMES, Range, SAMPLE_TIMES};

form! {
    /// Values that complete the table of a plant, by the names of keys; numbers in SI units.
    PlantForm, PLANT_RECORD:
    "Table"
    PLANT_COLUMNS = columns: text("", "Columns, as in input=valve,output=temperature, or input=12@2s of one set to 12 at 2 s, or of a response frequency, real, imaginary, gain, phase [default: time_s, input, output, or by names such as Stellgröße; those of a response by name]");
    ROW_TIME = sample_time_s: optional(SAMPLE_TIMES, "Time from row to row, in place of a column of time");
    FIRST_ROW = subtract_start: flag("Subtract the first row: the record begins at rest, but not at 0");
    SMOOTH = smooth: flag("The input is smooth between samples, not held");
    "Function"
    MODEL = model: text("", "Terms and first values as in 2exp(-5s)/(30s^0.9+1); a sum such as 0.02+0.01/s^0.5 stays one [default: found from the record]");
    POLES = poles: optional(Range::Within(1.0, 4.0), "Integer orders with this number of poles [default: found from the record]");
    STABLE = stable: flag("Only functions that come to rest by themselves");
    KNOWN_DELAY = delay_s: optional(DEAD_TIMES, "Known dead time [default: found from the record]");
    VALIDATE = validate: text("", "A second record with the same columns, on which the function is tried");
}
