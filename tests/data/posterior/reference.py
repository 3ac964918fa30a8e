"""Makes reference.json: what the posterior of each scene here is, by importance sampling, sharing no code with wetcor.

The model is written anew from its formulas in model.py. Each scene's posterior is sampled in unconstrained coordinates
from a mixture of multivariate t distributions fitted to pilot draws; every mean, sd and quantile has its Monte Carlo
error. Three scenes are integrated on a grid besides, and must agree. Densities with slopes: mpmath, 50 digits.

Usage: python3 reference.py   (numpy, scipy, mpmath; some ten minutes; the same numbers each time)
"""
import json
import math
import platform
import zlib

import mpmath as mp
import numpy as np
import scipy
from scipy import optimize, special, stats
from scipy.interpolate import CubicSpline

from model import HERE, Scene, exact, log_phi, log_prior

SCENES = [
    "stepwise", "stepwise_stuck", "impact_stuck", "cap", "saturating", "none", "bound", "weak", "few", "other_priors",
]
ON_A_GRID = ["none", "weak", "few"]
DRAWS = 4_000_000
PILOT = 200_000
CHUNK = 20_000
DEGREES = 6  # of freedom, of the proposal
COMPONENTS = 6
KHAT_MOST = 0.5
TAIL_MOST = 0.25  # of a quantity's own upper tail: four moments exist, as the errors of mean and sd need
ESS_LEAST = 1e5
GRID = 80
APART_MOST = 4.5  # Monte Carlo errors, between sampling and grid
mp.mp.dps = 50


class Proposal:
    """A mixture of multivariate t distributions."""

    def __init__(self, shares, centres, covariances):
        self.shares = np.array(shares) / np.sum(shares)
        self.parts = [stats.multivariate_t(c, s, df=DEGREES) for c, s in zip(centres, covariances)]

    def draw(self, count, rng):
        counts = rng.multinomial(count, self.shares)
        u = np.vstack([np.atleast_2d(part.rvs(n, random_state=rng)) for part, n in zip(self.parts, counts) if n])
        # chunks are taken in order: mix the components
        return rng.permutation(u)

    def log_density(self, u):
        each = [math.log(share) + part.logpdf(u) for share, part in zip(self.shares, self.parts)]
        return special.logsumexp(each, axis=0)


def in_chunks(function, u):
    return np.concatenate([np.atleast_1d(function(u[i:i + CHUNK])) for i in range(0, len(u), CHUNK)])


def weighted(scene, proposal, count, rng):
    u = proposal.draw(count, rng)
    log_weights = in_chunks(lambda part: scene.log_posterior(part) - proposal.log_density(part), u)
    weights = np.exp(log_weights - log_weights.max())
    return u, weights / weights.sum()


def mixture(u, weights, rng):
    """A proposal fitted to weighted draws by a few rounds of expectation and maximisation, with a wide part besides."""
    u = u[rng.choice(len(u), 40_000, p=weights)]
    overall = np.cov(u.T)
    centres, covariances = u[rng.choice(len(u), COMPONENTS)], [overall] * COMPONENTS
    shares = np.full(COMPONENTS, 1 / COMPONENTS)
    for _ in range(30):
        each = np.array([np.log(s) + stats.multivariate_normal(c, k).logpdf(u)
                         for s, c, k in zip(shares, centres, covariances)])
        belong = np.exp(each - special.logsumexp(each, axis=0))
        shares = belong.mean(axis=1)
        centres = [np.average(u, axis=0, weights=b) for b in belong]
        covariances = [np.cov(u.T, aweights=b) + 1e-3 * np.diag(np.diag(overall)) for b in belong]
    inflated = [1.1 * c for c in covariances]
    return Proposal([*(0.85 * shares), 0.15], [*centres, u.mean(axis=0)], [*inflated, 2.5 * overall])


