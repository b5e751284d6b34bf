//! The loop of body, robot, hand and world: its verdict, and what the hand feels of it.

use super::robot::Robot;
use super::terms::{AdmittanceBody, AdmittanceWorld, Family, Node, TERMS};
use crate::affine::Ways;
use crate::curve::NEAR_REST;
use crate::stability::BOUNDARY;
use crate::transparency::turned;
use crate::{AnalysisError, LoopOperator};
use certified_count::{Curve, NodeValue, StabilityVerdict};
use fracdiff::FrequencyResponse;
use fracdiff::parameter::{not_negative, range};
use num_complex::Complex;

/// A hand on the handle, in whose stiffness that of what the handle touches is included: m·s + b + k/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandImpedance {
    /// Mass, kg, at least 0.
    pub mass_kg: f64,
    /// Damping, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
    /// Stiffness, N/m, at least 0.
    pub stiffness_n_per_m: f64,
}

/// A coefficient in which the characteristic function is affine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AdmittanceNumber {
    /// b of the body, N·s/m.
    Damping,
    /// m of the body, N·s^(1+α)/m.
    Inertance,
    /// Mass of the hand, kg; that of the tool is added to it.
    HandMass,
    /// Damping of the hand, N·s/m.
    HandDamping,
    /// Stiffness of the hand and of what the handle touches, N/m.
    HandStiffness,
    /// K of the world, N/m.
    WorldStiffness,
    /// B of the world, N·s^μ/m.
    WorldDissipation,
}

impl AdmittanceNumber {
    pub(super) const fn index(self) -> usize {
        match self {
            Self::Damping => 0,
            Self::Inertance => 1,
            Self::HandMass => 2,
            Self::HandDamping => 3,
            Self::HandStiffness => 4,
            Self::WorldStiffness => 5,
            Self::WorldDissipation => 6,
        }
    }
}

/// A body on a robot, in one hand and against one world.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{AdmittanceLoop, AdmittanceNumber, ForceFilter, HandImpedance, LoopOperator, Robot, VelocityLoop, AdmittanceBody};
///
/// let t = Seconds(2e-3);
/// let robot = Robot::new(
///     VelocityLoop::second_order(10.0, 0.8)?, 4e-3, ForceFilter { cutoff_hz: 30.0, lags: 2 }, 0.0, t.0)?;
/// let operator = LoopOperator::new(Scheme::Exact, Order::new(0.8)?, t, 1e4)?;
/// let body = AdmittanceBody { inertance_n_s_alpha_per_m: 1.16, damping_n_s_per_m: 1.0, operator: &operator };
/// let hand = HandImpedance { mass_kg: 1.5, damping_n_s_per_m: 20.0, stiffness_n_per_m: 300.0 };
/// let free = AdmittanceLoop::new(&robot, body, hand, None)?;
/// assert!(free.verdict().stable);
/// let stable = free.stable_values(AdmittanceNumber::HandStiffness, [0.0, 1e4]);
/// assert!((stable[0][1] - 2176.953).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct AdmittanceLoop<'a> {
    pub(super) family: Family<'a>,
    pub(super) coefficients: [f64; TERMS],
}

impl<'a> AdmittanceLoop<'a> {
    /// Checks all numbers.
    ///
    /// # Errors
    /// One that is negative or not finite; a delay of the world above 10 000 samples.
    pub fn new(
        robot: &'a Robot,
        body: AdmittanceBody<'a>,
        hand: HandImpedance,
        world: Option<AdmittanceWorld<'a>>,
    ) -> Result<Self, AnalysisError> {
        let unit = "N·s^(1+α)/m";
        not_negative("virtual inertance", body.inertance_n_s_alpha_per_m, unit)?;
        not_negative("virtual damping", body.damping_n_s_per_m, "N·s/m")?;
        not_negative("mass of the hand", hand.mass_kg, "kg")?;
        not_negative("damping of the hand", hand.damping_n_s_per_m, "N·s/m")?;
        not_negative("stiffness of the hand", hand.stiffness_n_per_m, "N/m")?;
        if let Some(world) = world {
            not_negative("stiffness of the world", world.stiffness_n_per_m, "N/m")?;
            let unit = "N·s^μ/m";
            not_negative(
                "dissipation of the world",
                world.dissipation_n_s_mu_per_m,
                unit,
            )?;
            let late = world.delay_samples;
            let allowed = "from 0 to 10000 samples";
            range(
                "delay of the world",
                late as f64,
                late <= 10_000,
                allowed,
                "",
            )?;
        }
        let family = Family { robot, body, world };
        let [stiffness, dissipation] = world.map_or([0.0; 2], |world| {
            [world.stiffness_n_per_m, world.dissipation_n_s_mu_per_m]
        });
        let units = family.units();
        let numbers = [
            body.damping_n_s_per_m,
            body.inertance_n_s_alpha_per_m,
            hand.mass_kg + robot.tool_mass_kg(),
            hand.damping_n_s_per_m,
            hand.stiffness_n_per_m,
            stiffness,
            dissipation,
        ];
        let mut coefficients = numbers;
        for (coefficient, unit) in coefficients.iter_mut().zip(units) {
            *coefficient *= unit;
        }
        Ok(Self {
            family,
            coefficients,
        })
    }

