"""A law along a trajectory -> NAME_swingup/: C that stands alone, its self-test, its CasADi form, a manifest, a README."""

from __future__ import annotations

from collections.abc import Mapping
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
from phichain.emit.law.cases.along import Case, cases, held_numbers, table
from phichain.emit.law.literals import (
    BYTES,
    bound,
    described_inputs,
    listed_inputs,
    listed_operations,
    literal,
    padded,
    whole_folder,
)
from phichain.emit.render import render
from phichain.emit.stencil import instance
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.ir.rounded import nearest
from phichain.laws import FORGOTTEN, STILL, TrajectoryLaw
from phichain.lowering.laws.holding import holding
from phichain.lowering.trajectory import beginning, measurement, tracking

_OBSERVED: Final = (
    "z is the deviation from x_r, estimated from the positions y alone: what was expected of it, corrected by L w(y - q_r - z_expected_q), "
    "and for the next call carried on by the chain's linearisation along the trajectory, whose tables L, F and G are."
)
_LEARNED: Final = (
    "theta, relative errors of parameters, is estimated too: M corrects it along the trajectory, where rates gain E theta, and at the target "
    "it is what has been found. There the linearisation is that of the chain with these parameters, F + sum theta_k F_k and "
    "G + sum theta_k G_k, and what lies within half a step of a sensor is corrected by L_in, what lies beyond by L_out."
)
_STILL: Final = (
    f"A reading that stays the same to the bit pulls z along: where what it has pulled within the last {FORGOTTEN:g} s comes to {STILL} steps of its "
    "sensor, the sensor is taken for stuck and the chain for LOST."
)
_ABOUT: Final = (
    "x_r, u_r and K stand in a table over time; between its rows x_r is the cubic that meets the states of both, u_r and K are "
    "straight lines. Its last row is the target with the gains of its regulator, so that from the end of the table on the chain "
    "is held there. w takes whole turns from the deviations of angles."
)


def swingup_name(law: TrajectoryLaw) -> str:
    """NAME_swingup: the folder, the files and the function of a law along a trajectory."""
    return f"{law.name}_swingup"


def swingup_files(law: TrajectoryLaw, real: str = "float") -> dict[str, str]:
    """The whole folder by file name.

    Args:
        law: the law.
        real: "float" or "double", the type of its C and of its table.

    Raises:
        EmissionError: a number of the law does not fit the type.
    """
    name, program, rows = swingup_name(law), tracking(law), table(law, real)
    width = len(rows[0])
    shown = {
        "name": name, "upper": name.upper(), "chain": law.name, "real": real, "digest": law.digest, "knots": len(rows),
        "nx": law.states.shape[1], "nu": law.inputs.shape[1], "sample": f"{law.catch.sample:.17g}", "width": width,
        "duration": f"{law.duration:.9g}", "bytes": BYTES[real] * (len(rows) * width + len(held_numbers(law, real))), "note": wrap(law.note, WIDTH - 3),
        "operations": sum(count_operations(program).values()),
        "reads": law.measured, "results": law.inputs.shape[1] + law.remembered, "memory": law.remembered, "measured": measurement(law)[0],
        "observed": wrap(_OBSERVED, WIDTH - 3) if law.observer else [], "learned": wrap(_learned(law), WIDTH - 3) if _learns(law) else [],
        "deviation": "z" if law.observer else "w(x_meas - x_r(t))",
    }  # fmt: skip
    files = {
        f"{name}.h": _header(law, shown),
        f"{name}.c": _source(law, program, rows, shown),
        f"{name}_casadi.py": _casadi(law, program, shown),
        "selftest.c": _selftest(cases(law, real), shown),
        "README.md": render("laws/trajectory/readme.md.j2", **shown, rows=_rows(law)),
    }
    return whole_folder("swingup", name, law, real, _manifest(law, program, shown), files)


def _learns(law: TrajectoryLaw) -> bool:
    return law.observer is not None and law.observer.learning is not None


def _learned(law: TrajectoryLaw) -> str:
    """What is found out, and what it is found out of."""
    learning = law.observer.learning if law.observer else None
    if learning is None:
        return ""
    named = f" The entries of theta are those of {', '.join(learning.names)}." if learning.names else ""
    bounds = f" They are kept within {', '.join(f'{bound:g}' for bound in learning.bounds)}."
    return f"{_LEARNED}{named}{bounds} {_STILL}"


def _programs(law: TrajectoryLaw, program: Program) -> tuple[Program, ...]:
    """All that is called: between two rows of the table, at its end where that is another law, and before the first call."""
    held = (holding(law),) if _learns(law) else ()
    return (program, *held, beginning(law)) if law.observer else (program,)


def _header(law: TrajectoryLaw, shown: Mapping[str, Any]) -> str:
    prototype = f"{_law_declaration(shown, definition=False)};"
    return render(
        "laws/trajectory/header.h.j2", **shown, about=wrap(_ABOUT, WIDTH - 3), rows=padded(_rows(law)),
        prototype="\n".join(laid_out(prototype)), reset="\n".join(laid_out(f"{_reset_declaration(shown)};")),
    )  # fmt: skip


