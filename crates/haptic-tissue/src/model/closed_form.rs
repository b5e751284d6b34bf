//! Relaxation modulus, creep compliance and complex modulus of every model.

use super::exponentials::Response;
use super::form::{Form, MaxwellBranch, Model};
use super::spectrum::spectrum;
use super::spring_pot::SpringPot;
use num_complex::Complex64;

impl Model {
    /// G(t), Pa: stress over a step of strain, a time after it. 0 for t < 0, [`Model::instantaneous_modulus`] at 0.
    ///
    /// ```text
    /// spring-pot                    V·t^(−α)/Γ(1−α)
    /// fractional Kelvin–Voigt       V·t^(−α)/Γ(1−α) + G·t^(−β)/Γ(1−β)
    /// fractional Maxwell            G·t^(−β)·E_{α−β,1−β}(−(G/V)·t^(α−β))
    /// fractional Zener              E + that of the fractional Maxwell model
    /// fractional Poynting–Thomson   no closed form; the integral over its relaxation spectrum
    /// Prony series                  E + Σ E_i·e^(−t/τ_i)
    /// ```
    /// `E_{a,b}` is the Mittag-Leffler function, summed as exponentials. Relative error below 1e-10 for 10⁻⁶ ≤ t/τ ≤ 10⁶,
    /// τ = (V/G)^(1/(α−β)). A dashpot beside the rest has an impulse at t = 0 only.
    /// Cost: 20 µs; many times at once, [`Model::relaxation_moduli`], 0.2 µs each.
    ///
    /// ```
    /// use haptic_tissue::{Form, Model, SpringPot};
    ///
    /// let muscle = Model::new(Form::FractionalMaxwell {
    ///     first: SpringPot::new(876e3, 0.675)?,
    ///     second: SpringPot::new(22.1e3, 0.110)?,
    /// })?;
    /// let (fast, slow) = (muscle.relaxation_modulus(0.014), muscle.relaxation_modulus(981.0));
    /// assert!((fast / 33e3 - 1.0).abs() < 0.05 && slow < 4e3);
    /// # Ok::<(), haptic_tissue::ModelError>(())
    /// ```
    #[must_use]
    pub fn relaxation_modulus(&self, time_s: f64) -> f64 {
        self.relaxation_moduli(&[time_s])[0]
    }

    /// [`Model::relaxation_modulus`] at many times, in any order.
    #[must_use]
    pub fn relaxation_moduli(&self, time_s: &[f64]) -> Vec<f64> {
        let form = self.form();
        let at_zero = self.instantaneous_modulus();
        match form {
            Form::SpringPot(one) => each(time_s, at_zero, |t| one.relaxation(t)),
            Form::FractionalKelvinVoigt { first, second } => each(time_s, at_zero, |t| {
                first.relaxation(t) + second.relaxation(t)
            }),
            _ => by_modes(form, Response::Relaxation, time_s, at_zero),
        }
    }

    /// J(t), 1/Pa: strain over a step of stress, a time after it. 0 for t < 0, 1 over [`Model::instantaneous_modulus`] at 0.
    ///
    /// ```text
    /// spring-pot                    t^α/(V·Γ(1+α))
    /// fractional Kelvin–Voigt       (t^α/V)·E_{α−β,1+α}(−(G/V)·t^(α−β))
    /// fractional Maxwell            t^α/(V·Γ(1+α)) + t^β/(G·Γ(1+β))
    /// fractional Zener              no closed form; the integral over its retardation spectrum
    /// fractional Poynting–Thomson   1/E + that of the fractional Kelvin–Voigt model
    /// Prony series                  exponentials at the zeros of its modulus
    /// ```
    /// Error and cost as for [`Model::relaxation_modulus`].
    #[must_use]
    pub fn creep_compliance(&self, time_s: f64) -> f64 {
        self.creep_compliances(&[time_s])[0]
    }

