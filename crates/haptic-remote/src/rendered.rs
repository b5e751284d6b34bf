//! The environment of a device: its wall, or the controller that holds it in a run.

#[cfg(feature = "controllers")]
use crate::holding::{Holding, HoldingHistory};
use crate::prepared::DeviceWall;
use haptic_loop::Environment;
use nalgebra::SVector;

/// What a device of one axis renders; one of several renders nothing by itself.
#[derive(Clone, Debug)]
pub(crate) struct Rendered {
    pub(crate) wall: DeviceWall,
    /// In place of the wall.
    #[cfg(feature = "controllers")]
    pub(crate) holding: Option<Holding>,
}

/// History of [`Rendered`].
#[derive(Clone, Debug)]
pub(crate) struct RenderedHistory {
    wall: <DeviceWall as Environment<f32, 1>>::History,
    #[cfg(feature = "controllers")]
    holding: Option<HoldingHistory>,
}

impl Rendered {
    pub(crate) const fn of(wall: DeviceWall) -> Self {
        Self {
            wall,
            #[cfg(feature = "controllers")]
            holding: None,
        }
    }
}

fn first<const D: usize>(vector: &SVector<f32, D>) -> SVector<f32, 1> {
    SVector::from([vector[0]])
}

impl<const D: usize> Environment<f32, D> for Rendered {
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

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<f32, D>) -> SVector<f32, D> {
        if D > 1 {
            return SVector::from([0.0; D]);
        }
        #[cfg(feature = "controllers")]
        if let (Some(holding), Some(own)) = (&self.holding, &history.holding) {
            return SVector::from([holding.force_n(own, position_m[0]); D]);
        }
        let force = self.wall.force(&history.wall, &first(position_m));
        SVector::from([force[0]; D])
    }

    #[inline]
    fn force_and_input(
        &self,
        history: &Self::History,
        position_m: &SVector<f32, D>,
    ) -> (SVector<f32, D>, SVector<f32, D>) {
        if D > 1 {
            return (SVector::from([0.0; D]), *position_m);
        }
        #[cfg(feature = "controllers")]
        if let (Some(holding), Some(own)) = (&self.holding, &history.holding) {
            let force_n = holding.force_n(own, position_m[0]);
            return (SVector::from([force_n; D]), *position_m);
        }
        let (force, input) = (self.wall).force_and_input(&history.wall, &first(position_m));
        (SVector::from([force[0]; D]), SVector::from([input[0]; D]))
    }

    #[inline]
    fn advance_input(&self, history: &mut Self::History, input: &SVector<f32, D>) {
        if D == 1 {
            (self.wall).advance_input(&mut history.wall, &first(input));
        }
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
            (Some(holding), Some(own)) => holding.advance(own, input[0], applied_n[0]),
            _ => self.advance_input(history, input),
        }
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<f32, D>) {
        if D == 1 {
            self.wall.advance(&mut history.wall, &first(position_m));
        }
    }
}
