//! `analyze teleoperation`: two hands over a line, what is stable and what is felt.

use super::resolved::logarithmic;
use crate::command::materials::library;
use crate::options::{Given, WithFiles, keys};
use crate::output::Output;
use crate::picture::{Panel, Points, linear, logarithmic as axis, page};
use fracdiff::{Order, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    CouplerSearch, HandCoupler, HandLine, HandMass, LargestDelay, Teleoperation, Transparency,
};
use haptic_experiment::parameters as p;
use haptic_experiment::parameters::analysis as a;
use haptic_experiment::run::analysed;
use haptic_experiment::{Failure, Matter, ModelledTissue, Named as _, TissuePiece};
use haptic_figure::{FigureError, Look, Picture};
use haptic_link::Architecture;
use haptic_loop::{Loading, LoadingKind};
use haptic_quantity::{digits, written};
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

/// Longest delay that is looked for, s.
const DELAY_MOST_S: f64 = 1.0;
/// Orders that are tried: 0, 0.05, … 1.
const ORDERS: u32 = 20;

struct Question {
    hands: Teleoperation,
    omegas: Vec<f64>,
    touched: Matter,
    environment: Vec<Complex<f64>>,
}

pub(super) fn answer(asked: WithFiles<keys::Hands>, output: Output) -> Result<(), Failure> {
    let given = asked.options.given()?;
    let files = asked.files;
    let asked = Asked {
        architecture: architecture(&given)?,
        given,
    };
    if asked.architecture == Architecture::TimeDomain {
        return Err(Failure::bad_input(
            "time-domain is not a linear law: give --architecture position-position",
        ));
    }
    asked.all_act()?;
    let mut outputs = files.look("teleoperation", &[])?;
    let question = asked.question()?;
    let candidates = match asked.given.flag(&a::BEST) {
        true => asked.candidates(&question)?,
        false => Vec::new(),
    };
    let best = (candidates.iter()).min_by(|a, b| a.1.error.total_cmp(&b.1.error));
    // Show the best candidate, if there is one.
    let hands = Teleoperation {
        line: best.map_or(question.hands.line, |best| best.0),
        ..question.hands
    };
    let stability = hands.absolute_stability().map_err(analysed)?;
    let largest = hands.largest_delay(DELAY_MOST_S).map_err(analysed)?;
    let felt = (hands.transparency(&question.omegas, &question.environment)).map_err(analysed)?;
    let points = question.points(&hands)?;
    let (architecture, tissue) = (asked.architecture.name(), question.touched.words());
    let about = format!(
        "{architecture} · delay {} · {} · {tissue}",
        written("delay_s", hands.delay_s),
        law(hands.line)
    );
    let files =
        outputs.table_and_picture(&[], points.iter(), || draw(&points, &candidates, &about));
    let candidate = |found: &Candidate| {
        let (coupler, impedance) = parts(found.0);
        json!({
            "order": coupler.map(|coupler| coupler.order.get()),
            "coupler_stiffness_n_per_m": coupler.map(|coupler| coupler.stiffness_n_per_m),
            "coupler_dissipation_n_s_mu_per_m": coupler.map(|coupler| coupler.dissipation_n_s_mu_per_m),
            "wave_impedance_n_s_per_m": impedance,
            "error": found.1.error,
            "largest_db": found.1.largest_db,
            "largest_degrees": found.1.largest_degrees,
        })
    };
    output.report(&json!({
        "architecture": architecture,
        "line_delay_s": hands.delay_s,
        "tissue": tissue,
        "absolutely_stable": stability.stable,
        "least_ratio": stability.least_ratio,
        "worst_hz": stability.worst_rad_s / TAU,
        // Null if it is not stable even without delay.
        "largest_delay_s": match largest {
            LargestDelay::None => None,
            LargestDelay::Below { delay_s } => Some(delay_s),
            LargestDelay::Any => Some(DELAY_MOST_S),
        },
        // The longest that was tried.
        "any_delay": largest == LargestDelay::Any,
        // It gives no energy at any delay.
        "passive_line": asked.architecture.is_passive(),
        "error": felt.error,
        "largest_db": felt.largest_db,
        "largest_degrees": felt.largest_degrees,
        "points": points,
        "candidates": candidates.iter().map(candidate).collect::<Vec<Value>>(),
        "best": best.map(candidate),
        "files": files,
    }))?;
    outputs.close(Ok(()))
}

/// The best coupler or impedance of an order.
type Candidate = (HandLine, Transparency);

/// Coupler and wave impedance of a line: one of them.
const fn parts(line: HandLine) -> (Option<HandCoupler>, Option<f64>) {
    match line {
        HandLine::PositionPosition(coupler) | HandLine::PositionForce(coupler) => {
            (Some(coupler), None)
        }
        HandLine::Wave {
            impedance_n_s_per_m,
            ..
        } => (None, Some(impedance_n_s_per_m)),
    }
}

