//! The core of each form of operator in C: its tables, its part of the struct, its step.
//!
//! `u` is the input of the core in all of them, and the core leaves its part of the next output in `past`. `@` stands
//! for the name, `real` for the number type; both are put in at the end. Words in capitals are put in by [`filled`].

use crate::{
    error::HeaderError,
    number::{CNumber, filled, literal, table},
};
use fracdiff::{OperatorList, portable::Form};

/// A member of the struct: zero at rest.
pub(crate) enum Field {
    Real(&'static str),
    Reals(&'static str, usize),
    /// A place in an array.
    Index(&'static str),
}

/// The core of an operator in C.
pub(crate) struct Core {
    pub tables: String,
    /// Its part of the history.
    pub fields: Vec<Field>,
    /// Functions that the step calls.
    pub functions: String,
    /// Step from `u` to `past`, without an input in between.
    pub step: String,
    pub direct: String,
    /// Meaning of the numbers, for the comment.
    pub words: String,
}

/// The core of a list that an operator made.
pub(crate) fn core<F: CNumber>(list: &OperatorList<F>) -> Result<Core, HeaderError> {
    let values = finite(&list.values)?;
    let core = match list.form {
        Form::Taps if list.integer == 0 => taps(values),
        Form::Modes => modes(list),
        Form::Recursion => recursion(values),
        Form::Taps => None,
    };
    let integer = list.integer;
    core.filter(|_| (-2..=2).contains(&integer))
        .ok_or(HeaderError::List {
            count: values.len(),
            integer,
        })
}

/// The core of a finite impulse response.
pub(crate) fn filter<F: CNumber>(values: &[F]) -> Result<Core, HeaderError> {
    let (count, integer) = (values.len(), 0);
    taps(finite(values)?).ok_or(HeaderError::List { count, integer })
}

/// Values, all of which are finite.
fn finite<F: CNumber>(values: &[F]) -> Result<&[F], HeaderError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(HeaderError::Value {
            index,
            value: values[index].to_f64(),
        }),
        None => Ok(values),
    }
}

/// Sixteen partial sums, then in pairs: the order of summation of fracdiff. Each sample is kept twice, so that the
/// newest always lie in one piece.
const TAPS_STEP: &str = "    real sum[16];
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

/// A finite impulse response: g, k₁, …, k_{n−1}.
fn taps<F: CNumber>(values: &[F]) -> Option<Core> {
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
        step: filled(TAPS_STEP, &[("TAPS", count)]),
        direct,
        words,
    })
}

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

/// Contribution of the taps to the next output.
const DUE: &str = "    for (i = 0U; i < 15U; ++i) {
        self->due[i] = self->due[i + 1U] + @_tap[i] * u;
    }
";

/// The modes of four lanes, then of the other four, which keeps the code small; then the eight sums in pairs. One state a sample without input
/// becomes zero before it gets so small that arithmetic slows down.
const MODES_STEP: &str = "    real t0 = ZERO, t1 = ZERO, t2 = ZERO, t3 = ZERO;
    uint32_t lane;
    uint32_t i;
TAKE_DUE    for (lane = 0U; lane < 8U; lane += 4U) {
        real s0 = ZERO, s1 = ZERO, s2 = ZERO, s3 = ZERO;
FADES        t0 = t0 + s0;
        t1 = t1 + s1;
        t2 = t2 + s2;
        t3 = t3 + s3;
    }
    past = FIRST_DUE + ((t0 + t2) + (t1 + t3));
    if (u == ZERO) {
        const uint32_t turn = self->turn;
        const real state = self->state[turn];
        self->turn = ((turn + 1U) < MODES) ? (turn + 1U) : 0U;
        if ((state < TINY) && (state > -TINY) && (state != ZERO)) {
            self->state[turn] = ZERO;
CLEAR        }
    }
";

/// Four modes side by side, each with a sum of its own.
const FOUR: &str = "        for (i = FROM + lane; i < TO; i += 8U) {
            s0 = FADE(self, i, u, s0);
            s1 = FADE(self, i + 1U, u, s1);
            s2 = FADE(self, i + 2U, u, s2);
            s3 = FADE(self, i + 3U, u, s3);
        }
";

/// Step of an order without modes: taps alone.
const TAPS_ONLY: &str = "    uint32_t i;
TAKE_DUE    past = FIRST_DUE + ZERO;
";

/// Recent taps and decaying modes: g, k₁, …, k₁₅, d₁, W₁, d₂, W₂, …, fastest mode first.
fn modes<F: CNumber>(list: &OperatorList<F>) -> Option<Core> {
    let (taps, rest) = list.values.split_at_checked(TAPS)?;
    let (pairs, odd) = rest.as_chunks::<2>();
    if !odd.is_empty() {
        return None;
    }
    let count = pairs.len().next_multiple_of(LANES);
    let plain = list.plain_modes().min(count);
    let column = |which: usize| {
        let mut column: Vec<F> = pairs.iter().map(|pair| pair[which]).collect();
        column.resize(count, F::ZERO);
        column
    };
    // A list without modes keeps its taps, whatever they are: a struct in C is not empty.
    let tapped = count == 0 || taps[1..].iter().any(|&tap| tap != F::ZERO);
    let (mut tables, mut fields) = (String::new(), Vec::new());
    if tapped {
        tables.push_str(&table("@_tap", &taps[1..]));
        fields.push(Field::Reals("due", TAPS));
    }
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
        step: step::<F>(tapped, plain, count),
        direct: literal(taps[0]),
        words: if tapped {
            format!("16 recent samples and {} decaying modes", pairs.len())
        } else {
            format!("{} decaying modes", pairs.len())
        },
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
        functions.push_str(&filled(CARRIED, &[("CARRY", carry_of("i", plain))]));
    }
    functions
}

