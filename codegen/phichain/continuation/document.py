"""Branches as JSON that people and other programs read, 17 digits, and that a run can be resumed from.

    {"kind": "branch", "scene", "digest", "p", "mode", "method", "points": [{"start": {"q", "v"}, "omega", "energy", "kappa", "error",
     "arclength", ...}], "events": [{"kind", "breaks", "start", "omega", "kappa", "continues", ...}],
     "passages": [{"at", "width", "crossed", ...}], "status", "reason", "tol", ...}

Unknowns are those of a start, the last of them omega; "closing" says which: a start at rest has no rates among its unknowns, an "odd" one no
angles, and "half" and "whole" have both and an "unfolding", zero but for rounding. Where they are none of these, as in conical families, the
start is the state that they stand for, and "unknowns" holds them; so it is of runs in a parameter of the chain, where every point says
"parameter": {NAME: VALUE}, too. Complex numbers are pairs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from phichain.archive import VALUES, Part, Possible
from phichain.continuation.met.specials import STATUS, Passage, Special
from phichain.errors import OutputError
from phichain.reading import parse_json, read_regular, text_of
from phichain.records import write_json

Read = TypeVar("Read")
_MOVING: Final = ("half", "whole")
"""Kinds of orbits that are taken up where the chain moves."""
_LARGEST: Final = 2**28
"""Bytes that a file may have."""


def _places(branch: Any) -> Iterator[tuple[str, Part]]:
    """The unknowns of events and gaps, and every frequency."""
    known = branch.names.index("omega") if "omega" in branch.names else None
    yield "finite", Part("points", branch.points)
    if known is not None:
        yield "positive", Part("points", branch.points[:, known], ".omega")
    for name, met in (("events", branch.events), ("passages", branch.passages)):
        for k, place in enumerate(met):
            yield "finite", Part(f"{name}[{k}].z", place.z)
            if known is not None:
                yield "positive", Part(f"{name}[{k}].omega", place.z[known])
    for k, gap in enumerate(branch.passages):
        yield "not negative", Part(f"passages[{k}].width", gap.width)


POSSIBLE: Final = Possible(
    finite=("arclength", "tangent", "states"), positive=("scale",), not_negative=("step", "tol", "residual", "iterations"), more=_places
)
"""What the numbers of a Branch must be."""


def write_document(branch: Any, path: Path | str) -> Path:
    """Write a Branch.

    Raises:
        OutputError: The file cannot be written.
    """
    return write_json(path, "branch", branch_document(branch))


def branch_document(branch: Any) -> dict[str, Any]:
    """A Branch as JSON has it."""
    points = [
        {
            **_start(z, branch, None if branch.states is None else branch.states[k]), **_turned(z, branch),
            **({} if branch.momentum is None else {"momentum": float(branch.momentum[k])}),
            "energy": _number(branch.energy, k), "kappa": pairs(branch.multipliers[k]), "error": _number(branch.error, k),
            "arclength": float(branch.arclength[k]), "residual": float(branch.residual[k]), "iterations": int(branch.iterations[k]),
            "tangent": branch.tangent[k].tolist(),
        }
        for k, z in enumerate(branch.points)
    ]  # fmt: skip
    own = branch.own_events
    events = [_event(event, branch) for event in own]
    ended = [_event(event, branch) for event in branch.events[len(own) :]]
    passages = [
        {
            "at": float(gap.z[_first_angle(branch.names)]), "width": gap.width, "crossed": gap.is_crossed,
            **(_start(gap.z, branch) if branch.states is None else _unknowns_of(gap.z, branch)), **_turned(gap.z, branch),
            "arclength": gap.arclength,
        }
        for gap in branch.passages
    ]  # fmt: skip
    return {
        "kind": "branch", "scene": branch.scene, "digest": branch.digest, "p": branch.p, "mode": branch.mode, "method": branch.method,
        **({"closing": branch.closing} if branch.closing else {}),
        "name": branch.name, "names": list(branch.names), "scale": branch.scale.tolist(), "points": points, "events": events,
        "passages": passages, "status": branch.status, "reason": branch.reason,
        "tol": branch.tol, "checkpoint": {"regular": branch.regular, "step": branch.step, "ended": ended},
    }  # fmt: skip


def _event(event: Special, branch: Any) -> dict[str, Any]:
    kind = event.kind.replace("fold in amplitude_theta_", "fold amplitude ").replace("fold in ", "fold ")
    return {
        "kind": kind, "breaks": event.breaks, **_start(event.z, branch, event.state), **_turned(event.z, branch), "kappa": pairs(event.multipliers), "continues": event.continues,
        "arclength": event.arclength, "after": event.index, "value": event.value,
    }  # fmt: skip


def _start(z: np.ndarray, branch: Any, state: np.ndarray | None = None) -> dict[str, Any]:
    """A start and its omega."""
    closing = branch.closing
    if state is not None:
        # Spatial and planar states alike have as many rates as coordinates.
        q, v = np.split(state, 2)
        return {"start": {"q": q.tolist(), "v": v.tolist()}, **_unknowns_of(z, branch)}
    if closing in _MOVING:
        half = (len(z) - 2) // 2
        return {
            "start": {"q": z[:half].tolist(), "v": z[half : 2 * half].tolist()}, "unfolding": float(z[-2]), "omega": float(z[-1]),
        }  # fmt: skip
    own, none = z[:-1].tolist(), [0.0] * (len(z) - 1)
    return {"start": {"q": none, "v": own} if closing == "odd" else {"q": own, "v": none}, "omega": float(z[-1])}


def _unknowns_of(z: np.ndarray, branch: Any) -> dict[str, Any]:
    return {"omega": float(z[branch.names.index("omega")]), "unknowns": z.tolist()}


def _turned(z: np.ndarray, branch: Any) -> dict[str, Any]:
    """Of a run in a parameter of the chain, which chain it is."""
    return {} if "omega" not in branch.names[:-1] else {"parameter": {branch.names[-1]: float(z[-1])}}


def _first_angle(names: Sequence[str]) -> int:
    return next((k for k, name in enumerate(names) if "theta" in name), 0)


def _number(values: np.ndarray | None, k: int) -> float | None:
    return None if values is None or not math.isfinite(values[k]) else float(values[k])


def pairs(values: np.ndarray) -> list[list[float]]:
    """Complex numbers as JSON has them."""
    return [[float(value.real), float(value.imag)] for value in values]


def read_document(path: Path | str) -> dict[str, Any]:
    """The fields of the Branch that `write_document` wrote.

    Raises:
        OutputError: The file is missing, cut short, or no Branch.
    """
    return reading_document(path, "branch", branch_fields)


def reading_document(path: Path | str, kind: str, read: Callable[[dict[str, Any]], Read]) -> Read:
    """What a JSON file holds, {"kind": KIND, ...}, read by `read`.

    Raises:
        OutputError: The file is missing, cut short, or holds no such thing.
    """
    try:
        found = parse_json(read_regular(path, _LARGEST))
        if not isinstance(found, dict) or found.get("kind") != kind:
            raise ValueError(f'it is no {{"kind": "{kind}", ...}}')
        return read(found)
    except (OSError, ValueError, KeyError, TypeError, IndexError, OverflowError, RecursionError, MemoryError) as failure:
        why = f"it lacks {failure}" if isinstance(failure, KeyError) else str(failure) or type(failure).__name__
        raise OutputError(
            "path", str(path), f"no {kind} can be read there: {why}", f"name a JSON file that a {kind.capitalize()} wrote, whole"
        ) from failure


def branch_fields(found: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a Branch from its JSON."""
    names, closing = tuple(map(str, found["names"])), str(found.get("closing", ""))
    size, rows = len(names), found["points"]
    points = np.array([_unknowns(row, closing) for row in rows], dtype=float).reshape(len(rows), size)
    tangent = _table(rows, "tangent", (len(rows), size))
    multipliers = _complex([row["kappa"] for row in rows])
    checkpoint = found["checkpoint"]
    regular, step, status = int(checkpoint["regular"]), float(checkpoint["step"]), found["status"]
    if not rows or not 0 <= regular <= len(rows) or status not in STATUS:
        raise ValueError("its checkpoint does not fit its points")
    scale = np.array(found["scale"], dtype=float)
    if scale.shape != (size,):
        raise ValueError("its unknowns do not fit their scale")
    events = tuple(
        Special(
            text_of(row, "kind"), int(row["after"]), np.array(_unknowns(row, closing)), float(row["arclength"]), float(row["value"]),
            _complex([row["kappa"]])[0], text_of(row, "breaks"), text_of(row, "continues"), _state(row),
        )
        for row in (*found["events"], *checkpoint["ended"])
    )  # fmt: skip
    passages = tuple(
        Passage(np.array(_unknowns(row, closing)), float(row["arclength"]), float(row["width"]), bool(row["crossed"]))
        for row in found["passages"]
    )
    return {
        "name": text_of(found, "name"), "names": names, "points": points, "arclength": _table(rows, "arclength", (len(rows),)),
        "tangent": tangent, "residual": _table(rows, "residual", (len(rows),)), "scale": scale,
        "iterations": np.array([int(row["iterations"]) for row in rows]), "energy": _optional(rows, "energy"),
        "error": _optional(rows, "error"), "multipliers": multipliers, "events": events, "passages": passages,
        "status": str(status), "reason": text_of(found, "reason"), "scene": text_of(found, "scene"), "digest": text_of(found, "digest"),
        "method": text_of(found, "method"), "closing": closing, "mode": int(found["mode"]), "regular": regular, "step": step,
        "momentum": _optional(rows, "momentum"), "states": _states(rows), "tol": float(found.get("tol", 0.0)), "p": values_of(found),
    }  # fmt: skip


