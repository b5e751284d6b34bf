//! Numbers outside their range, and names that nobody knows.

use super::all_refused;
use crate::process::{Place, words};

/// Value, range and option: what a user needs to mend it.
#[test]
fn an_order_outside_its_range_is_refused() {
    all_refused(
        2,
        "
        weights --order 3 => 3 | [-2, 2] | --order
        weights --order -2.5 => -2.5 | [-2, 2] | --order
        weights --order NaN => NaN | [-2, 2] | --order
        weights --order inf => inf | [-2, 2] | --order
        weights --order half => half | --order
        differintegrate --order 2.01 --sample-time 1ms file => 2.01 | [-2, 2] | --order
        ",
    );
}

#[test]
fn an_order_that_no_wall_has_is_refused_as_such() {
    let wall = "[0, 2], a wall has no integral: give --order within it";
    let walls = "[0, 2], a wall has no integral: give --orders within it";
    all_refused(
        2,
        &format!(
            "
            analyze stability --order 2.5 --alpha 0.1 --beta 0.1 => 2.5 | {wall}
            analyze environment --order -0.5 --stiffness 1 --dissipation 1 --sample-time 1ms => -0.5 | {wall}
            analyze coupling --order 2.5 --coupler-stiffness 1 --coupler-dissipation 2 --sample-time 1ms => 2.5 | {wall}
            zwidth --orders 0.5,2.5 => 2.5 | {walls}
            zwidth --orders -1 => -1 | {walls}
            design --mass 65g --orders 3 => 3 | {walls}
            "
        ),
    );
}

#[test]
fn a_number_in_a_refusal_has_six_digits() {
    // The last: all digits where fewer would look like the bound.
    all_refused(
        2,
        "
        weights --order 2.123456789 => order 2.12346 is not
        relax --strain 123456.789e3 => strain 1.23457e8 is not
        rt-check --duration 1e300 => duration 1e300 s is not
        rt-check --rate 1e300 => rate 1e300 Hz is not
        relax --strain 1.0000001 => strain 1.0000001 is not
        ",
    );
}

#[test]
fn a_count_or_a_list_that_is_none_is_refused_with_its_range() {
    all_refused(
        2,
        "
        zwidth --points 1e9 => points 1e9 | whole number from 2 to 1000 | --points
        zwidth --points= => points \"\" | from 2 to 1000
        weights --order 0.5 --count 1.5 => count 1.5 | --count
        relax --seed -1 => seed -1 | --seed
        materials export jelly --prony 101 => from 1 to 100
        design --orders= => '' | --orders | [0, 2] | as in 0,0.5,1
        zwidth --orders 0,x => 'x' | --orders | [0, 2]
        ",
    );
}

#[test]
fn the_unit_of_a_dissipation_is_explained() {
    let environment =
        "analyze environment --order 0.5 --stiffness 1 --sample-time 1ms --dissipation";
    for given in ["100Ns/m", "1e2N.s^0.5/m", "100 Ns/m"] {
        let mut arguments = words(environment);
        arguments.push(given);
        let ended = Place::new().run_arguments(&arguments, &[]);
        ended.refused(
            2,
            &[
                given,
                "N·s^μ/m",
                "follows from the order",
                "the number alone",
            ],
        );
    }
    let line = format!("{environment} soft");
    all_refused(2, &format!("{line} => soft | not a finite number"));
}

#[test]
fn a_sample_time_outside_its_range_is_refused() {
    all_refused(
        2,
        "
        relax --sample-time 0 => 0 s | --sample-time
        relax --sample-time 0s => 0 s | --sample-time
        relax --sample-time -1ms => - | --sample-time
        relax --sample-time -0.001 => -0.001 s | --sample-time
        relax --sample-time NaN => NaN | --sample-time
        relax --sample-time inf => inf | --sample-time
        relax --sample-time 1kg => 1kg | ms | --sample-time
        creep --sample-time 0 => 0 s | --sample-time
        differintegrate --order 0.5 --sample-time 0 file => 0 s | --sample-time
        differintegrate --order 0.5 --sample-time -1ms file => - | --sample-time
        differintegrate --order 0.5 --sample-time NaN file => NaN | --sample-time
        weights --order 0.5 --scheme full --sample-time 0 => 0 s | --sample-time
        ",
    );
}

