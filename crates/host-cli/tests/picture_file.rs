//! How a picture gets onto the disk: both files or neither.

use std::fs;

use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Picture, Scale, Series};
use host_cli::picture_file::{PictureFileError, save};
use host_cli::record::NewFileError;

/// What a PNG begins with.
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
fn existing_files_are_refused_unless_overwriting_is_wanted() {
    let folder = tempfile::tempdir().expect("folder");
    let stem = folder.path().join("relax-0.2247");
    let picture = picture();
    let saved = save(&picture, &stem, false).expect("saves");
    assert!(saved.svg.ends_with("relax-0.2247.svg") && saved.png.ends_with("relax-0.2247.png"));
    let svg = fs::read_to_string(&saved.svg).expect("reads");
    assert_eq!(svg, picture.svg());

    fs::remove_file(&saved.svg).expect("removes");
    fs::write(&saved.png, "precious").expect("writes");
    let error = save(&picture, &stem, false).expect_err("refuses");
    assert!(
        matches!(error, PictureFileError::File(NewFileError::Exists(_))),
        "{error}"
    );
    assert!(!saved.svg.exists(), "both files or neither");
    assert_eq!(fs::read(&saved.png).expect("reads"), b"precious");
    assert_eq!(
        fs::read_dir(folder.path()).expect("lists").count(),
        1,
        "leftovers"
    );

    save(&picture, &stem, true).expect("overwrites");
    let png = fs::read(&saved.png).expect("reads");
    assert!(png.starts_with(PNG_SIGNATURE));
    let nowhere = folder.path().join("missing").join("relax");
    let error = save(&picture, &nowhere, false).expect_err("refuses");
    assert!(
        error.to_string().contains("check that the folder exists"),
        "{error}"
    );
}
