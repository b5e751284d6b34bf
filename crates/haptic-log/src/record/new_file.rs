//! A file that gets its name only when it is whole: bytes go to another name in the same folder, and
//! [`NewFile::publish`] gives the file its own. Nothing half-written looks complete, whatever kills the process.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    hash::{BuildHasher as _, RandomState},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// A file that could not be created or named.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NewFileError {
    /// Another file has the name, and replacing it was not requested.
    #[error("`{}` already exists and is not overwritten; choose another name or move it away", .0.display())]
    Exists(PathBuf),
    /// A folder, a device, a pipe, a socket or a link has the name.
    #[error("`{}` is not a regular file and is left as it is; choose another name", .0.display())]
    NotRegular(PathBuf),
    /// A file that is to be continued begins otherwise.
    #[error("`{}` begins otherwise and is not continued; choose another name", .0.display())]
    Foreign(PathBuf),
    /// An earlier log under this name was never finished.
    #[error(
        "`{}` is left from a run that was cut off; save what it holds with `host-cli log recover`, then remove it",
        .0.display()
    )]
    Leftover(PathBuf),
    /// Another process is writing the file just now.
    #[error(
        "`{}` is being written by another run; wait until that run has ended, or choose another name",
        .0.display()
    )]
    BeingWritten(PathBuf),
    /// The file to write is the file to read.
    #[error("`{}` would be written over the log it is made from; choose another name", .0.display())]
    OwnSource(PathBuf),
    /// The name stands for standard output.
    #[error("`-` stands for standard output, where only a CSV goes: name a file, as in ./-")]
    Dash,
    /// The folder does not take the file.
    #[error("cannot write `{}`: {source}; check that the folder exists, is writable and has space", .path.display())]
    Io {
        /// The file that the message names.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

impl NewFileError {
    /// An I/O error on `path`.
    pub fn io(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        Self::Io { path, source }
    }
}

/// Rule for an unfinished file that is never published, or already there. The kinds have different names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leftover {
    /// `NAME.part` holds data: it stays, and one that is already there is refused.
    Keep,
    /// `NAME.DRAWN.host-cli-tmp`, with a number that is drawn, can be made again: it is removed.
    Discard,
}

impl Leftover {
    /// Suffix of an unfinished file; one that can be made again gets a number, so that no two have the same name.
    fn suffix(self) -> String {
        match self {
            Self::Keep => ".part".to_owned(),
            Self::Discard => format!(".{}.host-cli-tmp", drawn_number()),
        }
    }
}

/// A unique number of 16 digits: the standard library draws the keys of its hash tables anew.
pub(super) fn drawn_number() -> String {
    format!("{:016x}", RandomState::new().hash_one(0))
}

/// A file under construction, for logs, tables and pictures alike: it gets its name once it is whole.
///
/// Dropped without [`publish`](Self::publish), it leaves nothing ([`Leftover::Discard`]) or its
/// data under the unfinished name ([`Leftover::Keep`]). A kept file is locked while its writer
/// lives, so that others can distinguish a live run from a dead one ([`leftover_at`]).
///
/// ```
/// use haptic_log::record::{Leftover, NewFile};
/// use std::io::Write as _;
///
/// let folder = tempfile::tempdir()?;
/// let name = folder.path().join("table.csv");
/// let (new_file, mut file) = NewFile::create(&name, Leftover::Discard, false)?;
/// file.write_all(b"x\n1\n")?;
/// assert!(!name.exists(), "half a table is no table");
/// new_file.publish()?;
/// assert_eq!(std::fs::read(&name)?, b"x\n1\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct NewFile {
    target: PathBuf,
    part: PathBuf,
    leftover: Leftover,
    overwrite: bool,
    published: bool,
}

