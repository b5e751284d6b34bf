//! `analyze teleoperation`: two hands over a line, what is stable and what is felt.

use super::arguments::{Files, logarithmic};
use crate::choice::choice;
use crate::command::words::{parse_dissipation, parse_number};
use crate::output::{Output, fixed};
use crate::quantity::{Area, Damping, Frequency, Length, Mass, Stiffness, Time};
use clap::Args;
use fracdiff::{Order, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    AnalysisError, CouplerSearch, HandCoupler, HandLine, HandMass, LargestDelay, Teleoperation,
    Transparency,
};
use haptic_experiment::ModelledTissue;
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters as p;
use haptic_experiment::teleoperation::{ArchitectureName, RemotePlace};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use haptic_link::Architecture;
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_tissue::Library;
use serde::Serialize;
use std::f64::consts::TAU;
use std::io::{self, Write};
use std::path::PathBuf;

/// Longest delay that is looked for, s.
const DELAY_MOST_S: f64 = 1.0;
/// Orders that are tried: 0, 0.05, … 1.
const ORDERS: u32 = 20;

/// Arguments of `analyze teleoperation`.
#[derive(Debug, Args)]
#[command(
    long_about = LONG_ABOUT,
    after_help = "Examples:\n  host-cli analyze teleoperation --coupler-stiffness 300 --coupler-dissipation 10 --order 0.5 --line-delay 20ms\n  \
                  host-cli analyze teleoperation --line-delay 20ms --best --out far"
)]
pub struct TeleoperationArguments {
    #[arg(long, help = p::ARCHITECTURE.help, value_parser = choice::<ArchitectureName>(), default_value = p::ARCHITECTURE.shown, help_heading = "Line")]
    architecture: ArchitectureName,
    #[arg(long, help = p::LINE_DELAY.help, default_value = p::LINE_DELAY.shown, allow_hyphen_values = true, help_heading = "Line")]
    line_delay: Time,
    #[arg(long, help = p::HAND_COUPLER_STIFFNESS.help, default_value = p::HAND_COUPLER_STIFFNESS.shown, allow_hyphen_values = true, help_heading = "Line")]
    coupler_stiffness: Stiffness,
    #[arg(long, help = p::HAND_COUPLER_DISSIPATION.help, value_name = "B_C", default_value = p::HAND_COUPLER_DISSIPATION.shown, value_parser = parse_dissipation, allow_hyphen_values = true, help_heading = "Line")]
    coupler_dissipation: f64,
    #[arg(long, help = p::HAND_COUPLER_ORDER.help, default_value = p::HAND_COUPLER_ORDER.shown, value_parser = parse_number, allow_hyphen_values = true, help_heading = "Line")]
    order: f64,
    #[arg(long, help = p::WAVE_IMPEDANCE.help, default_value = p::WAVE_IMPEDANCE.shown, allow_hyphen_values = true, help_heading = "Line")]
    wave_impedance: Damping,
    /// Samples over which waves are played out
    #[arg(long, default_value_t = 2, value_name = "SAMPLES", value_parser = clap::value_parser!(u32).range(1..=10_000), help_heading = "Line")]
    playout: u32,
    /// Find the best coupler of each order, or the best impedance of waves, for this delay and tissue
    #[arg(long, help_heading = "Line")]
    best: bool,
    #[arg(long, help = p::MASS.help, default_value = p::MASS.shown, allow_hyphen_values = true, help_heading = "Devices")]
    mass: Mass,
    #[arg(long, help = p::DAMPING.help, default_value = p::DAMPING.shown, allow_hyphen_values = true, help_heading = "Devices")]
    damping: Damping,
    #[arg(long, help = p::SLAVE_MASS.help, allow_hyphen_values = true, help_heading = "Devices")]
    slave_mass: Option<Mass>,
    #[arg(long, help = p::SLAVE_DAMPING.help, allow_hyphen_values = true, help_heading = "Devices")]
    slave_damping: Option<Damping>,
    #[arg(long, help = p::SAMPLE_TIME.help, default_value = p::SAMPLE_TIME.shown, allow_hyphen_values = true, help_heading = "Devices")]
    sample_time: Time,
    #[arg(long, help = p::TISSUE.help, value_name = "NAME", default_value = p::TISSUE.shown, help_heading = "Tissue")]
    tissue: String,
    #[arg(long, help = p::LIBRARY.help, value_name = "DIR", help_heading = "Tissue")]
    library: Option<PathBuf>,
    #[arg(long, help = p::AREA.help, default_value = p::AREA.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    area: Area,
    #[arg(long, help = p::THICKNESS.help, default_value = p::THICKNESS.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    thickness: Length,
    /// Lowest frequency at which the tissue is to feel right
    #[arg(
        long,
        default_value = "0.5Hz",
        allow_hyphen_values = true,
        help_heading = "Tissue"
    )]
    low: Frequency,
    /// Highest frequency at which the tissue is to feel right
    #[arg(
        long,
        default_value = "5Hz",
        allow_hyphen_values = true,
        help_heading = "Tissue"
    )]
    high: Frequency,
    /// Number of frequencies
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(2..=10_000), help_heading = "Tissue")]
    points: u32,
    #[command(flatten)]
    files: Files,
}

