"""Results as one JSON object: what a command prints for people, for programs. Records are known by their names, so that none is imported."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, Final

from phichain.origin import origin, plain


def summary(found: Any) -> dict[str, Any]:
    """Where a result comes from, its texts and numbers, and what else belongs to a record of its kind."""
    further = _FURTHER.get(type(found).__name__)
    return {**origin(found), **(further(found) if further else {})}


def printed(data: Mapping[str, Any]) -> str:
    """One line of JSON; numbers that are none become null."""
    return json.dumps(plain(data), sort_keys=True)


def _motion(found: Any) -> dict[str, Any]:
    return {
        "t": found.t[-1], "q": dict(zip(found.q_names, found.q[-1], strict=True)), "v": dict(zip(found.v_names, found.v[-1], strict=True)),
        "balance_error": found.balance_error, "holds_until": found.holds_until, "error": None if found.error is None else found.error[-1],
        "events": [{"name": event.name, "t": event.t, "x": event.x} for event in found.events],
    }  # fmt: skip


def _gains(found: Any) -> dict[str, Any]:
    return {
        "s": found.s, "decay": found.decay, "margin": found.margin, "poles": found.poles,
        "K": {name: dict(zip(found.state_names, row, strict=True)) for name, row in zip(found.input_names, found.K, strict=True)},
    }  # fmt: skip


def _branch(found: Any) -> dict[str, Any]:
    def at(z: Any) -> dict[str, Any]:
        return dict(zip(found.names, z, strict=True))

    return {
        "points": len(found), "arclength": found.arclength[-1], "first": at(found.points[0]), "last": at(found.points[-1]),
        "events": [{"kind": event.kind, **at(event.z), "breaks": event.breaks, "continues": event.continues} for event in found.events],
        "gaps": [{"width": gap.width, "crossed": gap.is_crossed, **at(gap.z)} for gap in found.passages],
    }  # fmt: skip


def _network(found: Any) -> dict[str, Any]:
    return {"branches": [{**origin(branch), **_branch(branch)} for branch in found.branches], "links": [vars(link) for link in found.links]}


def _fit(found: Any) -> dict[str, Any]:
    rows = zip(found.names, found.values, found.standard_error, found.confidence, strict=True)
    return {
        "fitted": {name: {"value": value, "standard_error": error, "confidence": limits} for name, value, error, limits in rows},
        "noise": dict(zip(found.columns, found.noise, strict=True)), "remarks": found.remarks, "rows": len(found.t), "x0": found.x0,
        "at_bound": found.at_bound,
    }  # fmt: skip


def _orbit(found: Any) -> dict[str, Any]:
    start = {name: dict(zip(getattr(found, f"{name}_names"), getattr(found, name)[0], strict=True)) for name in ("q", "v")}
    return {"period": found.period, "start": start, "multipliers": found.multipliers, "stable": found.is_stable}


def _response(found: Any) -> dict[str, Any]:
    events = [{"kind": event.kind, "omega": event.omega, "breaks": event.breaks, "continues": event.continues} for event in found.events]
    return {"points": len(found.omega), "omega": [found.omega[0], found.omega[-1]], "peak": dict(zip(found.names, found.peak.max(axis=0), strict=True)), "events": events}


def _connection(found: Any) -> dict[str, Any]:
    return {"s": found.s, "turns": found.turns, "rates": found.rates}


def _attraction(found: Any) -> dict[str, Any]:
    names = ("s", "radius", "beyond", "usual", "failed", "share", "runs")
    return {"equilibria": [{name: getattr(found, name)[k] for name in names} for k in range(len(found.s))]}


def _map(found: Any) -> dict[str, Any]:
    return {"home": float((found.verdict == 1).mean()), "coordinates": found.coordinates, "reach": found.axis[-1]}


def _trials(found: Any) -> dict[str, Any]:
    return {"runs": len(found.held), "share": found.share, "interval": found.interval}


def _swing_up(found: Any) -> dict[str, Any]:
    return {"plan": {**origin(found.plan), "duration": found.plan.duration}, "trials": _trials(found.trials), "tried": len(found.tried)}


def _climbed(found: Any) -> dict[str, Any]:
    return {"trials": {**origin(found.runs), **_trials(found.runs)}, "energy": [found.energy[0], found.energy[-1]], "t": found.t[-1]}


_FURTHER: Final[Mapping[str, Callable[[Any], dict[str, Any]]]] = {
    "Trajectory": _motion, "Gains": _gains, "Branch": _branch, "Network": _network, "Fit": _fit, "Orbit": _orbit, "Response": _response,
    "Connection": _connection, "Attraction": _attraction, "AttractionMap": _map, "Trials": _trials, "Runs": _trials, "SwingUp": _swing_up,
    "Climbed": _climbed,
}  # fmt: skip
