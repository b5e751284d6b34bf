//! Prony series of models, and their text for finite-element programs, read back.

use haptic_tissue::{
    Card, ExportFormat, Library, Material, MeasuredLoading, Model, ModelKind, PronyFit,
};
use std::path::Path;
use testkit::tissue::model;
use testkit::{assert_refused, assert_relative, assert_says};

fn muscle() -> Model {
    let library = Library::load(None).expect("valid");
    library.find("fish-muscle").expect("known").model
}

/// The largest relative error of a series over a band, at other times than those of the fit.
fn error(model: &Model, series: &Model, shortest_s: f64, horizon_s: f64) -> f64 {
    let decades = libm::log10(horizon_s / shortest_s);
    let times: Vec<f64> = (0..=997)
        .map(|i| shortest_s * libm::pow(10.0, decades * f64::from(i) / 997.0))
        .collect();
    let have = series.relaxation_moduli(&times).into_iter();
    let pairs = have.zip(model.relaxation_moduli(&times));
    pairs.fold(0.0, |most, (have, want)| {
        f64::max(most, (have / want - 1.0).abs())
    })
}

#[test]
fn the_error_that_is_named_is_the_error() {
    let prostate = model(ModelKind::SpringPot, &[8650.0, 0.2247]);
    let gel = model(ModelKind::FractionalZener, &[500.0, 0.8, 3e4, 0.05, 100.0]);
    for (model, branches, most) in [
        (&muscle(), 12, 0.006),
        (&muscle(), 6, 0.05),
        (&prostate, 12, 0.006),
        (&prostate, 1, 0.7),
        (&gel, 10, 0.02),
    ] {
        let fit = PronyFit::new(model, branches, 1e-3, 1e3).expect("fits");
        let series = fit.model().expect("valid");
        let have = error(model, &series, 1e-3, 1e3);
        let named = fit.max_relative_error;
        assert!(named < most, "{branches}: {named}");
        let named_well = have < 1.02 * named && have > 0.9 * named;
        assert!(named_well, "{branches}: {have} {named}");
        assert!(fit.branches.len() <= branches && fit.elastic_modulus_pa >= 0.0);
    }
}

#[test]
fn every_format_takes_as_many_branches_as_it_has_by_itself() {
    for format in ExportFormat::ALL {
        let fit = PronyFit::new(&muscle(), format.branches(), 1e-3, 1e3).expect("fits");
        assert!(
            fit.text(format, Card::Series, "muscle", &MeasuredLoading::default())
                .is_ok(),
            "{format:?}"
        );
    }
}

#[test]
fn more_branches_are_closer() {
    let errors = [3, 6, 12, 24].map(|branches| {
        let fit = PronyFit::new(&muscle(), branches, 1e-3, 1e3);
        fit.expect("fits").max_relative_error
    });
    let closer = errors.is_sorted_by(|a, b| *b < 0.5 * *a);
    assert!(closer, "{errors:?}");
}

#[test]
fn a_prony_series_stays_as_it_is() {
    let prony = model(ModelKind::Prony, &[2.0, 7.0, 0.1, 3.0, 5.0]);
    let fit = PronyFit::new(&prony, 2, 1e-3, 1e3).expect("fits");
    assert_eq!(fit.model().expect("valid"), prony);
}

/// Numbers of a line, whatever stands between them.
fn numbers(line: &str) -> Vec<f64> {
    line.split([',', '<', '>', ' '])
        .filter_map(|cell| cell.parse().ok())
        .collect()
}

#[test]
fn classical_models_are_their_own_series() {
    for (kind, values) in [
        (ModelKind::Maxwell, &[2e3, 40.0][..]),
        (ModelKind::Zener, &[500.0, 2e3, 40.0]),
        (ModelKind::PoyntingThomson, &[500.0, 2e3, 40.0]),
    ] {
        let model = Model::from_parameters(kind, values).expect("in range");
        // Far beyond the time at which nothing is left of it.
        let fit = PronyFit::new(&model, 12, 1e-3, 1e6).expect("a series");
        let found = (fit.branches.len(), fit.max_relative_error);
        assert_eq!(found, (1, 0.0), "{kind}");
        let times = [1e-3, 0.01, 0.05, 0.2];
        let series = fit.model().expect("a model").relaxation_moduli(&times);
        for (have, want) in series.iter().zip(model.relaxation_moduli(&times)) {
            assert_relative(kind.name(), *have, want, 1e-9);
        }
    }
}

