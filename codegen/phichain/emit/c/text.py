"""Programs -> NAME.h and NAME.c."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from textwrap import wrap

from phichain.emit import bessel
from phichain.emit.arguments import meaning, state_meanings
from phichain.emit.c import sincos as trig
from phichain.emit.c.function import CFunction, CNames, c_function
from phichain.emit.c.layout import WIDTH, aligned, laid_out, laid_out_text
from phichain.emit.c.parts import declaration, words
from phichain.emit.flow.flows import flows
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import total_operations
from phichain.lowering.lower import Lowered
from phichain.scene import Scene

Tables = dict[tuple[str, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class _Function:
    """One function as the templates see it: its text, and what a caller should know."""

    name: str
    symbol: str
    is_static: bool
    doc: str
    prototype: str
    definition: str
    arguments: tuple[str, ...]
    operations: int
    form: str
    cost: str
    lines: tuple[str, ...]
    uses: frozenset[str]
    ignored: tuple[str, ...]


def header(scene: Scene, lowered: Lowered, tolerances: Mapping[str, str]) -> str:
    """NAME.h: sizes, the params struct, and one documented prototype a wanted function."""
    upper = scene.name.upper()
    declared = [flow.text.declarations for flow in flows(scene, lowered)]
    return render(
        "header.h.j2", name=scene.name, upper=upper, real=scene.real, sketch=_sketch(scene), digest=scene.digest,
        sizes=_sizes(scene), state=_explained(list(state_meanings(scene).items())), params=_params(lowered),
        functions=_functions(scene, lowered), flows=declared,
        sizes_come_as_size_t=any("size_t" in text for text in declared),
        tolerances=aligned((f"#define {upper}_{name.upper()}_TOLERANCE", value) for name, value in tolerances.items()),
    )  # fmt: skip


def source(scene: Scene, lowered: Lowered) -> str:
    """NAME.c: kernels, tables and functions, each only where something needs it."""
    functions, made = _functions(scene, lowered), [flow.text for flow in flows(scene, lowered)]
    uses = set().union(*(function.uses for function in functions), *(flow.uses for flow in made))
    return render(
        "source.c.j2", name=scene.name, functions=functions, tables=_table_lines(scene, lowered),
        includes=sorted(set(_includes(uses)).union(*(flow.includes for flow in made))), sincos=sincos_kernel(scene) if "sincos" in uses else "",
        bessel=bessel_kernel(scene) if "bessel" in uses else "",
        flows=[flow.definitions for flow in made],
    )  # fmt: skip


def sincos_kernel(scene: Scene) -> str:
    """The vectorisable sine-cosine kernel in the scene's type."""
    return laid_out_text(render("sincos.c.j2", name=scene.name, real=scene.real, **trig.coefficients(scene.real)))


def bessel_kernel(scene: Scene) -> str:
    """The Bessel functions J_0 to J_4 in the scene's type."""
    return laid_out_text(render("bessel.c.j2", name=scene.name, real=scene.real, **bessel.coefficients(scene.real)))


def _includes(uses: Iterable[str]) -> list[str]:
    uses = set(uses)
    wanted = set(trig.HEADERS) if "sincos" in uses else set()
    return sorted(wanted | ({"math.h"} if uses & {"math", "bessel"} else set()))


def _programs(lowered: Lowered) -> dict[str, Program]:
    """Helpers first, so that every function is known before it is called."""
    return {**lowered.helpers, **lowered.wanted}


def _tables(scene: Scene, lowered: Lowered) -> Tables:
    """One file-scope name for each distinct table."""
    tables: Tables = {}
    for program in _programs(lowered).values():
        for name, values in program.tables.items():
            if (name, values) not in tables:
                number = 1 + sum(name == other for other, _ in tables)
                tables[name, values] = f"{scene.name}_{name}_table{number if number > 1 else ''}"
    return tables


def _table_lines(scene: Scene, lowered: Lowered) -> list[str]:
    names = _names(scene, lowered)
    lines = []
    for (_, values), table in names.tables.items():
        numbers = ", ".join(names.number(value).text for value in values)
        lines += laid_out(f"static const {scene.real} {table}[{len(values)}] = {{{numbers}}};")
    return lines


def _names(scene: Scene, lowered: Lowered) -> CNames:
    return CNames(scene.name, scene.real, _tables(scene, lowered))


def _bodies(scene: Scene, lowered: Lowered) -> dict[str, CFunction]:
    names, programs = _names(scene, lowered), _programs(lowered)
    symbols = {name: f"{scene.name}_{name}" for name in programs}
    return {name: c_function(program, names, symbols) for name, program in programs.items()}


