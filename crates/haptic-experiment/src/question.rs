//! Questions to a device as TOML: one table, `[zwidth]`, `[design]` or that of an analysis, read as experiments are.

pub(crate) mod calibration;
mod machine_check;
pub(crate) mod measurement;
pub(crate) mod zwidth;

pub use calibration::{CalibrationReport, Calibrator, GRAVITY, Person};
use haptic_document::{
    Document, Failure, Warn,
    parameters::{ON_DEVICE, Parameter},
};
pub use haptic_question::design::coupler::CouplerAnswer;
pub use haptic_question::design::front::{FrontReport, FrontWall};
pub use haptic_question::design::{Candidate, DesignReport};
pub use haptic_question::zwidth::{BoundaryPoint, ZWidthReport};
use haptic_question::{
    analysis::{self, Analysed, Analysis, Drawn, Region},
    bench::BENCH,
    design::{self, DesignWish, WallDesign, coupler::CouplerDesign, front::Front},
    zwidth::ZWIDTH,
};
use haptic_run::{document::read_document, folder::OutputFolder};
use haptic_trial::device_table::with_devices;
pub use machine_check::RtCheck;
pub use measurement::{MeasureReport, Measurement};
use serde::Serialize;
use serde_json::Value;
use std::{
    path::Path,
    sync::{Arc, atomic::AtomicBool},
};
use zwidth::ZWidthSearch;

/// Names of the tables of all questions to a device.
pub const QUESTIONS: [&str; 12] = [
    "zwidth",
    "design",
    "analyze-admittance",
    "analyze-environment",
    "analyze-stability",
    "analyze-stability-region",
    "analyze-passivity",
    "analyze-coupling",
    "analyze-teleoperation",
    "analyze-transparency",
    "analyze-difference",
    "analyze-sensitivity",
];

/// Tables of a question, or of a measurement: heading and parameters.
pub(crate) fn tables(kind: &str) -> Vec<(&'static str, &'static [Parameter])> {
    match kind {
        "zwidth" => vec![("Z-width", ZWIDTH), ("bench", BENCH), ("device", ON_DEVICE)],
        "design" => vec![("design", design::DESIGN), ("bench", BENCH)],
        calibration::CALIBRATION => calibration::TABLES.to_vec(),
        _ => analysis::tables(kind)
            .unwrap_or(&haptic_measurement::TABLES)
            .to_vec(),
    }
}

/// A question, all of its parameters checked.
///
/// ```
/// use haptic_experiment::question::Question;
/// use std::path::Path;
/// use std::sync::Arc;
///
/// let text = "[design]\nrequire = \"passive\"\nscheme = \"muir:3\"\nsample_time_s = 0.002\norders = [1]";
/// let question = Question::parse(Path::new("form"), text)?;
/// assert_eq!(question.steps(), 1);
/// let answer = question.answer(&|_| {}, &Arc::default(), &|_| {})?;
/// // Theorem 1 without delay: K up to 2b/T.
/// let stiffness = serde_json::to_value(&answer)?["best"]["stiffness_n_per_m"].as_f64().expect("a wall");
/// assert!((stiffness / 3500.0 - 1.0).abs() < 1e-3);
/// let wrong = Question::parse(Path::new("form"), "[design]\nwish = \"peace\"");
/// assert_eq!(
///     wrong.expect_err("no wish of a wall").to_string(),
///     "form:2: wish = \"peace\" is not one of stiffest-wall, most-damping, tissue, controller, coupler"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Question(Asked);

/// A question of any kind.
#[derive(Clone, Debug)]
enum Asked {
    /// `[zwidth]`: how stiff a wall can be rendered?
    ZWidth(Box<ZWidthSearch>),
    /// `[design]`: what is the most that a device can render?
    Design(Box<WallDesign>),
    /// `[design]` with the wish coupler.
    Coupler(CouplerDesign),
    /// `[design]` with the key front.
    Front(Box<Front>),
    Analysis(Box<Analysis>),
}

