//! The quantities that a column can hold.

use super::unit::Dimension;

/// A quantity of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Column {
    /// Time, s.
    Time,
    /// Relaxation modulus, Pa.
    Modulus,
    /// Creep compliance, 1/Pa.
    Compliance,
    /// Strain, 1.
    Strain,
    /// Stress, Pa.
    Stress,
    /// Force on the specimen, N.
    Force,
    /// Position into the specimen, m: its depth.
    Position,
    /// Angular frequency, rad/s.
    Omega,
    /// Storage modulus, Pa.
    Storage,
    /// Loss modulus, Pa.
    Loss,
}

/// The place of a column that a user named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// By its number, from 1.
    Number(usize),
    /// By its header, or the header without the unit.
    Name(String),
}

impl Column {
    /// All, in the order of messages.
    pub const ALL: [Self; 10] = [
        Self::Time,
        Self::Modulus,
        Self::Compliance,
        Self::Strain,
        Self::Stress,
        Self::Force,
        Self::Position,
        Self::Omega,
        Self::Storage,
        Self::Loss,
    ];

    /// Its name where a user chooses columns or units.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Modulus => "modulus",
            Self::Compliance => "compliance",
            Self::Strain => "strain",
            Self::Stress => "stress",
            Self::Force => "force",
            Self::Position => "position",
            Self::Omega => "omega",
            Self::Storage => "storage",
            Self::Loss => "loss",
        }
    }

    /// The one of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name() == name)
    }

    /// The header that needs no guess.
    #[must_use]
    pub const fn header(self) -> &'static str {
        match self {
            Self::Time => "time_s",
            Self::Modulus => "relaxation_modulus_pa",
            Self::Compliance => "creep_compliance_per_pa",
            Self::Strain => "strain",
            Self::Stress => "stress_pa",
            Self::Force => "force_n",
            Self::Position => "position_m",
            Self::Omega => "omega_rad_s",
            Self::Storage => "storage_modulus_pa",
            Self::Loss => "loss_modulus_pa",
        }
    }

    pub(super) const fn dimension(self) -> Dimension {
        match self {
            Self::Time => Dimension::Time,
            Self::Modulus | Self::Stress | Self::Storage | Self::Loss => Dimension::Pressure,
            Self::Compliance => Dimension::PerPressure,
            Self::Strain => Dimension::Ratio,
            Self::Force => Dimension::Force,
            Self::Position => Dimension::Length,
            Self::Omega => Dimension::AngularFrequency,
        }
    }

    /// Spellings of other programs, in lower case, words apart by one space.
    pub(super) fn spellings(self) -> &'static [&'static str] {
        let found = SPELLINGS.iter().find(|known| known.0 == self);
        found.map_or(&[], |known| known.1)
    }
}

const SPELLINGS: &[(Column, &[&str])] = &[
    (
        Column::Time,
        &[
            "time",
            "t",
            "test time",
            "elapsed time",
            "step time",
            "interval time",
            "total time",
            "run time",
            "creep time",
            "relaxation time",
        ],
    ),
    (
        Column::Modulus,
        &[
            "relaxation modulus",
            "modulus",
            "g(t)",
            "e(t)",
            "stress relaxation modulus",
            "relaxation modulus g(t)",
            "relaxation modulus e(t)",
            "shear modulus",
            "shear relaxation modulus",
            "g",
            "e",
            "young's modulus",
            "young modulus",
            "tensile modulus",
            "compressive modulus",
        ],
    ),
    (
        Column::Compliance,
        &[
            "creep compliance",
            "compliance",
            "j(t)",
            "j",
            "d(t)",
            "creep compliance j(t)",
            "shear creep compliance",
        ],
    ),
    (
        Column::Strain,
        &[
            "strain",
            "ε",
            "e",
            "γ",
            "epsilon",
            "gamma",
            "shear strain",
            "engineering strain",
            "compressive strain",
            "tensile strain",
            "normal strain",
            "axial strain",
        ],
    ),
    (
        Column::Stress,
        &[
            "stress",
            "σ",
            "τ",
            "sigma",
            "tau",
            "shear stress",
            "engineering stress",
            "compressive stress",
            "tensile stress",
            "normal stress",
            "axial stress",
            "nominal stress",
        ],
    ),
    (
        Column::Force,
        &[
            "force",
            "load",
            "normal force",
            "axial force",
            "standard force",
            "simulated force",
            "rendered force",
            "f",
            "fn",
            "fz",
        ],
    ),
    (
        Column::Position,
        &[
            "position",
            "displacement",
            "indentation",
            "indentation depth",
            "depth",
            "penetration",
            "penetration depth",
            "extension",
            "deformation",
            "stroke",
            "crosshead",
            "compression",
            "travel",
            "standard travel",
            "x",
            "z",
        ],
    ),
    (
        Column::Omega,
        &[
            "omega",
            "ω",
            "angular frequency",
            "frequency",
            "freq",
            "ang. frequency",
            "ang. freq.",
            "oscillation frequency",
            "f",
        ],
    ),
    (
        Column::Storage,
        &[
            "storage modulus",
            "storage",
            "g'",
            "e'",
            "gp",
            "ep",
            "g prime",
            "storage modulus g'",
            "storage modulus e'",
            "dynamic storage modulus",
        ],
    ),
    (
        Column::Loss,
        &[
            "loss modulus",
            "loss",
            "g''",
            "e''",
            "gpp",
            "epp",
            "g double prime",
            "loss modulus g''",
            "loss modulus e''",
            "dynamic loss modulus",
        ],
    ),
];
