"""Controllability (20)-(21) with its margin.

The reduced system is controllable when [lambda^2 M_qq + lambda D_qq + G_qq, B_q] has full rank at every eigenvalue
lambda of the links. Instead of a yes or no, the smallest singular value of that pencil is given, mode by mode, in
coordinates where M_qq = I and divided by the size of the input: 0 is uncontrollable, and the smaller it is, the more
effort (and the larger gains) that mode takes.

A chain with its masses at the link ends is controllable from its cart at every equilibrium; with r < l it need not
be: two links folded on each other (s_2 = -s_1) with r_2 = l_1 - r_1 have a mode in which the cart feels no force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.control.equations.blocks import Indices, alike, turned
from phichain.control.linear import LinearSystem, linearize
from phichain.control.weights import Spectrum, solve
from phichain.errors import ControlError
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.angles import absolute_angles

UNCONTROLLABLE = 1e-10
"""Margins below this are called uncontrollable, or below a hundred times the accuracy of the matrices."""

SHOWN = 3
"""Other equilibria that an error names."""

LOOKED_THROUGH = 8
"""Links up to which all equilibria are looked through for others."""


@dataclass(frozen=True)
class Alternatives:
    """What would be controllable where an equilibrium is not.

    Attributes:
        equilibria: Other ones of the same chain, those with the fewest links turned first.
        joints: Joints, from 1, one torque at any of which would do.
    """

    equilibria: tuple[tuple[int, ...], ...] = ()
    joints: tuple[int, ...] = ()

    def __str__(self) -> str:
        near = ", ".join(str(list(s)) for s in self.equilibria[:SHOWN])
        parts = [f"choose another equilibrium, such as s = {near}" if near else "choose another equilibrium", "move a mass"]
        return f"{', '.join(parts)}, or actuate {'joint ' + ' or '.join(map(str, self.joints)) if self.joints else 'a joint'}"


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

    def demand(self, s: Sequence[int], alternatives: Callable[[], Alternatives] | None = None) -> Controllability:
        """Itself, or an error that names the mode.

        Args:
            s: The equilibrium.
            alternatives: Finds what would be controllable instead, asked only where this is not.

        Raises:
            ControlError: A mode is uncontrollable; carries `mode` (lambda), `number` (from 1) and `margin`.
        """
        if self.is_controllable:
            return self
        mode = complex(self.modes[self.worst])
        instead = Alternatives() if alternatives is None else alternatives()
        raise ControlError(
            "s",
            list(s),
            f"mode {self.worst + 1} (lambda = {mode:.6g} 1/s) is uncontrollable: margin {self.margin:.2g}",
            str(instead),
            mode=mode,
            number=self.worst + 1,
            margin=self.margin,
            equilibria=instead.equilibria,
            joints=instead.joints,
        )


def controllability(system: System, s: Sequence[int], p: Parameters | None = None) -> Controllability:
    """The margins of one equilibrium.

    Raises:
        ControlError: s is no equilibrium, or the system has no input.
        AbsentFunctionError: The system has no `linearization`.
    """
    return margins_of(linearize(system, s, p))


def alternatives(system: System, s: Sequence[int], p: Parameters | None = None) -> Alternatives:
    """What would be controllable instead of an equilibrium that is not: others of a chain of up to 8 links, and torques in the plane."""
    near: list[tuple[int, ...]] = []
    if system.links <= LOOKED_THROUGH:
        others = [other for other in product((1, -1), repeat=system.links) if other != tuple(s)]
        others.sort(key=lambda other: sum(a != b for a, b in zip(other, s, strict=True)))
        found = margins_of_all([linearize(system, other, p) for other in others])
        near = [other for other, margins in zip(others, found, strict=True) if margins.is_controllable]
    return Alternatives(tuple(near), _joints(system, linearize(system, s, p)) if system.is_planar else ())


def _joints(system: System, linear: LinearSystem) -> tuple[int, ...]:
    """Joints whose torque, beside the inputs that are there, reaches every mode."""
    m, c = len(linear.M), linear.cart
    # The relative angle of joint k is the difference of two links' directions; a torque there works along it.
    turned = np.diff(absolute_angles(system, np.eye(m)[:, : system.nq]), axis=-1, prepend=0.0)
    found = []
    for joint in range(m - c):
        more = np.hstack([linear.B, turned[:, joint : joint + 1]])
        if margins_of(replace(linear, B=more)).is_controllable:
            found.append(joint + 1)
    return tuple(found)


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
