"""Opens a report's draws with arviz.from_zarr, warnings being errors, and holds ArviZ's diagnostics against its findings.

    python -W error tests/arviz_opens_draws.py REPORT_FOLDER

Needs Python >= 3.12 with arviz >= 1.3 and zarr (tried with arviz 1.3.0, arviz-stats 1.3.3, xarray 2026.9.0, zarr 3.4.2).
Prints R-hat, ESS (bulk, and tail at 5 %/95 %) and LOO as JSON. Compares with findings.json to 1e-8, relative:
posterior.parameters[*].{rhat, ess_bulk, ess_tail}, {value, rhat} of what follows from them among estimates, and
posterior.{e_bfmi, divergences} where they are there, and the entry of compare that the store's attribute `model` names; and the store with draws.csv, to
the last bit. Log likelihoods are stored as float32, in which ArviZ then sums, too: summed in float64 its LOO is held to
1e-8 (the largest shape to 1e-5), as it comes to a thousandth of the standard error. Exit status 1 on any difference,
missing group, variable without a single number, or warning.
"""

import csv
import json
import math
import re
import sys
import warnings
from collections import Counter
from pathlib import Path

# a reader that warns is not served without an adapter
warnings.simplefilter("error")

import arviz as az
import numpy as np
from arviz_stats.base import array_stats

GROUPS = [
    "posterior",
    "sample_stats",
    "log_likelihood",
    "log_prior",
    "posterior_predictive",
    "observed_data",
    "constant_data",
]
SAMPLE_STATS = ["lp", "acceptance_rate", "step_size", "tree_depth", "n_steps", "diverging", "energy"]
TAIL = (0.05, 0.95)
RELATIVE = 1e-8

wrong = []


def compare(what, arviz, ours, relative=RELATIVE, absolute=0.0):
    """Nothing is null in findings and not a number in ArviZ; all else is equal to 1e-8, or as far as is said."""
    none = ours is None, arviz is None or not math.isfinite(arviz)
    if any(none):
        if not all(none):
            wrong.append(f"{what}: ArviZ {arviz}, findings {ours}")
    elif not math.isclose(arviz, ours, rel_tol=relative, abs_tol=absolute):
        wrong.append(f"{what}: ArviZ {arviz!r}, findings {ours!r}")


def draws_of(posterior, name):
    """Chains by draws of `dry_k[PTFE]`: the variable before the bracket, at the labels in it, dimension by dimension."""
    variable, labels = re.fullmatch(r"([^\[]*)(?:\[(.*)\])?", name).groups()
    array = posterior[variable]
    dimensions = [d for d in array.dims if d not in ("chain", "draw")]
    # the label of a setting has commas of its own
    labels = [] if not labels else [labels] if len(dimensions) == 1 else labels.split(",")
    if len(labels) != len(dimensions):
        raise KeyError(f"{name}: the variable has the dimensions {dimensions}")
    for dimension, label in zip(dimensions, labels):
        names = [str(x) for x in posterior[dimension].values]
        array = array.isel({dimension: names.index(label)})
    return array.transpose("chain", "draw").values


