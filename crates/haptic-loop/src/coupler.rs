//! A fractional virtual coupler between the device and a simulated object.

use crate::Environment;
use crate::error::{Checks, LoopParameterError};
use crate::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre, Seconds};
use core::array;
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{Differintegrator, Order, Real};
use nalgebra::SVector;

/// A simulated object: a mass on a damper and a spring to the ground.
///
/// ```text
/// F = m_o·v' + b_o·v + k_o·p,   p' = v        F force on it N, v velocity m/s, p position m
/// ```
/// - *Ranges*: all at least 0, one of them above 0. A mass of 0 is the spring and the damper alone.
/// - *In the loop* under Tustin's rule, s → (2/T)(1 − w)/(1 + w): without damping it neither gains nor loses energy in any sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualObject {
    mass: f64,
    damping: f64,
    stiffness: f64,
}

impl VirtualObject {
    /// `m_o`, `b_o` and `k_o`.
    ///
    /// # Errors
    /// One below 0 or not finite, or all of them 0.
    pub fn new(
        mass: Kilograms,
        damping: NewtonSecondsPerMetre,
        stiffness: NewtonsPerMetre,
    ) -> Result<Self, LoopParameterError> {
        let object = Self {
            mass: not_negative("object mass", mass.0, "kg")?,
            damping: not_negative("object damping", damping.0, "N·s/m")?,
            stiffness: not_negative("object stiffness", stiffness.0, "N/m")?,
        };
        if object.mass + object.damping <= 0.0 {
            positive(
                "object stiffness of an object without mass and damping",
                object.stiffness,
                "N/m",
            )?;
        }
        Ok(object)
    }

    /// `m_o`.
    #[must_use]
    pub const fn mass(&self) -> Kilograms {
        Kilograms(self.mass)
    }

    /// `b_o`.
    #[must_use]
    pub const fn damping(&self) -> NewtonSecondsPerMetre {
        NewtonSecondsPerMetre(self.damping)
    }

    /// `k_o`.
    #[must_use]
    pub const fn stiffness(&self) -> NewtonsPerMetre {
        NewtonsPerMetre(self.stiffness)
    }
}

/// 1 − μ, the order of the operator that a coupler of order μ runs on its deflection.
///
/// # Errors
/// μ below 0 or above 1. Above 1 the coupler itself gives energy at low frequency.
pub fn deflection_order(order: Order) -> Result<Order, LoopParameterError> {
    let (mu, allowed) = (order.get(), "in [0, 1]: above 1 it gives energy by itself");
    let within = (0.0..=1.0).contains(&mu);
    range("order of a coupler", mu, within, allowed, "")?;
    Ok(Order::new(1.0 - mu)?)
}

/// A fractional virtual coupler and the object behind it, the same on each axis.
///
/// ```text
/// Z_c = k_c + b_c·(T/(1 − w))^μ        velocity in, force out: k_c N·s/m ≥ 0, b_c N·s^(1−μ)/m ≥ 0, 0 ≤ μ ≤ 1
/// F = Z_c·(v_h − v_e) = Z_o·v_e        v_h = (1 − w)x/T of the device, v_e of the object;  f = −F on the device
/// ```
/// At μ = 1 `k_c` is the damper and `b_c` the spring. Both sides are integrated once, exactly: with q = `T·v_e`/(1 − w) and the
/// deflection y = x − q
/// ```text
/// F[n] = k_c·(y[n] − y[n−1])/T + b_c·D^(1−μ) y[n]                  the operator has the order 1 − μ
/// v[n] = Y·(F[n] + S),   S = r − k_o·q[n−1],   Y = 1/(2m_o/T + b_o + k_o·T/2)        the object under Tustin
/// q[n] = q[n−1] + T·v[n],   r ← (4m_o/T)·v[n] − r,   p[n] = q[n] − (T/2)·v[n]        p the place of the object
/// ```
/// Both have a direct part, so the tick solves one equation. With y° = x − q[n−1] − T·Y·S, the deflection if F were 0, and g
/// the direct gain of the operator
/// ```text
/// F[n] = (k_c·(y° − y[n−1])/T + b_c·D^(1−μ) y°)/(1 + T·Y·(k_c/T + b_c·g))
/// ```
/// where the denominator is a constant.
/// - *Energy*: an operator with Re D^(1−μ)/(1 − w) ≥ 0, as all full memories, makes a coupler that gives none away: with the
///   object, ΣF·Δx ≥ 0 for every motion from rest, but for rounding. The loop with a *sampled* device needs damping of the
///   device all the same.
/// - *Start-up*: coupler and object at rest, both at 0.
/// - *State*: four numbers an axis beside the operator's.
/// - *Cost*: `force` six multiply-adds an axis beside the operator's output; `advance` twice that and the operator's.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 5.15, after R. J. Adams, B. Hannaford, *Stable haptic
/// interaction with virtual environments*, IEEE Trans. Robotics and Automation 15(3), 1999.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualCoupler<F, O> {
    operator: O,
    /// `k_c/T`, N/m.
    step: F,
    /// `b_c`.
    dissipation: F,
    /// 1/(1 + T·Y·(`k_c/T + b_c·g`)).
    share: F,
    mobility: F,
    /// T·Y, m/N: the way of the object in a tick for each newton.
    give: F,
    /// `k_o`, N/m.
    stiffness: F,
    /// `4m_o/T`, N·s/m.
    momentum: F,
    /// T, s.
    sample_time: F,
    /// T/2, s.
    half: F,
}

