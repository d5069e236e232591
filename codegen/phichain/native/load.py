"""From a generated folder to a System of compiled callables."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from phichain.files import MANIFEST
from phichain.native.agreement import demand_agreement
from phichain.native.cache import Cache, default_cache
from phichain.native.callables import make_callable
from phichain.native.compiler import CompilerOptions
from phichain.native.flows.beside import Watched
from phichain.native.flows.brake import Braking
from phichain.native.flows.call import CALLERS
from phichain.native.flows.prepare import Foreigners, prepared_dynamics, prepared_signature
from phichain.native.glue.bound import bound_symbol
from phichain.native.glue.brake import TWINNED, brake_calls, brake_file, brake_source, brakes
from phichain.native.glue.interrupts import Interruptible
from phichain.native.glue.rows import prepared_size, row_loop, rows_source
from phichain.native.glue.source import beside_file, errors_beside, foreign_flow, glue_source, noted_flow
from phichain.native.library import load_library, shared_object
from phichain.native.memory.arrays import REAL
from phichain.native.origin import Origin, mark
from phichain.native.signature import Manifest, manifest_of, read_manifest
from phichain.native.symbolic import casadi_dynamics
from phichain.scene import Scene
from phichain.system import Drive, Joints, Numbers, System


def build_folder(
    folder: Path | str, options: CompilerOptions | None = None, cache: Cache | None = None
) -> System:
    """Compile a generated folder, or find it compiled, and load it.

    The folder is only read. Its NAME.c is compiled together with the row loops of `rows_source`.

    Args:
        folder: ``DIR/NAME`` with manifest.json, NAME.h and NAME.c.
        options: How to compile.
        cache: Where compiled objects are kept; the user's cache when None.

    Returns:
        A System whose callables take arrays of shape (...) or (n, ...), in the order of the C signatures. Its
        entry ``casadi``, where casadi is installed, makes the casadi.Function of the forward dynamics.

    Raises:
        OutputError: The folder is not a generated one or was changed; the disk is full.
        CompilerError: The compiler is missing, failed or hung.
        CacheError: The cache's folder is not the owner's alone, or the system cannot load from it.
    """
    return _built(read_manifest(folder), options, cache)


def build_files(
    files: Mapping[str, str | bytes], options: CompilerOptions | None = None, cache: Cache | None = None
) -> System:
    """Compile the files of a generated folder without a folder; arguments and errors as in `build_folder`.

    Args:
        files: Contents by file name: manifest.json, NAME.h, NAME.c and, where it is there, NAME_casadi.py.
    """
    texts = {name: text.encode() if isinstance(text, str) else bytes(text) for name, text in files.items()}
    return _built(manifest_of(texts), options, cache)


def _built(manifest: Manifest, options: CompilerOptions | None, cache: Cache | None) -> System:
    scene, name = demand_agreement(manifest), manifest.name
    sources = {file: manifest.source(file) for file in (f"{name}.h", f"{name}.c")}
    prepared = prepared_signature(scene, manifest.parameters) if "prepare" in manifest.flows else None
    glue = {f"{name}_rows.c": rows_source(manifest, prepared), f"{name}_glue.c": glue_source(manifest, scene, prepared)}
    if brakes(manifest, scene):
        glue[brake_file(manifest)] = brake_source(manifest, scene)
    beside = {file: manifest.source(file) for file in (beside_file(manifest),) if file in manifest.files}
    # What flies beside a flow is made of the static functions of NAME.c.
    whole = {f"{name}.c": b"\n".join((sources[f"{name}.c"], *beside.values()))}
    texts = {**sources, **whole, **{file: text.encode() for file, text in glue.items()}}
    library = load_library(shared_object(name, texts, cache or default_cache(), options))
    functions = _callables(manifest, scene, library)
    held = {MANIFEST: manifest.texts[MANIFEST], **sources, **beside}
    module = f"{name}_casadi.py"
    if module in manifest.files:
        held[module] = manifest.source(module)
    mark(functions, Origin(held, options, cache))
    return _system(manifest, scene, functions)


def build_casadi(
    folder: Path | str, options: CompilerOptions | None = None, cache: Cache | None = None
) -> Path:
    """Compile the opt-in NAME_casadi.c of a generated folder for CasADi's ``external``.

    Use it as ``casadi.external("NAME_casadi_forward_dynamics", str(path))``; the Jacobians come along and are
    exact.

    Args:
        folder: ``DIR/NAME`` with manifest.json, NAME.h, NAME.c and NAME_casadi.c.
        options: How to compile.
        cache: Where compiled objects are kept; the user's cache when None.

    Returns:
        The shared object: a verified copy for this process, which lasts until it ends.

    Raises:
        OutputError: The folder is not a generated one, was changed, or has no NAME_casadi.c; the disk is
            full.
        CompilerError: The compiler is missing, failed or hung.
        CacheError: The cache's folder is not the owner's alone.
    """
    manifest = read_manifest(folder)
    demand_agreement(manifest)
    # NAME_casadi.c calls the plain functions of NAME.c.
    files = (f"{manifest.name}{ending}" for ending in ("_casadi.c", ".h", ".c"))
    sources = {file: manifest.source(file) for file in files}
    return shared_object(manifest.name, sources, cache or default_cache(), options)


def _callables(manifest: Manifest, scene: Scene, library: ctypes.CDLL) -> dict[str, Callable[..., Any]]:
    functions: dict[str, Callable[..., Any]] = {}
    for name, signature in manifest.functions.items():
        function, loop = library[signature.symbol], Interruptible(library, row_loop(manifest.name, signature))
        function.restype = loop.restype = None
        functions[name] = make_callable(signature, function, loop, REAL[manifest.real])
    for name, symbol in manifest.flows.items():
        foreign: Any = Interruptible(library, foreign_flow(symbol, name, scene))
        if name == "prepare":
            foreign = _foreigners(manifest, scene, library, foreign)
            if "forward_dynamics" in functions:
                functions["forward_dynamics"] = prepared_dynamics(scene, manifest.parameters, foreign)
        more = _of_propagate(manifest, scene, library) if name == "propagate" else {}
        functions[name] = CALLERS.of(name)(scene, manifest.parameters, foreign, **more)
    dynamics = casadi_dynamics(manifest)
    return functions if dynamics is None else {**functions, "casadi": dynamics}


def _of_propagate(manifest: Manifest, scene: Scene, library: ctypes.CDLL) -> dict[str, Any]:
    """What the Taylor flow has beside itself."""
    found = {"watched": _watched(manifest, scene, library), "braking": _braking(manifest, scene, library)}
    return found | {"go": library[bound_symbol(manifest.name)]}


def _braking(manifest: Manifest, scene: Scene, library: ctypes.CDLL) -> Braking | None:
    """Brake orbits, where they were compiled."""
    if not brakes(manifest, scene):
        return None
    found: dict[str, Any] = {}
    for call, foreign in brake_calls(manifest).items():
        found[call] = Interruptible(library, foreign) if call in TWINNED else library[foreign.symbol]
        found[call].restype = ctypes.c_int
    return Braking(**found)


def _watched(manifest: Manifest, scene: Scene, library: ctypes.CDLL) -> Watched | None:
    """The Taylor flow that leaves its steps, and what flies beside these, where it was compiled."""
    if beside_file(manifest) not in manifest.files:
        return None
    flow = foreign_flow(manifest.flows["propagate"], "propagate", scene)
    function, errors = Interruptible(library, noted_flow(flow, manifest.name)), Interruptible(library, errors_beside(flow, manifest.name))
    errors.restype = None
    stop, step, room, low = (ctypes.c_ulong * 4).in_dll(library, f"{manifest.name}_beside_sizes")
    return Watched(function, errors, stop, step // REAL[manifest.real].itemsize, scene.nq, low, room)


def _foreigners(manifest: Manifest, scene: Scene, library: ctypes.CDLL, prepare: Any) -> Foreigners:
    """What belongs to NAME_prepare."""
    signature = prepared_signature(scene, manifest.parameters)
    size = library[prepared_size(manifest.name)]
    size.restype = ctypes.c_size_t
    rows = Interruptible(library, row_loop(manifest.name, signature))
    return Foreigners(prepare, library[signature.symbol], rows, int(size()))


def _system(manifest: Manifest, scene: Scene, functions: Mapping[str, Callable[..., Any]]) -> System:
    return System(
        name=manifest.name,
        space=scene.space,
        base=scene.base,
        links=scene.links,
        nq=scene.nq,
        nv=scene.nv,
        nu=scene.nu,
        real=manifest.real,
        functions=functions,
        q_names=scene.q_names,
        v_names=scene.v_names,
        u_names=scene.u_names,
        params=None,
        angles=scene.angles,
        numbers=Numbers(
            scene.mass, scene.length, scene.com, scene.cart_mass, scene.gravity, scene.inertia,
            scene.cart_damping, scene.cart_friction, scene.cart_friction_speed,
        ),
        joints=Joints(
            scene.stiffness, scene.damping, scene.armature, scene.rest_angle, scene.friction, scene.friction_speed,
        ),
        drive=Drive(scene.driven, scene.base_accelerations, scene.told_axes),
        variational=bool(scene.variational),
        varied=MappingProxyType(scene.varied),
        scene=manifest.scene,
        digest=manifest.digest,
    )