def _functions(scene: Scene, lowered: Lowered) -> list[_Function]:
    bodies = _bodies(scene, lowered)
    return [
        _function(scene, program, bodies[name], name in lowered.helpers)
        for name, program in _programs(lowered).items()
    ]


def _function(scene: Scene, program: Program, body: CFunction, is_static: bool) -> _Function:
    symbol, ignored = f"{scene.name}_{program.name}", _ignored(program, body)
    head = f"{'static ' if is_static else ''}void {symbol}("
    definition = "\n".join(laid_out(f"{head}{', '.join(_declared(scene, program, definition=True))})"))
    return _Function(
        name=program.name,
        symbol=symbol,
        is_static=is_static,
        doc=program.doc,
        prototype="\n".join(laid_out(f"void {symbol}({', '.join(_declared(scene, program, definition=False))});")),
        definition=definition.removeprefix(head).removesuffix(")"),
        arguments=_arguments(scene, program, ignored),
        operations=total_operations(program),
        form="straight-line code" if program.is_straight_line else "loops",
        cost=_cost(scene, program),
        lines=body.lines,
        uses=body.uses,
        ignored=ignored,
    )


def _ignored(program: Program, body: CFunction) -> tuple[str, ...]:
    """Arguments of the contract that this scene's function has no use for."""
    names = [*(["p"] if program.params else []), *(array.name for array in program.inputs)]
    used = words("\n".join(body.lines))
    return tuple(name for name in names if name not in used)


def _declared(scene: Scene, program: Program, definition: bool) -> list[str]:
    declared = [f"const {scene.name}_params *p"] if program.params else []
    declared += [declaration(array, scene.name, False, definition) for array in program.inputs]
    return declared + [declaration(array, scene.name, True, definition) for array in program.outputs]


def _arguments(scene: Scene, program: Program, ignored: tuple[str, ...]) -> tuple[str, ...]:
    """What the header says about every argument."""
    explained = [("p", "in", "runtime parameters")] if program.params else []
    explained += [(array.name, "in", meaning(scene, program.name, array)) for array in program.inputs]
    explained += [(array.name, "out", meaning(scene, program.name, array)) for array in program.outputs]
    width = max(len(name) for name, _, _ in explained)
    rows = [
        (f"{name:{width}}  {direction:3}", text + (" (without influence)" if name in ignored else ""))
        for name, direction, text in explained
    ]
    return tuple(_explained(rows))


def _explained(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Names and what they mean, as lines of a comment."""
    width = max(len(name) for name, _ in rows)
    lines: list[str] = []
    for name, text in rows:
        head = f"{name:{width}}  "
        lines += wrap(text, WIDTH - 5, initial_indent=head, subsequent_indent=" " * len(head), break_on_hyphens=False)
    return lines


def _cost(scene: Scene, program: Program) -> str:
    operations, stack = total_operations(program), _work_bytes(scene, program)
    if program.is_straight_line:
        return f"{operations} operations, straight-line code."
    return f"{operations} operations in loops{f', {stack} bytes of arrays on the stack' if stack else ''}."


def _work_bytes(scene: Scene, program: Program) -> int:
    """Bytes of work arrays while the function or one that it calls runs."""
    own = sum(array.size for array in program.work) * (8 if scene.real == "double" else 4)
    return own + max((_work_bytes(scene, callee) for callee in program.callees.values()), default=0)


def _sizes(scene: Scene) -> list[str]:
    upper = scene.name.upper()
    sizes = [
        ("LINKS", scene.links, "number of links"),
        ("NQ", scene.nq, "entries of q: " + _listed(scene.q_names)),
        ("NV", scene.nv, "entries of v and a: " + _listed(scene.v_names)),
        *([("NU", scene.nu, "entries of u: " + _listed(scene.u_names))] if scene.nu else []),
    ]
    return aligned((f"#define {upper}_{size}", str(value), f"/* {doc} */") for size, value, doc in sizes)


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names) if len(names) <= 5 else f"{', '.join(names[:3])}, ..., {names[-1]}"


def _params(lowered: Lowered) -> list[tuple[str, str]]:
    """(declarator, doc) of every field of the params struct."""
    fields = [f"{array.name}{f'[{array.size}]' if array.shape else ''};" for array in lowered.params]
    width = max(map(len, fields), default=0)
    return [(f"{field:{width}}", array.doc) for field, array in zip(fields, lowered.params, strict=True)]


def _sketch(scene: Scene) -> list[str]:
    """The scene's picture as lines fit for a C comment."""
    lines = [line.rstrip().replace("*/", "* /") for line in str(scene).splitlines()]
    return [part for line in lines for part in wrap(line, WIDTH - 3, subsequent_indent=" " * 9) or [""]]
