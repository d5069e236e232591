"""A chain under the law of a table, from many starts, as C around the chain's own step: what regions of attraction are counted with."""

from __future__ import annotations

from phichain.emit.c.function import c_function
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro
from phichain.emit.render import render
from phichain.laws import GainTable
from phichain.lowering.laws import table_programs


def closed_loop_files(table: GainTable, real: str = "double") -> tuple[dict[str, str], list[dict[str, tuple[float, ...]]]]:
    """NAME_closed_loop.c by its name, and the rows of the table that it is handed over at run time.

    The chain's NAME.h and NAME.c, in double precision and with `step`, belong beside it.

    Args:
        table: the laws.
        real: "double" or "float", the type in which level and law are computed.
    """
    chain, name, programs = table.name, f"{table.name}_controller", table_programs(table)
    names, nx = CNames(f"{table.name}_controller", real, {}), len(table.state_names)
    functions = []
    for program in (programs.level, programs.law):
        arguments = [declaration(array, name, False, True) for array in program.inputs]
        arguments += [declaration(array, name, True, True) for array in program.outputs]
        functions.append((program.doc, f"static void {name}_{program.name}({', '.join(arguments)})", c_function(program, names, {}).lines))
    fields = {field: len(values) for field, values in programs.row(table, 0).items()}
    nq = table.compared[-1] + 1
    text = laid_out_text(
        render(
            "laws/closed_loop.c.j2", name=name, chain=chain, real=real, restrict=restrict_macro(name), functions=functions, fields=fields,
            law_fields=[array.name for array in programs.law.inputs[1:]], nx=nx, nq=nq, nv=nx - nq, nu=len(table.input_names),
        )
    )  # fmt: skip
    return {f"{chain}_closed_loop.c": text}, [programs.row(table, which) for which in range(len(table.signs))]
