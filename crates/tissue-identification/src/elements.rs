//! The models that are fitted, as elements eᵢ(s) = exp(aᵢ)·(s·t₀)^αᵢ and how they are joined.
//!
//! aᵢ is the logarithm of the modulus at the rate 1/t₀ in the middle of the record, where it hangs together least with αᵢ.
//! Variables, as parameters of a tissue file: a₁, α₁, a₂, α₂, and a₃ of the spring, whose α is 0.

use haptic_tissue::{ModelKind, ParameterRange};
use spring_pots::{Elements, Joint, VARIABLES, is_order};

/// The models that are fitted, those with few parameters first; a Prony series with as many branches as the record shows. A classical Poynting–Thomson model is a Zener model with other numbers.
pub const CANDIDATES: [ModelKind; 12] = [
    ModelKind::Spring,
    ModelKind::Dashpot,
    ModelKind::SpringPot,
    ModelKind::KelvinVoigt,
    ModelKind::Maxwell,
    ModelKind::Zener,
    ModelKind::FractionalKelvinVoigt,
    ModelKind::FractionalMaxwell,
    ModelKind::FractionalZener,
    ModelKind::FractionalPoyntingThomson,
    ModelKind::Jeffreys,
    ModelKind::Prony,
];

/// One of [`CANDIDATES`]. Springs and dashpots are spring-pots whose orders are fixed at 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    kind: ModelKind,
    /// Low and high end of each variable; of a modulus ln V, infinite where it is not held.
    ranges: [(f64, f64); VARIABLES],
    held: [bool; VARIABLES],
    /// Parameters that are looked for beside those of the model.
    nuisance: usize,
}

impl Candidate {
    /// Candidate with nothing held.
    pub(super) fn of(kind: ModelKind) -> Self {
        let mut ranges = [(f64::NEG_INFINITY, f64::INFINITY); VARIABLES];
        let classical = |element: usize| match (kind, element) {
            (ModelKind::Spring, _) | (_, 1..) => 0.0,
            (_, 0) => 1.0,
        };
        let mut candidate = Self {
            kind,
            ranges,
            held: [false; VARIABLES],
            nuisance: 0,
        };
        for (variable, range) in ranges.iter_mut().enumerate() {
            if is_order(variable) {
                let order = classical(variable / 2);
                *range = if candidate.is_fractional() {
                    (0.0, 1.0)
                } else {
                    (order, order)
                };
            }
        }
        candidate.ranges = ranges;
        candidate
    }

    /// Holds the parameter of this name between these ends; `None` if the model has no such parameter.
    pub(super) fn with_held(mut self, name: &str, low: f64, high: f64) -> Option<Self> {
        let parameters = self.kind.parameters();
        let parameter = parameters.iter().position(|one| one.name == name)?;
        let variable = self.variable(parameter);
        self.ranges[variable] = if parameters[parameter].range == ParameterRange::Order {
            (low, high)
        } else {
            (libm::log(low), libm::log(high))
        };
        self.held[variable] = true;
        if self.has_two_orders() {
            // The larger order is the first one's: then orders may be exchanged and stay in their ranges.
            let [first, second] = [self.ranges[1], self.ranges[3]];
            self.ranges[1].0 = first.0.max(second.0);
            self.ranges[3].1 = second.1.min(first.1);
        }
        Some(self)
    }

    /// The highest first order and the lowest second one, if the second is held above the first.
    pub(super) fn exchanged(self) -> Option<(f64, f64)> {
        let (order, second) = (self.ranges[1].1, self.ranges[3].0);
        (self.has_two_orders() && order < second).then_some((order, second))
    }

    /// Sets the number of parameters beside those of the model.
    pub(super) const fn with_nuisance(self, nuisance: usize) -> Self {
        Self { nuisance, ..self }
    }

    pub(super) const fn kind(self) -> ModelKind {
        self.kind
    }

    /// Joint of its elements; `None` of one alone.
    pub(super) const fn joint(self) -> Option<Joint> {
        self.kind.joint()
    }

    /// Number of the variables of its elements.
    pub(super) const fn variables(self) -> usize {
        spring_pots::variables(self.joint())
    }

    const fn is_fractional(self) -> bool {
        self.kind.parameters().len() == self.variables()
    }

    /// True without memory: no order is above 0.
    pub(super) fn is_static(self) -> bool {
        let mut variables = (0..self.variables()).filter(|variable| is_order(*variable));
        variables.all(|variable| self.ranges[variable].1 <= 0.0)
    }

    /// True if two orders are looked for, the larger one first.
    pub(super) const fn has_two_orders(self) -> bool {
        self.is_fractional() && self.variables() > 2
    }

    /// Number of parameters to be fitted, with those beside the model.
    pub(super) fn parameters(self) -> usize {
        let ranges = self.ranges[..self.variables()].iter();
        ranges.filter(|(low, high)| low < high).count() + self.nuisance
    }

    /// Low and high end of a variable; of a modulus ln V, infinite where it is not held.
    pub(super) const fn range(self, variable: usize) -> (f64, f64) {
        self.ranges[variable]
    }

    pub(super) const fn is_held(self, variable: usize) -> bool {
        self.held[variable]
    }

    /// The variable of a parameter. A file names the spring before the dashpot, of which the order is larger.
    pub(super) const fn variable(self, parameter: usize) -> usize {
        if self.is_fractional() {
            parameter
        } else {
            2 * (self.kind.parameters().len() - 1 - parameter)
        }
    }

    /// Share of each variable in a parameter: ln Vᵢ = aᵢ + αᵢ ln t₀; an order is its own variable.
    pub(super) fn shares(self, parameter: usize, ln_unit: f64) -> Vec<f64> {
        let first = self.variable(parameter);
        let mut shares = vec![0.0; self.variables()];
        shares[first] = 1.0;
        if let Some(order) = shares.get_mut(first + 1).filter(|_| !is_order(first)) {
            *order = ln_unit;
        }
        shares
    }

    /// Puts the larger order first, unless a modulus of either is held.
    pub(super) fn sorted(self, mut elements: Elements) -> Elements {
        let may = self.has_two_orders() && !self.is_held(0) && !self.is_held(2);
        if may && elements.order[0] < elements.order[1] {
            elements.ln_modulus.swap(0, 1);
            elements.order.swap(0, 1);
        }
        elements
    }

    /// Those whose variables are their parameters.
    #[cfg(test)]
    pub(super) fn fractional() -> impl Iterator<Item = Self> {
        let all = CANDIDATES.into_iter().map(Self::of);
        all.filter(|candidate| candidate.is_fractional())
    }
}

/// A parameter of its logarithm, or an order of itself.
pub(super) fn number(variable: usize, value: f64) -> f64 {
    if is_order(variable) {
        value
    } else {
        libm::exp(value)
    }
}
