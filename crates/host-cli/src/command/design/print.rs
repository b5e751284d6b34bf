//! The answer as a person reads it.

use haptic_experiment::question::design::{Candidate, DesignReport};
use std::io::{self, Write};

/// Text after a space and in brackets; nothing for none.
fn in_brackets(text: Option<String>) -> String {
    text.map_or_else(String::new, |text| format!(" ({text})"))
}

/// The answer as a person reads it.
pub(super) fn print(out: &mut dyn Write, report: &DesignReport) -> io::Result<()> {
    let frequency = report.frequency_hz;
    writeln!(out, "device: {}", report.asked)?;
    write!(
        out,
        "{:>6} {:>16} {:>16} {:>10} {:>8}",
        "order", "K / N/m", "B / N·s^μ/m", "margin", "passive"
    )?;
    let noisy = !report.imperfections.sensors.are_ideal();
    if noisy {
        write!(out, " {:>14}", "noise / N rms")?;
    }
    match (frequency, &report.tissue) {
        (Some(_), Some(_)) => writeln!(out, " {:>16}", "largest scale")?,
        (Some(frequency), None) => writeln!(out, " {:>16}", format!("ED({frequency} Hz)"))?,
        _ => writeln!(out)?,
    }
    for candidate in &report.candidates {
        print_candidate(out, report, candidate)?;
    }
    print_verdicts(out, report)?;
    for note in &report.notes {
        writeln!(out, "{note}")?;
    }
    if let Some(experiment) = &report.experiment {
        writeln!(
            out,
            "written: {experiment} (try it: host-cli run {experiment})"
        )?;
    }
    report
        .files
        .iter()
        .try_for_each(|file| writeln!(out, "written: {file}"))
}

/// Its line of the table.
fn print_candidate(
    out: &mut dyn Write,
    report: &DesignReport,
    candidate: &Candidate,
) -> io::Result<()> {
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.6}"));
    if candidate.stiffness.is_none() {
        let reason = candidate.reason.as_deref().unwrap_or("–");
        writeln!(out, "{:>6} {reason}", candidate.order)?;
        return Ok(());
    }
    write!(
        out,
        "{:>6} {:>16} {:>16} {:>10} {:>8}",
        candidate.order,
        number(candidate.stiffness),
        number(candidate.dissipation),
        number(candidate.margin),
        match candidate.passive {
            Some(true) => "yes",
            Some(false) => "no",
            None => "–",
        }
    )?;
    if !report.imperfections.sensors.are_ideal() {
        write!(out, " {:>14}", number(candidate.force_noise_rms_n))?;
    }
    match (report.frequency_hz, &report.tissue) {
        (Some(_), Some(_)) => writeln!(out, " {:>16}", number(candidate.largest_scale))?,
        (Some(_), None) => {
            writeln!(
                out,
                " {:>16}",
                number(candidate.effective_damping_n_s_per_m)
            )?;
        }
        _ => writeln!(out)?,
    }
    Ok(())
}

/// The lines below the table: tissue, best, trial, device.
fn print_verdicts(out: &mut dyn Write, report: &DesignReport) -> io::Result<()> {
    if let Some(tissue) = &report.tissue {
        writeln!(
            out,
            "{} at its own order {}: {}",
            tissue.name,
            tissue.order,
            match (tissue.fits, tissue.largest_scale) {
                (true, Some(scale)) =>
                    format!("fits; the specimen may be {scale:.4} times as large"),
                (_, Some(scale)) => format!("does not fit; {scale:.4} of the specimen would"),
                _ => "does not fit at any size".to_owned(),
            }
        )?;
    }
    match (&report.best, &report.simulated) {
        (Some(best), Some(simulated)) => writeln!(
            out,
            "best: order {}, {} when tried on the simulated device{}",
            best.order,
            simulated.verdict.words(),
            in_brackets(simulated.reason())
        )?,
        _ => writeln!(out, "best: none")?,
    }
    writeln!(
        out,
        "{}",
        if report.ideal_device_assumed {
            "an ideal device was assumed: no friction, delay, current lag or encoder steps"
                .to_owned()
        } else {
            format!("device with {}", report.imperfections.words())
        }
    )?;
    if let Some(real) = &report.realistic {
        writeln!(
            out,
            "on a realistic one ({}) the best is {} by the analysis{} and {} when tried{}, with {:.2e} N rms of force \
             noise; --device-model laboratory designs for such a device",
            real.imperfections.words(),
            if real.analysis_stable {
                "stable"
            } else {
                "unstable"
            },
            in_brackets(real.margin.map(|margin| format!("margin {margin:.3}"))),
            real.simulated.verdict.words(),
            in_brackets(real.simulated.reason()),
            real.force_noise_rms_n
        )?;
    }
    Ok(())
}
