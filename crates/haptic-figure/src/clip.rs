//! Cuts curves off a little outside their box, before they become pixels.
//!
//! The SVG hides what lies beyond the box, but not from the renderer: a dashed line that ran on for
//! 1e9 px would be cut into as many dashes. Curves come as fractions of the axes, 0 at the low ends
//! and 1 at the high ends, and are cut at the four sides in turn (I. E. Sutherland and G. W.
//! Hodgman, "Reentrant polygon clipping", 1974). An excursion becomes a walk along the outside.

use crate::thin::Points;

/// Distance of the cut from the box, as a share of its sides: more than half a line's width.
const BEYOND: f64 = 0.1;

/// The part of a curve inside and just outside the box; `closed` if its last point leads back to
/// its first. Empty if the curve passes the box by.
pub(crate) fn clip(points: &[(f64, f64)], closed: bool) -> Points {
    let mut kept = points.to_vec();
    for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
        kept = cut(&kept, closed, side);
    }
    // A remainder that lies wholly beyond one side is a walk outside it.
    let outside = |side: Side| kept.iter().all(|point| side.depth(*point) < BEYOND);
    if [Side::Left, Side::Right, Side::Bottom, Side::Top]
        .into_iter()
        .any(outside)
    {
        kept.clear();
    }
    kept
}

#[derive(Clone, Copy, Debug)]
enum Side {
    Left,
    Right,
    Bottom,
    Top,
}

impl Side {
    /// Distance of a point from the cut, positive towards the box.
    fn depth(self, (x, y): (f64, f64)) -> f64 {
        BEYOND
            + match self {
                Self::Left => x,
                Self::Right => 1.0 - x,
                Self::Bottom => y,
                Self::Top => 1.0 - y,
            }
    }
}

/// The part of a curve on the inner side of one cut, whose ends on the cut are joined.
fn cut(points: &[(f64, f64)], closed: bool, side: Side) -> Points {
    let mut kept = Points::with_capacity(points.len());
    let mut before = if closed { points.last() } else { None };
    for point in points {
        let depth = side.depth(*point);
        if let Some(before) = before {
            let depth_before = side.depth(*before);
            if (depth < 0.0) != (depth_before < 0.0) {
                let share = depth_before / (depth_before - depth);
                let between = |from: f64, to: f64| from + share * (to - from);
                kept.push((between(before.0, point.0), between(before.1, point.1)));
            }
        }
        if depth >= 0.0 {
            kept.push(*point);
        }
        before = Some(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: std::ops::RangeInclusive<f64> = -BEYOND - 1e-9..=1.0 + BEYOND + 1e-9;

    #[test]
    fn what_is_inside_stays_as_it_is() {
        let curve = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.2)];
        assert_eq!(clip(&curve, false), curve);
        assert_eq!(clip(&curve, true), curve);
    }

    #[test]
    fn a_line_through_the_box_keeps_its_slope_however_long_it_is() {
        let kept = clip(&[(-1e30, -1e30), (1e30, 1e30)], false);
        assert_eq!(kept.len(), 2);
        for (x, y) in kept {
            assert!((x - y).abs() < 1e-9 && ENDS.contains(&x), "{x} {y}");
        }
    }

    #[test]
    fn a_polygon_around_the_box_fills_it() {
        let kept = clip(&[(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)], true);
        assert_eq!(kept.len(), 4);
        assert!(
            kept.iter()
                .all(|(x, y)| ENDS.contains(x) && ENDS.contains(y))
        );
    }

    #[test]
    fn what_passes_the_box_by_is_gone() {
        assert!(clip(&[(2.0, 0.0), (3.0, 1.0)], false).is_empty());
        assert!(clip(&[(-1.0, 0.5), (0.5, 3.0), (2.0, 2.4)], true).is_empty());
        assert!(clip(&[], true).is_empty());
    }
}
