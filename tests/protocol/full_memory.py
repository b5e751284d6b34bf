"""Coefficients of a full memory for a device: the form Modes of crates/haptic-link/protocol.md, section Coefficients.

With i = ceil(order) differences around it (sums for orders up to -1) what remains is a fractional integral of order
nu = ceil(order) - order, 0 <= nu < 1, with positive weights:

    c_j = Γ(j + ν)/(Γ(ν)·Γ(j + 1)) = ∫ e^(−js) ρ(s) d(ln s),    ρ(s) = sin(πν)/π·s·(e^s − 1)^(−ν)

The integral becomes a sum over nodes s_q = e^(qh): one mode each, with weight w_q = h·ρ(s_q), and two modes with the
moments of all nodes that the horizon cannot resolve. The first 16 weights are exact: k_j is what the modes leave of
c_j. In the list, g = T^(−μ), k_j = T^(−μ)·(c_j − Σ_q w_q·e^(−j·s_q)), d_q = 1 − e^(−s_q), W_q = T^(−μ)·w_q·e^(−s_q).
Up to the horizon the error of y is at most tolerance·T^(−μ)·Σ_j c_j·|Δ^i x[n−j]|; for a motion in one direction and
0 < μ <= 1 that is the tolerance times y.

full_memory(0.2247, 1e-3, 1e-6, 200.0) gives i = 1 and 21 modes, 58 coefficients. Needs nothing but Python 3.8.
"""

from math import ceil, exp, expm1, floor, lgamma, log, pi, sin, sqrt

def full_memory(order, tick_s, tolerance, horizon_s):
    """operator.integer and the coefficients of D^order, Modes: tolerance from 1e-8 to 0.1."""
    integer, rate, horizon = ceil(order), tick_s**-order, max(horizon_s / tick_s, 100.0)
    nu = integer - order
    weights = [1.0]
    for j in range(1, 16):
        weights.append(weights[-1] * (j - 1 + nu) / j)
    if nu == 0.0:
        return integer, [rate * weight for weight in weights]
    weight = lambda j: exp(lgamma(j + nu) - lgamma(nu) - lgamma(j + 1))
    density = lambda s: sin(pi * min(nu, 1 - nu)) / pi * s * expm1(s)**-nu

    def modes(step):
        node = lambda q: (exp(q * step), step * density(exp(q * step)))
        last = floor(log(min((1000 * tolerance)**(1 / (5 - nu)), 1.0) / horizon) / step) + 1
        first = floor(log(2.5) / step)
        least = 0.05 * tolerance * weight(16)
        while first > last and node(first)[1] * exp(-16 * node(first)[0]) < least:
            first -= 1
        unit, moments, q = exp(last * step), [0.0] * 4, last - 1
        while True:  # all that is slower: moments, the last terms as a geometric series
            s, term = node(q)
            for m in range(4):
                rest = -expm1(-step * (1 - nu + m)) if s < 1e-18 else 1.0
                moments[m] += term * (s / unit)**m / rest
            if s < 1e-18:
                break
            q -= 1
        m0, m1, m2, m3 = moments
        p, q = ((m0 * m3 - m1 * m2) / (m0 * m2 - m1 * m1), (m1 * m3 - m2 * m2) / (m0 * m2 - m1 * m1))
        fast = (p + sqrt(p * p - 4 * q)) / 2
        slow = q / fast
        share = (m1 - slow * m0) / (fast - slow)
        nodes = [node(q) for q in range(first, last - 1, -1)]
        return nodes + [(fast * unit, share), (slow * unit, m0 - share)]

    made = lambda found, j: sum(w * exp(-j * s) for s, w in found)
    step = 3.0
    while True:  # ever finer, until every weight is good enough
        found, j, worst = modes(step), 16.0, 0.0
        while j < horizon:
            worst = max(worst, abs(made(found, floor(j)) / weight(floor(j)) - 1))
            j = max(j * exp(step / 24), j + 1)
        if max(worst, abs(made(found, horizon) / weight(horizon) - 1)) <= tolerance:
            break
        step *= 0.97
    taps = [weights[0]] + [weights[j] - made(found, j) for j in range(1, 16)]
    pairs = [value for s, w in found for value in (-expm1(-s), w * exp(-s))]
    return integer, [rate * tap for tap in taps] + [
        value * (rate if q % 2 else 1.0) for q, value in enumerate(pairs)]
