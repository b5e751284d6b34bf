//! Recent taps and decaying modes: g, k₁, …, k₁₅, d₁, W₁, d₂, W₂, …, fastest mode first.

use super::parts::{Core, Field};
use crate::number::{CNumber, literal, table};
use fracdiff::OperatorList;

/// Taps of the form, and modes that are added side by side.
const TAPS: usize = 16;
const LANES: usize = 8;

/// One mode, which needs no second word: what it leaves is added to the sum of its lane.
const PLAIN: &str = "
/* A mode takes u in; its contribution to the next output is added to the sum. */
static inline real @_fade(@_t *self, uint32_t i, real u, real sum)
{
AS_WRITTEN    const real state = self->state[i] + (u - @_decay[i] * self->state[i]);
    self->state[i] = state;
    return sum + @_weight[i] * state;
}
";

/// A slow mode: what rounding takes from the state goes to its carry.
const CARRIED: &str = "
/* A slow mode takes u in: what rounding takes from its state is carried. */
static inline real @_fade_slowly(@_t *self, uint32_t i, real u, real sum)
{
AS_WRITTEN    const real before = self->state[i];
    const real addend = (u - @_decay[i] * before) + self->carry[CARRY];
    const real state = before + addend;
    self->carry[CARRY] = addend - (state - before);
    self->state[i] = state;
    return sum + @_weight[i] * state;
}
";

/// What the taps leave for the next output.
const BEFORE: &str = "    real s0 = ZERO, s1 = ZERO, s2 = ZERO, s3 = ZERO, s4 = ZERO, s5 = ZERO, s6 = ZERO, s7 = ZERO;
    uint32_t i;
    for (i = 0U; i < 15U; ++i) {
        self->due[i] = self->due[i + 1U] + @_tap[i] * u;
    }
";

/// Eight modes side by side, each with a sum of its own.
const EIGHT: &str = "    for (i = FROM; i < TO; i += 8U) {
        s0 = FADE(self, i, u, s0);
        s1 = FADE(self, i + 1U, u, s1);
        s2 = FADE(self, i + 2U, u, s2);
        s3 = FADE(self, i + 3U, u, s3);
        s4 = FADE(self, i + 4U, u, s4);
        s5 = FADE(self, i + 5U, u, s5);
        s6 = FADE(self, i + 6U, u, s6);
        s7 = FADE(self, i + 7U, u, s7);
    }
";

/// The eight sums in pairs.
const AFTER: &str = "    s0 = s0 + s4;
    s1 = s1 + s5;
    s2 = s2 + s6;
    s3 = s3 + s7;
    past = self->due[0] + ((s0 + s2) + (s1 + s3));
";

/// One state a sample without input becomes zero before it gets so small that arithmetic slows down.
const FLUSH: &str = "    if (u == ZERO) {
        const uint32_t turn = self->turn;
        const real state = self->state[turn];
        self->turn = ((turn + 1U) < MODES) ? (turn + 1U) : 0U;
        if ((state < TINY) && (state > -TINY) && (state != ZERO)) {
            self->state[turn] = ZERO;
CLEAR        }
    }
";

/// Of an order without modes: taps alone.
const TAPS_ONLY: &str = "    uint32_t i;
    for (i = 0U; i < 15U; ++i) {
        self->due[i] = self->due[i + 1U] + @_tap[i] * u;
    }
    past = self->due[0] + ZERO;
";

pub(super) fn core<F: CNumber>(list: &OperatorList<F>) -> Option<Core> {
    let (taps, modes) = list.values.split_at_checked(TAPS)?;
    let (pairs, rest) = modes.as_chunks::<2>();
    if !rest.is_empty() {
        return None;
    }
    let count = pairs.len().next_multiple_of(LANES);
    let plain = list.plain_modes().min(count);
    let column = |which: usize| {
        let mut column: Vec<F> = pairs.iter().map(|pair| pair[which]).collect();
        column.resize(count, F::ZERO);
        column
    };
    let mut tables = table("@_tap", &taps[1..]);
    let mut fields = vec![Field::Reals("due", TAPS)];
    if count > 0 {
        tables.push_str(&table("@_decay", &column(0)));
        tables.push_str(&table("@_weight", &column(1)));
        fields.push(Field::Reals("state", count));
        if plain < count {
            fields.push(Field::Reals("carry", count - plain));
        }
        fields.push(Field::Index("turn"));
    }
    Some(Core {
        tables,
        fields,
        functions: fading(plain, count),
        step: step::<F>(plain, count),
        direct: literal(taps[0]),
        words: format!("16 recent samples and {} decaying modes", pairs.len()),
    })
}

/// The index of the carry of mode i.
fn carry_of(index: &str, plain: usize) -> String {
    if plain == 0 {
        index.to_owned()
    } else {
        format!("{index} - {plain}U")
    }
}

/// The functions of a mode, as far as they are needed.
fn fading(plain: usize, count: usize) -> String {
    let mut functions = String::new();
    if plain > 0 {
        functions.push_str(PLAIN);
    }
    if plain < count {
        functions.push_str(&CARRIED.replace("CARRY", &carry_of("i", plain)));
    }
    functions
}

/// The step for so many modes, the first of them without a carry.
fn step<F: CNumber>(plain: usize, count: usize) -> String {
    if count == 0 {
        return TAPS_ONLY.to_owned();
    }
    let eight = |from: usize, to: usize, fade: &str| {
        EIGHT
            .replace("FROM", &format!("{from}U"))
            .replace("TO", &format!("{to}U"))
            .replace("FADE", fade)
    };
    let mut step = BEFORE.to_owned();
    if plain > 0 {
        step.push_str(&eight(0, plain, "@_fade"));
    }
    if plain < count {
        step.push_str(&eight(plain, count, "@_fade_slowly"));
    }
    step.push_str(AFTER);
    step.push_str(FLUSH);
    let clear = match (plain, plain < count) {
        (_, false) => String::new(),
        (0, true) => "            self->carry[turn] = ZERO;\n".to_owned(),
        _ => format!(
            "            if (turn >= {plain}U) {{\n                self->carry[{}] = ZERO;\n            }}\n",
            carry_of("turn", plain)
        ),
    };
    step.replace("MODES", &format!("{count}U"))
        .replace("CLEAR", &clear)
        .replace("TINY", &literal(F::NEGLIGIBLE))
}
