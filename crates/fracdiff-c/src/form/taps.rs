//! A finite impulse response: g, k₁, …, k_{n−1}.

use super::parts::{Core, Field};
use crate::number::{CNumber, literal, table};

/// Sixteen partial sums, then in pairs: the order of summation of fracdiff. Each sample is kept twice, so that the
/// newest always lie in one piece.
const STEP: &str = "    real sum[16];
    uint32_t i;
    uint32_t lane;
    self->newest = (self->newest == 0U) ? (TAPS - 1U) : (self->newest - 1U);
    self->sample[self->newest] = u;
    self->sample[self->newest + TAPS] = u;
    for (lane = 0U; lane < 16U; ++lane) {
        real part = ZERO;
        for (i = lane; i < TAPS; i += 16U) {
            part += @_tap[i] * self->sample[self->newest + i];
        }
        sum[lane] = part;
    }
    for (lane = 0U; lane < 8U; ++lane) {
        sum[lane] = sum[lane] + sum[lane + 8U];
    }
    for (lane = 0U; lane < 4U; ++lane) {
        sum[lane] = sum[lane] + sum[lane + 4U];
    }
    past = (sum[0] + sum[2]) + (sum[1] + sum[3]);
";

pub(super) fn core<F: CNumber>(values: &[F]) -> Option<Core> {
    let (&direct, taps) = values.split_first()?;
    let direct = literal(direct);
    let words = format!("the {} newest samples", values.len());
    if taps.is_empty() {
        return Some(Core {
            tables: String::new(),
            fields: Vec::new(),
            functions: String::new(),
            step: "    (void)u;\n    past = ZERO;\n".to_owned(),
            direct,
            words,
        });
    }
    let count = format!("{}U", taps.len());
    Some(Core {
        tables: table("@_tap", taps),
        fields: vec![
            Field::Reals("sample", 2 * taps.len()),
            Field::Index("newest"),
        ],
        functions: String::new(),
        step: STEP.replace("TAPS", &count),
        direct,
        words,
    })
}
