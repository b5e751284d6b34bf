//! Pictures of a run: what is on them and what must never be.

use crate::picture::{self, texts};
use haptic_figure::{FigureError, HeldPanels, MeasuredCurve, Picture, TheoryFigure};

/// Pixels of a PNG per unit of the SVG.
#[cfg(feature = "png")]
const SCALE: u32 = 2;

const CONDITIONS: &str = "prostate, cancerous  ·  order μ = 0.2247  ·  device serial:/dev/ttyACM0  ·  scheme full:1e-6  ·  5 % strain in 1 s, held";

/// Ramp and hold after theory.md, 9, with a wiggle of 1e-3 as the run.
struct Relaxation {
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    theory_n: Vec<f64>,
    relative_error: Vec<f64>,
}

impl Relaxation {
    fn new(samples: u32) -> Self {
        // F = η·r·(t^(1−α) − (t−T₀)₊^(1−α))/Γ(2−α) with T₀ = 1 s; η in N·s^α.
        let (eta, alpha, rate, gamma) = (173.0, 0.2247, 0.05, 0.925);
        let power = |t: f64| t.max(0.0).powf(1.0 - alpha);
        let time_s: Vec<f64> = (0..samples).map(|i| f64::from(i) * 1e-3).collect();
        let theory_n: Vec<f64> = (time_s.iter())
            .map(|t| eta * rate * (power(*t) - power(t - 1.0)) / gamma)
            .collect();
        let relative_error: Vec<f64> = time_s.iter().map(|t| 1e-3 * (97.0 * t).sin()).collect();
        let force_n = (theory_n.iter().zip(&relative_error))
            .map(|(force, error)| force * (1.0 + error))
            .collect();
        Self {
            time_s,
            force_n,
            theory_n,
            relative_error,
        }
    }

    fn draw(&self) -> Result<Picture, FigureError> {
        self.draw_as("Stress relaxation of a virtual prostate", CONDITIONS)
    }

    fn draw_as(&self, title: &str, subtitle: &str) -> Result<Picture, FigureError> {
        let figure = TheoryFigure {
            title,
            subtitle,
            origin: "rendered",
            ..self.figure()
        };
        figure.draw()
    }

    /// Of a simulated indenter that nobody holds.
    fn figure(&self) -> TheoryFigure<'_> {
        TheoryFigure {
            title: "Relaxation",
            subtitle: CONDITIONS,
            quantity: "force",
            label: "force / N",
            origin: "simulated",
            time_s: &self.time_s,
            values: &self.force_n,
            closed_form: &self.theory_n,
            relative_error: &self.relative_error,
            record: None,
            held: None,
        }
    }
}

fn assert_sound(picture: &Picture, name: &str) {
    picture::assert_sound(picture, name, 300_000);
}

#[test]
fn the_relaxation_picture_says_what_is_on_its_axes_and_under_what_conditions() {
    let picture = Relaxation::new(20_000).draw().expect("draws");
    let svg = picture.svg();
    for text in [
        "time / s",
        "force / N",
        "relative error",
        "rendered force",
        "closed form",
        "device serial:/dev/ttyACM0",
        "(a) force",
        "(b) force, log–log",
        "(c) relative error",
        "prostate, cancerous",
        "μ = 0.2247",
        "full:1e-6",
        "10⁻³",
    ] {
        assert!(svg.contains(text), "`{text}` is missing");
    }
    assert_sound(&picture, "relaxation");
}

#[test]
fn a_device_that_a_controller_held_has_two_panels_more() {
    let data = Relaxation::new(5_000);
    let figure = TheoryFigure {
        record: None,
        held: Some(HeldPanels {
            time_s: &data.time_s,
            label: "tracking error / µm",
            tracking_error: &data.relative_error,
            force_n: &data.force_n,
        }),
        ..data.figure()
    };
    let picture = figure.draw().expect("draws");
    for text in [
        "(d) set point less measurement",
        "(e) force of the drive",
        // A thousandth of a micrometre.
        "tracking error / nm",
    ] {
        assert!(picture.svg().contains(text), "`{text}` is missing");
    }
    assert_sound(&picture, "held");
    let mut short = figure;
    if let Some(held) = &mut short.held {
        held.force_n = &data.force_n[1..];
    }
    assert!(short.draw().is_err());
}

#[test]
fn a_measured_record_lies_under_the_run_and_has_a_panel_for_the_error() {
    let data = Relaxation::new(5_000);
    let record = MeasuredCurve {
        time_s: &data.time_s[..40],
        values: &data.force_n[..40],
        relative_error: &data.relative_error[..40],
        rms: 0.0321,
    };
    let figure = TheoryFigure {
        record: Some(record),
        ..data.figure()
    };
    let picture = figure.draw().expect("draws");
    for text in [
        "(d) run less record, over the record: rms 3.21 %",
        "difference / %",
        "measured",
    ] {
        assert!(picture.svg().contains(text), "`{text}` is missing");
    }
    assert_sound(&picture, "measured");
    let lacks = MeasuredCurve {
        values: &data.force_n[..39],
        ..record
    };
    let figure = TheoryFigure {
        record: Some(lacks),
        ..figure
    };
    assert!(figure.draw().is_err());
}

