"""Events of families of brake orbits: where they are, whatever the step, and that what they say breaks does break."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from phichain.continuation import Branch, Options
from phichain.orbits import linear_modes, quarter_problem, trace
from phichain.orbits.covers import traversals
from phichain.orbits.symmetry import BRANCH_POINT, ended_by
from tests.orbits.shot import uniform

STABILITY = ("energy extremum", "brake loss", "odd loss", "unequal brakes")


def two_links(step_max: float) -> Branch:
    options = Options(step=0.01, step_max=step_max, max_points=5000, tol=1e-9)
    return trace(uniform(2), until="theta_1=-2.5", options=options)


@pytest.fixture(scope="module")
def in_phase() -> Branch:
    return two_links(0.1)


def test_two_links_in_phase_through_both_folds(in_phase: Branch) -> None:
    """theta = (-2.5, 0.746), T = 2.27931277388, by a quadruple-precision integration of others."""
    z = in_phase.points[-1]
    assert z[0] == -2.5 and z[1] == pytest.approx(0.746, abs=5e-4)
    assert 2 * np.pi / z[2] == pytest.approx(2.27931277388, abs=1e-11)  # as many digits as are printed there
    counts = {kind: len(in_phase.located(kind)) for kind in (*STABILITY, "fold omega", "cover 3 of mode 2", "branch point")}
    assert counts == {
        "energy extremum": 2, "brake loss": 2, "odd loss": 1, "unequal brakes": 1, "fold omega": 2, "cover 3 of mode 2": 1,
        "branch point": 0,
    }  # fmt: skip
    (fold,) = in_phase.located("fold amplitude 1")
    assert fold.z[0] == pytest.approx(1.4053, abs=5e-5)
    assert all(event.breaks and event.continues for event in in_phase.events[:-1])
    assert np.max(in_phase.error) < 1e-11


def test_the_cover_is_where_the_literature_has_it(in_phase: Branch) -> None:
    (cover,) = in_phase.located("cover 3 of mode 2")
    assert cover.z == pytest.approx([-0.221977632259, 0.742328618792, 3.983985870022], abs=2e-12)
    assert in_phase.located("brake loss")[0].z == pytest.approx(cover.z, abs=1e-11)
    assert traversals(uniform(2), None, cover.z) == 3


@pytest.mark.parametrize("step_max", [0.02, 0.5])
def test_events_do_not_depend_on_the_step(in_phase: Branch, step_max: float) -> None:
    other = two_links(step_max)
    assert [event.kind for event in other.events] == [event.kind for event in in_phase.events]
    for a, b in zip(in_phase.events, other.events, strict=True):
        assert a.z == pytest.approx(b.z, abs=1e-11)


def test_multipliers_are_at_one_and_minus_one_where_events_say(in_phase: Branch) -> None:
    for event in in_phase.events:
        if event.kind in STABILITY:
            sign = -1 if event.kind in ("odd loss", "unequal brakes") else 1
            assert event.multipliers[0] == pytest.approx(sign, abs=1e-9)


def test_what_an_event_breaks_is_broken_beside_it(in_phase: Branch) -> None:
    """Perturbations of the kind said, rates or angles, come back after T/2 with the sign said, and the flow's own besides."""
    system = uniform(2)
    for kind, part, sign in (("brake loss", slice(2, 4), -1), ("odd loss", slice(2, 4), 1), ("unequal brakes", slice(0, 2), 1)):
        event = in_phase.located(kind)[-1]
        half = system.propagate(event.z[:-1], np.zeros(2), 0.0, np.pi / event.z[-1], 1e-16, transition=np.eye(4)).transition
        sizes = np.linalg.svd((half - sign * np.eye(4))[:, part], compute_uv=False)
        # The flow itself changes the rates, and turns them round in half a period.
        own = 1 if kind == "brake loss" else 0
        assert np.all(sizes[len(sizes) - 1 - own :] < 1e-8) and np.all(sizes[: len(sizes) - 1 - own] > 1e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("links", "mode", "joint", "fold"),
    [(3, 1, 1, 0.7336), (3, 2, 3, 0.5283), (3, 3, 3, 1.594), (4, 2, 4, 0.4797), (4, 3, 4, 0.1529), (4, 4, 4, 0.6927)],
)
def test_first_folds(links: int, mode: int, joint: int, fold: float) -> None:
    branch = trace(uniform(links), mode, until=f"amplitude={max(1.3 * fold, fold + 0.3):.3f}", options=None, limits={"max_points": 400})
    found = [abs(event.z[joint - 1]) for event in branch.located(f"fold amplitude {joint}")]
    # As many digits as are printed, cut off.
    assert min(abs(np.array(found) - fold)) < (1e-3 if fold > 1 else 1e-4)


def test_krein_collisions() -> None:
    branch = trace(uniform(4), 2, until="amplitude=0.65")
    first, second = branch.located("krein")
    assert first.z[-1] == pytest.approx(8.4062022372, rel=1e-10) and second.z[-1] == pytest.approx(8.3140601081, rel=1e-10)
    for event in (first, second):
        kappa = event.multipliers[np.abs(event.multipliers) < 1]
        assert np.min(np.abs(np.diff(np.sort_complex(kappa)))) < 1e-5


