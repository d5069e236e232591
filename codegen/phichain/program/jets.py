"""Program -> Taylor recurrences: two Programs that compute the Taylor coefficients of its outputs order by order.

Along a motion every value of a Program is a power series in time, x(t) = sum x_n h^n. Of its operations only products (and
what is made of them) mix orders:

    c = a b        c_n = a_0 b_n + a_n b_0 + S_n(a, b),          S_n(a, b) = sum_{0<j<n} a_j b_{n-j}
    c = a^2        c_n = 2 a_0 a_n + S_n(a, a)                    (half the terms)
    r = a / b      r_n = (a_n - r_0 b_n - S_n(r, b)) / b_0
    s = sqrt a     s_n = (a_n - S_n(s, s)) / (2 s_0)
    s = sin x      s_n = x_n c_0 + S_n(x', c) / n,    c = cos x      c_n = -x_n s_0 - S_n(x', s) / n,    x'_j = j x_j

(Griewank & Walther 2008, section 13.2). S_n needs orders below n alone, so all sums of an order are known before the order
begins. That splits the work in two: the sums, one lane for each product, side by side in memory and so vectorised across
products whatever the chain's data flow is; and a linear sweep through the Program, as long as the Program itself, which
turns sums into coefficients. Both are the same text at every order, so the order is a number at run time and the code is
twice as long as the Program, not `order` times.

`start` computes order 0 and fills the first row of the lanes; `follow` computes order n from the coefficients of the
arguments, the lanes' first rows and the sums, and gives the lanes' rows of order n.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Final

from phichain.errors import DerivationError
from phichain.program.builder import ArrayRef, Builder, Expr
from phichain.program.inline import inline
from phichain.program.nodes import Affine, Array, Const, For, Local, Op, Operand, Program, SinCos, Statement, Store
from phichain.program.passes import prune
from phichain.program.varying import varying

#: Arrays of the two Programs that hold the lanes: factors of products, bases of squares, and what does not vary in time.
LEFT: Final = "jet_left"
RIGHT: Final = "jet_right"
SQUARE: Final = "jet_square"
HELD: Final = "jet_held"
#: What `follow` sees of order 0, the sums S_n, and the order itself.
FIRST: Final = "_0"
SUMS: Final = "jet_sum"
SQUARE_SUMS: Final = "jet_square_sum"
ORDER: Final = "jet_order"
INVERSE_ORDER: Final = "jet_inverse_order"


@dataclass(frozen=True)
class Jets:
    """The Taylor recurrences of a Program.

    Attributes:
        start: inputs and outputs of the Program at order 0, and the first rows of the lanes that are there.
        follow: the moving inputs' coefficients of order n >= 1 -> the outputs' coefficients, and the lanes' rows.
        products: lanes of products (LEFT times RIGHT).
        squares: lanes of squares (SQUARE times itself).
        held: values that do not vary in time, computed once by `start`.
    """

    start: Program
    follow: Program
    products: int
    squares: int
    held: int


def jets(program: Program, moving: tuple[str, ...] = ("q", "v")) -> Jets:
    """Derive the Taylor recurrences of a Program.

    Args:
        program: straight-line code, loops or calls.
        moving: the inputs that vary in time; all others, and the parameters, are held.

    Raises:
        DerivationError: an operation has no recurrence here.
    """
    plain = inline(program)
    first = _Recurrences(plain, moving, {})
    first.run()
    second = _Recurrences(plain, moving, first.wanted)
    second.run()
    return second.finish()


@dataclass(frozen=True, slots=True)
class _Value:
    """A scalar: its value at order 0, and its coefficient of order n (None where it does not vary)."""

    start: Expr
    rate: Expr | None
    operand: Operand


@dataclass
class _Lanes:
    """Cells handed out to operations, a run of them for an operation inside loops."""

    used: int = 0

    def take(self, nest: tuple[For, ...]) -> Affine:
        """The cell of this turn of the loops around."""
        index, stride = Affine(0), 1
        for loop in reversed(nest):
            low, high = loop.hull
            index = index + stride * Affine(-low, ((loop.variable, 1),))
            stride *= max(high - low + 1, 1)
        index, self.used = index + self.used, self.used + stride
        return index


@dataclass
class _Counts:
    products: _Lanes = field(default_factory=_Lanes)
    squares: _Lanes = field(default_factory=_Lanes)
    held: _Lanes = field(default_factory=_Lanes)


class _Recurrences:
    """Walks the Program once and writes both results side by side."""

    def __init__(self, program: Program, moving: tuple[str, ...], wanted: dict[str, None]) -> None:
        self.program, self.moving = program, moving
        self.varying = varying(program, moving)
        self.start = Builder(f"{program.name}_start", "Order 0 of the Taylor series.")
        self.follow = Builder(f"{program.name}_follow", "Order n of the Taylor series from the orders below.")
        #: constants in time that `follow` needs, found by a first walk; the second walk stores them.
        self.wanted, self._stored = dict(wanted), wanted
        self.held_at: dict[str, Affine] = {}
        self.lanes = _Counts()
        self.values: dict[str, _Value] = {}
        self.pairs: dict[tuple[Operand, tuple[str, ...]], tuple[_Value, _Value]] = {}
        self.nest: tuple[For, ...] = ()
        self._arguments()

    def run(self) -> None:
        self._block(self.program.body)

    def finish(self) -> Jets:
        counts = self.lanes
        sizes = {LEFT: counts.products.used, RIGHT: counts.products.used, SQUARE: counts.squares.used}
        start = _sized(self.start.finish(), {**sizes, HELD: counts.held.used})
        sizes |= {f"{name}{FIRST}": size for name, size in sizes.items()}
        sums = {SUMS: counts.products.used, SQUARE_SUMS: counts.squares.used, HELD: counts.held.used}
        follow = _sized(self.follow.finish(), sizes | sums)
        return Jets(prune(start), prune(follow), counts.products.used, counts.squares.used, counts.held.used)

    # --- arrays -------------------------------------------------------------------------------------------------------

    def _arguments(self) -> None:
        program, start, follow = self.program, self.start, self.follow
        for builder in (start, follow):
            for array in program.params:
                builder.param(array.name, array.shape, array.doc)
            for array in program.inputs:
                builder.input(array.name, array.shape, array.doc)
        for name in (f"{LEFT}{FIRST}", f"{RIGHT}{FIRST}", f"{SQUARE}{FIRST}", SUMS, SQUARE_SUMS, HELD):
            follow.input(name, (0,))
        follow.input(ORDER, (), "n")
        follow.input(INVERSE_ORDER, (), "1 / n")
        for builder in (start, follow):
            for array in program.outputs:
                builder.output(array.name, array.shape, array.doc)
            for name in (LEFT, RIGHT, SQUARE):
                builder.output(name, (0,))
            for name, values in program.tables.items():
                builder.tables[builder.fresh(name)] = values
        start.output(HELD, (0,))
        for array in program.work:
            # What is constant in time goes from `start` to `follow` as an array of its own.
            if array.name in self.varying:
                start.array(array.name, array.size)
                follow.array(array.name, array.size)
            else:
                start.output(array.name, array.shape, "constant in time")
                follow.input(array.name, array.shape, "constant in time")

    def _hold(self, value: Expr) -> Expr:
        """Compute something once, in `start`; the same in `follow`."""
        place = self.lanes.held.take(self.nest)
        self.start.write(HELD, place, value)
        return self.follow.read(HELD, place)

    def _factor(self, value: _Value) -> Expr:
        """A value that is constant in time, as `follow` sees it."""
        match value.operand:
            case Const(number):
                return self.follow.lift(number)
            case Local(name):
                self.wanted[name] = None
                return self.follow.read(HELD, self.held_at.get(name, Affine(0)))
            case cell:
                return self.follow.read(cell.array, cell.index)

    # --- statements ---------------------------------------------------------------------------------------------------

    def _block(self, statements: tuple[Statement, ...]) -> None:
        for statement in statements:
            match statement:
                case Op(result, kind, args):
                    self._bind(result, self._op(result, kind, [self._value(arg) for arg in args]))
                case Store(cell, operand):
                    value = self._value(operand)
                    self.start.write(cell.array, cell.index, value.start)
                    if cell.array in self.varying:
                        self.follow.write(cell.array, cell.index, self._rate(value))
                case SinCos():
                    self._sincos_run(statement)
                case For():
                    self._loop(statement)

    def _bind(self, name: str, value: _Value) -> None:
        self.values[name] = replace(value, operand=Local(name))
        if value.rate is None and name in self._stored:
            self.held_at[name] = place = self.lanes.held.take(self.nest)
            self.start.write(HELD, place, value.start)

    def _value(self, operand: Operand) -> _Value:
        if isinstance(operand, Const):
            return _Value(self.start.lift(operand.value), None, operand)
        if isinstance(operand, Local):
            return self.values[operand.name]
        moves = operand.array in self.varying
        rate = self.follow.read(operand.array, operand.index) if moves else None
        return _Value(self.start.read(operand.array, operand.index), rate, operand)

    def _rate(self, value: _Value) -> Expr:
        return self.follow.lift(0) if value.rate is None else value.rate

    def _loop(self, loop: For) -> None:
        firsts = [self._value(carry.initial) for carry in loop.carries]
        with self._both_loops(loop) as (start, follow):
            carried = {}
            for carry, first in zip(loop.carries, firsts, strict=True):
                moves = carry.name in self.varying
                rate = follow.carry(carry.name, self._rate(first)) if moves else None
                carried[carry.name] = _Value(start.carry(carry.name, first.start), rate, Local(carry.name))
                self._bind(carry.name, carried[carry.name])
            self._block(loop.body)
            for carry in loop.carries:
                after, value = self._value(carry.following), carried[carry.name]
                start.follow(value.start, after.start)
                if value.rate is not None:
                    follow.follow(value.rate, self._rate(after))

    @contextmanager
    def _both_loops(self, loop: For) -> Iterator[tuple]:  # type: ignore[type-arg]
        turns = loop.variable, loop.start, loop.stop, loop.step
        outside, self.nest = self.nest, (*self.nest, loop)
        with self.start.loop(*turns) as start, self.follow.loop(*turns) as follow:
            yield start, follow
        self.nest = outside

    # --- operations ---------------------------------------------------------------------------------------------------

    def _op(self, result: str, kind: str, args: list[_Value]) -> _Value:
        if kind in ("sin", "cos") and args[0].rate is not None:
            return self._sincos(args[0])[kind == "cos"]
        label = "" if result.startswith("_") else result
        value = self.start.apply(kind, *(arg.start for arg in args), label=label)
        if all(arg.rate is None for arg in args):
            return _Value(value, None, Local(result))
        rules = {"mul": self._product, "div": self._quotient, "sqrt": self._root}
        if kind in ("add", "sub", "neg"):
            rate = self.follow.apply(kind, *(self._rate(arg) for arg in args))
        elif kind in rules:
            rate = rules[kind](value, *args)
        else:
            raise DerivationError("operation", kind, "has no Taylor recurrence", "write the Program without it")
        return _Value(value, self.follow.let(label, rate) if label else rate, Local(result))

    def _product(self, value: Expr, a: _Value, b: _Value) -> Expr:
        if a.rate is None:
            return self._factor(a) * self._rate(b)
        if b.rate is None:
            return self._factor(b) * a.rate
        if a.operand == b.operand:
            base, total = self._square(a.start, a.rate)
            return total + (base + base) * a.rate
        left, right, total = self._lane(a.start, b.start)
        self.follow.write(LEFT, self._last, a.rate)
        self.follow.write(RIGHT, self._last, b.rate)
        return total + left * b.rate + right * a.rate

    def _quotient(self, value: Expr, a: _Value, b: _Value) -> Expr:
        if b.rate is None:
            return self._rate(a) * self._hold(1 / b.start)
        left, _, total = self._lane(value, b.start)
        lane = self._last
        inverse = left if a.operand == Const(1) else self._hold(1 / b.start)
        rest = total + left * b.rate
        rate = (-rest if a.rate is None else a.rate - rest) * inverse
        self.follow.write(LEFT, lane, rate)
        self.follow.write(RIGHT, lane, b.rate)
        return rate

    def _root(self, value: Expr, a: _Value) -> Expr:
        place = self.lanes.squares.take(self.nest)
        self.start.write(SQUARE, place, value)
        rate = (self._rate(a) - self.follow.read(SQUARE_SUMS, place)) * self._hold(1 / (value + value))
        self.follow.write(SQUARE, place, rate)
        return rate

    def _square(self, base: Expr, rate: Expr) -> tuple[Expr, Expr]:
        place = self.lanes.squares.take(self.nest)
        self.start.write(SQUARE, place, base)
        self.follow.write(SQUARE, place, rate)
        return self.follow.read(f"{SQUARE}{FIRST}", place), self.follow.read(SQUARE_SUMS, place)

    def _lane(self, left: Expr, right: Expr) -> tuple[Expr, Expr, Expr]:
        """A new lane: the first coefficients of its factors, and its sum S_n, as `follow` sees them."""
        self._last = place = self.lanes.products.take(self.nest)
        self.start.write(LEFT, place, left)
        self.start.write(RIGHT, place, right)
        follow = self.follow
        return follow.read(f"{LEFT}{FIRST}", place), follow.read(f"{RIGHT}{FIRST}", place), follow.read(SUMS, place)

    # --- sines and cosines --------------------------------------------------------------------------------------------

    def _sincos(self, angle: _Value) -> tuple[_Value, _Value]:
        """(sine, cosine) of one angle, made once."""
        key = angle.operand, tuple(loop.variable for loop in self.nest)
        if key not in self.pairs:
            sine, cosine = self.start.sin(angle.start), self.start.cos(angle.start)
            rates = self._sincos_rates(sine, cosine, self._rate(angle))
            values = (_Value(sine, rates[0], angle.operand), _Value(cosine, rates[1], angle.operand))
            self.pairs[key] = values
        return self.pairs[key]

    def _sincos_rates(self, sine: Expr, cosine: Expr, angle: Expr) -> tuple[Expr, Expr]:
        follow, nothing = self.follow, self.start.lift(0)
        order, inverse = follow.read(ORDER, 0), follow.read(INVERSE_ORDER, 0)
        _, first_cosine, sine_sum = self._lane(nothing, cosine)
        sine_lane = self._last
        _, first_sine, cosine_sum = self._lane(nothing, sine)
        turning = order * angle
        sine_rate = angle * first_cosine + inverse * sine_sum
        cosine_rate = -(angle * first_sine + inverse * cosine_sum)
        for lane, factor in ((sine_lane, cosine_rate), (self._last, sine_rate)):
            follow.write(LEFT, lane, turning)
            follow.write(RIGHT, lane, factor)
        return sine_rate, cosine_rate

    def _sincos_run(self, statement: SinCos) -> None:
        start, follow, count = self.start, self.follow, statement.count
        sine, cosine, angle = (_reference(start, name) for name in (statement.sine, statement.cosine, statement.angle))
        start.sincos_into(sine, cosine, angle.shifted(statement.offset), count)
        turns = For("i", Affine(0), Affine(count), 1, (), (), (0, count - 1))
        with self._both_loops(turns):
            i = Affine(0, (("i", 1),))
            turning = follow.read(statement.angle, i + statement.offset)
            rates = self._sincos_rates(sine[i], cosine[i], turning)
            follow.write(statement.sine, i, rates[0])
            follow.write(statement.cosine, i, rates[1])


def _reference(builder: Builder, name: str) -> ArrayRef:
    return ArrayRef(builder, name, 0)


def _sized(program: Program, sizes: dict[str, int]) -> Program:
    """The Program with the sizes of its lanes, now that they are known; arrays without cells are left out."""

    def resized(arrays: tuple[Array, ...]) -> tuple[Array, ...]:
        known = (replace(a, shape=(sizes[a.name],)) if a.name in sizes else a for a in arrays)
        return tuple(array for array in known if array.size)

    return replace(program, inputs=resized(program.inputs), outputs=resized(program.outputs))
