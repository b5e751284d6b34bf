//! Arguments that sentences name.

use haptic_quantity::Key;
pub(crate) use measured_table::{COLUMNS, FROM, SKIP_BAD_ROWS};

pub(crate) const AREA: Key = Key("area_m2");
pub(crate) const BASELINE: Key = Key("baseline");
pub(crate) const BONDED: Key = Key("bonded");
pub(crate) const BOOTSTRAP: Key = Key("bootstrap");
pub(crate) const CONTACT_POINT: Key = Key("contact_point_m");
pub(crate) const HALF_ANGLE: Key = Key("half_angle_rad");
pub(crate) const KIND: Key = Key("kind");
pub(crate) const LOADING: Key = Key("loading");
pub(crate) const MASTER_CURVE: Key = Key("master_curve");
pub(crate) const MODEL: Key = Key("model");
pub(crate) const POISSON_RATIO: Key = Key("poisson_ratio");
pub(crate) const RAMP_ENDS: Key = Key("ramp_ends_s");
pub(crate) const RAMP_TIME: Key = Key("ramp_time_s");
pub(crate) const SUBTRACT_START: Key = Key("subtract_start");
pub(crate) const RADIUS: Key = Key("indenter_radius_m");
pub(crate) const REPLICATES: Key = Key("replicates");
pub(crate) const SHIFT_BY: Key = Key("shift_by");
pub(crate) const STIFFENING: Key = Key(haptic_tissue::STIFFENING);
pub(crate) const STRAIN: Key = Key("strain");
pub(crate) const STRESS: Key = Key("stress_pa");
pub(crate) const TEMPERATURE: Key = Key("temperature");
pub(crate) const THICKNESS: Key = Key("thickness_m");
pub(crate) const WEIGHTS: Key = Key("weights");
