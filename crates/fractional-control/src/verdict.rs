//! The verdict on a sampled loop, stable or not, as a proof.

use crate::{
    ControlError, ControllerParameters, HeldPlant, LoadedPlant, PowerMemory, enclosure::Fraction,
    held_response::HeldResponse,
};
use certified_count::{Arc, Enclosed, StabilityVerdict, count};
use fracdiff::Seconds;
use num_complex::Complex;

/// The first angle at most at which a plant is not its rule, and times 1/(the samples that are remembered).
const FIRST: f64 = 1e-4;
const OF_MEMORY: f64 = 100.0;

/// The loop that is really run: the weights of the controller, the hold, the dead time, the sampled plant.
/// ```text
/// F(w) = A_C·A_G + k·B_C·B_G,   C = B_C/A_C,  G = B_G/A_G:   stable ⇔ no zero in |w| ≤ 1,  w = z⁻¹
/// ```
/// Zeros are counted by the turn of F along the circle, in steps short enough that a bound of F′
/// proves each (argument principle). `A_C` and `A_G` stay apart from `B_C` and `B_G`, so an
/// unstable pole that a zero cancels is still detected.
///
/// - *Of*: the weights before they are rounded to the sample type, with the bound of their error from [`PowerMemory`].
/// - *Cost*: some hundred to some thousand evaluations, a millisecond to ten.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{PowerMemory, PidParameters, Plant, Rule, SampledControlLoop, HeldPlant};
///
/// let (t, memory) = (Seconds(0.01), PowerMemory::new(Rule::Bdf2, 1e-6, 100.0)?);
/// let plant: Plant = "exp(-0.1s)/(s+1)".parse()?;
/// let plant = HeldPlant::new(&plant, memory, t)?;
/// let gains = PidParameters { proportional: 5.0, integral: 2.0, integral_order: 0.9, ..PidParameters::NONE };
/// let closed = SampledControlLoop::new(gains.into(), memory, &plant)?;
/// let verdict = closed.verdict();
/// assert!(verdict.stable);
/// // It takes several times the gain to make it unstable.
/// assert!(!closed.with_gain(6.0).verdict().stable);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SampledControlLoop {
    controller: Fraction,
    plant: Fraction,
    gain: f64,
    /// The part of a sample in the dead time of the plant.
    part: f64,
    memory_s: Option<f64>,
    /// The plant behind its hold, of one that follows a rule.
    held: Option<HeldResponse>,
    /// True if it is of that, in place of the rule.
    is_held: bool,
    /// False if the rule of such a plant does not grow as the plant does, of which nothing is proved then.
    is_known: bool,
    sample_time: Seconds,
}

/// A loop with its verdict, which is found once.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Judged {
    /// The loop as it runs, of a rule where that replaces the plant.
    pub(crate) closed: SampledControlLoop,
    /// The loop of the plant, behind its hold in place of a rule.
    pub(crate) of_plant: SampledControlLoop,
    /// True if the verdict is on that loop, false if on the rule's.
    is_plants: bool,
    pub(crate) verdict: StabilityVerdict,
}

impl Judged {
    /// The loop that the verdict is on.
    #[must_use]
    pub fn sampled_loop(&self) -> &SampledControlLoop {
        if self.is_plants {
            &self.of_plant
        } else {
            &self.closed
        }
    }

    /// The loop of the rule where the verdict is on that.
    pub(crate) fn of_rule(&self) -> Option<&SampledControlLoop> {
        (!self.is_plants).then_some(&self.closed)
    }
}

impl SampledControlLoop {
    /// The controller's memory may differ from the one that the plant is sampled with.
    ///
    /// # Errors
    /// Parameters outside their range, a memory that is not reached.
    pub fn new(
        controller: ControllerParameters,
        memory: PowerMemory,
        plant: &HeldPlant,
    ) -> Result<Self, ControlError> {
        let rule = Self::around(controller, memory, plant.curve(), plant.sample_time())?;
        let memories = [rule.memory_s, plant.memory_s()].into_iter().flatten();
        Ok(Self {
            memory_s: memories.min_by(f64::total_cmp),
            held: plant.held_response().cloned(),
            part: plant.part(),
            ..rule
        })
    }

