//! `host-cli`: parse, run, map the error to an exit code.

fn main() -> std::process::ExitCode {
    host_cli::main()
}
