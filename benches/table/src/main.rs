//! Rust's side of `docs/performance.md`: `table OUT BUILD` appends times to OUT/results.jsonl and writes the outputs of the
//! operators. See `run`, which does it all.

mod kernels;
mod whole;

use biquad::{Biquad as _, Coefficients, DirectForm2Transposed};
use cpu_time::ThreadTime;
use dsp_process::SplitProcess as _;
use fracdiff::full_memory::{Design, FullMemory, Kernel};
use fracdiff::{
    Band, Differintegrator, Order, Oustaloup, Real, Seconds, ShortMemory, TustinMuir, batch::Batch,
};
use oxictl::pid::fractional::grunwald::GrunwaldLeibniz;
use oxictl::pid::fractional::tustin_approx::TustinFrac;
use std::error::Error;
use std::fs::{File, OpenOptions};
use std::hint::black_box;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

const SAMPLES: usize = 200_000;
/// Two periods of the longest block (2048) of a partitioned memory of 65 536 samples.
const BATCH: usize = 4096;
const RUNS: usize = 5;
const MU: f64 = 0.2247;
const T: f64 = 1e-3;
const BAND: Band = Band {
    low_hz: 0.01,
    high_hz: 100.0,
};
const SECTIONS: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, build] = arguments.as_slice() else {
        return Err("table OUT BUILD".into());
    };
    let bench = Bench {
        folder: PathBuf::from(folder),
        build: build.clone(),
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    bench.line(&format!("{{\"kernels\": \"{}\"}}", kernels::digest(&root)?))?;
    let (order, t) = (Order::new(MU)?, Seconds(T));
    bench.operator::<f32, _>("FullMemory 1e-6, 200 s", &full::<f32>(1e-6)?)?;
    bench.operator::<f64, _>("FullMemory 1e-6, 200 s", &full::<f64>(1e-6)?)?;
    bench.operator::<f64, _>("FullMemory 1e-9, 200 s", &full::<f64>(1e-9)?)?;
    let straight = Design::<16, 48>::pruned(Kernel::PiecewiseLinear, order, 1e-6, 2.1e5)?;
    let straight = FullMemory::<f64, 16, 48>::new(&straight, t)?;
    bench.operator::<f64, _>("FullMemory 1e-6, piecewise linear", &straight)?;
    bench.operator(
        "ShortMemory 1024",
        &ShortMemory::<f32, 1024>::new(order, t)?,
    )?;
    bench.operator(
        "ShortMemory 1024",
        &ShortMemory::<f64, 1024>::new(order, t)?,
    )?;
    bench.operator("TustinMuir 9", &TustinMuir::<f32, 9>::new(order, t)?)?;
    bench.operator(
        "Oustaloup 9",
        &Oustaloup::<f32, 16>::new(order, SECTIONS, BAND, t)?,
    )?;
    let x: Vec<f64> = input();
    bench.record("batch, full history", 100 * SAMPLES, || {
        Batch::full_history(Kernel::Grunwald, order, t).map(|sum| sum.run(&x))
    })?;
    let million: Vec<f64> = (0..1_000_000).map(sample).collect();
    bench.record("batch, full history, 10^6 samples", 100_000_000, || {
        Batch::full_history(Kernel::Grunwald, order, t).map(|sum| sum.run(&million))
    })?;
    whole::controllers(&bench)?;
    whole::analyses(&bench)?;
    peers(&bench)
}

fn full<F: Real>(tolerance: f64) -> Result<FullMemory<F, 16, 48>, Box<dyn Error>> {
    let design = Design::pruned(Kernel::Grunwald, Order::new(MU)?, tolerance, 2.1e5)?;
    Ok(FullMemory::new(&design, Seconds(T))?)
}

