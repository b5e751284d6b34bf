//! Arguments that sentences name.

use haptic_quantity::Key;
pub(in crate::identify) use measured_table::{COLUMNS, FROM, SKIP_BAD_ROWS};

pub(in crate::identify) const AREA: Key = Key("area_m2");
pub(in crate::identify) const BASELINE: Key = Key("baseline");
pub(in crate::identify) const BONDED: Key = Key("bonded");
pub(in crate::identify) const BOOTSTRAP: Key = Key("bootstrap");
pub(in crate::identify) const CONTACT_POINT: Key = Key("contact_point_m");
pub(in crate::identify) const HALF_ANGLE: Key = Key("half_angle_rad");
pub(in crate::identify) const KIND: Key = Key("kind");
pub(in crate::identify) const LOADING: Key = Key("loading");
pub(in crate::identify) const MASTER_CURVE: Key = Key("master_curve");
pub(in crate::identify) const MODEL: Key = Key("model");
pub(in crate::identify) const POISSON_RATIO: Key = Key("poisson_ratio");
pub(in crate::identify) const RAMP_ENDS: Key = Key("ramp_ends_s");
pub(in crate::identify) const RAMP_TIME: Key = Key("ramp_time_s");
pub(in crate::identify) const SUBTRACT_START: Key = Key("subtract_start");
pub(in crate::identify) const RADIUS: Key = Key("indenter_radius_m");
pub(in crate::identify) const REPLICATES: Key = Key("replicates");
pub(in crate::identify) const SHIFT_BY: Key = Key("shift_by");
pub(in crate::identify) const STIFFENING: Key = Key(crate::material::STIFFENING);
pub(in crate::identify) const STRAIN: Key = Key("strain");
pub(in crate::identify) const STRESS: Key = Key("stress_pa");
pub(in crate::identify) const TEMPERATURE: Key = Key("temperature");
pub(in crate::identify) const THICKNESS: Key = Key("thickness_m");
pub(in crate::identify) const WEIGHTS: Key = Key("weights");
