//! A controller in C: the law of `fractional-control`, line by line, around its powers.
//!
//! `@` stands for the name, `real` for the number type and words in capitals for what differs, as in the code of an operator.

use crate::{
    error::HeaderError,
    header::{CHeader, Operator},
    number::{CNumber, filled, literal},
};
use fracdiff::OperatorList;
use fractional_control::{
    AVERAGED, BranchList, ControllerList, DEAD_ZONE, LawList, LeadList, MISSED_MOST, ParallelList,
    RANGE_MOST,
};

/// A controller in C, in the parts that differ from law to law.
#[derive(Default)]
struct Law {
    /// Kind of controller, for the comment.
    words: String,
    /// Its powers: tables, structs and functions.
    powers: String,
    /// Those that may be changed, beside the limits.
    parameters: Vec<Parameter>,
    /// Members of the struct beside limits and bias, and what they begin with.
    members: Vec<(String, String)>,
    /// The powers in the struct.
    histories: Vec<String>,
    /// Functions that the others call.
    functions: String,
    terms: Vec<String>,
    /// The histories of a start beside a running plant.
    settle: String,
    /// Updates of the history, by the controller and by hand.
    advance: String,
    follow: String,
    /// New parameters: what is computed from them, what is taken over.
    change: String,
}

/// A number that may be changed while the controller runs.
struct Parameter {
    name: String,
    number: f64,
    /// A gain of 0 is refused: what it multiplies was left out.
    is_gain: bool,
}

impl CHeader {
    /// A controller as `fractional-control` runs it, in `float` or `double`:
    ///
    /// ```text
    /// NAME_t                                                 the controller and the history of its loop
    /// void NAME_init(NAME_t *self)                           at rest, with the parameters of the list
    /// real NAME_settle(NAME_t *self, real r, real y, real u) as if all three had stood for ever, of a lead r = y; the bump that is left,
    ///                                                        or not finite, as r or y, and nothing done
    /// real NAME_output(const NAME_t *self, real r, real y)   the command, within its limits
    /// void NAME_advance(NAME_t *self, real r, real y, real applied)   history, by what was really applied
    /// void NAME_follow(NAME_t *self, real r, real y, real applied)    history, while somebody else commands
    /// real NAME_step(NAME_t *self, real r, real y)           output and advance
    /// int NAME_change(NAME_t *self, const NAME_parameters_t *to, real r, real y)   other gains, no bump
    /// ```
    /// - *Same bits* as in Rust, if C computes as written. `change` computes in `double`, as Rust does, and nothing else.
    /// - *Manual and automatic*: Call `follow` instead of `advance` while the command comes from
    ///   elsewhere.
    /// - *Readings*: while r − y is not a finite number the last command that was applied is held, `advance` and `follow` take nothing
    ///   in, and the member `missed` counts them; the tenth in a row and all that follow give 0.
    /// - *Applied*: what is not finite counts as the output, by hand as what was applied last.
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
        };
        let code = law.code(list);
        Self::assembled::<F>(name, &law.words, notes, USE, &code)
    }
}

const USE: &str = " *
 * @_t is a controller with the history of its loop. @_init(&c) first, then for each sample u = @_output(&c, r, y), which is
 * cheap, for reference r and measurement y, and @_advance(&c, r, y, applied) with what the actuator really did when u has
 * been sent, or NaN if that is unknown; or both as @_step(&c, r, y). By hand: @_follow(&c, r, y, applied) in its place.
 * @_change takes other gains.
 * Beside a plant that runs already: @_settle(&c, y, y, 0) after @_init, with the first reading y and the command that is sent.
 * A reading that is no number: the last command is held and c.missed counts; the tenth in a row and all that follow give 0.
 * The same bits as in Rust: compile with -ffp-contract=off.
 */
";

/// Code that all controllers share; words in capitals are replaced.
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
    real average;
    real applied;
    uint32_t missed;
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

/* A command within the limits. */
static inline real @_limited(const @_t *self, real u)
{
    return (u < self->low) ? self->low : ((u > self->high) ? self->high : u);
}

/* Finite, and so are both. */
static inline int @_is_number(real r, real y)
{
    const real error = r - y;
    return (error - error) == ZERO;
}

/* The command for reference r and measurement y now; changes nothing. */
static inline real @_output(const @_t *self, real r, real y)
{
    if (!@_is_number(r, y)) {
        return (self->missed < MISSED) ? @_limited(self, self->applied) : ZERO;
    }
    return @_limited(self, @_wanted(self, r, y));
}

