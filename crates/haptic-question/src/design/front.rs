//! The front: walls that no other wall beats in everything at once.
//!
//! ```text
//! directions  (α, β) = (cos φ·α_max, sin φ·β_max) of each order, 24 angles φ from 0 to below π/2; α_max and β_max of its stable region
//! sizes       the largest that requirement and limit of noise allow, and eight smaller ones by √2 each
//! kept        stiffness Re H and damping Im H/ω at a frequency, gain margin, noise of the force: no other wall is at least as
//!             good in all of them and better in one
//! ```
//! - *The margin* is the least factor by which a wall as a whole may grow, or shrink, before it is unstable; up to 17 times the least.
//! - *Ideal sensors* make no noise, which is not compared then.
//! - *Nothing is tried*: experiment files of a designed wall are; these are numbers of the analysis, from which a wall is chosen.
//! - *Cost*: the margins of 24 walls an order, since those of a smaller wall are in proportion.

use crate::bench::{AskedDevice, for_each_order, unbeaten};
use crate::design::bench::Bench;
use crate::design::{WallDesign, nothing_found};
use fracdiff::Order;
use haptic_analysis::AnalysisError;
use haptic_document::Failure;
use haptic_trial::Imperfections;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, SQRT_2, TAU};
use std::sync::atomic::AtomicBool;

const DIRECTIONS: u32 = 24;
const SIZES: i32 = 9;
/// Largest gain margin in the least: a wall that is weaker still is no choice.
const MARGINS: f64 = 17.0;

/// A question for the front: requirement, device, orders and scheme of a design.
#[derive(Clone, Debug)]
pub struct Front {
    /// Requirement, device, orders and scheme.
    pub design: WallDesign,
    /// Frequency at which stiffness and damping are compared, Hz.
    pub frequency_hz: f64,
}

/// A wall of the front.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrontWall {
    /// Order μ of its dissipation.
    pub order: f64,
    /// K of the wall, N/m.
    pub stiffness_n_per_m: f64,
    /// B of the wall, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// Factor by which the wall as a whole may grow or shrink until it is unstable.
    pub margin: f64,
    /// Re H at the frequency.
    pub effective_stiffness_n_per_m: f64,
    /// Im H/ω at the frequency.
    pub effective_damping_n_s_per_m: f64,
    /// Force noise that encoder steps and sensor noise cause, rms N; null for ideal sensors.
    pub force_noise_rms_n: Option<f64>,
    /// The device damping that passivity requires.
    pub required_damping_n_s_per_m: f64,
}

/// The front. The keys are a contract of the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontReport {
    /// Mass, damping, hand and sample time of the device.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// Imperfections of the device, as far as they were given.
    pub imperfections: Imperfections,
    /// `stable` or `passive`.
    pub require: &'static str,
    /// The least gain margin; null if passivity was required.
    pub gain_margin: Option<f64>,
    /// Frequency at which stiffness and damping are compared.
    pub frequency_hz: f64,
    /// The scheme of the operator.
    pub scheme: String,
    /// The limit on the noise of the force, if one was given.
    pub force_noise_limit_n: Option<f64>,
    /// Number of walls that were compared.
    pub compared: usize,
    /// Those that none beats, by order and stiffness.
    pub walls: Vec<FrontWall>,
}

impl FrontReport {
    ///
    /// # Errors
    /// No wall that meets the requirement.
    pub fn require(&self) -> Result<(), Failure> {
        if self.walls.is_empty() {
            Err(nothing_found(Some(&format!(
                "no wall of these orders is {}",
                self.require
            ))))
        } else {
            Ok(())
        }
    }
}

impl Front {
    /// Answers it; `progress` hears of each order that is done, `stop` ends it before the next.
    ///
    /// # Errors
    /// A design that was stopped, or a loop that cannot be analysed.
    pub fn answer(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<FrontReport, Failure> {
        let design = &self.design;
        let walls = for_each_order(&design.orders, stop, progress, |order| self.walls(order))?;
        let walls = walls.concat();
        // Walls of order 0 are one spring however it is parted.
        let kept = unbeaten(&walls, |wall| {
            let quiet = -wall.force_noise_rms_n.unwrap_or(0.0);
            [
                wall.effective_stiffness_n_per_m,
                wall.effective_damping_n_s_per_m,
                wall.margin,
                quiet,
            ]
        });
        let mut kept: Vec<FrontWall> = kept.into_iter().map(|n| walls[n]).collect();
        kept.sort_by(|a, b| {
            let key = |wall: &FrontWall| (wall.order, wall.stiffness_n_per_m);
            key(a)
                .partial_cmp(&key(b))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        Ok(FrontReport {
            asked: AskedDevice::of(&design.device.plant),
            imperfections: design.device.imperfections(),
            require: match design.gain_margin {
                None => "passive",
                Some(_) => "stable",
            },
            gain_margin: design.gain_margin,
            frequency_hz: self.frequency_hz,
            scheme: design.scheme.to_string(),
            force_noise_limit_n: design.force_noise_limit_n,
            compared: walls.len(),
            walls: kept,
        })
    }

    /// All walls of an order that meet the requirement; none of one that cannot be analysed.
    fn walls(&self, order: Order) -> Result<Vec<FrontWall>, Failure> {
        let bench = Bench::new(&self.design, order)?;
        let Ok(Some([alpha, beta])) = bench.largest_parts() else {
            return Ok(Vec::new());
        };
        let walls = (0..DIRECTIONS).flat_map(|step| {
            let (sin, cos) = libm::sincos(FRAC_PI_2 * f64::from(step) / f64::from(DIRECTIONS));
            self.along(&bench, [cos * alpha, sin * beta])
                .unwrap_or_default()
        });
        Ok(walls.collect())
    }

    /// The walls of one direction.
    fn along(
        &self,
        bench: &Bench<'_>,
        [alpha, beta]: [f64; 2],
    ) -> Result<Vec<FrontWall>, AnalysisError> {
        let Some((low, high)) = bench.stable_scales(alpha, beta)? else {
            return Ok(Vec::new());
        };
        let Some(largest) = bench.scale_within(Some(high), alpha, beta)? else {
            return Ok(Vec::new());
        };
        let largest = largest.min(bench.largest_quiet_scale(alpha, beta));
        let (_, required) = bench.required(alpha, beta)?;
        let least = self.design.gain_margin.unwrap_or(1.0);
        let mut walls = Vec::new();
        for size in 0..SIZES {
            let scale = largest * libm::pow(SQRT_2, f64::from(-size));
            let (alpha, beta) = (scale * alpha, scale * beta);
            let margin = low.map_or(f64::INFINITY, |low| scale / low);
            let margin = margin.min(high / scale);
            let noise_n = bench.force_noise_n(alpha, beta);
            if margin < least || margin > MARGINS * least {
                continue;
            }
            let felt = bench.felt(alpha, beta, TAU * self.frequency_hz)?;
            let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = bench.law(alpha, beta);
            walls.push(FrontWall {
                order: bench.order.get(),
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                margin,
                effective_stiffness_n_per_m: felt.stiffness_n_per_m,
                effective_damping_n_s_per_m: felt.damping_n_s_per_m,
                force_noise_rms_n: noise_n.filter(|_| !self.design.device.sensors.are_ideal()),
                required_damping_n_s_per_m: scale * required,
            });
        }
        Ok(walls)
    }
}
