//! Questions to a device as TOML: one table, `[zwidth]` or `[design]`, read as experiments are.

pub(crate) mod asked_device;
pub mod design;
pub(crate) mod keys;
mod machine_check;
pub mod measurement;
pub(crate) mod zwidth;

use crate::document::Document;
use crate::document::error::FileError;
use crate::document::parameters as p;
use crate::document::parameters::ON_DEVICE;
use crate::document::parameters::{
    CURRENT_LAG, DELAY, DEVICE, DEVICE_MODEL, ENCODER_RESOLUTION, FRICTION, Parameter, SENSOR_NOISE,
};
use crate::document::reader::Table;
use crate::experiment::reading::{remote, without};
use crate::experiment::rendering::reading::piece;
use crate::experiment::trial::TRIAL_SAMPLES;
use crate::experiment::trial::keys::{IMPACT, TRIAL_FORCE_LIMIT};
use crate::experiment::trial::reading::{device, with_devices};
use crate::experiment::wall::keys::ONE_SIDED;
use crate::question::design::keys::{
    COMPARED_AT_HZ, DESIGN_ORDERS, FORCE_NOISE_LIMIT, GAIN_MARGIN, REQUIRE, WISH, WISH_FREQUENCY,
    WISH_TISSUE,
};
use crate::question::zwidth::keys::{ZWIDTH_ORDERS, ZWIDTH_POINTS};
use crate::{Imperfections, TissuePiece};
use design::coupler::{CouplerCriterion, CouplerDesign};
use design::{Design, Device, RequireName, Requirement, Wish, WishName};
use fracdiff::{Order, Scheme};
use haptic_loop::plant::MassDamperConfig;
use keys::{BENCH, SIMULATED};
pub use machine_check::{FIT_SHARE, Machine, Plain, Rate, RtCheck, RtReport};
use std::path::Path;
use zwidth::ZWidth;
pub use zwidth::{BoundaryPoint, BoundaryRow, OrderBoundary};

/// Questions to a device, the names of their tables.
pub const QUESTIONS: [&str; 2] = ["zwidth", "design"];

/// The question that lets a device move.
pub const MEASUREMENT: &str = "measure";

