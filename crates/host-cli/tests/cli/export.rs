//! `export-c`: a header that a C compiler takes, or one line that says why not.

use crate::process::Place;

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
    Place::new().refuses(
        r#"
        export-c --order 0.5 --sample-time 1ms --name int => "int" | C identifier | --name
        export-c --order 0.5 --sample-time 1ms --out no/where/half.h => no/where/half.h | folder
        "#,
    );
}