def mode(scene, rng):
    """The mode and the covariance there, from several starts in the middle of the priors and about the truth."""
    def upside_down(u):
        value = -scene.log_posterior(u[None])[0]
        return value if math.isfinite(value) else 1e10

    middle = dict.fromkeys(scene.names, 0.05)
    for name in scene.names:
        if name.startswith("dry_k"):
            middle[name] = 0.5 * scene.bounds[name][1]
    middle["lubrication_log"] = 3.0
    if "inertial_prefactor" in middle:
        middle["inertial_prefactor"] = 0.5
    starts = [scene.unconstrained(place) for place in (middle, true_values(scene))]
    starts += [starts[1] + 0.3 * rng.standard_normal(len(scene.names)) for _ in range(4)]
    settings = {"maxiter": 20_000, "maxfev": 20_000, "xatol": 1e-6, "fatol": 1e-8}
    best = min((optimize.minimize(upside_down, s, method="Nelder-Mead", options=settings) for s in starts),
               key=lambda found: found.fun).x
    d, h = len(best), 1e-3
    hessian, steps = np.empty((d, d)), h * np.eye(d)
    for i in range(d):
        for j in range(d):
            corners = [best + steps[i] + steps[j], best + steps[i] - steps[j], best - steps[i] + steps[j],
                       best - steps[i] - steps[j]]
            a, b, c, e = map(upside_down, corners)
            hessian[i, j] = (a - b - c + e) / (4 * h * h)
    values, vectors = np.linalg.eigh((hessian + hessian.T) / 2)
    return best, (vectors / np.maximum(values, 0.5)) @ vectors.T


def true_values(scene):
    truth = dict(scene.truth)
    truth |= {f"dry_k[{p}]": k for p, k in truth["dry_k"].items()}
    return {name: truth[name] for name in scene.names}


