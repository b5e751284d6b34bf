#!/usr/bin/env python3
"""A host for haptic devices in plain Python, written from crates/haptic-link/protocol.md: take it as an example.

    client.py PORT --hello
    client.py PORT --samples 10000 --stiffness 500 --push 1

The first says hello and tells what the device is; nothing is set, nothing moves. The second sets the parameters of
a device, reads them back, runs its loop, records every tick, and compares the forces with the law. Each prints one
JSON object. Needs nothing but Python 3.8 or later on a system with termios.
Exit codes: 0 done, 1 the device, the line or the forces are not as they should be.
"""

import argparse
import collections
import json
import operator
import os
import random
import select
import socket
import stat
import struct
import sys
import termios
import time
import zlib

FROM_HOST, FROM_DEVICE = 0x02, 0x82
# Keys of the messages that are used here, by their numbers; others may change.
REQUEST_KEYS = {0: 0xEA059449, 1: 0xAF5AAF58, 2: 0x786B87AB, 3: 0xD64D3415, 4: 0xFE3E4473, 5: 0x5F950ADB, 6:
                0x49AD326F, 7: 0x80892389, 8: 0x6DB3EADF, 9: 0x34E32396, 12: 0x54DE2568, 13: 0xE4D4C71D, 16:
                0xB7C92CEF}
REPORT_KEYS = {0: 0xC2B7320C, 1: 0x749B5261, 2: 0x3E9AD9F8, 3: 0xFACF7DE3, 4: 0x21201806, 5: 0x9B4CF31F, 6:
               0x47E8A9FB, 8: 0x66BD3387, 9: 0xA4362A23, 10: 0x1B05F339, 12: 0x65196196}
RETRY_S, TRIES = 0.15, 10
HELLO_TRIES = 24  # 3.5 s, for ports that notice late that somebody listens
FRAME_MAX = 256

# Requests.
(HELLO, GET_CAPABILITIES, CONFIGURE, COEFFICIENTS, COMMIT, GET_CONFIGURATION, GET_COEFFICIENTS, ARM,
 DISARM, START, STOP, FORCE, KEEP_ALIVE, GET_STATISTICS, READ_FLIGHT, STREAM, GET_KEYS) = range(17)
# Reports.
ACK, SAMPLE, BATCH, EVENT, FAULT, ALIVE, KEYS = 2, 5, 6, 7, 8, 10, 12
# The report that answers a request; an ack answers all others.
ANSWERS = {HELLO: 0, GET_CAPABILITIES: 1, GET_CONFIGURATION: 3, GET_COEFFICIENTS: 4, GET_STATISTICS: 9,
           READ_FLIGHT: 11, GET_KEYS: KEYS}
LENGTHS = {0: 61, 1: 56, 4: 67, 5: 25, 7: 14, 8: 26, 9: 77, 10: 30, 11: 29}  # with one axis and no force sensor
REFUSALS = (("State", "<B"), ("Range", "<Bfff"), ("Digest", "<"), ("Incomplete", "<"), ("Unsupported", "<B"),
            ("UnknownFault", "<"), ("ForceNotZero", "<"), ("ForceNotSmall", "<ff"), ("FaultPersists", "<B"),
            ("Connection", "<"), ("Looser", "<B"))
FOR_A_RUN, LASTING = 0, 1
IDLE, ARMED, RUNNING, STOPPING, IN_FAULT = range(5)

CONFIGURATION = struct.Struct("<BIfff?fBbHffHHHffffffffffffBfffBfffffffBfffffffffIB")
CONFIGURATION_FIELDS = (
    "loop_mode tick_period_us stiffness_n_per_m dissipation_n_s_mu_per_m order one_sided surface_m form integer "
    "count force_n force_rate_n_per_s watchdog_ms late_ticks max_age_ticks start_force_n rise_time_s workspace_low_m "
    "workspace_high_m workspace_soft_m speed_soft_m_per_s speed_hard_m_per_s velocity_bandwidth_hz braking_n_s_per_m "
    "stop_time_s brake_force_n device_mass_kg device_delay_ticks stuck_force_n stuck_time_s jump_m guard "
    "guard_damping_n_s_per_m guard_share guard_forget_s guard_delay_least_samples guard_delay_most_samples "
    "guard_lag_s guard_noise_m simulation mass_kg "
    "damping_n_s_per_m hand_stiffness_n_per_m push_n depth_m ramp_time_s start_ticks own_push_n tap_n tap_ticks maps").split()
