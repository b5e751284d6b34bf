//! The whole header: comment, tables, struct and functions.

use crate::{
    error::HeaderError,
    form::{self, Core, Field},
    number::{CNumber, check_name, filled, literal},
};
use fracdiff::OperatorList;
use std::fmt;

/// A header in C99 of one operator; `to_string` is its text.
///
/// ```text
/// NAME_t                                  the history of one signal
/// void NAME_init(NAME_t *self)            a signal that was zero for ever
/// real NAME_output(const NAME_t *self, real x)      y[n], a multiply-add after the increment
/// void NAME_advance(NAME_t *self, real x)           takes x[n] into the history
/// real NAME_step(NAME_t *self, real x)              both
/// ```
/// - *Same bits* as the operator in Rust, if C computes as written: no fast math, no contraction.
/// - *Not finite*: as in Rust no output is finite until `NAME_init`, or for as many samples as there are taps.
/// - *Cost*: as in Rust; no heap, no libm, no other files than `float.h` and `stdint.h`.
///
/// ```
/// use fracdiff::{Operator, Order, Scheme, Seconds};
/// use fracdiff_c::CHeader;
///
/// let scheme: Scheme = "grunwald:3".parse()?;
/// let slope: Operator<f32> = scheme.build(Order::new(1.0)?, Seconds(1e-3), 1e3)?;
/// let list = slope.list().ok_or("a scheme without a list")?;
/// let header = CHeader::new("slope", &list, None, &[])?.to_string();
/// assert!(header.contains("static inline float slope_step(slope_t *self, float x)"));
/// assert!(CHeader::new("2nd", &list, None, &[]).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CHeader(String);

/// A spring and a fractional damper, as of a piece of tissue.
///
/// ```text
/// f = −(K·x + B·y)        y the output of the operator
/// ```
/// With a map both see e(x) in place of x, behind a surface:
///
/// ```text
/// e(x) = x·(c₀ + c₁u + … + c₅u⁵)·(exp(qx) − 1)/(qx),        u = √(x/s)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLaw {
    /// K, finite and at least 0, in newtons for each unit of x.
    pub stiffness: f64,
    /// B, finite and at least 0, in newtons for each unit of y.
    pub dissipation: f64,
    /// 1/s above 0; c₀ to c₅ and q, finite and at least 0: see `DepthMap` of `haptic-loop`.
    pub depth_map: Option<[f64; 8]>,
}

impl CHeader {
    /// - `name`: begins all names in the header; a C identifier of 24 characters at most.
    /// - `list`: the operator, as [`Operator::list`](fracdiff::Operator::list) gives it, in `float` or `double`.
    /// - `notes`: lines for the comment at its head: what it is, its error, how it was made.
    ///
    /// With a [`WallLaw`] the header has that of a spring and this operator too, as `haptic-loop` renders it:
    ///
    /// ```text
    /// real NAME_force(const NAME_t *self, real x)       −(K·x + B·y[n]), then NAME_advance(self, x)
    /// real NAME_push(const NAME_t *self, real x)        the same behind a surface at 0, which never pulls, …
    /// real NAME_depth(real x)                           … then NAME_advance(self, NAME_depth(x))
    /// real NAME_depth_map(real x)                       e(x), which NAME_depth takes if the law has a map
    /// ```
    ///
    /// # Errors
    /// A name that C does not take; a list that is of no operator; a K, a B or a number of the map that is negative or not finite, or
    /// vanishes as 1/s.
    pub fn new<F: CNumber>(
        name: &str,
        list: &OperatorList<F>,
        law: Option<&WallLaw>,
        notes: &[String],
    ) -> Result<Self, HeaderError> {
        let operator = Operator::new(list)?;
        let law = law.map_or(Ok(String::new()), WallLaw::functions::<F>)?;
        let head = format!("a fractional operator, {}.", operator.words);
        Self::assembled::<F>(name, &head, notes, USE, &(operator.code + &law))
    }

    /// Comment, guard and code, in which `@` stands for the name and `real` for the number type.
    pub(crate) fn assembled<F: CNumber>(
        name: &str,
        head: &str,
        notes: &[String],
        usage: &str,
        code: &str,
    ) -> Result<Self, HeaderError> {
        let name = check_name(name)?;
        let mut comment = format!("/* {name}: {head}\n");
        for note in notes {
            // Nothing in a note ends the comment.
            let note = note.replace("*/", "* /");
            let words: Vec<&str> = note.split_whitespace().collect();
            comment.push_str(&format!(" * {}\n", words.join(" ")));
        }
        let usage = usage.replace('@', name);
        let zero = literal(F::ZERO);
        let words = [
            ("AS_WRITTEN", AS_WRITTEN),
            ("ZERO", &zero),
            ("real", F::TYPE),
        ];
        let code = filled(code, &words).replace('@', name);
        let opening = opening(name);
        Ok(Self(format!("{comment}{usage}{opening}{code}{CLOSING}")))
    }
}

