"""The inverse model (15) in front of the direct one: Fig. 2 of paper A as a control law.

The inverse model turns a wanted motion into the forces that make it, u = I(theta) theta'' + N + G (and springs and
dampers). Fed forward alone it keeps an exact model on the motion it starts on, as far as that motion is stable. With
the state fed back it is the computed torque: in

    u = inverse_dynamics(theta, theta', theta_d'' + 2 w e' + w^2 e),   e = theta_d - theta,

the model's own terms cancel and what is left of the closed loop is e'' + 2 w e' + w^2 e = 0: every coordinate is
critically damped with the rate w, whatever the motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from phichain.errors import ArrayError, ControlError, UnsupportedError
from phichain.system import Parameters, System, Vector, unpack
from phichain.system.arrays import number, real_numbers, reals

if TYPE_CHECKING:
    from phichain.control.feedback import Law

Reference = Callable[[float], tuple[Vector, Vector, Vector]]
"""A motion to follow: t -> (q, q', q''), each (nq,)."""


def computed_torque(
    system: System, reference: Reference, rate: float | None = None, *, p: Parameters | None = None
) -> Law:
    """The law u(t, x) that makes a chain follow a motion, for `simulate(..., u=computed_torque(...))`.

    Args:
        system: A planar chain with `inverse_dynamics` and one input per coordinate (`actuated = "all"`).
        reference: The motion to follow.
        rate: w, 1/s: how fast errors die out. None feeds the reference's own forces forward and looks at no state.
        p: Runtime parameters by name.

    Raises:
        UnsupportedError: A spatial scene.
        AbsentFunctionError: No `inverse_dynamics`.
        ControlError: Fewer inputs than coordinates, or a rate that is not positive.
        ArrayError: The reference has another shape, or is not finite.
    """
    _check(system, rate)
    inverse, parameters = system.function("inverse_dynamics"), system.parameters(p)
    follow = _checked(system, reference)
    follow(0.0)

    def forward(t: float, x: Vector) -> Vector:
        return np.asarray(inverse(*follow(t), **parameters), dtype=float)

    if rate is None:
        return forward

    def corrected(t: float, x: Vector) -> Vector:
        q, v = unpack(system, x)
        wanted, its_rate, its_acceleration = follow(t)
        demand = its_acceleration + 2 * rate * (its_rate - v) + rate**2 * (wanted - q)
        return np.asarray(inverse(q, v, demand, **parameters), dtype=float)

    return corrected


def in_phase(amplitude: ArrayLike, omega: float) -> Reference:
    """The in-phase motion (17), theta_k = A_k cos(omega t), as a reference.

    Args:
        amplitude: A (nq,), rad (m for a cart).
        omega: Angular frequency, rad/s.

    Raises:
        ArrayError: The amplitudes are no finite real numbers, or omega is none.
    """
    size, omega = reals("amplitude", amplitude, "give one per coordinate"), number("omega", omega, "give rad/s")
    if not np.all(np.isfinite(size)):
        raise ArrayError("amplitude", size.tolist(), "is not finite", "give finite amplitudes")

    def motion(t: float) -> tuple[Vector, Vector, Vector]:
        cosine = size * math.cos(omega * t)
        return cosine, -omega * size * math.sin(omega * t), -(omega**2) * cosine

    return motion


def tracking_error(reference: Reference, t: Vector, q: Vector) -> Vector:
    """Largest |theta_d - theta| over the coordinates at every time, shape (m,).

    Args:
        reference: The wanted motion.
        t: Times (m,), s.
        q: The motion there was (m, nq).
    """
    wanted = np.array([reference(float(time))[0] for time in t])
    error: Vector = np.max(np.abs(wanted - q), axis=1)
    return error


def _check(system: System, rate: float | None) -> None:
    if not system.is_planar:
        raise UnsupportedError(
            "system",
            system.name,
            "a spatial chain has no joint torques",
            "use a planar scene, or `lqr` on a cart",
        )
    if system.drive.accelerations:
        raise UnsupportedError(
            "base",
            system.base,
            "is given its acceleration, which computed torque does not choose",
            'use base = "fixed", or drive = "force" on a cart; inverse_dynamics gives the torques at any acceleration',
        )
    if system.nu < system.nv:
        raise ControlError(
            "actuated",
            system.nu,
            f"leaves {system.nv - system.nu} of {system.nv} coordinates without an input of their own",
            'set actuated = "all" in the scene',
        )
    if rate is None:
        return
    given = real_numbers("rate", rate, "give how fast errors are to die out, in 1/s")
    if given.shape or not (np.isfinite(given) and given > 0):
        raise ControlError(
            "rate", rate, "is not a positive number", "give how fast errors are to die out, in 1/s"
        )


def _checked(system: System, reference: Reference) -> Reference:
    """The reference with its shapes looked at whenever it is asked."""

    if not callable(reference):
        raise ArrayError("reference", reference, "is no function of time", "pass t -> (q, q', q'')")

    shape = (system.nq,)

    def follow(t: float) -> tuple[Vector, Vector, Vector]:
        given = reference(t)
        try:
            q, v, a = (np.asarray(part, dtype=float) for part in given)
        except (TypeError, ValueError):
            raise _no_reference(system, given) from None
        # A sum is not finite where an entry is not, and costs less than looking at each: the law is asked at every stage.
        if not (q.shape == v.shape == a.shape == shape and math.isfinite(q.sum() + v.sum() + a.sum())):
            raise _no_reference(system, [part.shape for part in (q, v, a)])
        return q, v, a

    return follow


def _no_reference(system: System, given: object) -> ArrayError:
    return ArrayError(
        "reference",
        given,
        f"must give three finite vectors of {system.nq} numbers",
        "return (q, q', q'') at t",
    )
