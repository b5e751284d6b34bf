//! First-order sections in series: gain, g, then direct, decay and slow of each.

use super::parts::{Core, Field};
use crate::number::{CNumber, literal, table};

const STEP: &str = "    real signal = u;
    real rest = ZERO;
    uint32_t i;
    for (i = 0U; i < SECTIONS; ++i) {
        const real slow = self->slow[i];
        const real y = @_direct[i] * signal + @_slow[i] * slow;
APPROACH        signal = y;
        rest = @_direct[i] * rest + @_slow[i] * self->slow[i];
    }
    past = GAIN * rest;
";

/// The state follows the signal; in single precision what rounding takes goes to the carry.
const COMPENSATED: &str =
    "        const real addend = @_decay[i] * (signal - slow) + self->carry[i];
        const real total = slow + addend;
        const real virtual_addend = total - slow;
        self->carry[i] = (slow - (total - virtual_addend)) + (addend - virtual_addend);
        self->slow[i] = total;
";
const PLAIN: &str = "        self->slow[i] = slow + @_decay[i] * (signal - slow);\n";

pub(super) fn core<F: CNumber>(values: &[F]) -> Option<Core> {
    let (&[gain, direct], rest) = values.split_first_chunk()?;
    let (triples, rest) = rest.as_chunks::<3>();
    if !rest.is_empty() || triples.is_empty() {
        return None;
    }
    let count = triples.len();
    let column = |which: usize| triples.iter().map(|three| three[which]).collect::<Vec<F>>();
    let mut fields = vec![Field::Reals("slow", count)];
    if F::COMPENSATED {
        fields.push(Field::Reals("carry", count));
    }
    Some(Core {
        tables: table("@_direct", &column(0))
            + &table("@_decay", &column(1))
            + &table("@_slow", &column(2)),
        fields,
        functions: String::new(),
        step: STEP
            .replace("APPROACH", if F::COMPENSATED { COMPENSATED } else { PLAIN })
            .replace("SECTIONS", &format!("{count}U"))
            .replace("GAIN", &literal(gain)),
        direct: literal(direct),
        words: format!("{count} first-order sections"),
    })
}
