//! The commands: arguments and actions.

pub(crate) mod analyze;
pub(crate) mod conduct;
pub(crate) mod control;
pub(crate) mod design;
pub(crate) mod device;
pub(crate) mod export_c;
pub(crate) mod identify;
pub(crate) mod log;
pub(crate) mod materials;
pub(crate) mod operator;
pub(crate) mod reproduce;
pub(crate) mod rt_check;
pub(crate) mod run;
#[cfg(feature = "serve")]
pub(crate) mod serve;
pub(crate) mod shell;
pub(crate) mod teleoperate;
pub(crate) mod zwidth;

/// Runs the arguments of a command that run themselves, by the names of their variants; the rest as it says.
macro_rules! run_each {
    ($command:expr, $output:expr, [$($name:ident)*] $($rest:tt)*) => {
        match $command {
            $(Self::$name(asked) => asked.run($output),)*
            $($rest)*
        }
    };
}
pub(crate) use run_each;
