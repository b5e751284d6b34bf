//! `[wall]`: device, wall and trial.

use super::device::{remote, samples_fit, scheme, sensors};
use super::reader::{FileError, Table};
use super::safety::safety;
use crate::pushed::TRIAL_SAMPLES;
use crate::schedule::Pace;
use crate::{Criterion, CriterionName, TrialPlan, WallExperiment, parameters as p};
use fracdiff::{Order, Seconds};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre};

pub(super) fn wall(table: &Table<'_>) -> Result<WallExperiment, FileError> {
    let remote = remote(table)?;
    let sample_time_s = table.required(&p::WALL_SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let order = table.required(&p::ORDER)?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let device = MassDamperConfig {
        mass: Kilograms(table.required(&p::MASS)?),
        damping: NewtonSecondsPerMetre(table.required(&p::DAMPING)?),
        stiffness: NewtonsPerMetre(table.number(&p::HAND_STIFFNESS)?),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(table.number(&p::DELAY)?),
        friction: Newtons(table.number(&p::FRICTION)?),
        saturation: None,
        lag: Seconds(table.number(&p::CURRENT_LAG)?),
    };
    let plan = plan(table, duration_s)?;
    let wall = WallExperiment {
        device,
        sensors: sensors(table)?,
        order,
        scheme: scheme(table, order, sample_time_s, duration_s)?,
        stiffness_n_per_m: table.required(&p::STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.required(&p::DISSIPATION)?,
        one_sided: table.flag(&p::ONE_SIDED)?,
        plan,
        must_be_stable: table.flag(&p::MUST_BE_STABLE)?,
        force_rate_limit_n_per_s: table.number_if(&p::TRIAL_FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote,
        force_unstable: false,
    };
    wall.check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(wall)
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
