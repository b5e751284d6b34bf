//! Superscripts that Unicode does not have, above all μ in the unit N·s^μ/m: `s^μ` and `T^{2−μ}`.

/// Size of what is raised, over that of the line.
pub(crate) const RAISED_SIZE: f64 = 0.7;
/// Its height above the line over its own size, and over the line's.
pub(crate) const RAISE_EM: f64 = 0.5;
pub(crate) const LOWER_EM: f64 = RAISE_EM * RAISED_SIZE;

/// A part of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part<'a> {
    Level(&'a str),
    Raised(&'a str),
}

/// The parts of a line, from left to right. A `^` before anything but a Greek letter or a pair of braces stays.
pub(crate) fn parts(line: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let (mut rest, mut from) = (line, 0);
    while let Some(at) = rest[from..].find('^').map(|at| from + at) {
        let Some((raised, after)) = superscript(&rest[at + 1..]) else {
            from = at + 1;
            continue;
        };
        if at > 0 {
            parts.push(Part::Level(&rest[..at]));
        }
        parts.push(Part::Raised(raised));
        (rest, from) = (after, 0);
    }
    if !rest.is_empty() {
        parts.push(Part::Level(rest));
    }
    parts
}

/// The text right after a `^`, if it is to be raised, and the rest.
fn superscript(marked: &str) -> Option<(&str, &str)> {
    if let Some(braced) = marked.strip_prefix('{') {
        return braced.split_once('}');
    }
    let letter = marked
        .chars()
        .next()
        .filter(|letter| ('α'..='ω').contains(letter))?;
    Some(marked.split_at(letter.len_utf8()))
}

#[cfg(test)]
mod tests {
    use super::Part::{Level, Raised};
    use super::*;

    #[test]
    fn greek_letters_and_braces_are_raised_and_what_follows_is_not() {
        assert_eq!(parts("N·s^μ/m"), [Level("N·s"), Raised("μ"), Level("/m")]);
        assert_eq!(parts("T^{2−μ}"), [Level("T"), Raised("2−μ")]);
        assert_eq!(
            parts("a^μb^c^{2}"),
            [Level("a"), Raised("μ"), Level("b^c"), Raised("2")]
        );
        assert!(parts("").is_empty());
    }

    #[test]
    fn any_other_caret_stays() {
        for text in ["a^b", "^", "x^{open", "^^", "e^{"] {
            assert_eq!(parts(text), [Level(text)]);
        }
    }
}