/// The step for `count` modes, the first `plain` of them without a carry.
fn step<F: CNumber>(tapped: bool, plain: usize, count: usize) -> String {
    let (take_due, first_due) = if tapped {
        (DUE, "self->due[0]")
    } else {
        ("", "ZERO")
    };
    if count == 0 {
        return filled(
            TAPS_ONLY,
            &[("TAKE_DUE", take_due), ("FIRST_DUE", first_due)],
        );
    }
    let mut fades = String::new();
    for (from, to, fade) in [(0, plain, "@_fade"), (plain, count, "@_fade_slowly")] {
        if from < to {
            let [from, to] = [from, to].map(|mode| format!("{mode}U"));
            fades += &filled(FOUR, &[("FROM", &*from), ("TO", &to), ("FADE", fade)]);
        }
    }
    let clear = match (plain, plain < count) {
        (_, false) => String::new(),
        (0, true) => "            self->carry[turn] = ZERO;\n".to_owned(),
        _ => format!(
            "            if (turn >= {plain}U) {{\n                self->carry[{}] = ZERO;\n            }}\n",
            carry_of("turn", plain)
        ),
    };
    let (count, tiny) = (format!("{count}U"), literal(F::NEGLIGIBLE));
    filled(
        MODES_STEP,
        &[
            ("TAKE_DUE", take_due),
            ("FIRST_DUE", first_due),
            ("FADES", &fades),
            ("CLEAR", &clear),
            ("MODES", &count),
            ("TINY", &tiny),
        ],
    )
}

const RECURSION: &str = "    const real y = DIRECT * u + self->state[0];
    uint32_t i;
    for (i = 0U; i < LAST; ++i) {
        self->state[i] = self->state[i + 1U] + (@_forward[i] * u - @_backward[i] * y);
    }
    self->state[LAST] = ZERO + (@_forward[LAST] * u - @_backward[LAST] * y);
    past = self->state[0];
";

/// Variant of [`RECURSION`] for a single degree.
const RECURSION_OF_ONE: &str = "    const real y = DIRECT * u + self->state[0];
    self->state[0] = ZERO + (@_forward[0] * u - @_backward[0] * y);
    past = self->state[0];
";

/// The step where b is −g·a₁, g·a₂, …, with half the multiplications of [`RECURSION`].
const MIRRORED: &str = "    const real z = self->state[0];
    const real odd = z + (u + u);
LOOP    past = DIRECT * self->state[0];
";

/// The loop of [`MIRRORED`] over the pairs that a state follows.
const PAIRS: &str = "    uint32_t i;
    for (i = 0U; i < PAIRED; i += 2U) {
        self->state[i] = self->state[i + 1U] - @_backward[i] * odd;
        self->state[i + 1U] = self->state[i + 2U] - @_backward[i + 1U] * z;
    }
";

/// The step of [`MIRRORED`] for this degree.
fn mirrored(degree: usize, direct: &str) -> String {
    let (paired, last) = ((degree - 1) / 2 * 2, degree - 1);
    let mut all = if paired > 0 {
        filled(PAIRS, &[("PAIRED", &format!("{paired}U"))])
    } else {
        String::new()
    };
    for i in paired..degree {
        let next = if i == last {
            "ZERO".to_owned()
        } else {
            format!("self->state[{last}U]")
        };
        let fed = if i == paired { "odd" } else { "z" };
        all += &format!("    self->state[{i}U] = {next} - @_backward[{i}U] * {fed};\n");
    }
    filled(MIRRORED, &[("LOOP", &*all), ("DIRECT", direct)])
}

/// A recursive filter: g, b₁, a₁, b₂, a₂, ….
fn recursion<F: CNumber>(values: &[F]) -> Option<Core> {
    let (&g, rest) = values.split_first()?;
    let (pairs, rest) = rest.as_chunks::<2>();
    if !rest.is_empty() || pairs.is_empty() {
        return None;
    }
    let degree = pairs.len();
    let column = |which: usize| pairs.iter().map(|pair| pair[which]).collect::<Vec<F>>();
    let direct = literal(g);
    // As fracdiff decides it.
    let is_mirrored = pairs.iter().enumerate().all(|(i, &[b, a])| {
        let product = g * a;
        b == if i % 2 == 0 { -product } else { product }
    });
    let mut tables = table("@_backward", &column(1));
    let step = if is_mirrored {
        mirrored(degree, &direct)
    } else {
        tables.push_str(&table("@_forward", &column(0)));
        let step = if degree == 1 {
            RECURSION_OF_ONE
        } else {
            RECURSION
        };
        let last = format!("{}U", degree - 1);
        filled(step, &[("LAST", &*last), ("DIRECT", &direct)])
    };
    Some(Core {
        tables,
        fields: vec![Field::Reals("state", degree)],
        functions: String::new(),
        step,
        direct,
        words: format!("a recursive filter of degree {degree}"),
    })
}
