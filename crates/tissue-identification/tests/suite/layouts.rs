//! Files in the layouts of instruments and programs: every row is read, in SI units, without a word or with at most two.

use measured_table::{Choice, Column, Columns, Reader, read_table};
use testkit::{assert_refused, assert_relative};
use tissue_identification::{IdentifyError, TableDetails};

/// A file, the options that it needs, and the law that its numbers obey.
const LAYOUTS: &str = r"
    trios-relaxation.txt | - | relaxation
    trios-sweep.txt | - | sweep
    trios-creep.csv | - | creep
    dma850-sweep.csv | - | sweep
    q800-relaxation.txt | - | relaxation
    ares-orchestrator.txt | - | sweep
    rheocompass-sweep.csv | - | sweep
    rheocompass-german.csv | - | relaxation
    rheoplus-sweep.txt | - | sweep
    rheoplus-creep.txt | - | creep
    rheowin-sweep.csv | - | sweep
    rheowin-creep.txt | - | creep
    kinexus-sweep.csv | - | sweep
    kinexus-complex.csv | - | complex
    bohlin-sweep.txt | - | sweep
    piuma.txt | - | press
    chiaro.txt | - | press
    afm-workshop.csv | - | curve
    nt-mdt.txt | columns position=1,force=2 units position=nm,force=nN | curve
    jpk.txt | columns time=seriesTime,position=measuredHeight,force=vDeflection | press
    hysitron.txt | - | press
    softmech.csv | - | curve
    mach1.txt | - | slab
    mach1-two.txt | segment 2 | slab
    bluehill.csv | - | slab
    bluehill-raw.csv | - | slab
    bluehill-german.csv | - | slab
    bluehill-thousands.csv | - | slab
    testxpert-german.txt | - | slab
    testxpert.txt | - | slab
    mts793.dat | - | slab
    mts-testworks.csv | - | slab
    testresources.csv | - | slab
    electroforce.txt | - | slab
    cellscale.csv | - | slab
    texture-analyser.csv | - | slab
    netzsch-dma.txt | - | sweep
    labview.lvm | columns time=X_Value,position=3,force=2 | slab
    rheos-sweep.csv | columns omega=1,storage=2,loss=3 | sweep
    pyvisco-sweep.csv | - | sweep
    pyvisco-sets.csv | segment 1 | relaxation
    rheojax.csv | - | relaxation
    origin.txt | - | sweep
    spreadsheet.csv | - | sweep
    numbers-minus.csv | - | slab
    testxpert-french.txt | - | slab
    spreadsheet-turkish.csv | - | slab
    spreadsheet-capitals.csv | - | slab
    spreadsheet-french.csv | - | slab
    bluehill-unquoted.csv | - | slab
    kinexus-actions.csv | segment 2 | relaxation
    rheocompass-french.csv | - | sweep
    rheowin-elements.txt | segment 2 | sweep
";

