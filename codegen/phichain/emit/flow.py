"""The Taylor flow of a scene as C: ``NAME_propagate``, its types, and what it is made of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

from phichain.emit.c_function import CNames, c_function, declaration, words
from phichain.emit.render import render
from phichain.program.field import vector_field
from phichain.program.jets import HELD, INVERSE_ORDER, LEFT, ORDER, RIGHT, SQUARE, SQUARE_SUMS, SUMS, Jets, jets
from phichain.program.nodes import Array, Program
from phichain.program.passes import total_operations, unroll
from phichain.program.rates import fastest_rate
from phichain.scene import Scene

#: Highest order of the Taylor series, for which the stack has room.
HIGHEST: Final = {"double": 28, "float": 14}
#: Order 1 - share * log(tolerance); one half is the optimum where sums dominate, more where the linear sweep does.
ORDER_SHARE: Final = Fraction(1, 2)
#: Steps are this much shorter than the last two terms ask.
SAFETY: Final = Fraction(1)
#: Longest step in units of what resolves the fastest linear mode.
CAP: Final = Fraction(5, 4)
#: Above this many operations per order loops are kept.
UNROLL_LIMIT: Final = 400
_LANES: Final = 8


@dataclass(frozen=True)
class Flow:
    """The Taylor flow of a scene as text.

    Attributes:
        declarations: types and prototype, for NAME.h after its typedefs.
        definitions: for NAME.c after the kernels and before or after the other functions.
        uses: kernels that the definitions lean on ("sincos", "math").
        tables: constants at file scope, by (name, values); the definitions read them under these names.
        recurrences: what was printed.
    """

    declarations: str
    definitions: str
    uses: frozenset[str]
    tables: dict[tuple[str, tuple[Fraction, ...]], str]
    recurrences: Jets


@dataclass(frozen=True)
class _Part:
    """One of the two sweeps as the template sees it."""

    doc: str
    symbol: str
    definition: str
    ignored: tuple[str, ...]
    lines: tuple[str, ...]


def flow_program(scene: Scene) -> Program:
    """The scene's vector field in the form the flow differentiates: straight-line code where it is short."""
    loops = vector_field(scene)
    if scene.code == "loops" or (scene.code == "auto" and total_operations(loops) > UNROLL_LIMIT):
        return loops
    return unroll(loops)


def flow(scene: Scene) -> Flow:
    """Print the Taylor flow of a scene."""
    recurrences = jets(flow_program(scene))
    tables = {
        (name, values): f"flow_{name}_table"
        for program in (recurrences.start, recurrences.follow)
        for name, values in program.tables.items()
    }
    names = CNames(scene.name, scene.real, tables)
    bodies = [c_function(program, names, {}) for program in (recurrences.start, recurrences.follow)]
    docs = ("Order 0: the derivative, and the first coefficients of the factors.", "Order n from the orders below.")
    parts = [
        _part(scene, program, names, body.lines, doc)
        for program, body, doc in zip((recurrences.start, recurrences.follow), bodies, docs, strict=True)
    ]
    uses = frozenset({"math"}).union(*(body.uses for body in bodies))
    return Flow(_declarations(scene), _definitions(scene, recurrences, parts, names), uses, tables, recurrences)


def _part(scene: Scene, program: Program, names: CNames, lines: tuple[str, ...], doc: str) -> _Part:
    declared = [f"const {scene.name}_params *p"] if program.params else []
    declared += [declaration(array, scene.name, False, True) for array in program.inputs]
    declared += [declaration(array, scene.name, True, True) for array in program.outputs]
    used = words("\n".join(lines))
    arguments = [*(["p"] if program.params else []), *(array.name for array in program.inputs)]
    ignored = tuple(name for name in arguments if name not in used)
    return _Part(doc, _symbol(scene, program), ", ".join(declared), ignored, lines)


def _symbol(scene: Scene, program: Program) -> str:
    return f"{scene.name}_flow_{'start' if program.name.endswith('_start') else 'follow'}"


def _call(scene: Scene, program: Program, order: str) -> str:
    """The call of a sweep at an order, on the arrays of the jets."""
    row = {
        "q": f"jet->x[{order}]", "v": f"jet->x[{order}] + {scene.nq}", "u": "u",
        f"{LEFT}_0": "jet->left[0]", f"{RIGHT}_0": "jet->right[0]", f"{SQUARE}_0": "jet->square[0]",
        SUMS: "jet->sum", SQUARE_SUMS: "jet->square_sum", ORDER: f"({scene.name}_real){order}",
        INVERSE_ORDER: f"1 / ({scene.name}_real){order}", LEFT: f"jet->left[{order}]",
        RIGHT: f"jet->right[{order}]", SQUARE: f"jet->square[{order}]",
        "a": f"slope + {scene.nq}", "q_dot": "slope",
    }  # fmt: skip
    arguments = [*(["p"] if program.params else [])]
    arguments += [row.get(array.name, f"jet->{array.name}") for array in (*program.inputs, *program.outputs)]
    return f"{_symbol(scene, program)}({', '.join(arguments)})"


def _padded(count: int) -> int:
    """Whole vectors, so that no lane is left to scalar code."""
    return -(-count // _LANES) * _LANES


def _definitions(scene: Scene, recurrences: Jets, parts: list[_Part], names: CNames) -> str:
    has_params, has_input = bool(recurrences.start.params), scene.nu > 0
    parameter = f"const {scene.name}_params *p, " if has_params else ""
    given = f"const {scene.name}_real u[{scene.nu}], " if has_input else ""
    held = [
        (array.name, array.size) for array in recurrences.start.outputs
        if array.name not in (LEFT, RIGHT, SQUARE, "a", "q_dot")
    ]  # fmt: skip
    slopes = [(scene.nq, scene.nq + scene.nv, "slope[i]")]
    slopes.insert(0, (0, scene.nq, f"x[{scene.nq} + i]" if scene.is_planar else "slope[i]"))
    real, numbers = f"{scene.name}_real", flow_scales(scene)
    scales = None if numbers is None else [names.number(value).text for value in numbers]
    return render(
        "flow.c.j2", name=scene.name, upper=scene.name.upper(), real=real, nq=scene.nq, nv=scene.nv,
        highest=HIGHEST[scene.real], products=_padded(recurrences.products), squares=_padded(recurrences.squares),
        held=held, functions=parts, parameter=parameter, pass_parameter="p, " if has_params else "",
        context=parameter + given, pass_context=("p, " if has_params else "") + ("u, " if has_input else ""),
        start_call=_call(scene, recurrences.start, "0"), follow_call=_call(scene, recurrences.follow, "n"),
        slopes=slopes, cart=(1 if scene.is_planar else 2) if scene.has_cart else 0, scales=scales,
        safety=names.number(SAFETY).text, cap=names.number(CAP).text, order_share=names.number(ORDER_SHARE).text,
        epsilon=names.number(EPSILON[scene.real]).text, positions=positions, masses=scene.links,
        axes=2 if scene.is_planar else 3, definition=", ".join(_arguments(scene, True)), max=names.libm("fmax"),
        min=names.libm("fmin"), abs=names.libm("fabs"), exp=names.libm("exp"), log=names.libm("log"),
        ceil=names.libm("ceil"), lgamma=names.libm("lgamma"),
    )  # fmt: skip


def _declarations(scene: Scene) -> str:
    return render(
        "flow.h.j2", name=scene.name, upper=scene.name.upper(), prototype=", ".join(_arguments(scene, False)),
        arguments=_documented(scene), stack=_stack(scene),
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
