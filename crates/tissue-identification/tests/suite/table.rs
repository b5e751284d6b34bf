//! Tables as rheometers and testing machines write them, and tables that are wrong.

use super::told;
use haptic_loop::{Loading, LoadingKind, Modulus};
use measured_table::{Choice, Column, Columns, Reader, read_record, read_table};
use testkit::{assert_close, assert_refused, assert_relative, assert_says};
use tissue_identification::{RecordKind, TableDetails, Understood};

fn understand(text: &str, reader: &Reader, reading: &TableDetails) -> Result<Understood, String> {
    let table = read_table(text.as_bytes()).map_err(|error| error.to_string())?;
    let columns = reader.read(table).map_err(|error| error.to_string())?;
    reading.record(columns).map_err(|error| error.to_string())
}

/// A table of which nobody says anything.
fn as_it_is(text: &str) -> Result<Understood, String> {
    understand(text, &Reader::default(), &TableDetails::default())
}

fn plain(text: &str) -> Understood {
    as_it_is(text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

#[test]
fn our_own_headers_need_no_word() {
    for [text, kind] in testkit::table(
        r"
        time_s,relaxation_modulus_pa\n1,5\n2,4\n | relaxation
        time_s,creep_compliance_per_pa\n1,4\n2,5\n | creep
        omega_rad_s,storage_modulus_pa,loss_modulus_pa\n2,5,1\n1,4,2\n | oscillation
        time_s,strain,stress_pa\n0,0,0\n1,0.1,4\n | record
        ",
    ) {
        let understood = plain(&text);
        assert_eq!(understood.record.kind().name(), kind, "{text}");
        let [loading, note] = &understood.notes[..] else {
            panic!("{:?}", understood.notes);
        };
        assert_eq!(
            loading,
            "loading unknown: the modulus is taken as Young's; give `loading`"
        );
        assert!(
            note.starts_with(&format!("kind {kind}, by the columns")),
            "{note}"
        );
    }
}

#[test]
fn usual_spellings_and_units_of_other_programs_are_understood() {
    // `~` stands for a tab.
    for [header, rows, x, first] in testkit::table(
        r"
        Time [s]~Relaxation Modulus [kPa] | 1~5\n2~4 | 1 | 5e3
        t;G(t) / MPa | 1,5;5,25\n2;4 | 1.5 | 5.25e6
        Time (ms),E(t) (Pa) | 1,5\n2,4 | 1e-3 | 5
        Test Time in min,Modulus | 1,5\n2,4 | 60 | 5
        elapsed_time_ms,relaxation_modulus_kpa | 1,5\n2,4 | 1e-3 | 5e3
        Time,Creep Compliance (1/MPa) | 1,4\n2,5 | 1 | 4e-6
        Time,Compliance [Pa⁻¹] | 1,4\n2,5 | 1 | 4
        Angular Frequency (rad/s),Storage Modulus (kPa),Loss Modulus (kPa) | 1,4,1\n2,5,2 | 1 | 4e3
        Frequency (Hz)~G' (Pa)~G'' (Pa) | 1~4~1\n2~5~2 | 6.283185307179586 | 4
        ω [rad/s];E′ [MPa];E″ [MPa] | 1;4;1\n2;5;2 | 1 | 4e6
        Angular Frequency,Storage Modulus,Loss Modulus\nrad/s,kPa,kPa | 1,4,1\n2,5,2 | 1 | 4e3
        ",
    ) {
        let table = format!("{header}\n{rows}\n").replace('~', "\t");
        let record = plain(&table).record;
        let number = |cell: &str| cell.parse().expect("a number");
        assert_relative(&header, record.x()[0], number(&x), 1e-12);
        assert_relative(&header, record.first()[0], number(&first), 1e-12);
    }
}

#[test]
fn forces_and_positions_become_stresses_and_strains() {
    let loading = Loading {
        area_m2: Some(4e-4),
        thickness_m: Some(0.02),
        ..Loading::new(LoadingKind::Compression)
    };
    let reading = TableDetails {
        loading,
        ..TableDetails::default()
    };
    let text = "Time (s),Extension (mm),Load (N)\n0,0,0\n1,1,2\n2,1,1.5\n";
    let record = understand(text, &Reader::default(), &reading)
        .expect("valid")
        .record;
    assert_eq!(record.kind(), RecordKind::History);
    assert!((record.first()[1] - 0.05).abs() < 1e-15 && (record.second()[1] - 5000.0).abs() < 1e-9);
    // A held strain makes a relaxation of it.
    let held = TableDetails {
        strain: Some(0.05),
        loading: Loading {
            area_m2: Some(4e-4),
            ..Loading::new(LoadingKind::Compression)
        },
        ..TableDetails::default()
    };
    let record = understand("t,F (N)\n1,2\n2,1.5\n", &Reader::default(), &held)
        .expect("valid")
        .record;
    assert_eq!(record.kind(), RecordKind::Relaxation);
    assert_close("record.first()[0]", record.first()[0], 1e5, 1e-6);
}

/// The loading, the modulus, and the headers that say it; `?` where they do not.
const HEADERS: &str = r"
    ? ? | time_s,relaxation_modulus_pa
    ? shear | t (s),G(t) (kPa)
    ? shear | Time,G
    ? young | t (s),E(t) (Pa)
    ? young | t,E [kPa]
    ? young | t,Young's modulus
    shear shear | t (s),Shear modulus (Pa)
    shear shear | t (s),Shear stress (Pa),Strain (%)
    compression young | t (s),Compressive stress (Pa),Strain (%)
    tension young | t (s),Tensile stress (Pa),Strain (%)
    ? ? | t (s),Tensile stress (Pa),Shear strain (%)
    ? ? | t (s),Stress (Pa),e (%)
";

#[test]
fn headers_tell_the_loading_and_the_modulus() {
    for [decision, header] in testkit::table(HEADERS) {
        let row = |n: f64| match header.matches(',').count() {
            1 => format!("{n},{}\n", 5.0 - n),
            _ => format!("{n},{},{}\n", 5.0 * n, 2.0 * n),
        };
        let rows = match header.matches(',').count() {
            1 => row(1.0) + &row(2.0),
            _ => row(0.0) + &row(1.0) + &row(2.0),
        };
        let understood = plain(&format!("{header}\n{rows}"));
        let (kind, modulus) = (understood.loading.kind, understood.loading.modulus);
        let have = [kind.map(LoadingKind::name), modulus.map(Modulus::name)];
        let have = have.map(|word| word.unwrap_or("?")).join(" ");
        assert_eq!(have, decision, "{header}");
        let unknown = understood
            .notes
            .iter()
            .any(|note| note.starts_with("loading unknown"));
        assert_eq!(
            unknown,
            modulus.is_none(),
            "{header}: {:?}",
            understood.notes
        );
    }
    // What is told counts more than symbols, but not more than words.
    let tension = TableDetails {
        poisson_ratio: Some(0.4),
        ..told(Loading::new(LoadingKind::Tension))
    };
    let read = |header: &str| {
        understand(
            &format!("t,{header} (Pa)\n1,5\n2,4\n"),
            &Reader::default(),
            &tension,
        )
    };
    let loading = read("Relaxation modulus").expect("valid").loading;
    assert_eq!(
        (loading.kind, loading.modulus, loading.poisson_ratio),
        (Some(LoadingKind::Tension), Some(Modulus::Young), Some(0.4))
    );
    let symbol = read("G").expect("valid");
    assert_eq!(symbol.loading.modulus, Some(Modulus::Young));
    let note = "column G (Pa) is taken as the modulus that `loading` tells";
    assert_says(&symbol.notes.join("\n"), note);
    assert_refused(
        read("Shear modulus"),
        "is of shear, and `loading` is tension",
    );
}

/// Force and depth, how they were measured, and what the refusal says; sizes as `radius=5e-3`.
const WRONG_LOADINGS: &str = r"
    force_n,depth_mm | sphere | loading sphere needs indenter radius: give `indenter_radius_m`
    force_n,depth_mm | cone | needs half angle: give `half_angle_rad`
    force_n,depth_mm | cone radius=1e-3 angle=1 | indenter radius has no effect on loading cone: omit `indenter_radius_m`
    force_n,depth_mm | sphere radius=-1e-3 | radius & change `indenter_radius_m`
    force_n,depth_mm | cone angle=2 | half angle & change `half_angle_rad`
    force_n,depth_mm | sphere radius=1e-3 bonded | needs thickness: give `thickness_m`
    force_n,depth_mm | punch radius=1e-3 thickness=1 | a layer under a punch resists more & W. C. Hayes & omit `thickness_m`
    force_n,depth_mm | punch radius=1e-3 thickness=1 bonded | a layer under a punch & and omit `thickness_m`
    force_n,depth_mm | cone angle=1 thickness=1 | a layer under a cone resists more & omit `thickness_m`
    force_n,depth_mm | cone angle=1 bonded | a layer under a cone resists more & omit `bonded`
    force_n,depth_mm | sphere radius=1e-3 thickness=1 nu=0.4 | Poisson's ratio of a layer & change `poisson_ratio`
    force_n,depth_mm | sphere radius=1e-3 thickness=1e-3 bonded nu=0.4 | change `poisson_ratio`
    force_n,depth_mm | sphere radius=1e-3 nu=0.6 | `poisson_ratio` 0.6 is not from 0 to 0.5
    force_n,depth_mm | sphere radius=1e-3 strain=0.1 | `strain` 0.1 has no effect
    force_n,depth_mm | sphere radius=1e-3 thickness=1e-4 bonded | line 3 & is beyond the thickness & change `thickness_m`
    force_n,depth_mm | compression radius=1e-3 | `indenter_radius_m` has no effect & omit it, or change `loading`
    force_n,depth_mm | shear area=1e-4 thickness=1e-2 bonded | bonded has no effect & omit `bonded`
    stress_pa,strain | sphere radius=1e-3 | needs columns force_n and position_m & `columns`
    stress_pa,strain | compression bonded | `bonded` has no effect
";

#[test]
fn a_loading_that_does_not_fit_is_refused_with_the_remedy() {
    for [header, given, wanted] in testkit::table(WRONG_LOADINGS) {
        let (kind, sizes) = given.split_once(' ').unwrap_or((&given, ""));
        let mut kinds = LoadingKind::ALL.into_iter();
        let kind = kinds.find(|one| one.name() == kind).expect("a kind");
        let mut reading = told(Loading::new(kind));
        for size in sizes.split_whitespace() {
            let (name, value) = size.split_once('=').unwrap_or((size, "1"));
            let value = Some(value.parse().expect("a number"));
            match name {
                "radius" => reading.loading.radius_m = value,
                "angle" => reading.loading.half_angle_rad = value,
                "area" => reading.loading.area_m2 = value,
                "thickness" => reading.loading.thickness_m = value,
                "nu" => reading.poisson_ratio = value,
                "strain" => reading.strain = value,
                _ => reading.loading.bonded = true,
            }
        }
        let text = format!("time_s,{header}\n0,0,0\n1,2,0.3\n2,1.5,0.3\n");
        assert_refused(understand(&text, &Reader::default(), &reading), &wanted);
    }
}

/// A sphere, a layer and a bonded slab by their closed forms: the stress is that of a spring of 1 kPa.
#[test]
fn force_and_depth_become_the_stress_of_a_strain() {
    let spring = |e: f64| 1000.0 * e;
    let (radius, depth) = (5e-3_f64, 5e-4_f64);
    let sphere = super::sphere(radius);
    let cases = [
        // (16/9)·√R·E·δ^1.5 of an incompressible body, and with ν = 0.2 (4/3)/(1 − ν²).
        (
            sphere,
            None,
            16.0 / 9.0 * radius.sqrt() * depth.powf(1.5),
            (depth / radius).powf(1.5),
        ),
        (
            sphere,
            Some(0.2),
            4.0 / 3.0 / 0.96 * radius.sqrt() * depth.powf(1.5),
            (depth / radius).powf(1.5),
        ),
    ];
    for (loading, poisson_ratio, per_pa, e) in cases {
        let reading = TableDetails {
            poisson_ratio,
            ..told(loading)
        };
        let force = [0.5, 1.0].map(|share| spring(per_pa * share));
        let text = format!(
            "t (s),Depth (mm),F (N)\n0,0,0\n1,0.5,{}\n2,0.5,{}\n",
            force[1], force[0]
        );
        let understood = understand(&text, &Reader::default(), &reading).expect("valid");
        let record = &understood.record;
        assert_eq!(record.kind(), RecordKind::History);
        assert_relative("strain", record.first()[1], depth / radius, 1e-14);
        assert_relative("stress", record.second()[1], spring(e), 1e-12);
        assert_eq!(
            understood.loading.poisson_ratio,
            Some(poisson_ratio.unwrap_or(0.5))
        );
        let assumed = understood
            .notes
            .iter()
            .any(|note| note.starts_with("Poisson's ratio is taken as 0.5"));
        assert_eq!(assumed, poisson_ratio.is_none());
        assert_eq!(record.strain_to(), Some(depth / radius));
    }
    // A bonded slab is stiffer by 1 + 2S², S = radius/(2h).
    let slab = Loading {
        area_m2: Some(4e-4),
        thickness_m: Some(0.01),
        bonded: true,
        ..Loading::new(LoadingKind::Compression)
    };
    let reading = told(slab);
    let text = "t (s),Depth (mm),F (N)\n0,0,0\n1,1,2\n2,1,1\n";
    let record = understand(text, &Reader::default(), &reading)
        .expect("valid")
        .record;
    let factor = 1.0 + 4e-4 / (2.0 * std::f64::consts::PI * 1e-4);
    assert_relative("stress", record.second()[1], 2.0 / 4e-4 / factor, 1e-14);
    // And held.
    let held = TableDetails {
        strain: Some(0.1),
        ..reading
    };
    let record = understand("t,F (N)\n1,2\n2,1\n", &Reader::default(), &held).expect("valid");
    assert_relative("E", record.record.first()[0], 2.0 / 4e-5 / factor, 1e-14);
    // A machine's own stress knows nothing of it; the force does.
    let both = "t (s),Depth (mm),F (N),Stress (kPa)\n0,0,0,0\n1,1,2,5\n2,1,1,2.5\n";
    assert_refused(
        understand(both, &Reader::default(), &reading),
        "`bonded` acts on the force",
    );
    let force = Reader {
        columns: vec![(Column::Force, Choice::Number(3))],
        units: vec![(Column::Force, "N".to_owned())],
        ..Reader::default()
    };
    let record = understand(both, &force, &reading)
        .expect("the force")
        .record;
    assert_relative("stress", record.second()[1], 2.0 / 4e-4 / factor, 1e-14);
}

/// A bar of 20 mm that is drawn to three times its length: compression is not told, so no plate is in the way.
#[test]
fn an_unknown_loading_may_move_beyond_the_thickness() {
    let sizes = Loading {
        area_m2: Some(4e-4),
        thickness_m: Some(0.02),
        ..Loading::new(LoadingKind::Compression)
    };
    for (loading_is_told, wording) in [(false, "a motion"), (true, "is beyond the thickness")] {
        let reading = TableDetails {
            loading: sizes,
            loading_is_told,
            ..TableDetails::default()
        };
        let text = "Time (s),Extension (mm),Load (N)\n0,0,0\n1,20,2\n2,40,3\n";
        let have = match understand(text, &Reader::default(), &reading) {
            Ok(understood) => {
                assert_relative("strain", understood.record.first()[2], 2.0, 1e-14);
                "a motion".to_owned()
            }
            Err(refused) => refused,
        };
        assert_says(&have, wording);
    }
}

#[test]
fn columns_units_and_range_can_be_given() {
    let reader = Reader {
        columns: vec![
            (Column::Time, Choice::Number(1)),
            (Column::Modulus, Choice::Name("Value".to_owned())),
        ],
        units: vec![
            (Column::Time, "ms".to_owned()),
            (Column::Modulus, "kPa".to_owned()),
        ],
        from: Some(2e-3),
        to: None,
        segments: Vec::new(),
        ..Reader::default()
    };
    let text = "# made by hand\na,Value,Temperature\n0,9,20\n1,8,20\n\n2,7,20\n3,,20\n4,6,20\n";
    let understood = understand(text, &reader, &TableDetails::default()).expect("valid");
    assert_eq!(understood.record.x(), [2e-3, 4e-3]);
    assert_eq!(understood.record.first(), [7e3, 6e3]);
    let wording = understood.notes.join("\n");
    for note in [
        "1 row (line 7) left out, a cell without a number",
        "2 rows (lines 3, 4) left out, outside the range asked for",
    ] {
        assert_says(&wording, note);
    }
    // No header at all.
    let places = [
        (Column::Time, Choice::Number(1)),
        (Column::Modulus, Choice::Number(2)),
    ];
    let reader = Reader {
        columns: places.into(),
        ..Reader::default()
    };
    let read = understand("1,8\n2,7\n", &reader, &TableDetails::default()).expect("valid");
    assert_eq!(read.record.samples(), 2);
}

#[test]
fn columns_that_are_named_are_those_that_count() {
    // A machine writes its own modulus beside the stress, whose strain it does not know.
    let text = "time_s,relaxation_modulus_pa,stress_pa,strain,creep_compliance_per_pa\n1,7,10,0.1,9\n2,6,8,0.1,10\n";
    let read = |named: &[Column], kind| {
        let places = [
            Column::Time,
            Column::Modulus,
            Column::Stress,
            Column::Strain,
        ];
        let place = |column: &Column| places.iter().position(|place| place == column);
        let number = |column| Choice::Number(place(column).expect("a column of the table") + 1);
        let columns = named.iter().map(|column| (*column, number(column)));
        let reader = Reader {
            columns: columns.collect(),
            ..Reader::default()
        };
        let reading = TableDetails {
            kind: Some(kind),
            ..TableDetails::default()
        };
        understand(text, &reader, &reading)
    };
    let (relaxation, creep) = (RecordKind::Relaxation, RecordKind::Creep);
    for (named, want) in [
        (&[][..], [7.0, 6.0]),
        (&[Column::Stress], [100.0, 80.0]),
        (&[Column::Modulus], [7.0, 6.0]),
    ] {
        let read = read(named, relaxation).expect("valid");
        assert_eq!(read.record.first(), want, "{named:?}");
    }
    for (named, kind) in [
        (&[Column::Modulus, Column::Stress][..], relaxation),
        (&[Column::Modulus], creep),
    ] {
        let refused = read(named, kind).expect_err("no effect");
        for words in ["has no effect", kind.name()] {
            assert_says(&refused, words);
        }
    }
}

/// A table, the kind of record that is asked for, and what the refusal says.
const REFUSED: &str = r#"
    time_s\n1\n | - | line 1 & only one column
    1,2\n3,4\n | - | line 1 & no header & `columns`
    time_s,relaxation_modulus_pa\n | - | no row with numbers
    time_s,relaxation_modulus_pa\n1,5\n2,four\n | - | line 3, column relaxation_modulus_pa & "four" is not a finite number
    time_s,relaxation_modulus_pa\n1,5\n2,inf\n | - | line 3, column relaxation_modulus_pa & "inf"
    time_s,relaxation_modulus_pa\n0,5\n1,4\n | - | line 2 & time 0 s is not above 0 s & omit the rows
    time_s,relaxation_modulus_pa\n2,5\n\n1,4\n | - | line 4 & time 1 s comes after 2 s & sort
    time_s,relaxation_modulus_pa\n1,5\n2,-4\n | - | line 3 & modulus -4 Pa is not above 0 Pa
    time_s,relaxation_modulus_pa\n1,5\n2,5\n | - | 5 Pa in every sample
    time_s,relaxation_modulus_pa\n1,4,5\n | - | line 2 & 3 cells under a header of 2 & decimals have commas
    Time [Pa],Modulus\n1,5\n | - | line 1, column Time [Pa] & unit "Pa" is not a unit of time & `units` time=s
    time_s,t [s],modulus\n1,1,5\n | - | line 1 & both look like time & `columns`
    time_s,stress_pa\n1,5\n2,4\n | - | stress_pa (stress) & give `strain`
    time_s,strain\n1,5\n2,4\n | - | give `stress_pa`
    Z (nm),Force (nN)\n1,5\n2,4\n | - | a specimen & `loading` = sphere and `indenter_radius_m` & `area_m2` and `thickness_m`
    time_s,temperature\n1,5\n2,4\n | - | the columns make no record & relaxation_modulus_pa
    time_s,relaxation_modulus_pa\n1,5\n2,4\n | creep | kind creep needs a column creep_compliance_per_pa & `kind`
    time_s,creep_compliance_per_pa\n1,5\n2,4\n | - | compliance falls with time & `kind` = relaxation
    time_s,position_m,stress_pa\n0,0,5\n2,4,5\n | record | needs a column strain & `thickness_m`
"#;

#[test]
fn a_bad_table_is_refused_with_line_column_and_remedy() {
    let empty = ["", "-", "empty"].map(str::to_owned);
    for [text, kind, wanted] in testkit::table(REFUSED).chain([empty]) {
        let kind = RecordKind::ALL
            .into_iter()
            .find(|known| known.name() == kind);
        let reading = TableDetails {
            kind,
            ..TableDetails::default()
        };
        assert_refused(understand(&text, &Reader::default(), &reading), &wanted);
    }
}

#[test]
fn what_is_no_text_and_a_unit_of_something_else_are_refused() {
    let says = |wording: &str, words: &str| assert_says(&wording, words);
    let picture = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x02\x80";
    let refused = read_table(picture).expect_err("no text").to_string();
    says(&refused, "this is no text: export the table as CSV");
    for (column, text, words) in [
        (
            Column::Time,
            "t,modulus\n1,5\n2,4\n",
            "unit \"kPa\" is not a unit of time",
        ),
        (
            Column::Modulus,
            "time_s,relaxation_modulus_pa\n1,5\n2,4\n",
            "names its own unit",
        ),
    ] {
        let units = vec![(column, "kPa".to_owned())];
        let reader = Reader {
            units,
            ..Reader::default()
        };
        let refused = understand(text, &reader, &TableDetails::default());
        says(&refused.expect_err(words), words);
    }
}

#[test]
fn what_would_be_read_as_another_number_is_refused() {
    let read = |text: &str| Reader::default().read(read_table(text.as_bytes())?);
    for (text, words) in [
        (
            "t\tx\n1\t998.5\n2\t1,001\n",
            "line 3: \"1,001\" has a comma that may separate thousands",
        ),
        ("t;x\n1;999,5\n2;1.001\n", "line 2: \"999,5\" has a comma"),
        (
            "t,x\n1,998.5\n2,\"1,001\"\n",
            "line 3: \"1,001\" has a comma that may separate thousands",
        ),
        (
            "t\tx\n1\t2,359\n2\t2,301\n",
            "line 2: \"2,359\" has a comma",
        ),
        (
            "Time Valve open Level\n0 1 0.5\n1 1 0.6\n",
            "line 2: 3 cells under a header of 4",
        ),
        (
            "t valve x\n0 1 0.5\n1   0.7\n",
            "line 3: 2 cells under a header of 3",
        ),
        // A header that has slipped; a row of one number may be a remark.
        (
            "0,1\n,\n0.1,\n0.2,3\ntime_s,relaxation_modulus_pa\n1,5\n2,4\n",
            "2 rows (lines 1, 4) of numbers above the header in line 5",
        ),
        (
            "Rig 3\n1;2;3\ntime_s;valve;level\n1;5;2\n",
            "1 row (line 2) of numbers above the header in line 3",
        ),
    ] {
        assert_refused(read(text), words);
    }
    // A number of a remark is none of the samples.
    read("Samples,2\n1000,\ntime_s,relaxation_modulus_pa\n1,5\n2,4\n").expect("remarks");
    // What shows its decimals is taken.
    read("t;x\n0,5;1,001\n1,0;1,002\n").expect("decimal commas");
    let marked = read_record(b"x,t\n5,1\n#N/A,2\n6,3\n", ["time_s", "x"]);
    let gaps = marked.expect("a gap is counted").gaps();
    assert_eq!(gaps.as_deref(), Some("1 row (line 3)"));
    let missing = read_record(b"x,u\n5,1\n#N/A,2\n6,3\n", ["time_s", "x"]);
    assert_refused(missing, "line 3");
    // An empty line is a missing sample, of numbers in quotes too.
    let missing = read_record(b"x,u\n\"5\",\"1\"\n\n\"6\",\"3\"\n", ["time_s", "x"]);
    assert_refused(missing, "line 3");
    // A date that cannot be is no time.
    let clock = read_record(b"time_s,x\n10:15:00,1\n10:75:01,2\n", ["time_s", "x"]);
    assert_refused(
        clock,
        "line 2, column time_s: \"10:15:00\" is not a finite number",
    );
}

#[test]
fn dates_and_times_of_day_are_times_from_the_first_row_on() {
    let spellings = [
        ["10:15:00", "10:15:00.5", "10:15:02"],
        ["23:59:59", "23:59:59.5", "0:00:01"],
        [
            "2025-12-31 23:59:59",
            "2025-12-31 23:59:59.500",
            "2026-01-01 00:00:01",
        ],
        [
            "2025-12-31T23:59:59Z",
            "2026-01-01T00:59:59.5+01:00",
            "2026-01-01T00:00:01Z",
        ],
        [
            "2024/02/28 23:59:59",
            "2024/02/28 23:59:59.5",
            "2024/02/29 00:00:01",
        ],
        [
            "31.12.2025 23:59:59",
            "31.12.2025 23:59:59.5",
            "1.1.2026 00:00:01",
        ],
    ];
    for rows in spellings {
        // Beside it a clock that stands still, which is not the time.
        let rows = rows.map(|cell| format!("{cell},7,1,2\n")).concat();
        let table = format!("timestamp,elapsed_seconds,u,y\n{rows}");
        let found = read_record(table.as_bytes(), ["time_s", "u", "y"]).expect(&table);
        assert_eq!(found.columns[0], [0.0, 0.5, 2.0], "{table}");
        assert_eq!(found.columns[2], [2.0; 3], "{table}");
    }
    let both = b"date,time_s,y\n2025-12-31 23:59:59,0,1\n2025-12-31 23:59:58,3,1\n";
    let found = read_record(both, ["time_s", "y"]).expect("both");
    assert_eq!(found.columns[0], [0.0, 3.0]);
    let nothing = read_record(both, ["", "y"]).expect("no times");
    assert_eq!(nothing.columns, [vec![], vec![1.0; 2]]);
}

/// One record as programs save it: the same numbers, whatever the spelling.
#[test]
fn a_record_reads_the_same_however_it_is_spelt() {
    let utf16 = |text: &str, mark: bool, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let mark = mark.then_some(0xfeff);
        let units = mark.into_iter().chain(text.encode_utf16());
        units.flat_map(bytes).collect()
    };
    let (little, big) = (u16::to_le_bytes, u16::to_be_bytes);
    let plain = "time_s,valve,level\n0,1,0.5\n0.5,1,1.25\n1,0,-2e-1\n";
    let german = "Prüfstand 3;;\nDatum: 3.4.2026, 12 Uhr;;\n\nZeit [ms];Valve [%];Level / °C\n0;1;0,5\n500;1;1,25\n1000;0;-2e-1\n";
    let latin: Vec<u8> = german
        .chars()
        .map(|c| u8::try_from(c).expect("Latin"))
        .collect();
    let tabs = "sep=\t\r\nTime\tValve\tLevel\r\nms\t%\tV\r\n0\t1\t0,5\r\n500\t1\t1,25\r\n1000\t0\t-0,2\r\n";
    let quoted =
        "time_s,valve,level\n\"0\",\"1\",\"0,5\"\n\"0,5\",\"1\",\"1,25\"\n\"1\",\"0\",\"-0,2\"\n";
    let spellings: [(&str, Vec<u8>, &str); 13] = [
        ("plain", plain.into(), "time_s"),
        ("marked", format!("\u{feff}{plain}").into_bytes(), "time_s"),
        ("UTF-16", utf16(plain, true, little), "time_s"),
        ("UTF-16BE", utf16(plain, true, big), "time_s"),
        (
            "UTF-16 without a mark",
            utf16(plain, false, little),
            "time_s",
        ),
        (
            "UTF-16BE without a mark",
            utf16(plain, false, big),
            "time_s",
        ),
        ("German", german.into(), "Zeit"),
        ("German of Windows", latin, "Zeit"),
        ("tabs and a row of units", tabs.into(), "time_s"),
        (
            "blank rows, old Mac",
            plain.replace('\n', "\r\r").into(),
            "time_s",
        ),
        ("spaces", plain.replace(',', "   ").into(), "time_s"),
        (
            "spaces and decimal commas",
            plain.replace(',', " ").replace('.', ",").into(),
            "time_s",
        ),
        ("decimal commas in quotes", quoted.into(), "time_s"),
    ];
    for (what, bytes, time) in spellings {
        let record = read_record(&bytes, [time, "valve", "level"]).expect(what);
        let want = [
            vec![0.0, 0.5, 1.0],
            vec![1.0, 1.0, 0.0],
            vec![0.5, 1.25, -0.2],
        ];
        assert_eq!(record.columns, want, "{what}");
        assert_eq!(record.gaps(), None, "{what}");
    }
    let gaps = read_record(
        plain.replace("1.25", "NaN").replace("-2e-1", "").as_bytes(),
        ["time_s", "valve", "level"],
    );
    let gaps = gaps.expect("gaps are counted");
    assert_eq!(gaps.gaps().as_deref(), Some("2 rows (lines 3, 4)"));
    assert!(gaps.columns[2][1].is_nan() && gaps.columns[2][2].is_nan());
    let mut odd = utf16(plain, true, little);
    odd.truncate(odd.len() - 3);
    let refused = read_record(&odd, ["time_s", "valve", "level"]);
    assert_refused(refused, "UTF-16 of an odd number of bytes");
    let fortnights = plain.replace("time_s", "time [fortnights]");
    let refused = read_record(fortnights.as_bytes(), ["time", "valve", "level"]);
    let refused = refused.expect_err("no unit").to_string();
    assert!(
        refused.starts_with("line 1: unit \"fortnights\" is not a unit of time"),
        "{refused}"
    );
}

/// A table, and what is read of it or said.
const FOUND: &str = r#"
    time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n\ntime_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n | 2 segments could be meant & lines 2 to 4 & lines 7 to 9 & `segment`
    time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\nMark\n4,2\n5,1.5\n6,1\n | 2 segments could be meant & lines 6 to 8
    time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\nMean,4\n | line 5, column time_s & "Mean"
    time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n2.5,2\n6,1\n | line 5 & time 2.5 s comes after 3 s
    Frequency,G' (Pa),G'' (Pa)\n1,5,1\n2,6,2\n3,7,3\n | line 1, column Frequency & Hz or rad/s & `units`
    Time [fortnights],Modulus\n1,5\n2,4\n | line 1, column Time [fortnights] & "fortnights" is not a unit of time
    Time,Modulus\nfortnights,Pa\n1,5\n2,4\n | "fortnights" is not a unit of time
    dear reader\nno number is here\n | no row with numbers in 2 lines
    T,E(t)\n1,5\n2,4\n3,3\n | make no record & time=1
    Time (s),G (Pa),G (Pa)\n1,5,1\n2,4,2\n3,3,3\n | line 1 & the columns G (Pa) and G (Pa) both look like modulus & modulus=2 or modulus=3
    Time (s),Load (N)\n100,200,300\n100,300,400\n | 3 cells under a header of 2
    foo,bar\n1,5\n2,4\n | line 1 & none of the columns foo, bar is known & `columns`
"#;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_was_found_where_is_said_in_one_line() {
    for [text, wanted] in testkit::table(FOUND) {
        let message = as_it_is(&text).expect_err(&text);
        assert_says(&message, &wanted);
        assert!(!message.contains('\n') && message.len() < 400, "{message}");
    }
    // Nobody reads a cell of a megabyte.
    let long = format!(
        "time_s,relaxation_modulus_pa\n1,{}\n2,3\n",
        "9".repeat(1 << 20)
    );
    let message = as_it_is(&long).expect_err("long");
    assert!(
        message.starts_with("line 2") && message.len() < 300,
        "{message}"
    );
    let line = "x".repeat(1 << 22);
    let message = as_it_is(&line).expect_err("long");
    assert_says(&message, "no row with numbers in 1 lines");
}

