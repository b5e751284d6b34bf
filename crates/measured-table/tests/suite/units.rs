//! Units of headers: each spelling with its value in SI, or with why it is refused.

use measured_table::{Choice, Column, Columns, Reader, TableError, read_table};

/// A name, its units, and the size of one of each in SI.
const SPELLINGS: &str = "
Time | s 1; ms 1e-3; µs 1e-6; μs 1e-6; min 60; h 3600; d 86400; day 86400; days 86400; hour 3600; hr 3600; hrs 3600; mins 60; minute 60; msec 1e-3; week 604800
Stress | Pa 1; kPa 1e3; MPa 1e6; GPa 1e9; mPa 1e-3; N/m2 1; N/mm2 1e6; N/mm² 1e6; psi 6894.757293168361; mmHg 133.322387415; dyn/cm2 0.1; dyn/cm^2 0.1; dyne/cm² 0.1; kN/m² 1e3; MN/m² 1e6; mN/m² 1e-3; N/cm² 1e4; kgf/cm² 98066.5; ksi 6894757.293168361; bar 1e5; atm 101325
Stress | kg/cm² 98066.5; g/cm2 98.0665; lb/in² 6894.757293168361
Creep compliance | 1/Pa 1; 1/kPa 1e-3; 1/MPa 1e-6; 1/mPa 1e3; MPa-1 1e-6; kPa^-1 1e-3; GPa⁻¹ 1e-9; Pa**-1 1; m²/N 1; 1/psi 1.450377377302092e-4; cm²/dyne 10; mm²/N 1e-6
Strain | % 0.01; 1 1; m/m 1; mm/mm 1; 1e-6 1e-6; 10⁻⁶ 1e-6; µε 1e-6; με 1e-6; microstrain 1e-6; mstrain 1e-3; in/in 1
Force | N 1; mN 1e-3; MN 1e6; nN 1e-9; kgf 9.80665; gf 0.00980665; lbf 4.4482216152605; dyn 1e-5; cN 0.01; lb 4.4482216152605; g 0.00980665; kg 9.80665
# Of files that people publish.
Stress | kgf/mm² 9806650; N m⁻² 1; N·mm-2 1e6; nN/µm² 1e3; pN/nm2 1e6; lbf/ft² 47.88025898033584; cmH2O 98.0665; torr 133.32236842105263; mbar 100; hPa 100; kN / m2 1e3
Stress | inHg 3386.388640341; mmH2O 9.80665; at 98066.5; tf/m² 9806.65; Mdyn/cm² 1e5; Ba 0.1
Time | ks 1e3; Sek. 1; sec. 1; Stunden 3600
ω | krad/s 1e3; deg/s 0.017453292519943295; rev/s 6.283185307179586; cycles/min 0.10471975511965977
Force | ozf 0.27801385095378125; kp 9.80665; daN 10; µN 1e-6
Creep compliance | µm²/nN 1e-3; in²/lbf 1.450377377302092e-4; cm2 dyn-1 10; 1/bar 1e-5; m² per N 1
Strain | mm/m 1e-3; µm/m 1e-6; ‰ 1e-3; ppm 1e-6; cm/cm 1
Position | Å 1e-10; mil 2.54e-5; inch 0.0254; microns 1e-6
";

/// Names in lower case with their units behind an underscore.
const SUFFIXES: &str = "
time_day 86400; time_hr 3600; stress_kgf_per_cm2 98066.5; stress_mpa 1e6; stress_n_per_mm2 1e6; compliance_cm2_per_dyne 10; compliance_per_psi 1.450377377302092e-4; force_mn 1e-3; force_kg 9.80665
";

/// A name, its units, and why none is taken.
const REFUSED: &str = "
Time | month, months | has 28 to 31 days: write days
ω | 1/min | may be cycles or radians per minute: write rpm
Time | year, yr | has 365 or 366 days: write days
Time | fortnight, Pa | is not a unit of time: give one of s, ms, us, ns, min, h, d, week, ks in the header
Stress | N, kg, N/m, m2/N, Pa-1, kg/s | is not a unit of stress: give one of Pa, kPa
Force | Pa, m | is not a unit of force: give one of N, mN
Force | a.u., counts | has no size of its own: calibrate
Creep compliance | Pa, N/m2, 1/N, 1/s | is not a unit of compliance: give one of 1/Pa
Strain | mm, Pa/Pa | is not a unit of strain
";

fn read(header: &str) -> Result<Columns, TableError> {
    read_rows(header, "3;1\n4;2\n5;2.5\n")
}

