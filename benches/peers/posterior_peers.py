"""Times the posterior of 2,000 runs by `wetcor fit` beside PyMC with nutpie and beside PyStan, all of one posterior.

With `--own-films` the film of every wet run is taken times a normal number about 1 with the sd 0.02, as where a laboratory
measures each: no two settings are then the same. With `--stepwise` the inertial loss is stepwise, which has no film scale, and runs
that stuck are left out: nutpie needs no tail of a normal then, so that this is where it is at its best; PyStan is not run.

Each side is a process of its own, with empty compile caches, and samples 4 chains of 1,000 + 1,000 draws on two cores.
Reported: smallest bulk effective sample size over the sampled parameters (ArviZ's for the peers, findings.json's for
ours), seconds of sampling alone, and seconds from process start to exit, compiling included; of ours the medians over
some processes.

Usage: python3 benches/peers/posterior_peers.py [--own-films | --stepwise] [runs]   (needs cargo; the peers of posterior_requirements.txt and, for
PyStan, a C++ compiler)
"""
import csv
import json
import math
import os
import pathlib
import random
import shutil
import statistics
import sys
import tempfile
import time
import tomllib

CHAINS, WARMUP, DRAWS, CORES, SEED = 4, 1000, 1000, 2, 1
REPEATS = 9
REFERENCE_SPEED = 2.0
PRIORS = {  # the defaults of a scene with saturating inertia: median and sd of the log, or the scale of a half-normal
    "dry_k": (0.15, 0.5), "lubrication_log": (3.0, 0.5), "inertial_prefactor": (0.3, 0.5), "film_scale": (0.07, 0.5),
    "sigma_dry": 0.1, "sigma_wet": 0.1,
}
FILM_SPREAD = 0.02
# times ours in samples a second, and in the whole process
TARGETS = {"nutpie": (150, 50), "pystan": (500, 100)}
TARGETS_OF_OWN_FILMS = {"nutpie": (150, 50), "pystan": (700, 70)}
TARGETS_STEPWISE = {"nutpie": (20, 50)}
STEPWISE_PRIORS = {**PRIORS, "inertial_prefactor": (1.0, 0.5)}
del STEPWISE_PRIORS["film_scale"]
STAN = """
data {
  int P; int D; int W; int S;
  real k_max; real reference; real limit;
  array[D] int dry_particle; vector[D] dry_power; vector[D] dry_e;
  array[W] int particle; vector[W] film_ratio; vector[W] density_ratio; vector[W] inverse_stokes; vector[W] e;
  array[S] int stuck_particle; vector[S] stuck_film_ratio; vector[S] stuck_density_ratio;
  vector[S] stuck_inverse_stokes;
}
parameters {
  vector<lower=0, upper=k_max>[P] dry_k;
  real<lower=0> lubrication_log; real<lower=0> inertial_prefactor; real<lower=0> film_scale;
  real<lower=0> sigma_dry; real<lower=0> sigma_wet;
}
model {
  vector[P] kept_dry = square(1 - dry_k * reference);
  vector[W] r = kept_dry[particle] + inertial_prefactor * density_ratio .* expm1(-film_ratio / film_scale)
                - 4 * lubrication_log * inverse_stokes;
  vector[S] q = kept_dry[stuck_particle]
                + inertial_prefactor * stuck_density_ratio .* expm1(-stuck_film_ratio / film_scale)
                - 4 * lubrication_log * stuck_inverse_stokes;
  dry_k ~ lognormal(log(0.15), 0.5);
  lubrication_log ~ lognormal(log(3.0), 0.5);
  inertial_prefactor ~ lognormal(log(0.3), 0.5);
  film_scale ~ lognormal(log(0.07), 0.5);
  sigma_dry ~ normal(0, 0.1);
  sigma_wet ~ normal(0, 0.1);
  dry_e ~ normal(1 - dry_k[dry_particle] .* dry_power, sigma_dry);
  e ~ normal(r ./ sqrt(sqrt(square(r) + 1e-8)), sigma_wet);
  target += normal_lcdf(limit | q ./ sqrt(sqrt(square(q) + 1e-8)), sigma_wet);
}
"""