const LONG_ABOUT: &str = "\
Is a teleoperation stable with every passive hand and every passive thing at the other end (Llewellyn's criterion, with the delay of the line, \
sampled controllers and held forces)? Up to which delay? And what does the hand feel of a remote tissue?

--best looks for the coupler k_c + b_c D^mu of each order that makes the tissue feel right from --low to --high: the least root mean square of \
|ln(Z_felt/Z_tissue)|, 0.1 being 10 % or 6 degrees, among those that are stable with every hand and place at this delay. Of waves it finds the impedance.

time-domain is judged as the position-position that it is while its account of energy is not empty; itself it gives no energy at any delay.";

/// One frequency.
#[derive(Clone, Copy, Serialize)]
struct Point {
    frequency_hz: f64,
    tissue_n_per_m: f64,
    tissue_degrees: f64,
    felt_n_per_m: f64,
    felt_degrees: f64,
    llewellyn_ratio: f64,
}

/// The best coupler of an order.
#[derive(Clone, Copy, Serialize)]
struct Best {
    #[serde(skip)]
    line: HandLine,
    /// Null for waves.
    order: Option<f64>,
    coupler_stiffness_n_per_m: Option<f64>,
    coupler_dissipation_n_s_mu_per_m: Option<f64>,
    wave_impedance_n_s_per_m: Option<f64>,
    error: f64,
    largest_db: f64,
    largest_degrees: f64,
}

/// The result.
#[derive(Serialize)]
struct Answer {
    architecture: &'static str,
    line_delay_s: f64,
    tissue: String,
    absolutely_stable: bool,
    least_ratio: f64,
    worst_hz: f64,
    /// The largest stable delay, s; null if not even without delay.
    largest_delay_s: Option<f64>,
    /// True if it is the longest that was tried.
    any_delay: bool,
    /// True if the line gives no energy at any delay.
    passive_line: bool,
    error: f64,
    largest_db: f64,
    largest_degrees: f64,
    points: Vec<Point>,
    /// With --best, those that were found, and the best of them.
    candidates: Vec<Best>,
    best: Option<Best>,
    files: Vec<String>,
}

/// A question with its tissue.
struct Question {
    hands: Teleoperation,
    omegas: Vec<f64>,
    place: RemotePlace,
    environment: Vec<Complex<f64>>,
}

