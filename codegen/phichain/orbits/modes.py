"""Linear modes: where the families of oscillations of a hanging chain start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from phichain.errors import ConvergenceError, UnsupportedError
from phichain.orbits.factored import factored_modes
from phichain.records import Held
from phichain.system import Parameters, System, Vector

_FAST = 2.0**40
"""A frequency at which omega^2 M outweighs any stiffness, so that stiff springs leave no trace in M."""


@dataclass(frozen=True, eq=False)
class LinearModes(Held):
    """Small oscillations about hanging: K a = omega^2 M a.

    Attributes:
        omega: Angular frequencies (k,), rad/s, rising; a cart's free translation (omega = 0) is left out.
        shapes: Their shapes (n, k): largest angle 1, the first angle that moves positive.
    """

    omega: Vector
    shapes: Vector

    def __len__(self) -> int:
        return len(self.omega)


def linear_modes(system: System, p: Parameters | None = None) -> LinearModes:
    """Linear modes from the chain's numbers, or from Phi's Jacobian at rest: dPhi/dA = K - omega^2 M there, exactly.

    The numbers serve where they are known and the chain hangs stably; their frequencies are right to the last digits, and no
    function of the system is needed.

    Raises:
        AbsentFunctionError: The numbers do not serve, and the system has no `phi_jacobian`.
        UnsupportedError: The scene is spatial, loses energy, does not hang straight, or its cart is driven by its acceleration.
        ConvergenceError: M is not positive definite.
    """
    demand_oscillations(system)
    if (factored := factored_modes(system, p)) is not None:
        return LinearModes(factored[0], _normalised(system, factored[1]))
    return _of_jacobian(system, system.function("phi_jacobian"), system.parameters(p))


def demand_oscillations(system: System) -> None:
    """Refuse a chain that has no families of oscillations about hanging straight.

    Raises:
        UnsupportedError: The scene is spatial, loses energy, or does not hang straight.
    """
    if not system.is_planar:
        raise UnsupportedError(
            "system",
            system.name,
            "a spatial chain has no scalar amplitudes",
            'use a planar scene, or method = "conical" for the families that turn about the vertical',
        )
    demand_conserved(system)


def demand_conserved(system: System) -> None:
    """Refuse a chain that loses energy, does not hang straight, or is driven by its cart's acceleration.

    Raises:
        UnsupportedError: It does.
    """
    joints, numbers = system.joints, system.numbers
    losses = {
        "damping": joints.damping, "friction": joints.friction,
        "cart_damping": numbers.cart_damping, "cart_friction": numbers.cart_friction,
    }  # fmt: skip
    for name, said in losses.items():
        if said is not None:
            raise UnsupportedError(
                name,
                said,
                "links that lose energy have no periodic motion, so no families of oscillations: unforced, they come to rest",
                f"{_WITHOUT[name]}, simulate how they do, or drive them: phichain response follows what A cos(omega t) makes periodic",
            )
    if joints.rest_angle is not None:
        raise UnsupportedError(
            "rest_angle", joints.rest_angle, "families start where the chain hangs straight, and these springs bend it",
            "leave rest_angle out of the scene",
        )  # fmt: skip
    if system.drive.accelerations and system.has_cart:
        raise UnsupportedError(
            "drive", "acceleration", "a cart that follows its input does not swing with the chain",
            'use base = "fixed" for one that is held, or drive = "force"',
        )  # fmt: skip


_WITHOUT = {
    "damping": "leave the dampers out of the scene",
    "friction": "leave the joints' friction out of the scene",
    "cart_damping": "leave the cart's damper out of the scene",
    "cart_friction": "leave the cart's friction out of the scene",
}


def _of_jacobian(system: System, slope: Callable[..., Any], parameters: dict[str, Any]) -> LinearModes:
    still = np.zeros(system.nq)
    stiffness = np.asarray(slope(still, 0.0, **parameters))[:, :-1]
    mass = (stiffness - np.asarray(slope(still, _FAST, **parameters))[:, :-1]) / _FAST**2
    try:
        squares, vectors = eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    except np.linalg.LinAlgError as failure:
        raise ConvergenceError(
            "phi_jacobian",
            system.name,
            f"gives no positive definite mass matrix ({failure})",
            "check the masses",
        ) from failure
    moving = squares > 1e-10 * np.max(np.abs(squares))
    return LinearModes(np.sqrt(squares[moving]), _normalised(system, vectors[:, moving]))


def _normalised(system: System, vectors: Vector) -> Vector:
    angles = vectors[system.cart_size :]
    sizes = np.abs(angles)
    largest = sizes.max(axis=0)
    first = (sizes > 1e-6 * largest).argmax(axis=0)
    return vectors / largest * np.sign(angles[first, np.arange(angles.shape[1])])
