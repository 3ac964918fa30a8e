"""Times one series fit beside scipy's curve_fit, on the same 40 runs, and checks that both agree.

Usage: python3 benches/peers/series_fit.py   (needs requirements.txt and cargo)
"""
import json
import pathlib
import subprocess
import sys
import timeit

try:
    import numpy as np
    import scipy
    from scipy.optimize import curve_fit
except ImportError as missing:
    print(f"SKIPPED: {missing}; install benches/peers/requirements.txt to compare with scipy")
    sys.exit(0)

START = (0.7, -0.2)
AGREE = 1e-6
ROOT = pathlib.Path(__file__).resolve().parents[2]


def runs():
    """40 impacts of one film: square-root law, alpha 0.8, beta -0.3 m/s, sd 0.012."""
    rng = np.random.default_rng(20161108)
    speed = np.repeat(np.sqrt(2 * 9.81 * np.linspace(0.03, 0.15, 8)), 5)
    restitution = np.sqrt(0.8 - 0.3 / speed) + rng.normal(0.0, 0.012, speed.size)
    return speed, restitution


def law(speed, alpha, beta):
    return np.sqrt(alpha + beta / speed)


def slopes(speed, alpha, beta):
    half = 0.5 / law(speed, alpha, beta)
    return np.column_stack([half, half / speed])


def ours(speed, restitution):
    build = ["cargo", "build", "--release", "--quiet", "--message-format=json",
             "--example", "series_fit_peer"]
    messages = subprocess.run(build, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    # cargo names the file it built; the target directory may be anywhere.
    built = [json.loads(line) for line in messages.splitlines()]
    exe = next(m["executable"] for m in built
               if m.get("target", {}).get("name") == "series_fit_peer" and m.get("executable"))
    table = "\n".join(f"{v!r},{e!r}" for v, e in zip(speed.tolist(), restitution.tolist()))
    return json.loads(subprocess.run([exe], input=table, check=True, capture_output=True,
                                     text=True).stdout)


def scipys(speed, restitution, **more):
    def once():
        return curve_fit(law, speed, restitution, p0=START, **more)

    (alpha, beta), covariance = once()
    se_alpha, se_beta = np.sqrt(np.diag(covariance))
    best = min(timeit.repeat(once, number=100, repeat=10)) / 100
    return {"seconds_per_fit": best, "alpha": alpha, "beta": beta,
            "se_alpha": se_alpha, "se_beta": se_beta}


def main():
    speed, restitution = runs()
    wetcor = ours(speed, restitution)
    # Tolerances at their tightest, so that what is compared is the minimum.
    tight = scipys(speed, restitution, jac=slopes, ftol=1e-15, xtol=1e-15, gtol=1e-15)
    plain = scipys(speed, restitution)
    print(f"scipy {scipy.__version__}, numpy {np.__version__}, {speed.size} runs, best of 10")
    agree = True
    for key in ("alpha", "beta", "se_alpha", "se_beta"):
        apart = abs(wetcor[key] / tight[key] - 1)
        agree &= apart <= AGREE
        print(f"{key:9} wetcor {wetcor[key]:+.10f}  curve_fit {tight[key]:+.10f}  apart {apart:.0e}")
    print(f"wetcor                            {1e6 * wetcor['seconds_per_fit']:8.2f} us a fit")
    for label, peer in (("curve_fit", plain), ("curve_fit, slopes in closed form", tight)):
        ratio = peer["seconds_per_fit"] / wetcor["seconds_per_fit"]
        print(f"{label:33} {1e6 * peer['seconds_per_fit']:8.2f} us a fit, {ratio:.0f} times ours")
    if not agree:
        sys.exit(f"the two sides differ by more than {AGREE} relative")


main()
