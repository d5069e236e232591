"""A law along a family of orbits: the orbits and gains about them in a table, and the regulator of the equilibrium that they lead up to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.archive import NUMBER, TEXT, VALUES, Array, Schema, names, read_archive, real
from phichain.errors import ArrayError, OutputError
from phichain.laws.numbers import words_of
from phichain.laws.state_feedback import StateFeedback
from phichain.records import Held, held, write_npz

Vector = NDArray[np.float64]

_TABLES: Final = {
    "states": real("rungs", "nodes", "nx"), "rates": real("rungs", "nodes"), "gains": real("rungs", "nodes", "nx"),
    "energies": real("rungs"), "periods": real("rungs"), "slowness": real("rungs"), "rises": real("rungs"), "weights": real("nx"), "shape": real("n", "nx"),
}  # fmt: skip
_CATCH: Final = {"target": real("nx"), "rest": real("nu"), "catch_gains": real("nu", "nx"), "low": real("nu"), "high": real("nu")}
_WORDS: Final = {
    "name": TEXT, "digest": TEXT, "p": VALUES, "state_names": names("nx"), "state_units": names("nx"),
    "input_names": names("nu"), "input_units": names("nu"),
}  # fmt: skip
_NUMBERS: Final = {"pace": NUMBER, "tube": NUMBER, "sample": NUMBER}
_SCHEMA: Final = Schema(
    "FamilyLaw",
    {**_TABLES, **_CATCH, "wraps": Array(np.bool_, ("nx",))},
    {**_WORDS, **_NUMBERS},
    filled=("rungs", "nodes", "nx", "nu", "n"),
)

FOLLOW: Final = 0.2
"""Share of what the phase is found to be off that one call corrects."""

SLIP: Final = 0.05
"""Most that the phase is taken to be off in one call, in half periods."""

SOFT: Final = 1e-3
"""Squared speed, rad^2 a half period squared, below which an orbit is too small to tell its phase."""

REST: Final = 0.01
"""Squared size of a motion, weighed, below which the chain hangs still enough to begin: a tenth of a radian."""

LEAVE: Final = 100.0
"""Level at which the equilibrium is let go: ten times as far out as it was taken up, for on the way home of the whole equations it rises first."""


@dataclass(frozen=True, eq=False)
class FamilyLaw(Held):
    """One input that leads a hanging chain up through a family of brake orbits and holds it where the family ends.

    The table has rungs, orbits of rising energy, the chain at rest first, and nodes along half a period, from one brake to the other: state
    x_r, rate r of the phase and gains K. The other half is its mirror image. With the phase s, between nodes by the cubic of Catmull and Rom,
    and the rung h, between rungs by a straight line, x_r' the derivative by s and <.,.> the product that weighs squared rates by `slowness`,

        e = w(x - x_r),  slip = <x_r', e> / (<x_r', x_r'> + soft),  e_n = e - slip x_r',  u = clip(-K e_n, low, high),
        s' = r + follow * slip / sample,  h' = min(pace, rise(h) r) max(-1/2, 1 - |K e_n| / limit):

    the phase is where the chain is, what is left across the orbit is regulated, and the orbit rises as fast as the input has room.
    Where the level |W w(x - target)|^2 is at most 1 the regulator of the target takes over, until it passes 100. Where e_n is larger
    than `tube` the chain is calmed, u against the rate of its joint, until it hangs still and climbs anew.

    Attributes:
        catch: The regulator of the target, of which names, units, wraps, limits and sample hold all along.
        shape: W (n, nx).
        states: x_r (rungs, nodes, nx); both ends of the half period are nodes.
        rates: r (rungs, nodes), half periods a second.
        gains: K (rungs, nodes, nx).
        weights: How entries of the state are weighed (nx,) where it is told whether the chain hangs still: 1 for angles, s^2 for rates.
        slowness: Weights of squared rates across each orbit (rungs,), s^2: with them the orbit is about as wide as high, so that one that is
            too small for its rung does not look late or early.
        energies: Of the orbits (rungs,), J above the hanging chain.
        periods: Of the orbits (rungs,), s.
        rises: Rungs a half period, at most, from each rung on (rungs,): near an equilibrium orbits take their time, and where the input hardly
            moves the chain from one orbit to the next, rungs wait for it.
        pace: Rungs a second, at most, where the input has nothing else to do.
        tube: Largest |e_n|, rad.

    Raises:
        ArrayError: Shapes that do not fit, numbers that are not finite or not positive, more than one input, or energies that fall.
    """

    catch: StateFeedback
    shape: Vector
    states: Vector
    rates: Vector
    gains: Vector
    weights: Vector
    slowness: Vector
    rises: Vector
    energies: Vector
    periods: Vector
    pace: float
    tube: float

    def __post_init__(self) -> None:
        nx = len(self.catch.state_names)
        rungs, nodes = np.shape(self.states)[:2]
        shapes = {
            "shape": (len(self.shape), nx), "states": (rungs, nodes, nx), "rates": (rungs, nodes), "gains": (rungs, nodes, nx),
            "weights": (nx,), "slowness": (rungs,), "rises": (rungs,), "energies": (rungs,), "periods": (rungs,),
        }  # fmt: skip
        for name, shape in shapes.items():
            table = held(getattr(self, name))
            if table.shape != shape or rungs < 2 or nodes < 4 or not np.all(np.isfinite(table)):
                raise ArrayError(f"law.{name}", table, f"must hold finite numbers of shape {shape}", "give two rungs of four nodes or more")
            object.__setattr__(self, name, table)
        if len(self.catch.input_names) != 1 or not np.isfinite(self.limit) or self.catch.low[0] != -self.limit:
            raise ArrayError("law.catch", self.catch.input_names, "is not of one input with a limit", "give the regulator of one joint")
        for name in ("pace", "tube"):
            if not 0 < getattr(self, name) < np.inf:
                raise ArrayError(f"law.{name}", getattr(self, name), "is not positive", "give rungs a second, radians")
        for name, least in (("rates", self.rates), ("weights", self.weights), ("slowness", self.slowness), ("rises", self.rises), ("energies", np.diff(self.energies)), ("periods", self.periods)):
            if not np.min(least) > 0:
                raise ArrayError(f"law.{name}", getattr(self, name), "are not positive, or energies not rising", "order the orbits by energy")
        if not self.catch.sample > 0:
            raise ArrayError("law.catch.sample", self.catch.sample, "is no time between two calls", "give a sampled regulator")

    @property
    def name(self) -> str:
        """The scene it belongs to."""
        return self.catch.name

    @property
    def digest(self) -> str:
        """That scene's canonical digest."""
        return self.catch.digest

    @property
    def p(self) -> Mapping[str, Any]:
        """Runtime parameters of the chain that it was made for."""
        return self.catch.p

    @property
    def limit(self) -> float:
        """Largest size of the input."""
        return self.catch.high[0]

    def __str__(self) -> str:
        rungs, nodes, nx = self.states.shape
        return (
            f"{self.name}: law along a family of {rungs} orbits up to {self.energies[-1]:.6g} J, {nodes} nodes of {nx} states, "
            f"{self.catch.input_names[0]} within {self.limit:.4g} {self.catch.input_units[0]}"
        )

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        catch = {"catch_gains" if name == "gains" else name: np.array(getattr(self.catch, name)) for name in _catch_names()}
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _TABLES} | catch
        meta = {name: getattr(self.catch, name) for name in (*_WORDS, "sample")} | {name: getattr(self, name) for name in ("pace", "tube")}
        return write_npz(path, arrays, meta | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> FamilyLaw:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, holds no FamilyLaw, or one that does not fit together.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        tables: dict[str, Any] = {name: arrays.pop(name) for name in _TABLES}
        catch: dict[str, Any] = {"gains" if name == "catch_gains" else name: array for name, array in arrays.items()}
        try:
            return cls(StateFeedback(**catch, **words_of(meta, _WORDS), sample=meta["sample"]), **tables, **{name: meta[name] for name in ("pace", "tube")})
        except ArrayError as failure:
            remedy = f"name a file that a {_SCHEMA.kind} wrote"
            raise OutputError("path", str(path), f"no {_SCHEMA.kind} can be read there: {failure}", remedy) from failure


def _catch_names() -> list[str]:
    """The arrays of the regulator."""
    return [field.name for field in fields(StateFeedback) if field.name not in (*_WORDS, "sample")]
