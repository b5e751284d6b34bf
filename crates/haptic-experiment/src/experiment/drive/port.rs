//! The rig in contact as a loop sees it: from sample to sample, its command by any time late.

use crate::document::advice::parameter;
use crate::document::failure::Failure;
use fracdiff::Seconds;
use fractional_control::TwoPort;
use haptic_loop::plant::{IndentationRig, RigConfig, RigContact, RigDrive, RigMotion};
use haptic_loop::units::Newtons;
use nalgebra::{DMatrix, DVector, RowDVector, Vector4};

/// Parts of a sample smaller than this are none.
const NO_PART: f64 = 1e-9;

/// A rig whose command acts later, by whole samples and a part of one.
#[derive(Debug)]
pub(super) struct LatePort {
    /// Both masses in contact: the controller pushes the indenter, the tissue feels and pushes the renderer. Velocities in m a sample.
    ///
    /// With a part h of a sample the command of before acts first, and is a state more:
    ///
    /// ```text
    /// x[n+1] = Φx[n] + Γ((1−h)T)·u[n] + Φ((1−h)T)Γ(hT)·u[n−1] + Γ_f f[n]
    /// ```
    pub(super) port: TwoPort,
    /// Whole samples beside that.
    pub(super) samples: usize,
}

impl LatePort {
    /// Of this rig, the force on the indenter so many seconds late.
    ///
    /// # Errors
    /// A rig that cannot be run.
    pub(super) fn new(rig: &RigConfig, delay_s: f64) -> Result<Self, Failure> {
        let Seconds(t) = rig.sample_time;
        let samples = delay_s / t;
        let near = samples.round();
        let samples = if (samples - near).abs() < NO_PART {
            near
        } else {
            samples
        };
        let part = samples - samples.floor();
        let motion = |share: f64| motion(rig, share * t);
        let whole = motion(1.0)?;
        let commands = if part > 0.0 {
            let (late, early) = (motion(1.0 - part)?, motion(part)?);
            vec![late.indenter, late.transition * early.indenter]
        } else {
            vec![whole.indenter]
        };
        Ok(Self {
            port: port(rig, &whole, &commands),
            samples: samples.floor() as usize,
        })
    }
}

/// In contact, over a time in s.
fn motion(rig: &RigConfig, time_s: f64) -> Result<RigMotion, Failure> {
    let pushed = RigConfig {
        drive: RigDrive::Force(Newtons(0.0)),
        sample_time: Seconds(time_s),
        ..*rig
    };
    Ok(IndentationRig::new(pushed).map_err(parameter)?.motion(true))
}

/// With what the command does in its own sample, and what it does in the next if it comes late.
fn port(rig: &RigConfig, whole: &RigMotion, commands: &[Vector4<f64>]) -> TwoPort {
    let Seconds(t) = rig.sample_time;
    let units = [1.0, 1.0 / t, 1.0, 1.0 / t];
    let measured = match (rig.drive, rig.contact) {
        (RigDrive::Force(_), RigContact::Compliant { stiffness, damping }) => {
            // F = k·p + c·p'
            let (k, c) = (stiffness.0, damping.0);
            [-k, -c, k, c]
        }
        _ => [0.0, 0.0, 1.0, 0.0],
    };
    // The four of the motion, then the command of before.
    let states = 3 + commands.len();
    let input = |v: &Vector4<f64>, kept: f64| {
        DVector::from_fn(states, |row, _| {
            units.get(row).map_or(kept, |unit| v[row] / unit)
        })
    };
    let output = |v: [f64; 4]| {
        RowDVector::from_fn(states, |_, column| {
            units.get(column).map_or(0.0, |unit| v[column] * unit)
        })
    };
    TwoPort {
        transition: DMatrix::from_fn(states, states, |row, column| {
            match (units.get(row), units.get(column)) {
                (Some(own), Some(unit)) => whole.transition[(row, column)] * unit / own,
                (Some(own), None) => commands[1][row] / own,
                _ => 0.0,
            }
        }),
        command: input(&commands[0], 1.0),
        load: input(&whole.renderer, 0.0),
        measured: output(measured),
        felt: output([1.0, 0.0, 0.0, 0.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight steps of an eighth of a sample, three of them with the command of before.
    #[test]
    fn a_command_that_comes_late_acts_as_in_small_steps() {
        let rig = RigConfig::new(
            RigDrive::Force(Newtons(0.0)),
            RigContact::COMPLIANT,
            Seconds(2e-3),
        );
        let small = motion(&rig, 2.5e-4).expect("runs");
        let late = LatePort::new(&rig, 2e-3 * 5.375).expect("runs");
        assert_eq!(late.samples, 5);
        let units = [1.0, 500.0, 1.0, 500.0];
        let from = Vector4::new(1e-3, -0.2, 1.5e-3, 0.3);
        let (before, now, load) = (1.7, -0.6, 0.4);
        let mut want = from;
        for part in 0..8 {
            let command = if part < 3 { before } else { now };
            want = small.transition * want + small.indenter * command + small.renderer * load;
        }
        let state = DVector::from_fn(5, |row, _| {
            units.get(row).map_or(before, |unit| from[row] / unit)
        });
        let port = &late.port;
        let have = &port.transition * state + &port.command * now + &port.load * load;
        for (row, unit) in units.iter().enumerate() {
            let (have, want) = (have[row] * unit, want[row]);
            assert!(
                (have - want).abs() < 1e-12 * want.abs().max(1.0),
                "{row}: {have} {want}"
            );
        }
        assert!((have[4] - now).abs() <= 0.0);
    }
}
