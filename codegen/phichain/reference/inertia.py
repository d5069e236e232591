"""The inertia of a chain: applied to rates, written out, and solved with; J^T m J of `masses`, and the joints' rotors.

Short chains are solved with the matrix as it is written out. Longer ones in coordinates that keep what the Jacobians eliminate:
the places p_k of the joints beyond the links, held by forces f_k. What is to be stationary is

    1/2 m_0 |x''|^2 + sum_k 1/2 (m_k |p_{k-1}'' + com_k w_k|^2 + J_k |w_k|^2) + sum_k 1/2 A_k (w_k - w_{k-1})^2 + sum_k f_k.(p_k'' - p_{k-1}'' - l_k w_k) - F.x'' - sum_k tau_k.(rates of w_k),

w_k the links' vectors moved by their own rates: one sparse system whose band is as wide as one link, eliminated with pivots. That
system is believed in nothing: M times its solution, summed up from positions, must be the force, and what is left of the force,
solved for again, must be as small as round-off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from mpmath import mp, mpf

from phichain.errors import ConvergenceError
from phichain.reference.algebra import Matrix, Vector, dot, solve, unit
from phichain.reference.elimination import Factored, Row, factored
from phichain.reference.masses import conjugate, driven, rotor_momentum
from phichain.reference.pose import Parameters, Pose, cart_axes, pushed_forward, scene_angles
from phichain.scene import Scene

#: Up to so many rates the matrix itself takes fewer operations.
DENSE: Final = 10
#: Bits of the working precision that may be lost before it is raised: two thirds of the guard.
_LOST_BITS: Final = 132
_PRECISIONS: Final = (1, 2, 4)


@dataclass(frozen=True)
class Inertia:
    """J^T m J and rotors with m_0 on the cart's diagonal, in the rates of a pose (planar: of the scene's own angles).

    Attributes:
        scene: the chain.
        values: its numbers.
        pose: where it is.
        ahead: where the rates act, if that is another pose than the one where the forces are taken: J^T m J_ahead.
        normals: one vector n_k a link, if its rates w_k (three, along e_1, e_2, e_3) are held by a multiplier Lambda_k: the rates
            have the multipliers behind them, and the forces behind them the n_k.w_k. The matrix is [M, -n; n^T, 0].
    """

    scene: Scene
    values: Parameters
    pose: Pose
    ahead: Pose | None = None
    normals: Matrix | None = None

    def times(self, rates: Vector) -> Vector:
        """Return the matrix times rates, in O(N)."""
        carts = cart_axes(self.scene)
        rates, multipliers = rates[: self._rates], rates[self._rates :]
        moved = driven(self.scene, self.values, self.ahead or self.pose, rates)
        force = conjugate(self.scene, self.values, self.pose, moved)
        for axis in range(carts):
            force[axis] += self.values.cart_mass * rates[axis]
        force = [a + b for a, b in zip(force, rotor_momentum(self.scene, self.values, rates), strict=True)]
        if self.normals is None:
            return force
        pulls = [held * entry for held, normal in zip(multipliers, self.normals, strict=True) for entry in normal]
        links = [rates[i : i + 3] for i in range(carts, len(rates), 3)]
        along = [dot(normal, link) for normal, link in zip(self.normals, links, strict=True)]
        return force[:carts] + [a - b for a, b in zip(force[carts:], pulls, strict=True)] + along

    def written(self) -> Matrix:
        """Return the matrix, row by row."""
        size = self._size
        columns = [self.times(unit(size, i)) for i in range(size)]
        return [list(row) for row in zip(*columns, strict=True)]

    def solve(self, *forces: Vector) -> Matrix:
        """Return the rates for which the matrix times them is each of these forces.

        Raises:
            ConvergenceError: the system that is eliminated does not give them.
        """
        if self._size <= DENSE:
            return solve(self.written(), list(forces))
        for times in _PRECISIONS:
            working = mp.prec
            with mp.workprec(times * working):
                system = _System(self, factored(_rows(self)))
                answers = [self._refined(system, force, working) for force in forces]
            found = [answer for answer in answers if answer is not None]
            if len(found) == len(answers):
                return [[+entry for entry in answer] for answer in found]
        raise ConvergenceError(
            "precision", mp.prec, "does not hold the accelerations of this chain: what they leave of the forces stays",
            "ask for more digits, or bring masses and lengths nearer to each other",
        )  # fmt: skip

    def _refined(self, system: _System, force: Vector, working: int) -> Vector | None:
        """The solution, corrected by what it left of the force; None where that is more than round-off."""
        rates = system.solve(force)
        left = [a - b for a, b in zip(force, self.times(rates), strict=True)]
        change = system.solve(left)
        if max(map(abs, change)) > max(map(abs, rates)) * mpf(2) ** (_LOST_BITS - working):
            return None
        return [a + b for a, b in zip(rates, change, strict=True)]

    @property
    def _rates(self) -> int:
        return cart_axes(self.scene) + sum(map(len, self.pose.turning))

    @property
    def _size(self) -> int:
        return self._rates + len(self.normals or ())


@dataclass(frozen=True)
class _System:
    """The sparse system, and where forces and rates stand in it."""

    inertia: Inertia
    matrix: Factored

    def solve(self, force: Vector) -> Vector:
        scene, carts = self.inertia.scene, cart_axes(self.inertia.scene)
        own = pushed_forward(scene, force[carts:]) if scene.is_planar else force[carts:]
        places = _places(self.inertia)
        right: Vector = [mpf(0)] * len(self.matrix.steps)
        for place, entry in zip(places, [*force[:carts], *own], strict=True):
            right[place] = entry
        x = self.matrix.solve(right)
        rates = [x[place] for place in places]
        return rates[:carts] + (scene_angles(scene, rates[carts:]) if scene.is_planar else rates[carts:])


def _places(inertia: Inertia) -> list[int]:
    """The number of each rate, which is that of the row with its force: the cart's, every link's before its f_k and p_k, multipliers last."""
    carts, size = cart_axes(inertia.scene), len(inertia.pose.direction[0])
    places, multipliers, first = list(range(carts)), [], carts
    for turning in inertia.pose.turning:
        places += range(first, first + len(turning))
        first += len(turning)
        if inertia.normals is not None:
            multipliers.append(first)
            first += 1
        first += 2 * size
    return places + multipliers


def _rows(inertia: Inertia) -> list[Row]:
    """The derivatives of the function above by x'', the links' rates, f_k and p_k''; the last link has neither f nor p."""
    values, pose, ahead = inertia.values, inertia.pose, inertia.ahead or inertia.pose
    carts, size = cart_axes(inertia.scene), len(pose.direction[0])
    rows: list[Row] = [{axis: values.cart_mass} for axis in range(carts)]
    inner: Sequence[int | None] = [axis if axis < carts else None for axis in range(size)]
    before: int | None = None
    numbers = zip(values.mass, values.length, values.com, pose.turning, ahead.turning, strict=True)
    spins = values.inertia or [mpf(0)] * inertia.scene.links
    for k, ((mass, length, com, turning, moving), spin) in enumerate(zip(numbers, spins, strict=True), 1):
        first = len(rows)
        normal = None if inertia.normals is None else inertia.normals[k - 1]
        held = first + len(turning)
        force = range(held + (normal is not None), held + (normal is not None) + size)
        joint = range(force.stop, force.stop + size)
        is_last = k == inertia.scene.links
        for turn in turning:
            row: Row = {first + j: (mass * com * com + spin) * dot(turn, other) for j, other in enumerate(moving)}
            row |= {place: mass * com * entry for place, entry in zip(inner, turn, strict=True) if place is not None}
            rows.append(row if is_last else row | {place: -length * entry for place, entry in zip(force, turn, strict=True)})
        _add_rotor(rows, values.armature[k - 1], first, before)
        before = first
        if normal is not None:
            for j, entry in enumerate(normal):
                rows[first + j][held] = -entry
            rows.append({first + j: entry for j, entry in enumerate(normal)})
        for axis, place in enumerate(inner):
            if place is not None:
                _add(rows[place], place, mass)
                for j, other in enumerate(moving):
                    _add(rows[place], first + j, mass * com * other[axis])
                if not is_last:
                    _add(rows[place], force[axis], mpf(-1))
        if is_last:
            break
        for axis, place in enumerate(inner):
            row = {first + j: -length * other[axis] for j, other in enumerate(moving)} | {joint[axis]: mpf(1)}
            rows.append(row if place is None else row | {place: mpf(-1)})
        rows += [{force[axis]: mpf(1)} for axis in range(size)]
        inner = list(joint)
    return rows


def _add_rotor(rows: list[Row], inertia: Any, own: int, before: int | None) -> None:
    """The derivatives of 1/2 A (w_k - w_{k-1})^2; rates and rows have the same numbers."""
    if not inertia:
        return
    _add(rows[own], own, inertia)
    if before is not None:
        _add(rows[before], before, inertia)
        _add(rows[own], before, -inertia)
        _add(rows[before], own, -inertia)


def _add(row: Row, column: int, value: Any) -> None:
    row[column] = row.get(column, 0) + value
