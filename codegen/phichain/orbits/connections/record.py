"""A connection as it is kept: the motion from one upright equilibrium to another, and how well it is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from phichain.archive import (
    NUMBER,
    TEXT,
    VALUES,
    Possible,
    Schema,
    names,
    read_archive,
    real,
    signs,
    whole,
    word,
)
from phichain.records import Shown, columns_of, write_csv, write_npz
from phichain.system import Vector

_ARRAYS: Final = {"t": real("m"), "q": real("m", "nq"), "v": real("m", "nq"), "rates": real("links"), "start": real("links"), "turns": whole("links"), "lengths": real("nq", optional=True)}
_PLAIN: Final = {
    **dict.fromkeys(("name", "digest"), TEXT), "s": signs("links"), "q_names": names("nq"), "v_names": names("nq"),
    **dict.fromkeys(("residual", "error", "energy", "transversality"), NUMBER), "angles": replace(word("", "relative", "absolute", "adjacent"), default=""), "p": VALUES,
}  # fmt: skip
_SCHEMA: Final = Schema("Connection", _ARRAYS, _PLAIN, filled=("m", "links", "nq"))

_POSSIBLE: Final = Possible(finite=("q", "v", "start", "energy"), positive=("rates",), not_negative=("lengths", "residual", "error"), rising=("t",))


@dataclass(frozen=True, eq=False, repr=False)
class Connection(Shown):
    """A motion that leaves one equilibrium at t = -infinity and arrives at another one at t = infinity.

    Attributes:
        name: The system.
        digest: Its scene's digest.
        s: Directions of the links at both ends, +1 hanging and -1 upright.
        turns: Whole turns (N,) by which the links' absolute angles differ at the ends; the same place where all are equal to it.
        t: Times (m,), s; zero half way, where the angles are those half way between both ends.
        q: Configurations (m, nq); it begins and ends where the linear motion takes over.
        v: Rates (m, nq).
        rates: Growth rates at the ends (N,), 1/s, falling.
        start: Parts of the unstable directions in which it leaves (N,), the fastest first, their squares adding up to 1.
        residual: The largest mismatch of the boundary value problem, of the states' size.
        error: By how much the state half way differs when the linear motion takes over at twice the distance.
        energy: Of the motion less that of the equilibrium, J: zero but for errors.
        transversality: Angle between unstable and stable manifold across the motion, half way, rad; NaN for one link, where both
            are one curve. Above zero the connection is isolated and stays where parameters change a little.
        q_names: Names of q's entries.
        v_names: Names of v's entries.
        lengths: Length of the link that each entry of q belongs to (nq,), m, 0 for a cart's: by these it is drawn. None where unknown.
        angles: What planar angles are measured from; empty in space.
    """

    name: str
    digest: str
    s: tuple[int, ...]
    turns: tuple[int, ...]
    t: Vector
    q: Vector
    v: Vector
    rates: Vector
    start: Vector
    residual: float
    error: float
    energy: float
    transversality: float
    q_names: tuple[str, ...]
    v_names: tuple[str, ...]
    lengths: Vector | None = None
    angles: str = ""

    def __str__(self) -> str:
        turned = ", ".join(f"link {k} {n:+d}" for k, n in enumerate(self.turns, 1) if n)
        across = "" if self.transversality != self.transversality else f", manifolds {self.transversality:.3g} rad apart"
        return (
            f"{self.name}: {turned} turn(s) in {self.t[-1] - self.t[0]:.4g} s between 2e-5 rad from its ends, residual {self.residual:.1e}, "
            f"error {self.error:.1e}{across}"
        )

    def to_csv(self, path: Path | str) -> Path:
        """Write t, q and v, one row a time.

        Raises:
            OutputError: The file cannot be written.
        """
        return write_csv(path, {"t": self.t, **columns_of(self.q_names, self.q), **columns_of(self.v_names, self.v)}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write all of it; `from_npz` reads it back.

        Raises:
            OutputError: The file cannot be written.
        """
        meta: dict[str, Any] = {name: getattr(self, name) for name in _PLAIN}
        return write_npz(path, {name: value for name in _ARRAYS if (value := getattr(self, name)) is not None}, meta | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> Connection:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Connection, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        held: dict[str, Any] = {**arrays, "turns": tuple(int(n) for n in arrays["turns"])}
        held |= {name: tuple(value) if isinstance(value, list) else value for name, value in meta.items()}
        return _POSSIBLE.demand(path, cls(**held))
