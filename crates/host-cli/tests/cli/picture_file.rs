//! Saving a picture: both files or neither; SVG alone without the feature `png`.

use std::fs;

use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Picture, Scale, Series};
use haptic_log::record::NewFileError;
use host_cli::picture_file::{PictureFileError, save};

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
    let folder = tempfile::tempdir().expect("folder");
    let saved = save(&picture(), &folder.path().join("a"), false).expect("saves");
    let (ending, files) = if cfg!(feature = "png") {
        ("a.png", 2)
    } else {
        ("a.svg", 1)
    };
    assert!(saved.shown().ends_with(ending), "{saved:?}");
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), files);
}

#[cfg(not(feature = "png"))]
#[test]
fn a_png_of_an_earlier_run_is_refused_or_removed() {
    let folder = tempfile::tempdir().expect("folder");
    let stem = folder.path().join("a");
    let png = folder.path().join("a.png");
    fs::write(&png, "old").expect("writes");
    assert!(matches!(
        save(&picture(), &stem, false),
        Err(PictureFileError::File(NewFileError::Exists(_)))
    ));
    assert!(!folder.path().join("a.svg").exists(), "both or neither");
    save(&picture(), &stem, true).expect("saves");
    assert!(!png.exists());
}

#[cfg(feature = "png")]
#[test]
fn existing_files_are_refused_unless_overwriting_is_wanted() {
    let folder = tempfile::tempdir().expect("folder");
    let stem = folder.path().join("relax-0.2247");
    let picture = picture();
    let saved = save(&picture, &stem, false).expect("saves");
    let saved_png = saved.png.as_ref().expect("has pixels");
    assert!(saved.svg.ends_with("relax-0.2247.svg") && saved_png.ends_with("relax-0.2247.png"));
    let svg = fs::read_to_string(&saved.svg).expect("reads");
    assert_eq!(svg, picture.svg());

    fs::remove_file(&saved.svg).expect("removes");
    fs::write(saved_png, "precious").expect("writes");
    let error = save(&picture, &stem, false).expect_err("refuses");
    let exists = matches!(error, PictureFileError::File(NewFileError::Exists(_)));
    assert!(exists, "{error}");
    // Both files or neither, and no leftovers.
    assert!(!saved.svg.exists());
    assert_eq!(fs::read(saved_png).expect("reads"), b"precious");
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 1);

    save(&picture, &stem, true).expect("overwrites");
    assert!(
        fs::read(saved_png)
            .expect("reads")
            .starts_with(PNG_SIGNATURE)
    );
    let nowhere = folder.path().join("missing").join("relax");
    let said = save(&picture, &nowhere, false)
        .expect_err("refuses")
        .to_string();
    assert!(said.contains("check that the folder exists"), "{said}");
}
