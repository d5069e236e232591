"""Whether a manifest is borne out: by the scene in it, by the contract, and by the header of its C.

What a manifest says decides which symbol is called with how many numbers of which type, and a wrong word there would make C read
and write where it may not. So nothing is taken on its word: the functions, their arguments and the flows follow from its scene
by the contract, and the header must declare the same.
"""

from __future__ import annotations

import re
from typing import NoReturn

from phichain.contract.functions import ROWS
from phichain.errors import OutputError, PhichainError
from phichain.native.signature import Argument, Manifest, Signature
from phichain.scene import Scene, scene_from_dict

_REMEDY = "generate the folder again with this version of phichain"
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)


def demand_agreement(manifest: Manifest) -> Scene:
    """The scene of a manifest that scene, contract and header bear out.

    Raises:
        OutputError: One of them says something else; the message says what.
    """
    scene = _scene(manifest)
    _demand(manifest, "name", manifest.name, scene.name)
    _demand(manifest, "digest", manifest.digest, scene.digest)
    _demand(manifest, "real", manifest.real, scene.real)
    runtime = tuple(Argument(name, shape) for name, shape in scene.runtime_shapes.items())
    _demand(manifest, "params", _told(manifest.parameters), _told(runtime))
    flows = [name for name in scene.want if ROWS[name].flow]
    plain = [name for name in scene.want if not ROWS[name].flow]
    _demand(manifest, "functions", sorted(manifest.functions), sorted(plain))
    _demand(manifest, "flows", sorted(manifest.flows), sorted(flows))
    for name, symbol in manifest.flows.items():
        _demand(manifest, f"flows.{name}.symbol", symbol, f"{scene.name}_{name}")
    for name, signature in manifest.functions.items():
        _demand(manifest, f"functions.{name}.symbol", signature.symbol, f"{scene.name}_{name}")
        for direction, given in (("in", signature.inputs), ("out", signature.outputs)):
            promised = [row for row in ROWS[name].arguments_of(scene) if row.direction == direction]
            expected = tuple(Argument(row.name, row.shape(scene)) for row in promised)
            _demand(manifest, f"functions.{name}.{direction}puts", _told(given), _told(expected))
    _demand_header(manifest, scene)
    return scene


def _scene(manifest: Manifest) -> Scene:
    try:
        return scene_from_dict(dict(manifest.scene))
    except (PhichainError, TypeError, ValueError) as error:
        _refuse(manifest, "scene", manifest.scene.get("name"), f"describes no scene, {error}")


def _demand_header(manifest: Manifest, scene: Scene) -> None:
    """Hold sizes, type and prototypes of the header against the scene."""
    name = scene.name
    text = manifest.source(f"{name}.h").decode("utf-8", "replace")
    types = re.findall(rf"\btypedef\s+(\w+)\s+{name}_real\s*;", code := _COMMENT.sub(" ", text))
    _demand(manifest, "real", [manifest.real], types)
    for size, value in {"LINKS": scene.links, "NQ": scene.nq, "NV": scene.nv, "NU": scene.nu}.items():
        found = re.findall(rf"#define\s+{name.upper()}_{size}\s+(\d+)", code)
        _demand(manifest, f"the header's {size}", found, [str(value)] if value or found else [])
    for signature in manifest.functions.values():
        _demand(manifest, f"functions.{signature.name}", [prototype(name, signature)], _declared(code, signature.symbol))
    for flow, symbol in manifest.flows.items():
        _demand(manifest, f"flows.{flow}", len(_declared(code, symbol)), 1)


def prototype(name: str, signature: Signature) -> str:
    """What a header says between the brackets of a function, in one spelling."""
    parts = [f"const {name}_params *p"] if signature.takes_parameters else []
    for item in signature.inputs:
        parts.append(f"const {name}_real {item.name}[{item.size}]" if item.shape else f"{name}_real {item.name}")
    for item in signature.outputs:
        parts.append(f"{name}_real {item.name}[{item.size}]" if item.shape else f"{name}_real *{item.name}")
    return ", ".join(parts)


def _declared(code: str, symbol: str) -> list[str]:
    """The arguments of every declaration of a symbol."""
    return [" ".join(found.split()) for found in re.findall(rf"\b\w+\s+{symbol}\s*\(([^)]*)\)\s*;", code)]


def _told(arguments: tuple[Argument, ...]) -> list[str]:
    return [str(argument) for argument in arguments]


def _demand(manifest: Manifest, where: str, found: object, expected: object) -> None:
    if found != expected:
        _refuse(manifest, where, found, f"says another {where} than its scene and its C, {expected}")


def _refuse(manifest: Manifest, where: str, value: object, problem: str) -> NoReturn:
    place = manifest.folder or "texts in memory"
    raise OutputError("manifest", value, f"{problem}, in {place}", _REMEDY, where=where)
