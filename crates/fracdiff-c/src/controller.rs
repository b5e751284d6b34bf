//! A controller in C: the law of `fractional-control`, line by line, around its powers.
//!
//! `@` stands for the name, `real` for the number type, as in the code of an operator.

use crate::error::HeaderError;
use crate::header::{Header, Operator};
use crate::number::{CNumber, literal};
use fracdiff::OperatorList;
use fractional_control::{BranchList, ControllerList, LawList, LeadList, ParallelList};

/// A controller in C, in the parts that differ from law to law.
#[derive(Default)]
struct Law {
    /// What it is, for the comment.
    words: String,
    /// Its powers: tables, structs and functions.
    powers: String,
    /// Parameters beside the limits, as they may be changed: name and number.
    parameters: Vec<(String, f64)>,
    /// Members of the struct beside limits and bias, and what they begin with.
    members: Vec<(String, String)>,
    /// The powers in the struct.
    histories: Vec<String>,
    /// Functions that the others call.
    functions: String,
    /// Terms of the command.
    terms: Vec<String>,
    /// What the history takes in, by the controller and by hand.
    advance: String,
    follow: String,
    /// New parameters: what is refused, what is computed, what is taken over.
    refused: String,
    change: String,
}

impl Header {
    /// A controller as `fractional-control` runs it, in `float` or `double`:
    ///
    /// ```text
    /// NAME_t                                                 the controller and the history of its loop
    /// void NAME_init(NAME_t *self)                           at rest, with the parameters of the list
    /// real NAME_output(const NAME_t *self, real r, real y)   the command, within its limits
    /// void NAME_advance(NAME_t *self, real r, real y, real applied)   history, by what was really applied
    /// void NAME_follow(NAME_t *self, real r, real y, real applied)    the same while somebody else commands
    /// real NAME_step(NAME_t *self, real r, real y)           output and advance
    /// int NAME_change(NAME_t *self, const NAME_parameters_t *to, real r, real y)   other gains, no bump
    /// ```
    /// - *Same bits* as in Rust, if C computes as written. `change` computes in `double`, as Rust does, and nothing else.
    /// - *Manual and automatic*: `follow` takes the place of `advance` as long as the command comes from elsewhere.
    /// - *Other orders*: another header, whose controller follows the commands of the first before it takes over.
    ///
    /// # Errors
    /// A name that C does not take; a number that is not finite. Without a limit its largest number is one.
    pub fn of_controller<F: CNumber>(
        name: &str,
        list: &ControllerList<F>,
        notes: &[String],
    ) -> Result<Self, HeaderError> {
        let law = match &list.law {
            LawList::Parallel(law) => parallel(law)?,
            LawList::Lead(law) => lead(law)?,
            _ => return Err(HeaderError::Controller),
        };
        let code = law.code(list);
        Self::assembled::<F>(name, &law.words, notes, USE, &code)
    }
}

const USE: &str = " *
 * @_t is a controller with the history of its loop. @_init(&c) first, then for each sample u = @_output(&c, r, y), which is
 * cheap, for reference r and measurement y, and @_advance(&c, r, y, applied) with what the actuator really did when u has
 * been sent; or both as @_step(&c, r, y). By hand: @_follow(&c, r, y, applied) in its place. @_change takes other gains.
 * A NaN makes every later command a NaN, past the limits: check each reading first.
 * The same bits as in Rust: compile with -ffp-contract=off.
 */
";

/// What all controllers have; words in capitals are put in.
const COMMON: &str = "
/* What may be changed while it runs: gains, set-point weights, limits of the command. */
typedef struct {
PARAMETERS    double low;
    double high;
} @_parameters_t;

/* Those that it begins with. */
static inline @_parameters_t @_parameters(void)
{
    const @_parameters_t parameters = {NUMBERS};
    return parameters;
}

/* A controller and the history of its loop. */
typedef struct {
MEMBERS    real low;
    real high;
    real bias;
HISTORIES} @_t;

/* A loop that was at rest for ever. */
static inline void @_init(@_t *self)
{
STARTS}
FUNCTIONS
/* The command before its limits. */
static inline real @_wanted(const @_t *self, real r, real y)
{
AS_WRITTEN    real u = self->bias;
TERMS    return u;
}

/* The command for reference r and measurement y now; changes nothing. */
static inline real @_output(const @_t *self, real r, real y)
{
    const real u = @_wanted(self, r, y);
    return (u < self->low) ? self->low : ((u > self->high) ? self->high : u);
}

/* A bump that was held fades. */
static inline real @_faded(real bias)
{
AS_WRITTEN    const real left = bias * KEEP;
    return ((left < TINY) && (left > -TINY)) ? ZERO : left;
}

