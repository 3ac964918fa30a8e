"""Draws hard and easy, and what ArviZ says of them: arviz_draws.csv, arviz_loo.csv and arviz_reference.json beside it.

Needs Python >= 3.12 with arviz (made with 1.3.0: arviz-base 1.3.1, arviz-stats 1.3.3, NumPy 2.5.5, SciPy 1.18.1):
python arviz_reference.py
"""

import json
import warnings
from pathlib import Path

import arviz as az
import numpy as np
from arviz_stats.base import array_stats
from arviz_stats.base.diagnostics import _DiagnosticsBase

HERE = Path(__file__).parent
rng = np.random.default_rng(20161121)
# the ways ArviZ goes inside, for what it does not offer by itself
inside = _DiagnosticsBase()
# constant draws divide by zero on the way to ArviZ's answer
warnings.simplefilter("ignore", RuntimeWarning)


def ar1(chains, draws, rho):
    x = np.empty((chains, draws))
    x[:, 0] = rng.normal(size=chains)
    for i in range(1, draws):
        x[:, i] = rho * x[:, i - 1] + np.sqrt(1 - rho**2) * rng.normal(size=chains)
    return x


def changed(x, index, value):
    x = x.copy()
    x[index] = value
    return x


plain = rng.normal(size=(4, 200))
CASES = {
    "independent": plain,
    "autocorrelated": ar1(4, 300, 0.97),
    "antithetic": ar1(4, 200, -0.9),
    "slightly_antithetic": ar1(4, 101, -0.3),
    "one_chain_shifted": plain + np.array([[0.0], [0.0], [0.0], [1.0]]),
    "one_chain_wider": plain * np.array([[1.0], [1.0], [1.0], [3.0]]),
    "one_chain_stuck": changed(plain, 2, 0.25),
    "drifting": plain + np.linspace(-1, 1, 200),
    "each_chain_still": np.repeat([[1.0], [2.0], [3.0], [4.0]], 50, axis=1),
    "constant": np.full((4, 50), 0.5),
    "with_nan": changed(plain, (1, 7), np.nan),
    "with_inf": changed(plain, (1, 7), np.inf),
    "counts": rng.poisson(3.0, size=(4, 150)).astype(float),
    "two_values": (rng.random((4, 100)) < 0.3).astype(float),
    "heavy_tails": rng.standard_cauchy(size=(4, 200)),
    "small_numbers": 3e-5 + 1e-6 * ar1(4, 150, 0.5),
    "large_offset": 1e4 + ar1(4, 150, 0.5),
    "odd": ar1(4, 101, 0.6),
    "one_chain": ar1(1, 200, 0.6),
    "two_chains": ar1(2, 151, 0.8),
    "ten_draws": rng.normal(size=(3, 10)),
    "five_draws": rng.normal(size=(2, 5)),
    "four_draws": rng.normal(size=(2, 4)),
}
CASES["heavy_tails_one_shifted"] = CASES["heavy_tails"] + np.array([[0.0], [0.0], [0.0], [2.0]])
# as they are written, so that the answers belong to the file
CASES = {name: np.vectorize(lambda v: float(f"{v:.10g}"))(x) for name, x in CASES.items()}


def rhat(x):
    if len(x) > 1:
        return array_stats.rhat(x, method="rank")
    # ArviZ asks for two chains; a single one is compared with itself, by ArviZ's own steps
    halves = inside._split_chains(x)
    folded = abs(halves - np.median(halves))
    return max(inside._rhat(inside._z_scale(y)) for y in (halves, folded))


def number(value):
    return float(value) if np.isfinite(value) else None


