//! `analyze teleoperation`: two hands over a line, what is stable and what is felt.

mod answer;

use super::arguments::{Files, logarithmic};
use crate::choice::choice;
use crate::command::materials::folder::library;
use crate::command::words::parse_dissipation;
use crate::options;
use crate::output::Output;
use crate::whole::whole;
use crate::within::{number_within, read_within, within};
use answer::{Answer, Best, Point};
use clap::Args;
use fracdiff::{Order, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    AnalysisError, CouplerSearch, HandCoupler, HandLine, HandMass, LargestDelay, Teleoperation,
};
use haptic_experiment::Failure;
use haptic_experiment::experiment::teleoperation::{ArchitectureName, RemotePlace};
use haptic_experiment::parameters as p;
use haptic_experiment::parameters::range;
use haptic_experiment::{ModelledTissue, TissuePiece};
use haptic_link::Architecture;
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_quantity::{Area, Damping, Frequency, Length, Mass, Stiffness, Time};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Longest delay that is looked for, s.
const DELAY_MOST_S: f64 = 1.0;
/// Samples of playout of waves.
const PLAYOUT: u32 = 2;
/// Orders that are tried: 0, 0.05, … 1.
const ORDERS: u32 = 20;

/// Arguments of `analyze teleoperation`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli analyze teleoperation --coupler-stiffness 300 --coupler-dissipation 10 --order 0.5 --line-delay 20ms\n  \
                  host-cli analyze teleoperation --line-delay 20ms --best --out far"
)]
pub struct TeleoperationArguments {
    #[arg(long, help = p::ARCHITECTURE.help, value_parser = choice::<ArchitectureName>(), default_value = p::ARCHITECTURE.shown, help_heading = "Line")]
    architecture: ArchitectureName,
    #[arg(long, value_parser = within::<Time>(p::LINE_DELAY.range()), help = p::LINE_DELAY.help, default_value = p::LINE_DELAY.shown, allow_hyphen_values = true, help_heading = "Line")]
    line_delay: Time,
    #[arg(long, value_parser = within::<Stiffness>(p::HAND_COUPLER_STIFFNESS.range()), help = options::help(&p::HAND_COUPLER_STIFFNESS), allow_hyphen_values = true, help_heading = "Line")]
    coupler_stiffness: Option<Stiffness>,
    #[arg(long, help = options::help(&p::HAND_COUPLER_DISSIPATION), value_name = "B_C", value_parser = read_within(parse_dissipation, p::HAND_COUPLER_DISSIPATION.range()), allow_hyphen_values = true, help_heading = "Line")]
    coupler_dissipation: Option<f64>,
    #[arg(long, help = options::help(&p::HAND_COUPLER_ORDER), value_parser = number_within(p::HAND_COUPLER_ORDER.range()), allow_hyphen_values = true, help_heading = "Line")]
    order: Option<f64>,
    #[arg(long, value_parser = within::<Damping>(p::WAVE_IMPEDANCE.range()), help = options::help(&p::WAVE_IMPEDANCE), allow_hyphen_values = true, help_heading = "Line")]
    wave_impedance: Option<Damping>,
    /// Samples over which waves are played out [default: 2]
    #[arg(long, value_name = "SAMPLES", value_parser = whole::<u32>(1..=10_000), help_heading = "Line")]
    playout: Option<u32>,
    /// Find the best coupler of each order, or the best impedance of waves, for this delay and tissue
    #[arg(long, help_heading = "Line")]
    best: bool,
    #[arg(long, value_parser = within::<Mass>(p::MASS.range()), help = p::MASS.help, default_value = p::MASS.shown, allow_hyphen_values = true, help_heading = "Devices")]
    mass: Mass,
    #[arg(long, value_parser = within::<Damping>(p::DAMPING.range()), help = p::DAMPING.help, default_value = p::DAMPING.shown, allow_hyphen_values = true, help_heading = "Devices")]
    damping: Damping,
    #[arg(long, value_parser = within::<Mass>(p::SLAVE_MASS.range()), help = p::SLAVE_MASS.help, allow_hyphen_values = true, help_heading = "Devices")]
    slave_mass: Option<Mass>,
    #[arg(long, value_parser = within::<Damping>(p::SLAVE_DAMPING.range()), help = p::SLAVE_DAMPING.help, allow_hyphen_values = true, help_heading = "Devices")]
    slave_damping: Option<Damping>,
    #[arg(long, value_parser = within::<Time>(p::SAMPLE_TIME.range()), help = p::SAMPLE_TIME.help, default_value = p::SAMPLE_TIME.shown, allow_hyphen_values = true, help_heading = "Devices")]
    sample_time: Time,
    #[arg(long, help = p::TISSUE.help, value_name = "NAME", default_value = p::TISSUE.shown, help_heading = "Tissue")]
    tissue: String,
    #[arg(long, help = p::LIBRARY.help, value_name = "DIR", help_heading = "Tissue")]
    library: Option<PathBuf>,
    #[arg(long, value_parser = within::<Area>(p::AREA.range()), help = p::AREA.help, default_value = p::AREA.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    area: Area,
    #[arg(long, value_parser = within::<Length>(p::THICKNESS.range()), help = p::THICKNESS.help, default_value = p::THICKNESS.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    thickness: Length,
    /// Lowest frequency at which the tissue is to feel right
    #[arg(long, allow_hyphen_values = true, value_parser = within::<Frequency>(range::FREQUENCIES_HZ))]
    #[arg(default_value = "0.5Hz", help_heading = "Tissue")]
    low: Frequency,
    /// Highest frequency at which the tissue is to feel right
    #[arg(long, allow_hyphen_values = true, value_parser = within::<Frequency>(range::FREQUENCIES_HZ))]
    #[arg(default_value = "5Hz", help_heading = "Tissue")]
    high: Frequency,
    /// Number of frequencies
    #[arg(long, default_value_t = 20, value_parser = whole::<u32>(2..=10_000), help_heading = "Tissue")]
    points: u32,
    #[command(flatten)]
    files: Files,
}