/// Pairs from lines of six constants, each with the number of its first.
fn pairs_of_constants(lines: &[Vec<f64>]) -> Vec<[f64; 2]> {
    for (line, row) in lines.iter().enumerate() {
        assert_eq!(row[0] as usize, 1 + 6 * line, "{row:?}");
        assert!(row.len() <= 7, "{row:?}");
    }
    let constants: Vec<f64> = lines.iter().flat_map(|row| row[1..].to_vec()).collect();
    constants.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// The model that a text describes by the convention it names.
fn read_back(format: ExportFormat, text: &str, fit: &PronyFit) -> Model {
    let comment = |line: &str| {
        ["#", "!", "**", "<!--", "branch"]
            .iter()
            .any(|c| line.starts_with(c))
    };
    let lines: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| !comment(line))
        .map(numbers)
        .collect();
    let instantaneous = fit.instantaneous_modulus_pa();
    let (unit, pairs): (f64, Vec<[f64; 2]>) = match format {
        ExportFormat::Table => (1.0, lines[1..].iter().map(|row| [row[1], row[2]]).collect()),
        // TB,PRONY,1,1,N,SHEAR and then TBDATA,first,six constants.
        ExportFormat::Ansys => {
            for part in ["SHEAR", "BULK"] {
                let header = format!("\nTB,PRONY,1,1,{},{part}\n", fit.branches.len());
                assert_says(&text, &header);
            }
            let [shear, bulk] = card(format, text);
            assert_eq!(shear, bulk);
            (instantaneous, shear)
        }
        ExportFormat::Abaqus => (
            instantaneous,
            lines[1..].iter().map(|row| [row[0], row[2]]).collect(),
        ),
        ExportFormat::Febio => {
            assert_says(&text, "<g0>1</g0>\n<g1>");
            (
                fit.elastic_modulus_pa,
                lines[1..].iter().map(|row| [row[0], row[1]]).collect(),
            )
        }
    };
    // In relative terms, what the branches leave of 1 is the spring.
    let sum: f64 = pairs.iter().map(|[modulus, _]| modulus * unit).sum();
    let spring = match format {
        ExportFormat::Table => lines[0][1],
        ExportFormat::Ansys | ExportFormat::Abaqus => (instantaneous - sum).max(0.0),
        ExportFormat::Febio => fit.elastic_modulus_pa,
    };
    let branches = pairs
        .iter()
        .flat_map(|[modulus, time]| [modulus * unit, *time]);
    let values: Vec<f64> = std::iter::once(spring).chain(branches).collect();
    model(ModelKind::Prony, &values)
}

#[test]
fn each_text_describes_the_series_by_the_convention_of_its_program() {
    for format in ExportFormat::ALL {
        let fit = PronyFit::new(&muscle(), 6, 1e-3, 1e3).expect("fits");
        let text = fit
            .text(
                format,
                Card::Series,
                "fish muscle -- a\ntest",
                &MeasuredLoading::default(),
            )
            .expect("text");
        let back = read_back(format, &text, &fit);
        let exact = fit.model().expect("valid");
        for t in [1e-3, 0.1, 7.0, 1e3] {
            let error =
                (back.relaxation_moduli(&[t])[0] / exact.relaxation_moduli(&[t])[0] - 1.0).abs();
            assert!(error < 1e-10, "{format:?} {t}: {error:e}\n{text}");
        }
        assert_says(&text, "largest relative error");
        assert_says(&text, &format!("{:.2e}", fit.max_relative_error));
    }
}

