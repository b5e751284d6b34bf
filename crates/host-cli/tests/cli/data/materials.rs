//! `materials`: listed, shown, exported, refused.

use super::GEL;
use crate::process::{Place, number, says};
use serde_json::Value;

#[test]
fn materials_are_listed_with_those_of_the_user() {
    let place = Place::new();
    std::fs::create_dir(place.path("mine")).expect("makes the folder");
    place.write("mine/gel.toml", GEL);
    let names = |line: &str| -> Vec<String> {
        let list = place.run(line).succeeded().json();
        let list = list["materials"].as_array().expect("a list").clone();
        let name = |m: &Value| m["name"].as_str().expect("a name").to_owned();
        list.iter().map(name).collect()
    };
    let own = ["prostate-cancerous", "prostate-healthy", "fish-muscle"];
    assert_eq!(names("materials list --json"), own);
    let with_gel = names("materials list --library mine --json");
    assert_eq!(with_gel, [own[0], own[1], own[2], "gel"]);
    let text = place.run("materials list --library mine").succeeded();
    let muscle = text.stdout.split("fish-muscle").nth(1).expect("a row");
    says(
        muscle,
        &["fractional-maxwell", "13.9 ms to 981 s", "no", "pyRheo"],
    );
    assert!(text.stdout.contains("gel"), "{text}");
}

#[test]
fn a_material_is_shown_with_its_source() {
    let place = Place::new();
    place.write("gel.toml", GEL);
    let gel = place.run("materials show gel.toml --json").succeeded();
    let gel = gel.json();
    assert_eq!(number(&gel, "viscosity_pa_s_alpha"), 5.0);
    assert_eq!(gel["model"], "fractional-kelvin-voigt");
    assert_eq!(number(&gel["parameters"], "second_order"), 0.0);
    let muscle = place.run("materials show fish-muscle --json").succeeded();
    let muscle = muscle.json();
    assert_eq!(muscle["order"], Value::Null);
    assert_eq!(number(&muscle["parameters"], "second_order"), 0.1102);
    assert_eq!(gel["source"]["checked"], Value::from(true));
    let show = place.run("materials show prostate-cancerous --json");
    let show = show.succeeded().json();
    assert_eq!(number(&show, "order"), 0.2247);
    assert_eq!(show["source"]["checked"], Value::from(false));
    let citation = show["source"]["citation"].as_str().expect("text");
    assert!(citation.contains("Tokatlı"), "{citation}");
}

#[test]
fn what_show_prints_of_a_tissue_that_comes_along_is_a_file_to_start_from() {
    let place = Place::new();
    let shown = place.run("materials show prostate-healthy").succeeded();
    place.write("copy.toml", shown.stdout);
    let copy = place.run("materials show copy.toml --json").succeeded();
    let original = place.run("materials show prostate-healthy --json");
    assert_eq!(copy.json(), original.succeeded().json());
}

#[test]
fn a_tissue_is_exported_for_finite_elements_with_its_error() {
    let place = Place::new();
    let table = place.run("materials export fish-muscle --prony 12 --horizon 1000s");
    let table = table.succeeded().stdout;
    let rows: Vec<&str> = table
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect();
    assert_eq!(rows[0], "branch,modulus_pa,relaxation_time_s");
    assert!(rows.len() <= 14, "{table}");
    assert!(
        table.contains("# largest relative error of G over this band: "),
        "{table}"
    );
    let line = "materials export fish-muscle --format febio --out muscle.xml";
    let said = place.run(line).succeeded().stdout;
    assert!(
        said.contains("muscle.xml") && said.contains("max relative error"),
        "{said}"
    );
    let written = std::fs::read_to_string(place.path("muscle.xml")).expect("a file");
    assert!(written.contains("<g0>1</g0>"), "{written}");
    place.run(line).refused(2, &["muscle.xml"]);
    place.run(&format!("{line} --overwrite")).succeeded();
    let json = place.run("materials export prostate-healthy --format abaqus --json");
    let json = json.succeeded().json();
    assert!(number(&json, "max_relative_error") < 0.01);
    assert_eq!(
        json["branch_moduli_pa"].as_array().map(Vec::len),
        json["branch_times_s"].as_array().map(Vec::len)
    );
    assert_eq!(json["file"], Value::Null);
    place
        .run("materials export fish-muscle --format febio --prony 7")
        .refused(2, &["take --prony", "6"]);
}

#[test]
#[cfg(unix)]
fn what_is_no_tissue_is_named_with_its_reason_and_skipped() {
    let place = Place::new();
    std::fs::create_dir_all(place.path("mine/folder.toml")).expect("makes folders");
    place.write("mine/gel.toml", GEL);
    place.write("mine/wall.toml", GEL.replace("order = 0.3", "order = 1.3"));
    place.write("mine/bytes.toml", "\u{0}\u{1}");
    // A pipe that nobody writes to must not be waited for.
    place.shell("mkfifo mine/pipe.toml").succeeded();
    for line in [
        "materials list",
        "export-c --tissue gel --sample-time 1ms --horizon 10s --name gel --out gel.h",
    ] {
        let ended = place.run(&format!("{line} --library mine"));
        let skipped = ended.stderr.matches("warning: skipped").count();
        assert_eq!(skipped, 4, "{ended}");
        for file in ["folder", "wall", "bytes", "pipe"] {
            says(&ended.stderr, &[&format!("mine/{file}.toml")]);
        }
        let reasons = [
            "it is not a regular file",
            "mine/wall.toml:7: order = 1.3 is not in [0, 1]",
        ];
        says(&ended.stderr, &reasons);
        ended.succeeded_with_warnings();
    }
}
