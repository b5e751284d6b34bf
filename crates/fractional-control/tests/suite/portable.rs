//! Controllers from lists of numbers, against those that the lists are of.

use fracdiff::{Seconds, portable::ListError};
use fractional_control::{
    ControllerList, ControllerSetup, CroneParameters, PidParameters, PortableController,
    PortableForm, PortablePart,
};

const T: Seconds = Seconds(1e-3);
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