fn bytes(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/layouts");
    let path = std::path::Path::new(folder).join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reader with options such as `columns time=1,modulus=3 units time=min`; without options for `-`.
pub(super) fn reader(options: &str) -> Reader {
    let mut reader = Reader::default();
    let words: Vec<&str> = options.split_whitespace().collect();
    for pair in words.chunks_exact(2) {
        for value in pair[1].split(',') {
            let named = || {
                let (name, value) = value.split_once('=').expect("a pair");
                (Column::named(name).expect("a column"), value.to_owned())
            };
            match pair[0] {
                "columns" => {
                    let (column, value) = named();
                    let number = value.parse().map(Choice::Number);
                    let choice = number.unwrap_or(Choice::Name(value));
                    reader.columns.push((column, choice));
                }
                "units" => reader.units.push(named()),
                _ => reader.segments.push(value.to_owned()),
            }
        }
    }
    reader
}

fn values(columns: &Columns, column: Column) -> &[f64] {
    let found = columns.values.iter().find(|value| value.0 == column);
    &found
        .unwrap_or_else(|| panic!("no {column:?} in {:?}", columns.values))
        .2
}

/// Two columns and the law of the second.
fn obeys(name: &str, columns: &Columns, x: Column, y: Column, law: impl Fn(f64) -> f64) {
    let (x, y) = (values(columns, x), values(columns, y));
    assert_eq!((x.len(), y.len()), (12, 12), "{name}");
    for (x, y) in x.iter().zip(y) {
        // Six digits are printed, four decimals where it is fewer.
        let near = (y - law(*x)).abs() <= 2e-4 * law(*x).abs();
        assert!(near, "{name}: {y} of {x} is not {}", law(*x));
    }
}

fn press(depth: f64) -> f64 {
    16.0 / 9.0 * 25e-6_f64.sqrt() * 1000.0 * depth.powf(1.5)
}

#[test]
fn files_of_instruments_are_read() {
    let (mut alone, mut with_options) = (0, 0);
    let angle = 22.5_f64.to_radians();
    for [name, options, law] in testkit::table(LAYOUTS) {
        let table = read_table(&bytes(&name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let columns = reader(&options).read(table);
        let columns = columns.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(columns.unclear.is_empty(), "{name}: {:?}", columns.unclear);
        let obeys = |x, y, law: &dyn Fn(f64) -> f64| obeys(&name, &columns, x, y, law);
        let modulus = |w: f64| 5000.0 * w.powf(0.25);
        match law.as_str() {
            "relaxation" => obeys(Column::Time, Column::Modulus, &|t| 1e3 * t.powf(-0.2)),
            "creep" => obeys(Column::Time, Column::Compliance, &|t| 1e-3 * t.powf(0.2)),
            "sweep" => {
                obeys(Column::Omega, Column::Storage, &|w| {
                    modulus(w) * angle.cos()
                });
                obeys(Column::Omega, Column::Loss, &|w| modulus(w) * angle.sin());
            }
            "complex" => {
                obeys(Column::Omega, Column::Complex, &modulus);
                obeys(Column::Omega, Column::Phase, &|_| angle);
            }
            "press" => {
                obeys(Column::Time, Column::Position, &|t| 1e-6 * t);
                obeys(Column::Position, Column::Force, &press);
            }
            "curve" => obeys(Column::Position, Column::Force, &press),
            _ => {
                obeys(Column::Time, Column::Position, &|t| 1e-3 * t);
                obeys(Column::Position, Column::Force, &|x| 500.0 * x);
            }
        }
        match options.split_whitespace().count() / 2 {
            0 => alone += 1,
            count => {
                assert!(count <= 2, "{name}");
                with_options += 1;
            }
        }
    }
    assert!(
        alone >= 43 && alone + with_options >= 53,
        "{alone} {with_options}"
    );
}

/// A file without the options that it needs is refused, or no record is in it: nothing is guessed.
#[test]
fn what_needs_a_word_says_so() {
    for [name, options, law] in testkit::table(LAYOUTS) {
        if options == "-" && law != "curve" {
            continue;
        }
        let table = read_table(&bytes(&name)).expect("a table");
        let record = Reader::default().read(table).map_err(IdentifyError::from);
        let record = record.and_then(|columns| TableDetails::default().record(columns));
        let message = record.expect_err(&name).to_string();
        let asked = ["`columns`", "`segment`", "`strain`", "`loading`"];
        assert!(
            asked.iter().any(|word| message.contains(word)),
            "{name}: {message}"
        );
        assert!(
            !message.contains('\n') && message.len() < 600,
            "{name}: {message}"
        );
    }
}

/// Two segments, and what tells them apart.
#[test]
fn segments_are_listed_and_chosen() {
    let table = read_table(&bytes("pyvisco-sets.csv")).expect("a table");
    let segments = Reader::default().segments(&table).expect("two");
    let lines: Vec<_> = segments
        .iter()
        .map(|one| (one.number, one.name.as_str(), one.rows, one.lines))
        .collect();
    assert_eq!(
        lines,
        [
            (1, "Set 0, 25.3 °C", 12, [3, 14]),
            (2, "Set 1, 18.1 °C", 12, [15, 26])
        ]
    );
    let range = segments[0].clock.expect("a clock");
    assert_relative("first time", range[0], 0.01, 1e-6);
    for (chosen, temperatures) in [
        ("1", &[25.3][..]),
        ("2", &[18.1]),
        ("set 1", &[18.1]),
        ("25.3", &[25.3]),
        ("1,2", &[25.3, 18.1]),
        ("all", &[25.3, 18.1]),
        ("2,2", &[18.1]),
    ] {
        let reader = Reader {
            segments: chosen.split(',').map(str::to_owned).collect(),
            ..Reader::default()
        };
        let all = reader.read_all(&table).expect(chosen);
        let have: Vec<f64> = all
            .iter()
            .filter_map(|columns| columns.temperature_c)
            .collect();
        assert_eq!(have.len(), temperatures.len(), "{chosen}");
        for (have, want) in have.iter().zip(temperatures) {
            assert_relative(chosen, *have, *want, 1e-12);
        }
    }
    for wrong in ["0", "3", "set", "Set 2", ""] {
        let reader = Reader {
            segments: vec![wrong.to_owned()],
            ..Reader::default()
        };
        assert_refused(
            reader.read_all(&table),
            "give `segment` a number from 1 to 2",
        );
    }
}
