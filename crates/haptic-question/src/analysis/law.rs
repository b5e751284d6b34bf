//! The law that is analysed: a wall K + B·D^μ, a piece of tissue, which has a K, a B and a memory too, or a controller.

use crate::analysis::answer::{HORIZON, Kind, operator};
use crate::analysis::keys::{
    ANALYSED_CONTROLLER, ANALYSED_SAMPLE_TIME, ANALYSED_SCHEME, ANALYSED_TISSUE, JUDGED_DEPTH,
};
use fracdiff::num_complex::Complex;
use fracdiff::parameter::Shown;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::LoopOperator;
use haptic_document::parameters::{Parameter, SCHEME, UNNAMED_PIECE};
use haptic_document::{Failure, FileError, Table};
use haptic_judge::modelled_tissue::TissuePiece;
use haptic_judge::position_controller::PositionController;
use haptic_judge::preflight::Matter;
use haptic_judge::tissue_table::{fits, piece};
use haptic_quantity::{digits, in_five_digits};
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};
use serde_json::{Value, json};

/// f = −(K·x + B·T^(−μ)·P(w)·x), for small motions at one depth.
///
/// A controller is all P: K = 0, and μ = 1 with B = T·1 N/m, which make P a force per displacement in N/m.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    /// K, N/m, if it was given.
    pub(crate) stiffness: Option<f64>,
    /// B, N·s^μ/m, if it was given.
    pub(crate) dissipation: Option<f64>,
    pub(crate) order: Order,
    pub(crate) scheme: Scheme,
    pub(crate) operator: LoopOperator,
    /// `None` of a wall.
    pub(crate) in_place: Option<InPlace>,
}

/// A law in place of a wall.
#[derive(Clone, Debug)]
pub(crate) enum InPlace {
    Tissue(Box<JudgedTissue>),
    Controller(Box<PositionController>),
}

/// A piece of tissue at the depth where it is judged.
#[derive(Clone, Debug)]
pub(crate) struct JudgedTissue {
    matter: Matter,
    depth_m: Option<f64>,
    /// Slope of its map of depth there, without unit.
    slope: f64,
    /// True if its memory is that of several elements, not D^μ.
    is_composed: bool,
}

impl Law {
    /// The law of the keys, and its sample time, which a controller brings.
    pub(crate) fn of(
        table: &Table<'_>,
        given_s: Option<f64>,
    ) -> Result<(Self, Option<f64>), Failure> {
        let has = |parameter: &Parameter| Ok::<_, Failure>(!table.text(parameter)?.is_empty());
        if has(&ANALYSED_CONTROLLER)? {
            without(
                table,
                &[&ANALYSED_TISSUE, &ANALYSED_SCHEME],
                &ANALYSED_CONTROLLER,
            )?;
            without(table, OF_WALL, &ANALYSED_CONTROLLER)?;
            of_a_tissue_alone(table)?;
            let (law, sample_time_s) = Self::of_controller(table, given_s)?;
            return Ok((law, Some(sample_time_s)));
        }
        if has(&ANALYSED_TISSUE)? {
            let t = table.required(&ANALYSED_SAMPLE_TIME)?;
            return Ok((Self::of_tissue(table, piece(table)?, Seconds(t))?, given_s));
        }
        of_a_tissue_alone(table)?;
        let order = table.order(&ORDER)?;
        let (scheme, operator) = operator(table, &ANALYSED_SCHEME, order, given_s)?;
        let wall = Self {
            stiffness: table.number_if(&STIFFNESS)?,
            dissipation: table.number_if(&DISSIPATION)?,
            order,
            scheme,
            operator,
            in_place: None,
        };
        Ok((wall, given_s))
    }

    /// A spring alone, N/m.
    pub(crate) fn spring(stiffness: f64, t: f64) -> Result<Self, Failure> {
        let order = Order::new(0.0).map_err(Failure::input)?;
        let operator = LoopOperator::new(Scheme::Exact, order, Seconds(t), HORIZON);
        Ok(Self {
            stiffness: Some(stiffness),
            dissipation: None,
            order,
            scheme: Scheme::Exact,
            operator: operator.map_err(Failure::input)?,
            in_place: None,
        })
    }

