"""The Taylor flow of a scene as C: ``NAME_propagate``, its types, and what it is made of."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

from phichain.emit.c_function import CNames, c_function, declaration, words
from phichain.emit.c_layout import laid_out
from phichain.emit.render import render
from phichain.program.field import vector_field
from phichain.program.jets import jets
from phichain.program.lanes import FIRST, INVERSE_ORDER, LEFT, ORDER, RIGHT, SUMS, Jets
from phichain.program.lower import lower_function
from phichain.program.nodes import Program
from phichain.program.passes import total_operations, unroll
from phichain.program.rates import fastest_rate, reach, scales_program
from phichain.scene import Scene

#: Highest order of the Taylor series, for which the stack has room.
HIGHEST: Final = {"double": 28, "float": 14}
#: Tolerances below this are round-off.
EPSILON: Final = {"double": Fraction(1, 2**52), "float": Fraction(1, 2**23)}
#: Order 1 - share * log(local error). One half is the optimum where the sums cost most (Jorba & Zou 2005), as on long
#: chains; on short ones the linear sweep does, which favours fewer and longer steps.
ORDER_SHARE: Final = {"long": Fraction(1, 2), "short": Fraction(3, 5)}
#: Lanes from which on the sums cost most.
MANY_LANES: Final = 64
#: The local error aimed at, in units of the tolerance.
MARGIN: Final = Fraction(1, 256)
#: Longest step in units of what resolves the fastest linear mode.
CAP: Final = Fraction(5, 4)
#: Above this many operations loops are kept.
UNROLL_LIMIT: Final = 500
#: Lanes come in whole vectors, so that no lane is left to scalar code.
LANES: Final = 8

Tables = dict[tuple[str, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class Flow:
    """The Taylor flow of a scene as text.

    Attributes:
        declarations: types and prototype, for NAME.h after its own types.
        definitions: for NAME.c, after the kernels and the functions that were named as known.
        includes: standard headers that the definitions want.
        uses: kernels that the definitions lean on: "sincos", "math".
        recurrences: what was printed.
    """

    declarations: str
    definitions: str
    includes: tuple[str, ...]
    uses: frozenset[str]
    recurrences: Jets


@dataclass(frozen=True)
class _Part:
    """One static function as the template sees it."""

    doc: str
    symbol: str
    definition: str
    ignored: tuple[str, ...]
    lines: tuple[str, ...]


def flow_program(scene: Scene) -> Program:
    """The vector field in the form that the flow differentiates: straight-line code where it is short."""
    loops = vector_field(scene)
    if scene.code == "loops" or (scene.code == "auto" and total_operations(loops) > UNROLL_LIMIT):
        return loops
    return unroll(loops)


def flow(scene: Scene, known: Collection[str] = ()) -> Flow:
    """Print the Taylor flow of a scene.

    Args:
        scene: the scene.
        known: functions of NAME.c that stand before the flow and that it may call.
    """
    made = jets(flow_program(scene))
    recurrences = replace(made, start=_named(made.start, "flow_start"), follow=_named(made.follow, "flow_follow"))
    programs = [recurrences.start, recurrences.follow]
    if scene.runtime:
        programs.append(scales_program(scene))
    if "positions" not in known:
        programs.append(_named(lower_function(scene, "positions", "loops"), "flow_positions"))
    tables: Tables = {}
    for program in programs:
        for key in program.tables.items():
            tables.setdefault(key, f"{scene.name}_flow_{key[0]}_{len(tables) + 1}")
    names = CNames(scene.name, scene.real, tables)
    bodies = [c_function(program, names, {}) for program in programs]
    parts = [_part(scene, program, body.lines) for program, body in zip(programs, bodies, strict=True)]
    uses = frozenset({"math"}).union(*(body.uses for body in bodies))
    return Flow(
        declarations=_broken(_declarations(scene)),
        definitions=_broken(_definitions(scene, recurrences, parts, names, "positions" in known)),
        includes=("math.h", "string.h"),
        uses=uses,
        recurrences=recurrences,
    )


def _broken(text: str) -> str:
    """The text without lines that are too long."""
    return "\n".join(line for long in text.split("\n") for line in laid_out(long))


def _named(program: Program, name: str) -> Program:
    return replace(program, name=name)


def _part(scene: Scene, program: Program, lines: tuple[str, ...]) -> _Part:
    declared = [f"const {scene.name}_params *p"] if program.params else []
    declared += [declaration(array, scene.name, False, True) for array in program.inputs]
    declared += [declaration(array, scene.name, True, True) for array in program.outputs]
    used = words("\n".join(lines))
    arguments = [*(["p"] if program.params else []), *(array.name for array in program.inputs)]
    ignored = tuple(name for name in arguments if name not in used)
    return _Part(program.doc, f"{scene.name}_{program.name}", ", ".join(declared), ignored, lines)


def _call(scene: Scene, program: Program, order: str) -> str:
    """The call of a sweep at an order, on the arrays of the jets."""
    row = {
        "q": f"jet->x[{order}]", "v": f"jet->x[{order}] + {scene.nq}", "u": "u",
        LEFT + FIRST: "jet->left[0]", RIGHT + FIRST: "jet->right[0]",
        SUMS: "jet->sum", ORDER: f"({scene.name}_real){order}", INVERSE_ORDER: f"1 / ({scene.name}_real){order}",
        LEFT: f"jet->left[{order}]", RIGHT: f"jet->right[{order}]",
        "a": f"slope + {scene.nq}", "q_dot": "slope",
    }  # fmt: skip
    arguments = [*(["p"] if program.params else [])]
    arguments += [row.get(array.name, f"jet->{array.name}") for array in (*program.inputs, *program.outputs)]
    return f"{scene.name}_{program.name}({', '.join(arguments)})"


def _definitions(
    scene: Scene, recurrences: Jets, parts: list[_Part], names: CNames, positions_known: bool
) -> str:
    has_params, has_input = bool(scene.runtime), scene.nu > 0
    parameter = f"const {scene.name}_params *p, " if has_params else ""
    given = f"const {scene.name}_real u[{scene.nu}], " if has_input else ""
    of_q = f"jet->x[n][{scene.nq} + i]" if scene.is_planar else "slope[i]"
    tables = [
        (table, len(values), ", ".join(names.number(value).text for value in values))
        for (_, values), table in names.tables.items()
    ]
    return render(
        "flow.c.j2", name=scene.name, upper=scene.name.upper(), real=f"{scene.name}_real", nq=scene.nq, nv=scene.nv,
        highest=HIGHEST[scene.real], products=_padded(recurrences.products),
        held=_held(recurrences), tables=tables, functions=parts, parameter=parameter,
        pass_parameter="p, " if has_params else "", context=parameter + given,
        pass_context=("p, " if has_params else "") + ("u, " if has_input else ""),
        start_call=_call(scene, recurrences.start, "0"), follow_call=_call(scene, recurrences.follow, "n"),
        slopes=[(0, scene.nq, of_q), (scene.nq, scene.nq + scene.nv, "slope[i]")],
        cart=(1 if scene.is_planar else 2) if scene.has_cart else 0, scales=_scales(scene, names),
        positions=f"{scene.name}_{'positions' if positions_known else 'flow_positions'}", masses=scene.links,
        positions_parameter="p, " if has_params and _reads_parameters(scene) else "",
        axes=2 if scene.is_planar else 3, margin=names.number(MARGIN).text, huge="700" if scene.real == "double" else "80", cap=names.number(CAP).text,
        order_share=names.number(ORDER_SHARE["long" if recurrences.products > MANY_LANES else "short"]).text, epsilon=names.number(EPSILON[scene.real]).text,
        definition=", ".join(_arguments(scene, True)), **_libm(names),
    )  # fmt: skip


def _padded(count: int) -> int:
    return -(-count // LANES) * LANES


def _held(recurrences: Jets) -> list[tuple[str, int]]:
    """What `start` computes once for all orders."""
    rows = {LEFT, RIGHT, "a", "q_dot"}
    return [(array.name, array.size) for array in recurrences.start.outputs if array.name not in rows]


def _scales(scene: Scene, names: CNames) -> tuple[str, str] | None:
    """Fastest linear rate and length of the chain as literals; None where they are computed."""
    rate, length = fastest_rate(scene), reach(scene)
    if rate is None or length is None:
        return None
    return names.number(rate).text, names.number(length).text


def _reads_parameters(scene: Scene) -> bool:
    return bool(lower_function(scene, "positions", "loops").params)


def _libm(names: CNames) -> Mapping[str, str]:
    functions = {"abs": "fabs", **{name: name for name in ("exp", "log", "ceil")}}
    return {key: names.libm(function) for key, function in functions.items()}


def _declarations(scene: Scene) -> str:
    return render(
        "flow.h.j2", name=scene.name, upper=scene.name.upper(), prototype=", ".join(_arguments(scene, False)),
        arguments=_documented(scene), size=scene.nq + scene.nv,
    )  # fmt: skip


def _arguments(scene: Scene, definition: bool) -> list[str]:
    real, restrict = f"{scene.name}_real", "restrict " if definition else ""
    return [
        *([f"const {scene.name}_params *p"] if scene.runtime else []),
        f"{scene.name}_flow *flow",
        f"{real} t_end",
        "unsigned long max_steps",
        *([f"const {real} u[{scene.nu}]"] if scene.nu else []),
        f"{real} q[{restrict}{scene.nq}]",
        f"{real} v[{restrict}{scene.nv}]",
        f"const {scene.name}_event *event",
        "unsigned long count",
        f"const {real} *times",
        f"{real} *q_out",
        f"{real} *v_out",
    ]


def _documented(scene: Scene) -> list[tuple[str, str, str]]:
    rows = [
        ("p", "in", "parameters") if scene.runtime else None,
        ("flow", "in, out", "start time and tolerance; what was done"),
        ("t_end", "in", "final time, s"),
        ("max_steps", "in", "step budget; called again, it goes on from where it stopped"),
        ("u", "in", "inputs, held constant") if scene.nu else None,
        ("q, v", "in, out", "state"),
        ("event", "in", "where to stop, or NULL"),
        ("count", "in", "number of times"),
        ("times", "in", "times on the way, in its order, at which the state is wanted, or NULL"),
        ("q_out", "out", f"configurations there, count x {scene.nq}, or NULL"),
        ("v_out", "out", f"rates there, count x {scene.nv}, or NULL"),
    ]
    return [row for row in rows if row is not None]
