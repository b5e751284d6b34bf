//! Logs that somebody else wrote: topics as tables, for every command that reads one.

use crate::process::Place;
use std::path::Path;
use testkit::assert_says;

/// A folder with the logs that `others/make_logs.py` made by the public packages.
fn place() -> Place {
    let place = Place::new();
    let logs = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/others");
    for name in ["ros1", "ros2", "json", "protobuf", "set-back"].map(|name| format!("{name}.mcap"))
    {
        std::fs::copy(logs.join(&name), place.path(&name)).expect("copies");
    }
    place
}

/// Rows of a table by the names of its columns; what is no number is NaN.
fn rows(text: &str, columns: &[&str]) -> Vec<Vec<f64>> {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let place = |name: &&str| {
        header
            .iter()
            .position(|cell| cell == name)
            .expect("is there")
    };
    let places: Vec<usize> = columns.iter().map(place).collect();
    let row = |row: Vec<&str>| {
        let cells = places
            .iter()
            .map(|&place| row[place].parse().unwrap_or(f64::NAN));
        cells.collect()
    };
    lines.map(row).collect()
}

#[test]
fn nested_messages_arrays_and_stamps_of_ros_2_are_columns() {
    let place = place();
    let text = place
        .run("log export ros2.mcap - --columns /wrench")
        .succeeded()
        .stdout
        .clone();
    let header = "time_s,header.stamp_s,wrench.force.x,wrench.force.y,wrench.force.z,wrench.torque.x,wrench.torque.y,wrench.torque.z,depth_mm";
    assert_eq!(text.lines().next(), Some(header));
    let all = rows(
        &text,
        &[
            "time_s",
            "header.stamp_s",
            "wrench.force.y",
            "wrench.force.z",
            "depth_mm",
        ],
    );
    assert_eq!(all.len(), 60);
    for (n, row) in (0..).zip(&all) {
        let stamp = f64::from(20 * n) / 1e3;
        // Recorded 3 ms late where n is odd; both to the last digit.
        let recorded = f64::from(20 * n + 3 * (n % 2)) / 1e3;
        let depth_mm = 1e3 * (1e-3 * f64::min(0.02 * f64::from(n) / 0.2, 1.0));
        assert_eq!(
            (row[0], row[1], row[2], row[4]),
            (recorded, stamp, -1.5, depth_mm),
            "{n}"
        );
    }
    let text = place
        .run("log export ros2.mcap - --columns /joints")
        .succeeded()
        .stdout
        .clone();
    let names = [
        "counts[0]",
        "counts[1]",
        "is_on",
        "current",
        "position[0]",
        "position[3]",
    ];
    let n3 = &rows(&text, &names)[3];
    assert_eq!(n3[..5], [-3.0, 900.0, 1.0, 0.75, 1.5]);
    // A shorter array has no such element, and text no number.
    assert!(
        n3[5].is_nan() && !text.contains("name") && !text.contains("KIND"),
        "{text}"
    );
}

#[test]
fn messages_of_json_are_columns() {
    let place = place();
    let text = place
        .run("log export json.mcap -")
        .succeeded()
        .stdout
        .clone();
    assert_eq!(
        text.lines().nth(3),
        Some("0.1,1,0.3625384938440363,1,1.5,2,2")
    );
}

#[test]
fn a_tissue_and_a_plant_are_identified_from_logs_of_others() {
    let place = place();
    let line = "identify ros2.mcap --area 4cm2 --thickness 20mm --model spring-pot --columns";
    let columns = "time=/wrench.header.stamp_s,position=/wrench.depth_mm,force=/wrench.wrench.force.z --units position=mm";
    let found = place
        .run(&format!("{line} {columns} --json"))
        .succeeded()
        .json();
    let [v, order] = ["viscosity_pa_s_alpha", "order"].map(|name| {
        found["parameters"][name]["value"]
            .as_f64()
            .expect("a number")
    });
    // The lines between the samples are the motion itself.
    assert!(
        (v - 1000.0).abs() < 1e-3 && (order - 0.2).abs() < 1e-6,
        "{v} {order}"
    );
    let line = "control identify json.mcap --columns input=/plant.u,output=y";
    let found = place.run(&format!("{line} --json")).succeeded().json();
    assert_eq!(found["function"], "2/(0.5s+1)");
    let y = place.run(
        "differintegrate --order 1 --sample-time 50ms json.mcap --column /plant.motor.current",
    );
    assert_eq!(y.succeeded().table("x,y")[7], [7.0, 20.0]);
    place
        .run("log plot json.mcap --columns /plant.y,/plant.u")
        .succeeded();
    assert!(place.path("json.log.svg").exists());
    let report = place.json("log export json.mcap plant.csv");
    assert_eq!(report["samples"], 80);
}

