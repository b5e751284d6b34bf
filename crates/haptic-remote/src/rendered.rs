//! The environment of a device of any number of axes.

use crate::prepared::DeviceWall;
use haptic_loop::Environment;
use nalgebra::SVector;

/// The wall of a device. With one axis it is felt along it; a device of several renders nothing by itself, as its forces come
/// from the host.
#[derive(Clone, Debug)]
pub(crate) struct Rendered(pub(crate) DeviceWall);

/// The first of the axes.
fn first<const D: usize>(vector: &SVector<f32, D>) -> SVector<f32, 1> {
    SVector::from([vector[0]])
}

impl<const D: usize> Environment<f32, D> for Rendered {
    type History = <DeviceWall as Environment<f32, 1>>::History;

    fn at_rest(&self) -> Self::History {
        self.0.at_rest()
    }

    fn rest(&self, history: &mut Self::History) {
        self.0.rest(history);
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<f32, D>) -> SVector<f32, D> {
        if D > 1 {
            return SVector::from([0.0; D]);
        }
        let force = self.0.force(history, &first(position_m));
        SVector::from([force[0]; D])
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<f32, D>) {
        if D == 1 {
            self.0.advance(history, &first(position_m));
        }
    }
}
