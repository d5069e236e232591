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
from scipy.linalg import eigh

from phichain.control.blocks import blocks
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
    if linear.B.shape[1] == 0:
        raise ControlError(
            "actuated", "none", "this system has no input", "actuate the cart or joints in the scene"
        )
    M, D, G, B = linear.reduced
    parts, members = _distinct(M, D, G, B)
    rate = max(np.sqrt(np.linalg.norm(part.stiffness, 2)) for part in parts) or 1.0
    size = max(float(np.linalg.norm(part.drive, 2)) for part in parts)
    each = [_modes(part.stiffness, part.damping) for part in parts]
    found = [np.min([_margins(modes / rate, part, rate, size) for part in parts], axis=0) for modes in each]
    modes, margins = (np.concatenate([values[k] for k in members]) for values in (each, found))
    rising = np.argsort(np.abs(modes), kind="stable")
    return Controllability(modes[rising], margins[rising], max(UNCONTROLLABLE, 100 * linear.noise))


@dataclass(frozen=True, eq=False)
class _Part(Held):
    """Links that others do not touch, in coordinates in which M_qq = I."""

    stiffness: Vector
    damping: Vector
    drive: Vector


def _distinct(M: Vector, D: Vector, G: Vector, B: Vector) -> tuple[list[_Part], list[int]]:
    """The parts that differ by more than signs, and which of them each block is."""
    keys: list[bytes] = []
    parts, members = [], []
    for block in blocks((M, D, G), B):
        mass, damping, stiffness, drive = block.square(M), block.square(D), block.square(G), block.across(B)
        key = b"".join(matrix.tobytes() for matrix in (mass, damping, stiffness, drive))
        if key not in keys:
            keys.append(key)
            factor = np.linalg.cholesky(mass)
            parts.append(_Part(_normalised(factor, stiffness), _normalised(factor, damping), solve(factor, drive)))
        members.append(keys.index(key))
    return parts, members


def _normalised(factor: NDArray[Any], part: Vector) -> Vector:
    """L^-1 part L^-T, symmetric."""
    scaled = solve(factor, solve(factor, part).T)
    return (scaled + scaled.T) / 2


def _modes(stiffness: Vector, damping: Vector) -> Spectrum:
    """Eigenvalues of lambda^2 + lambda D + G, the one in the closed right or upper half of each pair."""
    n = len(stiffness)
    if not np.any(damping):
        squares = -eigh(stiffness, eigvals_only=True)
        modes: Spectrum = np.sqrt(squares.astype(complex))
        return modes[np.argsort(np.abs(modes), kind="stable")]
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])
    values = np.linalg.eigvals(first_order).astype(complex)
    upper = values[values.imag >= 0]
    return upper[np.argsort(np.abs(upper), kind="stable")]


def _margins(modes: Spectrum, part: _Part, rate: float, size: float) -> Vector:
    """Smallest singular values of the pencil of one part at all modes, everything in units of the rate."""
    n = len(part.stiffness)
    squares = modes**2
    # Without damping the squares are real, and so is the pencil.
    pencil: NDArray[Any] = (squares if np.any(squares.imag) else squares.real)[:, None, None] * np.eye(n)
    if np.any(part.damping):
        pencil = pencil + modes[:, None, None] * part.damping / rate
    pencil = pencil + part.stiffness / rate**2
    drive = np.broadcast_to(part.drive / size, (len(modes), *part.drive.shape))
    return np.asarray(np.linalg.svd(np.concatenate([pencil, drive], axis=2), compute_uv=False)[:, -1])
