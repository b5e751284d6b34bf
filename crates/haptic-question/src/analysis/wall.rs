//! A wall on a device, with units or without: is it stable, passive, and how much does it amplify errors?

use crate::analysis::answer::{
    Analysed, Drawn, FREQUENCIES_MOST, Region, SensitivityPoint, decibel, logarithmic,
};
use crate::analysis::keys::{
    ALPHA, ANALYSED_CONTROLLER, ANALYSED_DAMPING, ANALYSED_DELAY, ANALYSED_HAND, ANALYSED_LAG,
    ANALYSED_MASS, ANALYSED_SAMPLE_TIME, BETA, DELAY_SAMPLES, DELTA, GAMMA, SENSITIVITY_POINTS,
};
use crate::analysis::law::{InPlace, Law, without};
use haptic_analysis::{
    AnalysisError, Dynamics, Effective, ForcePath, HandPort, Largest, LoopOperator, Nondimensional,
    OnePort, Polygon, RequiredDelta, SampledLoop, SampledPlant, SampledWall, StabilityRegion,
    StableArea,
};
use haptic_document::Warn;
use haptic_document::parameters::{DEVICE_MODEL, PLANT_MODEL, Parameter};
use haptic_document::{Failure, Table};
use haptic_document::{Rows, rows};
use haptic_quantity::{digits, written};
use haptic_trial::PlantModel;
use haptic_trial::advice::analysed;
use haptic_trial::keys::wall::{DISSIPATION, STIFFNESS};
use serde_json::{Value, json};
use std::f64::consts::PI;

const WITHOUT_UNITS: [Parameter; 4] = [ALPHA, BETA, DELTA, GAMMA];
const WITH_UNITS: [Parameter; 5] = [
    ANALYSED_MASS,
    ANALYSED_DAMPING,
    ANALYSED_HAND,
    STIFFNESS,
    DISSIPATION,
];
/// Frequencies at which a loop on a plant may give energy to a hand, from this share of the highest on.
const ACTIVE_POINTS: usize = 2000;
const LOWEST: f64 = 1e-6;
/// Points on the boundary of a region.
const BOUNDARY: usize = 1000;
/// Factors on a tissue or controller that are judged.
const SCALES: [f64; 2] = [0.1, 10.0];

/// A loop that is ready to be analysed.
#[derive(Clone, Debug)]
pub(crate) struct WallLoop {
    pub(crate) parameters: Nondimensional,
    pub(crate) law: Law,
    pub(crate) path: ForcePath,
    /// T, s, if it was given.
    sample_time_s: Option<f64>,
    pub(crate) units: Option<WithUnits>,
    /// A plant in place of the device, which then is 1 kg as a unit.
    on_plant: Option<Box<OnPlant>>,
    /// Number of frequencies of a sensitivity.
    points: usize,
    /// Number of keys of the wall that were given: two make one.
    of_wall: usize,
    /// True if δ (or b) was given at all.
    delta_given: bool,
    /// The loop with units, as a result repeats it: who took a wrong unit sees it there.
    asked: Value,
}

#[derive(Clone, Debug)]
pub(crate) struct OnPlant {
    pub(crate) name: String,
    sampled: SampledPlant,
    path: ForcePath,
    port: HandPort,
}

/// Is a loop passive, and why is it not, or not known? Where a hand that pushes at one frequency is given energy, rad/s.
#[derive(Clone, Debug)]
struct Passivity {
    passive: Option<bool>,
    reason: Option<String>,
    active_rad_s: Option<f64>,
}

/// Wall and device of a loop that was given with units; delay and lag are in its path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WithUnits {
    pub(crate) device: Dynamics,
    pub(crate) wall: SampledWall,
}

impl WallLoop {
    /// A wall that is given.
    pub(crate) fn needed(table: &Table<'_>) -> Result<Self, Failure> {
        Self::of(table, |parameter| Err(missing(parameter)))
    }

