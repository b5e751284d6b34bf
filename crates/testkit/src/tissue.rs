//! Models of tissues that tests go through one by one.

use haptic_tissue::{Form, SpringPot};

/// A spring-pot of V in Pa·s^α and α.
///
/// # Panics
/// Parameters outside their ranges.
#[must_use]
pub fn pot(viscosity_pa_s_alpha: f64, order: f64) -> SpringPot {
    SpringPot::new(viscosity_pa_s_alpha, order).expect("valid")
}

/// Orders α and β of two elements, with a word for them: spring-pots, with a spring, with a dashpot, and classical.
pub const KINDS: [(&str, f64, f64); 4] = [
    ("of spring-pots", 0.675, 0.11),
    ("with a spring", 0.675, 0.0),
    ("with a dashpot", 1.0, 0.11),
    ("classical", 1.0, 0.0),
];

/// Each form of two elements; a third one is a spring of so many Pa.
#[must_use]
pub fn of_two(
    first: SpringPot,
    second: SpringPot,
    elastic_modulus_pa: f64,
) -> [(&'static str, Form); 4] {
    let zener = Form::FractionalZener {
        first,
        second,
        elastic_modulus_pa,
    };
    let poynting_thomson = Form::FractionalPoyntingThomson {
        first,
        second,
        elastic_modulus_pa,
    };
    [
        (
            "Kelvin-Voigt",
            Form::FractionalKelvinVoigt { first, second },
        ),
        ("Maxwell", Form::FractionalMaxwell { first, second }),
        ("Zener", zener),
        ("Poynting-Thomson", poynting_thomson),
    ]
}

/// A spring-pot alone, and each form of two elements, V and G, of these orders; a third one is a spring.
#[must_use]
pub fn forms(v: f64, g: f64, kinds: &[(&str, f64, f64)]) -> Vec<(String, Form)> {
    let one = Form::SpringPot(pot(8650.0, 0.2247));
    let mut forms = vec![("spring-pot".to_owned(), one)];
    for &(kind, alpha, beta) in kinds {
        let (first, second) = (pot(v, alpha), pot(g, beta));
        let [kelvin_voigt, maxwell, zener, _] = of_two(first, second, 5e3);
        let [_, _, _, poynting_thomson] = of_two(first, second, 40e3);
        for (name, form) in [maxwell, kelvin_voigt, zener, poynting_thomson] {
            forms.push((format!("{name} {kind}"), form));
        }
    }
    forms
}
