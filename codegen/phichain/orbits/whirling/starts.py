"""Where whirling families begin: at small motions beside a conical orbit, at orbits in a plane, and where these lose their plane.

*Beside a relative equilibrium* that turns at Omega, x+' = B x-, x-' = C x+ in even and odd motions of the turning frame: at every square
s^2 < 0 of an exponent, an eigenvalue of B C, begin orbits of omega = |s|, phi = 2 pi Omega / omega that leave J as it is.

*An orbit in a plane* with the period T_p is mirrored, so turned by pi, half of it later: as a whirling orbit it has T = T_p / 2, phi = pi and,
at its rest, r = 0. Of the same energy there are orbits beside it that turn either way.

*Where it loses its plane* it does so in one of four ways, told by which block of the quarter map of motions out of the plane is singular:

    det d = 0    mu = -1   from the rest, across the plane; T = T_p / 2
    det b = 0    mu = +1   from the rest, across the plane; T = T_p
    det c = 0    mu = +1   from where the chain hangs straight, its links leaning across; T = T_p
    det a = 0    mu = -1   orbits that stand still off any plane, which no vertical plane's mirror image is the reversal of: `orbits.in_space`
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Special
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits.conical.starts import METHOD as CONICAL
from phichain.orbits.in_plane import METHOD as IN_PLANE
from phichain.orbits.in_plane import PLANE_LOSS
from phichain.orbits.quarter import EPS
from phichain.orbits.targets import placed, point_index
from phichain.orbits.whirling.fixed import fixed, read
from phichain.orbits.whirling.problem import whirling_problem
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.state import rhs_jacobian

METHOD: Final = "whirling"
NEEDED: Final = ("forward_dynamics", "state_jacobian", "energy", "mass_matrix", "propagate")
"""Functions that whirling families call."""
_REMEDY: Final = (
    'give a conical family or one "in a plane", (Branch, point), (Branch, event), "FILE.json:POINT" or "FILE.json:event=K" of one'
)
_REAL: Final = 1e-9
"""Relative size below which an imaginary part, or a square, is rounding."""
_SINGULAR: Final = 1e-6
"""Relative size below which a singular value is zero: events are located to about 1e-10."""


@dataclass(frozen=True, eq=False)
class Whirl(Held):
    """Where a family begins.

    Attributes:
        z: Unknowns there (theta, r, phi, omega) (2 N + 2,).
        shape: How it leaves (2 N + 2,), the largest change of an angle, or of a rate over omega, 1; zero where its Jacobian says.
        where: The same in words.
    """

    z: Vector
    shape: Vector
    where: str


def whirls_of(system: System, start: Any, p: Parameters | None = None) -> tuple[Whirl, ...]:
    """All families that begin at a start: beside a conical orbit by rising frequency, and one at any other.

    Args:
        system: A spatial chain on a fixed base.
        start: A Branch of conical orbits or of orbits in a plane (its last point), (Branch, index), (Branch, event) or its file.
        p: Runtime parameters.

    Raises:
        UnsupportedError: The chain is planar, on a cart, loses energy, or lacks what shooting needs; or no such orbits are followed.
        ArrayError: There is no start, or it is none of these.
    """
    demand_whirling(system)
    branch, at = given_family(start)
    if branch.digest != system.digest:
        raise ArrayError("start", branch.digest, f"is the digest of that branch's scene, and {system.digest!r} is wanted here", "use its scene")
    z = at.z if isinstance(at, Special) else branch.points[at]
    if branch.method == CONICAL:
        return _beside(system, z, p)
    if isinstance(at, Special) and at.kind == PLANE_LOSS:
        return (_off_plane(system, z, p),)
    links = system.links
    z_whirl = np.concatenate([z[:links], np.zeros(links), [np.pi, 2 * z[-1]]])
    return (Whirl(z_whirl, np.zeros(2 * links + 2), "beside an orbit in a plane"),)


def demand_whirling(system: System, method: str = METHOD) -> None:
    """Refuse a chain that has no orbits in space that come back, or lacks what they call.

    Raises:
        UnsupportedError: It is one.
    """
    if system.is_planar or system.has_cart:
        raise UnsupportedError("method", method, "is for spatial chains on a fixed base", 'use method = "shooting" with a planar scene')
    missing = [name for name in NEEDED if not system.has(name)]
    if missing or not system.variational or system.real != "double":
        raise UnsupportedError(
            "method", method, f"system '{system.name}' lacks a double precision flow that carries derivatives, or what it calls",
            f"build its scene with [functions] want = {list(NEEDED)} and [flow] variational = true",
        )  # fmt: skip


def given_family(start: Any, methods: tuple[str, ...] = (CONICAL, IN_PLANE)) -> tuple[Branch, int | Special]:
    """A family and its point or event.

    Raises:
        ArrayError: It is no start.
    """
    if isinstance(start, Path | str):
        path, place = placed(str(start))
        branch = Branch.from_json(path)
        start = (branch, _event(branch, place.removeprefix("event=")) if "=" in place else point_index(place or "-1"))
    if isinstance(start, Branch):
        start = (start, -1)
    if not (isinstance(start, tuple) and len(start) == 2 and isinstance(start[0], Branch) and isinstance(start[1], int | Special)):
        raise ArrayError("start", start, "is nothing that whirling families begin at", _REMEDY)
    branch, at = start
    if branch.method not in methods:
        raise ArrayError("start", branch.method, "is how that branch was traced: whirling families begin at others", _REMEDY)
    if not isinstance(at, Special) and (isinstance(at, bool) or not -len(branch) <= at < len(branch)):
        raise ArrayError("start", at, f"is no point of that branch, which has {len(branch)}", f"use 0 .. {len(branch) - 1}; in FILE.json:POINT they count from 1")
    return branch, at


def _event(branch: Branch, number: str) -> Special:
    events = branch.own_events
    if not number.isdecimal() or not 1 <= int(number) <= len(events):
        raise ArrayError("start", number, f"is none of that branch's {len(events)} events", "count them from 1")
    return events[int(number) - 1]


def _beside(system: System, z: Vector, p: Parameters | None) -> tuple[Whirl, ...]:
    """The families beside a relative equilibrium (theta, Omega)."""
    theta, turning = z[:-1], float(z[-1])
    links = len(theta)
    at = fixed(theta, turning * np.sin(theta))
    jacobian = np.asarray(rhs_jacobian(system)(0.0, at.x, None, p))
    about = np.kron(np.eye(2 * links), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    linear = jacobian - turning * about
    forth, back = read(at, linear @ at.even)[1], read(at, linear @ at.odd)[0]
    squares, shapes = np.linalg.eig(back @ forth)
    largest = float(np.max(np.abs(squares)))
    found: list[Whirl] = []
    for square, shape in sorted(zip(squares, shapes.T, strict=True), key=lambda pair: abs(pair[0])):
        if abs(square.imag) > _REAL * largest or square.real > -_REAL * largest:
            continue
        omega = float(np.sqrt(-square.real))
        real = shape.real / np.max(np.abs(np.concatenate([shape.real[:links], shape.real[links:] / omega])))
        begun = np.concatenate([theta, turning * np.sin(theta), [2 * np.pi * turning / omega, omega]])
        where = f"small motion {len(found) + 1} beside the conical orbit that turns at {turning:.6g} rad/s"
        found.append(Whirl(begun, np.concatenate([real, [0.0, 0.0]]), where))
    if not found:
        raise UnsupportedError(
            "start", z.tolist(), "is a conical orbit beside which no small motion only oscillates", "start from another point of its family"
        )
    return tuple(found)


def _off_plane(system: System, z: Vector, p: Parameters | None) -> Whirl:
    """The family that an orbit in a plane opens where it loses it: of those that it may be, the one whose equations have a null vector.

    Raises:
        UnsupportedError: It is of the kind that stands still off any plane.
    """
    links, omega = system.links, float(z[-1])
    still = np.zeros(links)
    quarter = system.propagate(fixed(z[:-1], still).x[: 3 * links], np.zeros(3 * links), 0.0, np.pi / (2 * omega), EPS, **system.parameters(p))
    # At T / 4 the chain hangs straight and moves along x, which is across the plane of y.
    straight = -np.asarray(quarter.v).reshape(links, 3)[:, 1]
    across, within = [*range(links, 2 * links), 2 * links], [*range(links), 2 * links]
    candidates = (
        ("from a rest, after half of its period", np.concatenate([z[:-1], still, [np.pi, 2 * omega]]), across),
        ("from a rest", np.concatenate([z[:-1], still, [0.0, omega]]), across),
        ("from where it hangs straight", np.concatenate([still, straight, [0.0, omega]]), within),
    )
    found = []
    for words, begun, moved in candidates:
        problem = whirling_problem(system, p, held="momentum", value=0.0, omega=omega)
        _, sizes, rows = np.linalg.svd(problem.at(begun / problem.sizes).jacobian[:, moved])
        shape = np.zeros(len(begun))
        shape[moved] = rows[-1] * problem.sizes[moved]
        found.append((float(sizes[-1] / sizes[0]), words, begun, shape))
    least, words, begun, shape = min(found, key=lambda one: one[0])
    if least > _SINGULAR:
        raise UnsupportedError(
            "start", PLANE_LOSS, "opens orbits that stand still off any plane, and turn nowhere", 'use method = "in space"',
        )  # fmt: skip
    return Whirl(begun, shape / np.max(np.abs(sized(shape, begun[-1]))), f"an orbit in a plane that loses it, {words}")


def sized(unknowns: Vector, omega: float) -> Vector:
    """Angles, and rates over omega (2 N,), of unknowns (2 N + 2,)."""
    links = len(unknowns) // 2 - 1
    return np.concatenate([unknowns[:links], unknowns[links : 2 * links] / omega])
