"""Brake orbits in the compiled object: Newton's iteration over a quarter period of the Taylor flow, in one call.

The stencils are those of `stencils/orbits`, compiled beside a generated folder's own C and never written into it. They compute on a
desk of numbers, whose fields are said here and in `desk.c`; that both say the same is checked when they are compiled.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from phichain.contract.chain import Chain
from phichain.errors import ArrayError
from phichain.native.flows.bound import Bound
from phichain.native.memory.arrays import place

KNOWN: Final = 8
"""Places that a curve is touched at."""
CORRECTIONS: Final = 16
"""Corrections that are told."""
ASKED: Final = 32
"""Evaluations that are told."""

Shape = tuple[int, ...]
Array = NDArray[np.float64]


class Ahead(NamedTuple):
    """How a step went: how far it led, how far Newton moved its guess, the cosine of its turn, and the size of [J; t]^-1 dJ."""

    moved: float
    shifted: float
    turned: float
    changed: float


class Numbers(NamedTuple):
    """What is told of an orbit in a number each, in the order of the C, which begins with them.

    Attributes:
        relative: Residual, relative.
        converged: Above 0 where Newton got there.
        is_whole: Above 0 where the columns are of this very place.
        is_told: Above 0 where there is a quarter map.
        taken: Corrections.
        sigma: +- the smallest singular value of [J; t].
        brake_loss: Test function, as the next two.
        odd_loss: That of b.
        unequal_brakes: That of c.
        error: What may be wrong with omega, relative.
        energy: J, from the hanging rest; NaN where none is emitted.
    """

    relative: float
    converged: float
    is_whole: float
    is_told: float
    taken: float
    sigma: float
    brake_loss: float
    odd_loss: float
    unequal_brakes: float
    error: float
    energy: float


def orbit_fields(nq: int, links: int) -> dict[str, Shape]:
    """What is told of one orbit, in the order of the C."""
    every, square = nq + 1, (links, links)
    return {
        **dict.fromkeys(Numbers._fields, ()), "y": (every,), "tangent": (every,), "residual": (nq,), "jacobian": (nq, every),
        "corrections": (CORRECTIONS,), "a": square, "b": square, "c": square, "d": square, "rate": (links,), "force": (links,),
        "slope": (links,), "noise": (nq,), "folded": (links * links,),
    }  # fmt: skip


def desk_fields(nq: int, links: int) -> dict[str, Shape]:
    """What a call is given and tells, in the order of the C."""
    every = nq + 1
    return {
        "scale": (every,), "tolerance": (), "rough": (), "most_steps": (), "tol": (), "trust": (), "most_corrections": (), "guess": (every,),
        "normal": (every,), "count": (), "place": (), "axis": (every,), "known": (KNOWN, 2, every), "before_jacobian": (nq, every),
        "before_tangent": (every,), "moved": (), "shifted": (), "turned": (), "changed": (), "change": (every, every), "evaluations": (), "asked": (ASKED, every + 2),
        "orbit": (sum(map(prod, orbit_fields(nq, links).values())),), "transition": (4 * nq * links,), "rates": (nq,), "steps": (),
    }  # fmt: skip


def offsets(fields: Mapping[str, Shape]) -> dict[str, tuple[int, int, Shape]]:
    """Where every field begins and ends, in numbers, and its shape."""
    found, at = {}, 0
    for name, shape in fields.items():
        found[name] = (at, at + prod(shape), shape)
        at += prod(shape)
    return found


def has_brake(chain: Chain) -> bool:
    """Whether the stencils serve a chain."""
    return chain.is_planar and chain.real == "double" and bool(chain.variational)


@dataclass(frozen=True)
class Braking:
    """The foreign functions.

    Attributes:
        at: The orbit at a guess.
        settled: The same, freed of what Newton still finds.
        corrected: The orbit that Newton finds from it.
        ahead: The next orbit.
        touched: A guess, by the orbits that are known.
    """

    at: Callable[..., int]
    settled: Callable[..., int]
    corrected: Callable[..., int]
    ahead: Callable[..., int]
    touched: Callable[..., int]


class Brake:
    """Brake orbits of one chain with its parameters; one thread at a time, `another` for the next.

    Attributes:
        desk: The numbers that C computes on, by name, all of them views.
        asked: How many evaluations the last call took, which `desk["asked"]` tells.
    """

    def __init__(self, functions: Braking, bind: Callable[[], Bound], sizes: tuple[int, int], scale: Array, tolerance: float, rough: float, most_steps: int) -> None:
        """Bind a flow, and take a problem's sizes.

        Args:
            functions: The foreign functions.
            bind: Binds the flow with all columns.
            sizes: nq and the number of links.
            scale: Sizes of the unknowns (nq + 1,).
            tolerance: Tolerance of the flow.
            rough: The same far from an orbit.
            most_steps: Budget of its steps.
        """
        self._given = functions, bind, sizes, scale, tolerance, rough, most_steps
        self._bound, self._functions = bind(), functions
        self._fields = offsets(orbit_fields(*sizes))
        whole = offsets(desk_fields(*sizes))
        self._memory = np.zeros(max(end for _, end, _ in whole.values()))
        self.desk: dict[str, Array] = {name: self._memory[a:b].reshape(shape) for name, (a, b, shape) in whole.items()}
        self.desk["scale"][:] = scale
        for name, value in (("tolerance", tolerance), ("rough", rough), ("most_steps", most_steps)):
            self.desk[name].fill(value)
        self._orbit, self._guess, self._normal = self.desk["orbit"], self.desk["guess"], self.desk["normal"]
        # Row by row: NumPy takes longer to see what a list of pairs holds than C takes for the polynomial through them.
        self._rows = [(row[0], row[1]) for row in self.desk["known"]]
        self._before_jacobian, self._before_tangent, self._axis = (self.desk[name] for name in ("before_jacobian", "before_tangent", "axis"))
        self._newton, self._where, self._ahead = (
            self._memory[whole[first][0] : whole[last][1]] for first, last in (("tol", "most_corrections"), ("count", "place"), ("moved", "changed"))
        )
        self._desk = ctypes.c_void_p(place(self._memory))
        self._arguments = (*self._bound.context, self._desk)

    def another(self) -> Brake:
        """The same on memory of its own, the flow's included."""
        return Brake(*self._given)

    @property
    def asked(self) -> list[list[float]]:
        """Evaluations of the last call: q_0, omega, the flow's tolerance, and how many columns were carried."""
        return self.desk["asked"][: int(self.desk["evaluations"])].tolist()

    def at(self, y: Array, along: Array | None = None) -> Found | None:
        """The orbit at y (nq + 1,), scaled, whether it closes or not, its tangent along a direction; None where the chain cannot be followed."""
        self._guess[:], self._normal[:] = y, 0 if along is None else along
        return Found(self._orbit.copy(), self._fields) if self._functions.at(*self._arguments) else None

    def settled(self, y: Array, along: Array) -> Found | None:
        """The same, freed of what Newton still finds to be wrong with it."""
        self._guess[:], self._normal[:] = y, along
        return Found(self._orbit.copy(), self._fields) if self._functions.settled(*self._arguments) else None

    def corrected(self, guess: Array, normal: Array, tol: float, trust: float, most: int) -> Found:
        """Newton from a guess (nq + 1,) in the plane across a normal, to a correction below tol or trust, with so many at most."""
        self._guess[:], self._normal[:] = guess, normal
        self._newton[:] = tol, trust, most
        self._functions.corrected(*self._arguments)
        return Found(self._orbit.copy(), self._fields)

    def ahead(self, known: Sequence[tuple[Array, Array]], jacobian: Array, step: float, tol: float, most: int) -> tuple[Found, Ahead]:
        """The orbit a step ahead of the last of those with tangents that are known, whose Jacobian (nq, nq + 1) is given, too.

        Raises:
            ArrayError: More than `KNOWN` are.
        """
        self._know(known)
        self._before_jacobian[:], self._before_tangent[:] = jacobian, known[-1][1]
        self._newton[:] = tol, 0.0, most
        self._where[:] = len(known), step
        self._functions.ahead(*self._arguments)
        return Found(self._orbit.copy(), self._fields), Ahead(*self._ahead.tolist())

    def _know(self, known: Sequence[tuple[Array, Array]]) -> None:
        if len(known) > KNOWN:
            raise ArrayError("known", len(known), f"must be at most {KNOWN} places", "give those that are nearest")
        for (at, along), (y, tangent) in zip(self._rows, known, strict=False):
            at[:], along[:] = y, tangent

    @property
    def change(self) -> Array:
        """[J; t]^-1 [J'; t] of the last step, t its first tangent (nq + 1, nq + 1)."""
        return self.desk["change"].copy()

    def touched(self, known: Sequence[tuple[Array, Array]], axis: Array, at: float) -> Array | None:
        """Where the curve through places with tangents has a distance along an axis (nq + 1,); None where none goes along it.

        Raises:
            ArrayError: They are more than `KNOWN`.
        """
        self._know(known)
        self._where[:], self._axis[:] = (len(known), at), axis
        return self._guess.copy() if self._functions.touched(self._desk) else None


class Found:
    """What is told of an orbit: numbers at once, arrays by name when they are asked for."""

    __slots__ = ("_fields", "_row", "numbers")

    def __init__(self, row: Array, fields: Mapping[str, tuple[int, int, Shape]]) -> None:
        """Take what C told."""
        row.flags.writeable = False
        self._row, self._fields, self.numbers = row, fields, Numbers(*row[:_NUMBERS].tolist())

    def array(self, name: str) -> Array:
        """An array."""
        begin, end, shape = self._fields[name]
        part = self._row[begin:end]
        return part if len(shape) == 1 else part.reshape(shape)


_NUMBERS: Final = len(Numbers._fields)