#[test]
fn what_cannot_be_exported_is_refused_with_a_remedy() {
    let refused = |model: &Model, branches, shortest_s, horizon_s| {
        let error = PronyFit::new(model, branches, shortest_s, horizon_s);
        error.expect_err("refused").to_string()
    };
    assert!(refused(&muscle(), 0, 1e-3, 1.0).starts_with("`branches` 0 is not from 1 to 100"));
    assert!(refused(&muscle(), 3, 1.0, 1e-3).contains("decades longer"));
    assert!(refused(&muscle(), 3, 0.0, 1.0).contains("decades longer"));
    assert!(refused(&muscle(), 3, f64::NAN, 1.0).contains("decades longer"));
    let voigt = model(ModelKind::KelvinVoigt, &[100.0, 5.0]);
    assert!(refused(&voigt, 3, 1e-3, 1.0).contains("kelvin-voigt has a parallel dashpot"));
    // More branches than asked for, and nothing left of them.
    let two = model(ModelKind::Prony, &[0.0, 100.0, 0.05, 50.0, 0.1]);
    assert!(refused(&two, 1, 1e-3, 1e4).contains("has decayed to zero"));
    let twelve = PronyFit::new(&muscle(), 12, 1e-3, 1e3).expect("fits");
    let error = twelve
        .text(
            ExportFormat::Febio,
            Card::Series,
            "",
            &MeasuredLoading::default(),
        )
        .expect_err("six terms");
    assert!(error.to_string().ends_with("use `branches` = 6"), "{error}");
}

/// (1 − what has relaxed) of a card's pairs at a time.
fn left(pairs: &[[f64; 2]], time_s: f64) -> f64 {
    let relaxed = |[share, tau]: &[f64; 2]| share * -libm::expm1(-time_s / tau);
    1.0 - pairs.iter().map(relaxed).sum::<f64>()
}

/// The uniaxial stress of a finite-element program that reads a card: of a bar that is strained by 1 at once, whose sides are free
/// at each of these times, with E(0) = 1.
/// ```text
/// side  0 = ∫ (K − ⅔G)(t − τ) dε_a + ∫ (2K + ⅔G)(t − τ) dε_s         G(0) = 1/(2(1 + ν)),  K(0) = 1/(3(1 − 2ν))
/// end   σ = ∫ (K + 4⁄3·G)(t − τ) dε_a + ∫ (2K − 4⁄3·G)(t − τ) dε_s
/// ```
fn uniaxial(shear: &[[f64; 2]], bulk: &[[f64; 2]], ratio: f64, times: &[f64]) -> Vec<f64> {
    if ratio >= 0.5 {
        // No volume changes: E = 3G, whatever the bulk does.
        return times.iter().map(|t| left(shear, *t)).collect();
    }
    let at = |t: f64| {
        let shear = left(shear, t) / (2.0 * (1.0 + ratio));
        (shear, left(bulk, t) / (3.0 * (1.0 - 2.0 * ratio)))
    };
    // The sides move at each time at once.
    let mut moves: Vec<(f64, f64)> = Vec::new();
    let stress = times.iter().map(|&t| {
        let over = |modulus: &dyn Fn(f64, f64) -> f64, moves: &[(f64, f64)]| {
            let each = moves.iter().map(|&(begin, by)| {
                let (shear, bulk) = at(t - begin);
                by * modulus(shear, bulk)
            });
            each.sum::<f64>()
        };
        let (shear, bulk) = at(t);
        let held = bulk - 2.0 / 3.0 * shear + over(&|g, k| 2.0 * k + 2.0 / 3.0 * g, &moves);
        let (first_shear, first_bulk) = at(0.0);
        moves.push((t, -held / (2.0 * first_bulk + 2.0 / 3.0 * first_shear)));
        bulk + 4.0 / 3.0 * shear + over(&|g, k| 2.0 * k - 4.0 / 3.0 * g, &moves)
    });
    stress.collect()
}

