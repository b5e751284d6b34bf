//! The answer of `analyze teleoperation`: as JSON, as text, as a picture.

use haptic_analysis::{HandLine, Teleoperation, Transparency};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use serde::Serialize;

/// One frequency.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Point {
    pub(super) frequency_hz: f64,
    pub(super) tissue_n_per_m: f64,
    pub(super) tissue_degrees: f64,
    pub(super) felt_n_per_m: f64,
    pub(super) felt_degrees: f64,
    pub(super) llewellyn_ratio: f64,
}

/// The best coupler of an order.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Best {
    #[serde(skip)]
    pub(super) line: HandLine,
    /// Null for waves.
    pub(super) order: Option<f64>,
    pub(super) coupler_stiffness_n_per_m: Option<f64>,
    pub(super) coupler_dissipation_n_s_mu_per_m: Option<f64>,
    pub(super) wave_impedance_n_s_per_m: Option<f64>,
    pub(super) error: f64,
    pub(super) largest_db: f64,
    pub(super) largest_degrees: f64,
}

/// The result.
#[derive(Serialize)]
pub(super) struct Answer {
    pub(super) architecture: &'static str,
    pub(super) line_delay_s: f64,
    pub(super) tissue: String,
    pub(super) absolutely_stable: bool,
    pub(super) least_ratio: f64,
    pub(super) worst_hz: f64,
    /// The largest stable delay, s; null if not even without delay.
    pub(super) largest_delay_s: Option<f64>,
    /// True if it is the longest that was tried.
    pub(super) any_delay: bool,
    /// True if the line gives no energy at any delay.
    pub(super) passive_line: bool,
    pub(super) error: f64,
    pub(super) largest_db: f64,
    pub(super) largest_degrees: f64,
    pub(super) points: Vec<Point>,
    /// With --best, those that were found, and the best of them.
    pub(super) candidates: Vec<Best>,
    pub(super) best: Option<Best>,
    pub(super) files: Vec<String>,
}

impl Best {
    pub(super) fn new(line: HandLine, transparency: Transparency) -> Self {
        let (coupler, wave_impedance_n_s_per_m) = match line {
            HandLine::PositionPosition(coupler) | HandLine::PositionForce(coupler) => {
                (Some(coupler), None)
            }
            HandLine::Wave {
                impedance_n_s_per_m,
                ..
            } => (None, Some(impedance_n_s_per_m)),
        };
        Self {
            line,
            order: coupler.map(|coupler| coupler.order.get()),
            coupler_stiffness_n_per_m: coupler.map(|coupler| coupler.stiffness_n_per_m),
            coupler_dissipation_n_s_mu_per_m: coupler
                .map(|coupler| coupler.dissipation_n_s_mu_per_m),
            wave_impedance_n_s_per_m,
            error: transparency.error,
            largest_db: transparency.largest_db,
            largest_degrees: transparency.largest_degrees,
        }
    }
}

impl Answer {
    pub(super) fn draw(&self, hands: &Teleoperation) -> Result<Picture, FigureError> {
        let column = |value: fn(&Point) -> f64| -> Vec<(f64, f64)> {
            let points = self.points.iter();
            points.map(|p| (p.frequency_hz, value(p))).collect()
        };
        let (tissue, felt) = (column(|p| p.tissue_n_per_m), column(|p| p.felt_n_per_m));
        let (before, after) = (column(|p| p.tissue_degrees), column(|p| p.felt_degrees));
        let errors: Vec<(f64, f64)> = (self.candidates.iter())
            .filter_map(|best| Some((best.order?, best.error)))
            .collect();
        let chart = |caption, label, scale, tissue, felt| Chart {
            caption,
            x: AxisSpec::new("frequency / Hz", Scale::Log),
            y: AxisSpec::new(label, scale),
            series: vec![
                Series::new("tissue", tissue, Look::Line, 1),
                Series::new("felt in the hand", felt, Look::Line, 0),
            ],
        };
        let mut charts = vec![
            chart("stiffness", "|F/x| / N·m⁻¹", Scale::Log, &tissue, &felt),
            chart("phase", "phase / °", Scale::Linear, &before, &after),
        ];
        if errors.len() > 1 {
            charts.push(Chart {
                caption: "the best coupler of each order",
                x: AxisSpec::new("order μ", Scale::Linear),
                y: AxisSpec::new("rms of ln(felt/tissue)", Scale::Linear),
                series: vec![Series::new("best coupler", &errors, Look::Markers, 2)],
            });
        }
        let law = match hands.line {
            HandLine::PositionPosition(coupler) | HandLine::PositionForce(coupler) => format!(
                "spring {:.4} N/m · damper {:.4} N·s^{{μ}}/m · μ = {}",
                coupler.stiffness_n_per_m, coupler.dissipation_n_s_mu_per_m, coupler.order
            ),
            HandLine::Wave {
                impedance_n_s_per_m,
                ..
            } => format!("b = {impedance_n_s_per_m:.4} N·s/m"),
        };
        let subtitle = format!(
            "{} · delay {} ms · {law} · {}",
            self.architecture,
            1e3 * self.line_delay_s,
            self.tissue
        );
        ChartPage {
            title: "What the hand feels of a tissue far away",
            subtitle: &subtitle,
            columns: 2,
            charts,
        }
        .draw()
    }
}
