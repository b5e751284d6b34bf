//! Z-width: how stiff a wall can be rendered, by trying (after the dissertation's section 4.4).
//!
//! The device hits a wall at its start position and is pushed into it; the rule by which it comes to rest is
//! that of [`settling`](haptic_judge::settling). For each dissipation B the largest stable stiffness K is bracketed
//! from above on a coarse scale and then bisected. Beside it stands what the analysis says, of a device
//! at a port if its file is given. That one is tried from soft walls up instead, and few times beyond its limits.
//! Cells are independent and run on all cores; each has a seed of its own, made from the
//! seed of the experiment and the cell's place, so the result does not depend on the number of cores.
//! - *Friction* can hold a wall that would shake. So a device with friction is tried with and without: stable is
//!   what settles both ways, and how far friction alone holds it stands beside. The dissertation's rule does not ask.
//! - *A wall that only pushes* is hit at six speeds, and has to settle after each.
//! - *A specimen of a tissue* in place of walls has its own order, and K, B and memory that only grow together: of it the largest
//!   scale is searched, along one line.
//! - *A controller* from position to force likewise, without limits of its own.
//! - *Cost*: about 60 runs of a quarter of a millisecond a cell, twice that with friction, up to six times that of one that only
//!   pushes.
//!
//! - *A robot that moves*, by the device file of one, is tried in each corner of its hands, and its stable walls are intervals.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

pub mod campaign;
pub mod rig;
mod robot;
mod search;
mod upward;

use crate::analysis::{ANALYSED_CONTROLLER, ANALYSED_TISSUE, RUN_S, law};
use crate::bench::{AskedDevice, bench, check_orders, orders, scheme};
use fracdiff::{Order, Scheme};
use haptic_document::Warn;
use haptic_document::parameters::range::WALL_ORDERS;
use haptic_document::parameters::{
    CAMPAIGN, DEVICE, DEVICE_MODEL, LESS_THAN_IDEAL, PUSH_BY, SAMPLE_TIME, SCHEME, TRIAL_DURATION,
    UNNAMED_PIECE,
};
use haptic_document::parameters::{Parameter, joined};
use haptic_document::{Failure, Table, parameters};
use haptic_judge::modelled_tissue::TissuePiece;
use haptic_judge::position_controller::PositionController;
use haptic_judge::preflight::WallContact;
use haptic_judge::settling::Criterion;
use haptic_judge::setup::{OF_FORCES, held_by};
use haptic_judge::tissue_table::linear_piece;
use haptic_judge::trial::{TRIAL_SAMPLES, TrialPlan, plan};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Newtons, Seconds};
use haptic_quantity::{digits, in_five_digits, written};
use haptic_tissue::Model;
use haptic_trial::Sensors;
use haptic_trial::device_table::{robot, samples_fit, without};
use haptic_trial::keys::trial::{CRITERION, IMPACT, PUSH, THRESHOLD, TRIAL_FORCE_LIMIT, WINDOW};
use haptic_trial::keys::wall::ONE_SIDED;
use haptic_trial::robot::RobotModel;
use serde::{Serialize, Serializer};
use std::path::PathBuf;
use std::sync::Arc;

parameters! {
    pub mod keys;
    ZWIDTH_ORDERS = list_of("orders", "0,0.5,1,1.5,2", WALL_ORDERS, "Orders of the dissipation, 0 to 2");
    ZWIDTH_POINTS = count("points", 21, "21", "Dissipations for each order, from 0 to the largest stable one");
}

/// Keys of `[zwidth]`, beside those of the device of a question.
pub const ZWIDTH: &[Parameter] = &joined::<21>(&[
    &[
        ZWIDTH_ORDERS,
        ZWIDTH_POINTS,
        ANALYSED_TISSUE,
        ANALYSED_CONTROLLER,
    ],
    UNNAMED_PIECE,
    &[CAMPAIGN, SCHEME, ONE_SIDED, PUSH, PUSH_BY, IMPACT],
    &[TRIAL_DURATION, WINDOW, CRITERION, THRESHOLD],
]);

/// A law that only grows as a whole.
#[derive(Clone, Debug)]
pub enum Growing {
    /// A specimen of a tissue, by its area.
    Specimen(TissuePiece),
    /// A controller, by its gain.
    Controller(Box<PositionController>),
}

/// A device at a port, as reports name it.
#[derive(Clone, Debug)]
pub struct AtPort {
    /// Its name, as on the command line.
    pub name: String,
    /// One line: its newtons were checked, or never.
    pub calibration: String,
}

