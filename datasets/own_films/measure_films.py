"""Gives every wet run of ../mueller2016/runs.csv a film of its own, as where a laboratory measures each.

film_um is taken times a normal number about 1 with the sd SPREAD and rounded to 0.01 um; the column film_ratio, which named
the ratio that was aimed at, is left out. Everything else stays as it was.

Run: python measure_films.py > runs.csv   (Python 3.9 or later, nothing else)
"""
import csv
import pathlib
import random
import sys

SPREAD = 0.02

rng = random.Random("films of their own")
with open(pathlib.Path(__file__).parents[1] / "mueller2016" / "runs.csv", newline="") as table:
    runs = list(csv.DictReader(table))
columns = [name for name in runs[0] if name != "film_ratio"]
writer = csv.DictWriter(sys.stdout, columns, extrasaction="ignore", lineterminator="\n")
writer.writeheader()
for run in runs:
    if run["film_um"]:
        run["film_um"] = f"{float(run['film_um']) * rng.gauss(1.0, SPREAD):.2f}"
    writer.writerow(run)
