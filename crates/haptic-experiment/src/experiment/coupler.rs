//! A fractional virtual coupler: a device is pushed and thrown into it, an object behind it moves, and all comes to rest or not.
//!
//! ```text
//! m·x'' + b·x' + k·x = push − F,   F = Z_c·(v_h − v_e) = Z_o·v_e through the safety chain,   x(0) = 0, x'(0) = impact
//! Z_c = k_c + b_c·(T/(1 − w))^μ, 0 ≤ μ ≤ 1,   Z_o: mass m_o, damping b_o, spring k_o to the ground
//! at rest, μ = 1: x = push/(k + 1/(1/b_c + 1/k_o)), the object at F/k_o
//! ```
//! - *Below order 1* nothing holds the push: the coupler creeps as t^(1−μ) under it. There is no rest position then, and the force
//!   alone is judged, as for a wall without a spring.
//! - *The object* is in no log: it follows from the positions, and the table of the run has it.
//! - *A loop on a device* cannot carry it: its firmware renders walls. The loop on the host can.
//!
//! Before the run the loop is analysed, with the two criteria for every hand and object:
//!
//! ```text
//! stable      the sampled loop of this device, this hand and this object has no pole on or outside the unit circle: certified
//! Llewellyn   2b·Re(1/Z_c) ≥ cos(θ/2)(1 − cos(θ/2)): every passive hand and object, of a device under Tustin's rule
//! passive     2b·Re(1/Z_c) ≥ 1 − cos θ (no delay): every passive hand and object, of the sampled device
//! ```
//! - *Llewellyn is not enough for a real device.* Under Tustin's rule the force acts half a sample earlier than a held one does. The
//!   sampled port needs at least four times the damping of his criterion, and a coupler that passes it can be unstable with a light device:
//!   so the loop that runs is analysed too. A run needs both, `stable` and Llewellyn; `passive` is only reported.
//! - *Only* `passive` *promises anything for another hand.*
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, chapter V.

use super::kind::Experiment as _;
use super::trial::{
    OfSample, OffN, Parts, Trial, TrialSetup, incomparable, limited, setup, six_digits,
};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, CoupledLoop, CoupledObject, Coupler, CouplerOperator, Dynamics, LoopOperator,
};
use haptic_document::parameters::range::{COUPLER_ORDERS, DAMPINGS, OBJECT_MASSES, STIFFNESSES};
use haptic_document::parameters::{COUPLER_DAMPING, COUPLER_SPRING};
use haptic_document::parameters::{Parameter, joined};
use haptic_document::{Failure, FileError, Table, parameters, parameters as p};
use haptic_judge::preflight::softer;
use haptic_judge::reference::ReferenceWeights;
use haptic_judge::reference::{ReferenceSeries, operator};
use haptic_judge::settling::Settling;
use haptic_judge::tissue_table::scheme;
use haptic_link::LoopMode;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{
    Controller, Environment, OwnPush, VirtualCoupler, VirtualObject, deflection_order,
};
use haptic_run::Ran;
use haptic_run::remote::{RemoteDevice, RemoteLaw};
use haptic_trial::GuardChoice;
use haptic_trial::advice::analysed;
use haptic_trial::device_table::encoder_step;
use haptic_trial::keys::trial::{TRIAL, TRIAL_LOOP};
use haptic_trial::preflight::{CouplerVerdict, PreflightVerdict};
use haptic_trial::samples::horizon;
use nalgebra::Vector1;
use serde_json::{Value, json};

parameters! {
    crate;
    COUPLER_ORDER = optional("order", COUPLER_ORDERS,
        "Order of the coupler: 1 a spring beside a damper, below 1 the spring creeps; above 1 it would generate energy");
    /// Mass of the object, kg.
    OBJECT_MASS = number("object_mass_kg", 0.1, "100g", OBJECT_MASSES, "Mass of the object behind the coupler");
    /// Damping of the object, N·s/m.
    OBJECT_DAMPING = number("object_damping_n_s_per_m", 1.0, "1", DAMPINGS, "Viscous damping of the object");
    /// Spring of the object, N/m.
    OBJECT_STIFFNESS = number("object_stiffness_n_per_m", 500.0, "500", STIFFNESSES,
        "Spring between object and ground; 0 = nothing holds the object in place");
    /// True if a refused coupler is a failure.
    COUPLER_MUST_BE_STABLE = flag("must_be_stable",
        "Fail unless trial, analysis and Llewellyn's criterion accept the coupler");
}

