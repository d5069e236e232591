"""Taylor recurrences: the Lagrangian's residual along the coefficients that they give vanishes as a truncated power series.

The recurrences are run in the field, sums formed exactly, 1/(n + 1) modular, in time scaled by a random rho. With
q(t), q'(t), q''(t) the series that come out, T, V and R are evaluated in power-series arithmetic with nilpotent directions
(`proof.lagrange`), and every coefficient of

    [d/dt dT/dx' - dT/dx + dV/dx].dx + dR/drate.eta - u.eta

must vanish, with q' the derivative of q and in space q.q = 1. Columns must be the derivatives of the recurrences themselves, which
run once more on dual numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Final

from phichain.ir.interpret import run
from phichain.ir.nodes import Program
from phichain.lowering.series.forced import push_of, with_inputs
from phichain.lowering.series.run import Arithmetic, Expanded, Row, expand, expand_along, expand_column
from phichain.lowering.series.series import Series
from phichain.lowering.series.varied import varied_parameters
from phichain.proof.case import Subject, Wrong, nothing
from phichain.proof.lagrange import ENERGIES, Judge
from phichain.proof.modular.compiled import FAULTS, Given
from phichain.proof.modular.field import PRIME, Vector, dot, exact, inverse, plus
from phichain.proof.modular.points import Point
from phichain.proof.modular.power_series import Coefficients, Jet, PowerSeries
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
            Subject(program) for program in (series.tangent, series.factor_along, series.order_along) if program is not None
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


def recurrences(made: Recurrences, judge: Judge, point: Point) -> None:
    """Hold the recurrences at a point.

    Raises:
        Wrong: the motion they expand is not the Lagrangian's, or a column no derivative of it.
    """
    start = _Start(made, judge, point)
    found = start.expanded(start.values())
    _consistent(judge, point, found)
    _no_residual(judge, point, found, start)
    if made.columns is not None:
        _columns(start, found)
    if made.series.order_along is not None:
        _along(start, found)


@dataclass(frozen=True)
class _Start:
    """Where a step starts: the point's state in scaled time."""

    made: Recurrences
    judge: Judge
    point: Point

    @property
    def rho(self) -> int:
        """The unit of time."""
        return self.point.free("rho", 1)[0]

    @property
    def rate(self) -> Vector:
        """x' in scaled time."""
        return [self.rho * entry % PRIME for entry in self.judge.turned(self.point, self.point.v)]

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

    def expanded(
        self, arithmetic: Arithmetic, wrap: Callable[[str, Vector], Row] = lambda name, values: list(values)
    ) -> Expanded:
        """The coefficients in some arithmetic."""
        point = self.point
        rows = {
            name: wrap(name, values)
            for name, values in {"q": point.q, "v": self.rate, "u": point.u, "force": self.force, **point.parameters}.items()
        }
        return expand(self.made.series, arithmetic, ORDERS, rho=Fraction(self.rho), **rows)

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


def _consistent(judge: Judge, point: Point, found: Expanded) -> None:
    """q' is the derivative of q; unit vectors stay unit vectors."""
    size = point.scene.nq
    for n in range(ORDERS):
        for i in range(size):
            if ((n + 1) * found.state[n + 1][i] - found.state[n][size + i]) % PRIME:
                raise Wrong(f"next[{i}] at order {n}")
    if judge.scene.is_planar:
        return
    for first in range(point.carts, size, 3):
        links = [row[first : first + 3] for row in found.state]
        for n in range(1, ORDERS + 1):
            if sum(dot(links[j], links[n - j]) for j in range(n + 1)) % PRIME:
                raise Wrong(f"the length of next[{first}] to [{first + 2}] at order {n - 1}")


