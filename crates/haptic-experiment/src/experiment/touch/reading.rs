//! `[touch]`: shape, matter, device, hand, limits.

use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::parameters::TOUCH_AXES;
use crate::document::reader::Table;
use crate::experiment::reading::{remote, samples_fit, scheme, sensors};
use crate::experiment::rendering::reading::piece;
use crate::experiment::touch::keys::{
    TOUCH_BOX_HIGH, TOUCH_BOX_LOW, TOUCH_CENTRE, TOUCH_CIRCLE_CENTRE, TOUCH_CIRCLE_PERIOD,
    TOUCH_CIRCLE_RADIUS, TOUCH_CIRCLE_START, TOUCH_DAMPING, TOUCH_DISSIPATION, TOUCH_DURATION,
    TOUCH_HAND, TOUCH_HAND_STIFFNESS, TOUCH_MASS, TOUCH_MASS_DEFAULT, TOUCH_MUST_BE_PASSIVE,
    TOUCH_NORMAL, TOUCH_ORDER, TOUCH_RADIUS, TOUCH_SHAPE, TOUCH_STIFFNESS, TOUCH_SURFACE,
    TOUCH_TISSUE, TOUCH_WAY,
};
use crate::experiment::touch::{
    Grip, GripName, HandPath, ShapeName, TouchExperiment, TouchLaw, TouchShape, WorkspaceBox,
};
use crate::experiment::trial::keys::TRIAL_FORCE_RATE_LIMIT;
use crate::run::record::WHOLE_MOST;
use crate::run::safety::safety;
use crate::run::schedule::Pace;
use fracdiff::{Order, Seconds};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};

pub(crate) fn touch(table: &Table<'_>) -> Result<TouchExperiment, FileError> {
    acts(table)?;
    let axes = match table.count(&p::TOUCH_AXES)? {
        2 => 2,
        3 => 3,
        other => {
            let reason = format!("axes = {other} is not 2 or 3: one axis is a [wall]");
            return Err(table.fail_at("axes", reason));
        }
    };
    let t = table.number(&p::SAMPLE_TIME)?;
    let duration_s = table.number(&TOUCH_DURATION)?;
    samples_fit(table, t, duration_s, &(10.0..=WHOLE_MOST as f64))?;
    let law = law(table)?;
    let shape = shape(table, axes)?;
    let touch = TouchExperiment {
        axes,
        scheme: scheme(table, law.model(), law.order(), t, duration_s)?,
        law,
        mass_kg: masses(table, axes)?,
        device: device(table, t)?,
        sensors: sensors(table)?,
        path: path(table, axes, &shape)?,
        grip: match table.choice(&TOUCH_HAND)? {
            GripName::Spring => Grip::Spring(table.number(&TOUCH_HAND_STIFFNESS)?),
            GripName::Force => Grip::Force,
        },
        shape,
        duration_s,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        workspace: workspace(table, axes)?,
        must_be_passive: table.flag(&TOUCH_MUST_BE_PASSIVE)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote: remote(table)?,
        force_unstable: false,
    };
    touch
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
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
    let no_tissue: [&p::Parameter; 3] = [&p::LIBRARY, &p::AREA, &p::THICKNESS];
    for (idle, keys, with) in [
        (plane, &ball[..], "with shape = \"plane\""),
        (!plane, &[&TOUCH_NORMAL, &TOUCH_SURFACE], "with a ball"),
        (tissue, &wall, &format!("with {TOUCH_TISSUE}")),
        (!tissue, &no_tissue, &format!("without {TOUCH_TISSUE}")),
        (way, &circle, &format!("with {TOUCH_WAY}")),
        (!spring, &[&TOUCH_HAND_STIFFNESS], "with hand = \"force\""),
    ] {
        let given = keys.iter().find(|key| idle && table.has(key));
        if let Some(p::Parameter { key, .. }) = given {
            let reason = format!("{key} has no effect {with}: change that, or leave {key} out");
            return Err(table.fail_at(key, reason));
        }
    }
    Ok(())
}

