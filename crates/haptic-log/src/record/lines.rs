//! A file that grows by whole lines and that a later process goes on with.
//!
//! - *Ours*: a regular file that begins with the line it is asked for. Any other stays as it is, and is refused.
//! - *One writer*: it is locked as long as it is open.
//! - *Changed* by [`LineFile::add`] alone. A last line without an end, of a computer that was switched off, gives way to the next one.
//! - *New*: it gets its name with its first line after the head. *Errors*: [`NewFileError`].

use super::new_file::{Leftover, NewFile, NewFileError, locked, open_to_change};
use std::{
    fs::File,
    io::{Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
};

/// A file of lines, open for the next one.
#[derive(Debug)]
pub struct LineFile {
    path: PathBuf,
    file: File,
    /// Bytes of whole lines.
    end: u64,
    unnamed: Option<NewFile>,
}

impl LineFile {
    /// Opens the file that begins with this line, or starts one; returns the whole lines that follow. No file of this name has changed yet.
    ///
    /// # Errors
    /// [`NewFileError::Foreign`] for another beginning, [`NewFileError::BeingWritten`], [`NewFileError::NotRegular`],
    /// [`NewFileError::Io`].
    pub fn open(path: &Path, head: &str) -> Result<(Self, String), NewFileError> {
        let failed = |source| NewFileError::io(path, source);
        let head = format!("{head}\n");
        let mut rest = Vec::new();
        let (mut file, unnamed) = if path.symlink_metadata().is_ok() {
            (open_to_change(path)?, None)
        } else {
            let (unnamed, mut file) = NewFile::create(path, Leftover::Discard, false)?;
            file.write_all(head.as_bytes()).map_err(failed)?;
            (locked(file, path)?, Some(unnamed))
        };
        if unnamed.is_none() {
            // Its beginning first: a file of somebody else may be of any size.
            let mut found = vec![0; head.len()];
            if file.read_exact(&mut found).is_err() || found != head.as_bytes() {
                return Err(NewFileError::Foreign(path.to_owned()));
            }
            file.read_to_end(&mut rest).map_err(failed)?;
            rest.truncate(
                rest.iter()
                    .rposition(|&b| b == b'\n')
                    .map_or(0, |end| end + 1),
            );
        }
        let lines = Self {
            path: path.to_owned(),
            file,
            end: (head.len() + rest.len()) as u64,
            unnamed,
        };
        Ok((lines, String::from_utf8_lossy(&rest).into_owned()))
    }

    /// Adds a line, which is on the disk when this returns.
    ///
    /// # Errors
    /// A disk that does not take it, or another file that has got the name of a new one.
    pub fn add(&mut self, line: &str) -> Result<(), NewFileError> {
        let line = format!("{line}\n");
        let written = self.cut().and_then(|()| {
            self.file.write_all(line.as_bytes())?;
            self.file.sync_data()
        });
        written.map_err(|source| NewFileError::io(&self.path, source))?;
        self.end += line.len() as u64;
        let named = self.unnamed.take().map_or(Ok(()), NewFile::publish);
        match named {
            Err(NewFileError::Exists(path)) => Err(NewFileError::BeingWritten(path)),
            named => named,
        }
    }

    /// Goes to the end of the whole lines. What is behind them is half a line, of an earlier process or of a disk that was full.
    fn cut(&mut self) -> std::io::Result<()> {
        if self.file.metadata()?.len() > self.end {
            self.file.set_len(self.end)?;
        }
        self.file.seek(SeekFrom::Start(self.end)).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use testkit::{Folder, Tested};

    #[test]
    fn a_file_is_continued_behind_its_last_whole_line_by_one_writer_at_a_time() -> Tested {
        let folder = Folder::empty();
        let path = folder.join("lines");
        let open = || LineFile::open(&path, "head");
        let text = || fs::read_to_string(&path).expect("text");
        drop(open()?);
        assert_eq!(folder.read_dir()?.count(), 0);
        let ((mut first, _), (mut second, _)) = (open()?, open()?);
        first.add("one")?;
        let late = second.add("two").expect_err("the name is taken");
        for refused in [late, open().expect_err("is open")] {
            assert!(
                matches!(refused, NewFileError::BeingWritten(_)),
                "{refused}"
            );
        }
        drop(first);
        let torn = text() + "half a line";
        fs::write(&path, &torn)?;
        let (mut again, found) = open()?;
        assert_eq!((found, text()), ("one\n".to_owned(), torn));
        again.add("2")?;
        assert_eq!(text(), "head\none\n2\n");
        Ok(())
    }
}
