"""One Program as the body of one C function for several trajectories at once, a lane each.

What depends on the inputs is of type STEM_lanes, a vector of the compiler's where it has vectors and one number where it
has none; what depends on parameters and constants alone stays a number. The text of an expression is the scalar one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Final

from phichain.emit.c import sincos as trig
from phichain.emit.c.function import CFunction, Writer
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.storage import Storage, own_storage
from phichain.emit.expressions import Text
from phichain.emit.render import render
from phichain.errors import EmissionError
from phichain.ir.inline import inline
from phichain.ir.nodes import Array, Cell, Const, Local, Op, Operand, Program, SinCos
from phichain.ir.varying import varying
from phichain.scene import Scene

_THROUGH_MEMORY: Final = {"sqrt": ("radicand", "root"), "tanh": ("rate_ratio", "saturation")}
"""Functions that lanes have no operator for: what their argument and their value are called where nothing else names them."""


def _libm(real: str) -> dict[str, str]:
    """How the C library calls them for numbers of a type."""
    return {kind: f"{kind}f" if real == "float" else kind for kind in _THROUGH_MEMORY}


def lanes_kernel(scene: Scene, stem: str, uses: Collection[str], registers: int | None) -> str:
    """The type of lanes and what is used of it: sines and cosines, roots, the way from arrays to lanes and back.

    Args:
        scene: the scene.
        stem: prefix of the type and of its functions.
        uses: "lanes_sincos", "lanes_sqrt", "lanes_tanh", "lanes_move", "lanes_choose".
        registers: how many vector registers of the machine a value takes; None for 64 bytes on any machine.
    """
    text = render(
        "flow/lanes.c.j2", name=scene.name, stem=stem, upper=stem.upper(), uses=uses, registers=registers,
        abs="fabsf" if scene.real == "float" else "fabs", **_libm(scene.real), **trig.coefficients(scene.real),
    )  # fmt: skip
    return laid_out_text(text)


def lane_function(program: Program, names: CNames, stem: str, uniform: Collection[str] = ()) -> CFunction:
    """Print a Program for lanes.

    Args:
        program: the function; calls are put in place.
        names: spelling.
        stem: prefix of the type of lanes and its functions.
        uniform: inputs, and outputs, that are one number for all lanes.
    """
    writer = _LaneWriter(inline(program), names, stem, frozenset(uniform))
    writer.arrays()
    writer.block(writer.program.body, 1)
    own = ("lanes_sincos",) if writer.turns else ()
    return CFunction(tuple(writer.lines), frozenset({*writer.uses, *own}))


def lane_declaration(array: Array, prefix: str, stem: str, is_output: bool, is_uniform: bool) -> str:
    """How an argument is declared: numbers by value, everything else as an array."""
    if is_uniform and array.shape == ():
        return f"const {prefix}_real {array.name}"
    element = f"{prefix}_real" if is_uniform else f"{stem}_lanes"
    if is_output:
        return f"{element} {array.name}[{prefix.upper()}_RESTRICT {max(array.size, 1)}]"
    return f"const {element} {array.name}[{max(array.size, 1)}]"


class _LaneWriter(Writer):
    def __init__(self, program: Program, names: CNames, stem: str, uniform: frozenset[str]) -> None:
        super().__init__(program, names, {})
        self.stem, self.element, self.sincos_symbol = stem, f"{stem}_lanes", f"{stem}_sincos"
        self.turns, self.register = False, ""
        self.lanes = varying(program, {array.name for array in program.inputs} - uniform)
        self.lanes |= {array.name for array in program.outputs if array.name not in uniform}
        # Numbers come by value and lanes by address.
        self.scalars -= self.lanes
        self.pointers = set()

    def stored_in(self) -> Storage:
        """Arrays of lanes and arrays of numbers share no cells."""
        return own_storage(self.program)

    def lanes_loop(self, depth: int) -> None:
        """Nothing: lanes are trajectories here."""

    def sincos(self, statement: SinCos, depth: int) -> None:
        with self._turning(statement.sine in self.lanes or statement.cosine in self.lanes):
            super().sincos(statement, depth)

    def trig_batch(self, op: Op, depth: int) -> None:
        with self._turning(op.result in self.lanes):
            super().trig_batch(op, depth)

    @contextmanager
    def _turning(self, in_lanes: bool) -> Iterator[None]:
        """Sines and cosines of lanes, or of what is one number for all: those are the scalar kernel's."""
        kept = self.element, self.sincos_symbol
        if in_lanes:
            self.turns = True
        else:
            self.element, self.sincos_symbol = self.names.type, f"{self.names.prefix}_sincos"
        yield
        self.element, self.sincos_symbol = kept

    def side_by_side(self, array: str, texts: list[str], depth: int) -> None:
        self.line(depth, f"const {self.element} {array}[{len(texts)}] = {{{', '.join(texts)}}};")

    def kind(self, value: str) -> str:
        return self.element if value in self.lanes else self.names.type

    def given(self, value: str, operand: Operand) -> str:
        text = super().given(value, operand)
        if value in self.lanes and not self.differs(operand):
            return f"{self.stem.upper()}_EVERY({text})"
        return text

    def differs(self, operand: Operand) -> bool:
        """Whether an operand differs from lane to lane."""
        match operand:
            case Const():
                return False
            case Local(name):
                return name in self.lanes
            case Cell(array, _):
                return array in self.lanes

    def op(self, op: Op, depth: int) -> None:
        if op.kind in _THROUGH_MEMORY and op.result in self.lanes:
            self.through_memory(op, depth)
            return
        if op.kind in ("select", "floor") and op.result in self.lanes:
            raise EmissionError("operation", op.kind, "has no form on vectors", "write the Program without it")
        super().op(op, depth)

    def through_memory(self, op: Op, depth: int) -> None:
        """Roots and tanh have no operator: they are taken lane by lane, through memory."""
        self.uses |= {"math", f"lanes_{op.kind}"}
        of, value = _THROUGH_MEMORY[op.kind]
        argument = self.fresh(of)
        result = self.fresh(value) if op.result.startswith("_") else op.result
        self.variable(depth, argument, self.operand(op.args[0]).text, self.element)
        self.line(depth, f"{self.element} {result};")
        self.line(depth, f"{self.stem}_{op.kind}(&{argument}, &{result});")
        self.texts[op.result] = Text(result)