/// Keys of `[coupler]` that have to be given in a file.
pub(crate) const COUPLER_REQUIRED: &[Parameter] = &[
    p::MASS,
    p::DAMPING,
    p::SAMPLE_TIME,
    COUPLER_ORDER,
    COUPLER_DAMPING,
    COUPLER_SPRING,
];

/// Keys of `[coupler]` with defaults.
pub(crate) const COUPLER: &[Parameter] = &joined::<22>(&[
    &[
        p::DEVICE_MODEL,
        OBJECT_MASS,
        OBJECT_DAMPING,
        OBJECT_STIFFNESS,
    ],
    &[p::HAND_STIFFNESS],
    p::LESS_THAN_IDEAL,
    TRIAL_LOOP,
    TRIAL,
    &[COUPLER_MUST_BE_STABLE],
]);

#[derive(Clone, Debug)]
pub(crate) struct CouplerExperiment {
    /// Device, trial, safety and pace.
    pub setup: TrialSetup,
    /// μ, 0 to 1.
    pub order: Order,
    /// The operator; it has the order 1 − μ and runs on the deflection.
    pub scheme: Scheme,
    /// `k_c`, N·s/m, at least 0.
    pub coupler_damping_n_s_per_m: f64,
    /// `b_c`, N·s^(1−μ)/m, at least 0.
    pub coupler_spring_n_s_1_minus_mu_per_m: f64,
    pub object: CoupledObject,
}

/// `[coupler]`: device, coupler, object and trial, with the table of a second device that pushes.
pub(crate) fn coupler(
    table: &Table<'_>,
    drive: Option<&Table<'_>>,
) -> Result<CouplerExperiment, FileError> {
    let setup = setup(table, &COUPLER_MUST_BE_STABLE, drive)?;
    let order = table.order(&COUPLER_ORDER)?;
    let run = deflection_order(order).map_err(|error| table.fail_at("order", error))?;
    let (t, duration_s) = (setup.device.sample_time.0, setup.plan.duration_s);
    let coupler = CouplerExperiment {
        setup,
        order,
        scheme: scheme(table, None, run, t, duration_s)?,
        coupler_damping_n_s_per_m: table.required(&p::COUPLER_DAMPING)?,
        coupler_spring_n_s_1_minus_mu_per_m: table.required(&p::COUPLER_SPRING)?,
        object: CoupledObject {
            mass_kg: table.number(&OBJECT_MASS)?,
            damping_n_s_per_m: table.number(&OBJECT_DAMPING)?,
            stiffness_n_per_m: table.number(&OBJECT_STIFFNESS)?,
        },
    };
    (coupler.check_loop()).map_err(|error| table.fail_at(p::LOOP.key, error))?;
    (coupler.check()).map_err(|error| table.fail(error))?;
    Ok(coupler)
}

/// The coupler of an experiment.
type Law = VirtualCoupler<f64, Operator<f64>>;

impl CouplerExperiment {
    /// The analysis of the loop on the simulated device.
    #[cfg(test)]
    pub(crate) fn look(&self) -> Result<PreflightVerdict, Failure> {
        self.judge(self.check()?, self.setup.dynamics(), 0)
    }

    /// Refuses a loop on a device, which cannot carry it.
    pub(crate) fn check_loop(&self) -> Result<(), Failure> {
        match self
            .setup
            .conduct
            .remote
            .as_ref()
            .map(|remote| remote.loop_mode)
        {
            Some(LoopMode::Device) => Err(Failure::bad_input(format_args!(
                "a loop on the device cannot run a coupler, as its firmware renders only walls: give {loop_host}",
                loop_host = p::LOOP.set_to("host")
            ))),
            _ => Ok(()),
        }
    }

