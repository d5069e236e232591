"""From a branch of driven motions to its Response: starts, peaks and first harmonics, and the events under their names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from phichain.continuation import Branch, Level, Special, TestFunction
from phichain.orbits.forced.floquet import SAID, genuine
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.forced.response import Response, ResponseEvent
from phichain.orbits.harmonics.basis import Basis
from phichain.system import System, Vector

_SAMPLES: Final = 4
"""Samples for each harmonic, among which the peak is looked for before Newton's iteration finds it."""
_NEWTON: Final = 4
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


def response_of(
    system: System, forcing: Forcing, branch: Branch, method: str, series: Sequence[Vector], table: Basis,
    starts: Sequence[Vector] | None = None, own: Sequence[tuple[Vector, Vector]] | None = None,
) -> Response:  # fmt: skip
    """The Response of a branch.

    Args:
        system: The chain.
        forcing: What drives it.
        branch: Points with omega last among their unknowns.
        method: How it was followed.
        series: Coefficients (M, n) of every point.
        table: Their basis.
        starts: States (q, v) of the points where the unknowns hold them.
        own: State and coefficients of every event, likewise.
    """
    n, omega = system.nq, branch.points[:, -1]
    states = starts if starts is not None else [_start(table, own_series, w) for own_series, w in zip(series, omega, strict=True)]
    peaks = np.array([peak(table, own_series) for own_series in series])
    events = []
    for k, event in enumerate(branch.events):
        if not genuine(event):
            continue
        if own is None:
            coefficients = event.z[:-1].reshape(-1, n)
            state = _start(table, coefficients, event.z[-1])
        else:
            state, coefficients = own[k]
        events.append(_event(event, state, peak(table, coefficients)))
    largest = float(np.max(peaks[:, system.cart_size :]))
    beyond = "; amplitudes beyond pi are of links that turn over" if largest > np.pi else ""
    name = f"{system.name}, {forcing.amplitude:g} {forcing.unit} cos(omega t): {forcing.place}, {method}"
    return Response(
        name, system.name, system.digest, str(forcing.forced), forcing.place, forcing.unit, forcing.amplitude, method,
        system.q_names or tuple(f"q_{k + 1}" for k in range(n)), omega, np.array([x[:n] for x in states]), np.array([x[n:] for x in states]),
        peaks, np.array([first(table, own_series) for own_series in series]), branch.multipliers,
        np.full(len(branch), np.nan) if branch.error is None else branch.error, branch.residual, branch.arclength, tuple(events),
        branch.status, branch.reason + beyond,
    )  # fmt: skip


def _event(event: Special, state: Vector, peaks: Vector) -> ResponseEvent:
    n = len(peaks)
    breaks, continues = SAID.get(event.kind, ("", ""))
    return ResponseEvent(event.kind, event.index, float(event.z[-1]), state[:n], state[n:], peaks, event.multipliers, breaks, continues)


def _start(table: Basis, series: Vector, omega: float) -> Vector:
    """(q, v) at phase zero."""
    value, slope, _ = table.at(np.zeros(1))
    return np.concatenate([(value @ series)[0], omega * (slope @ series)[0]])


def first(table: Basis, series: Vector) -> np.ndarray:
    """The first harmonic (n,) as complex numbers: q = Re(first e^(i tau)) + .."""
    cosine, sine = np.flatnonzero(table.order == 1)
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
