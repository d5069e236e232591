"""Shapes, arguments and absences that several functions of the contract share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from phichain.contract import meanings
from phichain.contract.bases import law_of
from phichain.contract.chain import Chain, Kind, Words
from phichain.contract.flows import has_input
from phichain.contract.function import Absence, Argument, Shape


def scalar(chain: Chain) -> Shape:
    """A single number."""
    return ()


def per_v(chain: Chain) -> Shape:
    """Rates, and what is conjugate to them."""
    return (chain.nv,)


def per_q(chain: Chain) -> Shape:
    """Configurations."""
    return (chain.nq,)


def small(chain: Chain) -> Shape:
    """The matrices of (19)."""
    size = chain.nv if chain.is_planar else 2 * chain.links + (2 if chain.has_cart else 0)
    return size, size


def is_planar(chain: Kind) -> bool:
    """Links have angles."""
    return chain.is_planar


def is_spatial(chain: Kind) -> bool:
    """Links have unit vectors."""
    return not chain.is_planar


def is_driven(chain: Kind) -> bool:
    """A cart is driven by its acceleration."""
    law = law_of(chain.base, chain.drive)
    return law.is_placed and law.is_told


def is_damped(chain: Kind) -> bool:
    """Joints carry dampers."""
    return chain.damping is not None


def rubs(chain: Kind) -> bool:
    """Dry friction acts, at joints or on the cart."""
    return chain.friction is not None or chain.cart_friction is not None


def is_lossy(chain: Kind) -> bool:
    """Something resists a motion: dampers or dry friction, at joints or on the cart."""
    return is_damped(chain) or rubs(chain) or chain.cart_damping is not None


def rests_bent(chain: Kind) -> bool:
    """Springs rest elsewhere than along the link before."""
    return chain.rest_angle is not None


def out(shape: Callable[[Chain], Shape], doc: str, meaning: Words) -> Argument:
    """The only result of a function."""
    return Argument("out", "out", shape, doc, meaning)


def jacobian_by(name: str, columns: Callable[[Chain], int], present: Callable[[Chain], bool]) -> Argument:
    """The result of state_jacobian for one of its arguments."""
    meaning = f"partial derivatives of a by {name}"
    return Argument(f"dad{name}", "out", lambda chain: (chain.nv, columns(chain)), "", meaning, present)


def force_by(name: str) -> Argument:
    """The result of inverse_and_jacobian for one of its arguments."""
    meaning = f"partial derivatives of u by {name}" + (": the mass matrix" if name == "a" else "")
    return Argument(f"dud{name}", "out", lambda chain: (chain.nv, chain.nv), "", meaning)


Q: Final = Argument("q", "in", per_q, "configuration")
V: Final = Argument("v", "in", per_v, "rates")
U: Final = Argument("u", "in", lambda chain: (chain.nu,), "inputs", present=has_input)
B: Final = Argument(
    "b", "in", lambda chain: (chain.base_inputs,), "acceleration of the base",
    lambda chain: chain.base_law.argument, lambda chain: chain.is_moving,
)  # fmt: skip
ACCELERATIONS: Final = Argument("a", "in", per_v, "accelerations")
FORCE: Final = Argument(
    "u", "out", per_v, "full generalised force", lambda chain: f"generalised force conjugate to q, {meanings.forces(chain)}"
)
STATE: Final = (Q, V, U)
STEP: Final = (
    Argument("h", "in", scalar, "step, s"),
    *STATE,
    Argument("q_next", "out", per_q, "configuration after the step"),
    Argument("v_next", "out", per_v, "rates after the step"),
)
ESTIMATE: Final = "estimated error of the step"
BALANCE: Final = (
    Argument("amplitude", "in", per_v, "amplitudes of [x,] theta", meanings.amplitudes),
    Argument("omega", "in", scalar, "angular frequency, rad/s"),
)
NO_FORCES: Final = (
    Absence(
        is_spatial,
        "is defined on planar scenes alone, since spatial joints are not actuated",
        'use "mass_matrix", "coriolis" and "gravity_torque": the force is M a + coriolis + gravity_torque',
    ),
)
NO_BALANCE: Final = (
    Absence(
        is_spatial,
        "is defined on planar scenes alone, since a spatial link has no scalar amplitude",
        'use "linearization" for small motions, "step" for large ones, or space = "planar"',
    ),
    Absence(
        is_damped,
        "needs an undamped scene, since damped links have no in-phase periodic motion",
        'use "linearization" for the decaying modes, "step" for the motion, or remove joints.damping',
    ),
    Absence(
        is_lossy,
        "needs a scene without losses, since nothing swings periodically against dry friction or a cart's damper",
        'use "linearization" for small motions, "step" for the motion, or remove joints.friction, chain.cart_damping and'
        " chain.cart_friction",
    ),
    Absence(
        rests_bent,
        "needs springs that rest along the link before, since others pull to one side and leave no motion in phase",
        'use "step" for the motion, or remove joints.rest_angle',
    ),
    Absence(
        is_driven,
        "is a balance of forces, and a cart that is driven by its acceleration goes where it is told",
        'use base = "fixed" for the chain beneath it, or drive = "force"',
    ),
)
NO_PREPARATION: Final = (
    Absence(
        lambda chain: not chain.runtime,
        "has nothing to prepare on a scene without runtime parameters, whose numbers are folded into the code",
        'use "forward_dynamics", or make some number of the scene "runtime"',
    ),
)