/// Shear and bulk pairs of a card.
fn card(format: ExportFormat, text: &str) -> [Vec<[f64; 2]>; 2] {
    let rows = |part: &str| -> Vec<Vec<f64>> {
        let rows = part.lines().filter(|line| line.contains(','));
        rows.map(numbers).collect()
    };
    match format {
        ExportFormat::Abaqus => {
            let (_, data) = text.split_once("TIME=PRONY\n").expect("a card");
            [0, 1].map(|column| rows(data).iter().map(|row| [row[column], row[2]]).collect())
        }
        ExportFormat::Table | ExportFormat::Ansys | ExportFormat::Febio => {
            let (_, data) = text.split_once(",SHEAR\n").expect("a card");
            let (shear, bulk) = data.split_once("TB,PRONY").unwrap_or((data, ""));
            let bulk = bulk.split_once(",BULK\n").map_or("", |(_, bulk)| bulk);
            [shear, bulk].map(|part| pairs_of_constants(&rows(part)))
        }
    }
}

/// Bulk relaxes like the shear with a constant Poisson's ratio, so that a bar pulled in the program is the tissue.
#[test]
fn a_bar_of_the_exported_card_relaxes_like_the_tissue() {
    let skin = model(ModelKind::SpringPot, &[8650.0, 0.2247]);
    let fit = PronyFit::new(&skin, 12, 1e-3, 1e3).expect("fits");
    let times: Vec<f64> = (0..=120)
        .map(|n| 1e-3 * libm::pow(10.0, f64::from(n) / 20.0))
        .collect();
    for format in [ExportFormat::Abaqus, ExportFormat::Ansys] {
        for ratio in [0.3, 0.45, 0.5] {
            let loading = MeasuredLoading {
                poisson_ratio: Some(ratio),
                ..MeasuredLoading::default()
            };
            let text = fit
                .text(format, Card::Series, "skin", &loading)
                .expect("text");
            let [shear, bulk] = card(format, &text);
            let stress = uniaxial(&shear, &bulk, ratio, &times);
            let want = skin.relaxation_moduli(&times);
            let worst = stress.iter().zip(want).fold(0.0, |most, (have, want)| {
                f64::max(
                    most,
                    (have * fit.instantaneous_modulus_pa() / want - 1.0).abs(),
                )
            });
            println!(
                "{format:?} {ratio}: {worst:.1e} of {:.1e}",
                fit.max_relative_error
            );
            assert!(
                worst < 1.02 * fit.max_relative_error,
                "{format:?} {ratio}: {worst}"
            );
        }
    }
}

/// A spring does not relax, and a card without data is refused by the program.
#[test]
fn a_spring_has_no_card() {
    let spring = model(ModelKind::Spring, &[500.0]);
    let fit = PronyFit::new(&spring, 12, 1e-3, 1e3).expect("fits");
    assert_eq!((fit.branches.len(), fit.elastic_modulus_pa), (0, 500.0));
    for format in [ExportFormat::Abaqus, ExportFormat::Ansys] {
        let text = fit.text(format, Card::Series, "spring", &MeasuredLoading::default());
        let text = text.expect("text");
        assert!(
            text.lines().all(|line| line.starts_with(['*', '!'])),
            "{text}"
        );
        assert!(
            !text.contains("\n*VISCO") && !text.contains("\nTB"),
            "{text}"
        );
        assert_says(
            &text,
            "Young's modulus = 500.0 Pa & a spring does not relax",
        );
    }
}

/// `golden/prony`: the cards of a spring-pot of Young's modulus, ν = 0.3, and E(t) of a bar of them, inverted from the Laplace domain.
#[test]
fn the_card_is_the_tissue_by_the_definitions_of_the_programs() {
    const TISSUE: &str = include_str!("../golden/prony/c19-nu03.toml");
    let tissue = Material::parse(Path::new("c19-nu03.toml"), TISSUE).expect("valid");
    let fit = PronyFit::new(&tissue.model, 12, 1e-3, 1e3).expect("fits");
    for (format, name, golden) in [
        (
            ExportFormat::Abaqus,
            "abaqus",
            include_str!("../golden/prony/c19-nu03.abaqus"),
        ),
        (
            ExportFormat::Ansys,
            "ansys",
            include_str!("../golden/prony/c19-nu03.ansys"),
        ),
    ] {
        let text = fit
            .text(format, Card::Series, "", &tissue.loading)
            .expect("text");
        // All but the title, which names the program.
        let body = |text: &str| text.split_once('\n').expect("lines").1.to_owned();
        assert_eq!(body(&text), body(golden));
        let (_, claim) = text.split_once("this band: ").expect("a claim");
        let claim: f64 = claim
            .split(';')
            .next()
            .expect("a number")
            .parse()
            .expect("a number");
        assert!(claim < 5e-4, "{claim}");
        let rows = include_str!("../golden/prony/uniaxial.csv").lines();
        let rows: Vec<Vec<f64>> = rows
            .filter_map(|row| row.strip_prefix(name))
            .map(|row| {
                row[1..]
                    .split(',')
                    .map(|cell| cell.parse().expect("a number"))
                    .collect()
            })
            .collect();
        assert_eq!(rows.len(), 75);
        for row in rows {
            let want = tissue.model.relaxation_moduli(&[row[1]])[0];
            // The last digit of the claim is rounded.
            assert_relative(&format!("{name} {row:?}"), row[2], want, claim + 5e-7);
        }
    }
}

