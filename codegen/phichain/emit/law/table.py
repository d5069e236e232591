"""A table of gains -> NAME_controller/: its supervisor and its law as C, self-test, CasADi form, manifest, README."""

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
from phichain.emit.law.cases.table import Case, cases
from phichain.emit.law.literals import (
    BYTES,
    MANNERS,
    described_inputs,
    listed_inputs,
    literal,
    padded,
    whole_folder,
)
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.laws import GainTable
from phichain.lowering.laws import TablePrograms, table_programs


def table_files(table: GainTable, real: str = "double") -> dict[str, str]:
    """The whole folder by file name.

    Args:
        table: the table.
        real: "double" or "float", the type of its C.

    Raises:
        EmissionError: a number of the table does not fit the type.
    """
    name, programs = f"{table.name}_controller", table_programs(table)
    fields = {field: len(values) for field, values in programs.row(table, 0).items()}
    count = len(table.signs)
    shown = {
        "name": name, "upper": name.upper(), "chain": table.name, "real": real, "nx": len(table.state_names), "nu": len(table.input_names),
        "count": count, "sample": f"{table.sample:.17g}" if table.sample else "", "digest": table.digest, "leave": f"{table.leave:.9g}",
        "rows": _rows(table), "equilibria": [f"{which}: {arrows(signs)}" for which, signs in enumerate(table.signs)],
        "operations": _cost(programs, count), "bytes": BYTES[real] * count * sum(fields.values()), "fields": fields,
        "formula": _formula(table),
    }  # fmt: skip
    files = {
        f"{name}.h": _header(table, shown),
        f"{name}.c": _source(table, programs, real, shown),
        f"{name}_casadi.py": _casadi(table, programs, shown),
        "selftest.c": _selftest(cases(table, real), real, shown),
        "README.md": render("laws/table/readme.md.j2", **shown),
    }
    return whole_folder("gain table", name, table, real, _manifest(table, real, shown), files)


def _header(table: GainTable, shown: Mapping[str, Any]) -> str:
    name, nx, nu = shown["name"], shown["nx"], shown["nu"]
    about = (
        "with target and gains of the equilibrium that is held. The level of an equilibrium is a sum of squares of the deviation from it: "
        "in the ellipsoid where it is at most 1 the linear closed loop stays, no input reaches its limit, and every angle is small. The "
        f"equilibrium whose links are closest is taken up where its level is at most 1, and let go where that passes {shown['leave']}. A "
        "measurement that is NaN takes up nothing and lets go of what is held."
    )
    state, measured = f"{name}_state *state", f"const {name}_real x_meas[{nx}]"
    return render(
        "laws/table/header.h.j2", **{**shown, "rows": padded(_rows(table))}, about=wrap(about, WIDTH - 3),
        manners=wrap(f"{MANNERS} {shown['bytes']} bytes of constants.", WIDTH - 3),
        supervisor="\n".join(laid_out(f"int {name}_supervisor({state}, {measured});")),
        controller="\n".join(laid_out(f"int {name}({state}, {measured}, {name}_real u[{nu}]);")),
    )  # fmt: skip


def _source(table: GainTable, programs: TablePrograms, real: str, shown: Mapping[str, Any]) -> str:
    name, names = str(shown["name"]), CNames(str(shown["name"]), real, {})
    printed = [(program, c_function(program, names, {})) for program in (programs.level, programs.apart, programs.law)]
    functions = [(program.doc, _declared(name, program), body.lines) for program, body in printed]
    entries = []
    for which, signs in enumerate(table.signs):
        row = programs.row(table, which)
        parts = ["{ " + ", ".join(names.number(Fraction(value)).text for value in values) + " }" for values in row.values()]
        entries.append((arrows(signs), parts))
    includes = ["math.h"] if any("math" in body.uses for _, body in printed) else []
    zero, one = names.number(Fraction(0.0)).text, names.number(Fraction(1.0)).text
    idle = [names.number(Fraction(min(max(0.0, low), high))).text for low, high in zip(table.low, table.high, strict=True)]
    return laid_out_text(
        render(
            "laws/table/source.c.j2", **shown, includes=includes, restrict=restrict_macro(name), functions=functions, entries=entries, zero=zero,
            one=one, letting_go=names.number(Fraction(table.leave)).text, idle=idle, arguments=", ".join(f"row->{field}" for field in _law_fields(programs)),
        )
    )  # fmt: skip