    /// A device whose stable walls are sought.
    pub(crate) fn sought(table: &Table<'_>) -> Result<Self, Failure> {
        Self::of(table, |_| Ok(0.0))
    }

    fn of(
        table: &Table<'_>,
        without: fn(&Parameter) -> Result<f64, Failure>,
    ) -> Result<Self, Failure> {
        let points = table.count_in(&SENSITIVITY_POINTS, 2..=FREQUENCIES_MOST)?;
        let given = table.number_if(&ANALYSED_SAMPLE_TIME)?;
        let (law, sample_time_s) = Law::of(table, given)?;
        let on_plant = OnPlant::of(table, sample_time_s)?;
        let has_file = !table.text(&DEVICE_MODEL)?.is_empty();
        let with_units = on_plant.is_some()
            || has_file
            || law.in_place.is_some()
            || WITH_UNITS.iter().any(|key| table.has(key));
        if with_units && WITHOUT_UNITS.iter().any(|key| table.has(key)) {
            return Err(Failure::bad_input(format_args!(
                "the loop is given both with and without units: omit {ALPHA}, {BETA}, {DELTA} and {GAMMA}"
            )));
        }
        let needed = |given: Option<f64>, key: &Parameter| given.map_or_else(|| without(key), Ok);
        let mass = table.number_if(&ANALYSED_MASS)?;
        let damping = table.number_if(&ANALYSED_DAMPING)?.unwrap_or(0.0);
        let hand = table.number_if(&ANALYSED_HAND)?.unwrap_or(0.0);
        let of_device = with_units && on_plant.is_none();
        let asked = json!({
            "plant_model": on_plant.as_ref().map(|plant| &plant.name),
            "mass_kg": mass,
            "damping_n_s_per_m": of_device.then_some(damping),
            "hand_stiffness_n_per_m": of_device.then_some(hand),
            "sample_time_s": sample_time_s,
            "stiffness_n_per_m": law.of_wall(law.stiffness),
            "dissipation_n_s_mu_per_m": law.of_wall(law.dissipation),
        });
        let (parameters, units) = if with_units {
            let unit = on_plant.as_ref().map(|_| 1.0);
            let mass = mass.or(unit).ok_or_else(|| missing(&ANALYSED_MASS))?;
            let t = sample_time_s.ok_or_else(|| missing(&ANALYSED_SAMPLE_TIME))?;
            let device = Dynamics {
                hand_stiffness_n_per_m: hand,
                ..Dynamics::ideal(mass, damping)
            };
            let wall = SampledWall {
                stiffness_n_per_m: needed(law.stiffness, &STIFFNESS)?,
                dissipation_n_s_mu_per_m: needed(law.dissipation, &DISSIPATION)?,
                order: law.order,
                sample_time_s: t,
            };
            let units = WithUnits { device, wall };
            (device.nondimensional(&wall), Some(units))
        } else {
            let without_units = Nondimensional {
                alpha: needed(table.number_if(&ALPHA)?, &ALPHA)?,
                beta: needed(table.number_if(&BETA)?, &BETA)?,
                delta: table.number_if(&DELTA)?.unwrap_or(0.0),
                gamma: table.number_if(&GAMMA)?.unwrap_or(0.0),
            };
            (without_units.checked(), None)
        };
        let parameters = parameters.map_err(analysed)?;
        let of_wall = [STIFFNESS, DISSIPATION, ALPHA, BETA];
        Ok(Self {
            parameters,
            path: match &on_plant {
                Some(plant) => plant.path,
                None => path(table, sample_time_s)?,
            },
            points,
            sample_time_s,
            units,
            on_plant,
            asked,
            of_wall: match law.in_place {
                Some(_) => 2,
                None => of_wall.iter().filter(|key| table.has(key)).count(),
            },
            delta_given: has_file || [DELTA, ANALYSED_DAMPING].iter().any(|key| table.has(key)),
            law,
        })
    }