def data(scene):
    """The runs as columns: dry runs, wet rebounds and stuck wet runs."""
    given = tomllib.loads(pathlib.Path(scene).read_text())
    inertia = given["model"].get("inertia")
    model = {"dry_speed_m_s": REFERENCE_SPEED, "inertia": inertia, "noise": "restitution"}
    if given["model"] != model or inertia not in ("saturating", "stepwise") or "priors" in given:
        sys.exit("the model of the scene has changed: change the peers' with it")
    names = sorted(given["particles"])
    limit = given["data"]["smallest_restitution"]
    columns = {"names": names, "limit": limit, "stepwise": inertia == "stepwise", "dry": [], "wet": [], "stuck": []}
    fastest = dict.fromkeys(names, REFERENCE_SPEED)
    with open(pathlib.Path(scene).with_name("runs.csv"), newline="") as table:
        for run in csv.DictReader(table):
            name, e, v = run["particle"], float(run["restitution"]), float(run["impact_speed_m_s"])
            if run["liquid"] == "dry":
                fastest[name] = max(fastest[name], v)
                columns["dry"].append((names.index(name), v**0.2, e))
                continue
            particle, liquid = given["particles"][name], given["liquids"][run["liquid"]]
            diameter = 1e-3 * float(run["diameter_mm"])
            stokes = particle["density_kg_m3"] * diameter * v / (9e-3 * liquid["viscosity_mPa_s"])
            row = (names.index(name), 1e-6 * float(run["film_um"]) / diameter,
                   liquid["density_kg_m3"] / particle["density_kg_m3"], 1 / stokes, e)
            columns["stuck" if e <= limit else "wet"].append(row)
    # one bound for all: the fastest dry run of each particle is the same here
    (columns["k_max"],) = {v**-0.2 for v in fastest.values()}
    return columns


