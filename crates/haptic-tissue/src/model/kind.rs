//! The models by name, and the parameters of each: the one table from which files, help and identification are made.

use spring_pots::Joint;
use std::fmt;

/// The numbers that a parameter may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterRange {
    /// Above 0 and finite.
    Positive,
    /// Number of at least 0 and finite.
    NotNegative,
    /// Number from 0 to 1.
    Order,
}

impl ParameterRange {
    /// True for a number within it.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Positive => value > 0.0 && value.is_finite(),
            Self::NotNegative => value >= 0.0 && value.is_finite(),
            Self::Order => (0.0..=1.0).contains(&value),
        }
    }

    /// The range in words, to go after "is not".
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Positive => "above 0 and finite",
            Self::NotNegative => "a finite number of at least 0",
            Self::Order => "in [0, 1]",
        }
    }
}

/// A parameter of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ModelParameter {
    /// Its key in a tissue file, which includes the unit.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// The numbers that it may be.
    pub range: ParameterRange,
    /// True if there is one value per branch of a Prony series: in a file a list.
    pub for_each_branch: bool,
    /// A few words for people.
    pub help: &'static str,
}

const fn positive(name: &'static str, unit: &'static str, help: &'static str) -> ModelParameter {
    ModelParameter {
        name,
        unit,
        range: ParameterRange::Positive,
        for_each_branch: false,
        help,
    }
}

const fn share(name: &'static str, help: &'static str) -> ModelParameter {
    ModelParameter {
        range: ParameterRange::Order,
        ..positive(name, "", help)
    }
}

const VISCOSITY: ModelParameter =
    positive("viscosity_pa_s_alpha", "Pa·s^α", "V of the first element");
const ORDER: ModelParameter = share("order", "α of the first element");
const SECOND_VISCOSITY: ModelParameter = positive(
    "second_viscosity_pa_s_beta",
    "Pa·s^β",
    "G of the second element",
);
const SECOND_ORDER: ModelParameter = share("second_order", "β of the second element, below α");
const SPRING: ModelParameter = positive("elastic_modulus_pa", "Pa", "E of the spring");
const SECOND_SPRING: ModelParameter = positive(
    "second_elastic_modulus_pa",
    "Pa",
    "E of the spring that the dashpot belongs to",
);
const DASHPOT: ModelParameter = positive("viscosity_pa_s", "Pa·s", "η of the dashpot");
const SECOND_DASHPOT: ModelParameter = positive(
    "second_viscosity_pa_s",
    "Pa·s",
    "η of the dashpot beside the others",
);
const BASE: ModelParameter = ModelParameter {
    range: ParameterRange::NotNegative,
    ..positive("elastic_modulus_pa", "Pa", "E of the spring, 0 Pa for none")
};
const BRANCH_MODULI: ModelParameter = ModelParameter {
    for_each_branch: true,
    ..positive("branch_moduli_pa", "Pa", "E of each branch")
};
const BRANCH_TIMES: ModelParameter = ModelParameter {
    for_each_branch: true,
    ..positive("branch_times_s", "s", "τ of each branch, rising")
};
const TWO: [ModelParameter; 4] = [VISCOSITY, ORDER, SECOND_VISCOSITY, SECOND_ORDER];
const THREE: [ModelParameter; 5] = [VISCOSITY, ORDER, SECOND_VISCOSITY, SECOND_ORDER, SPRING];

/// E₀, η and α of a tissue file without `model`: a spring beside a spring-pot, either of which may be missing.
pub(crate) const TWO_ELEMENTS: [ModelParameter; 3] = [
    BASE,
    ModelParameter {
        range: ParameterRange::NotNegative,
        ..VISCOSITY
    },
    ORDER,
];

fracdiff::enumerated! {
    /// The models that have names. The classical ones are those with α = 1 and β = 0. `E_{a,b}` is the Mittag-Leffler function;
    /// where a function of time has no closed form, it is the integral over its spectrum.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    #[non_exhaustive]
    pub enum ModelKind {
        /// σ = E·ε.
        Spring "spring",
        /// σ = η·dε/dt.
        Dashpot "dashpot",
        /// σ = V·D^α ε: G = V·t^(−α)/Γ(1−α), J = t^α/(V·Γ(1+α)).
        SpringPot "spring-pot",
        /// A spring and a dashpot side by side.
        KelvinVoigt "kelvin-voigt",
        /// Two spring-pots side by side: G is the sum of theirs, J = (t^α/V)·E_{α−β,1+α}(−(G/V)·t^(α−β)).
        FractionalKelvinVoigt "fractional-kelvin-voigt",
        /// A spring and a dashpot in series.
        Maxwell "maxwell",
        /// Two spring-pots in series: G = G·t^(−β)·E_{α−β,1−β}(−(G/V)·t^(α−β)), J is the sum of theirs.
        FractionalMaxwell "fractional-maxwell",
        /// A spring beside a Maxwell model.
        Zener "zener",
        /// A spring beside a fractional Maxwell model, whose G it adds to; J has no closed form.
        FractionalZener "fractional-zener",
        /// A spring in series with a Kelvin–Voigt model.
        PoyntingThomson "poynting-thomson",
        /// A spring in series with a fractional Kelvin–Voigt model, whose J it adds to; G has no closed form.
        FractionalPoyntingThomson "fractional-poynting-thomson",
        /// A dashpot beside a Maxwell model: J = t/η + J₁·(1 − e^(−t/τ)), as of a polymer in its solvent.
        Jeffreys "jeffreys",
        /// A spring and Maxwell branches side by side: G = E + Σ `E_i`·e^(−t/`τ_i`), J has an exponential at each zero of M.
        Prony "prony",
    }
}

