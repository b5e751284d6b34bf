//! Keys that `[wall]` and `[coupler]` share: the device, and the plan of the trial.

use super::device::{samples_fit, sensors};
use super::reader::{FileError, Table};
use super::safety::safety;
use crate::pushed::TRIAL_SAMPLES;
use crate::remote::RemoteDevice;
use crate::{Criterion, CriterionName, TrialPlan, TrialSetup, parameters as p};
use fracdiff::Seconds;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};

/// Sample time and duration, s, of a run that is not too long.
pub(super) fn times(table: &Table<'_>) -> Result<(f64, f64), FileError> {
    let sample_time_s = table.required(&p::WALL_SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    Ok((sample_time_s, duration_s))
}

/// The device.
fn device(table: &Table<'_>, sample_time_s: f64) -> Result<MassDamperConfig, FileError> {
    Ok(MassDamperConfig {
        mass: Kilograms(table.required(&p::MASS)?),
        damping: NewtonSecondsPerMetre(table.required(&p::DAMPING)?),
        stiffness: NewtonsPerMetre(table.number(&p::HAND_STIFFNESS)?),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(table.number(&p::DELAY)?),
        friction: Newtons(table.number(&p::FRICTION)?),
        saturation: None,
        lag: Seconds(table.number(&p::CURRENT_LAG)?),
    })
}

/// Device, trial, safety and pace, but `must_be_stable`, which each table has by itself.
pub(super) fn setup(
    table: &Table<'_>,
    remote: Option<RemoteDevice>,
    (sample_time_s, duration_s): (f64, f64),
) -> Result<TrialSetup, FileError> {
    let device = device(table, sample_time_s)?;
    let plan = plan(table, duration_s)?;
    Ok(TrialSetup {
        force_rate_limit_n_per_s: table.number_if(&p::TRIAL_FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        remote,
        ..TrialSetup::new(device, sensors(table)?, plan)
    })
}

/// Reads the plan of a trial: how a wall is tried and judged.
fn plan(table: &Table<'_>, duration_s: f64) -> Result<TrialPlan, FileError> {
    let name = table.choice(&p::CRITERION)?;
    let threshold = table.number_if(&p::THRESHOLD)?;
    let (default, criterion) = match (name, threshold) {
        (CriterionName::Settling, Some(threshold)) => {
            let reason = format!(
                "threshold_m = {threshold} belongs to criterion = \"dissertation\": add that, or leave it out"
            );
            return Err(table.fail_at("threshold_m", reason));
        }
        (CriterionName::Settling, None) => (TrialPlan::DEFAULT, Criterion::Settling),
        (CriterionName::Dissertation, threshold) => {
            let threshold_m = threshold.unwrap_or(Criterion::DISSERTATION_THRESHOLD_M);
            let criterion = Criterion::Dissertation { threshold_m };
            (TrialPlan::DISSERTATION, criterion)
        }
    };
    let plan = TrialPlan {
        criterion,
        impact_m_per_s: table
            .number_if(&p::IMPACT)?
            .unwrap_or(default.impact_m_per_s),
        push_n: table.number(&p::PUSH)?,
        duration_s,
        window_s: table.number(&p::WINDOW)?,
        force_limit_n: table.number(&p::TRIAL_FORCE_LIMIT)?,
    };
    if plan.push_n >= plan.force_limit_n {
        let reason = format!(
            "push_n = {} is not below force_limit_n = {}: no wall could hold it",
            plan.push_n, plan.force_limit_n
        );
        return Err(table.fail_at("push_n", reason));
    }
    Ok(plan)
}
