#!/usr/bin/env python3
"""The maker's own Python host, HaplyHAPI, on an emulated Haply 2DIY: what it reads, and the torques it sends.

    pip install HaplyHAPI==1.0.1
    python3 tests/conformance/haply_2diy.py PORT VERSION FORCE_X FORCE_Y SECONDS

Prints one JSON object: the angles and the place of the handle at the end, and the torques for that force. HaplyHAPI comes from
PyPI and is used as it is; it states no licence, so nothing of it is copied or passed on. Exit code 3 without it.
"""
import json
import sys
import time

try:
    from HaplyHAPI import Board, Device, Pantograph
except ImportError as missing:
    print(f"{missing}: pip install HaplyHAPI==1.0.1", file=sys.stderr)
    sys.exit(3)

CW, CCW = 0, 1


def main():
    port, version = sys.argv[1], int(sys.argv[2])
    force = [float(sys.argv[3]), float(sys.argv[4])]
    seconds = float(sys.argv[5])
    # As in the maker's example, line by line.
    board = Board("conformance", port, 0)
    device = Device(5, board)
    device.set_mechanism(Pantograph(version))
    if version == 3:
        device.add_actuator(1, CCW, 2)
        device.add_actuator(2, CCW, 1)
        device.add_encoder(1, CCW, 168, 4880, 2)
        device.add_encoder(2, CCW, 12, 4880, 1)
    else:
        device.add_actuator(1, CCW, 2)
        device.add_actuator(2, CW, 1)
        device.add_encoder(1, CCW, 241, 10752, 2)
        device.add_encoder(2, CW, -61, 10752, 1)
    device.device_set_parameters()
    # The maker's example asks before it reads for the first time, and then every millisecond, answered or not: on a busy machine
    # what it reads is older and older. This one asks when it has read. It ends with the second answer to a question of the end:
    # by then the board has the torques of the end too.
    began, answers, angles, place, torques = time.monotonic(), 0, None, None, [0.0, 0.0]
    asked, late_answers = began, 0
    device.device_write_torques()
    while time.monotonic() - began < 120:
        if board.data_available():
            device.device_read_data()
            answers += 1
            angles = device.get_device_angles()
            place = device.get_device_position(angles)
            torques = device.set_device_torques(force)
            late_answers += asked - began >= seconds and answers > 50
            if late_answers == 2:
                break
            asked = time.monotonic()
            device.device_write_torques()
        time.sleep(0.001)
    print(json.dumps({"answers": answers, "angles_deg": angles, "place_m": place, "torques_nm": torques}))


if __name__ == "__main__":
    main()
