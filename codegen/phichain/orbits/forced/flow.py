"""The emitted Taylor flow of a scene with [forcing] as the motion that shooting integrates by."""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.errors import UnsupportedError
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.quarter import EPS
from phichain.system import Parameters, System, Vector
from phichain.system.variations import Along, variations

_STEPS: Final = 40_000
"""Steps of a period that are worth taking."""
_NUDGE: Final = 2.0**-17
"""Change of omega, relative, by whose both sides the derivative is taken where the flow carries none by omega: h^2 and rounding over h
are some 1e-10 then.

No fold depends on it: there the derivatives by the state are singular, whatever that by omega is."""


_BESIDE: Final = 2.0**-11
"""Distance, in spans, of the states about the end that tell how fast it moves: to the eighth order, and to rounding over it, 1e-13."""
_SLOPE: Final = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Weights of the first derivative on nine places."""


class EmittedFlow:
    """`propagate` under A cos(omega t), its derivatives by the state carried along.

    That by omega is one more column where the scene's flow carries it, `[flow] variational = ["state", "forcing"]`; else it is taken by
    differences, which cost two more motions and are right to some 1e-10.

    Raises:
        UnsupportedError: The scene's flow is not forced there, or carries no derivatives.
    """

    def __init__(self, system: System, forcing: Forcing, p: Parameters | None = None) -> None:
        """Hold what is propagated."""
        forced, along = system.forcing
        where = (forced, along or 1)
        if where != (forcing.forced, forcing.axis) or not system.variational or not system.has("propagate"):
            axis = f", axis = {forcing.axis}" if forcing.base.any() else ""
            raise UnsupportedError(
                "method", "shooting", f"needs a flow that is forced at {forcing.forced!r} and carries derivatives, and system '{system.name}' has none",
                f'build its scene with propagate in want, [flow] variational = true and [forcing] forced = {forcing.forced!r}{axis}, or use method = "harmonics"',
            )  # fmt: skip
        self._flow, self._parameters, self._size = system.function("propagate"), system.parameters(p), system.nq
        self._by_omega = variations(system, "omega") if "omega" in system.varied else None

    def __call__(self, x: Vector, span: float, amplitude: float, omega: float) -> tuple[Vector, Vector, Vector] | None:
        """As `ForcedFlow`."""
        if self._by_omega is not None:
            return self._with_omega(x, span, amplitude, omega, *self._by_omega)
        found = self._moved(x, span, amplitude, omega, np.eye(len(x)))
        nudge, phase = _NUDGE * omega, span * omega
        sides = [self._moved(x, phase / (omega + side), amplitude, omega + side) for side in (nudge, -nudge)]
        if found is None or sides[0] is None or sides[1] is None:
            return None
        return found[0], found[1], (sides[0][0] - sides[1][0]) / (2 * nudge)

    def sampled(self, x: Vector, times: Vector, amplitude: float, omega: float) -> Vector:
        """As `ForcedFlow`."""
        n = self._size
        found = self._flow(x[:n], x[n:], 0.0, times[-1], EPS, forcing=(amplitude, omega), times=times, **self._parameters)
        return np.hstack([found.q_at, found.v_at])

    def _with_omega(
        self, x: Vector, span: float, amplitude: float, omega: float, columns: Vector, along: Along
    ) -> tuple[Vector, Vector, Vector] | None:
        """All derivatives from one motion: at the same phase it ends earlier by span / omega for each unit of omega."""
        n, beside = self._size, _BESIDE * span
        times = span + beside * np.arange(-4.0, 5.0)
        found = self._flow(
            x[:n], x[n:], 0.0, float(times[-1]), EPS, forcing=(amplitude, omega), times=times, max_steps=_STEPS, transition=columns,
            along=along, **self._parameters,
        )  # fmt: skip
        if found.outcome != "done":
            return None
        moved = found.columns_at[4]
        slope = np.concatenate([found.v_at[4], _SLOPE @ found.v_at / beside])
        return np.concatenate([found.q_at[4], found.v_at[4]]), moved[:, : 2 * n], moved[:, 2 * n] - slope * (span / omega)

    def _moved(
        self, x: Vector, span: float, amplitude: float, omega: float, columns: Vector | None = None
    ) -> tuple[Vector, Vector] | None:
        n = self._size
        more = {} if columns is None else {"transition": columns}
        found = self._flow(x[:n], x[n:], 0.0, span, EPS, forcing=(amplitude, omega), max_steps=_STEPS, **more, **self._parameters)
        if found.outcome != "done":
            return None
        return np.concatenate([found.q, found.v]), np.empty((0, 0)) if columns is None else found.transition
