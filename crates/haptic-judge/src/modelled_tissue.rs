//! A tissue of the library with the model that is rendered: its operator, its closed forms, and the force that the full
//! history of a motion asks for.
//!
//! `shape` is γ of a specimen, m: the force of a piece for a depth, N for m. With 1 it is the stress for a strain.

use crate::{reference, reference::ReferenceWeights};
use fracdiff::{
    Channel, Differintegrator as _, FullMemory, Operator, Order, Real, Scheme, SchemeError,
    Seconds, ShortQuotient,
    full_memory::{Design, HORIZON_MIN, Kernel},
    num_complex::Complex,
    scheme::{FULL_MODES, FULL_TAPS},
};
use haptic_analysis::{AnalysisError, LoopOperator};
use haptic_document::{
    Failure, bad_input,
    parameters::{AREA, SCHEME, THICKNESS},
};
use haptic_loop::{
    DepthMap, Loading, LoadingKind, LoopParameterError, Specimen, Tissue,
    units::{Metres, Pascals},
};
use haptic_quantity::digits;
use haptic_tissue::{FullHistory, Material, Model, SampledModel};
use haptic_trial::samples::horizon;
use std::ops::Deref;

/// A tissue of the library and the model of it: what is rendered, and its closed forms.
///
/// ```text
/// σ = E·ε + B·(T^μ·P) D^μ ε        P = 1 of one spring-pot beside a spring; else the memory of all elements at once
/// ```
///
/// ```
/// use haptic_judge::modelled_tissue::ModelledTissue;
/// use haptic_tissue::Library;
///
/// let library = Library::load(None)?;
/// let prostate = ModelledTissue::new(library.find("prostate-healthy")?)?;
/// assert_eq!(prostate.order().get(), 0.2154);
/// // Elements in series are rendered by one operator, of the order of what carries the slow motion.
/// let muscle = ModelledTissue::new(library.find("fish-muscle")?)?;
/// assert_eq!((muscle.order().get(), muscle.spring_and_damper(1.0).0), (0.6751, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ModelledTissue {
    material: Material,
    /// One spring-pot beside a spring, by D^α of any scheme; `None` for any other model, by its one memory.
    pot: Option<Tissue>,
    rest_modulus_pa: f64,
    viscosity_pa_s_mu: f64,
    order: Order,
}

impl ModelledTissue {
    /// The model of a tissue.
    ///
    /// # Errors
    /// Parameters outside the range of the model; tissue files stay within it, except for
    /// an element that carries the slow motion with an order below 1e-6, next to a spring.
    pub fn new(material: Material) -> Result<Self, Failure> {
        let pot = |modulus, viscosity, order| -> Result<Tissue, Failure> {
            let order = Order::new(order).map_err(Failure::input)?;
            Tissue::new(Pascals(modulus), viscosity, order).map_err(Failure::input)
        };
        let pot = match (
            material.elastic_modulus_pa(),
            material.viscosity_pa_s_alpha(),
            material.order(),
        ) {
            (Some(modulus), Some(viscosity), Some(order)) => pot(modulus, viscosity, order)?,
            _ => {
                // E, B and μ are of the model; the sample time of a rendering comes later.
                let sampled = SampledModel::new(&material.model, Seconds(1.0));
                let sampled = sampled.map_err(Failure::input)?;
                if sampled.viscosity_pa_s_mu() > 0.0 {
                    return Ok(Self {
                        material,
                        pot: None,
                        rest_modulus_pa: sampled.elastic_modulus_pa(),
                        viscosity_pa_s_mu: sampled.viscosity_pa_s_mu(),
                        order: sampled.order(),
                    });
                }
                // A spring, as a Prony series without branches is.
                pot(sampled.elastic_modulus_pa(), 0.0, 0.0)?
            }
        };
        Ok(Self {
            material,
            rest_modulus_pa: pot.elastic_modulus().0,
            viscosity_pa_s_mu: pot.viscosity_pa_s_alpha(),
            order: pot.order(),
            pot: Some(pot),
        })
    }

    /// The model, unless it is one spring-pot beside a spring.
    #[must_use]
    pub const fn composed(&self) -> Option<&Model> {
        match self.pot {
            Some(_) => None,
            None => Some(&self.material.model),
        }
    }

    /// μ of the operator: α of a single spring-pot, else the order of the element that carries the
    /// slow motion.
    #[must_use]
    pub const fn order(&self) -> Order {
        self.order
    }

