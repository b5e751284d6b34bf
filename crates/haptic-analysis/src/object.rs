//! A simulated object behind a virtual coupler: the loop that a sampled device really closes over both.

use crate::characteristic::{Behind, Characteristic};
use crate::{AnalysisError, AtAngle, Coupler, Dynamics, LoopOperator, SampledLoop};
use certified_count::Place;
use fracdiff::FrequencyResponse;
use fracdiff::parameter::{not_negative, positive, range};
use num_complex::Complex;

/// A simulated object: a mass on a damper and a spring to the ground, under Tustin's rule.
/// ```text
/// Z_o(w) = m_o·(2/T)(1 − w)/(1 + w) + b_o + k_o·(T/2)(1 + w)/(1 − w)        velocity in, force out
/// ```
/// All at least 0, one of them above 0; without mass it is the spring and the damper alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledObject {
    /// `m_o`, kg.
    pub mass_kg: f64,
    /// `b_o`, N·s/m.
    pub damping_n_s_per_m: f64,
    /// `k_o`, N/m.
    pub stiffness_n_per_m: f64,
}

/// P = (1 − w)/Q: the operator of order μ that a coupler inverts when it runs Q, of order 1 − μ, on
/// its deflection.
/// ```text
/// Z_c = k_c + b_c·T^μ·Q(w)/(1 − w)
/// ```
/// For [`Coupler::with_operator`]: Llewellyn's conditions for the coupler that really runs.
#[derive(Clone, Copy, Debug)]
pub struct CouplerOperator<'a>(pub &'a LoopOperator);

impl FrequencyResponse for CouplerOperator<'_> {
    fn response(&self, theta: f64) -> Complex<f64> {
        Place::new(theta).v / self.0.response(theta)
    }
}

/// A device, a fractional virtual coupler and a simulated object, as they are really sampled: device behind a zero-order hold,
/// with its delay and lag and the hand that holds it.
/// ```text
/// H_c = k_c·(1 − w)/T + b_c·T^(μ−1)·Q(w)         coupler, N/m of its deflection, Q of order 1 − μ, 0 ≤ μ ≤ 1
/// H_o = Z_o·(1 − w)/T                            object
/// H = H_c·H_o/(H_c + H_o)                        from the position of the device to the force that pushes it back
/// F = A·e + (A·u + S·e)·T²·H_c/m,  H_o·T²/m = e/u,  A and S of the device as in SampledLoop
/// ```
/// F is, but for a factor without zeros, the determinant of all equations of the tick: its zeros in |w| < 1 are all unstable
/// poles, none cancels unseen. They are counted with a certificate, as for a wall.
///
/// *Nothing that holds it*: where device or object can drift, F has a zero at w = 1. That is not an
/// instability; such a loop is judged without that zero, as by [`SampledLoop::beside_rest`].
///
/// *Llewellyn's criterion is another question.* It asks for every passive hand and object, but of a device under Tustin's rule,
/// whose force acts half a sample earlier than a held one does. [`Coupler::sampled_damping`] asks the same of the sampled
/// device. Neither implies the other's answer for one given hand, which is what is answered here.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{CoupledLoop, CoupledObject, Coupler, Dynamics, LoopOperator};
///
/// let (t, order) = (Seconds(1e-3), Order::new(1.0)?);
/// let spring = LoopOperator::new(Scheme::Exact, Order::new(0.0)?, t, 1e3)?; // order 1 − μ
/// let coupler = Coupler::exact(order, t.0, 2.0, 3000.0)?;
/// let object = CoupledObject { mass_kg: 0.2, damping_n_s_per_m: 0.1, stiffness_n_per_m: 500.0 };
/// let device = Dynamics::ideal(0.065, 3.5);
/// let coupled = CoupledLoop::new(&device, &coupler, &object, &spring)?;
/// assert!(coupled.is_stable());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CoupledLoop<'a> {
    inner: SampledLoop<'a>,
}

