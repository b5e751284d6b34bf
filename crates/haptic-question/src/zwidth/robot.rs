//! The search on a robot that moves, in virtual time: a robot may run away from soft walls and bear stiff ones, so nothing is bisected from one end.
//! ```text
//! K = 0, then 1 N/m to 1 MN/m, six a decade, and the middle of each interval that the analysis calls stable, or not; each change is bisected
//! ```
//! - *Trial*: a tap of `push_n` for 0.1 s in each corner of the hands, with a sensor without noise. Stable is a wall after which the velocity
//!   dies in all of them, however slowly: also one that the robot creeps into, and free space.
//! - *Analysis*: the intervals that are stable in all corners, and how far all softer walls are proved for all hands between them.
//! - *Cost*: one run a corner and wall, a hundred walls a dissipation.

use crate::analysis::RobotTap;
use crate::bench::{AskedDevice, last, units};
use crate::zwidth::search::{AGREES_WITHIN, HORIZON, dissipation_unit};
use crate::zwidth::{BoundaryPoint, Hands, InHands, OrderBoundary, ZWidth, ZWidthReport};
use fracdiff::Order;
use haptic_analysis::{
    AdmittanceBox, AdmittanceNumber, AdmittanceWorld, HandImpedance, LoopOperator,
};
use haptic_document::{Failure, Named as _};
use haptic_judge::modelled_tissue::loop_operator;
use haptic_loop::plant::SimulatedRobotConfig;
use haptic_loop::units::Newtons;
use haptic_trial::advice::analysed;
use haptic_trial::robot::{RobotInHands, RobotModel};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// Stiffest wall that is tried, N/m, and walls of a decade below it.
const STIFFEST: f64 = 1e6;
const DECADES: i32 = 6;
const PER_DECADE: i32 = 6;
/// Halvings of a way between two walls: within 0.1 % of the value found.
const HALVINGS: u32 = 9;
/// Dissipations of a decade and decades below the largest that is tried, whose force in a sample is that of the stiffest wall.
const DAMPERS: i32 = 3;
const DAMPER_DECADES: i32 = 8;

/// Falling values from `most` on, so many a decade, and 0.
fn falling(most: f64, decades: i32, per_decade: i32) -> impl Iterator<Item = f64> {
    let value = move |step: i32| most * libm::exp10(-f64::from(step) / f64::from(per_decade));
    (0..=decades * per_decade).map(value).chain([0.0])
}

/// The intersection of two lists of intervals.
fn both(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    let common = pairs.map(|(a, b)| [a[0].max(b[0]), a[1].min(b[1])]);
    common.filter(|[low, high]| low < high).collect()
}

/// The middle of each interval, and of each gap beside one.
fn middles(stable: &[[f64; 2]]) -> impl Iterator<Item = f64> {
    let ends = stable.iter().flatten().copied();
    let ends: Vec<f64> = [0.0].into_iter().chain(ends).chain([STIFFEST]).collect();
    let middle = |pair: &[f64]| {
        if pair[0] > 0.0 {
            libm::sqrt(pair[0] * pair[1])
        } else {
            0.5 * pair[1]
        }
    };
    let all: Vec<f64> = ends.windows(2).map(middle).collect();
    all.into_iter()
}

/// True if both have the same intervals, within a share of their ends.
fn agree(tried: &[[f64; 2]], analysed: &[[f64; 2]]) -> bool {
    let mut ends = tried.iter().flatten().zip(analysed.iter().flatten());
    tried.len() == analysed.len() && ends.all(|(a, b)| (a - b).abs() <= AGREES_WITHIN * b)
}

/// Walls of one order on a robot.
struct Walls<'a> {
    asked: &'a ZWidth,
    robot: &'a RobotModel,
    /// The robot with a sensor that has no noise and no end.
    place: RobotInHands,
    corners: Vec<HandImpedance>,
    order: Order,
    operator: LoopOperator,
    /// N/m of α = 1, and N·s^μ/m of β = 1.
    units: (f64, f64),
    /// The corner that did not bear the wall before: it is tried first.
    worst: AtomicUsize,
    runs: AtomicU64,
    stop: &'a AtomicBool,
}

impl<'a> Walls<'a> {
    fn new(
        asked: &'a ZWidth,
        robot: &'a RobotModel,
        order: Order,
        stop: &'a AtomicBool,
    ) -> Result<Self, Failure> {
        let t = asked.device.sample_time;
        let walls = Self {
            asked,
            robot,
            place: RobotInHands {
                simulated: SimulatedRobotConfig {
                    sensor_range: Newtons(1e9),
                    sensor_noise: Newtons(0.0),
                    ..robot.place.simulated
                },
                ..robot.place.clone()
            },
            corners: robot.place.corners().collect(),
            order,
            operator: loop_operator(None, asked.scheme, order, t, HORIZON)?,
            units: units(&asked.device, order),
            worst: AtomicUsize::new(0),
            runs: AtomicU64::new(0),
            stop,
        };
        // A wall that cannot be tried is refused before the search.
        walls.tap(0, [0.0; 2])?;
        Ok(walls)
    }

