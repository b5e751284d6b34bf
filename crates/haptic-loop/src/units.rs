//! Units at the public edges, where two plain numbers could be swapped. Total: any number is
//! allowed here, the constructor that takes it checks the range it needs. Kernels use plain floats.

pub use fracdiff::Seconds;

macro_rules! unit {
    ($(#[$doc:meta])* $name:ident, $symbol:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(&self.0, f)?;
                f.write_str(concat!(" ", $symbol))
            }
        }
    };
}

unit!(
    /// A length or position, m.
    Metres, "m"
);
unit!(
    /// An area, m².
    SquareMetres, "m²"
);
unit!(
    /// A force, N.
    Newtons, "N"
);
unit!(
    /// A rate of change of force, N/s.
    NewtonsPerSecond, "N/s"
);
unit!(
    /// A velocity or speed, m/s.
    MetresPerSecond, "m/s"
);
unit!(
    /// A frequency, Hz.
    Hertz, "Hz"
);
unit!(
    /// A stiffness, N/m.
    NewtonsPerMetre, "N/m"
);
unit!(
    /// A viscous damping, N·s/m.
    NewtonSecondsPerMetre, "N·s/m"
);
unit!(
    /// A mass, kg.
    Kilograms, "kg"
);
unit!(
    /// A stress or modulus, Pa.
    Pascals, "Pa"
);
