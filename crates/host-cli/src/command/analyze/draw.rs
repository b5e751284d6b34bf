//! Pictures of analyses.

use crate::picture::{Panel, Points, linear, logarithmic as axis, page};
use haptic_figure::{AxisSpec, FigureError, Look, Picture};
use haptic_quantity::written;
use haptic_question::analysis::{
    AdmittancePoint, BodyPoint, DifferencePoint, Drawn, FeltPoint, HandPoint, Kind, Region,
    SensitivityPoint, StableBodies, StableHands,
};
use haptic_question::bench::unbeaten;

/// The picture of an analysis as it may be, with its panels and without its numbers; it `seeks` the best body or coupler too.
pub(super) fn rehearsed(name: &str, seeks: bool) -> Result<Picture, FigureError> {
    let captions: &[&str] = match name {
        "admittance" if !seeks => &["impedance", "stable hands", "stable bodies"],
        "teleoperation" if !seeks => &["stiffness", "phase"],
        "admittance" => &[
            "impedance",
            "stable hands",
            "stable bodies",
            "effort",
            "noise at half the sample rate",
        ],
        "environment" | "transparency" => &["stiffness", "damping"],
        "teleoperation" => &["stiffness", "phase", "the best coupler of each order"],
        _ => &[""],
    };
    let panel = |caption: &&str| {
        Panel::new(*caption, linear(""), linear("")).with(
            "",
            Look::Line,
            0,
            [(0.0, 0.0), (1.0, 1.0)],
        )
    };
    let panels: Vec<_> = captions.iter().map(panel).collect();
    page("", "", panels.len().min(2), &panels)
}

/// The picture of an analysis.
pub(super) fn draw(drawn: &Drawn, about: &str) -> Result<Picture, FigureError> {
    let mut about = about.to_owned();
    let (title, panels) = match drawn {
        Drawn::Admittance {
            points,
            stable,
            stable_bodies: around,
            bodies,
            front,
        } => {
            let mut panels = vec![moving(points), stable_hands(stable), stable_bodies(around)];
            about += &format!(
                " · hand of {} and {}",
                written("mass_kg", stable.mass_kg),
                written("damping_n_s_per_m", stable.damping_n_s_per_m)
            );
            if front.is_empty() && !bodies.is_empty() {
                panels.extend(best_bodies(bodies));
            } else if !front.is_empty() {
                panels.extend(front_of_bodies(front));
            }
            ("A robot in the hand", panels)
        }
        Drawn::Felt(points) => felt(points),
        Drawn::Region(region) => {
            let title = match region.in_place {
                None => "Stable walls",
                Some(Kind::Tissue) => "Stable tissues with this memory",
                Some(Kind::Controller) => "Stable scales of the controller",
            };
            (title, vec![stable(region)])
        }
        Drawn::Difference(points) => (
            "Difference that a hand should feel, above 1",
            vec![difference(points)],
        ),
        Drawn::Sensitivity(points) => ("Sensitivity", vec![sensitivity(points)]),
        Drawn::Teleoperation { points, errors } => (
            "What the hand feels of a tissue far away",
            hands(points, errors),
        ),
    };
    page(title, &about, panels.len().min(2), &panels)
}

/// A value over another, where there is one.
fn over<P>(points: &[P], x: fn(&P) -> f64, value: fn(&P) -> Option<f64>) -> Points {
    let points = points.iter();
    points.filter_map(|at| Some((x(at), value(at)?))).collect()
}

fn felt(points: &[FeltPoint]) -> (&'static str, Vec<Panel<'static>>) {
    type Value = fn(&FeltPoint) -> Option<f64>;
    let panel = |caption, y, sampled: Value, continuous: Value| {
        let curve = |value| over(points, |at| at.omega_rad_s, value);
        Panel::new(caption, axis("frequency ω / rad·s⁻¹"), y)
            .with("sampled", Look::Line, 0, curve(sampled))
            .with("continuous", Look::Dashed, 1, curve(continuous))
    };
    // The mass outgrows every law at high frequencies: the law is what is looked at.
    let stiffnesses = points.iter().map(|at| at.effective_stiffness_n_per_m);
    let (low, high) = stiffnesses.fold((0.0_f64, 0.0_f64), |ends, at| {
        (ends.0.min(at), ends.1.max(at))
    });
    let stiffness = linear("effective stiffness / N·m⁻¹");
    let stiffness = if high > 0.0 && low < -10.0 * high {
        stiffness.focused(-1.2 * high, 1.2 * high)
    } else {
        stiffness
    };
    let panels = vec![
        panel(
            "stiffness",
            stiffness,
            |at| Some(at.effective_stiffness_n_per_m),
            |at| at.continuous_stiffness_n_per_m,
        ),
        panel(
            "damping",
            linear("effective damping / N·s·m⁻¹"),
            |at| Some(at.effective_damping_n_s_per_m),
            |at| at.continuous_damping_n_s_per_m,
        ),
    ];
    let mut points = points.iter();
    let title = if points.any(|at| at.continuous_stiffness_n_per_m.is_some()) {
        "Effective stiffness and damping at the hand"
    } else {
        "Effective stiffness and damping of the environment"
    };
    (title, panels)
}

