#!/usr/bin/env python3
"""Golden values of the pantograph: the hand by root finding, not by the closed form, and its derivatives.

The hand P solves |P - A|^2 = |P - B|^2 = L^2; Newton's method from a point on the side of +90 degrees from AB finds it
with 40 digits. The Jacobian is a central difference of such roots, with 40 digits its error is below 1e-20.

    pip install mpmath && python3 make_pantograph_golden.py > pantograph.csv
"""

import random

import mpmath as mp

mp.mp.dps = 40
NEAR, FAR = mp.mpf("0.07"), mp.mpf("0.09")
STEP = mp.mpf(10) ** -12
BASES = {2: mp.mpf(0), 3: mp.mpf("0.038")}
ROWS = 150


def elbows(base, angles):
    first, second = angles
    a = (NEAR * mp.cos(first), NEAR * mp.sin(first))
    b = (base + NEAR * mp.cos(second), NEAR * mp.sin(second))
    return a, b


def hand(base, angles):
    (ax, ay), (bx, by) = elbows(base, angles)
    start = ((ax + bx) / 2 - (by - ay) / 2, (ay + by) / 2 + (bx - ax) / 2)
    equations = lambda x, y: (
        (x - ax) ** 2 + (y - ay) ** 2 - FAR**2,
        (x - bx) ** 2 + (y - by) ** 2 - FAR**2,
    )
    x, y = mp.findroot(equations, start, tol=mp.mpf(10) ** -60)
    assert (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0, "the other side of AB"
    return x, y


def sines(base, angles):
    """Between the far arms, and at both elbows."""
    x, y = hand(base, angles)
    (ax, ay), (bx, by) = elbows(base, angles)
    far = abs((x - ax) * (y - by) - (y - ay) * (x - bx)) / FAR**2
    at = lambda ex, ey, o: abs((x - ex) * ey - (y - ey) * (ex - o)) / (NEAR * FAR)
    return far, at(ax, ay, mp.mpf(0)), at(bx, by, base)


def main():
    random.seed(2046)
    print("version,theta_1_rad,theta_2_rad,x_m,y_m,j11,j12,j21,j22")
    for version, base in BASES.items():
        rows = 0
        while rows < ROWS:
            # Angles that a double holds exactly.
            angles = [mp.mpf(random.uniform(1.2, 4.3)), mp.mpf(random.uniform(-1.2, 1.9))]
            (ax, ay), (bx, by) = elbows(base, angles)
            if bx <= ax or mp.hypot(bx - ax, by - ay) > mp.mpf("1.97") * FAR:
                continue
            far, first, second = sines(base, angles)
            if far < 0.12 or min(first, second) < 0.03:
                continue
            x, y = hand(base, angles)
            columns = []
            for i in range(2):
                plus, minus = list(angles), list(angles)
                plus[i] += STEP
                minus[i] -= STEP
                columns.append([(p - m) / (2 * STEP) for p, m in zip(hand(base, plus), hand(base, minus))])
            numbers = [*angles, x, y, columns[0][0], columns[1][0], columns[0][1], columns[1][1]]
            print(version, *(mp.nstr(number, 20) for number in numbers), sep=",")
            rows += 1


if __name__ == "__main__":
    main()
