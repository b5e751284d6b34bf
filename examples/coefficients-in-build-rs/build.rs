//! Designs the operator where there is room, and writes its coefficients as Rust.

use fracdiff::{Order, Scheme, Seconds};
use std::error::Error;
use std::path::Path;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    // D^0.2247 at 1 kHz, within 1e-6 for 200 s.
    let scheme: Scheme = "full:1e-6".parse()?;
    let operator = scheme.build::<f32>(Order::new(0.2247)?, Seconds(1e-3), 2e5)?;
    let list = operator.list().expect("a full memory is a list");
    // 16 taps, then two numbers a mode; room for modes comes in eights.
    let modes = ((list.values.len() - 16) / 2).next_multiple_of(8);
    let code = format!(
        "const MODES: usize = {modes};\nconst INTEGER: i8 = {};\nstatic COEFFICIENTS: [f32; {}] = {:?};\n",
        list.integer,
        list.values.len(),
        list.values,
    );
    let out = env::var("OUT_DIR")?;
    fs::write(Path::new(&out).join("coefficients.rs"), code)?;
    fs::copy("memory.x", Path::new(&out).join("memory.x"))?;
    println!("cargo::rustc-link-search={out}");
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-changed=build.rs");
    Ok(())
}