impl TeleoperationArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let question = self.question()?;
        let candidates = match self.best {
            true => self.candidates(&question)?,
            false => Vec::new(),
        };
        let best = (candidates.iter())
            .min_by(|a, b| a.error.total_cmp(&b.error))
            .copied();
        // What is shown is the best, if there is one.
        let hands = match best {
            Some(best) => Teleoperation {
                line: best.line,
                ..question.hands
            },
            None => question.hands,
        };
        let stability = hands.absolute_stability().map_err(refused)?;
        let largest = hands.largest_delay(DELAY_MOST_S).map_err(refused)?;
        let felt =
            (hands.transparency(&question.omegas, &question.environment)).map_err(refused)?;
        let points = question.points(&hands)?;
        let mut answer = Answer {
            architecture: self.architecture.0.name(),
            line_delay_s: self.line_delay.0,
            tissue: question.place.words(),
            absolutely_stable: stability.stable,
            least_ratio: stability.least_ratio,
            worst_hz: stability.worst_rad_s / TAU,
            largest_delay_s: match largest {
                LargestDelay::None => None,
                LargestDelay::Below { delay_s } => Some(delay_s),
                LargestDelay::Any => Some(DELAY_MOST_S),
            },
            any_delay: largest == LargestDelay::Any,
            passive_line: self.architecture.0.is_passive(),
            error: felt.error,
            largest_db: felt.largest_db,
            largest_degrees: felt.largest_degrees,
            points,
            candidates,
            best,
            files: Vec::new(),
        };
        let rows = answer.points.iter().copied();
        answer.files = (self.files).write("teleoperation", rows, || answer.draw(&hands))?;
        output.print(&answer, |out| answer.print(out))
    }

    fn question(&self) -> Result<Question, Failure> {
        let (low, high) = (self.low.0, self.high.0);
        let most = 0.5 / self.sample_time.0;
        if !(low > 0.0 && low < high && high <= most) {
            return Err(Failure::bad_input(format_args!(
                "frequencies {low} to {high} Hz are not inside 0 to {most} Hz, lowest first: change --low, --high or --sample-time"
            )));
        }
        let library = Library::load(self.library.as_deref()).map_err(Failure::input)?;
        let material = library.find(&self.tissue).map_err(Failure::input)?;
        let specimen = Specimen::new(SquareMetres(self.area.0), Metres(self.thickness.0));
        let place = RemotePlace::Tissue {
            material: Box::new(ModelledTissue::new(material)?),
            specimen: specimen.map_err(|error| {
                Failure::input_with_advice(error, "change --area or --thickness")
            })?,
        };
        let omegas: Vec<f64> = logarithmic(TAU * low, TAU * high, self.points as usize).collect();
        let environment = (omegas.iter())
            .filter_map(|&omega| Some(place.stiffness(omega)? / Complex::new(0.0, omega)))
            .collect();
        let device = |mass: Mass, damping: Damping| HandMass {
            mass_kg: mass.0,
            damping_n_s_per_m: damping.0,
        };
        let order = Order::new(self.order).map_err(Failure::input)?;
        let coupler = HandCoupler {
            stiffness_n_per_m: self.coupler_stiffness.0,
            dissipation_n_s_mu_per_m: self.coupler_dissipation,
            order,
        };
        // Checked where the loop is.
        let t = Seconds(self.sample_time.0);
        t.rate_to_the(order)
            .map_err(|error| Failure::input_with_advice(error, "give --sample-time, as in 1ms"))?;
        let hands = Teleoperation {
            master: device(self.mass, self.damping),
            slave: device(
                self.slave_mass.unwrap_or(self.mass),
                self.slave_damping.unwrap_or(self.damping),
            ),
            line: self.kind(coupler, self.wave_impedance.0),
            sample_time_s: t.0,
            delay_s: self.line_delay.0,
        };
        Ok(Question {
            hands,
            omegas,
            place,
            environment,
        })
    }

    fn kind(&self, coupler: HandCoupler, impedance_n_s_per_m: f64) -> HandLine {
        match self.architecture.0 {
            Architecture::PositionPosition | Architecture::TimeDomain => {
                HandLine::PositionPosition(coupler)
            }
            Architecture::PositionForce => HandLine::PositionForce(coupler),
            Architecture::Wave => HandLine::Wave {
                impedance_n_s_per_m,
                playout_samples: self.playout,
            },
        }
    }

    /// The best of each order, or of waves.
    fn candidates(&self, question: &Question) -> Result<Vec<Best>, Failure> {
        let search = CouplerSearch {
            hands: question.hands,
            omegas_rad_s: question.omegas.clone(),
            environment: question.environment.clone(),
            stable: true,
        };
        let orders = match self.architecture.0 {
            Architecture::Wave => 0..=0,
            _ => 0..=ORDERS,
        };
        let mut found = Vec::new();
        for n in orders {
            let mu = f64::from(n) / f64::from(ORDERS);
            let order = Order::new(mu).map_err(Failure::input)?;
            if let Some(best) = search.best(order).map_err(refused)? {
                found.push(Best::new(best.line, best.transparency));
            }
        }
        if found.is_empty() {
            return Err(Failure::bad_input(
                "no coupler that was tried is stable with every hand and place: take more damping of the devices, a shorter \
                 --line-delay or --sample-time, or --architecture wave",
            ));
        }
        Ok(found)
    }
}

/// A parameter that the analysis refuses, with the option that sets it.
fn refused(error: AnalysisError) -> Failure {
    let advice = match &error {
        AnalysisError::Range { what, .. } => match *what {
            "delay of the line" => "a line takes time, it does not give it: change --line-delay",
            "mass" => "change --mass or --slave-mass",
            "damping" => "change --damping or --slave-damping",
            "sample time" => "change --sample-time",
            "order of the coupler" => "change --order",
            "coupler stiffness" | "coupler stiffness and dissipation together" => {
                "change --coupler-stiffness or --coupler-dissipation"
            }
            "coupler dissipation" => "change --coupler-dissipation",
            "wave impedance" => "change --wave-impedance",
            _ => return Failure::input(error),
        },
        _ => return Failure::input(error),
    };
    Failure::input_with_advice(error, advice)
}