#[derive(Clone, Copy, Serialize)]
struct Point {
    frequency_hz: f64,
    tissue_n_per_m: f64,
    tissue_degrees: f64,
    felt_n_per_m: f64,
    felt_degrees: f64,
    llewellyn_ratio: f64,
}

struct Asked {
    given: Given,
    architecture: Architecture,
}

fn architecture(given: &Given) -> Result<Architecture, Failure> {
    let name = given.text(&p::ARCHITECTURE);
    Architecture::named(name).ok_or_else(|| {
        let choices = Architecture::CHOICES.iter();
        let known: Vec<&str> = choices.map(|(_, known, _)| *known).collect();
        Failure::bad_input(format_args!(
            "{} \"{name}\" is not one of {}",
            p::ARCHITECTURE,
            known.join(", ")
        ))
    })
}

impl Asked {
    /// A number with a default, or one that the parser has asked for.
    fn number(&self, parameter: &p::Parameter) -> f64 {
        self.given.number(parameter).unwrap_or_default()
    }

    fn all_act(&self) -> Result<(), Failure> {
        let refuse = |parameters: &[&p::Parameter], why: &str| {
            let mut given = parameters
                .iter()
                .filter(|parameter| self.given.has(parameter));
            given.next().map_or(Ok(()), |parameter| {
                let why = format_args!("{parameter} has no effect {why}: omit it");
                Err(Failure::bad_input(why))
            })
        };
        let coupler = [
            &p::HAND_COUPLER_STIFFNESS,
            &p::HAND_COUPLER_DISSIPATION,
            &p::HAND_COUPLER_ORDER,
        ];
        let waves = [&p::WAVE_IMPEDANCE, &a::PLAYOUT_SAMPLES];
        if self.architecture == Architecture::Wave {
            refuse(&coupler, "on waves, which have no coupler")?;
        } else {
            refuse(&waves, "without --architecture wave")?;
        }
        if self.given.flag(&a::BEST) {
            refuse(&coupler, "with --best, which looks for it")?;
            refuse(&waves[..1], "with --best, which looks for it")?;
        }
        Ok(())
    }

    fn question(&self) -> Result<Question, Failure> {
        let (low, high) = (self.number(&a::FELT_LOW), self.number(&a::FELT_HIGH));
        let most = 0.5 / self.number(&p::SAMPLE_TIME);
        if !(low > 0.0 && low < high && high <= most) {
            return Err(Failure::bad_input(format_args!(
                "{low} to {high} Hz are not in 0 to {most} Hz: change --low, --high or --sample-time"
            )));
        }
        let folder = Some(self.given.text(&p::LIBRARY)).filter(|folder| !folder.is_empty());
        let library = library(folder.map(Path::new))?;
        let material = library
            .find(self.given.text(&p::TISSUE))
            .map_err(Failure::input)?;
        let (area, thickness) = (self.number(&p::AREA), self.number(&p::THICKNESS));
        let loading = Loading {
            area_m2: Some(area),
            thickness_m: Some(thickness),
            ..Loading::new(LoadingKind::Compression)
        };
        let piece = TissuePiece::new(ModelledTissue::new(material)?, loading);
        let piece = piece
            .map_err(|error| Failure::input_with_advice(error, "change --area or --thickness"))?;
        if !piece.is_linear() {
            return Err(Failure::bad_input(TissuePiece::NOT_LINEAR));
        }
        let touched = Matter::Tissue(piece);
        let count = self.given.count(&a::FELT_POINTS, 2..=10_000)? as usize;
        let omegas: Vec<f64> = logarithmic(TAU * low, TAU * high, count).collect();
        let environment = (omegas.iter())
            .map(|&omega| touched.stiffness(omega) / Complex::new(0.0, omega))
            .collect();
        Ok(Question {
            hands: self.hands()?,
            omegas,
            touched,
            environment,
        })
    }

    fn hands(&self) -> Result<Teleoperation, Failure> {
        let order = Order::new(self.number(&p::HAND_COUPLER_ORDER)).map_err(Failure::input)?;
        let coupler = HandCoupler {
            stiffness_n_per_m: self.number(&p::HAND_COUPLER_STIFFNESS),
            dissipation_n_s_mu_per_m: self.number(&p::HAND_COUPLER_DISSIPATION),
            order,
        };
        let t = Seconds(self.number(&p::SAMPLE_TIME));
        t.rate_to_the(order)
            .map_err(|error| Failure::input_with_advice(error, "give --sample-time, as in 1ms"))?;
        let master = HandMass {
            mass_kg: self.number(&p::MASS),
            damping_n_s_per_m: self.number(&p::DAMPING),
        };
        Ok(Teleoperation {
            master,
            slave: HandMass {
                mass_kg: self.given.number(&p::SLAVE_MASS).unwrap_or(master.mass_kg),
                damping_n_s_per_m: (self.given.number(&p::SLAVE_DAMPING))
                    .unwrap_or(master.damping_n_s_per_m),
            },
            line: self.line(coupler)?,
            sample_time_s: t.0,
            delay_s: self.number(&p::LINE_DELAY),
        })
    }