def answers(x):
    ess = lambda **kw: number(array_stats.ess(x, **kw))
    mcse = lambda **kw: number(array_stats.mcse(x, **kw))
    quantiles = np.quantile(x, [0.05, 0.5, 0.95]) if np.isfinite(x).all() else [np.nan] * 3
    return {
        "mean": number(x.mean()),
        "sd": number(x.std(ddof=1)),
        "q05": number(quantiles[0]),
        "median": number(quantiles[1]),
        "q95": number(quantiles[2]),
        "rhat": number(rhat(x)),
        "ess_bulk": ess(method="bulk"),
        "ess_tail": ess(method="tail", prob=(0.05, 0.95)),
        "ess_mean": ess(method="mean"),
        "ess_sd": ess(method="sd"),
        "ess_q30": ess(method="quantile", prob=0.3),
        "mcse_mean": mcse(method="mean"),
        "mcse_sd": mcse(method="sd"),
        "mcse_q05": mcse(method="quantile", prob=0.05),
        "mcse_q95": mcse(method="quantile", prob=0.95),
        "mcse_q30": mcse(method="quantile", prob=0.3),
        "e_bfmi": [number(v) for v in array_stats.bfmi(x)],
    }


def weights():
    """Log ratios with light, heavy and hopeless tails, few of them, and some too far apart for plain exponentials."""
    cases = {
        "light": 0.3 * rng.normal(size=400),
        "heavy": rng.standard_t(3, size=400),
        "hopeless": 5 * rng.normal(size=1000),
        "few": rng.normal(size=30),
        "far_apart": -300 * rng.exponential(size=300),
    }
    for name, x in cases.items():
        x = np.round(x, 8)
        r_eff = 0.8
        tail = int(inside._get_ps_tails(len(x), r_eff, "right"))
        smoothed, khat = array_stats.psislw(-x, r_eff=r_eff)
        yield name, {
            "log_ratios": x.tolist(),
            "r_eff": r_eff,
            "tail": tail,
            "khat": float(khat),
            "log_weights": smoothed.tolist(),
        }


def leave_one_out():
    """Two models of the same 9 runs, the last an outlier: a mean with known sd, and one with its sd unknown."""
    runs = np.append(rng.normal(size=8), 4.0)
    posterior = {
        "mean": np.round(runs.mean() + ar1(4, 150, 0.4) / 3, 8),
        "sd": np.round(np.exp(0.4 + 0.25 * ar1(4, 150, 0.6)), 8),
    }
    away = runs - posterior["mean"][..., None]
    scale = posterior["sd"][..., None]
    models = {
        "known": -0.5 * away**2 - 0.5 * np.log(2 * np.pi),
        "unknown": -0.5 * (away / scale) ** 2 - np.log(scale) - 0.5 * np.log(2 * np.pi),
    }
    models = {name: np.round(x, 8) for name, x in models.items()}
    rows, told, results = [], {}, {}
    for name, x in models.items():
        for run in range(len(runs)):
            rows.append(",".join([name, str(run), *(f"{v:.10g}" for v in x[..., run].ravel())]))
        tree = az.from_dict({"posterior": posterior, "log_likelihood": {"runs": x}})
        results[name] = az.loo(tree, pointwise=True)
        ess = [float(array_stats.ess(v, method="mean")) for v in posterior.values()]
        told[name] = {
            "ess_of_means": ess,
            "elpd": results[name].elpd,
            "se": results[name].se,
            "p_loo": results[name].p,
            "good_k": results[name].good_k,
            "elpd_i": results[name].elpd_i.values.tolist(),
            "khat": results[name].pareto_k.values.tolist(),
        }
    apart = (results["known"].elpd_i - results["unknown"].elpd_i).values
    # ArviZ's own dse divides by n
    told["difference"] = {"value": apart.sum(), "se": np.sqrt(len(apart) * apart.var(ddof=1))}
    (HERE / "arviz_loo.csv").write_text("\n".join(rows) + "\n")
    return told


lines = []
for name, x in CASES.items():
    for chain in x:
        lines.append(",".join([name, *(f"{v:.10g}" for v in chain)]))
reference = {
    "cases": {name: answers(x) for name, x in CASES.items()},
    "weights": dict(weights()),
    "loo": leave_one_out(),
}
(HERE / "arviz_draws.csv").write_text("\n".join(lines) + "\n")
# one entry a line
parts = [
    f'"{part}": {{\n' + ",\n".join(f'  "{name}": {json.dumps(v, allow_nan=False)}' for name, v in entries.items()) + "\n}"
    for part, entries in reference.items()
]
(HERE / "arviz_reference.json").write_text("{\n" + ",\n".join(parts) + "\n}\n")