def _no_residual(judge: Judge, point: Point, found: Expanded, start: _Start) -> None:
    """Lagrange and d'Alembert's principle along the series, in true time."""
    ring, size, over, (view, inputs) = PowerSeries(ORDERS, point.tanh, point.root), point.scene.nq, inverse(start.rho), start.inputs
    rows = [[row[i] for row in found.state] for i in range(2 * size)]
    q = [row[:ORDERS] for row in rows[:size]]
    rate = [[over * entry % PRIME for entry in row[:ORDERS]] for row in rows[size:]]
    square = over * over % PRIME
    second = [[square * (n + 1) % PRIME * row[n + 1] % PRIME for n in range(ORDERS)] for row in rows[size:]]
    told = point.carts if judge.scene.is_driven else 0
    turn = [*[0] * told, *point.tangent("turn")[told:]]
    still = [[entry, *[0] * (ORDERS - 1)] for entry in turn]
    shift, omega = still, rate
    if not judge.scene.is_planar:
        carts = point.carts
        shift = [*still[:carts], *_crossed(ring, still[carts:], q[carts:])]
        omega = [*rate[:carts], *_crossed(ring, q[carts:], rate[carts:])]
        # Dampers work along what stays across the links.
        still = [*still[:carts], *_crossed(ring, q[carts:], shift[carts:])]

    # Along time (a), along the virtual displacement as rates (b) and as a change of place (c).
    directions = {
        "a": {"q": rate, judge.rate: second},
        "b": {"v": still, judge.rate: shift},
        "c": {"q": shift},
    }
    held = [0] * (ORDERS - 1)
    base = {name: [[entry, *held] for entry in rates] for name, rates in judge.drift(point).items()}
    directions["a"] |= {name: inputs[: view.base_inputs] for name in base}
    arguments = {name: [ring.constant(entry) for entry in entries] for name, entries in point.parameters.items()}
    for name, series in {"q": q, "v": omega, judge.rate: rate, **base}.items():
        arguments[name] = []
        for i, entry in enumerate(series):
            parts = {"": entry} | {mark: rows[name][i] for mark, rows in directions.items() if name in rows}
            circle = point.circles[i] if judge.scene.is_planar and name == "q" else None
            arguments[name].append(Jet(parts, circle))
    energies = run(judge.energy_program, ring.algebra, arguments)
    kinetic, potential, dissipation = (energies[name][0].parts for name in ENERGIES)
    zeros = [0] * ORDERS
    work = [
        kinetic.get("m", zeros), [-x for x in kinetic.get("c", zeros)], potential.get("c", zeros), dissipation.get("b", zeros),
    ]  # fmt: skip
    _told(judge, point, second, inputs)
    push = [(inputs[view.base_accelerations + i], turn[at]) for i, at in enumerate(view.driven)]
    for n, entries in enumerate(zip(*work, strict=True)):
        if (sum(entries) - sum(force[n] * along for force, along in push)) % PRIME:
            raise Wrong(f"the accelerations of order {n}")


def _told(judge: Judge, point: Point, second: list[Coefficients], inputs: list[Coefficients]) -> None:
    """A cart that is driven by its acceleration has x'' = u."""
    for axis in range(point.carts if judge.scene.is_driven else 0):
        for n, entry in enumerate(second[axis]):
            if (entry - inputs[axis][n]) % PRIME:
                raise Wrong(f"the cart's acceleration of order {n}")


def _crossed(ring: PowerSeries, a: list[Coefficients], b: list[Coefficients]) -> list[Coefficients]:
    """a_k x b_k for every link."""
    found: list[Coefficients] = []
    for k in range(0, len(a), 3):
        for i in range(3):
            one, other = (i + 1) % 3 + k, (i + 2) % 3 + k
            found.append(plus(ring.times(a[one], b[other]), ring.times(a[other], b[one]), -1))
    return found


def _columns(start: _Start, base: Expanded) -> None:
    """Along a variation that is tangent to the states, columns are what dual numbers give."""
    point = start.point
    dq, dv = _tangent(start)
    found = expand_column(start.made.series, start.values(), base, dq, dv, **point.parameters)
    slopes = {"q": dq, "v": dv}
    true = start.expanded(
        start.duals(),
        lambda name, values: list(zip(values, slopes.get(name, [0] * len(values)), strict=True)),
    )
    for n, (row, pairs) in enumerate(zip(found.state, true.state, strict=True)):
        for i, (entry, (_, slope)) in enumerate(zip(row, pairs, strict=True)):
            if (entry - slope) % PRIME:
                raise Wrong(f"a column's next[{i}] at order {n - 1}")


def _along(start: _Start, base: Expanded) -> None:
    """Along a variation of state, parameters and forcing, columns are what dual numbers give."""
    point = start.point
    (dq, dv), varied = _tangent(start), varied_parameters(point.scene)
    moved = {name: point.free(f"d_{name}", len(point.parameters[name])) for name in varied}
    d_force = point.free("d_force", ORDERS) if start.made.series.is_forced else []
    found = expand_along(start.made.series, start.values(), base, dq, dv, moved, d_force, **point.parameters)
    slopes = {"q": dq, "v": dv, "force": d_force, **moved}
    true = start.expanded(
        start.duals(),
        lambda name, values: list(zip(values, slopes.get(name, [0] * len(values)), strict=True)),
    )
    for n, (row, pairs) in enumerate(zip(found.state, true.state, strict=True)):
        for i, (entry, (_, slope)) in enumerate(zip(row, pairs, strict=True)):
            if (entry - slope) % PRIME:
                raise Wrong(f"next[{i}] at order {n - 1} of a derivative by parameters")


def _tangent(start: _Start) -> tuple[Vector, Vector]:
    """(dq, dv) with q.dq = 0 and q.dv + v.dq = 0 for every link."""
    point, judge, rate = start.point, start.judge, start.rate
    dq, dv = judge.turned(point, point.free("dq")), judge.turned(point, point.free("dv"))
    if judge.scene.is_planar:
        return dq, dv
    for k in range(point.carts, point.scene.nq, 3):
        at = slice(k, k + 3)
        dv[at] = plus(dv[at], point.q[at], -dot(rate[at], dq[at]))
    return dq, dv