pub(super) const LONG_ABOUT: &str = "\
Is a teleoperation stable with every passive hand and every passive thing at the other end (Llewellyn's criterion, with the delay of the line, \
sampled controllers and held forces)? Up to which delay? And what does the hand feel of a remote tissue?

--best looks for the coupler spring + damper D^mu of each order that makes the tissue feel right from --low to --high: the least root mean square of \
|ln(Z_felt/Z_tissue)|, 0.1 being 10 % or 6 degrees, among those that are stable with every hand and place at this delay. Of waves it finds the impedance.

time-domain is no linear law and is refused: analyze position-position, whose coupler it limits; `host-cli run` shows what is felt of it.";

fn or_default(given: Option<f64>, parameter: &p::Parameter) -> f64 {
    given.unwrap_or_else(|| parameter.default_number())
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
        if self.architecture.0 == Architecture::TimeDomain {
            return Err(Failure::bad_input(
                "time-domain is no linear law, it has neither Llewellyn's criterion nor a formula: analyze its coupler with \
                 --architecture position-position, and see with `run` what is felt of it",
            ));
        }
        self.all_act()?;
        let mut place = self.files.look("teleoperation")?;
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
        answer.files = place.table_and_picture(rows, || answer.draw(&hands));
        output.print(&answer, |out| answer.print(out))?;
        place.close(Ok(()))
    }

    /// Refuses options that would have no effect.
    fn all_act(&self) -> Result<(), Failure> {
        let wave = self.architecture.0 == Architecture::Wave;
        let coupler = [
            ("--coupler-stiffness", self.coupler_stiffness.is_some()),
            ("--coupler-dissipation", self.coupler_dissipation.is_some()),
            ("--order", self.order.is_some()),
        ];
        let impedance = ("--wave-impedance", self.wave_impedance.is_some());
        let given = |options: &[(&'static str, bool)]| {
            let mut given = options.iter().filter(|(_, given)| *given);
            given.next().map(|(option, _)| *option)
        };
        let refusal = |option: &str, why: &str| {
            Err(Failure::bad_input(format_args!(
                "{option} has no effect {why}: leave it out"
            )))
        };
        if wave && let Some(option) = given(&coupler) {
            return refusal(option, "on waves, which have no coupler");
        }
        let of_waves = [impedance, ("--playout", self.playout.is_some())];
        if !wave && let Some(option) = given(&of_waves) {
            return refusal(option, "without --architecture wave");
        }
        let [k, b, order] = coupler;
        if self.best
            && let Some(option) = given(&[k, b, order, impedance])
        {
            return refusal(option, "with --best, which looks for it");
        }
        Ok(())
    }

    fn question(&self) -> Result<Question, Failure> {
        let (low, high) = (self.low.0, self.high.0);
        let most = 0.5 / self.sample_time.0;
        if !(low > 0.0 && low < high && high <= most) {
            return Err(Failure::bad_input(format_args!(
                "frequencies {low} to {high} Hz are not inside 0 to {most} Hz, lowest first: change --low, --high or --sample-time"
            )));
        }
        let library = library(self.library.as_deref())?;
        let material = library.find(&self.tissue).map_err(Failure::input)?;
        let specimen = Specimen::new(SquareMetres(self.area.0), Metres(self.thickness.0));
        let place = RemotePlace::Tissue(TissuePiece {
            material: Box::new(ModelledTissue::new(material)?),
            specimen: specimen.map_err(|error| {
                Failure::input_with_advice(error, "change --area or --thickness")
            })?,
        });
        let omegas: Vec<f64> = logarithmic(TAU * low, TAU * high, self.points as usize).collect();
        let environment = (omegas.iter())
            .filter_map(|&omega| Some(place.stiffness(omega)? / Complex::new(0.0, omega)))
            .collect();
        let hands = self.hands()?;
        Ok(Question {
            hands,
            omegas,
            place,
            environment,
        })
    }

    /// Devices and line.
    fn hands(&self) -> Result<Teleoperation, Failure> {
        let device = |mass: Mass, damping: Damping| HandMass {
            mass_kg: mass.0,
            damping_n_s_per_m: damping.0,
        };
        let order =
            Order::new(or_default(self.order, &p::HAND_COUPLER_ORDER)).map_err(Failure::input)?;
        let coupler = HandCoupler {
            stiffness_n_per_m: or_default(
                self.coupler_stiffness.map(|k| k.0),
                &p::HAND_COUPLER_STIFFNESS,
            ),
            dissipation_n_s_mu_per_m: or_default(
                self.coupler_dissipation,
                &p::HAND_COUPLER_DISSIPATION,
            ),
            order,
        };
        // Checked where the loop is.
        let t = Seconds(self.sample_time.0);
        t.rate_to_the(order)
            .map_err(|error| Failure::input_with_advice(error, "give --sample-time, as in 1ms"))?;
        Ok(Teleoperation {
            master: device(self.mass, self.damping),
            slave: device(
                self.slave_mass.unwrap_or(self.mass),
                self.slave_damping.unwrap_or(self.damping),
            ),
            line: self.kind(
                coupler,
                or_default(self.wave_impedance.map(|b| b.0), &p::WAVE_IMPEDANCE),
            ),
            sample_time_s: t.0,
            delay_s: self.line_delay.0,
        })
    }

    fn kind(&self, coupler: HandCoupler, impedance_n_s_per_m: f64) -> HandLine {
        match self.architecture.0 {
            // `run` has refused the second.
            Architecture::PositionPosition | Architecture::TimeDomain => {
                HandLine::PositionPosition(coupler)
            }
            Architecture::PositionForce => HandLine::PositionForce(coupler),
            Architecture::Wave => HandLine::Wave {
                impedance_n_s_per_m,
                playout_samples: self.playout.unwrap_or(PLAYOUT),
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
        AnalysisError::Range(range) => match range.what {
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