impl Best {
    fn new(line: HandLine, transparency: Transparency) -> Self {
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

impl Question {
    fn points(&self, hands: &Teleoperation) -> Result<Vec<Point>, Failure> {
        let pairs = self.omegas.iter().zip(&self.environment);
        let point = |(&omega, &impedance): (&f64, &Complex<f64>)| {
            let s = Complex::new(0.0, omega);
            let felt = hands.transmitted(omega, impedance).map_err(refused)? * s;
            let tissue = impedance * s;
            let (real, ratio) = hands.llewellyn(omega).map_err(refused)?;
            Ok(Point {
                frequency_hz: omega / TAU,
                tissue_n_per_m: tissue.norm(),
                tissue_degrees: tissue.arg().to_degrees(),
                felt_n_per_m: felt.norm(),
                felt_degrees: felt.arg().to_degrees(),
                llewellyn_ratio: if real < 0.0 { 0.0 } else { ratio },
            })
        };
        pairs.map(point).collect()
    }
}

impl Answer {
    fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        if let Some(best) = &self.best {
            self.print_candidates(out, best)?;
        }
        writeln!(
            out,
            "any hand and place {}, ratio {:.4} at {:.4} Hz (Llewellyn)",
            if self.absolutely_stable {
                "stable"
            } else {
                "not always stable"
            },
            self.least_ratio,
            self.worst_hz
        )?;
        match (self.largest_delay_s, self.any_delay) {
            (None, _) => writeln!(
                out,
                "largest delay      none: not stable even without delay"
            )?,
            (Some(delay), true) => writeln!(out, "largest delay      {} ms and more", 1e3 * delay)?,
            (Some(delay), false) => {
                writeln!(out, "largest delay      {} ms", fixed(1e3 * delay, 3))?
            }
        }
        if self.passive_line {
            writeln!(
                out,
                "energy             the line itself gives none at any delay"
            )?;
        }
        writeln!(
            out,
            "felt of {}: off by {:.1} dB and {:.0}° at most, {:.4} rms of ln",
            self.tissue, self.largest_db, self.largest_degrees, self.error
        )?;
        writeln!(
            out,
            "{:>10} {:>20} {:>20}",
            "f / Hz", "tissue / N/m", "felt / N/m"
        )?;
        for point in &self.points {
            let polar = |size: f64, degrees: f64| format!("{size:.3} {degrees:>4.0}°");
            writeln!(
                out,
                "{:>10.4} {:>20} {:>20}",
                point.frequency_hz,
                polar(point.tissue_n_per_m, point.tissue_degrees),
                polar(point.felt_n_per_m, point.felt_degrees)
            )?;
        }
        (self.files.iter()).try_for_each(|file| writeln!(out, "written: {file}"))
    }

    fn print_candidates(&self, out: &mut dyn Write, best: &Best) -> io::Result<()> {
        if let Some(impedance) = best.wave_impedance_n_s_per_m {
            return writeln!(out, "best impedance     {impedance:.4} N·s/m");
        }
        writeln!(
            out,
            "{:>6} {:>12} {:>16} {:>10} {:>8} {:>8}",
            "order", "k_c / N/m", "b_c / N·s^μ/m", "rms of ln", "off dB", "off °"
        )?;
        for candidate in &self.candidates {
            let star = if candidate.order == best.order {
                " *"
            } else {
                ""
            };
            writeln!(
                out,
                "{:>6.2} {:>12.3} {:>16.4} {:>10.4} {:>8.2} {:>8.1}{star}",
                candidate.order.unwrap_or_default(),
                candidate.coupler_stiffness_n_per_m.unwrap_or_default(),
                candidate
                    .coupler_dissipation_n_s_mu_per_m
                    .unwrap_or_default(),
                candidate.error,
                candidate.largest_db,
                candidate.largest_degrees
            )?;
        }
        Ok(())
    }

    fn draw(&self, hands: &Teleoperation) -> Result<Picture, FigureError> {
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
                "k_c = {:.4} N/m · b_c = {:.4} N·s^μ/m · μ = {}",
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
