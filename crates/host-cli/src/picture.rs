//! Pictures: a page of charts that own their curves, and what experiments leave.

use haptic_figure::{
    AxisSpec, Chart, ChartPage, FigureError, Look, Picture, PlaneFigure, Scale, Series, envelope,
};
use haptic_judge::curves::{Curves, Drawing, Overlay, Theory};

pub(crate) type Points = Vec<(f64, f64)>;

/// The name of a file as a picture shows it: a long one without its middle.
pub(crate) fn short_name(name: &str) -> String {
    const MOST: usize = 40;
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= MOST {
        return name.to_owned();
    }
    let (head, tail) = (&letters[..MOST / 2], &letters[letters.len() - MOST / 2..]);
    head.iter().chain(&['…']).chain(tail).collect()
}

pub(crate) fn linear(label: &str) -> AxisSpec<'_> {
    AxisSpec::new(label, Scale::Linear)
}

pub(crate) fn logarithmic(label: &str) -> AxisSpec<'_> {
    AxisSpec::new(label, Scale::Log)
}

/// A chart and its curves: name, points, look, and number of a colour.
pub(crate) struct Panel<'a> {
    caption: String,
    x: AxisSpec<'a>,
    y: AxisSpec<'a>,
    curves: Vec<(String, Points, Look, usize)>,
}

impl<'a> Panel<'a> {
    pub(crate) fn new(caption: impl Into<String>, x: AxisSpec<'a>, y: AxisSpec<'a>) -> Self {
        Self {
            caption: caption.into(),
            x,
            y,
            curves: Vec::new(),
        }
    }

    /// Appends a curve, unless it has no points.
    pub(crate) fn with(
        mut self,
        name: impl Into<String>,
        look: Look,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points: Points = points.into_iter().collect();
        if !points.is_empty() {
            self.curves.push((name.into(), points, look, colour));
        }
        self
    }

    fn has(&self, name: &str) -> bool {
        self.curves.iter().any(|curve| curve.0 == name)
    }

    fn chart(&self) -> Chart<'_> {
        let curves = self.curves.iter();
        let series =
            curves.map(|(name, points, look, colour)| Series::new(name, points, *look, *colour));
        Chart {
            caption: &self.caption,
            x: self.x,
            y: self.y,
            series: series.collect(),
        }
    }
}

