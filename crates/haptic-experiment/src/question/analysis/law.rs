//! The law that is analysed: a wall K + B·D^μ, or a piece of tissue, which has a K, a B and a memory too.

use super::answer::{HORIZON, operator};
use super::keys::{ANALYSED_SAMPLE_TIME, ANALYSED_SCHEME, ANALYSED_TISSUE, JUDGED_DEPTH};
use crate::document::failure::Failure;
use crate::document::parameters::{SCHEME, UNNAMED_PIECE};
use crate::document::reader::Table;
use crate::experiment::reading::{fits, piece};
use crate::experiment::wall::{DISSIPATION, ORDER, STIFFNESS};
use crate::judge::modelled_tissue::TissuePiece;
use crate::judge::preflight::Matter;
use fracdiff::num_complex::Complex;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::LoopOperator;
use haptic_quantity::digits;
use haptic_tissue::{Model, SampledModel};
use serde_json::{Value, json};

/// f = −(K·x + B·T^(−μ)·P(w)·x), for small motions at one depth.
#[derive(Clone, Debug)]
pub(super) struct Law {
    /// K, N/m, if it was given.
    pub(super) stiffness: Option<f64>,
    /// B, N·s^μ/m, if it was given.
    pub(super) dissipation: Option<f64>,
    pub(super) order: Order,
    pub(super) scheme: Scheme,
    pub(super) operator: LoopOperator,
    pub(super) tissue: Option<JudgedTissue>,
}

/// A piece of tissue at the depth where it is judged.
#[derive(Clone, Debug)]
pub(super) struct JudgedTissue {
    matter: Matter,
    depth_m: Option<f64>,
    /// Slope of its map of depth there, without unit.
    slope: f64,
    /// True if its memory is that of several elements, not D^μ.
    pub(super) is_composed: bool,
}

impl Law {
    pub(super) fn of(table: &Table<'_>, sample_time_s: Option<f64>) -> Result<Self, Failure> {
        if !table.text(&ANALYSED_TISSUE)?.is_empty() {
            let t = table.required(&ANALYSED_SAMPLE_TIME)?;
            return Self::of_tissue(table, piece(table)?, Seconds(t));
        }
        for parameter in UNNAMED_PIECE.iter().chain([&JUDGED_DEPTH]) {
            if table.has(parameter) {
                let reason = format!("it belongs to a tissue: give {ANALYSED_TISSUE}, or omit it");
                return Err(table.fail_at(parameter.key, reason).into());
            }
        }
        let order = table.order(&ORDER)?;
        let (scheme, operator) = operator(table, order, sample_time_s)?;
        Ok(Self {
            stiffness: table.number_if(&STIFFNESS)?,
            dissipation: table.number_if(&DISSIPATION)?,
            order,
            scheme,
            operator,
            tissue: None,
        })
    }

    fn of_tissue(table: &Table<'_>, piece: TissuePiece, t: Seconds) -> Result<Self, Failure> {
        for parameter in [&STIFFNESS, &DISSIPATION, &ORDER] {
            if table.has(parameter) {
                let reason = format!("{ANALYSED_TISSUE} has one of its own: omit it");
                return Err(table.fail_at(parameter.key, reason).into());
            }
        }
        let is_composed = piece.material.composed().is_some();
        let scheme = match is_composed && !table.has(&ANALYSED_SCHEME) {
            true => table.scheme(&SCHEME)?,
            false => table.scheme(&ANALYSED_SCHEME)?,
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
            operator: match (judged.model, scheme) {
                // No loop runs one: it is analysed for comparison.
                (Some(model), Scheme::Grunwald { length }) => short_memory(model, t, length)?,
                _ => judged.loop_operator()?,
            },
            tissue: Some(JudgedTissue {
                depth_m,
                slope: judged.map.map_or(1.0, |(_, slope)| slope),
                is_composed,
                matter,
            }),
        })
    }

    /// The tissue as a report repeats it; nothing of a wall.
    pub(super) fn tissue_result(&self) -> Value {
        self.tissue.as_ref().map_or(
            json!({}),
            |tissue| json!({"tissue": tissue.matter.words(), "depth_m": tissue.depth_m}),
        )
    }

    /// Its name, or scheme and order, in the words below a picture.
    pub(super) fn words(&self) -> Vec<String> {
        let tissue = self.tissue.as_ref().map(|tissue| tissue.matter.words());
        let order = tissue.unwrap_or_else(|| format!("order μ = {}", digits(self.order.get(), 4)));
        vec![order, format!("scheme {}", self.scheme)]
    }
}

fn short_memory(model: &Model, t: Seconds, length: usize) -> Result<LoopOperator, Failure> {
    let sampled = SampledModel::new(model, t).map_err(Failure::input)?;
    let [above, below] = sampled.short_memory(length).map_err(Failure::input)?;
    LoopOperator::from_quotient(sampled.order(), above, below).map_err(Failure::input)
}

impl JudgedTissue {
    /// Force per displacement without sampling, N/m.
    pub(super) fn stiffness(&self, omega_rad_s: f64) -> Complex<f64> {
        self.matter.stiffness(omega_rad_s) * self.slope
    }
}