def _law_fields(programs: TablePrograms) -> list[str]:
    return [array.name for array in programs.law.inputs[1:]]


def _declared(name: str, program: Program) -> str:
    arguments = [declaration(array, name, False, True) for array in program.inputs]
    arguments += [declaration(array, name, True, True) for array in program.outputs]
    return f"static void {name}_{program.name}({', '.join(arguments)})"


def _casadi(table: GainTable, programs: TablePrograms, shown: Mapping[str, Any]) -> str:
    printed = []
    for program in (programs.level, programs.apart, programs.law):
        body = python_function(program, {}, {})
        printed.append((program.name, ", ".join(body.arguments), body.lines, program.doc))
    rows = [{field: [float(value) for value in values] for field, values in programs.row(table, k).items()} for k in range(len(table.signs))]
    return render("laws/table/casadi.py.j2", **shown, functions=printed, table=rows, law_fields=_law_fields(programs))


def _selftest(found: tuple[Case, ...], real: str, shown: Mapping[str, Any]) -> str:
    rows = [
        (case.before, case.after, ", ".join(literal(x, real) for part in (case.measured, case.expected, case.allowed) for x in part))
        for case in found
    ]
    return laid_out_text(render("laws/table/selftest.c.j2", **shown, cases=rows, zero=literal(0.0, real)))


def arrows(signs: tuple[int, ...]) -> str:
    """One equilibrium in words."""
    standing = [str(k + 1) for k, sign in enumerate(signs) if sign < 0]
    if not standing:
        return "every link hangs"
    if len(standing) == len(signs):
        return "every link stands"
    return f"link{'s' if len(standing) > 1 else ''} {', '.join(standing)} stand{'s' if len(standing) == 1 else ''}"


def _rows(table: GainTable) -> list[str]:
    """What every entry of x_meas and u is."""
    names = [f"x_meas[{i}]" for i in range(len(table.state_names))] + [f"u[{i}]" for i in range(len(table.input_names))]
    width = max(map(len, names))
    rows = []
    for i, (what, unit, turns) in enumerate(zip(table.state_names, table.state_units, table.wraps, strict=True)):
        rows.append(f"{names[i]:{width}}  {what}, {unit}{', whole turns count as none' if turns else ''}")
    return [*rows, *described_inputs(table, width)]


def _formula(table: GainTable) -> str:
    wrapped = "w(x_meas - target)" if any(table.wraps) else "(x_meas - target)"
    free = f"u_0 - K {wrapped}" if any(value for row in table.rest for value in row) else f"-K {wrapped}"
    return f"clip({free}, low, high)" if any(map(isfinite, (*table.low, *table.high))) else free


def _cost(programs: TablePrograms, count: int) -> int:
    """Operations of the longest call: what is held is let go, the closest is looked for, taken up, and its law applied."""
    one = {program.name: sum(count_operations(program).values()) for program in (programs.level, programs.apart, programs.law)}
    return 2 * one["level"] + count * one["apart"] + one["law"]


def _manifest(table: GainTable, real: str, shown: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "sample": table.sample,
        "leave": table.leave,
        "state": [list(row) for row in zip(table.state_names, table.state_units, table.wraps, strict=True)],
        "inputs": listed_inputs(table),
        "equilibria": [
            {"s": list(s), "target": list(target), "rest": list(rest), "gains": [list(row) for row in gains], "shape": [list(row) for row in shape]}
            for s, target, rest, gains, shape in zip(table.signs, table.targets, table.rest, table.gains, table.shapes, strict=True)
        ],
        "operations": {"most": shown["operations"]},
        "state_bytes": 4 + BYTES[real],
        "constant_bytes": shown["bytes"],
    }
