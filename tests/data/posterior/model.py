"""States the model of an impact anew from its formulas: priors, likelihood and derived quantities of a scene here.

Every function takes numpy arrays of draws, or mpmath numbers with `f=mp` for any number of digits.
"""
import csv
import math
import pathlib
import tomllib

import mpmath as mp
import numpy as np
from scipy import special

HERE = pathlib.Path(__file__).resolve().parent
TURN = 0.01  # of m(r)
DEFAULTS = {
    "dry_k": {"lognormal": [0.15, 0.5]},
    "lubrication_log": {"lognormal": [3.0, 0.5]},
    "inertial_prefactor": {"lognormal": [1.0, 0.5]},
    "film_scale": {"lognormal": [0.07, 0.5]},
    "sigma_dry": {"half_normal": 0.1},
    "sigma_wet": {"half_normal": 0.1},
}


def log_prior(family, args, x, f=np):
    """Log of the normalised density; f is numpy, or mpmath for x of its numbers."""
    pi = f.pi
    gammaln = special.gammaln if f is np else f.loggamma
    if family == "lognormal":
        median, sd = args
        return -((f.log(x) - f.log(median)) / sd) ** 2 / 2 - f.log(x) - f.log(sd) - f.log(2 * pi) / 2
    if family == "half_normal":
        return -((x / args) ** 2) / 2 + f.log(2 / pi) / 2 - f.log(args)
    if family == "normal":
        mean, sd = args
        return -(((x - mean) / sd) ** 2) / 2 - f.log(sd) - f.log(2 * pi) / 2
    if family == "gamma":
        shape, rate = args
        return shape * f.log(rate) - gammaln(shape) + (shape - 1) * f.log(x) - rate * x
    if family == "uniform":
        low, high = args
        return -f.log(high - low) + 0 * x
    if family == "student_t":
        df, loc, scale = args
        z = (x - loc) / scale
        constant = gammaln((df + 1) / 2) - gammaln(df / 2) - f.log(df * pi) / 2 - f.log(scale)
        return constant - (df + 1) / 2 * f.log(1 + z * z / df)
    raise ValueError(family)


def exact(value):
    """The same numbers in mpmath."""
    return [exact(v) for v in value] if isinstance(value, list) else mp.mpf(value)