def rewrite(scene, changed):
    """Puts what `changed` makes of the rows of the scene's table in their place."""
    table = pathlib.Path(scene).with_name("runs.csv")
    with open(table, newline="") as file:
        reader = csv.DictReader(file)
        names, rows = reader.fieldnames, list(reader)
    with open(table, "w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(changed(rows))


def with_films_of_their_own(rows):
    """Every wet film times a normal number."""
    rng = random.Random(SEED)
    for row in rows:
        if row["liquid"] != "dry":
            row["film_um"] = float(row["film_um"]) * rng.gauss(1.0, FILM_SPREAD)
    return rows


def without_stuck(rows):
    import wetcor

    limit = tomllib.loads(wetcor.SCENE.read_text())["data"]["smallest_restitution"]
    return [row for row in rows if float(row["restitution"]) > limit]


def priors_of(columns):
    return STEPWISE_PRIORS if columns["stepwise"] else PRIORS


def nutpie_draws(columns):
    import numpy as np
    import nutpie
    import pymc as pm
    import pytensor.tensor as pt

    def lognormal(name):
        median, sd = priors[name]
        return {"mu": math.log(median), "sigma": sd}

    def mean(runs, dry_k, lubrication_log, inertial_prefactor, film_scale=None):
        particle, x, density_ratio, inverse_stokes, _ = runs
        kept_dry = (1 - dry_k * REFERENCE_SPEED**0.2) ** 2
        shape = -pt.expm1(-x / film_scale) if film_scale is not None else x * (3 - 6 * x + 4 * x**2)
        r = kept_dry[particle.astype(int)] - inertial_prefactor * density_ratio * shape
        r = r - 4 * lubrication_log * inverse_stokes
        return r / pt.sqrt(pt.sqrt(r**2 + 1e-8))

    priors = priors_of(columns)
    dry, wet, stuck = (np.array(columns[kind]).T for kind in ("dry", "wet", "stuck"))
    with pm.Model() as model:
        law = pm.LogNormal.dist(**lognormal("dry_k"))
        dry_k = pm.Truncated("dry_k", law, lower=0.0, upper=columns["k_max"], shape=len(columns["names"]))
        names = [n for n in ("lubrication_log", "inertial_prefactor", "film_scale") if n in priors]
        others = [pm.LogNormal(n, **lognormal(n)) for n in names]
        sigma_dry = pm.HalfNormal("sigma_dry", PRIORS["sigma_dry"])
        sigma_wet = pm.HalfNormal("sigma_wet", PRIORS["sigma_wet"])
        pm.Normal("dry", 1 - dry_k[dry[0].astype(int)] * dry[1], sigma_dry, observed=dry[2])
        pm.Normal("wet", mean(wet, dry_k, *others), sigma_wet, observed=wet[4])
        if stuck.size:
            sticking = pm.Normal.dist(mean(stuck, dry_k, *others), sigma_wet)
            pm.Potential("stuck", pm.logcdf(sticking, columns["limit"]).sum())
    compiled = nutpie.compile_pymc_model(model)
    started = time.perf_counter()
    trace = nutpie.sample(compiled, draws=DRAWS, tune=WARMUP, chains=CHAINS, cores=CORES, seed=SEED, progress_bar=False)
    seconds = time.perf_counter() - started
    draws = {}
    for name in priors:
        values = trace.posterior[name].values
        if name == "dry_k":
            draws |= {f"dry_k[{p}]": values[..., i] for i, p in enumerate(columns["names"])}
        else:
            draws[name] = values
    version = f"nutpie {nutpie.__version__}, PyMC {pm.__version__}"
    return draws, seconds, int(trace.sample_stats["diverging"].sum()), version


def pystan_draws(columns):
    import importlib.metadata

    import numpy as np
    import stan

    table = {kind: [list(column) for column in zip(*columns[kind])] for kind in ("dry", "wet", "stuck")}
    given = {"P": len(columns["names"]), "k_max": columns["k_max"], "reference": REFERENCE_SPEED**0.2,
             "limit": columns["limit"]}
    given |= dict(zip("DWS", (len(columns[kind]) for kind in ("dry", "wet", "stuck"))))
    given |= {"dry_particle": [1 + i for i in table["dry"][0]], "dry_power": table["dry"][1], "dry_e": table["dry"][2]}
    for prefix, (particle, *rest) in (("", table["wet"]), ("stuck_", table["stuck"])):
        given[prefix + "particle"] = [1 + i for i in particle]
        given |= dict(zip((prefix + n for n in ("film_ratio", "density_ratio", "inverse_stokes")), rest))
    given["e"] = table["wet"][4]
    built = stan.build(STAN, data=given, random_seed=SEED)
    started = time.perf_counter()
    fit = built.sample(num_chains=CHAINS, num_samples=DRAWS, num_warmup=WARMUP)
    seconds = time.perf_counter() - started

    def chains(rows):
        # PyStan gives draws by chain last, chains running fastest
        return np.asarray(rows).reshape(DRAWS, CHAINS).T

    draws = {f"dry_k[{p}]": chains(fit["dry_k"][i]) for i, p in enumerate(columns["names"])}
    draws |= {name: chains(fit[name][0]) for name in PRIORS if name != "dry_k"}
    return draws, seconds, int(fit["divergent__"].sum()), f"PyStan {importlib.metadata.version('pystan')}"


def peer(name, scene, out):
    """One peer in its own process: samples and writes what came out."""
    # PyStan leaves a build folder where it runs
    os.chdir(pathlib.Path(out).parent)
    draws, seconds, divergences, version = {"nutpie": nutpie_draws, "pystan": pystan_draws}[name](data(scene))
    import arviz

    rows = {parameter: {"mean": float(x.mean()), "sd": float(x.std(ddof=1)),
                        "rhat": float(arviz.rhat(x)), "ess_bulk": float(arviz.ess(x, method="bulk"))}
            for parameter, x in draws.items()}
    told = {"version": version, "seconds": seconds, "divergences": divergences, "parameters": rows}
    pathlib.Path(out).write_text(json.dumps(told))


def ours(program, scene, folder):
    """Ours at its median over some processes, since one is over before a machine settles; each into the place of the one
    before, whose draws are removed."""
    import wetcor

    whole, sampling = [], []
    out = pathlib.Path(folder, "posterior")
    for _ in range(REPEATS):
        shutil.rmtree(out, ignore_errors=True)
        fit = [program, "fit", scene, "--stages", "least_squares,posterior", "--threads", str(CORES), "--quiet"]
        seconds, _, status = wetcor.measured([*fit, "--out", out])
        if status not in (0, 1):
            print(f"OURS NOT MEASURED: `wetcor fit --stages least_squares,posterior` ended with status {status}")
            return None
        findings = json.loads((out / "findings.json").read_text())
        whole.append(seconds)
        sampling.append(json.loads((out / "timing.json").read_text()).get("posterior_sampling"))
        if findings.get("posterior") is None or sampling[-1] is None:
            print("OURS NOT MEASURED: the report has no posterior, or timing.json no `posterior_sampling`")
            return None
    print(f"wetcor, {REPEATS} processes: {min(whole):.2f} to {max(whole):.2f} s, sampling {min(sampling):.3f} to "
          f"{max(sampling):.3f} s; medians are told")
    rows = {row["name"]: row for row in findings["posterior"]["parameters"]}
    return {"version": f"wetcor {findings['wetcor']}", "seconds": statistics.median(sampling),
            "whole": statistics.median(whole), "parameters": rows,
            "divergences": findings["posterior"]["divergences"]}


def theirs(name, scene, folder):
    import wetcor

    out = pathlib.Path(folder, f"{name}.json")
    # where PyTensor, Numba and httpstan would find what an earlier run compiled
    caches = pathlib.Path(folder, name)
    caches.mkdir()
    os.environ |= {"PYTENSOR_FLAGS": f"base_compiledir={caches}", "NUMBA_CACHE_DIR": str(caches),
                   "XDG_CACHE_HOME": str(caches), "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    whole, _, status = wetcor.measured([sys.executable, __file__, "--peer", name, scene, out])
    if status != 0:
        print(f"SKIPPED {name}: its process ended with status {status}; see posterior_requirements.txt")
        return None
    return json.loads(out.read_text()) | {"whole": whole}


def rate(told):
    return min(row["ess_bulk"] for row in told["parameters"].values()) / told["seconds"]


# a table's targets, and what becomes of its rows
TABLES = {
    None: (TARGETS, lambda rows: rows),
    "--own-films": (TARGETS_OF_OWN_FILMS, with_films_of_their_own),
    "--stepwise": (TARGETS_STEPWISE, without_stuck),
}


def main():
    if sys.argv[1:2] == ["--peer"]:
        return peer(*sys.argv[2:])
    import wetcor

    arguments = sys.argv[1:]
    kind = next((argument for argument in arguments if argument in TABLES), None)
    arguments = [argument for argument in arguments if argument != kind]
    runs = int(arguments[0]) if arguments else 2_000
    targets, changed = TABLES[kind]
    program = wetcor.built("bin", "wetcor")
    print(f"{runs} runs{' ' + kind if kind else ''}, {CHAINS} chains of {WARMUP} + {DRAWS}, {CORES} of {os.cpu_count()} cores, "
          f"load {os.getloadavg()[0]:.1f} at the start", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        inertia = "stepwise" if kind == "--stepwise" else "saturating"
        scene = wetcor.simulated(program, runs, folder, inertia)
        rewrite(scene, changed)
        results = {"wetcor": ours(program, scene, folder)}
        results |= {name: theirs(name, scene, folder) for name in targets}
    for name, told in results.items():
        if told is None:
            continue
        smallest = min(row["ess_bulk"] for row in told["parameters"].values())
        print(f"{told['version']:32} smallest bulk ESS {smallest:6.0f}, sampling {told['seconds']:8.3f} s, "
              f"{rate(told):9.0f} a second, whole process {told['whole']:7.2f} s, {told['divergences']} divergences")
        for parameter, row in told["parameters"].items():
            print(f"    {parameter:20} mean {row['mean']:.6g}  sd {row['sd']:.4g}  R-hat {row['rhat']:.4f}  "
                  f"bulk ESS {row['ess_bulk']:.0f}")
    mine = results["wetcor"]
    for name, (samples, process) in targets.items():
        if mine and results[name]:
            faster, sooner = rate(mine) / rate(results[name]), results[name]["whole"] / mine["whole"]
            print(f"beside {name}: {faster:.0f} times the effective samples a second (target {samples}), "
                  f"{sooner:.0f} times faster as a process (target {process})")


main()
