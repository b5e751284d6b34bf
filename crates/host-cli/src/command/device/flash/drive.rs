//! The drive that a chip's boot loader shows, found by its `INFO_UF2.TXT`.

use haptic_experiment::Failure;
use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

/// Bring a chip to show its drive.
pub(super) const REMEDY: &str =
    "plug the board in with BOOTSEL held, and mount the drive that it shows";

/// The places where FAT drives are mounted: those of boot loaders are, and have no links that lead elsewhere.
pub(super) fn mounted() -> Vec<PathBuf> {
    let disks = sysinfo::Disks::new_with_refreshed_list();
    let fat = disks.iter().filter(|disk| {
        let system = disk.file_system().to_string_lossy().to_lowercase();
        system.contains("fat") || system == "msdos"
    });
    fat.map(|disk| disk.mount_point().to_owned()).collect()
}

/// Name by which the boot loader at a place calls its board.
pub(super) fn board_id(mount: &Path) -> Option<String> {
    let mut info = String::new();
    let file = File::open(mount.join("INFO_UF2.TXT")).ok()?;
    file.take(4096).read_to_string(&mut info).ok()?;
    let id = info
        .lines()
        .find_map(|line| line.strip_prefix("Board-ID:"))?;
    Some(id.trim().to_owned())
}

/// The one place with the drive of this board.
pub(super) fn find(places: &[PathBuf], id: &str) -> Result<PathBuf, Failure> {
    let device = |words: String| Err(Failure::device(words));
    let drives = places
        .iter()
        .filter_map(|mount| Some((mount, board_id(mount)?)));
    let (mut of_board, of_others): (Vec<_>, Vec<_>) = drives.partition(|(_, found)| found == id);
    match (of_board.pop(), of_others.first()) {
        (Some((mount, _)), _) if of_board.is_empty() => Ok(mount.clone()),
        (Some(_), _) => device(format!(
            "{} drives {id}: unplug all boards but the one to flash",
            of_board.len() + 1
        )),
        (None, Some((mount, other))) => device(format!(
            "the drive at `{}` is of {other}, not {id}: change --board",
            mount.display()
        )),
        (None, None) => device(format!("no drive {id}: {REMEDY}")),
    }
}

/// The file that is written.
const FILE: &str = "haptic.uf2";

/// Writes a new file through to the drive. The board starts the image as soon as it has all of it, and takes its drive away, so an error
/// at the very end says little: the device's hello decides.
pub(super) fn write(drive: &Path, bytes: &[u8]) -> io::Result<io::Result<()>> {
    let file = drive.join(FILE);
    let mut opened = File::create_new(&file)?;
    if let Err(error) = opened.write_all(bytes) {
        // Half an image must not be in the way of the next; a drive that is gone has none.
        let _ = std::fs::remove_file(file);
        return Err(error);
    }
    Ok(opened.sync_all())
}

/// A drive that did not take the image.
pub(super) fn refused(drive: &Path, error: &io::Error) -> Failure {
    let is = |kinds: &[io::ErrorKind]| kinds.contains(&error.kind());
    let what = if is(&[io::ErrorKind::StorageFull]) {
        format!("is full: {REMEDY}")
    } else if is(&[io::ErrorKind::AlreadyExists]) {
        format!("already has a file {FILE}: delete it")
    } else if is(&[
        io::ErrorKind::ReadOnlyFilesystem,
        io::ErrorKind::PermissionDenied,
    ]) {
        format!("cannot be written to ({error}): mount it writable for this user")
    } else {
        format!("was lost while it was written ({error}): {REMEDY}")
    };
    Failure::device(format_args!("the drive at `{}` {what}", drive.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(id: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        let info = format!("UF2 Bootloader v3.0\r\nModel: Raspberry Pi RP2\r\nBoard-ID: {id}\r\n");
        std::fs::write(folder.path().join("INFO_UF2.TXT"), info).expect("is written");
        folder
    }

    #[test]
    fn the_drive_is_found_by_its_text_and_only_if_there_is_one() {
        let (pico, other, none) = (drive("RPI-RP2"), drive("RP2350"), tempfile::tempdir());
        let none = none.expect("a folder");
        let places = |drives: &[&tempfile::TempDir]| -> Vec<PathBuf> {
            drives.iter().map(|drive| drive.path().to_owned()).collect()
        };
        let found = find(&places(&[&none, &other, &pico]), "RPI-RP2").expect("is there");
        assert_eq!(found, pico.path());
        let second = drive("RPI-RP2");
        for (drives, words) in [
            (vec![&none], "no drive RPI-RP2: plug the board"),
            (vec![&none, &other], "is of RP2350, not RPI-RP2"),
            (vec![&pico, &second], "2 drives RPI-RP2: unplug"),
        ] {
            let error = find(&places(&drives), "RPI-RP2").expect_err("refused");
            assert!(matches!(error, Failure::Device(_)));
            assert!(error.to_string().contains(words), "{error}");
        }
    }

    #[test]
    fn a_drive_that_is_full_or_gone_is_an_error_with_the_remedy() {
        let full = io::Error::from(io::ErrorKind::StorageFull);
        let words = refused(Path::new("RPI-RP2"), &full).to_string();
        assert!(words.contains("`RPI-RP2` is full: plug"), "{words}");
        for kind in [
            io::ErrorKind::ReadOnlyFilesystem,
            io::ErrorKind::PermissionDenied,
        ] {
            let words = refused(Path::new("RPI-RP2"), &kind.into()).to_string();
            assert!(words.contains("cannot be written to"), "{words}");
            assert!(
                words.ends_with("mount it writable for this user"),
                "{words}"
            );
        }
        let gone = write(Path::new("/nonexistent"), &[0; 512]).expect_err("gone");
        let words = refused(Path::new("RPI-RP2"), &gone).to_string();
        assert!(words.contains("was lost while it was written"), "{words}");
        // Nothing that is there is written over.
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join(FILE);
        std::fs::write(&file, "precious").expect("is written");
        let image = write(folder.path(), &[0; 512]).expect_err("is there");
        let words = refused(folder.path(), &image).to_string();
        assert!(
            words.ends_with("already has a file haptic.uf2: delete it"),
            "{words}"
        );
        assert_eq!(std::fs::read(&file).expect("is there"), b"precious");
    }
}