@pytest.mark.parametrize("step_max", [0.02, 0.1, 0.5])
def test_two_folds_within_a_step_are_found_whatever_the_step(step_max: float) -> None:
    """N = 4: before its gap the third angle of mode 1 turns twice within 4.5e-4 of arclength, among points that show one sign; known from a step of 0.002."""
    branch = trace(uniform(4), 1, until="theta_1=0.336", limits={"step_max": step_max})
    found = branch.located("fold amplitude 3")
    wanted = (
        [0.33486675525, 0.07332341963, 0.05809581605, 0.03185679127, 3.77427730255],
        [0.33530504432, 0.07339863464, 0.05809579064, 0.03180540598, 3.77419821712],
    )
    assert [event.z for event in found] == [pytest.approx(z, abs=1e-10) for z in wanted]


@pytest.fixture(scope="module")
def short_steps() -> Branch:
    return trace(uniform(4), 3, until="theta_2=0.2", limits={"step_max": 0.02})


@pytest.mark.parametrize("step_max", [0.1, 0.5])
def test_a_cover_lies_where_it_does_however_long_the_step(short_steps: Branch, step_max: float) -> None:
    """N = 4, mode 3: another family crosses at a small angle within 1e-3 of a bend, where Newton from a bad guess lands anywhere."""
    other = trace(uniform(4), 3, until="theta_2=0.2", limits={"step_max": step_max})
    assert [event.kind for event in other.events] == [event.kind for event in short_steps.events]
    for a, b in zip(short_steps.events, other.events, strict=True):
        assert a.z == pytest.approx(b.z, abs=1e-10)
    (cover,) = other.located("cover 3 of mode 4")
    system = uniform(4)
    modes = linear_modes(system)
    problem = quarter_problem(system, omega=modes.omega[3], shape=modes.shapes[:, 3])
    # Traversed once it is an orbit of mode 4 with a third of a turn, which its own multipliers say.
    found = problem.evaluate(np.append(cover.z[:-1], 3 * cover.z[-1]))
    assert found.residual == pytest.approx(0, abs=1e-13) and np.min(np.abs(found.extra.multipliers + 0.5)) < 1e-9


def test_a_cover_of_high_order_has_one_brake_loss() -> None:
    """Beside the ninefold cover of N = 3 the function goes as the seventh power of the distance: round-off far around."""
    branch = trace(uniform(3), 1, until="theta_1=-0.3")
    (cover,) = branch.located("cover 9 of mode 3")
    (loss,) = branch.located("brake loss")
    assert loss.z.tolist() == cover.z.tolist()
    for kind in ("energy extremum", "fold omega"):
        assert min(np.max(np.abs(event.z - cover.z)) for event in branch.located(kind)) == 0
    assert traversals(uniform(3), None, cover.z) == 9


def test_the_gap_is_named_and_turned_at() -> None:
    branch = trace(uniform(4), 1, until="theta_4=-0.05", limits={"step_max": 0.05})
    (gap,) = branch.passages
    assert gap.z[0] == pytest.approx(0.33630, abs=2e-5) and gap.width == pytest.approx(5.5e-5, rel=0.2) and not gap.is_crossed
    assert not branch.located("branch point")


def test_the_gap_is_crossed_on_request() -> None:
    """The backbone has its first fold at theta_1 = 0.7239; two step limits a factor 25 apart agree."""
    folds = []
    for step_max in (0.1, 0.004):
        branch = trace(uniform(4), 1, until="theta_3=-0.053", through=1e-4, limits={"step_max": step_max})
        gap = branch.passages[0]
        assert gap.is_crossed and gap.width == pytest.approx(5.5e-5, rel=0.2)
        folds.append(branch.located("fold amplitude 1")[0].z)
    assert folds[0][0] == pytest.approx(0.7239, abs=5e-5)
    assert folds[0] == pytest.approx(folds[1], abs=1e-11)


def test_a_family_ends_where_its_orbits_are_too_unstable_to_know() -> None:
    """Mode 2 of two links runs into the chain that stands on its head: kappa grows without bound, and events would be rounding."""
    branch = trace(uniform(2), 2)
    assert "unstable beyond double precision'; amplitude_max was not reached" in branch.reason
    assert np.max(np.abs(branch.multipliers)) == pytest.approx(1e12, rel=0.1) and np.max(branch.error) < 1e-9
    assert [event.kind for event in branch.events[:-1]] == ["brake loss", "fold amplitude 2", "fold amplitude 1", "fold amplitude 1"]


def test_what_only_seems_to_turn_where_a_family_ends_is_none_of_it() -> None:
    def branch(status: str, *events: tuple[str, float]) -> Any:
        return SimpleNamespace(status=status, events=tuple(SimpleNamespace(kind=kind, arclength=at) for kind, at in events))

    met = ("fold omega", 1.0), ("energy extremum", 1.9995), (BRANCH_POINT, 2.0)
    kept, last = ended_by(branch("event", *met), (BRANCH_POINT,))
    assert [event.kind for event in kept] == ["fold omega"] and last is not None and last.arclength == 2.0
    for other in (branch("length", *met), branch("event", *met[:2])):
        kept, last = ended_by(other, (BRANCH_POINT,))
        assert tuple(kept) == other.events and last is None