impl Question {
    /// Reads and checks the text of a question; `path` is for messages and for the paths in it.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Failure> {
        Self::open(&Document::of_text(path, text))
    }

    /// Reads and checks a document.
    ///
    /// # Errors
    /// If it is wrong: in one line, with its place.
    pub fn open(document: &Document) -> Result<Self, Failure> {
        let document = document.parse()?;
        let words = format!("a question has one of [{}]", QUESTIONS.join("], ["));
        let (kind, table, _) = document.one_of(&QUESTIONS, &[], "question", &words)?;
        let table = with_devices(table.with_keys(&tables(kind))?)?;
        if let Some(analysis) = Analysis::read(kind, &table, read_document) {
            return Ok(Self(Asked::Analysis(Box::new(analysis?))));
        }
        Ok(Self(match kind {
            "zwidth" => Asked::ZWidth(Box::new(ZWidthSearch::of(&table)?)),
            _ if table.flag(&design::FRONT)? => {
                Asked::Front(Box::new(design::reading::front(&table)?))
            }
            _ => match design::reading::wish(&table)? {
                DesignWish::Coupler => Asked::Coupler(design::reading::coupler(&table)?),
                wish @ (DesignWish::StiffestWall
                | DesignWish::MostDamping
                | DesignWish::Tissue
                | DesignWish::Controller) => {
                    Asked::Design(Box::new(design::reading::design(&table, wish)?))
                }
            },
        }))
    }

    /// True if it concerns the simulated device.
    #[must_use]
    pub const fn is_simulated(&self) -> bool {
        !matches!(&self.0, Asked::ZWidth(zwidth) if zwidth.remote.is_some())
    }

    /// Number of steps in the reported progress.
    #[must_use]
    pub fn steps(&self) -> u64 {
        match &self.0 {
            Asked::ZWidth(asked) => asked.zwidth.cells(),
            Asked::Design(design) => design.steps() as u64,
            Asked::Coupler(design) => design.orders.len() as u64,
            Asked::Front(front) => front.design.orders.len() as u64,
            Asked::Analysis(asked) => asked.steps(),
        }
    }

    /// A wall among all walls of its device: outlines of about so many points, margins, noise and curves, as a page draws them.
    ///
    /// # Errors
    /// Another question than one to the loop of a wall with units; a wall that cannot be analysed.
    pub fn wall_map(&self, points: usize, position_noise_m: f64) -> Result<Value, Failure> {
        if let Asked::Analysis(asked) = &self.0 {
            return asked.wall_map(points, position_noise_m);
        }
        Err(Failure::bad_input("only a wall has a map"))
    }

    /// Answers the question. `progress` receives the steps done; setting `stop` ends it, and a
    /// Z-width keeps its finished points.
    ///
    /// # Errors
    /// A device that cannot be used; a design that was stopped.
    pub fn answer(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &Arc<AtomicBool>,
        warn: Warn<'_>,
    ) -> Result<Answer, Failure> {
        match &self.0 {
            Asked::ZWidth(zwidth) => {
                let found = zwidth.run(progress, stop, warn)?;
                found.warn(warn);
                Ok(Answer::ZWidth(Box::new(found)))
            }
            Asked::Design(design) => {
                let found = design.answer(stop, progress)?;
                Ok(Answer::Design(Box::new(found)))
            }
            Asked::Coupler(design) => {
                let found = design.answer(stop, progress)?;
                Ok(Answer::Coupler(Box::new(found)))
            }
            Asked::Front(front) => {
                let found = front.answer(stop, progress)?;
                Ok(Answer::Front(Box::new(found)))
            }
            Asked::Analysis(asked) => {
                let found = asked.answer(progress, stop, warn)?;
                Ok(Answer::Analysis(Box::new(found)))
            }
        }
    }
}

/// The answer to a question: whose JSON and rows are those of its kind.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// The stiffest walls of a device.
    ZWidth(Box<ZWidthReport>),
    /// The best wall of each order.
    Design(Box<DesignReport>),
    /// The stiffest coupler of each order.
    Coupler(Box<CouplerAnswer>),
    /// The walls that none beats.
    Front(Box<FrontReport>),
    /// An analysis, as of stability, passivity or transparency.
    Analysis(Box<Analysed>),
}

impl Answer {
    /// The best that was found, in a few words for a title.
    #[must_use]
    pub fn verdict(&self) -> String {
        let (order, simulated) = match self {
            Self::ZWidth(report) => return report.stiffest(),
            Self::Analysis(found) => return found.verdict(),
            Self::Front(found) => {
                let (kept, compared) = (found.walls.len(), found.compared);
                return format!("{kept} of {compared} walls are beaten by none");
            }
            Self::Design(found) if found.controller.is_some() => return found.of_controller(),
            Self::Design(found) => (
                found.best.as_ref().and_then(|best| best.order),
                found.simulated,
            ),
            Self::Coupler(found) => (found.best.as_ref().map(|best| best.order), found.simulated),
        };
        let Some(order) = order else {
            return "nothing on the grid does it".to_owned();
        };
        let tried = simulated.map(|settling| format!(", {} when tried", settling.verdict.words()));
        format!("best: order {order}{}", tried.unwrap_or_default())
    }