class Scene:
    """A scene with its runs, its parameters in order, their priors and their bounds."""

    def __init__(self, name):
        given = tomllib.loads((HERE / name / "scene.toml").read_text())
        self.name, self.truth = name, given["truth"]
        self.limit = given["data"].get("smallest_restitution", 0.0)
        model = given["model"]
        self.inertia = model.get("inertia", "stepwise")
        self.own_speed = model.get("dry_speed_m_s", 2.0) == "impact"
        self.dry, self.wet = [], []
        with open(HERE / name / "runs.csv", newline="") as table:
            for row in csv.DictReader(table):
                particle = given["particles"][row["particle"]]
                run = {"particle": row["particle"], "v": float(row["impact_speed_m_s"]), "e": float(row["restitution"])}
                if row["liquid"] == "dry":
                    self.dry.append(run)
                    continue
                liquid = given["liquids"][row["liquid"]]
                run |= {
                    "liquid": row["liquid"], "label": row["film_ratio"], "D": 1e-3 * float(row["diameter_mm"]),
                    "film_ratio": 1e-3 * float(row["film_um"]) / float(row["diameter_mm"]),
                    "density": particle["density_kg_m3"], "viscosity": 1e-3 * liquid["viscosity_mPa_s"],
                    "density_ratio": liquid["density_kg_m3"] / particle["density_kg_m3"],
                }
                self.wet.append(run)
        self.particles = sorted({run["particle"] for run in self.dry + self.wet})
        self.names = [f"dry_k[{p}]" for p in self.particles] + ["lubrication_log"]
        if self.inertia != "none":
            self.names.append("inertial_prefactor")
        if self.inertia == "saturating":
            self.names.append("film_scale")
        self.names += ["sigma_dry", "sigma_wet"]
        defaults = dict(DEFAULTS)
        if self.inertia == "saturating":
            defaults["inertial_prefactor"] = {"lognormal": [0.3, 0.5]}
        asked = given.get("priors", {})
        self.priors, self.bounds = {}, {}
        for symbol in self.names:
            bare, _, particle = symbol.rstrip("]").partition("[")
            prior = asked.get(f"{bare}.{particle}") or asked.get(bare) or defaults[bare]
            (family, args), = prior.items()
            self.priors[symbol] = family, args
            self.bounds[symbol] = (0.0, math.inf)
            if family == "uniform":
                self.bounds[symbol] = tuple(args)
            if bare == "dry_k":
                self.bounds[symbol] = (0.0, self.fastest(particle) ** -0.2)

    def fastest(self, particle):
        """Largest speed at which the dry restitution of a particle is used."""
        speeds = [run["v"] for run in self.dry if run["particle"] == particle]
        if self.own_speed:
            speeds += [run["v"] for run in self.wet if run["particle"] == particle]
        else:
            speeds.append(2.0)
        return max(speeds)

    def natural(self, u):
        """Parameters by name at unconstrained points (rows), and the log Jacobian."""
        at, jacobian = {}, 0.0
        for name, column in zip(self.names, np.asarray(u).T):
            low, high = self.bounds[name]
            if math.isinf(high):
                at[name] = np.exp(column)
                jacobian = jacobian + column
            else:
                at[name] = low + (high - low) * special.expit(column)
                jacobian = jacobian + math.log(high - low) + special.log_expit(column) + special.log_expit(-column)
        return at, jacobian

    def unconstrained(self, at):
        place = []
        for name in self.names:
            low, high = self.bounds[name]
            place.append(math.log(at[name]) if math.isinf(high) else special.logit((at[name] - low) / (high - low)))
        return np.array(place)

    def log_posterior(self, u):
        """Up to a constant, with respect to the unconstrained coordinates."""
        at, jacobian = self.natural(u)
        with np.errstate(all="ignore"):
            total = jacobian + self.log_priors(at) + self.log_likelihood(at)
        return np.where(np.isfinite(total), total, -np.inf)

    def log_priors(self, at, f=np):
        number = exact if f is mp else lambda args: args
        return sum(log_prior(family, number(args), at[name], f) for name, (family, args) in self.priors.items())

    def shape(self, x, at, f=np):
        if self.inertia == "stepwise":
            return x * (3 - 6 * x + 4 * x * x)
        if self.inertia == "cap":
            return 2 * x * (3 - 5 * x + 2 * x * x)
        return 1 - f.exp(-x / at["film_scale"])

    def inertial_loss(self, run, film_ratio, at, f=np):
        if self.inertia == "none":
            return 0
        return at["inertial_prefactor"] * run["density_ratio"] * self.shape(film_ratio, at, f)

    def log_likelihood(self, at, f=np):
        return self.log_likelihood_dry(at, f) + self.log_likelihood_wet(at, f)

    def log_likelihood_dry(self, at, f=np):
        means = {}
        for run in self.dry:
            key = run["particle"], run["v"]
            if key not in means:
                dry = 1 - at[f"dry_k[{run['particle']}]"] * power(run["v"], f)
                means[key] = mean_restitution(dry * dry, f)
        return noise(((run["e"], means[run["particle"], run["v"]]) for run in self.dry), at["sigma_dry"], self.limit, f)

    def log_likelihood_wet(self, at, f=np):
        means, runs = {}, []
        for run in self.wet:
            key = run["particle"], run["liquid"], run["D"], run["film_ratio"], run["v"]
            if key not in means:
                speed = run["v"] if self.own_speed else 2.0
                dry = 1 - at[f"dry_k[{run['particle']}]"] * power(speed, f)
                stokes = run["density"] * run["D"] * run["v"] / (9 * run["viscosity"])
                kept = dry * dry - self.inertial_loss(run, run["film_ratio"], at, f)
                kept = kept - 4 * at["lubrication_log"] / stokes
                means[key] = mean_restitution(kept, f)
            runs.append((run["e"], means[key]))
        return noise(runs, at["sigma_wet"], self.limit, f)

    def derived(self):
        """Names of the derived quantities with functions of the parameters; a negative radicand gives NaN."""
        quantities = {"delta_c_over_roughness": lambda at: np.exp(np.minimum(at["lubrication_log"], 700.0))}
        groups = {(run["particle"], run["liquid"], run["label"]): run for run in self.wet}
        for group, run in sorted(groups.items()):
            label = f"[{','.join(group)}]"

            def square(at, run=run):
                dry = 1 - at[f"dry_k[{run['particle']}]"] * 2.0**0.2
                kept = dry**2 - self.inertial_loss(run, float(run["label"]), at)
                return np.where(kept > 0, kept, np.nan)

            quantities["e_inf" + label] = lambda at, square=square: np.sqrt(square(at))
            quantities["st_c" + label] = lambda at, square=square: 2 * at["lubrication_log"] / square(at)
            quantities["st_no_rebound" + label] = lambda at, square=square: 4 * at["lubrication_log"] / square(at)
        return quantities


def power(speed, f):
    return speed**0.2 if f is np else f.mpf(speed) ** (f.mpf(1) / 5)


def mean_restitution(kept, f):
    return kept / f.sqrt(f.sqrt(kept * kept + TURN**4))


def log_phi(z, f=np):
    """Log of the standard normal's distribution function."""
    return special.log_ndtr(z) if f is np else f.log(f.erfc(-z / f.sqrt(2)) / 2)


def noise(runs, sigma, limit, f):
    """Log likelihood of runs (restitution, mean): normal where it rebounded, censored at the limit where it stuck."""
    total, constant = 0, f.log(2 * f.pi) / 2
    for e, mean in runs:
        if e <= limit:
            total = total + log_phi((limit - mean) / sigma, f)
        else:
            total = total - ((e - mean) / sigma) ** 2 / 2 - f.log(sigma) - constant
    return total