    /// E, Pa: the modulus at rest.
    pub const fn rest_modulus_pa(&self) -> f64 {
        self.rest_modulus_pa
    }

    /// K in N/m and B in N·s^μ/m of a piece with a shape γ, m.
    #[must_use]
    pub fn spring_and_damper(&self, shape: f64) -> (f64, f64) {
        (shape * self.rest_modulus_pa, shape * self.viscosity_pa_s_mu)
    }

    /// The B of a piece with a shape γ, m, of another order that resists as much at an angular frequency, N·s^μ/m.
    ///
    /// ```text
    /// |B'·(jω)^μ| = (A/ℓ)·|M(jω) − E|
    /// ```
    pub fn dissipation_at(&self, shape: f64, order: Order, omega_rad_s: f64) -> f64 {
        if let Some(model) = self.composed().filter(|_| self.order != order) {
            let s = Complex::new(0.0, omega_rad_s);
            let loss = (model.modulus(s) - self.rest_modulus_pa).norm();
            return shape * loss / libm::pow(omega_rad_s, order.get());
        }
        let change = libm::pow(omega_rad_s, self.order.get() - order.get());
        shape * self.viscosity_pa_s_mu * change
    }

    /// The operator that renders the tissue for `samples` samples.
    ///
    /// # Errors
    /// An operator that the scheme cannot make.
    pub fn operator<F: Real>(
        &self,
        scheme: Scheme,
        sample_time: Seconds,
        samples: u64,
    ) -> Result<Operator<F>, Failure> {
        let horizon = horizon(samples);
        match self.composed() {
            None => (scheme.build(self.order, sample_time, horizon)).map_err(|error| {
                Failure::input_with_advice(error, format_args!("change {SCHEME}"))
            }),
            model => operator(model, scheme, self.order, sample_time, horizon),
        }
    }

    /// The force of a whole record of depths that begins at rest, by the defining sums.
    ///
    /// # Errors
    /// An order or a history that cannot be summed.
    pub fn full_history(
        &self,
        shape: f64,
        reference: ReferenceWeights,
        t: Seconds,
        depth: &[f64],
    ) -> Result<Vec<f64>, Failure> {
        if let Some(model) = self.composed() {
            let sampled = SampledModel::new(model, t).map_err(Failure::run)?;
            let mut sums = FullHistory::new(&sampled, depth.len()).map_err(Failure::run)?;
            return Ok(depth.iter().map(|&x| shape * sums.step(x)).collect());
        }
        let (k, b) = self.spring_and_damper(shape);
        let rates = reference.full_history(self.order, t, depth)?;
        let forces = depth.iter().zip(rates).map(|(x, d)| k * x + b * d);
        Ok(forces.collect())
    }

    /// The full history tick by tick.
    ///
    /// # Errors
    /// An operator or a model that cannot be sampled.
    pub fn sampled(
        &self,
        shape: f64,
        reference: ReferenceWeights,
        t: Seconds,
        samples: u64,
    ) -> Result<Sampled, Failure> {
        let (k, b) = self.spring_and_damper(shape);
        let Some(model) = self.composed() else {
            let channel = reference::operator(reference, self.order, t, samples)?;
            return Ok(Sampled::Derivative(k, b, channel));
        };
        let model = SampledModel::new(model, t).map_err(Failure::input)?;
        let sums = FullHistory::new(&model, samples as usize).map_err(Failure::input)?;
        Ok(Sampled::Sums(shape, Box::new(sums)))
    }
}

impl Deref for ModelledTissue {
    type Target = Material;

    fn deref(&self) -> &Material {
        &self.material
    }
}

/// A piece of tissue that is touched.
///
/// ```text
/// f = γ·(E·e(δ) + B·(T^μ·P) D^μ e(δ))
/// ```
#[derive(Clone, Debug)]
pub struct TissuePiece {
    /// Boxed, because a tissue is large and a [`crate::preflight::Matter`] is moved about.
    pub material: Box<ModelledTissue>,
    /// Size and loading of the piece: they turn stress over strain into force over depth.
    pub specimen: Specimen,
}

impl TissuePiece {
    /// A piece of this tissue, with its Poisson ratio and stiffening, loaded like this.
    ///
    /// # Errors
    /// As [`Specimen::new`].
    pub fn new(material: ModelledTissue, loading: Loading) -> Result<Self, LoopParameterError> {
        let ratio = material.loading.poisson_ratio();
        let specimen = Specimen::new(loading, ratio, material.stiffening)?;
        Ok(Self {
            material: Box::new(material),
            specimen,
        })
    }