/// Draws panels in `columns` columns.
pub(crate) fn page(
    title: &str,
    subtitle: &str,
    columns: usize,
    panels: &[Panel<'_>],
) -> Result<Picture, FigureError> {
    ChartPage {
        title,
        subtitle,
        columns,
        charts: panels.iter().map(Panel::chart).collect(),
    }
    .draw()
}

/// A run of any kind.
///
/// # Errors
/// If there is nothing to draw.
pub(crate) fn of_run(curves: &Curves) -> Result<Picture, FigureError> {
    match &curves.drawing {
        Drawing::Theory(theory) => of_theory(theory, curves),
        Drawing::Trial {
            expected_deflection_m,
        } => of_trial(*expected_deflection_m, curves),
        Drawing::Pair { stiffnesses } => of_pair(stiffnesses, curves),
        Drawing::Side => of_side(curves),
        Drawing::Press => of_press(curves),
        Drawing::Plane { outline_m } => of_path(outline_m, curves),
    }
}

/// Columns of the runs of each kind; those behind the others are of a drive, an object or a third axis.
const COLUMNS: &str = "values closed_form relative_error reference_m position_m hand_m far_position_m force_n far_force_n taken_j \
    hand_x_m hand_y_m x_m y_m depth_m force_x_n force_y_n drive_force_n object_position_m sensed_force_n";

/// The picture of a run of this kind as it will be, with its panels and without its numbers: `None` of a kind without one.
pub(crate) fn rehearsed(
    kind: &str,
    document: &toml::Table,
) -> Option<Result<Picture, FigureError>> {
    let value = |key: &str| document.get(kind).and_then(|table| table.get(key));
    let has_drive = document.contains_key("drive");
    let is_column = |name: &&str| match *name {
        "drive_force_n" => has_drive,
        "object_position_m" => kind == "coupler",
        _ => true,
    };
    let deep = value("axes").and_then(toml::Value::as_integer) == Some(3);
    let columns = COLUMNS.split(' ').filter(is_column);
    let columns = columns.chain(deep.then_some("force_z_n"));
    let (time_s, ones) = (vec![0.0, 1.0], vec![1.0; 2]);
    let slab = value("loading").and_then(toml::Value::as_str);
    let theory = |quantity| {
        Drawing::Theory(Theory {
            quantity,
            label: FORCE,
            record: value("against").map(|_| Overlay {
                time_s: time_s.clone(),
                values: ones.clone(),
                relative_error: ones.clone(),
                rms: 1.0,
            }),
        })
    };
    let drawing = match kind {
        "relax" => theory("force"),
        "creep" if slab.is_none_or(|slab| ["compression", "shear", "tension"].contains(&slab)) => {
            theory("strain")
        }
        "creep" => theory("depth"),
        "wall" | "coupler" => Drawing::Trial {
            expected_deflection_m: None,
        },
        "touch" => Drawing::Plane {
            outline_m: Vec::new(),
        },
        "teleoperation" => Drawing::Pair {
            stiffnesses: Vec::new(),
        },
        "press" => Drawing::Press,
        _ => return None,
    };
    Some(of_run(&Curves {
        title: String::new(),
        subtitle: String::new(),
        origin: "",
        time_s: time_s.clone(),
        columns: columns.map(|name| (name, ones.clone())).collect(),
        drawing,
    }))
}

/// Steps of log t of which the largest error is drawn.
const STEPS: usize = 600;
/// The error reaches this far below the largest.
const ERROR_SPAN: f64 = 1e10;
/// An error against a record of more per cent is not drawn: where a record begins, it may be any.
const PER_CENT_MOST: f64 = 100.0;

/// A run over its closed form, linear and log–log, and its error; with what a controller left of the way, and the error against a record.
fn of_theory(theory: &Theory, curves: &Curves) -> Result<Picture, FigureError> {
    let column = |name, scale| column(curves, name, scale);
    let (closed, run) = (column("closed_form", 1.0), column("values", 1.0));
    let over = |times: &[f64], values: &[f64]| -> Points {
        std::iter::zip(times, values)
            .map(|(t, y)| (*t, *y))
            .collect()
    };
    let record = theory.record.as_ref();
    let measured = record.map_or_else(Vec::new, |record| over(&record.time_s, &record.values));
    let name = format!("{} {}", curves.origin, theory.quantity);
    let panel = |caption: String, time, y| {
        Panel::new(caption, time, y)
            .with("closed form", Look::Broad, 3, closed.iter().copied())
            .with(&name, Look::Line, 0, run.iter().copied())
            .with("measured", Look::Dashed, 4, measured.iter().copied())
    };
    let size = |point: &(f64, f64)| (point.0, point.1.abs());
    let mut errors: Points = column("relative_error", 1.0).iter().map(size).collect();
    errors.retain(|point| point.0 > 0.0 && point.1 > 0.0);
    let errors = envelope(&errors, Scale::Log, STEPS);
    let (time, log) = (linear("time / s"), logarithmic("time / s"));
    let lowest = positive(&closed).0 / 10.0;
    let over_log = above(
        logarithmic(theory.label),
        &[&closed, &run, &measured],
        lowest,
    );
    let least = positive(&errors).1 / ERROR_SPAN;
    let error = above(logarithmic("relative error"), &[&errors], least);
    let mut panels = vec![
        panel(theory.quantity.to_owned(), time, linear(theory.label)),
        panel(format!("{}, log–log", theory.quantity), log, over_log),
        Panel::new("relative error, largest per step", log, error).with(
            "relative error",
            Look::Line,
            1,
            errors,
        ),
    ];
    if !curves.column("drive_force_n").is_empty() {
        // A controller tracks a place where the force is the result, and a force where that is the load.
        let (label, factor) = match theory.quantity {
            "force" => ("tracking error / µm", 1e6),
            _ => ("tracking error / mN", 1e3),
        };
        let left = over_time("set point less measurement", label);
        let force = over_time("force of the drive", "force / N");
        panels.push(left.with("", Look::Line, 2, column("tracking_error", factor)));
        panels.push(force.with("", Look::Line, 5, column("drive_force_n", 1.0)));
    }
    if let Some(record) = record {
        let rms = 100.0 * record.rms;
        let caption = format!("run less record: rms {rms:.2} %");
        let per_cent = over(&record.time_s, &record.relative_error).into_iter();
        let per_cent = per_cent.map(|(t, error)| (t, 100.0 * error));
        let per_cent = per_cent.filter(|(_, error)| error.abs() <= PER_CENT_MOST);
        let panel = Panel::new(caption, log, linear("difference / %"));
        panels.push(panel.with("", Look::Line, 4, per_cent));
    }
    page(&curves.title, &curves.subtitle, 2, &panels)
}

/// The least and the largest of the values above 0.
fn positive(points: &[(f64, f64)]) -> (f64, f64) {
    let values = points
        .iter()
        .map(|point| point.1)
        .filter(|value| *value > 0.0);
    values.fold((f64::INFINITY, 0.0), |(low, high), value| {
        (f64::min(low, value), f64::max(high, value))
    })
}

/// An axis that a curve through zero does not stretch without end: it begins at this value or higher.
fn above<'a>(axis: AxisSpec<'a>, curves: &[&Points], floor: f64) -> AxisSpec<'a> {
    let ends = curves.iter().map(|curve| positive(curve));
    let (low, high) = ends.fold((f64::INFINITY, 0.0), |(low, high), ends| {
        (f64::min(low, ends.0), f64::max(high, ends.1))
    });
    if low < floor {
        axis.between(floor, 1.2 * high)
    } else {
        axis
    }
}

