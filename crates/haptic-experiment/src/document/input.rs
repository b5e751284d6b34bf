//! What somebody gave, in a message.

use std::borrow::Cow;

/// The user's text, for a message, cut to its beginning if it exceeds 200 characters.
#[must_use]
pub fn short(text: &str) -> Cow<'_, str> {
    // Many a message shows it twice: as an argument, and as what is wrong with it.
    let (most, kept) = (200, 80);
    let length = text.chars().count();
    if length <= most {
        return text.into();
    }
    let kept: String = text.chars().take(kept).collect();
    format!("{kept}… ({length} characters)").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_text_is_shown_by_its_beginning() {
        assert_eq!(short("5 N"), "5 N");
        let shown = short(&"é".repeat(1000)).into_owned();
        assert!(
            shown.ends_with("é… (1000 characters)") && shown.chars().count() < 110,
            "{shown}"
        );
    }
}
