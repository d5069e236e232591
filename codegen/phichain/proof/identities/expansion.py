"""What recurrences are run on: their Programs, compiled when they are first run, and the state where a step starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Final

from phichain.ir.nodes import Program
from phichain.lowering.series.forced import push_of, with_inputs
from phichain.lowering.series.run import Arithmetic, Expanded, Row, expand
from phichain.lowering.series.series import LOST, Series
from phichain.proof.case import Subject, Wrong, nothing
from phichain.proof.lagrange import Judge
from phichain.proof.modular.compiled import FAULTS, Given
from phichain.proof.modular.field import PRIME, Vector, exact, inverse, plus
from phichain.proof.modular.points import Point
from phichain.proof.modular.power_series import Coefficients
from phichain.scene import Scene

ORDERS: Final = 5
"""So many orders are held: an order takes part in all that follow, and what depends on its number is a fraction of small degree."""


@dataclass(frozen=True)
class Recurrences:
    """A `Series`, its Programs compiled when they are first run."""

    series: Series
    factor: Subject
    order: Subject
    columns: Subject | None
    others: tuple[Subject, ...]
    moving: Mapping[str, Subject]

    @staticmethod
    def of(series: Series) -> Recurrences:
        """Nothing is compiled yet."""
        columns = None if series.columns is None else Subject(series.columns)
        others = tuple(
            Subject(program)
            for program in (series.tangent, series.factor_along, series.order_along, series.order_shared, series.outright)
            if program is not None
        )
        moving = {program.name: Subject(_all_inputs(program)) for program in (series.factor, series.order)}
        return Recurrences(series, Subject(series.factor), Subject(series.order), columns, others, moving)

    def subject(self, program: Program) -> Subject:
        """The one that compiles a Program of the series."""
        known = [subject for subject in (self.factor, self.order, self.columns, *self.others) if subject is not None]
        return next(subject for subject in known if subject.program is program)


def _all_inputs(program: Program) -> Program:
    """A Program whose parameters are inputs, which can move."""
    return replace(program, params=(), inputs=(*program.params, *program.inputs))


@dataclass(frozen=True)
class Start:
    """Where a step starts: the point's state in scaled time.

    Attributes:
        lost: what rounding took from the state; empty for nothing.
    """

    made: Recurrences
    judge: Judge
    point: Point
    lost: Vector = field(default_factory=list)

    @property
    def rho(self) -> int:
        """The unit of time."""
        return self.point.free("rho", 1)[0]

    @property
    def rate(self) -> Vector:
        """x' in scaled time."""
        return [self.rho * entry % PRIME for entry in self.judge.turned(self.point, self.point.v)]

    @property
    def takes_lost(self) -> bool:
        """Whether the recurrences look at what rounding took."""
        return any(array.name == LOST for array in self.made.series.factor.inputs)

    @property
    def force(self) -> Vector:
        """The forcing's coefficients, any numbers: the recurrences know nothing of cosines."""
        return self.point.free("force", ORDERS) if self.made.series.is_forced else []

    @cached_property
    def inputs(self) -> tuple[Scene, list[Coefficients]]:
        """A scene with an input where the chain is forced, and the series of all inputs: held, the forcing beside."""
        scene, later = self.point.scene, [0] * (ORDERS - 1)
        if not self.made.series.is_forced:
            return scene, [[entry, *later] for entry in self.point.u]
        view, known = with_inputs(scene), dict(zip(scene.u_names, self.point.u, strict=True))
        push = push_of(scene, view)
        rows = [[known.get(name, 0), *later] for name in view.u_names]
        return view, [plus(row, self.force, push.get(i, 0)) for i, row in enumerate(rows)]

    @property
    def given(self) -> dict[str, Vector]:
        """What coefficients are expanded from."""
        point = self.point
        lost = self.lost or [0] * (2 * point.scene.nq)
        return {"q": point.q, "v": self.rate, "u": point.u, "force": self.force, "lost": lost, **point.parameters}

    def expanded(
        self, arithmetic: Arithmetic, wrap: Callable[[str, Vector], Row] = lambda name, values: list(values), orders: int = ORDERS
    ) -> Expanded:
        """The coefficients in some arithmetic."""
        rows = {name: wrap(name, values) for name, values in self.given.items()}
        return expand(self.made.series, arithmetic, orders, rho=Fraction(self.rho), **rows)

    def values(self) -> Arithmetic:
        """Elements of the field."""

        def go(program: Program, given: Mapping[str, Sequence[int]]) -> dict[str, Vector]:
            made = self._ran(
                lambda: self.made.subject(program).values(Given(given, self._circles()), self.point)
            )
            return {name: parts[0] for name, parts in made.items()}

        return Arithmetic(go, exact, lambda pairs: sum(a * b for a, b in pairs) % PRIME, inverse)

    def duals(self) -> Arithmetic:
        """Pairs of an element and its derivative."""

        def go(
            program: Program, given: Mapping[str, Sequence[tuple[int, int]]]
        ) -> dict[str, list[tuple[int, int]]]:
            values = {name: [x for x, _ in entries] for name, entries in given.items()}
            along = {name: [dx for _, dx in entries] for name, entries in given.items()}
            subject = self.made.moving[program.name]
            made = self._ran(lambda: subject.slopes(Given(values, self._circles(), along=along), self.point))
            return {name: list(zip(*parts, strict=True)) for name, parts in made.items()}

        def total(pairs: Any) -> tuple[int, int]:
            value = slope = 0
            for (x, dx), (y, dy) in pairs:
                value += x * y
                slope += x * dy + dx * y
            return value % PRIME, slope % PRIME

        def over(x: tuple[int, int]) -> tuple[int, int]:
            first = inverse(x[0])
            return first, -first * first * x[1] % PRIME

        return Arithmetic(go, lambda value: (exact(value), 0), total, over)

    def _circles(self) -> dict[str, Any]:
        return {"q": self.point.circles} if self.point.scene.is_planar else {}

    def _ran(self, run: Callable[[], dict[str, tuple[list[int], ...]]]) -> dict[str, tuple[list[int], ...]]:
        try:
            return run()
        except FAULTS as fault:
            raise Wrong(f"no coefficients at all, for {nothing(fault)}") from fault
