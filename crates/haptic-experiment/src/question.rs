//! Questions to a device as TOML: one table, `[zwidth]` or `[design]`, read as experiments are.

pub mod analysis;
pub(crate) mod bench;
pub mod design;
mod machine_check;
pub mod measurement;
pub(crate) mod zwidth;

use crate::document::Document;
use crate::document::error::FileError;
use crate::document::parameters::{ON_DEVICE, Parameter};
use crate::experiment::reading::with_devices;
use bench::BENCH;
use design::coupler::CouplerDesign;
use design::{Design, WishName};
pub use machine_check::{Machine, Plain, RtCheck};
use std::path::Path;
use zwidth::ZWidth;
pub use zwidth::{BoundaryPoint, BoundaryRow};

/// Questions to a device, the names of their tables.
pub const QUESTIONS: [&str; 2] = ["zwidth", "design"];

/// Tables of a question, or of a measurement: heading and parameters.
pub(crate) fn tables(kind: &str) -> Vec<(&'static str, &'static [Parameter])> {
    match kind {
        "zwidth" => vec![
            ("Z-width", zwidth::ZWIDTH),
            ("bench", BENCH),
            ("device", ON_DEVICE),
        ],
        "design" => vec![("design", design::DESIGN), ("bench", BENCH)],
        _ => measurement::TABLES.to_vec(),
    }
}

/// A question, all of its parameters checked.
///
/// ```
/// use haptic_experiment::question::Question;
/// use std::path::Path;
///
/// let text = "[zwidth]\norders = [0.5, 1]\npoints = 3";
/// let question = Question::parse(Path::new("form"), text)?;
/// assert_eq!(question.steps(), 6);
/// let wrong = Question::parse(Path::new("form"), "[design]\nwish = \"peace\"");
/// assert_eq!(
///     wrong.expect_err("no wish of a wall").to_string(),
///     "form:2: wish = \"peace\" is not one of stiffest-wall, most-damping, tissue, coupler"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub enum Question {
    /// `[zwidth]`: how stiff a wall can be rendered?
    ZWidth(ZWidth),
    /// `[design]`: what is the most that a device can render?
    Design(Box<Design>),
    /// `[design]` with the wish coupler.
    Coupler(CouplerDesign),
}

impl Question {
    /// Reads and checks the text of a question; `path` is for messages and for the paths in it.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        Self::open(&Document::of_text(path, text))
    }

    /// Reads and checks a document.
    ///
    /// # Errors
    /// If it is wrong: in one line, with its place.
    pub fn open(document: &Document) -> Result<Self, FileError> {
        let document = document.parse()?;
        let words = ("question", "a question has one of [zwidth], [design]");
        let (kind, table, _) = document.one_of(&QUESTIONS, &[], words)?;
        let table = with_devices(table.with_keys(&tables(kind))?)?;
        match kind {
            "zwidth" => ZWidth::of(&table).map(Self::ZWidth),
            _ => match design::reading::wish(&table)? {
                WishName::Coupler => design::reading::coupler(&table).map(Self::Coupler),
                wish => {
                    let design = design::reading::design(&table, wish)?;
                    Ok(Self::Design(Box::new(design)))
                }
            },
        }
    }

    /// Steps of which progress is told.
    #[must_use]
    pub fn steps(&self) -> u64 {
        match self {
            Self::ZWidth(zwidth) => zwidth.cells(),
            Self::Design(design) => design.orders_to_try().len() as u64,
            Self::Coupler(design) => design.orders.len() as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::design::coupler::CouplerCriterion;
    use super::*;

    fn read(text: &str) -> Result<Question, String> {
        Question::parse(Path::new("form"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_left_out_is_as_the_commands_have_it() {
        let Ok(Question::ZWidth(zwidth)) = read("[zwidth]") else {
            panic!("a Z-width");
        };
        let device = crate::dissertation_device(fracdiff::Seconds(1e-3));
        assert_eq!((zwidth.points, zwidth.orders.len()), (21, 5));
        assert_eq!(zwidth.device, device);
        assert_eq!(zwidth.plan, crate::TrialPlan::DEFAULT);
        let Ok(Question::Design(design)) = read("[design]") else {
            panic!("a design");
        };
        assert_eq!((design.device.plant, design.orders.len()), (device, 9));
        assert_eq!(design.gain_margin, Some(2.0));
        assert!(matches!(
            read("[design]\nwish = \"coupler\"\nrequire = \"passive\"\norders = [1]"),
            Ok(Question::Coupler(CouplerDesign {
                criterion: CouplerCriterion::Passive,
                ..
            }))
        ));
    }

    #[test]
    fn nobody_can_throw_a_real_device() {
        let mut document = Document::new("zwidth");
        for (key, value, words) in [
            ("device", "serial:x", "--device serial:x"),
            ("impact_m_per_s", "1", "impact=1"),
        ] {
            document.set("zwidth", key, value, words).expect("new");
        }
        let error = Question::open(&document)
            .expect_err("no effect")
            .to_string();
        let want = "impact=1: impact_m_per_s has no effect on a real device";
        assert!(error.starts_with(want), "{error}");
    }

    #[test]
    fn what_has_no_effect_or_no_meaning_is_refused_in_a_line() {
        assert!(read("").expect_err("nothing").contains("no question"));
        for [text, want] in testkit::table(
            r#"
            [zwidth]\n[design] | a second question
            [zwidth]\npoints = 1 | is not in [2, 1000]
            [zwidth]\norders = [3] | form:2: orders has 3
            [zwidth]\norders = [] | no order was given
            [zwidth]\nmass_kg = 0 | is not above 0
            [zwidth]\nwish = "coupler" | unknown key
            [zwidth]\npush_n = 200 | no wall could hold it
            [zwidth]\nduration_s = 50000 | 50000001 samples, which is not in [10, 2e7]
            [zwidth]\nwindow_s = 9 | window 9
            [design]\nscheme = "exact" | form:2
            [design]\nwish = "most-damping"\nfrequency_hz = 501 | (0, 500] Hz
            [design]\nwish = "coupler"\ngain_margin = 3 | gain_margin belongs to a wall
            [design]\nwish = "tissue" | give `tissue`
            [design]\ntissue = "fish-muscle" | belongs to the wish tissue
            [design]\nwish = "most-damping" | frequency_hz
            [design]\nfrequency_hz = 1 | belongs to another wish
            [design]\nrequire = "passive"\ngain_margin = 3 | belongs to
            [design]\nwish = "coupler"\ndevice_model = "laboratory" | ideal device
            [design]\nforce_noise_limit_n = 0.01 | encoder
            "#,
        ) {
            let error = read(&text).expect_err(&text);
            let said = error.contains(&want) && !error.contains('\n');
            assert!(said, "{text}: {error}");
        }
    }
}
