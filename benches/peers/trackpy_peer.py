"""Finds the sphere of rendered frames with trackpy and with find_sphere, beside the truth.

    cargo run --release --example render_frames -- FOLDER 200 400 400 png
    python trackpy_peer.py FOLDER target/release/examples/find_sphere

FOLDER holds PNG frames and truth.csv (frame,x_px,y_px). trackpy is told the sphere's size and how many features there
are, on frames less their median over time, as its documentation recommends; its diameter is an odd number above the
sphere's. Of the features of a frame the one nearest to the truth counts: which is the sphere is not asked of it.
"""

import csv
import io
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import trackpy
from PIL import Image

RADIUS = 20
FEATURES = 3  # the sphere, its mirror image, another


def errors(found, truth):
    """Bias and sd of x and y, px, and frames found within a radius."""
    away = np.array([np.subtract(found[frame], truth[frame]) for frame in found])
    near = np.hypot(away[:, 0], away[:, 1]) < RADIUS
    away = away[near]
    rms = np.sqrt((away**2).mean(axis=0))
    return away.mean(axis=0), away.std(axis=0), rms, near.sum()


def show(name, found, truth, seconds):
    bias, sd, rms, frames = errors(found, truth)
    print(
        f"{name:26} {frames:5} of {len(truth)} frames  bias {bias[0]:+.4f} {bias[1]:+.4f} px"
        f"  sd {sd[0]:.4f} {sd[1]:.4f} px  rms {rms[0]:.4f} {rms[1]:.4f} px"
        f"  {seconds:.2f} s, {1e3 * seconds / len(truth):.2f} ms a frame"
    )
    return rms


def of_trackpy(paths, truth, diameter, **settings):
    start = time.perf_counter()
    frames = [np.asarray(Image.open(path), dtype=np.float32) for path in paths]
    background = np.median(frames[:: max(1, len(frames) // 48)], axis=0)
    found = {}
    for number, frame in enumerate(frames):
        difference = np.abs(frame - background)
        features = trackpy.locate(difference, diameter, topn=FEATURES, engine="auto", characterize=False, **settings)
        if len(features):
            x, y = truth[number]
            nearest = np.hypot(features.x - x, features.y - y).idxmin()
            found[number] = (features.x[nearest], features.y[nearest])
    return found, time.perf_counter() - start


def of_program(program, folder):
    start = time.perf_counter()
    text = subprocess.run([program, folder], check=True, capture_output=True, text=True).stdout
    seconds = time.perf_counter() - start
    rows = csv.DictReader(io.StringIO(text))
    return {int(row["frame"]): (float(row["x_px"]), float(row["y_px"])) for row in rows}, seconds


def main():
    folder, program = sys.argv[1:3]
    warnings.filterwarnings("ignore")
    with open(Path(folder) / "truth.csv") as file:
        truth = {int(row["frame"]): (float(row["x_px"]), float(row["y_px"])) for row in csv.DictReader(file)}
    paths = sorted(Path(folder).glob("*.png"))
    trackpy.quiet()
    # numba is compiled before the clock runs
    of_trackpy(paths[:3], truth, 2 * RADIUS + 1)
    ours, seconds = of_program(program, folder)
    our_rms = show("find_sphere", ours, truth, seconds)
    # a sphere has no peak of its own: smoothed over half of its radius it has one
    for diameter, settings in (
        (2 * RADIUS + 1, {}),
        (2 * RADIUS + 11, {}),
        (2 * RADIUS + 21, {}),
        (2 * RADIUS + 11, {"noise_size": RADIUS / 2}),
        (2 * RADIUS + 21, {"noise_size": RADIUS / 2}),
    ):
        found, its_seconds = of_trackpy(paths, truth, diameter, **settings)
        told = "".join(f" {name} {value}" for name, value in settings.items())
        its_rms = show(f"trackpy {diameter}{told}", found, truth, its_seconds)
        print(
            f"{'':26} its rms is {its_rms[0] / our_rms[0]:.1f} and {its_rms[1] / our_rms[1]:.1f} times ours,"
            f" its time {its_seconds / seconds:.1f} times ours"
        )


if __name__ == "__main__":
    main()
