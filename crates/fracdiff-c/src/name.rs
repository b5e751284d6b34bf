//! Names that C takes.

use super::error::HeaderError;

/// Longest name: with what is put behind it, C99 still tells all names apart.
const LONGEST: usize = 24;

/// Words of C99, C++ and Arduino that name something else.
const TAKEN: &[&str] = &[
    "alignas",
    "alignof",
    "and",
    "asm",
    "auto",
    "bool",
    "boolean",
    "break",
    "byte",
    "case",
    "catch",
    "char",
    "class",
    "const",
    "constexpr",
    "continue",
    "decltype",
    "default",
    "delete",
    "do",
    "double",
    "else",
    "enum",
    "explicit",
    "export",
    "extern",
    "false",
    "float",
    "for",
    "friend",
    "goto",
    "if",
    "inline",
    "int",
    "long",
    "mutable",
    "namespace",
    "new",
    "noexcept",
    "not",
    "nullptr",
    "operator",
    "or",
    "private",
    "protected",
    "public",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "struct",
    "switch",
    "template",
    "this",
    "throw",
    "true",
    "try",
    "typedef",
    "typeid",
    "typename",
    "union",
    "unsigned",
    "using",
    "virtual",
    "void",
    "volatile",
    "while",
    "word",
    "xor",
];

/// The name, if it can stand before `_t`, `_init` and the rest.
pub(crate) fn check(name: &str) -> Result<&str, HeaderError> {
    let first = name.starts_with(|c: char| c.is_ascii_alphabetic());
    let all = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if first && all && name.len() <= LONGEST && !TAKEN.contains(&name) {
        Ok(name)
    } else {
        Err(HeaderError::Name(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers() {
        for good in ["half", "D05", "x_1", "a23456789012345678901234"] {
            assert_eq!(check(good), Ok(good));
        }
        for bad in [
            "",
            "1half",
            "_half",
            "ha-lf",
            "häl",
            "float",
            "class",
            "a234567890123456789012345",
            "a\nb",
        ] {
            let message = check(bad).expect_err(bad).to_string();
            assert!(message.contains("is not a C identifier"), "{message}");
        }
    }
}
