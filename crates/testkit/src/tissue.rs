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

/// A spring-pot alone, and each form of two elements, V and G, of these orders; a third one is a spring.
#[must_use]
pub fn forms(v: f64, g: f64, kinds: &[(&str, f64, f64)]) -> Vec<(String, Form)> {
    let one = Form::SpringPot(pot(8650.0, 0.2247));
    let mut forms = vec![("spring-pot".to_owned(), one)];
    for &(kind, alpha, beta) in kinds {
        let (first, second) = (pot(v, alpha), pot(g, beta));
        let zener = Form::FractionalZener {
            first,
            second,
            elastic_modulus_pa: 5e3,
        };
        let poynting_thomson = Form::FractionalPoyntingThomson {
            first,
            second,
            elastic_modulus_pa: 40e3,
        };
        for (name, form) in [
            ("Maxwell", Form::FractionalMaxwell { first, second }),
            (
                "Kelvin-Voigt",
                Form::FractionalKelvinVoigt { first, second },
            ),
            ("Zener", zener),
            ("Poynting-Thomson", poynting_thomson),
        ] {
            forms.push((format!("{name} {kind}"), form));
        }
    }
    forms
}
