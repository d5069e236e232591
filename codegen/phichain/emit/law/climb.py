"""A law along a family of orbits -> NAME_climb/: C that stands alone, its self-test, a manifest, a README."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from textwrap import wrap
from typing import Any, Final

from phichain.emit.c.function import c_function
from phichain.emit.c.layout import WIDTH, laid_out, laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro
from phichain.emit.law.cases.climb import cases, table
from phichain.emit.law.literals import BYTES, MANNERS, described_inputs, literal, padded, whole_folder
from phichain.emit.render import render
from phichain.emit.stencil import instance
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.ir.rounded import nearest
from phichain.laws import FamilyLaw
from phichain.laws.family import FOLLOW, LEAVE, REST
from phichain.lowering.climb import calming, catching, following

BACK: Final = 0.5
"""Pace at which the orbit sinks where the input has no room, in that of rising."""

_ABOUT: Final = (
    "x_r and K stand in a table over the family, orbits of rising energy, and over half a period of each, the other half being its mirror image; "
    "x_r' is the derivative of x_r along the orbit, and slip how far ahead of x_r the chain is. The phase follows the chain, what is left across "
    "the orbit is regulated, and the orbit rises as fast as the input has room. Where the ellipsoid of the target's own regulator is reached that "
    "one holds the chain; where the chain is too far from its orbit it is calmed until it hangs still, and climbs anew. w takes whole turns from "
    "the deviations of angles."
)


def climb_name(law: FamilyLaw) -> str:
    """NAME_climb: the folder, the files and the function of a law along a family."""
    return f"{law.name}_climb"


def climb_files(law: FamilyLaw, real: str = "float") -> dict[str, str]:
    """The whole folder by file name.

    Args:
        law: the law.
        real: "float" or "double", the type of its C and of its table.

    Raises:
        EmissionError: a number of the law does not fit the type.
    """
    name, rungs, programs = climb_name(law), table(law, real), (catching(law), calming(law), following(law))
    width, nodes = len(rungs[0][0]), law.states.shape[1]
    shown = {
        "name": name, "upper": name.upper(), "chain": law.name, "real": real, "digest": law.digest, "rungs": len(rungs), "nodes": nodes,
        "nx": law.states.shape[2], "sample": f"{law.catch.sample:.17g}", "width": width,
        "bytes": BYTES[real] * len(rungs) * ((nodes + 2) * width + 2),
        "operations": sum(sum(count_operations(program).values()) for program in programs),
    }  # fmt: skip
    files = {
        f"{name}.h": _header(law, shown),
        f"{name}.c": _source(law, programs, rungs, shown),
        "selftest.c": _selftest(law, shown),
        "README.md": render("laws/climb/readme.md.j2", **shown, rows=_rows(law)),
    }
    return whole_folder("climb", name, law, real, _manifest(law, programs, shown), files)


def _header(law: FamilyLaw, shown: Mapping[str, Any]) -> str:
    name = shown["name"]
    prototype = f"{name}_phase {name}({name}_state *state, const {name}_real x_meas[{shown['nx']}], {name}_real u[1]);"
    return render(
        "laws/climb/header.h.j2", **shown, about=wrap(_ABOUT, WIDTH - 3), manners=wrap(MANNERS, WIDTH - 3),
        rows=padded(_rows(law)), prototype="\n".join(laid_out(prototype)),
    )  # fmt: skip


def _source(law: FamilyLaw, programs: tuple[Program, ...], rungs: list[list[list[float]]], shown: Mapping[str, Any]) -> str:
    name, real = str(shown["name"]), str(shown["real"])
    functions, uses = [], set()
    for program in programs:
        body = c_function(program, CNames(name, real, {}), {})
        arguments = [declaration(array, name, False, True) for array in program.inputs]
        arguments += [declaration(array, name, True, True) for array in program.outputs]
        functions.append((program.doc, f"static void {name}_{program.name}({', '.join(arguments)})", body.lines))
        uses |= set(body.uses)
    sample, slow = Fraction(law.catch.sample), [nearest(real, Fraction(value)) for value in law.slowness.tolist()]
    numbers = {
        "period": sample, "pace": Fraction(law.pace), "back": Fraction(BACK), "follow": Fraction(FOLLOW),
        "tube": Fraction(law.tube) ** 2, "rest": Fraction(REST), "leave": Fraction(LEAVE),
    }  # fmt: skip
    return laid_out_text(
        render(
            "laws/climb/source.c.j2", **shown, includes=["math.h"] if "math" in uses else [], restrict=restrict_macro(name), functions=functions,
            table=[[", ".join(literal(value, real) for value in row) for row in rung] for rung in rungs],
            slow=[literal(value, real) for value in slow], rise=[literal(nearest(real, Fraction(value)), real) for value in law.rises.tolist()],
            law=instance("laws/climb", {"phi_law": name, "phi_": f"{name}_", "PHI_": f"{shown['upper']}_"}, {}).rstrip("\n"),
            **{key: literal(nearest(real, value), real) for key, value in numbers.items()},
        )
    )  # fmt: skip


def _selftest(law: FamilyLaw, shown: Mapping[str, Any]) -> str:
    real = str(shown["real"])
    listed = [
        {"before": test.before, "after": test.after, "numbers": ", ".join(literal(value, real) for value in test.numbers)}
        for test in cases(law, real)
    ]
    return laid_out_text(render("laws/climb/selftest.c.j2", **shown, cases=listed, zero=literal(0.0, real)))


def _rows(law: FamilyLaw) -> list[str]:
    """What every entry of x_meas and u is."""
    catch = law.catch
    rows = [
        f"x_meas[{i}]  {what}, {unit}; target {target:.9g}{', whole turns count as none' if turns else ''}"
        for i, (what, unit, target, turns) in enumerate(zip(catch.state_names, catch.state_units, catch.target, catch.wraps, strict=True))
    ]
    return [*rows, *described_inputs(catch)]


def _manifest(law: FamilyLaw, programs: tuple[Program, ...], shown: Mapping[str, Any]) -> dict[str, Any]:
    catch = law.catch
    return {
        "sample": catch.sample,
        "state": [list(row) for row in zip(catch.state_names, catch.state_units, catch.target, catch.wraps, strict=True)],
        "input": [catch.input_names[0], catch.input_units[0], -law.limit, law.limit],
        "rungs": len(law.states),
        "nodes": law.states.shape[1],
        "energy": [float(law.energies[0]), float(law.energies[-1])],
        "pace": law.pace,
        "rise": [float(law.rises.min()), float(law.rises.max())],
        "tube": law.tube,
        "operations": {program.name: sum(count_operations(program).values()) for program in programs},
        "table_bytes": shown["bytes"],
    }