    fn of_controller(table: &Table<'_>, given_s: Option<f64>) -> Result<(Self, f64), Failure> {
        let controller = controller(table, given_s)?;
        let t = controller.setup.sample_time_s;
        let law = Self {
            stiffness: Some(0.0),
            dissipation: Some(t),
            order: controller.operator.order(),
            scheme: controller.setup.scheme,
            operator: controller.operator.clone(),
            in_place: Some(InPlace::Controller(Box::new(controller))),
        };
        Ok((law, t))
    }

    fn of_tissue(table: &Table<'_>, piece: TissuePiece, t: Seconds) -> Result<Self, Failure> {
        without(table, OF_WALL, &ANALYSED_TISSUE)?;
        let is_composed = piece.material.composed().is_some();
        let scheme = if is_composed && !table.has(&ANALYSED_SCHEME) {
            table.scheme(&SCHEME)?
        } else {
            table.scheme(&ANALYSED_SCHEME)?
        };
        if is_composed && scheme == Scheme::Exact {
            let reason = format!(
                "it is of D^μ alone, and {} has several elements: use full, or a short memory, as in grunwald:1000",
                piece.material.name
            );
            return Err(table.fail_at(ANALYSED_SCHEME.key, reason).into());
        }
        let depth_m = table.number_if(&JUDGED_DEPTH)?;
        match (piece.is_linear(), depth_m) {
            (true, None) => {}
            (false, Some(depth_m)) => fits(table, &piece, depth_m)?,
            (true, Some(_)) => {
                let reason = "the force of this piece is linear in its depth: omit it";
                return Err(table.fail_at(JUDGED_DEPTH.key, reason).into());
            }
            (false, None) => {
                let reason = format_args!(
                    "the force of this piece is not linear in its depth: give {JUDGED_DEPTH}, at which it is judged"
                );
                return Err(table.fail(reason).into());
            }
        }
        let matter = Matter::Tissue(piece);
        let map = matter.depth_map();
        let judged = matter.run_by(scheme, t, HORIZON as u64);
        let judged = judged.at_depth(map, depth_m.unwrap_or_default());
        Ok(Self {
            stiffness: Some(judged.stiffness_n_per_m),
            dissipation: Some(judged.dissipation_n_s_mu_per_m),
            order: judged.order,
            scheme,
            operator: judged.loop_operator()?,
            in_place: Some(InPlace::Tissue(Box::new(JudgedTissue {
                depth_m,
                slope: judged.map.map_or(1.0, |(_, slope)| slope),
                is_composed,
                matter,
            }))),
        })
    }

    pub(crate) fn is_controller(&self) -> bool {
        matches!(self.in_place, Some(InPlace::Controller(_)))
    }

    /// A number of a wall, which a controller has not, nor a tissue of several elements, for a report.
    pub(crate) fn of_wall(&self, number: impl Into<Option<f64>>) -> Option<f64> {
        number.into().filter(|_| self.is_one_element())
    }

    /// True of a controller that pushes on and on at a place that stands.
    pub(crate) fn integrates(&self) -> bool {
        matches!(&self.in_place, Some(InPlace::Controller(controller)) if controller.integrates)
    }

    /// A sentence that says how far times of 1/ω, s, lie outside the record of a tissue.
    pub(crate) fn beyond(&self, times_s: (f64, f64)) -> Option<String> {
        let Some(InPlace::Tissue(tissue)) = &self.in_place else {
            return None;
        };
        let Matter::Tissue(piece) = &tissue.matter else {
            return None;
        };
        let beyond = piece.material.beyond(times_s)?;
        Some(format!("{beyond}: times are 1/ω here"))
    }

