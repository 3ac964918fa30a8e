"""Times one series fit beside scipy's curve_fit, on the same 40 runs, and checks that both agree.

Usage: python3 benches/peers/series_fit.py   (needs requirements.txt and cargo)
"""
import json
import subprocess
import sys
import timeit

import wetcor

try:
    import numpy as np
    import scipy
    from scipy.optimize import curve_fit
except ImportError as missing:
    print(f"SKIPPED: {missing}; install benches/peers/requirements.txt to compare with scipy")
    sys.exit(0)

START = (0.7, -0.2)
AGREE = 1e-6


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
    program = wetcor.built("example", "series_fit_peer")
    table = "\n".join(f"{v!r},{e!r}" for v, e in zip(speed.tolist(), restitution.tolist()))
    return json.loads(subprocess.run([program], input=table, check=True, stdout=subprocess.PIPE, text=True).stdout)


def scipys(speed, restitution, **more):
    def once():
        return curve_fit(law, speed, restitution, **more)

    (alpha, beta), covariance = once()
    se_alpha, se_beta = np.sqrt(np.diag(covariance))
    best = min(timeit.repeat(once, number=100, repeat=10)) / 100
    return {"seconds_per_fit": best, "alpha": alpha, "beta": beta,
            "se_alpha": se_alpha, "se_beta": se_beta}


def main():
    speed, restitution = runs()
    mine = ours(speed, restitution)
    # tolerances at their tightest, so that what is compared is the minimum
    tight = scipys(speed, restitution, p0=START, jac=slopes, ftol=1e-15, xtol=1e-15, gtol=1e-15)
    started = scipys(speed, restitution, p0=START)
    # its own start, (1, 1), is the wrong side of beta; on the way some square roots are undefined
    with np.errstate(invalid="ignore"):
        plain = scipys(speed, restitution)
    print(f"scipy {scipy.__version__}, numpy {np.__version__}, {speed.size} runs, best of 10")
    agree = True
    for key in ("alpha", "beta", "se_alpha", "se_beta"):
        apart = abs(mine[key] / tight[key] - 1)
        agree &= apart <= AGREE
        print(f"{key:9} wetcor {mine[key]:+.10f}  curve_fit {tight[key]:+.10f}  apart {apart:.0e}")
    print(f"wetcor, no start given             {1e6 * mine['seconds_per_fit']:8.2f} us a fit")
    for label, peer in (("curve_fit, no start given", plain), ("curve_fit from a good start", started),
                        ("the same, slopes in closed form", tight)):
        ratio = peer["seconds_per_fit"] / mine["seconds_per_fit"]
        print(f"{label:34} {1e6 * peer['seconds_per_fit']:8.2f} us a fit, {ratio:.0f} times ours")
    if not agree:
        sys.exit(f"the two sides differ by more than {AGREE} relative")


main()
