//! Operators as lists of numbers.

use fracdiff::portable::{Form, ListError};
use fracdiff::{
    Differintegrator, FullMemory, Operator, Order, PortableOperator, Real, Scheme, Seconds,
};

type Portable<F> = PortableOperator<F, 256, 48, 16>;

const SCHEMES: [&str; 9] = [
    "grunwald:1",
    "grunwald:17",
    "grunwald:256",
    "muir:3",
    "tustin-muir:9",
    "oustaloup:9:0.01:100",
    "full:1e-3",
    "full",
    "piecewise-linear",
];

fn operator<F: Real>(scheme: &str, mu: f64) -> Operator<F> {
    let scheme: Scheme = scheme.parse().expect("valid");
    let order = Order::new(mu).expect("valid");
    scheme.build(order, Seconds(1e-3), 2e5).expect("valid")
}

/// A signal with jumps, rests and all signs, the same every time.
fn signal(n: u32) -> f64 {
    let phase = f64::from(n) * 0.0137;
    let jump = if n % 300 < 150 { 1.0 } else { -0.25 };
    1e-3 * (phase.sin() + jump)
}

fn agrees<F: Real>(scheme: &str, mu: f64) {
    let original = operator::<F>(scheme, mu);
    let list = original.list().expect("portable");
    let copy = Portable::<F>::new(list.form, list.integer, &list.values)
        .unwrap_or_else(|error| panic!("{scheme} {mu}: {error}"));
    assert_eq!(
        copy.memory_length(),
        original.memory_length(),
        "{scheme} {mu}"
    );
    let values = (0..).map_while(|index| copy.value(index));
    assert_eq!(values.collect::<Vec<F>>(), list.values, "{scheme} {mu}");
    let (mut one, mut other) = (original.at_rest(), copy.at_rest());
    for n in 0..3000 {
        let x = F::from_f64(signal(n));
        let (want, have) = (original.step(&mut one, x), copy.step(&mut other, x));
        assert_eq!(
            want.to_f64().to_bits(),
            have.to_f64().to_bits(),
            "{scheme} {mu} {n}"
        );
    }
}

#[test]
fn a_list_makes_the_same_operator_bit_for_bit() {
    for scheme in SCHEMES {
        for mu in [-2.0, -1.3, -1.0, -0.5, 0.0, 0.2247, 0.5, 1.0, 1.5, 2.0] {
            agrees::<f32>(scheme, mu);
            agrees::<f64>(scheme, mu);
        }
    }
}

#[test]
fn a_full_memory_from_its_list_has_its_bits() {
    for mu in [-1.3, 0.2247, 1.5] {
        let original = operator::<f32>("full", mu);
        let list = original.list().expect("portable");
        let copy = FullMemory::<f32, 16, 24>::from_list(list.integer, &list.values).expect("fits");
        let (mut one, mut other) = (original.at_rest(), copy.at_rest());
        for n in 0..1000 {
            let x = signal(n) as f32;
            assert_eq!(
                original.step(&mut one, x),
                copy.step(&mut other, x),
                "{mu} {n}"
            );
        }
    }
    type Full = FullMemory<f32, 16, 8>;
    let refused = Full::from_list(3, &[0.0; 16]);
    assert!(matches!(refused, Err(ListError::IntegerPart(3))));
    assert!(matches!(
        Full::from_list(0, &[0.0; 34]),
        Err(ListError::Count { .. })
    ));
    let refused = Full::from_list(0, &[f32::NAN; 16]);
    assert!(matches!(refused, Err(ListError::Value { index: 0, .. })));
}

