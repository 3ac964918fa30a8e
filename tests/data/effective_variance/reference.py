"""Fits a square-root law by effective variance in plain Python, without wetcor: python reference.py > reference.json

The definition stands in src/inference/effective_variance.rs; here it is written again, with derivatives by complex steps
and the minimum by Gauss-Newton. Needs numpy (made with 2.4.6).
"""

import json

import numpy as np

rng = np.random.default_rng(20161)
N = 40
v_true = np.geomspace(0.35, 3.0, 8).repeat(5)
s_v = v_true * rng.uniform(0.002, 0.03, N)
u = rng.uniform(0.001, 0.02, N)
s_v[::6] = 0.0
u[::4] = 0.0
e = np.sqrt(0.51 - 0.095 / v_true) + 0.006 * rng.standard_normal(N)
v = v_true + s_v * rng.standard_normal(N)
e = e * v_true / v + u * rng.standard_normal(N)
v, e, s_v, u = (np.round(column, 6) for column in (v, e, s_v, u))

law = lambda b, v: np.sqrt(b[0] + b[1] / v)
STEP = 1e-200
slope = lambda f, v: np.imag(f(v + 1j * STEP)) / STEP
jacobian = lambda b, v: np.stack([0.5 / law(b, v), 0.5 / law(b, v) / v], axis=-1)


def tau2(b):
    pull = law(b, v) / v + slope(lambda v: law(b, v), v)
    tau = u**2 + (s_v * pull) ** 2
    given = np.sort(tau[tau > 0])
    return np.where(tau > 0, tau, given[len(given) // 2]), pull


def intrinsic(r, tau, wanted):
    lo, hi = 0.0, 1.0
    if np.sum(r**2 / tau) <= wanted:
        return 0.0
    for _ in range(200):
        mid = 0.5 * (lo + hi)
        lo, hi = (mid, hi) if np.sum(r**2 / (mid + tau)) > wanted else (lo, mid)
    return hi


def fit(scale):
    """With the errors times a scale: a small one leaves an intrinsic spread, a large one explains too much."""
    global s_v, u
    kept = s_v, u
    s_v, u = s_v * scale, u * scale
    b = np.array([0.5, -0.09])
    for _ in range(400):
        tau, pull = tau2(b)
        r = law(b, v) - e
        sigma2 = intrinsic(r, tau, N - 2)
        w = 1.0 / (sigma2 + tau)
        J = jacobian(b, v)
        information = J.T @ (w[:, None] * J)
        b = b - np.linalg.solve(information, J.T @ (w * r))
    # the curvature in v by a real difference of the complex-step slope
    h = 1e-5 * v
    bend = (slope(lambda v: law(b, v), v + h) - slope(lambda v: law(b, v), v - h)) / (2 * h)
    J_slope = np.stack([slope(lambda v: jacobian(b, v)[:, j], v) for j in range(2)], axis=-1)
    expected = s_v[:, None] ** 2 * (J * (law(b, v) / v**2 - 0.5 * bend)[:, None] - J_slope * pull[:, None])
    covariance = np.linalg.inv(information)
    bias = covariance @ (w[:, None] * expected).sum(axis=0)
    final = law(b - bias, v) - e
    s_v, u = kept
    return {
        "scale": scale,
        "parameters": list(b - bias),
        "se": list(np.sqrt(np.diag(covariance))),
        "intrinsic_sd": float(np.sqrt(sigma2)),
        "bias": list(bias),
        "reduced_chi_squared": float(np.sum(final**2 / tau) / (N - 2)),
    }


columns = {"speed": v, "restitution": e, "impact_speed_sd": s_v, "restitution_sd": u}
print(json.dumps({"runs": {k: list(c) for k, c in columns.items()}, "fits": [fit(s) for s in (0.3, 1.0, 2.0)]}, indent=1))