/// Pictures show the force by which a device pushes back: it is positive in compression. That of a log acts on the device along the
/// position, so it is negative there.
const FORCE: &str = "force on the hand / N";

fn over_time(caption: impl Into<String>, y: &str) -> Panel<'_> {
    Panel::new(caption, linear("time / s"), linear(y))
}

/// A column over time, in another unit.
fn column(curves: &Curves, name: &str, scale: f64) -> Points {
    let scaled = curves.column(name).iter().map(|value| scale * value);
    curves.time_s.iter().copied().zip(scaled).collect()
}

/// Time over which forces are averaged that switch from tick to tick where a line takes energy, s.
const MEAN_S: f64 = 0.02;

/// A force this many times the peak of the specimen is a knock: it is cut off, with an arrow that says how high it is.
const KNOCK: f64 = 1.3;

/// The mean of each 20 ms, as a hand or a tissue takes it.
fn smoothed(points: &Points) -> Points {
    let step = points.get(1).map_or(MEAN_S, |next| next.0 - points[0].0);
    let most = (MEAN_S / step).round().max(1.0);
    let mean = |some: &[(f64, f64)]| {
        let sum = (some.iter()).fold((0.0, 0.0), |sum, at| (sum.0 + at.0, sum.1 + at.1));
        let count = some.len() as f64;
        (sum.0 / count, sum.1 / count)
    };
    points.chunks(most as usize).map(mean).collect()
}

/// One side of a teleoperation: places and forces.
fn of_side(curves: &Curves) -> Result<Picture, FigureError> {
    let column = |name, scale| column(curves, name, scale);
    // There is no hand on the side of the slave.
    let hand = column("reference_m", 1e3).into_iter();
    let hand = hand.filter(|point| point.1.is_finite());
    let places = over_time("place", "place / mm")
        .with("hand", Look::Dashed, 2, hand)
        .with("device", Look::Line, 0, column("position_m", 1e3));
    // In compression both are positive: what the device does to hand or place, and what these do to it.
    let (name, sign) = if places.has("hand") {
        ("hand", -1.0)
    } else {
        ("place", 1.0)
    };
    let forces = over_time(format!("force on the {name}, in compression"), FORCE)
        .with(
            format!("of the device on the {name}"),
            Look::Line,
            0,
            column("force_n", sign),
        )
        .with(
            format!("of the {name} on the device"),
            Look::Line,
            1,
            column("outside_n", -sign),
        );
    page(&curves.title, &curves.subtitle, 1, &[places, forces])
}

