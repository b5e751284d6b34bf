//! The stability region: anchors, closed forms, and agreement with point verdicts.

use haptic_analysis::{LoopOperator, SampledLoop, SampledPlant, StabilityRegion, StableArea};
use std::f64::consts::PI;
use testkit::operator::{operator, path, wall};
use testkit::{Random, assert_close, assert_says};

fn region_of(operator: &LoopOperator, delta: f64, gamma: f64, delay: usize) -> StabilityRegion {
    let plant = SampledPlant::new(delta, gamma).expect("in range");
    StabilityRegion::new(plant, operator, delay, 2000).unwrap_or_else(|error| {
        panic!(
            "μ = {}, δ = {delta}, γ = {gamma}, d = {delay}: {error}",
            operator.order()
        )
    })
}

fn area(scheme: &str, order: f64, delta: f64, gamma: f64, delay: usize) -> StableArea {
    let region = region_of(&operator(scheme, order), delta, gamma, delay);
    region.bounded().expect("not empty").clone()
}

#[test]
fn a_spring_and_a_damper_on_a_free_mass_have_the_closed_form() {
    let have = area("exact", 1.0, 0.0, 0.0, 0);
    let root = 2_f64.sqrt();
    assert_close("α", have.alpha_max, 12.0 - 8.0 * root, 1e-9);
    assert_close("β", have.beta_at_alpha_max, 2.0 * root - 2.0, 1e-9);
    assert_close("β", have.beta_max, 2.0, 1e-9);
    // ∫₀² 2β(2 − β)/(2 + β) dβ = 12 − 16 ln 2
    assert_close("area", have.area, 12.0 - 16.0 * 2_f64.ln(), 1e-9);
    assert_eq!(have.polygons.len(), 1);
    for point in have.polygons[0]
        .points
        .iter()
        .filter(|point| point.alpha != 0.0)
    {
        let beta = point.beta;
        let want = 2.0 * beta * (2.0 - beta) / (2.0 + beta);
        assert_close(&format!("{point:?}"), point.alpha, want, 1e-9);
    }
}

#[test]
fn the_anchors_with_delay_and_damping_are_met_to_the_digits_printed() {
    for (delta, delay, alpha, beta) in [
        (0.0, 1, 0.14447, 0.42469),
        (0.0, 2, 0.06243, 0.29139),
        (0.0, 3, 0.03478, 0.22238),
        (0.1, 0, 0.82582, 0.80875),
    ] {
        let have = area("exact", 1.0, delta, 0.0, delay);
        let what = format!("δ = {delta}, d = {delay}");
        assert_close(&what, have.alpha_max, alpha, 5.1e-6);
        assert_close(&what, have.beta_at_alpha_max, beta, 5.1e-6);
    }
}

/// A loop but for its stiffness and dissipation.
#[derive(Debug)]
struct Drawn {
    scheme: &'static str,
    order: f64,
    delta: f64,
    gamma: f64,
    delay: usize,
}