/// A search for the stiffest wall of each order: device, walls and trials.
#[derive(Clone, Debug)]
pub struct ZWidth {
    /// The device with its imperfections; for a serial device only mass, damping and hand.
    pub device: MassDamperConfig,
    /// The robot in place of it all, of which `device` is the largest hand.
    pub robot: Option<Arc<RobotModel>>,
    /// The device that the analysis takes: for a serial device the model from its file.
    pub analysed: Option<MassDamperConfig>,
    /// Encoder resolution and noise of the position that the loop reads.
    pub sensors: Sensors,
    /// The linear wall that the theory assumes, or one that only pushes.
    pub contact: WallContact,
    /// Numerical scheme of the operator.
    pub scheme: Scheme,
    /// A law to grow, in place of walls.
    pub growing: Option<Growing>,
    /// Orders of the walls, 0 to 2.
    pub orders: Vec<Order>,
    /// Dissipations to try for each order, from 0 to the largest stable one.
    pub points: usize,
    /// Plan of the trial of each wall; on a serial device the force limit is at most the device's.
    pub plan: TrialPlan,
    /// The device at a port; `None` for the simulated one.
    pub at_port: Option<AtPort>,
    /// File of what a search on a serial device has found.
    pub campaign: Option<PathBuf>,
}

impl Growing {
    /// The law of the keys; `None` for walls.
    fn of(table: &Table<'_>) -> Result<Option<Self>, Failure> {
        if !table.text(&ANALYSED_CONTROLLER)?.is_empty() {
            let of_others = [&ANALYSED_TISSUE, &ZWIDTH_ORDERS, &ZWIDTH_POINTS, &SCHEME];
            law::without(table, &of_others, &ANALYSED_CONTROLLER)?;
            law::of_a_tissue_alone(table)?;
            for parameter in [&DEVICE, &ONE_SIDED] {
                if table.has(parameter) {
                    let reason =
                        "a controller is tried on the simulated device, and pulls too: omit it";
                    return Err(table.fail_at(parameter.key, reason).into());
                }
            }
            let controller = law::controller(table, table.number_if(&SAMPLE_TIME)?)?;
            return Ok(Some(Self::Controller(Box::new(controller))));
        }
        if table.text(&ANALYSED_TISSUE)?.is_empty() {
            law::of_a_tissue_alone(table)?;
            return Ok(None);
        }
        law::without(table, &[&ZWIDTH_ORDERS, &ZWIDTH_POINTS], &ANALYSED_TISSUE)?;
        Ok(Some(Self::Specimen(linear_piece(table)?)))
    }

    /// T, s, if the law brings one.
    fn sample_time_s(&self) -> Option<f64> {
        match self {
            Self::Specimen(_) => None,
            Self::Controller(controller) => Some(controller.setup.sample_time_s),
        }
    }

    fn order(&self) -> Order {
        match self {
            Self::Specimen(piece) => piece.material.order(),
            Self::Controller(controller) => controller.operator.order(),
        }
    }

    /// K, N/m, and B, N·s^μ/m, of a scale of 1.
    fn spring_and_damper(&self) -> (f64, f64) {
        match self {
            Self::Specimen(piece) => piece.spring_and_damper(),
            Self::Controller(controller) => (0.0, controller.setup.sample_time_s),
        }
    }
}

impl ZWidth {
    /// Plan of the trials as they are really tried: a serial device cannot be thrown.
    #[must_use]
    pub fn plan(&self) -> TrialPlan {
        match self.at_port {
            Some(_) => self.plan.starting_at_rest(),
            None => self.plan,
        }
    }

    /// Cells of the experiment, for a progress bar.
    pub fn cells(&self) -> u64 {
        (self.orders.len() * self.points) as u64
    }