/// An operator in C, `@` for its name.
pub(crate) struct Operator {
    words: String,
    pub code: String,
}

impl Operator {
    pub(crate) fn new<F: CNumber>(list: &OperatorList<F>) -> Result<Self, HeaderError> {
        let core = form::core(list)?;
        let fields = plain(core, list.integer);
        if list.filter.is_empty() {
            return Ok(fields);
        }
        let filter = plain(form::filter(&list.filter)?, 0);
        Ok(Self {
            words: format!("{}, {} behind", fields.words, filter.words),
            code: fields.code.replace('@', "@_memory")
                + &filter.code.replace('@', "@_filter")
                + SERIES,
        })
    }
}

/// A core, and the integer part of the order around it.
fn plain(core: Core, integer: i8) -> Operator {
    let functions = functions(&core, integer);
    let mut tables = core.tables.clone();
    if !tables.is_empty() {
        tables.insert(0, '\n');
    }
    let words = core.words.clone();
    let structure = structure(&fields(core, integer));
    Operator {
        words,
        code: tables + &structure + &functions,
    }
}

impl fmt::Display for CHeader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

const USE: &str = " *
 * @_t is the history of one signal. @_init(&h) first, then for each sample y = @_output(&h, x), which is
 * cheap, and @_advance(&h, x) when y has been used; or both as @_step(&h, x).
 * The same bits as in Rust: compile with -ffp-contract=off.
 */
";

const CLOSING: &str = "
#ifdef __cplusplus
}
#endif

#endif
";

fn opening(name: &str) -> String {
    let guard = name.to_ascii_uppercase();
    format!(
        "#ifndef {guard}_H\n#define {guard}_H\n\n\
         #ifdef __FAST_MATH__\n#error \"{name} computes as written: compile without -ffast-math and -Ofast\"\n#endif\n\n\
         #include <float.h>\n#include <stdint.h>\n\n\
         #if FLT_EVAL_METHOD != 0\n\
         #error \"{name} computes as written: compile without the x87's wider numbers, as by -msse2 -mfpmath=sse\"\n\
         #endif\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n"
    )
}

/// An operator, and a finite impulse response of its output.
const SERIES: &str = "
/* The history of one signal. */
typedef struct {
    @_memory_t memory;
    @_filter_t filter;
} @_t;

/* A signal that was zero for ever. */
static inline void @_init(@_t *self)
{
    @_memory_init(&self->memory);
    @_filter_init(&self->filter);
}

/* The output for the input x now; changes nothing. */
static inline real @_output(const @_t *self, real x)
{
    return @_filter_output(&self->filter, @_memory_output(&self->memory, x));
}

/* Takes the input x into the history. */
static inline void @_advance(@_t *self, real x)
{
    const real z = @_memory_output(&self->memory, x);
    @_memory_advance(&self->memory, x);
    @_filter_advance(&self->filter, z);
}

/* Output and advance. */
static inline real @_step(@_t *self, real x)
{
    const real y = @_output(self, x);
    @_advance(self, x);
    return y;
}
";

fn fields(core: Core, integer: i8) -> Vec<Field> {
    let mut fields = core.fields;
    let sums: &[&str] = match integer {
        2 => &["base", "slope"],
        1 => &["base"],
        -1 => &["core_past", "inner", "inner_carry"],
        -2 => &["core_past", "inner", "inner_carry", "outer", "outer_carry"],
        _ => &[],
    };
    fields.extend(sums.iter().map(|name| Field::Real(name)));
    fields.push(Field::Real("past"));
    fields
}

/// The struct, and the function that puts it to rest.
fn structure(fields: &[Field]) -> String {
    let members = fields.iter().map(|field| match field {
        Field::Real(name) => format!("    real {name};\n"),
        Field::Reals(name, count) => format!("    real {name}[{count}];\n"),
        Field::Index(name) => format!("    uint32_t {name};\n"),
    });
    let at_rest = fields.iter().map(|field| match field {
        Field::Real(name) => format!("    self->{name} = ZERO;\n"),
        Field::Index(name) => format!("    self->{name} = 0U;\n"),
        Field::Reals(name, count) => {
            format!(
                "    for (i = 0U; i < {count}U; ++i) {{\n        self->{name}[i] = ZERO;\n    }}\n"
            )
        }
    });
    let loops = fields.iter().any(|field| matches!(field, Field::Reals(..)));
    let index = if loops { "    uint32_t i;\n" } else { "" };
    format!(
        "\n/* The history of one signal. */\ntypedef struct {{\n{}}} @_t;\n\n\
         /* A signal that was zero for ever. */\nstatic inline void @_init(@_t *self)\n{{\n{index}{}}}\n",
        members.collect::<String>(),
        at_rest.collect::<String>()
    )
}