    /// L(e^(−jθ)), N·s/m: the sampled force of the hand over the command, 0 < θ ≤ π.
    #[must_use]
    pub fn hand_response(&self, theta: f64) -> Complex<f64> {
        let node = self.family.node(theta);
        let [of_mass, of_damping, of_stiffness] = node.forces.map(|force| force.value);
        let [.., mass, damping, stiffness, _, _] = self.coefficients;
        (of_mass * mass + of_damping * damping + of_stiffness * stiffness / node.place.v)
            / node.robot.value
    }

    /// (1 − w)(M + L)/T + w^(1+e)·E at w = e^(−jθ), 0 < θ ≤ π, N/m: what must have no zero in |w| ≤ 1.
    #[must_use]
    pub fn characteristic(&self, theta: f64) -> Complex<f64> {
        let node = self.family.node(theta);
        let value = node.terms.value(&self.coefficients);
        let below = node.robot.value * node.body.denominator.value * node.world.denominator.value;
        value / below / self.family.robot.sample_time_s()
    }

    /// M and the world, as the law renders them: what the hand would feel of a perfect robot, N·s/m, 0 < ω ≤ π/T.
    /// ```text
    /// M(w) + w^(1+e)·T·E(w)/(1 − w)
    /// ```
    ///
    /// # Errors
    /// ω outside its range.
    pub fn virtual_impedance(&self, omega: f64) -> Result<Complex<f64>, AnalysisError> {
        let t = self.family.robot.sample_time_s();
        let place = certified_count::Place::new(turned(omega, t)?.min(core::f64::consts::PI));
        let [damping, inertance, .., stiffness, dissipation] = self.coefficients;
        let body = self.family.body.operator.response(place.theta) * inertance + damping;
        let Some(world) = self.family.world else {
            return Ok(body);
        };
        let law = world.operator.response(place.theta) * dissipation + stiffness;
        let late = crate::curve::w_to(&place, 1 + world.delay_samples);
        Ok(body + late * law * t / place.v)
    }

    /// Z, N·s/m: what the hand feels of body and world through robot and sensor, at 0 < ω ≤ π/T. Force over velocity; images of the hand's motion at other
    /// frequencies are left out.
    /// ```text
    /// Z = (M + w^(1+e)·T·E/(1 − w))/(G·H·e^(−sτ)·hold) + m_t·s
    /// ```
    ///
    /// # Errors
    /// ω outside its range.
    pub fn displayed_impedance(&self, omega: f64) -> Result<Complex<f64>, AnalysisError> {
        let tool = Complex::new(0.0, omega * self.family.robot.tool_mass_kg());
        Ok(self.virtual_impedance(omega)? / self.family.robot.way(omega) + tool)
    }

