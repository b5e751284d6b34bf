//! Pictures: a page of charts that own their curves, and what experiments leave.

use haptic_experiment::judge::{Curves, Drawing, Theory};
use haptic_figure::{
    AxisSpec, Chart, ChartPage, FigureError, HeldPanels, Look, MeasuredCurve, Picture, PlaneFigure,
    Scale, Series, TheoryFigure,
};

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

    /// The same with one more curve, unless it has no points.
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

/// Draws panels in so many columns.
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
        Drawing::Plane { outline_m } => of_path(outline_m, curves),
    }
}

/// A run beside its closed form.
fn of_theory(theory: &Theory, curves: &Curves) -> Result<Picture, FigureError> {
    // A controller tracks a place where the force is the result, and a force where that is the load.
    let (error_label, factor) = match theory.quantity {
        "force" => ("tracking error / µm", 1e6),
        _ => ("tracking error / mN", 1e3),
    };
    let errors = curves.column("tracking_error").iter();
    let tracking_error: Vec<f64> = errors.map(|error| factor * error).collect();
    TheoryFigure {
        title: &curves.title,
        subtitle: &curves.subtitle,
        quantity: theory.quantity,
        label: theory.label,
        origin: curves.origin,
        time_s: &curves.time_s,
        values: curves.column("values"),
        closed_form: curves.column("closed_form"),
        relative_error: curves.column("relative_error"),
        record: theory.record.as_ref().map(|record| MeasuredCurve {
            time_s: &record.time_s,
            values: &record.values,
            relative_error: &record.relative_error,
            rms: record.rms,
        }),
        held: (!curves.column("drive_force_n").is_empty()).then(|| HeldPanels {
            time_s: &curves.time_s,
            label: error_label,
            tracking_error: &tracking_error,
            force_n: curves.column("drive_force_n"),
        }),
    }
    .draw()
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
    let (name, sign) = match places.has("hand") {
        true => ("hand", -1.0),
        false => ("place", 1.0),
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

/// A teleoperation: places and forces of both sides, the energy that the line took, and what was felt.
fn of_pair(stiffnesses: &[(&str, Points)], curves: &Curves) -> Result<Picture, FigureError> {
    let column = |name, scale| column(curves, name, scale);
    let places = over_time("place", "place / mm")
        .with("hand", Look::Dashed, 2, column("hand_m", 1e3))
        .with("master", Look::Line, 0, column("position_m", 1e3))
        .with("slave", Look::Line, 1, column("far_position_m", 1e3));
    // In compression both are positive, so equal curves are a line that nobody feels.
    let forces = over_time("force on the hand, and of the slave on the place", FORCE)
        .with("master", Look::Line, 0, column("force_n", -1.0))
        .with("slave", Look::Line, 1, column("far_force_n", 1.0));
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
    let run = trial.origin;
    let (device, what) = match object.is_empty() {
        true => (run.to_owned(), "wall"),
        false => (format!("device, {run}"), "coupler"),
    };
    let ends = [trial.time_s.first(), trial.time_s.last()];
    let rest = rest_m.map(|x| ends.map(|t| Some((*t?, 1e3 * x))));
    let rest: Points = rest.into_iter().flatten().flatten().collect();
    let positions = |caption: &str, time| {
        Panel::new(caption, time, linear("position / mm"))
            .with(&device, Look::Line, 0, position.iter().copied())
            .with("object", Look::Line, 2, object.iter().copied())
            .with("rest position", Look::Dashed, 1, rest.iter().copied())
    };
    let forces = |caption: String, time| {
        let panel = Panel::new(caption, time, linear(FORCE));
        panel.with(&device, Look::Line, 0, force.iter().copied())
    };
    // An impact takes milliseconds, and the rest seconds.
    let (whole, log) = (linear("time / s"), logarithmic("time / s"));
    let panels = [
        positions("position", whole),
        positions("position over log t", log),
        forces(format!("force of the {what}"), whole),
        forces("the same over log t".to_owned(), log),
    ];
    page(&trial.title, &trial.subtitle, 2, &panels)
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
}