/// A number an axis, if the key is there.
fn per_axis(
    table: &Table<'_>,
    parameter: &p::Parameter,
    axes: usize,
) -> Result<Option<Vec<f64>>, FileError> {
    let key = parameter.key;
    let Some(numbers) = table.numbers_if(parameter)? else {
        return Ok(None);
    };
    if numbers.len() == axes {
        return Ok(Some(numbers));
    }
    let reason = format!(
        "{key} has {} numbers, not one for each of {axes} axes: change it, or {TOUCH_AXES}",
        numbers.len()
    );
    Err(table.fail_at(key, reason))
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
        ShapeName::Ball | ShapeName::HollowBall => TouchShape::Ball {
            centre_m: per_axis(table, &TOUCH_CENTRE, axes)?.unwrap_or_else(|| vec![0.0; axes]),
            radius_m: table.number(&TOUCH_RADIUS)?,
            hollow: name == ShapeName::HollowBall,
        },
    })
}

fn law(table: &Table<'_>) -> Result<TouchLaw, FileError> {
    if !table.text(&TOUCH_TISSUE)?.is_empty() {
        return Ok(TouchLaw::Tissue(piece(table)?));
    }
    let order = Order::new(table.number(&TOUCH_ORDER)?);
    Ok(TouchLaw::Wall {
        stiffness_n_per_m: table.number(&TOUCH_STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.number(&TOUCH_DISSIPATION)?,
        order: order.map_err(|error| table.fail_at("order", error.to_string()))?,
    })
}

fn masses(table: &Table<'_>, axes: usize) -> Result<Vec<f64>, FileError> {
    let key = TOUCH_MASS.key;
    let masses = match table.numbers_if(&TOUCH_MASS)? {
        None => vec![TOUCH_MASS_DEFAULT; axes],
        Some(one) if one.len() == 1 => vec![one[0]; axes],
        Some(each) if each.len() == axes => each,
        Some(other) => {
            let reason = format!(
                "{key} has {} numbers, not one for all or each of {axes} axes",
                other.len()
            );
            return Err(table.fail_at(key, reason));
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
        delay: Seconds(table.number(&p::DELAY)?),
        friction: Newtons(table.number(&p::FRICTION)?),
        saturation: None,
        lag: Seconds(table.number(&p::CURRENT_LAG)?),
    })
}

fn path(table: &Table<'_>, axes: usize, shape: &TouchShape) -> Result<HandPath, FileError> {
    let key = TOUCH_WAY.key;
    if let Some(rows) = table.matrix_if(&TOUCH_WAY)? {
        let rows = rows.iter().map(|row| match row.split_first() {
            Some((time_s, place)) => Ok((*time_s, place.to_vec())),
            None => Err(table.fail_at(key, format!("{key} has an empty row"))),
        });
        return Ok(HandPath::WayPoints(rows.collect::<Result<_, _>>()?));
    }
    let radius = table.number(&TOUCH_CIRCLE_RADIUS)?;
    let (centre, start) = match shape {
        TouchShape::Ball {
            centre_m, radius_m, ..
        } => (centre_m.clone(), *radius_m),
        TouchShape::Plane { .. } => (vec![0.0; axes], radius),
    };
    Ok(HandPath::Circle {
        centre: per_axis(table, &TOUCH_CIRCLE_CENTRE, axes)?.unwrap_or(centre),
        start_radius: table.number_if(&TOUCH_CIRCLE_START)?.unwrap_or(start),
        radius,
        period_s: table.number(&TOUCH_CIRCLE_PERIOD)?,
    })
}

/// The workspace, if there is one.
fn workspace(table: &Table<'_>, axes: usize) -> Result<Option<WorkspaceBox>, FileError> {
    let low = per_axis(table, &TOUCH_BOX_LOW, axes)?;
    let high = per_axis(table, &TOUCH_BOX_HIGH, axes)?;
    match (low, high) {
        (None, None) => Ok(None),
        (Some(low_m), Some(high_m)) => Ok(Some(WorkspaceBox { low_m, high_m })),
        (Some(_), None) => {
            let reason = "a box has two corners: give box_high_m too".to_owned();
            Err(table.fail_at("box_low_m", reason))
        }
        (None, Some(_)) => {
            let reason = "a box has two corners: give box_low_m too".to_owned();
            Err(table.fail_at("box_high_m", reason))
        }
    }
}
