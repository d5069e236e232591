"""Regions of attraction as a frozen record and its files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.archive import COUNT, NUMBER, TEXT, VALUES, Schema, read_archive, real, whole
from phichain.records import Shown, write_csv, write_npz
from phichain.system import Vector

_ARRAYS: Final = {
    "s": whole("count", "links"), "radius": real("count"), "beyond": real("count"), "usual": real("count"), "worst": real("count", "k"), "failed": whole("count"),
    "late": whole("count"), "share": real("count"), "runs": whole("count"),
}  # fmt: skip
_PLAIN: Final = {
    "name": TEXT, "digest": TEXT, "directions": COUNT, "tested": COUNT, "seconds": NUMBER, "period": NUMBER, "seed": COUNT, "p": VALUES,
}  # fmt: skip
_SCHEMA: Final = Schema("Attraction", _ARRAYS, _PLAIN, filled=("count", "links", "k"))


@dataclass(frozen=True, eq=False, repr=False)
class Attraction(Shown):
    """How far regulators of a chain hold it, by simulation of the emitted closed loop.

    Attributes:
        name: The scene.
        digest: Its canonical digest.
        s: Equilibria (count, links).
        radius: Radius (count,), 2-norm over the links' turns xi_i (rad in the plane; s_i e_3 x q_i in space, sines of tilts), from which
            every direction came home.
        beyond: The least radius (count,) from which one did not; infinite where all came home from wherever rays lead.
        usual: Radius (count,) from which all but two in a hundred directions came home.
        worst: The direction that did not from `beyond` (count, k).
        late: Whether it was still under way (1), and did not fly off (0), when its time was over (count,).
        directions: Directions that were tried.
        tested: Starts drawn evenly from the ball of that radius.
        failed: How many of these did not come home (count,).
        share: With 95 % confidence no more than this share of the ball does not (count,).
        runs: Simulations (count,).
        seconds: Time within which a start had to come home.
        period: From one call of the law to the next, s.
        seed: Of directions and starts.
    """

    name: str
    digest: str
    s: Vector
    radius: Vector
    beyond: Vector
    usual: Vector
    worst: Vector
    late: Vector
    directions: int
    tested: int
    failed: Vector
    share: Vector
    runs: Vector
    seconds: float
    period: float
    seed: int

    def __str__(self) -> str:
        rows = [
            f"s = {signs.tolist()}: comes home from {radius:.4g} in {self.directions} directions, {_words(beyond, late)}, from {usual:.4g} in 98 %; "
            f"{failed} of {self.tested} starts in that ball fail, at most {100 * share:.2g} % (95 %)"
            for signs, radius, beyond, usual, late, failed, share in zip(
                self.s, self.radius, self.beyond, self.usual, self.late, self.failed, self.share, strict=True
            )
        ]
        return "\n".join([f"{self.name}: regions of attraction within {self.seconds:g} s, {int(np.sum(self.runs))} simulations", *rows])

    def to_csv(self, path: Path | str) -> Path:
        """Write one row per equilibrium; 17 digits."""
        words = np.array(["".join("-" if sign > 0 else "+" for sign in signs) for signs in self.s])
        return write_csv(path, {"s": words, **{name: getattr(self, name) for name in ("radius", "beyond", "usual", "late", "failed", "share", "runs")}}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        return write_npz(path, arrays, {name: getattr(self, name) for name in _PLAIN} | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> Attraction:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, or holds no Attraction, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        known: dict[str, Any] = {**arrays, **{name: meta[name] for name in _PLAIN}}
        return cls(**known)


def _words(beyond: float, late: int) -> str:
    """What happens beyond the radius."""
    if not np.isfinite(beyond):
        return "wherever they lead"
    return f"{'is still under way' if late else 'flies off'} from {beyond:.4g} in one"