/* The applied command if it is finite, otherwise the command within its limits. */
static inline real @_told(const @_t *self, real wanted, real applied)
{
    return ((applied - applied) == ZERO) ? applied : @_limited(self, wanted);
}

/* The applied command if it is beyond the dead zone, a limit that nobody told, otherwise the command within its limits. */
static inline real @_given(const @_t *self, real wanted, real applied)
{
AS_WRITTEN    const real command = @_limited(self, wanted);
    const real range = self->high - self->low;
    const real size = (command < ZERO) ? -command : command;
    const real zone = OF_COMMAND * size + OF_RANGE * ((range < FARTHEST) ? range : ZERO);
    const real off = @_told(self, wanted, applied) - command;
    return ((off > zone) || (off < -zone)) ? applied : command;
}

/* True if the clock of an integral stands while its error pushes this way. */
static inline int @_stands(const @_t *self, real wanted, real applied, real push)
{
    const real command = @_limited(self, wanted);
    const real given = @_given(self, wanted, applied);
    const int is_low = (wanted < self->low) && (self->average < self->low);
    const int is_high = (wanted > self->high) && (self->average > self->high);
    return ((push < ZERO) && ((given > command) || is_low)) || ((push > ZERO) && ((given < command) || is_high));
}

/* Starts as if reference, measurement and command had stood for ever. The bump that is left: the next command less this one,
 * where a limit takes it. */
static inline real @_settle(@_t *self, real r, real y, real u)
{
AS_WRITTEN    real wanted;
    real output;
    if (!@_is_number(r, y)) {
        return r - y;
    }
SETTLE    self->bias = ZERO;
    self->average = ZERO;
    wanted = @_wanted(self, r, y);
    self->bias = @_limited(self, @_told(self, wanted, u)) - wanted;
    output = @_output(self, r, y);
    self->applied = @_told(self, output, u);
    self->missed = 0U;
    return output - self->applied;
}

/* Counts what is no number, or keeps what was applied. */
static inline int @_takes(@_t *self, real r, real y, real applied)
{
    if (!@_is_number(r, y)) {
        self->missed += (self->missed < MISSED) ? 1U : 0U;
        return 0;
    }
    self->applied = applied;
    self->missed = 0U;
    return 1;
}

/* A state that fades, or 0 where little is left of it or where it is not finite. */
static inline real @_settled(real state)
{
    return (((state - state) == ZERO) && ((state >= TINY) || (state <= -TINY))) ? state : ZERO;
}

/* Takes the sample into the history, with what was applied: no wind-up at a limit. */
static inline void @_advance(@_t *self, real r, real y, real applied)
{
AS_WRITTEN    const real wanted = @_wanted(self, r, y);
    if (!@_takes(self, r, y, @_told(self, wanted, applied))) {
        return;
    }
    self->average = @_settled(self->average + (wanted - self->average) * SHARE);
ADVANCE    self->bias = @_settled(self->bias * KEEP);
}

