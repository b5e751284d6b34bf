//! A surface that the law of a device of several axes lies behind.
//!
//! ```text
//! x = depth(p)      the law sees the depth into the surface in place of a position
//! f = n(p)·f(x)     its force acts along the normal, into the environment where it is above 0
//! ```
//! The depth and the normal are those of [`Shape`], in single precision. Without a surface the first axis is the normal.

use crate::{limits::Fields, prepared::Prepared};
use haptic_link::{Field, LoopMode, Refusal, SurfaceKind, SurfaceShape};
use haptic_loop::{Ball, Plane, Shape, ShapeKind, ShapeNumbers};

/// The surface of these numbers.
///
/// # Errors
/// Another number of axes; a normal that is not of length 1, a radius outside its range, a number that is not finite.
#[inline(never)]
pub(crate) fn shape<const D: usize>(surface: &SurfaceShape) -> Result<Shape<f32, D>, Refusal> {
    let other = Refusal::Unsupported(Field::Surface);
    let numbers: [f32; D] = surface.axes[..].try_into().map_err(|_| other)?;
    let mut fields = Fields::default();
    for number in numbers {
        fields.within(Field::Surface, number, -f32::MAX, f32::MAX);
    }
    let distance = surface.distance_m;
    let [least, most] = match surface.kind {
        SurfaceKind::Plane => {
            let [least, most] = Plane::<f32, D>::UNIT.map(|end| end as f32);
            let square = numbers.iter().map(|n| n * n).sum();
            fields.within(Field::Surface, square, least, most);
            [-f32::MAX, f32::MAX]
        }
        SurfaceKind::Ball | SurfaceKind::HollowBall => {
            Ball::<f32, D>::RADIUS_M.map(|end| end as f32)
        }
    };
    fields.within(Field::Surface, distance, least, most);
    fields.done()?;
    let shape = ShapeNumbers {
        kind: match surface.kind {
            SurfaceKind::Plane => ShapeKind::Plane,
            SurfaceKind::Ball => ShapeKind::Ball,
            SurfaceKind::HollowBall => ShapeKind::HollowBall,
        },
        place: numbers,
        distance,
    };
    // Everything was checked above.
    Shape::of(&shape).map_err(|_| other)
}

impl<S> Prepared<S> {
    /// Puts a surface in front of the law; `digest` covers all.
    pub(crate) fn behind<const D: usize>(
        self,
        surface: SurfaceShape,
        digest: u32,
    ) -> Result<Self, Refusal> {
        if self.configuration.loop_mode != LoopMode::Device {
            return Err(Refusal::Unsupported(Field::Surface));
        }
        // Only a check: the shape is made anew in its place.
        shape::<D>(&surface)?;
        Ok(Self {
            digest,
            surface: Some(surface),
            ..self
        })
    }
}

/// A surface as it goes over the wire, rounded once.
#[cfg(feature = "std")]
#[must_use]
pub fn wire_surface<const D: usize>(shape: &Shape<f64, D>) -> SurfaceShape {
    let numbers = shape.numbers();
    SurfaceShape {
        kind: match numbers.kind {
            ShapeKind::Plane => SurfaceKind::Plane,
            ShapeKind::Ball => SurfaceKind::Ball,
            ShapeKind::HollowBall => SurfaceKind::HollowBall,
        },
        distance_m: numbers.distance as f32,
        axes: numbers.place.iter().map(|number| *number as f32).collect(),
    }
}
