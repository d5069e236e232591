"""A map of one region of attraction: which starts of a plane through its equilibrium come home, and when."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from phichain.archive import COUNT, NUMBER, TEXT, VALUES, Schema, names, read_archive, real, signs, whole
from phichain.contract.words import known_names
from phichain.control.reach.attraction import CHUNK, FAR, NEAR
from phichain.control.reach.starts import Flown, turn_names, turned
from phichain.errors import ControlError
from phichain.laws import GainTable
from phichain.records import Shown, write_csv, write_npz
from phichain.system import System, Vector
from phichain.system.arrays import number
from phichain.system.vertical import Signs

_ARRAYS: Final = {"axis": real("points"), "verdict": whole("points", "points"), "time": real("points", "points")}
_SCHEMA: Final = Schema(
    "AttractionMap", _ARRAYS, {"name": TEXT, "digest": TEXT, "coordinates": names("two"), "s": signs("links"), "seconds": NUMBER, "two": COUNT, "p": VALUES},
    filled=("points", "links"),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class AttractionMap(Shown):
    """Starts of a plane, at rest.

    Attributes:
        name: The scene.
        digest: Its canonical digest.
        s: The equilibrium.
        coordinates: The two turns that are mapped, all others zero.
        axis: Their values (points,), rad, or sines of tilts in space.
        verdict: 1 home, 0 flown off, -1 neither in time (points, points), the first coordinate along the columns.
        time: When, s (points, points).
        seconds: Time within which a start had to come home.
    """

    name: str
    digest: str
    s: Signs
    coordinates: tuple[str, ...]
    axis: Vector
    verdict: Vector
    time: Vector
    seconds: float

    def __str__(self) -> str:
        share = float(np.mean(self.verdict == 1))
        reach = f"{self.axis[-1]:.3g}"
        return f"{self.name}: {100 * share:.3g} % of starts with {' and '.join(self.coordinates)} within {reach} of s = {list(self.s)} come home"

    def to_csv(self, path: Path | str) -> Path:
        """Write one row per start; 17 digits."""
        first, second = np.meshgrid(self.axis, self.axis)
        columns = dict(zip(self.coordinates, (first.ravel(), second.ravel()), strict=True))
        return write_csv(path, {**columns, "verdict": self.verdict.ravel(), "time": self.time.ravel()}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        meta = {"name": self.name, "digest": self.digest, "coordinates": list(self.coordinates), "s": list(self.s), "seconds": self.seconds, "p": self.p}
        return write_npz(path, {name: getattr(self, name) for name in _ARRAYS}, meta | {"kind": _SCHEMA.kind, "two": 2})

    @classmethod
    def from_npz(cls, path: Path | str) -> AttractionMap:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, or holds no AttractionMap, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        return cls(meta["name"], meta["digest"], tuple(meta["s"]), tuple(meta["coordinates"]), **arrays, seconds=meta["seconds"], p=meta["p"])


def demand_turns(system: System, coordinates: tuple[str, ...]) -> tuple[str, str]:
    """The names of two turns of a chain's links.

    Raises:
        ControlError: One is none, or they are not two.
    """
    turns = turn_names(system)
    for name in coordinates:
        if name not in turns:
            raise ControlError("map", name, "is no turn of a link", known_names(name, turns))
    if len(set(coordinates)) < 2 or len(coordinates) > 2:
        raise ControlError("map", list(coordinates), "are not two turns", f"name two of {', '.join(turns)}")
    return coordinates[0], coordinates[1]


def attraction_map(
    system: System, table: GainTable, flown: Flown, which: int, coordinates: tuple[str, ...], extent: float, points: int = 61, seconds: float = 15.0
) -> AttractionMap:
    """The map of one equilibrium of a table.

    Args:
        system: The chain.
        table: Its laws.
        flown: The closed loop of both, from `build_closed_loop`.
        which: Number of the equilibrium.
        coordinates: Names of two turns of links, xi_1 .. in the plane, xi_1_1, xi_1_2 .. in space.
        extent: Largest turn, rad; in space less than 1.
        points: Starts along each axis.
        seconds: Time within which a start must come home.

    Raises:
        ControlError: A coordinate is no turn of the chain, both are one, or a number is not positive.
    """
    turns, coordinates = turn_names(system), demand_turns(system, coordinates)
    size = number("extent", extent, "give the largest turn, rad", ControlError)
    for field, value in (("extent", size), ("points", points - 1), ("seconds", seconds)):
        if not 0 < value < np.inf:
            raise ControlError(field, value, "is not positive", "give a positive number")
    axis = np.linspace(-size, size, points)
    first, second = np.meshgrid(axis, axis)
    xi = np.zeros((points**2, len(turns)))
    xi[:, turns.index(coordinates[0])], xi[:, turns.index(coordinates[1])] = first.ravel(), second.ravel()
    calls = max(1, round(seconds / flown.period))
    found = [
        flown(which, turned(system, table.signs[which], xi[start : start + CHUNK]), calls, NEAR, FAR) for start in range(0, len(xi), CHUNK)
    ]
    verdict, came = (np.concatenate(parts).reshape(points, points) for parts in zip(*found, strict=True))
    return AttractionMap(
        table.name, table.digest, table.signs[which], coordinates, axis, verdict.astype(np.int64), came * flown.period, float(seconds), p=table.p
    )