    /// Effort of a hand, N·s/m: the root mean square of |Z| from 0.1 to 4 Hz, or to half the sample rate.
    ///
    /// # Errors
    /// A sample rate of less than 0.4 Hz.
    pub fn effort(&self, weight: EffortWeight) -> Result<f64, AnalysisError> {
        const PANELS: u32 = 400;
        let half_rate = 0.5 / self.family.robot.sample_time_s();
        let [low, high] = [0.1, half_rate.min(4.0)];
        range(
            "half the sample rate",
            half_rate,
            half_rate >= 0.2,
            "0.2 {} or more",
            "Hz",
        )?;
        let (mut squares, mut weights) = (0.0, 0.0);
        for i in 0..=2 * PANELS {
            let frequency = low + (high - low) * f64::from(i) / f64::from(2 * PANELS);
            // Simpson's rule.
            let share = match i {
                0 => 1.0,
                i if i == 2 * PANELS => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let share = share * weight.at(frequency);
            let felt = self.displayed_impedance(2.0 * core::f64::consts::PI * frequency)?;
            squares += share * felt.norm_sqr();
            weights += share;
        }
        Ok(libm::sqrt(squares / weights))
    }

    /// The command that a newton of the sensor's noise makes at half the sample rate, m/s per N: 1/|M(e^(−jπ))|.
    #[must_use]
    pub fn command_noise(&self) -> f64 {
        let [damping, inertance, ..] = self.coefficients;
        let body = self.family.body.operator.response(core::f64::consts::PI) * inertance;
        1.0 / (body + damping).norm()
    }

    /// The certified verdict, by encirclement: as that of a wall, with the distance relative to the sizes of F's terms.
    #[must_use]
    pub fn verdict(&self) -> StabilityVerdict {
        self.family.verdict(&self.coefficients)
    }
}

/// The weight of a frequency in the effort of a hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffortWeight {
    /// 1/(1 + (f/1 Hz)²)²: a hand moves slowly most of the time.
    #[default]
    Hand,
    /// All alike.
    Flat,
}

impl EffortWeight {
    fn at(self, frequency_hz: f64) -> f64 {
        let share = 1.0 + frequency_hz * frequency_hz;
        match self {
            Self::Hand => 1.0 / (share * share),
            Self::Flat => 1.0,
        }
    }
}

impl Family<'_> {
    /// Coefficient of a term over the number that people give: T^(−α), T^(−μ).
    pub(super) fn units(&self) -> [f64; TERMS] {
        let t = self.robot.sample_time_s();
        let unit = |operator: &LoopOperator| libm::pow(t, -operator.order().get());
        let world = self.world.map_or(1.0, |world| unit(world.operator));
        [1.0, unit(self.body.operator), 1.0, 1.0, 1.0, 1.0, world]
    }

    pub(super) fn verdict(&self, coefficients: &[f64; TERMS]) -> StabilityVerdict {
        let (springs, damping) = self.at_rest(coefficients);
        // Nearer to rest F is known by its limit: v·(b + b_h) and the springs are a right angle apart.
        let begin = self.node(NEAR_REST);
        let value = begin.terms.value(coefficients);
        // A body that nothing holds or damps: m·v² has two zeros at rest.
        let drifts_freely = springs == 0.0 && damping == 0.0;
        if drifts_freely && self.body.operator.order().get() >= 1.0 {
            return StabilityVerdict {
                stable: false,
                unstable_poles: None,
                distance: 0.0,
                theta: 0.0,
            };
        }
        let member = Member {
            family: self,
            coefficients,
        };
        let mut nodes = vec![begin];
        let slow = (0..12).map(|k| libm::ldexp(core::f64::consts::PI / 64.0, k - 12));
        let fast = (1..=64).map(|k| core::f64::consts::PI * f64::from(k) / 64.0);
        nodes.extend(slow.chain(fast).map(|theta| self.node(theta)));
        let ways: Vec<_> = nodes
            .windows(2)
            .map(|pair| self.ways(&pair[0], &pair[1]))
            .collect();
        member.count(&nodes[0], value.arg(), ways.iter().zip(&nodes[1..]))
    }
}

/// F with its coefficients.
struct Member<'a, 'b> {
    family: &'a Family<'b>,
    coefficients: &'a [f64; TERMS],
}

impl Curve for Member<'_, '_> {
    type Node = Node;
    type Span = Ways<TERMS>;

    fn node(&self, theta: f64) -> Node {
        self.family.node(theta)
    }

    fn span(&self, a: &Node, b: &Node) -> Ways<TERMS> {
        self.family.ways(a, b)
    }

    fn sample(&self, node: &Node) -> NodeValue {
        let value = node.terms.value(self.coefficients);
        let size = node.terms.size(self.coefficients);
        NodeValue {
            theta: node.place.theta,
            value,
            size: value.norm() / size,
            noise: node.terms.noise(self.coefficients) + BOUNDARY * size,
        }
    }

    fn path(&self, a: &Node, b: &Node, ways: &Ways<TERMS>) -> f64 {
        let width = b.place.theta - a.place.theta;
        ways.path([&a.terms, &b.terms], self.coefficients, width)
    }
}
