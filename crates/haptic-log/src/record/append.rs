//! The verdict on a run, as a metadata record behind the others of its finished log: it is known only once the log is whole.
//! ```text
//! … chunks │ DataEnd │ summary │ offsets │ footer     becomes     … chunks │ Metadata │ DataEnd │ summary, one index more │ footer
//! ```
//! Everything behind the chunks is written anew, so it costs the size of the index, not of the log. No sample is touched: a power cut in
//! between leaves a log that ends behind its last chunk. The checksum of the data section, if it has one, is continued over the new record.

use std::{
    fs::File,
    io::{self, Read as _, Seek as _, SeekFrom, Write as _},
    path::Path,
};

use super::{RecordError, new_file::open_to_change};
use mcap::records::op;

/// Name of the metadata record with the verdict on a run, under the key of the same name.
pub const VERDICT: &str = "verdict";

/// Opcode and length of a record.
const HEAD: usize = 9;
const DATA_END: usize = HEAD + 4;
const FOOTER: usize = HEAD + 20;
/// Footer and magic bytes.
const TAIL: usize = FOOTER + 8;
/// Place of the number of metadata records in the record of the statistics.
const METADATA_COUNT: usize = HEAD + 18;

/// Adds the verdict to a finished log, or to the last file of one in several.
///
/// # Errors
/// A file that is no finished log, or cannot be written.
pub fn add_verdict(path: &Path, verdict: &str) -> Result<(), RecordError> {
    appended(open_to_change(path)?, verdict).map_err(|source| RecordError::Write {
        path: path.to_owned(),
        samples_safe: 0,
        source,
    })
}

fn appended(mut file: File, verdict: &str) -> io::Result<()> {
    let mut tail = [0; TAIL];
    file.seek(SeekFrom::End(-(TAIL as i64)))?;
    file.read_exact(&mut tail)?;
    let [summary, offsets] = [HEAD, HEAD + 8].map(|at| number(&tail, at));
    let data_end = summary.saturating_sub(DATA_END as u64);
    let mut rest = Vec::new();
    file.seek(SeekFrom::Start(data_end))?;
    file.read_to_end(&mut rest)?;
    // The offsets at its end are optional, and would all have moved.
    let length = match offsets {
        0 => rest.len().saturating_sub(TAIL),
        _ => offsets.saturating_sub(data_end) as usize,
    };
    let sum = rest.get(HEAD..DATA_END).and_then(<[u8]>::first_chunk);
    let sum = sum.map_or(0, |sum| u32::from_le_bytes(*sum));
    // The footer of a log without a summary leads to the beginning of the file, which must stay.
    let is_log =
        rest.first() == Some(&op::DATA_END) && tail[0] == op::FOOTER && tail.ends_with(mcap::MAGIC);
    let index = rest.get_mut(DATA_END..length);
    let Some(index) = index.filter(|_| is_log) else {
        return Err(io::Error::other("it is not a finished log"));
    };
    count_one_more(index);
    let name = text(VERDICT);
    let pair = [&name[..], &text(verdict)].concat();
    let length = (pair.len() as u32).to_le_bytes();
    let metadata = record(op::METADATA, &[&name, &length, &pair]);
    let length = (metadata.len() as u64).to_le_bytes();
    let place = record(
        op::METADATA_INDEX,
        &[&data_end.to_le_bytes(), &length, &name],
    );
    // A missing checksum is written as 0.
    let sum = match sum {
        0 => 0,
        sum => checksum(sum, &metadata),
    };
    let before = [metadata, record(op::DATA_END, &[&sum.to_le_bytes()])].concat();
    let summary = data_end + before.len() as u64;
    let footer = record(op::FOOTER, &[&summary.to_le_bytes(), &[0; 12]]);
    let (footer, _) = footer.split_at(FOOTER - 4);
    let index = [&*index, &place, footer].concat();
    let sum = checksum(0, &index).to_le_bytes();
    let new = [&before, &index, &sum[..], mcap::MAGIC].concat();
    file.seek(SeekFrom::Start(data_end))?;
    file.write_all(&new)?;
    file.set_len(data_end + new.len() as u64)?;
    file.sync_data()
}

/// Counts a metadata record more in the statistics of an index.
fn count_one_more(mut index: &mut [u8]) {
    while index.len() >= HEAD {
        let end = HEAD.saturating_add(number(index, 1) as usize);
        let is_statistics = index[0] == op::STATISTICS;
        let count = index
            .get_mut(METADATA_COUNT..)
            .and_then(<[u8]>::first_chunk_mut);
        if let Some(count) = count.filter(|_| is_statistics) {
            *count = u32::from_le_bytes(*count).saturating_add(1).to_le_bytes();
        }
        index = index.get_mut(end..).unwrap_or_default();
    }
}

/// The checksum of what had this one, with more behind it.
fn checksum(before: u32, more: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new_with_initial(before);
    sum.update(more);
    sum.finalize()
}