    /// Reads and checks `[zwidth]`.
    ///
    /// # Errors
    /// A missing or wrong key, or trials that cannot be made: with file and line.
    pub fn of(table: &Table<'_>, at_port: Option<AtPort>) -> Result<Self, Failure> {
        let growing = Growing::of(table)?;
        let sample_time_s = growing.as_ref().and_then(Growing::sample_time_s);
        let mut bench = bench(table, sample_time_s)?;
        let analysed = (at_port.is_none() || table.has(&DEVICE_MODEL)).then_some(bench.plant);
        if at_port.is_some() {
            // It has its own, whatever its file says of them.
            let its_keys = LESS_THAN_IDEAL.iter().chain([&IMPACT]);
            let why = format!(
                "on a real device, which has its own and cannot be thrown: give {}",
                DEVICE.set_to("sim")
            );
            without(table, its_keys, &why)?;
            bench.plant = MassDamperConfig {
                friction: Newtons(0.0),
                delay: Seconds(0.0),
                current_lag: Seconds(0.0),
                ..bench.plant
            };
            bench.sensors = Sensors::NONE;
        } else {
            let why =
                format!("on the simulated device, whose search is short: give another {DEVICE}");
            without(table, [&CAMPAIGN], &why)?;
        }
        let sample_time_s = bench.plant.sample_time.0;
        let robot = robot(table, None, sample_time_s)?;
        let mut duration_s = table.number(&TRIAL_DURATION)?;
        if let Some(robot) = &robot {
            if let Some(key) = Self::idle_on_a_robot().find(|key| table.has(key)) {
                let reason = format!(
                    "{} has no effect on a robot, which a tap of push_n tries in each corner of its hands: omit it",
                    key.key
                );
                return Err(table.fail_at(key.key, reason).into());
            }
            if at_port.is_some() {
                let reason = "a robot is tried in virtual time, where nobody is pushed: omit it, and `run` the wall that was found on the robot";
                return Err(table.fail_at(DEVICE.key, reason).into());
            }
            bench.plant = held_by(robot, robot.place.hand([1; 3]));
            let given = table.number_if(&TRIAL_DURATION)?;
            duration_s = given.unwrap_or(RUN_S);
        }
        samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
        let (orders, points) = match &growing {
            Some(growing) => (vec![growing.order()], 1),
            None => {
                let points = table.count_in(&ZWIDTH_POINTS, 2..=1000)?;
                (orders(table, &ZWIDTH_ORDERS)?, points)
            }
        };
        let zwidth = Self {
            device: bench.plant,
            robot: robot.map(Arc::new),
            analysed,
            sensors: bench.sensors,
            contact: WallContact::of(table.flag(&ONE_SIDED)?),
            scheme: match &growing {
                Some(Growing::Controller(controller)) => controller.setup.scheme,
                Some(Growing::Specimen(_)) | None => scheme(table)?,
            },
            growing,
            orders,
            points,
            plan: plan(table, duration_s)?,
            at_port,
            campaign: table.file(&CAMPAIGN)?,
        };
        zwidth
            .check()
            .map_err(|error| table.fail(error.to_string()))?;
        Ok(zwidth)
    }

    /// Keys of another device than a robot, of another trial, or of another law than a wall that pulls too.
    fn idle_on_a_robot() -> impl Iterator<Item = &'static Parameter> {
        const OTHERS: [Parameter; 7] = [
            ANALYSED_TISSUE,
            ANALYSED_CONTROLLER,
            ONE_SIDED,
            WINDOW,
            CRITERION,
            THRESHOLD,
            TRIAL_FORCE_LIMIT,
        ];
        OF_FORCES.iter().chain(LESS_THAN_IDEAL).chain(&OTHERS)
    }

    /// The specimen in place of walls.
    fn piece(&self) -> Option<&TissuePiece> {
        match self.growing.as_ref()? {
            Growing::Specimen(piece) => Some(piece),
            Growing::Controller(_) => None,
        }
    }

    /// The controller in place of walls.
    fn controller(&self) -> Option<&PositionController> {
        match self.growing.as_ref()? {
            Growing::Specimen(_) => None,
            Growing::Controller(controller) => Some(controller),
        }
    }

    /// All that its points depend on; `whose` are identity and lasting limits of the device, which any port or name may lead to.
    fn in_full(&self, whose: &str) -> String {
        let asked = Self {
            analysed: None,
            at_port: None,
            campaign: None,
            ..self.clone()
        };
        format!("{whose} {asked:?}")
    }

    /// The model whose memory is the operator; `None` for D^μ.
    fn model(&self) -> Option<&Model> {
        self.piece()?.material.composed()
    }

    fn check(&self) -> Result<(), Failure> {
        check_orders(&self.orders, &ZWIDTH_ORDERS)?;
        self.plan().samples(self.device.sample_time).map(|_| ())
    }
}