#[test]
fn a_strain_or_stress_outside_its_range_is_refused() {
    all_refused(
        2,
        "
        relax --strain 0 => strain 0 | above 0 and at most 1 | --strain
        relax --strain 0% => strain 0 | above 0 and at most 1 | --strain
        relax --strain -0.05 => -0.05 | above 0 and at most 1 | --strain
        relax --strain -5% => -0.05 | above 0 and at most 1 | --strain
        relax --strain=-5% => -0.05 | above 0 and at most 1 | --strain
        relax --strain 200% => strain 2 | above 0 and at most 1 | --strain
        relax --strain NaN => NaN | --strain
        relax --strain 5mm => 5mm | % | --strain
        creep --stress 0 => 0 Pa | --stress
        creep --stress -100Pa => -100 | --stress
        creep --stress NaN => NaN | --stress
        ",
    );
}

#[test]
fn a_specimen_that_is_none_is_refused() {
    all_refused(
        2,
        "
        relax --thickness 0 => 0 m | --thickness
        relax --thickness -20mm => -0.02 m | --thickness
        relax --thickness=-20mm => -0.02 m | --thickness
        relax --thickness NaN => NaN | --thickness
        relax --area 0 => 0 m2 | --area
        relax --area -4cm2 => -0.0004 m2 | --area
        relax --area NaN => NaN | --area
        creep --thickness 0 => 0 m | --thickness
        ",
    );
}

#[test]
fn times_that_make_no_experiment_are_refused() {
    all_refused(
        2,
        "
        relax --duration 0 => 0 s | --duration
        relax --duration -1s => -1 | --duration
        relax --duration NaN => NaN | --duration
        relax --duration 5ms => 0.005 s | --duration
        relax --duration 1e9s => 1e9 s | --duration
        relax --ramp-time 0 => 0 s | --ramp-time
        relax --ramp-time 200s => 200 s | --ramp-time
        creep --duration 0 => 0 s | --duration
        ",
    );
}

#[test]
fn an_unknown_or_impossible_scheme_is_refused() {
    all_refused(
        2,
        "
        relax --scheme gruenwald:9 => gruenwald:9 | grunwald:N
        relax --scheme grunwald => grunwald | grunwald:N
        relax --scheme grunwald:0 => 0 | [1,  | --scheme
        relax --scheme grunwald:many => many | --scheme
        relax --scheme full:0 => 0 | [1e-11,  | --scheme
        relax --scheme full:NaN => NaN | --scheme
        relax --scheme exact => exact | analysis | full
        relax --scheme oustaloup:3:100:1 => 100 Hz | 1 Hz | 500 Hz
        relax --scheme oustaloup:3:1:1000 => 1000 Hz | 500 Hz
        weights --order 0.5 --scheme muir:0 => 0 | --scheme
        differintegrate --order 0.5 --sample-time 1ms --scheme spline file => spline | grunwald:N
        ",
    );
}

#[test]
fn an_unknown_tissue_is_refused_with_those_there_are() {
    let known = "jelly | prostate-cancerous | prostate-healthy";
    all_refused(
        2,
        &format!(
            "
            relax --tissue jelly => {known}
            creep --tissue jelly => {known}
            materials show jelly => {known}
            relax --tissue jelly.toml => jelly.toml
            relax --library nowhere => nowhere | folder
            materials list --library nowhere => nowhere | folder
            "
        ),
    );
}

#[test]
fn limits_and_sensors_outside_their_range_are_refused() {
    all_refused(
        2,
        "
        relax --force-limit 0 => 0 N | force limit
        relax --force-limit -1N => -1 N | force limit
        relax --force-limit NaN => NaN | --force-limit
        relax --force-rate-limit 0 => 0 N/s
        relax --sensor-noise -1um => -0.000001 m | noise
        relax --encoder-resolution -1um => -0.000001 m
        relax --seed -1 => -1 | --seed
        relax --out new/deep --force-limit 0 => force limit
        ",
    );
}
