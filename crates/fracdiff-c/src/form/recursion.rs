//! A recursive filter: g, b₁, a₁, b₂, a₂, ….

use super::parts::{Core, Field};
use crate::number::{CNumber, literal, table};

const STEP: &str = "    const real y = DIRECT * u + self->state[0];
    uint32_t i;
    for (i = 0U; i < LAST; ++i) {
        self->state[i] = self->state[i + 1U] + (@_forward[i] * u - @_backward[i] * y);
    }
    self->state[LAST] = ZERO + (@_forward[LAST] * u - @_backward[LAST] * y);
    past = self->state[0];
";

/// The same for a single degree.
const STEP_OF_ONE: &str = "    const real y = DIRECT * u + self->state[0];
    self->state[0] = ZERO + (@_forward[0] * u - @_backward[0] * y);
    past = self->state[0];
";

pub(super) fn core<F: CNumber>(values: &[F]) -> Option<Core> {
    let (&direct, rest) = values.split_first()?;
    let (pairs, rest) = rest.as_chunks::<2>();
    if !rest.is_empty() || pairs.is_empty() {
        return None;
    }
    let degree = pairs.len();
    let column = |which: usize| pairs.iter().map(|pair| pair[which]).collect::<Vec<F>>();
    let direct = literal(direct);
    let step = if degree == 1 { STEP_OF_ONE } else { STEP };
    Some(Core {
        tables: table("@_forward", &column(0)) + &table("@_backward", &column(1)),
        fields: vec![Field::Reals("state", degree)],
        functions: String::new(),
        step: step
            .replace("LAST", &format!("{}U", degree - 1))
            .replace("DIRECT", &direct),
        direct,
        words: format!("a recursive filter of degree {degree}"),
    })
}