impl Drawn {
    fn new(random: &mut Random, case: usize) -> Self {
        let schemes = "exact muir:3 grunwald:20 tustin-muir:5 full:1e-4 exact muir:3";
        let scheme = schemes.split(' ').nth(case % 7).expect("seven");
        let order = match case % 5 {
            0 => 0.5 * (random.between(0.0, 5.0)).floor(),
            _ => random.between(0.02, 2.0),
        };
        let mut unless = |is_nothing: bool, most: f64| {
            if is_nothing {
                0.0
            } else {
                random.between(0.0, most)
            }
        };
        let delta = unless(case.is_multiple_of(3), 2.0);
        let gamma = unless(case % 4 < 2, 1.5);
        Self {
            scheme,
            order,
            delta,
            gamma,
            delay: (random.share() * random.share() * 6.0) as usize,
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn membership_agrees_with_point_verdicts_everywhere() {
    let mut random = Random(5);
    let (mut points, mut skipped) = (0, 0);
    for case in 0..400 {
        let drawn = Drawn::new(&mut random, case);
        let (delta, gamma, delay) = (drawn.delta, drawn.gamma, drawn.delay);
        let operator = operator(drawn.scheme, drawn.order);
        let region = region_of(&operator, delta, gamma, delay);
        let (alpha_most, beta_most) = region
            .bounded()
            .map_or((2.0, 2.0), |area| (area.alpha_max, area.beta_max));
        for i in 0..60 {
            // Mostly near the region, some far away.
            let far = if i % 6 == 5 { 20.0 } else { 1.3 };
            let alpha = random.between(0.0, far * alpha_most);
            let beta = random.between(0.0, far * beta_most);
            let parameters = wall(alpha, beta, delta, gamma);
            let subject = SampledLoop::new(parameters, &operator, delay).expect("in range");
            let verdict = subject.verdict();
            let agrees = region.contains(alpha, beta) == verdict.stable;
            points += 1;
            // Chords cut corners.
            let is_near = verdict.distance < 1e-5 * (1.0 + alpha + beta);
            assert!(
                agrees || is_near,
                "case {case}, {drawn:?}: α = {alpha}, β = {beta}"
            );
            skipped += usize::from(!agrees);
        }
    }
    assert!(skipped < points / 500, "{skipped} skipped");
}
#[test]
fn a_memory_of_second_order_has_a_region_at_order_2() {
    // There its boundary comes from infinity so steeply that an angle gives its points to some 1e-9 only.
    let mut random = Random(2);
    let operator = operator("full-bdf2", 2.0);
    let mut on_a_chord = 0;
    for (delta, gamma, delay) in [
        (6.5e-5, 0.0, 1),
        (0.0, 1.6e-3, 3),
        (5e-4, 2e-5, 1),
        (1e-3, 0.0, 0),
        (0.02, 0.01, 2),
        (0.1, 0.0, 3),
    ] {
        let region = region_of(&operator, delta, gamma, delay);
        let area = region.bounded().expect("not empty");
        for _ in 0..40 {
            let alpha = random.between(0.0, 1.3 * area.alpha_max);
            let beta = random.between(0.0, 1.3 * area.beta_max);
            let parameters = wall(alpha, beta, delta, gamma);
            let subject = SampledLoop::new(parameters, &operator, delay).expect("in range");
            let verdict = subject.verdict();
            let agrees = region.contains(alpha, beta) == verdict.stable;
            // Chords cut corners, of few points only.
            let is_near = verdict.distance < 1e-6 * (1.0 + alpha + beta);
            assert!(
                agrees || is_near,
                "{delta} {gamma} {delay}: {alpha}, {beta}"
            );
            on_a_chord += usize::from(!agrees);
        }
    }
    assert!(on_a_chord <= 2, "{on_a_chord} of 240");
}

#[test]
fn the_boundary_is_where_the_characteristic_function_vanishes() {
    for (scheme, order, delta, gamma, delay) in [
        ("exact", 0.5, 0.1, 0.0, 0),
        ("muir:3", 1.7, 0.1, 0.2, 1),
        ("full:1e-6", 0.8, 0.05, 0.0, 2),
    ] {
        let operator = operator(scheme, order);
        let have = region_of(&operator, delta, gamma, delay);
        for polygon in &have.bounded().expect("not empty").polygons {
            for point in &polygon.points {
                let Some(theta) = point.theta else { continue };
                let parameters = wall(point.alpha, point.beta, delta, gamma);
                let subject = SampledLoop::new(parameters, &operator, delay).expect("in range");
                let f = subject.characteristic(theta);
                assert!(f.norm() < 1e-8, "{scheme}, {point:?}: {f}");
                assert!((0.0..=PI).contains(&theta));
            }
        }
    }
}

#[test]
fn detached_parts_are_found() {
    // The ninth Muir polynomial ripples, and its boundary curve with it.
    let (delta, gamma) = (1.219_125_731_899_1, 1.227_911_057_393_125_6);
    let operator = operator("muir:9", 0.580_811_450_707_542_6);
    let region = region_of(&operator, delta, gamma, 0);
    let area = region.bounded().expect("not empty");
    assert_eq!(area.polygons.len(), 3);
    for polygon in &area.polygons {
        assert!(polygon.area > 0.0);
        // Its boundary has a stable loop to its left, and only there; but for the corners, where both sides are.
        let count = polygon.points.len();
        let (mut tried, mut wrong) = (0, 0);
        for index in 0..count {
            let (a, b) = (polygon.points[index], polygon.points[(index + 1) % count]);
            let (along, across) = (b.alpha - a.alpha, b.beta - a.beta);
            let stable = |step: f64| {
                let alpha = 0.5 * (a.alpha + b.alpha) - step * across;
                let beta = 0.5 * (a.beta + b.beta) + step * along;
                let parameters = wall(alpha, beta, delta, gamma);
                // Outside the quadrant there is no loop at all.
                let subject = SampledLoop::new(parameters, &operator, 0);
                subject.is_ok_and(|subject| subject.is_stable())
            };
            tried += 1;
            wrong += usize::from(!stable(0.02) || stable(-0.02));
        }
        assert!(wrong <= 4 + tried / 100, "{wrong} of {tried}");
    }
}

#[test]
fn a_region_that_cannot_be_asked_for_is_refused_in_words() {
    let plant = SampledPlant::new(0.1, 0.0).expect("in range");
    let refused = |order, delay| {
        let operator = operator("exact", order);
        let region = StabilityRegion::new(plant, &operator, delay, 100);
        region.expect_err("refused").to_string()
    };
    let words = "delay of a region 65 samples is not from 0 to 64 samples";
    assert_eq!(refused(1.0, 65), words);
    let words = "order of a region 1e-9 is not 0, or from 1e-6 to 2";
    assert_eq!(refused(1e-9, 0), words);
}

/// A fifth of the cases; all where `CAMPAIGN_CASES` is set.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_region_hangs_or_holds_a_nan() {
    let is_campaign = std::env::var_os("CAMPAIGN_CASES").is_some();
    let every = if is_campaign { 1 } else { 5 };
    let mut case = 0;
    let schemes = "exact muir:3 grunwald:100 tustin-muir:9 oustaloup:5:0.5:200 full:1e-4 piecewise-linear:1e-4 full-bdf2:1e-4";
    for scheme in schemes.split(' ') {
        for order in [0.0, 1e-3, 0.5, 1.0, 1.5, 2.0] {
            let operator = operator(scheme, order);
            let devices = [
                (0.0, 0.0),
                (1e-4, 0.0),
                (0.1, 1e-6),
                (0.0, 10.0),
                (10.0, 0.0),
                (1000.0, 5.0),
            ];
            for (delta, gamma) in devices {
                for delay in [0, 3, 64] {
                    case += 1;
                    if case % every != 0 {
                        continue;
                    }
                    let region = region_of(&operator, delta, gamma, delay);
                    let Some(area) = region.bounded() else {
                        continue;
                    };
                    let what =
                        format!("{scheme}, μ = {order}, δ = {delta}, γ = {gamma}, d = {delay}");
                    let most = area.alpha_max * area.beta_max * (1.0 + 1e-9);
                    assert!(area.area > 0.0 && area.area <= most, "{what}");
                    assert!(area.alpha_max > 0.0 && area.beta_max > 0.0, "{what}");
                    assert!(area.alpha_max <= area.searched, "{what}");
                    assert!(area.searched.is_finite(), "{what}");
                    let points = area.polygons.iter().flat_map(|polygon| &polygon.points);
                    for point in points {
                        assert!(point.alpha >= 0.0 && point.alpha.is_finite(), "{what}");
                        assert!(point.beta >= 0.0 && point.beta.is_finite(), "{what}");
                        let on_circle = |theta: f64| (0.0..=PI).contains(&theta);
                        assert!(point.theta.is_none_or(on_circle), "{what}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_loop_without_stiffness_is_stable_only_if_its_damper_holds_still() {
    // (1 − w)^μ is 0 at rest: α = 0 leaves a pole at z = 1. The third Muir polynomial is not.
    let exact = region_of(&operator("exact", 0.5), 0.1, 0.0, 0);
    assert!(!exact.contains(0.0, 0.5) && exact.contains(1e-6, 0.5));
    let muir = region_of(&operator("muir:3", 0.5), 0.1, 0.0, 0);
    assert!(muir.contains(0.0, 0.5) && !muir.contains(0.0, 0.0));
    // With a hand it is the hand that holds it.
    let held = region_of(&operator("exact", 0.5), 0.1, 0.1, 0);
    assert!(held.contains(0.0, 0.5) && held.contains(0.0, 0.0));
}

/// (100 − 10s)/(s + 10)², whose answer to a step begins below 0.
#[test]
fn a_plant_that_first_moves_the_other_way_has_no_box_for_that_reason() {
    let (a, c) = ([0.0, 1.0, -100.0, -20.0], [100.0, -10.0]);
    for delay in [0.0, 0.5] {
        let path = path(delay, 0.0);
        let plant = SampledPlant::linear(&a, &[0.0, 1.0], &c, 1e-3, 1.0, path).expect("a plant");
        let refused = StabilityRegion::new(plant, &operator("exact", 1.0), 0, 500);
        assert_says(&refused.expect_err("refused").to_string(), "the other way");
    }
}
