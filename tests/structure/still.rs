//! STILL ALLOWED: what the house is to get rid of. The list shrinks to nothing; nothing is added to it.

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Rule {
    /// Modules that import each other in a circle.
    Circle,
    /// The parser of command lines.
    Clap,
    /// Standard output and standard error.
    Print,
    /// The arguments of the process.
    Arguments,
    /// A text that names an option of the command.
    Flag,
    /// A sentence that is taken apart, or in which a key of a document is a word and not a value.
    Sentence,
    /// A crate that uses another, named in place of the module, which the table of arrows does not allow.
    Arrow,
    /// A room of a crate that uses one above it.
    Room,
}

/// Rule, crate, module: what is still allowed and has to go. An entry that nothing needs any more fails the test.
pub(crate) const STILL: &[(Rule, &str, &str)] = &[];