/// The wrench of ROS 2, in the bytes of ROS 1.
#[test]
fn messages_of_ros_1_are_columns_too() {
    let place = place();
    let export = |name: &str| {
        let line = format!("log export {name}.mcap - --columns /wrench");
        let text = place.run(&line).succeeded().stdout.clone();
        rows(
            &text,
            &[
                "header.stamp_s",
                "wrench.force.y",
                "wrench.force.z",
                "depth_mm",
            ],
        )
    };
    assert_eq!(export("ros1"), export("ros2"));
    let line = "log export ros1.mcap - --columns /wrench.header.seq,/wrench.wrench.torque[1]";
    let text = place.run(line).succeeded().stdout.clone();
    let all = rows(&text, &["header.seq", "wrench.torque[1]"]);
    assert_eq!(all[5], [5.0, 2.5]);
    assert!(all[4][1].is_nan());
}

#[test]
fn what_a_log_of_others_does_not_tell_is_asked_for_in_one_line() {
    let place = place();
    place.refuses(
        "
        identify ros2.mcap => several topics | /joints (5 messages: header.stamp_s, counts[0] | /wrench (60 messages | /topic.field | --columns
        log export ros2.mcap - => several topics | /wrench (60
        log plot ros2.mcap => several topics
        control identify ros2.mcap => several topics
        log export ros2.mcap - --columns /nowhere => no topic of that name | /wrench (60
        log export ros2.mcap - --columns /wrenches.force => no topic of that name
        log export ros2.mcap - --columns /wrench,/joints.current => times of its own in each topic
        log export ros2.mcap - --columns /wrench.force => no column force | wrench.force.x
        log plot ros2.mcap --columns /wrench => 8 columns | room for 6 | --columns
        log export protobuf.mcap - --columns /probe => no numbers in that topic | \"protobuf\" defined by \"protobuf\" is not read
        log export protobuf.mcap - => no topic of numbers | /probe (30 messages: \"protobuf\"
        identify json.mcap --columns time=/plant.mode,force=/plant.y => no column \"mode\"
        control identify json.mcap --columns input=/plant.u,output=/plant.mode => no column mode
        differintegrate --order 0.5 --sample-time 1ms json.mcap => no column x
        ",
    );
    place
        .run("log export json.mcap - --columns /plant.y")
        .succeeded();
}

#[test]
fn a_clock_that_was_set_back_is_told_and_nothing_is_read_by_it() {
    let place = place();
    let words = "steps by -0.95 s behind message 40 of 80 & in the order of the file";
    let export = place.run("log export set-back.mcap -");
    assert_says(&export.stderr, words);
    let export = export.succeeded_with_warnings();
    let currents = rows(&export.stdout, &["time_s", "motor.current"]);
    assert_eq!(
        [&currents[39], &currents[40]],
        [&[1.95, 39.0], &[1.0, 40.0]]
    );
    let line = "control identify set-back.mcap --columns input=u,output=y";
    let refused = place.run(line).failed(2);
    assert_says(&refused.stderr, &format!("{words} & --sample-time"));
    // Its rows are right.
    let found = place.run(&format!("{line} --sample-time 50ms --json"));
    assert_eq!(
        found.succeeded_with_warnings().json()["function"],
        "2/(0.5s+1)"
    );
}

#[test]
fn a_damaged_log_of_others_is_read_as_far_as_it_goes_and_told() {
    let place = place();
    let whole = place.read("ros2.mcap");
    // The chunk begins early; the index and the summary are behind it.
    place.write("cut.mcap", &whole[..whole.len() - 40]);
    let run = place.run("log export cut.mcap - --columns /wrench");
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    assert!(run.stderr.contains("not whole"), "{}", run.stderr);
    assert_eq!(run.stdout.lines().count(), 61);
    for length in (0..whole.len()).step_by(97) {
        place.write("cut.mcap", &whole[..length]);
        let run = place.run("log export cut.mcap - --columns /wrench");
        assert!(matches!(run.code, Some(2 | 4)), "{length}: {}", run.stderr);
    }
}
