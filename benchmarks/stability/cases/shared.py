"""The seventeen committed cases of tests/data/extreme_cases.json: their references come from outside this project.

Gravity points along -e_3 in their spatial ones, so these are turned about e_1 by pi: (x, y, z) -> (x, -y, -z).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.stability.cases.case import Case

_FILE = Path(__file__).resolve().parents[3] / "tests" / "data" / "extreme_cases.json"
_KINDS = {"forward_dynamics": "dynamics", "simulation": "motion", "periodic_orbit": "period"}


@cache
def given() -> dict[str, dict[str, Any]]:
    """The file's cases by id."""
    return {case["id"]: case for case in json.loads(_FILE.read_text())["cases"]}


def cases() -> list[Case]:
    """All of them."""
    return [_case(entry) for entry in given().values()]


def _case(entry: dict[str, Any]) -> Case:
    kind = _KINDS[entry["kind"]]
    if kind == "period":
        chain = {"links": 1, "mass": 1.0, "length": 1.0, "gravity": float(entry["g"]), "actuated": "none"}
        return Case(
            entry["id"], entry["desc"], kind, chain, (float(entry["amplitude"]),), (0.0,), means="given"
        )
    chain = {
        "links": entry["N"], "mass": _floats(entry["m"]), "length": _floats(entry["l"]), "gravity": float(entry["g"]),
        "actuated": "none",
    }  # fmt: skip
    times = tuple(float(t) for t in entry.get("times", ()))
    if entry["model"] == "P":
        chain |= {
            "com": _floats(entry["r"]),
            "damping": _floats(entry["d"]),
            "stiffness": _floats(entry["k"]),
        }
        state = tuple(_floats(entry["theta"])), tuple(_floats(entry["thetadot"]))
        side = 7.0 if entry["id"] == "B01" else None
        return Case(entry["id"], entry["desc"], kind, chain, *state, times=times, means="given", side=side)
    chain |= {"space": "spatial", "base": "cart", "cart_mass": float(entry["mc"])}
    force = tuple(_turned(_floats(entry["F"])))
    if any(force):
        chain["actuated"] = "cart"
    cart = _floats(entry.get("cart", ["0"] * 4))
    q, w = ([x for row in entry[key] for x in _turned(_floats(row))] for key in ("q", "w"))
    state = (*_turned(cart[:2]), *q), (*_turned(cart[2:]), *w)
    return Case(entry["id"], entry["desc"], kind, chain, *state, force if any(force) else (), times, "given")


def rows(name: str) -> list[list[str]]:
    """The reference in the scene's coordinates: one row per time, or one of accelerations, or the frequency."""
    entry = given()[name]
    if entry["kind"] == "periodic_orbit":
        return [[entry["omega"]]]
    if entry["kind"] == "forward_dynamics":
        values = entry["ref"]
        return [values if entry["model"] == "P" else _turned_state(values, 2)]
    found = list(entry["reference"].values())
    return found if entry["model"] == "P" else [_cart_first(row, entry["N"]) for row in found]


def condition(name: str) -> list[float] | None:
    """The stated condition numbers, one per row; None where none is stated."""
    entry = given()[name]
    if entry["kind"] == "periodic_orbit":
        return [abs(float(entry["kappa_omega"]))]
    if entry["kind"] == "forward_dynamics":
        return [max(float(entry["kappa_state"]), float(entry["kappa_all"]))]
    return [float(x) for x in entry["kappa_initial_state"].values()] or None


def _cart_first(row: Sequence[str], links: int) -> list[str]:
    """q, w, cart x, cart x' of the file -> x, q, x', w of the scene, turned."""
    q, w = row[: 3 * links], row[3 * links : 6 * links]
    x, rate = row[6 * links : 6 * links + 2], row[6 * links + 2 :]
    return [*_turned_state([*x, *q], 2), *_turned_state([*rate, *w], 2)]


def _turned_state(values: Sequence[str], cart: int) -> list[str]:
    blocks = [values[:cart], *(values[i : i + 3] for i in range(cart, len(values), 3))]
    return [entry for block in blocks for entry in (block[0], *map(_negative, block[1:]))]


def _negative(text: str) -> str:
    return text[1:] if text.startswith("-") else f"-{text}"


def _turned(vector: Sequence[float]) -> list[float]:
    return [vector[0], *(-x for x in vector[1:])]


def _floats(texts: Sequence[str]) -> list[float]:
    return [float(text) for text in texts]
