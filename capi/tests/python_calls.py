"""Compares what the library answers to Python with the formulas; fails where they differ."""

import ctypes
import math
import sys

from wetcor_ctypes import EXTRAPOLATED, NOT_QUOTABLE, OK, Law, ask, byref, law, library, restitution

HEADER = b"quotable,law,alpha,beta_m_s,kappa_m2_s2,min_speed_m_s,max_speed_m_s,dry_k,dry_order,inertial_loss"

assert ctypes.sizeof(Law) == 56
assert library.wetcor_version().decode() == sys.argv[1], library.wetcor_version()

wet = law("wetcor_law_from_alpha_beta", 0.53, -0.31)
own = law("wetcor_law_impact", 0.183, 2, 0.06, -0.11, 0.0)
dry = law("wetcor_law_dry", 0.183, 1)
for step in range(1, 300):
    v = 0.01 * step
    z = 0.183 * v**0.2
    for of, square in [
        (wet, 0.53 - 0.31 / v),
        (own, (1 - z + 0.6 * z * z) ** 2 - 0.06 - 0.11 / v),
        (dry, (1 - z) ** 2),
    ]:
        assert abs(restitution(of, v) - math.sqrt(max(square, 0.0))) < 1e-13, (v, square)
assert abs(ask("wetcor_threshold_speed", wet)[0] - 0.31 / 0.53) < 1e-14

from_table = law("wetcor_law_from_csv", HEADER, b"true,reference,0.53,-0.31,,0.6,1.8,,,\n")
assert ask("wetcor_restitution", from_table, 1.0) == (restitution(wet, 1.0), OK)
assert ask("wetcor_restitution", from_table, 2.0) == (restitution(wet, 2.0), EXTRAPOLATED)
unsure = Law()
assert library.wetcor_law_from_csv(HEADER, b"false,dry,,,,,,0.183,1,", byref(unsure)) == NOT_QUOTABLE
assert bytes(unsure) == bytes(dry)
# a law is its bytes
assert restitution(Law.from_buffer_copy(bytes(own)), 1.2) == restitution(own, 1.2)

for refused in [lambda: restitution(wet, -1.0), lambda: restitution(Law(), 1.0), lambda: law("wetcor_law_dry", -1.0, 1)]:
    try:
        refused()
    except ValueError as error:
        assert str(error), error
    else:
        raise AssertionError("it was not refused")
