"""Where a run in a parameter starts: at an orbit of any kind, or at an event of its family, as it was given."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch, Special
from phichain.errors import ArrayError, OutputError
from phichain.orbits.closed.arrivals import shorter_orbit
from phichain.orbits.closed.kinds import KINDS
from phichain.orbits.closed.start import closed, given
from phichain.orbits.conical.starts import METHOD as CONICAL
from phichain.orbits.forced.forcing import Forcing, forcing_of
from phichain.orbits.forced.response import Response, ResponseEvent
from phichain.orbits.in_plane import METHOD as IN_PLANE
from phichain.orbits.in_space import METHOD as IN_SPACE
from phichain.orbits.parameter.followed import (
    AMPLITUDE,
    FORCED,
    Followed,
    Values,
    closed_orbits,
    driven_orbits,
    spatial_orbits,
)
from phichain.orbits.parameter.held import times_of
from phichain.orbits.symmetry import BRANCH_POINT
from phichain.orbits.targets import placed, point_index
from phichain.orbits.unmirrored import METHOD as UNMIRRORED
from phichain.orbits.whirling.problem import held_value
from phichain.orbits.whirling.starts import METHOD as WHIRLING
from phichain.system import System, Vector

_REMEDY: Final = (
    'give a Branch or a Response, (Branch, k), one of its events, "FILE.json:POINT" or "FILE.json:event=K" of one, (q_0, omega) of a brake orbit, '
    'or {"q": ..., "v": ..., "period": ...}'
)
_SPATIAL: Final = (CONICAL, IN_PLANE, IN_SPACE, UNMIRRORED, WHIRLING)
Begun = tuple[Followed, Vector, str, Values]
"""What is followed, the orbit in its unknowns, the event that is held (empty where none is said), and all parameters."""


def started(system: System, start: Any, hold: str | None, values: Values) -> Begun:
    """What a start means.

    Args:
        system: The chain.
        start: As in `vary`.
        hold: What is to be held; where it is None and the start is an event, that event is.
        values: Runtime parameters.

    Raises:
        ArrayError: It is no orbit of the chain.
        OutputError: A file holds none.
        ConvergenceError: A state and a period close no orbit.
    """
    if isinstance(start, Path) or (isinstance(start, str) and "=" not in start.rpartition(":")[0] and not start.startswith(("q=", "v="))):
        start = _read(str(start))
    record, place = start if isinstance(start, tuple) and len(start) == 2 and isinstance(start[0], Branch | Response) else (start, -1)
    if isinstance(record, Response):
        return _driven(system, record, place, hold, values)
    event = place if isinstance(place, Special) else record if isinstance(record, Special) else None
    held = hold or ("" if event is None else event.kind)
    if isinstance(record, Branch):
        if record.digest and record.digest != system.digest:
            raise ArrayError("start", record.scene, f"is the scene of that branch, and '{system.name}' is another one", "use its scene")
        kind = _kind(record)
        z = _point(record, place) if event is None else np.array(event.z, float)
        if kind in _SPATIAL:
            return spatial_orbits(system, kind, z, values, _closed_besides(system, kind, record, values)), z, held, values
    elif event is not None:
        kind, z = "quarter", np.array(event.z, float)
    elif isinstance(start, Mapping | str) or hasattr(start, "period"):
        kind, problem, point = closed(system, values, *given(system, start))
        z = point.z(problem)
    else:
        kind, z = "quarter", _pair(start)
    return _closed(system, kind, z, held, values)


def _closed(system: System, kind: str, z: Vector, held: str, values: Values) -> Begun:
    """A planar orbit; the shorter one where it is at a cover, and the one with more symmetries where its family meets its mirror image."""
    if kind in ("quarter", "unequal", "odd"):
        if z.shape != (system.nq + 1,) or not np.all(np.isfinite(z)) or z[-1] <= 0:
            raise ArrayError("start", z, f"is no brake orbit (q_0, omega) of {system.nq} coordinates at rest", _REMEDY)
    elif z.shape != (2 * system.nq + 2,):
        raise ArrayError("start", z, f"is no orbit of {system.nq} coordinates", _REMEDY)
    if times := times_of(held):
        if kind == "quarter":
            return closed_orbits(system, kind, shorter := np.append(z[:-1], times * z[-1]), values), shorter, held, values
        kind, z = shorter_orbit(system, values, kind, z)
    elif held == BRANCH_POINT:
        kind, z, held = _met(system, kind, z, values)
    return closed_orbits(system, kind, z, values), z, held, values


def _met(system: System, kind: str, z: Vector, values: Values) -> tuple[str, Vector, str]:
    """The orbit at a crossing of families, under the kind whose event it is: that has a locus, the crossing itself has none.

    Raises:
        ArrayError: Two families of one kind cross there.
    """
    own, shorter = shorter_orbit(system, values, kind, z)
    times = round(float(shorter[-1] / z[-1]))
    broken = next((name for name, opened in KINDS[own].opens.items() if opened == (kind, times) and (own, 1) != opened), None)
    if broken is not None:
        return own, shorter, broken
    if times > 1:
        return own, shorter, f"cover {times} of an orbit"
    raise ArrayError(
        "hold", BRANCH_POINT, "is where two families of one kind cross, which any other parameter opens into a gap: it has no locus",
        "hold another event, or a quantity of the orbit",
    )  # fmt: skip


def _driven(system: System, response: Response, place: Any, hold: str | None, values: Values) -> Begun:
    if response.digest != system.digest:
        raise ArrayError("start", response.scene, f"is the scene of that response, and '{system.name}' is another one", "use its scene")
    if isinstance(place, ResponseEvent):
        q, v, omega, event = place.q, place.v, place.omega, place.kind
    else:
        at = _index(place, len(response))
        q, v, omega, event = response.q[at], response.v[at], response.omega[at], ""
    own: Forcing = forcing_of(system, response.forced, response.amplitude)
    whole = values | {AMPLITUDE: values.get(AMPLITUDE, response.amplitude)}
    z = np.concatenate([q, v, [float(omega)]])
    return driven_orbits(system, own, response.periods, z, whole), z, hold or event, whole


def _kind(branch: Branch) -> str:
    """Which orbits a family is of.

    Raises:
        ArrayError: Its points are orbits of many chains.
    """
    if branch.names[-1:] != ("omega",):
        raise ArrayError("start", branch.names, "are the unknowns of no family of one chain", _REMEDY)
    kind = branch.method if branch.method in _SPATIAL else branch.closing or "quarter"
    if kind not in (*KINDS, *_SPATIAL):
        raise ArrayError("start", kind, "are orbits that are not followed in a parameter", _REMEDY)
    return kind


def _closed_besides(system: System, kind: str, branch: Branch, values: Values) -> str:
    """How a family of spatial orbits is closed besides, in the words of `spatial_orbits`."""
    if kind == WHIRLING:
        own = branch.closing.removesuffix(" held")
        return f"{own} held at {held_value(system, values, own, branch.points[0])!r}"
    if kind == UNMIRRORED:
        return branch.closing
    return branch.closing.partition(", ")[2] if kind == IN_SPACE else ""


def _point(branch: Branch, place: Any) -> Vector:
    return np.array(branch.points[_index(place, len(branch))], float)


def _index(place: Any, count: int) -> int:
    if isinstance(place, bool) or not isinstance(place, int | np.integer) or not -count <= place < count:
        raise ArrayError("start", place, f"is no point of that branch, which has {count}", "count points from 0; in FILE.json:POINT from 1")
    return int(place)


def _pair(start: Any) -> Vector:
    """(q_0, omega)."""
    if not (isinstance(start, tuple | list) and len(start) == 2):
        raise ArrayError("start", start, "is no orbit", _REMEDY)
    return np.append(np.asarray(start[0], float).ravel(), float(start[1]))


def _read(text: str) -> Any:
    """A record, or it with the point or event that its name says."""
    path, place = placed(text)
    record: Branch | Response
    try:
        record = Branch.from_json(path)
    except OutputError as failure:
        try:
            record = Response.from_json(path)
        except OutputError:
            raise failure from None
    if not place.startswith("event="):
        return record, point_index(place or "-1")
    events = record.own_events if isinstance(record, Branch) else record.events
    number = place.removeprefix("event=")
    if not number.isdecimal() or not 1 <= int(number) <= len(events):
        raise ArrayError("start", place, f"is none of its {len(events)} events", "count them from 1")
    return record, events[int(number) - 1]


def resumed(system: System, branch: Branch, values: Values) -> Begun:
    """What a run that is gone on with follows, by what its record says.

    Raises:
        ArrayError: It belongs to another scene, or is no run in a parameter.
    """
    kind, bar, what = branch.closing.partition("; ")
    if not bar or branch.digest != system.digest:
        problem = "is no run in a parameter" if not bar else f"is a run of another scene than '{system.name}'"
        raise ArrayError("resume", branch.name, problem, "resume it with the scene that it was of")
    z, held = branch.points[0, :-1], what.partition(" = ")[0]
    method, _, more = kind.partition(", ")
    if method in _SPATIAL:
        return spatial_orbits(system, method, z, values, more), z, held, values
    if method == FORCED:
        periods, amplitude = more.split(", ")
        whole = values | {AMPLITUDE: float(amplitude)}
        return driven_orbits(system, forcing_of(system, None, float(amplitude)), int(periods), z, whole), z, held, whole
    return closed_orbits(system, kind, z, values), z, held, values