DEPTH_MAP = struct.Struct("<8f")  # follows if maps is 1
CAPABILITIES = struct.Struct("<16sB?IIffffHHHHI?")
STATISTICS = ("ticks overruns tick_cycles_max tick_cycles_last stale_forces samples_dropped sent received corrupt "
              "oversize foreign lost duplicate late bytes_overrun strangers unanswered forces_not_taken "
              "period_ns").split()
Sample = collections.namedtuple("Sample", "tick time_us position_m environment_force_n force_n limiters flaws")
# Of the reason of a fault, in a program that is a device, only the room is used here.
STATUS = "BBH9x"
Status = collections.namedtuple("Status", "state fault faults")


class LinkError(Exception):
    """The device refused, did not answer, or is not what it should be."""


def cobs_encode(content):
    """Each piece between zeros with its length + 1 before it; no content here has 254 bytes without a zero."""
    return b"".join(bytes([len(piece) + 1]) + piece for piece in content.split(b"\0"))


def cobs_decode(line):
    """None if it is no COBS."""
    content, at = bytearray(), 0
    while at < len(line):
        code = line[at]
        if at + code > len(line):
            return None
        content += line[at + 1:at + code]
        at += code
        if code < 0xFF and at < len(line):
            content.append(0)
    return bytes(content)


def well_formed(message):
    """Whether the message is known and as long as it should be."""
    number, length = message[0], len(message)
    if number == BATCH:
        at = 13 + 14 * message[12] if length > 13 else length
        return length > at and message[at] in (0, message[12]) and length == at + 1 + 4 * message[at]
    if number == KEYS:
        requests = message[1] if length > 1 else 255
        at = 2 + 4 * requests
        return requests < 128 and length > at and message[at] < 128 and length == at + 1 + 4 * message[at]
    if number == ACK:
        if length < 6 or message[4] == 0:
            return length == 5 and message[4] == 0
        return message[5] < len(REFUSALS) and length == 6 + struct.calcsize(REFUSALS[message[5]][1])
    if number == ANSWERS[GET_CONFIGURATION]:
        return length - 5 - CONFIGURATION.size in (0, DEPTH_MAP.size)
    if number in (SAMPLE, ANSWERS[READ_FLIGHT]) and length == LENGTHS[number] + 4:
        return message[LENGTHS[number] - 1] == 1  # the force at a sensor, which is not used here
    return LENGTHS.get(number) == length


def opened(path, baud):
    """A serial port set up for bytes; or a Unix socket, where an emulator listens at one."""
    if stat.S_ISSOCK(os.stat(path).st_mode):
        line = socket.socket(socket.AF_UNIX)
        line.connect(path)
        return line.detach()
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    speed, control = getattr(termios, f"B{baud}"), termios.tcgetattr(port)[6]
    control[termios.VMIN] = control[termios.VTIME] = 0
    raw = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0, speed, speed, control]
    termios.tcsetattr(port, termios.TCSAFLUSH, raw)
    return port


