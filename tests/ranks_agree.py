"""Holds that what ranks write has the same bytes for any number of them, and that a failure of one ends all.

    python3 tests/ranks_agree.py PROGRAM PROGRAM_WITHOUT_MPI

PROGRAM was built with the feature `mpi`; needs mpirun of Open MPI.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

SETS = "21"
# as root, as CI has it, and with more ranks than processors
ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}
OURS = "error: "
SCENE = pathlib.Path(__file__).parents[1] / "datasets/mueller2016/scene.toml"


def calibrate(program, ranks, out, *more, sets=SETS):
    """The command on so many ranks; none: without a launcher."""
    launcher = ["mpirun", "-n", str(ranks)] if ranks else []
    return [*launcher, program, "calibrate", "--sets", sets, "--out", out, *more]


def run(command, folder):
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
    told = [line for line in done.stderr.splitlines() if line.startswith(OURS)]
    return done, told


def the_page_is_the_same(program, folder):
    pages = {}
    for ranks in [1, 2, 3]:
        out = f"{ranks}.md"
        done, _ = run(calibrate(program, ranks, out), folder)
        assert done.returncode == 0, done.stderr
        assert done.stdout == f"table: {out}\n", f"{ranks} ranks told {done.stdout!r}"
        pages[ranks] = (folder / out).read_bytes()
    assert pages[1] == pages[2] == pages[3], "pages differ"
    # another seed is another page: what was compared depends on the work
    done, _ = run(calibrate(program, 2, "other.md", "--seed", "2"), folder)
    assert done.returncode == 0, done.stderr
    assert (folder / "other.md").read_bytes() != pages[1], "a seed changes nothing"


def fit(program, ranks, scene, out, stages="least_squares"):
    """A fit of a scene of this folder, in which it leaves a report."""
    launcher = ["mpirun", "-n", str(ranks)] if ranks else []
    return [*launcher, program, "fit", scene, "--stages", stages, "--out", out, "--quiet"]


# more runs than are kept
MANY = 3_000_000
WHOLE, BAD = "many.toml", "bad.toml"
# so many sets, and so many draws, that a command is killed before it is done
MANY_SETS = "2000"
LONG = "long.toml"


def the_report_is_the_same(program, plain, folder):
    (folder / "scene.toml").write_text(SCENE.read_text())
    parts = [f"many/part-{part:03}.parquet" for part in range(5)]
    (folder / "many").mkdir()
    for seed, part in enumerate(parts, 1):
        each = ["--runs", str(MANY // len(parts)), "--seed", str(seed), "--out", part]
        done, _ = run([program, "simulate", "scene.toml", *each], folder)
        assert done.returncode == 0, done.stderr
    with (folder / "bad.csv").open("w") as table:
        table.write("particle,liquid,diameter_mm,film_um,film_ratio,impact_speed_m_s,restitution\nPTFE,dry,4.762,,,fast,0.8\n")
    for scene, tables in [(WHOLE, parts), (BAD, [*parts, "bad.csv"])]:
        text = SCENE.read_text().replace('"runs.csv"', str(tables).replace("'", '"'))
        assert str(MANY) not in text and "part-004" in text
        (folder / scene).write_text(text)
    (folder / LONG).write_text((folder / WHOLE).read_text() + "\n[sampler]\ndraws = 100000\n")
    findings = same_findings(program, plain, folder, WHOLE, "least_squares")
    assert findings["counts"]["runs"] == MANY, findings["counts"]
    assert any(remark["code"] == "condensed_runs" for remark in findings["remarks"]), "every run was kept"


def same_findings(program, plain, folder, scene, stages):
    """The findings of a scene, which any number of ranks report with the same bytes."""
    reports = {}
    for ranks in [0, 1, 2, 3]:
        done, _ = run(fit(program if ranks else plain, ranks, scene, "report", stages), folder)
        assert done.returncode in [0, 1], done.stderr
        reports[ranks] = {
            path.name: path.read_bytes() for path in (folder / "report").iterdir() if path.name in ["findings.json", "report.md"]
        }
    for ranks in [1, 2, 3]:
        assert reports[ranks] == reports[0], f"reports of {ranks} ranks differ"
    return json.loads(reports[0]["findings.json"])


def a_refusal_is_told_once(program, folder):
    (folder / "notes.md").write_text("notes\n")
    for arguments, expected in [
        (calibrate(program, 3, "notes.md"), "notes.md: exists and is no page"),
        (calibrate(program, 3, "new.md", "--bogus"), "unexpected argument '--bogus'"),
        (["mpirun", "-n", "3", program, "check", "scene.toml"], "only `fit` and `calibrate` divide"),
        (fit(program, 3, BAD, "bad"), "bad.csv"),
    ]:
        done, told = run(arguments, folder)
        assert done.returncode == 2, (done.returncode, done.stderr)
        assert len(told) == 1 and expected in told[0], told
    assert (folder / "notes.md").read_text() == "notes\n"
    assert not (folder / "new.md").exists()


def kill_one(command, folder, place):
    """Starts a command on two ranks, kills one of them at work, and holds that the command fails."""
    with subprocess.Popen(command, cwd=folder, env=ENVIRONMENT, stderr=subprocess.PIPE) as launcher:
        ranks = []
        while len(ranks) < 2:
            time.sleep(0.2)
            assert launcher.poll() is None, "it ended before one was killed"
            found = subprocess.run(["pgrep", "-P", str(launcher.pid)], capture_output=True, text=True).stdout
            ranks = [int(word) for word in found.split()]
        # at work by now, and far from done
        time.sleep(2)
        os.kill(ranks[place], signal.SIGKILL)
        launcher.communicate(timeout=60)
        assert launcher.returncode != 0, "a rank was killed and the command succeeded"


def one_that_is_killed_ends_all(program, folder, place):
    before = (folder / "1.md").read_bytes()
    report = (folder / "report/findings.json").read_bytes()
    names = set(os.listdir(folder))
    kill_one(calibrate(program, 2, "1.md", sets=MANY_SETS), folder, place)
    assert (folder / "1.md").read_bytes() == before
    assert set(os.listdir(folder)) == names, set(os.listdir(folder)) - names
    kill_one(fit(program, 2, LONG, "report", "least_squares,posterior"), folder, place)
    assert (folder / "report/findings.json").read_bytes() == report
    assert set(os.listdir(folder)) == names, set(os.listdir(folder)) - names


def without_the_feature_it_says_what_to_build(program, folder):
    done, told = run(calibrate(program, 2, "plain.md"), folder)
    assert done.returncode == 2, done.stderr
    assert len(told) == 1 and "--features mpi" in told[0] and "libopenmpi-dev" in told[0], told
    assert not (folder / "plain.md").exists()


def main(program, plain):
    program, plain = (str(pathlib.Path(path).resolve()) for path in (program, plain))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        the_page_is_the_same(program, folder)
        the_report_is_the_same(program, plain, folder)
        a_refusal_is_told_once(program, folder)
        for place in [0, 1]:
            one_that_is_killed_ends_all(program, folder, place)
        without_the_feature_it_says_what_to_build(plain, folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