#[test]
fn a_recursion_of_free_coefficients_solves_its_difference_equation() {
    // y[n] = g·x[n] + Σ_i (b_i·x[n−i] − a_i·y[n−i]); then one whose b are g·a with every other sign turned, but for one bit.
    let mirrored = [2.0, 1.0, -0.5, 0.4, 0.2];
    let mut nearly = mirrored;
    nearly[3] = 0.4_f64.next_up();
    for list in [[1.5, 0.7, -0.9, 0.25, 0.3], nearly, mirrored] {
        let operator = Portable::<f64>::new(Form::Recursion, 0, &list).expect("valid");
        let values = (0..).map_while(|index| operator.value(index));
        assert_eq!(values.collect::<Vec<f64>>(), list);
        let [g, b1, a1, b2, a2] = list;
        let (mut history, mut before) = (operator.at_rest(), [[0.0; 2]; 2]);
        for n in 0..3000 {
            let x = signal(n);
            let [[x1, y1], [x2, y2]] = before;
            let want = g * x + (b1 * x1 - a1 * y1) + (b2 * x2 - a2 * y2);
            let y = operator.step(&mut history, x);
            assert!((y - want).abs() <= 1e-16, "{list:?} {n}: {y}, {want}");
            before = [[x, y], [x1, y1]];
        }
        let mut history = operator.settled(0.7).expect("it settles");
        let want = 0.7 * (g + b1 + b2) / (1.0 + a1 + a2);
        for _ in 0..300 {
            let y = operator.step(&mut history, 0.7);
            assert!((y - want).abs() <= 1e-14, "{list:?}: {y}, {want}");
        }
    }
}

#[test]
fn a_list_that_is_no_operator_is_refused() {
    type P = Portable<f32>;
    let zeros = [0.0; 400];
    let count = |form, count: usize| P::new(form, 0, &zeros[..count]);
    let wrong = |result| matches!(result, Err(ListError::Count { .. }));
    for (form, counts) in [
        (Form::Taps, [0, 257]),
        (Form::Modes, [15, 17]),
        (Form::Modes, [0, 16 + 98]),
        (Form::Recursion, [1, 2]),
        (Form::Recursion, [0, 35]),
    ] {
        for n in counts {
            assert!(wrong(count(form, n)), "{form:?} {n}");
        }
    }
    assert!(matches!(
        P::new(Form::Taps, 1, &[1.0]),
        Err(ListError::IntegerPart(1))
    ));
    assert!(matches!(
        P::new(Form::Modes, 3, &[1.0; 16]),
        Err(ListError::IntegerPart(3))
    ));
    for bad in [f32::NAN, f32::INFINITY] {
        let refused = P::new(Form::Taps, 0, &[1.0, bad]);
        assert!(matches!(refused, Err(ListError::Value { index: 1, .. })));
    }
    let mut modes = [0.0; 18];
    for bad in [0.0, -0.5, 1.5] {
        modes[16] = bad;
        let refused = P::new(Form::Modes, 0, &modes);
        assert!(matches!(refused, Err(ListError::Decay { index: 16, .. })));
    }
}

#[test]
fn the_history_of_another_form_gives_nan_and_no_panic() {
    let taps = Portable::<f32>::new(Form::Taps, 0, &[1.0, 0.5]).expect("valid");
    let recursion = Portable::<f32>::new(Form::Recursion, 0, &[1.0, 0.5, 0.1]).expect("valid");
    let mut history = taps.at_rest();
    recursion.advance(&mut history, 1.0);
    assert!(recursion.output(&history, 1.0).is_nan());
    assert_eq!(taps.output(&history, 1.0), 1.0);
}

/// The example in Python, which is not in the package of this crate.
fn example() -> Option<String> {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/protocol/full_memory.py"
    );
    let read = std::fs::read_to_string(file);
    if let Err(why) = &read {
        let why = format!("skipped: {file}: {why}");
        assert!(std::env::var_os("REQUIRE_ALL_CHECKS").is_none(), "{why}");
        println!("{why}");
    }
    read.ok()
}

