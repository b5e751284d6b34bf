#!/usr/bin/env python3
"""Makes uniaxial.csv: E(t) of a bar whose material is the card beside this script, with 30 digits.

    pip install mpmath==1.3.0 && python3 make_golden.py

The cards are `host-cli materials export c19-nu03.toml --format abaqus` and `--format ansys`. They are read here by the
programs' own definitions and not integrated in time, as the test does, but inverted from the Laplace domain (Talbot):

    Abaqus  G_R(t) = G_0 (1 - sum g_i (1 - exp(-t/tau_i))),  K_R(t) = K_0 (1 - sum k_i (1 - exp(-t/tau_i)))
    Ansys   G(t) = G_0 (a_inf + sum a_i exp(-t/tau_i)),  a_inf = 1 - sum a_i, and the same of the bulk
    a bar   s E(s) = 9 K G/(3 K + G),  K and G times s each; 3 G where Poisson's ratio is 0.5

G_0 and K_0 come from Young's modulus in the card's comment and Poisson's ratio, as a user would type them under *ELASTIC.
"""
import re

from mpmath import inf, invertlaplace, mp, mpf, nstr

mp.dps = 30


def abaqus(text):
    rows = text.split("TIME=PRONY\n")[1].split("\n")
    cells = [[mpf(cell) for cell in row.split(",")] for row in rows if "," in row]
    return [(g, tau) for g, _, tau in cells], [(k, tau) for _, k, tau in cells]


def ansys(text):
    parts = []
    for part in ("SHEAR", "BULK"):
        rows = text.split(f",{part}\n")[1].split("TB,")[0].split("\n")
        numbers = [mpf(cell) for row in rows if row.startswith("TBDATA") for cell in row.split(",")[2:]]
        parts.append(list(zip(numbers[::2], numbers[1::2])))
    return parts


def relaxed(pairs, s):
    """s times the transform of 1 - sum g (1 - exp(-t/tau))."""
    return 1 - sum(g / (1 + tau * s) for g, tau in pairs)


def main():
    rows = ["format,poisson_ratio,time_s,modulus_pa"]
    for name, read in (("abaqus", abaqus), ("ansys", ansys)):
        text = open(f"c19-nu03.{name}").read()
        young = mpf(re.search(r"Young's modulus at 0 = ([0-9.e+]+) Pa", text).group(1))
        shear, bulk = read(text)
        for ratio in (mpf("0.3"), mpf("0.45"), mpf("0.5")):
            g0 = young / (2 * (1 + ratio))
            k0 = young / (3 * (1 - 2 * ratio)) if ratio < 0.5 else inf

            def carson(s):
                g = g0 * relaxed(shear, s)
                if k0 == inf:
                    return 3 * g
                k = k0 * relaxed(bulk, s)
                return 9 * k * g / (3 * k + g)

            for n in range(25):
                t = mpf(10) ** (-3 + mpf(n) / 4)
                e = invertlaplace(lambda s: carson(s) / s, t, method="talbot")
                rows.append(f"{name},{nstr(ratio, 3)},{nstr(t, 17)},{nstr(e, 16)}")
    with open("uniaxial.csv", "w") as file:
        file.write("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
