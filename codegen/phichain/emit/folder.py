"""A scene's generated folder as texts: every file a pure function of the scene."""

from __future__ import annotations

from phichain.emit.c.text import header, source
from phichain.emit.casadi.external import casadi_external
from phichain.emit.casadi.module import casadi_module
from phichain.emit.flow.flows import flows
from phichain.emit.left_out import left_out
from phichain.emit.manifest import manifest
from phichain.emit.render import render
from phichain.emit.selftest.cases import make_selftest
from phichain.emit.selftest.text import selftest_source
from phichain.files import MANIFEST
from phichain.ir.passes import total_operations
from phichain.lowering.lower import Lowered
from phichain.scene import Scene


def library_files(scene: Scene, lowered: Lowered) -> dict[str, str]:
    """What a compiled System is made of: the C, the CasADi module and the manifest, by file name."""
    files = {f"{scene.name}.h": header(scene, lowered, {}), f"{scene.name}.c": source(scene, lowered)}
    files |= _casadi(scene, lowered)
    return files | {MANIFEST: manifest(scene, lowered, {}, files)}


def folder_files(scene: Scene, lowered: Lowered, with_casadi_c: bool = False) -> dict[str, str]:
    """The whole folder that a user takes away, by file name.

    Args:
        scene: the scene.
        lowered: its Programs.
        with_casadi_c: also write NAME_casadi.c, which CasADi's ``external`` loads.
    """
    selftest = make_selftest(scene, lowered)
    files = {
        f"{scene.name}.h": header(scene, lowered, selftest.tolerances),
        f"{scene.name}.c": source(scene, lowered),
        **_casadi(scene, lowered),
        "selftest.c": selftest_source(scene, lowered, selftest),
        "CMakeLists.txt": render("CMakeLists.txt.j2", name=scene.name),
        "README.md": _readme(scene, lowered),
    }
    if with_casadi_c:
        files[f"{scene.name}_casadi.c"] = casadi_external(scene, lowered)
    return files | {MANIFEST: manifest(scene, lowered, selftest.tolerances, files)}


def _casadi(scene: Scene, lowered: Lowered) -> dict[str, str]:
    """The CasADi module, unless the scene wants nothing but flows, which CasADi has no form for."""
    return {f"{scene.name}_casadi.py": casadi_module(scene, lowered)} if lowered.wanted else {}


def _readme(scene: Scene, lowered: Lowered) -> str:
    functions = [(p.name, p.doc, str(total_operations(p))) for p in lowered.wanted.values()]
    functions += [(flow.name, flow.doc, "") for flow in flows(scene, lowered)]
    return render(
        "generated_readme.md.j2", name=scene.name, real=scene.real, sketch=str(scene), functions=functions,
        left_out=left_out(scene, lowered), has_casadi=bool(lowered.wanted), digest=scene.digest, runtime=list(scene.runtime),
    )  # fmt: skip
