"""Orbit: the frozen record of one periodic orbit, sampled over its period, with its stability."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.archive import (
    COUNT,
    NUMBER,
    TEXT,
    VALUES,
    Possible,
    Schema,
    complex_numbers,
    names,
    read_archive,
    real,
    word,
)
from phichain.continuation.document import values_of
from phichain.continuation.problem import Multipliers, are_stable
from phichain.errors import OutputError
from phichain.origin import plain
from phichain.reading import parse_json, read_regular
from phichain.records import Shown, columns_of, write_csv, write_json, write_npz
from phichain.system import Vector

_ARRAYS: Final = {
    "t": real("m"),
    "q": real("m", "nq"),
    "v": real("m", "nv"),
    "lengths": real("nq", optional=True),
    "kappa": complex_numbers("exponents"),
    "multipliers": complex_numbers("floquet"),
}
_PLAIN: Final = {
    "scene": TEXT,
    "digest": TEXT,
    "method": TEXT,
    "mode": COUNT,
    "space": word("planar", "spatial"),
    "omega": NUMBER,
    "energy": NUMBER,
    "error": NUMBER,
    "closure": NUMBER,
    "turn": replace(NUMBER, default=0.0),
    "q_names": names("nq"),
    "v_names": names("nv"),
    "angles": replace(word("", "relative", "absolute", "adjacent"), default=""),
    "tol": replace(NUMBER, default=0.0),
    "p": VALUES,
}
_MAYBE: Final = ("energy", "error")
_SCHEMA: Final = Schema("Orbit", _ARRAYS, {**_PLAIN, **{name: replace(NUMBER, default=math.nan) for name in _MAYBE}}, filled=("m",))
_POSSIBLE: Final = Possible(finite=("t", "q", "v", "turn", "closure"), positive=("omega",), not_negative=("lengths", "tol"), rising=("t",))
_LARGEST: Final = 2**26
"""Bytes that a file may have."""


@dataclass(frozen=True, eq=False, repr=False)
class Orbit(Shown):
    """One periodic orbit.

    Attributes:
        scene: Name of the scene that it belongs to.
        digest: The scene's digest.
        method: How it was found: the kind of shooting ("quarter" of brake orbits, "half", ...), or "conical".
        mode: Number of the linear mode, or of the conical beginning, of its family; 0 for none.
        space: "planar" or "spatial".
        omega: Angular frequency, rad/s; of a conical orbit the rate at which it turns.
        energy: Energy, J, counted from the hanging rest; NaN where it is not known.
        kappa: (mu + 1/mu) / 2 of all multipliers but the flow's own (k,), in the form that `method` has.
        multipliers: Floquet multipliers (2 k,), in pairs lambda and 1/lambda.
        error: How far off omega may be, relative; NaN where the method does not say.
        closure: Largest distance of the state after one period from the start, in amplitudes and largest rates.
        t: Times over one period (m,), s, its end included.
        q: Configurations (m, nq).
        v: Rates (m, nv).
        q_names: Names of the entries of q.
        v_names: Names of the entries of v.
        lengths: Length of the link that each entry of q belongs to (nq,), m, 0 for a cart's: by these it is drawn. None where unknown.
        angles: What planar angles are measured from; empty in space.
        turn: Angle about the vertical by which a whirling orbit comes back turned, rad; 0 of all others.
        tol: Newton's tolerance of its family; 0 where that was not kept.
    """

    scene: str
    digest: str
    method: str
    mode: int
    space: str
    omega: float
    energy: float
    kappa: Multipliers
    multipliers: Multipliers
    error: float
    closure: float
    t: Vector
    q: Vector
    v: Vector
    q_names: tuple[str, ...]
    v_names: tuple[str, ...]
    lengths: Vector | None = None
    angles: str = ""
    turn: float = 0.0
    tol: float = 0.0

    @property
    def period(self) -> float:
        """T = 2 pi / omega, s."""
        return 2 * math.pi / self.omega

    @property
    def is_stable(self) -> bool:
        """Whether all multipliers lie on the unit circle, to 1e-6."""
        return bool(are_stable(self.kappa[None, :])[0])

    def __str__(self) -> str:
        return "\n".join(f"{name:12} {value}" for name, value in self.rows().items())

    def rows(self) -> dict[str, str]:
        """What there is to say of it, line by line."""
        start = ", ".join(f"{name} = {value:.12g}" for name, value in zip(self.q_names, self.q[0], strict=True))
        rates = ", ".join(f"{name} = {value:.12g}" for name, value in zip(self.v_names, self.v[0], strict=True))
        lambdas = ", ".join(_complex(value) for value in self.multipliers)
        known = {"energy": f"{self.energy:.15g} J"} if math.isfinite(self.energy) else {}
        error = f"; omega within {self.error:.1e} of it" if math.isfinite(self.error) else ""
        return {
            "orbit of": f"{self.scene}, {self.method} {self.mode}",
            "start": start,
            **({"moving with": rates} if np.any(self.v[0]) else {}),
            "period": f"{self.period:.15g} s, omega = {self.omega:.15g} rad/s{error}",
            **({"turned by": f"{self.turn:.15g} rad about the vertical"} if self.turn else {}),
            **known,
            "multipliers": f"{lambdas or 'none but the flow’s own'}: {'stable' if self.is_stable else 'unstable'}",
            "closes to": f"{self.closure:.1e}",
        }

    def to_csv(self, path: Path | str) -> Path:
        """Write one row per sample: t, q, v; 17 digits."""
        return write_csv(path, {"t": self.t, **columns_of(self.q_names, self.q), **columns_of(self.v_names, self.v)}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        meta = {name: getattr(self, name) for name in _PLAIN if not (name in _MAYBE and math.isnan(getattr(self, name)))}
        return write_npz(path, {name: value for name in _ARRAYS if (value := getattr(self, name)) is not None}, meta | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> Orbit:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Orbit, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        fields: dict[str, Any] = {**arrays, **meta, "q_names": tuple(meta["q_names"]), "v_names": tuple(meta["v_names"])}
        return _POSSIBLE.demand(path, cls(**fields))

    def to_json(self, path: Path | str) -> Path:
        """Write what programs of other kinds read, 17 digits; complex numbers are pairs. `from_json` reads it back.

        {"kind": "orbit", "scene", "digest", "p", "method", "mode", "start": {"q", "v"}, "omega", "period", "energy", "kappa", "multipliers",
        "error", "closure", "samples": {"t", "q", "v"}, ...}
        """
        told = {name: plain(getattr(self, name)) for name in _PLAIN}
        samples = {name: getattr(self, name).tolist() for name in ("t", "q", "v")}
        found = {
            **told, "period": self.period, "start": {"q": samples["q"][0], "v": samples["v"][0]},
            **{name: [[float(x.real), float(x.imag)] for x in getattr(self, name)] for name in ("kappa", "multipliers")},
            "samples": samples, "lengths": None if self.lengths is None else self.lengths.tolist(),
        }  # fmt: skip
        return write_json(path, "orbit", found)

    @classmethod
    def from_json(cls, path: Path | str) -> Orbit:
        """Read what `to_json` wrote.

        Raises:
            OutputError: The file is missing, cut short, or holds no Orbit.
        """
        try:
            return _POSSIBLE.demand(path, cls._of(parse_json(read_regular(path, _LARGEST))))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError, MemoryError) as failure:
            why = f"it lacks {failure}" if isinstance(failure, KeyError) else str(failure) or type(failure).__name__
            raise OutputError(
                "path", str(path), f"no orbit can be read there: {why}", "name a JSON file that an Orbit wrote, whole"
            ) from failure

    @classmethod
    def _of(cls, found: Mapping[str, Any]) -> Orbit:
        if found["kind"] != "orbit":
            raise ValueError('it is no {"kind": "orbit", ...}')
        fields: dict[str, Any] = {name: np.array(found["samples"][name], dtype=float) for name in ("t", "q", "v")}
        sizes = [(len(fields["t"]), len(found[f"{name}_names"])) for name in ("q", "v")]
        if fields["t"].ndim != 1 or [fields["q"].shape, fields["v"].shape] != sizes or not len(fields["t"]):
            raise ValueError("its samples do not fit each other")
        fields |= {name: np.array([complex(*pair) for pair in found[name]], complex) for name in ("kappa", "multipliers")}
        fields |= {name: _fitting(name, found.get(name, 0.0) if name in ("turn", "tol") else found[name]) for name in _PLAIN if name not in (*_MAYBE, "angles", "p")}
        lengths = None if (given := found.get("lengths")) is None else _of_entries(given, sizes[0][1])
        fields |= {"lengths": lengths, "angles": _fitting("angles", found.get("angles", "")), "p": values_of(found)}
        fields |= {name: math.nan if found[name] is None else float(found[name]) for name in _MAYBE}
        return cls(**{**fields, **{f"{x}_names": tuple(found[f"{x}_names"]) for x in "qv"}})


def _fitting(name: str, value: Any) -> Any:
    """A small field, once it is what such a field must be."""
    if not _PLAIN[name].fits(value):
        raise ValueError(f"its {name} {'are' if name.endswith('s') else 'is'} not {_PLAIN[name].what}")
    return value


def _of_entries(given: Any, size: int) -> Vector:
    """One number for each entry of q."""
    lengths = np.array(given, dtype=float)
    if lengths.shape != (size,):
        raise ValueError("its lengths do not fit its samples")
    return lengths


def _complex(value: complex) -> str:
    return f"{value.real:.9g}" if abs(value.imag) < 1e-12 else f"{value.real:.9g}{value.imag:+.9g}i"
