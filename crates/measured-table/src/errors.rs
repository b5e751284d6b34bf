//! Columns of errors beside measured ones, as tables of means name them.
//! ```text
//! G' SD (Pa), modulus_std_kpa, stress ±, u(G'), standard error of stress     belongs to the column that the rest of the name names
//! SD, ±, Std. Dev. (kPa)                                                      belongs to the column to its left
//! ```
//! Without a unit an error has that of its column; in per cent of what is no ratio it is a share of the value; beside logarithms it is one of
//! them. A standard deviation, a standard error and an uncertainty are alike here: they weigh rows against each other.

use super::column::Column;
use super::header::{plain, split, understand};
use super::heading::Heading;
use super::unit::of_suffix;

/// Words for an error, the longer before what begins like them.
const WORDS: &str = "standard deviation, standard error, std. error, std error, std. dev., std. dev, std dev, std.dev., st. dev., stddev, stdev, \
                     stderr, std, s.d., sd, s.e.m., sem, s.e., se, error, err, uncertainty, unc, ±, standardabweichung, standardfehler, stabw, \
                     messunsicherheit, unsicherheit, fehler, écart-type, écart type, ecart-type, incertitude, erreur, desviación estándar, \
                     deviazione standard, incertezza, 标准差";
/// Letters that are an error before a quantity in brackets.
const LETTERS: [&str; 3] = ["u", "σ", "sigma"];
const JOINTS: [char; 7] = [' ', '_', '-', '(', ')', '[', ']'];

/// A column that was found: its quantity, place and name.
pub(super) type Measured<'a> = (Column, usize, &'a str);

/// A column with the errors of a measured one.
pub(super) struct ErrorColumn {
    /// The index of the measured column among those that were found.
    pub(super) of: usize,
    pub(super) place: usize,
    pub(super) name: String,
    scale: Scale,
}

#[derive(Clone, Copy)]
enum Scale {
    /// Scale of the measured column.
    Alike,
    /// Size of one in SI units.
    Factor(f64),
    /// Share of the value.
    Share(f64),
}

impl ErrorColumn {
    /// The error in SI units of a value, of a column with this factor, or of logarithms to this base.
    pub(super) fn size(&self, base: Option<f64>, cell: f64, value: f64, factor: f64) -> f64 {
        match (base, self.scale) {
            (Some(base), _) => value.abs() * libm::log(base) * cell,
            (None, Scale::Share(share)) => share * value.abs() * cell,
            (None, Scale::Factor(size)) => size * cell,
            (None, Scale::Alike) => factor * cell,
        }
    }

    /// That of a name which says that it holds errors, if one of the columns that were found is meant.
    pub(super) fn named(
        heading: &Heading,
        measured: &[Measured<'_>],
        place: usize,
    ) -> Option<Self> {
        let name = &heading.names[place];
        let header = name.trim().replace("+/-", "±");
        let below = Some(heading.below(place)).filter(|below| !below.is_empty());
        let (head, inside) = split(&header);
        let mut ways = vec![(header.clone(), None), (head, inside)];
        let marks = header.match_indices('_');
        ways.extend(marks.map(|(mark, _)| {
            (
                header[..mark].to_owned(),
                Some(of_suffix(&header[mark + 1..])),
            )
        }));
        ways.into_iter().find_map(|(text, unit)| {
            let rest = rest(&text)?;
            let unit = below.map(str::to_owned).or(unit);
            let of = measured.iter().position(|one| {
                let is_beside = rest.is_empty() && one.1 + 1 == place;
                has_errors(one.0) && (is_beside || is_meant(*one, rest, unit.as_deref()))
            })?;
            let unit = unit.or_else(|| split(rest).1);
            let dimension = measured[of].0.dimension();
            let scale = match unit.as_deref() {
                None | Some("") => Scale::Alike,
                Some(unit) => match (dimension.size(unit), unit) {
                    (Some(size), _) => Scale::Factor(size.si),
                    (None, "%") => Scale::Share(0.01),
                    (None, _) => return None,
                },
            };
            Some(Self {
                of,
                place,
                name: name.clone(),
                scale,
            })
        })
    }
}

const fn has_errors(column: Column) -> bool {
    !matches!(column, Column::Time | Column::Omega | Column::Temperature)
}

/// A name without its word for an error; `None` if it has none.
fn rest(text: &str) -> Option<&str> {
    let word_at = |text: &str, word: &str| text.eq_ignore_ascii_case(word);
    let bare = |rest: &'_ str| rest.starts_with(JOINTS) || rest.is_empty();
    let behind = |word: &str| {
        let head = text.get(..word.len()).filter(|head| word_at(head, word));
        head.map(|_| &text[word.len()..])
    };
    let closed = text.trim_end_matches([')', ']']);
    let before = |word: &str| {
        let at = closed.len().checked_sub(word.len())?;
        let tail = closed.get(at..).filter(|tail| word_at(tail, word));
        tail.map(|_| &closed[..at])
    };
    let letters = LETTERS
        .into_iter()
        .filter_map(|letter| behind(letter).filter(|rest| rest.starts_with('(')));
    let words = WORDS.split(", ").filter_map(|word| {
        let behind = behind(word).filter(|rest| bare(rest) || word == "±");
        behind.or_else(|| before(word).filter(|rest| rest.ends_with(JOINTS) || word == "±"))
    });
    let rest = words.chain(letters).next()?.trim_matches([' ', '_', '-']);
    let rest = ["of ", "in ", "on "]
        .iter()
        .find_map(|word| rest.strip_prefix(word))
        .unwrap_or(rest);
    let inside = rest
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')'));
    Some(inside.unwrap_or(rest).trim_end_matches(['(', '[']).trim())
}

/// True if the rest of a name is that of this column.
fn is_meant((column, _, name): Measured<'_>, rest: &str, unit: Option<&str>) -> bool {
    let bare = |name: &str| plain(&split(name).0);
    let quantity = || understand(rest, unit.unwrap_or_default());
    !rest.is_empty()
        && (plain(name) == plain(rest)
            || bare(name) == bare(rest)
            || quantity().is_some_and(|meaning| meaning.column == column))
}
