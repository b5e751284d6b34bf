//! Keys that have an option, command by command: those that most runs change. Any other key is given as `KEY=VALUE`.

use haptic_experiment::parameters::{
    AREA, CONTACT, CONTROLLER, CREEP_DURATION, DAMPING, DELAY, DESIGN_ORDERS, DEVICE, DEVICE_MODEL,
    FORCE_NOISE_LIMIT, GAIN_MARGIN, GUARD, HAND_STIFFNESS, HELD, LOOP, MASS, MEASURE_BOX,
    MEASURE_DEVICE, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME, ONE_SIDED, PUSH,
    Parameter, RAMP_TIME, RELAX_DURATION, REQUIRE, SAMPLE_TIME, SCHEME, STRAIN, STRESS, THICKNESS,
    TISSUE, TRIAL_FORCE_LIMIT, WISH, WISH_FREQUENCY, WISH_TISSUE, ZWIDTH_ORDERS, ZWIDTH_POINTS,
};

/// A command whose options are made from tables of parameters.
pub trait Named {
    /// In the order of the help, in groups that several commands have.
    const OPTIONS: &'static [&'static [&'static Parameter]];
}

/// Of the rig that presses a tissue.
const RIG: &[&Parameter] = &[
    &AREA,
    &THICKNESS,
    &SCHEME,
    &SAMPLE_TIME,
    &CONTACT,
    &CONTROLLER,
    &DEVICE,
    &LOOP,
    &DEVICE_MODEL,
    &GUARD,
];

/// `relax`.
#[derive(Clone, Debug)]
pub struct Relax;

impl Named for Relax {
    const OPTIONS: &'static [&'static [&'static Parameter]] =
        &[&[&TISSUE, &STRAIN, &RAMP_TIME, &RELAX_DURATION], RIG];
}

/// `creep`.
#[derive(Clone, Debug)]
pub struct Creep;

impl Named for Creep {
    const OPTIONS: &'static [&'static [&'static Parameter]] =
        &[&[&TISSUE, &STRESS, &CREEP_DURATION], RIG];
}

/// `run`.
#[derive(Clone, Debug)]
pub struct Run;

impl Named for Run {
    const OPTIONS: &'static [&'static [&'static Parameter]] =
        &[&[&DEVICE, &LOOP, &DEVICE_MODEL, &GUARD, &CONTROLLER]];
}

/// `zwidth`.
#[derive(Clone, Debug)]
pub struct ZWidth;

impl Named for ZWidth {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[&[
        &ZWIDTH_ORDERS,
        &ZWIDTH_POINTS,
        &SCHEME,
        &DEVICE_MODEL,
        &MASS,
        &DAMPING,
        &HAND_STIFFNESS,
        &SAMPLE_TIME,
        &TRIAL_FORCE_LIMIT,
        &PUSH,
        &ONE_SIDED,
        &DEVICE,
        &LOOP,
    ]];
}

/// `design`.
#[derive(Clone, Debug)]
pub struct Design;

impl Named for Design {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[&[
        &WISH,
        &WISH_TISSUE,
        &WISH_FREQUENCY,
        &REQUIRE,
        &GAIN_MARGIN,
        &DESIGN_ORDERS,
        &SCHEME,
        &DEVICE_MODEL,
        &MASS,
        &DAMPING,
        &HAND_STIFFNESS,
        &SAMPLE_TIME,
        &DELAY,
        &TRIAL_FORCE_LIMIT,
        &FORCE_NOISE_LIMIT,
    ]];
}

/// `teleoperate`.
#[derive(Clone, Debug)]
pub struct Teleoperate;

impl Named for Teleoperate {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[];
}

/// `device measure`.
#[derive(Clone, Debug)]
pub struct Measure;

impl Named for Measure {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[&[
        &MEASURE_DEVICE,
        &MEASURE_FORCE_LIMIT,
        &MEASURE_BOX,
        &MEASURE_DURATION,
        &MEASURE_SAMPLE_TIME,
        &HELD,
        &DEVICE_MODEL,
        &MASS,
        &DAMPING,
    ]];
}
