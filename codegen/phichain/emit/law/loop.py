"""C that lets any compiled law run on a compiled chain, many times, with wrong parameters, late inputs and sensors that read in steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from phichain.emit.stencil import at_once, instance
from phichain.errors import EmissionError
from phichain.scene import Scene

LATEST: Final = 1000
"""Largest delay, in calls of the law."""

_SAYS: Final = "*phase = (int)law_call(&state, measured, pushed);"

KINDS: Final = {
    "feedback": ("", "", "law_call(measured, pushed);"),
    "memory": ("law_state state;", "RESET", "law_call(&state, measured, pushed);"),
    "table": ("law_state state;", "law_reset(&state);", _SAYS),
    "output table": ("law_state state;", "law_reset(&state);", _SAYS),
    "climb": ("law_state state;", "law_reset(&state);", _SAYS),
    "trajectory": (
        "law_state state;", "RESET", "*phase = (int)law_call(&state, (law_real)((phi_real)k * task->sample), measured, pushed);"
    ),
}  # fmt: skip
"""What a law keeps, how it is reset, how it is called, by its kind."""


@dataclass(frozen=True)
class Called:
    """How a law on file is called.

    Attributes:
        name: Its function, and the stem of its files.
        kind: One of `KINDS`.
        ny: Entries of what is measured.
        reset: Arguments of the reset of a law with a memory.
    """

    name: str
    kind: str
    ny: int
    reset: str = "&state"


def loop_symbol(scene: Scene) -> str:
    """Name of the C function that `loop_source` defines."""
    return f"{scene.name}_loop"


def loop_source(scene: Scene, law: Called) -> str:
    """C text on NAME.h and the law's header, to be compiled with both and never emitted.

    Raises:
        EmissionError: there are no laws of that kind.
    """
    if law.kind not in KINDS:
        raise EmissionError("law", law.kind, "is no kind of law that is called here", f"known are {', '.join(KINDS)}")
    name, nx, nu, has_params = scene.name, scene.nq + scene.nv, scene.nu, bool(scene.runtime)
    context, passed = (f"const {name}_params *const p, ", "p, ") if has_params else ("", "")
    state, reset, call = KINDS[law.kind]
    reset = f"law_reset({law.reset});" if reset == "RESET" else reset
    own = {"law_call": law.name, "law_": f"{law.name}_", "phi_real": f"{name}_real"}
    state, reset, call = (at_once(part, own) for part in (state, reset, call))
    names = own | {
        "phi_": f"{name}_", "loop_runs": loop_symbol(scene), "loop_": f"{name}_loop_", "LOOP_NX": str(nx), "LOOP_NU": str(nu),
        "LOOP_NY": str(law.ny), "LOOP_LATEST": str(LATEST), "LOOP_CONTEXT": context, "LOOP_PASS": passed,
        "LOOP_PARAMS": f"{name}_params" if has_params else f"{name}_real", "LOOP_STATE": state, "LOOP_RESET": reset, "LOOP_CALL": call,
    }  # fmt: skip
    text = at_once(instance("laws/loop", {}, {"WITH_PARAMS": has_params, "WITH_STEP": not scene.is_planar}), names)
    task = "\n".join(f"    {line};" for line in task_fields(nx, law.ny))
    head = f'#include "{name}.h"\n#include "{law.name}.h"\n#include <math.h>\n\ntypedef struct {{\n{task}\n}} {name}_loop_task;\n\n'
    start = text.index(f"\nvoid {loop_symbol(scene)}(") + 1
    return f"{head}{text[start : text.index(')', start) + 1]};\n\n{text}"


def task_fields(nx: int, ny: int) -> tuple[str, ...]:
    """The members of the task, which ctypes repeats."""
    return (
        "long calls, every, steps, lost", "double sample", f"double target[{nx}], turns[{nx}], near[{nx}]", f"double resolution[{ny}]",
        f"long reads[{ny}]",
    )  # fmt: skip
