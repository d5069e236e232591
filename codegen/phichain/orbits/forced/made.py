"""From a branch of driven motions to its Response: starts, peaks and first harmonics, and the events under their names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.continuation import Branch, Level, Special, TestFunction
from phichain.orbits.forced.checkpoint import Checkpoint
from phichain.orbits.forced.floquet import SAID, genuine
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.response import Response, ResponseEvent
from phichain.orbits.harmonics.basis import Basis
from phichain.records import Held
from phichain.system import System, Vector

_SAMPLES: Final = 4
"""Samples for each harmonic, among which the peak is looked for before Newton's iteration finds it."""
_NEWTON: Final = 4
JOINED: Final = ("omega", "q", "v", "peak", "first", "multipliers", "error", "residual")
"""What a response has at every point, besides the arclength."""
_OUTSIDE: Final = 1e-3
"""Share of the range beyond its start at which a run that came back ends."""


def ends_of(ends: tuple[float, float]) -> list[TestFunction]:
    """Where a response ends: at the second frequency, or back beyond the first."""
    start, end = ends
    beyond = start - _OUTSIDE * (end - start)
    return [
        Level(lambda z: float(z[-1]), end, "end of the range", held=lambda z: (len(z) - 1, end)),
        Level(lambda z: float(z[-1]), beyond, "back before the range", held=lambda z: (len(z) - 1, beyond)),
    ]


@dataclass(frozen=True, eq=False)
class Motion(Held):
    """One periodic motion as a series.

    Attributes:
        table: Functions of the phase.
        coefficients: X (M, n).
        omega: rad/s.
        state: (q, v) at phase zero where it is known better than by the series.
    """

    table: Basis
    coefficients: Vector
    omega: float
    state: Vector | None = None

    @property
    def start(self) -> Vector:
        """(q, v) at phase zero (2 n,)."""
        if self.state is not None:
            return self.state
        value, slope, _ = self.table.at(np.zeros(1))
        return np.concatenate([(value @ self.coefficients)[0], self.omega * (slope @ self.coefficients)[0]])


def response_of(
    system: System, forcing: Forcing, branch: Branch, method: str, motion: Callable[[Vector], Motion], periods: int = 1
) -> Response:
    """The Response of a branch.

    Args:
        system: The chain.
        forcing: What drives it.
        branch: Points with omega last among their unknowns.
        method: How it was followed.
        motion: Unknowns -> what they stand for.
        periods: Of the forcing that one motion takes.
    """
    n, omega = system.nq, branch.points[:, -1]
    motions = [motion(z) for z in branch.points]
    states, peaks = np.array([one.start for one in motions]), np.array([peak(one.table, one.coefficients) for one in motions])
    events = tuple(_event(event, motion(event.z)) for event in branch.events if genuine(event))
    beyond = "; amplitudes beyond pi are of links that turn over" if np.max(peaks[:, system.cart_size :]) > np.pi else ""
    name = f"{system.name}, {forcing.amplitude:g} {forcing.unit} cos(omega t): {forcing.place}, {method}"
    return Response(
        name, system.name, system.digest, str(forcing.forced), forcing.place, forcing.unit, forcing.amplitude, method,
        system.q_names or tuple(f"q_{k + 1}" for k in range(n)), omega, states[:, :n], states[:, n:], peaks,
        np.array([first(one.table, one.coefficients, periods) for one in motions]), branch.multipliers,
        np.full(len(branch), np.nan) if branch.error is None else branch.error, branch.residual, branch.arclength, events,
        branch.status, branch.reason + beyond, periods, branch.tol,
    )  # fmt: skip


def begun_of(found: Response, at: Checkpoint) -> Response:
    """The part of a response that comes before the run that it stands on."""
    arrays = {name: getattr(found, name)[: at.before + 1] for name in (*JOINED, "arclength")}
    return replace(found, **arrays, events=found.events[: at.events])


def _event(event: Special, motion: Motion) -> ResponseEvent:
    peaks, state, n = peak(motion.table, motion.coefficients), motion.start, motion.coefficients.shape[1]
    breaks, continues = SAID.get(event.kind, ("", ""))
    return ResponseEvent(event.kind, event.index, float(event.z[-1]), state[:n], state[n:], peaks, event.multipliers, breaks, continues)


def first(table: Basis, series: Vector, order: int = 1) -> np.ndarray:
    """The harmonic of the forcing (n,) as complex numbers: q = Re(first e^(i omega t)) + .."""
    cosine, sine = np.flatnonzero(table.order == order)
    return np.asarray(series[cosine] - 1j * series[sine], complex)


def peak(table: Basis, series: Vector) -> Vector:
    """Largest distance of every coordinate from its mean over the period (n,)."""
    swinging = np.where(table.order[:, None] == 0, 0.0, series)
    phase = 2 * np.pi * np.arange(_SAMPLES * (table.highest + 1)) / (_SAMPLES * (table.highest + 1))
    value = np.abs(table.at(phase)[0] @ swinging)
    found = []
    for k, at in enumerate(np.argmax(value, axis=0)):
        tau, best = float(phase[at]), float(value[at, k])
        for _ in range(_NEWTON):
            place, slope, bend = (float((part @ swinging[:, k])[0]) for part in table.at(np.array([tau])))
            best = max(best, abs(place))
            if bend * place >= 0:
                break
            tau -= slope / bend
        found.append(best)
    return np.array(found)
