//! Keys of experiment files that take one of several names, and the names.

use crate::experiment::teleoperation::{ArchitectureName, PlaceName};
use crate::experiment::touch::{GripName, ShapeName};
use crate::question::design::{RequireName, WishName};
use crate::run::device::Loop;
use crate::{Contact, GuardChoice, Named, Precision};

/// Names that the text of a key may be, each with a few words for people; none where any text will do.
#[must_use]
pub fn choices(key: &str) -> Vec<(&'static str, &'static str)> {
    fn names<T: Named>() -> Vec<(&'static str, &'static str)> {
        let choices = T::CHOICES.iter();
        choices.map(|(_, name, help)| (*name, *help)).collect()
    }
    match key {
        "architecture" => names::<ArchitectureName>(),
        "contact" => names::<Contact>(),
        "guard" => names::<GuardChoice>(),
        "hand" => names::<GripName>(),
        "loop" => names::<Loop>(),
        "place" => names::<PlaceName>(),
        "precision" => names::<Precision>(),
        "require" => names::<RequireName>(),
        "shape" => names::<ShapeName>(),
        "wish" => names::<WishName>(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::parameters::{KINDS, QUESTIONS, Value, of_kind};

    #[test]
    fn a_default_is_one_of_the_choices() {
        let mut found = 0;
        for kind in KINDS.into_iter().chain(QUESTIONS) {
            for parameter in of_kind(kind).iter().flat_map(|(_, table)| *table) {
                let choices = choices(parameter.key);
                if let (Value::Text(default), false) = (parameter.value, choices.is_empty()) {
                    found += 1;
                    assert!(
                        choices.iter().any(|choice| choice.0 == default),
                        "{}: {default}",
                        parameter.key
                    );
                }
            }
        }
        assert!(found > 5, "{found}");
    }
}