    fn line(&self, coupler: HandCoupler) -> Result<HandLine, Failure> {
        Ok(match self.architecture {
            // `run` has refused the second.
            Architecture::PositionPosition | Architecture::TimeDomain => {
                HandLine::PositionPosition(coupler)
            }
            Architecture::PositionForce => HandLine::PositionForce(coupler),
            Architecture::Wave => HandLine::Wave {
                impedance_n_s_per_m: self.number(&p::WAVE_IMPEDANCE),
                playout_samples: self.given.count(&a::PLAYOUT_SAMPLES, 1..=10_000)?,
            },
        })
    }

    /// The best of each order, or of waves.
    fn candidates(&self, question: &Question) -> Result<Vec<Candidate>, Failure> {
        let search = CouplerSearch {
            hands: question.hands,
            omegas_rad_s: question.omegas.clone(),
            environment: question.environment.clone(),
            stable: true,
        };
        let is_wave = self.architecture == Architecture::Wave;
        let mut found = Vec::new();
        for n in 0..=if is_wave { 0 } else { ORDERS } {
            let mu = f64::from(n) / f64::from(ORDERS);
            let order = Order::new(mu).map_err(Failure::input)?;
            if let Some(best) = search.best(order).map_err(analysed)? {
                found.push((best.line, best.transparency));
            }
        }
        if found.is_empty() {
            return Err(Failure::bad_input(
                "no coupler is stable with every hand and environment: shorten --line-delay or --sample-time",
            ));
        }
        Ok(found)
    }
}

impl Question {
    fn points(&self, hands: &Teleoperation) -> Result<Vec<Point>, Failure> {
        let pairs = self.omegas.iter().zip(&self.environment);
        let point = |(&omega, &impedance): (&f64, &Complex<f64>)| {
            let s = Complex::new(0.0, omega);
            let felt = hands.transmitted(omega, impedance).map_err(analysed)? * s;
            let tissue = impedance * s;
            let (real, ratio) = hands.llewellyn(omega).map_err(analysed)?;
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

/// The law of a line, in words.
fn law(line: HandLine) -> String {
    match parts(line) {
        (Some(coupler), _) => format!(
            "spring {} · damper {} · μ = {}",
            written("stiffness_n_per_m", coupler.stiffness_n_per_m),
            written("dissipation_n_s_mu_per_m", coupler.dissipation_n_s_mu_per_m),
            digits(coupler.order.get(), 4)
        ),
        (None, impedance) => {
            let impedance = impedance.unwrap_or(f64::NAN);
            format!("b = {}", written("impedance_n_s_per_m", impedance))
        }
    }
}

/// Stiffness and phase of the tissue, and as felt; and the error of the best coupler of each order.
fn draw(points: &[Point], candidates: &[Candidate], about: &str) -> Result<Picture, FigureError> {
    let panel = |caption, y, tissue: fn(&Point) -> f64, felt: fn(&Point) -> f64| {
        let over = |value: fn(&Point) -> f64| {
            let points = points.iter();
            points.map(move |p| (p.frequency_hz, value(p)))
        };
        Panel::new(caption, axis("frequency / Hz"), y)
            .with("tissue", Look::Line, 1, over(tissue))
            .with("felt in the hand", Look::Line, 0, over(felt))
    };
    let stiffness = axis("|F/x| / N·m⁻¹");
    let mut panels = vec![
        panel(
            "stiffness",
            stiffness,
            |p| p.tissue_n_per_m,
            |p| p.felt_n_per_m,
        ),
        panel(
            "phase",
            linear("phase / °"),
            |p| p.tissue_degrees,
            |p| p.felt_degrees,
        ),
    ];
    let errors: Points = (candidates.iter())
        .filter_map(|(line, felt)| Some((parts(*line).0?.order.get(), felt.error)))
        .collect();
    if errors.len() > 1 {
        let caption = "the best coupler of each order";
        let panel = Panel::new(caption, linear("order μ"), linear("rms of ln(felt/tissue)"));
        panels.push(panel.with("best coupler", Look::Markers, 2, errors));
    }
    let title = "What the hand feels of a tissue far away";
    page(title, about, 2, &panels)
}
