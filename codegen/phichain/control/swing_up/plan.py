"""A planned motion: states and inputs at the samples of the law, such as the chain itself runs through."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from phichain.archive import (
    COUNT,
    NUMBER,
    TEXT,
    TRUTH,
    VALUES,
    Schema,
    names,
    read_archive,
    real,
    signs,
    word,
)
from phichain.records import Shown, columns_of, write_csv, write_npz
from phichain.system import Vector
from phichain.system.vertical import Signs

_NUMBERS = ("sample", "rail", "cost", "infeasibility", "defect")
_SCHEMA = Schema(
    "Plan",
    {"t": real("points"), "x": real("points", "nx"), "u": real("samples", "nu"), "limit": real("nu"), "lengths": real("nq", optional=True)},
    {
        "name": TEXT, "digest": TEXT, "solver": TEXT, "state_names": names("nx"), "input_names": names("nu"),
        "start": signs("links"), "target": signs("links"), "converged": TRUTH, "iterations": COUNT,
        **dict.fromkeys(_NUMBERS, NUMBER), "angles": replace(word("", "relative", "absolute", "adjacent"), default=""), "p": VALUES,
    },
    filled=("points", "samples", "nx", "nu", "links"),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Shown):
    """A motion from one equilibrium to another.

    Attributes:
        name: Name of the chain.
        digest: Canonical digest of its scene.
        t: Times (M + 1,), s.
        x: States (M + 1, nx); the chain runs through them when `u` is held from sample to sample.
        u: Inputs (M, nu).
        state_names: Names of x.
        input_names: Names of u.
        start: Directions of the links at the start, +1 hanging, -1 upright.
        target: Directions at the end.
        limit: Largest size of every input (nu,).
        rail: Largest distance of the cart from 0, m; 0 for none.
        sample: Time between two samples, s.
        solver: Which solver planned it.
        converged: Whether that solver said so.
        iterations: How many it took.
        cost: Its objective.
        infeasibility: Largest violation of its equations.
        defect: How far the chain, led along the optimum, leaves it: largest entry of the state.
        lengths: Length of the link that each entry of q belongs to (nq,), m, 0 for a cart's: by these it is drawn. None where unknown.
        angles: What planar angles are measured from; empty in space.
    """

    name: str
    digest: str
    t: Vector
    x: Vector
    u: Vector
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    start: Signs
    target: Signs
    limit: Vector
    rail: float
    sample: float
    solver: str
    converged: bool
    iterations: int
    cost: float
    infeasibility: float
    defect: float
    lengths: Vector | None = None
    angles: str = ""

    @property
    def duration(self) -> float:
        """Time from start to target, s."""
        return float(self.t[-1])

    def __str__(self) -> str:
        far = f", the cart within {np.max(np.abs(self.x[:, 0])):.3g} m" if self.rail else ""
        state = "" if self.converged else ", NOT CONVERGED"
        return (
            f"{self.name}: planned in {self.duration:.3g} s, largest input {np.max(np.abs(self.u)):.3g}{far}; cost {self.cost:.4g}, "
            f"infeasibility {self.infeasibility:.1e}, {self.iterations} iterations of {self.solver}, defect {self.defect:.1e}{state}"
        )

    def to_csv(self, path: Path | str) -> Path:
        """Write t, states and inputs, 17 digits; the last row repeats the inputs of the one before."""
        u = np.vstack([self.u, self.u[-1:]])
        return write_csv(path, {"t": self.t, **columns_of(self.state_names, self.x), **columns_of(self.input_names, u)}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        meta: dict[str, Any] = {name: getattr(self, name) for name in _SCHEMA.fields}
        meta = {name: list(value) if isinstance(value, tuple) else value for name, value in meta.items()} | {"kind": _SCHEMA.kind}
        return write_npz(path, {name: value for name in _SCHEMA.arrays if (value := getattr(self, name)) is not None}, meta)

    @classmethod
    def from_npz(cls, path: Path | str) -> Plan:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, or holds no Plan, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        whole: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in meta.items()}
        whole |= arrays
        return cls(**whole)
