#!/usr/bin/env python3
"""Makes the logs of others in this folder: python3 make_logs.py (pip install mcap mcap-ros1-support mcap-ros2-support mcap-protobuf-support).

A ramp of 1 mm in 0.2 s and a hold on a spring-pot of 1000 Pa·s^0.2, order 0.2, 4 cm2 and 20 mm, as forces; and the step
response of 2/(0.5 s + 1). Numbers are ours; the bytes are those of the public packages.
"""
import json
import math

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.writer import CompressionType, Writer
from mcap_protobuf.writer import Writer as ProtobufWriter
from mcap_ros1._vendor.genpy import dynamic
from mcap_ros1.writer import Writer as Ros1Writer
from mcap_ros2.writer import Writer as Ros2Writer

START_NS = 1_700_000_000_000_000_000
TIMES_S = [0.02 * n for n in range(60)]
RAMP_S, DEPTH_M = 0.2, 1e-3


def depth_m(t):
    return DEPTH_M * min(t / RAMP_S, 1.0)


def force_n(t):
    """The area times the stress of a spring-pot under a ramp of strain, then a hold."""
    ages = (t, max(t - RAMP_S, 0.0))
    powers = [age**0.8 / math.gamma(1.8) for age in ages]
    return 4e-4 * 1000.0 * (DEPTH_M / 0.02 / RAMP_S) * (powers[0] - powers[1])


STEPS_S = [0.05 * n for n in range(80)]

SEPARATOR = "=" * 80 + "\n"
HEADER = "builtin_interfaces/Time stamp\nstring frame_id\n"
TIME = "int32 sec\nuint32 nanosec\n"
WRENCH = (
    "# A wrench with its time.\nstd_msgs/Header header\nWrench wrench\nfloat64 depth_mm\n"
    + SEPARATOR
    + "MSG: std_msgs/Header\n"
    + HEADER
    + SEPARATOR
    + "MSG: builtin_interfaces/Time\n"
    + TIME
    + SEPARATOR
    + "MSG: geometry_msgs/Wrench\nVector3 force\nVector3 torque\n"
    + SEPARATOR
    + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y 0\nfloat64 z\n"
)
JOINTS = (
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nuint8 KIND = 3\nint16[2] counts\nbool is_on\nfloat32 current\n"
    + SEPARATOR
    + "MSG: std_msgs/Header\n"
    + HEADER
    + SEPARATOR
    + "MSG: builtin_interfaces/Time\n"
    + TIME
)


def stamp(time_s):
    """Seconds and nanoseconds since 1970."""
    ns = START_NS + round(1e9 * time_s)
    return {"sec": ns // 10**9, "nanosec": ns % 10**9}


def header(time_s):
    return {"stamp": stamp(time_s), "frame_id": "tool" if time_s < 1 else "to"}


def ros2(path):
    """Two topics: a wrench whose recording is late by 3 ms, and joints with arrays of several lengths."""
    with open(path, "wb") as file, Ros2Writer(file) as log:
        wrench = log.register_msgdef("geometry_msgs/msg/WrenchStamped", WRENCH)
        joints = log.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
        for n, t in enumerate(TIMES_S):
            recorded = START_NS + round(1e9 * t) + 3_000_000 * (n % 2)
            message = {
                "header": header(t),
                "wrench": {"force": {"x": 0.0, "y": -1.5, "z": force_n(t)}, "torque": {"x": 0.0, "y": 0.0, "z": 0.0}},
                "depth_mm": 1e3 * depth_m(t),
            }
            log.write_message("/wrench", wrench, message, recorded, recorded, n)
            if n < 5:
                message = {
                    "header": header(t),
                    "name": ["a"] * n,
                    "position": [0.5 * n] * n,
                    "counts": [-n, 300 * n],
                    "is_on": n % 2 == 1,
                    "current": 0.25 * n,
                }
                log.write_message("/joints", joints, message, recorded, recorded, n)


def ros1(path):
    """The same wrench in the words and bytes of ROS 1, as converted bags have it."""
    definition = (
        "Header header\nWrench wrench\nuint8 kind\nfloat64 depth_mm\n"
        + SEPARATOR
        + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
        + SEPARATOR
        + "MSG: lab/Wrench\nVector3 force\nfloat32[] torque\n"
        + SEPARATOR
        + "MSG: lab/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    )
    kinds = dynamic.generate_dynamic("lab/WrenchStamped", definition)
    with open(path, "wb") as file:
        log = Ros1Writer(file)
        for n, t in enumerate(TIMES_S):
            message = kinds["lab/WrenchStamped"]()
            at = stamp(t)
            message.header.seq, message.header.frame_id = n, "tool" * (n % 3)
            message.header.stamp.secs, message.header.stamp.nsecs = at["sec"], at["nanosec"]
            message.wrench.force.y, message.wrench.force.z = -1.5, force_n(t)
            message.wrench.torque = [0.5 * n] * (n % 3)
            message.kind, message.depth_mm = 7, 1e3 * depth_m(t)
            log.write_message("/wrench", message, START_NS + round(1e9 * t))
        log.finish()


def as_json(path, set_back_ns=0):
    """One topic, a plant's step, with text, a truth, a nested object and an array; the recorder's clock may be set back half-way."""
    with open(path, "wb") as file:
        log = Writer(file, compression=CompressionType.LZ4)
        log.start()
        schema = log.register_schema("plant", "jsonschema", json.dumps({"type": "object"}).encode())
        channel = log.register_channel("/plant", "json", schema)
        for n, t in enumerate(STEPS_S):
            message = {
                "u": 1.0,
                "y": 2.0 * (1.0 - math.exp(-t / 0.5)),
                "mode": "auto",
                "ok": True,
                "gains": [1.5, 2],
                "motor": {"current": n, "text": None},
            }
            at = START_NS + round(1e9 * t) - (set_back_ns if n >= 40 else 0)
            log.add_message(channel, at, json.dumps(message).encode(), at, n)
        log.finish()


def protobuf(path):
    """A topic with a zero that is left out, an array, an optional number and a stamp."""
    field = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(name="probe.proto", package="lab", syntax="proto3")
    stamp_type = file.message_type.add(name="Stamp")
    stamp_type.field.add(name="seconds", number=1, label=1, type=field.TYPE_INT64)
    stamp_type.field.add(name="nanos", number=2, label=1, type=field.TYPE_INT32)
    probe = file.message_type.add(name="Probe")
    probe.field.add(name="stamp", number=1, label=1, type=field.TYPE_MESSAGE, type_name=".lab.Stamp")
    probe.field.add(name="depth", number=2, label=1, type=field.TYPE_DOUBLE)
    probe.field.add(name="force", number=3, label=1, type=field.TYPE_FLOAT)
    probe.field.add(name="count", number=4, label=1, type=field.TYPE_SINT32)
    probe.field.add(name="raw", number=5, label=3, type=field.TYPE_INT32)
    probe.field.add(name="note", number=6, label=1, type=field.TYPE_STRING)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName("lab.Probe"))
    with open(path, "wb") as out, ProtobufWriter(out) as log:
        for n in range(30):
            message = kind(depth=1e-4 * n, force=0.5 * n, count=-n, raw=[n, -2 * n], note="x" * (n % 3))
            ns = START_NS + 1_000_000 * n
            message.stamp.seconds, message.stamp.nanos = ns // 10**9, ns % 10**9
            log.write_message("/probe", message, ns, ns, n)


if __name__ == "__main__":
    ros1("ros1.mcap")
    ros2("ros2.mcap")
    as_json("json.mcap")
    as_json("set-back.mcap", 10**9)
    protobuf("protobuf.mcap")
