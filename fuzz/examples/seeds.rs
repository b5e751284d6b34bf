//! Writes `corpus/`: one small input for each thing a target should know of. Run it after a change of the
//! messages or of the log: `cargo run --example seeds`.
#![forbid(unsafe_code)]

use haptic_link::{
    BatchItem, DeviceReport, FRAME_MAX, Header, Request, Sample, SampleBatch, encode,
};
use haptic_log::record::LogWriter;
use haptic_message::{EventMessage, TickMessage};
use std::error::Error;
use std::fs;
use std::io::Cursor;
use std::path::Path;

type Done = Result<(), Box<dyn Error>>;

fn main() -> Done {
    frames()?;
    sessions()?;
    logs()?;
    files()?;
    records()?;
    tables()
}

/// Measured records: each kind, with headers of ours and of others.
fn records() -> Done {
    for (name, text) in [
        ("relaxation", "time_s\trelaxation_modulus_pa\n1\t5\n2\t4\n"),
        ("creep", "# creep\nTime (ms),J(t) [1/kPa]\n1,4\n2,5\n"),
        (
            "oscillation",
            "Frequency;G';G''\nHz;kPa;kPa\n1,5;4;1\n2;5;2\n",
        ),
        ("motion", "time_s,strain,stress_pa\n0,0,0\n1,0.1,4\n2,,5\n"),
    ] {
        write("record", name, text.as_bytes())?;
    }
    Ok(())
}

/// A file of the corpus.
fn write(target: &str, name: &str, bytes: &[u8]) -> Done {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target);
    fs::create_dir_all(&folder)?;
    Ok(fs::write(folder.join(name), bytes)?)
}

/// A request; reports, one of them cut.
fn frames() -> Done {
    let mut line = [0; FRAME_MAX];
    let hello = Request::Hello { nonce: 1 };
    let length = encode(&hello, Header::from_host(0, 0), &mut line).map_err(|e| e.to_string())?;
    write("frame", "request", &line[..length])?;
    let item = BatchItem::default();
    let sample = DeviceReport::Sample(Sample {
        axes: [item].into_iter().collect(),
        ..Sample::default()
    });
    let length = encode(&sample, Header::from_device(1), &mut line).map_err(|e| e.to_string())?;
    let twice = [&line[..length], &line[..length / 2], &[0], &line[..length]].concat();
    write("frame", "reports", &twice)?;
    let force = Request::Force {
        tick: 1,
        force_n: [0.5, -0.5].into_iter().collect(),
    };
    let length = encode(&force, Header::from_host(1, 1), &mut line).map_err(|e| e.to_string())?;
    write("frame", "force", &line[..length])?;
    let batch = DeviceReport::Batch(SampleBatch {
        tick: 1,
        time_us: 1000,
        every: 1,
        axes: 2,
        items: [item; 4].into_iter().collect(),
        sensed_force_n: [0.25; 4].into_iter().collect(),
    });
    let length = encode(&batch, Header::from_device(2), &mut line).map_err(|e| e.to_string())?;
    write("frame", "vectors", &line[..length])?;
    Ok(())
}

/// Sessions with a loop on the device and on the host.
fn sessions() -> Done {
    // Numbers of steps as in script.rs: 0 ticks, 2 frame, 4 configure, 5 coefficients, 6 commit, 7 arm, 8 start,
    // 9 force, 10 keep-alive, 11 skip.
    let spring = [5, 0, 2, 125, 131, 6];
    let device_loop = [&[4, 0, 0][..], &spring, &[7, 8, 60, 1, 0, 15, 10, 0, 200]].concat();
    write("session", "device-loop", &device_loop)?;
    let host_loop = [
        &[4, 1, 0][..],
        &spring,
        &[7, 8, 0, 4],
        &[9, 16, 0, 5].repeat(4),
        &[0, 40, 7, 8, 0, 1, 2, 1, 10],
    ]
    .concat();
    write("session", "host-loop", &host_loop)?;
    // Disarmed while running, late ticks, a skipped and a repeated number.
    let disarm = [
        &device_loop[..15],
        &[2, 1, 8, 1, 9, 3, 11, 5, 10, 11, 255, 10, 0, 9],
    ]
    .concat();
    write("session", "disarm", &disarm)?;
    Ok(())
}

/// A log, whole, cut and damaged.
fn logs() -> Done {
    let mut log = LogWriter::with_sink(Cursor::new(Vec::new()), Path::new("seed"))?;
    log.metadata("run", [("seed".to_owned(), "1".to_owned())].into())?;
    // Three chunks.
    for tick in 0..30 {
        let time_s = 1e-2 * tick as f64;
        let message = TickMessage {
            tick,
            time_s,
            position_m: 1e-3.into(),
            ..TickMessage::at_rest(1)
        };
        log.tick(&message)?;
    }
    log.event(&EventMessage {
        time_s: 0.3,
        kind: "end".to_owned(),
        text: "done".to_owned(),
    })?;
    let log = log.close()?.into_inner();
    write("log", "whole", &log)?;
    write("log", "cut", &log[..log.len() / 2])?;
    let name = log.windows(7).position(|window| window == b"\x03\0\0\0run");
    let name = 4 + name.ok_or("no metadata")?;
    // Found by this target: a length that nothing should be reserved for.
    let long = [&log[..name - 4], &[0xff; 4], &log[name..]].concat();
    write("log", "long-text", &long)?;
    // Found by this target too: a chunk, not compressed, whose one record says that it has a byte more.
    let record = [&[0x88], 3_u64.to_le_bytes().as_slice(), &[1, 2]].concat();
    let records = (record.len() as u64).to_le_bytes();
    let chunk = [&[0; 32], records.as_slice(), &record, &[7; 5]].concat();
    let length = (chunk.len() as u64).to_le_bytes();
    let padded = [&log[..8], &[6], length.as_slice(), &chunk].concat();
    write("log", "padded-chunk", &padded)?;
    Ok(())
}

/// Experiments and materials as users have them.
fn files() -> Done {
    let folder = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name);
    for name in ["wall", "relax", "creep"] {
        let text = fs::read(folder("experiments").join(format!("{name}.toml")))?;
        write("experiment", name, &text)?;
    }
    let all_keys = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 2e-3\norder = 0.5\n\
                    stiffness_n_per_m = 3_000\ndissipation_n_s_mu_per_m = 60.0\ndevice = \"sim\"\n\
                    loop = \"host\"\nguard = \"observer\"\nscheme = \"sm=20\"\none_sided = true\nseed = 7\n";
    write("experiment", "keys", all_keys.as_bytes())?;
    for name in ["prostate-cancerous", "prostate-healthy"] {
        let text = fs::read(folder("crates/haptic-tissue/materials").join(format!("{name}.toml")))?;
        write("material", name, &text)?;
    }
    Ok(())
}

/// Tables with and without quotation marks.
fn tables() -> Done {
    write("csv", "plain", b"t,x\n0,1.5\n1,-2e-3\n")?;
    write(
        "csv",
        "quoted",
        b"\"x\", \"a\"\"b\"\r\n 1 ,\"two\nlines\"\r\n\r\n3,4\r\n",
    )?;
    Ok(())
}