impl ModelKind {
    /// The model of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The elements and how they are joined, as help prints it.
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Spring => "one spring",
            Self::Dashpot => "one dashpot",
            Self::SpringPot => "one spring-pot",
            Self::KelvinVoigt => "a spring and a dashpot side by side",
            Self::FractionalKelvinVoigt => "two spring-pots side by side",
            Self::Maxwell => "a spring and a dashpot in series",
            Self::FractionalMaxwell => "two spring-pots in series",
            Self::Zener => "a spring beside a Maxwell model",
            Self::FractionalZener => "a spring beside a fractional Maxwell model",
            Self::PoyntingThomson => "a spring in series with a Kelvin–Voigt model",
            Self::FractionalPoyntingThomson => {
                "a spring in series with a fractional Kelvin–Voigt model"
            }
            Self::Jeffreys => "a dashpot beside a Maxwell model",
            Self::Prony => "a spring and Maxwell branches side by side",
        }
    }

    /// Its parameters, in the order of [`Model::from_parameters`](super::Model::from_parameters). Those for each branch of a Prony series
    /// come again and again there: spring; modulus, time; modulus, time; …
    #[must_use]
    pub const fn parameters(self) -> &'static [ModelParameter] {
        match self {
            Self::Spring => &[SPRING],
            Self::Dashpot => &[DASHPOT],
            Self::SpringPot => &[VISCOSITY, ORDER],
            Self::KelvinVoigt | Self::Maxwell => &[SPRING, DASHPOT],
            Self::FractionalKelvinVoigt | Self::FractionalMaxwell => &TWO,
            Self::Zener | Self::PoyntingThomson => &[SPRING, SECOND_SPRING, DASHPOT],
            Self::FractionalZener | Self::FractionalPoyntingThomson => &THREE,
            Self::Jeffreys => &[SPRING, DASHPOT, SECOND_DASHPOT],
            Self::Prony => &[BASE, BRANCH_MODULI, BRANCH_TIMES],
        }
    }

    /// True of a sum of Maxwell elements, which is fitted by its modes, not by its elements.
    #[must_use]
    pub const fn is_sum(self) -> bool {
        matches!(self, Self::Jeffreys | Self::Prony)
    }

    /// True of a relaxation modulus, and of a complex modulus, that is neither 0 nor infinite throughout.
    #[must_use]
    pub const fn relaxes_and_oscillates(self) -> (bool, bool) {
        match self {
            Self::Dashpot => (false, false),
            Self::KelvinVoigt | Self::Jeffreys => (false, true),
            Self::Spring => (true, false),
            Self::SpringPot
            | Self::FractionalKelvinVoigt
            | Self::Maxwell
            | Self::FractionalMaxwell
            | Self::Zener
            | Self::FractionalZener
            | Self::PoyntingThomson
            | Self::FractionalPoyntingThomson
            | Self::Prony => (true, true),
        }
    }

    /// The joint of its two elements; `None` where there are not two.
    #[must_use]
    pub const fn joint(self) -> Option<Joint> {
        match self {
            Self::Spring | Self::Dashpot | Self::SpringPot | Self::Jeffreys | Self::Prony => None,
            Self::KelvinVoigt | Self::FractionalKelvinVoigt => Some(Joint::KelvinVoigt),
            Self::Maxwell | Self::FractionalMaxwell => Some(Joint::Maxwell),
            Self::Zener | Self::FractionalZener => Some(Joint::Zener),
            Self::PoyntingThomson | Self::FractionalPoyntingThomson => Some(Joint::PoyntingThomson),
        }
    }

    /// Two elements that are joined so; `classical` if they are a dashpot and a spring.
    pub(super) const fn of_two(joint: Joint, classical: bool) -> Self {
        match (joint, classical) {
            (Joint::KelvinVoigt, true) => Self::KelvinVoigt,
            (Joint::KelvinVoigt, false) => Self::FractionalKelvinVoigt,
            (Joint::Maxwell, true) => Self::Maxwell,
            (Joint::Maxwell, false) => Self::FractionalMaxwell,
            (Joint::Zener, true) => Self::Zener,
            (Joint::Zener, false) => Self::FractionalZener,
            (Joint::PoyntingThomson, true) => Self::PoyntingThomson,
            (Joint::PoyntingThomson, false) => Self::FractionalPoyntingThomson,
        }
    }

    /// The parameter of the value at a place.
    pub(super) fn parameter(self, index: usize) -> Option<&'static ModelParameter> {
        let all = self.parameters();
        let (once, each) = all.split_at(all.partition_point(|one| !one.for_each_branch));
        once.get(index)
            .or_else(|| each.get((index - once.len()).checked_rem(each.len())?))
    }
}

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