/// A press: force and depth over time, and the force over the depth, as a testing machine shows it.
fn of_press(curves: &Curves) -> Result<Picture, FigureError> {
    let (force, depth) = ("force / N", "depth / mm");
    let depths = column(curves, "depth_m", 1e3);
    let motor = column(curves, "force_n", 1.0);
    let sensor = column(curves, "sensed_force_n", 1.0);
    let highest = |points: &Points| {
        let points = points.iter().copied();
        points.fold(
            (0.0, 0.0),
            |best: (f64, f64), at| if at.1 > best.1 { at } else { best },
        )
    };
    // The specimen's peak is that of the sensor where there is one, and where the contact knocks, that of means.
    let felt = if sensor.is_empty() { &motor } else { &sensor };
    let mean = highest(&smoothed(felt));
    let knocks = mean.1 > 0.0 && highest(&motor).1.max(highest(felt).1) > KNOCK * mean.1;
    let (peak, axis) = if knocks {
        let axis = linear(force).focused(-0.1 * mean.1, KNOCK * mean.1);
        (mean, axis)
    } else {
        (highest(felt), linear(force))
    };
    let mut over_depth = Panel::new("force over depth", linear(depth), axis);
    let mut forces = Panel::new("force on the specimen", linear("time / s"), axis);
    for (name, look, colour, points) in [
        ("motor", Look::Line, 0, motor),
        ("sensor", Look::Dashed, 1, sensor),
    ] {
        let pairs = std::iter::zip(&depths, &points);
        over_depth = over_depth.with(name, look, colour, pairs.map(|(at, y)| (at.1, y.1)));
        forces = forces.with(name, look, colour, points);
    }
    let peaks = (peak.1 > 0.0).then_some(peak);
    let forces = forces.with("peak of the specimen", Look::Markers, 5, peaks);
    let depths = over_time("depth", depth)
        .with("wanted", Look::Broad, 3, column(curves, "reference_m", 1e3))
        .with("handle", Look::Line, 2, depths);
    page(
        &curves.title,
        &curves.subtitle,
        2,
        &[forces, depths, over_depth],
    )
}

/// A teleoperation: places and forces of both sides, the energy that the line took, and what was felt.
fn of_pair(stiffnesses: &[(&str, Points)], curves: &Curves) -> Result<Picture, FigureError> {
    let column = |name, scale| column(curves, name, scale);
    let places = over_time("place", "place / mm")
        .with("hand", Look::Dashed, 2, column("hand_m", 1e3))
        .with("master", Look::Line, 0, column("position_m", 1e3))
        .with("slave", Look::Line, 1, column("far_position_m", 1e3));
    // In compression both are positive, so equal curves are a line that nobody feels.
    let forces = over_time("forces on hand and place, mean of 20 ms", FORCE)
        .with(
            "slave",
            Look::Line,
            1,
            smoothed(&column("far_force_n", 1.0)),
        )
        .with("master", Look::Line, 0, smoothed(&column("force_n", -1.0)));
    let energy = over_time("energy taken by the line", "energy / mJ");
    let energy = energy.with("line", Look::Line, 3, column("taken_j", 1e3));
    let points = |name: &str| {
        let mut curves = stiffnesses.iter();
        let found = curves.find(|curve| curve.0 == name);
        found.map_or_else(Vec::new, |curve| curve.1.clone())
    };
    let frequency = logarithmic("frequency / Hz");
    let stiffness = logarithmic("stiffness |F/x| / N·m⁻¹");
    let caption = "felt by the master, touched by the slave";
    let stiffnesses = Panel::new(caption, frequency, stiffness)
        .with("slave", Look::Line, 1, points("touched"))
        .with("formula", Look::Dashed, 4, points("formula"))
        .with("master", Look::Markers, 0, points("felt"));
    let panels = [places, forces, energy, stiffnesses];
    page(&curves.title, &curves.subtitle, 2, &panels)
}

