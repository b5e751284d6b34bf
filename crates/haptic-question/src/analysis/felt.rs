//! The impedance that is felt of a wall, alone or through a device, and the damping that a coupler needs.

use crate::analysis::answer::{
    Analysed, Drawn, FREQUENCIES_MOST, FeltPoint, HORIZON, logarithmic, operator,
};
use crate::analysis::keys::{
    ANALYSED_CONTROLLER, ANALYSED_DAMPING, ANALYSED_MASS, ANALYSED_SAMPLE_TIME, ANALYSED_SCHEME,
    COUPLING_ORDER, OMEGA_MAX, OMEGA_MIN, POINTS,
};
use crate::analysis::law::Law;
use crate::analysis::wall::{OnPlant, missing, path, path_result};
use fracdiff::num_complex::Complex;
use fracdiff::{FrequencyResponse, Order, Scheme, Seconds};
use haptic_analysis::{
    ClosedLoop, Coupler, Dynamics, LeastDamping, LoopOperator, SampledLoop, SampledPlant,
    SampledWall,
};
use haptic_document::Warn;
use haptic_document::parameters::{COUPLER_DAMPING, COUPLER_SPRING, Parameter};
use haptic_document::{Failure, Table, rows};
use haptic_quantity::written;
use haptic_trial::keys::wall::{DISSIPATION, STIFFNESS};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// A law, at these frequencies, and the device that it is felt through.
#[derive(Clone, Debug)]
pub(crate) struct Felt {
    wall: SampledWall,
    law: Law,
    omegas: Vec<f64>,
    closed: Option<ClosedLoop>,
    /// A plant in place of the device.
    on_plant: Option<Box<OnPlant>>,
}