    /// The coupler with its object, for a run of `samples` samples.
    fn law(&self, samples: u64) -> Result<Law, Failure> {
        let t = self.setup.device.sample_time;
        let order = deflection_order(self.order).map_err(Failure::input)?;
        let operator = self.scheme.build(order, t, horizon(samples));
        let object = VirtualObject::new(
            Kilograms(self.object.mass_kg),
            NewtonSecondsPerMetre(self.object.damping_n_s_per_m),
            NewtonsPerMetre(self.object.stiffness_n_per_m),
        );
        let object = object.map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("give {OBJECT_MASS}, {OBJECT_DAMPING} or {OBJECT_STIFFNESS} above 0"),
            )
        })?;
        VirtualCoupler::new(
            self.coupler_damping_n_s_per_m,
            self.coupler_spring_n_s_1_minus_mu_per_m,
            operator.map_err(Failure::input)?,
            object,
            t,
        )
        .map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("give {COUPLER_DAMPING} or {COUPLER_SPRING} above 0"),
            )
        })
    }

    /// Place of the object, m, from the positions that the loop read, one after the other.
    fn replayed(&self, samples: u64) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
        let law = self.law(samples)?;
        let mut history = Environment::<f64, 1>::at_rest(&law);
        Ok(move |x| {
            law.advance(&mut history, &Vector1::new(x));
            law.object_position_m(&history)[0]
        })
    }

    /// Stiffness that coupler and object hold a push with for ever, N/m: both springs in series at order 1, none below.
    fn holding_stiffness(&self) -> f64 {
        let (spring, ground) = (
            self.coupler_spring_n_s_1_minus_mu_per_m,
            self.object.stiffness_n_per_m,
        );
        if self.order.get() < 1.0 || spring <= 0.0 || ground <= 0.0 {
            0.0
        } else {
            1.0 / (1.0 / spring + 1.0 / ground)
        }
    }
}

impl Trial for CouplerExperiment {
    type Law = OwnPush<f64, Law>;
    const KIND: &'static str = "coupler";
    const NO_REST: &'static str =
        "the coupler creeps or nothing holds the object, so there is no rest position";
    const MUST_BE_STABLE: Parameter = COUPLER_MUST_BE_STABLE;
    const REFUSED: &'static str =
        ", analysis and Llewellyn's criterion do not all accept the coupler";

    fn setup(&self) -> &TrialSetup {
        &self.setup
    }

    fn setup_mut(&mut self) -> &mut TrialSetup {
        &mut self.setup
    }

    /// The analysis has its say here on the simulated device alone: a serial one heard it before it was armed.
    fn warning(&self, ran: &Ran) -> Option<String> {
        let analysis = ran
            .preflight
            .filter(|_| self.setup.conduct.remote.is_none());
        // Energy bounding promises passivity for the damping of the device.
        let guarded = self.setup.safety.guard == GuardChoice::EnergyBounding;
        analysis.and_then(|analysis| analysis.warning(guarded))
    }

