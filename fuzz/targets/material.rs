//! A material file of any text: what is accepted has a tissue of its own numbers.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_tissue::Material;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    match Material::parse(Path::new("lab/fuzz.toml"), text) {
        Ok(material) => {
            assert!(material.elastic_modulus_pa.is_finite() && material.elastic_modulus_pa >= 0.0);
            assert!(
                material.viscosity_pa_s_alpha.is_finite() && material.viscosity_pa_s_alpha >= 0.0
            );
            assert!((0.0..=1.0).contains(&material.order));
            assert_eq!(material.text, text);
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
        }
    }
});