/// The result. The keys are a contract of the command line.
#[derive(Debug, Serialize)]
pub struct ZWidthReport {
    /// The device by its name, `sim` for the simulated one.
    pub device: String,
    /// Its newtons were checked on this day, or never; none of the simulated one.
    pub calibration: Option<String>,
    /// Its mass, damping, hand and sample time.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// The hands of a robot, whose largest one with the tool is the device above; none of a device of forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hands: Option<Hands>,
    /// δ = bT/m of the device.
    pub delta: f64,
    /// The operator of the walls, as documents write it.
    pub scheme: String,
    /// Rule by which walls were judged.
    pub criterion: Criterion,
    /// Speed at which the device hit them, m/s.
    pub impact_m_per_s: f64,
    /// The force that pushes into the wall all the time, N.
    pub push_n: f64,
    /// Source of the push: with `device` one actuator rendered the wall and pushed into it.
    pub push_by: &'static str,
    /// Time in which the force of a device that pushes by itself rose, s: that of the search, or a longer one that is set on the device.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rise_time_s: Option<f64>,
    /// Largest α that was searched: a point this high is a bound of the search, not of the device.
    pub alpha_searched: f64,
    /// One entry per order, in the question's sequence.
    pub orders: Vec<OrderBoundary>,
    /// The tissue that was tried: stiffness and dissipation of its largest specimen are those of the only point.
    pub tissue: Option<String>,
    /// The controller that was tried.
    pub controller: Option<String>,
    /// Scales of the one or the other; left out if none came to rest.
    #[serde(flatten)]
    pub scales: Option<Scales>,
    /// Total number of trials, which explains the time taken.
    pub runs: u64,
    /// Points where trial and analysis disagree by more than 5 % of the wall.
    pub disagreements: usize,
    /// Why the search ended early; null if it did not. Its points are complete.
    #[serde(serialize_with = "in_words")]
    pub ended_early: Option<Failure>,
}

fn in_words<S: Serializer>(failure: &Option<Failure>, to: S) -> Result<S::Ok, S::Error> {
    failure.as_ref().map(ToString::to_string).serialize(to)
}

/// The boundary of one order.
#[derive(Clone, Debug, Serialize)]
pub struct OrderBoundary {
    /// μ of all walls of the boundary.
    pub order: f64,
    /// Unit of the dissipations of this order.
    pub dissipation_unit: &'static str,
    /// Unit of the largest stiffnesses, N/m for every order.
    pub stiffness_max_unit: &'static str,
    /// The largest stable stiffness for each dissipation; dissipations without one are omitted.
    pub boundary: Vec<BoundaryPoint>,
    /// Outline of the stable region by the analysis, as (β, α); empty if it has none.
    #[serde(skip)]
    pub outline: Vec<(f64, f64)>,
    /// The stiffness at α = 1, N/m, and the dissipation at β = 1, N·s^μ/m.
    #[serde(skip)]
    pub units: (f64, f64),
}

/// Least and largest hand of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hands {
    /// Mass without the tool, kg.
    pub mass_kg: [f64; 2],
    /// Least and largest damping, N·s/m.
    pub damping_n_s_per_m: [f64; 2],
    /// Least and largest stiffness, N/m.
    pub stiffness_n_per_m: [f64; 2],
}

/// Walls that a robot bears in its hands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InHands {
    /// Intervals of K, N/m, in which the robot comes to rest in every corner of its hands, by trial.
    pub stable_n_per_m: Vec<[f64; 2]>,
    /// Those that the analysis calls stable.
    pub analysis_stable_n_per_m: Vec<[f64; 2]>,
    /// K up to which every softer wall is proved for all hands, between the corners too; null if this dissipation alone is not.
    pub proved_up_to_n_per_m: Option<f64>,
}

/// Factors by which a specimen, as its area, or a controller, as its gain, may grow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scales {
    /// The largest at which the device came to rest.
    pub largest_scale: f64,
    /// The largest stable one by the analysis; null if it finds none.
    pub analysis_scale: Option<f64>,
    /// The least one of those up to it, where smaller ones are unstable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysis_scale_from: Option<f64>,
    /// The one up to which friction alone holds the device still; null as for a wall.
    pub held_by_friction_up_to_scale: Option<f64>,
}

