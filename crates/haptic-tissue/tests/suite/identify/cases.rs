//! Records that people had trouble with, made anew, with their right values.

use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::ModelKind;
use haptic_tissue::identify::table::{Reader, Reading, read_table};
use haptic_tissue::identify::{Identification, Options, Record, identify};
use testkit::assert_relative;

