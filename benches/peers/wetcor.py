"""Builds and runs our side of the peers."""
import json
import os
import pathlib
import re
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "datasets" / "mueller2016" / "scene.toml"


def built(kind, name):
    """Path of a program of this package: kind "bin" or "example"."""
    build = ["cargo", "build", "--release", "--quiet", "--message-format=json", f"--{kind}", name]
    messages = subprocess.run(build, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    # cargo names the file it built; the target directory may be anywhere
    lines = [json.loads(line) for line in messages.splitlines()]
    return next(m["executable"] for m in lines if m.get("executable") and m["target"]["name"] == name)


def simulated(program, runs, folder, inertia="saturating"):
    """A copy of the example's scene with such an inertial loss, noise on the restitution alone as the peers have it, and so many
    simulated runs; the path of its scene file."""
    scene = pathlib.Path(folder) / "scene.toml"
    text = re.sub(r"^inertia *= .*\n", "", SCENE.read_text(), count=1, flags=re.M)
    scene.write_text(text.replace("[model]\n", f'[model]\ninertia = "{inertia}"\nnoise = "restitution"\n'))
    command = [program, "simulate", scene, "--runs", str(runs), "--out", scene.with_name("runs.csv"), "--quiet"]
    subprocess.run(command, check=True)
    return scene


def measured(command):
    """Seconds from process start to its end, its largest memory in bytes, and its exit status."""
    started = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    return seconds, 1024 * usage.ru_maxrss, process.returncode
