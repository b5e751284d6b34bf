//! Bytes as a list of things to do to a device. Every list of bytes is one, and none depends on how many
//! fields a message has, so that a corpus outlives a change of the messages.

/// One thing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<'a> {
    /// This many ticks, each this many periods after the one before.
    Ticks { count: u8, periods: u8 },
    /// A good frame around whatever bytes: the fuzzer writes the message itself.
    Frame(&'a [u8]),
    /// Bytes on the line.
    Noise(&'a [u8]),
    /// Stages a good configuration, of a loop on the host or on the device, with some of its bytes on the wire
    /// replaced: pairs of place and value.
    Configure { host_loop: bool, patches: &'a [u8] },
    /// Stages this block of coefficients: eighths of a signed byte.
    Coefficients { block: u8, values: &'a [u8] },
    /// Commits with the right digest of what is staged.
    Commit,
    /// Arms, knowing of all faults.
    Arm,
    /// Starts a run; 0 ticks for ever.
    Start { ticks: u8, batch: u8 },
    /// A force for a loop on the host, in eighths of a newton.
    Force(i8),
    /// A keep-alive.
    KeepAlive,
    /// The host's frames skip this many numbers, or come twice.
    Skip(i8),
}

/// The steps in a list of bytes.
#[derive(Clone, Debug)]
pub struct Steps<'a>(pub &'a [u8]);

impl<'a> Steps<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// A length, and so many bytes, or what is left.
    fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = usize::from(self.byte()?).min(self.0.len());
        let (taken, rest) = self.0.split_at(length);
        self.0 = rest;
        Some(taken)
    }
}

impl<'a> Iterator for Steps<'a> {
    type Item = Step<'a>;

    fn next(&mut self) -> Option<Step<'a>> {
        Some(match self.byte()? % 12 {
            0 => Step::Ticks {
                count: self.byte()?,
                periods: 1,
            },
            1 => Step::Ticks {
                count: self.byte()? % 32,
                periods: self.byte()?,
            },
            2 => Step::Frame(self.bytes()?),
            3 => Step::Noise(self.bytes()?),
            4 => Step::Configure {
                host_loop: self.byte()? & 1 == 1,
                patches: self.bytes()?,
            },
            5 => Step::Coefficients {
                block: self.byte()?,
                values: self.bytes()?,
            },
            6 => Step::Commit,
            7 => Step::Arm,
            8 => Step::Start {
                ticks: self.byte()?,
                batch: self.byte()?,
            },
            9 => Step::Force(self.byte()? as i8),
            10 => Step::KeepAlive,
            _ => Step::Skip(self.byte()? as i8),
        })
    }
}
