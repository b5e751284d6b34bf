//! Fifty more mistakes of a first hour, by what public threads ask of such programs: units, blanks, letters of formulas, words of other
//! programs, ports, files. Each answer names the remedy, and none sends the wrong way.

use crate::process::{Place, cases};

/// A line as it is typed, what its answer says, and behind `!` what it must not say.
const MISTAKES: &str = r#"
    relax --duration 10sec => with one of the units s, ms
    relax --duration 2mins => write 2min
    relax --duration 200seconds => with one of the units s, ms
    relax --sample-time 1kHz => write 1ms
    relax --sample-time 500Hz => write 2ms
    relax --area 4cm^2 => write 4cm2
    relax --strain 5 => 5 has no unit: write 5% ! 0.05
    relax --strain 5 % => write 5%, without a blank ! KEY=VALUE
    relax --thickness 20 mm => write 20mm, without a blank ! if it is that
    creep --stress 5 kPa => write 5kPa, without a blank ! KEY=VALUE
    creep --stress 5kpa => write 5kPa
    run experiments/wall.toml mass=65gr => with one of the units kg, g
    run experiments/wall.toml mass=65grams => with one of the units kg, g
    run experiments/wall.toml mass=0.065kgs => write 0.065kg
    run experiments/wall.toml force_limit=3.3 N => write force_limit=3.3N, without a blank ! KEY=VALUE
    run experiments/wall.toml stiffness = 3 => write stiffness=3, without a blank ! KEY=VALUE
    run experiments/wall.toml stiffness:3 => is not KEY=VALUE, as sample_time=1ms
    run experiments/wall.toml one_sided => is not KEY=VALUE, as sample_time=1ms
    run experiments/wall.toml order=1/2 => write 0.5
    run experiments/wall.toml K=3000 => did you mean `stiffness_n_per_m`? ! known are
    run experiments/wall.toml B=30 => did you mean `dissipation_n_s_mu_per_m`? ! known are
    run experiments/wall.toml mu=0.5 => did you mean `order`? ! known are
    run experiments/wall.toml encoder=20um => did you mean `encoder_resolution_m`? ! known are
    run experiments/wall.toml wal.stiffness=3 => did you mean `stiffness_n_per_m`? ! known are
    run experiments/wall => give the path of a TOML file
    run record.csv => record.csv:1 ! a point
    run units.toml => the unit is in the key: write mass_kg = 0.065 ! quoted
    run quoted.toml => is a string, not a number
    design --gain-margin 6dB => write 1.995
    design --encoder 20um => did you mean `encoder_resolution=VALUE`?
    design --friction 0.3 => did you mean `friction=VALUE`?
    device set --force-limit 0.5N => did you mean `force_limit=VALUE`?
    device emulate --delay 3ms => did you mean `delay=VALUE`?
    device emulate drop=1,5% => write 1.5%
    design --force-noise-limit 50mn => write 50mN
    design encoder=20um => did you mean `encoder_resolution_m`? ! known are
    relax liver => as --tissue liver
    relax -tissue liver => did you mean `--tissue`?
    relax -o results => did you mean `--out`?
    relax --rate 1000 => did you mean `--sample-time`? ! --write
    creep --strain 5% => did you mean `--stress`? ! --duration
    relax --device ttyACM0 => write serial:ttyACM0
    relax --device serial => serial:auto
    device emulate drop=5 => drop=5 is not from 0 to 1
    device info COM3 => write serial:COM3
    device info /dev/ttyACM0 => write serial:/dev/ttyACM0
    device info --port COM3 => did you mean `--device`?
    device measre => did you mean `measure`?
    device set workspace=-20:20 => write -20mm, or -20m if it is that
    device set mass=65 => write 65g
    device set force_limit 0.5N => KEY=VALUE, as force_limit=0.5N
    run experiments/coupler.toml --coupler-stiffness 1 => coupler_stiffness=VALUE
    control analyze --plant 1/(s**2+1) => write a power as s^2
    control analyze --plant 1/(z+1) => a number for any letter but s
    control analyze --plant tf([1],[1,1]) => as in 1/(0.8s
    control analyze --plant K/(s+1) => a number for any letter but s
    control analyze --plant oven => a file that ends in .toml
    control analyze --plant s^0.5 => an operator alone is no plant ! faster pole
    control design --plant 1/(s+1) --crossover 1rad/s --phase-margin 60degrees => with one of the units rad, deg
    control design --plant 1/(s+1) --bandwidth 1rad/s --phase-margin 60deg => did you mean `--crossover`?
    weights --order s^0.5 => give a finite number
    rt-check --duration 1 min => write 1min, without a blank ! unexpected
    identify loaded.csv => the strain begins at 0.03, not at 0 | --subtract-start
    identify relax.csv --subtract-start => --subtract-start has no effect
    version => unrecognized ! design
    relax --tissue liver. => did you mean `liver`? ! ?;
"#;

#[test]
fn the_answer_to_a_first_hours_mistake_names_the_remedy_and_no_wrong_one() {
    let place = Place::with_examples();
    place.write("record.csv", "t,u,y\n0,0,0\n1,1,0.5\n2,1,0.75\n");
    place.write("units.toml", "[wall]\nmass_kg = 65g\n");
    place.write("quoted.toml", "[wall]\nsample_time_s = \"1ms\"\n");
    place.write("loaded.csv", LOADED);
    let rows = "time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n4,2.5\n5,2.2\n";
    place.write("relax.csv", rows);
    let mut complaints = Vec::new();
    for line in MISTAKES.lines().filter(|line| !line.trim().is_empty()) {
        let (line, wrong) = line.split_once(" ! ").unwrap_or((line, "\n\n"));
        for (typed, wanted) in cases(line) {
            let ended = place.run(typed);
            complaints.extend(ended.complaint(2, &wanted));
            if ended.stderr.contains(wrong) {
                complaints.push(format!("{typed}: sends the wrong way, {wrong}: {ended}"));
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// Record of a testing machine whose gauges were not zeroed: 3 % and 10 Pa at rest, then the law of a spring of 20 kPa.
const LOADED: &str = "time_s,strain,stress_pa
0,0.03,10\n1,0.04,210\n2,0.05,410\n3,0.06,610\n4,0.07,810\n5,0.08,1010\n6,0.07,810\n7,0.06,610
";

#[test]
fn gauges_that_were_not_zeroed_are_counted_from_their_first_row() {
    let place = Place::new();
    place.write("loaded.csv", LOADED);
    let line = "identify loaded.csv --model spring --subtract-start --json";
    let message = place.run(line).succeeded_with_warnings().json();
    // (210 − 10) Pa over (0.04 − 0.03).
    let modulus = message["parameters"]["elastic_modulus_pa"]["value"]
        .as_f64()
        .expect("a number");
    assert!((modulus / 2e4 - 1.0).abs() < 1e-6, "{message}");
}