    /// Writes its table, if it has one, into the folder and returns the path.
    ///
    /// # Errors
    /// A table that cannot be written.
    pub fn write_table(&self, folder: &OutputFolder) -> Result<Option<String>, Failure> {
        let written = match self {
            Self::ZWidth(report) if report.controller.is_some() => {
                folder.write_table(&[], report.scales.iter())
            }
            Self::ZWidth(report) if report.hands.is_some() => {
                folder.write_table(&[], report.interval_rows())
            }
            Self::ZWidth(report) => folder.write_table(&[], report.rows()),
            Self::Design(found) => folder.write_table(&[], found.candidates.iter()),
            Self::Coupler(found) => folder.write_table(&[], found.candidates.iter()),
            Self::Front(found) => folder.write_table(&[], found.walls.iter()),
            Self::Analysis(found) => match &found.drawn {
                None => return Ok(None),
                Some(Drawn::Felt(points)) => folder.write_table(&[], points.iter()),
                Some(Drawn::Region(region)) => folder.write_table(&Region::COLUMNS, region.rows()),
                Some(Drawn::Admittance { points, .. }) => folder.write_table(&[], points.iter()),
                Some(Drawn::Difference(points)) => folder.write_table(&[], points.iter()),
                Some(Drawn::Sensitivity(points)) => folder.write_table(&[], points.iter()),
                Some(Drawn::Teleoperation { points, .. }) => folder.write_table(&[], points.iter()),
            },
        };
        written.map(Some)
    }

    /// Refuses a search that found nothing, or a design whose best is not stable in its trial; lesser
    /// problems go to `warn`.
    ///
    /// # Errors
    /// Exit code 1.
    pub fn require(&self, warn: Warn<'_>) -> Result<(), Failure> {
        match self {
            Self::Analysis(_) => Ok(()),
            Self::ZWidth(found) => found.require(),
            Self::Design(found) => found.require(warn),
            Self::Coupler(found) => found.require(),
            Self::Front(found) => found.require(),
        }
    }

    /// The experiment file that tries the best wall or coupler.
    #[must_use]
    pub fn experiment_text(&self) -> Option<&str> {
        match self {
            Self::ZWidth(_) | Self::Analysis(_) | Self::Front(_) => None,
            Self::Design(found) => found.experiment_text.as_deref(),
            Self::Coupler(found) => found.experiment_text.as_deref(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_question::design::coupler::CouplerCriterion;

    fn read(text: &str) -> Result<Question, String> {
        Question::parse(Path::new("form"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_left_out_is_as_the_commands_have_it() {
        let Ok(Question(Asked::ZWidth(asked))) = read("[zwidth]") else {
            panic!("a Z-width");
        };
        let zwidth = asked.zwidth;
        let device = testkit::device::dissertation(fracdiff::Seconds(1e-3));
        assert_eq!((zwidth.points, zwidth.orders.len()), (21, 5));
        assert_eq!(zwidth.device, device);
        assert_eq!(zwidth.plan, haptic_judge::trial::TrialPlan::DEFAULT);
        let Ok(Question(Asked::Design(design))) = read("[design]") else {
            panic!("a design");
        };
        assert_eq!((design.device.plant, design.orders.len()), (device, 9));
        assert_eq!(design.gain_margin, Some(2.0));
        assert!(matches!(
            read("[design]\nwish = \"coupler\"\nrequire = \"passive\"\norders = [1]"),
            Ok(Question(Asked::Coupler(CouplerDesign {
                criterion: CouplerCriterion::Passive,
                ..
            })))
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
            [zwidth]\npoints = 1 | points = 1 is not a whole number from 2 to 1000: change it
            [analyze-passivity]\norder = 1\nalpha = 1\nmass_kg = 1 | omit `alpha`
            [design]\nfront = true\nwish = "most-damping" | wish belongs to a design without `front`: omit it
            [design]\nfront = true\nrequire = "every-motion" | proofs belong to a design without `front`: change it
            [analyze-sensitivity]\npoints = 1 | points = 1 is not a whole number from 2 to 100000
            [analyze-teleoperation]\nplayout = 3 | `playout` has no effect
            [zwidth]\norders = [3] | form:2: orders has 3
            [zwidth]\norders = [] | no order was given
            [zwidth]\nmass_kg = 0 | is not above 0
            [zwidth]\nwish = "coupler" | unknown key
            [zwidth]\npush_n = 200 | no wall could hold it
            [zwidth]\nduration_s = 50000 | 50000001 samples of 0.001 s, not in [10, 2e7]
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
            let is_named = error.contains(&want) && !error.contains('\n');
            assert!(is_named, "{text}: {error}");
        }
    }
}
