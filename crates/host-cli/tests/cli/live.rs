//! Live streams as a viewer meets them.

#[cfg(feature = "foxglove")]
mod foxglove;

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::process::Output;
use std::time::Duration;

/// No step of these tests takes a tenth of this, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// Runs `host-cli LINE` in a folder.
fn run(place: &Path, line: &str) -> Output {
    let mut command = assert_cmd::Command::new(assert_cmd::cargo::cargo_bin!("host-cli"));
    let command = command.args(line.split_whitespace()).current_dir(place);
    command.timeout(PATIENCE).output().expect("runs and ends")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

/// A point of a Teleplot line.
struct Point {
    name: String,
    time_ms: f64,
    value: f64,
    unit: String,
}

/// Reads a datagram by the grammar of Teleplot's README.
fn points(datagram: &str) -> Vec<Point> {
    let mut points = Vec::new();
    for line in datagram.lines() {
        let (name, rest) = line.split_once(':').expect("a name");
        let (values, unit) = rest.split_once('§').unwrap_or((rest, ""));
        for value in values.split(';') {
            let (time_ms, value) = value.split_once(':').expect("a time");
            points.push(Point {
                name: name.to_owned(),
                time_ms: time_ms.parse().expect("a time"),
                value: value.parse().expect("a value"),
                unit: unit.to_owned(),
            });
        }
    }
    points
}

/// All points that come, until one says `end`.
fn listen(viewer: &UdpSocket) -> Vec<Point> {
    let (mut all, mut buffer) = (Vec::new(), [0; 65536]);
    loop {
        let length = viewer.recv(&mut buffer).expect("receives");
        assert!(length <= 1400, "{length} bytes");
        match std::str::from_utf8(&buffer[..length]).expect("UTF-8") {
            "end" => return all,
            datagram => all.extend(points(datagram)),
        }
    }
}

/// The points of a field are its column of the log, in its unit.
fn assert_points(have: &[&Point], unit: &str, rows: &[&Vec<f64>], column: usize) {
    for (n, point) in have.iter().enumerate() {
        assert_eq!(point.unit, unit, "{}", point.name);
        let want = rows[n][column];
        assert!(
            (point.value - want).abs() <= 1e-6 * want.abs(),
            "{} {n}: {} {want}",
            point.name,
            point.value
        );
        // To the µs, whatever the ms it began in.
        let (since_ms, time_ms) = (point.time_ms - have[0].time_ms, 1e3 * rows[n][1]);
        assert!(
            (since_ms - time_ms).abs() < 2e-3,
            "{} {n}: {since_ms} {time_ms}",
            point.name
        );
    }
}

#[test]
fn teleplot_gets_the_samples_of_the_log() {
    let place = tempfile::tempdir().expect("a folder");
    let viewer = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let address = viewer.local_addr().expect("has one");
    let listener = std::thread::spawn(move || listen(&viewer));
    let line =
        format!("relax --duration 0.4s --ramp-time 0.1s --realtime --teleplot={address} --out .");
    let ended = run(place.path(), &line);
    assert!(ended.status.success(), "{}", stderr(&ended));
    let note = format!("live stream: Teleplot datagrams to {address}");
    assert!(stderr(&ended).contains(&note), "{}", stderr(&ended));
    let end = UdpSocket::bind("127.0.0.1:0").expect("a port");
    end.send_to(b"end", address).expect("sends");
    let points = listener.join().expect("listens");

    run(place.path(), "log export relax.mcap ticks.csv");
    let mut log = csv::Reader::from_path(place.path().join("ticks.csv")).expect("a table");
    let columns: Vec<String> = log
        .headers()
        .expect("names")
        .iter()
        .map(str::to_owned)
        .collect();
    let rows: Vec<Vec<f64>> = log.deserialize().map(|row| row.expect("numbers")).collect();
    assert!(rows.len() > 400, "{}", rows.len());
    let sent = columns
        .iter()
        .enumerate()
        .filter(|(_, name)| !["tick", "time_s"].contains(&name.as_str()));
    for (column, name) in sent {
        let have: Vec<&Point> = points.iter().filter(|point| point.name == *name).collect();
        // What is not a number, as the energy without a guard, is left out.
        let rows: Vec<&Vec<f64>> = rows.iter().filter(|row| row[column].is_finite()).collect();
        assert_eq!(have.len(), rows.len(), "{name}");
        assert_eq!(rows.is_empty(), name == "observed_energy_j", "{name}");
        let unit = match name.rsplit_once('_') {
            Some((_, "m")) => "m",
            Some((_, "n")) => "N",
            Some((_, "j")) => "J",
            _ => "",
        };
        assert_points(&have, unit, &rows, column);
    }
}

#[test]
fn a_burst_and_a_missing_viewer_are_warnings_and_no_failure() {
    let place = tempfile::tempdir().expect("a folder");
    let gone: SocketAddr = {
        let viewer = UdpSocket::bind("127.0.0.1:0").expect("a port");
        viewer.local_addr().expect("has one")
    };
    let ended = run(
        place.path(),
        &format!("relax --duration 2s --teleplot={gone} --out ."),
    );
    assert!(ended.status.success(), "{}", stderr(&ended));
    assert!(stderr(&ended).contains("--realtime"), "{}", stderr(&ended));
    #[cfg(target_os = "linux")]
    {
        let lost = format!("2001 of 2001 samples did not reach a Teleplot at {gone}");
        assert!(stderr(&ended).contains(&lost), "{}", stderr(&ended));
    }
}

#[test]
fn a_bad_address_is_refused_before_any_file_is_made() {
    for (arguments, wanted) in [
        ("--teleplot=localhost", "IP:PORT"),
        ("--teleplot=127.0.0.1:0", "port 0"),
        ("--foxglove=8765", "IP:PORT"),
        ("--foxglove=127.0.0.1:65536", "IP:PORT"),
    ] {
        let place = tempfile::tempdir().expect("a folder");
        let ended = run(
            place.path(),
            &format!("relax --duration 2s {arguments} --out run"),
        );
        assert_eq!(
            ended.status.code(),
            Some(2),
            "{arguments}: {}",
            stderr(&ended)
        );
        assert!(
            stderr(&ended).contains(wanted),
            "{arguments}: {}",
            stderr(&ended)
        );
        assert!(!place.path().join("run").exists(), "{arguments}");
    }
}

// `.ci/run` tests with the feature, and asks a command without it the same.
#[cfg(not(feature = "foxglove"))]
#[test]
fn a_build_without_foxglove_says_so() {
    let place = tempfile::tempdir().expect("a folder");
    let ended = run(place.path(), "relax --duration 2s --foxglove --out run");
    assert_eq!(ended.status.code(), Some(2), "{}", stderr(&ended));
    assert!(
        stderr(&ended).contains("--features foxglove"),
        "{}",
        stderr(&ended)
    );
}
