//! Saving a picture: both files or neither; SVG alone without the feature `png`.

use crate::process::Place;
use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Picture, Scale, Series};
use host_cli::picture_file::Pictures;
use std::fs;
use std::path::Path;
use testkit::{Folder, assert_says};

/// The first bytes of a PNG.
#[cfg(feature = "png")]
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

fn picture() -> Picture {
    let line = [(0.0, 0.0), (1.0, 2.0)];
    let page = ChartPage {
        title: "A line",
        subtitle: "",
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("time / s", Scale::Linear),
            y: AxisSpec::new("force / N", Scale::Linear),
            series: vec![Series::new("force", &line, Look::Line, 0)],
        }],
    };
    page.draw().expect("draws")
}

#[test]
fn the_file_to_look_at_is_the_png_if_there_is_one() {
    let folder = Folder::empty();
    let saved = Pictures::default()
        .save(Ok(picture()), &folder.join("a"), false)
        .expect("saves");
    let (ending, files) = if cfg!(feature = "png") {
        ("a.png", 2)
    } else {
        ("a.svg", 1)
    };
    assert!(saved.ends_with(ending), "{saved}");
    assert_eq!(fs::read_dir(&*folder).expect("lists").count(), files);
}

fn refused(stem: &Path) -> String {
    let saved = Pictures::default().save(Ok(picture()), stem, false);
    saved.expect_err("refuses").to_string()
}

#[cfg(not(feature = "png"))]
#[test]
fn a_png_of_an_earlier_run_is_refused_or_removed() {
    let folder = Folder::empty();
    let stem = folder.join("a");
    let png = folder.join("a.png");
    fs::write(&png, "old").expect("writes");
    assert!(refused(&stem).contains("already exists"));
    assert!(!folder.join("a.svg").exists(), "both or neither");
    Pictures::default()
        .save(Ok(picture()), &stem, true)
        .expect("saves");
    assert!(!png.exists());
}

#[cfg(feature = "png")]
#[test]
fn existing_files_are_refused_unless_overwriting_is_wanted() {
    let folder = Folder::empty();
    let stem = folder.join("relax-0.2247");
    Pictures::default()
        .save(Ok(picture()), &stem, false)
        .expect("saves");
    let [svg, png] = ["svg", "png"].map(|end| folder.join(format!("relax-0.2247.{end}")));
    assert_eq!(fs::read_to_string(&svg).expect("reads"), picture().svg());

    fs::remove_file(&svg).expect("removes");
    fs::write(&png, "precious").expect("writes");
    assert!(refused(&stem).contains("already exists"));
    assert!(!svg.exists(), "both files or neither");
    assert_eq!(fs::read(&png).expect("reads"), b"precious");
    let left = fs::read_dir(&*folder).expect("lists").count();
    assert_eq!(left, 1, "leftovers");

    Pictures::default()
        .save(Ok(picture()), &stem, true)
        .expect("overwrites");
    assert!(fs::read(&png).expect("reads").starts_with(PNG_SIGNATURE));
    let nowhere = refused(&folder.join("missing").join("relax"));
    assert_says(&nowhere, "check that the folder exists");
}

#[test]
fn a_panel_that_a_run_will_not_have_is_refused_before_it_with_those_that_it_has() {
    let place = Place::with_examples();
    let rows = (0..=20).map(|n| format!("{},{}\n", 0.1 * f64::from(n), 0.1));
    let record = format!("time_s,force_n\n{}", rows.collect::<String>());
    fs::write(place.path("record.csv"), record).expect("writes");
    for [line, stem] in testkit::table(
        "
        relax --duration 2s | relax
        relax --duration 2s --against record.csv | relax
        run experiments/relax-driven.toml duration=2s | relax
        creep --duration 2s | creep
        creep --duration 2s --loading sphere --indenter-radius 5mm --force 50mN | creep
        run experiments/wall.toml duration=1s | wall
        run experiments/coupler.toml duration=1s | coupler
        run experiments/touch-disc.toml duration=1s | touch
        run experiments/touch-edge.toml duration=1s | touch
        run experiments/teleoperation.toml duration=5s | teleoperation
        press --hold-time 1s | press
        ",
    ) {
        let ended = place.run(&format!("{line} --out p --panel z"));
        let error = ended.error();
        let list = error.split_once("`z`: ").map_or("", |parts| parts.1);
        let known = list.split_once("); give a letter").map(|parts| parts.0);
        let known = known.unwrap_or_else(|| panic!("{line}: {error}"));
        assert!(!place.path("p").exists(), "{line}: it ran");
        let ran = place.run(&format!("{line} --out p --figure-format svg"));
        assert!(!ran.stderr.contains("error"), "{ran}");
        let svg = place.text(&format!("p/{stem}.svg"));
        let mut next = 'a';
        for panel in known.split("), ") {
            let (letter, caption) = panel.split_once(" (").expect("a caption");
            let shown: String = format!("({letter}) {caption}").chars().take(12).collect();
            assert!(svg.contains(&shown), "{line}: {shown}");
            next = char::from(next as u8 + 1);
        }
        assert!(
            !svg.contains(&format!("({next}) ")),
            "{line}: more than {known}"
        );
        std::fs::remove_dir_all(place.path("p")).expect("removed");
    }
}