/// The other crates.
fn peers(bench: &Bench) -> Result<(), Box<dyn Error>> {
    let mut ring = GrunwaldLeibniz::<f32, 1024>::new(MU as f32, T as f32).map_err(debug)?;
    let bytes = size_of_val(&ring);
    bench.filter("oxictl GrunwaldLeibniz 1024, f32", bytes, || {
        ring.reset();
        let mut ring = ring.clone();
        move |x| ring.update(x)
    })?;
    let mut tustin = TustinFrac::<f32, 9>::new(MU as f32, T as f32).map_err(debug)?;
    let bytes = size_of_val(&tustin);
    bench.filter("oxictl TustinFrac 9, f32", bytes, || {
        tustin.reset();
        let mut tustin = tustin.clone();
        move |x| tustin.update(x)
    })?;
    // The sections of our Oustaloup filter of the same degree and band, in pairs; their coefficients are ours.
    let sections = sections();
    let filters: Vec<DirectForm2Transposed<f32>> = sections
        .iter()
        .map(|&([b0, b1, b2], [a1, a2])| {
            let [a1, a2, b0, b1, b2] = [a1, a2, b0, b1, b2].map(|c| c as f32);
            DirectForm2Transposed::new(Coefficients { a1, a2, b0, b1, b2 })
        })
        .collect();
    let bytes = size_of_val(filters.as_slice());
    bench.filter("biquad, Oustaloup 9 in 5 sections, f32", bytes, || {
        let mut filters: [_; 5] = std::array::from_fn(|i| filters[i]);
        move |x| filters.iter_mut().fold(x, |x, filter| filter.run(x))
    })?;
    let filters: Vec<idsp::iir::Biquad<f32>> = sections
        .iter()
        .map(|&([b0, b1, b2], [a1, a2])| [[b0, b1, b2], [1.0, a1, a2]].map(|c| c.map(|c| c as f32)))
        .map(idsp::iir::Biquad::from)
        .collect();
    let bytes = size_of_val(filters.as_slice()) + 5 * 8;
    bench.filter("idsp, Oustaloup 9 in 5 sections, f32", bytes, || {
        let filters: [_; 5] = std::array::from_fn(|i| filters[i].clone());
        let mut states: [idsp::iir::DirectForm2Transposed<f32>; 5] = Default::default();
        move |x| {
            let sections = filters.iter().zip(&mut states);
            sections.fold(x, |x, (filter, state)| filter.process(state, x))
        }
    })?;
    Ok(())
}

fn debug(error: impl std::fmt::Debug) -> String {
    format!("{error:?}")
}

/// (b, a₁, a₂) of five biquads: the nine zeros and poles of an Oustaloup filter by Tustin's rule.
fn sections() -> Vec<([f64; 3], [f64; 2])> {
    let (low, high) = (BAND.low_hz, BAND.high_hz);
    let tau = 2.0 * std::f64::consts::PI;
    let corner = |i: usize, sign: f64| {
        let share = (2.0 * i as f64 - 1.0 + sign * MU) / (2.0 * SECTIONS as f64);
        tau * low * (high / low).powf(share)
    };
    let gain = (tau * high).powf(MU);
    let first: Vec<[f64; 3]> = (1..=SECTIONS)
        .map(|i| {
            // (s + z)/(s + p), s = 2/T (1 − w)/(1 + w): ((k + z) + (z − k)w)/((k + p) + (p − k)w)
            let (k, z, p) = (2.0 / T, corner(i, -1.0), corner(i, 1.0));
            [(k + z) / (k + p), (z - k) / (k + p), (p - k) / (k + p)]
        })
        .collect();
    let mut pairs: Vec<_> = first
        .chunks(2)
        .map(|pair| match *pair {
            [[b0, b1, a1], [d0, d1, c1]] => {
                ([b0 * d0, b0 * d1 + b1 * d0, b1 * d1], [a1 + c1, a1 * c1])
            }
            [[b0, b1, a1]] => ([b0, b1, 0.0], [a1, 0.0]),
            _ => ([1.0, 0.0, 0.0], [0.0, 0.0]),
        })
        .collect();
    pairs[0].0 = pairs[0].0.map(|b| gain * b);
    pairs
}

