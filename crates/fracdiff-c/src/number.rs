//! Numbers as C writes them.

use fracdiff::Real;
use std::fmt::{LowerExp, Write as _};

/// A number type of C.
pub trait CNumber: Real + LowerExp {
    /// Its name.
    const TYPE: &'static str;
    /// The end of its literals.
    const SUFFIX: &'static str;
}

impl CNumber for f32 {
    const TYPE: &'static str = "float";
    const SUFFIX: &'static str = "f";
}

impl CNumber for f64 {
    const TYPE: &'static str = "double";
    const SUFFIX: &'static str = "";
}

/// The shortest decimal that reads back as the same bits.
pub(crate) fn literal<F: CNumber>(value: F) -> String {
    format!("{value:e}{}", F::SUFFIX)
}

/// `static const TYPE NAME[N] = {…};`, four to a line.
pub(crate) fn table<F: CNumber>(name: &str, values: &[F]) -> String {
    let mut text = format!("static const {} {name}[{}] = {{", F::TYPE, values.len());
    for (index, value) in values.iter().enumerate() {
        let before = match index {
            0 => "\n    ",
            _ if index.is_multiple_of(4) => ",\n    ",
            _ => ", ",
        };
        // Writing to a string cannot fail.
        let _ = write!(text, "{before}{}", literal(*value));
    }
    text.push_str("};\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_literal_is_the_shortest_that_reads_back() {
        assert_eq!(literal(0.1_f32), "1e-1f");
        assert_eq!(literal(1.0_f64), "1e0");
        assert_eq!(literal(-0.0_f64), "-0e0");
        assert_eq!(literal(-31.622_776_f32), "-3.1622776e1f");
        for bits in [
            1_u64,
            0x000f_ffff_ffff_ffff,
            0x7fef_ffff_ffff_ffff,
            0x3ff0_0000_0000_0001,
        ] {
            let value = f64::from_bits(bits);
            assert_eq!(literal(value).parse::<f64>().map(f64::to_bits), Ok(bits));
        }
    }
}
