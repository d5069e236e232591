"""Programs -> NAME_casadi.py, a module that needs casadi alone and makes one casadi.Function per wanted function.

The equations stand in the text as the Program has them, loops as loops: run on CasADi symbols they leave the same
expression graph as straight-line code, in a fraction of the text. casadi itself is not needed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from textwrap import wrap

from phichain.contract.functions import ROWS
from phichain.contract.meanings import state_meanings
from phichain.emit import bessel
from phichain.emit.casadi.python_function import Table, python_function, spelt
from phichain.emit.expressions import double_literal
from phichain.emit.render import render
from phichain.ir.nodes import Array, Program
from phichain.lowering.lower import Lowered, lower
from phichain.scene import Scene

_WIDTH = 110


@dataclass(frozen=True)
class _Argument:
    """An argument or result: its Python name, its size as its user reads it, and how SX.sym makes it."""

    name: str
    extent: str
    doc: str
    symbol: str


@dataclass(frozen=True)
class _Function:
    """One function as the template sees it: the casadi.Function's arguments, and the equations it hands them to."""

    name: str
    doc: str
    inputs: tuple[_Argument, ...]
    outputs: tuple[_Argument, ...]
    call: str
    expressions: tuple[str, ...]


@dataclass(frozen=True)
class _Equations:
    """The equations of one function, on lists of scalars."""

    name: str
    doc: str
    arguments: tuple[str, ...]
    lines: tuple[str, ...]


def casadi_module(scene: Scene, lowered: Lowered) -> str:
    """The text of NAME_casadi.py.

    Args:
        scene: whose functions these are.
        lowered: its Programs; printed as they are where the scene asks for straight-line code, else with loops.
    """
    programs = (lowered if scene.code == "unrolled" else lower(lowered.model, "loops")).wanted
    reached = _with_callees(programs)
    tables = _tables(reached.values())
    constants = {table: values for (_, values), table in tables.items()}
    callees = {name: f"_{name}" for name in reached}
    printed = {name: python_function(program, tables, callees) for name, program in reached.items()}
    return render(
        "casadi/module.py.j2",
        name=scene.name,
        sketch=[line.rstrip() for line in str(scene).splitlines()],
        state=state_meanings(scene).items(),
        params=tuple(_parameters(next(iter(programs.values())))),
        constants=[line for table, values in constants.items() for line in _constant(table, values)],
        bessel=bessel_text() if any(function.uses_bessel for function in printed.values()) else "",
        equations=[
            _Equations(f"_{name}", reached[name].doc, function.arguments, function.lines)
            for name, function in printed.items()
        ],
        has_matrices=any(len(array.shape) == 2 for p in programs.values() for array in p.outputs),
        functions=[_function(scene, program) for program in programs.values()],
    )


def bessel_text() -> str:
    """J_0 to J_4 as a Python function on CasADi expressions."""
    return render("casadi/bessel.py.j2", **bessel.casadi_coefficients())


def _with_callees(programs: Mapping[str, Program]) -> dict[str, Program]:
    """All Programs that are reached, callees first."""
    reached: dict[str, Program] = {}
    for name, program in programs.items():
        reached |= _with_callees(program.callees) | {name: program}
    return reached


def _tables(programs: Iterable[Program]) -> dict[Table, str]:
    """The module-level name of each table of constants; tables of one quantity with the same values share it."""
    tables: dict[Table, str] = {}
    shared: dict[Table, str] = {}
    for name, values in (table for program in programs for table in program.tables.items()):
        quantity = name.rstrip("_0123456789")
        number = 1 + sum(quantity == other for other, _ in shared)
        unique = f"_{quantity.upper()}" if number == 1 else f"_{quantity.upper()}_{number}"
        tables[name, values] = shared.setdefault((quantity, values), unique)
    return tables


def _constant(name: str, values: tuple[Fraction, ...]) -> list[str]:
    """The lines that define a table."""
    numbers = ", ".join(double_literal(value).text for value in values)
    if len(name) + len(numbers) + 7 <= _WIDTH:
        return [f"{name} = [{numbers}]"]
    rows = wrap(
        f"{numbers},", _WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False
    )
    return [f"{name} = [", *rows, "]"]


def _parameters(program: Program) -> Iterator[tuple[str, str]]:
    """Name of every runtime parameter and the part of p that holds it; all functions of a scene share them."""
    start = 0
    for array in program.params:
        stop = start + array.size
        yield array.name, f"casadi.vertsplit(p[{start}:{stop}])" if array.shape else f"p[{start}]"
        start = stop


def _function(scene: Scene, program: Program) -> _Function:
    meanings = ROWS[program.name].meanings(scene)
    inputs = [_argument(array, meanings[array.name]) for array in program.inputs]
    given = [f"casadi.vertsplit({spelt(a.name)})" if a.shape else spelt(a.name) for a in program.inputs]
    if program.params:
        size = sum(array.size for array in program.params)
        fields = ", ".join(array.name for array in program.params)
        inputs.insert(0, _argument(Array("p", (size,)), f"runtime parameters: {fields}"))
        given.insert(0, "*_parameters(p)")
    return _Function(
        name=program.name,
        doc=program.doc,
        inputs=tuple(inputs),
        outputs=tuple(_argument(array, meanings[array.name]) for array in program.outputs),
        call=f"_{program.name}({', '.join(given)})",
        expressions=tuple(map(_expression, program.outputs)),
    )


def _argument(array: Array, doc: str) -> _Argument:
    extent = " x ".join(map(str, array.shape))
    symbol = f'"{array.name}", {array.size}' if array.shape else f'"{array.name}"'
    label = f" ({extent})" if extent else ""
    return _Argument(spelt(array.name), label, doc.removeprefix(f"{extent}, "), symbol)


def _expression(array: Array) -> str:
    """The result as CasADi's users expect it: scalar, column, or matrix of its natural shape."""
    name = spelt(array.name)
    if len(array.shape) == 2:
        return f"_matrix({name}, {array.shape[0]}, {array.shape[1]})"
    return f"casadi.vertcat(*{name})" if array.shape else name