    fn plant(&self) -> Result<SampledPlant, Failure> {
        if let Some(plant) = &self.on_plant {
            return Ok(plant.sampled);
        }
        let Nondimensional { delta, gamma, .. } = self.parameters;
        SampledPlant::behind(delta, gamma, self.path).map_err(Failure::input)
    }

    pub(crate) fn sampled(&self) -> Result<SampledLoop<'_>, Failure> {
        let Nondimensional { alpha, beta, .. } = self.parameters;
        SampledLoop::with_plant(self.plant()?, alpha, beta, &self.law.operator)
            .map_err(Failure::input)
    }

    pub(crate) fn port(&self) -> Result<OnePort<'_, LoopOperator>, Failure> {
        let law = &self.law;
        let port = OnePort::new(&law.operator, law.order).and_then(|port| port.through(self.path));
        Ok(port
            .map_err(Failure::input)?
            .with_memory(law.operator.memory()))
    }

    pub(crate) fn stable_region(&self, points: usize) -> Result<StabilityRegion, Failure> {
        let region = StabilityRegion::new(self.plant()?, &self.law.operator, 0, points);
        // Only a controller may have another one.
        let has_gain = self.law.operator.direct_gain() > 0.0;
        region.map_err(|error| if has_gain { Failure::input(error) } else { Failure::input_with_advice(
            error,
            format_args!(
                "this is the force against a new position, N/m; change {ANALYSED_CONTROLLER}, or ask for stability alone"
            ),
        ) })
    }

    /// A number of a device, which a plant has not, for a report.
    fn of_device(&self, number: impl Into<Option<f64>>) -> Option<f64> {
        number.into().filter(|_| self.on_plant.is_none())
    }

    /// Mass and sample time, where the loop was given with units.
    fn mass_and_time(&self) -> Option<[f64; 2]> {
        let units = self.units.as_ref()?;
        Some([units.device.mass_kg, units.wall.sample_time_s])
    }

    /// The loop, with the wall and device without units and the way of the force, and what was found of it.
    fn report(&self, without_units: Value, found: Value) -> Rows {
        let law = &self.law;
        let loop_ =
            json!({"order": law.of_wall(law.order.get()), "scheme": law.scheme.to_string()});
        let path = path_result(self.path, self.sample_time_s);
        let asked = self.asked.clone();
        rows([
            loop_,
            law.in_place_result(),
            asked,
            without_units,
            path,
            found,
        ])
    }

    /// Stiffness and dissipation of a wall without units: K = αm/T², B = βm/T^(2−μ).
    pub(crate) fn with_units(&self, alpha: Option<f64>, beta: Option<f64>) -> [Option<f64>; 2] {
        let Some([m, t]) = self.mass_and_time() else {
            return [None; 2];
        };
        let stiffness = alpha.map(|alpha| alpha * m / (t * t));
        [
            stiffness,
            beta.map(|beta| beta * m / libm::pow(t, 2.0 - self.law.order.get())),
        ]
    }

    pub(crate) fn stability(&self, _: Warn<'_>) -> Result<Analysed, Failure> {
        let parameters = self.parameters;
        // Without any spring there is a pole at z = 1, which is no instability: the device stays where it is left.
        let sampled = self.sampled()?;
        let (drifts, sampled) = (sampled.drifts(), sampled.beside_rest());
        let verdict = sampled.verdict();
        // Only a stable loop has margins; the edge is not stable.
        let margins = verdict.stable.then(|| sampled.margins().ok()).flatten();
        // The proof takes a law that comes to rest where the motion does.
        let contact = (!self.law.integrates()).then(|| sampled.slope_limit());
        let contact = contact.as_ref();
        let factor = |value: f64| (value > 0.0 && value.is_finite()).then_some(value);
        let without_units = json!({
            "alpha": self.of_device(self.law.of_wall(parameters.alpha)),
            "beta": self.of_device(self.law.of_wall(parameters.beta)),
            "delta": self.of_device(parameters.delta),
            "gamma": self.of_device(parameters.gamma),
        });
        let found = json!({
            "stable": verdict.stable,
            "stable_reason": match (verdict.unstable_poles, drifts) {
                (None, _) => Some("on the boundary"),
                (Some(0), true) => Some("without a spring the device stays where it is left"),
                _ => None,
            },
            "drifts": drifts,
            // Largest |z| of a pole; null if P is irrational or the polynomial too long.
            "spectral_radius": sampled.spectral_radius(),
            // Poles with |z| > 1; null on the boundary.
            "encirclements": verdict.unstable_poles,
            // By how much the wall could grow, and how much more delay it could bear; null for any, or if unstable.
            "gain_margin": margins.and_then(|margins| margins.gain_up).map(|at| at.value),
            "delay_margin_samples": margins.and_then(|margins| margins.delay).map(|at| at.value),
            "peak_sensitivity_db": margins.map(|margins| decibel(margins.sensitivity.value)),
            // The factor on the wall up to which contact that may pull, acts on one side or stiffens, and is nowhere steeper than this, is proved
            // stable for every motion; null if nothing is proved. And the factor that no such proof reaches.
            "pulling_contact_margin": contact.and_then(|contact| factor(contact.proved)),
            "pulling_contact_margin_reason": match contact {
                None => Some("a controller with an integral has no such proof"),
                Some(contact) if contact.proved == 0.0 && contact.provable > 0.0 => {
                    Some("no proof was found; a device without damping has none")
                }
                Some(_) => None,
            },
            "pulling_contact_margin_most": contact.and_then(|contact| factor(contact.provable)),
        });
        Ok(Analysed::in_numbers(self.report(without_units, found)))
    }

    pub(crate) fn passivity(&self, _: Warn<'_>) -> Result<Analysed, Failure> {
        let units = self.mass_and_time();
        // Of a plant the damping that it has at every frequency; its mass is 1 kg as a unit.
        let plant_damping = (self.on_plant.as_ref()).and_then(|plant| plant.port.least_damping());
        let delta = match (&self.on_plant, units) {
            (Some(_), Some([_, t])) => plant_damping.map(|(damping, _)| damping * t),
            _ => self.delta_given.then_some(self.parameters.delta),
        };
        // Next to rest an integral asks for more and more damping.
        let required = if self.law.integrates() {
            None
        } else {
            Some(self.required_delta()?)
        };
        let (mut alpha, mut beta) = (None, None);
        // Spring and memory of a tissue only grow together.
        if let Some(delta) = delta.filter(|_| self.law.in_place.is_none()) {
            [alpha, beta] = self.largest_passive(delta)?;
        }
        let [stiffness, dissipation] = self.with_units(alpha, beta);
        let without_units = json!({
            "alpha": self.of_device(self.law.of_wall(self.parameters.alpha)),
            "beta": self.of_device(self.law.of_wall(self.parameters.beta)),
            "delta": self.of_device(delta),
        });
        let proved = required
            .zip(delta)
            .map(|(required, delta)| required.passive(delta));
        let passivity = match &self.on_plant {
            Some(plant) if required.is_some_and(|law| !law.negative_at_rest) => {
                self.passivity_on(plant, proved == Some(true), plant_damping)?
            }
            _ => Passivity {
                passive: required.map_or(Some(false), |_| proved),
                reason: match (required, delta) {
                    (None, _) => Some(
                        "an integral pushes ever harder against a hand that holds still: no damping is enough"
                            .to_owned(),
                    ),
                    (Some(required), _) if required.negative_at_rest => {
                        Some("a negative spring at rest: no damping is enough".to_owned())
                    }
                    (Some(_), None) => Some(format!("give {DELTA} or {ANALYSED_DAMPING} to know")),
                    (Some(_), Some(_)) => None,
                },
                active_rad_s: None,
            },
        };
        let corollary = required.filter(|_| self.law.is_one_element());
        let damping = required
            .zip(units)
            .map(|(required, [m, t])| required.delta * m / t);
        let mut found = json!({
            // Least δ by Theorem 1 for the operator really used, and by Corollary 1 for the exact one without delay.
            "required_delta": self.of_device(required.map(|required| required.delta)),
            "corollary_delta": self.of_device(corollary.map(|required| required.corollary_delta)),
            "worst_theta": required.map(|required| required.worst_theta),
            "passive": passivity.passive,
            "passive_reason": passivity.reason,
            "negative_at_rest": required.map(|required| required.negative_at_rest),
            // Passive with the given δ and the other; null without a δ, or if none or any is.
            "largest_alpha": self.of_device(alpha),
            "largest_beta": self.of_device(beta),
            "largest_stiffness_n_per_m": stiffness,
            "largest_dissipation_n_s_mu_per_m": dissipation,
            // δ = bT/m
            "required_damping_n_s_per_m": damping,
            "worst_rad_s": required.zip(units).map(|(required, [_, t])| required.worst_theta / t),
        });
        if self.on_plant.is_some() {
            // That the plant has at every frequency, and where a hand is given energy.
            found["plant_damping_n_s_per_m"] = json!(plant_damping.map(|(damping, _)| damping));
            found["active_rad_s"] = json!(passivity.active_rad_s);
        }
        if self.law.in_place.is_some() {
            // Of the force of the whole law, up to which it is passive.
            let bounded = required.filter(|wall| wall.delta > 0.0 && !wall.negative_at_rest);
            let scale = delta
                .zip(bounded)
                .map(|(delta, required)| delta / required.delta);
            found["largest_scale"] = json!(scale);
        }
        Ok(Analysed::in_numbers(self.report(without_units, found)))
    }

    /// Passivity on a plant, where Theorem 1 did or did not prove it: necessary is that no single frequency gives a hand energy.
    fn passivity_on(
        &self,
        plant: &OnPlant,
        is_proved: bool,
        damping: Option<(f64, f64)>,
    ) -> Result<Passivity, Failure> {
        let known = |passive, reason: Option<String>, active_rad_s| Passivity {
            passive,
            reason,
            active_rad_s,
        };
        let Some(units) = self.units.filter(|_| !is_proved) else {
            return Ok(known(Some(true), None, None));
        };
        if !self.sampled()?.beside_rest().verdict().stable {
            let reason = "the loop is not stable by itself".to_owned();
            return Ok(known(Some(false), Some(reason), None));
        }
        if let Some(at) = plant.active(&units.wall, &self.law.operator)? {
            let reason = format!(
                "a hand that pushes at {} is given energy: it feels a damping of {}",
                written("omega_rad_s", at.omega_rad_s),
                written("damping_n_s_per_m", at.damping_n_s_per_m)
            );
            return Ok(known(Some(false), Some(reason), Some(at.omega_rad_s)));
        }
        let why = match damping {
            Some((damping, omega)) => format!(
                "the plant damps by {} only, at {}",
                written("damping_n_s_per_m", damping),
                written("omega_rad_s", omega)
            ),
            None => "the hand acts elsewhere than the law, or the plant is not passive by itself"
                .to_owned(),
        };
        let reason = format!("not proved, as {why}; no single frequency gives a hand energy");
        Ok(known(None, Some(reason), None))
    }

    pub(crate) fn required_delta(&self) -> Result<RequiredDelta, Failure> {
        let Nondimensional { alpha, beta, .. } = self.parameters;
        let required = self.port()?.required_delta(alpha, beta);
        required.map_err(Failure::input)
    }

    /// The largest α and the largest β that are passive with this δ, each with the other as it is.
    fn largest_passive(&self, delta: f64) -> Result<[Option<f64>; 2], Failure> {
        let (port, Nondimensional { alpha, beta, .. }) = (self.port()?, self.parameters);
        let largest = |found: Result<Largest, AnalysisError>| match found.map_err(Failure::input)? {
            Largest::Below { value, .. } => Ok::<_, Failure>(Some(value)),
            Largest::Any | Largest::Empty => Ok(None),
        };
        Ok([
            largest(port.largest_alpha(delta, beta))?,
            largest(port.largest_beta(delta, alpha))?,
        ])
    }

    pub(crate) fn region(&self, warn: Warn<'_>) -> Result<Analysed, Failure> {
        if self.of_wall == 1 {
            warn(&format!(
                "no wall is marked: give both {STIFFNESS} and {DISSIPATION}, or {ALPHA} and {BETA}"
            ));
        }
        let Nondimensional { delta, gamma, .. } = self.parameters;
        // Beyond an integral there is no box that holds them.
        let region = if self.law.integrates() {
            None
        } else {
            Some(self.stable_region(BOUNDARY)?)
        };
        let area = region.as_ref().and_then(StabilityRegion::bounded);
        let polygons = area.map_or(&[][..], |area| &area.polygons);
        let mut outlines = polygons.iter().map(|polygon| {
            let points = polygon.points.iter();
            let points = points.map(|at| json!({"alpha": at.alpha, "beta": at.beta}));
            points.collect::<Vec<_>>()
        });
        let [stiffness, dissipation] = self.with_units(
            area.map(|area| area.alpha_max),
            area.map(|area| area.beta_at_alpha_max),
        );
        let mut found = json!({
            "empty": region.as_ref().map(|_| area.is_none()),
            "area": region.as_ref().map(|_| area.map_or(0.0, |area| area.area)),
            "alpha_max": area.map(|area| area.alpha_max),
            "beta_at_alpha_max": area.map(|area| area.beta_at_alpha_max),
            "beta_max": area.map(|area| area.beta_max),
            "stiffness_max_n_per_m": stiffness,
            "dissipation_at_stiffness_max_n_s_mu_per_m": dissipation,
            // Outline of the largest part; others follow in `further_parts`.
            "boundary": outlines.next().unwrap_or_default(),
            "further_parts": outlines.collect::<Vec<_>>(),
        });
        if self.law.in_place.is_some() {
            self.of_scales(&mut found, area)?;
        }
        let drawn = area.map(|_| Drawn::Region(self.drawn_region(polygons)));
        let without_units = json!({"delta": self.of_device(delta), "gamma": self.of_device(gamma)});
        Ok(Analysed {
            report: self.report(without_units, found),
            drawn,
            about: self.words(false),
        })
    }

    /// Adds the factors on a whole law with which it is stable. The area of a controller is of a spring beside it, over that factor.
    fn of_scales(&self, found: &mut Value, area: Option<&StableArea>) -> Result<(), Failure> {
        let stable = self.sampled()?.beside_rest().stable_factors(SCALES);
        found["stable_scales"] = json!(stable);
        if self.law.is_controller() {
            let scale = |beta: f64| beta / self.parameters.beta;
            found["dissipation_at_stiffness_max_n_s_mu_per_m"] = Value::Null;
            found["scale_at_stiffness_max"] = json!(area.map(|at| scale(at.beta_at_alpha_max)));
            found["scale_max"] = json!(area.map(|at| scale(at.beta_max)));
        }
        Ok(())
    }

    fn drawn_region(&self, polygons: &[Polygon]) -> Region {
        let Nondimensional { alpha, beta, .. } = self.parameters;
        let [k, b] = self.with_units(Some(1.0), Some(1.0));
        let b = if self.law.is_controller() {
            Some(1.0 / beta)
        } else {
            b
        };
        Region {
            parts: polygons.to_vec(),
            units: k.zip(b).map(|(k, b)| [k, b]),
            wall: (self.of_wall == 2).then_some((beta, alpha)),
            in_place: self.law.in_place.as_ref().map(InPlace::kind),
        }
    }

    pub(crate) fn sensitivity(&self, _: Warn<'_>) -> Result<Analysed, Failure> {
        let sampled = self.sampled()?;
        let peak = sampled.sensitivity_peak().map_err(Failure::input)?;
        let points = logarithmic(1e-3 * PI, PI, self.points).map(|theta| SensitivityPoint {
            theta,
            magnitude_db: decibel(sampled.sensitivity(theta)),
        });
        let points: Vec<SensitivityPoint> = points.collect();
        let found = json!({
            "peak_db": decibel(peak.value),
            "theta_at_peak": peak.theta,
            "points": points,
        });
        Ok(Analysed {
            report: self.report(json!({}), found),
            drawn: Some(Drawn::Sensitivity(points)),
            about: self.words(true),
        })
    }

    /// The loop in words below a picture: operator and, if it is one of them, the wall; device, delay and lag in a second line.
    fn words(&self, with_wall: bool) -> String {
        let few = |value: f64| digits(value, 4);
        let Nondimensional {
            alpha,
            beta,
            delta,
            gamma,
        } = self.parameters;
        let k_and_b = match self.with_units(Some(alpha), Some(beta)) {
            [Some(stiffness), Some(dissipation)] => format!(
                "K = {} · B = {}",
                written("stiffness_n_per_m", stiffness),
                written("dissipation_n_s_mu_per_m", dissipation)
            ),
            _ => format!("α = {} · β = {}", few(alpha), few(beta)),
        };
        let law = self.law.words(with_wall.then_some(k_and_b));
        let (mut device, hand) = match (self.mass_and_time(), &self.on_plant) {
            (Some([_, t]), Some(plant)) => {
                let sampled = format!("T = {}", written("sample_time_s", t));
                (vec![plant.name.clone(), sampled], String::new())
            }
            (Some([mass, t]), None) => {
                let hand = written("hand_stiffness_n_per_m", gamma * mass / (t * t));
                let device = vec![
                    format!("m = {}", written("mass_kg", mass)),
                    format!("b = {}", written("damping_n_s_per_m", delta * mass / t)),
                    format!("T = {}", written("sample_time_s", t)),
                ];
                (device, format!("hand {hand}"))
            }
            (None, _) => (
                vec![format!("δ = {}", few(delta))],
                format!("γ = {}", few(gamma)),
            ),
        };
        device.extend((gamma > 0.0).then_some(hand));
        let time = |samples: f64| match self.sample_time_s {
            Some(t) => written("delay_s", samples * t),
            None => format!("{} samples", few(samples)),
        };
        device.push(format!("delay {}", time(self.path.delay_samples())));
        let lag = self.path.lag_samples();
        device.extend((lag > 0.0).then(|| format!("current lag {}", time(lag))));
        format!("{}\n{}", law.join(" · "), device.join(" · "))
    }
}

