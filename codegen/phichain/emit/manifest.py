"""manifest.json: what a generated folder is, offers, costs and leaves out, with the hash of every file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from phichain.emit.flow.flows import flows
from phichain.emit.left_out import left_out
from phichain.ir.nodes import Array, Program
from phichain.ir.passes import count_operations
from phichain.lowering.lower import Lowered
from phichain.scene import Scene
from phichain.transform.tangent import sparsity


def manifest(scene: Scene, lowered: Lowered, tolerances: Mapping[str, str], files: Mapping[str, str]) -> str:
    """The manifest as JSON text, keys in a fixed order."""
    record = {
        "name": scene.name,
        "scene": scene.to_dict(),
        "digest": scene.digest,
        "generator": {"phichain": _version("phichain"), "sympy": _version("sympy"), "jinja2": _version("jinja2")},
        "real": scene.real,
        "params": [_argument(array) for array in lowered.params],
        "functions": {
            name: _function(scene, program, tolerances.get(name)) for name, program in lowered.wanted.items()
        },
        "flows": {flow.name: {"symbol": flow.symbol, "doc": flow.doc} for flow in flows(scene, lowered)},
        "helpers": sorted(lowered.helpers),
        "left_out": left_out(scene, lowered),
        "files": {name: "sha256:" + hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(files.items())},
    }
    return json.dumps(record, indent=2, ensure_ascii=True) + "\n"


def _function(scene: Scene, program: Program, tolerance: str | None) -> dict[str, Any]:
    counts = count_operations(program)
    record: dict[str, Any] = {
        "symbol": f"{scene.name}_{program.name}",
        "params": bool(program.params),
        "inputs": [_argument(array) for array in program.inputs],
        "outputs": [_argument(array) for array in program.outputs],
        "code": "unrolled" if program.is_straight_line else "loops",
        "operations": {"total": sum(counts.values()), **dict(sorted(counts.items()))},
        "measured_tolerance": float(tolerance.rstrip("f")) if tolerance else None,
    }
    if program.is_straight_line:
        nonzero = sparsity(program)
        record["sparsity"] = {
            array.name: list(nonzero[array.name]) for array in program.outputs if len(nonzero[array.name]) < array.size
        }
    return record


def _argument(array: Array) -> dict[str, Any]:
    return {"name": array.name, "shape": list(array.shape), "doc": array.doc}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        from phichain._version import __version__

        return __version__
