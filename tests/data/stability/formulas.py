"""Writes formulas.csv: every formula, its slopes and its condition number in 50 digits, over the extremes of its arguments.

python3 formulas.py            needs mpmath 1.3 or later; half a minute

A line is `name;arguments;answers`, both lists separated by blanks. Arguments are exact doubles. An answer is
value:rest:condition: the double nearest to the exact value, what the exact value has beyond it in units of its last
place, and the condition number sum |x_i df/dx_i| / |f| over the arguments. A line whose name begins with `fit` holds
value:se pairs instead: the least-squares parameters and their standard errors.
The formulas are written anew from the definitions in the comments; nothing is taken from the program's own code.
"""
import math
import random
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 60
DIGITS = 50
TAU = mpf("0.01")
FIFTH = mpf(1) / 5
random.seed("wetcor stability")
lines = []


def between(lo, hi):
    """A number of four digits, its logarithm uniform."""
    return float(f"{math.exp(random.uniform(math.log(lo), math.log(hi))):.3e}")


def ulp(x):
    return math.ulp(x)


def answer(functions, arguments):
    exact = [mpf(x) for x in arguments]
    parts = []
    for f in functions:
        value = f(*exact)
        if value == 0:
            parts.append("0:0:0")
            continue
        if not mpf("1e-290") < abs(value) < mpf("1e290"):
            return None
        step = mpf(10) ** -20
        condition = mpf(0)
        for i, x in enumerate(exact):
            up, down = list(exact), list(exact)
            up[i], down[i] = x * (1 + step), x * (1 - step)
            condition += abs(f(*up) - f(*down)) / (2 * step)
        condition /= abs(value)
        nearest = float(value)
        rest = (value - mpf(nearest)) / mpf(ulp(nearest))
        parts.append(f"{nearest!r}:{mp.nstr(rest, 3)}:{mp.nstr(condition, 3)}")
    return " ".join(parts)


def write(name, functions, points):
    for arguments in points:
        parts = answer(functions, arguments)
        if parts is not None:
            lines.append(f"{name};{' '.join(short(x) for x in arguments)};{parts}")


def short(x):
    text = repr(x)
    return text[:-2] if text.endswith(".0") else text


def points(count, *ranges):
    return [[between(*r) if isinstance(r, tuple) else r for r in ranges] for _ in range(count)]


SPEED = (1e-12, 1e12)
FILM_RATIO = (1e-15, 0.5)
STOKES = (1e-9, 1e15)
DENSITY = (1.0, 2.5e4)
DIAMETER = (1e-9, 10.0)
VISCOSITY = (1e-6, 1e4)
NEAR = [1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15]


def towards(limit, sides=(-1, 1)):
    """Numbers that approach a limit from both sides."""
    return [limit * (1 + side * gap) for gap in NEAR for side in sides]


# --- numbers.rs -------------------------------------------------------------------------------------------------
write("numbers::stokes", [lambda r, d, v, eta: r * d * v / (9 * eta)], points(40, DENSITY, DIAMETER, SPEED, VISCOSITY))
write("numbers::reynolds", [lambda r, f, v, eta: r * f * v / eta], points(40, DENSITY, DIAMETER, SPEED, VISCOSITY))
write("numbers::free_fall_speed", [lambda h: mp.sqrt(2 * mpf("9.81") * h)], points(30, (1e-24, 1e24)))

# --- dry.rs: e = 1 - k v^(1/5) -------------------------------------------------------------------------------------
K = (1e-6, 10.0)
dry_points = points(40, K, SPEED) + [[k, v] for k in (0.123, 0.183) for v in towards(k**-5)]
write(
    "dry::restitution",
    [
        lambda k, v: 1 - k * v**FIFTH,
        lambda k, v: -(v**FIFTH),
        lambda k, v: -k * v ** (-4 * FIFTH) / 5,
    ],
    dry_points,
)
write(
    "dry::restitution_second_order",
    [
        lambda k, v: 1 - k * v**FIFTH + 3 * (k * v**FIFTH) ** 2 / 5,
        lambda k, v: -(v**FIFTH) + 6 * k * v ** (2 * FIFTH) / 5,
    ],
    points(40, K, SPEED) + [[k, v] for k in (0.123, 0.183) for v in towards((5 / 6 / k) ** 5)],
)
write("dry::speed_limit", [lambda k: k**-5], points(30, (1e-12, 1e12)))