/// A table without names, by numbers; blocks of another file's preamble do not hide it.
#[test]
fn a_table_without_names_has_numbers() {
    let text = "0 1 0.5\n0.5 1 0.6\n1 0 0.7\n";
    let record = read_record(text.as_bytes(), ["1", "3"]).expect("two columns");
    assert_eq!(
        record.columns,
        [[0.0, 0.5, 1.0], [0.5, 0.6, 0.7]].map(Vec::from)
    );
    assert_eq!(record.lines, [1, 2, 3]);
    assert_refused(read_record(text.as_bytes(), ["1", "4"]), "no column 4");
    // A word and its symbol are one name.
    let german = "Kreisfrequenz ω [rad/s];Speichermodul G' [kPa];Verlustmodul G'' [kPa]\n1;5,5;1\n2;6;2\n3;7;3\n";
    let record = plain(german).record;
    assert_eq!(
        (record.x(), record.first()),
        (&[1.0, 2.0, 3.0][..], &[5500.0, 6e3, 7e3][..])
    );
}

/// Rows and lines that are no part of the record are counted.
#[test]
fn nothing_is_left_out_in_silence() {
    for [text, samples, note] in testkit::table(
        r"
        made by hand\ntime_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n | 3 | lines 1 to 1 above the header are not read: made by hand
        time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n\nfirst,second\n1,2\n3,4\n5,6\n | 3 | 3 rows (lines 7, 8, 9) left out, no part of this table
        time_s,relaxation_modulus_pa\n1,5\n2,NaN\n3,4\n4,3\n | 3 | 1 row (line 3) left out, a cell without a number
        time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\nend,here\n | 3 | 1 row (line 5) left out, no part of this table
        t (s),E(t) (kPa)\n4,3\n2,4\n1,5\n | 3 | read from the last to the first
        Angular frequency (rad/s),Stress (Pa),Normal stress (Pa),G' (Pa),G'' (Pa)\n1,1,1,5,1\n2,1,1,6,2\n3,1,1,7,3\n | 3 | kind oscillation
        time_s,relaxation_modulus_pa,step\n1,5,a\n2,4,a\n3,3,a\n | 3 | kind relaxation
        Date,Time,Elapsed Time (s),E(t) (Pa)\n1.2.26,10:00,1,5\n1.2.26,10:01,2,4\n1.2.26,10:02,3,3\n | 3 | kind relaxation, by the columns Elapsed Time (s), E(t) (Pa)
        ",
    ) {
        let understood = plain(&text);
        assert_eq!(understood.record.samples().to_string(), samples, "{text:?}");
        assert_says(&understood.notes.join("\n"), &note);
    }
}

