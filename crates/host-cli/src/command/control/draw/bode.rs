//! Frequency responses: of a loop, of a plant alone.

use super::{Points, subtitle};
use crate::command::control::plant::NamedPlant;
use crate::command::control::words::decibel;
use fractional_control::ControllerSetup;
use fractional_control::Crossing;
use fractional_control::analysis::{Cause, LoopAnalysis, LoopPoint};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

const OMEGA: &str = "ω / rad·s⁻¹";

fn over_omega(points: &[LoopPoint], value: impl Fn(&LoopPoint) -> f64) -> Points {
    points
        .iter()
        .map(|point| (point.omega_rad_s, value(point)))
        .collect()
}

/// The ends of a row of points at this height.
fn level(points: &[LoopPoint], height: f64) -> Points {
    let ends = [points.first(), points.last()].into_iter().flatten();
    ends.map(|point| (point.omega_rad_s, height)).collect()
}

/// From a floor to above the highest: at half the sample rate the hold has a zero, which would be all of the picture.
fn decibels(label: &'static str, points: &[&Points], floor: f64) -> AxisSpec<'static> {
    let all = points.iter().flat_map(|points| points.iter());
    let highest = all.map(|point| point.1).fold(0.0, f64::max);
    AxisSpec::new(label, Scale::Linear).between(floor, 10.0 * (0.1 * highest).ceil() + 10.0)
}

fn linear(label: &'static str) -> AxisSpec<'static> {
    AxisSpec::new(label, Scale::Linear)
}

/// Everything that is drawn of a loop.
struct LoopCurves {
    gain: Points,
    phase: Points,
    sensitivity: Points,
    complementary: Points,
    nyquist: Points,
    circle: Points,
    zero: Points,
    /// The half turn of which the phase keeps its margin, °.
    half_turn_deg: f64,
    half_turn: Points,
    crossover: Points,
    phase_margin: Points,
    margin_words: String,
    gain_margins: Points,
}

/// The half turn that is nearest below the phase at the crossover, °.
fn half_turn(curve: &[LoopPoint], crossing: &Crossing) -> Option<f64> {
    let mut after = curve.iter();
    let after = after.find(|point| point.omega_rad_s >= crossing.omega_rad_s)?;
    let turns = ((after.phase_rad - crossing.value).to_degrees() / 360.0 - 0.5).round();
    Some(360.0 * turns + 180.0)
}

impl LoopCurves {
    fn new(analysis: &LoopAnalysis) -> Self {
        let (curve, margins) = (&analysis.curve, &analysis.margins);
        let crossover = margins.phase;
        // An unstable loop has none.
        let stable = analysis.verdict.stable;
        let margin = crossover.filter(|_| stable);
        let turn = crossover.and_then(|crossing| half_turn(curve, &crossing));
        let half_turn_deg = turn.unwrap_or(-180.0);
        let up_to_curve = |gain: &Crossing| {
            let place = gain.omega_rad_s;
            let end = (place, -decibel(gain.value));
            [(place, 0.0), end, (f64::NAN, f64::NAN)]
        };
        let at_margin = |crossing: Crossing| {
            let there = half_turn_deg + crossing.value.to_degrees();
            vec![
                (crossing.omega_rad_s, half_turn_deg),
                (crossing.omega_rad_s, there),
            ]
        };
        let degrees = (0..=180).map(|k| (2.0 * f64::from(k)).to_radians().sin_cos());
        let gains = [margins.gain_up, margins.gain_down];
        Self {
            gain: over_omega(curve, |point| decibel(point.open.norm())),
            phase: over_omega(curve, |point| point.phase_rad.to_degrees()),
            sensitivity: over_omega(curve, |point| decibel(point.sensitivity())),
            complementary: over_omega(curve, |point| decibel(point.complementary())),
            nyquist: curve.iter().map(|p| (p.open.re, p.open.im)).collect(),
            circle: degrees.map(|(sin, cos)| (cos, sin)).collect(),
            zero: level(curve, 0.0),
            half_turn_deg,
            half_turn: level(curve, half_turn_deg),
            crossover: crossover.iter().map(|at| (at.omega_rad_s, 0.0)).collect(),
            phase_margin: margin.map(at_margin).unwrap_or_default(),
            margin_words: margin.map_or_else(
                || "phase margin".to_owned(),
                |at| format!("phase margin {:.1}°", at.value.to_degrees()),
            ),
            gain_margins: (gains.iter().flatten())
                .filter(|_| stable)
                .flat_map(up_to_curve)
                .collect(),
        }
    }

    /// Gain and phase of the open loop.
    fn open(&self) -> [Chart<'_>; 2] {
        let omega = AxisSpec::new(OMEGA, Scale::Log);
        let turn = self.half_turn_deg;
        [
            Chart {
                caption: "gain of the open loop",
                x: omega,
                y: decibels("|L| / dB", &[&self.gain], -60.0),
                series: vec![
                    Series::new("open loop L", &self.gain, Look::Line, 0),
                    Series::new("", &self.zero, Look::Dotted, 5),
                    Series::new("gain margin", &self.gain_margins, Look::Broad, 2),
                    Series::new("crossover", &self.crossover, Look::Markers, 1),
                ]
                .into_iter()
                .filter(|series| !series.points.is_empty())
                .collect(),
            },
            Chart {
                caption: "its phase",
                x: omega,
                y: linear("phase / °").between(turn - 180.0, turn + 180.0),
                series: vec![
                    Series::new("open loop L", &self.phase, Look::Line, 0),
                    Series::new("", &self.half_turn, Look::Dotted, 5),
                    Series::new(&self.margin_words, &self.phase_margin, Look::Broad, 1),
                ]
                .into_iter()
                .filter(|series| !series.points.is_empty())
                .collect(),
            },
        ]
    }

    /// The closed loop, and the open one around −1.
    fn closed(&self) -> [Chart<'_>; 2] {
        let both = [&self.sensitivity, &self.complementary];
        let s = Series::new("|S|, errors and disturbances", both[0], Look::Line, 1);
        let t = Series::new("|T|, reference and noise", both[1], Look::Line, 2);
        [
            Chart {
                caption: "closed loop",
                x: AxisSpec::new(OMEGA, Scale::Log),
                y: decibels("gain / dB", &both, -40.0),
                series: vec![s, t, Series::new("", &self.zero, Look::Dotted, 5)],
            },
            Chart {
                caption: "L near −1 (the mark)",
                x: linear("Re L").between(-3.0, 2.0),
                y: linear("Im L").between(-2.0, 2.0),
                series: vec![
                    Series::new("open loop L", &self.nyquist, Look::Line, 0),
                    Series::new("|L| = 1", &self.circle, Look::Dotted, 5),
                    Series::new("", &[(-1.0, 0.0)], Look::Markers, 1),
                ],
            },
        ]
    }
}

/// Bode with margins, sensitivities, and Nyquist's curve near −1.
///
/// # Errors
/// If there is nothing to draw.
pub(in crate::command::control) fn draw_loop(
    analysis: &LoopAnalysis,
    plant: &NamedPlant,
    file: &ControllerSetup,
) -> Result<Picture, FigureError> {
    let verdict = match (analysis.verdict.stable, analysis.cause, analysis.coarse) {
        (true, _, None) => "stable, proved",
        (true, _, Some(_)) => "stable by the sampled model",
        (false, Cause::Boundary | Cause::Cancelled, _) => "on the boundary",
        (false, Cause::TooLarge | Cause::NearWhole(_), _) => "not decided",
        (false, _, None) => "unstable, proved",
        (false, _, Some(_)) => "unstable by the sampled model",
    };
    let curves = LoopCurves::new(analysis);
    ChartPage {
        title: &format!("A sampled loop: {verdict}"),
        subtitle: &subtitle(plant, file),
        columns: 2,
        charts: curves.open().into_iter().chain(curves.closed()).collect(),
    }
    .draw()
}

/// Bode of a plant alone.
///
/// # Errors
/// If there is nothing to draw.
pub(in crate::command::control) fn draw_plant(
    points: &[LoopPoint],
    plant: &NamedPlant,
) -> Result<Picture, FigureError> {
    let gain = over_omega(points, |point| decibel(point.open.norm()));
    let phase = over_omega(points, |point| point.phase_rad.to_degrees());
    let chart = |caption, label, points| Chart {
        caption,
        x: AxisSpec::new(OMEGA, Scale::Log),
        y: AxisSpec::new(label, Scale::Linear),
        series: vec![Series::new("", points, Look::Line, 0)],
    };
    ChartPage {
        title: "A plant alone",
        subtitle: &format!("plant {}", plant.words),
        columns: 2,
        charts: vec![
            chart("gain", "|G| / dB", &gain),
            chart("phase", "phase / °", &phase),
        ],
    }
    .draw()
}