/* Tracks a command applied by somebody else: the next output continues from it. The clock of an integral stands. */
static inline void @_follow(@_t *self, real r, real y, real applied)
{
AS_WRITTEN    const real wanted = @_wanted(self, r, y);
    if (!@_takes(self, r, y, ((applied - applied) == ZERO) ? applied : self->applied)) {
        return;
    }
    self->bias = self->bias + (self->applied - wanted);
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
        let parameters = self.parameters.iter();
        // The largest number stands for no limit.
        let limits = list
            .limits
            .map(|limit| limit.clamp(-F::LARGEST, F::LARGEST));
        let numbers = parameters
            .clone()
            .map(|parameter| parameter.number)
            .chain(limits);
        let numbers: Vec<String> = numbers.map(literal).collect();
        let refused = parameters.clone().map(|Parameter { name, is_gain, .. }| {
            let zero = format!("to->{name} == 0e0 || ");
            let zero = if *is_gain { &*zero } else { "" };
            format!("{zero}!@_is_finite(to->{name}) || ")
        });
        let parameters = parameters.map(|parameter| format!("    double {};\n", parameter.name));
        let members = self
            .members
            .iter()
            .map(|(name, _)| format!("    real {name};\n"));
        let starts = (self.members.iter())
            .map(|(name, start)| format!("    self->{name} = {start};\n"))
            .chain(["low", "high"].iter().zip(limits).map(|(name, limit)| {
                format!("    self->{name} = {};\n", literal(F::from_f64(limit)))
            }))
            .chain([
                "    self->bias = ZERO;\n    self->average = ZERO;\n    self->applied = ZERO;\n    self->missed = 0U;\n"
                    .to_owned(),
            ])
            .chain(
                (self.histories.iter()).map(|name| format!("    @_{name}_init(&self->{name});\n")),
            );
        let histories = (self.histories.iter()).map(|name| format!("    @_{name}_t {name};\n"));
        let terms = self.terms.iter().map(|term| format!("    u = {term};\n"));
        let [of_command, of_range] = DEAD_ZONE.map(F::from_f64).map(literal);
        let words: [(&str, String); 19] = [
            ("PARAMETERS", parameters.collect()),
            ("NUMBERS", numbers.join(", ")),
            ("MEMBERS", members.collect()),
            ("HISTORIES", histories.collect()),
            ("STARTS", starts.collect()),
            ("FUNCTIONS", self.functions.clone()),
            ("TERMS", terms.collect()),
            ("SETTLE", self.settle.clone()),
            ("OF_COMMAND", of_command),
            ("OF_RANGE", of_range),
            ("FARTHEST", literal(F::from_f64(RANGE_MOST))),
            ("SHARE", literal(F::from_f64(1.0 / AVERAGED))),
            ("MISSED", format!("{}U", MISSED_MOST - 1)),
            ("KEEP", literal(list.keep)),
            ("TINY", literal(F::NEGLIGIBLE)),
            ("ADVANCE", self.advance.clone()),
            ("FOLLOW", self.follow.clone()),
            ("REFUSED", refused.collect()),
            ("CHANGE", self.change.clone()),
        ];
        self.powers.clone() + &filled(COMMON, &words)
    }

    /// A power in the struct, by this name.
    fn power<F: CNumber>(&mut self, name: &str, list: &OperatorList<F>) -> Result<(), HeaderError> {
        let code = Operator::new(list)?.code;
        self.powers
            .push_str(&code.replace('@', &format!("@_{name}")));
        self.histories.push(name.to_owned());
        Ok(())
    }

    /// A parameter that is also a member as it is.
    fn keeps<F: CNumber>(&mut self, name: String, number: f64, is_gain: bool) {
        let start = literal(F::from_f64(number));
        self.members.push((name.clone(), start));
        self.parameters.push(Parameter {
            name,
            number,
            is_gain,
        });
    }

    /// A line of the change.
    fn changes(&mut self, line: &str) {
        self.change.push_str(&format!("    {line}\n"));
    }
}

/// The set-point weight of a branch is a member, unless it integrates.
fn is_weighted<F>(branch: &BranchList<F>) -> bool {
    branch.order >= 0.0
}

/// Input of a branch, in C.
fn error<F>(branch: &BranchList<F>) -> String {
    if is_weighted(branch) {
        format!("self->{}_weight * r - y", branch.name)
    } else {
        "r - y".to_owned()
    }
}

/// The history of a derivative becomes that of an input which has always been what it sees now.
fn settled<F>(branch: &BranchList<F>, power: &OperatorList<F>) -> String {
    let (name, error) = (branch.name, error(branch));
    // A filter stands behind the memory, in a struct around both.
    let memory = if power.filter.is_empty() {
        ""
    } else {
        ".memory"
    };
    format!(
        "@_{name}_past_init(&self->{name}_past);\n    self->{name}_past{memory}.base = {error};"
    )
}

fn parallel<F: CNumber>(list: &ParallelList<F>) -> Result<Law, HeaderError> {
    let mut law = Law {
        words: "a fractional controller, powers of s side by side.".to_owned(),
        ..Law::default()
    };
    for branch in &list.branches {
        law.keeps::<F>(branch.name.to_owned(), branch.gain, true);
    }
    for branch in list.branches.iter().filter(|branch| is_weighted(branch)) {
        law.keeps::<F>(format!("{}_weight", branch.name), branch.weight, false);
    }
    for branch in &list.branches {
        let (name, error) = (branch.name, error(branch));
        let Some(power) = &branch.power else {
            law.terms.push(format!("u + self->{name} * ({error})"));
            continue;
        };
        let history = format!("{name}_past");
        law.power(&history, power)?;
        law.terms.push(format!(
            "u + self->{name} * @_{history}_output(&self->{history}, {error})"
        ));
        let advance = format!("    @_{history}_advance(&self->{history}, {error});\n");
        if is_weighted(branch) {
            law.settle
                .push_str(&format!("    {}\n", settled(branch, power)));
            law.follow.push_str(&advance);
            law.advance.push_str(&advance);
        } else {
            let init = format!("    @_{history}_init(&self->{history});\n");
            law.settle.push_str(&init);
            // Its clock stands while it pushes on.
            let stands = format!("@_stands(self, wanted, applied, self->{name} * ({error}))");
            law.advance
                .push_str(&format!("    if (!{stands}) {{\n    {advance}    }}\n"));
        }
    }
    changes(&mut law, &list.branches);
    Ok(law)
}

