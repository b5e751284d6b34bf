//! Models fitted to records: measured ones, and synthetic ones whose truth is known.
#![cfg(feature = "identify")]

use haptic_tissue::identify::{Candidate, Options, Record, identify};

fn fish() -> Record {
    let rows = include_str!("../records/fish-muscle-relaxation.tsv").lines().skip(1);
    let (time, modulus) = rows
        .map(|row| {
            let (time, modulus) = row.split_once('\t').expect("two columns");
            (time.parse::<f64>().expect("time"), modulus.parse::<f64>().expect("modulus"))
        })
        .unzip();
    Record::relaxation(time, modulus).expect("valid")
}

#[test]
fn fish_muscle_is_a_fractional_maxwell_model() {
    for candidate in Candidate::ALL {
        let options = Options { candidates: vec![candidate], ..Options::default() };
        let start = std::time::Instant::now();
        let found = identify(&fish(), &options, &|_| ()).expect("converges");
        println!("{:?} {:#?}", start.elapsed(), (candidate, &found.fits[0].parameters, found.fits[0].rms, found.fits[0].bic, &found.warnings));
    }
}
