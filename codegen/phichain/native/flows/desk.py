"""The desk of numbers that the stencils of brake orbits compute on: its fields are said here and in `stencils/orbits/desk.c`; that both say the same is checked when they are compiled."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from functools import lru_cache
from math import prod
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from phichain.native.flows.bound import Bound
from phichain.native.memory.arrays import place

KNOWN: Final = 8
"""Places that a curve is touched at."""
CORRECTIONS: Final = 16
"""Corrections that are told."""
ASKED: Final = 1024
"""Evaluations that are told."""
WATCHED: Final = 24
"""Test functions of a run."""
ROWS: Final = 64
"""Orbits of one call of a run."""
TRIES: Final = 16
"""Orbits on the way to a zero."""
EVENTS: Final = 24
"""Zeros that one call of a run finds."""
ZEROS: Final = 16
"""Zeros of the step before that a run knows."""
LINE: Final = 24
"""Places of a curve that is known between two points, its two ends twice."""
OUTSIDE: Final = 4
"""Values outside a bracket."""
SHAPE: Final = 8
"""Places beside one where [J; t] is singular."""
WHAT: Final = (
    "tangent", "unknown", "largest angle", "energy", "sigma", "brake loss", "odd loss", "unequal brakes", "energy slope", "steepness", "largest kappa",
)
"""What a test function may be of, in the order of the C."""
STOPPED: Final = ("on", "met", "sign", "small")
"""Why a run stands: it may go on; somebody has to look at its last orbit; the same, det [J; t] having another sign there; it needs too small a step."""

Shape = tuple[int, ...]
Array = NDArray[np.float64]


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
        largest_kappa: The largest |kappa|.
        energy_slope: dV . t, with the tangent that is told.
        steepness: |dV| |theta| / 2 V at the rest.
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
    largest_kappa: float
    energy_slope: float
    steepness: float


def orbit_fields(nq: int, links: int) -> dict[str, Shape]:
    """What is told of one orbit, in the order of the C."""
    every, square = nq + 1, (links, links)
    return {
        **dict.fromkeys(Numbers._fields, ()), "y": (every,), "tangent": (every,), "residual": (nq,), "jacobian": (nq, every),
        "corrections": (CORRECTIONS,), "a": square, "b": square, "c": square, "d": square, "rate": (links,), "force": (links,),
        "slope": (links,), "noise": (nq,), "folded": (links * links,),
    }  # fmt: skip


def row_fields(nq: int, links: int) -> dict[str, Shape]:
    """What is told of one orbit of a run, in the order of the C."""
    return {"arclength": (), "step": (), "values": (WATCHED,), "orbit": (_size(orbit_fields(nq, links)),)}


def event_fields(nq: int, links: int) -> dict[str, Shape]:
    """What is told of a zero that a run met, in the order of the C."""
    return {"before": (), "which": (), "arclength": (), "left": (), "y": (nq + 1,), "folded": (links * links,)}


def _size(fields: Mapping[str, Shape]) -> int:
    return sum(map(prod, fields.values()))


def desk_fields(nq: int, links: int) -> dict[str, Shape]:
    """What a call is given and tells, in the order of the C."""
    every = nq + 1
    return {
        "scale": (every,), "tolerance": (), "rough": (), "most_steps": (), "tol": (), "trust": (), "most_corrections": (), "is_place": (), "guess": (every,),
        "normal": (every,), "count": (), "place": (), "axis": (every,), "known": (KNOWN, 2, every), "before_jacobian": (nq, every),
        "before_tangent": (every,), "moved": (), "shifted": (), "turned": (), "changed": (), "change": (every, every), "evaluations": (), "asked": (ASKED, every + 2),
        "orbit": (_size(orbit_fields(nq, links)),), "transition": (4 * nq * links,), "rates": (nq,), "steps": (),
        "step": (), "step_min": (), "step_max": (), "max_angle": (), "aim_angle": (), "max_change": (), "wanted": (), "since": (), "start": (2, every),
        "watched": (), "watch": (WATCHED, 5), "seen": (), "at": (KNOWN,), "values": (KNOWN, WATCHED), "sigmas": (KNOWN,), "zero_count": (), "zeros": (ZEROS, 2),
        "taken": (), "stopped": (), "doubtful": (), "met": (), "rows": (ROWS, _size(row_fields(nq, links))), "events": (EVENTS, _size(event_fields(nq, links))), "tried": (),
        "tries": (TRIES, _size(row_fields(nq, links))), "line_count": (), "line_at": (LINE,), "line": (LINE, 2, every), "line_values": (2,), "outside_count": (),
        "outside": (OUTSIDE, 2), "placed": (SHAPE, every + 1), "shape_centre": (), "shape_half": (), "shape": (SHAPE, every), "line_spacing": (), "line_near": (), "line_settle": (), "line_regular": (),
    }  # fmt: skip


_Places = Mapping[str, tuple[int, int, Shape]]


class Desk(dict[str, Array]):
    """Views of the fields on some memory, each made when it is first asked for: most calls need few of them."""

    def __init__(self, memory: Array, places: Mapping[str, tuple[int, int, Shape]]) -> None:
        """Take the memory, and where the fields lie in it (`offsets`)."""
        super().__init__()
        self._memory, self._places = memory, places

    def __missing__(self, name: str) -> Array:
        begin, end, shape = self._places[name]
        self[name] = view = self._memory[begin:end].reshape(shape)
        return view


def offsets(fields: Mapping[str, Shape]) -> dict[str, tuple[int, int, Shape]]:
    """Where every field begins and ends, in numbers, and its shape."""
    found, at = {}, 0
    for name, shape in fields.items():
        found[name] = (at, at + prod(shape), shape)
        at += prod(shape)
    return found


@lru_cache
def _places(nq: int, links: int) -> tuple[_Places, _Places, _Places]:
    """Where the fields of an orbit, of an event and of the desk lie."""
    orbit, event, desk = (offsets(fields(nq, links)) for fields in (orbit_fields, event_fields, desk_fields))
    return orbit, event, desk


class Table:
    """A flow that is bound, to whatever tolerance and budget, with a desk and its views: what one `Brake` computes on, and the next one when nobody has that any more.

    Attributes:
        bound: The flow, with all columns.
        memory: The desk's numbers.
        desk: Views of them by name.
        orbit: Where the fields of an orbit lie.
        event: Where those of an event lie.
        parts: Views of fields side by side: of Newton's iteration, of a place on a curve, of what a step tells, of a run, of a zero.
        rows: Views row by row of places known and of a line: NumPy takes longer to see what a list of pairs holds than C takes for the polynomial through them.
        at: The desk's address.
    """

    def __init__(self, bound: Bound, nq: int, links: int) -> None:
        """Lay out a desk for a chain."""
        self.bound = bound
        self.orbit, self.event, whole = _places(nq, links)
        self.memory = np.zeros(max(end for _, end, _ in whole.values()))
        self.desk: Mapping[str, Array] = Desk(self.memory, whole)
        self.parts = tuple(self.memory[whole[first][0] : whole[last][1]] for first, last in _PARTS)
        self.rows = tuple([(row[0], row[1]) for row in self.desk[name]] for name in ("known", "line"))
        self.at = ctypes.c_void_p(place(self.memory))


_PARTS = ("tol", "most_corrections"), ("count", "place"), ("moved", "changed"), ("step", "since"), ("line_spacing", "line_regular")
