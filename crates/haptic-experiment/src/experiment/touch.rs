//! A touch: a hand moves a device of two or three axes over a shape of tissue, simulated here or at a port.
//!
//! ```text
//! m_i·x_i'' + b·x_i' = k·(hand_i − x_i) + f_i       or with the hand's force in place of its spring
//! f = n·min(0, −(K·p + B·D^μ p))  through the safety chain         p depth into the shape, n its normal
//! ```
//! - *One operator* on the depth, whatever the number of axes: see [`Contact`](haptic_loop::Contact). No friction.
//! - *Energy* given to the hand: from the force and motion at the hand, exact between samples. A passive device never gives more than it
//!   received.
//! - *Pre-flight* along the normal, with the effective mass 1/(nᵀ M⁻¹ n) of the posture. A ball has normals in every direction, so the
//!   lightest and the heaviest mass are judged, and the worse verdict is reported.

mod device;
mod report;
mod running;
mod shape;

use super::{
    kind::{Conduct, Experiment as _},
    reading::remote,
};
use fracdiff::{Scheme, Seconds, parameter::Shown};
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, FileError, Table, parameters,
    parameters::{
        CURRENT_LAG, DELAY, DEVICE, FORCE_LIMIT, FORCE_SENSOR, FRICTION, LESS_THAN_IDEAL,
        Parameter, SAMPLE_TIME, SCHEME, SENSED_RANGE, TOUCH_AXES, UNNAMED_PIECE, joined,
        range::{
            DAMPINGS, DISSIPATIONS, DURATIONS, MASSES, NUMBERS, PLACES, RADII, Range, STIFFNESSES,
            STIFFNESSES_ABOVE_0, WALL_ORDERS, WORKSPACES,
        },
    },
};
use haptic_judge::{
    preflight::{Matter, Preflight, WallContact},
    tissue_table::{piece, scheme},
    trial::force_and_rate,
};
use haptic_loop::{
    Limit, SafetyChain, SafetyLimits,
    plant::{ForceSensorConfig, MassDamperConfig},
    units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre},
};
use haptic_trial::{
    Sensors,
    device_table::{dynamics, force_sensor, samples_fit, sensors, without},
    keys::trial::TRIAL_FORCE_RATE_LIMIT,
    safe_chain::safe_chain,
    safety::{GuardChoice, Safety, keys::WORKSPACE_LOW, safety, workspace},
    samples::WHOLE_MOST,
};
use shape::{Circle, Grip, HandPath, TouchBall, TouchShape};
pub(crate) use shape::{GripName, ShapeName};

parameters! {
    crate;
    /// The shape that is touched.
    TOUCH_SHAPE = text("shape", "ball",
        "Shape to touch");
    TOUCH_NORMAL = list("normal", NUMBERS,
        "Plane: direction into it, one number per axis, of any length [default: along the first axis]");
    /// Place of a plane, m.
    TOUCH_SURFACE = number("surface_m", 0.0, "0", PLACES, "Plane: its distance from 0 along that direction");
    /// Centre of a ball, m.
    TOUCH_CENTRE = list("centre_m", PLACES, "Ball: its centre, one number per axis [default: zeros]");
    /// Radius of a ball, m.
    TOUCH_RADIUS = number("radius_m", 0.02, "20mm", RADII, "Ball: its radius");
    TOUCH_TISSUE = text("tissue", "",
        "Tissue of the shape: a name from `host-cli materials list`, or a TOML file [default: K, B and order]");
    TOUCH_STIFFNESS = number("stiffness_n_per_m", 300.0, "300", STIFFNESSES, "K of the shape, without a tissue");
    TOUCH_DISSIPATION = number("dissipation_n_s_mu_per_m", 5.0, "5", DISSIPATIONS, "B of the shape, N·s^μ/m");
    TOUCH_ORDER = number("order", 0.5, "0.5", WALL_ORDERS, "Order of the dissipation: 0 a spring, 1 a damper");
    /// Mass of the device, kg.
    TOUCH_MASS = list("mass_kg", MASSES, "Mass of the device, above 0: one number, or one per axis [default: 0.065]");
    /// Damping of device and hand, N·s/m.
    TOUCH_DAMPING = number("damping_n_s_per_m", 3.5, "3.5", DAMPINGS, "Damping of device and hand on each axis");
    TOUCH_HAND = text("hand", "spring", "What the hand is");
    /// Stiffness of the hand, N/m.
    TOUCH_HAND_STIFFNESS = number("hand_stiffness_n_per_m", 300.0, "300", STIFFNESSES_ABOVE_0, "Stiffness of that spring");
    TOUCH_WAY = list("way_points", WAY,
        "Path of the hand instead of a circle: rows of time in s and position in m (or force in N), one number per axis, \
         straight in between");
    /// Centre of the circle of the hand, m.
    TOUCH_CIRCLE_CENTRE = list("circle_centre_m", PLACES, "Circle: its centre [default: that of the ball, else zeros]");
    /// Radius of the circle of the hand, m.
    TOUCH_CIRCLE_RADIUS = number("circle_radius_m", 0.018, "18mm", RADII, "Circle, in the plane of the first two axes: its radius");
    /// Radius at the start of the circle, m.
    TOUCH_CIRCLE_START = optional("circle_start_radius_m", RADII,
        "Circle: radius at time 0; the path reaches the circle in 1 s [default: that of the ball]");
    /// Time of a turn, s.
    TOUCH_CIRCLE_PERIOD = number("circle_period_s", 2.0, "2s", DURATIONS, "Circle: time per turn");
    /// Length of a run, s.
    TOUCH_DURATION = number("duration_s", 5.0, "5s", DURATIONS, "Length of a run, at most a million samples");
    /// Low corner of the workspace, m.
    TOUCH_BOX_LOW = list("box_low_m", WORKSPACES, "Low corner of a box, one number per axis; outside it a fault ends the run");
    /// High corner of the workspace, m.
    TOUCH_BOX_HIGH = list("box_high_m", WORKSPACES, "High corner of that box");
    /// True if energy for the hand is a failure.
    TOUCH_MUST_BE_PASSIVE = flag("must_be_passive", "Fail if the hand gets energy or a force reaches its limit");
}

