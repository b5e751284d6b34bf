//! The quantities that a column can hold.

use super::unit::Dimension;

/// A quantity of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Column {
    /// Time, s; of any origin.
    Time,
    /// Relaxation modulus, Pa.
    Modulus,
    /// Creep compliance, 1/Pa.
    Compliance,
    /// Strain, 1.
    Strain,
    /// Nominal stress, Pa: force over the area at rest.
    Stress,
    /// Force on the specimen, N.
    Force,
    /// Position into the specimen, m: its depth.
    Position,
    /// Angular frequency, rad/s; a column in Hz is converted.
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
    pub const ALL: [Self; 10] = {
        let mut all = [Self::Time; 10];
        let mut at = 0;
        while at < all.len() {
            all[at] = ROWS[at].column;
            assert!(all[at] as usize == at, "a row stands where its column does");
            at += 1;
        }
        all
    };

    /// Its name where a user chooses columns or units.
    #[must_use]
    pub const fn name(self) -> &'static str {
        ROWS[self as usize].names[0]
    }

    /// The column of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name() == name)
    }

    /// Its header in SI units, as this project writes it.
    #[must_use]
    pub const fn header(self) -> &'static str {
        ROWS[self as usize].names[1]
    }

    pub(super) const fn dimension(self) -> Dimension {
        ROWS[self as usize].dimension
    }

    /// True if machines write it so; in lower case, with plain primes, single spaces, without unit.
    pub(super) fn is_spelt(self, name: &str) -> bool {
        let mut spellings = ROWS[self as usize].spellings.split(", ");
        spellings.any(|spelling| spelling == name)
    }
}

struct Row {
    column: Column,
    names: [&'static str; 2],
    dimension: Dimension,
    spellings: &'static str,
}

const fn row(
    column: Column,
    names: [&'static str; 2],
    dimension: Dimension,
    spellings: &'static str,
) -> Row {
    Row {
        column,
        names,
        dimension,
        spellings,
    }
}

/// Name and header of each column, and how rheometers and testing machines spell it.
const ROWS: [Row; 10] = [
    row(
        Column::Time,
        ["time", "time_s"],
        Dimension::Time,
        "time, t, test time, elapsed time, step time, interval time, total time, run time, \
         creep time, relaxation time",
    ),
    row(
        Column::Modulus,
        ["modulus", "relaxation_modulus_pa"],
        Dimension::Pressure,
        "relaxation modulus, modulus, g(t), e(t), stress relaxation modulus, \
         relaxation modulus g(t), relaxation modulus e(t), shear modulus, \
         shear relaxation modulus, g, e, young's modulus, young modulus, tensile modulus, \
         compressive modulus",
    ),
    row(
        Column::Compliance,
        ["compliance", "creep_compliance_per_pa"],
        Dimension::PerPressure,
        "creep compliance, compliance, j(t), j, d(t), creep compliance j(t), \
         shear creep compliance",
    ),
    row(
        Column::Strain,
        ["strain", "strain"],
        Dimension::Ratio,
        "strain, ε, e, γ, epsilon, gamma, shear strain, engineering strain, compressive strain, \
         tensile strain, normal strain, axial strain",
    ),
    row(
        Column::Stress,
        ["stress", "stress_pa"],
        Dimension::Pressure,
        "stress, σ, τ, sigma, tau, shear stress, engineering stress, compressive stress, \
         tensile stress, normal stress, axial stress, nominal stress",
    ),
    row(
        Column::Force,
        ["force", "force_n"],
        Dimension::Force,
        "force, load, normal force, axial force, standard force, simulated force, rendered force, \
         f, fn, fz",
    ),
    row(
        Column::Position,
        ["position", "position_m"],
        Dimension::Length,
        "position, displacement, indentation, indentation depth, depth, penetration, \
         penetration depth, extension, deformation, stroke, crosshead, compression, travel, \
         standard travel, x, z",
    ),
    row(
        Column::Omega,
        ["omega", "omega_rad_s"],
        Dimension::AngularFrequency,
        "omega, ω, angular frequency, frequency, freq, ang. frequency, ang. freq., \
         oscillation frequency, f",
    ),
    row(
        Column::Storage,
        ["storage", "storage_modulus_pa"],
        Dimension::Pressure,
        "storage modulus, storage, g', e', gp, ep, g prime, storage modulus g', \
         storage modulus e', dynamic storage modulus",
    ),
    row(
        Column::Loss,
        ["loss", "loss_modulus_pa"],
        Dimension::Pressure,
        "loss modulus, loss, g'', e'', gpp, epp, g double prime, loss modulus g'', \
         loss modulus e'', dynamic loss modulus",
    ),
];
