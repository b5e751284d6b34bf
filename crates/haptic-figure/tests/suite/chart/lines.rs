//! Lines: gaps, single points, cut at the axes, thinned.

use super::{Points, assert_sound, chart, draw, noise, paths, places};
use haptic_figure::{Look, Scale, Series};

#[test]
fn a_line_has_gaps_where_it_has_no_place_and_no_odd_value_is_drawn() {
    let odd = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        -0.0,
        -1.0,
        1e-320,
        f64::MAX,
    ];
    let gaps: Points = (1..=300)
        .map(|i| {
            let y = if i % 100 == 0 {
                odd[(i / 100) % 7]
            } else {
                1.0 + noise(i as u32)
            };
            (i as f64, y)
        })
        .collect();
    let one = chart("", Scale::Log, vec![Series::new("", &gaps, Look::Line, 0)]);
    let picture = draw(1, vec![one]).expect("draws");
    let line = paths(&picture, "stroke=\"#0072b2\"");
    assert_eq!(line.len(), 1);
    assert_eq!(line[0].matches('M').count(), 3, "{}", line[0]);

    let spoilt: Points = (0..3_000)
        .map(|i| (odd[i % 7] + 0.3, noise(i as u32)))
        .chain((0..3_000).map(|i| (noise(i as u32), odd[i % 7] - 0.3)))
        .chain((0..3_000).map(|i| (noise(i as u32), noise(i as u32 + 9))))
        .collect();
    let looks = [
        Look::Line,
        Look::Dashed,
        Look::Dotted,
        Look::Markers,
        Look::Area,
    ];
    for look in looks {
        for scale in [Scale::Linear, Scale::Log] {
            let mut odd_ranges = chart("", scale, vec![Series::new("all", &spoilt, look, 3)]);
            odd_ranges.x = odd_ranges.x.between(f64::NAN, 1.0);
            odd_ranges.y = odd_ranges.y.between(1.0, -f64::INFINITY);
            let charts = vec![
                odd_ranges,
                chart("", scale, vec![Series::new("all", &spoilt, look, 3)]),
            ];
            assert_sound(
                &draw(2, charts).expect("draws"),
                &format!("{look:?} {scale:?}"),
            );
        }
    }
}

#[test]
fn one_point_and_equal_points_are_seen() {
    for look in [Look::Line, Look::Markers] {
        for points in [vec![(2.0, 3.0)], vec![(0.0, 0.0)], vec![(-2.0, 1e-9); 9]] {
            let one = chart("", Scale::Linear, vec![Series::new("", &points, look, 0)]);
            let picture = draw(1, vec![one]).expect("draws");
            assert_sound(&picture, &format!("{look:?} {points:?}"));
            assert_eq!(paths(&picture, "#0072b2").len(), 1, "{look:?} {points:?}");
        }
    }
}

#[test]
fn curves_are_cut_off_at_the_axes_however_far_they_go() {
    let pole: Points = (0..2_000)
        .map(|i| f64::from(i) / 1_000.0 - 0.9995)
        .map(|x| (x, (1e-3 / x).powi(9)))
        .collect();
    let looks = [Look::Line, Look::Dashed, Look::Area, Look::Markers];
    for look in looks {
        let mut one = chart("", Scale::Linear, vec![Series::new("", &pole, look, 1)]);
        one.x = one.x.between(-0.5, 0.5);
        one.y = one.y.between(-1.0, 1.0);
        let picture = draw(1, vec![one]).expect("draws");
        assert_sound(&picture, "pole");
        let data = paths(&picture, "#d55e00").concat();
        let starts = if look == Look::Markers { "M" } else { "M " };
        for start in data
            .split(|c| starts.contains(c))
            .filter(|part| !part.is_empty())
        {
            let place = places(start);
            assert!(
                place
                    .iter()
                    .all(|(x, y)| x.abs() < 1_000.0 && y.abs() < 600.0),
                "{look:?}"
            );
        }
        #[cfg(feature = "png")]
        picture.png().expect("renders");
    }
    let mut elsewhere = chart(
        "",
        Scale::Linear,
        vec![Series::new("", &pole, Look::Line, 0)],
    );
    elsewhere.x = elsewhere.x.between(5.0, 6.0);
    let picture = draw(1, vec![elsewhere]).expect("draws");
    assert!(picture.svg().contains("outside the axes"));
}
