"""The committed extreme cases as scenes and starts of flows."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.scene import Scene
from tests.flow.flows import scene

EPS = float(np.finfo(float).eps)
CASES = {
    case["id"]: case
    for case in json.loads((Path(__file__).parents[1] / "data" / "extreme_cases.json").read_text())["cases"]
}

#: The spatial cases have gravity along -z: half a turn about the first axis.
TURN = np.array([1.0, -1.0, -1.0])


def of_case(case: dict[str, Any]) -> Scene:
    numbers = {key: [float(x) for x in case[key]] for key in ("m", "l")}
    more: dict[str, Any] = {"gravity": float(case["g"]), "mass": numbers["m"], "length": numbers["l"]}
    if case["model"] == "P":
        return scene(f"case_{case['id']}", "planar", "fixed", links=case["N"], **more)
    return scene(
        f"case_{case['id']}", "spatial", "cart", links=case["N"], cart_mass=float(case["mc"]), **more
    )


def start(case: dict[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if case["model"] == "P":
        return np.array(case["theta"], dtype=float), np.array(case["thetadot"], dtype=float)
    cart = np.array(case["cart"], dtype=float)
    q, w = np.array(case["q"], dtype=float), np.array(case["w"], dtype=float)
    return np.append(TURN[:2] * cart[:2], TURN * q), np.append(TURN[:2] * cart[2:], TURN * w)