/// One point of a boundary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundaryPoint {
    /// B of the wall, in the unit of its order.
    pub dissipation: f64,
    /// The largest K at which the device came to rest, N/m.
    pub stiffness_max: f64,
    /// K·T²/m, by which walls of any device compare.
    pub alpha: f64,
    /// B·T^(2−μ)/m.
    pub beta: f64,
    /// The largest stable K for this B by the analysis, N/m; null if it finds none.
    pub analysis_stiffness_n_per_m: Option<f64>,
    /// True if the analysis calls this wall (its K, or K and B together) stable made 5 % weaker and
    /// unstable made 5 % stronger; null if the search ended earlier, or the analysis does not cover
    /// such a device.
    pub analysis_agrees: Option<bool>,
    /// The K up to which friction alone holds the device still, N/m; null without friction, and if it holds
    /// nothing beyond `stiffness_max`.
    pub held_by_friction_up_to_n_per_m: Option<f64>,
    /// The largest stable K by a search on the simulated device without friction, N/m: of a real device beside the one before, if its
    /// device file is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated_without_friction_n_per_m: Option<f64>,
    /// All stable walls of a robot with this B; `None` for a device of forces.
    #[serde(flatten)]
    pub in_hands: Option<InHands>,
    /// Scales of a specimen or controller; `None` for a wall.
    #[serde(skip)]
    pub scales: Option<Scales>,
}

impl BoundaryPoint {
    /// The softest wall up to the stiffest one, if walls below it are not stable, N/m.
    pub fn stable_from_n_per_m(&self) -> Option<f64> {
        let [from, _] = *self.in_hands.as_ref()?.stable_n_per_m.last()?;
        (from > 0.0).then_some(from)
    }
}

/// A row of the table of a robot's stable walls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct IntervalRow {
    order: f64,
    dissipation_n_s_mu_per_m: f64,
    stable_from_n_per_m: f64,
    stable_to_n_per_m: f64,
    proved_up_to_n_per_m: Option<f64>,
}

/// A row of the table of all points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct BoundaryRow {
    order: f64,
    dissipation_n_s_mu_per_m: f64,
    stiffness_max_n_per_m: f64,
    alpha: f64,
    /// B·T^(2−μ)/m.
    beta: f64,
    analysis_stiffness_n_per_m: Option<f64>,
    held_by_friction_up_to_n_per_m: Option<f64>,
}

impl ZWidthReport {
    /// The stiffest wall of all, or the largest specimen, in words.
    pub fn stiffest(&self) -> String {
        let tissue = self.tissue.iter().map(|name| (name.clone(), "specimen"));
        let law = self.controller.iter();
        let controller = law.map(|law| (in_five_digits(law), "gain"));
        if let Some((name, what)) = tissue.chain(controller).next() {
            return match self.scales {
                Some(scales) => {
                    let scale = digits(scales.largest_scale, 4);
                    format!("{name}: up to {scale} times the {what}")
                }
                None => format!("{name}: no scale came to rest"),
            };
        }
        let points = self.orders.iter().flat_map(|order| {
            let points = order.boundary.iter();
            points.map(|point| (order.order, point))
        });
        let best = points.max_by(|a, b| a.1.stiffness_max.total_cmp(&b.1.stiffness_max));
        best.map_or_else(
            || "no wall came to rest".to_owned(),
            |(order, point)| {
                let words = |stiffness| written("stiffness_n_per_m", stiffness);
                let stiffness = words(point.stiffness_max);
                let known = point.simulated_without_friction_n_per_m;
                let known =
                    known.map(|known| format!(", simulated without friction {}", words(known)));
                match point
                    .held_by_friction_up_to_n_per_m
                    .filter(|_| self.device != "sim")
                {
                    None => {
                        let from = point.stable_from_n_per_m().map(words);
                        let from = from.map(|from| format!(", from {from} on"));
                        let from = from.unwrap_or_default();
                        format!("stiffest wall: K = {stiffness}, of order {order}{from}")
                    }
                    Some(held) => format!(
                        "held by friction: K = {stiffness} to {}, of order {order}{}",
                        words(held),
                        known.unwrap_or_default()
                    ),
                }
            },
        )
    }

