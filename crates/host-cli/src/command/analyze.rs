//! `analyze`: what is stable, passive and transparent, before any hardware.

mod draw;

use crate::command::conduct::answered;
use crate::files::Place;
use crate::options::keys::Named;
use crate::options::{Options, WithFiles, keys};
use crate::output::Output;
use clap::{Args, Subcommand};
use haptic_experiment::Failure;
use haptic_experiment::question::Answer;
use serde_json::json;
use std::sync::Arc;

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Judge a robot that moves: a virtual body, for every hand and every wall between two
    ///
    /// A robot takes a velocity and measures a force. The law is a virtual body m*D^alpha + b in a
    /// virtual world. The verdict is a proof for all hands, from free space to the wall or tissue
    /// that is given: a body that is stable in free space may not be at a soft wall.
    #[command(
        after_help = "Example: host-cli analyze admittance --body-inertance 4 --body-order 0.7 --body-damping 0.5 \
                      --bandwidth 10Hz --dead-time 4ms --force-cutoff 30Hz --sample-time 2ms --stiffness 500 --out robot"
    )]
    Admittance(WithFiles<keys::Admittance>),
    /// Compute effective stiffness and damping of a virtual environment
    #[command(
        after_help = "Example: host-cli analyze environment --order 0.5 --stiffness 10N/mm --dissipation 100 \
                      --sample-time 1ms --out environment"
    )]
    Environment(WithFiles<keys::Environment>),
    /// Judge whether a wall is stable
    #[command(
        after_help = "Example: host-cli analyze stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms \
                      --stiffness 3N/mm --dissipation 100"
    )]
    Stability(Options<keys::Stability>),
    /// Find all stable walls: the region in the alpha-beta plane
    #[command(
        after_help = "Example: host-cli analyze stability-region --order 1 --mass 65g --damping 3.5 --sample-time 1ms \
                      --delay-samples 1 --out region"
    )]
    StabilityRegion(WithFiles<keys::Stability>),
    /// Judge whether a wall is passive, and how much damping that needs
    #[command(
        after_help = "Example: host-cli analyze passivity --order 0.5 --scheme muir:3 --mass 65g --damping 3.5 \
                      --sample-time 1ms --stiffness 3N/mm --dissipation 10"
    )]
    Passivity(Options<keys::Stability>),
    /// Judge whether a virtual coupler is passive on both sides, and how much damping that needs
    #[command(
        after_help = "Example: host-cli analyze coupling --order 0.75 --coupler-damping 1 --coupler-spring 200 \
                      --sample-time 1ms --damping 0.5"
    )]
    Coupling(Options<keys::Coupling>),
    /// Judge a teleoperation: stable up to which delay, what the hand feels, and the best coupler
    ///
    /// It is stable if it meets Llewellyn's criterion, with the line's delay and the hold: then it
    /// is stable with every passive hand and every passive environment.
    ///
    /// --best finds, for each order, the coupler that feels closest to the tissue from --low to
    /// --high and meets the criterion at this delay. The error is the rms of |ln(Z felt / Z tissue)|:
    /// 0.1 is 10 % or 6 degrees. For waves it finds the impedance.
    ///
    /// time-domain is not linear: analyze position-position instead, and try it with `host-cli
    /// run`.
    #[command(
        after_help = "Examples:\n  host-cli analyze teleoperation --coupler-stiffness 300 --coupler-dissipation 10 \
                      --order 0.5 --line-delay 20ms\n  host-cli analyze teleoperation --line-delay 20ms --best --out far"
    )]
    Teleoperation(WithFiles<keys::Hands>),
    /// Compute effective stiffness and damping of the closed loop, as the hand feels them
    #[command(
        after_help = "Example: host-cli analyze transparency --order 0.5 --stiffness 50 --dissipation 1 --mass 0.65kg \
                      --damping 3.5 --sample-time 1ms --out transparency"
    )]
    Transparency(WithFiles<keys::Transparency>),
    /// Predict whether a hand feels the difference of two laws, or of a law and the best spring and damper
    ///
    /// Each file has [wall], as `design` writes it, or a table of these options' keys. A difference
    /// above 1 is more than the share of the force that a hand notices. It is a prediction.
    #[command(
        after_help = "Examples:\n  host-cli analyze difference A.toml B.toml --out difference\n  \
                      host-cli analyze difference --order 0.5 --stiffness 300 --dissipation 20 --mass 65g --damping 0.5 \
                      --sample-time 1ms --weber-share 15%"
    )]
    Difference(TwoLaws),
    /// Compute how much the loop amplifies model errors: |1/(1 + GH)|
    #[command(
        after_help = "Example: host-cli analyze sensitivity --order 0.5 --mass 65g --damping 3.5 --sample-time 1ms \
                      --stiffness 3N/mm --dissipation 100 --out sensitivity"
    )]
    Sensitivity(WithFiles<keys::Sensitivity>),
}

/// Laws in files, or one of them by its keys.
#[derive(Debug, Args)]
pub(crate) struct TwoLaws {
    /// Files of the law that the hand knows and of the other one
    #[arg(value_name = "FILE", num_args = 0..=2)]
    laws: Vec<String>,
    #[command(flatten)]
    asked: WithFiles<keys::Difference>,
}

impl TwoLaws {
    fn asked(self) -> WithFiles<keys::Difference> {
        let mut asked = self.asked;
        for (law, key) in self.laws.iter().zip(["law", "other"]) {
            asked.options = asked.options.and(&format!("{key}={law}"));
        }
        asked
    }
}

impl Command {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::Admittance(asked) => kept("admittance", asked, output),
            Self::Environment(asked) => kept("environment", asked, output),
            Self::Stability(options) => answer("stability", options, None, output),
            Self::StabilityRegion(asked) => kept("stability-region", asked, output),
            Self::Passivity(options) => answer("passivity", options, None, output),
            Self::Coupling(options) => answer("coupling", options, None, output),
            Self::Teleoperation(asked) => kept("teleoperation", asked, output),
            Self::Transparency(asked) => kept("transparency", asked, output),
            Self::Difference(laws) => kept("difference", laws.asked(), output),
            Self::Sensitivity(asked) => kept("sensitivity", asked, output),
        }
    }
}

fn kept<N: Named>(name: &str, asked: WithFiles<N>, output: Output) -> Result<(), Failure> {
    let stem = name.strip_prefix("stability-").unwrap_or(name);
    let outputs = asked.files.look(stem, &[])?;
    let seeks = !asked.options.leaves_out("best");
    asked
        .files
        .pictures
        .check(|| Some(draw::rehearsed(name, seeks)))?;
    answer(name, asked.options, Some(outputs), output)
}

fn answer<N: Named>(
    name: &str,
    options: Options<N>,
    outputs: Option<Place>,
    output: Output,
) -> Result<(), Failure> {
    let kind = format!("analyze-{name}");
    let answer = answered(&kind, options, &Arc::default(), output)?;
    let mut report = json!(answer);
    let Some(mut outputs) = outputs else {
        return output.report(&report);
    };
    let mut files = Vec::new();
    if let Answer::Analysis(found) = &answer
        && let Some(drawn) = &found.drawn
    {
        files.extend(outputs.write(|folder| answer.write_table(folder)).flatten());
        files.extend(outputs.picture(|| draw::draw(drawn, &found.about)));
    }
    report["files"] = json!(files);
    output.report(&report)?;
    outputs.close(Ok(()))
}
