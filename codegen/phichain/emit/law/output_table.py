"""A table with observers or integrals -> NAME_controller/: supervisor and laws as C, self-test, CasADi form, manifest, README."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import isfinite
from textwrap import wrap
from typing import Any, Final

from phichain.emit.c.function import c_function
from phichain.emit.c.layout import WIDTH, laid_out, laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro
from phichain.emit.casadi.python_function import python_function
from phichain.emit.law.cases.output_table import Case, cases
from phichain.emit.law.literals import (
    BYTES,
    MANNERS,
    described_inputs,
    listed_inputs,
    literal,
    padded,
    whole_folder,
)
from phichain.emit.law.table import arrows
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.laws import OutputTable
from phichain.lowering.laws import OutputTablePrograms, output_table_programs

_GIVEN: Final = {
    "z": "state->deviation", "y_meas": "y_meas", "integral": "state->integral", "u": "u", "expected": "state->deviation",
}  # fmt: skip
"""What a part of a call is given, as the functions around it call that."""

_WHERE: Final = {
    "apart": ("table[which]", "&apart"), "start": ("table[near]", "state->deviation"), "estimate": ("table[which]", "z"),
    "level": ("table[which]", "&state->level"), "begin": ("table[near]", "state->integral"), "law": ("table[held]", "u"),
    "expect": ("table[state->watched]", "expected"), "grow": ("table[state->held]", "integral_next"),
}  # fmt: skip
"""Which row each part is called with, and where its result goes."""

_LARGE: Final = 2.0**100
"""Squared distances are smaller, or not finite; a float holds it."""


def output_table_files(table: OutputTable, real: str = "double") -> dict[str, str]:
    """The whole folder by file name.

    Args:
        table: the table.
        real: "double" or "float", the type of its C.

    Raises:
        EmissionError: a number of the table does not fit the type.
    """
    name, programs, law = f"{table.name}_controller", output_table_programs(table), table.laws[0]
    fields = {field: len(values) for field, values in programs.row(0).items()}
    count, n, ni = len(table.signs), len(law.deviation_names), len(law.integrated)
    shown = {
        "name": name, "upper": name.upper(), "chain": table.name, "real": real, "ny": len(law.measured_names), "nu": len(law.input_names),
        "n": n, "ni": ni, "count": count, "sample": f"{table.sample:.17g}", "digest": table.digest, "rows": _rows(table),
        "equilibria": [f"{which}: {arrows(signs)}" for which, signs in enumerate(table.signs)], "fields": fields,
        "operations": _cost(table, programs), "bytes": count * (BYTES[real] * (sum(fields.values()) + 2) + 4), "state_bytes": BYTES[real] * (1 + n + ni) + 12,
        "formula": _formula(table), "has_observer": bool(table.kind),
    }  # fmt: skip
    files = {
        f"{name}.h": _header(table, shown),
        f"{name}.c": _source(table, programs, real, shown),
        f"{name}_casadi.py": _casadi(table, programs, shown),
        "selftest.c": _selftest(cases(table, real), real, shown),
        "README.md": render("laws/output_table/readme.md.j2", **shown, about=_about(table), parts=list(programs.parts)),
    }
    return whole_folder("output table", name, table, real, _manifest(table, real, shown), files)


def _about(table: OutputTable) -> str:
    def span(values: Sequence[float], kind: str = ".4g") -> str:
        low, high = format(min(values), kind), format(max(values), kind)
        return low if low == high else f"{low} to {high}"

    watched = (
        "The equilibrium whose links are closest to what is measured is watched: its observer runs, from rest where another one was watched "
        f"before. It is taken up where its level was at most {span(table.take)} in more calls in a row than its observer takes to settle, "
        f"{span(table.settle, 'd')}, "
        if table.kind
        else f"The equilibrium whose links are closest is taken up where its level is at most {span(table.take)}, "
    )
    silent = (
        "A measurement that is not finite corrects nothing in that call, and where none is held nothing is watched."
        if table.kind
        else "A measurement that is NaN takes up nothing and lets go of what is held."
    )
    begun = (
        " Its integrals start where the cost to go is least, and each stands still while an input that it acts on is at a limit and would be driven beyond."
        if table.laws[0].integrated
        else ""
    )
    trembling = " What an estimate trembles by with the steps of its sensors is allowed for in both levels." if table.kind else ""
    return (
        "The level of an equilibrium is a sum of squares of the deviation z from it: in the ellipsoid where it is at most 1 the linear closed "
        f"loop stays, no input reaches its limit, and every angle is small. {watched}and let go where that passes {span(table.leave)}.{trembling}{begun} {silent}"
    )


def _header(table: OutputTable, shown: Mapping[str, Any]) -> str:
    name, ny, nu = shown["name"], shown["ny"], shown["nu"]
    state, measured = f"{name}_state *state", f"const {name}_real y_meas[{ny}]"
    return render(
        "laws/output_table/header.h.j2", **{**shown, "rows": padded(_rows(table))}, about=wrap(_about(table), WIDTH - 3),
        manners=wrap(f"{MANNERS} {shown['bytes']} bytes of constants, {shown['state_bytes']} of memory.", WIDTH - 3),
        supervisor="\n".join(laid_out(f"int {name}_supervisor({state}, {measured});")),
        follow="\n".join(laid_out(f"void {name}_follow({state}, {measured}, const {name}_real u[{nu}]);")),
        controller="\n".join(laid_out(f"int {name}({state}, {measured}, {name}_real u[{nu}]);")),
    )  # fmt: skip


def _source(table: OutputTable, programs: OutputTablePrograms, real: str, shown: Mapping[str, Any]) -> str:
    name, names = str(shown["name"]), CNames(str(shown["name"]), real, {})
    printed = [(program, c_function(program, names, {})) for program in programs.parts.values()]
    functions = [(program.doc, _declared(name, program), body.lines) for program, body in printed]
    entries = []
    for which, signs in enumerate(table.signs):
        parts = ["{ " + ", ".join(names.number(Fraction(value)).text for value in values) + " }" for values in programs.row(which).values()]
        entries.append((arrows(signs), [*parts, *(names.number(Fraction(level)).text for level in (table.take[which], table.leave[which])), str(table.settle[which])]))
    law = table.laws[0]
    zero, large = (names.number(Fraction(value)).text for value in (0.0, _LARGE))
    idle = [names.number(Fraction(min(max(0.0, low), high))).text for low, high in zip(law.low, law.high, strict=True)]
    calls = {part: _call(name, program) for part, program in programs.parts.items()}
    calls |= {f"level_of_{row}": _call(name, programs.parts["level"], f"table[{row}]") for row in ("which", "near")}
    return laid_out_text(
        render(
            "laws/output_table/source.c.j2", **shown, includes=["math.h"] if any("math" in body.uses for _, body in printed) else [],
            restrict=restrict_macro(name), functions=functions, entries=entries, zero=zero, large=large,
            idle=idle, calls=calls,
        )
    )  # fmt: skip


def _call(name: str, program: Program, row: str = "") -> str:
    """One part as it is called."""
    where, result = _WHERE[program.name]
    arguments = [_GIVEN.get(array.name) or f"{row or where}.{array.name}" for array in program.inputs]
    return f"{name}_{program.name}({', '.join([*arguments, result])});"


def _declared(name: str, program: Program) -> str:
    arguments = [declaration(array, name, False, True) for array in program.inputs]
    arguments += [declaration(array, name, True, True) for array in program.outputs]
    return f"static void {name}_{program.name}({', '.join(arguments)})"


def _casadi(table: OutputTable, programs: OutputTablePrograms, shown: Mapping[str, Any]) -> str:
    functions, parts = [], []
    for program in programs.parts.values():
        body = python_function(program, {}, {})
        functions.append((program.name, ", ".join(body.arguments), body.lines, program.doc))
        given = [(array.name, array.size) for array in program.inputs if array.name in _GIVEN]
        parts.append((program.name, given, [array.name for array in program.inputs if array.name not in _GIVEN], program.outputs[0].name))
    rows = [{field: [float(value) for value in values] for field, values in programs.row(which).items()} for which in range(len(table.signs))]
    return render("laws/output_table/casadi.py.j2", **shown, functions=functions, parts=parts, table=rows)


def _selftest(found: tuple[Case, ...], real: str, shown: Mapping[str, Any]) -> str:
    rows = [
        (", ".join(map(str, (*case.before, *case.after))), ", ".join(literal(x, real) for part in case.numbers for x in part)) for case in found
    ]
    results = 1 + shown["nu"] + shown["n"] + shown["ni"]
    return laid_out_text(render("laws/output_table/selftest.c.j2", **shown, cases=rows, results=results, zero=literal(0.0, real)))


def _rows(table: OutputTable) -> list[str]:
    """What every entry of y_meas and u is."""
    law = table.laws[0]
    names = [f"y_meas[{i}]" for i in range(len(law.measured_names))] + [f"u[{i}]" for i in range(len(law.input_names))]
    width = max(map(len, names))
    rows = []
    for i, (what, unit, turns) in enumerate(zip(law.measured_names, law.measured_units, law.wraps, strict=True)):
        more = ", whole turns count as none" if turns else ""
        more += ", integrated" if i in law.integrated else ""
        rows.append(f"{names[i]:{width}}  {what}, {unit}{more}")
    return [*rows, *described_inputs(law, width)]


def _formula(table: OutputTable) -> list[str]:
    """The law, a line each."""
    law, has_rest = table.laws[0], any(value for one in table.laws for value in one.rest)
    free = ("u_0 - K z" if has_rest else "-K z") + (" - K_i I" if law.integrated else "")
    limited = any(map(isfinite, (*law.low, *law.high)))
    lines = ["z = z_expected + L w(y - y_0 - C z_expected)" if table.kind else "z = w(y - y_0)"]
    lines.append(f"u = clip({free}, low, high)" if limited else f"u = {free}")
    lines += [f"z_expected = F z + H {'(u - u_0)' if has_rest else 'u'}"] if table.kind else []
    return lines + (["I = I + T (y - y_0)"] if law.integrated else [])


def _cost(table: OutputTable, programs: OutputTablePrograms) -> int:
    """Operations of the longest call: what is held is let go, the closest is looked for, taken up, and its law applied."""
    one = {name: sum(count_operations(program).values()) for name, program in programs.parts.items()}
    once = sum(one.get(part, 0) for part in ("start", "begin", "law", "expect", "grow"))
    looks = 1 if table.kind else 2
    return looks * one["estimate"] + 2 * one["level"] + len(table.laws) * one["apart"] + once


def _manifest(table: OutputTable, real: str, shown: Mapping[str, Any]) -> dict[str, Any]:
    law = table.laws[0]
    matrices = ("advance", "drive", "seen", "correction", "start")
    return {
        "sample": table.sample,
        "measured": [list(row) for row in zip(law.measured_names, law.measured_units, law.wraps, strict=True)],
        "deviation": list(law.deviation_names),
        "compared": [law.measured_names[k] for k in table.compared],
        "inputs": listed_inputs(law),
        "integrated": [law.measured_names[k] for k in law.integrated],
        "observer": table.kind or None,
        "equilibria": [
            {
                "s": list(s), "target": list(one.offsets), "rest": list(one.rest), "gains": [list(row) for row in one.gains],
                "integral_gains": [list(row) for row in one.integral_gains], "shape": [list(row) for row in shape], "begin": [list(row) for row in begin],
                "settle": settle, "take": take, "leave": leave, **({name: [list(row) for row in getattr(one.observer, name)] for name in matrices} if one.observer else {}),
            }
            for s, one, shape, begin, settle, take, leave in zip(
                table.signs, table.laws, table.shapes, table.begins, table.settle, table.take, table.leave, strict=True
            )
        ],
        "operations": {"most": shown["operations"]},
        "state_bytes": shown["state_bytes"],
        "constant_bytes": shown["bytes"],
    }  # fmt: skip
