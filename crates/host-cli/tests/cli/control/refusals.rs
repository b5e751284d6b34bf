//! Bad input of `control`, refused in one line.

use crate::process::Place;

/// Thirteen files, most of them bad.
fn files() -> Place {
    let place = Place::new();
    place.write("c.toml", "[pid]\nproportional_gain = x\n");
    place.write("p.toml", "[device]\nmass_kg = 1\ndampng_n_s_per_m = 2\n");
    place.write("uneven.csv", "time_s,input,output\n0,1,0\n1,1,1\n3,1,2\n");
    place.write("short.csv", "time_s,input\n0,1\n1,1\n");
    let rows = |row: &dyn Fn(i32) -> String| -> String {
        let rows: String = (0..30).map(|n| format!("{n},{}\n", row(n))).collect();
        format!("time_s,input,output\n{rows}")
    };
    place.write("still.csv", rows(&|n| format!("0,{n}")));
    place.write("mute.csv", rows(&|_| "1,0".to_owned()));
    place.write("flat.csv", rows(&|_| "1,2.5".to_owned()));
    place.write(
        "spike.csv",
        rows(&|n| format!("1,{}", if n == 7 { "1e300" } else { "2" })),
    );
    place.write("brief.csv", "time_s,input,output\n0,1,0\n1,1,1\n");
    place.write("good.csv", rows(&|n| format!("1,{n}")));
    place.write("far.csv", rows(&|n| format!("1e60,{n}e-60")));
    place.write("large.csv", "time_s,reference\n0,1\n1,1e300\n2,0\n");
    place.write("small.csv", rows(&|n| format!("1,{n}e-200")));
    place
}

