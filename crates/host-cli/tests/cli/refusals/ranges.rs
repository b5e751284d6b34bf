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
    all_refused(
        2,
        &format!(
            "
            analyze stability --order 2.5 --alpha 0.1 --beta 0.1 => 2.5 | {wall}
            analyze environment --order -0.5 --stiffness 1 --dissipation 1 --sample-time 1ms => -0.5 | {wall}
            analyze coupling --order 2.5 --coupler-stiffness 1 --coupler-dissipation 2 --sample-time 1ms => 2.5 | {wall}
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
        relax --strain 123456.789e3 => strain = 1.23457e8 is not
        rt-check --duration 1e300 => duration 1e300 s is not
        rt-check --rate 1e300 => rate 1e300 Hz is not
        relax --strain 1.0000001 => strain = 1.0000001 is not
        ",
    );
}

#[test]
fn a_count_or_a_list_that_is_none_is_refused_with_its_range() {
    all_refused(
        2,
        "
        zwidth --points 1e9 => points 1000000000 | [2, 1000]
        zwidth --points= => --points | whole number
        weights --order 0.5 --count 1.5 => count 1.5 | --count
        relax seed=-1 => seed=-1 | whole number
        materials export jelly --prony 101 => from 1 to 100
        design --orders= => --orders | finite number
        zwidth --orders 0,x => --orders 0,x | \"x\" is not a number
        zwidth --orders 0,3 => --orders 0,3 | has 3 | from 0 to 2
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
        relax --sample-time -1ms => --sample-time -1ms: sample_time_s = -0.001 is not from 1e-9
        relax --sample-time NaN => NaN | --sample-time
        relax --sample-time 1kg => 1kg | ms | --sample-time
        differintegrate --order 0.5 --sample-time 0 file => 0 s | --sample-time
        differintegrate --order 0.5 --sample-time -1ms file => - | --sample-time
        differintegrate --order 0.5 --sample-time NaN file => NaN | --sample-time
        weights --order 0.5 --scheme full --sample-time 0 => 0 s | --sample-time
        ",
    );
}

#[test]
fn a_value_of_an_experiment_is_refused_in_the_words_in_which_it_was_given() {
    all_refused(
        2,
        "
        relax --strain 500% => --strain 500%: strain = 5 is not above 0 and at most 1 | omit it for 0.05
        relax --strain=-5% => --strain -5%: strain = -0.05 is not
        relax strain=5mm => strain=5mm | % | is not a number
        relax stress=5 => stress=5: unknown key `stress` in [relax] | did you mean `strain`
        relax strain => strain: is not KEY=VALUE
        relax --strain 4% strain=3% => strain=3%: strain is given twice, the other is --strain 4%
        relax --duration 0.5s => ramp_time_s = 1 is not below duration_s = 0.5
        relax safety.force_limit=1 => safety.force_limit=1: unknown key
        relax --out new/deep force_limit=-1N => force_limit=-1N: force_limit_n = -1 is not above 0
        relax safety.workspace_low=2mm workspace_high_m=0.001 => workspace_high_m=0.001 | is not above workspace_low_m = 0.002
        creep --stress NaN => NaN | --stress
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
            relax library=nowhere => nowhere | folder
            materials list --library nowhere => nowhere | folder
            "
        ),
    );
}
