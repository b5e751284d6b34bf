//! Models of tissues that tests go through one by one.

use haptic_tissue::{Model, ModelKind};

/// Orders α and β of two elements, with a word for them: spring-pots, with a spring, with a dashpot, and classical.
pub const KINDS: [(&str, f64, f64); 4] = [
    ("of spring-pots", 0.675, 0.11),
    ("with a spring", 0.675, 0.0),
    ("with a dashpot", 1.0, 0.11),
    ("classical", 1.0, 0.0),
];

/// A model by its parameters, in the order of its kind.
///
/// # Panics
/// Parameters outside their ranges.
#[must_use]
pub fn model(kind: ModelKind, values: &[f64]) -> Model {
    Model::from_parameters(kind, values).expect("valid")
}

/// Each model of two elements, V and α, G and β; a third one is a spring of so many Pa.
#[must_use]
pub fn of_two(
    (v, alpha): (f64, f64),
    (g, beta): (f64, f64),
    elastic_modulus_pa: f64,
) -> [(&'static str, Model); 4] {
    let values = [v, alpha, g, beta, elastic_modulus_pa];
    [
        ("Kelvin-Voigt", ModelKind::FractionalKelvinVoigt),
        ("Maxwell", ModelKind::FractionalMaxwell),
        ("Zener", ModelKind::FractionalZener),
        ("Poynting-Thomson", ModelKind::FractionalPoyntingThomson),
    ]
    .map(|(name, kind)| (name, model(kind, &values[..kind.parameters().len()])))
}

/// A spring-pot alone, each model of two elements, V and G, of these orders, where a third one is a spring, and a Prony series.
#[must_use]
pub fn models(v: f64, g: f64, kinds: &[(&str, f64, f64)]) -> Vec<(String, Model)> {
    let one = model(ModelKind::SpringPot, &[8650.0, 0.2247]);
    let mut models = vec![("spring-pot".to_owned(), one)];
    for &(kind, alpha, beta) in kinds {
        let [kelvin_voigt, maxwell, zener, _] = of_two((v, alpha), (g, beta), 5e3);
        let [_, _, _, poynting_thomson] = of_two((v, alpha), (g, beta), 40e3);
        for (name, model) in [maxwell, kelvin_voigt, zener, poynting_thomson] {
            models.push((format!("{name} {kind}"), model));
        }
    }
    let series = [5e3, 3e3, 0.05, 3e3, 0.3, 3e3, 7.0, 3e3, 120.0];
    models.push(("Prony".to_owned(), model(ModelKind::Prony, &series)));
    models
}