/// Impedance at the hand and of the law, in free space and in contact.
fn moving(points: &[AdmittancePoint]) -> Panel<'static> {
    let curve = |value| over(points, |at| at.frequency_hz, value);
    Panel::new("impedance", axis("frequency / Hz"), axis("|F/v| / N·s·m⁻¹"))
        .with(
            "free, virtual",
            Look::Broad,
            0,
            curve(|at| Some(at.free_virtual_n_s_per_m)),
        )
        .with(
            "free, in the hand",
            Look::Dotted,
            4,
            curve(|at| Some(at.free_n_s_per_m)),
        )
        .with(
            "contact, virtual",
            Look::Broad,
            1,
            curve(|at| at.contact_virtual_n_s_per_m),
        )
        .with(
            "contact, in the hand",
            Look::Dotted,
            5,
            curve(|at| at.contact_n_s_per_m),
        )
}

/// Effort and noise of the best bodies over their order.
fn best_bodies(bodies: &[BodyPoint]) -> [Panel<'static>; 2] {
    let panel = |caption, y, value: fn(&BodyPoint) -> f64| {
        let kind = |is_lagged: bool| {
            let bodies = bodies.iter();
            let bodies = bodies.filter(move |body| body.body_lag_s.is_some() == is_lagged);
            bodies.map(move |body| (body.body_order, value(body)))
        };
        Panel::new(caption, linear("order α of the body"), axis(y))
            .with("least effort of each order", Look::Line, 2, kind(false))
            .with("lagged mass", Look::Markers, 3, kind(true))
    };
    [
        panel("effort", "rms of |F/v| / N·s·m⁻¹", |body| {
            body.effort_n_s_per_m
        }),
        panel(
            "noise at half the sample rate",
            "command / m·s⁻¹·N⁻¹",
            |body| body.command_noise,
        ),
    ]
}

/// The bodies that none beats, by kind: effort over noise with the least margin, and the least effort over the margin.
fn front_of_bodies(front: &[BodyPoint]) -> [Panel<'static>; 2] {
    let least = front.iter().map(|body| body.hand_margin);
    let least = least.fold(f64::INFINITY, f64::min);
    let mut panels = [
        Panel::new(
            "effort and noise at the least margin",
            axis("command / m·s⁻¹·N⁻¹"),
            axis("rms of |F/v| / N·s·m⁻¹"),
        ),
        Panel::new(
            "effort and margin",
            axis("factor on the hands"),
            axis("least rms of |F/v| / N·s·m⁻¹"),
        ),
    ];
    for (colour, (name, is_kind)) in BODY_KINDS.into_iter().enumerate() {
        let bodies = front.iter().filter(|body| is_kind(body));
        let is_least = |body: &&BodyPoint| body.hand_margin <= least * 1.001;
        let quiet = bodies.clone().filter(is_least);
        let quiet = quiet.map(|body| (body.command_noise, body.effort_n_s_per_m));
        let wide = bodies.map(|body| (body.hand_margin, body.effort_n_s_per_m));
        let quiet = of_unbeaten(quiet.collect(), |(noise, effort)| [-noise, -effort]);
        let wide = of_unbeaten(wide.collect(), |(margin, effort)| [margin, -effort]);
        let mut points = [quiet, wide].into_iter();
        panels = panels.map(|panel| {
            let points = points.next().unwrap_or_default();
            panel.with(name, Look::Markers, 2 + colour, points)
        });
    }
    panels
}

fn of_unbeaten(
    places: Vec<(f64, f64)>,
    merits: impl Fn((f64, f64)) -> [f64; 2],
) -> Vec<(f64, f64)> {
    let kept = unbeaten(&places, |place| merits(*place));
    kept.into_iter().map(|n| places[n]).collect()
}

