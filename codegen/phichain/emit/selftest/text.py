"""The text of selftest.c: every case with its numbers as hexadecimal literals of the scene's type."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from phichain.contract.flows import DONE
from phichain.contract.functions import ROWS
from phichain.emit.c.layout import laid_out_text
from phichain.emit.render import render
from phichain.emit.selftest.case import Case, columns
from phichain.emit.selftest.cases import Selftest
from phichain.emit.selftest.flow import FlowCase
from phichain.emit.selftest.states import rounded
from phichain.ir.nodes import Array, Program
from phichain.lowering.lower import Lowered
from phichain.lowering.preparation import preparation
from phichain.scene import Scene


def selftest_source(scene: Scene, lowered: Lowered, selftest: Selftest) -> str:
    """The text of selftest.c."""
    cases = [
        _rendered(scene, lowered.wanted[case.function], case, i) for i, case in enumerate(selftest.cases, 1)
    ]
    if selftest.prepared:
        program = preparation(lowered.model).whole
        cases += [_prepared(scene, program, case, i) for i, case in enumerate(selftest.prepared, len(cases) + 1)]
    text = render(
        "selftest.c.j2", name=scene.name, upper=scene.name.upper(), cases=cases,
        motions=[_motion(scene, lowered, motion) for motion in selftest.motions], literal=_literal(scene, 0.0),
        abs="fabs" if scene.real == "double" else "fabsf",
    )  # fmt: skip
    return laid_out_text(text)


def _literal(scene: Scene, value: float) -> str:
    text = re.sub(r"\.?0*p", "p", value.hex()) if value else "0.0"
    return f"{text}F" if scene.real == "float" else text


def _motion(scene: Scene, lowered: Lowered, motion: FlowCase) -> dict[str, Any]:
    """The motion with every number as a literal."""
    flow = ROWS[motion.function].flow
    assert flow is not None and flow.carries is not None
    return {
        "function": motion.function,
        "struct": flow.carries.name,
        "done": f"{flow.prefix}{DONE.name.upper()}",
        "has_event": flow.event is not None,
        "has_workspace": any(field.type == "workspace" for field in flow.carries.fields),
        "params": _fields(scene, lowered.params, motion.params),
        "start": [
            (name, len(values), _literals(scene, values)) for name, values in motion.inputs.items() if name in ("q", "v", "u")
        ],
        "forcing": "".join(f"{_literals(scene, motion.inputs[name])}, " for name in ("amplitude", "omega") if name in motion.inputs),
        "expected": {name: _literals(scene, values) for name, values in (motion.expected or {}).items()},
        "t_end": _literal(scene, motion.t_end),
        "tolerance": _literal(scene, rounded(scene, motion.tolerance)),
        "has_input": "u" in motion.inputs,
    }


def _prepared(scene: Scene, program: Program, case: Case, number: int) -> dict[str, Any]:
    """A case of the forward dynamics as a call of the two functions."""
    rendered = _rendered(scene, program, case, number)
    call = rendered["call"].replace("&parameters", "&prepared", 1)
    return rendered | {"function": "forward_dynamics_prepared", "call": call, "is_prepared": True}


def _literals(scene: Scene, values: Sequence[float]) -> str:
    return ", ".join(_literal(scene, value) for value in values)


def _fields(scene: Scene, arrays: Sequence[Array], values: Mapping[str, Sequence[float]]) -> list[str]:
    """Initialisers of the params struct."""
    return [
        f".{array.name} = {{{_literals(scene, values[array.name])}}}" if array.shape
        else f".{array.name} = {_literals(scene, values[array.name])}"
        for array in arrays
    ]  # fmt: skip


def _rendered(scene: Scene, program: Program, case: Case, number: int) -> dict[str, Any]:
    """The case with every number as a literal."""
    shapes = {array.name: array for array in (*program.inputs, *program.outputs)}
    calls = ["&parameters"] if program.params else []
    for array in program.inputs:
        calls.append(array.name if array.shape else _literal(scene, case.inputs[array.name][0]))
    calls += [array.name if array.shape else f"&{array.name}" for array in program.outputs]
    return {
        "number": number,
        "function": case.function,
        "params": _fields(scene, program.params, case.params),
        "inputs": [(n, shapes[n].size, _literals(scene, v)) for n, v in case.inputs.items() if shapes[n].shape],
        "outputs": [(array.name, array.size, bool(array.shape)) for array in program.outputs],
        "call": ", ".join(calls),
        "expected": [(n, len(v), _literals(scene, v), not (n in shapes and not shapes[n].shape)) for n, v in case.expected.items()],
        "direction": [
            (output, sum(len(case.direction[a]) for a in arguments),
             _literals(scene, [x for a in arguments for x in case.direction[a]]))
            for output, arguments in (columns(program, case).items() if case.direction else ())
        ],
        "rows": len(case.expected.get("slope", ())),
        "is_prepared": False,
    }  # fmt: skip
