"""Fits the example scene, prints the verdict and the main numbers, and takes a mean from the draws.

    python3 examples/fit_and_read.py

Runs in the project's folder, with `wetcor` on PATH. Needs nothing else; for all draws by name, with ArviZ:
arviz.from_zarr("target/fit_and_read/draws/draws.zarr").
"""

import csv, json, statistics, subprocess

out = "target/fit_and_read"
ran = subprocess.run(["wetcor", "fit", "datasets/mueller2016/scene.toml", "--out", out])
if ran.returncode not in (0, 1):  # 1: it ran, and the numbers are not to be quoted
    raise SystemExit(ran.returncode)

with open(f"{out}/findings.json", encoding="utf-8") as file:
    findings = json.load(file)
verdict = findings["main"]["verdict"]
print("may be quoted:" if verdict["passed"] else "not to be quoted:", verdict["reason"])
for row in findings["estimates"]:  # se or interval is None where there is none
    if row["main"]:
        place = {key: row[key] for key in ("particle", "liquid", "diameter_m", "film_ratio") if row[key] is not None}
        print(row["quantity"], place or "", "=", row["value"], "±", row["se"], "interval", row["interval"])

with open(f"{out}/draws/draws.csv", newline="", encoding="utf-8") as file:
    draws = [float(row["lubrication_log"]) for row in csv.DictReader(file)]
told = {p["name"]: p["mean"] for p in findings["posterior"]["parameters"]}
print("lubrication_log:", len(draws), "draws, mean", statistics.fmean(draws), "findings", told["lubrication_log"])
