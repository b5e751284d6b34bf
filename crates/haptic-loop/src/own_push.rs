//! A law whose device pushes into it by its own motor.

use crate::environment::Environment;
use fracdiff::Real;
use nalgebra::SVector;

/// An environment into which the motor that renders it also pushes, so that a trial needs nobody.
///
/// ```text
/// f = f_inner(x − x₀) + p + a·[⌊n/N⌋ odd]        p: the push, N; x₀: the place where the handle stood at the start
///                                                a: the tap, N, added in every second N ticks of the run; n: ticks since the start
/// ```
/// - *One actuator*: the sum is the wanted force, so the safety chain limits the push with the law and takes both away
///   after a fault or stop.
/// - *Where it stands* is where the environment begins: nobody has to bring the handle to a place as exact as a stiff wall
///   needs it. A start is judged by the force of the law, which is zero there; the push rises with the chain.
/// - *A tap* is a step of the force, up and N ticks later down. The response to it tells a stable law from one that friction holds still.
/// - *Without a push* it is the inner environment, number for number: then 0 is taken off place and force, which keeps even a
///   negative zero, and costs a tick less than a choice.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::{Environment, OwnPush, SpringDamper};
/// use nalgebra::vector;
///
/// let operator = ShortMemory::<f64, 64>::new(Order::new(1.0)?, Seconds(1e-3))?;
/// let wall = OwnPush::new(SpringDamper::new(512.0, 0.0, operator)?, Some(1.0));
/// let mut history = Environment::<f64, 1>::at_rest(&wall);
/// wall.settle(&mut history, &vector![0.25]);
/// assert_eq!(wall.force(&history, &vector![0.25]), vector![1.0]);
/// assert_eq!(wall.force(&history, &vector![0.25 + 1.0 / 512.0]), vector![0.0]); // at rest, 2 mm deep
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnPush<F, E> {
    inner: E,
    /// The push with the other sign; 0 without one.
    pull_n: F,
    /// True with a push or a tap.
    is_pushed: bool,
    tap: Tap<F>,
}

/// A square wave beside the push: its force, N, is there in every second `ticks` ticks, the first ones without it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap<F> {
    /// N; along the direction in which positions grow.
    pub force_n: F,
    /// Ticks from one step to the next; 0 without steps.
    pub ticks: u32,
}

impl<F: Real> Tap<F> {
    /// No tap in any tick.
    pub const NONE: Self = Self {
        force_n: F::ZERO,
        ticks: 0,
    };

    /// The force in a tick of the run, N.
    pub fn at(&self, tick: u64) -> F {
        match tick.checked_div(self.ticks.into()) {
            Some(step) if step % 2 == 1 => self.force_n,
            _ => F::ZERO,
        }
    }
}

/// History of an [`OwnPush`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnPushHistory<F, H> {
    inner: H,
    /// 0 without a push.
    start_m: F,
    /// Push and tap of this tick with the other sign, N: one number, so that a tick is not dearer for the tap.
    pull_n: F,
    /// Ticks since the tap's newest step.
    since: u32,
    is_tapped: bool,
}

impl<F: Real, E> OwnPush<F, E> {
    /// Environment with a push into it, N: along the direction in which positions grow. A push that is not finite becomes a
    /// force that is not finite, which the safety chain turns into a fault.
    pub fn new(inner: E, push_n: Option<F>) -> Self {
        Self {
            inner,
            pull_n: pull(push_n),
            is_pushed: push_n.is_some(),
            tap: Tap::NONE,
        }
    }

    /// The environment that is pushed into.
    pub const fn inner(&self) -> &E {
        &self.inner
    }

    /// True if it has a push or a tap.
    pub const fn is_pushed(&self) -> bool {
        self.is_pushed
    }

    /// Takes another push and tap, and gives its environment to be changed.
    pub fn reshape(&mut self, push_n: Option<F>, tap: Tap<F>) -> &mut E {
        self.is_pushed = push_n.is_some() || tap.force_n != F::ZERO;
        (self.pull_n, self.tap) = (pull(push_n), tap);
        &mut self.inner
    }

    /// Puts the beginning of the environment where the handle stands, if there is a push; without one the history stays as it is.
    pub fn begin<H>(&self, history: &mut OwnPushHistory<F, H>, position_m: &SVector<F, 1>) {
        if self.is_pushed {
            history.start_m = position_m[0];
        }
    }

    #[inline]
    fn count<H>(&self, history: &mut OwnPushHistory<F, H>) {
        if self.tap.ticks > 0 {
            history.since = history.since.wrapping_add(1);
            if history.since >= self.tap.ticks {
                history.since = 0;
                history.is_tapped = !history.is_tapped;
                history.pull_n = if history.is_tapped {
                    self.pull_n - self.tap.force_n
                } else {
                    self.pull_n
                };
            }
        }
    }
}

fn pull<F: Real>(push_n: Option<F>) -> F {
    push_n.map_or(F::ZERO, |push_n| -push_n)
}

impl<F: Real, H> OwnPushHistory<F, H> {
    #[inline]
    fn place(&self, position_m: &SVector<F, 1>) -> SVector<F, 1> {
        SVector::from([position_m[0] - self.start_m])
    }

    #[inline]
    fn with_push(&self, force: SVector<F, 1>) -> SVector<F, 1> {
        SVector::from([force[0] - self.pull_n])
    }
}

impl<F: Real, E: Environment<F, 1>> Environment<F, 1> for OwnPush<F, E> {
    type History = OwnPushHistory<F, E::History>;

    fn at_rest(&self) -> Self::History {
        OwnPushHistory {
            inner: self.inner.at_rest(),
            start_m: F::ZERO,
            pull_n: self.pull_n,
            since: 0,
            is_tapped: false,
        }
    }

    fn rest(&self, history: &mut Self::History) {
        self.inner.rest(&mut history.inner);
        history.start_m = F::ZERO;
        (history.pull_n, history.since, history.is_tapped) = (self.pull_n, 0, false);
    }

    fn settle(&self, history: &mut Self::History, position_m: &SVector<F, 1>) {
        history.start_m = F::ZERO;
        self.begin(history, position_m);
        if !self.is_pushed {
            self.inner.settle(&mut history.inner, position_m);
        }
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<F, 1>) -> SVector<F, 1> {
        let place = history.place(position_m);
        history.with_push(self.inner.force(&history.inner, &place))
    }

    #[inline]
    fn force_and_input(
        &self,
        history: &Self::History,
        position_m: &SVector<F, 1>,
    ) -> (SVector<F, 1>, SVector<F, 1>) {
        let place = history.place(position_m);
        let (force, input) = self.inner.force_and_input(&history.inner, &place);
        (history.with_push(force), input)
    }

    #[inline]
    fn advance_input(&self, history: &mut Self::History, input: &SVector<F, 1>) {
        self.inner.advance_input(&mut history.inner, input);
        self.count(history);
    }

    #[inline]
    fn advance_applied(
        &self,
        history: &mut Self::History,
        input: &SVector<F, 1>,
        applied_n: &SVector<F, 1>,
    ) {
        let of_law = if self.is_pushed {
            SVector::from([applied_n[0] + history.pull_n])
        } else {
            *applied_n
        };
        (self.inner).advance_applied(&mut history.inner, input, &of_law);
        self.count(history);
    }

    fn starting_force(&self, history: &Self::History, position_m: &SVector<F, 1>) -> SVector<F, 1> {
        let place = history.place(position_m);
        self.inner.starting_force(&history.inner, &place)
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, 1>) {
        let place = history.place(position_m);
        self.inner.advance(&mut history.inner, &place);
        self.count(history);
    }
}
