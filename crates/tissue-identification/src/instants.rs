//! Instants of the steps of a commanded stress, each anywhere between two rows, as a fitted number.
//! ```text
//! strain at x   Σ sₖ·J(x − tₖ)     tₖ uniform over the time between the last row before a step and the first behind it, of length wₖ
//! tₖ ← tₖ + dₖ,   d the least of ‖model + D·d − record‖² + Σ (σ(tₖ + dₖ − middle)/(wₖ/√12))²      Dₖ = −sₖ·J′(x − tₖ), a few times
//! left open:  Dₖ·(wₖ/√12)/σ, of which a sum with normal shares of deviation 1 is in the strain
//! ```
//! The columns are those of any doubt of a record: neither choice nor intervals of any model count an instant as known. J is that of the
//! [reference](super::reference) beside these columns, which takes no model for granted. J(t + d) has a positive spectrum too, so that it tells less than
//! a model of few parameters: once the instants have settled, the best model takes its place if its BIC is the less. A record too short for
//! a reference has the best model in each round. A uniform prior and a normal one of its deviation differ only where a record
//! says next to nothing about its instants, and then neither matters.
//!
//! *Cost*: a reference for each round, and one search of all models from few starts.

use super::elements::Candidate;
use super::fit::fit;
use super::options::{Options, candidates, target_of};
use super::record::{Record, digits};
use super::reference::Reference;
use super::search::search;
use fracdiff::parameter::Shown;
use haptic_tissue::Model;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

const ROUNDS: usize = 6;
/// Starts of a model that suffice to find an instant.
const STARTS: usize = 3;
/// Share of a time since a step over which the slope of J is taken.
const STEP: f64 = 1e-3;
/// Deviation of an instant that is known, over the time of the record.
const FIXED: f64 = 1e-9;
/// A move over the standard error of an instant that needs no further round.
const SETTLED: f64 = 0.1;

/// The source of J: the spectrum of the record, or its best model.
enum Answer<'a> {
    Spectrum(Box<Reference<'a>>),
    Model(Model),
}

impl Answer<'_> {
    fn creep(&self, times_s: &[f64]) -> Vec<f64> {
        match self {
            Self::Spectrum(spectrum) => spectrum.creep(times_s),
            Self::Model(model) => model.creep_compliances(times_s),
        }
    }
}

/// The record with its steps where they most likely were, and what of these instants is left open; as it is where nothing fits.
pub(super) fn found(record: &Record, options: &Options, stop: &AtomicBool) -> Record {
    let chosen = options.chosen.map(|kind| vec![kind]);
    let few = Options {
        candidates: chosen.unwrap_or_else(|| options.candidates.clone()),
        starts: options.starts.min(STARTS),
        bootstrap: 0,
        ..options.clone()
    };
    let ends: Vec<[f64; 2]> = record.instants().collect();
    let mut middle = record.clone();
    for (step, [early, late]) in middle.steps.iter_mut().zip(&ends) {
        step[0] = 0.5 * (early + late);
    }
    let any = |here: &Record| {
        let spectrum = Reference::of(&target_of(here, options, stop), None);
        let any = spectrum.map(|spectrum| Answer::Spectrum(Box::new(spectrum)));
        any.or_else(|| Some(Answer::Model(nearest(here, &few, stop)?.1)))
    };
    let Some((mut here, answer)) = settled(middle, &ends, &any, &few, stop) else {
        return record.clone();
    };
    if let Answer::Spectrum(spectrum) = &answer
        && let Some((bic, model)) = nearest(&here, &few, stop)
        && bic < spectrum.bic()
    {
        let model = |_: &Record| Some(Answer::Model(model.clone()));
        let last = settled(here.clone(), &ends, &model, &few, stop);
        here = last.map_or(here, |last| last.0);
    }
    let between = here.steps.iter().zip(&ends);
    let between = between.filter(|(_, ends)| ends[1] > ends[0]);
    let instants = between.map(|(step, _)| Shown(digits(step[0])).to_string());
    here.warnings.push(format!(
        "a step of the stress between two rows is taken where it most likely was, {} s after the row before the first step; choice and intervals know \
         how uncertain that is",
        instants.collect::<Vec<_>>().join(" and ")
    ));
    here
}

/// The record once its instants stay, and the answer beside them; `None` where nothing answers.
fn settled<'a>(
    mut here: Record,
    ends: &[[f64; 2]],
    answer: &dyn Fn(&Record) -> Option<Answer<'a>>,
    options: &Options,
    stop: &AtomicBool,
) -> Option<(Record, Answer<'a>)> {
    for round in 1.. {
        let answer = answer(&here)?;
        let moved = moved(&here, &answer, ends, options, stop)?;
        (here.bounded, here.expected) = (moved.open, moved.expected);
        let steps = here.steps.iter().zip(moved.moves).zip(ends);
        let steps = steps.map(|((step, [by_s, error_s]), [early, late])| {
            let to_s = (step[0] + by_s).clamp(*early, *late);
            let is_settled = (to_s - step[0]).abs() <= SETTLED * error_s;
            (is_settled, [to_s, step[1]])
        });
        let (are_settled, steps): (Vec<bool>, Vec<[f64; 2]>) = steps.unzip();
        if round == ROUNDS || !are_settled.contains(&false) {
            return Some((here, answer));
        }
        here.steps = steps;
    }
    None
}