# --- inertia.rs: g and its slopes in the film ratio and the film scale ----------------------------------------------------
write(
    "inertia::stepwise",
    [lambda x: x * (3 - 6 * x + 4 * x * x), lambda x: 3 * (1 - 2 * x) ** 2],
    points(40, FILM_RATIO) + [[x] for x in towards(0.5, (-1,))],
)
write(
    "inertia::cap",
    [lambda x: 2 * x * (3 - 5 * x + 2 * x * x), lambda x: 6 - 20 * x + 12 * x * x],
    points(40, FILM_RATIO) + [[x] for x in towards((10 - math.sqrt(28)) / 12)],
)
write(
    "inertia::saturating",
    [
        lambda x, s: -mp.expm1(-x / s),
        lambda x, s: mp.exp(-x / s) / s,
        lambda x, s: -x / s**2 * mp.exp(-x / s),
    ],
    points(40, FILM_RATIO, (1e-3, 1.0)) + points(20, (1e-3, 0.5), (1e-3, 0.1)) + points(10, (0.05, 0.5), (1e-3, 5e-3)),
)

# --- viscous.rs -------------------------------------------------------------------------------------------------------------
L = (1e-3, 30.0)
write("viscous::loss", [lambda l, st: 4 * l / st, lambda l, st: 4 / st], points(40, L, STOKES))
write("viscous::beta", [lambda l, eta, r, d: -36 * eta * l / (r * d)], points(30, L, VISCOSITY, DENSITY, DIAMETER))
write(
    "viscous::st_c",
    [lambda l, e: 2 * l / e**2, lambda l, e: 4 * l / e**2],
    points(30, L, (1e-12, 1.0)),
)
write("viscous::lubrication_log", [lambda e, st: st * e * e / 2], points(30, (1e-12, 1.0), STOKES))
write("viscous::critical_separation", [lambda eps, l: eps * mp.exp(l)], points(30, (1e-12, 1e-3), (1e-6, 300.0)))

# --- bridge.rs --------------------------------------------------------------------------------------------------------------
volume = lambda d, f: mp.pi * f**2 * (d / 2 - f / 3)
bridge_points = [[g, r, d, float(f"{x * d:.4e}")] for g, r, d, x in points(40, (1e-4, 1.0), DENSITY, DIAMETER, FILM_RATIO)]
write("bridge::volume", [volume], [p[2:] for p in bridge_points] + [[0.003, 0.003], [2e-12, 2e-12]])
write("bridge::kappa", [lambda g, r, d, f: 12 * g * mp.sqrt(2 * volume(d, f) * d) / (r * d**3)], bridge_points)
write(
    "bridge::loss",
    [lambda k, v: k / v**2, lambda k, v: -2 * k / v**3],
    points(40, (1e-12, 1e6), SPEED),
)

# --- rebound.rs -------------------------------------------------------------------------------------------------------------
mean = lambda r: r * (r * r + TAU**4) ** (-mpf(1) / 4)
mean_slope = lambda r: (r * r / 2 + TAU**4) * (r * r + TAU**4) ** (-mpf(5) / 4)
kept = points(30, (1e-18, 1.0)) + points(15, (1.0, 1e15)) + points(15, (1e-5, 1e-3))
write("rebound::mean_restitution", [mean, mean_slope], kept + [[-r] for [r] in kept])


def kept_of_mean(m):
    # r^4 = m^4 (r^2 + tau^4)
    fourth = m**4
    return mp.sign(m) * mp.sqrt((fourth + mp.sqrt(fourth**2 + 4 * fourth * TAU**4)) / 2)


