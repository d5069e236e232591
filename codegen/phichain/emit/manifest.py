"""manifest.json: what a generated folder is, offers, costs and leaves out, with the hash of every file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from phichain._version import __version__
from phichain.emit.c.programs import PrintedFunction
from phichain.emit.cost import Cost, costs, kernel_flash
from phichain.emit.left_out import left_out
from phichain.emit.printed import Printed
from phichain.ir.nodes import Array
from phichain.transform.tangent import sparsity

_UNPROVEN = "not proven: the proof was switched off"


def manifest(
    printed: Printed, tolerances: Mapping[str, str], files: Mapping[str, str], proof: Mapping[str, str] | None
) -> str:
    """The manifest as JSON text, keys in a fixed order.

    Args:
        printed: the scene's C.
        tolerances: how far each function may be from the reference.
        files: the texts to hash.
        proof: how each function was proven; None where nobody did.
    """
    scene, known = printed.scene, costs(printed)
    record = {
        "name": scene.name,
        "scene": scene.to_dict(),
        "digest": scene.digest,
        "generator": {"phichain": __version__, "sympy": _version("sympy"), "jinja2": _version("jinja2")},
        "real": scene.real,
        "params": [_argument(array) for array in printed.params],
        "functions": {
            function.name: _function(function, tolerances.get(function.name)) | _cost(known[function.name]) for function in printed.wanted
        },
        "flows": {flow.name: {"symbol": flow.symbol, "doc": flow.doc} | _cost(known[flow.name]) for flow in printed.flows},
        "sincos_flash_at_most": kernel_flash(printed),
        "helpers": sorted(function.name for function in printed.helpers),
        "proof": dict(proof) if proof is not None else dict.fromkeys(scene.want, _UNPROVEN),
        "left_out": left_out(printed),
        "files": {name: "sha256:" + hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(files.items())},
    }
    return _text(record)


def with_proof(manifest: str, proof: Mapping[str, str]) -> str:
    """The same manifest once it is known how each function was proven."""
    return _text(json.loads(manifest) | {"proof": dict(proof)})


def _text(record: Mapping[str, Any]) -> str:
    return json.dumps(record, indent=2, ensure_ascii=True) + "\n"


def _function(function: PrintedFunction, tolerance: str | None) -> dict[str, Any]:
    program = function.program
    record: dict[str, Any] = {
        "symbol": function.symbol,
        "params": bool(program.params),
        "inputs": [_argument(array) for array in program.inputs],
        "outputs": [_argument(array) for array in program.outputs],
        "code": "unrolled" if program.is_straight_line else "loops",
        "operations": {"total": function.operations, **dict(sorted(function.counts.items()))},
        "measured_tolerance": float(tolerance.rstrip("F")) if tolerance else None,
    }
    if program.is_straight_line:
        nonzero = sparsity(program)
        record["sparsity"] = {
            array.name: list(nonzero[array.name]) for array in program.outputs if len(nonzero[array.name]) < array.size
        }
    return record


def _cost(cost: Cost) -> dict[str, Any]:
    """Bounds on a Cortex-M4F; see `emit.cost`."""
    return {
        "cortex_m4f_at_most": {
            "flash_Os": cost.flash, "flash_O2": cost.fast_flash, "stack": cost.stack, "instructions_Os": cost.instructions
        }
    }  # fmt: skip


def _argument(array: Array) -> dict[str, Any]:
    return {"name": array.name, "shape": list(array.shape), "doc": array.doc}


def _version(package: str) -> str:
    """Version of a dependency, by its metadata, else by its own word."""
    try:
        return version(package)
    except PackageNotFoundError:
        return str(getattr(import_module(package), "__version__", "unknown"))