/// Times, places and forces alike.
const WAY: Range = Range::Within(-1e4, 1e7);

/// Mass on an axis that is not given, kg.
const TOUCH_MASS_DEFAULT: f64 = 0.065;

/// Keys of `[touch]`.
pub(crate) const TOUCH: &[Parameter] = &joined::<45>(&[
    &[TOUCH_AXES, TOUCH_SHAPE, TOUCH_NORMAL, TOUCH_SURFACE],
    &[TOUCH_CENTRE, TOUCH_RADIUS],
    &[TOUCH_TISSUE],
    UNNAMED_PIECE,
    &[TOUCH_STIFFNESS, TOUCH_DISSIPATION, TOUCH_ORDER, SCHEME],
    &[TOUCH_MASS, TOUCH_DAMPING],
    LESS_THAN_IDEAL,
    FORCE_SENSOR,
    &[TOUCH_HAND, TOUCH_HAND_STIFFNESS, TOUCH_WAY],
    &[TOUCH_CIRCLE_CENTRE, TOUCH_CIRCLE_RADIUS],
    &[TOUCH_CIRCLE_START, TOUCH_CIRCLE_PERIOD],
    &[SAMPLE_TIME, TOUCH_DURATION, FORCE_LIMIT],
    &[TRIAL_FORCE_RATE_LIMIT],
    &[TOUCH_BOX_LOW, TOUCH_BOX_HIGH, TOUCH_MUST_BE_PASSIVE],
]);

#[derive(Debug)]
pub(crate) struct TouchExperiment {
    /// Number of axes: 2 or 3.
    pub axes: usize,
    shape: TouchShape,
    /// The matter behind its surface.
    matter: Matter,
    scheme: Scheme,
    /// Mass of the device on each axis, kg, above 0.
    mass_kg: Vec<f64>,
    /// The device without its mass and hand: damping, delay, friction, lag, sample time; the same on each axis.
    device: MassDamperConfig,
    sensors: Sensors,
    force_sensor: Option<ForceSensorConfig>,
    /// Path of the hand, m or N.
    path: HandPath,
    /// Coupling of hand and device.
    grip: Grip,
    /// Length of a run, s.
    duration_s: f64,
    /// Largest norm of the force, N.
    force_limit_n: f64,
    /// Largest rate of the force on an axis, N/s; `None` for any.
    force_rate_limit_n_per_s: Option<f64>,
    /// The lowest and the highest place of each axis, m, if there is such a box.
    workspace_m: Option<[Vec<f64>; 2]>,
    /// True if the run fails when the hand gains energy or a force reaches its limit.
    pub must_be_passive: bool,
    /// Further settings of the safety chain.
    safety: Safety,
    /// Conduct of a device at a port, in whose hand the shape is then felt, or of the simulated one.
    conduct: Conduct,
}

impl TouchExperiment {
    pub(crate) const fn sample_time(&self) -> Seconds {
        self.device.sample_time
    }