means = points(40, (1e-18, 1e4))
write("rebound::kept_of_mean_restitution", [kept_of_mean], means + [[-m] for [m] in means])
alphas = points(20, (1e-18, 1.0))
threshold = [[a, -b, float(b / a * (1 + gap))] for [a] in alphas[:10] for b in [between(1e-12, 1.0)] for gap in NEAR]
write(
    "rebound::square_root_law",
    [lambda a, b, v: mp.sqrt(a + b / v)],
    [p for p in points(40, (1e-18, 1.0), (1e-18, 1e-3), SPEED)]
    + [p for p in threshold if mpf(p[0]) + mpf(p[1]) / mpf(p[2]) > 0],
)
write("rebound::threshold_speed", [lambda a, b: -b / a], [[a, -b] for a, b in points(30, (1e-18, 1.0), (1e-18, 1.0))])
write(
    "rebound::linear_law",
    [lambda e, c, st: e * (1 - c / st)],
    points(30, (1e-12, 1.0), (1e-3, 1e3), STOKES) + [[0.72, 10.45, st] for st in towards(10.45)],
)
write(
    "rebound::square_root_expansion",
    [
        lambda a, b: mp.sqrt(a),
        lambda a, b: b / (2 * mp.sqrt(a)),
        lambda a, b: -(b**2) * mp.sqrt(a) / (8 * a**2),
    ],
    [[a, -b] for a, b in points(30, (1e-18, 1.0), (1e-18, 1.0))],
)

# --- impact.rs: r = e_dry^2 - C rho g - 4 L/St, at the run's own speed, and its slopes in k, L, C, scale ---------------
FORMS = {
    "stepwise": (lambda x, s: x * (3 - 6 * x + 4 * x * x), lambda x, s: mpf(0)),
    "cap": (lambda x, s: 2 * x * (3 - 5 * x + 2 * x * x), lambda x, s: mpf(0)),
    "saturating": (lambda x, s: -mp.expm1(-x / s), lambda x, s: -x / s**2 * mp.exp(-x / s)),
    "none": (lambda x, s: mpf(0), lambda x, s: mpf(0)),
}


def kept_energy(form):
    shape = FORMS[form][0]
    return lambda rp, d, rl, eta, f, v, k, l, c, s: (
        (1 - k * v**FIFTH) ** 2 - c * rl / rp * shape(f / d, s) - 36 * eta * l / (rp * d * v)
    )


def kept_slopes(form):
    shape, scale = FORMS[form]
    return [
        lambda rp, d, rl, eta, f, v, k, l, c, s: -2 * (1 - k * v**FIFTH) * v**FIFTH,
        lambda rp, d, rl, eta, f, v, k, l, c, s: -36 * eta / (rp * d * v),
        lambda rp, d, rl, eta, f, v, k, l, c, s: -rl / rp * shape(f / d, s),
        lambda rp, d, rl, eta, f, v, k, l, c, s: -c * rl / rp * scale(f / d, s),
    ]


def settings(count):
    """Spheres whose Stokes number and film ratio reach over the whole range; half of them near r = 0."""
    found = []
    while len(found) < count:
        rp, rl, d, v = between(100, 2e4), between(100, 2e4), between(1e-6, 1.0), between(*SPEED)
        st, ratio = between(*STOKES), between(*FILM_RATIO)
        eta = float(f"{rp * d * v / (9 * st):.4e}")
        k = float(f"{random.uniform(0.01, 0.9) * v**-0.2:.4e}")
        l, c, s = between(0.1, 10), between(0.05, 3), between(0.01, 0.3)
        if len(found) % 2:
            # the viscosity that leaves nothing, and a little less or more
            e = 1 - k * v**0.2
            left = e * e - c * rl / rp * (1 - math.exp(-ratio / s))
            if left <= 0:
                continue
            gap = random.choice([-1, 1]) * random.choice(NEAR[:4])
            eta = float(f"{left * (1 + gap) * rp * d * v / (36 * l):.12e}")
        found.append([rp, d, rl, eta, float(f"{ratio * d:.4e}"), v, k, l, c, s])
    return found


for form in FORMS:
    write(f"impact::kept_energy/{form}", [kept_energy(form)] + kept_slopes(form), settings(40))

# --- normal.rs: ln Phi(z) and phi(z)/Phi(z) ------------------------------------------------------------------------------