/// A column that is named with its clock is all that is looked at.
#[test]
fn columns_that_nobody_named_are_not_looked_at() {
    let text = "Angular frequency (rad/s),a,b,Frequency (Hz),Time (s),Time (min)\n\
                1,5,1,x,1,y\n2,6,2,x,,y\n3,7,3,x,?,y\n";
    let columns = [(Column::Omega, 1), (Column::Storage, 2), (Column::Loss, 3)];
    let reader = Reader {
        columns: columns
            .map(|(column, n)| (column, Choice::Number(n)))
            .into(),
        ..Reader::default()
    };
    let record = understand(text, &reader, &TableDetails::default())
        .expect("valid")
        .record;
    assert_eq!((record.samples(), record.x()), (3, &[1.0, 2.0, 3.0][..]));
    // A frequency in 1/s is asked for there too.
    let text = "Frequency (1/s),a,b\n1,5,1\n2,6,2\n3,7,3\n";
    assert_refused(
        understand(text, &reader, &TableDetails::default()),
        "Hz or rad/s",
    );
}

/// A table of 24 rows, rows that are put into it at a line, and the lines that are named, or why none is.
const BAD_ROWS: &str = r"
    5 3,-1 | 1 row (line 5) left out
    5 3,over & 9 6,-1 & 15 11,0 | 3 rows (lines 5, 9, 15) left out
    9 6,700 | 1 row (line 9) left out
    4 x,1 & 5 x,1 & 6 x,1 & 7 x,1 | 4 bad rows are more than a tenth & `skip_bad_rows`
    3 1,0 & 4 1,0 & 5 1,0 & 6 1,0 | 4 bad rows are more than a tenth & `skip_bad_rows`