/// A touch: the paths over the shape, the depth, and the force of each axis.
fn of_path(outline_m: &[(f64, f64)], curves: &Curves) -> Result<Picture, FigureError> {
    let forces = ["force_x_n", "force_y_n", "force_z_n"].map(|name| curves.column(name).to_vec());
    let axes = forces.iter().filter(|force| !force.is_empty()).count();
    PlaneFigure {
        title: &curves.title,
        subtitle: &curves.subtitle,
        outline_m,
        time_s: &curves.time_s,
        reference_m: ["hand_x_m", "hand_y_m"].map(|name| curves.column(name)),
        position_m: ["x_m", "y_m"].map(|name| curves.column(name)),
        depth_m: Some(curves.column("depth_m")),
        force_n: &forces[..axes],
    }
    .draw()
}

/// The trial of a wall or a coupler: device and object over the device's rest position, and the force below; over t, and over log t for
/// how it begins.
fn of_trial(rest_m: Option<f64>, trial: &Curves) -> Result<Picture, FigureError> {
    let position = column(trial, "position_m", 1e3);
    let object = column(trial, "object_position_m", 1e3);
    let force = column(trial, "force_n", 1.0);
    let drive = column(trial, "drive_force_n", 1.0);
    let run = trial.origin;
    let (device, what) = if object.is_empty() {
        (run.to_owned(), "wall")
    } else {
        (format!("device, {run}"), "coupler")
    };
    // There is no 0 on log t, and the line is seen from the first sample behind it.
    let begins = trial.time_s.iter().find(|t| **t > 0.0);
    let ends = [begins, trial.time_s.last()];
    let rest = rest_m.map(|x| ends.map(|t| Some((*t?, 1e3 * x))));
    let rest: Points = rest.into_iter().flatten().flatten().collect();
    let positions = |caption: &str, time| {
        Panel::new(caption, time, linear("position / mm"))
            .with(&device, Look::Line, 0, position.iter().copied())
            .with("object", Look::Line, 2, object.iter().copied())
            .with("rest position", Look::Dashed, 1, rest.iter().copied())
    };
    let forces = |caption: String, time| {
        Panel::new(caption, time, linear(FORCE))
            .with(&device, Look::Line, 0, force.iter().copied())
            .with("second device", Look::Dashed, 3, drive.iter().copied())
    };
    // An impact takes milliseconds, and the rest seconds: over t it is drawn until it has settled, over log t to its end.
    let (whole, log) = (
        linear("time / s").between(0.0, settled(&position)),
        logarithmic("time / s"),
    );
    let panels = [
        positions("position", whole),
        positions("position over log t", log),
        forces(format!("force of the {what}"), whole),
        forces("the same over log t".to_owned(), log),
    ];
    page(&trial.title, &trial.subtitle, 2, &panels)
}