class Device:
    """A device at the other end of a line. Everything happens in `poll`; there is no thread."""

    def __init__(self, path, baud=460800):
        self.port = opened(path, baud)
        self.rest, self.number, self.connection, self.last, self.late_run = b"", 0, 0, None, (None, 0)
        self.awaited, self.answer = None, None
        self.keep_alive_s, self.keep_alive_due, self.token = None, 0.0, 0
        self.status, self.device_time_us, self.samples = Status(IDLE, 0, 0), 0, []
        self.counters = dict.fromkeys("received corrupt oversize foreign lost duplicate late retries".split(), 0)
        os.write(self.port, b"\0")  # ends what somebody else may have begun

    # Frames

    def send(self, request, fields=b""):
        """Sends a request and returns its sequence number."""
        number, self.number = self.number, (self.number + 1) & 0xFFFFFFFF
        connection = 0 if request == HELLO else self.connection
        content = struct.pack("<BIIB", FROM_HOST, number, connection, request) + fields
        content += struct.pack("<I", zlib.crc32(content))
        os.write(self.port, cobs_encode(content) + b"\0")
        return number

    def poll(self, until):
        """Receives until this time, or until something came; sends the keep-alive that is due."""
        now = time.monotonic()
        if self.keep_alive_s and now >= self.keep_alive_due:
            self.keep_alive_due = now + self.keep_alive_s
            self.token += 1
            self.send(KEEP_ALIVE, struct.pack("<I", self.token & 0xFFFFFFFF))
        if self.keep_alive_s:
            until = min(until, self.keep_alive_due)
        if select.select([self.port], [], [], max(0.0, until - now))[0]:
            *frames, rest = (self.rest + os.read(self.port, 65536)).split(b"\0")
            self.rest = rest[:FRAME_MAX + 1]
            for frame in filter(None, frames):
                self.receive(frame)

    def receive(self, frame):
        """Checks a frame; acts on it if it is good and new."""
        if len(frame) > FRAME_MAX:
            self.counters["oversize"] += 1
            return
        content = cobs_decode(frame)
        if content is None or len(content) < 8 or struct.pack("<I", zlib.crc32(content[:-4])) != content[-4:]:
            self.counters["corrupt"] += 1
            return
        version, number = struct.unpack_from("<BH", content)
        message = content[3:-4]
        if version != FROM_DEVICE:
            self.counters["foreign"] += 1
        elif not well_formed(message):
            self.counters["corrupt"] += 1
        else:
            self.counters["received"] += 1
            if self.is_new(number, message[0]):
                self.act(message)

    def is_new(self, number, report):
        """The rules of sequence numbers."""
        if self.last is None or (report == ANSWERS[HELLO] and self.awaited and self.awaited[0] == HELLO):
            self.last, self.late_run = number, (None, 0)
            return True
        ahead = (number - self.last) & 0xFFFF
        if ahead == 0:
            self.counters["duplicate"] += 1
            return False
        if ahead < 0x8000:
            self.counters["lost"] += ahead - 1
            self.last, self.late_run = number, (None, 0)
            return True
        self.counters["late"] += 1
        before, run = self.late_run
        run = run + 1 if before is not None and number == (before + 1) & 0xFFFF else 1
        self.late_run = (number, run)
        if run == 8:
            self.last, self.late_run = number, (None, 0)
        return run == 8

    def act(self, message):
        report = message[0]
        if self.awaited and self.answers(message):
            self.answer, self.awaited = message, None
        elif report == SAMPLE:
            tick, time_us, _, *item = struct.unpack_from("<IIBfffBB", message, 1)
            self.samples.append(Sample(tick, time_us, *item))
        elif report == BATCH:
            tick, time_us, every = struct.unpack_from("<IIH", message, 1)
            for n, item in enumerate(struct.iter_unpack("<fffBB", message[13:13 + 14 * message[12]])):
                # Times of a batch follow from its first; here only the ticks are used.
                self.samples.append(Sample(tick + n * every, time_us, *item))
        elif report == FAULT:
            self.status = Status._make(struct.unpack_from("<" + STATUS, message, 1))
        elif report == ALIVE:
            _, time_us, *status = struct.unpack_from("<IQ" + STATUS, message, 1)  # then the energy that the guard observed
            self.device_time_us, self.status = time_us, Status._make(status)
        elif report == ACK and message[4] and REFUSALS[message[5]][0] == "Connection":
            raise LinkError("the device does not know this connection any more: it was reset, or another host came")

    def answers(self, message):
        """Whether this is the answer that is awaited."""
        request, numbers, fields = self.awaited
        if message[0] == ACK:
            number, about = struct.unpack_from("<HB", message, 1)
            return about == request and number in (known & 0xFFFF for known in numbers)
        if message[0] != ANSWERS.get(request):
            return False
        # These answers say to which of several questions.
        if request == HELLO:
            return message[1:5] == fields
        return request not in (GET_COEFFICIENTS, READ_FLIGHT) or message[1:3] == fields

    def ask(self, request, fields=b""):
        """Sends a request until it is answered; returns the answer."""
        numbers = []
        for attempt in range(HELLO_TRIES if request == HELLO else TRIES):
            self.counters["retries"] += attempt > 0
            numbers.append(self.send(request, fields))
            self.awaited, self.answer = (request, numbers, fields), None
            deadline = time.monotonic() + RETRY_S
            while self.answer is None and time.monotonic() < deadline:
                self.poll(deadline)
            answer = self.answer
            if answer is not None:
                if answer[0] == ACK and answer[4]:
                    name, layout = REFUSALS[answer[5]]
                    raise LinkError(f"request {request} refused: {name} {struct.unpack_from(layout, answer, 6)}")
                return answer
        raise LinkError(f"no answer to request {request}")

    # Requests

    def hello(self):
        """Begins a session, and brings a device that was left running to rest."""
        answer = self.ask(HELLO, struct.pack("<I", random.getrandbits(32)))
        fields = struct.unpack_from("<IIBBBI" + STATUS + "32s", answer, 1)
        _, self.connection, *version, boot, state, fault, faults, serial_number = fields
        version = ".".join(map(str, version))
        answer = self.ask(GET_KEYS)
        requests = struct.unpack_from(f"<{answer[1]}I", answer, 2)
        reports = struct.unpack_from(f"<{answer[2 + 4 * answer[1]]}I", answer, 3 + 4 * answer[1])
        for known, used in (requests, REQUEST_KEYS), (reports, REPORT_KEYS):
            for number, key in used.items():
                if number >= len(known) or known[number] != key:
                    raise LinkError(f"firmware {version} has another message {number} than crates/haptic-link/protocol.md")
        self.status, self.device_time_us = Status(state, fault, faults), 0
        if state not in (IDLE, IN_FAULT):
            self.ask(DISARM)
            self.keep_alive_s = 0.01
            self.wait(lambda: self.status.state == IDLE, 5.0)
            self.keep_alive_s = None
        return {"firmware": version, "boot": boot, "serial_number": serial_number.rstrip(b"\0").decode() or None}

    def capabilities(self):
        name, axes, simulated, least, most, force, *_ = CAPABILITIES.unpack(self.ask(GET_CAPABILITIES)[1:])
        return {"board": name.rstrip(b"\0").decode(), "axes": axes, "simulated": simulated,
                "tick_period_us": [least, most], "force_max_n": force}

    def configuration(self):
        """What is in force: the fields, the coefficients, the digest."""
        answer = self.ask(GET_CONFIGURATION)
        end = 1 + CONFIGURATION.size
        fields = dict(zip(CONFIGURATION_FIELDS, CONFIGURATION.unpack(answer[1:end])))
        if fields["maps"]:
            fields["depth_map"] = DEPTH_MAP.unpack_from(answer, end)
            end += DEPTH_MAP.size
        coefficients = []
        for offset in range(0, fields["count"], 16):
            block = self.ask(GET_COEFFICIENTS, struct.pack("<H", offset))
            coefficients += struct.unpack_from("<16f", block, 3)
        return fields, coefficients[:fields["count"]], struct.unpack_from("<I", answer, end)[0]

    def configure(self, fields, coefficients, scope=LASTING):
        """Sets everything in one transaction and returns its digest. For a run no limit may be looser than before."""
        packed = CONFIGURATION.pack(*(dict(fields, count=len(coefficients))[name] for name in CONFIGURATION_FIELDS))
        packed += DEPTH_MAP.pack(*fields["depth_map"]) if fields["maps"] else b""
        self.ask(CONFIGURE, packed)
        for offset in range(0, len(coefficients), 16):
            block = (list(coefficients[offset:offset + 16]) + [0.0] * 16)[:16]
            self.ask(COEFFICIENTS, struct.pack("<H16f", offset, *block))
        digest = zlib.crc32(packed + struct.pack(f"<{len(coefficients)}f", *coefficients))
        self.ask(COMMIT, struct.pack("<IB", digest, scope))
        return digest

    def run(self, ticks, watchdog_ms, batch=1):
        """Arms, runs the loop for so many ticks, disarms; returns the samples of the run."""
        # Four in the watchdog time are enough; on a bad line, or an emulator faster than the clock, more are better.
        self.keep_alive_s = min(watchdog_ms / 4e3, 0.01)
        self.ask(ARM, struct.pack("<H", self.status.faults))
        self.samples = []
        self.ask(START, struct.pack("<IIHB", int(time.time()) & 0xFFFFFFFF, ticks, 1, batch))
        self.status = self.status._replace(state=RUNNING)  # an `alive` from before still said Armed
        # The event that a run has ended may be lost; keep-alives tell it too.
        self.wait(lambda: self.status.state not in (RUNNING, STOPPING), float("inf"))
        quiet = time.monotonic() + 0.1  # answers overtake samples that wait to be sent
        self.wait(lambda: time.monotonic() > quiet, 1.0)
        if self.status.state == IN_FAULT:
            raise LinkError(f"fault {self.status.fault}")
        self.ask(DISARM)
        self.keep_alive_s = None
        return [sample for sample in self.samples if sample.tick < ticks]

    def wait(self, condition, patience_s):
        deadline = time.monotonic() + patience_s
        while not condition():
            if time.monotonic() > deadline:
                raise LinkError("the device does not come to rest")
            self.poll(time.monotonic() + 0.05)

    def statistics(self):
        return dict(zip(STATISTICS, struct.unpack_from("<19I", self.ask(GET_STATISTICS), 1)))


