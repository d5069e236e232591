"""Fit: what a measurement says of a chain's parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from phichain.origin import plain
from phichain.records import Shown, columns_of, write_csv, write_json
from phichain.system import Vector

_HARDLY = 0.5
_TOGETHER = 0.99


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Shown):
    """Parameters of a chain by least squares, with what the data say of each.

    Attributes:
        name: The scene's name.
        digest: Its canonical digest.
        names: Names of the fitted numbers (k,): mass_1, gravity, ...; those of the initial state follow as theta_1(0), ...
        count: How many of them are parameters.
        values: Fitted values (k,), each in its SI unit.
        standard_error: Standard errors (k,) by (J^T W J)^-1.
        confidence: Limits (k, 2) of each within which it lies with 95 %, by Student's t.
        correlation: Correlations (k, k) of the estimates.
        singular: Singular values (k,) of the weighted columns of length one; small ones are what the data hardly tell apart.
        p: All runtime parameters, fitted or kept, for `simulate(..., p=fit.p)`.
        x0: The state that the fitted motion starts from (nx,).
        columns: Names of the measured columns (c,).
        t: Times (m,), s.
        measured: Measured columns (m, c).
        fitted: The same as predicted (m, c).
        noise: Standard deviation of every column's residuals (c,).
        method: The emitted flow that followed the motion.
        iterations: Evaluations of the parameter columns.
        seconds: Time taken, s.
        at_bound: Parameters that ended at a bound, where standard errors mean nothing.
    """

    name: str
    digest: str
    names: tuple[str, ...]
    count: int
    values: Vector
    standard_error: Vector
    confidence: Vector
    correlation: Vector
    singular: Vector
    x0: Vector
    columns: tuple[str, ...]
    t: Vector
    measured: Vector
    fitted: Vector
    noise: Vector
    method: str
    iterations: int
    seconds: float
    at_bound: tuple[str, ...] = ()

    @property
    def residual(self) -> Vector:
        """Measured less fitted (m, c)."""
        return np.asarray(self.measured - self.fitted)

    @property
    def parameters(self) -> dict[str, float]:
        """The fitted numbers of parameters by name."""
        return {name: float(value) for name, value in zip(self.names[: self.count], self.values, strict=False)}

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the reader should know: parameters hardly told, pairs that move together, bounds that were met."""
        found = [f"{name} ended at its bound, where its standard error means nothing" for name in self.at_bound]
        for k, name in enumerate(self.names[: self.count]):
            if self.standard_error[k] > _HARDLY * abs(self.values[k]):
                found.append(f"{name} is hardly told: its standard error is {100 * self.standard_error[k] / abs(self.values[k]):.0f} % of it")
            for j in range(k):
                if abs(self.correlation[j, k]) > _TOGETHER:
                    found.append(f"{self.names[j]} and {name} move together: correlation {self.correlation[j, k]:+.4f}")
        return tuple(found)

    def __str__(self) -> str:
        rows = [("", "value", "standard error", "95 % from", "to")]
        rows += [
            (name, f"{value:.8g}", f"{error:.2g}", f"{low:.8g}", f"{high:.8g}")
            for name, value, error, (low, high) in zip(self.names, self.values, self.standard_error, self.confidence, strict=True)
        ]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]
        left = ", ".join(f"{name} {noise:.3g}" for name, noise in zip(self.columns, self.noise, strict=True))
        how = f"{self.iterations} iterations by {self.method}, {self.seconds:.2g} s"
        head = f"{self.name}: {self.count} parameter(s) from {len(self.t)} rows; residuals {left}; {how}"
        return "\n".join([head, *lines, *self.remarks])

    def to_csv(self, path: Path | str) -> Path:
        """Write times, measured and fitted columns, and what is left.

        Raises:
            OutputError: The file cannot be written.
        """
        parts = (("", self.measured), ("_fitted", self.fitted), ("_residual", self.residual))
        columns: dict[str, Any] = {"t": self.t}
        for ending, table in parts:
            columns |= columns_of([f"{name}{ending}" for name in self.columns], table)
        return write_csv(path, columns, self)

    def to_json(self, path: Path | str) -> Path:
        """Write everything but the tables over time.

        Raises:
            OutputError: The file cannot be written.
        """
        left_out = ("t", "measured", "fitted")
        found = {name: plain(value) for name, value in sorted(vars(self).items()) if name not in left_out}
        return write_json(path, "fit", {**found, "rows": len(self.t), "remarks": list(self.remarks)})