impl OnPlant {
    /// The plant of a file with `[state_space]`, if there is one.
    pub(crate) fn of(
        table: &Table<'_>,
        sample_time_s: Option<f64>,
    ) -> Result<Option<Box<Self>>, Failure> {
        let Some(file) = table.file(&PLANT_MODEL)? else {
            return Ok(None);
        };
        let of_device = [
            &DEVICE_MODEL,
            &ANALYSED_MASS,
            &ANALYSED_DAMPING,
            &ANALYSED_HAND,
            &ANALYSED_LAG,
        ];
        without(table, &of_device, &PLANT_MODEL)?;
        let t = sample_time_s.ok_or_else(|| missing(&ANALYSED_SAMPLE_TIME))?;
        let name = file.display().to_string();
        let PlantModel::StateSpace {
            a,
            b,
            c,
            hand,
            delay_s,
            current_lag_s,
        } = PlantModel::read(&file)?
        else {
            return Err(Failure::bad_input(format_args!(
                "{name} has no [state_space]: give {PLANT_MODEL} with one, or {DEVICE_MODEL} with [device]"
            )));
        };
        let further = path(table, sample_time_s)?.delay_samples();
        let path = ForcePath::new(further + delay_s / t, current_lag_s / t).map_err(analysed)?;
        let a: Vec<f64> = a.into_iter().flatten().collect();
        let change = |error: AnalysisError| {
            Failure::input_with_advice(error, format_args!("change {PLANT_MODEL}"))
        };
        let sampled = SampledPlant::linear(&a, &b, &c, t, 1.0, path).map_err(change)?;
        let [b_hand, c_hand] = hand.each_ref().map(Option::as_deref);
        Ok(Some(Box::new(Self {
            name,
            sampled,
            path,
            port: HandPort::new([&a, &b, &c], [b_hand, c_hand]).map_err(change)?,
        })))
    }