impl Felt {
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let given = if table.text(&ANALYSED_CONTROLLER)?.is_empty() {
            Some(table.required(&ANALYSED_SAMPLE_TIME)?)
        } else {
            table.number_if(&ANALYSED_SAMPLE_TIME)?
        };
        let (law, t) = Law::of(table, given)?;
        let t = t.map_or_else(|| table.required(&ANALYSED_SAMPLE_TIME), Ok)?;
        let needed =
            |given: Option<f64>, key: &Parameter| given.map_or_else(|| table.required(key), Ok);
        let nyquist = PI / t;
        let high = table.number_if(&OMEGA_MAX)?.unwrap_or(nyquist);
        let low = table.number_if(&OMEGA_MIN)?.unwrap_or(high * 1e-3);
        if !(low < high && high <= nyquist) {
            return Err(Failure::bad_input(format_args!(
                "{low} to {high} rad/s are not in 0 to {nyquist}: change {OMEGA_MIN} or {OMEGA_MAX}"
            )));
        }
        let count = table.count_in(&POINTS, 2..=FREQUENCIES_MOST)?;
        Ok(Self {
            wall: SampledWall {
                stiffness_n_per_m: needed(law.stiffness, &STIFFNESS)?,
                dissipation_n_s_mu_per_m: needed(law.dissipation, &DISSIPATION)?,
                order: law.order,
                sample_time_s: t,
            },
            law,
            omegas: logarithmic(low, high, count).collect(),
            closed: None,
            on_plant: None,
        })
    }

    pub(crate) fn through_device(table: &Table<'_>) -> Result<Self, Failure> {
        let alone = Self::of(table)?;
        if let Some(plant) = OnPlant::of(table, Some(alone.wall.sample_time_s))? {
            return Ok(Self {
                on_plant: Some(plant),
                ..alone
            });
        }
        let needed = |parameter: &Parameter| table.required(parameter);
        let closed = ClosedLoop {
            mass_kg: needed(&ANALYSED_MASS)?,
            damping_n_s_per_m: needed(&ANALYSED_DAMPING)?,
            environment: alone.wall,
            path: path(table, Some(alone.wall.sample_time_s))?,
        };
        Ok(Self {
            closed: Some(closed),
            ..alone
        })
    }

    pub(crate) const fn sample_time_s(&self) -> f64 {
        self.wall.sample_time_s
    }

    /// D¹ by the law's scheme, or by none if it has no such derivative.
    pub(crate) fn damper(&self) -> Result<LoopOperator, Failure> {
        let order = Order::new(1.0).map_err(Failure::input)?;
        let t = Seconds(self.wall.sample_time_s);
        let of = |scheme| LoopOperator::new(scheme, order, t, HORIZON);
        let damper = of(self.law.scheme).or_else(|_| of(Scheme::Exact));
        damper.map_err(Failure::input)
    }

    /// The law alone as it is rendered, and a spring and a damper of 1 in its place, N/m.
    pub(crate) fn rendered(
        &self,
        damper: &LoopOperator,
        omega: f64,
    ) -> Result<[Complex<f64>; 3], Failure> {
        let Some(closed) = &self.closed else {
            return Err(missing(&ANALYSED_MASS));
        };
        let t = self.wall.sample_time_s;
        let theta = (omega * t).min(PI);
        let laws = [
            self.wall.response(&self.law.operator, theta),
            Complex::ONE,
            damper.response(theta) / t,
        ];
        let [law, spring, damper] = laws.map(|law| closed.rendered(law, omega));
        let all = law.and_then(|law| Ok([law, spring?, damper?]));
        all.map_err(Failure::input)
    }

    /// True if the loop with a spring and a damper in place of the law is stable.
    pub(crate) fn bears(
        &self,
        damper: &LoopOperator,
        [stiffness, damping]: [f64; 2],
    ) -> Result<bool, Failure> {
        let Some(closed) = &self.closed else {
            return Err(missing(&ANALYSED_MASS));
        };
        let wall = SampledWall {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: damping,
            order: damper.order(),
            ..self.wall
        };
        let device = Dynamics::ideal(closed.mass_kg, closed.damping_n_s_per_m);
        let verdict = device.nondimensional(&wall).and_then(|at| {
            let plant = SampledPlant::behind(at.delta, at.gamma, closed.path)?;
            let sampled = SampledLoop::with_plant(plant, at.alpha, at.beta, damper)?;
            Ok(sampled.beside_rest().verdict())
        });
        Ok(verdict.map_err(Failure::input)?.stable)
    }

    /// Force per displacement at the hand, N/m.
    pub(crate) fn force_per_displacement(&self, omega: f64) -> Result<Complex<f64>, Failure> {
        let felt = self.point(omega)?;
        Ok(Complex::new(
            felt.effective_stiffness_n_per_m,
            omega * felt.effective_damping_n_s_per_m,
        ))
    }

    /// The question as a report repeats it.
    pub(crate) fn asked(&self) -> [Value; 3] {
        let SampledWall {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order,
            sample_time_s,
        } = self.wall;
        let mut law = json!({
            "order": self.law.of_wall(order.get()),
            "scheme": self.law.scheme.to_string(),
            "sample_time_s": sample_time_s,
            "stiffness_n_per_m": self.law.of_wall(stiffness_n_per_m),
            "dissipation_n_s_mu_per_m": self.law.of_wall(dissipation_n_s_mu_per_m),
        });
        if let Some(plant) = &self.on_plant {
            law["plant_model"] = json!(plant.name);
        }
        let path = self.closed.map(|closed| closed.path);
        let path = path.or(self.on_plant.as_ref().map(|plant| plant.path()));
        let path = path.map_or(json!({}), |path| path_result(path, Some(sample_time_s)));
        [law, self.law.in_place_result(), path]
    }

    /// The law in the words below a picture.
    pub(crate) fn words(&self) -> String {
        let k_and_b = format!(
            "K = {} · B = {}",
            written("stiffness_n_per_m", self.wall.stiffness_n_per_m),
            written(
                "dissipation_n_s_mu_per_m",
                self.wall.dissipation_n_s_mu_per_m
            )
        );
        let law = self.law.words(Some(k_and_b)).join(" · ");
        format!(
            "{law} · T = {}",
            written("sample_time_s", self.wall.sample_time_s)
        )
    }

    fn point(&self, omega: f64) -> Result<FeltPoint, Failure> {
        let (sampled, continuous) = match (&self.closed, &self.on_plant) {
            (_, Some(plant)) => (plant.felt(&self.wall, &self.law.operator, omega), None),
            (Some(closed), None) => {
                let continuous = match &self.law.in_place {
                    Some(law) => closed.felt(law.stiffness(omega), omega),
                    None => closed.continuous(omega),
                };
                let sampled = closed.sampled(&self.law.operator, omega);
                (sampled, Some(continuous.map_err(Failure::input)?))
            }
            (None, None) => (self.wall.effective(&self.law.operator, omega), None),
        };
        let sampled = sampled.map_err(Failure::input)?;
        Ok(FeltPoint {
            omega_rad_s: sampled.omega_rad_s,
            effective_stiffness_n_per_m: sampled.stiffness_n_per_m,
            effective_damping_n_s_per_m: sampled.damping_n_s_per_m,
            continuous_stiffness_n_per_m: continuous.map(|felt| felt.stiffness_n_per_m),
            continuous_damping_n_s_per_m: continuous.map(|felt| felt.damping_n_s_per_m),
        })
    }

    pub(crate) fn answer(&self, warn: Warn<'_>) -> Result<Analysed, Failure> {
        let ends = [self.omegas.first(), self.omegas.last()];
        if let [Some(low), Some(high)] = ends {
            let beyond = self.law.beyond((1.0 / high, 1.0 / low));
            beyond.iter().for_each(|beyond| warn(beyond));
        }
        let points = self.omegas.iter().map(|&omega| self.point(omega));
        let points = points.collect::<Result<Vec<_>, Failure>>()?;
        let shown = points.iter().map(|at| {
            let mut point = json!({
                "omega_rad_s": at.omega_rad_s,
                "effective_stiffness": at.effective_stiffness_n_per_m,
                "effective_damping": at.effective_damping_n_s_per_m,
            });
            if self.closed.is_some() {
                point["continuous_stiffness_n_per_m"] = json!(at.continuous_stiffness_n_per_m);
                point["continuous_damping_n_s_per_m"] = json!(at.continuous_damping_n_s_per_m);
            }
            point
        });
        let found = json!({
            "effective_stiffness_unit": "N/m",
            "effective_damping_unit": "N·s/m",
            "points": shown.collect::<Vec<_>>(),
        });
        Ok(Analysed {
            report: rows(self.asked().into_iter().chain([found])),
            drawn: Some(Drawn::Felt(points)),
            about: self.words(),
        })
    }
}