/// Tables of a question, or of a measurement: heading and parameters.
pub(crate) fn tables(kind: &str) -> Vec<(&'static str, &'static [Parameter])> {
    match kind {
        "zwidth" => vec![
            ("Z-width", zwidth::keys::ZWIDTH),
            ("bench", BENCH),
            ("device", ON_DEVICE),
        ],
        "design" => vec![("design", design::keys::DESIGN), ("bench", BENCH)],
        _ => vec![
            (MEASUREMENT, measurement::keys::MEASURE),
            ("simulated", SIMULATED),
            ("device", measurement::keys::MEASURED),
        ],
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
        let choice = "a question has one of [zwidth], [design]";
        let mut found = document.tables(&QUESTIONS, choice)?.into_iter();
        let (Some((kind, table)), None) = (found.next(), found.next()) else {
            return Err(document.fail(format!("not one table: {choice}")));
        };
        let table = with_devices(table.with_keys(&tables(kind))?)?;
        match kind {
            "zwidth" => zwidth(&table).map(Self::ZWidth),
            _ => design(&table),
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

fn bench(table: &Table<'_>) -> Result<Device, FileError> {
    let (plant, sensors) = device(table, table.number(&p::SAMPLE_TIME)?)?;
    Ok(Device {
        plant,
        sensors,
        force_limit_n: table.number(&TRIAL_FORCE_LIMIT)?,
    })
}

fn zwidth(table: &Table<'_>) -> Result<ZWidth, FileError> {
    let remote = remote(table)?;
    if remote.is_some() {
        // It has its own, whatever its file says of them.
        let own = p::LESS_THAN_IDEAL.iter().chain([&IMPACT]);
        without(
            table,
            own,
            &format!(
                "on a real device, which has its own and cannot be thrown: give {device_sim}",
                device_sim = DEVICE.set_to("sim")
            ),
        )?;
    }
    let mut bench = bench(table)?;
    if remote.is_some() {
        bench.plant = Imperfections::NONE.on(bench.plant);
        bench.sensors = Imperfections::NONE.sensors;
    }
    let sample_time_s = bench.plant.sample_time.0;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    crate::experiment::reading::samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let zwidth = ZWidth {
        device: bench.plant,
        sensors: bench.sensors,
        one_sided: table.flag(&ONE_SIDED)?,
        scheme: scheme(table)?,
        orders: orders(table, &ZWIDTH_ORDERS)?,
        points: usize::try_from(table.count(&ZWIDTH_POINTS)?).unwrap_or(usize::MAX),
        plan: crate::experiment::trial::reading::plan(table, duration_s)?,
        remote,
    };
    zwidth
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(zwidth)
}

fn design(table: &Table<'_>) -> Result<Question, FileError> {
    let bench = bench(table)?;
    let wish: WishName = table.choice(&WISH)?;
    let require: RequireName = table.choice(&REQUIRE)?;
    if wish != WishName::Tissue {
        for parameter in [WISH_TISSUE, p::LIBRARY, p::AREA, p::THICKNESS] {
            foreign(table, &parameter, "the wish tissue")?;
        }
    }
    if wish == WishName::Coupler {
        return coupler(table, bench, require).map(Question::Coupler);
    }
    let requirement = match require {
        RequireName::Passive => {
            foreign(table, &GAIN_MARGIN, "the requirement stable")?;
            Requirement::Passive
        }
        RequireName::Stable => Requirement::Stable {
            gain_margin: table.number(&GAIN_MARGIN)?,
        },
    };
    let design = Design {
        device: bench,
        scheme: scheme(table)?,
        orders: in_order(orders(table, &DESIGN_ORDERS)?),
        requirement,
        wish: aim(table, wish)?,
        force_noise_limit_n: table.number_if(&FORCE_NOISE_LIMIT)?,
    };
    design
        .check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(Question::Design(Box::new(design)))
}

/// What is wanted most of a wall.
fn aim(table: &Table<'_>, wish: WishName) -> Result<Wish, FileError> {
    let frequency_hz = table.number_if(&WISH_FREQUENCY)?;
    Ok(match wish {
        WishName::MostDamping => Wish::MostDamping {
            frequency_hz: table.required(&WISH_FREQUENCY)?,
        },
        WishName::Tissue => {
            if table.text(&WISH_TISSUE)?.is_empty() {
                let reason = format!("the wish tissue needs one: give {WISH_TISSUE}");
                return Err(table.fail_at(WISH.key, reason));
            }
            let TissuePiece { material, specimen } = piece(table)?;
            Wish::Tissue {
                material: *material,
                specimen,
                frequency_hz: frequency_hz.unwrap_or(COMPARED_AT_HZ),
            }
        }
        WishName::StiffestWall | WishName::Coupler => {
            foreign(table, &WISH_FREQUENCY, "another wish")?;
            Wish::StiffestWall
        }
    })
}

/// A coupler is designed for an ideal device.
fn coupler(
    table: &Table<'_>,
    bench: Device,
    require: RequireName,
) -> Result<CouplerDesign, FileError> {
    for parameter in [GAIN_MARGIN, FORCE_NOISE_LIMIT, TRIAL_FORCE_LIMIT] {
        foreign(table, &parameter, "a wall")?;
    }
    if !bench.imperfections().is_ideal() {
        let reason = format!(
            "a coupler is designed for an ideal device: leave out {FRICTION}, {DELAY}, \
                      {CURRENT_LAG}, {ENCODER_RESOLUTION}, {SENSOR_NOISE} and {DEVICE_MODEL}"
        );
        return Err(table.fail(reason));
    }
    let ideal: MassDamperConfig = Imperfections::NONE.on(bench.plant);
    Ok(CouplerDesign {
        device: ideal,
        object: CouplerDesign::OBJECT,
        scheme: scheme(table)?,
        orders: in_order(orders(table, &DESIGN_ORDERS)?),
        criterion: match require {
            RequireName::Stable => CouplerCriterion::Llewellyn,
            RequireName::Passive => CouplerCriterion::Passive,
        },
        frequency_hz: (table.number_if(&WISH_FREQUENCY)?).unwrap_or(COMPARED_AT_HZ),
    })
}

/// Refuses a key that would have no effect.
fn foreign(table: &Table<'_>, parameter: &Parameter, of: &str) -> Result<(), FileError> {
    if !table.has(parameter) {
        return Ok(());
    }
    let key = parameter.key;
    Err(table.fail_at(key, format!("{key} belongs to {of}: omit it")))
}

fn scheme(table: &Table<'_>) -> Result<Scheme, FileError> {
    let parsed = table.text(&p::SCHEME)?.parse();
    let fail = |error: String| table.fail_at(p::SCHEME.key, error);
    match parsed.map_err(|error: fracdiff::SchemeError| fail(error.to_string()))? {
        Scheme::Exact => Err(fail(fracdiff::SchemeError::AnalysisOnly.to_string())),
        scheme => Ok(scheme),
    }
}

/// Orders of walls.
fn orders(table: &Table<'_>, parameter: &Parameter) -> Result<Vec<Order>, FileError> {
    let given = table.numbers_if(parameter)?;
    let numbers = given.unwrap_or_else(|| parameter.default_numbers());
    let order = |mu: f64| {
        let order = Order::new(mu).ok().filter(|_| (0.0..=2.0).contains(&mu));
        order.ok_or_else(|| {
            let reason = format!("orders has {mu}, which is not in [0, 2]: change it");
            table.fail_at(parameter.key, reason)
        })
    };
    numbers.into_iter().map(order).collect()
}

/// Each of them once, rising.
fn in_order(mut orders: Vec<Order>) -> Vec<Order> {
    orders.sort_by(|a, b| a.get().total_cmp(&b.get()));
    orders.dedup();
    orders
}

#[cfg(test)]
mod tests {
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
        assert_eq!(design.requirement, Requirement::Stable { gain_margin: 2.0 });
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
        for (text, want) in [
            ("", "not one table"),
            ("[zwidth]\n[design]", "not one table"),
            ("[zwidth]\npoints = 1", "is not in [2, 1000]"),
            ("[zwidth]\norders = [3]", "form:2: orders has 3"),
            ("[zwidth]\norders = []", "no order was given"),
            ("[zwidth]\nmass_kg = 0", "is not above 0"),
            ("[zwidth]\nwish = \"coupler\"", "unknown key"),
            ("[zwidth]\npush_n = 200", "no wall could hold it"),
            (
                "[zwidth]\nduration_s = 50000",
                "50000001 samples, which is not in [10, 2e7]",
            ),
            ("[zwidth]\nwindow_s = 9", "window 9"),
            ("[design]\nscheme = \"exact\"", "form:2"),
            (
                "[design]\nwish = \"most-damping\"\nfrequency_hz = 501",
                "(0, 500] Hz",
            ),
            (
                "[design]\nwish = \"coupler\"\ngain_margin = 3",
                "gain_margin belongs to a wall",
            ),
            ("[design]\nwish = \"tissue\"", "give `tissue`"),
            (
                "[design]\ntissue = \"fish-muscle\"",
                "belongs to the wish tissue",
            ),
            ("[design]\nwish = \"most-damping\"", "frequency_hz"),
            ("[design]\nfrequency_hz = 1", "belongs to another wish"),
            (
                "[design]\nrequire = \"passive\"\ngain_margin = 3",
                "belongs to",
            ),
            (
                "[design]\nwish = \"coupler\"\ndevice_model = \"laboratory\"",
                "ideal device",
            ),
            ("[design]\nforce_noise_limit_n = 0.01", "encoder"),
        ] {
            let error = read(text).expect_err(text);
            assert!(
                error.contains(want) && !error.contains('\n'),
                "{text}: {error}"
            );
        }
    }
}