def float32(number):
    """Rounded to single precision, as the device computes."""
    return struct.unpack("<f", struct.pack("<f", number))[0]


def grunwald(order, period_s, count):
    """Weights of D^order: k_0 = T^(-order), k_j = k_(j-1)·(j - 1 - order)/j."""
    weights = [period_s ** -order]
    for j in range(1, count):
        weights.append(weights[-1] * (j - 1 - order) / j)
    return weights


def largest_error(samples, stiffness, dissipation, weights):
    """Largest |force - law|, N. A spring alone is compared sample by sample, bit for bit; with a fractional
    damper the law needs all samples, and is computed in double precision."""
    window, largest = collections.deque(maxlen=len(weights)), 0.0
    for sample in samples:
        law = -float32(stiffness * sample.position_m)
        if dissipation:
            window.appendleft(sample.position_m)
            law = -(stiffness * sample.position_m + dissipation * sum(map(operator.mul, weights, window)))
        largest = max(largest, abs(sample.environment_force_n - law))
        if sample.limiters == 0:
            largest = max(largest, abs(sample.force_n - sample.environment_force_n))
    return largest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("port")
    parser.add_argument("--baud", type=int, default=460800)
    parser.add_argument("--hello", action="store_true", help="only tell what the device is")
    parser.add_argument("--samples", type=int, default=10000, help="ticks of the run")
    parser.add_argument("--stiffness", type=float, default=500.0, help="K, N/m")
    parser.add_argument("--dissipation", type=float, default=0.0, help="B, N·s^μ/m")
    parser.add_argument("--order", type=float, default=0.5, help="μ")
    parser.add_argument("--taps", type=int, default=40, help="weights of the operator D^μ")
    parser.add_argument("--push", type=float, default=1.0, help="push of the hand on a simulated device, N")
    parser.add_argument("--watchdog-ms", type=int, default=500)
    parser.add_argument("--batch", type=int, default=1, help="samples in a frame, 1 to 16")
    given = parser.parse_args()

    device = Device(given.port, given.baud)
    summary = {**device.hello(), **device.capabilities()}
    if given.hello:
        print(json.dumps(summary))
        return
    fields, _, _ = device.configuration()
    weights = grunwald(given.order, fields["tick_period_us"] * 1e-6, given.taps) if given.dissipation else [0.0]
    fields.update(loop_mode=0, one_sided=False, stiffness_n_per_m=float32(given.stiffness), form=0, integer=0,
                  dissipation_n_s_mu_per_m=float32(given.dissipation), order=float32(given.order), count=len(weights),
                  watchdog_ms=given.watchdog_ms, push_n=float32(given.push),
                  rise_time_s=0.0)  # a force that rises first would not be that of the law
    weights = [float32(weight) for weight in weights]
    digest = device.configure(fields, weights)
    if device.configuration() != (fields, weights, digest):
        raise LinkError("the parameters read back are not those that were set")

    samples = device.run(given.samples, given.watchdog_ms, given.batch)
    if [s.tick for s in samples] != sorted({s.tick for s in samples}):
        raise LinkError("a sample came twice, or before an earlier one")
    lost = given.samples - len(samples)
    summary.update(samples=len(samples), lost_ticks=lost, limited=sum(s.limiters != 0 for s in samples),
                   final_position_m=samples[-1].position_m, link=device.counters, device=device.statistics())
    if lost == 0 or not given.dissipation:
        summary["largest_force_error_n"] = largest_error(
            samples, float32(given.stiffness), float32(given.dissipation), weights)
    print(json.dumps(summary))


if __name__ == "__main__":
    try:
        main()
    except (LinkError, OSError) as error:
        sys.exit(f"{sys.argv[0]}: {error}")
