"""The functions a scene can ask for, and why some scenes have none of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from phichain.contract.words import nearest
from phichain.errors import SceneError, UnsupportedError

FUNCTIONS: Final[tuple[str, ...]] = (
    "forward_dynamics",
    "forward_dynamics_batch",
    "direction_dynamics",
    "inverse_dynamics",
    "mass_matrix",
    "coriolis",
    "gravity_torque",
    "energy",
    "positions",
    "linearization",
    "state_jacobian",
    "phi",
    "phi_jacobian",
    "step",
    "step_lie4",
    "step_variational",
    "step_rosenbrock",
    "propagate",
    "propagate_stiff",
    "propagate_batch",
    "project",
)
"""Every function of the contract, in the order of its table; `want` is kept in this order."""

ON_REQUEST: Final = (
    "forward_dynamics_batch", "step_lie4", "step_variational", "step_rosenbrock", "propagate_stiff", "propagate_batch",
)  # fmt: skip
"""Further steps, flows and forms for many trajectories: asked for by name, and in no list of all functions."""

FLOWS: Final = ("forward_dynamics_batch", "propagate", "propagate_stiff", "propagate_batch")
"""Those that run over many steps or states: C around Programs, where every other function is one Program."""

PLANAR_FUNCTIONS: Final = tuple(
    name for name in FUNCTIONS if name not in ("direction_dynamics", "project", *ON_REQUEST)
)
"""The functions of an undamped planar scene, but for those on request."""

SPATIAL_FUNCTIONS: Final = tuple(
    name for name in FUNCTIONS if name not in ("inverse_dynamics", "phi", "phi_jacobian", *ON_REQUEST)
)
"""The functions of a spatial scene, but for those on request."""

_PLANNED: Final = {
    "controller": 'compute the gains from "linearization" until then',
}


def wanted(value: object, space: str, damped: bool) -> tuple[str, ...]:
    """Check a list of wanted functions and return it in the contract's order, each name once.

    Args:
        value: The list of names.
        space: `"planar"` or `"spatial"`.
        damped: Whether the scene's joints may carry dampers.

    Raises:
        SceneError: The value is no list of names, or a name is unknown (the nearest one is given).
        UnsupportedError: A function is not defined for such a scene (what to use instead is given).
    """
    label = "functions.want"
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise SceneError(label, value, "is not a list of function names", 'write want = ["forward_dynamics"]')
    for name in value:
        _check_function(label, name, space, damped)
    if not value:
        raise SceneError(label, value, "asks for no function", 'write want = ["forward_dynamics"]')
    return tuple(name for name in FUNCTIONS if name in value)


def _check_function(label: str, name: object, space: str, damped: bool) -> None:
    """Raise unless `name` is a function that such a scene has."""
    if not isinstance(name, str):
        raise SceneError(label, name, "holds what is no function name", 'write want = ["forward_dynamics"]')
    if name in _PLANNED:
        raise UnsupportedError(label, name, "is not available in this version", _PLANNED[name])
    if name not in FUNCTIONS:
        best = nearest(name, FUNCTIONS)
        remedy = f'did you mean "{best}"? The functions are {", ".join(FUNCTIONS)}'
        raise SceneError(label, name, "is not a function", remedy, nearest=best)
    reason = _why_not(name, space, damped)
    if reason is not None:
        problem, remedy = reason
        raise UnsupportedError(label, name, problem, remedy)


def _why_not(name: str, space: str, damped: bool) -> tuple[str, str] | None:
    """Return (why a scene has no such function, what to use instead), or None when it has it."""
    if name == "project" and space == "planar":
        return (
            "has no meaning on a planar scene, whose angles need no projection",
            "remove it; project belongs to the unit vectors of spatial scenes",
        )
    if name == "direction_dynamics" and space == "planar":
        return (
            "is defined on spatial scenes alone, since a planar link has an angle and no unit vector",
            'use "forward_dynamics", whose accelerations are those of the angles',
        )
    if name == "inverse_dynamics" and space == "spatial":
        return (
            "is defined on planar scenes alone, since spatial joints are not actuated",
            'use "mass_matrix", "coriolis" and "gravity_torque": the force is M a + coriolis + gravity_torque',
        )
    if name in ("phi", "phi_jacobian") and space == "spatial":
        return (
            "is defined on planar scenes alone, since a spatial link has no scalar amplitude",
            'use "linearization" for small motions, "step" for large ones, or space = "planar"',
        )
    if name in ("phi", "phi_jacobian") and damped:
        return (
            "needs an undamped scene, since damped links have no in-phase periodic motion",
            'use "linearization" for the decaying modes, "step" for the motion, or remove joints.damping',
        )
    return None