/// Knuth's two-sum, as fracdiff has it.
const SUM: &str = "
/* Adds to a sum, and keeps what rounding takes. */
static inline void @_add(real *sum, real *carry, real increment)
{
    const real addend = increment + *carry;
    const real total = *sum + addend;
    const real virtual_addend = total - *sum;
    *carry = (*sum - (total - virtual_addend)) + (addend - virtual_addend);
    *sum = total;
}
";

/// Clang contracts within an expression unless a pragma forbids it.
const AS_WRITTEN: &str = "\
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
";

/// The sum in front of an integral.
fn before_step(direct: &str, integer: i8) -> String {
    if integer >= 0 {
        return String::new();
    }
    format!("    @_add(&self->inner, &self->inner_carry, {direct} * x + self->core_past);\n")
}

/// The integer part takes its step.
fn after_step(integer: i8) -> String {
    let mut after = String::new();
    if integer > 1 {
        after.push_str("    self->slope = x - self->base;\n");
    }
    if integer > 0 {
        after.push_str("    self->base = x;\n");
    }
    if integer < 0 {
        after.push_str("    self->core_past = past;\n");
    }
    if integer < -1 {
        after.push_str("    @_add(&self->outer, &self->outer_carry, self->inner);\n");
    }
    after.push_str(match integer {
        ..=-2 => "    self->past = (past + self->inner) + self->outer;\n",
        -1 => "    self->past = (past + self->inner) + ZERO;\n",
        _ => "    self->past = past;\n",
    });
    after
}

fn functions(core: &Core, integer: i8) -> String {
    let increment = match integer {
        2 => "(x - self->base) - self->slope",
        1 => "x - self->base",
        _ => "x",
    };
    let direct = &core.direct;
    let (before, after) = (before_step(direct, integer), after_step(integer));
    let sum = if integer < 0 { SUM } else { "" };
    let (step, functions) = (&core.step, &core.functions);
    format!(
        "{sum}{functions}
/* The output for the input x now; changes nothing. */
static inline real @_output(const @_t *self, real x)
{{
AS_WRITTEN    return {direct} * ({increment}) + self->past;
}}

/* Takes the input x into the history. */
static inline void @_advance(@_t *self, real x)
{{
AS_WRITTEN    const real u = {increment};
    real past;
    {{
{step}    }}
{after}}}

/* Output and advance. */
static inline real @_step(@_t *self, real x)
{{
    const real y = @_output(self, x);
    @_advance(self, x);
    return y;
}}
",
        step = indented(&format!("{before}{step}")),
    )
}

fn indented(text: &str) -> String {
    text.lines()
        .map(|line| {
            if line.is_empty() {
                "\n".to_owned()
            } else {
                format!("    {line}\n")
            }
        })
        .collect()
}

/// Force of the law, and the same behind a surface, as `haptic-loop` has them.
const LAW: &str = "
/* The force on what is joined to it at the displacement x: -(K x + B y). Changes nothing. Of a tissue with a map of the depth
   x is e(x): take @_push instead. */
static inline real @_force(const @_t *self, real x)
{
AS_WRITTEN    return -(STIFFNESS * x + DISSIPATION * @_output(self, x));
}

/* How deep a place is behind a surface at 0; not finite places are no number. */
static inline real @_depth(real x)
{
AS_WRITTEN    const real nothing = x - x;
    return DEPTH;
}

/* The force behind that surface: it pushes and never pulls. Take @_depth(x) into the history, not x. */
static inline real @_push(const @_t *self, real x)
{
    const real depth = @_depth(x);
    const real force = @_force(self, depth);
    return ((depth <= ZERO) || (force > ZERO)) ? ZERO : force;
}
";

/// Depths without a map, and with one.
const DEPTHS: [&str; 2] = [
    "((x < ZERO) ? ZERO : x) + nothing",
    "@_depth_map(((x < ZERO) ? ZERO : x) + nothing)",
];

/// The root of `haptic-loop`, in the same steps.
const ROOT: &str = "
/* The root of a number of at least 0: Newton's steps from what its bits say. */
static inline real @_root(real x)
{
AS_WRITTEN    const real half_x = HALF * x;
    union {
        real number;
        BITS bits;
    } rough;
    real y;
    real half_y;
    uint32_t i;
    rough.number = x;
    rough.bits = MAGIC - (rough.bits >> 1);
    y = rough.number;
    for (i = 0U; i < STEPS; ++i) {
        y = y * (THREE_HALVES - half_x * y * y);
    }
    half_y = HALF * y;
    y = x * y;
    return y + half_y * (x - y * y);
}
";

