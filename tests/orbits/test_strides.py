"""Many steps of a family in one call of C, and its events: as one by one, whose steps, tests and zeros are Python's; broken off, and gone on with."""

from __future__ import annotations

import ctypes
import subprocess
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.continuation import core
from phichain.continuation.compiled import strides
from phichain.continuation.correctors import pseudo_arclength
from phichain.continuation.point import point_at
from phichain.emit.stencil import stencils_folder
from phichain.native.flows.brake import Brake
from phichain.orbits import linear_modes, quarter_problem, symmetry, trace
from phichain.orbits.shooting import settings
from tests.emit.test_stencil import STRICT
from tests.orbits.shot import uniform

FAMILIES = [(1, 1, "theta_1=2.9", {}), (2, 1, "theta_1=-2.5", {}), (2, 2, "amplitude=1.2", {"base": "cart", "cart_mass": 0.4}), (3, 1, "energy=0.9", {})]


def one_by_one(*words: Any) -> Any:
    """A corrector that is none of the compiled problem's own, so that nothing but its evaluations is."""
    return pseudo_arclength(*words)


@pytest.mark.parametrize(("links", "mode", "until", "more"), FAMILIES)
def test_they_are_those_of_one_by_one(links: int, mode: int, until: str, more: dict[str, Any]) -> None:
    """As many points at the same places, and the same events; a step hangs on eigenvalues, which are right to round-off, and those of nearly equal ones to its root."""
    system = uniform(links, **more)
    together = trace(system, mode, until=until)
    single = trace(system, mode, until=until, engine=replace(settings(None, links), corrector=one_by_one))
    assert len(together) == len(single) > 10 and together.status == single.status and together.reason == single.reason
    assert together.points == pytest.approx(single.points, rel=1e-6, abs=1e-6)
    assert [event.kind for event in together.events] == [event.kind for event in single.events]
    for ours, theirs in zip(together.events, single.events, strict=True):
        # The energy turns 5e-3 beside a cover, where it is flat.
        assert ours.z == pytest.approx(theirs.z, rel=3e-10, abs=3e-10), ours.kind


def test_zeros_on_the_way_are_those_of_who_looks_at_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a run locates by itself, beside the same run whose every crossing is located from outside: the same calls of the flow lead there, and twelve digits of
    multipliers. From outside only the end is asked for, and what is singular."""
    system, zero, asked = uniform(2), Brake.zero, []
    monkeypatch.setattr(Brake, "zero", lambda self, *words: asked.append(words[3].what) or zero(self, *words))
    within = trace(system, 1, until="theta_1=-2.5")
    alone, asked[:] = set(asked), []
    watched = strides.watched
    monkeypatch.setattr(core, "watched", lambda *words: [watch._replace(passes=False) for watch in watched(*words) or ()])
    outside = trace(system, 1, until="theta_1=-2.5")
    assert {"brake loss", "odd loss", "unequal brakes", "energy slope", "tangent"} <= set(asked)
    assert "unequal brakes" not in alone
    assert within.points.tolist() == outside.points.tolist() and len(within.events) == len(outside.events) > 12
    for ours, theirs in zip(within.events, outside.events, strict=True):
        assert (ours.kind, ours.index) == (theirs.kind, theirs.index)
        assert ours.z == pytest.approx(theirs.z, rel=1e-14, abs=1e-14) and ours.arclength == pytest.approx(theirs.arclength, rel=1e-14)
        assert ours.multipliers == pytest.approx(theirs.multipliers, rel=1e-12, abs=1e-12) and ours.value == pytest.approx(theirs.value, abs=1e-13)


def test_functions_vanish_where_it_is_told() -> None:
    """Asked once more at the very place of each event, away from the cover where they are rounding: what is left of its function, in its slope per unit of arclength."""
    system = uniform(2)
    branch, modes = trace(system, 1, until="theta_1=-2.5"), linear_modes(system)
    problem = quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0])
    tests = {test.name: test for test in symmetry.tests_of(problem, 0, 2)}
    cover = next(event.arclength for event in branch.events if event.kind.startswith("cover"))
    events = [event for event in branch.events if event.kind in tests and abs(event.arclength - cover) > 0.1]
    assert len(events) > 9
    for event in events:
        k = int(np.searchsorted(branch.arclength, event.arclength))
        places = event.z, branch.points[k - 1], branch.points[k]
        along = branch.tangent[k] / problem.sizes
        left, before, after = (tests[event.kind].value(problem, point_at(problem, z / problem.sizes, along, 0.0, 0)) for z in places)
        slope = abs(after - before) / (branch.arclength[k] - branch.arclength[k - 1])
        assert before * after < 0 and abs(left) < 2e-12 * slope, event.kind


def test_a_run_that_is_broken_off_keeps_what_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while C is in the middle of many orbits: those before it are kept, and the rest is that of a whole run to the last bit."""
    system, until = uniform(2), "theta_1=1.5"
    whole, calls = trace(system, 1, until=until), []
    run = Brake.run

    def broken(self: Brake, *words: Any) -> Any:
        found = run(self, *words)
        calls.append(len(found.rows))
        if len(calls) != 2:
            return found
        kept = found.rows[:-1]
        return found._replace(rows=kept, events=[event for event in found.events if event.before < len(kept)], stopped="interrupted")

    monkeypatch.setattr(Brake, "run", broken)
    part = trace(system, 1, until=until)
    assert part.status == "interrupted" and 1 + calls[0] <= len(part) < len(whole) and part.points.tolist() == whole.points[: len(part)].tolist()
    again = trace(system, 1, until=until, resume=part)
    for name in ("points", "arclength", "tangent", "residual", "energy", "multipliers", "error"):
        assert np.array_equal(getattr(again, name), getattr(whole, name)), name
    assert [(event.kind, event.z.tolist()) for event in again.events] == [(event.kind, event.z.tolist()) for event in whole.events]