    /// True if the robot settles in this corner.
    fn tap(&self, corner: usize, gains: [f64; 2]) -> Result<bool, Failure> {
        let run = RobotTap {
            place: &self.place,
            hand: self.corners[corner],
            gains,
            order: self.order,
            scheme: self.asked.scheme,
            tap_n: self.asked.plan.push_n,
            duration_s: self.asked.plan.duration_s,
        };
        self.runs.fetch_add(1, Ordering::Relaxed);
        run.decays(&self.robot.body)
    }

    /// True if the robot settles in every corner. Whatever goes wrong on the way is not stable.
    fn settles(&self, gains: [f64; 2]) -> bool {
        let (first, count) = (self.worst.load(Ordering::Relaxed), self.corners.len());
        let mut corners = (0..count).map(|turn| (first + turn) % count);
        corners.all(|corner| {
            let settles =
                !self.stop.load(Ordering::Relaxed) && self.tap(corner, gains).unwrap_or(false);
            if !settles {
                self.worst.store(corner, Ordering::Relaxed);
            }
            settles
        })
    }

    /// The largest B with a wall that settles, of those that are tried; 0 if none does.
    fn largest_dissipation(&self) -> f64 {
        let t = self.asked.device.sample_time.0;
        let most = STIFFEST * libm::pow(t, self.order.get());
        let any = |dissipation: f64| {
            let mut walls = falling(STIFFEST, DECADES, PER_DECADE / 2);
            walls.any(|stiffness| self.settles([stiffness, dissipation]))
        };
        let mut above = most;
        for dissipation in falling(most, DAMPER_DECADES, DAMPERS) {
            if any(dissipation) {
                return last(dissipation, above, HALVINGS, any);
            }
            above = dissipation;
        }
        0.0
    }

    /// The intervals of K that settle with this B, with these further walls.
    fn tried(&self, dissipation: f64, more: impl Iterator<Item = f64>) -> Vec<[f64; 2]> {
        let mut walls: Vec<f64> = falling(STIFFEST, DECADES, PER_DECADE).chain(more).collect();
        walls.sort_by(f64::total_cmp);
        walls.dedup();
        let settles = |stiffness: f64| self.settles([stiffness, dissipation]);
        let mut stable: Vec<[f64; 2]> = Vec::new();
        let mut before: Option<(f64, bool)> = None;
        for wall in walls {
            let rests = settles(wall);
            let from = match before {
                Some((other, false)) if rests => Some(last(wall, other, HALVINGS, settles)),
                None if rests => Some(wall),
                _ => None,
            };
            stable.extend(from.map(|from| [from, wall]));
            if let (Some((other, true)), Some(newest)) = (before, stable.last_mut()) {
                newest[1] = if rests {
                    wall
                } else {
                    last(other, wall, HALVINGS, settles)
                };
            }
            before = Some((wall, rests));
        }
        stable
    }

    const fn world(&self, dissipation: f64) -> AdmittanceWorld<'_> {
        AdmittanceWorld {
            stiffness_n_per_m: 0.0,
            dissipation_n_s_mu_per_m: dissipation,
            operator: &self.operator,
            delay_samples: 0,
        }
    }

    /// The intervals of K that the analysis calls stable with this B in every corner.
    fn analysed(&self, dissipation: f64) -> Result<Vec<[f64; 2]>, Failure> {
        let whole = [0.0, STIFFEST];
        let body = &self.robot.body;
        self.corners.iter().try_fold(vec![whole], |all, hand| {
            let world = Some(self.world(dissipation));
            let subject = self.place.in_hand(body, *hand, world)?;
            let here = subject.stable_values(AdmittanceNumber::WorldStiffness, whole);
            Ok(both(&all, &here))
        })
    }

    /// K up to which every softer wall with this B is proved for all hands.
    fn proved(&self, dissipation: f64) -> Result<Option<f64>, Failure> {
        let (body, hand) = (&self.robot.body, self.place.hand([0; 3]));
        let subject = self
            .place
            .in_hand(body, hand, Some(self.world(dissipation)))?;
        let all = self.place.with_hands(AdmittanceBox::around(&subject))?;
        let proved = all.largest(AdmittanceNumber::WorldStiffness, STIFFEST);
        proved.map_err(analysed)
    }

    /// The point of this B; `None` if no wall settles, or the search has ended.
    fn point(&self, dissipation: f64) -> Result<Option<BoundaryPoint>, Failure> {
        let analysis_stable_n_per_m = self.analysed(dissipation)?;
        let stable_n_per_m = self.tried(dissipation, middles(&analysis_stable_n_per_m));
        let Some(&[_, stiffness_max]) = stable_n_per_m.last() else {
            return Ok(None);
        };
        if self.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        Ok(Some(BoundaryPoint {
            dissipation,
            stiffness_max,
            alpha: stiffness_max / self.units.0,
            beta: dissipation / self.units.1,
            analysis_stiffness_n_per_m: analysis_stable_n_per_m.last().map(|[_, to]| *to),
            analysis_agrees: Some(agree(&stable_n_per_m, &analysis_stable_n_per_m)),
            held_by_friction_up_to_n_per_m: None,
            simulated_without_friction_n_per_m: None,
            in_hands: Some(InHands {
                stable_n_per_m,
                analysis_stable_n_per_m,
                proved_up_to_n_per_m: self.proved(dissipation)?,
            }),
            scales: None,
        }))
    }

    fn boundary(
        &self,
        points: usize,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<OrderBoundary, Failure> {
        let most = self.largest_dissipation();
        let boundary = (0..points).into_par_iter().map(|point| {
            let found = self.point(most * point as f64 / (points - 1) as f64);
            progress(1);
            found
        });
        let boundary = boundary.collect::<Result<Vec<_>, Failure>>()?;
        Ok(OrderBoundary {
            order: self.order.get(),
            dissipation_unit: dissipation_unit(self.order),
            stiffness_max_unit: "N/m",
            boundary: boundary.into_iter().flatten().collect(),
            outline: Vec::new(),
            units: self.units,
        })
    }
}