/* Takes the sample into the history, with what was applied: no wind-up at a limit. */
static inline void @_advance(@_t *self, real r, real y, real applied)
{
AS_WRITTEN    const real excess = applied - @_wanted(self, r, y);
ADVANCE}

/* The same while somebody else commands: the next output goes on from there. */
static inline void @_follow(@_t *self, real r, real y, real applied)
{
AS_WRITTEN    const real excess = applied - @_wanted(self, r, y);
FOLLOW}

/* Output and advance, where the command is applied as it is. */
static inline real @_step(@_t *self, real r, real y)
{
    const real u = @_output(self, r, y);
    @_advance(self, r, y, u);
    return u;
}

/* Finite, also when rounded. */
static inline int @_is_finite(double x)
{
    const real rounded = (real)x;
    return (rounded - rounded) == ZERO;
}

/* Other parameters from now on; at this r and y the command stays. 0 and no change for a gain of 0, a number that is not
 * finite, r and y too, or limits that are not in order. */
static inline int @_change(@_t *self, const @_parameters_t *to, real r, real y)
{
AS_WRITTEN    const real wanted = @_wanted(self, r, y);
    const real low = (real)to->low;
    const real high = (real)to->high;
    if (REFUSED!(low < high) || !((wanted - wanted) == ZERO)) {
        return 0;
    }
CHANGE    self->low = low;
    self->high = high;
    self->bias = ZERO;
    self->bias = ZERO + (wanted - @_wanted(self, r, y));
    return 1;
}
";

impl Law {
    fn code<F: CNumber>(&self, list: &ControllerList<F>) -> String {
        let names = |names: &mut dyn Iterator<Item = &String>, kind: &str| {
            names
                .map(|name| format!("    {kind} {name};\n"))
                .collect::<String>()
        };
        let limits = list.limits.map(limit::<F>);
        let numbers = (self.parameters.iter().map(|(_, number)| *number)).chain(limits);
        let numbers: Vec<String> = numbers.map(literal).collect();
        let starts = (self.members.iter())
            .map(|(name, start)| format!("    self->{name} = {start};\n"))
            .chain(["low", "high"].iter().zip(limits).map(|(name, limit)| {
                format!("    self->{name} = {};\n", literal(F::from_f64(limit)))
            }))
            .chain(["    self->bias = ZERO;\n".to_owned()])
            .chain(
                (self.histories.iter()).map(|name| format!("    @_{name}_init(&self->{name});\n")),
            );
        let histories = (self.histories.iter())
            .map(|name| format!("    @_{name}_t {name};\n"))
            .collect::<String>();
        let terms = (self.terms.iter())
            .map(|term| format!("    u = {term};\n"))
            .collect::<String>();
        let common = COMMON
            .replace(
                "PARAMETERS",
                &names(&mut self.parameters.iter().map(|(name, _)| name), "double"),
            )
            .replace("NUMBERS", &numbers.join(", "))
            .replace(
                "MEMBERS",
                &names(&mut self.members.iter().map(|(name, _)| name), "real"),
            )
            .replace("HISTORIES", &histories)
            .replace("STARTS", &starts.collect::<String>())
            .replace("FUNCTIONS", &self.functions)
            .replace("TERMS", &terms)
            .replace("KEEP", &literal(list.keep))
            .replace("TINY", &literal(F::NEGLIGIBLE))
            .replace("ADVANCE", &self.advance)
            .replace("FOLLOW", &self.follow)
            .replace("REFUSED", &self.refused)
            .replace("CHANGE", &self.change);
        self.powers.clone() + &common
    }

    /// A power in the struct, by this name.
    fn power<F: CNumber>(&mut self, name: &str, list: &OperatorList<F>) -> Result<(), HeaderError> {
        let code = Operator::new(list)?.code;
        self.powers
            .push_str(&code.replace('@', &format!("@_{name}")));
        self.histories.push(name.to_owned());
        Ok(())
    }

    /// A parameter that is kept as it is.
    fn keeps<F: CNumber>(&mut self, name: &str, value: f64) {
        let start = literal(F::from_f64(value));
        self.parameters.push((name.to_owned(), value));
        self.members.push((name.to_owned(), start));
    }

    /// Refuses new parameters.
    fn refuses(&mut self, condition: &str) {
        self.refused.push_str(&format!("{condition} || "));
    }

    /// A line of the change.
    fn changes(&mut self, line: &str) {
        self.change.push_str(&format!("    {line}\n"));
    }
}

