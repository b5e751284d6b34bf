//! Units at the public edges, where two plain numbers could be swapped. Total: any number is
//! allowed here, the constructor that takes it checks the range it needs. Kernels use plain floats.

pub use fracdiff::Seconds;

macro_rules! units {
    ($($name:ident, $symbol:literal, $doc:literal;)*) => { $(
        #[doc = $doc]
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(&self.0, f)?;
                f.write_str(concat!(" ", $symbol))
            }
        }
    )* };
}

units! {
    Metres, "m", "A length or position, m.";
    SquareMetres, "m²", "An area, m².";
    Newtons, "N", "A force, N.";
    NewtonsPerSecond, "N/s", "A rate of change of force, N/s.";
    MetresPerSecond, "m/s", "A velocity or speed, m/s.";
    MetresPerSecondSquared, "m/s²", "An acceleration, m/s².";
    MetresPerSecondCubed, "m/s³", "A rate of change of acceleration, m/s³.";
    Joules, "J", "An energy, J.";
    Hertz, "Hz", "A frequency, Hz.";
    NewtonsPerMetre, "N/m", "A stiffness, N/m.";
    NewtonSecondsPerMetre, "N·s/m", "A viscous damping, N·s/m.";
    Kilograms, "kg", "A mass, kg.";
    Pascals, "Pa", "A stress or modulus, Pa.";
}
