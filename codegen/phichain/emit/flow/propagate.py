"""The Taylor flow of a scene as C: ``NAME_propagate``, its types, and what it is made of."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

from phichain.contract.flows import PROPAGATE
from phichain.contract.functions import ROWS
from phichain.emit.c.comment import Comments
from phichain.emit.c.function import c_function
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration, words
from phichain.emit.flow.columns import column_program, columns_at_once
from phichain.emit.flow.declared import arguments, passed_on
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.flow.header import HIGHEST, declarations, on_stack, padded, turns
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import total_operations, unroll
from phichain.ir.rounded import nearest
from phichain.lowering.field import vector_field
from phichain.lowering.lower import lower_function
from phichain.lowering.rates import fastest_rate, reach, scales_program
from phichain.mechanics import Model
from phichain.scene import Scene
from phichain.transform.jets import jets
from phichain.transform.lanes import FIRST, INVERSE_ORDER, LEFT, ORDER, RIGHT, SUMS, Jets

#: Tolerances below this are round-off.
EPSILON: Final = {"double": Fraction(1, 2**52), "float": Fraction(1, 2**23)}
#: Order 1 - share * log(local error). One half is the optimum where the sums cost most (Jorba & Zou 2005), as on long
#: chains; on short ones the linear sweep does, which favours fewer and longer steps.
ORDER_SHARE: Final = {"long": Fraction(1, 2), "short": Fraction(3, 5)}
#: Lanes from which on the sums cost most.
MANY_LANES: Final = 64
#: The local error aimed at, in units of the tolerance: over a chain's links errors add up, too.
MARGIN: Final = Fraction(1, 256)
CHAIN_MARGIN: Final = Fraction(1, 1024)
#: Of several blocks of columns the later ones accept steps longer than theirs by this, an error four times the goal.
SLACK: Final = Fraction(15, 16)
#: Difference of the slopes at a step's end that passes, in units of the local error aimed at. The term behind the last
#: enters the slope times the order: some ten of these are common.
ROOM: Final = 64
#: Relative differences below this may be rounding of the equations themselves.
NOISE: Final = {"double": Fraction(1, 2**26), "float": Fraction(1, 2**12)}
#: Above this many operations loops are kept: a few percent slower there, and compiled in half the time.
UNROLL_LIMIT: Final = 300
#: 2 pi to twice the precision.
TURN: Final = Fraction(6283185307179586476925286766559005768394338798750, 10**48)

__all__ = ["EPSILON", "HIGHEST", "MARGIN", "NOISE", "ROOM", "Tables", "TaylorFlow", "flow", "flow_program"]

Tables = dict[tuple[str, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class TaylorFlow(FlowText):
    """The Taylor flow of a scene as text, with the recurrences that were printed."""

    recurrences: Jets


@dataclass(frozen=True)
class _Part:
    """One static function as the template sees it."""

    comment: tuple[str, ...]
    symbol: str
    definition: str
    ignored: tuple[str, ...]
    lines: tuple[str, ...]


def flow_program(model: Model) -> Program:
    """The vector field in the form that the flow differentiates: straight-line code where it is short."""
    scene, loops = model.scene, vector_field(model)
    if scene.code == "loops" or (scene.code == "auto" and total_operations(loops) > UNROLL_LIMIT):
        return loops
    return unroll(loops)


@prints("propagate")
def flow(model: Model, known: Collection[str] = ()) -> TaylorFlow:
    """Print the Taylor flow of a scene.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before the flow and that it may call.
    """
    scene, made = model.scene, jets(flow_program(model))
    recurrences = replace(
        made, start=_named(made.start, "flow_start"), follow=_named(made.follow, "flow_follow")
    )
    programs = [recurrences.start, recurrences.follow]
    if scene.variational:
        programs.append(column_program(scene, recurrences))
    if scene.runtime:
        programs.append(scales_program(model))
    if "positions" not in known:
        programs.append(_named(lower_function(model, "positions", "loops"), "flow_positions"))
    tables: Tables = {}
    for program in programs:
        for key in program.tables.items():
            tables.setdefault(key, f"{scene.name}_flow_{key[0]}_{len(tables) + 1}")
    names = CNames(scene.name, scene.real, tables)
    bodies = [c_function(program, names, {}) for program in programs]
    comments = Comments(scene)
    parts = [_part(scene, program, body.lines, comments) for program, body in zip(programs, bodies, strict=True)]
    uses = frozenset({"math"}).union(*(body.uses for body in bodies))
    return TaylorFlow(
        declarations=laid_out_text(declarations(scene, recurrences)),
        definitions=laid_out_text(_definitions(model, recurrences, parts, names, "positions" in known)),
        includes=("math.h", "string.h"),
        uses=uses,
        recurrences=recurrences,
    )


def _named(program: Program, name: str) -> Program:
    return replace(program, name=name)


def _part(scene: Scene, program: Program, lines: tuple[str, ...], comments: Comments) -> _Part:
    declared = [f"const {scene.name}_params *p"] if program.params else []
    declared += [declaration(array, scene.name, False, True) for array in program.inputs]
    declared += [declaration(array, scene.name, True, True) for array in program.outputs]
    used = words("\n".join(lines))
    given = [*(["p"] if program.params else []), *(array.name for array in program.inputs)]
    ignored = tuple(name for name in given if name not in used)
    comment = comments.above(program.name, program.doc, lines)
    return _Part(comment, f"{scene.name}_{program.name}", ", ".join(declared), ignored, lines)


def _call(scene: Scene, program: Program, order: str) -> str:
    """The call of a sweep at an order, on the arrays of the workspace."""
    real = f"{scene.name}_real"
    row = {
        "q": f"work->x[{order}]", "v": f"work->x[{order}] + {scene.nq}", "u": "u",
        LEFT + FIRST: "work->left[0]", RIGHT + FIRST: "work->right[0]",
        SUMS: "work->sum", ORDER: f"({real}){order}", INVERSE_ORDER: f"1 / ({real}){order}",
        LEFT: f"work->left[{order}]", RIGHT: f"work->right[{order}]",
        "a": f"slope + {scene.nq}", "q_dot": "slope",
    }  # fmt: skip
    return _filled(scene, program, row)


def _column_call(scene: Scene, program: Program, width: int) -> str:
    """The call of the sweep for columns."""
    real, first = f"{scene.name}_real", scene.nq * width
    row = {
        "q": "work->d_x[n]", "v": f"work->d_x[n] + {first}", "u": "u",
        LEFT + FIRST: "work->left[0]", RIGHT + FIRST: "work->right[0]",
        SUMS: "work->d_sum[n % 4]", ORDER: f"({real})n", INVERSE_ORDER: f"n > 0 ? 1 / ({real})n : 0",
        LEFT: "work->d_left[n]", RIGHT: "work->d_right[n]", "a": f"slope + {first}", "q_dot": "slope",
    }  # fmt: skip
    return _filled(scene, program, row)


def _filled(scene: Scene, program: Program, row: Mapping[str, str]) -> str:
    given = [*(["p"] if program.params else [])]
    given += [row.get(array.name, f"work->{array.name}") for array in (*program.inputs, *program.outputs)]
    return f"{scene.name}_{program.name}({', '.join(given)})"


def _definitions(
    model: Model, recurrences: Jets, parts: list[_Part], names: CNames, positions_known: bool
) -> str:
    scene = model.scene
    has_params, has_input = bool(scene.runtime), scene.nu > 0
    parameter = f"const {scene.name}_params *p, " if has_params else ""
    given = f"const {scene.name}_real u[{scene.nu}], " if has_input else ""
    tables = [
        (table, len(values), ", ".join(names.number(value).text for value in values))
        for (_, values), table in names.tables.items()
    ]
    size = "long" if recurrences.products > MANY_LANES else "short"
    high = Fraction(nearest(scene.real, TURN))
    return render(
        "flow.c.j2", name=scene.name, doc=ROWS["propagate"].doc, upper=scene.name.upper(), real=f"{scene.name}_real", nq=scene.nq, nv=scene.nv,
        highest=HIGHEST[scene.real], products=padded(recurrences.products), tables=tables, functions=parts,
        parameter=parameter, pass_parameter="p, " if has_params else "", context=parameter + given,
        pass_context=("p, " if has_params else "") + ("u, " if has_input else ""),
        start_call=_call(scene, recurrences.start, "0"), follow_call=_call(scene, recurrences.follow, "n"),
        slopes=_slopes(scene, 1, "work->x[n]"), cart=(1 if scene.is_planar else 2) if scene.has_cart else 0,
        scales=scales_literals(scene, names), masses=scene.links, axes=2 if scene.is_planar else 3,
        positions=f"{scene.name}_{'positions' if positions_known else 'flow_positions'}",
        positions_parameter="p, " if has_params and positions_read_parameters(model) else "",
        margin=names.number(CHAIN_MARGIN if size == "long" else MARGIN).text, huge="700" if scene.real == "double" else "80", room=ROOM,
        noise=names.number(NOISE[scene.real]).text, planar=scene.is_planar,
        order_share=names.number(ORDER_SHARE[size]).text,
        epsilon=names.number(EPSILON[scene.real]).text, definition=", ".join(arguments(PROPAGATE, scene, definition=True)),
        pass_all=passed_on(PROPAGATE, scene), on_stack=on_stack(scene, recurrences),
        turns=turns(scene), turn_high=names.number(high).text, turn_low=names.number(TURN - high).text,
        half=names.number(Fraction(1, 2)).text, **_column_names(scene, recurrences, parts, names), **libm_names(names),
    )  # fmt: skip


def _column_names(scene: Scene, recurrences: Jets, parts: list[_Part], names: CNames) -> dict[str, object]:
    """What the template wants to know of the variational equations."""
    if not scene.variational:
        return {"columns": 0}
    width = columns_at_once(scene, recurrences)
    return {
        "columns": width, "lanes": max(recurrences.products, 1), "slack": names.number(SLACK).text,
        "column_call": _column_call(scene, column_program(scene, recurrences), width),
        "column_slopes": _slopes(scene, width, "work->d_x[n]"),
    }  # fmt: skip


def _slopes(scene: Scene, width: int, row: str) -> list[tuple[int, int, str]]:
    """Which entries of the next coefficient come from where."""
    of_q = f"{row}[{scene.nq * width} + i]" if scene.is_planar else "slope[i]"
    first, last = scene.nq * width, (scene.nq + scene.nv) * width
    return [(0, first, of_q), (first, last, "slope[i]")]


def scales_literals(scene: Scene, names: CNames) -> tuple[str, str] | None:
    """Fastest linear rate and length of the chain as literals; None where they are computed."""
    rate, length = fastest_rate(scene), reach(scene)
    if rate is None or length is None:
        return None
    return names.number(rate).text, names.number(length).text


def positions_read_parameters(model: Model) -> bool:
    """Whether positions lean on runtime parameters."""
    return bool(lower_function(model, "positions", "loops").params)


def libm_names(names: CNames) -> Mapping[str, str]:
    """The C library's functions as the templates call them, for the scene's type."""
    functions = {"abs": "fabs", **{name: name for name in ("exp", "log", "ceil", "floor", "fma")}}
    return {key: names.libm(function) for key, function in functions.items()}