/// BIC per sample and model of the best of these candidates, without a stiffening of its own.
pub(super) fn nearest(record: &Record, few: &Options, stop: &AtomicBool) -> Option<(f64, Model)> {
    let target = target_of(record, few, stop);
    let compressed = target.compressed();
    let candidates = candidates(few, record).ok()?;
    let fits = candidates.par_iter().filter_map(|&candidate: &Candidate| {
        let best = search(candidate, &compressed, few.starts.max(1)).ok()?;
        let fit = fit(candidate, &target, &best).0;
        Some((fit.bic / fit.predicted.len() as f64, fit.to_model().ok()?))
    });
    fits.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Instants about those of a record.
struct Moved {
    /// Move of each so that the least is left, s, and its standard error beside this answer.
    moves: Vec<[f64; 2]>,
    /// Columns of what is left open of them.
    open: Vec<Vec<f64>>,
    /// Residual of the middles between the rows, where the prior has its mean.
    expected: Vec<f64>,
}

/// The instants that leave the least of a record with this answer; `None` where it leaves nothing, or is 0.
fn moved(
    record: &Record,
    answer: &Answer<'_>,
    ends: &[[f64; 2]],
    options: &Options,
    stop: &AtomicBool,
) -> Option<Moved> {
    let mut plain = record.clone();
    (plain.bounded, plain.expected) = (Vec::new(), Vec::new());
    let target = target_of(&plain, options, stop);
    let chosen = target.chosen();
    let x: Vec<f64> = chosen.iter().map(|&n| record.x[n]).collect();
    let strain = |shift: f64, step: &[f64; 2]| -> Vec<f64> {
        let since = x.iter().map(|x| x - step[0]);
        let times: Vec<f64> = since
            .clone()
            .map(|t| t * (1.0 + shift))
            .filter(|t| *t > 0.0)
            .collect();
        let mut all = answer.creep(&times).into_iter();
        since
            .map(|t| {
                if t > 0.0 {
                    step[1] * all.next().unwrap_or_default()
                } else {
                    0.0
                }
            })
            .collect()
    };
    let parts: Vec<Vec<f64>> = record.steps.iter().map(|step| strain(0.0, step)).collect();
    let sum = |n: usize| parts.iter().map(|part| part[n]).sum::<f64>();
    let strains: Vec<f64> = (0..x.len()).map(sum).collect();
    // Units of a residual: a scale, or a share of the value.
    let unit = |n: usize| {
        if target.is_logarithmic() {
            strains[n].abs().max(f64::MIN_POSITIVE)
        } else {
            target.scale
        }
    };
    let slopes = record.steps.iter().map(|step| {
        let sides = [STEP, -STEP].map(|shift| strain(shift, step));
        let slope = |n: usize| {
            let since = x[n] - step[0];
            let by_s = (sides[1][n] - sides[0][n]) / (2.0 * STEP * since) / unit(n);
            if since > 0.0 { by_s } else { 0.0 }
        };
        (0..x.len()).map(slope).collect()
    });
    let slopes: Vec<Vec<f64>> = slopes.collect();
    let left = chosen.iter().zip(&strains).map(|(&n, strain)| {
        if target.is_logarithmic() {
            libm::log(record.first[n] / strain)
        } else {
            (record.first[n] - strain) / target.scale
        }
    });
    let weighed = |column: &[f64]| DVector::from_vec(target.through(column));
    let left = weighed(&left.collect::<Vec<f64>>());
    let columns: Vec<DVector<f64>> = slopes.iter().map(|slope| weighed(slope)).collect();
    let columns = DMatrix::from_columns(&columns);
    let deviation = |[early, late]: &[f64; 2]| (late - early) / libm::sqrt(12.0);
    let mut moves = DVector::zeros(ends.len());
    let (mut noise, mut errors) = (0.0, Vec::new());
    // The noise is what the moves leave, and holds them as far as the prior does.
    for _ in 0..3 {
        let rest = &left - &columns * &moves;
        noise = rest.norm() / libm::sqrt(rest.len() as f64);
        let mut normal = columns.tr_mul(&columns);
        let mut right = columns.tr_mul(&left);
        for (k, (ends, step)) in ends.iter().zip(&record.steps).enumerate() {
            let weight = noise / deviation(ends).max(FIXED * record.x[record.x.len() - 1]);
            normal[(k, k)] += weight * weight;
            right[k] += weight * weight * (0.5 * (ends[0] + ends[1]) - step[0]);
        }
        let parts = normal.cholesky()?;
        moves = parts.solve(&right);
        let spread = parts.inverse().diagonal();
        errors = spread.iter().map(|one| noise * libm::sqrt(*one)).collect();
    }
    let mut expected = vec![0.0; x.len()];
    for (slope, (ends, step)) in slopes.iter().zip(ends.iter().zip(&record.steps)) {
        let by_s = 0.5 * (ends[0] + ends[1]) - step[0];
        let pairs = expected.iter_mut().zip(slope);
        pairs.for_each(|(sum, slope)| *sum += by_s * slope);
    }
    let open = slopes
        .into_iter()
        .zip(ends)
        .filter(|(_, ends)| ends[1] > ends[0]);
    let open = open.map(|(slope, ends)| {
        let size = deviation(ends) / noise;
        slope.into_iter().map(|slope| size * slope).collect()
    });
    // Samples that are not compared have none.
    let whole = |values: Vec<f64>| {
        let mut all = vec![0.0; record.x.len()];
        for (&n, value) in chosen.iter().zip(values) {
            all[n] = value;
        }
        all
    };
    let open: Vec<Vec<f64>> = open.map(whole).collect();
    let mut all = moves.iter().chain(open.iter().flatten());
    let is_finite = all.all(|value| value.is_finite());
    is_finite.then(|| Moved {
        moves: moves
            .iter()
            .zip(errors)
            .map(|(by_s, error_s)| [*by_s, error_s])
            .collect(),
        open,
        expected: whole(expected),
    })
}