/// Gains and weights that are taken while it runs.
fn changes<F: CNumber>(law: &mut Law, branches: &[BranchList<F>]) {
    for branch in branches {
        let name = branch.name;
        law.changes(&format!("self->{name} = (real)to->{name};"));
        if !is_weighted(branch) {
            continue;
        }
        let weight = format!("{name}_weight");
        let Some(power) = &branch.power else {
            law.changes(&format!("self->{weight} = (real)to->{weight};"));
            continue;
        };
        // Another weight: as if the input always had been what it is now.
        let settled = settled(branch, power).replace('\n', "\n    ");
        law.changes(&format!(
            "if (self->{weight} != (real)to->{weight}) {{\n        \
             self->{weight} = (real)to->{weight};\n        {settled}\n    }}"
        ));
    }
}

fn lead<F: CNumber>(list: &LeadList<F>) -> Result<Law, HeaderError> {
    let mut law = Law {
        words: "a fractional controller, a power of a lead.".to_owned(),
        ..Law::default()
    };
    let [first, second] = list.factors;
    let gain = list.gain * first * second;
    law.parameters.push(Parameter {
        name: "gain".to_owned(),
        number: list.gain,
        is_gain: true,
    });
    law.members
        .push(("gain".to_owned(), literal(F::from_f64(gain))));
    let (zero, pole) = (literal(list.zero), literal(list.pole));
    let (mut output, mut advance) = (String::new(), String::new());
    for section in 0..list.sections {
        let (before, last) = (format!("before_{section}"), format!("own_{section}"));
        output.push_str(&format!(
            "    s = (s - {zero} * self->{before}) + {pole} * self->{last};\n"
        ));
        advance.push_str(&format!(
            "    next = (s - {zero} * self->{before}) + {pole} * self->{last};\n    \
             self->{before} = s;\n    self->{last} = next;\n    s = next;\n"
        ));
        let rest = format!("    self->{before} = ZERO;\n    self->{last} = ZERO;\n");
        law.settle.push_str(&rest);
        law.members
            .extend([before, last].map(|name| (name, "ZERO".to_owned())));
    }
    if let Some(memories) = &list.memories {
        law.members.push(("last".to_owned(), "ZERO".to_owned()));
        output.push_str(&format!("    s = s - {zero} * self->last;\n"));
        advance.push_str(&format!(
            "    next = s - {zero} * self->last;\n    self->last = s;\n    s = next;\n"
        ));
        law.settle.push_str("    self->last = ZERO;\n");
        for (index, memory) in memories.iter().enumerate() {
            let name = format!("memory_{index}");
            law.power(&name, memory)?;
            let rest = format!("    @_{name}_init(&self->{name});\n");
            law.settle.push_str(&rest);
            output.push_str(&format!("    s = @_{name}_output(&self->{name}, s);\n"));
            advance.push_str(&format!(
                "    next = @_{name}_output(&self->{name}, s);\n    @_{name}_advance(&self->{name}, s);\n    s = next;\n"
            ));
        }
    }
    law.functions = filled(SHAPED, &[("OUTPUT", output), ("ADVANCED", advance)]);
    // The bias comes last here.
    law.terms = vec!["self->gain * @_shaped(self, r - y) + u".to_owned()];
    law.advance =
        "    @_take(self, (r - y) + (@_given(self, wanted, applied) - wanted) / self->gain);\n"
            .to_owned();
    law.follow = "    @_take(self, r - y);\n".to_owned();
    let [first, second] = list.factors.map(literal);
    law.changes(&format!(
        "const double gain = to->gain * {first} * {second};"
    ));
    law.changes("self->gain = (real)gain;");
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
