"""Computes what src/inference/bootstrap is held against, by other means: numpy and scipy, not our kernels.

Writes runs.csv (the runs, in strata), replicates.csv (weights of 200 resamples, with the fits numpy gives them) and
reference.csv (acceleration, degrees of freedom and percentile limits of e_inf and St_c by both laws).

Usage: python3 tests/data/bootstrap/reference.py   (numpy 2.4, scipy 1.17)
"""
import csv
import pathlib

import numpy as np
from scipy.stats import norm

HERE = pathlib.Path(__file__).parent
REPLICATES = 200
LEVELS = (0.90, 0.95)


def runs():
    """Three strata of unequal size about the square-root law, their noise skewed."""
    rng = np.random.default_rng(20161108)
    sizes, at = (5, 7, 4), (0.012, 0.030, 0.047)
    x = np.concatenate([a + 0.004 * rng.random(n) for a, n in zip(at, sizes)])
    e = np.sqrt(0.52 - 7.4 * x) + 0.02 * (1 - rng.exponential(size=x.size))
    return np.repeat(range(len(sizes)), sizes), x, e


def linear(x, e, w):
    """a, b of e = a - b x by weighted normal equations from a QR decomposition."""
    design = np.column_stack([np.ones_like(x), -x])
    return gauss_newton(lambda p: (design @ p, design), np.array([0.8, 10.0]), e, w)


def square_root(x, e, w):
    """alpha, beta of e = sqrt(alpha + beta x) by Gauss-Newton in extended precision."""
    def law(p):
        root = np.sqrt(p[0] + p[1] * x)
        return root, np.column_stack([0.5 / root, 0.5 * x / root])
    return gauss_newton(law, np.array([0.52, -7.4]), e, w)


def gauss_newton(law, p, e, w):
    p = p.astype(np.longdouble)
    root_w = np.sqrt(w.astype(np.longdouble))
    for _ in range(200):
        fitted, slopes = law(p)
        a, r = slopes * root_w[:, None], (e - fitted) * root_w
        # two parameters: the normal equations in extended precision are exact enough and need no LAPACK
        h = a.T @ a
        g = a.T @ r
        det = h[0, 0] * h[1, 1] - h[0, 1] ** 2
        step = np.array([h[1, 1] * g[0] - h[0, 1] * g[1], h[0, 0] * g[1] - h[0, 1] * g[0]]) / det
        p = p + step
        if np.all(np.abs(step) <= 1e-17 * np.abs(p)):
            break
    return p


QUANTITIES = {
    ("linear", "e_inf"): lambda p: p[0],
    ("linear", "st_c"): lambda p: p[1] / p[0],
    ("sqrt", "e_inf"): lambda p: np.sqrt(p[0]),
    ("sqrt", "st_c"): lambda p: -p[1] / (2 * p[0]),
}
LAWS = {"linear": linear, "sqrt": square_root}


def jackknife(fit, value, of, strata, x, e):
    """Acceleration and Satterthwaite's degrees of freedom; the others of a stratum weigh n/(n - 1)."""
    cubes = squares = total = spread = np.longdouble(0)
    for stratum in np.unique(strata):
        mine = np.flatnonzero(strata == stratum)
        n = mine.size
        left = []
        for run in mine:
            w = np.where(strata == stratum, n / (n - 1), 1.0)
            w[run] = 0.0
            left.append(of(fit(x, e, w)))
        influence = (n - 1) * (value - np.array(left))
        cubes += np.sum(influence ** 3) / n ** 3
        squares += np.sum(influence ** 2) / n ** 2
        variance = np.var(influence, ddof=1) / n
        total += variance
        spread += variance ** 2 / (n - 1)
    return cubes / (6 * squares ** 1.5), total ** 2 / spread


def order_statistic(values, p):
    """Rank (R + 1) p, interpolated on the normal scale."""
    ordered = np.sort(values)
    rank = (ordered.size + 1) * p
    k = int(rank)
    z = [norm.ppf(i / (ordered.size + 1)) for i in (k, k + 1)]
    return ordered[k - 1] + (norm.ppf(p) - z[0]) / (z[1] - z[0]) * (ordered[k] - ordered[k - 1])


def resamples(strata):
    rng = np.random.default_rng(7)
    for _ in range(REPLICATES):
        w = np.zeros(strata.size)
        for stratum in np.unique(strata):
            mine = np.flatnonzero(strata == stratum)
            np.add.at(w, rng.choice(mine, mine.size - 1), mine.size / (mine.size - 1))
        yield w


def write(name, header, rows):
    with open(HERE / name, "w", newline="") as table:
        out = csv.writer(table, lineterminator="\n")
        out.writerow(header)
        out.writerows([[f"{x:.17g}" if not isinstance(x, str) else x for x in row] for row in rows])


def main():
    strata, x, e = runs()
    weights = list(resamples(strata))
    write("runs.csv", ["stratum", "x", "e"], zip(strata, x, e))
    write("replicates.csv", [f"run{i}" for i in range(x.size)], weights)
    rows = []
    for (law, quantity), of in QUANTITIES.items():
        fit = LAWS[law]
        value = of(fit(x, e, np.ones_like(x)))
        a, df = jackknife(fit, value, of, strata, x, e)
        made = np.array([of(fit(x, e, w)) for w in weights], dtype=float)
        limits = [order_statistic(made, (1 + side * level) / 2) for level in LEVELS for side in (-1, 1)]
        rows.append([law, quantity, value, a, df, *limits])
    write("reference.csv", ["law", "quantity", "value", "acceleration", "degrees_of_freedom",
                            "lo90", "hi90", "lo95", "hi95"], rows)


main()
