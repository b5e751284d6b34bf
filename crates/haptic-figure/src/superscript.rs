//! Superscripts that Unicode does not have, above all μ in the unit N·s^μ/m.
//!
//! kuva knows none in an SVG, so they are put into its text: `s^μ` and `T^{2−μ}` become parts of
//! the line that are smaller and higher.

/// Size of a superscript, and its height above the line over its own size and over that of the
/// line.
const SMALLER: &str = r#"<tspan dy="-0.5em" font-size="70%">"#;
const BACK: &str = r#"<tspan dy="0.35em">"#;
const END: &str = "</tspan>";

/// The SVG with its `^μ` and `^{…}` raised. A `^` before anything else stays.
pub(super) fn raise(svg: &str) -> String {
    let mut raised = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some(at) = rest.find('^') {
        let (before, marked) = rest.split_at(at);
        let Some((superscript, after)) = superscript(&marked[1..]) else {
            raised.push_str(before);
            raised.push('^');
            rest = &marked[1..];
            continue;
        };
        raised.extend([before, SMALLER, superscript, END]);
        // The rest of the line comes down again, up to the next superscript.
        let length = after.find(['^', '<']).unwrap_or(after.len());
        if length > 0 {
            raised.extend([BACK, &after[..length], END]);
        }
        rest = &after[length..];
    }
    raised + rest
}

/// What stands right after a `^`, if it is to be raised, and what follows.
fn superscript(marked: &str) -> Option<(&str, &str)> {
    if let Some(braced) = marked.strip_prefix('{') {
        let end = braced.find(['}', '<'])?;
        return Some((&braced[..end], braced[end..].strip_prefix('}')?));
    }
    let letter = marked
        .chars()
        .next()
        .filter(|letter| ('α'..='ω').contains(letter))?;
    Some(marked.split_at(letter.len_utf8()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greek_letters_and_braces_are_raised_and_what_follows_is_not() {
        assert_eq!(
            raise("<text>N·s^μ/m</text>"),
            r#"<text>N·s<tspan dy="-0.5em" font-size="70%">μ</tspan><tspan dy="0.35em">/m</tspan></text>"#
        );
        assert_eq!(
            raise("<text>T^{2−μ}</text>"),
            r#"<text>T<tspan dy="-0.5em" font-size="70%">2−μ</tspan></text>"#
        );
    }

    #[test]
    fn any_other_caret_stays() {
        for text in ["a^b", "^", "x^{open</text>", "<text>^</text>", "e^{"] {
            assert_eq!(raise(text), text);
        }
    }
}
