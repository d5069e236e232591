"""Programs -> NAME_casadi.c: the functions of NAME.c under the calling convention of CasADi's `external`.

Values come from the plain C functions. Jacobians are exact tangents of the Programs, printed as static C functions of
this file and handed over in column-compressed patterns: CasADi looks for them under the names jac_NAME_casadi_FUNCTION.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, product

from phichain.emit.c.layout import laid_out
from phichain.emit.c.parts import words
from phichain.emit.c.programs import print_programs
from phichain.emit.c.text import bessel_kernel, includes, macros, sincos_kernel
from phichain.emit.casadi.tangent import Cells, Tangent, block_name, make_tangent, stacked_inputs
from phichain.emit.printed import Printed
from phichain.emit.render import render
from phichain.errors import UnsupportedError
from phichain.ir.nodes import Array, Program
from phichain.scene import Scene

_ABI = ("arg", "res", "iw", "w", "mem")


@dataclass(frozen=True)
class _Function:
    """One function under CasADi's calling convention.

    Attributes:
        symbol: its name in C, and in CasADi.
        inputs: name and pattern of each argument.
        outputs: name and pattern of each result.
        size: length of the work vector it needs.
        lines: its body.
        ignored: what CasADi hands over and it has no use for.
    """

    symbol: str
    inputs: tuple[tuple[str, str], ...]
    outputs: tuple[tuple[str, str], ...]
    size: int
    lines: tuple[str, ...]
    ignored: tuple[str, ...]


def casadi_external(printed: Printed) -> str:
    """The text of NAME_casadi.c.

    Args:
        printed: the functions that it calls.

    Raises:
        UnsupportedError: the scene is in single precision, or wants flows alone.
    """
    scene, programs = printed.scene, {function.name: function.program for function in printed.wanted}
    if scene.real != "double":
        raise UnsupportedError(
            "real", scene.real, "CasADi calls functions in double precision",
            f'set target.real = "double", or use {scene.name}_casadi.py',
        )  # fmt: skip
    if not programs:
        raise UnsupportedError(
            "functions.want", scene.want, "holds nothing that CasADi could call",
            "want forward_dynamics too, or leave out the C for CasADi",
        )  # fmt: skip
    tangents = {name: tangent for name in programs if (tangent := make_tangent(printed.model, name)) is not None}
    writer = _Writer(scene.name)
    functions = []
    for name, program in programs.items():
        functions.append(writer.values(program))
        if name in tangents:
            functions.append(writer.jacobian(program, tangents[name]))
    first = next(iter(programs.values()))
    return render(
        "casadi/external.c.j2",
        name=scene.name,
        upper=scene.name.upper(),
        example=first.name,
        without_jacobian=[name for name in programs if name not in tangents],
        **_definitions(scene, tangents.values()),
        patterns=writer.pattern_lines(),
        functions=functions,
        longest=max(array.size for program in programs.values() for array in stacked_inputs(program)),
        params=[(array.name, array.size if array.shape else 0) for array in first.params],
        has_jacobians=any(tangent.program for tangent in tangents.values()),
    )


def _definitions(scene: Scene, tangents: Iterable[Tangent]) -> dict[str, object]:
    """The static functions that compute Jacobians, and what those lean on."""
    helpers = {t.program.name: t.program for t in tangents if t.program is not None}
    made = print_programs(scene, helpers, {})
    sincos = sincos_kernel(scene, made.uses) if "sincos" in made.uses else ""
    return {
        "restrict": macros(scene.name, (sincos, *(line for function in made.functions for line in function.lines))),
        "tangents": made.functions,
        "tables": made.tables,
        "includes": sorted({*includes(made.uses), "stddef.h"}),
        "sincos": sincos,
        "bessel": bessel_kernel(scene) if "bessel" in made.uses else "",
    }


class _Writer:
    """Functions of one file, and the sparsity patterns they share."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.patterns: dict[tuple[int, ...], str] = {}

    def pattern_lines(self) -> list[str]:
        """The definitions of all patterns."""
        definitions = [
            f"static const {self.name}_casadi_int {name}[] = {{{', '.join(map(str, numbers))}}};"
            for numbers, name in self.patterns.items()
        ]
        return [line for definition in definitions for line in laid_out(definition)]

    def values(self, program: Program) -> _Function:
        """The function itself."""
        lines = self._call(program, program)
        for i, array in enumerate(program.outputs):
            rows, columns = _extent(array)
            lines.append(f"{self.name}_casadi_put({rows}, {columns}, {array.name}, res[{i}]);")
        return self._function(
            symbol=f"{self.name}_casadi_{program.name}",
            inputs=[(array.name, self._full(array)) for array in stacked_inputs(program)],
            outputs=[(array.name, self._full(array)) for array in program.outputs],
            size=sum(array.size for array in program.outputs),
            lines=lines,
        )

    def jacobian(self, program: Program, tangent: Tangent) -> _Function:
        """Its Jacobians: beside the arguments CasADi hands over the results, and wants a block for each pair."""
        inputs = stacked_inputs(program)
        computed = {array.name: array for array in tangent.program.outputs} if tangent.program else {}
        lines = self._call(program, tangent.program) if tangent.program else []
        blocks = []
        for i, (output, argument) in enumerate(product(program.outputs, inputs)):
            block = block_name(output.name, argument.name)
            pattern = self._pattern(output.size, argument.size, _as_stored(output, tangent.cells[block]))
            blocks.append((block, pattern))
            if block in computed:
                rows, columns = _extent(output)
                put = f"{self.name}_casadi_put_jacobian"
                lines.append(f"{put}({rows}, {columns}, {pattern}, {block}, res[{i}]);")
        results = [(f"out_{array.name}", self._pattern(*_extent(array), ())) for array in program.outputs]
        return self._function(
            symbol=f"jac_{self.name}_casadi_{program.name}",
            inputs=[*((array.name, self._full(array)) for array in inputs), *results],
            outputs=blocks,
            size=sum(array.size for array in computed.values()),
            lines=lines,
        )

    def _function(
        self,
        symbol: str,
        inputs: Sequence[tuple[str, str]],
        outputs: Sequence[tuple[str, str]],
        size: int,
        lines: Sequence[str],
    ) -> _Function:
        used = words("\n".join(lines))
        ignored = tuple(name for name in _ABI if name not in used)
        body = tuple(line for whole in lines for line in laid_out(f"    {whole}" if whole else ""))
        return _Function(symbol, tuple(inputs), tuple(outputs), size, body, ignored)

    def _call(self, program: Program, called: Program) -> list[str]:
        """The lines that take the arguments, lay the results into the work vector and call a C function."""
        given = f"{self.name}_casadi_given"
        lines, names = [], []
        for i, array in enumerate(stacked_inputs(program)):
            if i == 0 and program.params:
                lines.append(f"const {self.name}_params p = {self.name}_casadi_params({given}(arg[{i}]));")
                names.append("&p")
                continue
            kind, value = ("*const ", "") if array.shape else ("", "*")
            lines.append(f"const double {kind}{array.name} = {value}{given}(arg[{i}]);")
            names.append(array.name)
        offset = 0
        for array in called.outputs:
            lines.append(f"double *const {array.name} = w{f' + {offset}' if offset else ''};")
            offset += array.size
        names += (array.name for array in called.outputs)
        return [*lines, "", f"{self.name}_{called.name}({', '.join(names)});"]

    def _full(self, array: Array) -> str:
        rows, columns = _extent(array)
        return self._pattern(rows, columns, [(i, j) for i in range(rows) for j in range(columns)])

    def _pattern(self, rows: int, columns: int, cells: Sequence[tuple[int, int]]) -> str:
        """The name of a column-compressed pattern, given the places of its nonzeros; full ones have a short form."""
        if len(cells) == rows * columns:
            numbers: tuple[int, ...] = (rows, columns, 1)
        else:
            by_column = sorted((column, row) for row, column in cells)
            counts = Counter(column for column, _ in by_column)
            ends = accumulate(counts[column] for column in range(columns))
            numbers = (rows, columns, 0, *ends, *(row for _, row in by_column))
        return self.patterns.setdefault(numbers, f"{self.name}_casadi_pattern_{len(self.patterns) + 1}")


def _extent(array: Array) -> tuple[int, int]:
    """Rows and columns under CasADi."""
    rows, columns = (*array.shape, 1, 1)[:2]
    return rows, columns


def _as_stored(output: Array, cells: Cells) -> list[tuple[int, int]]:
    """The rows of a Jacobian as CasADi counts them: the entries of a matrix result column by column."""
    rows, columns = _extent(output)
    return [(row % columns * rows + row // columns, column) for row, column in cells]