    pub(crate) const fn path(&self) -> ForcePath {
        self.path
    }

    /// A law as a hand meets it through the plant.
    pub(crate) fn felt(
        &self,
        wall: &SampledWall,
        operator: &LoopOperator,
        omega: f64,
    ) -> Result<Effective, AnalysisError> {
        let at = Dynamics::ideal(1.0, 0.0).nondimensional(wall)?;
        let sampled = SampledLoop::with_plant(self.sampled, at.alpha, at.beta, operator)?;
        let (t, theta) = (wall.sample_time_s, (omega * wall.sample_time_s).min(PI));
        let (law, gain) = (wall.response(operator, theta), sampled.loop_gain(theta));
        self.port.felt(law, gain, self.path, t, omega)
    }

    /// The least damping that a hand feels, if it is below 0: there the loop gives it energy.
    fn active(
        &self,
        wall: &SampledWall,
        operator: &LoopOperator,
    ) -> Result<Option<Effective>, Failure> {
        let nyquist = PI / wall.sample_time_s;
        let felt = logarithmic(nyquist * LOWEST, nyquist, ACTIVE_POINTS)
            .map(|omega| self.felt(wall, operator, omega));
        let felt = felt
            .collect::<Result<Vec<_>, _>>()
            .map_err(Failure::input)?;
        let damping = |at: &Effective| at.damping_n_s_per_m;
        let least = felt
            .into_iter()
            .min_by(|a, b| damping(a).total_cmp(&damping(b)));
        Ok(least.filter(|at| damping(at) < 0.0))
    }
}

