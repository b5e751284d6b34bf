//! Operators, maps and inputs whose outputs have the same bits on the target and on the host: compiled by both.

use super::lists::{self, List};
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc};
use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{
    Band, Differintegrator, FullMemory, MuirPolynomial, Order, Oustaloup, PortableOperator, Real,
    Seconds, ShortMemory, TustinMuir, portable::Form,
};
use haptic_loop::DepthMap;

const T: Seconds = Seconds(1e-3);
/// Integrals, the tissue's order, whole orders, and beyond one.
const ORDERS: [f64; 6] = [-1.3, -0.5, 0.2247, 0.5, 1.0, 1.5];
/// Orders of these whose modes are designed on the target too: it does some 10⁵ exponentials for each.
const DESIGNED: [f64; 3] = [-0.5, 0.2247, 1.5];
/// Longer than the longest finite memory, and long enough for slow modes to differ from rest.
const SAMPLES: u32 = 1500;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Room for every list, in either precision.
type Portable<F> = PortableOperator<F, 256, 48, 16>;

/// Sample n of a ramp to 1 mm, held, with noise of 1 µm: exact in `f64`, and rounded once to `f32`.
fn signal<F: Real>(n: u32) -> F {
    let ramp = f64::from(n.min(500)) * 2e-6;
    // Lehmer's generator with Park and Miller's multiplier of 1988, by the sample's number.
    let mut noise = u64::from(n) + 1;
    for _ in 0..3 {
        noise = noise * 48_271 % 0x7fff_ffff;
    }
    F::from_f64(ramp + noise as f64 * 4.66e-16)
}

/// CRC-32 over the outputs' bits, as `f64` (exact), little-endian.
fn digest<F: Real, O: Differintegrator<F>>(operator: &O) -> u32 {
    let mut history = operator.at_rest();
    let mut digest = CRC.digest();
    for n in 0..SAMPLES {
        let y = operator.step(&mut history, signal(n));
        digest.update(&y.to_f64().to_le_bytes());
    }
    digest.finalize()
}

/// CRC-32 over e of 4096 depths from 30 nm to 35 mm, each a 293rd part deeper than the one before.
fn digest_of_map<F: Real>(numbers: [f64; 8]) -> u32 {
    let map = DepthMap::<F>::new(numbers).expect("a map");
    let mut digest = CRC.digest();
    let (mut depth, step) = (F::from_f64(3e-8), F::from_f64(1.0 + 1.0 / 293.0));
    for _ in 0..4096 {
        digest.update(&map.at(depth).to_f64().to_le_bytes());
        depth = depth * step;
    }
    digest.finalize()
}

/// Maps of the depth: 1/s, c₀ to c₅, q, in 1/m.
const MAPS: [(&str, [f64; 8]); 4] = [
    ("sphere", [200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ("cone", [1e3, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
    ("layer", [200.0, 0.0, 1.0, 2.8, 8.0, 12.0, 3.8, 0.0]),
    // To x = 70, in four divisions by 16 in f64.
    ("stiffening", [200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2e3]),
];

/// Tells each case by its name.
pub(crate) fn digests(mut tell: impl FnMut(fmt::Arguments<'_>, u32)) {
    constructed::<f32>("f32", &mut tell);
    constructed::<f64>("f64", &mut tell);
    for mu in DESIGNED {
        let order = Order::new(mu).expect("valid");
        let design = Design::<16, 48>::closed_form(Kernel::Grunwald, order, 1e-6, 2e5)
            .expect("48 modes are enough");
        let single = FullMemory::<f32, 16, 48>::new(&design, T).expect("valid");
        let double = FullMemory::<f64, 16, 48>::new(&design, T).expect("valid");
        tell(format_args!("full f32 {mu}"), digest(&single));
        tell(format_args!("full f64 {mu}"), digest(&double));
    }
    for list in lists::all() {
        tell(
            format_args!("list {} f32", list.name),
            digest(&portable::<f32>(&list)),
        );
        tell(
            format_args!("list {} f64", list.name),
            digest(&portable::<f64>(&list)),
        );
    }
    for (name, numbers) in MAPS {
        tell(
            format_args!("map {name} f32"),
            digest_of_map::<f32>(numbers),
        );
        tell(
            format_args!("map {name} f64"),
            digest_of_map::<f64>(numbers),
        );
    }
}

fn constructed<F: Real>(precision: &str, tell: &mut impl FnMut(fmt::Arguments<'_>, u32)) {
    let band = Band {
        low_hz: 0.01,
        high_hz: 100.0,
    };
    for mu in ORDERS {
        let order = Order::new(mu).expect("valid");
        let mut case = |name: &str, digest| tell(format_args!("{name} {precision} {mu}"), digest);
        case(
            "grunwald:1",
            digest(&ShortMemory::<F, 1>::new(order, T).expect("valid")),
        );
        case(
            "grunwald:17",
            digest(&ShortMemory::<F, 17>::new(order, T).expect("valid")),
        );
        case(
            "grunwald:256",
            digest(&ShortMemory::<F, 256>::new(order, T).expect("valid")),
        );
        case(
            "muir:3",
            digest(&MuirPolynomial::<F, 3>::new(order, T).expect("valid")),
        );
        case(
            "muir:9",
            digest(&MuirPolynomial::<F, 9>::new(order, T).expect("valid")),
        );
        case(
            "tustin-muir:9",
            digest(&TustinMuir::<F, 9>::new(order, T).expect("valid")),
        );
        case(
            "oustaloup:9",
            digest(&Oustaloup::<F, 16>::new(order, 9, band, T).expect("valid")),
        );
    }
}

/// The operator of a list.
fn portable<F: Real>(list: &List) -> Portable<F> {
    let form = match list.form {
        "taps" => Form::Taps,
        "modes" => Form::Modes,
        _ => Form::Recursion,
    };
    let (values, count) = list.values();
    let values = values.map(|value| F::from_f64(value.into()));
    PortableOperator::new(form, list.integer, &values[..count]).expect("a good list")
}
