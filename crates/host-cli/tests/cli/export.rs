//! `export-c`: a header that a C compiler takes, or one line that says why not.

use crate::process::{Place, cases, says};

#[test]
fn a_header_is_written_once_and_compiles() {
    let place = Place::new();
    let command = "export-c --order 0.5 --sample-time 1ms --horizon 1h --name half --out half.h";
    place.run(command).succeeded();
    let header = place.text("half.h");
    assert!(header.contains("static inline float half_step(half_t *self, float x)"));
    assert!(
        header.contains("D^0.5 x, sample time 0.001 s") && header.contains("Error up to 3600 s")
    );
    place.write(
        "main.c",
        "#include \"half.h\"\n#include <stdio.h>\nint main(void) { half_t h; half_init(&h); \
         printf(\"%.9g\\n\", (double)half_step(&h, 1.0f)); return 0; }\n",
    );
    let ran = place.shell("cc -std=c99 -Wall -Wextra -Werror main.c -o main && ./main");
    // The first output is T^(−1/2).
    let first: f64 = ran.succeeded().stdout.trim().parse().expect("a number");
    assert!((first - 1000f64.sqrt()).abs() < 1e-5, "{first}");
    place
        .run(command)
        .refused(2, &["half.h", "already exists", "--overwrite"]);
    place.run(&format!("{command} --overwrite")).succeeded();
}

#[test]
fn the_law_of_any_tissue_compiles_and_presses_back_as_it_does_here() {
    let place = Place::new();
    // A fractional Maxwell model: one memory, not one order.
    let command = "export-c --tissue fish-muscle --area 4cm2 --thickness 2cm --sample-time 1ms --name muscle \
                   --precision f64 --out muscle.h --json";
    let json = place.run(command).succeeded().json();
    assert_eq!(json["tissue"], "fish-muscle");
    assert_eq!(json["stiffness_n_per_m"], 0.0);
    let header = place.text("muscle.h");
    says(
        &header,
        &[
            "the one memory of the model fractional-maxwell",
            "--tissue fish-muscle",
            "muscle_push(",
        ],
    );
    place.write(
        "main.c",
        "#include \"muscle.h\"\n#include <stdio.h>\nint main(void) { muscle_t h; int n; double f = 0.0; muscle_init(&h);\n\
         for (n = 0; n <= 100; ++n) { f = muscle_push(&h, 1e-3); muscle_advance(&h, muscle_depth(1e-3)); }\n\
         printf(\"%.17g %.17g\\n\", f, muscle_push(&h, -1e-3)); return 0; }\n",
    );
    let ran =
        place.shell("cc -std=c99 -Wall -Wextra -Werror -ffp-contract=off main.c -o main && ./main");
    let ran = ran.succeeded().stdout;
    let numbers: Vec<f64> = (ran.split_whitespace())
        .map(|n| n.parse().expect("a number"))
        .collect();
    // 5 % of strain for 0.1 s, by the sums over the whole history.
    let library = haptic_tissue::Library::load(None).expect("loads");
    let muscle = library.find("fish-muscle").expect("is there").model;
    let stress = 0.05 * muscle.relaxation_moduli(&[0.1])[0];
    let want = -stress * 4e-4;
    assert!(
        (numbers[0] / want - 1.0).abs() < 0.01,
        "{ran}, wanted {want}"
    );
    assert_eq!(numbers[1], 0.0);
    place
        .run("export-c --tissue fish-muscle --order 0.5 --sample-time 1ms")
        .refused(2, &["--tissue", "--order"]);
    place
        .run("export-c --tissue fish-muscle --sample-time 1ms --scheme grunwald:9")
        .refused(2, &["model with more elements", "full"]);
}

#[test]
fn without_a_file_the_header_is_printed() {
    let place = Place::new();
    let printed =
        place.run("export-c --order 1 --sample-time 1ms --scheme grunwald:2 --precision f64");
    assert!(
        printed
            .succeeded()
            .stdout
            .contains("double operator_d_output(")
    );
    let json = place
        .run("export-c --order 1 --sample-time 1ms --scheme grunwald:2 --json")
        .json();
    assert_eq!(json["coefficients"], 2);
    assert!(
        json["header"]
            .as_str()
            .is_some_and(|header| header.contains("#endif"))
    );
    assert!(json["file"].is_null() && json["error_bound"].is_null());
}

#[test]
fn what_gives_no_header_is_refused_in_one_line() {
    let place = Place::new();
    for (options, words) in cases(
        r#"
        --order 0.5 --sample-time 1ms --name int => "int" | C identifier | --name
        --order 0.5 --sample-time 1ms --scheme exact => exact | full
        --order 0.5 --sample-time 1ms --scheme full-bdf2 => full-bdf2 | no form in C | --scheme full
        --order 3 --sample-time 1ms => order 3 | [-2, 2] | --order
        --order 0.5 --sample-time 0s => sample time 0 s | --sample-time
        --order 0.5 --sample-time 1ms --horizon 1e20s => horizon 1e20 s is not above 0 and at most 1e15 s | --horizon
        --order 0.5 --sample-time 1ms --horizon -1s => horizon -1 s | --horizon
        --order 0.5 --sample-time 1ms --out no/where/half.h => no/where/half.h | folder
        "#,
    ) {
        place.run(&format!("export-c {options}")).refused(2, &words);
    }
}