/// A format, ν, and the lines of its whole material around Young's modulus at 0.
const MATERIALS: &str = r"
    abaqus | 0.3 | *MATERIAL, NAME=my_gel | *ELASTIC, MODULI=INSTANTANEOUS | *VISCOELASTIC, TIME=PRONY
    abaqus | 0.5 | *MATERIAL, NAME=my_gel | *ELASTIC, MODULI=INSTANTANEOUS | *VISCOELASTIC, TIME=PRONY
    ansys | 0.3 | MP,PRXY,1,0.3 | TB,PRONY,1,1,2,SHEAR | TB,PRONY,1,1,2,BULK
    ansys | 0.5 | MP,PRXY,1,0.4999 | TB,PRONY,1,1,2,SHEAR | TB,PRONY,1,1,2,BULK
";

#[test]
fn a_whole_material_has_its_elasticity_at_0() {
    // E(0) = 2(1 + ν)·(5 + 7 + 3) of a shear modulus.
    let prony = model(ModelKind::Prony, &[5.0, 7.0, 0.1, 3.0, 5.0]);
    let fit = PronyFit::new(&prony, 2, 1e-3, 1e3).expect("itself");
    let format = |name: &str| {
        let mut formats = ExportFormat::ALL.into_iter();
        formats.find(|format| format.name() == name).expect(name)
    };
    for [name, ratio, first, second, third] in testkit::table(MATERIALS) {
        let ratio: f64 = ratio.parse().expect("a number");
        let loading = MeasuredLoading {
            modulus: Some(haptic_loop::Modulus::Shear),
            poisson_ratio: Some(ratio),
            ..MeasuredLoading::default()
        };
        let text = |card| {
            fit.text(format(&name), card, "my-gel (prony)", &loading)
                .expect("text")
        };
        let (series, whole) = (text(Card::Series), text(Card::Material));
        let lines: Vec<&str> = whole.lines().collect();
        for line in [&first, &second, &third] {
            assert!(lines.contains(&line.as_str()), "{line}: {whole}");
        }
        let elastic = lines.iter().find_map(|line| {
            let line = line.strip_prefix("MP,EX,1,").unwrap_or(line);
            line.split(',').next()?.parse::<f64>().ok()
        });
        assert_relative(
            "E(0)",
            elastic.expect("a number"),
            30.0 * (1.0 + ratio),
            1e-11,
        );
        assert!(
            name == "ansys" || whole.contains(&format!(", {ratio:?}\n")),
            "{whole}"
        );
        // The series is as it is alone.
        assert!(series.lines().all(|line| lines.contains(&line)), "{whole}");
    }
    let spring =
        PronyFit::new(&model(ModelKind::Spring, &[500.0]), 2, 1e-3, 1e3).expect("a spring");
    let loading = MeasuredLoading::default();
    let whole = spring.text(ExportFormat::Abaqus, Card::Material, "gel", &loading);
    let whole = whole.expect("text");
    assert!(
        whole.ends_with("*MATERIAL, NAME=gel\n*ELASTIC\n5.000000000000e2, 0.5\n"),
        "{whole}"
    );
    for name in ["table", "febio"] {
        let refused = fit.text(format(name), Card::Material, "gel", &loading);
        assert_refused(refused, "use ansys or abaqus, or omit `card`");
    }
}