impl ZWidth {
    /// Runs the search on a robot, in each corner of its hands.
    ///
    /// # Errors
    /// A robot that cannot be simulated or analysed.
    pub(super) fn searched_in_hands(
        &self,
        robot: &RobotModel,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
    ) -> Result<ZWidthReport, Failure> {
        let walls = (self.orders.iter()).map(|order| Walls::new(self, robot, *order, stop));
        let walls = walls.collect::<Result<Vec<_>, _>>()?;
        let orders = (walls.iter()).map(|walls| walls.boundary(self.points, progress));
        let orders = orders.collect::<Result<Vec<_>, _>>()?;
        let config = &self.device;
        let points = orders.iter().flat_map(|order| &order.boundary);
        let disagreements = points.filter(|point| point.analysis_agrees == Some(false));
        let [mass_kg, damping_n_s_per_m, stiffness_n_per_m] = robot.place.hands;
        Ok(ZWidthReport {
            disagreements: disagreements.count(),
            device: "sim".to_owned(),
            calibration: None,
            asked: AskedDevice::of(config),
            hands: Some(Hands {
                mass_kg,
                damping_n_s_per_m,
                stiffness_n_per_m,
            }),
            delta: config.damping.0 * config.sample_time.0 / config.mass.0,
            scheme: self.scheme.to_string(),
            criterion: self.plan.criterion,
            impact_m_per_s: 0.0,
            push_n: self.plan.push_n,
            push_by: self.plan.push_by.name(),
            rise_time_s: None,
            alpha_searched: STIFFEST * config.sample_time.0 * config.sample_time.0 / config.mass.0,
            tissue: None,
            controller: None,
            scales: None,
            runs: (walls.iter())
                .map(|walls| walls.runs.load(Ordering::Relaxed))
                .sum(),
            orders,
            ended_early: (stop.load(Ordering::Relaxed)).then(Failure::interrupted),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::BENCH;
    use crate::one_table::read;
    use crate::zwidth::ZWIDTH;
    use std::path::Path;

    /// Walls of order 1 on the robot of theory 39 in a hand of 1.5 kg, 20 N·s/m and 300 N/m, behind a body that is stable in free space.
    #[test]
    fn a_light_body_bears_soft_and_stiff_walls_and_none_between_as_theory_39_says() {
        let robot = "[admittance]\nbandwidth_hz = 10\ndead_time_s = 0.004\nforce_cutoff_hz = 30\nhand_mass_kg = 1.5\n\
            hand_damping_n_s_per_m = 20\nhand_stiffness_n_per_m = 300\n\
            body_order = 0.8\nbody_inertance_n_s_mu_per_m = 1.16\nbody_damping_n_s_per_m = 1\n";
        let robot = RobotModel::parse(Path::new("robot.toml"), robot, 2e-3).expect("a robot");
        let text = "[zwidth]\nsample_time_s = 2e-3\npoints = 2\norders = [1]\nduration_s = 10\n";
        let tables = [("Z-width", ZWIDTH), ("bench", BENCH)];
        let asked = read(text, ("zwidth", &tables), |table| ZWidth::of(table, None));
        let stop = AtomicBool::new(false);
        let walls = Walls::new(&asked, &robot, asked.orders[0], &stop).expect("walls");
        let point = walls.point(0.0).expect("answers").expect("stable walls");
        let walls = point.in_hands.as_ref().expect("walls in hands");
        let [soft, stiff] = walls.stable_n_per_m.as_slice() else {
            panic!("{walls:?}");
        };
        // Unstable from 230 N/m to 10 kN/m.
        let softest = soft[0].total_cmp(&0.0).is_eq();
        let ends = [soft[1] / 230.0, stiff[0] / 10e3];
        assert!(
            softest && ends.iter().all(|end| (end - 1.0).abs() < 0.05),
            "{walls:?}"
        );
        assert_eq!(point.analysis_agrees, Some(true), "{walls:?}");
        let proved = walls.proved_up_to_n_per_m.expect("free space is proved");
        assert!((0.95..1.05).contains(&(proved / soft[1])), "{proved}");
        assert_eq!(point.stable_from_n_per_m(), Some(stiff[0]));
    }
}