/// Kinds of bodies, each with its name.
type BodyKind = (&'static str, fn(&BodyPoint) -> bool);
const BODY_KINDS: [BodyKind; 3] = [
    ("order other than 1", |body| {
        body.body_lag_s.is_none() && !body.is_mass_and_damper()
    }),
    ("mass and damper", BodyPoint::is_mass_and_damper),
    ("lagged mass", |body| body.body_lag_s.is_some()),
];

/// Least stiffness that is drawn, N/m.
const SOFTEST: f64 = 1.0;
/// Inertances that are drawn, so many times below the body's own.
const INERTANCES_BELOW: f64 = 100.0;

/// A panel with these intervals over their places as areas, drawn from `floor` on.
fn with_areas(
    panel: Panel<'static>,
    places: &[(f64, Vec<[f64; 2]>)],
    floor: f64,
) -> Panel<'static> {
    // Areas that are still open: their borders so far, the lower and the upper one.
    let mut open: Vec<[Vec<(f64, f64)>; 2]> = Vec::new();
    let mut closed = Vec::new();
    for (place, stable) in places {
        let mut next = Vec::new();
        for &[low, high] in stable {
            let met = open.iter().position(|[lower, upper]| {
                let ends = lower.last().zip(upper.last());
                ends.is_some_and(|(lower, upper)| lower.1 < high && low < upper.1)
            });
            let [mut lower, mut upper] =
                met.map_or_else(Default::default, |index| open.remove(index));
            lower.push((*place, low.max(floor)));
            upper.push((*place, high.max(floor)));
            next.push([lower, upper]);
        }
        closed.append(&mut open);
        open = next;
    }
    closed.append(&mut open);
    closed.into_iter().fold(panel, |panel, [lower, upper]| {
        let outline = lower.into_iter().chain(upper.into_iter().rev());
        panel.with("stable", Look::Area, 0, outline)
    })
}

/// Axes that areas fill: an edge where only the search ends is the frame of the picture.
fn filled<'a>(
    [x, y]: [AxisSpec<'a>; 2],
    places: &[(f64, Vec<[f64; 2]>)],
    floor: f64,
    own: f64,
) -> [AxisSpec<'a>; 2] {
    let ends = places.first().zip(places.last());
    let heights = places.iter().flat_map(|place| place.1.iter().flatten());
    let (low, high) = heights.fold((own, own), |(low, high), at| (low.min(*at), high.max(*at)));
    let low = if low > floor { 0.5 * low } else { floor };
    [
        ends.map_or(x, |(first, last)| x.between(first.0, last.0)),
        if low < high { y.between(low, high) } else { y },
    ]
}

/// Stable inertances of the body over its damping, and the body.
fn stable_bodies(stable: &StableBodies) -> Panel<'static> {
    let label = if stable.order.to_bits() == 1.0_f64.to_bits() {
        "mass of the body / kg"
    } else {
        "inertance of the body / N·s¹⁺ᵅ·m⁻¹"
    };
    let least = stable.body[1] / INERTANCES_BELOW;
    let axes = [axis("damping of the body / N·s·m⁻¹"), axis(label)];
    let [x, y] = filled(axes, &stable.dampings, least, stable.body[1]);
    let panel = Panel::new("stable bodies", x, y);
    let panel = with_areas(panel, &stable.dampings, least);
    let own = Some(stable.body).filter(|[damping, _]| *damping > 0.0);
    panel.with("your body", Look::Markers, 1, own.map(Into::into))
}

/// Stable stiffnesses of a hand over the spring that it meets, as areas, and those that were asked for.
fn stable_hands(stable: &StableHands) -> Panel<'static> {
    let [low, high] = stable.hands_n_per_m.map(|hand| hand.max(SOFTEST));
    let axes = [
        axis("spring of a wall / N·m⁻¹"),
        axis("stiffness of the hand / N·m⁻¹"),
    ];
    let [x, y] = filled(axes, &stable.springs, SOFTEST, high);
    let panel = with_areas(Panel::new("stable hands", x, y), &stable.springs, SOFTEST);
    // A tissue is at no place between springs: the hands alone are shown.
    let Some(spring) = stable.spring_n_per_m else {
        let ends = [stable.springs.first(), stable.springs.last()];
        let across = |hand: f64| ends.into_iter().flatten().map(move |end| (end.0, hand));
        let gap = (f64::NAN, f64::NAN);
        let both = across(low).chain([gap]).chain(across(high));
        return panel.with("your hands", Look::Dashed, 1, both);
    };
    let last = spring.max(SOFTEST);
    // Free space is left of every spring: a broad line on the edge.
    if last <= SOFTEST {
        return panel.with("your hands", Look::Broad, 1, [(last, low), (last, high)]);
    }
    let asked = [
        (SOFTEST, low),
        (last, low),
        (last, high),
        (SOFTEST, high),
        (SOFTEST, low),
    ];
    panel.with("your hands", Look::Dashed, 1, asked)
}