def loo_of(tree):
    """ArviZ's PSIS-LOO. That shapes are above the threshold it says by a warning: this one is a finding, and passes."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Estimated shape parameter of Pareto distribution")
        loo = az.loo(tree, pointwise=True)
    # runs that stuck for certain have no log likelihood to speak of: nothing in the sum, but runs all the same
    elpd = np.zeros(tree.observed_data.sizes["run"])
    elpd[: loo.elpd_i.size] = loo.elpd_i.values.ravel()
    return {
        "elpd_loo": float(loo.elpd),
        "se": float(np.sqrt(elpd.size * elpd.var(ddof=1))),
        "p_loo": float(loo.p),
        "khat_max": float(loo.pareto_k.max()),
    }


def main(folder):
    findings = json.loads((folder / "findings.json").read_text())
    told = findings["posterior"]
    tree = az.from_zarr(folder / "draws" / "draws.zarr")
    tree.load()
    for group in GROUPS:
        if group not in tree.children:
            wrong.append(f"there is no group {group}")
    if wrong:
        return {}
    for name in SAMPLE_STATS:
        if name not in tree.sample_stats:
            wrong.append(f"sample_stats has no {name}")

    for group in GROUPS:
        for name, variable in tree[group].data_vars.items():
            # a chunk that is not there is read as nothing but NaN, without a word
            if variable.dtype.kind == "f" and np.isnan(variable.values).all():
                wrong.append(f"{group}/{name} has no number")

    with open(folder / "draws" / "draws.csv", newline="") as file:
        header, *rows = csv.reader(file)
    parameters = {}
    for parameter in told["parameters"]:
        x = draws_of(tree.posterior, parameter["name"])
        column = header.index(parameter["name"])
        if not np.array_equal(x.ravel(), [float(row[column]) for row in rows]):
            wrong.append(f"{parameter['name']}: draws.csv and draws.zarr differ")
        said = {
            "rhat": float(array_stats.rhat(x, method="rank")),
            "ess_bulk": float(array_stats.ess(x, method="bulk")),
            "ess_tail": float(array_stats.ess(x, method="tail", prob=TAIL)),
        }
        parameters[parameter["name"]] = said
        for name, value in said.items():
            compare(f"{parameter['name']} {name}", value, parameter[name])
    seen = Counter()
    for row in findings["estimates"]:
        if row["source"] != "posterior" or "rhat" not in row:
            continue
        name = row["quantity"]
        # rows of a quantity stand in the order of its labels
        labels = [d for d in tree.derived[name].dims if d not in ("chain", "draw")]
        x = tree.derived[name].isel({d: seen[name] for d in labels}).transpose("chain", "draw").values
        seen[name] += 1
        finite = bool(np.isfinite(x).all())
        compare(f"{name} {seen[name]} mean", float(x.mean()) if finite else None, row["value"])
        compare(f"{name} {seen[name]} rhat", float(array_stats.rhat(x, method="rank")) if finite else None, row["rhat"])

    # the table a user would ask for, whatever its rounding
    az.summary(tree, kind="diagnostics")

    e_bfmi = [float(x) for x in np.atleast_1d(array_stats.bfmi(tree.sample_stats["energy"].values))]
    for chain, (arviz, ours) in enumerate(zip(e_bfmi, told.get("e_bfmi") or [])):
        compare(f"e_bfmi of chain {chain + 1}", arviz, ours)
    divergences = int(tree.sample_stats["diverging"].sum())
    if told.get("divergences", divergences) != divergences:
        wrong.append(f"divergences: stored {divergences}, findings {told['divergences']}")

    loo = loo_of(tree)
    tree["log_likelihood"] = tree["log_likelihood"].to_dataset().astype(np.float64)
    in_double = loo_of(tree)
    model = tree.attrs.get("model")
    own = [entry for entry in findings.get("compare") or [] if entry["model"] == model]
    if len(own) == 1:
        for name, value in loo.items():
            compare(f"{model} {name}", value, own[0][name], 0.0, 1e-3 * own[0]["se"])
            # a shape is fitted to how little weights differ, and moves by 1e-4 of it with the rounding of what is stored
            shape = 5e-4 if name == "khat_max" else RELATIVE
            compare(f"{model} {name} in float64", in_double[name], own[0][name], shape)
    else:
        wrong.append(f"compare has {len(own)} entries of the store's model {model!r}")
    return {"parameters": parameters, "e_bfmi": e_bfmi, "divergences": divergences, "loo": {"model": model, **loo}}


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print(json.dumps(main(Path(sys.argv[1])), indent=1))
    for line in wrong:
        print(line, file=sys.stderr)
    sys.exit(1 if wrong else 0)
