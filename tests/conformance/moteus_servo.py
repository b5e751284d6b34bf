#!/usr/bin/env python3
"""The maker's own Python package, moteus, on an emulated servo: query, torque, stop, watchdog.

    pip install moteus==1.1.1
    python3 tests/conformance/moteus_servo.py PORT [ID]

Prints one JSON object with what the package read at each step. The package comes from PyPI and is used as it is. Exit code 3
without it.
"""
import asyncio
import json
import math
import sys

try:
    import moteus
except ImportError as missing:
    print(f"{missing}: pip install moteus==1.1.1", file=sys.stderr)
    sys.exit(3)


def values(result):
    names = {
        "mode": moteus.Register.MODE,
        "position_rev": moteus.Register.POSITION,
        "velocity_rev_per_s": moteus.Register.VELOCITY,
        "torque_nm": moteus.Register.TORQUE,
        "voltage_v": moteus.Register.VOLTAGE,
        "temperature_c": moteus.Register.TEMPERATURE,
        "fault": moteus.Register.FAULT,
    }
    return {name: float(result.values[register]) for name, register in names.items()}


def torque(controller, torque_nm, watchdog_s):
    return controller.set_position(
        position=math.nan,
        feedforward_torque=torque_nm,
        maximum_torque=1.0,
        kp_scale=0.0,
        kd_scale=0.0,
        watchdog_timeout=watchdog_s,
        query=True,
    )


async def main():
    port, number = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1
    controller = moteus.Controller(id=number, transport=moteus.Fdcanusb(port))
    seen = {}
    await controller.set_stop()
    seen["stopped"] = values(await controller.query())
    # A torque that the watchdog does not end: it outlives whatever this machine is late by.
    seen["driven"] = values(await torque(controller, 0.0125, math.nan))
    for _ in range(20):
        await asyncio.sleep(0.005)
        seen["turning"] = values(await torque(controller, 0.0125, math.nan))
    # Integers of every width.
    wide = moteus.QueryResolution()
    wide.mode, wide.position, wide.velocity, wide.torque = (moteus.INT16, moteus.INT32, moteus.INT16, moteus.INT32)
    wide.voltage = wide.temperature = moteus.INT16
    seen["integers"] = values(await controller.query(query_override=wide))
    read = await controller.custom_query({0x020: moteus.F32, 0x022: moteus.F32, 0x025: moteus.F32, 0x102: moteus.INT32})
    seen["registers"] = {hex(int(key)): float(value) for key, value in read.values.items() if not math.isnan(value)}
    seen["stopped_again"] = values(await controller.set_stop(query=True))
    await torque(controller, 0.0125, 0.05)
    await asyncio.sleep(0.3)
    seen["silent"] = values(await controller.query())
    # Only a stop leads out of a timeout.
    seen["refused"] = values(await torque(controller, 0.0125, 0.05))
    await controller.set_stop()
    seen["last"] = values(await controller.query())
    print(json.dumps(seen))


if __name__ == "__main__":
    asyncio.run(main())