/// 0 to 1 in the first second, then held.
fn sample(n: usize) -> f64 {
    (n as f64 * T).min(1.0)
}

fn input<F: Real>() -> Vec<F> {
    (0..SAMPLES).map(|n| F::from_f64(sample(n))).collect()
}

struct Bench {
    folder: PathBuf,
    build: String,
}

impl Bench {
    fn operator<F: Real, O: Differintegrator<F>>(
        &self,
        name: &str,
        operator: &O,
    ) -> Result<(), Box<dyn Error>> {
        let precision = if size_of::<F>() == 4 { "f32" } else { "f64" };
        let bytes = size_of::<O>() + size_of::<O::History>();
        self.filter(&format!("{name}, {precision}"), bytes, || {
            let mut history = operator.at_rest();
            move |x| operator.step(&mut history, x)
        })
    }

    /// Runs a filter over the input, and keeps the shortest CPU time a batch took.
    fn filter<F: Real, S: FnMut(F) -> F>(
        &self,
        name: &str,
        bytes: usize,
        mut fresh: impl FnMut() -> S,
    ) -> Result<(), Box<dyn Error>> {
        let x = input::<F>();
        let mut y = vec![F::ZERO; x.len()];
        let mut least = f64::INFINITY;
        for _ in 0..RUNS {
            let mut step = fresh();
            for (x, y) in x.chunks(BATCH).zip(y.chunks_mut(BATCH)) {
                let start = ThreadTime::now();
                for (y, &x) in y.iter_mut().zip(x) {
                    *y = step(black_box(x));
                }
                black_box(&mut *y);
                let ns = start.elapsed().as_nanos() as f64 / x.len() as f64;
                least = if x.len() == BATCH {
                    least.min(ns)
                } else {
                    least
                };
            }
        }
        let y: Vec<f64> = y.into_iter().map(Real::to_f64).collect();
        self.write(name, least, bytes, &y)
    }

    /// A whole record at once.
    fn record<E: Error + 'static>(
        &self,
        name: &str,
        bytes: usize,
        run: impl Fn() -> Result<Vec<f64>, E>,
    ) -> Result<(), Box<dyn Error>> {
        let (mut least, mut y) = (f64::INFINITY, Vec::new());
        for _ in 0..RUNS {
            let start = ThreadTime::now();
            y = black_box(run()?);
            least = least.min(start.elapsed().as_nanos() as f64 / y.len() as f64);
        }
        self.write(&format!("{name}, f64"), least, bytes, &y)
    }

    /// The output of a filter, and a line for its time.
    fn write(&self, name: &str, ns: f64, bytes: usize, y: &[f64]) -> Result<(), Box<dyn Error>> {
        let slug = name.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        let mut file = BufWriter::new(File::create(self.folder.join(format!("{slug}.f64")))?);
        for y in y {
            file.write_all(&y.to_le_bytes())?;
        }
        file.flush()?;
        self.line(&format!(
            "{{\"name\": \"{name}\", \"build\": \"{}\", \"ns\": {ns}, \"file\": \"{slug}.f64\", \"bytes\": {bytes}}}",
            self.build
        ))
    }

    /// A time alone.
    fn time(&self, name: &str, ns: f64) -> Result<(), Box<dyn Error>> {
        let build = &self.build;
        self.line(&format!(
            "{{\"name\": \"{name}\", \"build\": \"{build}\", \"ns\": {ns}}}"
        ))
    }

    fn line(&self, text: &str) -> Result<(), Box<dyn Error>> {
        let results = self.folder.join("results.jsonl");
        let mut lines = OpenOptions::new().create(true).append(true).open(results)?;
        Ok(writeln!(lines, "{text}")?)
    }
}
