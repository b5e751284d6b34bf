//! Lengths inside a record, checked before the parser of the MCAP library believes them.

use mcap::records::op;

/// True if the texts and maps of a record end at the end of its bytes, or before. The parser takes their lengths on
/// trust and asks for up to 4 GiB.
pub(super) fn texts_fit(opcode: u8, data: &[u8]) -> bool {
    let mut rest = Rest(data);
    let fit = match opcode {
        op::HEADER => rest.text().and_then(|()| rest.text()),
        // Two numbers of the channel and its schema first.
        op::CHANNEL => (rest.take(4))
            .and_then(|_| rest.text())
            .and_then(|()| rest.text())
            .and_then(|()| rest.map()),
        op::METADATA => rest.text().and_then(|()| rest.map()),
        _ => Some(()),
    };
    fit.is_some()
}

/// A chunk without what stands behind its records. The parser of a chunk that is not compressed takes that for a part of its last record,
/// and subtracts what is not there.
pub(super) fn unpadded(chunk: &[u8]) -> &[u8] {
    let mut rest = Rest(chunk);
    // Times, size and sum first; then the compression, and the records behind their number of bytes.
    let behind = (rest.take(28))
        .and_then(|_| rest.text())
        .and_then(|()| rest.0.split_first_chunk())
        .and_then(|(length, records)| {
            let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
            records.get(length..)
        });
    let padding = behind.map_or(0, <[u8]>::len);
    &chunk[..chunk.len() - padding]
}

/// Rest of a record.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    /// Bytes behind their number.
    fn counted(&mut self) -> Option<&'a [u8]> {
        let (length, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        self.take(u32::from_le_bytes(*length) as usize)
    }

    fn text(&mut self) -> Option<()> {
        self.counted().map(|_| ())
    }

    fn map(&mut self) -> Option<()> {
        let mut pairs = Rest(self.counted()?);
        while !pairs.0.is_empty() {
            pairs.text()?;
            pairs.text()?;
        }
        Some(())
    }
}
