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
    /// A crate that uses another, named in place of the module, which the table of arrows does not allow.
    Arrow,
}

/// Rule, crate, module: what is still allowed and has to go. An entry that nothing needs any more fails the test.
pub(crate) const STILL: &[(Rule, &str, &str)] = &[
    (Rule::Circle, "fracdiff", "scheme"),
    (Rule::Circle, "fracdiff", "scheme::operator"),
    (Rule::Circle, "haptic-log", "record::inspect"),
    (Rule::Circle, "haptic-log", "record::recover"),
    (Rule::Circle, "haptic-remote", "emulator"),
    (Rule::Circle, "haptic-remote", "emulator::terminal"),
    (Rule::Circle, "haptic-remote", "serial"),
    (Rule::Circle, "haptic-remote", "serial::greeting"),
    (Rule::Circle, "haptic-remote", "serial::threads"),
    (Rule::Circle, "host-cli", "command::device"),
    (Rule::Circle, "host-cli", "command::device::flash"),
    (Rule::Circle, "host-cli", "command::device::info"),
    (Rule::Circle, "host-cli", "command::device::monitor"),
    (Rule::Circle, "host-cli", "command::device::set"),
];
