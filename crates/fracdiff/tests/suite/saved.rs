//! Histories as data: saved in the middle of a stream, restored, gone on with.

use crate::oracle::{SCHEMES, build, full, lively};
use fracdiff::full_memory::Kernel;
use fracdiff::portable::Form;
use fracdiff::{Differintegrator, Fir, FirHistory, OperatorHistory, PortableOperator, Real};
use serde::{Serialize, de::DeserializeOwned};

fn saved(history: &impl Serialize) -> Vec<u8> {
    postcard::to_extend(history, Vec::new()).expect("is data")
}

/// Runs to the middle, saves and restores there; both go on with the same bits.
#[track_caller]
fn goes_on<F: Real, O: Differintegrator<F>>(operator: &O, name: &str)
where
    O::History: Serialize + DeserializeOwned,
{
    let x = lively(4600);
    let mut kept = operator.at_rest();
    for (n, &x) in x.iter().enumerate() {
        // Two places: in the middle of blocks of 32, 256 and 2048, and at the end of one.
        if n == 1000 || n == 4096 {
            let bytes = saved(&kept);
            let mut restored: O::History = postcard::from_bytes(&bytes).expect("is a history");
            for (m, &x) in lively(600).iter().enumerate() {
                let (want, have) = (
                    operator.step(&mut kept, F::from_f64(x)),
                    operator.step(&mut restored, F::from_f64(x)),
                );
                assert_eq!(
                    want.to_f64().to_bits(),
                    have.to_f64().to_bits(),
                    "{name}, {m} after {n}"
                );
            }
        }
        operator.advance(&mut kept, F::from_f64(x));
    }
}

#[test]
fn a_history_saved_and_restored_goes_on_bit_for_bit() {
    for scheme in SCHEMES {
        for mu in [-1.4, 0.2247, 1.5] {
            goes_on(&build::<f32>(scheme, mu), scheme);
            goes_on(&build::<f64>(scheme, mu), scheme);
        }
    }
    goes_on(&full::<f32>(Kernel::Grunwald, 0.3, 1e-6), "full memory");
    goes_on(
        &Fir::<f64, 3>::from_slice(&[1.0, 2.0, 3.0]).expect("finite"),
        "coefficients",
    );
    type Portable = PortableOperator<f32, 8, 8, 8>;
    let recursion = Portable::new(Form::Recursion, 1, &[1.0, 0.5, -0.9, 0.25, 0.1]);
    goes_on(&recursion.expect("fits"), "portable");
}

#[test]
fn a_history_that_is_not_finite_stays_so() {
    let operator = build::<f64>("full:1e-6", 0.5);
    let mut history = operator.at_rest();
    operator.advance(&mut history, f64::NAN);
    let bytes = saved(&history);
    let restored: OperatorHistory<f64> = postcard::from_bytes(&bytes).expect("is a history");
    assert!(operator.output(&restored, 1.0).is_nan());
}

#[test]
fn data_that_is_no_history_is_an_error_or_runs_without_a_panic() {
    for scheme in SCHEMES {
        let operator = build::<f32>(scheme, 0.5);
        let mut history = operator.at_rest();
        for x in lively(700) {
            operator.advance(&mut history, x as f32);
        }
        let bytes = saved(&history);
        type Read = Result<OperatorHistory<f32>, postcard::Error>;
        for length in [0, 1, 2, bytes.len() / 2, bytes.len() - 1] {
            let read: Read = postcard::from_bytes(&bytes[..length]);
            assert!(read.is_err(), "{scheme}, {length} of {} bytes", bytes.len());
        }
        // Lengths and positions stand at the start, at the end, and between the lists: all of a short history, some of a long.
        let stride = 1 + bytes.len() / 2000;
        let places = (0..bytes.len())
            .step_by(stride)
            .chain(bytes.len().saturating_sub(40)..bytes.len());
        for place in places {
            for damage in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[place] ^= damage;
                let read: Read = postcard::from_bytes(&damaged);
                if let Ok(mut history) = read {
                    for x in lively(70) {
                        operator.step(&mut history, x as f32);
                    }
                }
            }
        }
    }
}

#[test]
fn positions_outside_a_history_and_other_lengths_are_refused() {
    // A full memory ends with the turn of its modes, S of the core, and what surrounds the core.
    let operator = full::<f32>(Kernel::Grunwald, 0.5, 1e-6);
    let mut bytes = saved(&operator.at_rest());
    let turn = 4 * (16 + 64 + 64);
    assert_eq!(bytes[turn], 0, "the turn at rest");
    type History = fracdiff::FullMemoryHistory<f32, 16, 64>;
    bytes[turn] = 63;
    assert!(postcard::from_bytes::<History>(&bytes).is_ok());
    bytes[turn] = 64;
    assert!(postcard::from_bytes::<History>(&bytes).is_err());
    // A list of two is no history of three.
    let two = Fir::<f32, 2>::from_slice(&[1.0, 1.0])
        .expect("finite")
        .at_rest();
    let bytes = saved(&two);
    assert!(postcard::from_bytes::<FirHistory<f32, 3>>(&bytes).is_err());
}
