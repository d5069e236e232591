"""fmu.c: names and sizes of a scene, and behind them the stencils of FMI 3.0."""

from __future__ import annotations

from phichain.contract.functions import ROWS
from phichain.emit.fmu.description import token
from phichain.emit.fmu.variables import parameters, start
from phichain.emit.stencil import instance
from phichain.scene import Scene

FLOWS = ("propagate", "propagate_stiff")
"""Flows that move the state in Co-Simulation: the first that a scene has."""


STENCILS = ("fmi/fmi3_instance", "fmi/fmi3_refused", "fmi/fmi3")
"""The C, in its order: an instance and its variables, what no scene offers, and what every scene does."""


def flow_of(scene: Scene) -> str:
    """The flow by which a scene steps."""
    return next(name for name in FLOWS if ROWS[name].absence(scene) is None)


def fmu_source(scene: Scene) -> str:
    """The C of an FMU, but for the scene's own."""
    name, upper = scene.name, scene.name.upper()
    found = parameters(scene)
    is_taylor = flow_of(scene) == "propagate"
    sizes = {
        "FMU_Q": scene.nq, "FMU_V": scene.nv, "FMU_U": scene.nu, "FMU_P": len(found), "FMU_ENERGY": 2 * ("energy" in scene.want),
        "FMU_CART": scene.nq - scene.links * (1 if scene.is_planar else 3), "FMU_STEPS": 10_000_000,
    }  # fmt: skip
    lines = [
        f"/* {name} as an FMU: FMI 3.0, Model Exchange and Co-Simulation. */",
        f'#include "{name}.h"',
        "#include <stdbool.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <stdlib.h>\n#include <string.h>",
        "#ifdef _WIN32\n#define FMI3_EXPORT __declspec(dllexport)\n#elif defined(__GNUC__)",
        '#define FMI3_EXPORT __attribute__((visibility("default")))\n#else\n#define FMI3_EXPORT\n#endif',
        f"enum {{ {', '.join(f'{key} = {value}' for key, value in sizes.items())} }};",
        f'#define FMU_TOKEN "{token(scene)}"',
        f"#define FMU_BUDGET {upper}_{'' if is_taylor else 'STIFF_'}STEP_BUDGET",
        f"/* Where the chain starts: hanging, at rest. */\nstatic const double fmu_start[{scene.nq}] = {{{', '.join(map(repr, start(scene)))}}};",
        f"static const double fmu_parameters[{len(found) + 1}] = {{{', '.join(repr(value) for _, value in found) or '0'}}};",
    ]
    if found:
        places = [f"    to->{_place(key)} = ({name}_real)p[{k}];" for k, (key, _) in enumerate(found)]
        lines.append(f"static void {name}_fill(const double *const p, {name}_params *const to)\n{{\n" + "\n".join(places) + "\n}")
    names = {
        "phi_carried": f"{name}_flow" if is_taylor else f"{name}_stiff", "phi_work": f"{name}_workspace" if is_taylor else f"{name}_stiff_workspace", "phi_move": f"{name}_{flow_of(scene)}", "phi_": f"{name}_",
        "PARAMS_PASS": "&it->own," if found else "", "FLOW_PASS": "&it->own," if found else "", "INPUT_PASS": "it->u," if scene.nu else "",
        "MOVE_PASS": "it->u," if scene.nu else "", "EVENT_PASS": "NULL," if is_taylor else "",
    }  # fmt: skip
    features = {"WITH_PARAMS": bool(found), "WITH_SPHERE": not scene.is_planar, "WITH_ENERGY": "energy" in scene.want}
    return "\n".join(lines) + "\n\n" + "\n".join(instance(stencil, names, features) for stencil in STENCILS)


def _place(key: str) -> str:
    """`mass[1]` as C counts: `mass[0]`."""
    name, _, entry = key.partition("[")
    return f"{name}[{int(entry[:-1]) - 1}]" if entry else name
