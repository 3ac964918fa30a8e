"""Calls the C library of wetcor from Python with nothing but ctypes.

The path of the library is read from WETCOR_LIBRARY.
"""

import ctypes
import os
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_uint32

OK, EXTRAPOLATED, NOT_QUOTABLE, BAD_LINE = 0, 1, 2, -7


class Law(ctypes.Structure):
    """wetcor_law, field by field as in include/wetcor.h."""

    _fields_ = [("tag", c_uint32), ("dry_order", c_uint32)] + [
        (name, c_double) for name in ("dry_k", "constant", "beta", "kappa", "min_speed", "max_speed")
    ]


library = ctypes.CDLL(os.environ["WETCOR_LIBRARY"])
_LAW, _NUMBER = POINTER(Law), POINTER(c_double)
for _name, _arguments in {
    "wetcor_law_from_alpha_beta": [c_double, c_double, _LAW],
    "wetcor_law_impact": [c_double, c_int, c_double, c_double, c_double, _LAW],
    "wetcor_law_dry": [c_double, c_int, _LAW],
    "wetcor_law_from_csv": [c_char_p, c_char_p, _LAW],
    "wetcor_restitution": [_LAW, c_double, _NUMBER],
    "wetcor_threshold_speed": [_LAW, _NUMBER],
}.items():
    getattr(library, _name).argtypes = _arguments
library.wetcor_status_text.restype = c_char_p
library.wetcor_version.restype = c_char_p


def _answered(status):
    if status < 0:
        raise ValueError(library.wetcor_status_text(status).decode())
    return status


def law(maker, *arguments):
    """The law that a function such as wetcor_law_dry makes of its arguments."""
    made = Law()
    _answered(getattr(library, maker)(*arguments, byref(made)))
    return made


def ask(question, of, *arguments):
    """A number asked of a law, and its status."""
    number = c_double()
    status = _answered(getattr(library, question)(byref(of), *arguments, byref(number)))
    return number.value, status


def restitution(of, speed):
    """e_n of a law at an impact speed in m/s."""
    return ask("wetcor_restitution", of, speed)[0]
