"""The motion that parameters predict, and its columns: how it moves with every unknown."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any, Final

import numpy as np

from phichain.errors import ConvergenceError, UnsupportedError
from phichain.identification.measurement import Measurement
from phichain.identification.pieces import Piece, pieces
from phichain.identification.unknowns import Unknowns
from phichain.system import System, Vector

TOLERANCES: Final = {"propagate": 2e-15, "propagate_stiff": 1e-12}
"""The emitted flows that can follow a motion, in the order in which they are taken, and the tolerance of each."""
_BUDGET: Final = 200_000
"""Steps of one run; a trial that needs more has left what was measured."""
_LINES_WITHIN: Final = 1e-7
"""By how much of a column's spread the pieces of a line may miss it."""
_MOST_CUTS: Final = 64
_CARRIED: Final = 1e-14
_MOVED: Final = 1e-4
_MOVED_FINE: Final = 1e-3
_LOOSE: Final = 8.0
_PROBED: Final = 1e-5
_SHORTEST: Final = 1e-9
_LONGEST: Final = 1e-3


@dataclass(frozen=True)
class Model:
    """Predicted states of a chain at measured times.

    Attributes:
        system: The chain.
        data: What was measured.
        unknowns: What is sought.
        flow: The emitted flow that follows the motion: "propagate" or "propagate_stiff".
        pieces: The inputs, constant over each.
        at: Places of the measured columns within the state.
    """

    system: System
    data: Measurement
    unknowns: Unknowns
    flow: str
    pieces: tuple[Piece, ...]
    at: tuple[int, ...]

    @property
    def tol(self) -> float:
        """Relative tolerance of a run."""
        return TOLERANCES[self.flow]

    @property
    def noise(self) -> float:
        """Relative error that a column may have: round-off where the flow carries it, else from the runs and from what bends."""
        return _CARRIED if self.is_exact else max(1e-9, 1e4 * self.tol)

    def predicted(self, z: Vector, rows: int) -> Vector:
        """The measured columns of the motion at the first times.

        Args:
            z: The unknowns.
            rows: How many times.

        Returns:
            (rows, c); infinite from where the motion could not be followed on.
        """
        x, p, nq = self.unknowns.state(z), self.unknowns.parameters(z), self.system.nq
        run, found, at = self.system.function(self.flow), np.full((rows, len(x)), np.inf), 1
        found[0] = x
        last = float(self.data.t[rows - 1])
        for piece in takewhile(lambda piece: piece.t0 < last, self.pieces):
            end, times = min(piece.t1, last), piece.times[: rows - at]
            more = {"u": piece.u} if self.system.nu else {}
            passed = run(x[:nq], x[nq:], piece.t0, end, self.tol, times=times, max_steps=_BUDGET, p=p, **more)
            reached = at + len(passed.q_at)
            found[at:reached, :nq], found[at:reached, nq:] = passed.q_at, passed.v_at
            if passed.outcome != "done":
                break
            at, x = reached, np.concatenate((passed.q, passed.v))
        return found[:, list(self.at)]

    @property
    def is_exact(self) -> bool:
        """Whether the flow carries derivatives by all parameters that are sought."""
        return self.flow == "propagate" and {name for name, _ in self.unknowns.keys} <= {*self.system.varied}

    def carried(self, z: Vector, rows: int) -> Vector:
        """Derivatives of the predicted columns with respect to the unknowns, as the flow carries them along the motion.

        Returns:
            (rows, c, k); infinite from where the motion could not be followed on.
        """
        unknowns, nx = self.unknowns, self.system.nx
        x, p, columns = unknowns.state(z), unknowns.parameters(z), np.zeros((nx, len(z)))
        along = {name: np.zeros((size, len(z))) for name, size in self.system.varied.items() if name in unknowns.given}
        for j, (name, place) in enumerate(unknowns.keys):
            along[name][place, j] = unknowns.scale[j]
        if unknowns.fits_state:
            columns[:, unknowns.count :] = np.diag(np.asarray(unknowns.scale)[unknowns.count :])
        found, states = np.full((rows, nx, len(z)), np.inf), np.empty((rows, nx))
        found[0] = columns
        self.run(x, p, columns, along, 0, rows - 1, states[1:], found[1:])
        return found[:, list(self.at)]

    def run(
        self, x: Vector, p: dict[str, Any], columns: Vector, along: dict[str, Vector], first: int, last: int, states: Vector, slopes: Vector
    ) -> tuple[Vector, Vector]:  # fmt: skip
        """The motion from a state at one row to another row, with columns of derivatives that the flow carries.

        Args:
            x: The state at the first row (nx,).
            p: The runtime parameters.
            columns: The derivatives there (nx, k).
            along: How parameters move along each column.
            first: The row where it begins.
            last: The row where it ends.
            states: Takes the states at the rows behind the first (last - first, nx), as far as the motion could be followed.
            slopes: Takes the columns there.

        Returns:
            State and columns at the last row; infinite where the motion could not be followed so far.
        """
        nq, start, stop, at = self.system.nq, float(self.data.t[first]), float(self.data.t[last]), 0
        for piece in self.pieces:
            if piece.t1 <= start or piece.t0 >= stop:
                continue
            begin, end = max(piece.t0, start), min(piece.t1, stop)
            times = piece.times[(piece.times > start) & (piece.times <= stop)]
            more = {"u": piece.u} if self.system.nu else {}
            passed = self.system.propagate(
                x[:nq], x[nq:], begin, end, self.tol, times=times, max_steps=_BUDGET, transition=columns, along=along, p=p, **more
            )
            reached = at + len(passed.q_at)
            states[at:reached, :nq], states[at:reached, nq:] = passed.q_at, passed.v_at
            if passed.columns_at is not None:
                slopes[at:reached] = passed.columns_at
            if passed.outcome != "done":
                return np.full_like(x, np.inf), np.full_like(columns, np.inf)
            at, x, columns = reached, np.concatenate((passed.q, passed.v)), np.asarray(passed.transition)
        return x, columns

    def columns(self, z: Vector, rows: int, fine: bool = False) -> Vector:
        """Derivatives of the predicted columns with respect to the unknowns: carried by the flow, or central differences of it.

        Where the flow does not carry them, d y / d z_j = (y(z + h e_j) - y(z - h e_j)) / 2 h. h is such that the motion moves by
        10^-4 rad (or of a column's spread, where that is less): what bends then errs by 10^-8 of the column, the runs by tol / 10^-4 times
        the growth of what they round. Fine columns are extrapolated from h and 2 h of 10^-3 rad, for 10^-11. A chaotic motion grows small changes
        of its start a thousandfold and more, so no one h serves all unknowns.

        Returns:
            (rows, c, k).
        """
        if self.is_exact:
            return self.carried(z, rows)
        scale = np.minimum(np.std(self.data.values, axis=0), 1.0)
        scale = np.where(scale > 0, scale, 1.0)
        moves, slopes = (_MOVED_FINE if fine else _MOVED), []
        for j in range(len(z)):
            h = _PROBED
            for _ in range(2):
                slope = self._slope(z, j, h, rows)
                moved = h * float(np.max(np.abs(slope) / scale))
                if not np.isfinite(moved) or moves / _LOOSE < moved < moves * _LOOSE:
                    break
                h = float(np.clip(h * moves / max(moved, 1e-300), _SHORTEST, _LONGEST))
            else:
                slope = self._slope(z, j, h, rows)
            slopes.append((4 * slope - self._slope(z, j, 2 * h, rows)) / 3 if fine else slope)
        return np.stack(slopes, axis=-1)

    def _slope(self, z: Vector, j: int, h: float, rows: int) -> Vector:
        """A difference of second order: central, or ahead alone beside a bound."""
        along = h * np.eye(len(z))[j]
        ahead = self.predicted(z + along, rows)
        if z[j] - h > self.unknowns.low[j]:
            return np.asarray((ahead - self.predicted(z - along, rows)) / (2 * h))
        return np.asarray((4 * ahead - self.predicted(z + 2 * along, rows) - 3 * self.predicted(z, rows)) / (2 * h))


