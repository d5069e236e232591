"""A scene's generated folder as texts: every file a pure function of the scene, every Program printed once."""

from __future__ import annotations

import re
from collections.abc import Mapping

from phichain.emit.c.sincos import coefficients
from phichain.emit.c.text import header, source
from phichain.emit.casadi.external import casadi_external
from phichain.emit.casadi.module import casadi_module
from phichain.emit.cost import costs, demand_room, kernel_flash
from phichain.emit.left_out import left_out
from phichain.emit.manifest import manifest
from phichain.emit.printed import Printed, print_scene
from phichain.emit.render import render
from phichain.emit.selftest.cases import make_selftest
from phichain.emit.selftest.text import selftest_source
from phichain.errors import SceneError
from phichain.files import MANIFEST, SELFTEST_HOOK
from phichain.lowering.lower import Lowered
from phichain.scene import Scene
from phichain.scene.keys import label


def library_files(scene: Scene, lowered: Lowered) -> dict[str, str]:
    """What a compiled System is made of: the C, the CasADi module and the manifest, by file name.

    The manifest says that nothing was proven yet; `with_proof` puts in what was.
    """
    printed = print_scene(scene, lowered)
    files = {f"{scene.name}.h": header(printed, {}), f"{scene.name}.c": source(printed)}
    files |= _casadi(scene, lowered)
    files |= {f"{scene.name}_beside.c": flow.text.beside for flow in printed.flows if flow.text.beside}
    return files | {MANIFEST: manifest(printed, {}, files, None)}


def folder_files(
    scene: Scene, lowered: Lowered, with_casadi_c: bool = False, proof: Mapping[str, str] | None = None
) -> dict[str, str]:
    """The whole folder that a user takes away, by file name.

    Args:
        scene: the scene.
        lowered: its Programs.
        with_casadi_c: also write NAME_casadi.c, which CasADi's ``external`` loads.
        proof: how each function was proven; None where nobody did.
    """
    printed = print_scene(scene, lowered)
    demand_room(printed)
    selftest = make_selftest(scene, lowered)
    files = {
        f"{scene.name}.h": header(printed, selftest.tolerances),
        f"{scene.name}.c": source(printed),
        **_casadi(scene, lowered),
        "selftest.c": selftest_source(scene, lowered, selftest),
        "CMakeLists.txt": render("CMakeLists.txt.j2", name=scene.name, upper=scene.name.upper(), hook=scene.trig_hook),
        "README.md": _readme(printed),
        **_hook(scene),
    }
    _demand_free_hook(scene, files)
    if with_casadi_c:
        files[f"{scene.name}_casadi.c"] = casadi_external(printed)
    return files | {MANIFEST: manifest(printed, selftest.tolerances, files, proof)}


def _hook(scene: Scene) -> dict[str, str]:
    """What the self-test links with where sines and cosines are the user's."""
    if scene.trig_hook is None:
        return {}
    text = render("selftest_hook.c.j2", name=scene.name, hook=scene.trig_hook, **coefficients(scene.real))
    return {SELFTEST_HOOK: text}


def _demand_free_hook(scene: Scene, files: Mapping[str, str]) -> None:
    """Go on only where the user's function is called by a name that C written here uses for nothing else.

    Raises:
        SceneError: it is the name of a variable or of a function here; what it says is its declaration and its call alone.
    """
    code = re.sub(r"/\*.*?\*/", "", "".join(files[name] for name in (f"{scene.name}.h", f"{scene.name}.c", "selftest.c")), flags=re.DOTALL)
    if scene.trig_hook is not None and len(re.findall(rf"\b{scene.trig_hook}\b", code)) > 2:
        raise SceneError(
            label("trig_hook"), scene.trig_hook, "is a name that the generated code uses itself", f'choose another name, e.g. "my_{scene.trig_hook}"'
        )


def _casadi(scene: Scene, lowered: Lowered) -> dict[str, str]:
    """The CasADi module, unless the scene wants nothing but flows, which CasADi has no form for."""
    return {f"{scene.name}_casadi.py": casadi_module(scene, lowered)} if lowered.wanted else {}


def _readme(printed: Printed) -> str:
    scene = printed.scene
    functions = [(function.name, function.doc, str(function.operations)) for function in printed.wanted]
    functions += [(flow.name, flow.doc, "") for flow in printed.flows]
    return render(
        "generated_readme.md.j2", name=scene.name, real=scene.real, sketch=str(scene), functions=functions,
        left_out=left_out(printed), costs=costs(printed), kernel=kernel_flash(printed),
        has_flows=any(flow.name in ("propagate", "propagate_stiff") for flow in printed.flows), has_casadi=bool(printed.wanted), digest=scene.digest, runtime=list(scene.runtime),
    )  # fmt: skip
