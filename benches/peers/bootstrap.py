"""Times replicates with a BCa interval beside scipy.stats.bootstrap, on the PTFE runs at film ratio 0.06 of 2,000.

SciPy: the linear law's e_inf in closed form, vectorized, all runs resampled as one stratum. Ours: the same law, inside
strata; and the square-root law. Then ours with more runs, more replicates and one thread.

Usage: python3 benches/peers/bootstrap.py   (needs cargo; scipy from requirements.txt for the peer)
"""
import collections
import csv
import json
import subprocess
import tempfile
import time
import tomllib

import wetcor

try:
    import numpy as np
    import scipy
    from scipy.stats import bootstrap
except ImportError as missing:
    scipy = None
    print(f"SKIPPED the peer: {missing}; install benches/peers/requirements.txt to compare with scipy")

REPLICATES = 10_000
REPEATS = 200  # a tenth of a second, as the peer's five take
TARGETS = {"linear": 20, "sqrt": 200_000}


def group(scene):
    """(stratum, 1/St, e) of the rebounds of PTFE at film ratio 0.06, a stratum a liquid, diameter and speed."""
    given = tomllib.loads(scene.read_text())
    density = given["particles"]["PTFE"]["density_kg_m3"]
    cells = collections.defaultdict(list)
    with open(scene.with_name("runs.csv"), newline="") as table:
        for run in csv.DictReader(table):
            e, v = float(run["restitution"]), float(run["impact_speed_m_s"])
            if run["particle"] != "PTFE" or run["film_ratio"] != "0.06" or e <= given["data"]["smallest_restitution"]:
                continue
            viscosity = 1e-3 * given["liquids"][run["liquid"]]["viscosity_mPa_s"]
            stokes = density * 1e-3 * float(run["diameter_mm"]) * v / (9 * viscosity)
            cells[run["liquid"], run["diameter_mm"], v].append((1 / stokes, e))
    return [(number, x, e) for number, cell in enumerate(cells.values()) for x, e in cell]


def ours(program, runs, law, replicates=REPLICATES, threads=2, repeats=REPEATS):
    text = "\n".join(f"{stratum},{x!r},{e!r}" for stratum, x, e in runs)
    command = [program, law, str(replicates), str(threads), str(repeats)]
    return json.loads(subprocess.run(command, input=text, check=True, stdout=subprocess.PIPE, text=True).stdout)


def intercept(x, e, axis=-1):
    x0, e0 = x.mean(axis=axis), e.mean(axis=axis)
    slope = ((x * e).mean(axis=axis) - x0 * e0) / ((x * x).mean(axis=axis) - x0 * x0)
    return e0 - slope * x0


def scipys(runs, batch):
    """Best seconds and the interval; batch None resamples everything at once, a smaller one stays in the cache."""
    x, e = np.array([x for _, x, _ in runs]), np.array([e for _, _, e in runs])
    best = float("inf")
    for _ in range(5):
        started = time.perf_counter()
        made = bootstrap((x, e), intercept, paired=True, vectorized=True, method="BCa", batch=batch,
                         n_resamples=REPLICATES, rng=np.random.default_rng(1))
        best = min(best, time.perf_counter() - started)
    return best, made.confidence_interval


def main():
    program = wetcor.built("example", "bootstrap_peer")
    with tempfile.TemporaryDirectory() as folder:
        runs = group(wetcor.simulated(wetcor.built("bin", "wetcor"), 2_000, folder))
    print(f"{len(runs)} runs in {runs[-1][0] + 1} strata, {REPLICATES} replicates, best of {REPEATS}, two threads")
    mine = {law: ours(program, runs, law) for law in TARGETS}
    rate = {law: REPLICATES / found["seconds"] for law, found in mine.items()}
    for law, found in mine.items():
        print(f"wetcor, {law:6} {rate[law]:12,.0f} replicates/s   e_inf {found['lo']:.4f} to {found['hi']:.4f}")
    if scipy:
        for batch in (None, 1000):
            seconds, (lo, hi) = scipys(runs, batch)
            peer = REPLICATES / seconds
            print(f"scipy {scipy.__version__}, linear, batch {batch}: {peer:,.0f} replicates/s   e_inf {lo:.4f} to {hi:.4f}, "
                  f"ours {rate['linear'] / peer:.1f} times as many (target {TARGETS['linear']})")
    print(f"square-root law: target {TARGETS['sqrt']:,}/s")
    for law in TARGETS:
        # by turns, so that whatever else the machine does disturbs both
        one, two = [], []
        for _ in range(5):
            one.append(ours(program, runs, law, 200_000, 1, 10)["seconds"])
            two.append(ours(program, runs, law, 200_000, 2, 10)["seconds"])
        print(f"{law}: two threads over one {min(one) / min(two):.2f} (target 1.8)")
        strata = runs[-1][0] + 1
        for times in (1, 2, 4, 8):
            more = [(stratum + strata * copy, x, e) for copy in range(times) for stratum, x, e in runs]
            seconds = ours(program, more, law, 20_000, 1, 3)["seconds"]
            print(f"  {len(more):5} runs, 20000 replicates, one thread {1e3 * seconds:8.1f} ms, "
                  f"{1e9 * seconds / len(more) / 20_000:.2f} ns a run and replicate")
        for replicates in (20_000, 40_000, 80_000):
            seconds = ours(program, runs, law, replicates, 1, 3)["seconds"]
            print(f"  {len(runs):5} runs, {replicates} replicates, one thread {1e3 * seconds:8.1f} ms, "
                  f"{1e9 * seconds / replicates:.0f} ns a replicate")


main()