    /// That at time 0 included.
    fn samples(&self) -> Result<u64, Failure> {
        let allowed = 10.0..=WHOLE_MOST as f64;
        haptic_trial::samples::count(self.duration_s, self.sample_time().0, &allowed)
    }

    /// An axis of this mass, kg, as it is simulated, the spring of the hand with it.
    const fn axis(&self, mass_kg: f64) -> MassDamperConfig {
        let stiffness = match self.grip {
            Grip::Spring(stiffness) => stiffness,
            Grip::Force => 0.0,
        };
        MassDamperConfig {
            mass: Kilograms(mass_kg),
            stiffness: NewtonsPerMetre(stiffness),
            ..self.device
        }
    }

    /// The loop for `samples` samples.
    fn look(&self, samples: u64) -> Preflight<'_> {
        Preflight {
            contact: WallContact::OneSided,
            guarded: self.safety.guard == GuardChoice::EnergyBounding,
            ..(self.matter).run_by(self.scheme, self.sample_time(), samples)
        }
    }

    fn lightest(&self) -> MassDamperConfig {
        self.axis(self.masses()[0])
    }

    /// The lightest axis as the analysis knows it.
    fn dynamics(&self) -> Dynamics {
        dynamics(&self.lightest())
    }

    /// The lightest and the heaviest axis, kg.
    fn masses(&self) -> [f64; 2] {
        let masses = || self.mass_kg.iter().copied();
        [
            masses().fold(f64::INFINITY, f64::min),
            masses().fold(0.0, f64::max),
        ]
    }

    /// The safety chain of the loop that runs here: force limited by its norm, the guard for the lightest axis. On a device it is that
    /// of the force alone; the rest is the device's.
    fn chain(&self) -> Result<SafetyChain<f64>, Failure> {
        let (limits, device) = (self.norm_and_box(), self.lightest());
        safe_chain(
            limits,
            &device,
            self.sensors,
            &self.safety,
            self.conduct.at_port(),
        )
    }

    fn norm_and_box(&self) -> SafetyLimits {
        let (force, rate) = (self.force_limit_n, self.force_rate_limit_n_per_s);
        let brakes = self.safety.number(Limit::Braking).is_some();
        let workspace_box = self.workspace_m.as_ref().map(|[low_m, high_m]| {
            // An axis beyond those of the device repeats the last one.
            [0, 1, 2].map(|axis: usize| {
                let axis = axis.min(self.axes - 1);
                workspace(low_m[axis], high_m[axis], brakes)
            })
        });
        SafetyLimits {
            norm: Some(Newtons(force)),
            workspace_box,
            ..force_and_rate(force, rate, self.sample_time())
        }
    }
}