impl NewFile {
    /// Opens the unfinished file for writing. With `overwrite` the target may exist, and stays until
    /// [`publish`](Self::publish) replaces it.
    ///
    /// # Errors
    /// As [`refuse_taken`]; [`NewFileError::Leftover`] or
    /// [`NewFileError::BeingWritten`] if a kept unfinished file is in the way; [`NewFileError::Io`]
    /// if the file cannot be written to the folder.
    pub fn create(
        target: &Path,
        leftover: Leftover,
        overwrite: bool,
    ) -> Result<(Self, File), NewFileError> {
        refuse_taken(target, overwrite)?;
        let part = with_suffix(target, &leftover.suffix());
        // Appended to, so that what somebody else cuts from it shows in its length. A link under that name is not followed.
        let opened = OpenOptions::new().append(true).create_new(true).open(&part);
        let file = opened.map_err(|source| {
            if is_taken(&source) {
                leftover_at(&part)
            } else {
                NewFileError::io(target, source)
            }
        })?;
        if leftover == Leftover::Keep {
            // Ends with the process however that dies. A file system without locks shows leftovers by their names
            // alone.
            let _ = file.try_lock();
        }
        let new_file = Self {
            target: target.to_owned(),
            part,
            leftover,
            overwrite,
            published: false,
        };
        Ok((new_file, file))
    }

    /// Writes these bytes to a complete file that still lacks its name; use it for data that can be
    /// made again.
    ///
    /// # Errors
    /// As [`create`](Self::create); bytes that the disk does not take.
    pub fn filled(target: &Path, bytes: &[u8], overwrite: bool) -> Result<Self, NewFileError> {
        let (new_file, mut file) = Self::create(target, Leftover::Discard, overwrite)?;
        (file.write_all(bytes)).map_err(|source| NewFileError::io(target, source))?;
        Ok(new_file)
    }

    /// The name while under construction.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// The name it will get.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Brings the names in the folder to the disk, where the system can.
    pub(crate) fn sync_folder(&self) {
        #[cfg(unix)]
        {
            let folder = self.target.parent();
            let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
            let opened = File::open(folder.unwrap_or(Path::new(".")));
            let _ = opened.and_then(|folder| folder.sync_all());
        }
    }

    /// Deletes the unfinished file, because nothing in it is worth keeping.
    pub fn discard(mut self) {
        // The name stays as it is; only the policy changes.
        self.leftover = Leftover::Discard;
    }

