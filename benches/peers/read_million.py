"""Times `wetcor check` of a million runs beside polars' typed read of the same file, and measures its memory.

Usage: python3 benches/peers/read_million.py [runs]   (needs cargo; polars from requirements.txt for the peer)
"""
import sys
import tempfile
import time

import wetcor

try:
    import polars
except ImportError as missing:
    polars = None
    print(f"SKIPPED the peer: {missing}; install benches/peers/requirements.txt to compare with polars")

REPEATS = 9
FIXED, A_RUN = 200e6, 100


def polars_read(table):
    numbers = ["diameter_mm", "film_um", "film_ratio", "impact_speed_m_s", "restitution"]
    schema = dict.fromkeys(["particle", "liquid"], polars.String) | dict.fromkeys(numbers, polars.Float64)
    started = time.perf_counter()
    polars.read_csv(table, schema=schema)
    return time.perf_counter() - started


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    program = wetcor.built("bin", "wetcor")
    with tempfile.TemporaryDirectory() as folder:
        scene = wetcor.simulated(program, runs, folder)
        ours, theirs, memory = [], [], {}
        # before polars reads: a process starts with the memory of the one that started it
        out = f"{folder}/report"
        fit = [program, "fit", scene, "--stages", "least_squares", "--out", out, "--quiet"]
        check = [program, "check", scene, "--quiet"]
        for verb, command in (("check", check), ("fit --stages least_squares", fit)):
            fit_seconds, memory[verb], status = wetcor.measured(command)
            if status not in (0, 1):
                sys.exit(f"wetcor {verb} failed with status {status}")
        # by turns, so that whatever else the machine does disturbs both
        for _ in range(REPEATS):
            ours.append(wetcor.measured(check)[0])
            if polars:
                theirs.append(polars_read(scene.with_name("runs.csv")))
    print(f"{runs} runs, best of {REPEATS}")
    print(f"wetcor check, from process start        {1e3 * min(ours):6.0f} ms")
    if theirs:
        print(f"polars {polars.__version__} read_csv, inside a process {1e3 * min(theirs):6.0f} ms")
        print(f"ratio                                   {min(ours) / min(theirs):6.2f}")
    allowed = FIXED + A_RUN * runs
    for verb, largest in memory.items():
        print(f"peak memory of {verb}: {largest / 1e6:.0f} MB (at most {allowed / 1e6:.0f} MB)")
    print(f"fit --stages least_squares, once: {fit_seconds:.2f} s")


main()
