#!/usr/bin/env python3
"""Writes other_records.csv and other_records_best.csv: records of plants as others make them, and the least residual that SciPy finds for each.

    y = c + G·(u − u_p) + Σ x_i·r_i(t),   G of a given number of poles and zeros behind a dead time, u held from stamp to stamp

Each record is made of its modes; the objective runs each pole by itself and projects everything that is linear: residues, direct path, c, u_p, x_i.
The poles and the dead time are searched by scipy.optimize.least_squares from 40 starts. Needs NumPy and SciPy.
"""
import numpy as np
from scipy.optimize import least_squares

RECORDS = {
    # name: poles (rad/s), residues, direct, dead time, offset, first states ("settled at" or values), jitter, reading after
    "lag-offset": ([-0.05], [0.1], 0.0, 3.0, 20.0, [0.0], 0.0),
    "lag-jitter": ([-0.04], [0.08], 0.0, 0.0, 5.0, [0.0], 0.05),
    "two-moving": ([-0.03, -0.12], [0.06, -0.06], 0.0, 0.0, -3.0, [15.0, -4.0], 0.05),
    "lead-at-once": ([-0.06], [0.03], 0.5, 0.0, 1.0, [4.0], 0.0),
    "swing-moving": ([-0.03 + 0.15j], [-0.05j], 0.0, 0.0, 0.0, [3.0], 0.05),
}
SAMPLES = 150


def response(pole, time, inputs, late, first=0.0):
    """The state of ẋ = px + u at these times."""
    switches = time + late
    out, x, now, acts, k = [], first + 0j, time[0], 0.0, 0
    for t in time:
        while k < len(time) and switches[k] < t:
            h = switches[k] - now
            x = np.exp(pole * h) * x + acts * np.expm1(pole * h) / pole
            now, acts, k = switches[k], inputs[k], k + 1
        h = t - now
        x = np.exp(pole * h) * x + acts * np.expm1(pole * h) / pole
        now = t
        out.append(x)
    return np.array(out)


def made(name, rng):
    poles, residues, direct, late, offset, first, jitter = RECORDS[name]
    time = np.arange(SAMPLES) + jitter * rng.uniform(-1, 1, SAMPLES)
    inputs = np.zeros(SAMPLES)
    level = 0.5
    for n in range(SAMPLES):
        if rng.random() < 0.06:
            level = rng.uniform(-1, 1)
        inputs[n] = level
    output = offset + direct * inputs
    for pole, residue, x in zip(poles, residues, first):
        output = output + (residue * response(pole, time, inputs, late, x)).real
    output = output + 0.01 * np.max(np.abs(output - output.mean())) * rng.standard_normal(SAMPLES)
    return [np.array([float(f"{value:.9g}") for value in row]) for row in (time, inputs, output)]


def columns(parameters, shape, time, inputs):
    """Everything that is linear, for poles in pairs (sum, product) or alone."""
    poles, prompt, has_late, moves = shape
    late = abs(parameters[-1]) if has_late else 0.0
    if poles == 2:
        roots = np.roots([1.0, np.exp(parameters[0]), np.exp(parameters[1])]).astype(complex)
    else:
        roots = np.array([-np.exp(parameters[0])], dtype=complex)
    rows = [np.ones_like(time)]
    for pole in roots[: 1 if roots[0].imag != 0 else poles]:
        forced = response(pole, time, inputs, late)
        free = np.exp(pole * (time - time[0]))
        for row in (forced, free) if moves else (forced,):
            rows.append(row.real)
            if pole.imag != 0:
                rows.append(row.imag)
    if prompt:
        rows.append(inputs)
    return np.array(rows).T


def residual(parameters, shape, time, inputs, output):
    matrix = columns(parameters, shape, time, inputs)
    if not np.all(np.isfinite(matrix)):
        return np.full_like(output, 1e6)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    found = np.linalg.lstsq(matrix / scale, output, rcond=None)[0]
    return matrix / scale @ found - output


def best(shape, time, inputs, output, rng):
    least = np.inf
    for _ in range(40):
        first = rng.uniform(-5, -1, shape[0])
        if shape[0] == 2:
            first[1] += first[0]
        if shape[2]:
            first = np.append(first, rng.uniform(0, 10))
        ran = least_squares(residual, first, args=(shape, time, inputs, output), xtol=1e-12, ftol=1e-12, gtol=1e-12)
        least = min(least, np.sqrt(np.mean(ran.fun**2)))
    return least


# Poles, answers at once, has a dead time, moves when the record begins.
SHAPES = {
    "lag-offset": (1, False, True, False),
    "lag-jitter": (1, False, False, False),
    "two-moving": (2, False, False, True),
    "lead-at-once": (1, True, False, True),
    "swing-moving": (2, False, False, True),
}


def main():
    rng = np.random.default_rng(58)
    with open("other_records.csv", "w") as rows, open("other_records_best.csv", "w") as bests:
        rows.write("record,time_s,input,output\n")
        bests.write("record,poles,at_once,late,moves,rms_residual\n")
        for name, shape in SHAPES.items():
            time, inputs, output = made(name, rng)
            for cells in zip(time, inputs, output):
                rows.write(name + "," + ",".join(f"{cell:.9g}" for cell in cells) + "\n")
            least = best(shape, time, inputs, output, rng)
            bests.write(f"{name},{shape[0]}," + ",".join(str(int(flag)) for flag in shape[1:]) + f",{least:.9g}\n")


if __name__ == "__main__":
    main()
