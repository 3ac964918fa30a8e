"""Installs the project with pip in a clean virtual environment, and runs the program and the Python example from it.

    python3 tests/wheel_installs.py [WHEEL]

Without a wheel pip builds one from the checkout, as `pip install .` does: in target/, where what cargo built before is used
again. The environment and the example's report lie in target/wheel. Holds what `wetcor --version` prints against Cargo.toml,
and what the example prints against the findings of the fit it ran. Exit status 1 on any difference. Needs Python >= 3.9.
"""

import json
import math
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# the mean of the draws is taken in another order of sums here than there
RELATIVE = 1e-9


def installed(environment, what):
    """The folder with the programs of a new environment into which something was installed."""
    venv.create(environment, clear=True, with_pip=True)
    folder = environment / ("Scripts" if os.name == "nt" else "bin")
    pip = [folder / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, what], check=True, cwd=ROOT)
    return folder


def main_numbers(findings):
    return [row for row in findings["estimates"] if row["main"]]


def differences(printed, findings):
    """What the example printed otherwise than the findings have it."""
    found = []
    lines = printed.splitlines()
    verdict = findings["main"]["verdict"]
    if f"{'may be quoted' if verdict['passed'] else 'not to be quoted'}: {verdict['reason']}" not in lines:
        found.append("the verdict")
    for main in main_numbers(findings):
        place = {key: main[key] for key in ("particle", "liquid", "diameter_m", "film_ratio") if main[key] is not None}
        number = f"{main['value']} ± {main['se']} interval {main['interval']}"
        line = f"{main['quantity']} {place or ''} = {number}"
        if line not in lines:
            found.append(line)
    posterior = findings["posterior"]
    told = next(p["mean"] for p in posterior["parameters"] if p["name"] == "lubrication_log")
    of_draws = re.search(r"^lubrication_log: (\d+) draws, mean (\S+) findings (\S+)$", printed, re.MULTILINE)
    if of_draws is None:
        return [*found, "the line on the draws"]
    count, mean, repeated = int(of_draws[1]), float(of_draws[2]), float(of_draws[3])
    if count != posterior["chains"] * posterior["draws"]:
        found.append(f"{count} draws")
    if repeated != told or not math.isclose(mean, told, rel_tol=RELATIVE):
        found.append(f"mean {mean}, repeated {repeated}, findings {told}")
    return found


def faults(what):
    programs = installed(ROOT / "target" / "wheel", what)
    wetcor = programs / ("wetcor.exe" if os.name == "nt" else "wetcor")
    version = subprocess.run([wetcor, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout
    expected = re.search(r'^version = "(.+)"$', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]
    if version.split() != ["wetcor", expected]:
        return [f"found {version!r}, expected wetcor {expected}"]

    # only programs of the environment, so that no other wetcor is found
    surroundings = {**os.environ, "PATH": str(programs), "PYTHONIOENCODING": "utf-8"}
    ran = subprocess.run(
        [programs / "python", "examples/fit_and_read.py"],
        check=True,
        cwd=ROOT,
        env=surroundings,
        stdout=subprocess.PIPE,
        encoding="utf-8",
    )
    findings = json.loads((ROOT / "target" / "fit_and_read" / "findings.json").read_text(encoding="utf-8"))
    found = differences(ran.stdout, findings)

    # the comparison can fail: a mean off by a millionth, a number in its last digit, another verdict
    planted = json.loads(json.dumps(findings))
    for parameter in planted["posterior"]["parameters"]:
        parameter["mean"] *= 1 + 1e-6
    first = main_numbers(planted)[0]
    first["value"] = math.nextafter(first["value"], 1.0)
    planted["main"]["verdict"]["passed"] = not planted["main"]["verdict"]["passed"]
    if len(differences(ran.stdout, planted)) != 3:
        found.append(f"of three planted faults were found: {differences(ran.stdout, planted)}")
    return found


if __name__ == "__main__":
    found = faults(sys.argv[1] if len(sys.argv) > 1 else ".")
    for line in found:
        print(line, file=sys.stderr)
    sys.exit(1 if found else 0)