/// State of a [`VirtualCoupler`] on one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledHistory<F, H> {
    operator: H,
    /// y[n−1], m.
    deflection: F,
    /// q[n−1], m.
    place: F,
    /// v[n−1], m/s.
    velocity: F,
    /// r, N, the memory of Tustin's rule.
    carried: F,
}

/// One tick of one axis.
struct Solved<F> {
    /// F, N, the force on the object; the device feels −F.
    force: F,
    /// y = x − q at the end of the tick, m.
    deflection: F,
    /// v of the object, m/s.
    velocity: F,
}

impl<F: Real, O: Differintegrator<F>> VirtualCoupler<F, O> {
    /// `k_c` in N·s/m and `b_c` in N·s^(1−μ)/m, in front of the object. The operator has the order
    /// 1 − μ, see [`deflection_order`], and this sample time.
    ///
    /// # Errors
    /// `k_c` or `b_c` below 0, or both 0; a sample time not above 0; a constant that leaves the loop's number type.
    pub fn new(
        stiffness: f64,
        dissipation: f64,
        operator: O,
        object: VirtualObject,
        sample_time: Seconds,
    ) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        checks.not_negative("coupler damping", stiffness, "N·s/m");
        checks.not_negative("coupler spring", dissipation, "N·s^(1−μ)/m");
        if stiffness <= 0.0 {
            checks.positive(
                "coupler spring of a coupler without damping",
                dissipation,
                "N·s^(1−μ)/m",
            );
        }
        let t = checks.positive("sample time", sample_time.0, "s");
        let VirtualObject {
            mass,
            damping,
            stiffness: spring,
        } = object;
        // Y = 1/(2m_o/T + b_o + k_o·T/2)
        let mobility = 1.0 / (2.0 * mass / t + damping + 0.5 * spring * t);
        let give = t * mobility;
        let step = stiffness / t;
        let direct = step + dissipation * operator.direct_gain().to_f64();
        let share = 1.0 / (1.0 + give * direct);
        let coupler = Self {
            step: checks.rounded("coupler damping over the sample time", step, "N/m"),
            dissipation: checks.rounded("coupler spring", dissipation, "N·s^(1−μ)/m"),
            share: checks.rounded("share of the coupler's force", share, ""),
            mobility: checks.rounded("mobility of the object", mobility, "m/(N·s)"),
            give: checks.rounded("give of the object in a sample", give, "m/N"),
            stiffness: checks.rounded("object stiffness", spring, "N/m"),
            momentum: checks.rounded("object mass over the sample time", 4.0 * mass / t, "N·s/m"),
            sample_time: checks.rounded("sample time", t, "s"),
            half: F::from_f64(0.5 * t),
            operator,
        };
        checks.done().map(|()| coupler)
    }

    /// Force that a sudden step of the position causes, N per m: the direct gain of coupler and
    /// object.
    pub fn step_stiffness_n_per_m(&self) -> f64 {
        let direct =
            self.step.to_f64() + self.dissipation.to_f64() * self.operator.direct_gain().to_f64();
        direct * self.share.to_f64()
    }

    /// D^(1−μ).
    pub const fn operator(&self) -> &O {
        &self.operator
    }

    /// Position of the object on each axis after the last [`advance`](Environment::advance), m.
    pub fn object_position_m<const D: usize>(
        &self,
        history: &[CoupledHistory<F, O::History>; D],
    ) -> SVector<F, D> {
        // p = q − (T/2)·v
        SVector::from(array::from_fn(|axis| {
            history[axis].place - self.half * history[axis].velocity
        }))
    }

    #[inline]
    fn solve(&self, history: &CoupledHistory<F, O::History>, position: F) -> Solved<F> {
        // S = r − k_o·q[n−1],   y° = x − q[n−1] − T·Y·S
        let free = history.carried - self.stiffness * history.place;
        let slack = (position - history.place) - self.give * free;
        let step = self.step * (slack - history.deflection);
        // F = (k_c·(y° − y[n−1])/T + b_c·D^(1−μ) y°)/(1 + T·Y·(k_c/T + b_c·g))
        let force =
            (step + self.dissipation * self.operator.output(&history.operator, slack)) * self.share;
        Solved {
            force,
            deflection: slack - self.give * force,
            velocity: self.mobility * (force + free),
        }
    }
}

impl<F: Real, O: Differintegrator<F>, const D: usize> Environment<F, D> for VirtualCoupler<F, O> {
    type History = [CoupledHistory<F, O::History>; D];

    fn at_rest(&self) -> Self::History {
        array::from_fn(|_| CoupledHistory {
            operator: self.operator.at_rest(),
            deflection: F::ZERO,
            place: F::ZERO,
            velocity: F::ZERO,
            carried: F::ZERO,
        })
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        // f = −F
        SVector::from(array::from_fn(|axis| {
            -self.solve(&history[axis], position_m[axis]).force
        }))
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, D>) {
        for (history, &x) in history.iter_mut().zip(position_m.iter()) {
            let Solved {
                deflection,
                velocity,
                ..
            } = self.solve(history, x);
            self.operator.advance(&mut history.operator, deflection);
            history.deflection = deflection;
            // q ← q + T·v,   r ← (4m_o/T)·v − r
            history.place += self.sample_time * velocity;
            history.carried = self.momentum * velocity - history.carried;
            history.velocity = velocity;
        }
    }
}