def pareto_khat(weights):
    """Shape of the generalised Pareto tail of the weights, as Vehtari et al. estimate it (PSIS)."""
    count = min(len(weights) // 5, int(3 * math.sqrt(len(weights))))
    tail = np.sort(weights)[-count - 1:]
    x = tail[1:] - tail[0]
    n, m = len(x), 30 + int(math.sqrt(len(x)))
    theta = 1 / x[-1] + (1 - np.sqrt(m / (np.arange(1, m + 1) - 0.5))) / (3 * x[int(n / 4 + 0.5) - 1])
    k = np.array([np.mean(np.log1p(-t * x)) for t in theta])
    profile = n * (np.log(-theta / k) - k - 1)
    share = special.softmax(profile)
    khat = np.mean(np.log1p(-np.sum(theta * share) * x))
    return (khat * n + 5) / (n + 10)


def summary(x, weights, rng):
    """Mean, sd and quantiles of weighted draws, each with its Monte Carlo error (delta method); NaN is left out."""
    lost = float(weights[np.isnan(x)].sum())
    # a weight of zero may stand beside a number too large for f64
    keep = ~np.isnan(x) & (weights > 0)
    x, weights = x[keep], weights[keep] / weights[keep].sum()
    tail = pareto_khat(rng.choice(x, 100_000, p=weights))
    told = {}
    if tail < TAIL_MOST:
        mean = np.sum(weights * x)
        sd = math.sqrt(np.sum(weights * (x - mean) ** 2))
        told["mean"] = [mean, math.sqrt(np.sum((weights * (x - mean)) ** 2))]
        told["sd"] = [sd, math.sqrt(np.sum((weights * ((x - mean) ** 2 - sd * sd)) ** 2)) / (2 * sd)]
    order = np.argsort(x)
    ordered, each = x[order], weights[order]
    below = np.cumsum(each) - each / 2
    for label, p in (("q05", 0.05), ("median", 0.5), ("q95", 0.95)):
        at = np.interp(p, below, ordered)
        error = math.sqrt(np.sum((weights * ((x <= at) - p)) ** 2))
        ends = np.interp([p - error, p + error], below, ordered)
        told[label] = [at, (ends[1] - ends[0]) / 2]
    told = {label: {"value": float(v), "mcse": float(e)} for label, (v, e) in told.items()}
    if tail >= TAIL_MOST:
        told |= {"mean": None, "sd": None, "why_none": f"the upper tail has shape {tail:.2f}: moments need not exist"}
    told["undefined_share"] = lost
    return told


def sampled(scene, rng):
    centre, covariance = mode(scene, rng)
    proposal = Proposal([0.7, 0.3], [centre, centre], [1.5 * covariance, 6 * covariance])
    for _ in range(3):
        u, weights = weighted(scene, proposal, PILOT, rng)
        proposal = mixture(u, weights, rng)
    u, weights = weighted(scene, proposal, DRAWS, rng)
    ess, khat = float(1 / np.sum(weights**2)), float(pareto_khat(weights))
    print(f"{scene.name}: {len(scene.dry)} dry and {len(scene.wet)} wet runs, effective sample size {ess:.3g}, "
          f"k-hat {khat:.2f}", flush=True)
    if khat >= KHAT_MOST or ess < ESS_LEAST:
        raise SystemExit(f"{scene.name}: the proposal is not good enough")
    at, _ = scene.natural(u)
    told = {
        "sampling": {"draws": DRAWS, "ess": ess, "pareto_khat": khat},
        "bounds_dry_k": {name: scene.bounds[name][1] for name in scene.names if name.startswith("dry_k")},
        "priors": {name: {family: args} for name, (family, args) in scene.priors.items()},
        "parameters": {name: summary(at[name], weights, rng) for name in scene.names},
        "derived": {name: summary(function(at), weights, rng) for name, function in scene.derived().items()},
    }
    covariance = np.cov([at[n] for n in scene.names], aweights=weights)
    sds = np.sqrt(np.diag(covariance))
    told["correlation"] = (covariance / np.outer(sds, sds)).tolist()
    held = u[weights > 1e-13 * weights.max()]
    return told, (held.min(axis=0), held.max(axis=0)), u[rng.choice(len(u), 2, p=weights)]


def on_a_grid(scene, ends):
    """The marginals of a scene of one particle by the trapezoidal rule: the dry part given k, the wet part given k."""
    axes = dict(zip(scene.names, (np.linspace(low, high, GRID) for low, high in zip(*ends))))
    k_name, wet_names = scene.names[0], [n for n in scene.names[1:] if n != "sigma_dry"]
    density = {name: np.zeros(GRID) for name in scene.names}

    def natural(name, u):
        low, high = scene.bounds[name]
        if math.isinf(high):
            return np.exp(u), u
        x = low + (high - low) * special.expit(u)
        return x, special.log_expit(u) + special.log_expit(-u)

    def prior(names, at, jacobian):
        return sum(log_prior(*scene.priors[n], at[n]) + jacobian[n] for n in names)

    mesh = dict(zip(wet_names, np.meshgrid(*(axes[n] for n in wet_names), indexing="ij")))
    rows, dry_rows = [], []
    for u in axes[k_name]:
        k, k_jacobian = natural(k_name, u)
        sides = []
        for names, coordinates, likelihood in (
            (["sigma_dry"], axes, scene.log_likelihood_dry), (wet_names, mesh, scene.log_likelihood_wet),
        ):
            both = {n: natural(n, coordinates[n]) for n in names}
            at = {n: pair[0] for n, pair in both.items()} | {k_name: k}
            sides.append(likelihood(at) + prior(names, at, {n: pair[1] for n, pair in both.items()}))
        # the prior of k belongs to the whole: put it on one side
        dry_rows.append(sides[0] + log_prior(*scene.priors[k_name], k) + k_jacobian)
        rows.append(sides[1])
    top_dry, top_wet = np.max(dry_rows), max(row.max() for row in rows)
    for i, (dry, wet) in enumerate(zip(dry_rows, rows)):
        dry, wet = np.exp(dry - top_dry), np.exp(wet - top_wet)
        density[k_name][i] = dry.sum() * wet.sum()
        density["sigma_dry"] += dry * wet.sum()
        for axis, name in enumerate(wet_names):
            others = tuple(a for a in range(wet.ndim) if a != axis)
            density[name] += dry.sum() * wet.sum(axis=others)
    told = {}
    for name in scene.names:
        u, p = axes[name], density[name] / density[name].sum()
        x, _ = natural(name, u)
        mean = np.sum(p * x)
        spline = CubicSpline(u, p / (u[1] - u[0]))
        below = spline.antiderivative()
        fine = np.linspace(u[0], u[-1], 20_001)
        quantiles = np.interp([0.05, 0.5, 0.95], below(fine), fine)
        told[name] = {"mean": mean, "sd": math.sqrt(np.sum(p * (x - mean) ** 2))}
        told[name] |= dict(zip(("q05", "median", "q95"), natural(name, quantiles)[0]))
        told[name] = {label: float(value) for label, value in told[name].items()}
    return told


def furthest(grid, parameters):
    """Largest distance between grid and sampling, in Monte Carlo errors."""
    return max(abs(value - parameters[name][label]["value"]) / parameters[name][label]["mcse"]
               for name, values in grid.items() for label, value in values.items())


def density_points(scene, held, rng):
    """Five points: the truth, two of the posterior, and two far from it (half the bound of k, wide factors)."""
    places = [true_values(scene)]
    places += [{name: float(x) for name, x in scene.natural(u)[0].items()} for u in held]
    for _ in range(2):
        far = {}
        for name, value in true_values(scene).items():
            low, high = scene.bounds[name]
            far[name] = value * math.exp(0.7 * rng.standard_normal())
            if not low < far[name] < high:
                far[name] = low + rng.uniform(0.1, 0.9) * (high - low)
        places.append(far)
    return [{name: float(f"{value:.6g}") for name, value in place.items()} for place in places]


def with_slopes(function, place):
    """A function of named parameters with its slopes, in 50 digits."""
    at = {name: mp.mpf(value) for name, value in place.items()}
    slopes = {name: float(mp.diff(lambda x, name=name: function(at | {name: x}), at[name])) for name in at}
    return float(function(at)), slopes


def densities(scene, held, rng):
    rows = []
    for place in density_points(scene, held, rng):
        row = {"at": place}
        for label, function in (("log_likelihood", scene.log_likelihood), ("log_prior", scene.log_priors)):
            value, slopes = with_slopes(lambda at, function=function: function(at, mp), place)
            row |= {label: value, f"gradient_{label}": slopes}
            plain = float(np.sum(function({name: np.array(x) for name, x in place.items()})))
            assert abs(plain - value) <= 1e-9 * (1 + abs(value)), (scene.name, label, plain, value)
        rows.append(row)
    return rows


def log_phi_table():
    rows = []
    for z in [*np.arange(-40, 8.25, 0.5).tolist(), -1e-3, 1e-3, -5.3, -7.07, -13.37, -26.6, -37.7, 3.3]:
        value = log_phi(mp.mpf(z), mp)
        slope = mp.exp(-mp.mpf(z) ** 2 / 2 - value) / mp.sqrt(2 * mp.pi)
        rows.append({"z": z, "log_phi": float(value), "slope": float(slope)})
    return rows


def prior_table():
    """Densities of every family, held against SciPy's."""
    rows = []
    for family, args, points, oracle in (
        ("lognormal", [0.15, 0.5], [1e-3, 0.08, 0.15, 0.61, 7.0], stats.lognorm(0.5, scale=0.15)),
        ("lognormal", [3.0, 0.25], [0.4, 2.5, 3.0, 11.0], stats.lognorm(0.25, scale=3.0)),
        ("half_normal", 0.1, [1e-6, 0.03, 0.1, 0.95], stats.halfnorm(scale=0.1)),
        ("normal", [0.15, 0.03], [-0.2, 0.149, 0.15, 0.3], stats.norm(0.15, 0.03)),
        ("gamma", [9.0, 4.0], [0.05, 1.7, 2.25, 9.0], stats.gamma(9.0, scale=0.25)),
        ("gamma", [0.5, 2.0], [1e-4, 0.3, 4.0], stats.gamma(0.5, scale=0.5)),
        ("uniform", [0.02, 0.15], [0.021, 0.07, 0.149], stats.uniform(0.02, 0.13)),
        ("student_t", [4.0, 0.12, 0.02], [-0.5, 0.11, 0.12, 0.2, 30.0], stats.t(4.0, 0.12, 0.02)),
        ("student_t", [1.0, -1.0, 2.5], [-40.0, -1.0, 3.0], stats.t(1.0, -1.0, 2.5)),
    ):
        for x in points:
            def density(at, family=family, args=args):
                return log_prior(family, exact(args), at["x"], mp)

            value, slope = with_slopes(density, {"x": x})
            assert abs(value - oracle.logpdf(x)) <= 1e-11 * (1 + abs(value)), (family, args, x)
            rows.append({"family": family, "args": args, "x": x, "log_density": value, "slope": slope["x"]})
    return rows


def main():
    told = {
        "made_by": "tests/data/posterior/reference.py",
        "versions": {"python": platform.python_version(), "numpy": np.__version__, "scipy": scipy.__version__,
                     "mpmath": mp.__version__},
        "scenes": {},
    }
    disagreeing = []
    for name in SCENES:
        rng = np.random.default_rng(zlib.crc32(name.encode()))
        scene = Scene(name)
        row, ends, held = sampled(scene, rng)
        if name in ON_A_GRID:
            row["grid"] = {"points_an_axis": GRID, "parameters": on_a_grid(scene, ends)}
            apart = furthest(row["grid"]["parameters"], row["parameters"])
            row["grid"]["furthest_in_mcse"] = apart
            print(f"{name}: grid and sampling are {apart:.2f} Monte Carlo errors apart at most", flush=True)
            if apart > APART_MOST:
                disagreeing.append(name)
        row["densities"] = densities(scene, held, rng)
        told["scenes"][name] = row
    told["log_phi"] = log_phi_table()
    told["priors"] = prior_table()
    (HERE / "reference.json").write_text(json.dumps(told, indent=1) + "\n")
    print("reference.json written")
    if disagreeing:
        raise SystemExit(f"grid and sampling disagree: {disagreeing}")


if __name__ == "__main__":
    main()