    /// A compressed slab of the default size.
    ///
    /// # Errors
    /// As [`Specimen::new`].
    pub fn usual(material: ModelledTissue) -> Result<Self, LoopParameterError> {
        let loading = Loading {
            area_m2: Some(AREA.default_number()),
            thickness_m: Some(THICKNESS.default_number()),
            ..Loading::new(LoadingKind::Compression)
        };
        Self::new(material, loading)
    }

    /// γ, m: force over the memory's stress for e(δ).
    #[must_use]
    pub fn shape_m(&self) -> f64 {
        self.specimen.shape(self.material.loading.modulus())
    }

    /// Why a piece that [is not linear](Self::is_linear) is refused, and what to press instead.
    pub const NOT_LINEAR: &'static str = "the force of this piece is not linear in its depth, which this needs: press a slab or \
                                          with a punch a tissue that does not stiffen";

    /// True if e(δ) = δ.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.specimen.depth_map().is_none()
    }

    /// e, from a depth, m, to m.
    pub fn effective(&self) -> impl Fn(f64) -> f64 + use<> {
        effective(self.specimen.depth_map())
    }

    /// Sentences about ticks, s, and a depth, m, of a run that lie beyond the tissue's record.
    pub fn leaves(&self, times_s: (f64, f64), depth_m: f64) -> Vec<String> {
        let mut sentences: Vec<String> = self.material.beyond(times_s).into_iter().collect();
        let strain = self.specimen.strain(Metres(depth_m));
        // The strain of a slab cannot be compared with that under a sphere.
        let measured = self.material.loading.kind;
        let alike = measured.is_none_or(|kind| kind == self.specimen.loading().kind);
        let (most, whose) = match self.material.range.strain_to.filter(|_| alike) {
            Some(most) => (most, format!("the numbers of {} hold", self.material.name)),
            None => (
                Specimen::SMALL_STRAIN,
                "small strain, as this model assumes, holds".to_owned(),
            ),
        };
        // An excess of one per cent does not matter.
        if strain > 1.01 * most {
            sentences.push(format!(
                "the strain reaches {} %; {whose} up to {} %",
                digits(100.0 * strain, 3),
                digits(100.0 * most, 3)
            ));
        }
        sentences
    }

    /// Force under a depth that rises to δ₀ in T₀ and is then held, N, at rising times; zero up to 0.
    pub fn relaxed(&self, depth_m: f64, ramp_time_s: f64, time_s: &[f64]) -> Vec<f64> {
        let shape = self.shape_m();
        let way = |time: f64| depth_m * (time / ramp_time_s).min(1.0);
        let model = &self.material.model;
        let stress = match (self.specimen.depth_map(), &self.material.pot) {
            (None, Some(pot)) => {
                let stress = |time: &f64| pot.relaxation_stress(depth_m, ramp_time_s, *time).0;
                time_s.iter().map(stress).collect()
            }
            (None, None) => driven(model, way, &[ramp_time_s], time_s),
            // A map is no straight line: fine corners, finer where it begins.
            (Some(map), _) => {
                let corners = (1..=CORNERS).map(|n| {
                    let share = f64::from(n) / f64::from(CORNERS);
                    ramp_time_s * share * share
                });
                let corners: Vec<f64> = corners.collect();
                driven(model, |time| map.at(way(time)), &corners, time_s)
            }
        };
        stress.into_iter().map(|stress| shape * stress).collect()
    }

    /// [`relaxed`](Self::relaxed) of ticks that come one after the other, at times n·T after this lead, s.
    pub fn relaxation(
        &self,
        depth_m: f64,
        ramp_time_s: f64,
        sample_time: Seconds,
        lead_s: f64,
    ) -> impl FnMut(u64, f64) -> f64 + '_ {
        by_ticks(sample_time, move |times| {
            let times: Vec<f64> = times.iter().map(|time| time + lead_s).collect();
            self.relaxed(depth_m, ramp_time_s, &times)
        })
    }

    /// Depth under a step of force F₀ at t = 0, m, at any times; zero up to 0.
    ///
    /// ```text
    /// e(δ(t)) = F₀·J(t)/γ
    /// ```
    pub fn crept(&self, force_n: f64, time_s: &[f64]) -> Vec<f64> {
        let map = self.specimen.depth_map();
        let strains = creep(&self.material.model, force_n / self.shape_m(), time_s);
        let depth = |strain| map.map_or(strain, |map| map.depth(strain));
        strains.into_iter().map(depth).collect()
    }

    /// Depth under a step of force at successive ticks.
    pub fn creep(&self, force_n: f64, sample_time: Seconds) -> impl FnMut(u64, f64) -> f64 + '_ {
        by_ticks(sample_time, move |times| self.crept(force_n, times))
    }

    /// K in N/m and B in N·s^μ/m.
    #[must_use]
    pub fn spring_and_damper(&self) -> (f64, f64) {
        self.material.spring_and_damper(self.shape_m())
    }
}