    fn judge(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<PreflightVerdict, Failure> {
        let judged = self.looked_at(samples, dynamics, line);
        judged.map_err(analysed)
    }

    /// Only a loop on the host carries a coupler: the device renders nothing.
    fn law_there(&self, _: &RemoteDevice, _: u64) -> Result<RemoteLaw, Failure> {
        Ok(self.setup.law())
    }

    fn operator_choice(&self) -> (Order, Scheme) {
        (self.order, self.scheme)
    }

    fn law_in_words(&self) -> String {
        let object = self.object;
        format!(
            "order μ = {} · damper {} N·s/m · spring {} N·s^{{1−μ}}/m\nobject {} kg, {} N·s/m, {} N/m",
            self.order,
            six_digits(self.coupler_damping_n_s_per_m),
            six_digits(self.coupler_spring_n_s_1_minus_mu_per_m),
            six_digits(object.mass_kg),
            six_digits(object.damping_n_s_per_m),
            six_digits(object.stiffness_n_per_m)
        )
    }

    fn parts(&self) -> Result<Parts<Self::Law>, Failure> {
        let setup = &self.setup;
        let plan = setup.plan();
        let samples = plan.samples(self.setup.device.sample_time)?;
        let device = setup.sensed()?;
        let law = self.law(samples)?;
        let holding = self.holding_stiffness();
        // A coupler that creeps has no rest position, whatever the hand: the force alone is judged.
        let hand = setup.device.stiffness.0;
        let spring = if holding > 0.0 { holding + hand } else { 0.0 };
        let judge = plan.judge(
            spring,
            law.step_stiffness_n_per_m(),
            encoder_step(self.setup.sensors),
            self.setup.device.sample_time.0,
        );
        Ok(Parts {
            controller: Controller::new(OwnPush::new(law, plan.own_push_n()), setup.chain()?),
            device,
            samples,
            judge,
            rest_m: (spring > 0.0).then(|| self.setup.plan.push_n / spring),
        })
    }

    fn object_m(&self, ran: &Ran) -> Result<Option<OfSample<'_>>, Failure> {
        let planned = self.setup.plan().samples(self.setup.device.sample_time)?;
        let samples = ran.samples();
        let mut step = self.replayed(planned)?;
        for sample in &ran.record.approach {
            step(sample.position_m);
        }
        let mut object = ReferenceSeries::stepped(samples, step)?;
        Ok(Some(Box::new(move |sample| object.at(sample))))
    }

    /// The force by the full history of the deflection, which follows from the forces.
    fn off_n(&self, ran: &Ran) -> Result<OffN<'_>, Failure> {
        let record = &ran.record;
        let reference = ReferenceWeights::of(self.scheme);
        let order = Order::new(1.0 - self.order.get()).map_err(Failure::input)?;
        let t = self.setup.device.sample_time;
        let push_n = self.setup.plan.own_push_n().unwrap_or(0.0);
        let serial = self.setup.conduct.remote.is_some();
        let reason = limited(record)
            .or_else(|| {
                (record.dropped > 0).then_some("samples are missing, so the object is not known")
            })
            .or_else(|| {
                serial.then_some("a serial device makes each force some samples after its position")
            })
            .or_else(|| incomparable(reference, order, record));
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        // D^(1−μ) of each deflection.
        let mut derivative: Box<dyn FnMut(f64) -> f64> = match &record.whole {
            Some(whole) => {
                let mut object = Object::default();
                let deflection: Vec<f64> = (whole.iter())
                    .map(|sample| {
                        object.deflection(self, sample.position_m, push_n - sample.force_n)
                    })
                    .collect();
                let values = reference.full_history(order, t, &deflection);
                let mut values = values?.into_iter();
                Box::new(move |_| values.next().unwrap_or(f64::NAN))
            }
            None => {
                let planned = self.setup.plan().samples(t)?;
                let mut channel = operator(reference, order, t, planned)?;
                Box::new(move |y| channel.step(y))
            }
        };
        let (mut object, mut last) = (Object::default(), 0.0);
        Ok(Ok(Box::new(move |sample| {
            let reaction_force_n = sample.reaction_n();
            let y = object.deflection(self, sample.position_m, reaction_force_n);
            // F = k_c·(y[n] − y[n−1])/T + b_c·D^(1−μ) y
            let wanted = self.coupler_damping_n_s_per_m * (y - last) / t.0
                + self.coupler_spring_n_s_1_minus_mu_per_m * derivative(y);
            last = y;
            wanted - reaction_force_n
        })))
    }

    fn law_in_rows(&self, _: &Settling, object_m: Option<f64>) -> Value {
        json!({
            "coupler_damping_n_s_per_m": self.coupler_damping_n_s_per_m,
            "coupler_spring_n_s_1_minus_mu_per_m": self.coupler_spring_n_s_1_minus_mu_per_m,
            "object_mass_kg": self.object.mass_kg,
            "object_damping_n_s_per_m": self.object.damping_n_s_per_m,
            "object_stiffness_n_per_m": self.object.stiffness_n_per_m,
            "object_position_m": object_m,
        })
    }

    fn is_accepted(&self, analysis: &PreflightVerdict) -> bool {
        analysis.coupler.is_some_and(|coupler| coupler.llewellyn)
    }
}