fn read_rows(header: &str, rows: &str) -> Result<Columns, TableError> {
    Reader::default().read(read_table(format!("{header}\n{rows}").as_bytes())?)
}

/// Lines of a name and what belongs to it.
fn rows(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.lines().filter_map(|row| row.split_once(" | "))
}

#[track_caller]
fn assert_size(header: &str, size: &str) -> Columns {
    let columns = read(&format!("{header};Phase (rad)")).expect(header);
    let size: f64 = size.parse().expect("a number");
    let have = columns.values[0].2[0] / 3.0;
    assert!((have / size - 1.0).abs() < 1e-12, "{header}: {have}");
    assert_eq!(columns.unclear, [], "{header}");
    columns
}

#[test]
fn every_spelling_has_its_size() {
    for (name, units) in rows(SPELLINGS) {
        for unit in units.split("; ") {
            let (unit, size) = unit.rsplit_once(' ').expect("a size");
            let columns = assert_size(&format!("{name} [{unit}]"), size);
            if unit.parse::<f64>().is_err() {
                // A line of its own says as much.
                let below = read(&format!("{name};Phase\n{unit};rad")).expect(unit);
                assert_eq!(below.values[0].2, columns.values[0].2, "{unit}");
            }
            let is_mass = ["g", "kg", "lb", "kg/cm²", "g/cm2", "lb/in²"].contains(&unit);
            let notes = columns.notes.concat();
            assert_eq!(
                notes.contains("taken as its weight"),
                is_mass,
                "{unit}: {notes}"
            );
        }
    }
    for suffixed in SUFFIXES.trim().split("; ") {
        let (header, size) = suffixed.split_once(' ').expect("a size");
        assert_size(header, size);
    }
}

#[test]
fn what_is_no_unit_is_refused_with_what_to_write() {
    for (name, rest) in rows(REFUSED) {
        let (units, why) = rest.split_once(" | ").expect("a reason");
        for unit in units.split(", ") {
            let columns = read(&format!("{name} [{unit}];Phase (rad)")).expect(unit);
            let [(_, asked)] = &columns.unclear[..] else {
                panic!("{unit}: {:?}", columns.unclear);
            };
            assert!(asked.contains(&format!("{unit:?} {why}")), "{asked}");
        }
    }
}

/// Headers of logarithms, what a cell of 3 is in SI, and the columns that they are.
const LOGARITHMS: &str = "
Time;log10 G' (Pa) | 1000 storage
Time;log(G'') [kPa] | 1e6 loss
Time;log G* (Pa) | 1000 complex-modulus
Time;lg(J(t) / (1/Pa)) | 1000 compliance
Time;Log[E'/MPa] | 1e9 storage
Time;ln(G(t)) (Pa) | 20.085536923187668 modulus
Time;ln_modulus_kpa | 20085.536923187668 modulus
Time;log_10 strain (%) | 10 strain
Time;log|G*| (Pa) | 1000 complex-modulus
Time;logG' | 1000 storage
";

#[test]
fn logarithms_are_taken_to_the_power_and_said() {
    for (header, rest) in rows(LOGARITHMS) {
        let (value, column) = rest.split_once(' ').expect("a column");
        let columns = read_rows(header, "0;3\n1;2\n").expect(header);
        let (have, name, values) = &columns.values[1];
        assert_eq!(have.name(), column, "{header}");
        let value: f64 = value.parse().expect("a number");
        assert!(
            (values[0] / value - 1.0).abs() < 1e-12,
            "{header}: {values:?}"
        );
        let note = format!("column {name} holds logarithms");
        assert!(columns.notes.concat().contains(&note), "{header}");
    }
    // A clock, by its number.
    let reader = Reader {
        columns: vec![
            (Column::Time, Choice::Number(1)),
            (Column::Modulus, Choice::Number(2)),
        ],
        ..Reader::default()
    };
    let table = read_table(b"log t (min),log x\n-1,3\n0,2\n1,1\n").expect("a table");
    let columns = reader.read(table.clone()).expect("logarithms");
    assert_eq!(columns.values[0].2, [6.0, 60.0, 600.0]);
    assert_eq!(columns.values[1].2, [1000.0, 100.0, 10.0]);
    assert_eq!(
        reader.segments(&table).expect("one")[0].clock,
        Some([6.0, 600.0])
    );
    // The clock of a log is no logarithm.
    let error = read_rows("Log time (s);Stress (Pa)", "0;3\n600;2\n").expect_err("a clock");
    assert!(
        error
            .to_string()
            .contains("10 to the power of 600 is no number"),
        "{error}"
    );
}
