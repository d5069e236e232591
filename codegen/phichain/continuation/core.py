"""The continuation core: problem x predictor x corrector x tests -> Branch.

From a point y with unit tangent t the predictor steps ahead, the corrector returns to the curve, and the new
tangent is the null vector of the new Jacobian. Nothing refers to a parameter, so folds are points like any other.

How far a step may go is `steps.advance`'s to say; where events lie, `locate.locate`'s; what an avoided crossing is, that of `gaps`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from phichain.continuation.branch import Branch
from phichain.continuation.compiled.strides import Behind, Stride, strides, watched, zeros_in
from phichain.continuation.engine import Engine
from phichain.continuation.events import BranchPoint, Fold, TestFunction
from phichain.continuation.met import gaps
from phichain.continuation.met.locate import locate, values_at
from phichain.continuation.met.pairs import pairs_of
from phichain.continuation.met.passage import NARROW
from phichain.continuation.met.specials import Passage, Special, is_same
from phichain.continuation.point import Point, Reached, tangent_of
from phichain.continuation.predictors import TOUCHED
from phichain.continuation.problem import Problem
from phichain.continuation.record import demand_unknowns, joined, point_of, record
from phichain.continuation.steps import StepTooSmallError, is_closed
from phichain.errors import ConvergenceError
from phichain.system import Vector

Progress = Callable[[Reached, float], None]
"""Told every new point, in unknowns, and the step that will be tried after it."""
REMEMBERED = max(3, TOUCHED)
"""Points that a run looks back on, for its predictor and for a gap."""
_SEEN = 3
"""Points before a step that help to find events in it."""
_SHORTEST = 4
"""Points of the shortest loop."""


def start_on(problem: Problem, z: Vector, direction: Vector, engine: Engine, *, fixed: bool = False) -> Point:
    """The first point: Newton from z in the plane through z across `direction`.

    Args:
        problem: What is continued.
        z: A guess (n + 1,).
        direction: Where the branch is to go (n + 1,), in unknowns; its tangent is turned that way.
        engine: Corrector and options.
        fixed: True takes `direction` itself as the plane's normal, so that direction . z is kept; else the tangent
            at the guess is.

    Raises:
        ArrayError: Wrong shapes.
        ConvergenceError: Newton did not converge.
    """
    guess = problem.check(z) / problem.sizes
    along = np.asarray(direction, dtype=float) / problem.sizes
    along = along / np.linalg.norm(along)
    normal = along if fixed else tangent_of(problem.at(guess).jacobian, along)
    found = engine.corrector(problem, guess, normal, engine.options)
    if not found.converged:
        raise ConvergenceError(
            "start",
            np.asarray(z).tolist(),
            f"Newton did not reach the branch in {found.iterations} iterations (relative residual {found.residual:.2g})",
            "start closer to a solution",
            corrections=found.corrections,
        )
    return found.point(along, 0.0)


def follow(
    problem: Problem,
    start: Point | Branch,
    engine: Engine | None = None,
    tests: Sequence[TestFunction] = (Fold(), BranchPoint()),
    name: str = "branch",
    *,
    through: float = 0.0,
    progress: Progress | None = None,
) -> Branch:
    """Follow a branch until a terminal event, its own start, the point limit, the smallest step, or Ctrl-C.

    Args:
        problem: What is continued.
        start: First point, from `start_on`; or an earlier Branch of the problem, which is gone on with bit by bit as if it had
            not ended.
        engine: Predictor, corrector and options.
        tests: Events to locate.
        name: Name of the branch.
        through: Half width, in arclength, up to which a gap is crossed to go on straight; elsewhere the run turns with its branch. One below 3e-6 is crossed in
            any case: a longer step would not tell it from a branch point.
        progress: Told every new point.

    Returns:
        The Branch; its status and reason say why it ended.
    """
    engine = engine or Engine()
    if isinstance(start, Point):
        run = _Run(problem, engine, tests, through, [start], engine.options.step, start)
    else:
        run = _resumed(problem, start, engine, tests, through)
    first = len(run.points)
    while run.status == "":
        try:
            # Whoever is told every point is told it as soon as it is found.
            run.go_on(1 if progress is not None else engine.options.max_points - len(run.points) + first - 1)
            if progress is not None:
                progress(Reached(problem.names, run.points[-1].z(problem), run.points[-1].arclength), run.step)
        except StepTooSmallError:
            run.end("step", f"a step below step_min = {engine.options.step_min:g} would be needed")
        except np.linalg.LinAlgError as failure:
            run.end("step", f"beyond the last point the Jacobian is no numbers ({failure})")
        except KeyboardInterrupt:
            run.end("interrupted", f"interrupted after {len(run.points)} points; what there is can be gone on with")
        if run.status == "" and len(run.points) - first + 1 >= engine.options.max_points:
            run.end("points", f"max_points = {engine.options.max_points} reached")
    own = record(
        problem, run.points, run.specials, run.passages, (run.status, run.reason), name, regular=run.regular, step=run.step,
        tol=engine.options.tol,
    )
    return own if isinstance(start, Point) else joined(start, own, min(start.regular, REMEMBERED))


def _resumed(problem: Problem, earlier: Branch, engine: Engine, tests: Sequence[TestFunction], through: float) -> _Run:
    """A run that stands where an earlier one stood at the last of its own points."""
    demand_unknowns(problem, earlier)
    near = range(max(0, earlier.regular - REMEMBERED), earlier.regular)
    points = [point_of(problem, earlier, k) for k in near]
    passed = [gap for gap in earlier.passages if gap.arclength >= points[0].arclength]
    crossed = [gap.arclength for gap in earlier.passages if gap.is_crossed]
    origin = int(np.argmax(earlier.arclength > crossed[-1])) if crossed else 0
    begun = point_of(problem, earlier, origin)
    return _Run(
        problem, engine, tests, through, points, earlier.step, begun, offset=near[0], passages=passed, origin=origin, known=earlier.events
    )


@dataclass
class _Run:
    """A run on its way.

    Attributes:
        offset: Index of its first point in the whole branch.
        regular: How many of its points are its own, and not where it was cut.
        start: Where the branch it is on began: its first point, or the first beyond a gap that was crossed.
        origin: Index of that point in the whole branch.
        known: Events of an earlier run that is gone on with.
        seen: Points before the last one, with the values of the tests there, on the branch that the run is on.
    """

    problem: Problem
    engine: Engine
    tests: Sequence[TestFunction]
    through: float
    points: list[Point]
    step: float
    start: Point
    offset: int = 0
    specials: list[Special] = field(default_factory=list)
    passages: list[Passage] = field(default_factory=list)
    status: str = ""
    reason: str = ""
    regular: int = 0
    origin: int = 0
    values: tuple[float, ...] = ()
    known: tuple[Special, ...] = ()
    seen: list[tuple[Point, tuple[float, ...]]] = field(default_factory=list)
    queue: list[Stride | BaseException] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.watch = watched(self.problem, self.tests, self.engine)
        self.unknown = [(k, test) for k, test in enumerate(self.tests) if self.watch is not None and not self.watch[k].what]
        self.singular = next((k for k, test in enumerate(self.tests) if isinstance(test, BranchPoint)), None)
        rows = [values_at(self.problem, point, self.tests) for point in self.points]
        self.values = rows[-1]
        own = max(0, self.origin - self.offset)
        self.seen = list(zip(self.points[own:-1], rows[own:-1], strict=True))
        self.sigma = [gaps.smallest(self.problem, point) for point in self.points]

    def end(self, status: str, reason: str) -> None:
        self.status, self.reason = status, reason
        self.regular = self.regular or len(self.points)

    @property
    def _since(self) -> int:
        """Points on this branch."""
        return self.offset + len(self.points) - self.origin

    def _next(self, most: int) -> Stride:
        """The next step, of some that were taken at once."""
        if not self.queue:
            last = self.points[-REMEMBERED:]
            values = [row for _, row in self.seen[1 - REMEMBERED :]] + [self.values]
            zeros = zeros_in(self.points[-2:], self.tests, (*self.known, *self.specials))
            behind = Behind(last, self.sigma[-REMEMBERED:], values, self.step, self._since, self.start, zeros)
            self.queue = strides(self.problem, behind, self.engine, self.watch, most)
        found = self.queue.pop(0)
        if isinstance(found, BaseException):
            raise found
        return found

    def _values(self, taken: Stride) -> tuple[float, ...]:
        """The test functions behind a step."""
        if taken.values is None:
            return values_at(self.problem, taken.point, self.tests)
        own = list(taken.values)
        for k, test in self.unknown:
            own[k] = test.value(self.problem, taken.point)
        return tuple(own)

    def go_on(self, most: int) -> None:
        """One more point, of so many that are wanted, with the events on the way to it; nothing of it is kept where it breaks off."""
        last = self.points[-1]
        try:
            taken = self._next(most)
        except StepTooSmallError:
            ahead = gaps.gap_ahead(self.problem, self.points[-3:], self.sigma[-3:])
            if ahead is None or ahead.width > NARROW or not self._cross(ahead):
                raise
            return
        new, step, values = taken.point, taken.step, self._values(taken)
        index, sizes = self.offset + len(self.points) - 1, self.problem.sizes
        if taken.is_plain and not self.unknown:
            found = [Special(self.tests[met.test].name, index, met.y * sizes, met.arclength, met.value, met.multipliers) for met in taken.met]
            self.specials += sorted(found, key=lambda event: event.arclength)
            self._take(new, values, self._sigma(new, values))
            self.step = step
            return
        found, cut = locate(self.problem, last, new, self.tests, self.engine, index, (self.values, values), self.seen[-_SEEN:], taken.through)
        sigma = self._sigma(new, values)
        gap = gaps.turned_at(self.problem, [*self.points[-2:], new], [*self.sigma[-2:], sigma], self.engine) if cut is None else None
        if gap is not None and gap.width <= max(self.through, NARROW) and self._cross(gap):
            return
        terminal = found[-1].kind if cut is not None else ""
        met = [*found, *self._pairs(new, values, index, cut, found, is_clear=taken.is_clear and not self.unknown)]
        self.specials = sorted([*self.specials, *met], key=lambda event: event.arclength) if met else self.specials
        self.passages += [gap] if gap else []
        self._take(new if cut is None else cut, values, sigma)
        if cut is not None:
            self._cut(terminal)
            return
        self.step = step
        if self._since >= _SHORTEST and is_closed(self.start, self.points[-2], self.points[-1]):
            self.end("closed", "the branch came back to its start")

    def _take(self, point: Point, values: tuple[float, ...], sigma: float) -> None:
        self.seen = [*self.seen[1 - _SEEN :], (self.points[-1], self.values)]
        self.values = values
        self.points.append(point)
        self.sigma.append(sigma)

    def _pairs(
        self, new: Point, values: tuple[float, ...], index: int, cut: Point | None, located: Sequence[Special], *, is_clear: bool
    ) -> list[Special]:
        """Zeros within one step that signs do not show, told from points on both sides of it.

        The step is the one before, unless it is known to be clear of them, and this one where the run is cut in it.
        """
        if is_clear and cut is None:
            return []
        rows = [*self.seen[-_SEEN:], (self.points[-1], self.values), (new, values)]
        met = [*self.known, *self.specials, *located]
        found = pairs_of(self.problem, self.tests, rows, len(rows) - 3, self.engine, index - 1, met) if self.seen and not is_clear else []
        if cut is not None:
            within = pairs_of(self.problem, self.tests, rows, len(rows) - 2, self.engine, index, met)
            found += [event for event in within if event.arclength < cut.arclength]
        return [event for event in found if not any(is_same(event, other) for other in self.known)]

    def _sigma(self, point: Point, values: Sequence[float]) -> float:
        """The smallest singular value of [J; t], which a test for branch points has as its own."""
        known = abs(values[self.singular]) if self.singular is not None else 0.0
        return known or gaps.smallest(self.problem, point)

    def _cross(self, gap: Passage) -> bool:
        """Go on straight beyond a gap, from where the branch did not yet feel it; what lay behind is dropped."""
        crossed = gaps.across(self.problem, self.points, gap, self.engine)
        if crossed is None:
            return False
        index, new = crossed
        last = self.points[index]
        found, cut = gaps.met_across(self.problem, last, new, gap, self.tests, self.engine, self.offset + index)
        self.points = [*self.points[: index + 1], new if cut is None else cut]
        self.start, self.origin = new, self.offset + index + 1
        self.sigma = [*self.sigma[: index + 1], gaps.smallest(self.problem, self.points[-1])]
        self.specials = [*(event for event in self.specials if event.index < self.offset + index), *found]
        self.passages.append(Passage(gap.z, gap.arclength, gap.width, True))
        self.values, self.seen, self.queue = values_at(self.problem, new, self.tests), [], []
        self.step = max(self.engine.options.step_min, new.arclength - last.arclength)
        if cut is not None:
            self._cut(found[-1].kind)
        return True

    def _cut(self, kind: str) -> None:
        """End at the last point, which is that of a terminal event."""
        self.regular = len(self.points) - 1
        self.end("event", f"ended by the event '{kind}'")
