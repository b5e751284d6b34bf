//! Input from outside never takes more memory, or more of a message, than it may.

use std::borrow::Cow;

/// A message shows at most so many characters of what somebody gave.
pub(crate) const ECHO_MOST: usize = 200;
/// No message is longer, whatever it shows, characters.
const MESSAGE_MOST: usize = 4000;

/// Text that somebody gave, for a message: its beginning if it is long.
#[must_use]
pub fn short(text: &str) -> Cow<'_, str> {
    // Many a message shows it twice: as an argument, and as what is wrong with it.
    const KEPT: usize = ECHO_MOST / 2 - 20;
    let length = text.chars().count();
    if length <= ECHO_MOST {
        return text.into();
    }
    let kept: String = text.chars().take(KEPT).collect();
    format!("{kept}… ({length} characters)").into()
}

/// A message with every long argument, quotation and word cut short.
pub fn without_bulk(message: &str, arguments: impl Iterator<Item = String>) -> String {
    let mut text = message.to_owned();
    for argument in arguments {
        let value = argument.split_once('=').map(|(_, value)| value.to_owned());
        for given in [Some(argument), value].into_iter().flatten() {
            // As it is, and as a message with its line breaks escaped shows it.
            for shown in [given.clone(), given.escape_debug().to_string()] {
                if shown.chars().count() > ECHO_MOST {
                    text = text.replace(&shown, &short(&shown));
                }
            }
        }
    }
    for quote in ['`', '"', '\''] {
        if text.matches(quote).count().is_multiple_of(2) {
            let parts: Vec<_> = text.split(quote).enumerate().collect();
            let parts = parts.into_iter().map(|(n, part)| match n % 2 {
                0 => Cow::Borrowed(part),
                _ => short(part),
            });
            text = parts.collect::<Vec<_>>().join(&quote.to_string());
        }
    }
    let words: Vec<_> = text.split(' ').map(short).collect();
    let text = words.join(" ");
    if text.chars().count() <= MESSAGE_MOST {
        return text;
    }
    let kept: String = text.chars().take(MESSAGE_MOST).collect();
    format!("{kept}…")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_shows_no_more_than_200_characters_of_what_was_given() {
        let long = "a b\n".repeat(1000);
        let word = "x".repeat(1000);
        assert_eq!(short("5 N"), "5 N");
        assert!(short(&long).chars().count() <= ECHO_MOST);
        assert!(short(&word).ends_with("(1000 characters)"));
        for (message, arguments) in [
            (format!("\"{long}\" is no time"), vec![]),
            (format!("`{long}` is no \"time\""), vec![]),
            (format!("invalid value {long} given"), vec![long.clone()]),
            (format!("{long:?} given"), vec![format!("--x={long}")]),
            (format!("key = {word} is no key"), vec![]),
        ] {
            let cut = without_bulk(&message, arguments.into_iter());
            assert!(cut.chars().count() <= ECHO_MOST + 40, "{cut}");
            assert!(cut.contains("characters)"), "{cut}");
        }
        let plain = "`relax.mcap` is left from a run that isn't finished";
        assert_eq!(without_bulk(plain, std::iter::empty()), plain);
    }
}