const GROWTH: &str = "
/* (exp(x) - 1)/x of a number of at least 0: a series, further out at x/16, x/256, ... */
static inline real @_growth(real x)
{
AS_WRITTEN    real y = x;
    real sum = C7;
    uint32_t doublings = 0U;
    while ((y > NEAR) && (doublings < 16U)) {
        y = SIXTEENTH * y;
        doublings += 4U;
    }
    sum = C6 + y * sum;
    sum = C5 + y * sum;
    sum = C4 + y * sum;
    sum = C3 + y * sum;
    sum = C2 + y * sum;
    sum = C1 + y * sum;
    sum = ONE + y * sum;
    if (doublings == 0U) {
        return sum;
    }
    sum = y * sum;
    while (doublings > 0U) {
        sum = sum * (sum + TWO);
        doublings -= 1U;
    }
    return sum / x;
}
";

const MAP: &str = "
/* What the law sees of a depth of at least 0. */
static inline real @_depth_map(real x)
{
AS_WRITTEN    const real u = @_root(x * PER_SCALE);
    real sum = C5;
    sum = C4 + u * sum;
    sum = C3 + u * sum;
    sum = C2 + u * sum;
    sum = C1 + u * sum;
    sum = C0 + u * sum;
    return (x * sum)STIFFENED;
}
";

/// The names of coefficients in the templates.
const C: [&str; 8] = ["C0", "C1", "C2", "C3", "C4", "C5", "C6", "C7"];

/// Root, growth and map of these numbers.
fn depth_map<F: CNumber>(numbers: &[f64; 8]) -> Result<String, HeaderError> {
    let rounded = numbers.map(F::from_f64);
    let bad = |at: &usize| {
        let good = numbers[*at] >= 0.0 && rounded[*at].is_finite();
        !good || (*at == 0 && rounded[0] <= F::ZERO)
    };
    if let Some(at) = (0..8).find(bad) {
        return Err(HeaderError::DepthMap { value: numbers[at] });
    }
    let number = |value: f64| literal(F::from_f64(value));
    let (near, steps) = if F::COMPENSATED {
        (0.5, "2U")
    } else {
        (1.0 / 32.0, "3U")
    };
    let mut text = filled(
        ROOT,
        &[
            ("THREE_HALVES", number(1.5)),
            ("HALF", number(0.5)),
            ("BITS", F::BITS.to_owned()),
            ("MAGIC", F::ZERO.rough_inverse_root().bits()),
            ("STEPS", steps.to_owned()),
        ],
    );
    let mut stiffening = String::new();
    if rounded[7] > F::ZERO {
        let named = [
            ("NEAR", near),
            ("SIXTEENTH", 1.0 / 16.0),
            ("ONE", 1.0),
            ("TWO", 2.0),
        ];
        let mut factorial = 1.0;
        let series = C[1..].iter().zip(2..9_u8).map(|(name, n)| {
            factorial *= f64::from(n);
            (*name, 1.0 / factorial)
        });
        let words: Vec<_> = (named.into_iter().chain(series))
            .map(|(name, value)| (name, number(value)))
            .collect();
        text.push_str(&filled(GROWTH, &words));
        stiffening = format!(" * @_growth({} * x)", literal(rounded[7]));
    }
    let terms = C.iter().zip(&rounded[1..7]);
    let mut words: Vec<_> = terms.map(|(name, term)| (*name, literal(*term))).collect();
    words.extend([
        ("PER_SCALE", literal(rounded[0])),
        ("STIFFENED", stiffening),
    ]);
    text.push_str(&filled(MAP, &words));
    Ok(text)
}

impl WallLaw {
    fn functions<F: CNumber>(&self) -> Result<String, HeaderError> {
        let number = |value: f64| {
            let rounded = F::from_f64(value);
            if value >= 0.0 && rounded.is_finite() {
                Ok(literal(rounded))
            } else {
                Err(HeaderError::Law { value })
            }
        };
        let map = self.depth_map.as_ref().map(depth_map::<F>).transpose()?;
        let depth = DEPTHS[usize::from(map.is_some())];
        let (stiffness, dissipation) = (number(self.stiffness)?, number(self.dissipation)?);
        let words = [
            ("DEPTH", depth),
            ("STIFFNESS", &stiffness),
            ("DISSIPATION", &dissipation),
        ];
        Ok(map.unwrap_or_default() + &filled(LAW, &words))
    }
}