def ncdf(z):
    with mp.workdps(120):
        return mp.erfc(-z / mp.sqrt(2)) / 2 if z > -60 else None


def ln_phi(z):
    if z > -60:
        with mp.workdps(120):
            low = mp.erfc(abs(z) / mp.sqrt(2)) / 2
            return +(mp.log(low) if z < 0 else mp.log1p(-low))
    return -z * z / 2 - mp.log(2 * mp.pi) / 2 - mp.log(-z) + mp.log(tail(z))


def tail(z):
    # Mills' ratio as a continued fraction, -z phi(z)... = 1/(1 + w/(1 + 2w/(1 + 3w/...))), w = 1/z^2
    w, value = 1 / (z * z), mpf(1)
    for n in range(400, 0, -1):
        value = 1 + n * w / value
    return 1 / value


def hazard(z):
    if z > -60:
        with mp.workdps(120):
            return mp.npdf(z) / ncdf(z)
    return -z / tail(z)


zs = [[-z] for [z] in points(60, (1e-12, 1e12))] + [[-z] for [z] in points(60, (0.1, 60.0))]
zs += points(40, (1e-12, 1.0)) + points(30, (0.5, 36.0)) + [[-35.0], [-34.999], [-35.001]]
write("normal::ln_normal_cdf", [ln_phi, hazard], zs)

# --- likelihood: one run alone; value and slopes in k, L, C, scale, sigma ---------------------------------------------------------
LN_ROOT = mp.log(2 * mp.pi) / 2


def run_density(form, stuck):
    r = kept_energy(form)

    def value(rp, d, rl, eta, f, v, e, k, l, c, s, sigma):
        m = mean(r(rp, d, rl, eta, f, v, k, l, c, s))
        if stuck:
            # the limit is 0
            return ln_phi(-m / sigma)
        return -(((e - m) / sigma) ** 2) / 2 - LN_ROOT - mp.log(sigma)

    def slope(j):
        def of(*x):
            step = mpf(10) ** -25
            up, down = list(x), list(x)
            up[j], down[j] = x[j] * (1 + step), x[j] * (1 - step)
            return (value(*up) - value(*down)) / (2 * step * x[j])

        return of

    slopes = [slope(j) for j in (7, 8, 9, 11)] if form != "saturating" else [slope(j) for j in (7, 8, 9, 10, 11)]
    return [value] + slopes


mp.dps = 80
for form in ("stepwise", "saturating"):
    for stuck in (False, True):
        chosen = []
        while len(chosen) < 24:
            [p] = settings(2)[len(chosen) % 2 :][:1]
            m = float(mean(kept_energy(form)(*[mpf(x) for x in p])))
            sigma = between(1e-6, 1.0)
            if not stuck and m > 0:
                e = float(f"{abs(m + sigma * random.gauss(0, 1)):.4e}")
            elif stuck and -1e6 < -m / sigma < 8:
                e = 0.0
            else:
                continue
            if not stuck and e == 0:
                continue
            chosen.append(p[:6] + [e] + p[6:] + [sigma])
        write(f"likelihood/{form}/{'stuck' if stuck else 'rebound'}", run_density(form, stuck), chosen)

def dry_density(stuck):
    def value(v, e, k, sigma):
        m = mean((1 - k * v**FIFTH) ** 2)
        return ln_phi(-m / sigma) if stuck else -(((e - m) / sigma) ** 2) / 2 - LN_ROOT - mp.log(sigma)

    def slope(j):
        def of(*x):
            step = mpf(10) ** -25
            up, down = list(x), list(x)
            up[j], down[j] = x[j] * (1 + step), x[j] * (1 - step)
            return (value(*up) - value(*down)) / (2 * step * x[j])

        return of

    return [value, slope(2), slope(3)]