    /// Says where search and analysis ended, or differ.
    pub fn warn(&self, warn: Warn<'_>) {
        if let Some(from) = self.scales.and_then(|scales| scales.analysis_scale_from) {
            warn(&format!(
                "by the analysis it is unstable with less gain too, below {} times",
                digits(from, 4)
            ));
        }
        let points = self.orders.iter().flat_map(|order| &order.boundary);
        let searched = self.alpha_searched;
        if points.clone().any(|point| point.alpha >= 0.999 * searched) {
            warn(&format!(
                "some walls were stable up to alpha = {searched}, where the search ends"
            ));
        }
        let held = |point: &&BoundaryPoint| point.held_by_friction_up_to_n_per_m.is_some();
        let held = points.clone().filter(held).count();
        if self.device != "sim" && held > 0 {
            warn(&format!(
                "held by friction at {held} of {} points, between stiffness_max and held_by_friction_up_to_n_per_m: no tap within the limits \
                 was large enough beside friction to tell, or steps of the encoder would shake it without friction; allow more force (and \
                 stuck_force), or give {DEVICE_MODEL} for the edge of the simulated device without friction",
                points.clone().count()
            ));
        }
        if let Some(rise_s) = self.rise_time_s.filter(|rise_s| *rise_s > 0.1) {
            warn(&format!(
                "the force rose in {rise_s} s, as the device is set: the search asks for 0.1 s, and taps after that time"
            ));
        }
        let mut analysed = points.clone().map(|point| point.analysis_stiffness_n_per_m);
        if self.device != "sim" && analysed.all(|found| found.is_none()) {
            warn(&format!(
                "the analysis needs the device's delay and lag: give {DEVICE_MODEL}, the file from host-cli device measure"
            ));
        }
        let parted = points.clone().filter(|point| {
            let stable = point.in_hands.as_ref().map(|walls| &walls.stable_n_per_m);
            stable.is_some_and(|stable| stable.len() > 1 || stable[0][0] > 0.0)
        });
        match parted.count() {
            0 => {}
            parted => warn(&format!(
                "softer walls than the stiffest one are not stable at {parted} of {} points, whose stable walls are the intervals of \
                 stable_n_per_m: a hand passes them on its way",
                points.clone().count()
            )),
        }
        if self.disagreements > 0 && self.hands.is_some() {
            warn(&format!(
                "trial and analysis differ by more than 5 % at an end of an interval at {} of {} points: the trial knows only its {TRIAL_DURATION}",
                self.disagreements,
                points.count()
            ));
        } else if self.disagreements > 0 {
            warn(&format!(
                "trial and analysis differ by more than 5 %, in K and in K and B together, at {} of {} points (analysis \
                 agrees: no): the analysis knows no friction, encoder, force limit or one-sided wall, the trial only its \
                 duration_s",
                self.disagreements,
                points.count().max(1)
            ));
        }
    }

    /// True if anything came to rest.
    #[must_use]
    pub fn has_found(&self) -> bool {
        self.scales.is_some() || self.rows().next().is_some()
    }

    /// Refuses a search that tried all and found nothing, as a design does.
    ///
    /// # Errors
    /// A search that tried all and found nothing.
    pub fn require(&self) -> Result<(), Failure> {
        if self.has_found() || self.ended_early.is_some() {
            return Ok(());
        }
        if self.hands.is_some() {
            return Err(Failure::run(format_args!(
                "{} in every hand: `analyze admittance` says how heavy the body must be; or {TRIAL_DURATION} is too short",
                self.stiffest()
            )));
        }
        Err(Failure::run(format_args!(
            "{}: it pushes the device away, or friction, the encoder or too short a {TRIAL_DURATION} keeps it from rest; change one of them",
            self.stiffest()
        )))
    }

    /// All stable intervals of a robot as rows of a table.
    pub fn interval_rows(&self) -> impl Iterator<Item = impl Serialize> {
        let points = self.orders.iter().flat_map(|order| {
            let points = order.boundary.iter();
            points.map(|point| (order.order, point))
        });
        points.flat_map(|(order, point)| {
            point.in_hands.iter().flat_map(move |walls| {
                let row = move |[from, to]: &[f64; 2]| IntervalRow {
                    order,
                    dissipation_n_s_mu_per_m: point.dissipation,
                    stable_from_n_per_m: *from,
                    stable_to_n_per_m: *to,
                    proved_up_to_n_per_m: walls.proved_up_to_n_per_m,
                };
                walls.stable_n_per_m.iter().map(row)
            })
        })
    }

    /// All points as rows of a table.
    pub fn rows(&self) -> impl Iterator<Item = impl Serialize> {
        self.orders.iter().flat_map(|order| {
            order.boundary.iter().map(|point| BoundaryRow {
                order: order.order,
                dissipation_n_s_mu_per_m: point.dissipation,
                stiffness_max_n_per_m: point.stiffness_max,
                alpha: point.alpha,
                beta: point.beta,
                analysis_stiffness_n_per_m: point.analysis_stiffness_n_per_m,
                held_by_friction_up_to_n_per_m: point.held_by_friction_up_to_n_per_m,
            })
        })
    }
}