def test_who_is_told_every_point_gets_the_same() -> None:
    told: list[float] = []
    quiet = trace(uniform(2), 1, until="theta_1=1.5")
    loud = trace(uniform(2), 1, until="theta_1=1.5", progress=lambda point, step: told.append(point.arclength))
    assert told == loud.arclength[1:].tolist() and loud.points.tolist() == quiet.points.tolist()


def test_eigenvalues_are_lapack_s(tmp_path: Any) -> None:
    """Random matrices, symmetric ones, some near 1, permutations whose eigenvalues all lie on a circle, and some with zero columns."""
    lines = ["#include <math.h>", "typedef double phi_real;", "#define SMALL_MOST 16", "#define SMALL_SWEEPS 40", "#define SMALL_NOTHING 1e-16"]
    lines += ['#include "orbits/small.c"', "int eigenvalues(int n, double *a, double *re, double *im);"]
    lines += ["int eigenvalues(int n, double *a, double *re, double *im) { return small_eigenvalues(n, a, re, im); }"]
    (tmp_path / "small.c").write_text("\n".join([*lines, ""]))
    words = ["cc", *STRICT, "-Wno-unused-function", f"-I{stencils_folder()}", "-O2", "-shared", "-fPIC", str(tmp_path / "small.c"), "-o", str(tmp_path / "small.so"), "-lm"]
    subprocess.run(words, check=True)
    library, rng = ctypes.CDLL(str(tmp_path / "small.so")), np.random.default_rng(5)
    for turn in range(2000):
        n = int(rng.integers(1, 13))
        matrix = rng.standard_normal((n, n))
        kinds = [matrix, matrix + matrix.T, np.eye(n) + 1e-3 * matrix, np.eye(n)[rng.permutation(n)], np.where(np.arange(n) < n // 2, 0.0, matrix)]
        given = np.array(kinds[turn % len(kinds)])
        used, re, im = given.copy(), np.zeros(n), np.zeros(n)
        assert library.eigenvalues(n, *(ctypes.c_void_p(array.ctypes.data) for array in (used, re, im))) == n
        ours, theirs = re + 1j * im, np.linalg.eigvals(given)
        gaps = np.abs(ours[:, None] - theirs)
        # Each of the one near one of the other, as near as their condition allows: the traces of powers to round-off.
        assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < 1e-6 * np.linalg.norm(given)
        for power in (1, 2):
            assert np.sum(ours**power) == pytest.approx(np.trace(np.linalg.matrix_power(given, power)), abs=1e-12 * (1 + np.linalg.norm(given) ** power) * n)
