"""C that lets a compiled law run on a compiled chain, many times, each with parameters of its own."""

from __future__ import annotations

from phichain.emit.law.trajectory import swingup_name
from phichain.emit.stencil import instance
from phichain.laws import TrajectoryLaw
from phichain.scene import Scene


def trials_symbol(scene: Scene) -> str:
    """Name of the C function that `trials_source` defines."""
    return f"{scene.name}_trials"


def trials_source(scene: Scene, law: TrajectoryLaw) -> str:
    """C text on NAME.h and NAME_swingup.h, to be compiled with both and never emitted."""
    name, led, has_params = scene.name, swingup_name(law), bool(scene.runtime)
    context, passed = (f"const {name}_params *const p, ", "p, ") if has_params else ("", "")
    names = {
        "phi_": f"{name}_", "law_call": led, "law_": f"{led}_", "LAW_": f"{led.upper()}_", "trial_runs": trials_symbol(scene),
        "trial_": f"{name}_trial_", "TRIAL_NX": str(scene.nq + scene.nv), "TRIAL_NU": str(scene.nu), "TRIAL_READ": str(law.measured), "TRIAL_CONTEXT": context,
        "TRIAL_PASS": passed, "TRIAL_PARAMS": f"{name}_params" if has_params else f"{name}_real",
    }  # fmt: skip
    head = f'#include "{name}.h"\n#include "{led}.h"\n\nvoid {trials_symbol(scene)}'
    text = instance("trials", names, {"WITH_PARAMS": has_params, "WITH_OBSERVER": law.observer is not None})
    start = text.index(f"void {trials_symbol(scene)}") + len(f"void {trials_symbol(scene)}")
    prototype = text[start : text.index(")\n", start) + 1]
    return f"{head}{prototype};\n\n{text}"
