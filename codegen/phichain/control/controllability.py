"""Controllability (20)-(21) with its margin.

The reduced system is controllable when [lambda^2 M_qq + lambda D_qq + G_qq, B_q] has full rank at every eigenvalue
lambda of the links. Instead of a yes or no, the smallest singular value of that pencil is given, mode by mode, in
coordinates where M_qq = I and divided by the size of the input: 0 is uncontrollable, and the smaller it is, the more
effort (and the larger gains) that mode takes.

A chain with its masses at the link ends is controllable from its cart at every equilibrium; with r < l it need not
be: two links folded on each other (s_2 = -s_1) with r_2 = l_1 - r_1 have a mode in which the cart feels no force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.control.equations.blocks import Indices, alike, turned
from phichain.control.linear import LinearSystem, linearize
from phichain.control.weights import Spectrum, solve
from phichain.errors import ControlError
from phichain.records import Held
from phichain.system import Parameters, System, Vector

UNCONTROLLABLE = 1e-10
"""Margins below this are called uncontrollable, or below a hundred times the accuracy of the matrices."""


@dataclass(frozen=True, eq=False)
class Controllability(Held):
    """How well each mode of the links can be reached by the inputs.

    Attributes:
        modes: Eigenvalues lambda (k,), 1/s, one of each +- or complex pair, by rising |lambda|.
        margins: Smallest singular value of the scaled pencil at each of them (k,), between 0 and about 1.
        limit: Margins below it are called uncontrollable.
    """

    modes: Spectrum
    margins: Vector
    limit: float = UNCONTROLLABLE

    @property
    def margin(self) -> float:
        """The smallest margin."""
        return float(np.min(self.margins))

    @property
    def worst(self) -> int:
        """Index of the mode with the smallest margin."""
        return int(np.argmin(self.margins))

    @property
    def is_controllable(self) -> bool:
        """True when every margin is above the limit."""
        return self.margin > self.limit

    def demand(self, s: Sequence[int]) -> Controllability:
        """Itself, or an error that names the mode.

        Raises:
            ControlError: A mode is uncontrollable; carries `mode` (lambda), `number` (from 1) and `margin`.
        """
        if self.is_controllable:
            return self
        mode = complex(self.modes[self.worst])
        raise ControlError(
            "s",
            list(s),
            f"mode {self.worst + 1} (lambda = {mode:.6g} 1/s) is uncontrollable: margin {self.margin:.2g}",
            "choose another equilibrium, move a mass, or actuate a joint",
            mode=mode,
            number=self.worst + 1,
            margin=self.margin,
        )


def controllability(system: System, s: Sequence[int], p: Parameters | None = None) -> Controllability:
    """The margins of one equilibrium.

    Raises:
        ControlError: s is no equilibrium, or the system has no input.
        AbsentFunctionError: The system has no `linearization`.
    """
    return margins_of(linearize(system, s, p))


def margins_of(linear: LinearSystem) -> Controllability:
    """The margins of a linear system, equation (21).

    Raises:
        ControlError: It has no input.
    """
    demand_input(linear)
    return margins_of_all([linear])[0]


def demand_input(linear: LinearSystem) -> int:
    """The number of inputs.

    Raises:
        ControlError: There is none.
    """
    if linear.B.shape[1] == 0:
        raise ControlError(
            "actuated", "none", "this system has no input", "actuate the cart or joints in the scene"
        )
    return linear.B.shape[1]


def margins_of_all(systems: Sequence[LinearSystem]) -> list[Controllability]:
    """The margins of linear systems of one chain that has inputs, each to the same bits as alone."""
    M, D, G, B = (np.array(matrices) for matrices in zip(*(linear.reduced for linear in systems), strict=True))
    found: dict[int, Controllability] = {}
    for group in alike((M, D, G), B):
        parts = [_Part.of(*problem) for problem in group.problems]
        # A damped pencil has as many modes as its dampers leave, which depends on the equilibrium.
        damped = any(np.any(part.damping) for part in parts)
        for at in np.array_split(np.arange(len(group.items)), len(group.items) if damped else 1):
            modes, margins = _reach([part.only(at) for part in parts], group.members)
            for k, own, margin in zip(group.items[at].tolist(), modes, margins, strict=True):
                found[k] = Controllability(own, margin, max(UNCONTROLLABLE, 100 * systems[k].noise))
    return [found[k] for k in range(len(systems))]


@dataclass(frozen=True, eq=False)
class _Part(Held):
    """Links that others do not touch, in coordinates in which M_qq = I: a stack of them."""

    stiffness: Vector
    damping: Vector
    drive: Vector

    @classmethod
    def of(cls, mass: Vector, damping: Vector, stiffness: Vector, drive: Vector) -> _Part:
        """The coordinates L^T x with M_qq = L L^T."""
        factor = np.linalg.cholesky(mass)
        return cls(_normalised(factor, stiffness), _normalised(factor, damping), solve(factor, drive))

    def only(self, items: Indices) -> _Part:
        """Those of the stack."""
        return _Part(self.stiffness[items], self.damping[items], self.drive[items])


def _normalised(factor: NDArray[Any], part: Vector) -> Vector:
    """L^-1 part L^-T, symmetric."""
    scaled = solve(factor, turned(solve(factor, part)))
    return (scaled + turned(scaled)) / 2


def _reach(parts: Sequence[_Part], members: Sequence[int]) -> tuple[Spectrum, Vector]:
    """Modes and margins of a stack (count, k), by rising |lambda|; `members` says which of the parts each block is."""
    rates = np.max([np.sqrt(_norm(part.stiffness)) for part in parts], axis=0)
    rate = np.where(rates > 0, rates, 1.0)[:, None, None]
    size = np.max([_norm(part.drive) for part in parts], axis=0)[:, None, None]
    scaled = [_Part(part.stiffness / rate**2, part.damping / rate, part.drive / size) for part in parts]
    each = [_modes(part.stiffness, part.damping) for part in parts]
    found = [np.min([_margins(modes / rate[:, 0], part) for part in scaled], axis=0) for modes in each]
    modes, margins = (np.concatenate([values[k] for k in members], axis=1) for values in (each, found))
    rising = np.argsort(np.abs(modes), axis=1, kind="stable")
    return np.take_along_axis(modes, rising, axis=1), np.take_along_axis(margins, rising, axis=1)


def _norm(matrices: Vector) -> Vector:
    """The largest singular values of a stack (count,)."""
    return np.asarray(np.linalg.norm(matrices, 2, axis=(1, 2)))


def _modes(stiffness: Vector, damping: Vector) -> Spectrum:
    """Eigenvalues of lambda^2 + lambda D + G (count, k), the one in the closed right or upper half of each pair."""
    n = stiffness.shape[-1]
    if not np.any(damping):
        modes: Spectrum = np.sqrt((-np.linalg.eigvalsh(stiffness)).astype(complex))
        return np.take_along_axis(modes, np.argsort(np.abs(modes), axis=1, kind="stable"), axis=1)
    ((own, friction),) = zip(stiffness, damping, strict=True)
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-own, -friction]])
    values = np.linalg.eigvals(first_order).astype(complex)
    upper = values[values.imag >= 0]
    return upper[np.argsort(np.abs(upper), kind="stable")][None]


def _margins(modes: Spectrum, part: _Part) -> Vector:
    """Smallest singular values of the pencils of a stack of parts at all modes (count, k), all in units of the rate."""
    n = part.stiffness.shape[-1]
    squares = modes**2
    # Without damping the squares are real, and so is the pencil.
    pencil: NDArray[Any] = (squares if np.any(squares.imag) else squares.real)[..., None, None] * np.eye(n)
    if np.any(part.damping):
        pencil = pencil + modes[..., None, None] * part.damping[:, None]
    pencil = pencil + part.stiffness[:, None]
    drive = np.broadcast_to(part.drive[:, None], (*modes.shape, *part.drive.shape[1:]))
    return np.asarray(np.linalg.svd(np.concatenate([pencil, drive], axis=3), compute_uv=False)[..., -1])