/// e, from a depth, m, to m; δ itself without a map.
pub fn effective(map: Option<DepthMap<f64>>) -> impl Fn(f64) -> f64 {
    move |depth_m| map.map_or(depth_m, |map| map.at(depth_m))
}

/// The operator for a horizon in samples: the model's, or D^μ.
///
/// # Errors
/// A scheme that cannot be built, or that does not support a model.
pub fn operator<F: Real>(
    model: Option<&Model>,
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
    horizon: f64,
) -> Result<Operator<F>, Failure> {
    let Some(model) = model else {
        let built = scheme.build(order, sample_time, horizon);
        return built.map_err(Failure::input);
    };
    if let Scheme::Grunwald { length } = scheme {
        let (order, quotient) = short_memory(model, sample_time, length)?;
        let quotient = quotient.each_ref().map(Vec::as_slice);
        let built = ShortQuotient::new(order, quotient, sample_time).map_err(Failure::input)?;
        return Ok(Operator::ShortQuotient(built));
    }
    let design = design(model, scheme, sample_time, horizon)?;
    let memory = FullMemory::new(&design, sample_time).map_err(Failure::input)?;
    Ok(Operator::FullMemory(Box::new(memory)))
}

/// The operator for the analysis.
///
/// # Errors
/// An operator that the scheme cannot make.
pub fn loop_operator(
    model: Option<&Model>,
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
    horizon: f64,
) -> Result<LoopOperator, Failure> {
    let made = match (model, scheme) {
        (None, _) => LoopOperator::new(scheme, order, sample_time, horizon),
        (Some(model), Scheme::Grunwald { length }) => {
            let (order, [above, below]) = short_memory(model, sample_time, length)?;
            LoopOperator::from_quotient(order, above, below)
        }
        (Some(model), _) => {
            LoopOperator::from_design(&design(model, scheme, sample_time, horizon)?)
        }
    };
    made.map_err(|error: AnalysisError| Failure::input(error))
}

/// μ of a model, and numerator and denominator of its memory where each element remembers so many samples.
fn short_memory(
    model: &Model,
    sample_time: Seconds,
    length: usize,
) -> Result<(Order, [Vec<f64>; 2]), Failure> {
    let sampled = SampledModel::new(model, sample_time).map_err(Failure::input)?;
    let quotient = sampled.short_memory(length).map_err(|error| {
        Failure::input_with_advice(error, format_args!("change N of grunwald:N in {SCHEME}"))
    })?;
    Ok((sampled.order(), quotient))
}

/// The modes of a model.
fn design(
    model: &Model,
    scheme: Scheme,
    sample_time: Seconds,
    horizon: f64,
) -> Result<Design<FULL_TAPS, FULL_MODES>, Failure> {
    let sampled = SampledModel::new(model, sample_time).map_err(Failure::input)?;
    if scheme == Scheme::Exact {
        return Err(Failure::input(SchemeError::AnalysisOnly));
    }
    let Scheme::Full {
        kernel: Kernel::Grunwald,
        tolerance,
    } = scheme
    else {
        return Err(bad_input!(
            "scheme {scheme} makes one spring-pot, not a model with more elements: use {scheme_full}, or a short memory, as in {short}",
            scheme_full = SCHEME.set_to("full"),
            short = SCHEME.set_to("grunwald:1000")
        ));
    };
    sampled
        .design(tolerance, horizon.max(HORIZON_MIN))
        .map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!(
                    "give {SCHEME} a larger tolerance, as in full:1e-4, or use a shorter run"
                ),
            )
        })
}

/// A piece of tissue tick by tick with all of its past: f\[n\] = gain·x\[n\] + past.
#[derive(Debug)]
pub enum Sampled {
    /// Gain on the position, that on the derivative, and its operator.
    Derivative(f64, f64, Channel<f64, Operator<f64>>),
    /// The shape, and the sums of the elements.
    Sums(f64, Box<FullHistory>),
}

