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
            assert_eq!(material.text, text);
            for (parameter, value) in material.model.parameters() {
                assert!(parameter.range.contains(value), "{value}");
            }
            let back = Material::parse(Path::new("lab/back.toml"), &material.to_toml());
            let back = back.expect("what is written is read");
            assert_eq!(back.model, material.model);
            assert_eq!(back.to_toml(), material.to_toml());
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
        }
    }
});