impl CouplerExperiment {
    fn looked_at(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<PreflightVerdict, AnalysisError> {
        let t = self.setup.device.sample_time.0;
        let dynamics = Dynamics {
            delay_s: dynamics.delay_s + line as f64 * t,
            ..dynamics
        };
        let path = dynamics.path(t)?;
        let order = Order::new(1.0 - self.order.get())?;
        let operator = LoopOperator::new(self.scheme, order, Seconds(t), horizon(samples))?;
        let exact = Coupler::exact(
            self.order,
            t,
            self.coupler_damping_n_s_per_m,
            self.coupler_spring_n_s_1_minus_mu_per_m,
        )?;
        let runs = CouplerOperator(&operator);
        let coupler = exact.with_operator(&runs, operator.memory());
        let coupled = CoupledLoop::new(&dynamics, &exact, &self.object, &operator)?;
        let stable = coupled.is_stable();
        let margin = if stable {
            coupled.gain_margin()?.map(|edge| edge.value)
        } else {
            softer(|factor| Ok(coupled.scaled(factor).is_stable()))?
        };
        let damping = dynamics.damping_n_s_per_m;
        let llewellyn = coupler.least_damping()?.damping_n_s_per_m();
        let sampled = coupler.sampled_damping(path)?.damping_n_s_per_m();
        let per_delta = t / dynamics.mass_kg;
        let (alpha, beta) = coupled.nondimensional();
        Ok(PreflightVerdict {
            stable,
            margin,
            pulling_contact_margin: None,
            pulling_contact_depth_m: None,
            pushing_contact: None,
            passive: sampled.is_some_and(|needed| damping >= needed),
            required_delta: sampled.map(|needed| needed * per_delta),
            delta: damping * per_delta,
            delay_samples: path.delay_samples(),
            delay_s: dynamics.delay_s,
            current_lag_s: dynamics.current_lag_s,
            alpha,
            beta,
            coupler: Some(CouplerVerdict {
                llewellyn: llewellyn.is_some_and(|needed| damping >= needed),
                damping_n_s_per_m: damping,
                llewellyn_damping_n_s_per_m: llewellyn,
                corollary_damping_n_s_per_m: coupler.corollary_damping(),
                sampled_damping_n_s_per_m: sampled,
            }),
        })
    }
}

/// The object by its own equation from the forces that were commanded, and from it the deflection of the coupler: nothing of
/// the coupler that ran is in it.
///
/// ```text
/// m_o > 0:  v ← v + (T/2m_o)(a + a'),  a = F − b_o·v − k_o·p,   p ← p + (T/2)(v + v')
/// m_o = 0:  F = b_o·v + k_o·p;          q = p + (T/2)·v,   y = x − q
/// ```
#[derive(Debug, Default)]
struct Object {
    velocity: f64,
    position: f64,
    net: f64,
}

impl Object {
    /// The deflection after this sample.
    fn deflection(&mut self, law: &CouplerExperiment, x: f64, force: f64) -> f64 {
        let (t, object) = (law.setup.device.sample_time.0, law.object);
        let (m, b) = (object.mass_kg, object.damping_n_s_per_m);
        let (k, half) = (object.stiffness_n_per_m, 0.5 * t);
        let ahead = self.position + half * self.velocity;
        let next = if m > 0.0 {
            (self.velocity + half / m * (self.net + force - k * ahead))
                / (1.0 + half / m * (b + half * k))
        } else {
            (force - k * ahead) / (b + half * k)
        };
        self.velocity = next;
        self.position = ahead + half * next;
        self.net = force - b * next - k * self.position;
        x - (self.position + half * next)
    }
}