";

#[test]
fn a_bad_row_is_left_out_by_name_where_that_is_asked_for() {
    for [bad, wanted] in testkit::table(BAD_ROWS) {
        let rows = (1..=24).map(|n| format!("{n},{}", 1e3 * f64::from(n).powf(-0.2)));
        let mut rows: Vec<String> = rows.collect();
        for row in bad.split(" & ") {
            let (line, row) = row.split_once(' ').expect("a row");
            // Line 1 is the header.
            rows.insert(line.parse::<usize>().expect("a line") - 2, row.to_owned());
        }
        let text = format!("time_s,relaxation_modulus_pa\n{}\n", rows.join("\n"));
        let refused = as_it_is(&text);
        assert!(refused.expect_err(&bad).starts_with("line "), "{bad}");
        let reader = Reader {
            skip_bad_rows: true,
            ..Reader::default()
        };
        let wording = match understand(&text, &reader, &TableDetails::default()) {
            Ok(read) => {
                assert_eq!(read.record.samples(), 24, "{bad}");
                read.notes.join("; ")
            }
            Err(refused) => refused,
        };
        assert_says(&wording, &wanted);
    }
}

/// Creep and recovery of 2000 Pa·s^0.5 in two segments of one clock: each by itself would begin at rest.
#[test]
fn segments_that_go_on_with_the_clock_are_one_motion() {
    let compliance = |t: f64| t.max(0.0).sqrt() / (2000.0 * libm::tgamma(1.5));
    let strain = |t: f64| 100.0 * (compliance(t) - compliance(t - 10.0));
    let rows = |from: i32, to: i32, stress: i32| -> String {
        let row = |n: i32| format!("{n},{},{stress}\n", strain(f64::from(n)));
        (from..=to).map(row).collect()
    };
    let header = "time_s,strain,stress_pa\n";
    let (creep, recovery) = (rows(1, 10, 100), rows(11, 30, 0));
    let text = format!("Creep\n{header}0,0,0\n{creep}\nRecovery\n{header}{recovery}");
    let reader = Reader {
        segments: vec!["all".to_owned()],
        ..Reader::default()
    };
    let table = read_table(text.as_bytes()).expect("a table");
    let all = reader.read_all(&table).expect("two segments");
    assert_eq!(all.len(), 2);
    let mut joined = Columns::joined(all.clone());
    let one = joined.pop().expect("one");
    assert!(joined.is_empty());
    let read = TableDetails::default().record(one).expect("a creep");
    assert_eq!(read.record.kind(), RecordKind::Creep);
    let found = super::one(&read.record, haptic_tissue::ModelKind::SpringPot);
    let values = &found.fits[0].parameters;
    assert_relative("V", values[0].value, 2000.0, 1e-6);
    assert_relative("order", values[1].value, 0.5, 1e-6);
    // A clock that begins anew is another motion.
    let again = Columns::joined([&all[..1], &all[..1]].concat());
    assert_eq!(again.len(), 2);
}