/// A limit of the command: where there is none, the largest number.
fn limit<F: CNumber>(limit: f64) -> f64 {
    limit.clamp(-F::LARGEST, F::LARGEST)
}

/// A branch, as C sees it.
struct Branch<'a, F> {
    own: &'a BranchList<F>,
    /// Its set-point weight is a member: that of all but integrals.
    is_weighted: bool,
    /// Back-calculation may leave it out: a derivative against the others.
    is_optional: bool,
}

impl<F: CNumber> Branch<'_, F> {
    /// What it sees of this reference.
    fn error(&self, reference: &str) -> String {
        match self.is_weighted {
            true => format!("self->{}_weight * {reference} - y", self.own.name),
            false => format!("{reference} - y"),
        }
    }

    /// What it sees when the reference is the one that would have given what was applied.
    fn error_instead(&self) -> String {
        match self.is_optional {
            true => self.error("((self->conditioned > ZERO) ? instead : r)"),
            false => self.error("instead"),
        }
    }
}

fn parallel<F: CNumber>(list: &ParallelList<F>) -> Result<Law, HeaderError> {
    let has_integral = list.branches.iter().any(|branch| branch.order < 0.0);
    let mut law = Law {
        words: "a fractional controller, powers of s side by side.".to_owned(),
        ..Law::default()
    };
    let branches: Vec<Branch<'_, F>> = (list.branches.iter())
        .map(|own| Branch {
            own,
            is_weighted: own.order >= 0.0,
            is_optional: own.order > 0.0 && list.branches.len() > 1,
        })
        .collect();
    for branch in &branches {
        law.keeps::<F>(branch.own.name, branch.own.gain);
    }
    for branch in branches.iter().filter(|branch| branch.is_weighted) {
        law.keeps::<F>(&format!("{}_weight", branch.own.name), branch.own.weight);
    }
    for (index, branch) in branches.iter().enumerate() {
        let (own, name) = (branch.own, branch.own.name);
        let error = branch.error("r");
        let Some(power) = &own.power else {
            law.terms.push(format!("u + self->{name} * ({error})"));
            continue;
        };
        let history = format!("{name}_past");
        law.power(&history, power)?;
        law.terms.push(format!(
            "u + self->{name} * @_{history}_output(&self->{history}, {error})"
        ));
        let advance = format!("    @_{history}_advance(&self->{history}");
        law.advance
            .push_str(&format!("{advance}, {});\n", branch.error_instead()));
        let by_hand = match list.integral {
            // The error with whose integral the command is what was applied.
            Some((integral, _)) if integral == index => {
                format!("({error}) + excess * self->integral_inverse")
            }
            _ => error,
        };
        law.follow.push_str(&format!("{advance}, {by_hand});\n"));
    }
    law.advance.insert_str(
        0,
        "    const real instead = (excess != ZERO) ? (r + excess * self->inverse) : r;\n",
    );
    law.advance
        .push_str("    self->bias = @_faded(self->bias);\n");
    law.follow.push_str(match has_integral {
        true => "    self->bias = @_faded(self->bias);\n",
        false => "    self->bias = self->bias + excess;\n",
    });
    inverses(&mut law, list, &branches);
    Ok(law)
}

