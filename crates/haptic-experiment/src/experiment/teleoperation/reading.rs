//! `[teleoperation]`: devices, hand, motion, remote place, laws, line.

use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::reader::Table;
use crate::experiment::rendering::reading::piece;
use crate::experiment::teleoperation::keys::{
    AMPLITUDE, ARCHITECTURE, FREQUENCIES, HAND_COUPLER_DISSIPATION, HAND_COUPLER_ORDER,
    HAND_COUPLER_STIFFNESS, HAND_DAMPER, HAND_SPRING, HIGH, LINE_DELAY, LINE_DUPLICATION,
    LINE_JITTER, LINE_LOSS, LINE_SEED, LOW, MUST_BE_PASSIVE, PLACE, PLACE_DISSIPATION,
    PLACE_ONE_SIDED, PLACE_ORDER, PLACE_STIFFNESS, PLAYOUT, PRESS, SILENCE, SLAVE_DAMPING,
    SLAVE_MASS, TELEOPERATION_DURATION, TELEOPERATION_WINDOW, WAVE_IMPEDANCE,
};
use crate::experiment::teleoperation::{
    ArchitectureName, HandModel, HandMotion, PlaceName, RemotePlace, TeleoperationExperiment,
};
use crate::experiment::trial::keys::TRIAL_FORCE_RATE_LIMIT;
use crate::run::safety::safety;
use crate::run::schedule::Pace;
use fracdiff::{Order, Seconds};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
use haptic_teleoperation::{ChannelModel, CouplerGains, Settings};

pub(crate) fn teleoperation(table: &Table<'_>) -> Result<TeleoperationExperiment, FileError> {
    let t = Seconds(table.number(&p::SAMPLE_TIME)?);
    let (mass, damping) = (table.number(&p::MASS)?, table.number(&p::DAMPING)?);
    let device =
        |mass, damping| MassDamperConfig::ideal(Kilograms(mass), NewtonSecondsPerMetre(damping), t);
    let slave_mass = table.number_if(&SLAVE_MASS)?.unwrap_or(mass);
    let slave_damping = table.number_if(&SLAVE_DAMPING)?.unwrap_or(damping);
    let window_s = table.number(&TELEOPERATION_WINDOW)?;
    let architecture: ArchitectureName = table.choice(&ARCHITECTURE)?;
    let order = table.number(&HAND_COUPLER_ORDER)?;
    let scheme = table.text(&p::SCHEME)?.parse();
    let experiment = TeleoperationExperiment {
        master: device(mass, damping),
        slave: device(slave_mass, slave_damping),
        hand: HandModel {
            stiffness_n_per_m: table.number(&HAND_SPRING)?,
            damping_n_s_per_m: table.number(&HAND_DAMPER)?,
        },
        motion: motion(table, window_s)?,
        place: place(table)?,
        architecture: architecture.0,
        coupler: CouplerGains {
            stiffness_n_per_m: table.number(&HAND_COUPLER_STIFFNESS)?,
            dissipation_n_s_mu_per_m: table.number(&HAND_COUPLER_DISSIPATION)?,
        },
        order: Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?,
        wave_impedance_n_s_per_m: table.number(&WAVE_IMPEDANCE)?,
        playout_samples: playout(table, t)?,
        channel: ChannelModel {
            delay: Seconds(table.number(&LINE_DELAY)?),
            jitter: table.number(&LINE_JITTER)?,
            loss: table.number(&LINE_LOSS)?,
            duplication: table.number(&LINE_DUPLICATION)?,
        },
        seed: table.count(&LINE_SEED)?,
        silence_s: table.number(&SILENCE)?,
        scheme: scheme
            .map_err(|error: fracdiff::SchemeError| table.fail_at("scheme", error.to_string()))?,
        duration_s: table.number(&TELEOPERATION_DURATION)?,
        window_s,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        must_be_passive: table.flag(&MUST_BE_PASSIVE)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        force_unstable: false,
    };
    experiment
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(experiment)
}

fn motion(table: &Table<'_>, window_s: f64) -> Result<HandMotion, FileError> {
    let (low, high) = (table.number(&LOW)?, table.number(&HIGH)?);
    if low > high {
        let reason = format!("low_hz = {low} is above high_hz = {high}");
        return Err(table.fail_at("low_hz", reason));
    }
    let count = table.count(&FREQUENCIES)?;
    if !(1..=100).contains(&count) {
        let reason = format!("frequencies = {count} is not in [1, 100]");
        return Err(table.fail_at("frequencies", reason));
    }
    Ok(HandMotion {
        press_m: table.number(&PRESS)?,
        amplitude_m: table.number(&AMPLITUDE)?,
        frequencies_hz: HandMotion::frequencies(low, high, count, window_s),
    })
}

fn place(table: &Table<'_>) -> Result<RemotePlace, FileError> {
    match table.choice(&PLACE)? {
        PlaceName::Tissue => Ok(RemotePlace::Tissue(piece(table)?)),
        PlaceName::Wall => {
            let order = Order::new(table.number(&PLACE_ORDER)?);
            Ok(RemotePlace::Wall {
                stiffness_n_per_m: table.number(&PLACE_STIFFNESS)?,
                dissipation_n_s_mu_per_m: table.number(&PLACE_DISSIPATION)?,
                order: order.map_err(|error| table.fail_at("wall_order", error.to_string()))?,
                one_sided: table.flag(&PLACE_ONE_SIDED)?,
            })
        }
    }
}

fn playout(table: &Table<'_>, t: Seconds) -> Result<Option<u32>, FileError> {
    let Some(time) = table.number_if(&PLAYOUT)? else {
        return Ok(None);
    };
    let samples = 1.0 + (time / t.0).round();
    if samples > f64::from(Settings::PLAYOUT_MOST) {
        let most = f64::from(Settings::PLAYOUT_MOST - 1) * t.0;
        let reason = format!("playout_s = {time} is more than {most} s: take a shorter one");
        return Err(table.fail_at("playout_s", reason));
    }
    Ok(Some(samples as u32))
}