for stuck in (False, True):
    chosen = []
    while len(chosen) < 30:
        v, sigma = between(*SPEED), between(1e-6, 1.0)
        # e_dry from 1 down to the bound of k, and a little beyond it for stuck runs
        share = random.choice([1e-9, 0.1, 0.5, 0.9, 0.999999, 1 - 1e-12] + stuck * [1.00001])
        k = float(f"{share * v**-0.2:.15e}")
        m = 1 - k * v**0.2
        e = 0.0 if stuck else float(f"{abs(m + sigma * random.gauss(0, 1)):.4e}")
        if not stuck or -m / sigma > -8:
            chosen.append([v, e, k, sigma])
    write(f"likelihood/dry/{'stuck' if stuck else 'rebound'}", dry_density(stuck), chosen)
mp.dps = 60

# --- laws.rs: least squares in 50 digits, parameters with their standard errors ----------------------------------------------


def solve(rows, y):
    """Least squares of a linear problem, by its normal equations in 60 digits."""
    p = len(rows[0])
    a = mp.matrix(p, p)
    b = mp.matrix(p, 1)
    for row, value in zip(rows, y):
        for i in range(p):
            b[i] += row[i] * value
            for j in range(p):
                a[i, j] += row[i] * row[j]
    return mp.lu_solve(a, b), a**-1


def fits(name, arguments, model, slopes, start):
    """Gauss-Newton in 60 digits until the step vanishes; `start` is near."""
    xs, es = [mpf(x) for x in arguments[0::2]], [mpf(x) for x in arguments[1::2]]
    b = [mpf(x) for x in start]
    for _ in range(400):
        rows = [slopes(b, x) for x in xs]
        step, inverse = solve(rows, [e - model(b, x) for x, e in zip(xs, es)])
        shrink = mpf(1)
        while any(model([bi + shrink * s for bi, s in zip(b, step)], x) is None for x in xs):
            shrink /= 2
        b = [bi + shrink * s for bi, s in zip(b, step)]
        if shrink == 1 and all(abs(s) < mpf(10) ** -30 * abs(bi) for bi, s in zip(b, step)):
            break
    else:
        return
    squares = sum((e - model(b, x)) ** 2 for x, e in zip(xs, es)) / (len(xs) - len(b))
    pairs = " ".join(
        f"{float(bi)!r}:{float(mp.sqrt(squares * inverse[i, i]))!r}" for i, bi in enumerate(b)
    )
    lines.append(f"{name};{' '.join(short(x) for x in arguments)};{pairs}")


def root(b, x):
    r = b[0] + b[1] * x
    return mp.sqrt(r) if r > 0 else None


for _ in range(30):
    unit = between(1e-12, 1e12)
    speeds = [float(f"{unit * s:.4e}") for s in (0.5, 0.8, 1.1, 1.5, 2.0)]
    k = random.uniform(0.05, 0.5) / unit**0.2
    noise = between(1e-9, 0.1)
    runs = [x for v in speeds for x in (v, float(f"{1 - k * v**0.2 + noise * random.gauss(0, 1):.12f}"))]
    fits("fit_dry", runs, lambda b, v: 1 - b[0] * v**FIFTH, lambda b, v: [-(v**FIFTH)], [k])
    # x = 1/v or 1/St; alpha towards 0, beta towards 0 and towards the threshold
    x = [float(f"{1 / v:.4e}") for v in speeds]
    runs = [y for x in x for y in (x, float(f"{0.72 - 0.1 * unit * x + noise * random.gauss(0, 1):.12f}"))]
    fits("fit_linear", runs, lambda b, x: b[0] - b[1] * x, lambda b, x: [mpf(1), -x], [0.72, 0.1 * unit])
    alpha = between(1e-12, 1.0)
    share = random.choice([1e-12, 1e-6, 1e-2, 0.2, 0.5, 0.9, 0.99])
    beta = -share * alpha * 0.5 * unit
    scatter = noise * math.sqrt(alpha * (1 - share))
    runs = [y for x in x for y in (x, float(f"{math.sqrt(alpha + beta * x) + 0.3 * scatter * random.gauss(0, 1):.12e}"))]
    fits(
        "fit_square_root",
        runs,
        root,
        lambda b, x: [1 / (2 * root(b, x)), x / (2 * root(b, x))],
        [alpha, beta],
    )

Path(__file__).with_name("formulas.csv").write_text("\n".join(lines) + "\n")