def _law_declaration(shown: Mapping[str, Any], definition: bool) -> str:
    name, nu = shown["name"], shown["nu"]
    const = "const " if definition else ""
    return f"{name}_phase {name}({name}_state *state, {const}{name}_real t, {_measured(shown)}, {name}_real u[{nu}])"


def _measured(shown: Mapping[str, Any]) -> str:
    return f"const {shown['name']}_real {shown['measured']}[{shown['reads']}]"


def _reset_declaration(shown: Mapping[str, Any]) -> str:
    more = f", {_measured(shown)}" if shown["observed"] else ""
    return f"void {shown['name']}_reset({shown['name']}_state *state{more})"


def _static(name: str, program: Program) -> str:
    """How a Program is declared that only this file calls."""
    arguments = [declaration(array, name, False, True) for array in program.inputs]
    arguments += [declaration(array, name, True, True) for array in program.outputs]
    return f"static void {name}_{program.name}({', '.join(arguments)})"


def _source(law: TrajectoryLaw, program: Program, rows: list[list[float]], shown: Mapping[str, Any]) -> str:
    name, real, upper = str(shown["name"]), str(shown["real"]), str(shown["upper"])
    programs, held = _programs(law, program), held_numbers(law, real)
    bodies = [c_function(one, CNames(name, real, {}), {}) for one in programs]
    functions = [(one.doc, _static(name, one), body.lines) for one, body in zip(programs, bodies, strict=True)]
    names = {"phi_law": name, "phi_": f"{name}_", "PHI_": f"{upper}_", "measured": shown["measured"]}
    squared = Fraction(law.tube) ** 2
    return laid_out_text(
        render(
            "laws/trajectory/source.c.j2", **{key: value for key, value in shown.items() if key != "note"}, functions=functions,
            includes=["math.h"] if any("math" in body.uses for body in bodies) else [], restrict=restrict_macro(name),
            table=[", ".join(literal(value, real) for value in row) for row in rows],
            held=", ".join(literal(value, real) for value in held), held_count=len(held),
            rate=literal(nearest(real, 1 / Fraction(law.interval)), real), tube=literal(nearest(real, squared), real),
            rail=literal(nearest(real, Fraction(law.rail)), real) if isfinite(law.rail) else "",
            law=instance("laws/trajectory", names, {"WITH_RAIL": isfinite(law.rail), "WITH_OBSERVER": law.observer is not None, "WITH_LEARNING": _learns(law)}).rstrip("\n"),
        )
    )  # fmt: skip


def _casadi(law: TrajectoryLaw, program: Program, shown: Mapping[str, Any]) -> str:
    functions = []
    for one in _programs(law, program):
        body = python_function(one, {}, {})
        functions.append((one.name, ", ".join(body.arguments), body.lines, [(a.name, a.size) for a in one.inputs], [a.name for a in one.outputs], one.doc))
    rows = [", ".join(map(repr, row)) for row in table(law, "double")]
    return render("laws/trajectory/casadi.py.j2", **shown, functions=functions, table=rows, held_exact=", ".join(map(repr, held_numbers(law, "double"))), interval=repr(float(law.interval)))


def _selftest(tests: tuple[Case, ...], shown: Mapping[str, Any]) -> str:
    real = str(shown["real"])
    listed = [
        {"phase": test.phase, "numbers": ", ".join(literal(value, real) for value in test.numbers)}
        for test in tests
    ]
    return laid_out_text(render("laws/trajectory/selftest.c.j2", **shown, cases=listed, zero=literal(0.0, real)))


def _rows(law: TrajectoryLaw) -> list[str]:
    """What every entry of x_meas and u is."""
    catch = law.catch
    names = [f"{measurement(law)[0]}[{i}]" for i in range(law.measured)]
    rows = []
    for name, what, unit, start, end in zip(names, catch.state_names, catch.state_units, law.states[0], catch.target, strict=False):
        rows.append(f"{name}  {what}, {unit}; from {start:.9g} to {end:.9g}")
    return [*rows, *described_inputs(catch)]


def _manifest(law: TrajectoryLaw, program: Program, shown: Mapping[str, Any]) -> dict[str, Any]:
    catch = law.catch
    return {
        "sample": catch.sample,
        "duration": law.duration,
        "interval": law.interval,
        "note": law.note,
        "state": [
            list(row)
            for row in zip(catch.state_names, catch.state_units, law.states[0].tolist(), catch.target, catch.wraps, strict=True)
        ],
        "inputs": listed_inputs(catch),
        "rail": bound(law.rail),
        "tube": law.tube,
        "operations": listed_operations(program),
        "observer": "along the trajectory, from positions" if law.observer else None,
        "learned": law.observer.learning.count if law.observer and law.observer.learning else 0,
        "state_bytes": 4 + BYTES[str(shown["real"])] * law.remembered,
        "table_bytes": shown["bytes"],
    }
