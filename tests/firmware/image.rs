//! Building and running the images.

use super::firmware;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};
use testkit::skip;

const TARGET: &str = "thumbv7em-none-eabihf";

/// An image of the firmware.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Image {
    Device,
    Operators,
    Behaviour,
    Controllers,
    Instructions,
    Replay,
    Robots,
}

impl Image {
    const fn name(self) -> &'static str {
        match self {
            Self::Device => "haptic-device",
            Self::Operators => "operators",
            Self::Behaviour => "behaviour",
            Self::Controllers => "controllers",
            Self::Instructions => "instructions",
            Self::Replay => "replay",
            Self::Robots => "robots",
        }
    }
}

/// Files of all images, by name.
#[derive(Debug)]
pub(crate) struct Images(BTreeMap<String, PathBuf>);

/// What an image takes, bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) flash: u32,
    pub(crate) data: u32,
    pub(crate) stack: u32,
    /// CRC-32 over its code, constants and first values of variables.
    pub(crate) digest: u32,
}

/// The images, built once; `None` where that is impossible, after having said why.
pub(crate) fn built() -> Option<&'static Images> {
    static IMAGES: OnceLock<Result<Images, String>> = OnceLock::new();
    match IMAGES.get_or_init(build) {
        Ok(images) => Some(images),
        Err(missing) => {
            skip(missing);
            None
        }
    }
}

fn build() -> Result<Images, String> {
    needs()?;
    let all = ["build", "--release", "--locked", "--bins", "--tests"];
    Ok(compiled("mps2", &all))
}

/// Whether an image can be built and run.
pub(crate) fn needs() -> Result<(), String> {
    let qemu = Command::new("qemu-system-arm").arg("--version").output();
    if qemu.is_err() {
        return Err(
            "qemu-system-arm is missing; on Debian `apt install qemu-system-arm`".to_owned(),
        );
    }
    target()
}

/// Whether there is a Rust for the target.
fn target() -> Result<(), String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let library = Command::new(rustc)
        .args(["--print", "target-libdir", "--target", TARGET])
        .output()
        .ok()
        .filter(|output| output.status.success())
        .map(|output| PathBuf::from(String::from_utf8_lossy(&output.stdout).trim()));
    if !library.is_some_and(|library| library.is_dir()) {
        return Err(format!(
            "the target is missing; `rustup target add {TARGET}`"
        ));
    }
    Ok(())
}

/// The device for the real board, so that it is known to build and its size is known.
pub(crate) fn real_board() -> Option<Images> {
    if let Err(missing) = target() {
        skip(&missing);
        return None;
    }
    Some(compiled("nucleo-f446re", &["image-nucleo-f446re"]))
}

/// The images of a board, in a folder of their own: those of another board have the same names, and come from the same crates.
fn compiled(board: &str, what: &[&str]) -> Images {
    /// A board's images are put aside before the next board's are built.
    static TURN: Mutex<()> = Mutex::new(());
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let target = firmware().with_file_name("target").join("firmware");
    let folder = target.join("images").join(board);
    std::fs::create_dir_all(&folder).expect("a folder");
    let output = Command::new(env!("CARGO"))
        .args(what)
        .args(["--message-format", "json-render-diagnostics"])
        .current_dir(firmware())
        .env("CARGO_TARGET_DIR", &target)
        // Flags for the host's processor are none for the target's.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_BUILD_TARGET")
        .stderr(Stdio::inherit())
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "the firmware does not build");
    let messages = String::from_utf8(output.stdout).expect("text");
    let images = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|message| {
            let built = message["executable"].as_str()?;
            let name = message["target"]["name"].as_str()?;
            let image = folder.join(name);
            std::fs::copy(built, &image).expect("copies");
            Some((name.to_owned(), image))
        })
        .collect();
    Images(images)
}

/// Kills QEMU at the end, whatever happens: it may hang, so not gently.
#[derive(Debug)]
pub(crate) struct Qemu(pub(crate) std::process::Child);

impl Drop for Qemu {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Images {
    pub(crate) fn path(&self, image: Image) -> PathBuf {
        let path = self.0.get(image.name());
        path.unwrap_or_else(|| panic!("{image:?} was not built"))
            .clone()
    }

    /// Runs a test image to its end, where each instruction takes 64 ns, and returns what it prints.
    pub(crate) fn run(&self, image: Image) -> String {
        self.run_with(image, &[])
    }

    /// The same, with more arguments of QEMU.
    pub(crate) fn run_with(&self, image: Image, more: &[String]) -> String {
        let output = tempfile::NamedTempFile::new().expect("a file");
        let file = output.reopen().expect("the same file");
        let child = Command::new("qemu-system-arm")
            .args(["-M", "mps2-an386", "-icount", "shift=6,sleep=off"])
            .args(["-display", "none", "-monitor", "none", "-serial", "null"])
            .args(more)
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(self.path(image))
            .stdin(Stdio::null())
            .stdout(file.try_clone().expect("the same file"))
            .stderr(file)
            .spawn()
            .expect("QEMU starts");
        let mut qemu = Qemu(child);
        let words = || std::fs::read_to_string(output.path()).expect("text");
        let deadline = Instant::now() + testkit::PATIENCE;
        let status = loop {
            if let Some(status) = qemu.0.try_wait().expect("a child") {
                break status;
            }
            assert!(
                Instant::now() < deadline,
                "{image:?} does not end:\n{}",
                words()
            );
            std::thread::sleep(Duration::from_millis(10));
        };
        assert!(status.success(), "{image:?} failed, {status}:\n{}", words());
        words()
    }

    /// What the device takes, by the sections and symbols of its file.
    pub(crate) fn size(&self) -> Size {
        let file = std::fs::read(self.path(Image::Device)).expect("readable");
        let word = |at: usize| {
            let bytes = file[at..at + 4].try_into().expect("four bytes");
            u32::from_le_bytes(bytes)
        };
        let half = |at: usize| usize::from(u16::from_le_bytes([file[at], file[at + 1]]));
        // ELF32, little-endian: e_shoff at 32, e_shentsize at 46, e_shnum at 48. Section: type, flags,
        // address, size and entry point of the vector table from its start on.
        let (table, entry, count) = (word(32) as usize, half(46), half(48));
        let (mut flash, mut data) = (0, 0);
        let mut stack_top = None;
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let mut digest = crc.digest();
        for section in (0..count).map(|index| table + index * entry) {
            let [kind, flags, address, offset, length] =
                [4, 8, 12, 16, 20].map(|field| word(section + field));
            const ALLOCATED: u32 = 2;
            const WITHOUT_CONTENT: u32 = 8;
            if flags & ALLOCATED == 0 || length == 0 {
                continue;
            }
            let in_ram = address >= 0x2000_0000;
            if kind != WITHOUT_CONTENT {
                flash += length;
            }
            if in_ram {
                data += length;
            }
            // The first word of the vector table is where the stack begins.
            if !in_ram && stack_top.is_none() {
                stack_top = Some(word(offset as usize));
            } else if kind != WITHOUT_CONTENT {
                digest.update(&file[offset as usize..(offset + length) as usize]);
            }
        }
        Size {
            flash,
            data,
            stack: stack_top.expect("a vector table") - 0x2000_0000,
            digest: digest.finalize(),
        }
    }
}