def values_of(found: Mapping[str, Any]) -> dict[str, Any]:
    """The runtime parameters of a result from its JSON; files from before they were kept say nothing.

    Raises:
        ValueError: They are no numbers by name.
    """
    given = found.get("p", {})
    if not VALUES.fits(given):
        raise ValueError(f"its p holds no {VALUES.what}")
    return dict(given)


def _unknowns(row: Mapping[str, Any], closing: str) -> list[float]:
    if "unknowns" in row:
        return [float(value) for value in row["unknowns"]]
    q, v = (list(map(float, row["start"][part])) for part in "qv")
    if closing in _MOVING:
        return [*q, *v, float(row["unfolding"]), float(row["omega"])]
    return [*(v if closing == "odd" else q), float(row["omega"])]


def _state(row: Mapping[str, Any]) -> np.ndarray | None:
    """The state that the unknowns of a row stand for; None where they are a start themselves."""
    return np.array([*row["start"]["q"], *row["start"]["v"]], dtype=float) if "unknowns" in row else None


def _states(rows: Sequence[Mapping[str, Any]]) -> np.ndarray | None:
    found = [state for state in map(_state, rows) if state is not None]
    if not found:
        return None
    if len(found) < len(rows) or len({state.shape for state in found}) > 1 or len(found[0]) % 2:
        raise ValueError("its starts differ in size")
    return np.array(found, dtype=float)


def _table(rows: Sequence[Mapping[str, Any]], name: str, shape: tuple[int, ...]) -> np.ndarray:
    table = np.array([row[name] for row in rows], dtype=float)
    if table.shape != shape:
        raise ValueError(f"{name} has another shape than {shape}")
    return table


def _optional(rows: Sequence[Mapping[str, Any]], name: str) -> np.ndarray | None:
    values = [row.get(name) for row in rows]
    if all(value is None for value in values):
        return None
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _complex(rows: Sequence[Sequence[Sequence[float]]]) -> np.ndarray:
    return np.array([[complex(real, imaginary) for real, imaginary in row] for row in rows], dtype=complex).reshape(len(rows), -1)
