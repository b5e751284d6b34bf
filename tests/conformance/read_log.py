#!/usr/bin/env python3
"""Reads a run log with the reference readers and compares it with the CSV exported from it.

    read_log.py LOG.mcap LOG.csv

Needs PyPI `mcap` and `mcap-ros2-support`; no ROS. Neither shares code with host-cli, so agreement
says that Foxglove, PlotJuggler and ROS 2 bag tools read the same numbers.
Exit codes: 0 agrees, 1 differs, 2 wrong usage, 3 packages are missing.
"""

import csv
import struct
import sys
from datetime import datetime, timezone

try:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory
except ImportError as error:
    print(f"Python package missing: {error.name}", file=sys.stderr)
    sys.exit(3)

TICK, EVENT = "/haptics/tick", "/haptics/event"
SCHEMAS = {
    TICK: ["haptics_msgs/msg/Tick", "haptics_msgs/msg/Tick2", "haptics_msgs/msg/Tick3"],
    EVENT: ["haptics_msgs/msg/Event"],
}


def bits(number: float) -> bytes:
    """So that -0.0 differs from 0.0 and NaN equals NaN."""
    return struct.pack("<d", number)


def check(condition: bool, what: str) -> None:
    if not condition:
        sys.exit(f"differs: {what}")


def nanoseconds(rfc3339: str) -> int:
    """Since 1970, of a time in UTC with nine digits of a second."""
    whole, fraction = rfc3339.removesuffix("Z").split(".")
    check(rfc3339.endswith("Z") and len(fraction) == 9, f"start {rfc3339}")
    moment = datetime.fromisoformat(whole).replace(tzinfo=timezone.utc)
    return int(moment.timestamp()) * 10**9 + int(fraction)


def main(log_path: str, csv_path: str) -> None:
    with open(csv_path, newline="") as file:
        rows = list(csv.DictReader(file))
    with open(log_path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        check(header.profile == "ros2", f"profile {header.profile}")
        check(summary is not None, "no summary section")
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            check(channel.message_encoding == "cdr", f"encoding {channel.message_encoding}")
            check(schema.encoding == "ros2msg", f"schema encoding {schema.encoding}")
            check(schema.name in SCHEMAS[channel.topic], f"schema {schema.name}")
        check(summary.statistics.metadata_count >= 1, "no metadata record")

        clock = [record.metadata for record in reader.iter_metadata() if record.name == "clock"]
        check(len(clock) == 1, f"{len(clock)} metadata records named clock")
        started_ns = nanoseconds(clock[0]["started_utc"])

        columns = list(rows[0])
        count = 0
        for _, channel, message, tick in reader.iter_decoded_messages(topics=[TICK]):
            fields = {name: getattr(tick, name) for name in tick.__slots__}
            check(list(fields) == columns, f"fields {list(fields)}, columns {columns}")
            row = rows[count]
            time_ns = started_ns + round(tick.time_s * 1e9)
            check(message.log_time == message.publish_time == time_ns, f"log time of row {count}")
            check(message.sequence == tick.tick % 2**32, f"sequence number of row {count}")
            for name in columns:
                value = fields[name]
                same = (
                    value == int(row[name])
                    if isinstance(value, int)
                    else bits(value) == bits(float(row[name]))
                )
                check(same, f"row {count}, {name}: log {value!r}, CSV {row[name]}")
            count += 1
        check(count == len(rows), f"{count} ticks in the log, {len(rows)} rows in the CSV")
        events = [event for *_, event in reader.iter_decoded_messages(topics=[EVENT])]
        check(all(event.kind and event.text for event in events), "an event without words")
        metadata = [record.name for record in reader.iter_metadata()]
    print(f"agrees: {count} ticks, {len(events)} events, metadata {', '.join(metadata)}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
