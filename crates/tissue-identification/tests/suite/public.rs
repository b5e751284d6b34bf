//! Public records of others are fitted as well as `SciPy` fits them; they stay outside the repository.

use super::{one, read_public, understood};
use haptic_tissue::ModelKind;
use tissue_identification::TableDetails;

/// Root of the mean square of the logarithms at the best spring-pot of 40 starts, of `tests/golden/meaning/make_golden.py` with the
/// folder of the records. One of equal frequencies is among them.
const BEST: [(&str, f64); 6] = [
    ("polystyrene-relaxation-145C.csv", 0.231_204_699),
    ("polypropylene-relaxation.csv", 0.098_144_635_6),
    ("laponite-relaxation-600.csv", 0.045_566_895_6),
    ("polystyrene-creep-160C.csv", 0.143_366_362),
    ("polystyrene-sweep-160C.csv", 0.344_177_03),
    ("polyisoprene-13k-sweep.csv", 0.865_264_281),
];

#[test]
fn public_records_are_fitted_as_well_as_scipy_does() {
    let Some(tables) = read_public(BEST.map(|(name, _)| name)) else {
        return;
    };
    for ((name, best), table) in BEST.iter().zip(tables) {
        let read = understood(&table, &TableDetails::default()).expect(name);
        let rms = one(&read.record, ModelKind::SpringPot).fits[0].rms;
        assert!(rms <= 1.001 * best, "{name}: {rms} {best}");
        // Nor better, or it would be another objective.
        assert!(rms >= 0.999 * best, "{name}: {rms} {best}");
    }
}
