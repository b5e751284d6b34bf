//! PDF pages, read by poppler: their size, and their pixels beside those of the PNG.

use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Picture, Scale, Series, Sheet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// All that a drawing can hold: lines in dashes, areas, markers of all shapes, superscripts, upright text, many panels.
fn picture() -> Picture {
    let wave = |n: u32| -> Vec<(f64, f64)> {
        let x = (0..200).map(|i| 0.05 * f64::from(i));
        x.map(|x| (x, (x + f64::from(n)).sin())).collect()
    };
    let waves: Vec<Vec<(f64, f64)>> = (0..4).map(wave).collect();
    let dots = waves.iter().map(|wave| wave.iter().step_by(20).copied());
    let dots: Vec<Vec<(f64, f64)>> = dots.map(Iterator::collect).collect();
    let ring = [(1.0, -0.5), (8.0, -0.5), (8.0, 0.5), (1.0, 0.5)];
    let drawn = |looks: &[Look]| {
        let series = looks.iter().enumerate().map(|(n, look)| {
            let points = match look {
                Look::Area => ring.as_slice(),
                Look::Line | Look::Dashed | Look::Dotted | Look::Broad => waves[n].as_slice(),
                Look::Markers | Look::OpenMarkers | Look::Crosses => dots[n].as_slice(),
            };
            Series::new(["one", "two", "three", "four"][n], points, *look, n)
        });
        Chart {
            caption: "force · depth",
            x: AxisSpec::new("time / s", Scale::Linear),
            y: AxisSpec::new("dissipation B / N·s^μ·m⁻¹", Scale::Linear),
            series: series.collect(),
        }
    };
    let page = ChartPage {
        title: "Walls that settle: 1 N & −0.5 N",
        subtitle: "B in N·s^μ·m⁻¹",
        columns: 2,
        charts: vec![
            drawn(&[Look::Area, Look::Line, Look::Dashed, Look::Broad]),
            drawn(&[
                Look::Dotted,
                Look::Markers,
                Look::OpenMarkers,
                Look::Crosses,
            ]),
        ],
    };
    page.draw().expect("draws")
}

fn at_85_mm() -> Picture {
    let sheet = Sheet {
        width_m: Some(0.085),
        ..Sheet::default()
    };
    picture().on(&sheet).expect("draws")
}

/// What a program of poppler prints of a file; nothing where there is none.
fn poppler(program: &str, arguments: &[&str], file: &Path) -> Option<String> {
    let ran = Command::new(program).args(arguments).arg(file).output();
    let Ok(ran) = ran else {
        let text = format!("skipped: no {program} here");
        assert!(std::env::var_os("REQUIRE_ALL_CHECKS").is_none(), "{text}");
        eprintln!("{text}");
        return None;
    };
    assert!(ran.status.success() && ran.stderr.is_empty(), "{ran:?}");
    Some(String::from_utf8(ran.stdout).expect("is text"))
}

/// A file in a folder of its own.
fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("picture.pdf");
    std::fs::write(&file, bytes).expect("writes");
    (folder, file)
}

#[test]
fn a_pdf_is_the_same_bytes_twice_and_not_large() {
    let pdf = picture().pdf().expect("writes");
    assert!(pdf.starts_with(b"%PDF-") && pdf.ends_with(b"%%EOF"));
    assert!(pdf == picture().pdf().expect("writes"));
    assert!(pdf.len() < 60_000, "{}", pdf.len());
}

#[test]
fn poppler_finds_the_size_and_no_font_that_could_be_missing() {
    let (_folder, file) = written(&at_85_mm().pdf().expect("writes"));
    if let Some(info) = poppler("pdfinfo", &[], &file) {
        let size = info.lines().find(|line| line.starts_with("Page size"));
        let size: Vec<f64> = (size.expect("has one").split_whitespace())
            .filter_map(|word| word.parse().ok())
            .collect();
        assert!((size[0] - 85.0 / 25.4 * 72.0).abs() < 0.01, "{info}");
    }
    if let Some(fonts) = poppler("pdffonts", &[], &file) {
        assert_eq!(fonts.lines().count(), 2, "its text is outlines: {fonts}");
    }
}

/// Share of the pixels that are dark in one and light in the other, with their neighbours.
#[test]
fn poppler_paints_what_the_png_shows() {
    for (name, picture, width_in) in [
        ("screen", picture(), 880.0 / 96.0),
        ("column", at_85_mm(), 85.0 / 25.4),
    ] {
        let (_folder, file) = written(&picture.pdf().expect("writes"));
        let ours = grey(&picture.png().expect("paints"));
        let per_inch = (ours.0 as f64 / width_in).to_string();
        let arguments = ["-png", "-singlefile", "-r", per_inch.as_str()];
        let Ok(ran) = Command::new("pdftoppm")
            .args(arguments)
            .arg(&file)
            .arg(&file)
            .output()
        else {
            poppler("pdftoppm", &[], &file);
            return;
        };
        assert!(ran.status.success() && ran.stderr.is_empty(), "{ran:?}");
        let painted = std::fs::read(file.with_extension("pdf.png")).expect("is painted");
        let theirs = grey(&painted);
        assert!(
            ours.0.abs_diff(theirs.0) <= 1 && ours.1.abs_diff(theirs.1) <= 4,
            "{name}"
        );
        let (one, other) = (differing(&ours, &theirs), differing(&theirs, &ours));
        assert!(one < 2e-3 && other < 2e-3, "{name}: {one} {other}");
        // The check finds a curve that is missing, or text that is elsewhere.
        let moved = (
            ours.0,
            ours.1,
            [vec![255; 12 * ours.0], ours.2.clone()].concat(),
        );
        assert!(differing(&moved, &theirs) > 0.01, "{name}");
    }
}

/// Width, height and the grey of each pixel.
type Grey = (usize, usize, Vec<u8>);

fn grey(bytes: &[u8]) -> Grey {
    let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    let mut reader = decoder.read_info().expect("is PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("fits")];
    let info = reader.next_frame(&mut pixels).expect("is whole");
    let samples = info.color_type.samples();
    let pixels = pixels.chunks_exact(samples).map(|pixel| {
        let colours = &pixel[..samples.min(3)];
        let sum: u32 = colours.iter().map(|colour| u32::from(*colour)).sum();
        (sum / colours.len() as u32) as u8
    });
    (info.width as usize, info.height as usize, pixels.collect())
}

/// Share of the pixels that are dark in the first and have nothing dark within two pixels in the second.
fn differing(first: &Grey, second: &Grey) -> f64 {
    let dark = |image: &Grey, x: usize, y: usize| {
        let inside = x < image.0 && y < image.1;
        inside && image.2[y * image.0 + x] < 150
    };
    let mut found = 0;
    for y in 2..first.1 {
        for x in 2..first.0 {
            let near = || {
                let around = (0..5).flat_map(|dy| (0..5).map(move |dx| (dx, dy)));
                around.into_iter().any(|(dx, dy)| {
                    let (x, y) = ((x + dx) - 2, (y + dy) - 2);
                    x < second.0 && y < second.1 && second.2[y * second.0 + x] < 200
                })
            };
            found += usize::from(dark(first, x, y) && !near());
        }
    }
    found as f64 / first.2.len() as f64
}