fn difference(points: &[DifferencePoint]) -> Panel<'static> {
    let curve = |value| over(points, |at| at.frequency_hz, value);
    Panel::new(
        "",
        axis("frequency / Hz"),
        linear("difference over what is noticed"),
    )
    .with(
        "other law, stiffness",
        Look::Line,
        0,
        curve(|at| at.other_stiffness),
    )
    .with(
        "other law, damping",
        Look::Line,
        1,
        curve(|at| at.other_damping),
    )
    .with(
        "spring and damper, stiffness",
        Look::Dashed,
        0,
        curve(|at| Some(at.spring_and_damper_stiffness)),
    )
    .with(
        "spring and damper, damping",
        Look::Dashed,
        1,
        curve(|at| Some(at.spring_and_damper_damping)),
    )
    .with(
        "noticed from here on",
        Look::Dotted,
        5,
        curve(|_| Some(1.0)),
    )
}

fn stable(region: &Region) -> Panel<'static> {
    let (x, y) = match (region.units, region.in_place) {
        (_, Some(Kind::Controller)) => ("factor on the controller", "spring beside it / N·m⁻¹"),
        (_, Some(Kind::Tissue)) => (
            "dissipation B of the tissue / N·s^μ·m⁻¹",
            "spring K of the tissue / N·m⁻¹",
        ),
        (Some(_), None) => ("dissipation B / N·s^μ·m⁻¹", "stiffness K / N·m⁻¹"),
        (None, None) => ("dissipation β = BT^{2−μ}/m", "stiffness α = KT²/m"),
    };
    let [stiffness, dissipation] = region.units.unwrap_or([1.0; 2]);
    let in_units = |beta: f64, alpha: f64| (beta * dissipation, alpha * stiffness);
    let mut panel = Panel::new("", linear(x), linear(y));
    for part in &region.parts {
        // Closed outlines.
        let closed = part.points.iter().chain(part.points.first());
        let outline = closed.map(|at| in_units(at.beta, at.alpha));
        panel = panel.with("stable", Look::Area, 0, outline);
    }
    let (name, scaled) = match region.in_place {
        None => ("your wall", ""),
        Some(Kind::Tissue) => ("your tissue", "more or less of it"),
        Some(Kind::Controller) => ("your controller", "more or less of it"),
    };
    if region.in_place.is_some()
        && let Some(wall) = region.wall
    {
        let ray =
            [0.1, longest(region, wall)].map(|factor| in_units(factor * wall.0, factor * wall.1));
        panel = panel.with(scaled, Look::Dashed, 1, ray);
    }
    let wall = region.wall.map(|(beta, alpha)| in_units(beta, alpha));
    panel.with(name, Look::Markers, 1, wall)
}

/// The factor on a law, from 1 to 10, that takes it to the edge of the picture of its region.
fn longest(region: &Region, (beta, alpha): (f64, f64)) -> f64 {
    let points = region.parts.iter().flat_map(|part| &part.points);
    let [across, up] = points.fold([0.0_f64; 2], |most, at| {
        [most[0].max(at.beta), most[1].max(at.alpha)]
    });
    let [across, up] = [1.1 * across / beta, 1.1 * up / alpha];
    across.min(up).clamp(1.0, 10.0)
}

fn sensitivity(points: &[SensitivityPoint]) -> Panel<'static> {
    let curve = points.iter().map(|at| (at.theta, at.magnitude_db));
    let panel = Panel::new("", axis("digital frequency θ / rad"), linear("|S| / dB"));
    panel.with("|1/(1 + GH)|", Look::Line, 0, curve)
}

/// Stiffness and phase of the tissue, and as felt; and the error of the best coupler of each order.
fn hands(points: &[HandPoint], errors: &[(f64, f64)]) -> Vec<Panel<'static>> {
    type Value = fn(&HandPoint) -> f64;
    let panel = |caption, y: AxisSpec<'static>, tissue: Value, felt: Value| {
        let over = |value: Value| points.iter().map(move |at| (at.frequency_hz, value(at)));
        Panel::new(caption, axis("frequency / Hz"), y)
            .with("tissue", Look::Line, 1, over(tissue))
            .with("felt in the hand", Look::Line, 0, over(felt))
    };
    let mut panels = vec![
        panel(
            "stiffness",
            axis("|F/x| / N·m⁻¹"),
            |at| at.tissue_n_per_m,
            |at| at.felt_n_per_m,
        ),
        panel(
            "phase",
            linear("phase / °"),
            |at| at.tissue_degrees,
            |at| at.felt_degrees,
        ),
    ];
    if errors.len() > 1 {
        let caption = "the best coupler of each order";
        let panel = Panel::new(caption, linear("order μ"), linear("rms of ln(felt/tissue)"));
        panels.push(panel.with("best coupler", Look::Markers, 2, errors.iter().copied()));
    }
    panels
}