    /// True if it is K + B·D^μ, of which Corollary 1 and these numbers speak.
    pub(crate) fn is_one_element(&self) -> bool {
        match &self.in_place {
            None => true,
            Some(InPlace::Tissue(tissue)) => !tissue.is_composed,
            Some(InPlace::Controller(_)) => false,
        }
    }

    /// A law in place of a wall as a report repeats it.
    pub(crate) fn in_place_result(&self) -> Value {
        match &self.in_place {
            None => json!({}),
            Some(InPlace::Tissue(tissue)) => {
                json!({"tissue": tissue.matter.words(), "depth_m": tissue.depth_m})
            }
            Some(InPlace::Controller(controller)) => {
                json!({"controller": controller.setup.law.to_string()})
            }
        }
    }

    /// Its name or order, scheme, and K and B if there are any and they are wanted, in the words below a picture.
    pub(crate) fn words(&self, k_and_b: Option<String>) -> Vec<String> {
        let law = match &self.in_place {
            None => format!("order μ = {}", digits(self.order.get(), 4)),
            Some(InPlace::Tissue(tissue)) => tissue.matter.words(),
            Some(InPlace::Controller(controller)) => {
                let law = controller.setup.law.to_string();
                format!("controller {}", in_five_digits(&law))
            }
        };
        let scheme = format!("scheme {}", self.scheme);
        let k_and_b = k_and_b.filter(|_| self.is_one_element());
        [law, scheme].into_iter().chain(k_and_b).collect()
    }
}

/// The controller in place of a wall, which brings its sample time: refuses another one.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn controller(table: &Table<'_>, given_s: Option<f64>) -> Result<PositionController, Failure> {
    let path = table.file(&ANALYSED_CONTROLLER)?.unwrap_or_default();
    let controller = PositionController::read(&path)?;
    let t = controller.setup.sample_time_s;
    if let Some(other) = given_s.filter(|given| !same_time(*given, t)) {
        let reason = format!(
            "{} s is not the {} s of the controller, whose weights are for it: omit it, or change its file",
            Shown(other),
            Shown(t)
        );
        return Err(table.fail_at(ANALYSED_SAMPLE_TIME.key, reason).into());
    }
    Ok(controller)
}

/// Keys of a wall that another law has itself.
const OF_WALL: &[&Parameter] = &[&STIFFNESS, &DISSIPATION, &ORDER];

/// Refuses keys of which a law in place of a wall has its own, or for which it has no use.
///
/// # Errors
/// A key that would have no effect, with its place.
pub fn without(table: &Table<'_>, keys: &[&Parameter], law: &Parameter) -> Result<(), FileError> {
    let Some(parameter) = keys.iter().find(|parameter| table.has(parameter)) else {
        return Ok(());
    };
    let reason = format!("it has no effect beside {law}: omit it");
    Err(table.fail_at(parameter.key, reason))
}

/// Refuses keys of a tissue without a tissue.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn of_a_tissue_alone(table: &Table<'_>) -> Result<(), FileError> {
    let mut keys = UNNAMED_PIECE.iter().chain([&JUDGED_DEPTH]);
    let Some(parameter) = keys.find(|parameter| table.has(parameter)) else {
        return Ok(());
    };
    let reason = format!("it belongs to a tissue: give {ANALYSED_TISSUE}, or omit it");
    Err(table.fail_at(parameter.key, reason))
}

/// True of two sample times that differ by rounding alone.
fn same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b
}

impl InPlace {
    /// Force per displacement without sampling, N/m.
    pub(crate) fn stiffness(&self, omega_rad_s: f64) -> Complex<f64> {
        match self {
            Self::Tissue(tissue) => tissue.matter.stiffness(omega_rad_s) * tissue.slope,
            Self::Controller(controller) => controller.setup.law.response(omega_rad_s),
        }
    }

    pub(crate) const fn kind(&self) -> Kind {
        match self {
            Self::Tissue(_) => Kind::Tissue,
            Self::Controller(_) => Kind::Controller,
        }
    }
}