def model(system: System, data: Measurement, unknowns: Unknowns, between: str) -> Model:
    """The model of a measurement: the Taylor flow, or the implicit one where dry friction makes the chain stiff or it has no other.

    Lines between rows of inputs are cut into more pieces until the motion from the starting values stays the same; the pieces are then kept, so
    that two runs differ by their parameters alone.

    Raises:
        UnsupportedError: The system has neither flow.
        ConvergenceError: The motion cannot be followed from the starting values.
    """
    names = (*system.q_names, *system.v_names)
    flows = [name for name in TOLERANCES if system.has(name)]
    rubs = system.joints.friction is not None or system.numbers.cart_friction is not None
    flow = next(reversed(flows) if rubs else iter(flows), None)
    if flow is None:
        raise UnsupportedError("system", system.name, "has no flow that could follow the motion", f"want one of {', '.join(TOLERANCES)}")
    u = np.zeros((len(data.t), system.nu))
    for name, column in zip(data.inputs, np.empty((0, 0)) if data.u is None else data.u.T, strict=False):
        u[:, system.u_names.index(name)] = column
    t, at = np.asarray(data.t), tuple(names.index(name) for name in data.columns)
    made = Model(system, data, unknowns, flow, pieces(t, u, between, 1), at)
    here = _followed(made)
    if between == "held" or not np.diff(u, axis=0).any():
        return made
    cuts, sizes = 1, np.maximum(np.std(data.values, axis=0), np.finfo(float).tiny)
    while cuts < _MOST_CUTS:
        cuts *= 2
        made = replace(made, pieces=pieces(t, u, between, cuts))
        before, here = here, _followed(made)
        # Twice the pieces leave a sixteenth of the error.
        if (np.max(np.abs(here - before), axis=0) < 15 * _LINES_WITHIN * sizes).all():
            break
    return made


def _followed(model: Model) -> Vector:
    found = model.predicted(np.asarray(model.unknowns.z), len(model.data.t))
    if not np.isfinite(found).all():
        reached = float(model.data.t[int(np.argmin(np.isfinite(found).all(axis=1))) - 1])
        raise ConvergenceError("start", reached, "leads to a motion that can be followed up to this time only, s", "start from likelier values")
    return found