impl<'a> CoupledLoop<'a> {
    /// Loop with Q, the operator of order 1 − μ that runs.
    ///
    /// # Errors
    /// A parameter outside its range; an operator of another order than 1 − μ.
    pub fn new(
        device: &Dynamics,
        coupler: &Coupler<'_>,
        object: &CoupledObject,
        difference: &'a LoopOperator,
    ) -> Result<Self, AnalysisError> {
        let (order, t) = (coupler.order().get(), coupler.sample_time_s());
        let wanted = 1.0 - order;
        let order = difference.order().get();
        let fits = (order - wanted).abs() < 1e-12;
        let allowed = "1 less the order of the coupler, which is from 0 to 1";
        range("order of the coupler's operator", order, fits, allowed, "")?;
        let m = positive("mass", device.mass_kg, "kg")?;
        let mass = not_negative("object mass", object.mass_kg, "kg")?;
        let damping = not_negative("object damping", object.damping_n_s_per_m, "N·s/m")?;
        let stiffness = not_negative("object stiffness", object.stiffness_n_per_m, "N/m")?;
        let shares = [mass / m, damping * t / m, stiffness * t * t / m];
        positive("impedance of the object", shares.iter().sum(), "")?;
        // α = k_c·T/m and β = b_c·T^(1+μ)/m, of v and Q.
        let (damper, per_sample) = coupler.gains();
        let (alpha, beta) = (damper * t / m, per_sample * t / m);
        // Springs of hand, coupler and object at rest: of two places and the ground.
        let between = beta * difference.response(0.0).re;
        let hand = device.hand_stiffness_n_per_m * t * t / m;
        let firm = hand * between + hand * shares[2] + between * shares[2];
        let all = hand + between + shares[2];
        let mut inner = SampledLoop::with_plant(device.plant(t)?, alpha, beta, difference)?;
        inner.characteristic = Characteristic {
            behind: Some(Behind::new(shares)),
            ..inner.characteristic
        };
        inner.beside_rest = firm <= 1e-18 * all * all;
        Ok(Self { inner })
    }

    /// Multiplies the coupler, `k_c` and `b_c` alike.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.inner.alpha *= factor;
        self.inner.beta *= factor;
        self
    }

    /// True if nothing holds device or object at rest.
    #[must_use]
    pub const fn drifts(&self) -> bool {
        self.inner.beside_rest
    }

    /// `k_c·T/m` and `b_c·T^(1+μ)/m`.
    #[must_use]
    pub const fn nondimensional(&self) -> (f64, f64) {
        (self.inner.alpha, self.inner.beta)
    }

    /// F(e^(−jθ)), in units of the largest that e can be.
    #[must_use]
    pub fn characteristic(&self, theta: f64) -> Complex<f64> {
        self.inner.characteristic(theta)
    }

    /// The certified verdict that no pole is on or outside the unit circle, by counting how often F
    /// turns around 0. Cost: about three times that of [`SampledLoop::verdict`], because of the
    /// longer terms.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.unstable_poles() == Some(0)
    }

    /// Poles outside the unit circle; `None` if one lies on it, within rounding errors.
    #[must_use]
    pub fn unstable_poles(&self) -> Option<usize> {
        let circle = self.inner.characteristic.circle();
        let gains = [self.inner.alpha, self.inner.beta];
        circle
            .count(gains, 0.0, self.inner.beside_rest)
            .unstable_poles
    }

    /// The least factor above 1 on `k_c` and `b_c` together that takes a stable loop to the edge; `None` if none does.
    ///
    /// # Errors
    /// [`AnalysisError::NotStable`].
    pub fn gain_margin(&self) -> Result<Option<AtAngle>, AnalysisError> {
        if !self.is_stable() {
            return Err(AnalysisError::NotStable { what: "margins" });
        }
        Ok(self.inner.gain_margins().0)
    }
}