/// The memory of a model alone, tick by tick, in units of x·s^(−μ): what D^μ is in the force −(K·x + B·D^μ x).
///
/// # Errors
/// An operator or a model that cannot be sampled.
pub fn memory(
    model: &Model,
    t: Seconds,
    samples: u64,
) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
    let sampled = SampledModel::new(model, t).map_err(Failure::input)?;
    let sums = FullHistory::new(&sampled, samples as usize);
    let mut sums = sums.map_err(Failure::input)?;
    let (e, b) = (sampled.elastic_modulus_pa(), sampled.viscosity_pa_s_mu());
    Ok(move |x: f64| (sums.step(x) - e * x) / b)
}

impl Sampled {
    /// The factor of the newest depth.
    pub fn gain(&self) -> f64 {
        match self {
            Self::Derivative(k, b, channel) => k + b * channel.operator().direct_gain(),
            Self::Sums(shape, sums) => shape * sums.gain(),
        }
    }

    /// The force at a depth; at 0 that of the past alone.
    pub fn force(&self, depth: f64) -> f64 {
        match self {
            Self::Derivative(k, b, channel) => k * depth + b * channel.output(depth),
            Self::Sums(shape, sums) => shape * sums.stress(depth),
        }
    }

    /// Takes the newest depth into the past.
    pub fn advance(&mut self, depth: f64) {
        match self {
            Self::Derivative(_, _, channel) => channel.advance(depth),
            Self::Sums(_, sums) => sums.advance(depth),
        }
    }
}

/// Many times at once cost a model little more than one.
fn by_ticks(
    sample_time: Seconds,
    many: impl Fn(&[f64]) -> Vec<f64>,
) -> impl FnMut(u64, f64) -> f64 {
    let (mut first, mut values) = (0, Vec::new());
    move |tick, _| {
        let known = tick
            .checked_sub(first)
            .and_then(|at| values.get(at as usize));
        if let Some(value) = known {
            return *value;
        }
        let times: Vec<f64> = (tick..tick + AT_ONCE)
            .map(|tick| tick as f64 * sample_time.0)
            .collect();
        (first, values) = (tick, many(&times));
        values[0]
    }
}

/// Ticks whose closed forms are made at once.
const AT_ONCE: u64 = 4096;

/// Corners of a ramp through a map of depth.
const CORNERS: u32 = 4096;

/// The stress at rising times under an input that is straight between these corners and times, Pa; zero up to 0.
fn driven(model: &Model, input: impl Fn(f64) -> f64, corners: &[f64], time_s: &[f64]) -> Vec<f64> {
    let later = time_s.iter().filter(|&&time| time > 0.0);
    let mut times: Vec<f64> = [0.0].iter().chain(later).chain(corners).copied().collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let inputs: Vec<f64> = times.iter().map(|&time| input(time)).collect();
    let stress = model.stress(&times, &inputs);
    let at = |time: &f64| match times.binary_search_by(|known| known.total_cmp(time)) {
        Ok(index) if *time > 0.0 => stress[index],
        _ => 0.0,
    };
    time_s.iter().map(at).collect()
}

