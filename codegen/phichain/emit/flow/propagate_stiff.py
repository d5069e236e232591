"""The implicit flow of a scene as C: ``NAME_propagate_stiff``, its types, and what it is made of."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from fractions import Fraction
from typing import Final

from phichain.contract.flows import PROPAGATE_STIFF, STIFF
from phichain.contract.functions import ROWS
from phichain.contract.rodas5p import EMBEDDED_ORDER
from phichain.emit.c.comment import Comments
from phichain.emit.c.function import c_function
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.sheet import work_field
from phichain.emit.flow.binary import binary_numbers, binary_words
from phichain.emit.flow.declared import arguments, documented, outcome_lines, passed_on, struct_lines
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.flow.instance import Called, Part, c_names, on_numbers, static_function, table_rows
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.lowering.lower import lower_function
from phichain.lowering.planar.joint_state import (
    carries_joints,
    from_joints,
    joint_scene,
    to_joint_inputs,
    to_joints,
)
from phichain.lowering.steps.rosenbrock import increment_of
from phichain.lowering.stiff_scales import scales_program
from phichain.mechanics import Model, derive
from phichain.scene import Scene

#: Tolerances below this are round-off.
LEAST_TOLERANCE: Final = {"double": Fraction(1, 2**46), "float": Fraction(1, 2**17)}
#: The local error aimed at, in units of the tolerance: errors add up over the steps.
MARGIN: Final = Fraction(1, 16)
#: What the step size is multiplied by, at least and at most, and the share of it that is taken.
LEAST_FACTOR: Final = Fraction(1, 10)
LARGEST_FACTOR: Final = Fraction(5)
SAFETY: Final = Fraction(9, 10)
#: Exponents of the error and of the one before it (Gustafsson's PI control; Hairer & Wanner, Solving ODEs II, IV.2).
PROPORTIONAL: Final = Fraction(7, 10) / (EMBEDDED_ORDER + 1)
INTEGRAL: Final = Fraction(4, 10) / (EMBEDDED_ORDER + 1)


@prints("propagate_stiff")
def stiff(model: Model, known: Collection[str] = ()) -> FlowText:
    """Print the implicit flow of a scene.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before the flow and that it may call.
    """
    scene, is_carried = model.scene, carries_joints(model.scene)
    if is_carried:
        # Its own dynamics, in joint angles: what NAME.c has is in the scene's.
        inner, known = derive(joint_scene(scene)), ()
    else:
        inner = model
    step = lower_function(inner, increment_of(inner.scene))
    symbols = {
        name: f"{scene.name}_{name}" if name in known else f"{scene.name}_stiff_{name}"
        for name in step.callees
    }
    programs = {symbols[name]: callee for name, callee in step.callees.items() if name not in known}
    programs |= {f"{scene.name}_stiff_step": step, f"{scene.name}_stiff_scales": scales_program(model)}
    if is_carried:
        programs |= {f"{scene.name}_{made.name}": made for made in _conversions(scene)}
    names = c_names(scene, f"{scene.name}_stiff", programs.values())
    working = _working(programs.values())
    bodies = {symbol: c_function(program, names, symbols, working) for symbol, program in programs.items()}
    called = {symbol: Called(symbol, program, takes_params=bool(program.params)) for symbol, program in programs.items()}
    given = [f"{scene.name}_stiff_workspace *work"]
    parts = [
        static_function(
            scene, Comments(scene), called[symbol],
            on_numbers(scene, programs[symbol]) + (given if programs[symbol].name in working else []), body.lines,
        )
        for symbol, body in bodies.items()
    ]  # fmt: skip
    arrays = _arrays(scene, programs.values())
    return FlowText(
        declarations=laid_out_text(_declarations(scene, arrays)),
        definitions=laid_out_text(_definitions(scene, parts, names, step.name in working)),
        includes=("math.h", "stdint.h", "string.h"),
        uses=frozenset({"math"}).union(*(body.uses for body in bodies.values())),
    )


def _working(programs: Iterable[Program]) -> frozenset[str]:
    """The Programs that have arrays of their own, or call one that has: the workspace is theirs."""
    found: frozenset[str] = frozenset()
    for program in programs:  # callees come first
        if any(array.size > 1 for array in program.work) or found & set(program.callees):
            found |= {program.name}
    return found


def _arrays(scene: Scene, programs: Iterable[Program]) -> list[tuple[str, int]]:
    """Names and sizes of the arrays of a workspace: what a step leaves, and those of the Programs."""
    own = [(name, 2 * scene.nq) for name in ("moved", "error", "part", "unused")]
    return own + [(work_field(one, array), array.size) for one in programs for array in one.work if array.size > 1]


def _conversions(scene: Scene) -> list[Program]:
    """What leads into joint terms and out of them again."""
    return [to_joints(scene), from_joints(scene), *([to_joint_inputs(scene)] if scene.actuated_joints else [])]


def _definitions(scene: Scene, parts: list[Part], names: CNames, works: bool) -> str:
    number, is_carried = names.number, carries_joints(scene)
    words, numbers = binary_words(scene.real), binary_numbers(scene.real)
    joint_inputs = joint_scene(scene).nu if is_carried and scene.actuated_joints else 0
    rest = "flow->lost, " if increment_of(scene) == "bent_increment" else ""
    return render(
        "flow/stiff.c.j2", name=scene.name, doc=ROWS["propagate_stiff"].doc, upper=scene.name.upper(), real=f"{scene.name}_real", size=scene.nq,
        tables=table_rows(names), functions=parts, cart=(1 if scene.is_planar else 2) if scene.has_cart else 0,
        parameter="p, " if scene.runtime else "", work=", work" if works else "",
        carried=is_carried, inputs=joint_inputs,
        **dict(zip(("q", "v", "lost"), ("joint_q", "joint_v", "lost") if is_carried else ("q", "v", "flow->lost"), strict=True)),
        given=rest + (("joint_u, " if joint_inputs else "u, ") if scene.nu else ""), definition=", ".join(arguments(PROPAGATE_STIFF, scene, definition=True)), passed=passed_on(PROPAGATE_STIFF, scene),
        least=number(LEAST_TOLERANCE[scene.real]).text, margin=number(MARGIN).text,
        smallest=number(LEAST_FACTOR).text, largest=number(LARGEST_FACTOR).text, safety=number(SAFETY).text,
        proportional=number(PROPORTIONAL).text, integral=number(INTEGRAL).text,
        one_over_order=number(Fraction(1, EMBEDDED_ORDER + 1)).text,
        floor="1e-8" if scene.real == "double" else "1e-4F", tiny="1e-290" if scene.real == "double" else "1e-30F",
        abs=names.libm("fabs"), word=words["PHI_WORD"], binary=words,
        count_one=number(numbers["PHI_COUNT_ONE"]).text, rounder=number(numbers["PHI_ROUNDER"]).text,
    )  # fmt: skip


def _declarations(scene: Scene, arrays: list[tuple[str, int]]) -> str:
    number = 8 if scene.real == "double" else 4
    return render(
        "flow/stiff.h.j2", name=scene.name, upper=scene.name.upper(), workspace=arrays, workspace_bytes=number * sum(size for _, size in arrays), doc=ROWS["propagate_stiff"].doc, outcomes=outcome_lines(PROPAGATE_STIFF, scene), stiff=struct_lines(STIFF, scene),
        returns=PROPAGATE_STIFF.returns, prototype=", ".join(arguments(PROPAGATE_STIFF, scene, definition=False)),
        arguments=documented(PROPAGATE_STIFF, scene),
    )  # fmt: skip
