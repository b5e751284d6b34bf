//! A metadata record behind the others of a finished log: what is known only once its run was judged.
//! ```text
//! … chunks │ DataEnd │ summary │ offsets │ footer     becomes     … chunks │ Metadata │ DataEnd │ summary, one index more │ footer
//! ```
//! Everything behind the chunks is written anew, so it costs the size of the index, not of the log. No sample is touched: a power cut in
//! between leaves a log that ends behind its last chunk. The checksum of the whole data section is dropped, those of the chunks stay.

use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use super::RecordError;
use mcap::records::op;

/// Name of the metadata record with the verdict on a run, under the key of the same name.
pub const VERDICT: &str = "verdict";

/// Opcode and length of a record.
const HEAD: usize = 9;
const DATA_END: usize = HEAD + 4;
const FOOTER: usize = HEAD + 20;
/// Footer and magic bytes.
const TAIL: usize = FOOTER + 8;
/// Place of the number of metadata records in the statistics.
const METADATA_COUNT: usize = 18;

/// Adds a metadata record to a finished log, or to the last file of one in several.
///
/// # Errors
/// A file that is no finished log, or cannot be written.
pub fn append(
    path: &Path,
    name: &str,
    values: &BTreeMap<String, String>,
) -> Result<(), RecordError> {
    appended(path, name, values).map_err(|source| RecordError::Write {
        path: path.to_owned(),
        samples_safe: 0,
        source,
    })
}

fn appended(path: &Path, name: &str, values: &BTreeMap<String, String>) -> io::Result<()> {
    let mut file = OpenOptions::new().read(true).write(true).open(path)?;
    let length = file.seek(SeekFrom::End(0))?;
    let mut tail = vec![0; TAIL];
    file.seek(SeekFrom::Start(length.saturating_sub(TAIL as u64)))?;
    file.read_exact(&mut tail)?;
    let summary = number(&tail, HEAD);
    let data_end = summary.saturating_sub(DATA_END as u64);
    let whole = tail[0] == op::FOOTER && tail.ends_with(mcap::MAGIC) && summary < length;
    file.seek(SeekFrom::Start(data_end))?;
    let mut rest = Vec::new();
    file.read_to_end(&mut rest)?;
    if !whole || rest.first() != Some(&op::DATA_END) {
        return Err(io::Error::other("it is not a finished log"));
    }
    let mut pairs = Vec::new();
    for text in values.iter().flat_map(|(key, value)| [key, value]) {
        push_text(&mut pairs, text);
    }
    let mut content = Vec::new();
    push_text(&mut content, name);
    content.extend((pairs.len() as u32).to_le_bytes());
    content.extend(pairs);
    let mut new = record(op::METADATA, &content);
    let metadata_length = new.len() as u64;
    new.extend(record(op::DATA_END, &[0; 4]));
    let summary = data_end + new.len() as u64;
    let mut records = &rest[DATA_END..rest.len() - TAIL];
    while records.len() >= HEAD {
        let end = usize::try_from(number(records, 1)).unwrap_or(usize::MAX);
        let Some((one, others)) = records.split_at_checked(HEAD.saturating_add(end)) else {
            return Err(io::Error::other("its index is damaged"));
        };
        records = others;
        let start = new.len();
        match one[0] {
            // They are optional, and would all have moved.
            op::SUMMARY_OFFSET => {}
            _ => new.extend(one),
        }
        if one[0] == op::STATISTICS && one.len() >= HEAD + METADATA_COUNT + 4 {
            let count = &mut new[start + HEAD + METADATA_COUNT..][..4];
            let more = u32::from_le_bytes([count[0], count[1], count[2], count[3]]) + 1;
            count.copy_from_slice(&more.to_le_bytes());
        }
    }
    let mut index = [data_end, metadata_length].map(u64::to_le_bytes).concat();
    push_text(&mut index, name);
    new.extend(record(op::METADATA_INDEX, &index));
    let mut footer = [summary, 0].map(u64::to_le_bytes).concat();
    footer.extend([0; 4]);
    new.extend(record(op::FOOTER, &footer));
    new.extend(mcap::MAGIC);
    file.seek(SeekFrom::Start(data_end))?;
    file.write_all(&new)?;
    file.set_len(data_end + new.len() as u64)?;
    file.sync_data()
}

/// The eight bytes at this place of a record.
fn number(bytes: &[u8], at: usize) -> u64 {
    let mut number = [0; 8];
    number.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(number)
}

fn push_text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text.as_bytes());
}

fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![opcode];
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(content);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{LogWriter, TickMessage, inspect};
    use std::fs;

    #[test]
    fn a_record_is_appended_and_the_log_stays_whole_for_every_reader() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        let mut log = LogWriter::create(&path).expect("made");
        let asked = [("mu".to_owned(), "0.5".to_owned())].into();
        log.metadata("experiment", asked).expect("written");
        for tick in 0..500 {
            let time_s = 1e-3 * tick as f64;
            let message = TickMessage {
                tick,
                time_s,
                ..TickMessage::default()
            };
            log.tick(&message).expect("written");
        }
        log.finish().expect("finished");
        let before = inspect(&path).expect("read");
        for (number, verdict) in ["stable", "µ = 0.2 %: passive"].into_iter().enumerate() {
            let values = [(VERDICT.to_owned(), verdict.to_owned())].into();
            append(&path, VERDICT, &values).expect("appended");
            let summary = inspect(&path).expect("read");
            assert!(summary.complete && summary.damage.is_empty(), "{summary:?}");
            assert_eq!((summary.samples, &summary.gaps), (500, &before.gaps));
            let last = summary.metadata.last().expect("there");
            assert_eq!((last.name.as_str(), &last.values), (VERDICT, &values));
            // The library's own reader, by the index.
            let bytes = fs::read(&path).expect("read");
            let index = mcap::Summary::read(&bytes).expect("whole").expect("there");
            let statistics = index.stats.expect("there");
            assert_eq!(statistics.metadata_count as usize, 2 + number);
            assert_eq!(index.metadata_indexes.len(), 2 + number);
            let at = index.metadata_indexes.last().expect("there");
            let found = mcap::read::metadata(&bytes, at).expect("where it is said to be");
            assert_eq!(found.metadata["verdict"], verdict);
            let samples = mcap::MessageStream::new(&bytes).expect("whole");
            assert_eq!(samples.filter(Result::is_ok).count(), 500);
        }
    }

    #[test]
    fn what_is_no_finished_log_is_refused_and_left_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        let mut log = LogWriter::create(&path).expect("made");
        log.tick(&TickMessage::default()).expect("written");
        log.finish().expect("finished");
        let whole = fs::read(&path).expect("read");
        for cut in [0, 7, 40, whole.len() / 2, whole.len() - 1] {
            fs::write(&path, &whole[..cut]).expect("written");
            let refused = append(&path, VERDICT, &BTreeMap::new());
            assert!(refused.is_err(), "{cut}");
            assert_eq!(fs::read(&path).expect("read"), &whole[..cut]);
        }
    }
}