/// The numbers that follow from the gains, and how they follow from others: in `double`, as in Rust.
fn inverses<F: CNumber>(law: &mut Law, list: &ParallelList<F>, branches: &[Branch<'_, F>]) {
    law.members
        .push(("inverse".to_owned(), literal(list.inverse)));
    for (name, _) in law.parameters.clone() {
        let gain = if name.ends_with("_weight") {
            ""
        } else {
            &format!("to->{name} == 0e0 || ")
        };
        law.refuses(&format!("{gain}!@_is_finite(to->{name})"));
    }
    let others: Vec<String> = (branches.iter().filter(|branch| branch.own.order <= 0.0))
        .map(|branch| format!("to->{}", branch.own.name))
        .collect();
    for branch in branches {
        let (name, direct) = (branch.own.name, literal(branch.own.direct.to_f64()));
        law.changes(&format!("const double {name} = to->{name} * {direct};"));
    }
    law.changes("double forward = 0e0;");
    for branch in branches {
        let name = branch.own.name;
        let share = match branch.is_weighted {
            true => format!("forward += to->{name}_weight * {name};"),
            false => format!("forward += {name};"),
        };
        if !branch.is_optional {
            law.changes(&share);
            continue;
        }
        let start = if branch.own.conditioned {
            F::ONE
        } else {
            F::ZERO
        };
        law.members.push(("conditioned".to_owned(), literal(start)));
        let one = literal(F::ONE);
        law.changes(&format!(
            "self->conditioned = (({}) * to->{name} >= 0e0) ? {one} : ZERO;",
            others.join(" + ")
        ));
        law.changes(&format!(
            "if (self->conditioned > ZERO) {{\n        {share}\n    }}"
        ));
    }
    law.changes("self->inverse = (real)((forward == 0e0) ? 0e0 : (1e0 / forward));");
    if let Some((index, inverse)) = list.integral {
        law.members
            .push(("integral_inverse".to_owned(), literal(inverse)));
        law.changes(&format!(
            "self->integral_inverse = (real)(1e0 / {});",
            branches[index].own.name
        ));
    }
    for branch in branches {
        let name = branch.own.name;
        law.changes(&format!("self->{name} = (real)to->{name};"));
        if !branch.is_weighted {
            continue;
        }
        let weight = format!("{name}_weight");
        // Another weight: as if the input always had been what it is now.
        let settle = match &branch.own.power {
            None => String::new(),
            Some(power) => {
                let place = if power.filter.is_empty() {
                    ""
                } else {
                    "memory."
                };
                format!(
                    "if (self->{weight} != (real)to->{weight}) {{\n        \
                     @_{name}_past_init(&self->{name}_past);\n        \
                     self->{name}_past.{place}base = (real)to->{weight} * r - y;\n    }}"
                )
            }
        };
        if !settle.is_empty() {
            law.changes(&settle);
        }
        law.changes(&format!("self->{weight} = (real)to->{weight};"));
    }
}

fn lead<F: CNumber>(list: &LeadList<F>) -> Result<Law, HeaderError> {
    let mut law = Law {
        words: "a fractional controller, a power of a lead.".to_owned(),
        ..Law::default()
    };
    let [first, second] = list.factors;
    let gain = list.gain * first * second;
    law.parameters.push(("gain".to_owned(), list.gain));
    law.members
        .push(("gain".to_owned(), literal(F::from_f64(gain))));
    law.members
        .push(("inverse".to_owned(), literal(F::from_f64(1.0 / gain))));
    let (zero, pole) = (literal(list.zero), literal(list.pole));
    let (mut output, mut advance) = (String::new(), String::new());
    for section in 0..list.sections {
        let (before, own) = (format!("before_{section}"), format!("own_{section}"));
        output.push_str(&format!(
            "    s = (s - {zero} * self->{before}) + {pole} * self->{own};\n"
        ));
        advance.push_str(&format!(
            "    next = (s - {zero} * self->{before}) + {pole} * self->{own};\n    \
             self->{before} = s;\n    self->{own} = next;\n    s = next;\n"
        ));
        law.members
            .extend([before, own].map(|name| (name, "ZERO".to_owned())));
    }
    if let Some(memories) = &list.memories {
        law.members.push(("last".to_owned(), "ZERO".to_owned()));
        output.push_str(&format!("    s = s - {zero} * self->last;\n"));
        advance.push_str(&format!(
            "    next = s - {zero} * self->last;\n    self->last = s;\n    s = next;\n"
        ));
        for (index, memory) in memories.iter().enumerate() {
            let name = format!("memory_{index}");
            law.power(&name, memory)?;
            output.push_str(&format!("    s = @_{name}_output(&self->{name}, s);\n"));
            advance.push_str(&format!(
                "    next = @_{name}_output(&self->{name}, s);\n    @_{name}_advance(&self->{name}, s);\n    s = next;\n"
            ));
        }
    }
    law.functions = SHAPED
        .replace("OUTPUT", &output)
        .replace("ADVANCED", &advance);
    // The bias comes last here.
    law.terms = vec!["self->gain * @_shaped(self, r - y) + u".to_owned()];
    law.advance = "    @_take(self, (r - y) + excess * self->inverse);\n    self->bias = @_faded(self->bias);\n".to_owned();
    law.follow = "    self->bias = self->bias + excess;\n    @_take(self, r - y);\n".to_owned();
    law.refuses("to->gain == 0e0 || !@_is_finite(to->gain)");
    let [first, second] = list.factors.map(literal);
    law.changes(&format!(
        "const double gain = to->gain * {first} * {second};"
    ));
    law.changes("self->gain = (real)gain;");
    law.changes("self->inverse = (real)(1e0 / gain);");
    Ok(law)
}

/// The power of a lead, and its history.
const SHAPED: &str = "
/* What the error becomes before its gain. */
static inline real @_shaped(const @_t *self, real x)
{
AS_WRITTEN    real s = x;
OUTPUT    return s;
}

/* Takes an error into the history. */
static inline void @_take(@_t *self, real x)
{
AS_WRITTEN    real s = x;
    real next;
ADVANCED    (void)s;
}
";