/// `[touch]`: shape, matter, device, hand, limits.
pub(crate) fn touch(table: &Table<'_>) -> Result<TouchExperiment, FileError> {
    acts(table)?;
    let axes = match table.count(&TOUCH_AXES)? {
        2 => 2,
        3 => 3,
        other => {
            return Err(table.fail_at(
                "axes",
                format_args!("axes = {other} is not 2 or 3: one axis is a [wall]"),
            ));
        }
    };
    let t = table.number(&SAMPLE_TIME)?;
    let duration_s = table.number(&TOUCH_DURATION)?;
    samples_fit(table, t, duration_s, &(10.0..=WHOLE_MOST as f64))?;
    let matter = matter(table)?;
    let look = matter.run_by(Scheme::Exact, Seconds(t), 0);
    let shape = shape(table, axes)?;
    let safety = safety(table)?;
    let remote = remote(table)?;
    if remote.is_some() {
        let idle = format!("with a device, which has its own: omit {DEVICE}");
        without(table, [&SENSED_RANGE], &idle)?;
    }
    let touch = TouchExperiment {
        axes,
        scheme: scheme(table, look.model, look.order, t, duration_s)?,
        matter,
        mass_kg: masses(table, axes)?,
        device: device(table, t)?,
        sensors: sensors(table)?,
        force_sensor: force_sensor(table)?,
        path: path(table, axes, &shape)?,
        grip: match table.choice(&TOUCH_HAND)? {
            GripName::Spring => Grip::Spring(table.number(&TOUCH_HAND_STIFFNESS)?),
            GripName::Force => Grip::Force,
        },
        shape,
        duration_s,
        force_limit_n: table.number(&FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        workspace_m: workspace_of(table, axes, &safety)?,
        must_be_passive: table.flag(&TOUCH_MUST_BE_PASSIVE)?,
        safety,
        conduct: Conduct::on(remote),
    };
    (touch.check()).map_err(|error| table.fail(error))?;
    Ok(touch)
}

/// Refuses keys of a shape, matter or hand that was not chosen.
fn acts(table: &Table<'_>) -> Result<(), FileError> {
    let shape: ShapeName = table.choice(&TOUCH_SHAPE)?;
    let plane = shape == ShapeName::Plane;
    let tissue = !table.text(&TOUCH_TISSUE)?.is_empty();
    let way = table.has(&TOUCH_WAY);
    let spring = table.choice::<GripName>(&TOUCH_HAND)? == GripName::Spring;
    let ball = [&TOUCH_CENTRE, &TOUCH_RADIUS];
    let wall = [&TOUCH_STIFFNESS, &TOUCH_DISSIPATION, &TOUCH_ORDER];
    let circle = [
        &TOUCH_CIRCLE_CENTRE,
        &TOUCH_CIRCLE_RADIUS,
        &TOUCH_CIRCLE_START,
        &TOUCH_CIRCLE_PERIOD,
    ];
    let no_tissue: Vec<&Parameter> = UNNAMED_PIECE.iter().collect();
    for (idle, keys, with) in [
        (plane, &ball[..], "with shape = \"plane\""),
        (!plane, &[&TOUCH_NORMAL, &TOUCH_SURFACE], "with a ball"),
        (tissue, &wall, &format!("with {TOUCH_TISSUE}")),
        (!tissue, &no_tissue, &format!("without {TOUCH_TISSUE}")),
        (way, &circle, &format!("with {TOUCH_WAY}")),
        (!spring, &[&TOUCH_HAND_STIFFNESS], "with hand = \"force\""),
    ] {
        let given = keys.iter().find(|key| idle && table.has(key));
        if let Some(Parameter { key, .. }) = given {
            return Err(table.fail_at(
                key,
                format_args!("{key} has no effect {with}: change that, or omit {key}"),
            ));
        }
    }
    Ok(())
}

/// A number an axis, if the key is there.
fn per_axis(
    table: &Table<'_>,
    parameter: &Parameter,
    axes: usize,
) -> Result<Option<Vec<f64>>, FileError> {
    let key = parameter.key;
    let Some(numbers) = table.numbers_if(parameter)? else {
        return Ok(None);
    };
    if numbers.len() == axes {
        return Ok(Some(numbers));
    }
    Err(table.fail_at(
        key,
        format_args!(
            "{key} has {} numbers, not one for each of {axes} axes: change it, or {TOUCH_AXES}",
            numbers.len()
        ),
    ))
}

fn shape(table: &Table<'_>, axes: usize) -> Result<TouchShape, FileError> {
    let name: ShapeName = table.choice(&TOUCH_SHAPE)?;
    Ok(match name {
        ShapeName::Plane => {
            let along_first = || (0..axes).map(|axis| f64::from(u8::from(axis == 0)));
            TouchShape::Plane {
                normal: per_axis(table, &TOUCH_NORMAL, axes)?
                    .unwrap_or_else(|| along_first().collect()),
                surface_m: table.number(&TOUCH_SURFACE)?,
            }
        }
        ShapeName::Ball | ShapeName::HollowBall => TouchShape::Ball(TouchBall {
            centre_m: per_axis(table, &TOUCH_CENTRE, axes)?.unwrap_or_else(|| vec![0.0; axes]),
            radius_m: table.number(&TOUCH_RADIUS)?,
            hollow: name == ShapeName::HollowBall,
        }),
    })
}

fn matter(table: &Table<'_>) -> Result<Matter, FileError> {
    if !table.text(&TOUCH_TISSUE)?.is_empty() {
        return Ok(Matter::Tissue(piece(table)?));
    }
    Ok(Matter::Wall {
        stiffness_n_per_m: table.number(&TOUCH_STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.number(&TOUCH_DISSIPATION)?,
        order: table.order(&TOUCH_ORDER)?,
    })
}

fn masses(table: &Table<'_>, axes: usize) -> Result<Vec<f64>, FileError> {
    let key = TOUCH_MASS.key;
    let masses = match table.numbers_if(&TOUCH_MASS)? {
        None => vec![TOUCH_MASS_DEFAULT; axes],
        Some(one) if one.len() == 1 => vec![one[0]; axes],
        Some(each) if each.len() == axes => each,
        Some(other) => {
            return Err(table.fail_at(
                key,
                format_args!(
                    "{key} has {} numbers, not one for all or each of {axes} axes",
                    other.len()
                ),
            ));
        }
    };
    Ok(masses)
}

/// All of the axes but their masses and the hand.
fn device(table: &Table<'_>, sample_time_s: f64) -> Result<MassDamperConfig, FileError> {
    Ok(MassDamperConfig {
        mass: Kilograms(TOUCH_MASS_DEFAULT),
        damping: NewtonSecondsPerMetre(table.number(&TOUCH_DAMPING)?),
        stiffness: NewtonsPerMetre(0.0),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(table.number(&DELAY)?),
        friction: Newtons(table.number(&FRICTION)?),
        saturation: None,
        gain: 1.0,
        current_lag: Seconds(table.number(&CURRENT_LAG)?),
    })
}

fn path(table: &Table<'_>, axes: usize, shape: &TouchShape) -> Result<HandPath, FileError> {
    let wrong = |reason: String| Err(table.fail_at(TOUCH_WAY.key, reason));
    let Some(rows) = table.matrix_if(&TOUCH_WAY)? else {
        if table.choice::<GripName>(&TOUCH_HAND)? == GripName::Force {
            return Err(table.fail(format!(
                "a hand that is a force follows {TOUCH_WAY} in N, and a circle is a path of positions: give {TOUCH_WAY}, or {hand_spring}",
                hand_spring = TOUCH_HAND.set_to("spring")
            )));
        }
        return circle(table, axes, shape);
    };
    if rows.is_empty() {
        return wrong(format!("{TOUCH_WAY} is empty: give at least one row"));
    }
    let (mut way, mut before) = (Vec::new(), f64::NEG_INFINITY);
    for (n, row) in (1..).zip(rows) {
        let (time_s, point) = match row.split_first() {
            Some((time_s, point)) if point.len() == axes => (*time_s, point.to_vec()),
            _ => {
                let numbers = row.len().saturating_sub(1);
                return wrong(format!(
                    "row {n} of {TOUCH_WAY} has {numbers} numbers behind its time, not one for each of {axes} axes"
                ));
            }
        };
        if time_s <= before || time_s < 0.0 {
            let time_s = Shown(time_s);
            return wrong(format!(
                "row {n} of {TOUCH_WAY} is at {time_s} s, which is not at least 0 and later than the row before"
            ));
        }
        before = time_s;
        way.push((time_s, point));
    }
    Ok(HandPath::WayPoints(way))
}

fn circle(table: &Table<'_>, axes: usize, shape: &TouchShape) -> Result<HandPath, FileError> {
    let radius = table.number(&TOUCH_CIRCLE_RADIUS)?;
    let (centre, start) = match shape {
        TouchShape::Ball(ball) => (ball.centre_m.clone(), ball.radius_m),
        TouchShape::Plane { .. } => (vec![0.0; axes], radius),
    };
    Ok(HandPath::Circle(Circle {
        centre: per_axis(table, &TOUCH_CIRCLE_CENTRE, axes)?.unwrap_or(centre),
        start_radius: table.number_if(&TOUCH_CIRCLE_START)?.unwrap_or(start),
        radius,
        period_s: table.number(&TOUCH_CIRCLE_PERIOD)?,
    }))
}

/// The corners of the workspace, if there is one.
fn workspace_of(
    table: &Table<'_>,
    axes: usize,
    safety: &Safety,
) -> Result<Option<[Vec<f64>; 2]>, FileError> {
    let corners = (
        per_axis(table, &TOUCH_BOX_LOW, axes)?,
        per_axis(table, &TOUCH_BOX_HIGH, axes)?,
    );
    let (low_m, high_m) = match corners {
        (None, None) => return Ok(None),
        (Some(low_m), Some(high_m)) => (low_m, high_m),
        (low, _) => {
            let (key, missing) = match low {
                Some(_) => ("box_low_m", "box_high_m"),
                None => ("box_high_m", "box_low_m"),
            };
            return Err(table.fail_at(
                key,
                format_args!("a box has two corners: give {missing} too"),
            ));
        }
    };
    if let Some((low, high)) = low_m.iter().zip(&high_m).find(|(low, high)| low >= high) {
        let (low, high) = (Shown(*low), Shown(*high));
        return Err(table.fail_at(
            TOUCH_BOX_HIGH.key,
            format_args!(
                "{TOUCH_BOX_HIGH} has {high}, which is not above {low} of {TOUCH_BOX_LOW}"
            ),
        ));
    }
    if safety.workspace_m.is_some() {
        return Err(table.fail_at(WORKSPACE_LOW.key, format_args!(
            "{WORKSPACE_LOW} applies to all axes, {TOUCH_BOX_LOW} to each separately: omit one of them"
        )));
    }
    Ok(Some([low_m, high_m]))
}
