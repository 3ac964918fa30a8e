"""Times `wetcor fit --stages least_squares` of 2,000 runs beside the fits of its main loop in SciPy.

Ours: the whole process, from its start to the written report, and its least-squares stage alone, which has the energy
balance over all runs and every interval, verdict and bias besides. SciPy: only the calls of curve_fit, of the
square-root law for each series and of both laws for each film ratio of a particle and over all of them.

Usage: python3 benches/peers/least_squares_stage.py [runs]   (needs cargo; scipy from requirements.txt for the peer)
"""
import collections
import csv
import json
import pathlib
import sys
import tempfile
import time
import tomllib

import wetcor

try:
    import numpy as np
    import scipy
    from scipy.optimize import curve_fit
except ImportError as missing:
    scipy = None
    print(f"SKIPPED the peer: {missing}; install benches/peers/requirements.txt to compare with scipy")

REPEATS = 9
TARGET = 0.3


def groups(scene):
    """x and e of every fit by the square-root law, and of every fit by the linear law."""
    given = tomllib.loads(scene.read_text())
    series, pooled = collections.defaultdict(list), collections.defaultdict(list)
    with open(scene.with_name("runs.csv"), newline="") as table:
        for run in csv.DictReader(table):
            e, v = float(run["restitution"]), float(run["impact_speed_m_s"])
            if run["liquid"] == "dry" or e <= given["data"]["smallest_restitution"]:
                continue
            particle, liquid, ratio = run["particle"], run["liquid"], run["film_ratio"]
            density = given["particles"][particle]["density_kg_m3"]
            viscosity = 1e-3 * given["liquids"][liquid]["viscosity_mPa_s"]
            stokes = density * 1e-3 * float(run["diameter_mm"]) * v / (9 * viscosity)
            series[particle, liquid, run["diameter_mm"], ratio].append((1 / v, e))
            pooled[particle, ratio].append((1 / stokes, e))
            pooled[particle, None].append((1 / stokes, e))

    def usable(some):
        columns = [np.array(runs).T for runs in some.values()]
        return [(x, e) for x, e in columns if len(set(x)) > 2]

    return usable(series) + usable(pooled), usable(pooled)


def square_root(x, alpha, beta):
    return np.sqrt(np.maximum(alpha + beta * x, 0.0))


def linear(x, a, b):
    return a - b * x


def scipys(root, line):
    started = time.perf_counter()
    for x, e in root:
        slope, level = np.polyfit(x, e * e, 1)
        curve_fit(square_root, x, e, p0=(level, slope))
    for x, e in line:
        curve_fit(linear, x, e)
    return time.perf_counter() - started


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000
    program = wetcor.built("bin", "wetcor")
    with tempfile.TemporaryDirectory() as folder:
        scene = wetcor.simulated(program, runs, folder)
        out = f"{folder}/report"
        fit = [program, "fit", scene, "--stages", "least_squares", "--out", out, "--quiet"]
        ours, stage, theirs = [], [], []
        root, line = groups(scene) if scipy else ([], [])
        for _ in range(REPEATS):
            seconds, _, status = wetcor.measured(fit)
            if status not in (0, 1):
                sys.exit(f"wetcor fit failed with status {status}")
            ours.append(seconds)
            stage.append(json.loads(pathlib.Path(out, "timing.json").read_text())["least_squares"])
            if scipy:
                theirs.append(scipys(root, line))
    print(f"{runs} runs, best of {REPEATS}")
    print(f"wetcor fit --stages least_squares, from process start {1e3 * min(ours):6.0f} ms (target {1e3 * TARGET:.0f} ms)")
    print(f"its least-squares stage alone                         {1e3 * min(stage):6.0f} ms")
    if theirs:
        what = f"scipy {scipy.__version__}, {len(root)} + {len(line)} calls of curve_fit"
        print(f"{what:53} {1e3 * min(theirs):6.0f} ms")


main()
