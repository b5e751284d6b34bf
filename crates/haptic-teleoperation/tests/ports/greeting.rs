//! Two sides that meet, whoever speaks first: they agree, or one line says why not.

use haptic_link::{
    Architecture, Direction, FRAME_MAX, HandHello, HandMessage, HandSample, HandSide, HandState,
    Header, MessageKey, Receiver, encode,
};
use haptic_teleoperation::{Introduction, Peer, PeerError, PeerMessage};
use testkit::assert_says;

const MASTER: Introduction = Introduction {
    side: HandSide::Master,
    architecture: Architecture::Wave,
    sample_time_s: 1e-3,
    wave_impedance_n_s_per_m: 3.0,
    coupler_digest: 0,
};
const SLAVE: Introduction = Introduction {
    side: HandSide::Slave,
    ..MASTER
};
const SAMPLE: HandSample = HandSample {
    sequence: 1,
    time_s: 0.5,
    state: HandState::Position { position_m: 1.0 },
};

fn hello(peer: &mut Peer) -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let length = peer.hello(&mut line).expect("it fits");
    line[..length].to_vec()
}

fn sample(peer: &mut Peer) -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let length = peer.sample(SAMPLE, &mut line).expect("it fits");
    line[..length].to_vec()
}

#[test]
fn two_sides_meet_whichever_speaks_first_and_whatever_is_lost() {
    let (mut master, mut slave) = (Peer::new(MASTER, 7), Peer::new(SLAVE, 9));
    // Lost.
    let _ = hello(&mut master);
    assert_eq!(master.take(&hello(&mut slave)), Ok(PeerMessage::Hello));
    assert!(!master.is_connected());
    // The master has heard the slave: no answer, which would be answered in turn.
    assert_eq!(slave.take(&hello(&mut master)), Ok(PeerMessage::Met));
    assert!(slave.is_connected());
    // The slave's answer is lost, but its first sample says as much.
    assert_eq!(
        master.take(&sample(&mut slave)),
        Ok(PeerMessage::Sample(SAMPLE))
    );
    assert!(master.is_connected());
    // Of another connection, damaged, or no frame at all: nothing.
    let mut other = Peer::new(SLAVE, 10);
    assert_eq!(master.take(&sample(&mut other)), Ok(PeerMessage::Nothing));
    assert_eq!(master.take(&hello(&mut other)), Ok(PeerMessage::Nothing));
    assert_eq!(master.other_connections(), 2);
    let mut damaged = sample(&mut slave);
    damaged[5] ^= 1;
    assert_eq!(master.take(&damaged), Ok(PeerMessage::Nothing));
    assert_eq!(
        master.take(b"GET / HTTP/1.1\r\n\0"),
        Ok(PeerMessage::Nothing)
    );
    // A cut frame does not spoil the next.
    let whole = sample(&mut slave);
    assert_eq!(master.take(&whole[..10]), Ok(PeerMessage::Nothing));
    assert_eq!(master.take(&whole), Ok(PeerMessage::Sample(SAMPLE)));
}

#[test]
fn a_side_that_does_not_fit_is_named() {
    let refused = |other: Introduction| {
        let mut other = Peer::new(other, 2);
        let heard = Peer::new(MASTER, 1).take(&hello(&mut other));
        heard.expect_err("does not fit")
    };
    assert_eq!(refused(MASTER), PeerError::SameSide(HandSide::Master));
    let error = refused(Introduction {
        architecture: Architecture::TimeDomain,
        ..SLAVE
    });
    assert_eq!(
        error.to_string(),
        "the other side has the architecture time-domain, this one wave: give both the same `architecture`"
    );
    let (mut slow, mut soft) = (SLAVE, SLAVE);
    slow.sample_time_s = 2e-3;
    soft.wave_impedance_n_s_per_m = 4.0;
    let words = [
        "0.002 s, this one of 0.001 s",
        "4 N·s/m, this one of 3 N·s/m",
    ];
    for (other, words) in [slow, soft].into_iter().zip(words) {
        let message = refused(other).to_string();
        assert_says(&message, words);
    }
    let error = refused(Introduction {
        coupler_digest: 1,
        ..SLAVE
    });
    assert_eq!(error, PeerError::OtherCoupler);
}

#[test]
fn somebody_who_comes_late_is_told_that_this_side_is_busy() {
    let (mut master, mut slave) = (Peer::new(MASTER, 7), Peer::new(SLAVE, 9));
    assert_eq!(master.take(&hello(&mut slave)), Ok(PeerMessage::Hello));
    assert_eq!(slave.take(&hello(&mut master)), Ok(PeerMessage::Met));
    assert_eq!(master.take(&hello(&mut slave)), Ok(PeerMessage::Met));
    let mut late = Peer::new(MASTER, 11);
    let mut line = [0; FRAME_MAX];
    let answer = slave.busy(&hello(&mut late), &mut line).expect("it fits");
    let answer = &line[..answer.expect("a greeting is answered")];
    assert!(answer.len() < hello(&mut late).len());
    assert_eq!(late.take(answer), Err(PeerError::Busy));
    // Nobody else is moved by it, and nothing but a greeting is answered.
    assert_eq!(master.take(answer), Ok(PeerMessage::Nothing));
    assert!(master.is_connected());
    let mut room = [0; FRAME_MAX];
    assert_eq!(slave.busy(&sample(&mut late), &mut room), Ok(None));
    assert_eq!(slave.busy(b"GET / HTTP/1.1\r\n\0", &mut room), Ok(None));
}

#[test]
fn another_version_and_other_messages_are_named() {
    // A frame of version 5: its first byte and its checksum are others.
    let content = [5, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3];
    let sum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&content);
    let bytes: Vec<u8> = content.into_iter().chain(sum.to_le_bytes()).collect();
    let mut frame = vec![0; cobs::max_encoding_length(bytes.len()) + 1];
    let end = cobs::encode(&bytes, &mut frame);
    frame.truncate(end + 1);
    let error = Peer::new(MASTER, 1).take(&frame);
    assert_eq!(error, Err(PeerError::OtherVersion { version: 5 }));

    let mut receiver = Receiver::<HandMessage>::new(Direction::FromHost);
    let greeting = hello(&mut Peer::new(SLAVE, 2));
    let heard = greeting.iter().find_map(|&byte| receiver.push(byte));
    let Some((_, HandMessage::Hello(fits))) = heard else {
        panic!("a hello");
    };
    let mut line = [0; FRAME_MAX];
    let other = HandMessage::Hello(HandHello {
        key: MessageKey(fits.key.0 ^ 1),
        ..fits
    });
    let length = encode(&other, Header::from_host(1, 0), &mut line).expect("it fits");
    let error = Peer::new(MASTER, 1).take(&line[..length]);
    assert_eq!(error, Err(PeerError::OtherMessages));
}