    /// [`Model::creep_compliance`] at many times, in any order.
    #[must_use]
    pub fn creep_compliances(&self, time_s: &[f64]) -> Vec<f64> {
        let form = self.form();
        let at_zero = self.instantaneous_compliance();
        match form {
            Form::SpringPot(one) => each(time_s, at_zero, |t| one.creep(t)),
            Form::FractionalMaxwell { first, second } => {
                each(time_s, at_zero, |t| first.creep(t) + second.creep(t))
            }
            _ => by_modes(form, Response::Creep, time_s, at_zero),
        }
    }

    /// M(iω), Pa: storage modulus + i·loss modulus, ω ≥ 0 in rad/s.
    #[must_use]
    pub fn complex_modulus(&self, omega_rad_s: f64) -> Complex64 {
        let ln = libm::log(omega_rad_s);
        let branch = |one: &MaxwellBranch| {
            let x = omega_rad_s * one.relaxation_time_s;
            let share = if x > 1.0 {
                let y = 1.0 / x;
                Complex64::new(1.0, y) / (1.0 + y * y)
            } else {
                Complex64::new(x * x, x) / (1.0 + x * x)
            };
            share * one.elastic_modulus_pa
        };
        self.form().joined(|one| at_frequency(one, ln), branch)
    }

    /// G(0), Pa: infinite where a sudden strain has no finite stress.
    #[must_use]
    pub fn instantaneous_modulus(&self) -> f64 {
        let stiff = |one: &SpringPot| {
            if one.is_spring() {
                one.viscosity_pa_s_alpha()
            } else {
                f64::INFINITY
            }
        };
        match self.form() {
            Form::SpringPot(one) => stiff(one),
            Form::FractionalKelvinVoigt { .. } => f64::INFINITY,
            Form::FractionalMaxwell { second, .. } => stiff(second),
            Form::FractionalZener {
                second,
                elastic_modulus_pa,
                ..
            } => stiff(second) + elastic_modulus_pa,
            Form::FractionalPoyntingThomson {
                elastic_modulus_pa, ..
            } => *elastic_modulus_pa,
            Form::Prony {
                elastic_modulus_pa,
                branches,
            } => {
                (branches.iter()).fold(*elastic_modulus_pa, |sum, one| sum + one.elastic_modulus_pa)
            }
        }
    }

    /// J(0), 1/Pa.
    #[must_use]
    pub(crate) fn instantaneous_compliance(&self) -> f64 {
        1.0 / self.instantaneous_modulus()
    }

    /// G(∞), Pa: 0 for a fluid and for a spring-pot.
    #[must_use]
    pub fn equilibrium_modulus(&self) -> f64 {
        self.form().equilibrium_pa()
    }
}

/// V·(iω)^α; 0 Hz of a spring is a spring.
fn at_frequency(one: &SpringPot, ln_omega: f64) -> Complex64 {
    if one.is_spring() {
        return Complex64::new(one.viscosity_pa_s_alpha(), 0.0);
    }
    one.modulus_at(ln_omega, 0.5)
}

/// 0 before the step, `at_zero` at it, `value` after it.
fn each(time_s: &[f64], at_zero: f64, mut value: impl FnMut(f64) -> f64) -> Vec<f64> {
    let one = |&t: &f64| {
        if t > 0.0 {
            value(t)
        } else if t == 0.0 {
            at_zero
        } else if t < 0.0 {
            0.0
        } else {
            f64::NAN
        }
    };
    time_s.iter().map(one).collect()
}

fn by_modes(form: &Form, response: Response, time_s: &[f64], at_zero: f64) -> Vec<f64> {
    let real = |t: &&f64| **t > 0.0 && t.is_finite();
    let (shortest, longest) = (time_s.iter().filter(real))
        .fold((f64::INFINITY, 0.0), |(low, high), &t| {
            (f64::min(low, t), f64::max(high, t))
        });
    if shortest > longest {
        return each(time_s, at_zero, |_| f64::NAN);
    }
    let spectrum = spectrum(form, response, shortest, longest);
    each(time_s, at_zero, |t| spectrum.at(t))
}