    /// Gives the file its name. Without `overwrite`, a file that took the name in the meantime is
    /// kept and causes an error.
    ///
    /// # Errors
    /// The name is taken, or the folder does not accept the file.
    pub fn publish(mut self) -> Result<(), NewFileError> {
        let moved = if self.overwrite {
            refuse_taken(&self.target, true)?;
            fs::rename(&self.part, &self.target)
        } else {
            rename_to_free_name(&self.part, &self.target)
        };
        moved.map_err(|source| {
            if is_taken(&source) {
                NewFileError::Exists(self.target.clone())
            } else {
                NewFileError::io(&self.target, source)
            }
        })?;
        self.published = true;
        if self.leftover == Leftover::Keep {
            self.sync_folder();
        }
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.published && self.leftover == Leftover::Discard {
            // Nothing useful can be done about a failure here.
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// Refuses a name that is taken: by anything, or with `overwrite` by anything but a regular file.
///
/// # Errors
/// [`NewFileError::Dash`]; [`NewFileError::Exists`]; [`NewFileError::NotRegular`].
pub fn refuse_taken(target: &Path, overwrite: bool) -> Result<(), NewFileError> {
    if target.as_os_str() == "-" {
        return Err(NewFileError::Dash);
    }
    // The link itself is asked: a dangling one is there too, and one to a device is not to become a file.
    match target.symlink_metadata() {
        Ok(_) if !overwrite => Err(NewFileError::Exists(target.to_owned())),
        Ok(taken) if !taken.is_file() => Err(NewFileError::NotRegular(target.to_owned())),
        Ok(_) | Err(_) => Ok(()),
    }
}

/// Opens a file to change it: a regular one, no link to one, that no other process changes meanwhile.
pub(super) fn open_to_change(path: &Path) -> Result<File, NewFileError> {
    refuse_taken(path, true)?;
    let opened = OpenOptions::new().read(true).write(true).open(path);
    locked(
        opened.map_err(|source| NewFileError::io(path, source))?,
        path,
    )
}

/// The file with its lock. A file system without locks lets anybody write.
pub(super) fn locked(file: File, path: &Path) -> Result<File, NewFileError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(NewFileError::BeingWritten(path.to_owned())),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// Removes a file of an earlier run, which would pass for one of this: a regular one, if it is there.
pub fn remove_earlier(file: &Path) {
    if refuse_taken(file, true).is_ok() {
        // Nothing there is as good.
        let _ = fs::remove_file(file);
    }
}

/// [`NewFileError::BeingWritten`] while the writer of an unfinished file lives, else, and without locks,
/// [`NewFileError::Leftover`].
pub fn leftover_at(part: &Path) -> NewFileError {
    match refuse_being_written(part) {
        Err(error) => error,
        Ok(()) => NewFileError::Leftover(part.to_owned()),
    }
}

pub(crate) fn open_file(path: &Path) -> io::Result<File> {
    if !fs::metadata(path)?.is_file() {
        let why = "it is not a regular file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    File::open(path)
}

/// Refuses a file that another run is writing: one whose lock is held.
pub(crate) fn refuse_being_written(file: &Path) -> Result<(), NewFileError> {
    // One that cannot be opened is no business of this check.
    match open_file(file).map(|file| file.try_lock_shared()) {
        Ok(Err(TryLockError::WouldBlock)) => Err(NewFileError::BeingWritten(file.to_owned())),
        _ => Ok(()),
    }
}

/// Refuses to write to `target` what is read from `source`.
pub(crate) fn refuse_own_source(source: &Path, target: &Path) -> Result<(), NewFileError> {
    let Ok(source) = fs::canonicalize(source) else {
        // It cannot be read either, which is found out soon enough.
        return Ok(());
    };
    match fs::canonicalize(target) {
        Ok(name) if is_same(&source, &name) => Err(NewFileError::OwnSource(target.to_owned())),
        _ => Ok(()),
    }
}

/// True if two canonical paths are one file, also by another hard link.
fn is_same(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let number = |path| fs::metadata(path).map(|file| (file.dev(), file.ino())).ok();
        if let (Some(a), Some(b)) = (number(a), number(b)) {
            return a == b;
        }
    }
    a == b
}

/// `NAME.part`, the name of the log NAME while it is being written.
#[must_use]
pub fn part_of(log: &Path) -> PathBuf {
    with_suffix(log, &Leftover::Keep.suffix())
}

fn is_taken(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::AlreadyExists
}

fn with_suffix(target: &Path, suffix: &str) -> PathBuf {
    let mut name = target.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

/// Renames, and fails if `to` exists: a hard link refuses a taken name in one step; without links (FAT) a look first
/// must do.
fn rename_to_free_name(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Ok(()) => {
            // The data is under its name now; an old name that stays behind is only untidy.
            let _ = fs::remove_file(from);
            Ok(())
        }
        Err(error) if is_taken(&error) => Err(error),
        Err(_) if to.symlink_metadata().is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(from, to),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::LineFile;
    use testkit::{Folder, Tested};

    #[test]
    fn the_name_appears_only_when_the_file_is_published() -> Tested {
        let folder = Folder::empty();
        let target = folder.join("a.csv");
        let (new_file, mut file) = NewFile::create(&target, Leftover::Discard, false)?;
        file.write_all(b"whole")?;
        assert!(!target.exists());
        new_file.publish()?;
        assert_eq!(fs::read(&target)?, b"whole");
        assert_eq!(folder.read_dir()?.count(), 1);
        Ok(())
    }

    #[test]
    fn a_name_taken_meanwhile_is_not_overwritten() -> Tested {
        let folder = Folder::empty();
        let target = folder.join("a.mcap");
        let (new_file, _file) = NewFile::create(&target, Leftover::Keep, false)?;
        fs::write(&target, b"theirs")?;
        let part = new_file.part().to_owned();
        assert!(matches!(new_file.publish(), Err(NewFileError::Exists(_))));
        assert_eq!(fs::read(&target)?, b"theirs");
        assert!(part.exists(), "the data stays in the .part file");
        Ok(())
    }

    #[test]
    fn a_file_that_is_being_written_is_told_from_one_that_was_left() -> Tested {
        let folder = Folder::empty();
        let target = folder.join("a.mcap");
        let (new_file, file) = NewFile::create(&target, Leftover::Keep, false)?;
        let part = new_file.part().to_owned();
        for overwrite in [false, true] {
            let error = NewFile::create(&target, Leftover::Keep, overwrite).expect_err("refuses");
            assert!(matches!(error, NewFileError::BeingWritten(_)), "{error}");
        }
        assert!(refuse_being_written(&part).is_err());
        drop(file);
        refuse_being_written(&part)?;
        let error = NewFile::create(&target, Leftover::Keep, false).expect_err("refuses");
        assert!(matches!(error, NewFileError::Leftover(_)), "{error}");
        // Nobody writes a file that is not there.
        refuse_being_written(&target)?;
        Ok(())
    }

    #[test]
    fn two_writers_of_one_name_have_a_file_each() -> Tested {
        let folder = Folder::empty();
        let target = folder.join("a.csv");
        let create = || NewFile::create(&target, Leftover::Discard, true).expect("creates");
        let ((one, mut first), (other, mut second)) = (create(), create());
        assert_ne!(one.part(), other.part());
        first.write_all(b"first")?;
        second.write_all(b"other")?;
        one.publish()?;
        assert_eq!(fs::read(&target)?, b"first");
        other.publish()?;
        assert_eq!(fs::read(&target)?, b"other");
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn a_link_under_an_unfinished_name_is_not_followed() -> Tested {
        let folder = Folder::empty();
        let name = |name: &str| folder.join(name);
        fs::write(name("theirs"), "theirs")?;
        for link in ["a.csv.host-cli-tmp", "a.csv.part"] {
            std::os::unix::fs::symlink(name("theirs"), name(link))?;
        }
        let kept = NewFile::create(&name("a.csv"), Leftover::Keep, true).map(drop);
        assert!(kept.is_err(), "{kept:?}");
        let new_file = NewFile::filled(&name("a.csv"), b"ours", false)?;
        new_file.publish()?;
        assert_eq!(fs::read(name("a.csv"))?, b"ours");
        assert_eq!(fs::read(name("theirs"))?, b"theirs");
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn only_a_regular_file_is_replaced_or_removed() -> Tested {
        let folder = Folder::empty();
        let name = |name: &str| folder.join(name);
        let link = |to: &str| std::os::unix::fs::symlink(name(to), name("link")).expect("links");
        let _socket = std::os::unix::net::UnixListener::bind(name("socket"))?;
        let made = std::process::Command::new("mkfifo")
            .arg(name("fifo"))
            .status();
        assert!(made?.success());
        fs::write(name("theirs"), "theirs")?;
        let refused = |special: &Path| {
            let words = NewFile::create(special, Leftover::Keep, true).map(drop);
            let words = words.expect_err("refused").to_string();
            assert!(words.contains("is not a regular file"), "{words}");
            assert!(LineFile::open(special, "theirs").is_err(), "{words}");
            remove_earlier(special);
            assert!(special.symlink_metadata().is_ok(), "{words}");
        };
        for special in ["socket", "fifo", "."] {
            refused(&name(special));
        }
        // To a device, a file, and nothing.
        for to in ["/dev/null", "theirs", "gone"] {
            link(to);
            refused(&name("link"));
            fs::remove_file(name("link"))?;
        }
        // One that was put there meanwhile.
        let new_file = NewFile::filled(&name("link"), b"ours", true)?;
        link("/dev/null");
        let error = new_file.publish().expect_err("refused");
        assert!(matches!(error, NewFileError::NotRegular(_)), "{error}");
        remove_earlier(&name("theirs"));
        assert!(!name("theirs").exists());
        Ok(())
    }

    #[test]
    fn an_abandoned_file_is_removed_or_kept_as_asked() {
        let folder = Folder::empty();
        for (leftover, stays) in [(Leftover::Discard, false), (Leftover::Keep, true)] {
            let target = folder.join(format!("{leftover:?}"));
            let (new_file, _file) = NewFile::create(&target, leftover, false).expect("creates");
            let part = new_file.part().to_owned();
            drop(new_file);
            assert_eq!(part.exists(), stays, "{leftover:?}");
        }
    }
}