    /// Closes the loop around a plant with a law at another port.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn loaded(
        controller: ControllerParameters,
        memory: PowerMemory,
        plant: &LoadedPlant,
    ) -> Result<Self, ControlError> {
        Self::around(controller, memory, plant.curve(), plant.sample_time())
    }

    fn around(
        controller: ControllerParameters,
        memory: PowerMemory,
        plant: &Fraction,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let controller = controller.fraction(memory, sample_time)?;
        Ok(Self {
            memory_s: controller.remembers().then_some(memory.horizon_s()),
            controller,
            plant: plant.clone(),
            gain: 1.0,
            part: 0.0,
            held: None,
            is_held: false,
            is_known: true,
            sample_time,
        })
    }

    /// Reach of the memories of fractional orders in this loop, s; `None` with whole orders only, which
    /// forget nothing. For slower motions the computed loop differs from the functions.
    #[must_use]
    pub fn memory_s(&self) -> Option<f64> {
        self.memory_s
    }

    /// Sets the factor on the gain of the plant.
    #[must_use]
    pub fn with_gain(&self, gain: f64) -> Self {
        Self {
            gain,
            ..self.clone()
        }
    }

    /// The loop of the plant behind its hold instead of the rule that replaces it; `None` for a plant that is sampled exactly, unless next to
    /// nothing of it is left at half the sample rate. Its verdict is
    /// neither stable nor any number of poles where nothing is proved.
    /// ```text
    /// F = A_C·A_G + k·B_C·A_G·G_d,   G_d the response behind the hold:   the rule's A_G has as many growing poles as the plant
    /// ```
    #[must_use]
    pub fn of_plant(&self) -> Option<Self> {
        let is_known = self.grows_as(self.held.as_ref()?);
        Some(Self {
            is_held: true,
            is_known,
            ..self.clone()
        })
    }

    /// True of one that [`of_plant`](Self::of_plant) made.
    pub(crate) const fn is_held(&self) -> bool {
        self.is_held
    }

    /// Judges the plant behind its hold if that is proved, else the rule that replaces it.
    #[must_use]
    pub fn judged(self) -> Judged {
        let of_plant = self.of_plant().unwrap_or_else(|| self.clone());
        let verdict = of_plant.verdict();
        let is_plants = !of_plant.is_held || verdict.unstable_poles.is_some();
        Judged {
            verdict: if is_plants { verdict } else { self.verdict() },
            is_plants,
            of_plant,
            closed: self,
        }
    }

    /// False if the rule of the plant has another number of growing poles than the plant. One at rest is not counted.
    fn grows_as(&self, held: &HeldResponse) -> bool {
        let below = self.plant.below.clone().without_differences();
        let poles = count(|arc| below.at(arc)).unstable_poles;
        poles.is_some() && poles == held.growing_poles()
    }

    /// 1/T.
    pub(crate) fn rate(&self) -> f64 {
        1.0 / self.sample_time.0
    }

    /// `A_C·A_G` and `B_C·B_G`, the latter at the nominal gain; `B_C·A_G·G_d` of a plant behind its hold with the response `G_d`, but next to
    /// rest, where a rule is right as long as its memory lasts.
    pub(crate) fn parts(&self, arc: &Arc) -> (Enclosed, Enclosed) {
        let (controller, below) = (&self.controller, self.plant.below.at(arc));
        let of_memory = |s: f64| OF_MEMORY / (s * self.rate());
        let above = match &self.held {
            Some(held)
                if self.is_held && arc.low >= self.memory_s.map_or(FIRST, of_memory).min(FIRST) =>
            {
                below.times(held.enclosed(arc))
            }
            _ => self.plant.above.at(arc),
        };
        (
            controller.below.at(arc).times(below),
            controller.above.at(arc).times(above),
        )
    }

    /// The least dead time, in samples, with which that of the plant is one of whole samples.
    pub(crate) fn to_whole(&self) -> f64 {
        if self.part == 0.0 {
            0.0
        } else {
            1.0 - self.part
        }
    }

    pub(crate) fn gain(&self) -> f64 {
        self.gain
    }

    /// The verdict, as a proof: no zero of F on or inside the circle, or how many. |F| is relative to the sum of the sizes of its terms.
    #[must_use]
    pub fn verdict(&self) -> StabilityVerdict {
        let verdict = count(|arc| {
            let (below, above) = self.parts(arc);
            below.plus(above.scaled(self.gain))
        });
        StabilityVerdict {
            stable: verdict.stable && self.is_known,
            unstable_poles: verdict.unstable_poles.filter(|_| self.is_known),
            ..verdict
        }
    }

    /// C·G at the angle θ, of the weights held: the open loop.
    #[must_use]
    pub fn open(&self, theta: f64) -> Complex<f64> {
        let [below, above] = self.open_parts(&Arc::new(theta, theta));
        above.middle.value / below.middle.value
    }

    /// Below and above of the open loop: of the plant behind its hold in place of a rule where this is of it.
    pub(crate) fn open_parts(&self, arc: &Arc) -> [Enclosed; 2] {
        let [below, above] =
            [&self.controller.below, &self.controller.above].map(|sum| sum.at(arc));
        let [below, above] = match &self.held {
            Some(held) if self.is_held => [below, above.times(held.enclosed(arc))],
            _ => [
                below.times(self.plant.below.at(arc)),
                above.times(self.plant.above.at(arc)),
            ],
        };
        [below, above.scaled(self.gain)]
    }

    /// Loop with less dead time by whole samples, which turn L alone.
    pub(crate) fn prompt(&self) -> Self {
        let mut prompt = self.clone();
        prompt.plant.above = prompt.plant.above.prompt();
        prompt.held = prompt.held.map(HeldResponse::prompt);
        prompt
    }
}
