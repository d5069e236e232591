"""One evaluation per iterate: residual, Jacobian and multipliers come from the same call and reach Branch and files."""

from __future__ import annotations

import dataclasses
from collections import Counter

import numpy as np
import pytest

from phichain.continuation import (
    Branch,
    BranchPoint,
    Engine,
    Evaluation,
    Extra,
    Fold,
    Level,
    Options,
    Point,
    Problem,
    correctors,
    follow,
    start_on,
)
from phichain.continuation.met.locate import locate
from phichain.errors import ArrayError
from tests import tables
from tests.continuation.problems import CIRCLE

GUESS, AHEAD = np.array([-1.0, -1.0]), np.array([1.0, 0.0])


def rates(z: np.ndarray) -> np.ndarray:
    """What x' = x^2 + l and y' = -y + i l say of their equilibria: a real eigenvalue and a complex one."""
    return np.array([2 * z[0], -1 + 1j * z[1]])


def parabola(seen: Counter[tuple[float, ...]] | None = None) -> Problem:
    """x^2 + l = 0, with the eigenvalues of its equilibria beside it; counts where it was evaluated."""
    seen = Counter() if seen is None else seen

    def evaluate(z: np.ndarray) -> Evaluation:
        seen[tuple(z)] += 1
        return Evaluation(np.array([z[0] ** 2 + z[1]]), np.array([[2 * z[0], 1.0]]), Extra(rates(z)))

    return Problem(evaluate, ("x", "l"))


def run(problem: Problem) -> Branch:
    start = start_on(problem, GUESS, AHEAD, Engine())
    return follow(problem, start, tests=[Fold(), BranchPoint(), Level(lambda z: z[0], 1.0, "end")])


@pytest.mark.parametrize("corrector", [correctors.pseudo_arclength, correctors.moore_penrose])
def test_every_iterate_is_evaluated_once(corrector) -> None:
    seen: Counter[tuple[float, ...]] = Counter()
    found = corrector(parabola(seen), np.array([-1.1, -0.9]), np.array([0.6, -0.8]), Options())
    assert found.converged and found.iterations >= 3
    # The guess, and what each correction led to.
    assert seen.total() == found.iterations + 1
    assert max(seen.values()) <= 2  # the last correction may be too small to move z


@pytest.mark.parametrize("corrector", [correctors.pseudo_arclength, correctors.moore_penrose])
def test_a_guess_that_is_right_to_rounding_is_taken_as_it_is(corrector) -> None:
    """Its correction is known without another evaluation; one whose correction is not rounding is corrected, however small its residual."""
    seen: Counter[tuple[float, ...]] = Counter()
    guess = np.array([np.nextafter(-1.0, -2.0), -1.0])
    found = corrector(parabola(seen), guess, np.array([0.6, -0.8]), Options())
    assert found.converged and found.iterations == 0 and seen.total() == 1 and np.array_equal(found.y, guess)
    seen.clear()
    found = corrector(parabola(seen), np.array([-1.0 + 3e-15, -1.0]), np.array([0.6, -0.8]), Options())
    assert found.converged and found.iterations == 1 and seen.total() == 2 and found.residual <= 1e-16


def test_a_run_evaluates_once_per_iterate_and_no_more() -> None:
    """Points of a run without events cost their Newton iterations and one: nothing is asked again for the record."""
    seen: Counter[tuple[float, ...]] = Counter()
    problem = parabola(seen)
    engine = Engine(options=Options(step=0.01, step_max=0.01, max_points=20))
    start = start_on(problem, GUESS, AHEAD, engine)
    # The check of the start, the tangent at the guess, the guess and every correction.
    assert seen.total() == start.iterations + 3
    seen.clear()
    branch = follow(problem, start, engine, [Fold(), BranchPoint()])
    assert len(branch) == 20 and not branch.events
    assert seen.total() == int(np.sum(branch.iterations[1:] + 1))


@pytest.mark.parametrize("corrector", [correctors.pseudo_arclength, correctors.moore_penrose])
def test_a_correction_that_is_trusted_is_not_asked_after(corrector) -> None:
    """Newton's last step is right to the square of itself; the Jacobian is that of the place before it."""
    seen: Counter[tuple[float, ...]] = Counter()
    problem, guess, normal = parabola(seen), np.array([-1.0 - 1e-7, -1.0]), np.array([0.6, -0.8])
    found = corrector(problem, guess, normal, Options(tol=1e-9, trust=1e-6))
    assert found.converged and found.iterations == 1 and seen.total() == 1
    assert found.jacobian.tolist() == [[2 * guess[0], 1.0]] and found.residual < 1e-15
    exact = corrector(problem, guess, normal, Options(tol=1e-9))
    assert seen.total() > 2 and found.y == pytest.approx(exact.y, abs=1e-13) and exact.jacobian.tolist() == [[2 * exact.y[0], 1.0]]


