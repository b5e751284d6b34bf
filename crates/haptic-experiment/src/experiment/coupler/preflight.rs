//! Pre-flight of a coupler: the loop that runs, and the two criteria for every hand and object.
//!
//! ```text
//! stable      the sampled loop of this device, this hand and this object has no pole on or outside the unit circle: certified
//! Llewellyn   2b·Re(1/Z_c) ≥ cos(θ/2)(1 − cos(θ/2)): every passive hand and object, of a device under Tustin's rule
//! passive     2b·Re(1/Z_c) ≥ 1 − cos θ (no delay): every passive hand and object, of the sampled device
//! ```
//! - *Llewellyn is not enough for a real device.* Under Tustin's rule the force acts half a sample earlier than a held one does. The
//!   sampled port asks for at least four times his damping, and a coupler that he passes can be unstable with a light device: so the
//!   loop that runs is looked at beside him. A run needs both, `stable` and Llewellyn; `passive` is told.
//! - *Only* `passive` *promises anything for another hand.*

use crate::document::failure::Failure;
use crate::judge::preflight::{refused, softer};
use crate::run::preflight::{CouplerVerdict, PreflightSubject, PreflightVerdict};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::Dynamics;
use haptic_analysis::{
    AnalysisError, CoupledLoop, CoupledObject, Coupler, CouplerOperator, LeastDamping, LoopOperator,
};

/// A coupler and an object that are to be looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CouplerPreflight {
    /// `k_c`, N·s/m.
    pub stiffness_n_s_per_m: f64,
    /// `b_c`, N·s^(1−μ)/m.
    pub dissipation_n_s_1_minus_mu_per_m: f64,
    /// μ, 0 to 1.
    pub order: Order,
    /// The operator, of order 1 − μ.
    pub scheme: Scheme,
    /// T, s.
    pub sample_time_s: f64,
    /// Samples of the run.
    pub samples: u64,
    /// The object.
    pub object: CoupledObject,
}

impl PreflightSubject for CouplerPreflight {
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        self.judge(dynamics, line).map_err(|error| refused(&error))
    }
}

impl CouplerPreflight {
    fn judge(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, AnalysisError> {
        let t = self.sample_time_s;
        let dynamics = Dynamics {
            delay_s: dynamics.delay_s + line as f64 * t,
            ..dynamics
        };
        let path = dynamics.path(t)?;
        let horizon = crate::run::schedule::horizon(self.samples);
        let order = Order::new(1.0 - self.order.get())?;
        let operator = LoopOperator::new(self.scheme, order, Seconds(t), horizon)?;
        let exact = Coupler::exact(
            self.order,
            t,
            self.stiffness_n_s_per_m,
            self.dissipation_n_s_1_minus_mu_per_m,
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
        let enough = |least: LeastDamping| match least {
            LeastDamping::Enough {
                damping_n_s_per_m, ..
            } => Some(damping_n_s_per_m),
            LeastDamping::NoneIsEnough { .. } => None,
        };
        let damping = dynamics.damping_n_s_per_m;
        let llewellyn = enough(coupler.least_damping()?);
        let sampled = enough(coupler.sampled_damping(path)?);
        let per_delta = t / dynamics.mass_kg;
        let (alpha, beta) = coupled.nondimensional();
        Ok(PreflightVerdict {
            stable,
            margin,
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
