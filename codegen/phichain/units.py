"""The unit of a quantity by its name: entries of states and inputs, and what stands beside them in results.

A name that means different things in different tables (a `phase` in radians or of a law, `late` in calls or as a verdict) has none here.
"""

from __future__ import annotations

import re
from typing import Final

_RULES: Final = (
    (r"t|time|settled", "s"),
    (r"x(_\d)?", "m"),
    (r"x_dot(_\d)?", "m/s"),
    (r"theta(_\d+)?", "rad"),
    (r"(theta_dot|omega)(_\d+){0,2}", "rad/s"),
    (r"(base_)?acceleration(_\d)?", "m/s^2"),
    (r"force(_\d)?", "N"),
    (r"torque_\d+", "N m"),
    (r"energy|kinetic|potential|work|loss", "J"),
    (r"momentum", "kg m^2/s"),
    (r"tangency_error", "rad/s"),
)
_KNOWN: Final = tuple((re.compile(names), unit) for names, unit in _RULES)
_AROUND: Final = re.compile(r"^(?:peak_|first_|amplitude_)|(?:_fitted|_residual|_0)$")
_PHASE: Final = re.compile(r"phase_")


def unit_of(name: str) -> str:
    """The unit of `theta_dot_2`, `force`, `peak_theta_1`, `kinetic`, ...; empty for pure numbers and for names that say none.

    Args:
        name: A name as scenes give them to their states and inputs, or of a column of a result.
    """
    if _PHASE.match(name):
        return "rad"
    plain = _AROUND.sub("", name)
    if dotted := re.fullmatch(r"(theta|x)(_\d+)_dot", plain):
        plain = f"{dotted[1]}_dot{dotted[2]}"
    return next((found for names, found in _KNOWN if names.fullmatch(plain)), "")
