//! `[design]`.

use crate::analysis::{ANALYSED_CONTROLLER, law};
use crate::bench::{bench, orders, scheme};
use crate::design::coupler::{CouplerCriterion, CouplerDesign};
use crate::design::front::Front;
use crate::design::{
    COMPARED_AT_HZ, DESIGN_ORDERS, DesignWish, FORCE_NOISE_LIMIT, FRONT, GAIN_MARGIN, REQUIRE,
    RequireName, WISH, WISH_FREQUENCY, WISH_TISSUE, WallDesign, WallWish,
};
use fracdiff::Order;
use haptic_document::parameters::{
    CURRENT_LAG, DELAY, DEVICE_MODEL, ENCODER_RESOLUTION, FRICTION, Parameter, SAMPLE_TIME, SCHEME,
    SENSOR_NOISE, UNNAMED_PIECE,
};
use haptic_document::{Failure, FileError, Table};
use haptic_judge::position_controller::PositionController;
use haptic_judge::preflight::WallContact;
use haptic_judge::tissue_table::linear_piece;
use haptic_judge::wall::contact;
use haptic_trial::keys::trial::TRIAL_FORCE_LIMIT;
use haptic_trial::keys::wall::{ONE_SIDED, WALL_CONTACT};

///
/// # Errors
/// A missing or wrong key: with file and line.
pub fn wish(table: &Table<'_>) -> Result<DesignWish, FileError> {
    let wish = table.choice(&WISH)?;
    if wish != DesignWish::Tissue {
        for parameter in [&WISH_TISSUE].into_iter().chain(UNNAMED_PIECE) {
            foreign(table, parameter, "the wish tissue")?;
        }
    }
    if wish != DesignWish::Controller {
        foreign(table, &ANALYSED_CONTROLLER, "the wish controller")?;
    }
    Ok(wish)
}

///
/// # Errors
/// A missing or wrong key: with file and line.
pub fn design(table: &Table<'_>, wish: DesignWish) -> Result<WallDesign, Failure> {
    let wish = match wish {
        DesignWish::Controller => WallWish::Controller(Box::new(controller(table)?)),
        DesignWish::StiffestWall
        | DesignWish::MostDamping
        | DesignWish::Tissue
        | DesignWish::Coupler => aim(table, wish)?,
    };
    Ok(towards(table, wish)?)
}

/// A controller, which has orders, scheme and sample time of its own, and pulls too.
fn controller(table: &Table<'_>) -> Result<PositionController, Failure> {
    if table.text(&ANALYSED_CONTROLLER)?.is_empty() {
        let reason = format!("the wish controller needs one: give {ANALYSED_CONTROLLER}");
        return Err(table.fail_at(WISH.key, reason).into());
    }
    for parameter in [
        &WISH_FREQUENCY,
        &DESIGN_ORDERS,
        &SCHEME,
        &ONE_SIDED,
        &WALL_CONTACT,
    ] {
        foreign(table, parameter, "another wish")?;
    }
    let controller = law::controller(table, table.number_if(&SAMPLE_TIME)?)?;
    let every_motion = table.choice::<RequireName>(&REQUIRE)? == RequireName::EveryMotion;
    if every_motion && controller.integrates {
        let reason = "a controller with an integral has no such proof: change it";
        return Err(table.fail_at(REQUIRE.key, reason).into());
    }
    Ok(controller)
}

/// The front, for which walls are not tried.
///
/// # Errors
/// A missing or wrong key: with file and line.
pub fn front(table: &Table<'_>) -> Result<Front, FileError> {
    for parameter in [
        &WISH,
        &WISH_TISSUE,
        &ANALYSED_CONTROLLER,
        &ONE_SIDED,
        &WALL_CONTACT,
        &TRIAL_FORCE_LIMIT,
    ]
    .into_iter()
    .chain(UNNAMED_PIECE)
    {
        foreign(table, parameter, &format!("a design without {FRONT}"))?;
    }
    if table.choice::<RequireName>(&REQUIRE)? == RequireName::EveryMotion {
        let reason = format!("proofs belong to a design without {FRONT}: change it");
        return Err(table.fail_at(REQUIRE.key, reason));
    }
    let frequency_hz = (table.number_if(&WISH_FREQUENCY)?).unwrap_or(COMPARED_AT_HZ);
    Ok(Front {
        design: towards(table, WallWish::MostDamping { frequency_hz })?,
        frequency_hz,
    })
}