/// The eight bytes at this place of a record.
fn number(bytes: &[u8], at: usize) -> u64 {
    let number = bytes[at..].first_chunk();
    number.map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn record(opcode: u8, content: &[&[u8]]) -> Vec<u8> {
    let content = content.concat();
    let length = (content.len() as u64).to_le_bytes();
    [&[opcode], &length[..], &content].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{LogWriter, inspect, recover};
    use haptic_message::TickMessage;
    use std::{collections::BTreeMap, fs, path::PathBuf};
    use testkit::{Folder, Tested};

    /// A log of 500 ticks.
    fn log_of(folder: &Folder) -> PathBuf {
        let path = folder.join("run.mcap");
        let mut log = LogWriter::create(&path).expect("made");
        let asked = [("mu".to_owned(), "0.5".to_owned())].into();
        log.metadata("experiment", asked).expect("written");
        for tick in 0..500 {
            let time_s = 1e-3 * tick as f64;
            let message = TickMessage {
                tick,
                time_s,
                ..TickMessage::at_rest(1)
            };
            log.tick(&message).expect("written");
        }
        log.finish().expect("finished");
        path
    }

    #[test]
    fn a_record_is_appended_and_the_log_stays_whole_for_every_reader() -> Tested {
        let folder = Folder::empty();
        let path = log_of(&folder);
        let before = inspect(&path)?;
        for (number, verdict) in ["stable", "µ = 0.2 %: passive"].into_iter().enumerate() {
            let values = BTreeMap::from([(VERDICT.to_owned(), verdict.to_owned())]);
            add_verdict(&path, verdict)?;
            let summary = inspect(&path)?;
            assert!(summary.complete && summary.damage.is_empty(), "{summary:?}");
            assert_eq!((summary.samples, &summary.gaps), (500, &before.gaps));
            let last = summary.metadata.last().expect("there");
            assert_eq!((last.name.as_str(), &last.values), (VERDICT, &values));
            // The library's own reader, by the index.
            let bytes = fs::read(&path)?;
            let index = mcap::Summary::read(&bytes)?.expect("there");
            let statistics = index.stats.expect("there");
            assert_eq!(statistics.metadata_count as usize, 2 + number);
            assert_eq!(index.metadata_indexes.len(), 2 + number);
            let at = index.metadata_indexes.last().expect("there");
            let found = mcap::read::metadata(&bytes, at)?;
            assert_eq!(found.metadata["verdict"], verdict);
            let samples = mcap::MessageStream::new(&bytes)?;
            assert_eq!(samples.filter(Result::is_ok).count(), 500);
        }
        Ok(())
    }

    #[test]
    fn what_is_no_finished_log_is_refused_and_left_as_it_is() -> Tested {
        let folder = Folder::empty();
        let path = folder.join("run.mcap");
        let mut log = LogWriter::create(&path)?;
        log.tick(&TickMessage::at_rest(1))?;
        log.finish()?;
        let whole = fs::read(&path)?;
        let mut others: Vec<Vec<u8>> = [0, 7, 40, whole.len() / 2, whole.len() - 1]
            .map(|cut| whole[..cut].to_vec())
            .into();
        // Logs of other programs that have no summary, or whose footer leads elsewhere.
        let footer = whole.len() - TAIL + HEAD;
        for place in [0_u64, 8, 13, 40, whole.len() as u64, u64::MAX] {
            for offsets in [0, whole.len() as u64 - TAIL as u64] {
                let mut other = whole.clone();
                other[footer..footer + 8].copy_from_slice(&place.to_le_bytes());
                other[footer + 8..footer + 16].copy_from_slice(&offsets.to_le_bytes());
                others.push(other);
            }
        }
        for (number, other) in others.iter().enumerate() {
            fs::write(&path, other)?;
            let refused = add_verdict(&path, "stable");
            assert!(refused.is_err(), "{number}");
            assert_eq!(&fs::read(&path)?, other, "{number}");
        }
        Ok(())
    }

    #[test]
    fn power_that_is_cut_while_a_verdict_is_added_costs_no_sample() -> Tested {
        let folder = Folder::empty();
        let path = log_of(&folder);
        let before = fs::read(&path)?;
        add_verdict(&path, "stable")?;
        let after = fs::read(&path)?;
        let same = before.iter().zip(&after).take_while(|(a, b)| a == b);
        let (cut, saved) = (folder.join("cut.mcap"), folder.join("saved.mcap"));
        // What was written until then, before what was there; or before nothing.
        for done in (same.count()..after.len()).step_by(41) {
            let rest = before.get(done..).unwrap_or_default();
            for rest in [rest, &[]] {
                fs::write(&cut, [&after[..done], rest].concat())?;
                let summary = recover(&cut, &saved, true)?;
                assert_eq!(summary.samples, 500, "{done}");
            }
        }
        Ok(())
    }
}