/// The strain at any times.
fn creep(model: &Model, stress_pa: f64, time_s: &[f64]) -> Vec<f64> {
    let compliances = model.creep_compliances(time_s).into_iter();
    let strains = compliances.zip(time_s);
    strains
        .map(|(j, &time)| if time > 0.0 { stress_pa * j } else { 0.0 })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::{compared::relative_error, modelled_tissue::*};
    use haptic_tissue::{ModelKind, Source};
    use std::path::Path;
    use testkit::Tested;

    fn creep_strain(tissue: &ModelledTissue, stress_pa: f64, time_s: f64) -> f64 {
        creep(&tissue.material.model, stress_pa, &[time_s])[0]
    }

    fn tissue(series: &[f64]) -> ModelledTissue {
        let model = Model::from_parameters(ModelKind::Prony, series).expect("valid");
        let material = Material::new("gel", "a gel", model, Source::default());
        ModelledTissue::new(material.expect("a name")).expect("sampled")
    }

    #[test]
    fn short_memories_in_series_share_the_strain_of_each_tick() -> Tested {
        // Each element remembers N of its own strains; the two forces are one.
        let (v, alpha, g, beta, length, t) = (3e3, 0.7, 9e3, 0.2, 40, Seconds(1e-3));
        let values = [v, alpha, g, beta];
        let model = Model::from_parameters(ModelKind::FractionalMaxwell, &values)?;
        let scheme = Scheme::Grunwald { length };
        let sampled = SampledModel::new(&model, t)?;
        let made = operator::<f64>(Some(&model), scheme, sampled.order(), t, 1e4);
        let mut rendered = Channel::new(made?);
        let element = |size: f64, order: f64| {
            let weights = fracdiff::grunwald_weights(Order::new(order).expect("in range"));
            let newest = size * t.0.powf(-order);
            let weights = weights.take(length).map(|c| newest * c);
            weights.collect::<Vec<f64>>()
        };
        let (first, second) = (element(v, alpha), element(g, beta));
        let (mut strains, mut worst) = ([Vec::new(), Vec::new()], 0.0_f64);
        for n in 0..300 {
            let strain = f64::min(1e-2 * f64::from(n) / 50.0, 1e-2) + 1e-3 * f64::sin(f64::from(n));
            let past = |weights: &[f64], strains: &[f64]| -> f64 {
                let newest_first = strains.iter().rev();
                weights[1..]
                    .iter()
                    .zip(newest_first)
                    .map(|(c, x)| c * x)
                    .sum()
            };
            let (one, other) = (past(&first, &strains[0]), past(&second, &strains[1]));
            let share = (second[0] * strain + other - one) / (first[0] + second[0]);
            strains[0].push(share);
            strains[1].push(strain - share);
            let stress = first[0] * share + one;
            let have = sampled.viscosity_pa_s_mu() * rendered.step(strain);
            worst = worst.max((have - stress).abs() / 100.0);
        }
        assert!(worst < 1e-10, "{worst}");
        Ok(())
    }

    #[test]
    fn a_series_without_branches_is_a_spring() {
        let spring = tissue(&[5e3]);
        assert!(spring.composed().is_none());
        assert_eq!(spring.spring_and_damper(0.02), (100.0, 0.0));
    }

    #[test]
    fn another_order_resists_as_much_at_the_frequency() {
        let gel = tissue(&[5e3, 1e3, 0.1]);
        let half = Order::new(0.5).expect("valid");
        // |M(jω) − E| = E₁·ωτ/√(1 + ω²τ²) at ωτ = 1.
        let have = gel.dissipation_at(2.0, half, 10.0) * 10.0_f64.sqrt();
        assert!((have - 2e3 / 2.0_f64.sqrt()).abs() < 1e-9, "{have}");
        assert!((gel.dissipation_at(2.0, gel.order(), 10.0) - 200.0).abs() < 1e-9);
    }

    fn pot(modulus_pa: f64, viscosity_pa_s_alpha: f64, order: f64) -> ModelledTissue {
        let text = format!(
            "name = \"piece\"\ndescription = \"\"\n[parameters]\nelastic_modulus_pa = {modulus_pa:?}\n\
             viscosity_pa_s_alpha = {viscosity_pa_s_alpha:?}\norder = {order:?}\n\
             [source]\ncitation = \"\"\nconditions = \"\"\nchecked = false\n"
        );
        let material = Material::parse(Path::new("piece.toml"), &text).expect("valid");
        ModelledTissue::new(material).expect("valid")
    }

    #[test]
    fn creep_agrees_with_50_digits() {
        // tests/golden/make_golden.py: E_α(−z). With E₀ = 1, η = 1/z, t = 1 the argument is −z.
        let golden = include_str!("../tests/golden/mittag_leffler.csv");
        for line in golden.lines().skip(1) {
            let cells: Vec<f64> = line
                .split(',')
                .map(|c| c.parse().expect("number"))
                .collect();
            let (alpha, z, value) = (cells[0], cells[1], cells[2]);
            let have = creep_strain(&pot(1.0, 1.0 / z, alpha), 1.0, 1.0);
            assert!(
                (have - (1.0 - value)).abs() < 1e-12,
                "α {alpha} z {z}: {have}"
            );
        }
    }

    #[test]
    fn creep_of_a_soft_spring_tends_to_creep_without_one() {
        let with = pot(1e-4, 8650.0, 0.2247);
        let without = pot(0.0, 8650.0, 0.2247);
        for t in [0.01, 1.0, 200.0] {
            let (a, b) = (
                creep_strain(&with, 100.0, t),
                creep_strain(&without, 100.0, t),
            );
            assert!(relative_error(a, b) < 1e-6, "t {t}: {a} {b}");
        }
    }
}
