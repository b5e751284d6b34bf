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
    /// Magnitude of the complex modulus, Pa.
    Complex,
    /// Phase angle between strain and stress, rad.
    Phase,
    /// Loss over storage modulus, 1.
    LossTangent,
    /// Temperature, °C: it tells segments apart, and is no number of a record.
    Temperature,
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
    pub const ALL: [Self; 14] = {
        let mut all = [Self::Time; 14];
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
const ROWS: [Row; 14] = [
    row(
        Column::Time,
        ["time", "time_s"],
        Dimension::Time,
        "time, t, test time, elapsed time, step time, interval time, total time, run time, \
         creep time, relaxation time, segment time, time in action, global time, elapsed, \
         timestamp, time stamp, t seg, zeit, prüfzeit, versuchszeit, testzeit, laufzeit, temps, \
         tiempo, tempo",
    ),
    row(
        Column::Modulus,
        ["modulus", "relaxation_modulus_pa"],
        Dimension::Pressure,
        "relaxation modulus, modulus, g(t), e(t), stress relaxation modulus, \
         relaxation modulus g(t), relaxation modulus e(t), shear modulus, \
         shear relaxation modulus, g, e, young's modulus, young modulus, tensile modulus, \
         compressive modulus, e relax, g relax, relax modulus, relaxationsmodul",
    ),
    row(
        Column::Compliance,
        ["compliance", "creep_compliance_per_pa"],
        Dimension::PerPressure,
        "creep compliance, compliance, j(t), j, d(t), creep compliance j(t), \
         shear creep compliance, j creep, d creep, kriechnachgiebigkeit",
    ),
    row(
        Column::Strain,
        ["strain", "strain"],
        Dimension::Ratio,
        "strain, ε, e, γ, epsilon, gamma, shear strain, engineering strain, compressive strain, \
         tensile strain, normal strain, axial strain, nominal strain, deformation, dehnung, \
         stauchung, scherdeformation, déformation",
    ),
    row(
        Column::Stress,
        ["stress", "stress_pa"],
        Dimension::Pressure,
        "stress, σ, τ, sigma, tau, shear stress, engineering stress, compressive stress, \
         tensile stress, normal stress, axial stress, nominal stress, spannung, schubspannung, \
         druckspannung, zugspannung, contrainte",
    ),
    row(
        Column::Force,
        ["force", "force_n"],
        Dimension::Force,
        "force, load, normal force, axial force, standard force, simulated force, rendered force, \
         f, fn, fz, compressive load, compressive force, tensile load, tensile force, axial load, \
         load cell, static force, f avg, extend force, kraft, standardkraft, prüfkraft, \
         normalkraft, force normale",
    ),
    row(
        Column::Position,
        ["position", "position_m"],
        Dimension::Length,
        "position, displacement, indentation, indentation depth, depth, penetration, \
         penetration depth, extension, deformation, stroke, crosshead, compression, travel, \
         standard travel, x, z, distance, compressive extension, tensile extension, \
         compressive displacement, axial displacement, crosshead displacement, \
         crosshead position, position z, z position, extend z sense, weg, standardweg, \
         traversenweg, verformung, eindringtiefe, déplacement",
    ),
    row(
        Column::Omega,
        ["omega", "omega_rad_s"],
        Dimension::AngularFrequency,
        "omega, ω, angular frequency, frequency, freq, ang. frequency, ang. freq., ang freq, \
         ang frequency, oscillation frequency, f, freq., kreisfrequenz, winkelfrequenz, frequenz, \
         fréquence",
    ),
    row(
        Column::Storage,
        ["storage", "storage_modulus_pa"],
        Dimension::Pressure,
        "storage modulus, storage, g', e', gp, ep, g prime, storage modulus g', \
         storage modulus e', dynamic storage modulus, g stor, e stor, elastic modulus, \
         shear storage modulus, tensile storage modulus, shear modulus (elastic component), \
         speichermodul, module de conservation",
    ),
    row(
        Column::Loss,
        ["loss", "loss_modulus_pa"],
        Dimension::Pressure,
        "loss modulus, loss, g'', e'', gpp, epp, g double prime, loss modulus g'', \
         loss modulus e'', dynamic loss modulus, g loss, e loss, viscous modulus, \
         shear loss modulus, tensile loss modulus, shear modulus (viscous component), \
         verlustmodul, module de perte",
    ),
    row(
        Column::Complex,
        ["complex-modulus", "complex_modulus_pa"],
        Dimension::Pressure,
        "complex modulus, |g*|, |e*|, g*, e*, complex shear modulus, complex modulus |g*|, \
         complex modulus |e*|, complex modulus g*, complex modulus e*, komplexer modul, \
         komplexer schubmodul",
    ),
    row(
        Column::Phase,
        ["phase", "phase_rad"],
        Dimension::Angle,
        "phase angle, phase, delta, δ, phase lag, phase shift, loss angle, phase angle δ, \
         phasenwinkel, phasenverschiebung",
    ),
    row(
        Column::LossTangent,
        ["loss-tangent", "loss_tangent"],
        Dimension::Ratio,
        "tan(delta), tan delta, tandelta, tan(δ), tan δ, tanδ, tan d, loss tangent, loss factor, \
         damping factor, verlustfaktor",
    ),
    row(
        Column::Temperature,
        ["temperature", "temperature_c"],
        Dimension::Temperature,
        "temperature, temp, temp., sample temperature, temperatur, température",
    ),
];
