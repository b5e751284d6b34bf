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

/// The models of two spring-pots, however they are joined: a new one is tested with the others.
#[must_use]
pub fn two_spring_pots() -> Vec<ModelKind> {
    let has_two = |kind: &ModelKind| {
        let mut parameters = kind.parameters().iter();
        parameters.any(|parameter| parameter.name == "second_order")
    };
    ModelKind::ALL.into_iter().filter(has_two).collect()
}

/// One of those models by turns, of V, α, G, β and a spring in Pa where it has one.
#[must_use]
pub fn of_two(turn: usize, values: [f64; 5]) -> Model {
    let kinds = two_spring_pots();
    let kind = kinds[turn % kinds.len()];
    model(kind, &values[..kind.parameters().len()])
}

/// A spring-pot alone, each model of two elements, V and G, of these orders, where a third one is a spring, and a Prony series.
#[must_use]
pub fn models(v: f64, g: f64, kinds: &[(&str, f64, f64)]) -> Vec<(String, Model)> {
    let one = model(ModelKind::SpringPot, &[8650.0, 0.2247]);
    let mut models = vec![("spring-pot".to_owned(), one)];
    for &(orders, alpha, beta) in kinds {
        for (turn, kind) in two_spring_pots().into_iter().enumerate() {
            let is_zener = kind == ModelKind::FractionalZener;
            let spring = if is_zener { 5e3 } else { 40e3 };
            let model = of_two(turn, [v, alpha, g, beta, spring]);
            models.push((format!("{kind} {orders}"), model));
        }
    }
    let series = [5e3, 3e3, 0.05, 3e3, 0.3, 3e3, 7.0, 3e3, 120.0];
    models.push(("Prony".to_owned(), model(ModelKind::Prony, &series)));
    models
}
