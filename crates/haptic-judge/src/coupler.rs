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

use crate::{
    preflight::softer,
    pushed_trial::{PushedTrial, six_digits},
    settling::Settling,
    setup::{Beside, TrialParts, TrialSetup, setup},
    tissue_table::scheme,
};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, CoupledLoop, CoupledObject, Coupler, CouplerOperator, Dynamics, LoopOperator,
};
use haptic_document::{
    Failure, FileError, Table, bad_input, parameters, parameters as p,
    parameters::{
        COUPLER_DAMPING, COUPLER_SPRING, Parameter, joined,
        range::{COUPLER_ORDERS, DAMPINGS, OBJECT_MASSES, STIFFNESSES},
    },
};
use haptic_link::LoopMode;
use haptic_loop::{
    Controller, Environment, OwnPush, VirtualCoupler, VirtualObject, deflection_order,
    units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre},
};
use haptic_trial::{
    advice::analysed,
    device_table::encoder_step,
    keys::trial::{TRIAL, TRIAL_LOOP},
    preflight::{CouplerVerdict, PreflightVerdict},
    samples::horizon,
};
use nalgebra::Vector1;
use serde_json::{Value, json};

parameters! {
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
pub const COUPLER_REQUIRED: &[Parameter] = &[
    p::MASS,
    p::DAMPING,
    p::SAMPLE_TIME,
    COUPLER_ORDER,
    COUPLER_DAMPING,
    COUPLER_SPRING,
];

/// Keys of `[coupler]` with defaults.
pub const COUPLER: &[Parameter] = &joined::<22>(&[
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

/// A coupler with its object on a device that is pushed into it.
#[derive(Clone, Debug)]
pub struct CouplerTrial {
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
    /// The object behind the coupler.
    pub object: CoupledObject,
}

/// `[coupler]`: device, coupler, object and trial, with the table of a second device that pushes.
///
/// # Errors
/// A missing or wrong key, or values of which no loop can be made: with file and line.
pub fn coupler(
    table: &Table<'_>,
    beside: Beside<'_>,
    at_port: [Option<LoopMode>; 2],
) -> Result<CouplerTrial, FileError> {
    let setup = setup(table, &COUPLER_MUST_BE_STABLE, beside, at_port)?;
    let order = table.order(&COUPLER_ORDER)?;
    let run = deflection_order(order).map_err(|error| table.fail_at("order", error))?;
    let (t, duration_s) = (setup.device.sample_time.0, setup.plan.duration_s);
    let coupler = CouplerTrial {
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
    (coupler.parts()).map_err(|error| table.fail(error))?;
    Ok(coupler)
}

/// The coupler of an experiment.
type Law = VirtualCoupler<f64, Operator<f64>>;

impl CouplerTrial {
    /// Refuses a loop on a device, which cannot carry it.
    fn check_loop(&self) -> Result<(), Failure> {
        match self.setup.at_port {
            Some(LoopMode::Device) => Err(bad_input!(
                "a loop on the device cannot run a coupler, as its firmware renders only walls: give {loop_host}",
                loop_host = p::LOOP.set_to("host")
            )),
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
    ///
    /// # Errors
    /// As [`parts`](PushedTrial::parts).
    pub fn replayed(&self, samples: u64) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
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

impl PushedTrial for CouplerTrial {
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

    fn judge(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<PreflightVerdict, Failure> {
        let judged = self.looked_at(samples, dynamics, line);
        judged.map_err(analysed)
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

    fn parts(&self) -> Result<TrialParts<Self::Law>, Failure> {
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
        Ok(TrialParts {
            controller: Controller::new(OwnPush::new(law, plan.own_push_n()), setup.chain()?),
            device,
            samples,
            judge,
            rest_m: (spring > 0.0).then(|| self.setup.plan.push_n / spring),
        })
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

impl CouplerTrial {
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
            robot: None,
        })
    }
}
