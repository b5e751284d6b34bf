//! Controllers from lists of numbers, against those that the lists are of.

use fracdiff::portable::ListError;
use fracdiff::{Scheme, Seconds};
use fractional_control::{
    Controller, ControllerList, ControllerSetup, CroneParameters, FractionalPid, LeadController,
    LeadLagParameters, PidParameters, PortableController, PortableForm, PortablePart, SetPoint,
    TidParameters,
};

const T: Seconds = Seconds(1e-3);
const LIMITS: [f64; 2] = [-0.2, 0.5];
const PID: PidParameters = PidParameters {
    proportional: 2.0,
    integral: 15.0,
    integral_order: 0.8,
    derivative: 0.03,
    derivative_order: 0.6,
};
const CRONE: CroneParameters = CroneParameters {
    gain: 1.5,
    order: 1.4,
    low_rad_s: 3.0,
    high_rad_s: 30.0,
};

fn listed(setup: &ControllerSetup) -> (PortableForm, Vec<PortablePart>, Vec<f32>) {
    ControllerList::new(setup).expect("a list").portable()
}

/// Both in a loop, every command the same to the last bit; how many are at a limit.
fn same<C: Controller<f32>>(
    setup: ControllerSetup,
    made: impl FnOnce(&ControllerSetup) -> C,
) -> usize {
    let setup = ControllerSetup {
        output_low: Some(LIMITS[0]),
        output_high: Some(LIMITS[1]),
        ..setup
    };
    let made = made(&setup);
    let (form, parts, values) = listed(&setup);
    let limits = LIMITS.map(|limit| limit as f32);
    let portable = PortableController::<f32>::new(form, &parts, &values, limits).expect("a list");
    let (mut past, mut history) = (made.at_rest(), portable.at_rest());
    let (mut y, mut held_back) = (0.0_f32, 0);
    for n in 0..10_000 {
        let r = if n % 2500 < 1250 { 0.45 } else { -0.15 };
        let (want, have) = (made.output(&past, r, y), portable.output(&history, r, y));
        assert_eq!(want.to_bits(), have.to_bits(), "{setup:?} {n}");
        held_back += usize::from(limits.contains(&have));
        // What is applied is less in some samples.
        let applied = if n % 7 == 0 { 0.5 * have } else { have };
        made.advance(&mut past, r, y, applied);
        portable.advance(&mut history, r, y, applied);
        y += 1e-2 * (applied - y);
    }
    held_back
}

#[test]
fn a_controller_from_its_list_has_the_same_bits() {
    let mut held_back = 0;
    for scheme in ["full:1e-6", "full-bdf2:1e-6"] {
        let scheme: Scheme = scheme.parse().expect("a scheme");
        let setup = |law: fractional_control::ControllerParameters| ControllerSetup {
            scheme,
            ..ControllerSetup::new(law, T)
        };
        let memory = |design: &ControllerSetup| design.memory().expect("valid").fewest_modes();
        let pi = PidParameters {
            derivative: 0.0,
            ..PID
        };
        let whole = PidParameters {
            integral_order: 1.0,
            derivative_order: 1.0,
            ..PID
        };
        for gains in [PID, pi, whole] {
            held_back += same(setup(gains.into()), |design| {
                let actuator = design.actuator().expect("valid");
                let pid = FractionalPid::<f32>::new(
                    gains,
                    SetPoint::DEFAULT,
                    actuator,
                    memory(design),
                    T,
                );
                pid.expect("valid")
            });
        }
        let tid = TidParameters {
            tilt: 12.0,
            tilt_divisor: 3.0,
            integral: 8.0,
            derivative: 0.01,
        };
        held_back += same(setup(tid.into()), |design| {
            let actuator = design.actuator().expect("valid");
            FractionalPid::<f32>::tid(tid, 0.0, actuator, memory(design), T).expect("valid")
        });
        // A whole section more, none, and no memory.
        for order in [1.4, 0.5, 2.0, -0.6] {
            let crone = CroneParameters { order, ..CRONE };
            held_back += same(setup(crone.into()), |design| {
                let actuator = design.actuator().expect("valid");
                LeadController::<f32>::crone(crone, actuator, memory(design), T).expect("valid")
            });
        }
        // The corner of the pole at 2/T, which has no memory.
        let lead = LeadLagParameters {
            gain: 2.0,
            lambda_s: 0.1,
            x: 0.005,
            order: 0.7,
        };
        held_back += same(setup(lead.into()), |design| {
            let actuator = design.actuator().expect("valid");
            LeadController::<f32>::lead_lag(lead, actuator, memory(design), T).expect("valid")
        });
    }
    assert!((1_000..100_000).contains(&held_back), "{held_back}");
}

#[test]
fn a_list_that_is_none_is_refused() {
    for setup in [ControllerSetup::new(PID, T), ControllerSetup::new(CRONE, T)] {
        let (form, parts, values) = listed(&setup);
        let new = |form, parts: &[PortablePart], values: &[f32]| {
            PortableController::<f32>::new(form, parts, values, [-1.0, 1.0]).map(|_| ())
        };
        assert_eq!(new(form, &parts, &values), Ok(()));
        let count = |refused| matches!(refused, Err(ListError::Count { .. }));
        assert!(count(new(form, &parts, &values[1..])));
        assert!(count(new(
            form,
            &[&parts[..], &[PortablePart::default(); 2]].concat(),
            &values
        )));
        assert!(count(new(
            PortableForm::Lead { sections: 3 },
            &[],
            &values[..4]
        )));
        assert!(count(new(PortableForm::Parallel, &[], &values[..1])));
        for (at, _) in values.iter().enumerate() {
            let mut bad = values.clone();
            bad[at] = f32::NAN;
            let refused = new(form, &parts, &bad);
            assert!(matches!(refused, Err(ListError::Value { index, .. }) if index == at));
        }
        // A power of another form, a filter where there is none.
        let mut other = parts.clone();
        other[1].integer = 3;
        let refused = new(form, &other, &values);
        assert_eq!(refused, Err(ListError::IntegerPart(3)));
        let mut other = parts.clone();
        other[1].values -= 1;
        other[1].filter += 1;
        assert!(new(form, &other, &values).is_err());
    }
    let (form, parts, mut values) = listed(&ControllerSetup::new(CRONE, T));
    values[3] = 1.5;
    let refused = PortableController::<f32>::new(form, &parts, &values, [-1.0, 1.0]);
    assert!(matches!(
        refused.err(),
        Some(ListError::Decay { index: 3, .. })
    ));
}
