"""Program -> Taylor recurrences: two Programs that compute the Taylor coefficients of its outputs order by order.

Along a motion every value of a Program is a power series in time, x(t) = sum x_n h^n. Of its operations only products (and
what is made of them) mix orders:

    c = a b        c_n = a_0 b_n + a_n b_0 + S_n(a, b),          S_n(a, b) = sum_{0<j<n} a_j b_{n-j}
    r = a / b      r_n = (a_n - r_0 b_n - S_n(r, b)) / b_0
    s = sqrt a     s_n = (a_n - S_n(s, s)) / (2 s_0)
    s = sin x      s_n = x_n c_0 + S_n(x', c) / n,    c = cos x      c_n = -x_n s_0 - S_n(x', s) / n,    x'_j = j x_j

(Griewank & Walther 2008, section 13.2). S_n needs orders below n alone, so all sums of an order are known before the order
begins. That splits the work in two: the sums, one lane for each product, side by side in memory and so vectorised across
products whatever the chain's data flow is; and a linear sweep through the Program, as long as the Program itself, which
turns sums into coefficients. Both are the same text at every order, so the order is a number at run time and the code is
twice as long as the Program, not `order` times.

`start` computes order 0 and fills the first row of the lanes; `follow` computes order n from the coefficients of the
arguments, the lanes' rows of order 0 and the sums, and gives the lanes' rows of order n.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction

from phichain.errors import DerivationError
from phichain.ir.builder import ArrayRef, Builder, Expr, Loop
from phichain.ir.inline import inline
from phichain.ir.nodes import Affine, Const, For, Local, Op, Operand, Program, SinCos, Statement, Store
from phichain.ir.passes import prune
from phichain.ir.varying import varying
from phichain.transform.lanes import (
    FIRST,
    HELD,
    INVERSE_ORDER,
    LEFT,
    ORDER,
    RIGHT,
    SUMS,
    Counts,
    Jets,
    Lane,
    Value,
    sized,
)


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
        self.lanes = Counts()
        self.values: dict[str, Value] = {}
        self.pairs: dict[tuple[Operand, tuple[str, ...]], tuple[Value, Value]] = {}
        self.nest: tuple[For, ...] = ()
        self._arguments()

    def run(self) -> None:
        self._block(self.program.body)

    def finish(self) -> Jets:
        products, held = self.lanes.products.used, self.lanes.held.used
        sizes = {name + row: products for name in (LEFT, RIGHT) for row in ("", FIRST)}
        sizes |= {SUMS: products, HELD: held}
        start, follow = (prune(sized(builder.finish(), sizes)) for builder in (self.start, self.follow))
        return Jets(start, follow, products, held)

    # --- arrays -------------------------------------------------------------------------------------------------------

    def _arguments(self) -> None:
        program, start, follow = self.program, self.start, self.follow
        for builder in (start, follow):
            for array in program.params:
                builder.param(array.name, array.shape, array.doc)
            for array in program.inputs:
                builder.input(array.name, array.shape, array.doc)
        for name in (LEFT + FIRST, RIGHT + FIRST, SUMS, HELD):
            follow.input(name, (0,))
        follow.input(ORDER, (), "n")
        follow.input(INVERSE_ORDER, (), "1 / n")
        for builder in (start, follow):
            for array in program.outputs:
                builder.output(array.name, array.shape, array.doc)
            for name in (LEFT, RIGHT):
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

    def _factor(self, value: Value) -> Expr:
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

    def _bind(self, name: str, value: Value) -> None:
        self.values[name] = replace(value, operand=Local(name))
        if value.rate is None and name in self._stored:
            self.held_at[name] = place = self.lanes.held.take(self.nest)
            self.start.write(HELD, place, value.start)

    def _value(self, operand: Operand) -> Value:
        if isinstance(operand, Const):
            return Value(self.start.lift(operand.value), None, operand)
        if isinstance(operand, Local):
            return self.values[operand.name]
        moves = operand.array in self.varying
        rate = self.follow.read(operand.array, operand.index) if moves else None
        return Value(self.start.read(operand.array, operand.index), rate, operand)

    def _rate(self, value: Value) -> Expr:
        return self.follow.lift(0) if value.rate is None else value.rate

    def _loop(self, loop: For) -> None:
        firsts = [self._value(carry.initial) for carry in loop.carries]
        with self._both_loops(loop) as (start, follow):
            carried = {}
            for carry, first in zip(loop.carries, firsts, strict=True):
                moves = carry.name in self.varying
                rate = follow.carry(carry.name, self._rate(first)) if moves else None
                carried[carry.name] = Value(start.carry(carry.name, first.start), rate, Local(carry.name))
                self._bind(carry.name, carried[carry.name])
            self._block(loop.body)
            for carry in loop.carries:
                after, value = self._value(carry.following), carried[carry.name]
                start.follow(value.start, after.start)
                if value.rate is not None:
                    follow.follow(value.rate, self._rate(after))

    @contextmanager
    def _both_loops(self, loop: For) -> Iterator[tuple[Loop, Loop]]:
        turns = loop.variable, loop.start, loop.stop, loop.step
        outside, self.nest = self.nest, (*self.nest, loop)
        with self.start.loop(*turns) as start, self.follow.loop(*turns) as follow:
            yield start, follow
        self.nest = outside

    # --- operations ---------------------------------------------------------------------------------------------------

    def _op(self, result: str, kind: str, args: list[Value]) -> Value:
        if kind in ("sin", "cos") and args[0].rate is not None:
            return self._sincos(args[0])[kind == "cos"]
        label = "" if result.startswith("_") else result
        value = self.start.apply(kind, *(arg.start for arg in args), label=label)
        if all(arg.rate is None for arg in args):
            return Value(value, None, Local(result))
        rate = self._series(kind, value, args)
        return Value(value, self.follow.let(label, rate) if label else rate, Local(result))

    def _series(self, kind: str, value: Expr, args: list[Value]) -> Expr:
        """Coefficient n of an operation whose value at order 0 is `value`."""
        match kind:
            case "add" | "sub" | "neg":
                return self.follow.apply(kind, *(self._rate(arg) for arg in args))
            case "mul":
                return self._product(*args)
            case "div":
                return self._quotient(value, *args)
            case "sqrt":
                return self._root(value, *args)
        raise DerivationError("operation", kind, "has no Taylor recurrence", "write the Program without it")

    def _product(self, a: Value, b: Value) -> Expr:
        if a.rate is None:
            return self._factor(a) * self._rate(b)
        if b.rate is None:
            return self._factor(b) * a.rate
        lane = self._lane(a.start, b.start)
        self._put(lane, a.rate, b.rate)
        if a.operand == b.operand:
            return lane.total + (lane.left + lane.left) * a.rate
        return lane.total + lane.left * b.rate + lane.right * a.rate

    def _quotient(self, value: Expr, a: Value, b: Value) -> Expr:
        if b.rate is None:
            return self._rate(a) * self._hold(1 / b.start)
        lane = self._lane(value, b.start)
        inverse = lane.left if a.operand == Const(Fraction(1)) else self._hold(1 / b.start)
        rest = lane.total + lane.left * b.rate
        rate = (-rest if a.rate is None else a.rate - rest) * inverse
        self._put(lane, rate, b.rate)
        return rate

    def _root(self, value: Expr, a: Value) -> Expr:
        lane = self._lane(value, value)
        rate = (self._rate(a) - lane.total) * self._hold(1 / (value + value))
        self._put(lane, rate, rate)
        return rate

    def _lane(self, left: Expr, right: Expr) -> Lane:
        """A new lane with its first coefficients."""
        place = self.lanes.products.take(self.nest)
        self.start.write(LEFT, place, left)
        self.start.write(RIGHT, place, right)
        read = self.follow.read
        return Lane(place, read(LEFT + FIRST, place), read(RIGHT + FIRST, place), read(SUMS, place))

    def _put(self, lane: Lane, left: Expr, right: Expr) -> None:
        """The factors' coefficients of order n."""
        self.follow.write(LEFT, lane.place, left)
        self.follow.write(RIGHT, lane.place, right)

    # --- sines and cosines --------------------------------------------------------------------------------------------

    def _sincos(self, angle: Value) -> tuple[Value, Value]:
        """(sine, cosine) of one angle, made once."""
        key = angle.operand, tuple(loop.variable for loop in self.nest)
        if key not in self.pairs:
            sine, cosine = self.start.sin(angle.start), self.start.cos(angle.start)
            rates = self._sincos_rates(sine, cosine, self._rate(angle))
            values = (Value(sine, rates[0], angle.operand), Value(cosine, rates[1], angle.operand))
            self.pairs[key] = values
        return self.pairs[key]

    def _sincos_rates(self, sine: Expr, cosine: Expr, angle: Expr) -> tuple[Expr, Expr]:
        follow, nothing = self.follow, self.start.lift(0)
        order, inverse = follow.read(ORDER, 0), follow.read(INVERSE_ORDER, 0)
        of_sine, of_cosine = self._lane(nothing, cosine), self._lane(nothing, sine)
        turning = order * angle
        sine_rate = angle * of_sine.right + inverse * of_sine.total
        cosine_rate = -(angle * of_cosine.right + inverse * of_cosine.total)
        self._put(of_sine, turning, cosine_rate)
        self._put(of_cosine, turning, sine_rate)
        return sine_rate, cosine_rate

    def _sincos_run(self, statement: SinCos) -> None:
        start, follow, count = self.start, self.follow, statement.count
        sine, cosine = ArrayRef(start, statement.sine, count), ArrayRef(start, statement.cosine, count)
        start.sincos_into(sine, cosine, ArrayRef(start, statement.angle, count, statement.offset), count)
        turns = For("i", Affine(0), Affine(count), 1, (), (), (0, count - 1))
        with self._both_loops(turns):
            i = Affine(0, (("i", 1),))
            turning = follow.read(statement.angle, i + statement.offset)
            rates = self._sincos_rates(sine[i], cosine[i], turning)
            follow.write(statement.sine, i, rates[0])
            follow.write(statement.cosine, i, rates[1])