#[test]
fn the_creep_and_motion_pictures_say_what_is_on_their_axes() {
    let data = Relaxation::new(5_000);
    let creep = TheoryFigure {
        title: "Creep",
        quantity: "strain",
        label: "strain",
        ..data.figure()
    };
    let creep = creep.draw().expect("draws");
    assert!(creep.svg().contains(">strain</text>") && creep.svg().contains("time / s"));
    assert!(creep.svg().contains(">simulated strain</text>"));
    assert_sound(&creep, "creep");
}

#[test]
fn no_value_however_odd_reaches_an_axis_or_moves_text_off_the_page() {
    let odd = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -1.0,
        1e-320,
        -0.0,
    ];
    let mut spoilt = Relaxation::new(3_000);
    for (index, value) in odd.iter().cycle().take(700).enumerate() {
        spoilt.force_n[3 * index] = *value;
        spoilt.theory_n[3 * index + 1] = *value;
        spoilt.relative_error[3 * index + 2] = *value;
        spoilt.time_s[4 * index] = odd[index % 5];
    }
    assert_sound(&spoilt.draw().expect("draws"), "spoilt");

    let scaled = |factor: f64| {
        let mut data = Relaxation::new(3_000);
        data.force_n.iter_mut().for_each(|force| *force *= factor);
        data.theory_n.iter_mut().for_each(|force| *force *= factor);
        data
    };
    for factor in [1e-9, -1e-3, 0.0, -1.0, 1e4, 1e12] {
        assert_sound(
            &scaled(factor).draw().expect("draws"),
            &format!("factor {factor}"),
        );
    }
    let mut flat = Relaxation::new(3_000);
    flat.force_n.fill(3.000_001);
    flat.theory_n.fill(3.0);
    flat.relative_error.fill(0.0);
    assert_sound(&flat.draw().expect("draws"), "flat");
    let mut nearly_flat = Relaxation::new(3_000);
    nearly_flat.force_n.fill(3.0);
    nearly_flat.theory_n.fill(3.0_f64.next_up());
    nearly_flat.time_s.fill(1e9);
    nearly_flat.time_s[0] = 1e9_f64.next_up();
    assert_sound(&nearly_flat.draw().expect("draws"), "nearly flat");
    let mut huge = Relaxation::new(3_000);
    (huge.force_n[1], huge.force_n[2]) = (f64::MAX, f64::MIN);
    (huge.theory_n[1], huge.time_s[3]) = (1e30, 1e-300);
    assert_sound(&huge.draw().expect("draws"), "huge");
    let one = Relaxation {
        time_s: vec![1.0],
        ..Relaxation::new(1)
    };
    assert_sound(&one.draw().expect("draws"), "one sample");
}

#[test]
fn a_title_too_long_for_the_page_goes_on_in_further_lines_and_a_word_is_cut() {
    let data = Relaxation::new(100);
    let title = "A title that goes on and on ".repeat(20);
    let subtitle = format!(
        "{CONDITIONS}  ·  {} {}",
        "WWWMMM ".repeat(60),
        "W".repeat(200)
    );
    let picture = data.draw_as(&title, &subtitle).expect("draws");
    assert_sound(&picture, "long title");
    assert_eq!(picture.svg().matches("goes").count(), 20);
    assert_eq!(picture.svg().matches("WWWMMM").count(), 60);
    assert_eq!(picture.svg().matches('…').count(), 1);
}

#[test]
fn two_hundred_thousand_noisy_samples_stay_a_small_file_that_keeps_the_peak() {
    let mut data = Relaxation::new(200_000);
    for (index, force) in data.force_n.iter_mut().enumerate() {
        *force += ((index * 7919) % 1000) as f64 * 1e-3;
    }
    data.force_n[123_457] = 40.0;
    let picture = data.draw().expect("draws");
    assert_sound(&picture, "noise");
    // The axis of the linear panel reaches the one sample at 40 N.
    let texts = texts(&picture);
    assert!(texts.iter().any(|(text, _)| text == "40"), "{texts:?}");
}

#[test]
fn the_same_data_give_the_same_picture() {
    let data = Relaxation::new(2_000);
    assert_eq!(data.draw().expect("draws"), data.draw().expect("draws"));
}

#[cfg(feature = "png")]
#[test]
fn the_png_has_its_size_and_its_text() {
    let picture = Relaxation::new(2_000).draw().expect("draws");
    let (width, height) = picture::size(&picture);
    let bytes = picture.png().expect("renders");
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .expect("is PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("fits")];
    let info = reader.next_frame(&mut pixels).expect("is whole");
    assert_eq!(info.width, width as u32 * SCALE);
    assert_eq!(info.height, height.ceil() as u32 * SCALE);
    // A font that is not found would lose its text silently: the band of the title must have ink.
    let band = pixels
        .chunks_exact(4)
        .take((info.width * 40 * SCALE) as usize);
    let dark = band.filter(|pixel| pixel[0] < 100).count();
    assert!(dark > 1_000, "{dark} dark pixels in the title");
}

#[test]
fn nothing_to_draw_and_slices_that_do_not_match_are_errors() {
    let empty = Relaxation::new(0);
    assert!(matches!(empty.draw(), Err(FigureError::Empty { .. })));
    let mut spoilt = Relaxation::new(10);
    spoilt.force_n.fill(f64::NAN);
    assert!(matches!(
        spoilt.draw(),
        Err(FigureError::Empty { samples: 10, .. })
    ));
    let mut short = Relaxation::new(10);
    short.theory_n.pop();
    let error = short.draw().expect_err("refuses");
    assert_eq!(
        error.to_string(),
        "closed form has 9 samples where time has 10; both need the same number"
    );
}