/// A coupler, and the damping of the device beside it.
#[derive(Clone, Debug)]
pub(crate) struct CouplerNeed {
    order: Order,
    scheme: Scheme,
    operator: LoopOperator,
    sample_time_s: f64,
    damper: f64,
    spring: f64,
    damping: Option<f64>,
}

impl CouplerNeed {
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let order = table.order(&COUPLING_ORDER)?;
        let t = table.required(&ANALYSED_SAMPLE_TIME)?;
        let (scheme, operator) = operator(table, &ANALYSED_SCHEME, order, Some(t))?;
        let asked = Self {
            order,
            scheme,
            operator,
            sample_time_s: t,
            damper: table.required(&COUPLER_DAMPING)?,
            spring: table.required(&COUPLER_SPRING)?,
            damping: table.number_if(&ANALYSED_DAMPING)?,
        };
        asked.coupler()?;
        Ok(asked)
    }

    fn coupler(&self) -> Result<Coupler<'_>, Failure> {
        let exact = Coupler::exact(self.order, self.sample_time_s, self.damper, self.spring);
        let exact = exact.map_err(Failure::input)?;
        Ok(if self.scheme == Scheme::Exact {
            exact
        } else {
            exact.with_operator(&self.operator, self.operator.memory())
        })
    }

    pub(crate) fn answer(&self) -> Result<Analysed, Failure> {
        let coupler = self.coupler()?;
        let least = coupler.least_damping().map_err(Failure::input)?;
        let (required, worst_theta) = match least {
            LeastDamping::Enough {
                damping_n_s_per_m,
                worst_theta,
            } => (Some(damping_n_s_per_m), worst_theta),
            LeastDamping::NoneIsEnough { theta } => (None, theta),
        };
        let passive = match (required, self.damping) {
            (None, _) => Some(false),
            (Some(_), Some(b)) => Some(coupler.passive(b).map_err(Failure::input)?),
            (Some(_), None) => None,
        };
        let found = json!({
            "order": self.order.get(),
            "scheme": self.scheme.to_string(),
            "sample_time_s": self.sample_time_s,
            "coupler_damping_n_s_per_m": self.damper,
            "coupler_spring_n_s_1_minus_mu_per_m": self.spring,
            "damping_n_s_per_m": self.damping,
            // By Llewellyn's criterion, null if no damping is enough, and by Corollary 2.
            "required_damping": required,
            "required_damping_unit": "N·s/m",
            "corollary_damping": coupler.corollary_damping(),
            "corollary_damping_unit": "N·s/m",
            "worst_theta": worst_theta,
            "passive": passive,
            "passive_reason": passive.is_none().then(|| format!("give {ANALYSED_DAMPING} to know")),
            "reason": required.is_none().then(|| format!(
                "the coupler itself is active at theta = {worst_theta:.6}: no damping is enough"
            )),
        });
        Ok(Analysed::in_numbers(rows([found])))
    }
}