pub(crate) fn missing(parameter: &Parameter) -> Failure {
    Failure::bad_input(format_args!(
        "{parameter} is missing: give {ALPHA} and {BETA}, or {ANALYSED_MASS}, {ANALYSED_SAMPLE_TIME} and the wall"
    ))
}

/// Delay and lag of a loop in samples; `sample_time_s` is its own, if it was given.
pub(crate) fn path(table: &Table<'_>, sample_time_s: Option<f64>) -> Result<ForcePath, Failure> {
    let in_samples = table.number_if(&DELAY_SAMPLES)?;
    if in_samples.is_some() && table.has(&ANALYSED_DELAY) {
        return Err(Failure::bad_input(format_args!(
            "the delay is given in samples and in seconds: omit {DELAY_SAMPLES} or {ANALYSED_DELAY}"
        )));
    }
    let samples = |parameter: &Parameter| {
        let time_s = table.number_if(parameter)?.unwrap_or(0.0);
        match sample_time_s {
            Some(t) => Ok(time_s / t),
            None if time_s == 0.0 => Ok(0.0),
            None => Err(Failure::bad_input(format_args!(
                "{parameter} {time_s} s is a time, but the loop has no units: give {ANALYSED_SAMPLE_TIME}"
            ))),
        }
    };
    let delay = in_samples.map_or_else(|| samples(&ANALYSED_DELAY), Ok)?;
    ForcePath::new(delay, samples(&ANALYSED_LAG)?).map_err(analysed)
}

pub(crate) fn path_result(path: ForcePath, sample_time_s: Option<f64>) -> Value {
    json!({
        "delay_samples": path.delay_samples(),
        "delay_s": sample_time_s.map(|t| path.delay_samples() * t),
        "current_lag_samples": path.lag_samples(),
        "current_lag_s": sample_time_s.map(|t| path.lag_samples() * t),
    })
}
