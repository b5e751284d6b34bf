//! A configuration takes effect as a whole, or not at all.

use crate::line::{Bench, START, beyond, spring, transaction};
use fracdiff::{PortableOperator, portable::Form};
use haptic_link::{
    Configuration, DeviceReport, EventKind, Field, OperatorForm, OperatorShape, Refusal, Request,
};
use haptic_loop::{Contact, DepthMap, Environment, SpringDamper, units::Metres};
use testkit::Tested;

#[test]
fn a_configuration_takes_effect_as_a_whole_and_reads_back() {
    let values: Vec<f32> = (0..40).map(|n| 1.0 / (1.0 + n as f32)).collect();
    let (mut configuration, _) = spring();
    configuration.operator.count = 40;
    let mut bench = Bench::configured(configuration, &values);
    let DeviceReport::Configuration {
        configuration: have,
        ..
    } = bench.done(Request::GetConfiguration)
    else {
        panic!("no configuration");
    };
    assert_eq!(have, configuration);
    let mut back = Vec::new();
    for offset in [0, 16, 32] {
        let DeviceReport::Coefficients(block) = bench.done(Request::GetCoefficients { offset })
        else {
            panic!("no coefficients");
        };
        back.extend(block.values);
    }
    assert_eq!(back[..40], values);
    assert!(back[40..].iter().all(|&value| value == 0.0));
    assert_eq!(bench.events(), [EventKind::Configured]);
}

#[test]
fn a_transaction_that_is_not_whole_changes_nothing() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (configuration, values) = spring();
    let before = bench.done(Request::GetConfiguration);
    let commit = Request::Commit {
        digest: 1,
        scope: haptic_link::Scope::Lasting,
    };
    assert_eq!(bench.refused(commit.clone()), Refusal::Incomplete);
    for request in transaction(configuration, &[]) {
        bench.done(request);
    }
    assert_eq!(bench.refused(commit.clone()), Refusal::Incomplete);
    for request in transaction(configuration, &values) {
        bench.done(request);
    }
    assert_eq!(bench.refused(commit), Refusal::Digest);
    assert_eq!(bench.done(Request::GetConfiguration), before);
}

#[test]
fn parameters_beyond_the_limits_of_the_device_are_refused_by_name() {
    type Change = fn(&mut Configuration);
    let cases: [(Field, Change); 13] = [
        (Field::TickPeriod, |c| c.tick_period_us = 20),
        (Field::TickPeriod, |c| c.tick_period_us = 1_000_000),
        (Field::Stiffness, |c| c.stiffness_n_per_m = -1.0),
        (Field::Stiffness, |c| c.stiffness_n_per_m = f32::NAN),
        (Field::Dissipation, |c| {
            c.dissipation_n_s_mu_per_m = f32::INFINITY;
        }),
        (Field::Surface, |c| c.surface_m = f32::NAN),
        (Field::IntegerPart, |c| c.operator.integer = 1),
        (Field::ForceLimit, |c| c.limits.force_n = 1000.0),
        (Field::ForceLimit, |c| c.limits.force_n = 0.0),
        (Field::ForceRateLimit, |c| {
            c.limits.force_rate_n_per_s = f32::NAN;
        }),
        (Field::Watchdog, |c| c.limits.watchdog_ms = 4),
        (Field::Watchdog, |c| c.limits.watchdog_ms = 1001),
        (Field::Mass, |c| c.simulation.mass_kg = 0.0),
    ];
    let mut bench = Bench::ideal();
    bench.hello();
    for (field, change) in cases {
        let (mut configuration, values) = spring();
        change(&mut configuration);
        let answer = bench.set(configuration, &values);
        assert_eq!(beyond(&answer), Some(field), "{answer:?}");
    }
    assert_eq!(
        bench.done(Request::GetConfiguration),
        Bench::ideal_configuration()
    );
}

#[test]
fn coefficients_that_no_operator_has_are_refused_by_name() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (configuration, values) = spring();
    let mut many = configuration;
    many.operator.count = 300;
    for (configuration, values, want) in [
        (many, values, Field::CoefficientCount),
        (configuration, [1.0, f32::NAN], Field::Coefficient),
    ] {
        let answer = bench.set(configuration, &values);
        assert_eq!(beyond(&answer), Some(want), "{answer:?}");
    }
    // A decay of 1.5 lies outside the range that the refusal names.
    let (mut configuration, _) = spring();
    configuration.operator = OperatorShape {
        form: OperatorForm::Modes,
        integer: 0,
        count: 18,
    };
    let mut values = [1.0; 18];
    values[16] = 1.5;
    let answer = bench.set(configuration, &values);
    assert_eq!(
        answer.map(|_| ()),
        Err(Refusal::Range {
            field: Field::Coefficient,
            value: 1.5,
            least: f32::from_bits(1),
            most: 1.0,
        })
    );
    assert_eq!(
        bench.done(Request::GetConfiguration),
        Bench::ideal_configuration()
    );
}

/// A sphere of 5 mm in tissue that stiffens.
const SPHERE: [f32; 8] = [200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 500.0];

#[test]
fn a_map_of_the_depth_that_is_none_is_refused_by_name() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (mut configuration, values) = spring();
    configuration.one_sided = true;
    for (at, number) in [
        (0, 0.0),
        (0, f32::NAN),
        (2, 0.0),
        (3, -1e-3),
        (7, f32::INFINITY),
    ] {
        let mut map = SPHERE;
        map[at] = number;
        configuration.depth_map = Some(map);
        let answer = bench.set(configuration, &values);
        assert_eq!(beyond(&answer), Some(Field::DepthMap), "{at} {number}");
    }
    configuration.depth_map = Some(SPHERE);
    configuration.one_sided = false;
    let answer = bench.set(configuration, &values).map(|_| ());
    assert_eq!(answer, Err(Refusal::Unsupported(Field::DepthMap)));
}

#[test]
fn a_map_of_the_depth_is_rendered_with_the_bits_of_a_contact_here() -> Tested {
    let (mut configuration, values) = spring();
    configuration.one_sided = true;
    configuration.depth_map = Some(SPHERE);
    let mut bench = Bench::configured(configuration, &values);
    bench.arm();
    bench.done(Request::Start(START));
    bench.run_ms(300);
    let operator = PortableOperator::<f32, 2, 1, 1>::new(Form::Taps, 0, &values)?;
    let spring = SpringDamper::new(1000.0, 2.0, operator)?;
    let contact = Contact::at(Metres(0.0), spring)?;
    let contact = contact.with_depth_map(DepthMap::of(SPHERE));
    let mut history = Environment::<f32, 1>::at_rest(&contact);
    let mut deepest = 0.0_f32;
    for sample in bench.samples() {
        let axis = sample.axes[0];
        let position = [axis.position_m].into();
        let force = contact.force(&history, &position)[0];
        contact.advance(&mut history, &position);
        assert_eq!(
            axis.environment_force_n.to_bits(),
            force.to_bits(),
            "{sample:?}"
        );
        deepest = deepest.max(axis.position_m);
    }
    // A spring of 1000 N/m alone would give way by 1 mm.
    assert!(deepest > 1.5e-3, "{deepest}");
    Ok(())
}
