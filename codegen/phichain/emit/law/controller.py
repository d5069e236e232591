"""A law -> NAME_controller/: C that stands alone, its self-test, its CasADi form, a manifest, a README."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isfinite
from textwrap import wrap
from typing import Any

from phichain.emit.c.function import c_function
from phichain.emit.c.layout import WIDTH, laid_out, laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro
from phichain.emit.casadi.python_function import python_function
from phichain.emit.law.cases.state import Vector, vectors
from phichain.emit.law.literals import (
    BYTES,
    described_inputs,
    listed_inputs,
    listed_operations,
    literal,
    padded,
    whole_folder,
)
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.ir.rounded import nearest
from phichain.laws import StateFeedback
from phichain.lowering.laws import controller


def controller_name(law: StateFeedback) -> str:
    """NAME_controller: the folder, the files and the function of a law."""
    return f"{law.name}_controller"


def controller_files(law: StateFeedback, real: str = "double") -> dict[str, str]:
    """The whole folder by file name.

    Args:
        law: the law.
        real: "double" or "float", the type of its C.

    Raises:
        EmissionError: a number of the law does not fit the type.
    """
    name, program, tests = controller_name(law), controller(law), vectors(law, real)
    shown = {
        "name": name, "upper": name.upper(), "chain": law.name, "real": real, "nx": len(law.state_names), "nu": len(law.input_names),
        "formula": _formula(law), "sample": f"{law.sample:.17g}" if law.sample else "", "digest": law.digest,
    }  # fmt: skip
    files = {
        f"{name}.h": _header(law, program, shown),
        f"{name}.c": _source(name, program, real),
        f"{name}_casadi.py": _casadi(law, program, shown),
        "selftest.c": _selftest(tests, real, shown),
        "README.md": render("laws/controller/readme.md.j2", **shown, operations=_operations(program), rows=_rows(law, real)),
    }
    return whole_folder("controller", name, law, real, _manifest(law, program, real), files)


def _header(law: StateFeedback, program: Program, shown: Mapping[str, Any]) -> str:
    rows = _rows(law, str(shown["real"]))
    about = wrap(
        f"Its inputs leave u_0 by K (x_meas - target), {len(law.state_names)} measured entries in, {len(law.input_names)} out; "
        "it has no state and takes the same operations every time. An input is NaN where a measurement that acts on it is.",
        WIDTH - 3,
    )  # fmt: skip
    return render(
        "laws/controller/header.h.j2", **shown, about=about, rows=padded(rows),
        prototype="\n".join(laid_out(f"{_declared(str(shown['name']), program, definition=False)};")),
        operations=_operations(program), stack=0,
    )  # fmt: skip


def _source(name: str, program: Program, real: str) -> str:
    body = c_function(program, CNames(name, real, {}), {})
    return laid_out_text(
        render(
            "laws/controller/source.c.j2", name=name, doc=program.doc, includes=["math.h"] if "math" in body.uses else [],
            restrict=restrict_macro(name), definition=_declared(name, program, definition=True), lines=body.lines,
        )
    )  # fmt: skip


def _declared(name: str, program: Program, definition: bool) -> str:
    arguments = [declaration(array, name, False, definition) for array in program.inputs]
    arguments += [declaration(array, name, True, definition) for array in program.outputs]
    return f"void {name}({', '.join(arguments)})"


def _selftest(tests: tuple[Vector, ...], real: str, shown: Mapping[str, Any]) -> str:
    cases = [
        tuple(", ".join(literal(value, real) for value in values) for values in (test.measured, test.expected, test.allowed))
        for test in tests
    ]
    return laid_out_text(render("laws/controller/selftest.c.j2", **shown, cases=cases, zero=literal(0.0, real)))


def _casadi(law: StateFeedback, program: Program, shown: Mapping[str, Any]) -> str:
    printed = python_function(program, {}, {})
    return render("laws/controller/casadi.py.j2", **shown, arguments=", ".join(printed.arguments), lines=printed.lines, doc=program.doc)


def _rows(law: StateFeedback, real: str) -> list[str]:
    """What every entry of x_meas and u is."""
    names = [f"x_meas[{i}]" for i in range(len(law.state_names))] + [f"u[{i}]" for i in range(len(law.input_names))]
    width = max(map(len, names))
    rows = []
    for i, (what, unit, target, turns) in enumerate(
        zip(law.state_names, law.state_units, law.target, law.wraps, strict=True)
    ):
        whole = ", whole turns away from it count as none" if turns else ""
        rows.append(f"{names[i]:{width}}  {what}, {unit}; target {nearest(real, Fraction(target)):.9g}{whole}")
    return [*rows, *described_inputs(law, width)]


def _formula(law: StateFeedback) -> str:
    wrapped = "w(x_meas - target)" if any(law.wraps) else "(x_meas - target)"
    free = f"u_0 - K {wrapped}" if any(law.rest) else f"-K {wrapped}"
    return f"clip({free}, low, high)" if any(map(isfinite, (*law.low, *law.high))) else free


def _operations(program: Program) -> int:
    return sum(count_operations(program).values())


def _manifest(law: StateFeedback, program: Program, real: str) -> dict[str, Any]:
    return {
        "sample": law.sample,
        "state": [list(row) for row in zip(law.state_names, law.state_units, law.target, law.wraps, strict=True)],
        "inputs": listed_inputs(law),
        "rest": list(law.rest),
        "gains": [list(row) for row in law.gains],
        "operations": listed_operations(program),
        "state_bytes": 0,
        "constant_bytes": BYTES[real] * (len(law.gains) * len(law.target) + len(law.target)),
    }

