//! Keys that have an option, command by command: those that most runs change. Any other key is given as `KEY=VALUE`.

use haptic_experiment::parameters::analysis;
use haptic_experiment::parameters::{
    AREA, CONTACT, CONTROLLER, CREEP_DURATION, DAMPING, DELAY, DESIGN_ORDERS, DEVICE, DEVICE_MODEL,
    FORCE_NOISE_LIMIT, GAIN_MARGIN, GUARD, HAND_STIFFNESS, HELD, LOOP, MASS, MEASURE_BOX,
    MEASURE_DEVICE, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME, ONE_SIDED, PUSH,
    Parameter, RAMP_TIME, RELAX_DURATION, REQUIRE, SAMPLE_TIME, SCHEME, STRAIN, STRESS, THICKNESS,
    TISSUE, TRIAL_FORCE_LIMIT, WISH, WISH_FREQUENCY, WISH_TISSUE, ZWIDTH_ORDERS, ZWIDTH_POINTS,
};

/// A command whose options are made from tables of parameters.
pub trait Named {
    /// In the order of the help, in groups. The first is what most runs change, and all that `-h` shows.
    const OPTIONS: &'static [&'static [&'static Parameter]];
}

/// Of the rig that presses a tissue.
const RIG: &[&Parameter] = &[
    &AREA,
    &THICKNESS,
    &CONTACT,
    &CONTROLLER,
    &LOOP,
    &DEVICE_MODEL,
    &GUARD,
];

/// `relax`.
#[derive(Clone, Debug)]
pub struct Relax;

impl Named for Relax {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[
        &[
            &TISSUE,
            &STRAIN,
            &RAMP_TIME,
            &RELAX_DURATION,
            &SCHEME,
            &SAMPLE_TIME,
            &DEVICE,
        ],
        RIG,
    ];
}

/// `creep`.
#[derive(Clone, Debug)]
pub struct Creep;

impl Named for Creep {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[
        &[
            &TISSUE,
            &STRESS,
            &CREEP_DURATION,
            &SCHEME,
            &SAMPLE_TIME,
            &DEVICE,
        ],
        RIG,
    ];
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

/// `analyze stability`, `stability-region` and `passivity`.
#[derive(Clone, Debug)]
pub struct Loop;

impl Named for Loop {
    const OPTIONS: &'static [&'static [&'static Parameter]] =
        &[analysis::LOOP, analysis::LOOP_WITHOUT_UNITS];
}

/// `analyze sensitivity`.
#[derive(Clone, Debug)]
pub struct Sensitivity;

impl Named for Sensitivity {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[
        analysis::LOOP,
        &[&analysis::SENSITIVITY_POINTS],
        analysis::LOOP_WITHOUT_UNITS,
    ];
}

/// `analyze environment`.
#[derive(Clone, Debug)]
pub struct Environment;

impl Named for Environment {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[analysis::ENVIRONMENT];
}

/// `analyze transparency`.
#[derive(Clone, Debug)]
pub struct Transparency;

impl Named for Transparency {
    const OPTIONS: &'static [&'static [&'static Parameter]] =
        &[analysis::ENVIRONMENT, analysis::TRANSPARENCY];
}

/// `analyze coupling`.
#[derive(Clone, Debug)]
pub struct Coupling;

impl Named for Coupling {
    const OPTIONS: &'static [&'static [&'static Parameter]] = &[analysis::COUPLING];
}

/// `analyze teleoperation`.
#[derive(Clone, Debug)]
pub struct Hands;

impl Named for Hands {
    const OPTIONS: &'static [&'static [&'static Parameter]] =
        &[analysis::HANDS, analysis::HANDS_ON];
}