fn towards(table: &Table<'_>, wish: WallWish) -> Result<WallDesign, FileError> {
    let require = table.choice(&REQUIRE)?;
    let gain_margin = match require {
        RequireName::Passive => {
            foreign(table, &GAIN_MARGIN, "the requirement stable")?;
            None
        }
        RequireName::Stable | RequireName::EveryMotion => Some(table.number(&GAIN_MARGIN)?),
    };
    let contact = contact(table)?;
    if require == RequireName::EveryMotion && contact == WallContact::OneSided {
        let signed = WALL_CONTACT.set_to("signed");
        let reason = format!(
            "no proof covers a wall that never pulls if its memory is fed with the depth: give {signed}, or omit {ONE_SIDED}"
        );
        return Err(table.fail_at(REQUIRE.key, reason));
    }
    let controller = wish.controller();
    let sample_time_s = controller.map(|controller| controller.setup.sample_time_s);
    let design = WallDesign {
        contact,
        device: bench(table, sample_time_s)?,
        scheme: match controller {
            Some(controller) => controller.setup.scheme,
            None => scheme(table)?,
        },
        orders: match controller {
            Some(controller) => vec![controller.operator.order()],
            None => in_order(table)?,
        },
        finer: controller.is_none() && !table.has(&DESIGN_ORDERS),
        gain_margin,
        every_motion: require == RequireName::EveryMotion || contact == WallContact::Signed,
        wish,
        force_noise_limit_n: table.number_if(&FORCE_NOISE_LIMIT)?,
    };
    design
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(design)
}

/// The quantity that a wall is optimised for.
fn aim(table: &Table<'_>, wish: DesignWish) -> Result<WallWish, FileError> {
    let frequency_hz = table.number_if(&WISH_FREQUENCY)?;
    Ok(match wish {
        DesignWish::MostDamping => WallWish::MostDamping {
            frequency_hz: table.required(&WISH_FREQUENCY)?,
        },
        DesignWish::Tissue => {
            if table.text(&WISH_TISSUE)?.is_empty() {
                let reason = format!("the wish tissue needs one: give {WISH_TISSUE}");
                return Err(table.fail_at(WISH.key, reason));
            }
            let piece = linear_piece(table)?;
            WallWish::Tissue {
                shape_m: piece.shape_m(),
                material: *piece.material,
                frequency_hz: frequency_hz.unwrap_or(COMPARED_AT_HZ),
            }
        }
        DesignWish::StiffestWall | DesignWish::Controller | DesignWish::Coupler => {
            foreign(table, &WISH_FREQUENCY, "another wish")?;
            WallWish::StiffestWall
        }
    })
}

/// A coupler is designed for an ideal device.
///
/// # Errors
/// A missing or wrong key: with file and line.
pub fn coupler(table: &Table<'_>) -> Result<CouplerDesign, FileError> {
    let of_walls = [GAIN_MARGIN, FORCE_NOISE_LIMIT, TRIAL_FORCE_LIMIT];
    for parameter in of_walls.into_iter().chain([ONE_SIDED, WALL_CONTACT]) {
        foreign(table, &parameter, "a wall")?;
    }
    let device = bench(table, None)?;
    if !device.imperfections().is_ideal() {
        let reason = format!(
            "a coupler is designed for an ideal device: leave out {FRICTION}, {DELAY}, \
             {CURRENT_LAG}, {ENCODER_RESOLUTION}, {SENSOR_NOISE} and {DEVICE_MODEL}"
        );
        return Err(table.fail(reason));
    }
    Ok(CouplerDesign {
        device: device.plant,
        object: CouplerDesign::OBJECT,
        scheme: scheme(table)?,
        orders: in_order(table)?,
        criterion: match table.choice(&REQUIRE)? {
            RequireName::Stable => CouplerCriterion::Llewellyn,
            RequireName::EveryMotion => {
                let reason = format!(
                    "{} belongs to a wall: change it",
                    REQUIRE.set_to("every-motion")
                );
                return Err(table.fail_at(REQUIRE.key, reason));
            }
            RequireName::Passive => CouplerCriterion::Passive,
        },
        frequency_hz: (table.number_if(&WISH_FREQUENCY)?).unwrap_or(COMPARED_AT_HZ),
    })
}

/// Refuses a key that would have no effect.
fn foreign(table: &Table<'_>, parameter: &Parameter, of: &str) -> Result<(), FileError> {
    if !table.has(parameter) {
        return Ok(());
    }
    let key = parameter.key;
    Err(table.fail_at(key, format!("{key} belongs to {of}: omit it")))
}

/// Each of the orders once, rising.
fn in_order(table: &Table<'_>) -> Result<Vec<Order>, FileError> {
    let mut orders = orders(table, &DESIGN_ORDERS)?;
    orders.sort_by(|a, b| a.get().total_cmp(&b.get()));
    orders.dedup();
    Ok(orders)
}
