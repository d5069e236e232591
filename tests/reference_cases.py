"""The committed reference vectors of tests/data/ as scenes, inputs and expected outputs.

Every case carries the inputs as exact binary64 numbers and the outputs as decimal strings of 25 or more
digits, from computations outside this project. `extreme` turns the spatial cases, whose gravity points along
-z, about e_1 by pi.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from mpmath import mp, mpf

from phichain.scene import Scene

DATA = Path(__file__).parent / "data"


@dataclass(frozen=True)
class ReferenceCase:
    """One vector: the scene, the C arguments by name, and the outputs by function and output name."""

    label: str
    scene: Scene
    inputs: dict[str, list[float]]
    expected: dict[str, dict[str, Any]] = field(repr=False)

    def __str__(self) -> str:
        return self.label


@cache
def read(name: str) -> Any:
    """Return the content of tests/data/NAME.json."""
    return json.loads((DATA / f"{name}.json").read_text())


def vectors() -> list[ReferenceCase]:
    """Return the 42 cases of vectors.json: paper A's planar chain, paper B's chain on a cart."""
    cases = enumerate(read("vectors")["cases"])
    return [_planar(i, case) if case["model"] == "planar" else _spatial(i, case) for i, case in cases]


def vectors_more() -> list[ReferenceCase]:
    """Return the 40 cases of vectors_more.json: planar carts, joints, spatial with fixed base or com < length."""
    cases = enumerate(read("vectors_more")["cases"])
    return [
        _planar_more(i, case) if case["model"].startswith("planar") else _spatial(i, case)
        for i, case in cases
    ]


def extreme() -> list[ReferenceCase]:
    """Return the forward-dynamics cases of extreme_cases.json."""
    chosen = [case for case in read("extreme_cases")["cases"] if case["kind"] == "forward_dynamics"]
    return [_extreme_planar(case) if case["model"] == "P" else _extreme_spatial(case) for case in chosen]


def relative_error(found: Any, expected: Any) -> float:
    """Return max |found - expected| / max |expected| over nested lists of numbers or decimal strings."""
    with mp.workdps(80):
        pairs = list(zip(flat(found), flat(expected), strict=True))
        scale = max((abs(b) for _, b in pairs), default=mpf(0))
        gap = max((abs(a - b) for a, b in pairs), default=mpf(0))
        return float(gap / scale) if scale else float(gap)


def flat(values: Any) -> list[Any]:
    """Return nested lists of numbers or decimal strings as one list of mpf."""
    if isinstance(values, Iterable) and not isinstance(values, str):
        return [entry for value in values for entry in flat(value)]
    return [mpf(values)]


def _planar(index: int, case: dict[str, Any]) -> ReferenceCase:
    scene = Scene(
        name=f"planar{case['links']}",
        links=case["links"],
        mass=case["mass"],
        length=case["length"],
        com=case["com"],
        gravity=case["gravity"],
        angles=case["coordinates"],
        actuated="all",
    )
    expected = {
        "forward_dynamics": {"a": case["theta_ddot"]},
        "mass_matrix": {"M": case["inertia"]},
        "coriolis": {"N": case["coriolis"]},
        "gravity_torque": {"G": case["gravity_torque"]},
        "energy": {"kinetic": case["kinetic"], "potential": case["potential"]},
    }
    inputs = {"q": case["theta"], "v": case["theta_dot"], "u": case["torque"]}
    return ReferenceCase(f"vectors-{index}-{scene.angles}-{scene.links}", scene, inputs, expected)


def _planar_more(index: int, case: dict[str, Any]) -> ReferenceCase:
    cart = {} if case["cart_mass"] is None else {"base": "cart", "cart_mass": case["cart_mass"]}
    scene = Scene(
        name=case["model"],
        links=case["links"],
        mass=case["mass"],
        length=case["length"],
        com=case["com"],
        gravity=case["gravity"],
        angles=case["coordinates"],
        stiffness=case["stiffness"],
        damping=case["damping"],
        actuated="all",
        **cart,
    )
    inputs = {"q": case["q"], "v": case["v"], "u": case["u"]}
    expected = {"forward_dynamics": {"a": case["a"]}}
    return ReferenceCase(f"more-{index}-{case['model']}-{scene.links}", scene, inputs, expected)


def _spatial(index: int, case: dict[str, Any]) -> ReferenceCase:
    cart = {} if case["cart_mass"] is None else {"base": "cart", "cart_mass": case["cart_mass"]}
    scene = Scene(
        name=case["model"],
        links=case["links"],
        space="spatial",
        mass=case["mass"],
        length=case["length"],
        com=case.get("com"),
        gravity=case["gravity"],
        **cart,
    )
    rest = [0.0] * (2 if cart else 0)
    inputs = {
        "q": case.get("x", rest) + [entry for link in case["q"] for entry in link],
        "v": case.get("x_dot", rest) + [entry for link in case["omega"] for entry in link],
        "u": case["force"],
    }
    turns = [entry for link in case["omega_dot"] for entry in link]
    expected = {"forward_dynamics": {"a": case["x_ddot"] + turns}}
    return ReferenceCase(f"spatial-{index}-{case['model']}-{scene.links}", scene, inputs, expected)


def _extreme_planar(case: dict[str, Any]) -> ReferenceCase:
    scene = Scene(
        name=case["id"],
        links=case["N"],
        mass=_floats(case["m"]),
        length=_floats(case["l"]),
        com=_floats(case["r"]),
        gravity=float(case["g"]),
        damping=_floats(case["d"]),
        stiffness=_floats(case["k"]),
    )
    inputs = {"q": _floats(case["theta"]), "v": _floats(case["thetadot"])}
    return ReferenceCase(
        f"{case['id']}-{case['desc']}", scene, inputs, {"forward_dynamics": {"a": case["ref"]}}
    )


def _extreme_spatial(case: dict[str, Any]) -> ReferenceCase:
    scene = Scene(
        name=case["id"],
        links=case["N"],
        space="spatial",
        base="cart",
        mass=_floats(case["m"]),
        length=_floats(case["l"]),
        cart_mass=float(case["mc"]),
        gravity=float(case["g"]),
    )
    links, rates = ([_turned(_floats(link)) for link in case[key]] for key in ("q", "w"))
    inputs = {
        "q": [0.0, 0.0, *(entry for link in links for entry in link)],
        "v": [0.0, 0.0, *(entry for rate in rates for entry in rate)],
        "u": _turned(_floats(case["F"])),
    }
    cart, *turns = [case["ref"][:2], *(case["ref"][i : i + 3] for i in range(2, len(case["ref"]), 3))]
    with mp.workdps(60):
        expected = [entry for block in (cart, *turns) for entry in _turned([mpf(text) for text in block])]
    return ReferenceCase(f"{case['id']}-{case['desc']}", scene, inputs, {"forward_dynamics": {"a": expected}})


def _floats(texts: Iterable[str]) -> list[float]:
    return [float(text) for text in texts]


def _turned(vector: list[Any]) -> list[Any]:
    """Return a horizontal or spatial vector turned about e_1 by pi: (x, y, z) -> (x, -y, -z)."""
    return [vector[0], *(-entry for entry in vector[1:])]