def test_an_event_is_told_by_the_jacobian_of_its_own_place() -> None:
    """Where the last correction was not asked after and was more than rounding, the Jacobian is: here that of a place 1e-9 farther on a circle."""

    def sloppy(problem: Problem, guess: np.ndarray, normal: np.ndarray, options: Options) -> correctors.Correction:
        y = guess / np.linalg.norm(guess)
        far = y + 1e-9 * np.array([-y[1], y[0]])
        return correctors.Correction(y, 2 * far[None], 0.0, (1e-9,), True, Extra())

    def on_circle(angle: float) -> Point:
        y = np.array([np.cos(angle), np.sin(angle)])
        return Point(y, np.array([-y[1], y[0]]), angle, 2 * y[None], 0.0, 0, (), Extra())

    (event,), _ = locate(CIRCLE, on_circle(1.2), on_circle(2.0), [Fold(1)], Engine(corrector=sloppy), 0)
    assert event.z == pytest.approx([0.0, 1.0], abs=1e-10) and abs(event.value) < 1e-10


def test_points_and_events_carry_the_multipliers_of_their_own_solutions() -> None:
    branch = run(parabola())
    assert branch.multipliers.shape == (len(branch), 2) and np.iscomplexobj(branch.multipliers)
    assert np.array_equal(branch.multipliers, np.array([rates(z) for z in branch.points]))
    kinds = [event.kind for event in branch.events]
    assert kinds == ["fold", "end"]
    for event in branch.events:
        assert event.multipliers == pytest.approx(rates(event.z), abs=1e-12)
    # An exchange of stability at the fold: the real eigenvalue passes zero there, its neighbour does not.
    assert abs(branch.events[0].multipliers[0]) < 1e-13 and branch.events[0].multipliers[1].real == -1


def test_multipliers_survive_files(tmp_path) -> None:
    branch = run(parabola())
    copy = Branch.from_npz(branch.to_npz(tmp_path / "branch.npz"))
    assert np.array_equal(copy.multipliers, branch.multipliers)
    for event, other in zip(copy.events, branch.events, strict=True):
        assert np.array_equal(event.multipliers, other.multipliers)
    header, *rows = tables.lines(branch.to_csv(tmp_path / "branch.csv"))
    columns = header.split(",")
    assert columns[-4:] == ["multiplier_1_re", "multiplier_1_im", "multiplier_2_re", "multiplier_2_im"]
    read = np.array([[float(word) for word in row.split(",")[-4:]] for row in rows])
    assert np.array_equal(read[:, ::2] + 1j * read[:, 1::2], branch.multipliers)


def test_a_problem_without_multipliers_has_empty_ones(tmp_path) -> None:
    plain = parabola().evaluate

    def evaluate(z: np.ndarray) -> Evaluation:
        return Evaluation(*plain(z)[:2])

    branch = run(Problem(evaluate, ("x", "l")))
    assert branch.multipliers.shape == (len(branch), 0)
    assert all(event.multipliers.shape == (0,) for event in branch.events)
    copy = Branch.from_npz(branch.to_npz(tmp_path / "branch.npz"))
    assert copy.multipliers.shape == (len(branch), 0) and copy.events[0].multipliers.shape == (0,)
    assert "multiplier" not in branch.to_csv(tmp_path / "branch.csv").read_text()


def test_files_from_before_there_were_multipliers_have_none(tmp_path) -> None:
    path = run(parabola()).to_npz(tmp_path / "branch.npz")
    with np.load(path) as archive:
        older = {name: archive[name] for name in archive.files if "multipliers" not in name}
    np.savez(tmp_path / "older.npz", **older)
    copy = Branch.from_npz(tmp_path / "older.npz")
    assert copy.multipliers.shape == (len(copy), 0) and copy.events[0].multipliers.shape == (0,)


def test_a_number_of_multipliers_that_changes_is_refused() -> None:
    plain = parabola().evaluate

    def evaluate(z: np.ndarray) -> Evaluation:
        residual, jacobian, _ = plain(z)
        return Evaluation(residual, jacobian, Extra(np.ones(1 if z[0] < 0 else 2)))

    with pytest.raises(ArrayError, match="their number changes along the branch"):
        run(Problem(evaluate, ("x", "l")))


def test_what_a_problem_keeps_cannot_be_written_to() -> None:
    given = np.array([2.0, 1.0])
    problem = dataclasses.replace(parabola(), scale=given)
    given[0] = 7.0
    assert problem.sizes[0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        problem.sizes[0] = 3.0
    values = np.array([1.0 + 1j])
    extra = Extra(values)
    values[0] = 0.0
    assert extra.multipliers[0] == 1.0 + 1j
    with pytest.raises(ValueError, match="read-only"):
        extra.multipliers[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        Extra().multipliers[...] = 0.0
