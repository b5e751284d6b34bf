//! Numbers and names as C writes them.

use crate::error::HeaderError;
use fracdiff::Real;
use std::fmt::{LowerExp, Write as _};

/// A number type of C.
pub trait CNumber: Real + LowerExp {
    /// The word by which C declares a number of this type.
    const TYPE: &'static str;
    /// The end of its literals.
    const SUFFIX: &'static str;
    /// The type of its bits.
    const BITS: &'static str;
    /// The largest: C writes no infinity that every compiler takes.
    const LARGEST: f64;

    /// Its bits as an unsigned literal of [`BITS`](Self::BITS).
    fn bits(self) -> String;
}

impl CNumber for f32 {
    const TYPE: &'static str = "float";
    const SUFFIX: &'static str = "f";
    const BITS: &'static str = "uint32_t";
    const LARGEST: f64 = f32::MAX as f64;

    fn bits(self) -> String {
        format!("0x{:x}U", self.to_bits())
    }
}

impl CNumber for f64 {
    const TYPE: &'static str = "double";
    const SUFFIX: &'static str = "";
    const BITS: &'static str = "uint64_t";
    const LARGEST: f64 = f64::MAX;

    fn bits(self) -> String {
        format!("0x{:x}ULL", self.to_bits())
    }
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

/// A template of C with text in the place of some of its words. Whole words alone are replaced, all in one pass: what is put in is not read
/// again, so neither the order of the words nor a word inside another one matters.
pub(crate) fn filled<S: AsRef<str>>(template: &str, words: &[(&str, S)]) -> String {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut text = String::new();
    for piece in template.split_inclusive(|c| !is_letter(c)) {
        let (word, behind) = piece.split_at(piece.find(|c| !is_letter(c)).unwrap_or(piece.len()));
        let known = words.iter().find(|(name, _)| *name == word);
        text.push_str(known.map_or(word, |(_, put)| put.as_ref()));
        text.push_str(behind);
    }
    text
}

/// Longest name: with its suffixes, all names still differ for C99.
const LONGEST: usize = 24;

/// Words of C99, C++ and Arduino that name something else.
const TAKEN: &str = "\
    alignas alignof and asm auto bool boolean break byte case catch char class const constexpr continue \
    decltype default delete do double else enum explicit export extern false float for friend goto if \
    inline int long mutable namespace new noexcept not nullptr operator or private protected public \
    register restrict return short signed sizeof static struct switch template this throw true try \
    typedef typeid typename union unsigned using virtual void volatile while word xor";

/// Names that with `_t` are types of the system: of C99 and of POSIX.
const TYPES: &str = "\
    blkcnt blksize clock clockid cnd dev div fenv fexcept fpos fsblkcnt fsfilcnt gid id imaxdiv ino \
    int16 int32 int64 int8 intmax intptr key ldiv lldiv locale loff max_align mbstate mode mtx nlink off pid \
    ptrdiff pthread quad regex regmatch regoff rlim sa_family sig_atomic sigset size socklen ssize stack \
    suseconds thrd time timer tss uid uint uint16 uint32 uint64 uint8 uintmax uintptr ulong useconds ushort va_list \
    wchar wctrans wctype wint";

/// The name, if it can stand before `_t`, `_init` and the rest.
pub(crate) fn check_name(name: &str) -> Result<&str, HeaderError> {
    let first = name.starts_with(|c: char| c.is_ascii_alphabetic());
    let all = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if first && all && name.len() <= LONGEST && !is_taken(name) {
        Ok(name)
    } else {
        Err(HeaderError::Name(name.to_owned()))
    }
}

fn is_taken(name: &str) -> bool {
    let mut words = TAKEN.split(' ').chain(TYPES.split(' '));
    words.any(|word| word == name)
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

    #[test]
    fn words_are_put_in_once_and_whole() {
        let words = [("TO", "FROM"), ("FROM", "0U"), ("real", "float")];
        let text = "unreal FROM_TO = (real)TO;\nreal *FROM";
        assert_eq!(
            filled(text, &words),
            "unreal FROM_TO = (float)FROM;\nfloat *0U"
        );
    }

    #[test]
    fn names_are_identifiers() {
        for good in ["half", "D05", "x_1", "a23456789012345678901234"] {
            assert_eq!(check_name(good), Ok(good));
        }
        for bad in [
            "",
            "1half",
            "_half",
            "ha-lf",
            "häl",
            "float",
            "class",
            "pid",
            "size",
            "a234567890123456789012345",
            "a\nb",
        ] {
            let message = check_name(bad).expect_err(bad).to_string();
            assert!(message.contains("is not a C identifier"), "{message}");
        }
    }
}
