//! Responses of a loop, and of a plant alone, to a step or a record.

use crate::{
    ControlError, ControllerSetup, HeldPlant, Plant, Response, SampledControlLoop,
    StabilityVerdict, StepShape, analysis::coarse,
};
use fracdiff::Seconds;

/// Largest number of samples of a run, which takes some seconds.
pub const SAMPLES_MOST: f64 = 2e6;
/// Default length of a run, in units of 1/ω of its crossover.
const LENGTH: f64 = 60.0;
/// Range of the default number of samples.
const SAMPLES: [f64; 2] = [200.0, 2e5];

/// The share of the reference by which the output may end away from it.
const AWAY: f64 = 0.05;

/// A disturbance by this factor slower than the run never ends.
const FOR_EVER: f64 = 1e-9;

/// A loop that was run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoopRun {
    /// Reference, output and command, one of each per sample.
    pub response: Response,
    /// Shape of a step; `None` for a record.
    pub shape: Option<StepShape>,
    /// The verdict, as a proof: a run of finite length cannot prove stability.
    pub verdict: StabilityVerdict,
    /// Factor of [`LoopAnalysis::coarse`](crate::analysis::LoopAnalysis::coarse).
    pub coarse: Option<f64>,
    /// Share of the samples with the command at a limit.
    pub limited_share: f64,
    /// False if output or command became NaN, or if the output is not where the loop brings it in the last
    /// tenth of the run, in which the reference stands: off by more than 5 % and what the loop leaves of a
    /// disturbance as slow as the run, |S|. `None` if the reference still moves.
    pub settles: Option<bool>,
    /// Settling as in `settles`, but at the reference itself, from which a loop without an integral stays away for ever:
    /// the allowance is less by |S| of an endless disturbance.
    pub at_reference: Option<bool>,
}

/// True if the output settles, and if it settles at the reference; `None` while the reference moves.
fn ends(closed: &SampledControlLoop, run: &Response) -> Option<[bool; 2]> {
    if !run
        .measured
        .iter()
        .chain(&run.command)
        .all(|value| value.is_finite())
    {
        return Some([false; 2]);
    }
    let (samples, last) = (run.reference.len(), *run.reference.last()?);
    let tail = samples - samples.div_ceil(10);
    let off = |values: &[f64]| {
        values[tail..]
            .iter()
            .map(|sample| (sample - last).abs())
            .fold(0.0, f64::max)
    };
    if off(&run.reference) > 0.0 {
        return None;
    }
    let size = run.reference.iter().map(|r| r.abs()).fold(0.0, f64::max);
    let left = |omega: f64| 1.0 / (1.0 + closed.open(omega)).norm();
    let slowest = 1.0 / samples as f64;
    let (left, for_ever) = (left(slowest), left(FOR_EVER * slowest));
    let allowed = [left, (left - for_ever).max(0.0)];
    Some(allowed.map(|left| off(&run.measured) <= (AWAY + left) * size))
}

/// Runs a loop from rest with this reference. `step` is the height of the reference, if it is a
/// step.
///
/// # Errors
/// A plant that does not run, parameters outside their range.
pub fn run(
    setup: &ControllerSetup,
    plant: &Plant,
    reference: &[f64],
    step: Option<f64>,
) -> Result<LoopRun, ControlError> {
    let plant = setup.sampled(plant)?;
    let response = setup.simulate(&plant, reference)?;
    let judged = setup.closed_with(&plant)?.judged();
    let ends = ends(&judged.closed, &response);
    Ok(LoopRun {
        shape: step.map(|height| response.shape_of_step(height)),
        verdict: judged.verdict,
        coarse: judged.of_rule().map(coarse),
        settles: ends.map(|ends| ends[0]),
        at_reference: ends.map(|ends| ends[1]),
        limited_share: limited_share(setup, &response),
        response,
    })
}

/// Share of the samples with the command at a limit.
#[must_use]
pub fn limited_share(setup: &ControllerSetup, run: &Response) -> f64 {
    let at = |limit: Option<f64>, u: f64| limit.is_some_and(|limit| (u - limit).abs() == 0.0);
    let limited = |u: &&f64| at(setup.output_low, **u) || at(setup.output_high, **u);
    let count = run.command.iter().filter(limited).count();
    count as f64 / run.command.len().max(1) as f64
}

/// The output of a plant alone for an input, from rest; of one that adds up, as a battery does the charge, too.
///
/// # Errors
/// A plant with a pole that grows, one that does not run.
pub fn run_plant(
    plant: &Plant,
    sample_time: Seconds,
    input: &[f64],
) -> Result<Response, ControlError> {
    if plant.unstable_poles() > 0 {
        plant.stable_by_itself()?;
    }
    let plant = HeldPlant::with_usual_memory(plant, sample_time)?;
    let mut state = plant.at_rest();
    Ok(Response {
        measured: input.iter().map(|u| plant.step(&mut state, *u)).collect(),
        command: input.to_vec(),
        reference: input.to_vec(),
    })
}

/// Samples in which a loop with this crossover settles.
#[must_use]
pub fn samples_for(crossover_rad_s: Option<f64>, sample_time_s: f64) -> f64 {
    let wanted = crossover_rad_s.map_or(SAMPLES[0], |omega| LENGTH / omega / sample_time_s);
    libm::round(wanted).clamp(SAMPLES[0], SAMPLES[1])
}
