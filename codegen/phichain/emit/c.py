"""Programs -> NAME.h and NAME.c."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from phichain.emit import trig
from phichain.emit.c_function import CFunction, CNames, c_function, declaration, words
from phichain.emit.render import render
from phichain.harmonic import bessel
from phichain.program.lower import Lowered
from phichain.program.nodes import Array, Program
from phichain.program.passes import total_operations
from phichain.scene import Scene

Tables = dict[tuple[str, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class _Argument:
    """One argument as the header explains it."""

    name: str
    direction: str
    doc: str


@dataclass(frozen=True)
class _Function:
    """One function as the templates see it."""

    name: str
    symbol: str
    is_static: bool
    doc: str
    prototype: str
    definition: str
    arguments: tuple[_Argument, ...]
    operations: int
    form: str
    lines: tuple[str, ...]
    ignored: tuple[str, ...]
    tolerance: str


def header(scene: Scene, lowered: Lowered, tolerances: Mapping[str, str]) -> str:
    """NAME.h: sizes, the params struct, and one documented prototype a wanted function."""
    return render(
        "header.h.j2", name=scene.name, upper=scene.name.upper(), real=scene.real, sketch=_sketch(scene),
        sizes=_sizes(scene), params=_params(scene, lowered), functions=_functions(scene, lowered, tolerances),
    )  # fmt: skip


def source(scene: Scene, lowered: Lowered) -> str:
    """NAME.c: kernels, tables and functions, each only where something needs it."""
    functions = _functions(scene, lowered, {})
    uses = set().union(*(body.uses for body in _bodies(scene, lowered).values()))
    names = CNames(scene.name, scene.real, _tables(lowered))
    tables = [
        (table, len(values), ", ".join(names.number(value).text for value in values))
        for (_, values), table in names.tables.items()
    ]
    return render(
        "source.c.j2", name=scene.name, functions=functions, tables=tables, includes=_includes(uses),
        sincos=sincos_kernel(scene) if "sincos" in uses else "", bessel=bessel_kernel(scene) if "bessel" in uses else "",
    )  # fmt: skip


def sincos_kernel(scene: Scene) -> str:
    """The vectorisable sine-cosine kernel in the scene's type."""
    return render("sincos.c.j2", name=scene.name, real=scene.real, **trig.coefficients(scene.real))


def bessel_kernel(scene: Scene) -> str:
    """The Bessel functions J_0 to J_4 in the scene's type."""
    return render("bessel.c.j2", name=scene.name, real=scene.real, **bessel.coefficients(scene.real))


def _includes(uses: Iterable[str]) -> list[str]:
    uses = set(uses)
    wanted = set(trig.HEADERS) if "sincos" in uses else set()
    return sorted(wanted | ({"math.h"} if uses & {"math", "bessel"} else set()))


def _programs(lowered: Lowered) -> dict[str, Program]:
    """Helpers first, so that every function is known before it is called."""
    return {**lowered.helpers, **lowered.wanted}


def _tables(lowered: Lowered) -> Tables:
    """One file-scope name for each distinct table."""
    tables: Tables = {}
    for program in _programs(lowered).values():
        for name, values in program.tables.items():
            if (name, values) not in tables:
                taken = set(tables.values())
                unique, number = f"{name}_table", 2
                while unique in taken:
                    unique, number = f"{name}_table_{number}", number + 1
                tables[name, values] = unique
    return tables


def _bodies(scene: Scene, lowered: Lowered) -> dict[str, CFunction]:
    names = CNames(scene.name, scene.real, _tables(lowered))
    programs = _programs(lowered)
    symbols = {name: f"{scene.name}_{name}" for name in programs}
    return {name: c_function(program, names, symbols) for name, program in programs.items()}


def _functions(scene: Scene, lowered: Lowered, tolerances: Mapping[str, str]) -> list[_Function]:
    bodies = _bodies(scene, lowered)
    return [
        _function(scene, program, bodies[name], name in lowered.helpers, tolerances.get(name, ""))
        for name, program in _programs(lowered).items()
    ]


def _function(scene: Scene, program: Program, body: CFunction, is_static: bool, tolerance: str) -> _Function:
    return _Function(
        name=program.name,
        symbol=f"{scene.name}_{program.name}",
        is_static=is_static,
        doc=program.doc,
        prototype=", ".join(_declared(scene, program, definition=False)),
        definition=", ".join(_declared(scene, program, definition=True)),
        arguments=_arguments(scene, program),
        operations=total_operations(program),
        form="straight-line code" if program.is_straight_line else "loops",
        lines=body.lines,
        ignored=_ignored(program, body),
        tolerance=tolerance,
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


def _arguments(scene: Scene, program: Program) -> tuple[_Argument, ...]:
    arguments = [_Argument("p", "in", "parameters")] if program.params else []
    arguments += [_Argument(array.name, "in", _explained(scene, array)) for array in program.inputs]
    arguments += [_Argument(array.name, "out", _explained(scene, array)) for array in program.outputs]
    return tuple(arguments)


def _explained(scene: Scene, array: Array) -> str:
    """The argument's meaning, with its shape where it is a matrix."""
    text = array.doc or array.name
    return f"{text}, {array.shape[0]} x {array.shape[1]}" if len(array.shape) == 2 else text


def _sizes(scene: Scene) -> list[tuple[str, int, str]]:
    return [
        ("LINKS", scene.links, "number of links"),
        ("NQ", scene.nq, "entries of q: " + _listed(scene.q_names)),
        ("NV", scene.nv, "entries of v and a: " + _listed(scene.v_names)),
        *([("NU", scene.nu, "entries of u: " + _listed(scene.u_names))] if scene.nu else []),
    ]


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names) if len(names) <= 8 else f"{', '.join(names[:4])}, ..., {names[-1]}"


def _params(scene: Scene, lowered: Lowered) -> list[tuple[str, str, str]]:
    """(name, extent, doc) of every field of the params struct."""
    first = next(iter(lowered.wanted.values()))
    return [(array.name, f"[{array.size}]" if array.shape else "", array.doc) for array in first.params]


def _sketch(scene: Scene) -> list[str]:
    """The scene's picture as lines fit for a C comment."""
    return [line.rstrip().replace("*/", "* /") for line in str(scene).splitlines()]
