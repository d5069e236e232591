"""An output feedback -> NAME_controller/: C whose caller keeps its memory, its self-test, its CasADi form, manifest, README."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isfinite
from textwrap import wrap
from typing import Any, Final

from phichain.emit.c.layout import WIDTH, laid_out, laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.text import restrict_macro
from phichain.emit.casadi.python_function import python_function
from phichain.emit.law.cases.output import Call, calls, first_calls
from phichain.emit.law.literals import (
    BYTES,
    MANNERS,
    described_inputs,
    listed_inputs,
    listed_operations,
    literal,
    padded,
    whole_folder,
)
from phichain.emit.law.memory import declared_with_memory, function_with_memory
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.ir.rounded import nearest
from phichain.laws import OutputFeedback
from phichain.lowering.laws import output_feedback, output_feedback_reset


def output_feedback_files(law: OutputFeedback, real: str = "double") -> dict[str, str]:
    """The whole folder by file name.

    Args:
        law: the law.
        real: "double" or "float", the type of its C.

    Raises:
        EmissionError: a number of the law does not fit the type.
    """
    name, step, reset = f"{law.name}_controller", output_feedback(law), output_feedback_reset(law)
    fields = frozenset(law.memory)
    shown = {
        "name": name, "upper": name.upper(), "chain": law.name, "real": real, "ny": len(law.measured_names), "nu": len(law.input_names),
        "sample": f"{law.sample:.17g}", "digest": law.digest, "formula": _formula(law), "has_observer": law.observer is not None,
        "fields": [(field, size, _ABOUT[field]) for field, size in law.memory.items()], "kind": law.observer.kind if law.observer else "",
        "rows": _rows(law, real), "operations": _operations(step), "bytes": BYTES[real] * sum(law.memory.values()),
    }  # fmt: skip
    files = {
        f"{name}.h": _header(law, step, reset, shown),
        f"{name}.c": _source(name, step, reset, real, fields),
        f"{name}_casadi.py": _casadi(step, reset, shown),
        "selftest.c": _selftest(law, real, shown),
        "README.md": render("laws/output/readme.md.j2", **shown),
    }
    return whole_folder("controller", name, law, real, _manifest(law, step, real), files)


_ABOUT: Final = {"expected": "deviation expected at the next call", "integral": "integrals over time"}


def _header(law: OutputFeedback, step: Program, reset: Program, shown: Mapping[str, Any]) -> str:
    fields = frozenset(law.memory)
    name = str(shown["name"])
    what = (
        "z is the deviation from the target: what the observer makes of the measurement y and of what it expected, z_expected; "
        "w takes whole turns from angles. A measurement that is not finite corrects nothing in that call."
        if law.observer
        else "z = w(y - y_0) is the deviation from the target; w takes whole turns from angles. An input is NaN where a "
        "measurement that acts on it is, and the integrals keep what they hold."
    )
    integral = " Each integral I stands still while an input that it acts on is at a limit and would be driven beyond."
    about = wrap(what + (integral if law.integrated else ""), WIDTH - 3)
    return render(
        "laws/output/header.h.j2", **{**shown, "rows": padded(list(shown["rows"]))}, about=about,
        manners=wrap(MANNERS, WIDTH - 3),
        reset="\n".join(laid_out(f"{declared_with_memory(f'{name}_reset', reset, fields, name, False)};")),
        step="\n".join(laid_out(f"{declared_with_memory(name, step, fields, name, False)};")),
    )  # fmt: skip


def _source(name: str, step: Program, reset: Program, real: str, fields: frozenset[str]) -> str:
    names = CNames(name, real, {})
    printed = {
        symbol: (program.doc, declared_with_memory(symbol, program, fields, name, True), function_with_memory(program, names, fields))
        for symbol, program in ((f"{name}_reset", reset), (name, step))
    }
    uses_math = any("math" in body.uses for _, _, body in printed.values())
    functions = [(doc, definition, body.lines) for doc, definition, body in printed.values()]
    includes = ["math.h"] if uses_math else []
    text = render("laws/output/source.c.j2", name=name, includes=includes, restrict=restrict_macro(name), functions=functions)
    return laid_out_text(text)


def _casadi(step: Program, reset: Program, shown: Mapping[str, Any]) -> str:
    printed = [python_function(program, {}, {}) for program in (step, reset)]
    functions = [
        (symbol, ", ".join(body.arguments), body.lines, [(a.name, a.size) for a in program.inputs], [a.name for a in program.outputs], program.doc)
        for symbol, body, program in zip((shown["name"], f"{shown['name']}_reset"), printed, (step, reset), strict=True)
    ]  # fmt: skip
    return render("laws/output/casadi.py.j2", **shown, functions=functions)


def _selftest(law: OutputFeedback, real: str, shown: Mapping[str, Any]) -> str:
    def rows(made: tuple[Call, ...]) -> list[str]:
        return [", ".join(literal(x, real) for part in _in_order(call) for x in part) for call in made]

    count, kept = len(law.input_names), sum(law.memory.values())
    text = render(
        "laws/output/selftest.c.j2", **shown, cases=rows(calls(law, real)), starts=rows(first_calls(law, real)), kept=kept,
        results=count + kept, zero=literal(0.0, real),
    )  # fmt: skip
    return laid_out_text(text)


def _in_order(call: Call) -> list[tuple[float, ...]]:
    return [*call.memory.values(), call.measured, call.expected, call.allowed]


def _rows(law: OutputFeedback, real: str) -> list[str]:
    """What every entry of y_meas and u is."""
    names = [f"y_meas[{i}]" for i in range(len(law.measured_names))] + [f"u[{i}]" for i in range(len(law.input_names))]
    width = max(map(len, names))
    rows = []
    for i, (what, unit, offset, turns) in enumerate(
        zip(law.measured_names, law.measured_units, law.offsets, law.wraps, strict=True)
    ):
        more = ", whole turns away from it count as none" if turns else ""
        more += ", integrated" if i in law.integrated else ""
        rows.append(f"{names[i]:{width}}  {what}, {unit}; target {nearest(real, Fraction(offset)):.9g}{more}")
    return [*rows, *described_inputs(law, width)]


def _formula(law: OutputFeedback) -> list[str]:
    """The law, a line each."""
    wrapped = "w(z)" if any(law.turns) else "z"
    free = f"u_0 - K {wrapped}" if any(law.rest) else f"-K {wrapped}"
    free += " - K_i I" if law.integrated else ""
    limited = any(map(isfinite, (*law.low, *law.high)))
    lines = ["z = z_expected + L w(y - y_0 - C z_expected)"] if law.observer else []
    lines.append(f"u = clip({free}, low, high)" if limited else f"u = {free}")
    lines += [f"z_expected = F {wrapped} + H {'(u - u_0)' if any(law.rest) else 'u'}"] if law.observer else []
    return lines + (["I = I + T (y - y_0)"] if law.integrated else [])


def _operations(program: Program) -> int:
    return sum(count_operations(program).values())


def _manifest(law: OutputFeedback, step: Program, real: str) -> dict[str, Any]:
    matrices = {} if law.observer is None else {
        name: [list(row) for row in getattr(law.observer, name)] for name in ("advance", "drive", "seen", "correction", "start")
    }  # fmt: skip
    return {
        "sample": law.sample,
        "measured": [list(row) for row in zip(law.measured_names, law.measured_units, law.offsets, law.wraps, strict=True)],
        "deviation": list(law.deviation_names),
        "inputs": listed_inputs(law),
        "rest": list(law.rest),
        "gains": [list(row) for row in law.gains],
        "observer": {"kind": law.observer.kind, **matrices} if law.observer else None,
        "integrated": [law.measured_names[i] for i in law.integrated],
        "integral_gains": [list(row) for row in law.integral_gains],
        "operations": listed_operations(step),
        "state_bytes": BYTES[real] * sum(law.memory.values()),
    }