/// Its `full_memory`, run by Python: integer part and coefficients.
fn example_list(code: &str, order: f64) -> (i8, Vec<f64>) {
    let call = format!("i, c = full_memory({order}, 1e-3, 1e-6, 200.0)\nprint(i, *c)");
    let output = std::process::Command::new("python3")
        .args(["-c", &format!("{code}\n{call}")])
        .output()
        .expect("python3 is installed");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let text = String::from_utf8(output.stdout).expect("text");
    let mut numbers = text.split_whitespace();
    let integer = numbers.next().expect("an integer part");
    let values = numbers.map(|number| number.parse().expect("a number"));
    (integer.parse().expect("whole"), values.collect())
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_list_that_the_example_makes_is_a_full_memory() {
    let Some(code) = example() else {
        return;
    };
    for mu in [0.05, 0.2247, 0.5, 0.9, 1.0, 1.5, -0.5, -1.4] {
        let (integer, values) = example_list(&code, mu);
        let made = Portable::<f64>::new(Form::Modes, integer, &values)
            .unwrap_or_else(|error| panic!("{mu}: {error}"));
        let exact = operator::<f64>("full:1e-10", mu);
        assert_eq!(integer, exact.list().expect("portable").integer, "{mu}");
        let (mut one, mut other) = (made.at_rest(), exact.at_rest());
        let mut largest = 0.0_f64;
        for n in 0..200_000 {
            // Pressed in for a second, then held: one direction, so the tolerance is of the output itself below order 1.
            let x = 1e-2 * (f64::from(n) * 1e-3).min(1.0);
            let (have, want) = (made.step(&mut one, x), exact.step(&mut other, x));
            largest = largest.max(want.abs());
            let scale = if mu <= 1.0 { want.abs() } else { largest };
            assert!(
                (have - want).abs() <= 1.1e-6 * scale,
                "{mu} {n}: {have:e} {want:e}"
            );
        }
    }
}

#[test]
fn an_operator_that_is_replaced_in_its_place_is_the_new_one_and_its_history_at_rest() {
    // From each form to each, order by order.
    let lists: Vec<_> = [0.2247, -0.6, 1.3]
        .iter()
        .flat_map(|&mu| SCHEMES.map(|scheme| operator::<f32>(scheme, mu).list().expect("portable")))
        .collect();
    let mut operator = Portable::<f32>::SILENT;
    let mut history = operator.at_rest();
    assert_eq!(
        (operator.step(&mut history, 3.0), operator.value(0)),
        (0.0, None)
    );
    for step in 0..lists.len() {
        for from in [0, 5, 7] {
            for list in [&lists[from * step % lists.len()], &lists[step]] {
                operator
                    .replace(list.form, list.integer, &list.values)
                    .expect("a list");
                let made = Portable::<f32>::new(list.form, list.integer, &list.values);
                assert_eq!(Ok(&operator), made.as_ref());
                operator.rest(&mut history);
                assert_eq!(history, operator.at_rest());
                for n in 0..20 {
                    operator.step(&mut history, signal(n) as f32);
                }
            }
        }
    }
}

#[test]
fn a_refused_list_leaves_the_operator_as_it_is() {
    for scheme in SCHEMES {
        let list = operator::<f32>(scheme, 0.4).list().expect("portable");
        let before = Portable::<f32>::new(list.form, list.integer, &list.values).expect("a list");
        let mut after = before.clone();
        let mut broken = list.values.clone();
        *broken.last_mut().expect("a value") = f32::NAN;
        for (form, integer, values) in [
            (list.form, list.integer, broken.as_slice()),
            (list.form, 3, list.values.as_slice()),
            (Form::Taps, 1, list.values.as_slice()),
            (Form::Taps, 0, &[]),
            (Form::Taps, 0, &[1.0; 257]),
            (Form::Modes, 0, &[1.0; 15]),
            (Form::Modes, 0, &[2.0; 18]),
            (Form::Recursion, 0, &[1.0; 34]),
        ] {
            let refused = after.replace(form, integer, values).expect_err("no list");
            let made = Portable::<f32>::new(form, integer, values).expect_err("no list");
            // A NaN in an error is not equal to itself.
            assert_eq!(format!("{refused:?}"), format!("{made:?}"), "{scheme}");
            assert_eq!(
                format!("{:?}", Portable::<f32>::check(form, integer, values)),
                format!("{:?}", Err::<(), _>(made))
            );
            assert_eq!(after, before, "{scheme}");
        }
    }
}
