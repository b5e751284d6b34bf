//! The environment of a device: its wall, or the controller that holds it in a run; with several axes behind a surface.

#[cfg(feature = "controllers")]
use crate::holding::{Holding, HoldingHistory};
use crate::prepared::DeviceWall;
use haptic_loop::Environment;
#[cfg(feature = "several-axes")]
use haptic_loop::{Shape, Surface as _};
use nalgebra::SVector;

/// Law that a device renders: a wall along its first axis, or along the normal of a surface.
#[derive(Debug)]
pub(crate) struct Rendered<const D: usize> {
    pub wall: DeviceWall,
    /// Its depth is the position that the wall sees.
    #[cfg(feature = "several-axes")]
    pub surface: Option<Shape<f32, D>>,
    /// Controller in place of the wall.
    #[cfg(feature = "controllers")]
    pub holding: Option<Holding>,
}

/// History of [`Rendered`].
#[derive(Clone, Debug)]
pub(crate) struct RenderedHistory {
    wall: <DeviceWall as Environment<f32, 1>>::History,
    #[cfg(feature = "controllers")]
    holding: Option<HoldingHistory>,
}

impl<const D: usize> Rendered<D> {
    pub(crate) const fn of(wall: DeviceWall) -> Self {
        Self {
            wall,
            #[cfg(feature = "several-axes")]
            surface: None,
            #[cfg(feature = "controllers")]
            holding: None,
        }
    }

    /// The position that the law sees, m, and the direction of its force.
    #[inline]
    fn along(&self, position_m: &SVector<f32, D>) -> (SVector<f32, 1>, SVector<f32, D>) {
        #[cfg(feature = "several-axes")]
        if let Some(surface) = &self.surface {
            let (depth, normal) = surface.touch(position_m);
            return (SVector::from([depth]), normal);
        }
        (SVector::from([position_m[0]]), on_first_axis(1.0))
    }
}

/// A number of all axes together, where there is an element for each.
#[inline]
fn on_first_axis<const D: usize>(number: f32) -> SVector<f32, D> {
    let mut all = [0.0; D];
    all[0] = number;
    SVector::from(all)
}

impl<const D: usize> Environment<f32, D> for Rendered<D> {
    type History = RenderedHistory;

    fn at_rest(&self) -> Self::History {
        RenderedHistory {
            wall: self.wall.at_rest(),
            #[cfg(feature = "controllers")]
            holding: self.holding.as_ref().map(Holding::at_rest),
        }
    }

    fn rest(&self, history: &mut Self::History) {
        self.wall.rest(&mut history.wall);
        #[cfg(feature = "controllers")]
        {
            history.holding = self.holding.as_ref().map(Holding::at_rest);
        }
    }

    fn settle(&self, history: &mut Self::History, position_m: &SVector<f32, D>) {
        #[cfg(feature = "controllers")]
        if let (Some(holding), Some(past)) = (&self.holding, &mut history.holding) {
            holding.settle(past, position_m[0]);
            return;
        }
        // A wall without a push of its own begins where it was set, and the way to there is a motion.
        self.wall
            .begin(&mut history.wall, &self.along(position_m).0);
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<f32, D>) -> SVector<f32, D> {
        #[cfg(feature = "controllers")]
        if let (Some(holding), Some(past)) = (&self.holding, &history.holding) {
            return on_first_axis(holding.force_n(past, position_m[0]));
        }
        let (depth, normal) = self.along(position_m);
        let force = self.wall.force(&history.wall, &depth);
        normal * force[0]
    }

    #[inline]
    fn force_and_input(
        &self,
        history: &Self::History,
        position_m: &SVector<f32, D>,
    ) -> (SVector<f32, D>, SVector<f32, D>) {
        #[cfg(feature = "controllers")]
        if let (Some(holding), Some(past)) = (&self.holding, &history.holding) {
            let force_n = holding.force_n(past, position_m[0]);
            return (on_first_axis(force_n), *position_m);
        }
        let (depth, normal) = self.along(position_m);
        let (force, input) = (self.wall).force_and_input(&history.wall, &depth);
        (normal * force[0], on_first_axis(input[0]))
    }

    #[inline]
    fn advance_input(&self, history: &mut Self::History, input: &SVector<f32, D>) {
        (self.wall).advance_input(&mut history.wall, &SVector::from([input[0]]));
    }

    /// All of the force: where the normal fades, as in the middle of a ball, the next place has it.
    fn starting_force(
        &self,
        history: &Self::History,
        position_m: &SVector<f32, D>,
    ) -> SVector<f32, D> {
        #[cfg(feature = "controllers")]
        if self.holding.is_some() {
            return self.force(history, position_m);
        }
        #[cfg(feature = "several-axes")]
        if let Some(surface) = &self.surface {
            let depth = SVector::from([surface.depth(position_m)]);
            return on_first_axis(self.wall.starting_force(&history.wall, &depth)[0]);
        }
        let (depth, _) = self.along(position_m);
        on_first_axis(self.wall.starting_force(&history.wall, &depth)[0])
    }

    #[cfg(feature = "controllers")]
    #[inline]
    fn advance_applied(
        &self,
        history: &mut Self::History,
        input: &SVector<f32, D>,
        applied_n: &SVector<f32, D>,
    ) {
        match (&self.holding, &mut history.holding) {
            (Some(holding), Some(past)) => holding.advance(past, input[0], applied_n[0]),
            _ => self.advance_input(history, input),
        }
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<f32, D>) {
        let (depth, _) = self.along(position_m);
        self.wall.advance(&mut history.wall, &depth);
    }
}