/// Twice the time after which a curve keeps within a fiftieth of its span of its end; all of it where it does not settle.
fn settled(points: &Points) -> f64 {
    let last = points.last().copied().unwrap_or_default();
    let span = points.iter().fold((last.1, last.1), |(low, high), at| {
        (low.min(at.1), high.max(at.1))
    });
    let is_off = |at: &&(f64, f64)| (at.1 - last.1).abs() > 0.02 * (span.1 - span.0);
    let off = points.iter().rev().find(is_off);
    off.map_or(last.0, |at| 2.0 * at.0).min(last.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_of_a_file_keeps_its_ends() {
        assert_eq!(short_name("fish.tsv"), "fish.tsv");
        let long = short_name(&("a".repeat(50) + &"µ".repeat(50) + ".csv"));
        assert_eq!(long.chars().count(), 41);
        assert!(long.starts_with("aaa") && long.ends_with("µ.csv"), "{long}");
    }

    #[test]
    fn a_wall_is_drawn_until_twice_the_time_in_which_it_settles() {
        let points = |last: f64| -> Points {
            let time = (0..=100).map(f64::from);
            time.map(|t| (t, if t < 10.5 { last - 1.0 } else { last }))
                .collect()
        };
        // One that swings to its end is drawn whole, as is one that rests all along.
        let swings: Points = (0..=100)
            .map(|n| (f64::from(n), f64::from(n % 2)))
            .collect();
        let rests = vec![(0.0, 1.0), (5.0, 1.0)];
        for (curve, end) in [(points(1.0), 20.0), (swings, 100.0), (rests, 5.0)] {
            assert!((settled(&curve) - end).abs() < 1e-9, "{end}");
        }
    }

    /// A press with a knock of the contact: the specimen's peak is behind it, and the axis ends a little above.
    #[test]
    fn a_knock_is_no_peak_of_the_specimen() {
        let time_s: Vec<f64> = (0..3000).map(|n| 1e-3 * f64::from(n)).collect();
        let press = |knock: f64| {
            let force = |t: &f64| {
                if (0.5..0.503).contains(t) {
                    knock
                } else {
                    t.min(1.0)
                }
            };
            let curves = Curves {
                title: "A press".to_owned(),
                subtitle: String::new(),
                origin: "simulated",
                time_s: time_s.clone(),
                columns: vec![
                    ("force_n", time_s.iter().map(force).collect()),
                    ("depth_m", time_s.clone()),
                    ("reference_m", time_s.clone()),
                ],
                drawing: Drawing::Press,
            };
            of_run(&curves).expect("draws").svg().to_owned()
        };
        let (quiet, knocked) = (press(0.5), press(30.0));
        assert!(quiet.contains("peak of the specimen") && knocked.contains("peak of the specimen"));
        // No number of an axis is above 1.3; an arrow says how high the knock is.
        assert!(
            knocked.contains(">1.0<") && !knocked.contains(">20<"),
            "{knocked}"
        );
        assert!(knocked.contains("30") && !quiet.contains(">30<"));
    }

    /// A relaxation whose run begins below its closed form and passes through zero, and whose error is 0 at places.
    fn relaxation(record: bool, held: bool) -> String {
        let time_s: Vec<f64> = (0..3000).map(|n| 1e-3 * f64::from(n)).collect();
        let closed: Vec<f64> = time_s.iter().map(|t| (t + 1e-3).powf(-0.2)).collect();
        let error: Vec<f64> = time_s.iter().map(|t| 1e-3 * (97.0 * t).sin()).collect();
        let value = |(n, y): (usize, &f64)| if n == 1 { 1e-20 } else { *y };
        let mut columns = vec![
            ("values", closed.iter().enumerate().map(value).collect()),
            ("closed_form", closed.clone()),
            ("relative_error", error.clone()),
        ];
        if held {
            columns.push(("drive_force_n", closed.clone()));
            columns.push(("tracking_error", vec![2e-6; 3000]));
        }
        let record = record.then(|| haptic_judge::curves::Overlay {
            time_s: time_s.clone(),
            values: closed.clone(),
            relative_error: vec![0.01; 3000],
            rms: 0.0123,
        });
        let theory = Theory {
            quantity: "force",
            label: FORCE,
            record,
        };
        let curves = Curves {
            title: "A relaxation".to_owned(),
            subtitle: String::new(),
            origin: "simulated",
            time_s,
            columns,
            drawing: Drawing::Theory(theory),
        };
        of_run(&curves).expect("draws").svg().to_owned()
    }

    #[test]
    fn a_run_is_drawn_over_its_closed_form_with_its_error_and_no_axis_without_end() {
        let svg = relaxation(false, false);
        for text in [
            "simulated force",
            "closed form",
            "(a) force<",
            "(b) force, log–log",
            "(c) relative error,",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(!svg.contains("measured") && !svg.contains("(d)"));
        // Neither the run at 1e-20 nor errors near 0 make an axis of twenty decades: every label has one digit.
        assert!(
            !svg.contains(">10⁻¹⁴<") && !svg.contains(">10⁻¹⁶<"),
            "{svg}"
        );
        assert!(svg.len() < 300_000, "{}", svg.len());
    }

    #[test]
    fn a_controller_and_a_record_have_panels_of_their_own() {
        let svg = relaxation(true, true);
        for text in [
            "measured",
            "(d) set point less measurement",
            "tracking error / µm",
            "(e) force of the drive",
            "(f) run less record: rms 1.23 %",
            "difference / %",
        ] {
            assert!(svg.contains(text), "{text}");
        }
    }
}
