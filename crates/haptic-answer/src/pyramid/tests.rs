use super::*;
use proptest::prelude::*;

const SMALL: PyramidSize<'static> = PyramidSize {
    channels: 2,
    follows: &[],
    samples: 64,
    entries: 32,
    coarser: 3,
};

/// Least and largest by looking at every sample.
fn brute_force(samples: &[[f32; 2]], channel: usize, ticks: std::ops::Range<u64>) -> (f32, f32) {
    let end = (ticks.end as usize).min(samples.len());
    let part = samples[ticks.start as usize..end]
        .iter()
        .map(|sample| sample[channel]);
    let none = (f32::NAN, f32::NAN);
    part.fold(none, |(least, largest), number| {
        (least.min(number), largest.max(number))
    })
}

fn filled(samples: &[[f32; 2]]) -> Pyramid {
    let mut pyramid = Pyramid::new(SMALL);
    for sample in samples {
        pyramid.push(sample);
    }
    pyramid
}

/// The first tick that any level still has.
fn first_tick(pyramid: &Pyramid) -> u64 {
    let firsts = pyramid.levels.iter();
    let firsts = firsts.map(|level| level.first_tick(pyramid.made));
    firsts.min().expect("levels")
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![8 => -1e3_f32..1e3, 1 => Just(f32::NAN), 1 => Just(0.0)]
}

proptest! {
    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn columns_hold_least_and_largest_of_every_sample_of_theirs(
        samples in prop::collection::vec([number(), number()], 1..3000),
        start in 0_u64..3000,
        length in 1_u64..3000,
        columns in 1_u32..200,
    ) {
        let pyramid = filled(&samples);
        let span = ViewSpan::new(start, start + length, columns);
        let have = pyramid.columns(span);
        let made = samples.len() as u64;
        prop_assert!(have.first_tick.is_multiple_of(have.width));
        // The span as far as it is remembered lies within the columns.
        let (first, end) = (start.max(first_tick(&pyramid)).min(made), (start + length).min(made));
        if first < end {
            prop_assert!(have.first_tick <= first);
            prop_assert!(have.first_tick + have.count as u64 * have.width >= end);
        }
        for channel in 0..2 {
            for column in 0..have.count {
                let begin = have.first_tick + column as u64 * have.width;
                // What came before what the level remembers may be forgotten in the first column alone.
                if begin < first_tick(&pyramid) {
                    continue;
                }
                let mut want = brute_force(&samples, channel, begin..begin + have.width);
                if column == 0 && begin < first {
                    // Of the first column a finer level may have forgotten the beginning.
                    want = brute_force(&samples, channel, first..begin + have.width);
                    prop_assert!(want.0.is_nan() || have.least(channel)[0] <= want.0);
                    prop_assert!(want.1.is_nan() || have.largest(channel)[0] >= want.1);
                    continue;
                }
                prop_assert_eq!(have.least(channel)[column].to_bits(), want.0.to_bits());
                prop_assert_eq!(have.largest(channel)[column].to_bits(), want.1.to_bits());
            }
        }
    }

    #[test]
    fn a_view_within_what_is_remembered_is_as_fine_as_asked_or_a_quarter_coarser(
        made in 1000_u64..5000,
        length in 1_u64..60,
        columns in 1_u32..200,
    ) {
        let pyramid = filled(&vec![[1.0, 2.0]; made as usize]);
        let have = pyramid.columns(ViewSpan::new(made - length, made, columns));
        let wanted = length.div_ceil(u64::from(columns));
        prop_assert!(have.width >= wanted && 4 * have.width <= 5 * wanted.max(1) + 4);
        // At most one more, where the first begins before the span.
        prop_assert!(have.count <= columns as usize + 1);
    }
}

#[test]
fn a_single_peak_is_seen_from_every_distance() {
    let mut samples = vec![[0.0, 0.0]; 600];
    samples[577] = [9.0, -9.0];
    let pyramid = filled(&samples);
    for (start, columns) in [(560, 40), (500, 7), (300, 10), (0, 3), (0, 1)] {
        let have = pyramid.columns(ViewSpan::new(start, 600, columns));
        let column = ((577 - have.first_tick) / have.width) as usize;
        let peak = (have.largest(0)[column], have.least(1)[column]);
        assert_eq!(peak, (9.0, -9.0));
        let peaks = have.largest(0).iter().filter(|&&peak| peak > 0.0);
        assert_eq!(peaks.count(), 1, "from {start} in {columns}");
    }
}

proptest! {
    #[test]
    fn a_pair_is_two_numbers_of_one_sample(
        samples in prop::collection::vec([number(), number()], 1..1500),
        length in 1_u64..1500,
        columns in 1_u32..100,
    ) {
        let mut pyramid = Pyramid::new(PyramidSize { channels: 3, follows: &[1], ..SMALL });
        for [at, force] in &samples {
            pyramid.push(&[*at, *force, *at]);
        }
        let made = samples.len() as u64;
        let have = pyramid.columns(ViewSpan::new(made.saturating_sub(length), made, columns));
        for column in 0..have.count {
            for (at, force) in [(have.least(2)[column], have.least(1)[column]), (have.largest(2)[column], have.largest(1)[column])] {
                let pair = |sample: &&[f32; 2]| [sample[0].to_bits(), sample[1].to_bits()] == [at.to_bits(), force.to_bits()];
                prop_assert!(force.is_nan() || samples.iter().any(|sample| pair(&sample)), "{at} {force}");
            }
        }
    }
}

#[test]
fn what_is_forgotten_in_full_is_drawn_from_a_coarser_level() {
    let samples: Vec<_> = (0..1000).map(|n| [n as f32, -(n as f32)]).collect();
    let pyramid = filled(&samples);
    assert_eq!(pyramid.levels[0].first_tick(1000), 1000 - 64);
    // Level 2, entries of 16, reaches back 32 of them: not to 100; level 3 does, all of it.
    let have = pyramid.columns(ViewSpan::new(100, 200, 100));
    assert_eq!((have.width, have.first_tick), (64, 64));
    assert_eq!((have.least(0)[0], have.largest(0)[0]), (64.0, 127.0));
}

#[test]
fn memory_does_not_grow_and_nothing_is_left_after_clear() {
    let mut pyramid = filled(&[[1.0, 2.0]; 5000]);
    assert_eq!(pyramid.made(), 5000);
    pyramid.clear();
    assert_eq!((pyramid.made(), first_tick(&pyramid)), (0, 0));
    assert_eq!(pyramid.columns(ViewSpan::new(0, 100, 10)).count, 0);
    pyramid.push(&[3.0]);
    let have = pyramid.columns(ViewSpan::new(0, 100, 10));
    assert_eq!((have.count, have.least(0)[0]), (1, 3.0));
    assert!(have.least(1)[0].is_nan(), "a channel that is missing");
}

#[test]
fn samples_are_given_as_far_as_they_are_remembered() {
    let samples: Vec<_> = (0..100).map(|n| [n as f32, 0.0]).collect();
    let pyramid = filled(&samples);
    let mut out = Vec::new();
    assert_eq!(pyramid.samples_from(0, 0, &mut out), 36);
    assert_eq!((out.len(), out[0], out[63]), (64, 36.0, 99.0));
    assert_eq!(pyramid.samples_from(98, 0, &mut out), 98);
    assert_eq!(out, [98.0, 99.0]);
    assert_eq!(pyramid.samples_from(500, 0, &mut out), 100);
    assert!(out.is_empty());
}