#[test]
fn bad_input_is_refused_in_one_line_with_the_remedy() {
    let place = files();
    let design = "control design --crossover 1rad/s";
    place.refuses(
        &format!(
            "
            control analyze => --plant | --mass
            control analyze --plant s^2/(s+1) => order 2 of the numerator | faster pole | --plant
            control analyze --plant 1/(s-s) => cancels | leave the term out
            control analyze --plant 1/(0s^2+s) => coefficient of s^2 is 0
            control analyze --plant s/(s^2+s) => share the factor s^1
            control analyze --plant 1/(s+1 => character 6 | closing bracket
            control analyze --plant none.toml => none.toml | TOML
            control analyze --plant p.toml => p.toml:3 | did you mean `damping_n_s_per_m`
            control analyze --plant 1/(s+1) --controller c.toml => c.toml:2
            control analyze --plant 1/(s+1) --controller 2 => --sample-time
            control analyze --plant 1/(s+1) --controller s^2 --sample-time 0s => sample time 0 s | --sample-time
            control analyze --plant 1/(s+1) --output-limits 0:1 => no effect | --controller
            control analyze --plant 1/(s+1) --controller 2 --sample-time 1s --output-limits 1:0 => not below
            control analyze --plant 1/(s+1) --controller 2 --sample-time 1s --scheme muir:3 => full-bdf2
            control analyze --plant 1/(s+1) --mass 1kg => --mass | --plant
            control analyze --plant 1/(s+1) --delay -1s --controller 2 --sample-time 1s
                => delay -1 s is not from 0 to 86400 s | --delay
            control analyze --plant 1/(s+1) --delay 100s --controller 2 --sample-time 1ms
                => 100000 samples | 10000 | --sample-time | --delay
            control analyze --plant 1/(s+1) --controller 1e308 --sample-time 1ms
                => 1e308 is not from 1e-60 to 1e60 in size | other units | --controller
            control analyze --plant 1/(s+1) --controller 1e-308 --sample-time 1ms
                => 1e-308 is not from 1e-60 to 1e60 in size | other units | --controller
            control analyze --plant 1e308/(1e-308s+1) => 1e-308 is not from 1e-60 to 1e60 in size | other units | --plant
            control analyze --plant 1e60/(1e-60s^1.5+1e-60) --controller 1 --sample-time 1s
                => gain of the plant over a sample | is not from 1e-75 to 1e75 in size | other units
            control analyze --plant exp(-1e307s)/(s+1) => dead time 1e307 s is not from 0 to 1e10 s | --plant
            control analyze --mass 1e-320 => mass 1e-320 kg is not at least 1e-15 kg | --mass
            control analyze --mass 1kg --current-lag 1e-320 => lag 1e-320 s is not 0, or at least 1e-15 | --current-lag
            control simulate --plant 1/(s-1) --duration 3s => does not decay | controller
            control simulate --plant 1/(s+1) => --duration
            control simulate --plant 1/(s+1) --duration 1s --step 0 => --step
            {design} --plant 1/(s+1) --phase-margin 65 => 3724.2° | 180° | --phase-margin | 60deg
            {design} --plant 1/(s+1) --phase-margin 1deg --sensitivity-peak 1.1
                => --sensitivity-peak 1.1 contradicts --phase-margin 1°
            {design} --plant 1/(s+1) --noise 1e9rad/s:-1e9dB => -1e9 dB is not from -300 to 120 dB | --noise | 10rad/s:-20dB
            {design} --plant 1/(s+1) --disturbance 0.1rad/s:7e150dB => 7e150 dB is not from -300 to 120 dB | --disturbance
            {design} --plant 1/(s+1) --sensitivity-peak -1e9dB => -1e9 dB is not from -300 to 120 dB | --sensitivity-peak | 4dB
            {design} --plant 1/(s+1) --noise 0.5rad/s:0.1 => --noise 0.1 contradicts --crossover 1 rad/s
            {design} --plant 1/(s+1) --disturbance 2rad/s:0.1 => --disturbance 0.1 contradicts --crossover 1 rad/s
            {design} --plant exp(-9s)/(s+1) => --phase-margin 60° contradicts --crossover 1 rad/s
            {design} --plant 1/(s+1) --sample-time 2s => crossover 1 rad/s | sample faster | --crossover
            {design} --plant 1/(s+1) --crossover => crossover
            control design --plant 1/(s+1) --crossover 0 => from 1e-12 to 1e9 rad/s | --crossover
            control simulate --plant 1/(s+1) --controller 2 --sample-time 1s --reference large.csv
                => large.csv: line 3: 1e300 in column reference is not from -1e12 to 1e12 | another unit
            "
        ),
    );
    assert_eq!(place.files().len(), 13, "nothing was written");
}

#[test]
fn bad_records_are_refused_in_one_line_with_the_remedy() {
    let place = files();
    place.refuses(
        "
            control identify good.csv --time input => column input | --time and by --input | give each its own
            control identify good.csv --output input => --input and by --output
            control identify still.csv --time input --input time_s => the time does not grow | column input, that of --time
            control identify far.csv => column `output` is | times column `input` | from 1e-50 to 1e50 | another unit
            control identify none.csv => none.csv | CSV
            control identify uneven.csv => uneven.csv: line 4 | equal steps
            control identify short.csv => no column output | --output
            control identify brief.csv => samples of the record | record for longer
            control identify brief.csv --delay 9s => dead time 9 s | shorter than the record | --delay
            control identify still.csv => still.csv: column `input` is 0 in every row | --input
            control identify mute.csv => mute.csv: column `output` is 0 in every row | record for longer | --output
            control identify flat.csv => column `output` is 2.5 in every row
            control identify spike.csv => spike.csv: line 9: column `output` is 1e300 | mend the row | unit
            control identify small.csv => column `output` is 2.9e-199 at most | unit
            control identify good.csv --model 2 => no power of s | --model
            control identify short.csv --out p.txt => .toml | --out
        ",
    );
    assert_eq!(place.files().len(), 13, "nothing was written");
}

/// A sample time, a duration or a number of samples that follows from another value is not what is at fault.
#[test]
fn an_extreme_value_is_named_itself_with_its_range() {
    let place = Place::new();
    place.refuses(
        "
            control design --plant 1/(s+1) --crossover 1e9rad/s
                => crossover 1e9 rad/s | 2e-8 to 2e7 rad/s | --crossover
            control design --plant 1/(s+1) --crossover 1e-12rad/s => crossover 1e-12 rad/s | change --crossover
            control design --crossover 1rad/s --plant 1e50/(s+1) => gain 7.0711e49 at --crossover 1 rad/s | 1e-12 to 1e12 | other units
            control design --crossover 1rad/s --plant 1e-50/(s+1) => gain 7.0711e-51 | 1e-12 to 1e12 | other units
            control design --crossover 1rad/s --plant 1/(s+1) --duration 10000000s => 500000000 samples | --duration | --sample-time
            control design --crossover 1rad/s --plant 1/(s+1) --sample-time 1000000s => crossover 1 rad/s | sample faster | --sample-time | --crossover
            control simulate --plant 1/(s+1) --duration 1e-9s => duration 1e-9 s | to 1e7 s | lengthen --duration
            control analyze --plant 1/(1e-12s+1) --controller 2+s --sample-time 1ms
                => sample time 0.001 s | 1e8 time constants of the fastest pole | leave that pole or lag out | sample faster
            ",
    );
}

/// What the libraries call a parameter, and what was given up already, helps nobody.
#[test]
fn a_remedy_of_a_design_is_an_option_that_is_not_given_yet() {
    let place = Place::new();
    let lines = [
        // There is no PID of order 1.
        "control design --plant 1/s^2 --crossover 2rad/s --phase-margin 95deg --not-flat",
        // Not met.
        "control design --plant exp(-0.1s)/(s+1) --crossover 3rad/s --phase-margin 80deg --not-flat --sensitivity-peak 1.01",
    ];
    for line in lines {
        let ended = place.run(line);
        let said = format!("{}{}", ended.stdout, ended.stderr);
        assert!(said.contains("crossover"), "{said}");
        for word in [
            "crossover_rad_s",
            "phase_margin_rad",
            "iso_damping",
            "--not-flat",
        ] {
            assert!(!said.contains(word), "{word}: {said}");
        }
    }
    let flat = lines[1].replace(" --not-flat", "");
    let ended = place.run(&flat).failed(1);
    assert!(ended.error().contains("--not-flat"), "{ended}");
}
