"""Python's text of a Program over the field: every operation on a value and on its derivatives.

A value is written as up to four variables, marked "" (itself), "a", "b" (derivatives along two directions) and "m" (along both); those
that are structurally zero are left out. Angles have "c" and "s" beside them, cosine and sine.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Final

from phichain.ir.nodes import (
    Array,
    Call,
    Cell,
    Const,
    For,
    Local,
    Op,
    Operand,
    Program,
    SinCos,
    Statement,
    Store,
)
from phichain.proof.modular.circles import whole_multiple
from phichain.proof.modular.field import PRIME, exact
from phichain.proof.modular.parts import Parts, added, chained, index_text, multiplied

_GIVEN: Final = {"": "values", "a": "along", "b": "across", "m": "mixed"}


class Python:
    """The text of one Program."""

    def __init__(self, program: Program, marks: tuple[str, ...], angles: frozenset[str]) -> None:
        """Prepare.

        Args:
            program: what to write.
            marks: the derivatives to carry along.
            angles: names of the arrays and local values that are angles.
        """
        self._program, self._marks, self._angles = program, marks, angles
        self._lines: list[str] = ["def run(given, at):"]
        self._depth = 1
        self._arrays: dict[str, str] = {}
        self._sizes: dict[str, int] = {}
        self._constant: set[str] = set()
        self._locals: dict[str, tuple[str, tuple[str, ...]]] = {}
        self._argument_of_j = ""

    def text(self) -> str:
        """Write it."""
        program = self._program
        for array in (*program.params, *program.inputs):
            self._argument(array)
        for name, values in program.tables.items():
            self._declare(name, len(values), is_constant=True)
            entries = ", ".join(f"{i}: {exact(value)}" for i, value in enumerate(values))
            self._line(f"{self._arrays[name]} = {{{entries}}}")
        for array in (*program.outputs, *program.work):
            self._declare(array.name, array.size)
            for mark in (*self._marks, *self._points(array.name)):
                self._line(f"{self._arrays[array.name]}{mark} = {{}}")
        self._statements(program.body)
        for array in (*program.outputs, *program.work):
            self._line(f"checked({self._arrays[array.name]}, {array.size}, {array.name!r})")
        results = ", ".join(f"{array.name!r}: ({self._result(array)},)" for array in program.outputs)
        self._line(f"return {{{results}}}")
        return "\n".join(self._lines) + "\n"

    def _result(self, array: Array) -> str:
        name = self._arrays[array.name]
        return ", ".join(f"flat({name}{mark}, {array.size})" for mark in self._marks)

    def _argument(self, array: Array) -> None:
        is_constant = array in self._program.params
        self._declare(array.name, array.size, is_constant)
        name = self._arrays[array.name]
        for mark in ("",) if is_constant else self._marks:
            given = f"given.{_GIVEN[mark]}"
            source = f"{given}[{array.name!r}]" if not mark else f"{given}.get({array.name!r}, (0,) * {array.size})"
            self._line(f"{name}{mark} = dict(enumerate({source}))")
        if array.name in self._angles:
            for i, mark in enumerate("cs"):
                self._line(f"{name}{mark} = {{k: p[{i}] for k, p in enumerate(given.circles[{array.name!r}])}}")

    def _declare(self, name: str, size: int, is_constant: bool = False) -> None:
        self._arrays[name], self._sizes[name] = f"A{len(self._arrays)}", size
        if is_constant:
            self._constant.add(name)

    def _points(self, name: str) -> tuple[str, ...]:
        return ("c", "s") if name in self._angles else ()

    def _line(self, text: str) -> None:
        self._lines.append(" " * self._depth + text)

    @contextmanager
    def _indented(self) -> Iterator[None]:
        self._depth += 1
        self._argument_of_j = ""
        yield
        self._argument_of_j = ""
        self._depth -= 1

    def _statements(self, statements: Iterable[Statement]) -> None:
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    self._operation(result, kind, args)
                case Store(cell, value):
                    self._store(cell, value)
                case SinCos():
                    self._sincos(statement)
                case For():
                    self._loop(statement)
                case Call():
                    self._call(statement)

    def _local(self, name: str, marks: Iterable[str]) -> str:
        known = self._locals.get(name)
        variable = known[0] if known else f"L{len(self._locals)}"
        self._locals[name] = (variable, tuple(marks))
        return variable

    def _parts(self, operand: Operand) -> Parts:
        """A value and those of its derivatives that are not zero."""
        match operand:
            case Const(value):
                return {"": str(exact(value))}
            case Local(name):
                variable, marks = self._locals.get(name, (f"unknown_{len(self._locals)}", ("",)))
                return {mark: variable + mark for mark in marks}
            case Cell(name, index):
                at = f"[{index_text(index)}]"
                marks = ("",) if name in self._constant else self._marks
                return {mark: f"{self._arrays[name]}{mark}{at}" for mark in marks}

    def _circle(self, operand: Operand) -> tuple[str, str]:
        """Cosine and sine of an angle."""
        match operand:
            case Const(value):
                self._line(f"c{len(self._lines)}, s{len(self._lines)} = at.atom({exact(value)})")
                return f"c{len(self._lines) - 1}", f"s{len(self._lines) - 1}"
            case Local(name):
                variable = self._locals[name][0] if name in self._locals else "unknown"
                return f"{variable}c", f"{variable}s"
            case Cell(name, index):
                return f"{self._arrays[name]}c[{index_text(index)}]", f"{self._arrays[name]}s[{index_text(index)}]"

    def _operation(self, result: str, kind: str, args: tuple[Operand, ...]) -> None:
        values = [self._parts(arg) for arg in args]
        if kind in ("sin", "cos"):
            cosine, sine = self._circle(args[0])
            value, slope = (sine, cosine) if kind == "sin" else (cosine, f"-{sine}")
            made = chained(self._line, self._marks, values[0], value, slope, f"-({value})")
        elif kind.startswith("besselj"):
            made = self._bessel(int(kind[-1]), values[0])
        elif kind == "div":
            made = multiplied(values[0], self._inverse(values[1]), self._marks)
        elif kind == "sqrt":
            self._line(f"r = at.root({values[0]['']} % {PRIME})")
            made = chained(self._line, self._marks, values[0], "r", "inverse(2 * r)", "-inverse(4 * r * r * r)")
        elif kind in ("tanh", "lncosh"):
            made = self._hyperbolic(kind, values[0])
        elif kind == "mul":
            made = multiplied(values[0], values[1], self._marks)
        else:
            made = added(values, kind)
        points = self._points_of(kind, args, made) if result in self._angles else {}
        variable = self._local(result, [mark for mark in self._marks if mark in made])
        for mark, text in (made | points).items():
            self._line(f"{variable}{mark} = {text}")

    def _hyperbolic(self, kind: str, x: Parts) -> Parts:
        """tanh with tanh' = 1 - tanh^2, or ln cosh, whose derivative tanh is."""
        self._line(f"y = at.tanh({x['']} % {PRIME})")
        if kind == "tanh":
            return chained(self._line, self._marks, x, "y", f"(1 - y * y) % {PRIME}", f"-2 * y * (1 - y * y) % {PRIME}")
        self._line(f"z = at.log_cosh({x['']} % {PRIME})")
        return chained(self._line, self._marks, x, "z", "y", f"(1 - y * y) % {PRIME}")

    def _inverse(self, x: Parts) -> Parts:
        self._line(f"i = inverse({x['']})")
        made = chained(self._line, self._marks, x, "i", f"-i * i % {PRIME}", f"2 * i * i % {PRIME} * i")
        for mark in [mark for mark in made if mark]:
            self._line(f"i{mark} = {made[mark]}")
        return {mark: f"i{mark}" for mark in made}

    def _bessel(self, order: int, x: Parts) -> Parts:
        """J_n, and J_n' = (J_{n-1} - J_{n+1}) / 2."""
        if "m" in self._marks:
            raise NotImplementedError("second derivatives of Bessel functions")
        # One look-up serves all orders of one argument: values are assigned once, so equal texts are equal within a block.
        if self._argument_of_j != x[""]:
            self._line(f"j = at.bessel({x['']} % {PRIME})")
            self._argument_of_j = x[""]
        slope = "-j[1]" if order == 0 else f"(j[{order - 1}] - j[{order + 1}]) * {(PRIME + 1) // 2} % {PRIME}"
        return chained(self._line, self._marks, x, f"j[{order}]", slope, "")

    def _points_of(self, kind: str, args: tuple[Operand, ...], made: Parts) -> Parts:
        """The point of the circle that the result of an operation has as an angle."""
        if kind in ("add", "sub"):
            (c, s), (C, S) = map(self._circle, args)
            sign = {"add": ("-", "+"), "sub": ("+", "-")}[kind]
            return {
                "c": f"({c} * {C} {sign[0]} {s} * {S}) % {PRIME}",
                "s": f"({s} * {C} {sign[1]} {c} * {S}) % {PRIME}",
            }
        if kind == "neg":
            cosine, sine = self._circle(args[0])
            return {"c": cosine, "s": f"-{sine}"}
        if (multiple := whole_multiple(kind, args)) is not None:
            return self._multiple(*multiple)
        self._line(f"c, s = at.atom(({made['']}) % {PRIME})")
        return {"c": "c", "s": "s"}

    def _multiple(self, times: int, angle: Operand) -> Parts:
        """The point of an integer multiple of an angle."""
        cosine, sine = self._circle(angle)
        self._line("c, s = 1, 0")
        self._line(f"for _ in range({abs(times)}):")
        with self._indented():
            self._line(f"c, s = (c * {cosine} - s * {sine}) % {PRIME}, (s * {cosine} + c * {sine}) % {PRIME}")
        return {"c": "c", "s": "s" if times > 0 else "-s"}

    def _store(self, cell: Cell, value: Operand) -> None:
        name, at, parts = self._arrays[cell.array], index_text(cell.index), self._parts(value)
        for mark in self._marks:
            self._line(f"{name}{mark}[{at}] = {parts.get(mark, '0')}")
        if cell.array in self._angles:
            for mark, text in zip("cs", self._circle(value), strict=True):
                self._line(f"{name}{mark}[{at}] = {text}")

    def _sincos(self, statement: SinCos) -> None:
        """Sines and cosines of a run of cells: the points that the angles have."""
        sine, cosine, angle = (self._arrays[name] for name in (statement.sine, statement.cosine, statement.angle))
        self._line(f"for k in range({statement.count}):")
        with self._indented():
            at = f"[k + {statement.offset}]"
            self._line(f"s, c = {angle}s{at}, {angle}c{at}")
            self._line(f"{sine}[k], {cosine}[k] = s, c")
            for mark in self._marks[1:3]:
                self._line(f"{sine}{mark}[k] = c * {angle}{mark}{at} % {PRIME}")
                self._line(f"{cosine}{mark}[k] = -s * {angle}{mark}{at} % {PRIME}")
            if "m" in self._marks:
                self._line(f"d, e = {angle}m{at}, {angle}a{at} * {angle}b{at}")
                self._line(f"{sine}m[k] = (c * d - s * e) % {PRIME}")
                self._line(f"{cosine}m[k] = (-s * d - c * e) % {PRIME}")

    def _loop(self, loop: For) -> None:
        """Carried scalars hold all derivatives, whether their first values do or not."""
        for carry in loop.carries:
            parts, points = self._parts(carry.initial), self._carried_points(carry.name, carry.initial)
            variable = self._local(carry.name, self._marks)
            for mark, text in ({mark: parts.get(mark, "0") for mark in self._marks} | points).items():
                self._line(f"{variable}{mark} = {text}")
        bounds = f"{index_text(loop.start)}, {index_text(loop.stop)}, {loop.step}"
        self._line(f"for I_{loop.variable} in range({bounds}):")
        with self._indented():
            self._statements(loop.body)
            left: list[str] = []
            right: list[str] = []
            for carry in loop.carries:
                parts, points = self._parts(carry.following), self._carried_points(carry.name, carry.following)
                variable = self._locals[carry.name][0]
                for mark, text in ({mark: parts.get(mark, "0") for mark in self._marks} | points).items():
                    left.append(f"{variable}{mark}")
                    right.append(text)
            self._line(f"{', '.join(left)} = {', '.join(right)}" if left else "pass")

    def _carried_points(self, name: str, value: Operand) -> Parts:
        return dict(zip("cs", self._circle(value), strict=True)) if name in self._angles else {}

    def _call(self, statement: Call) -> None:
        """Another Program's results, as values alone."""
        callee = self._program.callees[statement.callee]
        arrays = [(array, array.name) for array in callee.params]
        arrays += zip(callee.inputs, statement.inputs, strict=True)
        values, circles = [], []
        for array, name in arrays:
            own = self._arrays[name]
            values.append(f"{array.name!r}: flat({own}, {array.size})")
            if name in self._angles:
                circles.append(f"{array.name!r}: [({own}c[k], {own}s[k]) for k in range({array.size})]")
        self._line(f"o = callees[{statement.callee!r}](Given({{{', '.join(values)}}}, {{{', '.join(circles)}}}), at)")
        for array, name in zip(callee.outputs, statement.outputs, strict=True):
            self._line(f"{self._arrays[name]} = dict(enumerate(o[{array.name!r}][0]))")
