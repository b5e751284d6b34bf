//! The PNG of each kind of picture against its SVG as resvg renders it, pixel by pixel.
//!
//! Fails if more pixels differ, or a text stands elsewhere, than antialiasing explains.

mod difference;
mod pictures;
mod reference;

use difference::{Difference, SEEN};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Share of all pixels that may differ by more than [`SEEN`].
const MOST_SEEN: f64 = 2e-5;
/// A text may stand off by so much, CSS px.
const MOST_SHIFT: f64 = 0.1;

fn main() -> ExitCode {
    let fonts = reference::fonts();
    let mut sound = true;
    println!("picture        pixels  differ  of ink  worst  text off/px  time of resvg over ours");
    for (name, picture) in pictures::all() {
        let svg = picture.svg();
        let (ours, own_time) = timed(|| picture.png().expect("paints"));
        let (theirs, their_time) = timed(|| reference::png(svg, &fonts));
        let texts = reference::texts(svg, &fonts);
        let found = Difference::between(&decode(&ours), &decode(&theirs), &texts);
        println!(
            "{name:12} {:8}  {:.4}%  {:.3}%  {:5}  {:11.3}  {:.1}",
            found.pixels,
            100.0 * found.share,
            100.0 * found.share_of_ink,
            found.worst,
            found.shift,
            their_time.as_secs_f64() / own_time.as_secs_f64(),
        );
        sound &= found.share <= MOST_SEEN && found.shift <= MOST_SHIFT;
    }
    if sound {
        return ExitCode::SUCCESS;
    }
    eprintln!(
        "more than {MOST_SEEN} of the pixels differ by more than {SEEN} of 255, or a text is off by more than {MOST_SHIFT} px"
    );
    ExitCode::FAILURE
}

/// The result and the shortest time of three runs.
fn timed<T>(work: impl Fn() -> T) -> (T, Duration) {
    let run = || {
        let start = Instant::now();
        let result = work();
        (result, start.elapsed())
    };
    let [first, second, third] = [run(), run(), run()];
    let shortest = first.1.min(second.1).min(third.1);
    (first.0, shortest)
}

/// The darkness of a PNG, 0 for white and 255 for black, in all three colours.
struct Image {
    width: usize,
    height: usize,
    colours: Vec<[u8; 3]>,
}

fn decode(bytes: &[u8]) -> Image {
    let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    let mut reader = decoder.read_info().expect("is PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("fits")];
    let info = reader.next_frame(&mut pixels).expect("is whole");
    assert_eq!(info.color_type, png::ColorType::Rgba);
    let colours = pixels.chunks_exact(4);
    Image {
        width: info.width as usize,
        height: info.height as usize,
        colours: colours
            .map(|pixel| [pixel[0], pixel[1], pixel[2]].map(|colour| u8::MAX - colour))
            .collect(),
    }
}
